//! genBSDF's options that are called otherwise here, or have no counterpart: a command line written
//! for genBSDF works, or is told what to use instead.

use super::Args;
use lucarne::{Error, Result, Warnings, files};
use std::path::{Path, PathBuf};

/// For `#[command(flatten)]`.
#[derive(clap::Args, Clone)]
#[command(next_help_heading = "As in genBSDF")]
pub struct GenBsdfOptions {
    /// Options of rcontrib, or @FILE: -ab is taken, the others have no counterpart
    #[arg(short = 'r', value_name = "OPTIONS", allow_hyphen_values = true)]
    rcontrib: Vec<String>,

    /// Number of processes: of no effect
    #[arg(short = 'n', value_name = "N")]
    processes: Option<u32>,

    /// As --unit; +geom UNIT also embeds the geometry
    #[arg(long, value_name = "UNIT")]
    geom: Option<String>,

    /// Name and manufacturer: 'n=TEXT;m=TEXT'
    #[arg(short = 's', value_name = "FIELDS")]
    fields: Vec<String>,

    /// As --reciprocity keep (+a: auto)
    #[arg(short = 'a')]
    no_average: bool,

    /// No colour: always so
    #[arg(short = 'C')]
    grey: bool,

    /// For WINDOW: always so
    #[arg(short = 'W')]
    window: bool,

    /// Files are not MGF: always so
    #[arg(long)]
    mgf: bool,

    /// An interrupted run goes on by itself: give its command again
    #[arg(long, value_name = "FOLDER")]
    recover: Option<PathBuf>,
}

/// The arguments with genBSDF's put into those of this program; words like `+f` are no files any more.
pub(super) fn translated(mut args: Args, warnings: &mut Warnings) -> Result<Args> {
    if args.genbsdf.recover.is_some() {
        return Err(Error::new("there is nothing to recover from")
            .field("-recover")
            .help("give the interrupted command again: it goes on from FILE.xml.resume beside its output"));
    }
    let mut words = std::mem::take(&mut args.files).into_iter();
    while let Some(word) = words.next() {
        let text = word.to_str().unwrap_or_default();
        // genBSDF looks at the first letter alone.
        match text.get(..2).filter(|start| start.starts_with('+')) {
            Some("+f" | "+b" | "+a") => {}
            Some("+g") => {
                args.geometry = true;
                args.genbsdf.geom = Some(words.next().and_then(|w| w.to_str().map(str::to_owned)).unwrap_or_default());
            }
            Some("+m") => return Err(Error::new("MGF is not read").field(text).help("turn it into Radiance's format first: mgf2rad")),
            Some("+C") => return Err(Error::new("colour is not made").field(text).help("leave it out: the file gets visible values")),
            Some(_) => return Err(Error::new("this is neither a file nor an option of genBSDF").field(text)),
            None => args.files.push(word),
        }
    }
    if let Some(unit) = args.genbsdf.geom.take() {
        super::unit(&unit).map_err(|e| e.field("geom"))?;
        args.unit = unit;
    }
    if args.genbsdf.no_average && args.reciprocity == "auto" {
        args.reciprocity = "keep".into();
    }
    let fields = args.genbsdf.fields.join(";");
    for field in fields.split(';').map(str::trim).filter(|field| !field.is_empty()) {
        match field.split_once('=') {
            Some(("n", name)) => args.name = Some(name.into()),
            Some(("m", manufacturer)) => args.manufacturer = manufacturer.into(),
            _ => warnings.push(Error::new(format!("'{field}' is left out")).field("-s").help("n= (name) and m= (manufacturer) are taken")),
        }
    }
    let (bounces, others) = rcontrib_options(&args.genbsdf.rcontrib.join(" "))?;
    args.bounces = args.bounces.or(bounces);
    if !others.is_empty() {
        warnings.push(
            Error::new(format!("{} of rcontrib have no counterpart and are left out", others.join(" ")))
                .field("-r")
                .help("-c and --batches decide how exact the result is"),
        );
    }
    Ok(args)
}

/// The number of `-ab` among options of rcontrib, and the words of all others.
fn rcontrib_options(text: &str) -> Result<(Option<u32>, Vec<String>)> {
    let (mut bounces, mut others) = (None, Vec::new());
    let mut words = text.split_whitespace();
    while let Some(word) = words.next() {
        if let Some(file) = word.strip_prefix('@') {
            let text = String::from_utf8_lossy(&files::read(Path::new(file))?).into_owned();
            let (more, left) = rcontrib_options(&text.replace('@', " "))?;
            bounces = more.or(bounces);
            others.extend(left);
        } else if matches!(word, "-ab" | "--ab") {
            let number = words.next().unwrap_or("nothing");
            let parsed = number.parse().map_err(|_| Error::new(format!("'{number}' is no number of reflections")).field("-r -ab"));
            bounces = Some(parsed?);
        } else {
            others.push(word.strip_prefix('-').filter(|rest| rest.starts_with('-')).unwrap_or(word).to_owned());
        }
    }
    Ok((bounces, others))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Program {
        #[command(flatten)]
        args: Args,
    }

    fn parsed(line: &str) -> Result<(Args, Vec<String>)> {
        let mut warnings = Warnings::new();
        let words = shell_words(line);
        let words = crate::cli::radiance_style_arguments(words.into_iter().map(Into::into));
        let args = Program::try_parse_from(words).map_err(|e| Error::new(e.to_string()))?.args;
        let args = translated(args, &mut warnings)?;
        Ok((args, warnings.iter().map(ToString::to_string).collect()))
    }

    /// Words in single quotes stay together.
    fn shell_words(line: &str) -> Vec<String> {
        let mut words = Vec::new();
        for (k, part) in line.split('\'').enumerate() {
            if k % 2 == 1 { words.push(part.to_owned()) } else { words.extend(part.split_whitespace().map(str::to_owned)) }
        }
        words
    }

    #[test]
    fn command_lines_of_genbsdf_mean_the_same_here() {
        let folder = tempfile::tempdir().unwrap();
        let options = folder.path().join("rtc.opt");
        std::fs::write(&options, "-ab 7 -ad 1000\n-lw 1e-6\n").unwrap();
        let (args, warnings) = parsed("generate -n 8 -c 500 -r '-ab 5 -ad 700 -lw 3e-6' +f +b -geom inch mat.rad blinds.rad").unwrap();
        assert_eq!((args.bounces, args.samples, args.unit.as_str(), args.geometry), (Some(5), 500, "inch", false));
        assert_eq!(args.files, [PathBuf::from("mat.rad"), "blinds.rad".into()]);
        assert!((warnings.len(), warnings[0].contains("-ad 700 -lw 3e-6")) == (1, true), "{warnings:?}");

        let (args, warnings) = parsed("generate +forward -backward +geom millimeter +a -t4 5 -t -1 blinds.rad").unwrap();
        assert_eq!((args.no_front, args.no_back, args.unit.as_str(), args.geometry), (false, true, "millimeter", true));
        assert_eq!((args.tree4, args.cull, args.reciprocity.as_str(), args.files.len()), (Some(5), -1.0, "auto", 1));
        assert!(warnings.is_empty(), "{warnings:?}");

        let (args, warnings) = parsed("generate -a -C -W -mgf -s 'm=MF;n=my blind;c=x' -dim 0 1 0 1 -0.1 0 b.rad").unwrap();
        assert_eq!((args.reciprocity.as_str(), args.name.as_deref(), args.manufacturer.as_str()), ("keep", Some("my blind"), "MF"));
        assert!(args.dim.is_some() && warnings.len() == 1 && warnings[0].contains("c=x"), "{warnings:?}");

        let (args, _) = parsed(&format!("generate -r @{} b.rad", options.display())).unwrap();
        assert_eq!(args.bounces, Some(7));
        // An option of this program's own comes first.
        assert_eq!(parsed("generate -ab 2 -r '-ab 5' b.rad").unwrap().0.bounces, Some(2));
    }

    #[test]
    fn what_has_no_counterpart_is_answered() {
        for (line, wanted) in [
            ("generate -recover /tmp/genBSDF.x", "interrupted command again"),
            ("generate +mgf b.mgf", "mgf2rad"),
            ("generate +C b.rad", "colour"),
            ("generate +x b.rad", "neither"),
            ("generate -geom furlong b.rad", "furlong"),
            ("generate b.rad +geom", "no unit"),
            ("generate -r -ab b.rad", "no number of reflections"),
            ("generate -r @/does/not/exist b.rad", "/does/not/exist"),
        ] {
            let error = parsed(line).map(|(args, _)| args.files).expect_err(line).to_string();
            assert!(error.contains(wanted), "{line}: {error}");
        }
    }
}
