//! Textures that are made again only when what they show has changed.

use eframe::egui::{self, ColorImage, TextureHandle, TextureOptions};

/// One texture with the key it was made for.
#[derive(Default)]
pub struct CachedTexture {
    key: String,
    handle: Option<TextureHandle>,
}

impl CachedTexture {
    /// The texture for `key`, made by `image` if the key is new.
    pub fn get(&mut self, ctx: &egui::Context, key: String, smooth: bool, image: impl FnOnce() -> ColorImage) -> egui::TextureId {
        let options = if smooth {
            TextureOptions::LINEAR
        } else {
            TextureOptions { minification: egui::TextureFilter::Linear, ..TextureOptions::NEAREST }
        };
        match &mut self.handle {
            Some(handle) if self.key == key => handle.id(),
            Some(handle) => {
                handle.set(image(), options);
                self.key = key;
                handle.id()
            }
            None => {
                let handle = ctx.load_texture("lucarne", image(), options);
                let id = handle.id();
                self.handle = Some(handle);
                self.key = key;
                id
            }
        }
    }
}
