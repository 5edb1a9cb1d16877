//! Walks through files, commands and the files they name, and hands every object with its placement
//! to a [`Sink`].

use super::command::{self, Pipeline, Source};
use super::generators::Generator;
use super::syntax::{self, Object, Statement};
use super::xform::{Placement, Xform};
use crate::error::{Error, Result, Warnings};
use crate::{files, limits};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Receives what a scene consists of, in order.
pub(super) trait Sink {
    /// A surface, material, texture or mixture.
    ///
    /// # Errors
    /// If it makes no sense here.
    fn object(&mut self, object: &Object, placement: &Placement, file: &Rc<Path>, warnings: &mut Warnings) -> Result<()>;

    /// An alias.
    ///
    /// # Errors
    /// If it makes no sense here.
    fn alias(&mut self, modifier: &str, name: &str, target: &str, file: &Rc<Path>, line: usize) -> Result<()>;

    /// A `#@rfluxmtx` comment.
    ///
    /// # Errors
    /// If it makes no sense here.
    fn parameters(&mut self, text: &str, file: &Rc<Path>, line: usize) -> Result<()>;

    /// Triangles, or whatever it makes of surfaces, so far.
    fn size(&self) -> usize;

    /// A sky of the scene's own, which is left out.
    fn sky(&mut self, _file: &Path, _line: usize, _warnings: &mut Warnings) {}
}

/// Files read so far, and the chain of those being read.
pub(super) struct Reader<'a> {
    base: &'a Path,
    /// What files hold and which file they are, by the path that names them.
    parsed: HashMap<PathBuf, (Rc<Vec<Statement>>, Rc<Path>)>,
    chain: Vec<Rc<Path>>,
    statements: usize,
    copies: usize,
    /// How often the file that is being read appears, by the arrays around it.
    within: usize,
    /// What generators and copies made of surfaces: no file's length bounds it.
    made: usize,
}

impl<'a> Reader<'a> {
    /// A reader that resolves paths against the folder `base`.
    pub(super) fn new(base: &'a Path) -> Self {
        Self { base, parsed: HashMap::new(), chain: Vec::new(), statements: 0, copies: 0, within: 1, made: 0 }
    }

    /// Reads a file and all it includes.
    ///
    /// # Errors
    /// Anything wrong in the files, with file and line, or that the sink refuses.
    pub(super) fn read(&mut self, file: &Path, sink: &mut dyn Sink, warnings: &mut Warnings) -> Result<()> {
        let path = self.base.join(file);
        self.file(&path, &Placement::default(), sink, warnings)
    }

    fn file(&mut self, path: &Path, placement: &Placement, sink: &mut dyn Sink, warnings: &mut Warnings) -> Result<()> {
        let (statements, identity) = match self.parsed.get(path) {
            Some((statements, identity)) => (Rc::clone(statements), Rc::clone(identity)),
            None => {
                let identity: Rc<Path> = path.canonicalize().map_err(|e| Error::io(path, &e))?.into();
                if identity.is_dir() {
                    return Err(Error::new("this is a folder, not a scene file").file(path).help("name a .rad file in it"));
                }
                let known = self.parsed.values().find(|(_, other)| *other == identity).cloned();
                let read = || Ok((Rc::new(syntax::parse(&files::read(path)?, path)?), identity));
                let file = known.map_or_else(read, Ok)?;
                self.parsed.insert(path.to_path_buf(), file.clone());
                file
            }
        };
        if let Some(first) = self.chain.iter().position(|p| *p == identity) {
            let via: Vec<String> =
                self.chain[first..].iter().map(|p| p.file_name().unwrap_or_default().to_string_lossy().into_owned()).collect();
            return Err(Error::new(format!("{} includes itself (by way of {})", path.display(), via.join(" → ")))
                .help("remove the `!xform` that closes the circle"));
        }
        if self.chain.len() >= limits::NESTED_FILES {
            return Err(
                limits::exceeded("files include each other", limits::NESTED_FILES, "deep").help("put the files together into fewer")
            );
        }
        self.chain.push(identity);
        let file: Rc<Path> = path.into();
        for statement in statements.iter() {
            self.count(&file, statement)?;
            match statement {
                Statement::Object(object) if self.within > 1 => self.made(object, placement, &file, sink, warnings)?,
                Statement::Object(object) => sink.object(object, placement, &file, warnings)?,
                Statement::Alias { modifier, name, target, line } => sink.alias(modifier, name, target, &file, *line)?,
                Statement::Parameters { text, line } => sink.parameters(text, &file, *line)?,
                Statement::Command { text, line } => {
                    let at = |e: Error| e.file(&*file).line(*line);
                    let mut pipeline = command::parse(text).map_err(at)?;
                    if let Source::Generator(Generator { objects }) | Source::Sky(objects) = &mut pipeline.source {
                        objects.iter_mut().for_each(|object| object.line = *line);
                    }
                    let around = self.within;
                    self.within = self.count_copies(&pipeline).map_err(at)?;
                    let filters: Vec<Vec<Placement>> = pipeline.filters.iter().rev().map(Xform::copies).collect();
                    self.filtered(&pipeline.source, &filters, placement, &file, sink, warnings).map_err(at)?;
                    self.within = around;
                }
            }
        }
        self.chain.pop();
        Ok(())
    }

    /// The source of a pipeline, once for each combination of its filters' copies (outermost first).
    fn filtered(
        &mut self,
        source: &Source,
        filters: &[Vec<Placement>],
        placement: &Placement,
        file: &Rc<Path>,
        sink: &mut dyn Sink,
        warnings: &mut Warnings,
    ) -> Result<()> {
        if let Some((copies, inner)) = filters.split_first() {
            for copy in copies {
                self.filtered(source, inner, &placement.of(copy), file, sink, warnings)?;
            }
            return Ok(());
        }
        match source {
            Source::Generator(generator) => {
                for object in &generator.objects {
                    self.count_one(file, object.line)?;
                    self.made(object, placement, file, sink, warnings)?;
                }
            }
            Source::Sky(objects) => {
                sink.sky(file, objects.first().map_or(1, |o| o.line), warnings);
                for object in objects {
                    sink.object(object, placement, file, warnings)?;
                }
            }
            Source::Files(xform) => {
                let paths: Vec<PathBuf> = xform.files.iter().map(|f| self.resolve(f, file)).collect::<Result<_>>()?;
                for copy in xform.copies() {
                    for path in &paths {
                        self.file(path, &placement.of(&copy), sink, warnings)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// An object of a generator or a copy, which a short line may make many of.
    fn made(
        &mut self,
        object: &Object,
        placement: &Placement,
        file: &Rc<Path>,
        sink: &mut dyn Sink,
        warnings: &mut Warnings,
    ) -> Result<()> {
        let before = sink.size();
        sink.object(object, placement, file, warnings)?;
        self.made += (sink.size() - before).max(1);
        if self.made > limits::MADE_TRIANGLES {
            let error = limits::exceeded("copies and generators make", limits::MADE_TRIANGLES, "triangles");
            return Err(object.at(error.help("make fewer of them, or write what they make into a file: that may have more"), file));
        }
        Ok(())
    }

    /// A file named in a command. As in Radiance: for a command of a file that was itself placed by
    /// `xform`, beside that file (where xform goes before it runs the commands of its input); for
    /// one of the scene's own files, in the working folder. Where there is none, in the other.
    fn resolve(&self, name: &str, including: &Path) -> Result<PathBuf> {
        if name.starts_with('!') {
            return Err(Error::new(format!("'{name}' is a command in the place of a file"))
                .help("write the command first and pipe it: `!genbox … | xform …`"));
        }
        let working = self.base.join(name);
        let beside = including.parent().unwrap_or(Path::new("")).join(name);
        let nested = self.chain.len() > 1;
        let [first, second] = if nested { [beside, working] } else { [working, beside] };
        if first.exists() {
            return Ok(first);
        }
        if second.exists() {
            return Ok(second);
        }
        Err(Error::new(format!("the file '{name}' exists neither as {} nor as {}", first.display(), second.display()))
            .help("correct the path; it is relative to the working folder or to the folder of the file that names it"))
    }

    /// Counts the copies that a line makes before they are made, also those that it makes in the other copies of its
    /// file. Returns how often a file that it names appears.
    fn count_copies(&mut self, pipeline: &Pipeline) -> Result<usize> {
        let (each, files) = match &pipeline.source {
            Source::Files(xform) => (xform.count(), xform.files.len()),
            Source::Generator(_) | Source::Sky(_) => (1, 1),
        };
        let each = pipeline.filters.iter().fold(each, |n, filter| n.saturating_mul(filter.count()));
        let of_all = each.saturating_mul(self.within);
        self.copies = self.copies.saturating_add(each.saturating_mul(files));
        if self.copies.max(of_all.saturating_mul(files)) > limits::COPIES {
            return Err(limits::exceeded("the scene consists of", limits::COPIES, "copies of files and boxes")
                .help("use smaller arrays (-a), and fewer of them within each other"));
        }
        Ok(of_all)
    }

    fn count(&mut self, file: &Path, statement: &Statement) -> Result<()> {
        let (Statement::Object(Object { line, .. })
        | Statement::Alias { line, .. }
        | Statement::Command { line, .. }
        | Statement::Parameters { line, .. }) = statement;
        self.count_one(file, *line)
    }

    fn count_one(&mut self, file: &Path, line: usize) -> Result<()> {
        self.statements += 1;
        if self.statements > limits::STATEMENTS {
            return Err(limits::exceeded("the scene has", limits::STATEMENTS, "objects")
                .file(file)
                .line(line)
                .help("use smaller arrays (-a) and fewer repeated files"));
        }
        Ok(())
    }
}
