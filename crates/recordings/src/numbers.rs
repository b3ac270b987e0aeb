//! Numbers in texts: fields of a line, and decimal seconds that keep every nanosecond.

use crate::complaints::Trouble;

/// What is wrong with a line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fault {
    pub(crate) trouble: Trouble,
    pub(crate) found: String,
}

impl Fault {
    pub(crate) fn new(trouble: Trouble, found: impl Into<String>) -> Self {
        Self { trouble, found: found.into() }
    }
}

/// A field as it may be shown: at most 24 characters, nothing that a terminal would obey.
pub(crate) fn shown(field: &str) -> String {
    let mut text: String =
        field.chars().take(24).map(|c| if c.is_control() { '?' } else { c }).collect();
    if field.chars().nth(24).is_some() {
        text.push('…');
    }
    text
}

/// Whether a number can be a length or an angle of a robot's world: finite, and at most a million kilometres in metres. What
/// is beyond would overflow sooner or later.
pub(crate) fn is_measurable(value: f64) -> bool {
    value.abs() <= 1e9
}

/// The fields of one line, taken one by one.
#[derive(Debug)]
pub(crate) struct Fields<'a> {
    words: std::str::SplitAsciiWhitespace<'a>,
    n_taken: usize,
    n_bytes: usize,
}

impl<'a> Fields<'a> {
    /// The fields of a text, separated by blanks.
    pub(crate) fn new(line: &'a str) -> Self {
        Self { words: line.split_ascii_whitespace(), n_taken: 0, n_bytes: line.len() }
    }

    /// At most so many fields can be in the line: a bound for what is allocated.
    pub(crate) fn n_max(&self) -> usize {
        self.n_bytes / 2 + 1
    }

    pub(crate) fn word(&mut self, what: &str) -> Result<&'a str, Fault> {
        let Some(word) = self.words.next() else {
            let found = format!("the line ends after {} fields, before {what}", self.n_taken);
            return Err(Fault::new(Trouble::Truncated, found));
        };
        self.n_taken += 1;
        Ok(word)
    }

    /// A number that a measured quantity can have.
    pub(crate) fn number(&mut self, what: &str) -> Result<f64, Fault> {
        let value = self.any_number(what)?;
        if is_measurable(value) {
            return Ok(value);
        }
        Err(Fault::new(Trouble::NotFinite, format!("{what} is {value}")))
    }

    /// A number, NaN and infinity too.
    pub(crate) fn any_number(&mut self, what: &str) -> Result<f64, Fault> {
        let word = self.word(what)?;
        word.parse().map_err(|_e| {
            let found = format!("field {}, {what}, is no number: {:?}", self.n_taken, shown(word));
            Fault::new(Trouble::Unreadable, found)
        })
    }

    /// A count that the line can hold.
    pub(crate) fn count(&mut self, what: &str) -> Result<usize, Fault> {
        let word = self.word(what)?;
        let Ok(count) = word.parse::<usize>() else {
            let found = format!("field {}, {what}, is no count: {:?}", self.n_taken, shown(word));
            return Err(Fault::new(Trouble::Unreadable, found));
        };
        if count > self.n_max() {
            let found = format!("{what} is {count}, more than the line has fields");
            return Err(Fault::new(Trouble::Truncated, found));
        }
        Ok(count)
    }

    /// Seconds, as nanoseconds.
    pub(crate) fn seconds_ns(&mut self, what: &str) -> Result<i64, Fault> {
        let word = self.word(what)?;
        if let Some(ns) = nanos_from_decimal(word) {
            return Ok(ns);
        }
        match word.parse::<f64>() {
            Ok(value) if !value.is_finite() => {
                Err(Fault::new(Trouble::NotFinite, format!("{what} is {value}")))
            }
            _ => {
                let field = self.n_taken;
                let found = format!("field {field}, {what}, is no time: {:?}", shown(word));
                Err(Fault::new(Trouble::Unreadable, found))
            }
        }
    }

    /// How many fields are left.
    pub(crate) fn n_left(self) -> usize {
        self.words.count()
    }
}

/// Decimal seconds as nanoseconds, rounded to the nearest (halves away from zero); `None` for what is no
/// decimal number or beyond 292 years.
///
/// Digits are never taken through an `f64`: `1464602099.941193123` keeps its last digit.
pub(crate) fn nanos_from_decimal(text: &str) -> Option<i64> {
    let (mantissa, exponent) = match text.find(['e', 'E']) {
        Some(at) => (&text[..at], text[at + 1..].parse::<i32>().ok()?),
        None => (text, 0),
    };
    let (negative, digits) = match mantissa.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, mantissa.strip_prefix('+').unwrap_or(mantissa)),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    if whole.is_empty() && fraction.is_empty() {
        return None;
    }
    // value = digits × 10^(scale), in nanoseconds.
    let mut value: i128 = 0;
    let mut dropped = 0_i64;
    let mut first_dropped = 0_u8;
    for byte in whole.bytes().chain(fraction.bytes()) {
        if !byte.is_ascii_digit() {
            return None;
        }
        if value < 10_i128.pow(30) && dropped == 0 {
            value = value * 10 + i128::from(byte - b'0');
        } else {
            if dropped == 0 {
                first_dropped = byte - b'0';
            }
            dropped += 1;
        }
    }
    if dropped > 0 && first_dropped >= 5 {
        value += 1;
    }
    let scale = i64::from(exponent) + 9 + dropped - i64::try_from(fraction.len()).ok()?;
    let value = scaled(value, scale)?;
    i64::try_from(if negative { -value } else { value }).ok()
}

/// `value` × 10^`scale`, rounded; `value` is not negative.
fn scaled(value: i128, scale: i64) -> Option<i128> {
    if value == 0 {
        return Some(0);
    }
    if scale >= 0 {
        let factor = 10_i128.checked_pow(u32::try_from(scale).ok()?)?;
        return value.checked_mul(factor);
    }
    let Some(divisor) = u32::try_from(-scale).ok().and_then(|s| 10_i128.checked_pow(s)) else {
        return Some(0);
    };
    Some(value / divisor + i128::from(value % divisor >= divisor / 2))
}

/// Nanoseconds as decimal seconds, all nine digits, such as `-0.000000001`.
pub(crate) fn decimal_from_nanos(nanos: i64) -> String {
    let sign = if nanos < 0 { "-" } else { "" };
    let n = nanos.unsigned_abs();
    format!("{sign}{}.{:09}", n / 1_000_000_000, n % 1_000_000_000)
}

/// The lines of a text of any bytes, with their numbers from 1; without `\r` at the end.
pub(crate) fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let body = bytes.strip_suffix(b"\n").unwrap_or(bytes);
    let lines = body.split(|&b| b == b'\n').map(|l| l.strip_suffix(b"\r").unwrap_or(l));
    lines.enumerate().map(|(index, line)| (index + 1, line))
}

/// The text of a line; what is no UTF-8 is no line of ours.
pub(crate) fn text(line: &[u8]) -> Result<&str, Fault> {
    std::str::from_utf8(line).map_err(|e| {
        Fault::new(Trouble::Unreadable, format!("no text from byte {} on", e.valid_up_to()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_nanosecond_survives() {
        let cases = [
            ("1464602099.941193", Some(1_464_602_099_941_193_000)),
            ("1464602099.941193123", Some(1_464_602_099_941_193_123)),
            ("1464602099.9411931235", Some(1_464_602_099_941_193_124)),
            ("1464602099.9411931234", Some(1_464_602_099_941_193_123)),
            ("-0.958593", Some(-958_593_000)),
            ("1.13486e+09", Some(1_134_860_000_000_000_000)),
            ("1.5E-3", Some(1_500_000)),
            ("+7", Some(7_000_000_000)),
            (".5", Some(500_000_000)),
            ("5.", Some(5_000_000_000)),
            ("1e-40", Some(0)),
            ("0e99", Some(0)),
            ("9223372037", None),
            ("1e400", None),
            ("", None),
            ("-", None),
            (".", None),
            ("1.2.3", None),
            ("12x", None),
            ("nan", None),
            ("1e", None),
        ];
        for (text, expected) in cases {
            assert_eq!(nanos_from_decimal(text), expected, "{text}");
        }
        let long = format!("0.{}", "9".repeat(60));
        assert_eq!(nanos_from_decimal(&long), Some(1_000_000_000));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again(nanos: i64) {
            prop_assert_eq!(nanos_from_decimal(&decimal_from_nanos(nanos)), Some(nanos));
        }

        #[test]
        fn it_agrees_with_floating_point(seconds in -4.0e9..4.0e9_f64) {
            let nanos = nanos_from_decimal(&seconds.to_string()).unwrap();
            // An f64 of 4e9 s is good to 0.5 µs.
            prop_assert!((nanos as f64 * 1e-9 - seconds).abs() < 1e-6);
        }

        #[test]
        fn no_text_makes_it_panic(text in "\\PC{0,40}") {
            let _unused = nanos_from_decimal(&text);
        }
    }

    #[test]
    fn lines_are_counted_like_an_editor_does() {
        let found: Vec<_> = lines(b"a\r\n\nb\n").collect();
        assert_eq!(found, [(1, &b"a"[..]), (2, b""), (3, b"b")]);
        assert_eq!(lines(b"x\ny").count(), 2);
    }

    #[test]
    fn a_count_beyond_the_line_is_refused() {
        let mut fields = Fields::new("4000000000 1");
        assert_eq!(fields.count("n").unwrap_err().trouble, Trouble::Truncated);
    }
}
