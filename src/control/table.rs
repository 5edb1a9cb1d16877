//! Schedules as tables: CSV with a row per time step, per hour of the year, or per change.
//!
//! Cells are separated by commas, semicolons or tabs; lines that begin with # are skipped. A first line with names may stand
//! above. Of several columns the one with the group's name counts, else the only one that is no time, without names the
//! last. Under a column `from`, rows are changes: `03-21T08:00,closed` holds until the next row's time.

use super::facade::{Facade, Group, State, listed};
use super::schedule::Schedule;
use crate::error::{Error, Result};
use crate::files::write_atomically;
use crate::metrics::Year;
use crate::text;
use crate::weather::time::Time;
use std::path::Path;

/// Names of columns that tell times.
const TIMES: [&str; 12] =
    ["time", "date", "datetime", "date/time", "timestamp", "month", "day", "hour", "minute", "step", "begins", "hour of year"];
/// The column of the times from which a state holds.
const FROM: &str = "from";

/// Reads the states of one group by time step from a file.
///
/// # Errors
/// With file and line: rows that are not as many as the time steps or the hours of the year, states that the group does
/// not have, empty cells, several columns none of which is the group's, times that are not those of the steps.
pub fn read(path: &Path, group: &Group, year: &Year) -> Result<Vec<State>> {
    parse(&text::read(path, "a schedule")?, group, year).map_err(|e| e.file(path))
}

/// As [`read`], from the file's text.
///
/// # Errors
/// The same.
pub fn parse(text: &str, group: &Group, year: &Year) -> Result<Vec<State>> {
    let rows = rows(text);
    let Some(first) = rows.first() else {
        return Err(Error::new("the schedule is empty").help("write a state for each time step, one per line"));
    };
    let (columns, rows) = if is_header(first, group, rows.len(), year) {
        (Columns::named(&first.cells, group).map_err(|e| e.line(first.line))?, &rows[1..])
    } else {
        (Columns::unnamed(first, group).map_err(|e| e.line(first.line))?, &rows[..])
    };
    let states = rows.iter().map(|row| columns.state(row, group).map_err(|e| e.line(row.line))).collect::<Result<Vec<_>>>()?;
    match columns.from {
        Some(from) => of_changes(from, rows, &states, year),
        None => of_rows(&columns, rows, &states, year),
    }
}

struct Row<'t> {
    line: usize,
    cells: Vec<&'t str>,
}

fn rows(text: &str) -> Vec<Row<'_>> {
    let lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim_end()));
    let lines = lines.filter(|(_, l)| !l.trim().is_empty() && !l.trim_start().starts_with('#'));
    let mut separator = None;
    lines
        .map(|(line, content)| {
            let separator = *separator.get_or_insert_with(|| [';', '\t'].into_iter().find(|c| content.contains(*c)).unwrap_or(','));
            Row { line, cells: content.split(separator).map(|c| c.trim().trim_matches('"').trim()).collect() }
        })
        .collect()
}

/// Rows that fit: as many as steps, or as hours of the year.
fn fits(rows: usize, year: &Year) -> bool {
    rows == year.steps.len() || rows == year.whole() as usize
}

fn is_header(first: &Row<'_>, group: &Group, rows: usize, year: &Year) -> bool {
    let is = |cell: &str, name: &str| cell.eq_ignore_ascii_case(name);
    let state = first.cells.last().is_some_and(|c| group.state(c).is_ok());
    let named = first.cells.iter().any(|c| is(c, &group.name) || is(c, "state") || is(c, FROM) || TIMES.iter().any(|t| is(c, t)));
    if state {
        // A state may be called as a column is: the number of rows tells.
        named && (first.cells.len() > 1 || (!fits(rows, year) && fits(rows - 1, year)))
    } else {
        named || (!fits(rows, year) && fits(rows - 1, year))
    }
}

/// Where things stand in a row.
#[derive(Default)]
struct Columns {
    state: usize,
    from: Option<usize>,
    /// Month and day.
    date: Option<[usize; 2]>,
}

impl Columns {
    fn named(names: &[&str], group: &Group) -> Result<Self> {
        let find = |name: &str| names.iter().position(|n| n.eq_ignore_ascii_case(name));
        let is_time = |name: &str| name.is_empty() || name.eq_ignore_ascii_case(FROM) || TIMES.iter().any(|t| name.eq_ignore_ascii_case(t));
        let others: Vec<usize> = (0..names.len()).filter(|i| !is_time(names[*i])).collect();
        let own: Vec<usize> = (0..names.len()).filter(|i| names[*i].to_lowercase() == group.name.to_lowercase()).collect();
        let state = match (own.as_slice(), others.as_slice()) {
            ([one], _) | ([], [one]) => *one,
            ([_, ..], _) => return Err(Error::new(format!("two columns are called '{}'", group.name))),
            (_, []) => return Err(Error::new("no column holds states").help(format!("call it '{}' or 'state'", group.name))),
            (_, others) => {
                let names: Vec<&str> = others.iter().map(|i| names[*i]).collect();
                return Err(Error::new(format!("no column is called '{}': there are {}", group.name, listed(&names)))
                    .help("a file of several groups has a column with the name of each"));
            }
        };
        Ok(Self { state, from: find(FROM), date: find("month").zip(find("day")).map(|(m, d)| [m, d]) })
    }

    /// Without names the last column counts; no other may hold states.
    fn unnamed(first: &Row<'_>, group: &Group) -> Result<Self> {
        let state = first.cells.len() - 1;
        let words = first.cells[..state].iter().any(|c| c.parse::<f64>().is_err() && group.state(c).is_ok());
        if words {
            return Err(Error::new("several columns hold states").help("write the names of the groups above them"));
        }
        Ok(Self { state, ..Self::default() })
    }

    fn cell<'t>(row: &Row<'t>, column: usize) -> Result<&'t str> {
        match row.cells.get(column) {
            Some(cell) if !cell.is_empty() => Ok(cell),
            Some(_) => Err(Error::new(format!("cell {} is empty", column + 1)).help("write a state in every row")),
            None => Err(Error::new(format!("the row has {} cells, the state is in cell {}", row.cells.len(), column + 1))),
        }
    }

    fn state(&self, row: &Row<'_>, group: &Group) -> Result<State> {
        group.state(Self::cell(row, self.state)?)
    }
}

/// A row per step, or per hour of the year.
fn of_rows(columns: &Columns, rows: &[Row<'_>], states: &[State], year: &Year) -> Result<Vec<State>> {
    let (count, steps, whole) = (rows.len(), year.steps.len(), year.whole() as usize);
    if count == steps && steps == whole && !year.is_whole() {
        return Err(Error::new(format!("{count} rows may be the time steps or the hours of the year, which differ here"))
            .help("write changes, with their times in a column 'from'"));
    }
    if !fits(count, year) {
        let leap = if year.is_leap() { " (it has a 29 February)" } else { "" };
        let wanted = if steps == whole { format!("{steps}") } else { format!("{steps}, or {whole}, one for each hour of the year{leap}") };
        return Err(Error::new(format!("the schedule has {count} rows, the weather has {steps} time steps"))
            .help(format!("give a row for each time step: {wanted}; or changes only, with their times in a column 'from'")));
    }
    let row_of = |step: usize| if count == whole { year.hour_of(&year.steps[step]) } else { step };
    if let Some(date) = columns.date {
        for (step, at) in year.steps.iter().enumerate() {
            let row = &rows[row_of(step)];
            let [month, day] = date.map(|column| row.cells.get(column).and_then(|c| c.parse::<f64>().ok()));
            if (month, day) != (Some(f64::from(at.month)), Some(f64::from(at.day))) {
                let found = date.map(|column| row.cells.get(column).copied().unwrap_or_default()).join(", ");
                return Err(Error::new(format!("month and day are {found}, but this row is for {}, {}", at.month, at.day))
                    .line(row.line)
                    .help("order the rows as the weather's time steps, or leave month and day out"));
            }
        }
    }
    Ok((0..steps).map(|step| states[row_of(step)]).collect())
}

/// A row per change.
fn of_changes(from: usize, rows: &[Row<'_>], states: &[State], year: &Year) -> Result<Vec<State>> {
    // Minutes of a year in which every month has 31 days.
    let minute = |month: u8, day: u8, hour: f64| (u32::from(month) * 31 + u32::from(day)) * 1440 + (hour * 60.0 + 1e-6).floor() as u32;
    let mut changes: Vec<(u32, State)> = Vec::with_capacity(rows.len());
    for (row, state) in rows.iter().zip(states) {
        let at = || -> Result<u32> {
            let time = Time::parse(Columns::cell(row, from)?)?;
            Ok(minute(time.month, time.day, time.hour))
        };
        let at = at().map_err(|e| e.line(row.line))?;
        if changes.last().is_some_and(|(before, _)| *before >= at) {
            return Err(Error::new("this time is not after that of the row before").line(row.line).help("order the rows by their times"));
        }
        changes.push((at, *state));
    }
    let state_of = |step: &crate::metrics::Step| {
        let at = minute(step.month, step.day, step.begins);
        let after = changes.partition_point(|(from, _)| *from <= at);
        after.checked_sub(1).map(|i| changes[i].1).ok_or_else(|| {
            Error::new(format!("the schedule says nothing before its first row: the step of {}/{} is earlier", step.month, step.day))
                .line(rows.first().map_or(1, |r| r.line))
                .help("begin with the state at 01-01T00:00")
        })
    };
    year.steps.iter().map(state_of).collect()
}

/// Writes a schedule, states by name: `month,day,begins,GROUP,GROUP…`, a row per time step.
///
/// # Errors
/// Failures of the file system.
///
/// # Panics
/// If façade, year and schedule do not belong together.
pub fn write(path: &Path, facade: &Facade, year: &Year, schedule: &Schedule) -> Result<()> {
    assert_eq!((facade.groups().len(), year.steps.len()), (schedule.groups(), schedule.steps()), "a schedule of this façade and year");
    let groups = facade.groups();
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        let names: Vec<&str> = groups.iter().map(|g| g.name.as_str()).collect();
        writeln!(out, "month,day,begins,{}", names.join(",")).map_err(fault)?;
        for (step, at) in year.steps.iter().enumerate() {
            let states: Vec<&str> =
                groups.iter().enumerate().map(|(g, group)| group.states[usize::from(schedule.at(g, step))].as_str()).collect();
            let begins = (at.begins * 1e4).round() / 1e4;
            writeln!(out, "{},{},{begins},{}", at.month, at.day, states.join(",")).map_err(fault)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn south() -> Group {
        Group::new("south", &["open", "blind 45", "closed"]).unwrap()
    }

    fn days(first: usize, count: usize) -> Year {
        let mut year = Year::common();
        year.steps = year.steps[24 * first..24 * (first + count)].to_vec();
        year
    }

    fn refused(text: &str, year: &Year) -> String {
        parse(text, &south(), year).unwrap_err().to_string()
    }

    /// A name per hour: closed at 12 and 13 o'clock, half of it at 9.
    fn by_hour(hour: usize) -> State {
        match hour % 24 {
            9 => 1,
            12 | 13 => 2,
            _ => 0,
        }
    }

    #[test]
    fn a_row_per_step_or_hour_by_name_or_number() {
        let (day, year) = (days(40, 1), Year::common());
        let wanted: Vec<State> = (0..24).map(by_hour).collect();
        let text = |n: usize, header: &str, row: fn(usize) -> String| header.to_string() + &(0..n).map(row).collect::<String>();
        let named = |h: usize| format!("{}\n", ["open", "Blind 45", "closed"][usize::from(by_hour(h))]);
        for text in [
            text(24, "", named),
            text(24, "south\n", named),
            text(24, "# a schedule\n\nstate\r\n", named),
            text(24, "anything\n", named),
            text(24, "", |h| format!("{}\n", by_hour(h))),
            text(24, "", |h| format!("{h},{}\n", by_hour(h))),
            text(24, "hour;south\n", |h| format!("{h},5;\"{}\"\n", by_hour(h))),
            text(24, "month,day,hour,north,south,west\n", |h| format!("2,10,{h},shut,{},7\n", by_hour(h))),
            text(24, "SOUTH\ttime\n", |h| format!("{}\t{h}:00\n", by_hour(h))),
            // One for each hour of the year.
            text(8760, "hour,state\n", |h| format!("{h},{}\n", by_hour(h))),
        ] {
            assert_eq!(parse(&text, &south(), &day).unwrap(), wanted, "{}", text.chars().take(50).collect::<String>());
        }
        let whole = parse(&text(8760, "", |h| format!("{}\n", by_hour(h))), &south(), &year).unwrap();
        assert_eq!((whole.len(), whole[9], whole[8759 - 11]), (8760, 1, 2));
        // Quarters of an hour take the state of their hour.
        let mut quarters = days(0, 1);
        quarters.length = 0.25;
        quarters.steps = quarters
            .steps
            .iter()
            .flat_map(|s| (0..4).map(|q| crate::metrics::Step { begins: s.begins + f64::from(q) / 4.0, ..*s }))
            .collect();
        let found = parse(&text(8760, "", |h| format!("{}\n", by_hour(h))), &south(), &quarters).unwrap();
        assert_eq!(found[35..41], [0, 1, 1, 1, 1, 0]);
    }

    #[test]
    fn changes_hold_until_the_next() {
        let year = Year::common();
        let text = "from,south\n01-01T00:00,open\n03-21T08:00,closed\n03-21T17:30,blind 45\n10-01T00:00,0\n";
        let states = parse(text, &south(), &year).unwrap();
        let at = |month, day, hour: f64| states[year.steps.iter().position(|s| (s.month, s.day, s.begins) == (month, day, hour)).unwrap()];
        assert_eq!([at(1, 1, 0.0), at(3, 21, 7.0), at(3, 21, 8.0), at(3, 21, 17.0), at(3, 21, 18.0)], [0, 0, 2, 2, 1]);
        assert_eq!([at(9, 30, 23.0), at(10, 1, 0.0), at(12, 31, 23.0)], [1, 0, 0]);
        // A change that comes before the steps of a part of the year holds too.
        assert_eq!(parse(text, &south(), &days(100, 2)).unwrap(), [1; 48]);
        let error = refused("from,south\n02-01T00:00,open\n", &year);
        assert!(error.contains("line 2") && error.contains("01-01T00:00"), "{error}");
        let error = refused("from,south\n01-01T00:00,open\n02-01T00:00,open\n01-20T00:00,1\n", &year);
        assert!(error.contains("line 4") && error.contains("not after"), "{error}");
        assert!(refused("from,south\n01-01T00:00,open\nmonday,1\n", &year).contains("line 3: 'monday' is not a date"));
        assert!(refused("from,south\n", &year).contains("before its first row"));
    }

    #[test]
    fn what_does_not_fit_is_refused_with_its_line() {
        let day = days(0, 1);
        let lines = |n: usize| "open\n".repeat(n);
        let error = refused(&lines(22), &day);
        assert!(error.contains("22 rows") && error.contains("24, or 8760"), "{error}");
        assert!(refused(&lines(8761), &Year::common()).contains("8761 rows"));
        assert!(refused("", &day).contains("empty") && refused("# nothing\n", &day).contains("empty"));
        let error = refused(&(lines(3) + "opne\n" + &lines(20)), &day);
        assert!(error.contains("line 4") && error.contains("did you mean 'open'?"), "{error}");
        // A slip in the first row is none of a column's name.
        let error = refused(&("opne\n".to_string() + &lines(23)), &day);
        assert!(error.contains("line 1") && error.contains("'opne'"), "{error}");
        let error = refused(&("hour,south\n".to_string() + &"1,open\n".repeat(4) + "5,\n" + &"1,open\n".repeat(19)), &day);
        assert!(error.contains("line 6") && error.contains("cell 2 is empty"), "{error}");
        let error = refused(&("hour,south\n".to_string() + &"1,open\n".repeat(4) + "5\n" + &"1,open\n".repeat(19)), &day);
        assert!(error.contains("line 6") && error.contains("1 cells"), "{error}");
        let error = refused(&("hour,east,west\n".to_string() + &"1,0,0\n".repeat(24)), &day);
        assert!(error.contains("line 1") && error.contains("'east', 'west'"), "{error}");
        assert!(refused(&"open,closed\n".repeat(24), &day).contains("several columns hold states"));
        assert!(refused(&("south,South\n".to_string() + &"0,0\n".repeat(24)), &day).contains("two columns"));
        assert!(refused(&("month,day\n".to_string() + &"1,1\n".repeat(24)), &day).contains("no column holds states"));
        let error = refused(&("month,day,south\n".to_string() + &"1,1,0\n".repeat(23) + "1,2,0\n"), &day);
        assert!(error.contains("line 25") && error.contains("this row is for 1, 1"), "{error}");
        // As many steps as a year has hours, but not its hours.
        let mut twice = Year::common();
        twice.steps[8759] = twice.steps[0];
        assert!(refused(&lines(8760), &twice).contains("may be the time steps or the hours"));
    }

    #[test]
    fn what_is_written_is_read_again() {
        let facade = Facade::new(vec![south(), Group::new("roof", &["0", "50", "1"]).unwrap()]).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("schedule.csv");
        for year in [Year::common(), days(358, 3)] {
            let steps = year.steps.len();
            let states = vec![(0..steps).map(by_hour).collect(), (0..steps).map(|s| (s % 3) as State).collect()];
            let schedule = Schedule::new(&facade, steps, states).unwrap();
            write(&path, &facade, &year, &schedule).unwrap();
            for (g, group) in facade.groups().iter().enumerate() {
                assert_eq!(read(&path, group, &year).unwrap(), schedule.of_group(g));
            }
        }
        let error = read(&path, &south(), &Year::common()).unwrap_err().to_string();
        assert!(error.contains("schedule.csv") && error.contains("72 rows"), "{error}");
    }
}
