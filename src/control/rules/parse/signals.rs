//! Signals of a rule, and numbers in their units.

use super::{Parser, placed};
use crate::control::facade::listed;
use crate::control::rules::signal::{Signal, Statistic};
use crate::control::rules::words::{Kind, SIGNAL_WORDS, Word, at};
use crate::error::{Error, Result};
use crate::text::nearest;

const SIGNALS: &str = "irradiance [on GROUP], illuminance [on GROUP], profile angle [on GROUP], altitude, azimuth, time, month, occupied, \
                       sun on SENSORS, sunlit share of SENSORS, mean | least | most | percentile N illuminance of SENSORS, dgp of VIEW";

impl Parser<'_, '_> {
    /// A number in the unit of a signal.
    pub(super) fn number(&mut self, signal: Signal) -> Result<f64> {
        let word = self.take();
        let Kind::Number(mut n) = word.kind else {
            self.next -= 1;
            return Err(self.expected("a number"));
        };
        let unit = self.peek();
        let found = match &unit.kind {
            Kind::Sign("%") => "%",
            Kind::Sign("°") => "deg",
            Kind::Word(w) => match w.to_lowercase().as_str() {
                "lx" | "lux" => "lx",
                "klx" => "klx",
                "w/m2" | "w/m²" | "w/m^2" => "W/m2",
                "deg" | "degrees" => "deg",
                "h" => "h",
                _ => "",
            },
            _ => "",
        };
        if !found.is_empty() {
            self.next += 1;
            let wanted = signal.unit();
            match found {
                "klx" if wanted == "lx" => n *= 1000.0,
                "%" if matches!(signal, Signal::Dgp(_)) => n /= 100.0,
                found if found == wanted => {}
                found if wanted.is_empty() => return Err(at(unit.column, format!("'{found}' stands after a number that has no unit"))),
                found => return Err(at(unit.column, format!("'{found}' is not the unit of this signal, which is in {wanted}"))),
            }
        }
        if !signal.range().contains(&n) {
            let (least, most) = (*signal.range().start(), *signal.range().end());
            return Err(at(
                word.column,
                format!("{n} is never reached: this signal is between {least} and {most} {}", signal.unit()).trim_end(),
            ));
        }
        Ok(n)
    }

    pub(super) fn signal(&mut self) -> Result<Signal> {
        let word = self.take();
        let Kind::Word(name) = &word.kind else {
            self.next -= 1;
            return Err(self.expected("a signal").help(format!("signals are {SIGNALS}")));
        };
        match name.to_lowercase().as_str() {
            "irradiance" => Ok(Signal::Irradiance(self.own_or_named_group()?)),
            "illuminance" => {
                if self.is_word("of") {
                    return Err(at(word.column, "the illuminance of many sensors is many numbers")
                        .help("write mean, least, most or percentile N before it"));
                }
                Ok(Signal::Illuminance(self.own_or_named_group()?))
            }
            "profile" => {
                if !self.skip_word("angle") {
                    return Err(self.expected("'angle' of 'profile angle'"));
                }
                Ok(Signal::ProfileAngle(self.own_or_named_group()?))
            }
            "altitude" => Ok(Signal::Altitude),
            "azimuth" => Ok(Signal::Azimuth),
            "time" => Ok(Signal::Time),
            "month" => Ok(Signal::Month),
            "sun" => {
                if !self.skip_word("on") {
                    return Err(self.expected("'on' of 'sun on SENSORS'"));
                }
                Ok(Signal::Sun(self.sensors()?))
            }
            "sunlit" => {
                if !self.skip_word("share") {
                    return Err(self.expected("'share' of 'sunlit share of SENSORS'"));
                }
                self.skip_word("of");
                Ok(Signal::SunlitShare(self.sensors()?))
            }
            "mean" => self.statistic(Statistic::Mean),
            "least" => self.statistic(Statistic::Least),
            "most" => self.statistic(Statistic::Most),
            "percentile" => match self.take() {
                Word { kind: Kind::Number(n), .. } if (1.0..=99.0).contains(n) && n.fract() == 0.0 => {
                    self.statistic(Statistic::Percentile(*n as u8))
                }
                other => Err(at(other.column, "a percentile is a whole number from 1 to 99")),
            },
            "dgp" => {
                self.skip_word("of");
                let (column, name) = self.name("the name of a view")?;
                let found = self.known.views.iter().position(|v| *v == name);
                found.map(Signal::Dgp).ok_or_else(|| unknown(column, "view", &name, self.known.views))
            }
            other => {
                let error = at(word.column, format!("there is no signal {}", word.shown()));
                Err(match nearest(other, &[&SIGNAL_WORDS[..], &["occupied"]].concat()) {
                    Some(near) => error.help(format!("did you mean '{near}'? Signals are {SIGNALS}")),
                    None => error.help(format!("signals are {SIGNALS}")),
                })
            }
        }
    }

    fn statistic(&mut self, statistic: Statistic) -> Result<Signal> {
        if !self.skip_word("illuminance") {
            return Err(self.expected("'illuminance'"));
        }
        self.skip_word("of");
        Ok(Signal::Sensors(statistic, self.sensors()?))
    }

    fn name(&mut self, what: &str) -> Result<(usize, String)> {
        let word = self.take();
        match &word.kind {
            Kind::Word(w) | Kind::Quoted(w) => Ok((word.column, w.clone())),
            Kind::Number(n) => Ok((word.column, n.to_string())),
            _ => {
                self.next -= 1;
                Err(self.expected(what))
            }
        }
    }

    fn own_or_named_group(&mut self) -> Result<usize> {
        if !self.skip_word("on") {
            return Ok(self.group);
        }
        let (column, name) = self.name("the name of a group of windows")?;
        self.known.facade.group(&name).map_err(|e| placed(column, &e))
    }

    /// A group of sensors, or all of them by the word `sensors`.
    fn sensors(&mut self) -> Result<Option<usize>> {
        let (column, name) = self.name("the name of a group of sensors")?;
        match self.known.sensors.iter().position(|s| *s == name) {
            Some(found) => Ok(Some(found)),
            None if name.eq_ignore_ascii_case("sensors") && !self.known.sensors.is_empty() => Ok(None),
            None => Err(unknown(column, "group of sensors", &name, self.known.sensors)),
        }
    }
}

fn unknown(column: usize, what: &str, name: &str, known: &[String]) -> Error {
    let names: Vec<&str> = known.iter().map(String::as_str).collect();
    let shown: String = name.chars().take(40).collect();
    let error = at(column, format!("there is no {what} '{}'", shown.escape_debug()));
    match (nearest(&shown, &names), names.is_empty()) {
        (_, true) => error.help(format!("the project has no {what}")),
        (Some(near), _) => error.help(format!("did you mean '{near}'?")),
        (None, _) => error.help(format!("there are {}", listed(&names))),
    }
}
