//! Rules from their text.

mod signals;

use super::condition::{Condition, Limit};
use super::signal::{Known, Reading};
use super::words::{Kind, Word, at, is_keyword, words};
use crate::control::State;
use crate::control::facade::listed;
use crate::error::{Error, Result};

/// A state and when it is taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Clause {
    /// The state.
    pub state: State,
    /// When.
    pub condition: Condition,
    /// Minutes that the condition must have held.
    pub for_minutes: f64,
    /// Once taken, when it is left again; nothing: as soon as the condition does not hold.
    pub until: Option<Condition>,
    /// Its text.
    pub text: String,
}

/// What decides the state of one group: the first clause that is on, else a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Number of the group.
    pub group: usize,
    /// In order.
    pub clauses: Vec<Clause>,
    /// The state where none is on; the group's first if the text has no `else`.
    pub otherwise: State,
    /// Minutes that the group stays in a state once it has moved.
    pub keep_minutes: f64,
}

/// Clauses of a rule.
const MOST_CLAUSES: usize = 200;
/// Parentheses and `not` within each other.
const DEEPEST: usize = 40;
/// Minutes of `for` and `keep`.
const LONGEST: f64 = 7.0 * 1440.0;

impl Rule {
    /// The rule of a group. Names may stand in single or double quotes; those that are words of the language or have blanks
    /// must.
    ///
    /// # Errors
    /// With the column (in characters from 1): what cannot be read; states, groups, sensors and views that there are not;
    /// units that do not fit; numbers that the signal cannot have; conditions that can never hold or contradict each other;
    /// clauses that can never be reached.
    pub fn parse(text: &str, group: usize, known: Known<'_>) -> Result<Self> {
        let words = words(text)?;
        let mut parser = Parser { words: &words, next: 0, group, known, chars: text.chars().collect(), depth: 0 };
        let rule = parser.rule()?;
        Ok(rule)
    }

    /// The signals that it looks at, each once.
    pub fn readings(&self) -> Vec<Reading> {
        let conditions = self.clauses.iter().flat_map(|c| std::iter::once(&c.condition).chain(&c.until));
        let mut all: Vec<Reading> = conditions.flat_map(Condition::readings).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Whether it asks for occupancy.
    pub fn asks_for_occupancy(&self) -> bool {
        self.clauses.iter().any(|c| c.condition.asks_for_occupancy() || c.until.as_ref().is_some_and(Condition::asks_for_occupancy))
    }
}

struct Parser<'w, 'k> {
    words: &'w [Word],
    next: usize,
    group: usize,
    known: Known<'k>,
    chars: Vec<char>,
    depth: usize,
}

impl<'w> Parser<'w, '_> {
    fn peek(&self) -> &'w Word {
        &self.words[self.next.min(self.words.len() - 1)]
    }

    fn take(&mut self) -> &'w Word {
        let word = self.peek();
        self.next += 1;
        word
    }

    fn is_word(&self, word: &str) -> bool {
        matches!(&self.peek().kind, Kind::Word(w) if w.eq_ignore_ascii_case(word))
    }

    fn skip_word(&mut self, word: &str) -> bool {
        let is = self.is_word(word);
        self.next += usize::from(is);
        is
    }

    fn is_sign(&self, sign: &str) -> bool {
        matches!(self.peek().kind, Kind::Sign(s) if s == sign)
    }

    fn skip_sign(&mut self, sign: &str) -> bool {
        let is = self.is_sign(sign);
        self.next += usize::from(is);
        is
    }

    fn expected(&self, what: &str) -> Error {
        at(self.peek().column, format!("{} stands where {what} should", self.peek().shown()))
    }

    fn rule(&mut self) -> Result<Rule> {
        let mut rule = Rule { group: self.group, clauses: Vec::new(), otherwise: 0, keep_minutes: 0.0 };
        let (mut has_else, mut has_keep) = (false, false);
        loop {
            // A semicolon may end the rule.
            if self.peek().kind == Kind::End && (has_else || has_keep || !rule.clauses.is_empty()) {
                break;
            }
            let column = self.peek().column;
            if self.skip_word("else") {
                if has_else {
                    return Err(at(column, "there is an 'else' already"));
                }
                (rule.otherwise, has_else) = (self.state()?, true);
            } else if self.skip_word("keep") {
                if has_keep {
                    return Err(at(column, "there is a 'keep' already"));
                }
                (rule.keep_minutes, has_keep) = (self.minutes()?, true);
            } else {
                if has_else {
                    return Err(at(column, "this is never reached: it stands after 'else'").help("write 'else' last"));
                }
                let clause = self.clause()?;
                if rule.clauses.iter().any(|c| c.condition == clause.condition && c.for_minutes <= clause.for_minutes) {
                    return Err(at(column, "this is never reached: an earlier clause has the same condition"));
                }
                rule.clauses.push(clause);
                if rule.clauses.len() > MOST_CLAUSES {
                    return Err(at(column, format!("a rule has at most {MOST_CLAUSES} clauses")));
                }
            }
            if !self.skip_sign(";") && self.peek().kind != Kind::End {
                return Err(self
                    .expected("';' or the end")
                    .help("clauses are: STATE if CONDITION [for N min] [until CONDITION]; else STATE; keep N min"));
            }
        }
        if rule.clauses.is_empty() {
            return Err(Error::new("the rule has no clause with a condition").help("write: closed if irradiance > 250 W/m2; else open"));
        }
        Ok(rule)
    }

    fn clause(&mut self) -> Result<Clause> {
        let (start, column) = (self.peek().column, self.peek().column);
        let state = self.state()?;
        if !self.skip_word("if") {
            return Err(self.expected("'if'").help("write: closed if irradiance > 250 W/m2; else open"));
        }
        let condition = self.condition()?;
        let for_minutes = if self.skip_word("for") { self.minutes()? } else { 0.0 };
        let until = if self.skip_word("until") { Some(self.condition()?) } else { None };
        let end = self.peek().column - 1;
        for condition in std::iter::once(&condition).chain(&until) {
            if condition.impossible().is_some() {
                return Err(at(column, "this can never hold: two comparisons of one signal exclude each other"));
            }
        }
        if let Some(until) = &until
            && condition.overlaps(until)
        {
            return Err(at(column, "the rule contradicts itself: its 'if' and its 'until' hold at once for some values")
                .help("of a signal that closes above a limit, 'until' has the same limit or a lower one"));
        }
        let text = self.chars[start - 1..end].iter().collect::<String>().trim().to_string();
        Ok(Clause { state, condition, for_minutes, until, text })
    }

    fn state(&mut self) -> Result<State> {
        let word = self.take();
        let group = &self.known.facade.groups()[self.group];
        let name = match &word.kind {
            Kind::Word(w) if is_keyword(w) && group.state(w).is_err() => {
                self.next -= 1;
                return Err(self.expected("the name of a state"));
            }
            Kind::Word(w) | Kind::Quoted(w) => w.clone(),
            Kind::Number(n) => n.to_string(),
            _ => {
                self.next -= 1;
                return Err(self.expected("the name of a state").help(format!(
                    "the states of group '{}' are {}",
                    group.name,
                    listed(&group.states.iter().map(String::as_str).collect::<Vec<_>>())
                )));
            }
        };
        group.state(&name).map_err(|e| placed(word.column, &e))
    }

    fn minutes(&mut self) -> Result<f64> {
        let word = self.take();
        let Kind::Number(n) = word.kind else {
            self.next -= 1;
            return Err(self.expected("a number of minutes"));
        };
        let factor = if self.skip_word("h") {
            60.0
        } else if self.skip_word("min") || self.skip_word("minutes") {
            1.0
        } else {
            return Err(self.expected("'min' or 'h'"));
        };
        let minutes = n * factor;
        if !(minutes > 0.0 && minutes <= LONGEST) {
            return Err(at(word.column, format!("{minutes} min: choose more than 0 and at most {LONGEST}")));
        }
        Ok(minutes)
    }

    fn deeper(&mut self) -> Result<()> {
        self.depth += 1;
        if self.depth > DEEPEST {
            Err(at(self.peek().column, format!("more than {DEEPEST} parentheses within each other")))
        } else {
            Ok(())
        }
    }

    /// `or` binds less than `and`.
    fn condition(&mut self) -> Result<Condition> {
        self.deeper()?;
        let mut any = vec![self.conjunction()?];
        while self.skip_word("or") {
            any.push(self.conjunction()?);
        }
        self.depth -= 1;
        Ok(if any.len() == 1 { any.remove(0) } else { Condition::Any(any) })
    }

    fn conjunction(&mut self) -> Result<Condition> {
        let mut all = vec![self.negation()?];
        while self.skip_word("and") {
            all.push(self.negation()?);
        }
        Ok(if all.len() == 1 { all.remove(0) } else { Condition::All(all) })
    }

    fn negation(&mut self) -> Result<Condition> {
        if self.skip_word("not") {
            self.deeper()?;
            let inner = self.negation()?;
            self.depth -= 1;
            return Ok(Condition::Not(Box::new(inner)));
        }
        if self.skip_sign("(") {
            let inner = self.condition()?;
            if !self.skip_sign(")") {
                return Err(self.expected("')'"));
            }
            return Ok(inner);
        }
        if self.skip_word("occupied") {
            return Ok(Condition::Occupied);
        }
        self.comparison()
    }

    fn comparison(&mut self) -> Result<Condition> {
        let signal = self.signal()?;
        let as_set = signal.is_indoors() && self.is_word("as") && {
            self.next += 1;
            if !self.skip_word("set") {
                return Err(self.expected("'set' of 'as set'"));
            }
            true
        };
        let reading = Reading { signal, as_set };
        let limit = if self.skip_word("between") {
            let (column, from) = (self.peek().column, self.number(signal)?);
            if !self.skip_word("and") {
                return Err(self.expected("'and' with the second number of 'between'"));
            }
            let to = self.number(signal)?;
            if from > to && !signal.goes_round() {
                return Err(at(column, format!("nothing lies between {from} and {to}")).help("write the smaller number first"));
            }
            Limit::Between(from, to)
        } else {
            let Kind::Sign(sign @ (">" | ">=" | "<" | "<=")) = self.peek().kind else {
                return Err(self.expected("one of >, >=, <, <=, between"));
            };
            self.next += 1;
            let number = self.number(signal)?;
            match sign {
                ">" => Limit::Above(number),
                ">=" => Limit::AtLeast(number),
                "<" => Limit::Below(number),
                _ => Limit::AtMost(number),
            }
        };
        Ok(Condition::Compare(reading, limit))
    }
}

fn placed(column: usize, error: &Error) -> Error {
    let text = error.to_string();
    match text.split_once("\n  help: ") {
        Some((message, help)) => at(column, message).help(help),
        None => at(column, text),
    }
}
