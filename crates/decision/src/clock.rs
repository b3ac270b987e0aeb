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
    fn a_day_has_8_640_000_ticks() {
        let mut date = at(2008, 2, 28);
        (0..8_640_000).for_each(|_| date.tick(Mode::Corrected));
        assert_eq!(date.to_string(), "2008-02-29 00:00:00.00");
    }
}
