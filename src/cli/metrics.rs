//! `lucarne metrics`: named metrics of a finished result folder.

use lucarne::metrics::Metric;
use lucarne::simulate::project::metrics::{MetricsSection, OccupancyChoice};
use lucarne::simulate::year::metrics::judge_folder;
use lucarne::{Error, Result};
use std::path::PathBuf;
use std::process::ExitCode;

/// Judges a finished result folder again: DA, cDA, UDI, LM-83, EN 17037, LEED. Nothing is traced, no device is needed,
/// and the folder stays as it is.
///
/// Standard errors are those of the hours, as if all hours and sensors erred the same way: no less than they are, and
/// more than those of the run, which knows how hours err together.
#[derive(clap::Args)]
pub struct Args {
    /// Folder that 'lucarne run' has written
    folder: PathBuf,

    /// Hours that count for DA, cDA and UDI: lm-83, en-17037, or a CSV with a line of 0 or 1 for each hour of the year
    /// (default: lm-83)
    #[arg(long, value_name = "HOURS")]
    occupancy: Option<String>,

    /// Illuminance of DA and cDA, lx
    #[arg(long, value_name = "LUX", default_value_t = lucarne::metrics::AUTONOMY_LX)]
    autonomy: f64,

    /// Writes all of them into a CSV too
    #[arg(short = 'o', value_name = "FILE.csv")]
    output: Option<PathBuf>,

    /// All of them, for programs
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<ExitCode> {
    if !(args.autonomy > 0.0 && args.autonomy.is_finite()) {
        return Err(Error::new(format!("{} lx is no illuminance of daylight autonomy", args.autonomy))
            .field("--autonomy")
            .help("give lx, as 300"));
    }
    let occupancy = match args.occupancy.as_deref() {
        None | Some("lm-83") => OccupancyChoice::Lm83,
        Some("en-17037") => OccupancyChoice::En17037,
        Some(file) => OccupancyChoice::File(file.into()),
    };
    let section = MetricsSection { occupancy, autonomy: args.autonomy, ..MetricsSection::default() };
    let metrics = judge_folder(&args.folder, &section)?;
    if let Some(path) = &args.output {
        lucarne::simulate::year::metrics::write(path, &metrics)?;
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&metrics).map_err(|e| Error::new(e.to_string()))?);
        return Ok(ExitCode::SUCCESS);
    }
    let mut of = "";
    for metric in &metrics {
        if metric.of != of {
            of = &metric.of;
            println!("{of}");
        }
        print_one(metric);
    }
    Ok(ExitCode::SUCCESS)
}

/// The last lines of a run: what standards name. Means over the sensors are in the table.
pub fn print(metrics: &[Metric]) {
    metrics.iter().filter(|m| !m.is_detail()).for_each(print_one);
}

fn print_one(metric: &Metric) {
    println!("  {}: {}", metric.title, metric.result());
    // What makes a number another one than its name could say must stand beside it.
    if metric.lm83_conformant == Some(false) || metric.value.is_none() && metric.class.is_none() {
        metric.notes.iter().for_each(|note| println!("    {note}"));
    }
}
