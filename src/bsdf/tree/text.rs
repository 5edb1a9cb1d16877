//! The text of a tensor tree in a BSDF file.
//!
//! A group `{…}` is either 2^rank groups, in which bit i of the position selects the upper half of
//! dimension i, or a grid of (2^k)^rank numbers, in which the last dimension runs fastest.

use super::{Node, TensorTree};
use crate::error::{Error, Result};
use crate::limits::{NUMBER_CHARACTERS, TREE_DEPTH, TREE_VALUES};

impl TensorTree {
    /// Reads the nested text.
    ///
    /// # Errors
    /// What is wrong and in which line of the text.
    pub fn parse(text: &str, rank: usize) -> Result<Self> {
        let mut parser = TreeParser::new(rank);
        parser.feed(text.as_bytes(), 1)?;
        parser.finish()
    }

    /// The nested text of the tree, as in a file.
    ///
    /// # Errors
    /// What `out` returns.
    pub(crate) fn write_text(&self, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        self.write_node(self.nodes[0], 0, out)
    }

    fn write_node(&self, node: Node, depth: usize, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        let indent = "  ".repeat(depth);
        match node {
            Node::Branch(first) => {
                writeln!(out, "{indent}{{")?;
                for child in 0..1usize << self.rank {
                    self.write_node(self.nodes[first as usize + child], depth + 1, out)?;
                }
                writeln!(out, "{indent}}}")
            }
            Node::Leaf { log2, first } => {
                write!(out, "{indent}{{")?;
                let count = 1usize << (usize::from(log2) * self.rank);
                for (i, v) in self.values[first as usize..first as usize + count].iter().enumerate() {
                    // Short lines: Radiance's reader has fixed buffers.
                    write!(out, "{}{v:e}", if i % 16 == 15 { '\n' } else { ' ' })?;
                }
                writeln!(out, " }}")
            }
        }
    }
}

/// Reads a tree's text piece by piece.
pub(in crate::bsdf) struct TreeParser {
    tree: TensorTree,
    word: String,
    /// Open branches: first child and how many children have come.
    branches: Vec<(u32, usize)>,
    state: State,
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    /// Nothing read.
    Start,
    /// A brace was opened for this node, its content is not known.
    Opened(u32),
    /// Numbers of this leaf are read; its first value.
    InLeaf(u32, u32),
    /// Between the children of the innermost branch.
    InBranch,
    /// The outermost brace is closed.
    Done,
}

impl TreeParser {
    pub fn new(rank: usize) -> Self {
        assert!(rank == 3 || rank == 4);
        let tree = TensorTree { rank, nodes: Vec::new(), values: Vec::new() };
        Self { tree, word: String::new(), branches: Vec::new(), state: State::Start }
    }

    pub(crate) fn feed(&mut self, text: &[u8], mut line: usize) -> Result<()> {
        for &byte in text {
            match byte {
                b'{' | b'}' => {
                    self.end_word().map_err(|e| e.line(line))?;
                    if byte == b'{' { self.open() } else { self.close() }.map_err(|e| e.line(line))?;
                }
                b',' | b';' => self.end_word().map_err(|e| e.line(line))?,
                b if b.is_ascii_whitespace() => {
                    self.end_word().map_err(|e| e.line(line))?;
                    line += usize::from(b == b'\n');
                }
                _ if self.word.len() >= NUMBER_CHARACTERS => return Err(not_a_number(&self.word).line(line)),
                b => self.word.push(b as char),
            }
        }
        Ok(())
    }

    pub fn finish(mut self) -> Result<TensorTree> {
        self.end_word()?;
        match self.state {
            State::Done => Ok(self.tree),
            State::Start => Err(Error::new("the tensor tree is empty")),
            state => {
                let open = self.branches.len() + usize::from(state != State::InBranch);
                Err(Error::new(format!("the tensor tree ends inside {open} open brace(s)"))
                    .help("closing braces are missing, or the file is cut off: generate it again"))
            }
        }
    }

    fn children(&self) -> usize {
        1 << self.tree.rank
    }

    fn open(&mut self) -> Result<()> {
        let slot = match self.state {
            State::Start => {
                self.tree.nodes.push(Node::Leaf { log2: 0, first: 0 });
                0
            }
            State::Opened(slot) => {
                if self.branches.len() >= TREE_DEPTH {
                    return Err(Error::new(format!("the tensor tree is nested deeper than {TREE_DEPTH} levels"))
                        .help("trees of 2^7 by 2^7 directions have 7; closing braces may be missing"));
                }
                let first = self.tree.nodes.len() as u32;
                self.tree.nodes.resize(self.tree.nodes.len() + self.children(), Node::Leaf { log2: 0, first: 0 });
                self.tree.nodes[slot as usize] = Node::Branch(first);
                self.branches.push((first, 1));
                first
            }
            State::InBranch => {
                let wanted = self.children();
                let (first, count) = self.branches.last_mut().expect("a branch is open");
                if *count == wanted {
                    return Err(Error::new(format!("more than {wanted} groups in a brace of a rank {} tensor tree", self.tree.rank))
                        .help("is IncidentDataStructure (TensorTree3 or TensorTree4) right?"));
                }
                *count += 1;
                *first + *count as u32 - 1
            }
            State::InLeaf(..) => {
                return Err(Error::new("an opening brace among numbers of a tensor tree")
                    .help("a group holds either numbers or groups; a closing brace may be missing before"));
            }
            State::Done => {
                return Err(
                    Error::new("more text after the tensor tree").help("a block holds one group in braces: is there a brace too many?")
                );
            }
        };
        self.state = State::Opened(slot);
        Ok(())
    }

    fn close(&mut self) -> Result<()> {
        match self.state {
            State::Opened(_) => {
                return Err(
                    Error::new("an empty brace in the tensor tree").help("a group holds numbers or groups; generate the file again")
                );
            }
            State::InLeaf(slot, first) => {
                let count = self.tree.values.len() - first as usize;
                let log2 = (0..=TREE_DEPTH).find(|k| 1usize.checked_shl((k * self.tree.rank) as u32) == Some(count)).ok_or_else(|| {
                    Error::new(format!("a brace of the tensor tree has {count} values; it must be a power of {}", self.children()))
                        .help("values are numbers with decimal points, separated by blanks or commas")
                })?;
                self.tree.nodes[slot as usize] = Node::Leaf { log2: log2 as u8, first };
            }
            State::InBranch => {
                let (_, count) = self.branches.pop().expect("a branch is open");
                if count != self.children() {
                    return Err(Error::new(format!(
                        "{count} groups in a brace of a rank {} tensor tree; {} are needed",
                        self.tree.rank,
                        self.children()
                    ))
                    .help("is IncidentDataStructure (TensorTree3 or TensorTree4) right?"));
                }
            }
            State::Start | State::Done => {
                return Err(Error::new("a closing brace without its opening one")
                    .help("a tensor tree is one group in braces; there is one brace too many here or a missing one before"));
            }
        }
        self.state = if self.branches.is_empty() { State::Done } else { State::InBranch };
        Ok(())
    }

    fn end_word(&mut self) -> Result<()> {
        if self.word.is_empty() {
            return Ok(());
        }
        let value: f32 = self.word.parse().map_err(|_| not_a_number(&self.word))?;
        if !value.is_finite() {
            return Err(
                Error::new(format!("a value of the tensor tree is '{}'", self.word)).help("a scattering value must be a finite number")
            );
        }
        self.word.clear();
        match self.state {
            State::Opened(slot) => self.state = State::InLeaf(slot, self.tree.values.len() as u32),
            State::InLeaf(..) => {}
            _ => {
                return Err(Error::new("a number outside the innermost braces of the tensor tree")
                    .help("a group holds either numbers or groups: a brace is missing or too many"));
            }
        }
        if self.tree.values.len() >= TREE_VALUES {
            return Err(Error::new(format!("the tensor tree has more than {TREE_VALUES} values")));
        }
        self.tree.values.push(value);
        Ok(())
    }
}

fn not_a_number(word: &str) -> Error {
    Error::new(format!("'{}' is not a number", word.escape_debug())).help("a tensor tree consists of braces and numbers")
}
