//! The program without a window: frames are run and painted into a texture. Used by `--screenshot`
//! and by the tests.

use crate::app::App;
use crate::args::Args;
use eframe::egui::{self, Event, Rect, pos2, vec2};
use eframe::egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use lucarne::gpu::Device;
use lucarne::{Error, Result};
use std::path::Path;
use std::time::{Duration, Instant};

/// Longest time a screenshot waits for what is computed in the background.
const PATIENCE: Duration = Duration::from_secs(120);

/// An invisible window.
pub struct Offscreen {
    ctx: egui::Context,
    size: [u32; 2],
    scale: f32,
    time: f64,
    events: Vec<Event>,
    textures: egui::TexturesDelta,
    output: Option<egui::FullOutput>,
    painter: Option<(Device, Renderer)>,
}

impl Offscreen {
    /// A window of `size` pixels, `scale` pixels per point.
    pub fn new(size: [u32; 2], scale: f32) -> Self {
        let ctx = egui::Context::default();
        ctx.all_styles_mut(|s| s.animation_time = 0.0);
        Self { ctx, size, scale, time: 0.0, events: Vec::new(), textures: Default::default(), output: None, painter: None }
    }

    /// Its context, for the app's setup.
    pub fn ctx(&self) -> &egui::Context {
        &self.ctx
    }

    /// Sends an input.
    #[cfg(test)]
    pub fn send(&mut self, event: Event) {
        self.events.push(event);
    }

    /// Runs one frame.
    pub fn frame(&mut self, app: &mut App) {
        self.time += 1.0 / 30.0;
        let points = vec2(self.size[0] as f32, self.size[1] as f32) / self.scale;
        let mut input = egui::RawInput {
            screen_rect: Some(Rect::from_min_size(pos2(0.0, 0.0), points)),
            max_texture_side: Some(8192),
            time: Some(self.time),
            events: std::mem::take(&mut self.events),
            focused: true,
            ..Default::default()
        };
        if let Some(viewport) = input.viewports.get_mut(&egui::ViewportId::ROOT) {
            viewport.native_pixels_per_point = Some(self.scale);
        }
        let mut output = self.ctx.run_ui(input, |ui| app.frame(ui));
        self.textures.append(std::mem::take(&mut output.textures_delta));
        self.output = Some(output);
    }

    /// Runs frames until nothing is under way in the background.
    pub fn settle(&mut self, app: &mut App) -> Result<()> {
        let start = Instant::now();
        let mut quiet = 0;
        while quiet < 3 {
            self.frame(app);
            if app.busy() {
                quiet = 0;
                std::thread::sleep(Duration::from_millis(5));
            } else {
                quiet += 1;
            }
            if start.elapsed() > PATIENCE {
                return Err(Error::new(format!("still computing after {} s", PATIENCE.as_secs())));
            }
        }
        Ok(())
    }

    /// Paints the last frame: RGBA, row 0 on top.
    pub fn pixels(&mut self) -> Result<Vec<u8>> {
        let format = wgpu::TextureFormat::Rgba8Unorm;
        if self.painter.is_none() {
            let device = Device::shared()?;
            let renderer = Renderer::new(device.raw(), format, RendererOptions::PREDICTABLE);
            self.painter = Some((device, renderer));
        }
        let (Some((device, renderer)), Some(output)) = (&mut self.painter, &self.output) else {
            return Err(Error::new("no frame was run"));
        };
        let (raw, queue) = (device.raw(), device.queue());
        let textures = std::mem::take(&mut self.textures);
        for (id, deltas) in &textures.set {
            for delta in deltas {
                renderer.update_texture(raw, queue, *id, delta);
            }
        }
        let jobs = self.ctx.tessellate(output.shapes.clone(), output.pixels_per_point);
        let screen = ScreenDescriptor { size_in_pixels: self.size, pixels_per_point: output.pixels_per_point };
        let extent = wgpu::Extent3d { width: self.size[0], height: self.size[1], depth_or_array_layers: 1 };
        let target = raw.create_texture(&wgpu::TextureDescriptor {
            label: Some("screenshot"),
            size: extent,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let row = (4 * self.size[0]).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = raw.create_buffer(&wgpu::BufferDescriptor {
            label: Some("screenshot"),
            size: u64::from(row) * u64::from(self.size[1]),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = raw.create_command_encoder(&Default::default());
        let mut commands = renderer.update_buffers(raw, queue, &mut encoder, &jobs, &screen);
        {
            let view = target.create_view(&Default::default());
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("screenshot"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            });
            renderer.render(&mut pass.forget_lifetime(), &jobs, &screen);
        }
        encoder.copy_texture_to_buffer(
            target.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
            },
            extent,
        );
        commands.push(encoder.finish());
        queue.submit(commands);
        for id in &textures.free {
            renderer.free_texture(id);
        }
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |r| {
            // The receiver waits below.
            let _ = sender.send(r);
        });
        device.wait()?;
        let lost = || Error::new("the device did not give the picture back");
        receiver.recv().map_err(|_| lost())?.map_err(|_| lost())?;
        let mapped = buffer.slice(..).get_mapped_range().map_err(|_| lost())?;
        let width = 4 * self.size[0] as usize;
        let mut pixels: Vec<u8> = mapped.chunks_exact(row as usize).flat_map(|r| r[..width].iter().copied()).collect();
        pixels.chunks_exact_mut(4).for_each(|p| p[3] = 255);
        Ok(pixels)
    }

    /// All texts of the last frame with their places, points.
    #[cfg(test)]
    pub fn texts(&self) -> Vec<(String, Rect)> {
        fn collect(shape: &egui::Shape, found: &mut Vec<(String, Rect)>) {
            match shape {
                egui::Shape::Text(t) => found.push((t.galley.text().to_string(), t.visual_bounding_rect())),
                egui::Shape::Vec(v) => v.iter().for_each(|s| collect(s, found)),
                _ => {}
            }
        }
        let mut found = Vec::new();
        for clipped in self.output.iter().flat_map(|o| &o.shapes) {
            collect(&clipped.shape, &mut found);
        }
        found
    }

    /// What the last frame asked of the window.
    #[cfg(test)]
    pub fn commands(&self) -> Vec<egui::ViewportCommand> {
        let outputs = self.output.iter().filter_map(|o| o.viewport_output.get(&egui::ViewportId::ROOT));
        outputs.flat_map(|o| o.commands.clone()).collect()
    }

    /// Keys that write a text, all in one frame: as a fast hand or a pasting tool sends them.
    #[cfg(test)]
    pub fn write(&mut self, app: &mut App, text: &str) {
        for letter in text.chars() {
            if let Some(key) = egui::Key::from_name(&letter.to_uppercase().to_string()) {
                for pressed in [true, false] {
                    self.send(Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: egui::Modifiers::NONE });
                }
            }
            self.send(Event::Text(letter.into()));
        }
        self.frame(app);
    }

    /// A click: the pointer comes, presses and lets go, a frame each.
    #[cfg(test)]
    pub fn click(&mut self, app: &mut App, pos: egui::Pos2) {
        self.point(app, pos);
        for pressed in [true, false] {
            self.button(app, pos, pressed);
        }
        self.frame(app);
    }

    /// Moves the pointer and runs a frame.
    #[cfg(test)]
    pub fn point(&mut self, app: &mut App, pos: egui::Pos2) {
        self.send(Event::PointerMoved(pos));
        self.frame(app);
    }

    /// Presses or releases the first button and runs a frame.
    #[cfg(test)]
    pub fn button(&mut self, app: &mut App, pos: egui::Pos2, pressed: bool) {
        self.send(Event::PointerButton { pos, button: egui::PointerButton::Primary, pressed, modifiers: egui::Modifiers::NONE });
        self.frame(app);
    }

    /// A key, pressed and released.
    #[cfg(test)]
    pub fn key(&mut self, app: &mut App, key: egui::Key, modifiers: egui::Modifiers) {
        for pressed in [true, false] {
            self.send(Event::Key { key, physical_key: None, pressed, repeat: false, modifiers });
            self.frame(app);
        }
    }
}

/// `--screenshot`.
pub fn screenshot(args: &Args, path: &Path) -> Result<()> {
    let size = args.size.unwrap_or_default().0;
    let mut window = Offscreen::new(size, args.scale.unwrap_or(1.0));
    let mut app = App::new(window.ctx(), args, None);
    window.settle(&mut app)?;
    if let Some(message) = app.first_error() {
        return Err(Error::new(message));
    }
    let pixels = window.pixels()?;
    write_png(path, size, &pixels)
}

/// Writes opaque pixels as small as PNG allows.
pub fn write_png(path: &Path, [width, height]: [u32; 2], rgba: &[u8]) -> Result<()> {
    let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    lucarne::files::write_atomically(path, |out| {
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::Adaptive);
        let fault = |e: png::EncodingError| Error::new(e.to_string()).file(path);
        let mut writer = encoder.write_header().map_err(fault)?;
        writer.write_image_data(&rgb).map_err(fault)
    })
}
