//! Windows: polygons and rings with `#@rfluxmtx` parameters, one [`Window`] per modifier.

use super::reader::{Reader, Sink};
use super::surfaces::{self, Geometry};
use super::syntax::Object;
use super::types::{ObjectType, Surface};
use super::xform::Placement;
use crate::error::{Error, Result, Warnings};
use crate::limits;
use crate::scene::windows::WindowBuilder;
use crate::scene::{SurfaceOrigin, Window};
use std::path::Path;
use std::rc::Rc;

/// Reads the windows of a file: all polygons and rings, grouped by modifier in order of first
/// appearance. Their normals point into the room. The materials need not be defined.
///
/// `h=` of the `#@rfluxmtx` comment before a surface chooses the basis (`kf`, `kh`, `kq` or `u`;
/// without it Klems full), `u=` the up vector (without it, rfluxmtx's default).
/// A left-handed basis (`h=-kf`) gets a frame whose x axis is reversed.
///
/// # Errors
/// Anything wrong in the file; surfaces other than polygons and rings; polygons of one window that
/// face opposite ways; bases this program does not know.
pub fn read_windows(file: &Path, base: &Path, warnings: &mut Warnings) -> Result<Vec<Window>> {
    let mut sink = WindowSink::default();
    Reader::new(base).read(file, &mut sink, warnings)?;
    if let Some((_, origin_file, line)) = &sink.pending {
        warnings.push(
            Error::new("no surface follows this #@rfluxmtx comment")
                .file(origin_file)
                .line(*line)
                .help("put it before the window's polygon"),
        );
    }
    if sink.windows.is_empty() {
        return Err(Error::new("there is no window in this file")
            .file(base.join(file))
            .help("give polygons whose normals point into the room"));
    }
    sink.windows.into_iter().map(|w| w.finish(warnings)).collect()
}

#[derive(Default)]
struct WindowSink {
    pending: Option<(String, Rc<Path>, usize)>,
    windows: Vec<WindowBuilder>,
    surfaces: usize,
}

impl Sink for WindowSink {
    fn object(&mut self, object: &Object, placement: &Placement, file: &Rc<Path>, warnings: &mut Warnings) -> Result<()> {
        let at = |e| object.at(e, file);
        let surface = match object.kind {
            ObjectType::Surface(surface) => surface,
            ObjectType::Unsupported("instance" | "mesh", help) => return Err(at(Error::new("this cannot be a window").help(help))),
            // What a window is made of is told by its BSDF, not by the material here.
            _ => return Ok(()),
        };
        if !matches!(surface, Surface::Polygon | Surface::Ring) {
            return Err(at(Error::new(format!("a {} cannot be a window", object.kind.word())).help("windows are polygons or rings")));
        }
        self.surfaces += 1;
        if self.surfaces > limits::WINDOW_SURFACES {
            return Err(at(
                limits::exceeded("the file has", limits::WINDOW_SURFACES, "surfaces of windows").help("give windows in files of their own")
            ));
        }
        let Geometry::Triangles(triangles) = surfaces::geometry(surface, object, placement, file, warnings)? else {
            return Ok(());
        };
        let name = placement.modifier.as_deref().unwrap_or(&object.modifier).to_string();
        let origin = SurfaceOrigin { name: format!("{}{}", placement.prefix, object.name), file: file.to_path_buf(), line: object.line };
        let index = self.windows.iter().position(|w| w.name() == name).unwrap_or_else(|| {
            self.windows.push(WindowBuilder::new(name, origin.clone()));
            self.windows.len() - 1
        });
        let window = &mut self.windows[index];
        if let Some((text, file, line)) = self.pending.take() {
            window.parameters(&text).map_err(|e| e.file(file).line(line).field("#@rfluxmtx"))?;
        }
        window.add(origin, triangles);
        Ok(())
    }

    fn alias(&mut self, _: &str, _: &str, _: &str, _: &Rc<Path>, _: usize) -> Result<()> {
        Ok(())
    }

    fn size(&self) -> usize {
        self.surfaces
    }

    fn parameters(&mut self, text: &str, file: &Rc<Path>, line: usize) -> Result<()> {
        match &mut self.pending {
            Some((earlier, _, _)) => {
                earlier.push(' ');
                earlier.push_str(text);
            }
            none => *none = Some((text.to_string(), Rc::clone(file), line)),
        }
        Ok(())
    }
}
