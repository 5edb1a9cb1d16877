//! Radiance's expressions, as function files, generators and the arguments of materials have them.
//!
//! `+ - * / ^`, where the minus sign of a number binds closest (−2^2 is 4) and `^` from the right; numbers;
//! variables; functions. What is not defined has no value: an expression of the point or the ray that is
//! met is not constant, and the caller says so.

use crate::error::{Error, Result};
use crate::limits::{EXPRESSION_PARTS, EXPRESSION_STEPS};
use crate::units::BRIGHTNESS_WEIGHTS;
use std::cell::Cell;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Parts of formulas inside each other, through the functions they call.
const DEEPEST: usize = 1500;

#[derive(Debug, Clone, PartialEq)]
enum Node {
    Number(f64),
    Variable(String),
    Call(String, Vec<Node>),
    Operation(char, Box<[Node; 2]>),
    Negative(Box<Node>),
}

/// What names mean: Radiance's library, and what the caller adds.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    functions: HashMap<String, (Vec<String>, Node)>,
}

impl Definitions {
    /// Defines a function by its formula.
    ///
    /// # Errors
    /// If it is no expression.
    pub(super) fn function(&mut self, name: &str, parameters: &[&str], formula: &str) -> Result<()> {
        let node = Parser::whole(formula)?;
        self.functions.insert(name.to_string(), (parameters.iter().map(ToString::to_string).collect(), node));
        Ok(())
    }

    /// Defines variables and functions: `name = formula; name(a, b) = formula`, `:` for `=` where they are
    /// constant.
    ///
    /// # Errors
    /// The statement that is neither.
    pub(super) fn add(&mut self, text: &str) -> Result<()> {
        for statement in text.split(';').map(str::trim).filter(|s| !s.is_empty()) {
            let wrong = || {
                Error::new(format!("'{}' is no definition", super::syntax::shortened(statement)))
                    .help("write `name = formula` or `name(x) = formula`")
            };
            let (head, formula) = statement.split_once(['=', ':']).ok_or_else(wrong)?;
            let (name, parameters) = match head.trim().split_once('(') {
                None => (head.trim(), Vec::new()),
                Some((name, rest)) => {
                    (name.trim(), rest.trim_end().strip_suffix(')').ok_or_else(wrong)?.split(',').map(str::trim).collect())
                }
            };
            if std::iter::once(&name).chain(&parameters).any(|n| !is_name(n)) {
                return Err(wrong());
            }
            self.function(name, &parameters, formula)?;
        }
        Ok(())
    }

    /// The value of an expression, where `given` knows variables (no arguments) and functions of numbers
    /// beside those defined here. Nothing if it depends on what is not known.
    ///
    /// # Errors
    /// What is no expression, or does not end.
    pub(super) fn value(&self, expression: &str, given: &dyn Fn(&str, &[f64]) -> Option<f64>) -> Result<Option<f64>> {
        let node = Parser::whole(expression)?;
        let run = Run { definitions: self, given, steps: Cell::new(0), endless: Cell::new(false) };
        run.finish(run.evaluate(&node, &[], 0))
    }

    /// The value of a function that is defined here.
    ///
    /// # Errors
    /// As [`value`](Self::value).
    pub(super) fn call(&self, name: &str, arguments: &[f64]) -> Result<Option<f64>> {
        let run = Run { definitions: self, given: &|_, _| None, steps: Cell::new(0), endless: Cell::new(false) };
        run.finish(run.function(name, arguments, 0))
    }
}

fn is_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && word.chars().all(|c| c.is_ascii_alphanumeric() || "_.`".contains(c))
}

struct Run<'a> {
    definitions: &'a Definitions,
    given: &'a dyn Fn(&str, &[f64]) -> Option<f64>,
    steps: Cell<usize>,
    endless: Cell<bool>,
}

impl Run<'_> {
    fn finish(&self, value: Option<f64>) -> Result<Option<f64>> {
        if self.endless.get() {
            return Err(Error::new("its functions call each other without end").help("correct their definitions"));
        }
        Ok(value)
    }

    fn evaluate(&self, node: &Node, locals: &[(&str, f64)], depth: usize) -> Option<f64> {
        self.steps.set(self.steps.get() + 1);
        if self.steps.get() > EXPRESSION_STEPS || depth > DEEPEST {
            self.endless.set(true);
            return None;
        }
        let value = |n: &Node| self.evaluate(n, locals, depth + 1);
        match node {
            Node::Number(v) => Some(*v),
            Node::Negative(n) => value(n).map(|v| -v),
            Node::Operation(sign, sides) => {
                let (a, b) = (value(&sides[0])?, value(&sides[1])?);
                Some(match sign {
                    '+' => a + b,
                    '-' => a - b,
                    '*' => a * b,
                    '/' => a / b,
                    _ => a.powf(b),
                })
            }
            Node::Variable(name) => {
                let local = locals.iter().find(|(n, _)| n == name).map(|(_, v)| *v);
                local.or_else(|| self.function(name, &[], depth))
            }
            // Only one branch has to end.
            Node::Call(name, parts) if name == "if" && parts.len() == 3 => {
                if value(&parts[0])? > 0.0 {
                    value(&parts[1])
                } else {
                    value(&parts[2])
                }
            }
            Node::Call(name, parts) if name == "select" && parts.len() > 1 => {
                let which = (value(&parts[0])? + 0.5).floor();
                if which == 0.0 {
                    return Some((parts.len() - 1) as f64);
                }
                (which >= 1.0 && which < parts.len() as f64).then(|| value(&parts[which as usize])).flatten()
            }
            Node::Call(name, parts) => {
                let values: Vec<f64> = parts.iter().map(value).collect::<Option<_>>()?;
                self.function(name, &values, depth)
            }
        }
    }

    fn function(&self, name: &str, arguments: &[f64], depth: usize) -> Option<f64> {
        if let Some((parameters, node)) = self.definitions.functions.get(name) {
            if parameters.len() > arguments.len() {
                return None;
            }
            let locals: Vec<(&str, f64)> = parameters.iter().map(String::as_str).zip(arguments.iter().copied()).collect();
            return self.evaluate(node, &locals, depth + 1);
        }
        (self.given)(name, arguments).or_else(|| library(name, arguments))
    }
}

/// Constants and functions that every function file knows.
fn library(name: &str, arguments: &[f64]) -> Option<f64> {
    let bound = |low: f64, x: f64, high: f64| {
        if low > x {
            low
        } else if x > high {
            high
        } else {
            x
        }
    };
    let truth = |yes: bool| if yes { 1.0 } else { -1.0 };
    let grey = |rgb: [f64; 3]| rgb.iter().zip(BRIGHTNESS_WEIGHTS).map(|(c, w)| c * w).sum::<f64>();
    let value = match (name, arguments) {
        ("PI", []) => PI,
        ("DEGREE", []) => PI / 180.0,
        ("FTINY", []) => 1e-7,
        ("sqrt" | "Sqrt", [x]) => bound(0.0, *x, f64::INFINITY).sqrt(),
        ("sin", [x]) => x.sin(),
        ("cos", [x]) => x.cos(),
        ("tan", [x]) => x.tan(),
        ("asin" | "Asin", [x]) => bound(-1.0, *x, 1.0).asin(),
        ("acos" | "Acos", [x]) => bound(-1.0, *x, 1.0).acos(),
        ("atan", [x]) => x.atan(),
        ("atan2" | "Atan2", [y, x]) => y.atan2(*x),
        ("exp" | "Exp", [x]) => x.exp(),
        ("log", [x]) => x.ln(),
        ("log10", [x]) => x.log10(),
        ("floor", [x]) => x.floor(),
        ("ceil", [x]) => x.ceil(),
        ("min", [first, rest @ ..]) => rest.iter().fold(*first, |a, b| a.min(*b)),
        ("max", [first, rest @ ..]) => rest.iter().fold(*first, |a, b| a.max(*b)),
        ("abs", [x]) => x.abs(),
        ("sq", [x]) => x * x,
        ("sgn", [x]) if *x == 0.0 => 0.0,
        ("sgn", [x]) => x.signum(),
        ("frac", [x]) => x - x.floor(),
        ("mod", [n, d]) => n - (n / d).floor() * d,
        ("tri", [n, d]) => {
            let m = n - d;
            (d - (m - (m / (2.0 * d)).floor() * 2.0 * d)).abs()
        }
        ("and", [a, b]) => {
            if *a > 0.0 {
                *b
            } else {
                *a
            }
        }
        ("or", [a, b]) => {
            if *a > 0.0 {
                *a
            } else {
                *b
            }
        }
        ("not", [a]) => truth(*a <= 0.0),
        ("linterp", [t, a, b]) => (1.0 - t) * a + t * b,
        ("bound", [low, x, high]) => bound(*low, *x, *high),
        ("noop", [x]) => *x,
        ("clip", [x]) => bound(0.0, *x, 1.0),
        ("noneg", [x]) => x.max(0.0),
        ("red", [c, _, _]) | ("green", [_, c, _]) | ("blue", [_, _, c]) => c.max(0.0),
        ("clip_r", [c, _, _]) | ("clip_g", [_, c, _]) | ("clip_b", [_, _, c]) => bound(0.0, *c, 1.0),
        ("grey", [r, g, b]) => grey([*r, *g, *b]).max(0.0),
        ("clipgrey", [r, g, b]) => bound(0.0, grey([*r, *g, *b]), 1.0),
        ("hermite", [p0, p1, r0, r1, t]) => {
            p0 * ((2.0 * t - 3.0) * t * t + 1.0)
                + p1 * (3.0 - 2.0 * t) * t * t
                + r0 * (((t - 2.0) * t + 1.0) * t)
                + r1 * ((t - 1.0) * t * t)
        }
        ("bezier", [a, b, c, d, t]) => {
            let s = 1.0 - t;
            a * s * s * s + 3.0 * b * s * s * t + 3.0 * c * s * t * t + d * t * t * t
        }
        ("bspline", [a, b, c, d, t]) => {
            let s = 1.0 - t;
            (a * s * s * s + b * (4.0 + t * t * (3.0 * t - 6.0)) + c * (1.0 + 3.0 * t * (1.0 + t * s)) + d * t * t * t) / 6.0
        }
        _ => return None,
    };
    Some(value)
}

struct Parser<'a> {
    text: &'a str,
    position: usize,
    parts: usize,
}

impl<'a> Parser<'a> {
    fn whole(text: &'a str) -> Result<Node> {
        let mut parser = Parser { text, position: 0, parts: 0 };
        let node = parser.sum()?;
        match parser.peek() {
            None => Ok(node),
            Some(c) => Err(parser.unexpected(&format!("'{}'", c.escape_debug()))),
        }
    }

    fn unexpected(&self, what: &str) -> Error {
        Error::new(format!("{what} in the formula '{}' is not expected", super::syntax::shortened(self.text)))
            .help("formulas have numbers, names, + - * / ^, parentheses and functions")
    }

    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.position..];
        self.position += rest.len() - rest.trim_start().len();
        self.text[self.position..].chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        self.position += if found { wanted.len_utf8() } else { 0 };
        found
    }

    fn part(&mut self) -> Result<()> {
        self.parts += 1;
        if self.parts > EXPRESSION_PARTS {
            return Err(Error::new(format!("a formula has more than {EXPRESSION_PARTS} parts")).help("write a shorter one"));
        }
        Ok(())
    }

    fn sum(&mut self) -> Result<Node> {
        let mut left = self.product()?;
        while let Some(sign) = self.peek().filter(|c| matches!(c, '+' | '-')) {
            self.position += 1;
            left = Node::Operation(sign, Box::new([left, self.product()?]));
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<Node> {
        let mut left = self.power()?;
        while let Some(sign) = self.peek().filter(|c| matches!(c, '*' | '/')) {
            self.position += 1;
            left = Node::Operation(sign, Box::new([left, self.power()?]));
        }
        Ok(left)
    }

    fn power(&mut self) -> Result<Node> {
        let base = self.signed()?;
        if self.take('^') {
            return Ok(Node::Operation('^', Box::new([base, self.power()?])));
        }
        Ok(base)
    }

    fn signed(&mut self) -> Result<Node> {
        if self.take('-') {
            return Ok(Node::Negative(Box::new(self.operand()?)));
        }
        self.operand()
    }

    fn operand(&mut self) -> Result<Node> {
        self.part()?;
        match self.peek() {
            None => Err(self.unexpected("the end")),
            Some('(') => {
                self.position += 1;
                let inside = self.sum()?;
                if self.take(')') { Ok(inside) } else { Err(self.unexpected("a parenthesis without its end")) }
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || c == '_' || c == '`' => self.named(),
            Some(c) => Err(self.unexpected(&format!("'{}'", c.escape_debug()))),
        }
    }

    fn number(&mut self) -> Result<Node> {
        let rest = &self.text[self.position..];
        let digits = |s: &str| s.len() - s.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let mut end = digits(rest);
        if rest[end..].starts_with('.') {
            end += 1 + digits(&rest[end + 1..]);
        }
        if let Some(exponent) = rest[end..].strip_prefix(['e', 'E']) {
            let sign = usize::from(exponent.starts_with(['+', '-']));
            let places = digits(&exponent[sign..]);
            end += if places > 0 { 1 + sign + places } else { 0 };
        }
        let value = rest[..end].parse().map_err(|_| self.unexpected(&format!("'{}'", &rest[..end])))?;
        self.position += end;
        Ok(Node::Number(value))
    }

    fn named(&mut self) -> Result<Node> {
        let rest = &self.text[self.position..];
        let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || "_.`".contains(c))).unwrap_or(rest.len());
        let name = rest[..end].to_string();
        self.position += end;
        if !self.take('(') {
            return Ok(Node::Variable(name));
        }
        let mut arguments = Vec::new();
        loop {
            arguments.push(self.sum()?);
            if self.take(')') {
                return Ok(Node::Call(name, arguments));
            }
            if !self.take(',') {
                return Err(self.unexpected("a call without its end"));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Option<f64> {
        Definitions::default().value(text, &|name, _| (name == "x").then_some(3.0)).unwrap()
    }

    #[test]
    fn formulas_have_the_values_that_radiance_gives_them() {
        // From rcalc.
        for (text, right) in [
            ("-2^2", 4.0),
            ("2^3^2", 512.0),
            ("-2*-3", 6.0),
            ("2-3-4", -5.0),
            ("2/4*3", 1.5),
            ("3*-2^2", 12.0),
            ("if(0, 1, 2)", 2.0),
            (".5 + 5. + 1e2", 105.5),
            ("1.5e-1*2E+1", 3.0),
            ("select(2, 7, 8, 9)", 8.0),
            ("select(0, 7, 8, 9)", 3.0),
            ("max(1, x, 2) - min(4, 5)", -1.0),
            ("mod(-1, 3) + frac(2.25)", 2.25),
            ("bezier(0, 1, 2, 5, .5)", 1.75),
            ("hermite(1, 2, 0, 3, .5)", 1.125),
            ("bspline(0, 1, 2, 3, .5)", 1.5),
            ("if(x - 2, sqrt(x + 1), x / 0 * missing)", 2.0),
        ] {
            assert!((value(text).unwrap() - right).abs() < 1e-12, "{text}: {:?}", value(text));
        }
        for unknown in ["Px", "1 + noise3(1, 2, 3)", "sqrt(1, 2)", "select(9, 1)"] {
            assert_eq!(value(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn what_is_no_formula_or_does_not_end_is_refused() {
        let bad = |text: &str| Definitions::default().value(text, &|_, _| None).unwrap_err().to_string();
        let deep = "(".repeat(100_000);
        let long = "1+".repeat(100_000) + "1";
        for text in [
            "",
            "1 +",
            "(1",
            "f(1",
            "f(1;2)",
            "1 2",
            "--2",
            "$1",
            "1e2.5",
            "é",
            ".",
            deep.as_str(),
            long.as_str(),
            "-".repeat(9999).as_str(),
        ] {
            assert!(bad(text).contains("help: "), "{text}");
        }
        let mut own = Definitions::default();
        own.add("f(x) = f(x) + f(x); half : .5; twice(x) = x / half;").unwrap();
        assert_eq!(own.value("twice(4)", &|_, _| None).unwrap(), Some(8.0));
        assert!(own.value("f(1)", &|_, _| None).unwrap_err().message().contains("without end"));
        for text in ["f(x = 1", "1 = 2", "f", "f(x y) = 1", "a = "] {
            assert!(own.add(text).is_err(), "{text}");
        }
    }
}
