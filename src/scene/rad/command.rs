//! `!command` lines: cut into words as a shell would, then interpreted here. Nothing is executed.

use super::generators::Generator;
use super::sweeps;
use super::syntax::Object;
use super::types::ObjectType;
use super::xform::Xform;
use crate::error::{Error, Result};
use crate::limits;

/// A pipeline: a source, and the `xform`s its output passes through, innermost first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pipeline {
    /// Where the objects come from.
    pub source: Source,
    /// `| xform …` stages.
    pub filters: Vec<Xform>,
}

/// Head of a pipeline.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Source {
    /// `xform … files`.
    Files(Xform),
    /// `genbox`, `genblinds` or another generator of surfaces.
    Generator(Generator),
    /// `gensky` or `gendaylit`: what its output defines, without its light.
    Sky(Vec<Object>),
}

/// Understands a command line.
///
/// # Errors
/// Any command that is not known here, any use of the shell beyond words, quotes and
/// pipes, and more pipes than [`limits::PIPED_COMMANDS`].
pub(super) fn parse(text: &str) -> Result<Pipeline> {
    let stages = split(text)?;
    if stages.len() > limits::PIPED_COMMANDS {
        return Err(limits::exceeded("this line pipes", limits::PIPED_COMMANDS, "commands into each other")
            .help("put the transformations into one xform, or an intermediate result into a file of its own"));
    }
    let mut stages = stages.into_iter();
    let head = stages.next().unwrap_or_default();
    let source = match head.first().map(String::as_str) {
        Some(word @ ("xform" | "cat")) => {
            let xform = Xform::parse(&head[1..])?;
            if xform.files.is_empty() {
                return Err(Error::new(format!("this {word} has no input file")).help("name the file to place after the transformations"));
            }
            Source::Files(xform)
        }
        Some("genbox") => Source::Generator(Generator::genbox(&head[1..])?),
        Some("genblinds") => Source::Generator(Generator::genblinds(&head[1..])?),
        Some("genprism") => Source::Generator(sweeps::genprism(&head[1..])?),
        Some("gensurf") => Source::Generator(sweeps::gensurf(&head[1..])?),
        Some("genrev") => Source::Generator(sweeps::genrev(&head[1..])?),
        Some("genworm") => Source::Generator(sweeps::genworm(&head[1..])?),
        Some("gensky" | "gendaylit") => return Ok(Pipeline { source: Source::Sky(sky()), filters: Vec::new() }),
        other => return Err(refused(other.unwrap_or_default())),
    };
    let mut filters = Vec::new();
    for stage in stages {
        match stage.first().map(String::as_str) {
            Some("xform") => {
                let xform = Xform::parse(&stage[1..])?;
                if let Some(file) = xform.files.first() {
                    return Err(Error::new(format!("this xform reads '{file}' and would throw its piped input away"))
                        .help("leave the file out, or the commands before the pipe"));
                }
                filters.push(xform);
            }
            other => return Err(refused(other.unwrap_or_default())),
        }
    }
    Ok(Pipeline { source, filters })
}

/// The names that the output of `gensky` and `gendaylit` defines.
fn sky() -> Vec<Object> {
    let modifier = |kind: &str, name: &str, strings: &[&str], reals: &[f64]| Object {
        modifier: super::modifiers::VOID.to_string(),
        kind: ObjectType::from_word(kind).unwrap_or(ObjectType::Texture("brightfunc")),
        name: name.to_string(),
        strings: strings.iter().map(ToString::to_string).collect(),
        reals: reals.to_vec(),
        line: 0,
    };
    vec![modifier("light", "solar", &[], &[0.0; 3]), modifier("brightfunc", "skyfunc", &["skybright", "skybright.cal"], &[])]
}

fn refused(command: &str) -> Error {
    if command.is_empty() {
        return Error::new("an empty command").help("write `!xform …`, `!genbox …` or `!genblinds …`");
    }
    Error::new(format!("the command '{}' is not run: nothing from a scene file is ever executed", super::syntax::shortened(command)))
        .help("run the command once yourself, save its output as a .rad file and name that file here, for instance `!xform that.rad`; only xform, cat, genbox, genblinds, genprism, gensurf, genrev and genworm are understood")
}

/// Words of each pipeline stage.
fn split(text: &str) -> Result<Vec<Vec<String>>> {
    let mut stages = vec![Vec::new()];
    let mut word: Option<String> = None;
    let mut characters = text.chars();
    while let Some(c) = characters.next() {
        match c {
            '\'' | '"' => {
                let word = word.get_or_insert_default();
                loop {
                    match characters.next() {
                        None => return Err(Error::new(format!("a quote {c} is not closed"))),
                        Some(q) if q == c => break,
                        Some('\\') if c == '"' => word.extend(characters.next()),
                        Some('$' | '`') if c == '"' => return Err(shell_feature('$')),
                        Some(other) => word.push(other),
                    }
                }
            }
            '\\' => word.get_or_insert_default().extend(characters.next()),
            '|' => {
                stages.last_mut().expect("never empty").extend(word.take());
                stages.push(Vec::new());
            }
            ';' | '&' | '<' | '>' | '$' | '`' | '*' | '?' | '(' | ')' | '[' | ']' | '{' | '}' | '~' => return Err(shell_feature(c)),
            '#' if word.is_none() => break,
            c if c.is_whitespace() => stages.last_mut().expect("never empty").extend(word.take()),
            c => word.get_or_insert_default().push(c),
        }
    }
    stages.last_mut().expect("never empty").extend(word);
    Ok(stages)
}

fn shell_feature(c: char) -> Error {
    Error::new(format!("'{c}' in a command needs a shell, and nothing from a scene file is ever executed"))
        .help("write plain words, quotes and `| xform …` only; one command per line")
}
