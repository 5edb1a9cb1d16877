//! The command line.

use clap::{Parser, ValueEnum};
use std::path::PathBuf;

/// Look at BSDFs, pictures and results: hemispheres, falsecolours, a year to scrub, sensors on their plan.
///
/// Opens result folders of `lucarne run`, BSDF files (.xml), pictures (.hdr, .pic, .exr) and matrices
/// (.mtx). Two BSDF files are compared. Without a file, the one of last time is opened.
#[derive(Parser, Debug, Clone, Default)]
#[command(
    name = "lucarne-viewer",
    version,
    after_help = "Examples:\n  lucarne-viewer out/office\n  lucarne-viewer bsdf/clear.xml --screenshot bsdf.png --size 1280x800\n  lucarne-viewer out/ --panel year --hour 1929 --screenshot year.png"
)]
pub struct Args {
    /// Files and folders to open.
    pub files: Vec<PathBuf>,
    /// Panel to show first.
    #[arg(long, value_enum)]
    pub panel: Option<PanelKind>,
    /// Hour of the year to show, from 0.
    #[arg(long)]
    pub hour: Option<usize>,
    /// Write a picture of the window to this PNG file and end; needs no window system.
    #[arg(long, value_name = "PNG")]
    pub screenshot: Option<PathBuf>,
    /// Size of the picture or window, pixels [default: 1280x800; for the window that of last time].
    #[arg(long, value_parser = parse_size)]
    pub size: Option<Size>,
    /// Enlargement of text and controls, for fine screens 2 [default: 1; for the window that of last time].
    #[arg(long, value_parser = parse_enlargement)]
    pub scale: Option<f32>,
    /// Dark or light window.
    #[arg(long, value_enum)]
    pub theme: Option<ThemeChoice>,
}

/// One panel of the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Default)]
pub enum PanelKind {
    /// Scattering of a window: hemispheres.
    Bsdf,
    /// A picture.
    Picture,
    /// A year of results.
    #[default]
    Year,
    /// Sensors on their plan.
    Grid,
}

impl PanelKind {
    /// All panels in the order of their tabs.
    pub const ALL: [Self; 4] = [Self::Year, Self::Grid, Self::Picture, Self::Bsdf];

    /// The tab's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bsdf => "BSDF",
            Self::Picture => "Picture",
            Self::Year => "Year",
            Self::Grid => "Grid",
        }
    }
}

/// Colours of the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ThemeChoice {
    /// Dark text on white.
    Light,
    /// Light text on black.
    Dark,
}

/// Width and height, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

impl Default for Size {
    fn default() -> Self {
        Self([1280, 800])
    }
}

/// Sizes of a new window, points of the screen: the first one, and the least. What the command line
/// asks for counts more than what is remembered.
pub fn window_size(asked: Option<Size>, remembered: Option<[f32; 2]>) -> [[f32; 2]; 2] {
    const LEAST: [f32; 2] = [640.0, 480.0];
    match asked {
        Some(Size(size)) => {
            let [w, h] = size.map(|n| n as f32);
            [[w, h], [w.min(LEAST[0]), h.min(LEAST[1])]]
        }
        None => {
            let [w, h] = remembered.unwrap_or(Size::default().0.map(|n| n as f32));
            [[w.clamp(LEAST[0], 4000.0), h.clamp(LEAST[1], 3000.0)], LEAST]
        }
    }
}

fn parse_size(text: &str) -> Result<Size, String> {
    let numbers: Vec<u32> = text.split(['x', 'X', '×']).filter_map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        [w, h] if (200..=8192).contains(&w) && (200..=8192).contains(&h) => Ok(Size([w, h])),
        _ => Err(format!("'{text}' is no size: write for instance 1280x800 (200 to 8192 pixels)")),
    }
}

fn parse_enlargement(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(v) if (0.5..=4.0).contains(&v) => Ok(v),
        _ => Err(format!("'{text}' is no enlargement between 0.5 and 4")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_the_lines_of_the_manual_are_understood() {
        assert_eq!(parse_size("1280x800"), Ok(Size([1280, 800])));
        assert!(parse_size("12").is_err() && parse_size("10x10").is_err());
        let args = Args::try_parse_from("v out/ --panel year --hour 1929 --screenshot year.png --size 640x480".split(' ')).unwrap();
        assert_eq!((args.panel, args.hour, args.size), (Some(PanelKind::Year), Some(1929), Some(Size([640, 480]))));
        assert!(Args::try_parse_from("v --scale 9".split(' ')).is_err());
    }

    #[test]
    fn a_size_that_was_asked_for_counts_more_than_the_remembered_one() {
        let remembered = Some([900.0, 700.0]);
        assert_eq!(window_size(Some(Size([400, 300])), remembered), [[400.0, 300.0], [400.0, 300.0]]);
        assert_eq!(window_size(Some(Size([1920, 1080])), remembered), [[1920.0, 1080.0], [640.0, 480.0]]);
        assert_eq!(window_size(None, remembered)[0], [900.0, 700.0]);
        assert_eq!(window_size(None, None)[0], [1280.0, 800.0]);
        assert_eq!(window_size(None, Some([10.0, 1e9]))[0], [640.0, 3000.0]);
    }
}
