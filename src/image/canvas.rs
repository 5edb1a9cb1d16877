//! A grid of sRGB pixels with soft-edged drawing, written as PNG.

use super::font::{self, Contour};
use super::palette::{Color, WHITE};
use crate::error::{Error, Result};
use crate::files;
use crate::limits::PIXELS;
use std::path::Path;

/// Lines of samples per row of pixels when filling polygons; within a line, coverage is exact.
const SAMPLE_LINES: usize = 8;

/// An sRGB picture, row 0 on top. Places are measured in pixels from the upper left corner, so that
/// the centre of the first pixel is at 0.5, 0.5.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<Color>,
}

impl Canvas {
    /// A white canvas.
    ///
    /// # Errors
    /// If it has no pixels or too many.
    pub(crate) fn new(width: usize, height: usize) -> Result<Self> {
        if width == 0 || height == 0 || width.checked_mul(height).is_none_or(|n| n > PIXELS) {
            return Err(Error::new(format!("cannot draw a picture of {width} × {height} pixels")));
        }
        Ok(Self { width, height, pixels: vec![WHITE; width * height] })
    }

    /// Pixels per row.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub(crate) fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row.
    #[cfg(test)]
    pub fn pixels(&self) -> &[Color] {
        &self.pixels
    }

    /// Sets a pixel; places outside are ignored.
    #[cfg(test)]
    pub fn set(&mut self, x: usize, y: usize, color: Color) {
        if x < self.width && y < self.height {
            self.pixels[y * self.width + x] = color;
        }
    }

    /// The colour of a pixel.
    ///
    /// # Panics
    /// Outside the canvas.
    #[cfg(test)]
    pub fn get(&self, x: usize, y: usize) -> Color {
        assert!(x < self.width && y < self.height, "pixel {x}, {y}");
        self.pixels[y * self.width + x]
    }

    /// Fills shapes: what the closed lines of each wind around. All of one call are laid down together: where
    /// edges meet, no seam shows, which separate calls would leave.
    pub fn fill(&mut self, shapes: &[(Vec<Contour>, Color)]) {
        let Some((left, top, right, bottom)) = self.bounds(shapes.iter().flat_map(|(s, _)| s).flatten(), 0.0) else { return };
        let width = right - left;
        // Colour × coverage, and coverage.
        let mut laid = vec![[0f32; 4]; width * (bottom - top)];
        // Where edges cross a line of samples, and whether downwards.
        let mut crossings: Vec<(f64, i32)> = Vec::new();
        for (shape, color) in shapes {
            let Some((_, low, _, high)) = self.bounds(shape.iter().flatten(), 0.0) else { continue };
            for line in low * SAMPLE_LINES..high * SAMPLE_LINES {
                let y = (line as f64 + 0.5) / SAMPLE_LINES as f64;
                crossings.clear();
                for contour in shape {
                    for (i, &start) in contour.iter().enumerate() {
                        let end = contour[(i + 1) % contour.len()];
                        // From the upper to the lower end, so that a shared edge is cut at the very
                        // same place from both sides.
                        let (a, b, way) = if start[1] <= end[1] { (start, end, 1) } else { (end, start, -1) };
                        if a[1] <= y && y < b[1] {
                            crossings.push((a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]), way));
                        }
                    }
                }
                crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
                let row = &mut laid[(line / SAMPLE_LINES - top) * width..][..width];
                let mut winding = 0;
                for pair in crossings.windows(2) {
                    winding += pair[0].1;
                    let (from, to) = (pair[0].0.max(left as f64), pair[1].0.min(right as f64));
                    if winding == 0 || from >= to {
                        continue;
                    }
                    for x in from as usize..(to.ceil() as usize).min(right) {
                        let coverage = (to.min(x as f64 + 1.0) - from.max(x as f64)) as f32 / SAMPLE_LINES as f32;
                        let cell = &mut row[x - left];
                        for (sum, c) in cell.iter_mut().zip([f32::from(color[0]), f32::from(color[1]), f32::from(color[2]), 1.0]) {
                            *sum += c * coverage;
                        }
                    }
                }
            }
        }
        for (i, &[r, g, b, coverage]) in laid.iter().enumerate() {
            if coverage <= 0.0 {
                continue;
            }
            // Overlapping polygons share the pixel.
            let (share, rest) = if coverage > 1.0 { (1.0 / coverage, 0.0) } else { (1.0, 1.0 - coverage) };
            let pixel = &mut self.pixels[(top + i / width) * self.width + left + i % width];
            for (c, v) in pixel.iter_mut().zip([r, g, b]) {
                *c = (v * share + f32::from(*c) * rest).round() as u8;
            }
        }
    }

    /// Draws lines with round ends; where they cross, they do not get darker.
    pub fn stroke(&mut self, lines: &[Vec<[f64; 2]>], width: f64, color: Color) {
        let half = width / 2.0;
        let Some((left, top, right, bottom)) = self.bounds(lines.iter().flatten(), half + 1.0) else { return };
        let columns = right - left;
        let mut coverage = vec![0f32; columns * (bottom - top)];
        for line in lines {
            // A lone point is a dot.
            let last = line.len().saturating_sub(2);
            for i in 0..=last {
                let Some(&a) = line.get(i) else { continue };
                let b = line.get(i + 1).copied().unwrap_or(a);
                let Some((l, t, r, bo)) = self.bounds([a, b].iter(), half + 1.0) else { continue };
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                let squared = dx * dx + dy * dy;
                for y in t..bo {
                    for x in l..r {
                        let (px, py) = (x as f64 + 0.5 - a[0], y as f64 + 0.5 - a[1]);
                        let along = if squared > 0.0 { ((px * dx + py * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
                        let distance = (px - along * dx).hypot(py - along * dy);
                        // Lines thinner than a pixel are pale instead.
                        let covered = (half + 0.5 - distance).clamp(0.0, 1.0).min(width.max(0.0));
                        let cell = &mut coverage[(y - top) * columns + x - left];
                        *cell = cell.max(covered as f32);
                    }
                }
            }
        }
        for (i, &c) in coverage.iter().enumerate() {
            self.blend(left + i % columns, top + i / columns, color, c);
        }
    }

    /// Writes a line of text that begins at a place on the base line; `vertical` text runs upwards.
    /// A `halo` is drawn around it for legibility on pictures.
    pub fn text(&mut self, [x, y]: [f64; 2], text: &str, size: f64, color: Color, vertical: bool, halo: Option<Color>) {
        let mut outlines = font::outlines(text, size);
        for point in outlines.iter_mut().flatten() {
            let [dx, dy] = *point;
            *point = if vertical { [x + dy, y - dx] } else { [x + dx, y + dy] };
        }
        outlines.iter_mut().for_each(|contour| contour.extend_from_within(..1));
        if let Some(halo) = halo {
            self.stroke(&outlines, (size / 5.0).max(2.0), halo);
        }
        self.stroke(&outlines, size * font::RIM, color);
        self.fill(&[(outlines, color)]);
    }

    /// Places a picture of `columns` pixels per row into a rectangle, each pixel enlarged or
    /// repeated (never blurred).
    pub(crate) fn image(&mut self, rectangle: [f64; 4], columns: usize, pixels: &[Color]) {
        let [x, y, width, height] = rectangle;
        let rows = pixels.len() / columns.max(1);
        if rows == 0 || width <= 0.0 || height <= 0.0 {
            return;
        }
        let (left, top) = (x.round().max(0.0) as usize, y.round().max(0.0) as usize);
        let (right, bottom) = (((x + width).round() as usize).min(self.width), ((y + height).round() as usize).min(self.height));
        for py in top..bottom {
            let row = (((py as f64 + 0.5 - y) / height * rows as f64) as usize).min(rows - 1);
            for px in left..right {
                let column = (((px as f64 + 0.5 - x) / width * columns as f64) as usize).min(columns - 1);
                self.pixels[py * self.width + px] = pixels[row * columns + column];
            }
        }
    }

    fn blend(&mut self, x: usize, y: usize, color: Color, coverage: f32) {
        if coverage <= 0.0 || x >= self.width || y >= self.height {
            return;
        }
        for (c, v) in self.pixels[y * self.width + x].iter_mut().zip(color) {
            *c = (f32::from(*c) + (f32::from(v) - f32::from(*c)) * coverage).round() as u8;
        }
    }

    /// Pixels touched by points with a margin: left, top, right, bottom (exclusive).
    fn bounds<'a>(&self, points: impl Iterator<Item = &'a [f64; 2]>, margin: f64) -> Option<(usize, usize, usize, usize)> {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for p in points {
            for i in 0..2 {
                if !p[i].is_finite() {
                    return None;
                }
                low[i] = low[i].min(p[i] - margin);
                high[i] = high[i].max(p[i] + margin);
            }
        }
        let clamp = |v: f64, limit: usize| v.clamp(0.0, limit as f64) as usize;
        let (left, top) = (clamp(low[0].floor(), self.width), clamp(low[1].floor(), self.height));
        let (right, bottom) = (clamp(high[0].ceil(), self.width), clamp(high[1].ceil(), self.height));
        (left < right && top < bottom).then_some((left, top, right, bottom))
    }

    /// Encodes the canvas as PNG.
    ///
    /// # Errors
    /// If the encoder fails.
    pub(crate) fn png(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let failed = |e: png::EncodingError| Error::new(format!("cannot encode PNG: {e}"));
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(self.pixels.as_flattened()).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }

    /// Writes a PNG file, complete or not at all.
    ///
    /// # Errors
    /// Failures of the file system.
    pub(crate) fn write_png(&self, path: &Path) -> Result<()> {
        let bytes = self.png()?;
        files::write_atomically(path, |out| out.write_all(&bytes).map_err(|e| Error::io(path, &e)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_comes_back() {
        let mut canvas = Canvas::new(5, 3).unwrap();
        canvas.set(4, 2, [1, 2, 3]);
        canvas.set(9, 9, [1, 2, 3]);
        let mut reader = png::Decoder::new(std::io::Cursor::new(canvas.png().unwrap())).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        assert_eq!(data, canvas.pixels().as_flattened());
        assert_eq!(canvas.get(4, 2), [1, 2, 3]);
        assert!(Canvas::new(0, 3).is_err() && Canvas::new(usize::MAX, 3).is_err());
    }

    #[test]
    fn polygons_cover_their_area_and_leave_no_seams() {
        let mut canvas = Canvas::new(20, 20).unwrap();
        let square = vec![[2.0, 2.0], [7.5, 2.0], [7.5, 6.25], [2.0, 6.25]];
        canvas.fill(&[(vec![square.clone()], [0; 3])]);
        let dark: f64 = canvas.pixels().iter().map(|p| 1.0 - f64::from(p[0]) / 255.0).sum();
        assert!((dark - 5.5 * 4.25).abs() < 0.05, "{dark}");
        assert_eq!(canvas.get(3, 3), [0; 3]);
        // A hole is a line the other way round; the same way round it is none.
        let hole = vec![[3.0, 3.0], [3.0, 5.0], [5.0, 5.0], [5.0, 3.0]];
        for (contours, colour) in [(vec![square.clone(), hole.clone()], [255; 3]), (vec![square, hole.into_iter().rev().collect()], [0; 3])]
        {
            let mut canvas = Canvas::new(20, 20).unwrap();
            canvas.fill(&[(contours, [0; 3])]);
            assert_eq!((canvas.get(4, 4), canvas.get(6, 4)), (colour, [0; 3]));
        }
        // A fan of triangles over a square: the seams must be as dark as the rest.
        let mut canvas = Canvas::new(20, 20).unwrap();
        let centre = [9.3, 10.1];
        let rim = [[1.0, 1.0], [12.7, 1.0], [19.0, 1.0], [19.0, 19.0], [4.4, 19.0], [1.0, 19.0]];
        let triangles: Vec<_> = (0..6).map(|i| (vec![vec![centre, rim[i], rim[(i + 1) % 6]]], [0; 3])).collect();
        canvas.fill(&triangles);
        for y in 1..19 {
            for x in 1..19 {
                assert!(canvas.get(x, y)[0] <= 1, "{x} {y}: {:?}", canvas.get(x, y));
            }
        }
    }

    #[test]
    fn lines_have_their_width_and_nothing_panics_outside() {
        let mut canvas = Canvas::new(40, 20).unwrap();
        canvas.stroke(&[vec![[-10.0, 10.0], [60.0, 10.0]]], 3.0, [0; 3]);
        let column: f64 = (0..20).map(|y| 1.0 - f64::from(canvas.get(20, y)[0]) / 255.0).sum();
        assert!((column - 3.0).abs() < 0.05, "{column}");
        let odd = vec![[f64::NAN, 1.0], [1e30, -1e30]];
        canvas.stroke(std::slice::from_ref(&odd), 3.0, [0; 3]);
        canvas.fill(&[(vec![odd], [0; 3])]);
        canvas.text([-50.0, 500.0], "outside", 12.0, [0; 3], true, Some(WHITE));
        canvas.text([2.0, 8.0], "", 12.0, [0; 3], false, None);
        canvas.image([30.0, 10.0, 90.0, 90.0], 2, &[[9; 3]; 4]);
        assert_eq!(canvas.get(39, 19), [9; 3]);
    }
}
