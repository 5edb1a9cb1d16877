//! `lucarne sky`: the sky matrix of a weather file, with gendaymtx's options, or of one moment under a CIE sky.

use clap::ArgAction;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::{Format, write_matrix, write_matrix_to};
use lucarne::progress::Silent;
use lucarne::sky::cie::{CieMoment, CieSky, TURBIDITY};
use lucarne::sky::{SkyOptions, sky_matrix};
use lucarne::weather::Weather;
use lucarne::weather::sun::position;
use lucarne::weather::time::Time;
use lucarne::{Error, Result, Warnings, files};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Sky matrix [patch][hour] of RGB radiance from a weather file, options as gendaymtx; or its one column of a
/// CIE sky, as gensky and genskyvec: --cie clear --date 03-21T12:00 --site 46.5,11.35,15
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub struct Args {
    /// Weather file, EPW or WEA; standard input if absent or `-`
    weather: Option<PathBuf>,

    /// One moment under a sky of the CIE in place of a weather file; with its sun unless -s is given
    #[arg(long, value_name = "KIND", value_parser = cie_kind, conflicts_with_all = ["weather", "sun_hours_only", "average", "output_type"], requires = "date", requires = "site")]
    cie: Option<CieSky>,

    /// Month, day and standard time of the moment
    #[arg(long, value_name = "03-21T12:00", requires = "cie")]
    date: Option<String>,

    /// Latitude and longitude (degrees north and east) and the meridian of its standard time (degrees east)
    #[arg(long, value_name = "LAT,LON,MERIDIAN", requires = "cie", allow_hyphen_values = true)]
    site: Option<String>,

    /// Turbidity of the air of a clear or intermediate sky
    #[arg(long, value_name = "T", requires = "cie", default_value_t = TURBIDITY)]
    turbidity: f64,

    /// Matrix file to write; standard output if absent or `-`
    #[arg(short = 'o', value_name = "FILE")]
    output: Option<PathBuf>,

    /// Reinhart subdivision MF:N, 1 to 6
    #[arg(short = 'm', value_name = "N", default_value_t = 1)]
    subdivision: usize,

    /// Sun only: sky and ground black
    #[arg(short = 'd', conflicts_with = "sky_only")]
    sun_only: bool,

    /// Sky and ground only, without the sun's patches
    #[arg(short = 's')]
    sky_only: bool,

    /// The whole sun in the nearest patch, as radiance of a disc of this full angle (degrees; for
    /// the five-phase method 0.533)
    #[arg(short = '5', value_name = "ANGLE", allow_negative_numbers = true)]
    sun_disc: Option<f64>,

    /// 0: visible radiation, 179 lm to the watt; 1: the whole solar spectrum
    #[arg(short = 'O', value_name = "0|1", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=1))]
    output_type: u8,

    /// Reflectance of the ground
    #[arg(short = 'g', num_args = 3, value_names = ["R", "G", "B"], default_values_t = [0.2, 0.2, 0.2], allow_negative_numbers = true)]
    ground: Vec<f64>,

    /// Colour of the sky
    #[arg(short = 'c', num_args = 3, value_names = ["R", "G", "B"], default_values_t = [0.96, 1.004, 1.118], allow_negative_numbers = true)]
    color: Vec<f64>,

    /// Turn the sky counter-clockwise, degrees
    #[arg(short = 'r', long = "rz", value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true)]
    rotation: f64,

    /// Only hours with the sun above the horizon
    #[arg(short = 'u')]
    sun_hours_only: bool,

    /// One column: the mean of all hours
    #[arg(short = 'A')]
    average: bool,

    /// Length of the time steps: those with sunrise or sunset get the sun of their sunlit part
    #[arg(short = 'i', value_name = "MINUTES", default_value_t = 0.0, allow_negative_numbers = true)]
    interval: f64,

    /// Write numbers as text (default on standard output)
    #[arg(long = "oa", conflicts_with_all = ["float", "double"])]
    ascii: bool,

    /// Write 32-bit numbers (default in a file)
    #[arg(long = "of", conflicts_with = "double")]
    float: bool,

    /// Write 64-bit numbers
    #[arg(long = "od")]
    double: bool,

    /// Write no header
    #[arg(short = 'h')]
    no_header: bool,

    /// Print help
    #[arg(long, action = ArgAction::Help)]
    help: Option<bool>,
}

fn cie_kind(word: &str) -> std::result::Result<CieSky, String> {
    let kind = CieSky::ALL.into_iter().find(|(name, _)| *name == word).map(|(_, kind)| kind);
    kind.ok_or_else(|| format!("choose one of {}", CieSky::ALL.map(|(name, _)| name).join(", ")))
}

/// Latitude, longitude and standard meridian, degrees north and east.
fn site(text: &str) -> Result<[f64; 3]> {
    let wrong = || {
        Error::new(format!("'{text}' is no site"))
            .field("--site")
            .help("write latitude, longitude and standard meridian in degrees north and east, as 46.5,11.35,15")
    };
    let values: Vec<f64> = text.split(',').map(|v| v.trim().parse().ok()).collect::<Option<_>>().ok_or_else(wrong)?;
    let [latitude, longitude, meridian] = values[..] else { return Err(wrong()) };
    let fits = |v: f64, most: f64| v.abs() <= most;
    if !(fits(latitude, 90.0) && fits(longitude, 180.0) && fits(meridian, 210.0)) {
        return Err(wrong());
    }
    Ok([latitude, longitude, meridian])
}

/// The column of a CIE sky and its header.
fn moment(args: &Args, kind: CieSky, options: &SkyOptions, warnings: &mut Warnings) -> Result<(Matrix<f32>, Vec<String>)> {
    let time = Time::parse(args.date.as_deref().unwrap_or_default()).map_err(|e| e.field("--date"))?;
    let [latitude, longitude, meridian] = site(args.site.as_deref().unwrap_or_default())?;
    if (longitude - meridian).abs() > 45.0 {
        let message =
            format!("the standard meridian {meridian}° is {:.0}° away from the longitude {longitude}°", (longitude - meridian).abs());
        warnings.push(Error::new(message).field("--site").help("both are degrees east; west is negative"));
    }
    if !(args.turbidity > 0.0 && args.turbidity.is_finite()) {
        return Err(Error::new("the turbidity must be above 0").field("--turbidity").help("clear air has about 2.45"));
    }
    let mut sun = position(latitude, longitude, meridian / 15.0, time.day_of_year(), time.hour);
    sun.azimuth -= options.rotation.to_radians();
    let matrix = CieMoment::new(kind, sun, args.turbidity, warnings)?.matrix(options)?;
    Ok((matrix, vec![command_line(), format!("LATLONG= {latitude:.8} {longitude:.8}")]))
}

pub fn run(args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let rgb = |values: &[f64]| [values[0], values[1], values[2]];
    let options = SkyOptions {
        subdivision: args.subdivision,
        sky: !args.sun_only,
        sun: !args.sky_only,
        sun_disc: args.sun_disc,
        sky_color: rgb(&args.color),
        ground_reflectance: rgb(&args.ground),
        solar_spectrum: args.output_type == 1,
        rotation: args.rotation,
        sun_hours_only: args.sun_hours_only,
        average: args.average,
        interval_minutes: args.interval,
    };
    let (matrix, header) = match args.cie {
        Some(kind) => moment(&args, kind, &options, warnings)?,
        None => {
            let weather = read_weather(args.weather.as_deref(), warnings)?;
            let mut header = vec![command_line(), format!("LATLONG= {:.8} {:.8}", weather.latitude, weather.longitude)];
            if options.average {
                header.push(format!("NAVERAGED={}", averaged_hours(&weather, &options)?));
            }
            (sky_matrix(&weather, &options, &Silent)?, header)
        }
    };
    let path = args.output.as_deref().filter(|p| *p != Path::new("-"));
    let format = match (args.ascii, args.float, args.double) {
        (true, ..) => Format::Ascii,
        (_, true, _) => Format::Float,
        (.., true) => Format::Double,
        _ if path.is_some() => Format::Float,
        _ => Format::Ascii,
    };
    if args.no_header {
        write_without_header(path, &matrix, format)?;
    } else {
        write_matrix(path, &matrix, format, &header)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn averaged_hours(weather: &Weather, options: &SkyOptions) -> Result<usize> {
    Ok(lucarne::sky::sky_columns(weather, options)?.len())
}

fn read_weather(path: Option<&Path>, warnings: &mut Warnings) -> Result<Weather> {
    match path {
        Some(path) if path != Path::new("-") => Weather::read(path, warnings),
        _ => {
            const NAME: &str = "standard input";
            let mut bytes = Vec::new();
            std::io::stdin().lock().read_to_end(&mut bytes).map_err(|e| Error::io(NAME, &e))?;
            Weather::from_bytes(&bytes, warnings).map_err(|e| e.file(NAME))
        }
    }
}

/// The command as typed, for the header, as Radiance's programs keep it.
pub(super) fn command_line() -> String {
    let words: Vec<String> = std::env::args().skip(1).map(|w| w.replace(|c: char| c.is_control(), " ")).collect();
    format!("lucarne {}", words.join(" "))
}

pub(super) fn write_without_header(path: Option<&Path>, matrix: &Matrix<f32>, format: Format) -> Result<()> {
    let write = |out: &mut dyn Write| {
        let mut body = BodyOnly { out, newline_before: false, in_body: false };
        write_matrix_to(&mut body, matrix, format, &[])
    };
    match path {
        Some(path) => files::write_atomically(path, write).map_err(|e| e.file(path)),
        None => {
            let mut out = std::io::BufWriter::new(std::io::stdout().lock());
            write(&mut out).and_then(|()| out.flush().map_err(|e| Error::io("standard output", &e))).map_err(|e| e.file("standard output"))
        }
    }
}

/// Drops everything up to and including the first empty line.
struct BodyOnly<'a> {
    out: &'a mut dyn Write,
    newline_before: bool,
    in_body: bool,
}

impl Write for BodyOnly<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if self.in_body {
            return self.out.write(bytes);
        }
        for (i, &byte) in bytes.iter().enumerate() {
            if byte == b'\n' && self.newline_before {
                self.in_body = true;
                return Ok(i + 1);
            }
            self.newline_before = byte == b'\n';
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}
