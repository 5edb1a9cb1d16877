//! A rule's text as words.

use crate::error::{Error, Result};

/// Words that signals begin with.
pub(super) const SIGNAL_WORDS: [&str; 14] = [
    "irradiance",
    "illuminance",
    "profile",
    "altitude",
    "azimuth",
    "time",
    "month",
    "sun",
    "sunlit",
    "mean",
    "least",
    "most",
    "percentile",
    "dgp",
];
/// Words that join.
pub(super) const JOINING_WORDS: [&str; 14] =
    ["if", "until", "for", "else", "keep", "and", "or", "not", "between", "on", "of", "as", "set", "occupied"];

/// Whether the language needs a word.
pub(super) fn is_keyword(word: &str) -> bool {
    JOINING_WORDS.iter().chain(&SIGNAL_WORDS).any(|k| k.eq_ignore_ascii_case(word))
}

/// A piece of a rule's text.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    /// A word without quotes: of the language, or a name.
    Word(String),
    /// A name in quotes.
    Quoted(String),
    /// A number; of a time of day (`8:30`) its hours.
    Number(f64),
    /// `;`, `(`, `)`, `>`, `>=`, `<`, `<=`, `%`, `°`
    Sign(&'static str),
    /// Behind the last.
    End,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Word {
    pub kind: Kind,
    /// Where it begins, characters from 1.
    pub column: usize,
}

impl Word {
    /// As it stands in messages.
    pub fn shown(&self) -> String {
        match &self.kind {
            Kind::Word(w) | Kind::Quoted(w) => format!("'{}'", w.chars().take(40).collect::<String>().escape_debug()),
            Kind::Number(n) => format!("the number {n}"),
            Kind::Sign(s) => format!("'{s}'"),
            Kind::End => "the end".to_string(),
        }
    }
}

/// An error at a column.
pub(super) fn at(column: usize, message: impl std::fmt::Display) -> Error {
    Error::new(format!("column {column} of the rule: {message}"))
}

/// Characters of a rule.
const LONGEST: usize = 10_000;

const SIGNS: [&str; 9] = [">=", "<=", ">", "<", ";", "(", ")", "%", "°"];

pub(super) fn words(text: &str) -> Result<Vec<Word>> {
    let chars: Vec<char> = text.chars().collect();
    if chars.len() > LONGEST {
        return Err(Error::new(format!("the rule has {} characters, at most {LONGEST} are read", chars.len())));
    }
    let (mut found, mut i) = (Vec::new(), 0);
    let in_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | '/' | '²' | '^');
    while i < chars.len() {
        let (c, column) = (chars[i], i + 1);
        if c.is_whitespace() {
            i += 1;
            continue;
        }
        if let Some(sign) = SIGNS.iter().find(|s| s.chars().enumerate().all(|(k, c)| chars.get(i + k) == Some(&c))) {
            found.push(Word { kind: Kind::Sign(sign), column });
            i += sign.chars().count();
        } else if let Some(sign) = [('≥', ">="), ('≤', "<=")].iter().find(|(s, _)| *s == c) {
            found.push(Word { kind: Kind::Sign(sign.1), column });
            i += 1;
        } else if c == '\'' || c == '"' {
            let Some(end) = (i + 1..chars.len()).find(|k| chars[*k] == c) else {
                return Err(at(column, format!("the quote {c} is not closed")));
            };
            found.push(Word { kind: Kind::Quoted(chars[i + 1..end].iter().collect::<String>().trim().to_string()), column });
            i = end + 1;
        } else if c.is_ascii_digit() || (matches!(c, '-' | '.' | '+') && chars.get(i + 1).is_some_and(|d| d.is_ascii_digit() || *d == '.'))
        {
            let end = (i + 1..chars.len()).find(|k| !(chars[*k].is_ascii_digit() || matches!(chars[*k], '.' | ':'))).unwrap_or(chars.len());
            let text: String = chars[i..end].iter().collect();
            found.push(Word { kind: Kind::Number(number(&text).ok_or_else(|| at(column, format!("'{text}' is no number")))?), column });
            i = end;
        } else if in_word(c) {
            let end = (i + 1..chars.len()).find(|k| !in_word(chars[*k])).unwrap_or(chars.len());
            found.push(Word { kind: Kind::Word(chars[i..end].iter().collect()), column });
            i = end;
        } else {
            return Err(at(column, format!("'{}' has no meaning here", c.escape_debug())).help("put names with signs or blanks in quotes"));
        }
    }
    found.push(Word { kind: Kind::End, column: chars.len() + 1 });
    Ok(found)
}

/// A number, or a time as `8:30`.
fn number(text: &str) -> Option<f64> {
    let Some((hours, minutes)) = text.split_once(':') else { return text.parse().ok().filter(|v: &f64| v.is_finite()) };
    let whole = |text: &str| (1..=2).contains(&text.len()).then(|| text.parse::<u8>().ok()).flatten();
    let (hours, minutes) = whole(hours).zip(whole(minutes))?;
    let time = f64::from(hours) + f64::from(minutes) / 60.0;
    (minutes < 60 && time <= 24.0).then_some(time)
}
