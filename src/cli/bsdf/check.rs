//! `lucarne bsdf check`.

use lucarne::bsdf::check::{Finding, Verdict, check, is_sound, repair};
use lucarne::bsdf::{self};
use lucarne::{Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// The BSDF doctor: header, blocks, positivity, orientation, energy balance and reciprocity.
///
/// Exit code 0: sound. 1: faults found. 2: unreadable.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  lucarne bsdf check blinds.xml\n  lucarne bsdf check blinds.xml --repair -o repaired.xml")]
pub struct Args {
    /// XML file of WINDOW, genBSDF or wrapBSDF; or an interpolant (.sir), as the Klems matrix that it gives.
    file: PathBuf,
    /// Repair what can be repaired safely, write the result to -o and say what was changed.
    #[arg(long, requires = "output")]
    repair: bool,
    /// File for the repaired BSDF.
    #[arg(short, long, requires = "repair")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args, _warnings: &mut Warnings) -> Result<ExitCode> {
    let mut reading = Warnings::new();
    let bsdf = match super::read_any(&args.file, &mut reading) {
        Ok(bsdf) => bsdf,
        Err(error) => {
            eprintln!("lucarne: error: {error}");
            return Ok(ExitCode::from(2));
        }
    };
    let mut findings = check(&bsdf, &reading);
    print!("{}", describe(&findings));
    if let (true, Some(output)) = (args.repair, &args.output) {
        let (repaired, mut changes) = repair(&bsdf);
        if !reading.is_empty() {
            changes.push("header written anew".to_string());
        }
        bsdf::write(Some(output), &repaired, &super::made_by())?;
        findings = check(&repaired, &Warnings::new());
        println!("\nwritten to {}:", output.display());
        for change in &changes {
            println!("  {change}");
        }
        if changes.is_empty() {
            println!("  nothing could be repaired");
        }
        for finding in findings.iter().filter(|f| f.verdict == Verdict::Fault) {
            println!("  still wrong: {}: {}", finding.place, finding.text);
        }
    }
    Ok(if is_sound(&findings) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn describe(findings: &[Finding]) -> String {
    let mut text = String::new();
    for finding in findings {
        let verdict = match finding.verdict {
            Verdict::Sound => "ok   ",
            Verdict::Note => "note ",
            Verdict::Fault => "FAULT",
        };
        text += &format!("{verdict} {:<12} {:<28} {}\n", finding.item, finding.place, finding.text.replace('\n', "\n      "));
    }
    let faults = findings.iter().filter(|f| f.verdict == Verdict::Fault).count();
    text + &match faults {
        0 => "\nsound\n".to_string(),
        1 => "\n1 fault\n".to_string(),
        n => format!("\n{n} faults\n"),
    }
}
