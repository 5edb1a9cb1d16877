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
    /// Size of the picture or window, pixels.
    #[arg(long, default_value = "1280x800", value_parser = parse_size)]
    pub size: Size,
    /// Enlargement of text and controls (for fine screens 2).
    #[arg(long, default_value_t = 1.0, value_parser = parse_enlargement)]
    pub scale: f32,
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
        assert_eq!((args.panel, args.hour, args.size), (Some(PanelKind::Year), Some(1929), Size([640, 480])));
    }
}
