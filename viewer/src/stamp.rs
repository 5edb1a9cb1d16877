//! Times of the steps of a year.

/// Local standard time of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stamp {
    /// Month, 1…12.
    pub month: u8,
    /// Day of the month, from 1.
    pub day: u8,
    /// Hours from midnight.
    pub hour: f64,
}

const MONTHS: [&str; 12] =
    ["January", "February", "March", "April", "May", "June", "July", "August", "September", "October", "November", "December"];
const LENGTHS: [u8; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

impl Stamp {
    /// Steps of a common year where a result does not tell its times: as many per day as fit 365 days.
    pub fn common_year(steps: usize) -> Vec<Self> {
        let per_day = steps_per_day(steps);
        (0..steps)
            .map(|i| {
                let (mut day, hour) = ((i / per_day) % 365, (i % per_day) as f64 + 0.5);
                let mut month = 0;
                while day >= usize::from(LENGTHS[month]) {
                    day -= usize::from(LENGTHS[month]);
                    month += 1;
                }
                Self { month: month as u8 + 1, day: day as u8 + 1, hour: hour * 24.0 / per_day as f64 }
            })
            .collect()
    }

    /// `21 June, 12:30`.
    pub fn text(&self) -> String {
        let minutes = (self.hour * 60.0).round() as u32;
        let month = MONTHS.get(usize::from(self.month).wrapping_sub(1)).unwrap_or(&"?");
        format!("{} {month}, {:02}:{:02}", self.day, minutes / 60, minutes % 60)
    }
}

/// Steps per day of a year of this many steps.
pub fn steps_per_day(steps: usize) -> usize {
    if steps.is_multiple_of(365) && steps >= 365 {
        steps / 365
    } else if steps.is_multiple_of(366) && steps >= 366 {
        steps / 366
    } else {
        24
    }
}

/// Name and first day (from 0) of each month within `days` days.
pub fn months(stamps: &[Stamp], per_day: usize) -> Vec<(&'static str, usize)> {
    let mut found: Vec<(&'static str, usize)> = Vec::new();
    let mut last = 0;
    for (day, stamp) in stamps.iter().step_by(per_day.max(1)).enumerate() {
        if stamp.month != last {
            last = stamp.month;
            if let Some(name) = MONTHS.get(usize::from(stamp.month).wrapping_sub(1)) {
                found.push((&name[..3], day));
            }
        }
    }
    found
}
