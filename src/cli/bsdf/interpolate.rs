//! `lucarne bsdf interpolate`.

use lucarne::bsdf::{self, Bsdf, interpolate};
use lucarne::{Error, Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// States of switchable glazing between measured ones, linear in every value.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  lucarne bsdf interpolate clear.xml cloudy.xml --states 5 -o state_%d.xml   # state_0 … state_4, ends included\n  \
    lucarne bsdf interpolate clear.xml cloudy.xml --at 0.3 -o state.xml"
)]
pub struct Args {
    /// Measured states, two or more, in order.
    #[arg(required = true, num_args = 2..)]
    files: Vec<PathBuf>,
    /// Number of states to write, ends included.
    #[arg(long, conflicts_with = "at", required_unless_present = "at")]
    states: Option<usize>,
    /// One state at this fraction of the way from the first to the last file.
    #[arg(long)]
    at: Option<f64>,
    /// XML file to write; with --states a pattern with %d (or %03d) for the number of the state.
    #[arg(short, long)]
    output: Option<String>,
}

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let measured: Vec<Bsdf> = args.files.iter().map(|f| bsdf::read(f, warnings)).collect::<Result<_>>()?;
    if let Some(fraction) = args.at {
        if !(0.0..=1.0).contains(&fraction) {
            return Err(Error::new(format!("{fraction} is outside 0…1")).field("--at"));
        }
        let last = measured.len() - 1;
        let position = fraction * last as f64;
        let from = (position.floor() as usize).min(last - 1);
        let state = interpolate::interpolate(&measured[from], &measured[from + 1], position - from as f64, warnings)?;
        bsdf::write(args.output.as_deref().map(std::path::Path::new), &state, &super::made_by())?;
        return Ok(ExitCode::SUCCESS);
    }
    let count = args.states.unwrap_or_default();
    let pattern = args
        .output
        .as_deref()
        .ok_or_else(|| Error::new("no pattern for the files' names").field("-o").help("for instance -o state_%d.xml"))?;
    // A wrong pattern is found before any work.
    numbered(pattern, 0)?;
    for (k, state) in interpolate::states(&measured, count, warnings)?.iter().enumerate() {
        bsdf::write(Some(std::path::Path::new(&numbered(pattern, k)?)), state, &super::made_by())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Puts a number into a pattern with one `%d` or `%0Nd`.
fn numbered(pattern: &str, number: usize) -> Result<String> {
    let wrong =
        || Error::new(format!("'{pattern}' has no place for a number")).field("-o").help("write %d or %03d where the number should stand");
    let (before, rest) = pattern.split_once('%').ok_or_else(wrong)?;
    let (width, after) = rest.split_once('d').ok_or_else(wrong)?;
    let width: usize = if width.is_empty() { 0 } else { width.parse().map_err(|_| wrong())? };
    if width > 9 || after.contains('%') {
        return Err(wrong());
    }
    Ok(format!("{before}{number:0width$}{after}"))
}

#[cfg(test)]
mod tests {
    use super::numbered;

    #[test]
    fn patterns_take_one_number() {
        assert_eq!(numbered("state_%d.xml", 3).unwrap(), "state_3.xml");
        assert_eq!(numbered("s%03d", 12).unwrap(), "s012");
        for wrong in ["state.xml", "s%x.xml", "%d%d", "%99d"] {
            assert!(numbered(wrong, 1).is_err(), "{wrong}");
        }
    }
}
