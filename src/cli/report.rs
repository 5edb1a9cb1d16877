//! `lucarne report`: a page of results.

use lucarne::report::Report;
use lucarne::simulate::Results;
use lucarne::{Error, Result};
use std::path::PathBuf;
use std::process::ExitCode;

/// A page that shows what a run found: plan and section, heat maps, the year, glare, errors, warnings.
///
/// One HTML file that needs no network; print it to have a PDF. Several folders stand beside each other.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  lucarne report out/office\n  lucarne report out/before out/after -o compared.html --figures figures")]
pub struct Args {
    /// Folders of results, as 'lucarne run' writes them.
    #[arg(required = true, value_name = "RESULTS")]
    folders: Vec<PathBuf>,
    /// The page; of one folder report.html in it, if nothing is said.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Writes every figure as SVG and PNG and every table as CSV and JSON into this folder, too.
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let output = match (&args.output, &args.folders[..]) {
        (Some(output), _) => output.clone(),
        (None, [folder]) => folder.join("report.html"),
        (None, _) => return Err(Error::new("a report of several folders needs a name").help("add -o FILE.html")),
    };
    let results = args.folders.iter().map(|folder| Results::open(folder)).collect::<Result<Vec<_>>>()?;
    let report = Report::new(&results)?;
    report.write(&output)?;
    println!("{}", output.display());
    if let Some(folder) = &args.figures {
        let count = report.write_parts(folder)?;
        println!("{count} files in {}", folder.display());
    }
    Ok(ExitCode::SUCCESS)
}
