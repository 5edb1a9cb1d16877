//! Reading measurements line by line.

use super::{Options, Quantity, SAME_INCIDENCE, Scan, angle};
use crate::bsdf::Component;
use crate::error::{Error, Result, Warnings};
use crate::limits;
use crate::text::{self, Other};
use glam::DVec3;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// What one file holds.
pub(super) struct Measured {
    pub name: String,
    pub scans: Vec<Scan>,
}

/// Lines of a file, one at a time, each of bounded length.
struct Lines {
    input: BufReader<File>,
    buffer: Vec<u8>,
    number: usize,
}

impl Lines {
    fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|e| Error::io(path, &e))?;
        let mut input = BufReader::with_capacity(1 << 16, file);
        let head = input.fill_buf().map_err(|e| Error::io(path, &e))?;
        if let Some(other) = Other::of(head).filter(|o| *o != text::GONIOPHOTOMETER) {
            return Err(other.instead_of(WHAT));
        }
        if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
            return Err(Error::new("this is UTF-16 text").help("save it as UTF-8 (plain text)"));
        }
        if head.starts_with(b"\xef\xbb\xbf") {
            input.consume(3);
        }
        Ok(Self { input, buffer: Vec::new(), number: 0 })
    }

    /// The next line without its end; `None` at the end of the file.
    fn next(&mut self) -> Result<Option<&str>> {
        self.buffer.clear();
        self.number += 1;
        let number = self.number;
        let read = (&mut self.input).take(limits::SCAN_LINE as u64 + 1).read_until(b'\n', &mut self.buffer);
        if read.map_err(|e| Error::stream(&e).line(number))? == 0 {
            return Ok(None);
        }
        if self.buffer.len() > limits::SCAN_LINE {
            return Err(limits::exceeded("the line has", limits::SCAN_LINE, "characters").line(number));
        }
        if self.buffer.contains(&0) {
            return Err(Error::new(format!("this is binary data, not {WHAT}")).line(number).help("look whether the right file is named"));
        }
        if std::str::from_utf8(&self.buffer).is_err() {
            // Names in older encodings; numbers are the same in all of them.
            self.buffer.iter_mut().filter(|b| !b.is_ascii()).for_each(|b| *b = b'?');
        }
        Ok(Some(std::str::from_utf8(&self.buffer).unwrap_or_default().trim()))
    }
}

const WHAT: &str = "a measurement of a goniophotometer";

/// See [`super::is_scan`].
pub(super) fn looks_like_scan(path: &Path) -> bool {
    let mut head = Vec::new();
    let read = File::open(path).and_then(|f| f.take(4096).read_to_end(&mut head));
    let text = String::from_utf8_lossy(&head);
    let first = text.lines().find(|l| !l.trim().is_empty() && !l.starts_with('#')).unwrap_or_default();
    read.is_ok() && (Other::of(&head) == Some(text::GONIOPHOTOMETER) || quantity_of_columns(first).is_some())
}

/// The quantity that the first row of a CSV names, if it is one of five names.
fn quantity_of_columns(row: &str) -> Option<Quantity> {
    let names: Vec<&str> = row.split([',', ';', '\t']).map(str::trim).collect();
    let last = names.last()?.split(['[', '(', ' ']).next()?;
    Quantity::by_name(last).filter(|_| names.len() == 5 && names.iter().all(|n| n.parse::<f64>().is_err()))
}

pub(super) fn read(path: &Path, options: &Options, warnings: &mut Warnings) -> Result<Measured> {
    let mut lines = Lines::open(path)?;
    let mut header = Header::default();
    loop {
        let number = lines.number + 1;
        let Some(line) = lines.next()? else {
            return Err(Error::new("the file has no rows of values").help("rows are: theta phi value"));
        };
        if let Some(words) = line.strip_prefix('#') {
            header.line(words).map_err(|e| e.line(number))?;
        } else if let Some(quantity) = quantity_of_columns(line) {
            return table(lines, path, quantity, options).map(|scans| Measured { name: header.name, scans });
        } else if !line.is_empty() {
            let line = line.to_string();
            return one_direction(lines, line, path, header, options, warnings);
        }
    }
}

#[derive(Default)]
struct Header {
    name: String,
    quantity: Option<Quantity>,
    theta: Option<f64>,
    phi: Option<f64>,
    up: f64,
    three: bool,
}

impl Header {
    fn line(&mut self, line: &str) -> Result<()> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let degrees = |at: usize| -> Result<f64> {
            let word = words.get(at).copied().unwrap_or_default();
            let found = word.parse().ok().filter(|v: &f64| v.is_finite() && v.abs() <= 720.0);
            found.ok_or_else(|| Error::new(format!("'{}' is no angle in degrees", short(word))).field(format!("#{}", words[0])))
        };
        match words.first().copied() {
            Some("sample_name") => {
                let name = line.split_once('"').map_or("", |(_, rest)| rest.split('"').next().unwrap_or_default());
                self.name = name.chars().filter(|c| !c.is_control()).take(255).collect();
            }
            Some("format:") if words.get(1..3) == Some(&["theta", "phi"]) => {
                let name = words.get(3).copied().unwrap_or_default();
                self.quantity = Some(Quantity::by_name(name).ok_or_else(|| {
                    Error::new(format!("'{}' is no known quantity", short(name)))
                        .field("#format:")
                        .help("DSF, BSDF, BRDF and BTDF are known")
                })?);
            }
            Some("colorimetry:") => {
                self.three = match words.get(1).map(|w| w.to_ascii_uppercase()).as_deref() {
                    Some("CIE-XYZ") => true,
                    Some("CIE-Y") => false,
                    other => {
                        return Err(Error::new(format!("'{}' is not known", short(other.unwrap_or_default())))
                            .field("#colorimetry:")
                            .help("CIE-Y and CIE-XYZ are known"));
                    }
                }
            }
            Some("upphi") => self.up = degrees(1)?,
            Some("intheta") => self.theta = Some(degrees(1)?),
            Some("inphi") => self.phi = Some(degrees(1)?),
            Some("incident_angle") => (self.theta, self.phi) = (Some(degrees(1)?), Some(degrees(2)?)),
            _ => {}
        }
        Ok(())
    }
}

/// The rest of a file of one incident direction; `first` is the row that was read already.
fn one_direction(
    mut lines: Lines,
    first: String,
    path: &Path,
    header: Header,
    options: &Options,
    warnings: &mut Warnings,
) -> Result<Measured> {
    let number = lines.number;
    let missing = |what: &str| Error::new(format!("the header does not say {what}")).line(number);
    let quantity = header.quantity.ok_or_else(|| missing("what the values are").help("add a line '#format: theta phi BSDF' (or DSF)"))?;
    let (Some(theta), Some(phi)) = (header.theta, header.phi) else {
        return Err(missing("from where the light comes").help("add a line '#incident_angle THETA PHI', in degrees"));
    };
    if header.three {
        warnings.push(Error::new("X and Z of CIE-XYZ are not used, only Y").file(path));
    }
    let turn = |angle: f64| angle + 90.0 - header.up;
    let towards =
        |theta: f64, phi: f64| if options.reversed { direction(180.0 - theta, turn(360.0 - phi)) } else { direction(theta, turn(phi)) };
    let source = towards(theta, phi);
    let mut seen = Angles::default();
    let mut scan: Option<Scan> = None;
    let mut row = Some(first);
    let columns = if header.three { 5 } else { 3 };
    while let Some(line) = row {
        let number = lines.number;
        if !line.is_empty() {
            let at = |e: Error| e.line(number);
            let values = numbers(&line, columns).map_err(at)?;
            seen.see(values[0], values[1]);
            if values[0].abs() > 180.0 {
                return Err(Error::new(format!("θ = {}° is beyond 180°", values[0])).line(number));
            }
            let value = if header.three { values[3] } else { values[2] };
            add(&mut scan, source, towards(values[0], values[1]), value, quantity, options, path).map_err(at)?;
        }
        row = lines.next()?.map(str::to_string);
    }
    seen.check().map_err(|e| e.line(number))?;
    let scan = scan.ok_or_else(|| Error::new("no sample is left").help("the options leave out all its directions"))?;
    Ok(Measured { name: header.name, scans: vec![scan] })
}

/// The rows of a table of all directions.
fn table(mut lines: Lines, path: &Path, quantity: Quantity, options: &Options) -> Result<Vec<Scan>> {
    let first = lines.number;
    let mut scans: Vec<Scan> = Vec::new();
    let mut last = 0;
    let mut seen = Angles::default();
    let mut cells = 0usize;
    loop {
        let number = lines.number + 1;
        let Some(line) = lines.next()? else { break };
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let at = |e: Error| e.line(number);
        let v = numbers(line, 5).map_err(at)?;
        seen.see(v[0].max(v[2]), v[1].max(v[3]));
        if let Some(wrong) = [v[0], v[2]].into_iter().find(|t| t.abs() > 180.0) {
            return Err(Error::new(format!("θ = {wrong}° is beyond 180°")).line(number));
        }
        let towards = |theta: f64, phi: f64| if options.reversed { direction(180.0 - theta, 360.0 - phi) } else { direction(theta, phi) };
        let (source, outgoing) = (towards(v[0], v[1]), towards(v[2], v[3]));
        let travel = DVec3::new(-source.x, -source.y, source.z.abs());
        if scans.get(last).is_none_or(|s| angle(s.incident, travel) > SAME_INCIDENCE) {
            last = scans.iter().position(|s| angle(s.incident, travel) <= SAME_INCIDENCE).unwrap_or(scans.len());
        }
        if scans.len() > limits::GONIOPHOTOMETER_FILES || cells > limits::GONIOPHOTOMETER_CELLS {
            return Err(limits::exceeded("the table has", limits::GONIOPHOTOMETER_FILES, "incident directions").line(number));
        }
        let mut scan = (last < scans.len()).then(|| scans.swap_remove(last));
        let before = scan.as_ref().map_or(0, |s: &Scan| s.grid.len());
        add(&mut scan, source, outgoing, v[4], quantity, options, path).map_err(at)?;
        if let Some(scan) = scan {
            cells += scan.grid.len() - before;
            scans.push(scan);
            let end = scans.len() - 1;
            if last < end {
                scans.swap(last, end);
            }
        }
    }
    seen.check().map_err(|e| e.line(first))?;
    if scans.is_empty() {
        return Err(Error::new("the table has no rows that are used"));
    }
    Ok(scans)
}

/// Adds a sample, if the options keep it.
fn add(
    scan: &mut Option<Scan>,
    source: DVec3,
    outgoing: DVec3,
    value: f64,
    quantity: Quantity,
    options: &Options,
    path: &Path,
) -> Result<()> {
    if outgoing.z.abs() < options.grazing.to_radians().sin() {
        return Ok(());
    }
    let component = match (source.z < 0.0, outgoing.z > 0.0) {
        (true, true) => Component::TransmissionFront,
        (false, false) => Component::TransmissionBack,
        (true, false) => Component::ReflectionFront,
        (false, true) => Component::ReflectionBack,
    };
    if options.transmitted.is_some_and(|wanted| wanted != component.is_transmission()) {
        return Ok(());
    }
    let upper = |d: DVec3| DVec3::new(d.x, d.y, d.z.abs());
    let scan = scan.get_or_insert_with(|| Scan::new(upper(DVec3::new(-source.x, -source.y, source.z)), component, path));
    if scan.component != component {
        return Err(Error::new("the outgoing directions lie on both sides of the sample")
            .help("choose with --only transmission or --only reflection which samples to use"));
    }
    let dsf = if quantity == Quantity::Dsf { value } else { value * outgoing.z.abs() };
    scan.add(upper(outgoing), dsf);
    Ok(())
}

/// The numbers of a row.
fn numbers(line: &str, count: usize) -> Result<Vec<f64>> {
    let parse = |words: &mut dyn Iterator<Item = &str>| words.map(|w| w.parse().ok()).collect::<Option<Vec<f64>>>();
    let found = match parse(&mut line.split_ascii_whitespace()) {
        Some(found) if found.len() == count => Some(found),
        _ => parse(&mut text::words(line)?.iter().map(AsRef::as_ref)).filter(|v| v.len() == count),
    };
    let found = found.ok_or_else(|| {
        let rows = if count == 5 { "five numbers" } else { "three numbers, theta phi value" };
        Error::new(format!("'{}' is not a row of {rows}", short(line)))
    })?;
    if let Some(wrong) = found.iter().find(|v| !v.is_finite() || v.abs() > 1e12) {
        return Err(Error::new(format!("the value {wrong} is no measured one")).help("leave out rows without a measurement"));
    }
    Ok(found)
}

fn short(text: &str) -> String {
    text.chars().take(60).collect::<String>().escape_debug().to_string()
}

/// Away from the sample at polar angle and azimuth, degrees.
fn direction(theta: f64, phi: f64) -> DVec3 {
    let (sin, cos) = theta.to_radians().sin_cos();
    let (y, x) = phi.to_radians().sin_cos();
    DVec3::new(sin * x, sin * y, cos)
}

/// The extent of angles, to tell radians.
#[derive(Default)]
struct Angles {
    count: usize,
    theta: f64,
    phi: f64,
}

impl Angles {
    fn see(&mut self, theta: f64, phi: f64) {
        self.count += 1;
        (self.theta, self.phi) = (self.theta.max(theta.abs()), self.phi.max(phi.abs()));
    }

    fn check(&self) -> Result<()> {
        // A scan of more than a few samples in degrees does not end within a few of them in both angles.
        if self.count >= 20 && self.theta <= 3.15 && self.phi <= 6.29 && self.theta > 0.3 {
            return Err(Error::new(format!("no θ is above {:.2}, no φ above {:.2}: these angles look like radians", self.theta, self.phi))
                .help("angles are in degrees"));
        }
        Ok(())
    }
}
