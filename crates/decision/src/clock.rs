//! The clock of the target: date and time of day, to 10 ms.
//!
//! Source: the thesis, Annex A2, `rtc()`. Differences: [`Mode::Corrected`] keeps the Gregorian
//! calendar. The listing gives 31 days to every odd month and 30 to every even one, and a leap
//! day to every fourth year, so that from August on its dates are wrong; [`Mode::Listing`] does
//! the same.

use std::fmt;

use crate::Mode;

/// Date and time of day.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct DateTime {
    /// From 0.
    pub year: u16,
    /// 1 to 12.
    pub month: u8,
    /// 1 to 31.
    pub day: u8,
    /// 0 to 23.
    pub hour: u8,
    /// 0 to 59.
    pub minute: u8,
    /// 0 to 59.
    pub second: u8,
    /// Hundredths of a second, 0 to 99.
    pub centisecond: u8,
}

impl DateTime {
    /// What the clock shows when it is switched on: 1 January 2000, midnight.
    pub const SWITCHED_ON: Self =
        Self { year: 2000, month: 1, day: 1, hour: 0, minute: 0, second: 0, centisecond: 0 };

    /// Whether the calendar of that mode has this date, and the day this time.
    pub fn is_valid(self, mode: Mode) -> bool {
        (1..=12).contains(&self.month)
            && (1..=n_days(self.year, self.month, mode)).contains(&self.day)
            && self.hour < 24
            && self.minute < 60
            && self.second < 60
            && self.centisecond < 100
    }

    /// Day of the week, 1 (Monday) to 7 (Sunday), by the Gregorian calendar.
    ///
    /// Source: days counted from 1 March, as in Richards (2013), in the Explanatory Supplement to
    /// the Astronomical Almanac.
    pub fn weekday(self) -> u8 {
        let (year, month) = (u32::from(self.year), u32::from(self.month));
        // The year begins in March, so that a leap day is its last; 400 years are whole weeks.
        let (year, month) = if month < 3 {
            (year.saturating_add(399), month.saturating_add(9))
        } else {
            (year.saturating_add(400), month.saturating_sub(3))
        };
        let leap_days = (year / 4).saturating_sub(year / 100).saturating_add(year / 400);
        let days_of_months = month.saturating_mul(153).saturating_add(2) / 5;
        let days = year.saturating_mul(365).saturating_add(leap_days);
        let days = days.saturating_add(days_of_months).saturating_add(self.day.into());
        // 1 March of the year 0 was a Wednesday.
        u8::try_from(days.saturating_add(1) % 7).unwrap_or(0).saturating_add(1)
    }

    /// Reads `2009-12-04 17:05:09.25`, `2009-12-04 17:05` or `17:05:09`; without a date it is 1
    /// January 2000. `None` when it is written otherwise; whether a calendar has it is another
    /// question ([`DateTime::is_valid`]).
    pub fn parse(text: &str) -> Option<Self> {
        let (date, time) = match text.trim().split_once([' ', 'T']) {
            Some((date, time)) => (Some(date), time.trim_start()),
            None => (None, text.trim()),
        };
        let mut clock = Self::SWITCHED_ON;
        if let Some(date) = date {
            let mut parts = date.split('-');
            clock.year = digits(parts.next()?, 4)?;
            clock.month = u8::try_from(digits(parts.next()?, 2)?).ok()?;
            clock.day = u8::try_from(digits(parts.next()?, 2)?).ok()?;
            parts.next().is_none().then_some(())?;
        }
        let (time, hundredths) = time.split_once('.').unwrap_or((time, "00"));
        clock.centisecond = u8::try_from(digits(hundredths, 2)?).ok()?;
        let mut parts = time.split(':');
        clock.hour = u8::try_from(digits(parts.next()?, 2)?).ok()?;
        clock.minute = u8::try_from(digits(parts.next()?, 2)?).ok()?;
        clock.second = u8::try_from(digits(parts.next().unwrap_or("00"), 2)?).ok()?;
        parts.next().is_none().then_some(clock)
    }

    /// Seconds since midnight.
    pub fn second_of_day(self) -> f64 {
        let Self { hour, minute, second, centisecond, .. } = self;
        3600.0 * f64::from(hour)
            + 60.0 * f64::from(minute)
            + f64::from(second)
            + 0.01 * f64::from(centisecond)
    }

    /// 10 ms later. After the year 65535 comes the year 0.
    pub(crate) fn tick(&mut self, mode: Mode) {
        if carries(&mut self.centisecond, 0, 99)
            && carries(&mut self.second, 0, 59)
            && carries(&mut self.minute, 0, 59)
            && carries(&mut self.hour, 0, 23)
        {
            self.next_day(mode);
        }
    }

    fn next_day(&mut self, mode: Mode) {
        let n_days = n_days(self.year, self.month, mode);
        if carries(&mut self.day, 1, n_days) && carries(&mut self.month, 1, 12) {
            self.year = self.year.wrapping_add(1);
        }
    }
}

/// A number of one to `len_max` decimal digits.
fn digits(text: &str, len_max: usize) -> Option<u16> {
    let is_number = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    (is_number && text.len() <= len_max).then(|| text.parse().ok()).flatten()
}

/// Counts a digit up; true when it starts over.
fn carries(digit: &mut u8, first: u8, last: u8) -> bool {
    let over = *digit >= last;
    *digit = if over { first } else { digit.saturating_add(1) };
    over
}

fn n_days(year: u16, month: u8, mode: Mode) -> u8 {
    let is_leap = match mode {
        Mode::Corrected => {
            year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
        }
        Mode::Listing => year.is_multiple_of(4),
    };
    match (month, mode) {
        (2, _) => 28_u8.saturating_add(u8::from(is_leap)),
        (_, Mode::Listing) => 30_u8.saturating_add(month % 2),
        (4 | 6 | 9 | 11, Mode::Corrected) => 30,
        (_, Mode::Corrected) => 31,
    }
}

impl fmt::Display for DateTime {
    /// `2009-12-04 17:05:09.25`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { year, month, day, hour, minute, second, centisecond } = self;
        write!(
            f,
            "{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}.{centisecond:02}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(year: u16, month: u8, day: u8) -> DateTime {
        DateTime { year, month, day, ..DateTime::SWITCHED_ON }
    }

    fn after(mut date: DateTime, mode: Mode) -> DateTime {
        (date.hour, date.minute, date.second, date.centisecond) = (23, 59, 59, 99);
        date.tick(mode);
        date
    }

    /// Days from 1 March of year 0 to the date. Oracle: the closed formula with years that begin
    /// in March (Richards 2013, in the Explanatory Supplement to the Astronomical Almanac); it
    /// knows no table of months.
    fn day_number(date: DateTime) -> i64 {
        let (y, m) = (i64::from(date.year), i64::from(date.month));
        let (y, m) = if m < 3 { (y - 1, m + 9) } else { (y, m - 3) };
        365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + i64::from(date.day) - 1
    }

    #[test]
    fn eight_hundred_years_have_every_day_once() {
        let mut date = at(1600, 1, 1);
        while date.year < 2401 {
            let next = after(date, Mode::Corrected);
            assert_eq!(day_number(next), day_number(date) + 1, "after {date}");
            assert!(next.is_valid(Mode::Corrected));
            date = next;
        }
    }

    #[test]
    fn the_listing_errs_from_august_on_and_in_1900() {
        assert_eq!(after(at(2009, 8, 30), Mode::Listing), at(2009, 9, 1));
        assert_eq!(after(at(2009, 8, 30), Mode::Corrected), at(2009, 8, 31));
        assert_eq!(after(at(2009, 9, 30), Mode::Listing), at(2009, 9, 31));
        assert_eq!(after(at(2009, 7, 31), Mode::Listing), at(2009, 8, 1));
        assert_eq!(after(at(1900, 2, 28), Mode::Listing), at(1900, 2, 29));
        assert_eq!(after(at(1900, 2, 28), Mode::Corrected), at(1900, 3, 1));
    }

    #[test]
    fn weekdays_follow_one_another_and_known_dates_have_theirs() {
        let mut date = at(1600, 1, 1);
        while date.year < 2401 {
            let next = after(date, Mode::Corrected);
            assert_eq!(next.weekday(), date.weekday() % 7 + 1, "after {date}");
            date = next;
        }
        // A Saturday, a Friday, a Thursday.
        assert_eq!(DateTime::SWITCHED_ON.weekday(), 6);
        assert_eq!(at(2009, 12, 4).weekday(), 5);
        assert_eq!(at(1970, 1, 1).weekday(), 4);
    }

    #[test]
    fn a_clock_is_read_as_it_is_shown() {
        let clock = DateTime::parse("2009-12-04 17:05:09.25");
        assert_eq!(clock.map(|c| c.to_string()).as_deref(), Some("2009-12-04 17:05:09.25"));
        let shown = |text| DateTime::parse(text).map(|c| c.to_string());
        assert_eq!(shown("2026-02-28T06:59").as_deref(), Some("2026-02-28 06:59:00.00"));
        assert_eq!(shown("7:05").as_deref(), Some("2000-01-01 07:05:00.00"));
        assert_eq!(DateTime::parse("12:30:30").map(DateTime::second_of_day), Some(45_030.0));
        for wrong in ["", "7", "07:5a", "2009-12 17:05", "2009-12-04", "1:2:3:4", "+1:00"] {
            assert_eq!(DateTime::parse(wrong), None, "{wrong}");
        }
        assert!(!DateTime::parse("25:00").unwrap().is_valid(Mode::Corrected));
    }

    #[test]
    fn a_day_has_8_640_000_ticks() {
        let mut date = at(2008, 2, 28);
        (0..8_640_000).for_each(|_| date.tick(Mode::Corrected));
        assert_eq!(date.to_string(), "2008-02-29 00:00:00.00");
    }
}
