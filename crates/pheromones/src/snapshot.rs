//! Snapshots: a whole field as text, to save, hand on and restore exactly.

use std::fmt::Write as _;

use crate::{Field, FieldError, VALUE_MAX, deposit::Deposit};

/// The first line of every snapshot: name and version of the format.
pub const SNAPSHOT_HEADER: &str = "cairn pheromone snapshot 1";

/// A text that is no snapshot, or a damaged one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// Another format or version.
    #[error("line 1: found `{found}`, a snapshot begins with `{SNAPSHOT_HEADER}`")]
    Header {
        /// The first line, at most 60 characters of it.
        found: String,
    },
    /// A line that does not say what it should.
    #[error("line {line}: expected {expected}, found `{found}`")]
    Line {
        /// From 1.
        line: usize,
        /// What should stand there.
        expected: &'static str,
        /// What does, at most 60 characters of it.
        found: String,
    },
    /// All lines are well formed, but not those that were written.
    #[error(
        "the snapshot is damaged: its check value is {found:016x}, its contents give {computed:016x}"
    )]
    Checksum {
        /// What the last line says.
        found: u64,
        /// What the contents give.
        computed: u64,
    },
    /// Sizes that make no valid field.
    #[error(transparent)]
    Field(#[from] FieldError),
}

impl Field {
    /// The whole field as text: size, deposits with their ages, values, and a check value over all of it.
    ///
    /// [`from_snapshot`](Self::from_snapshot) gives back an equal field, which evaporates on as this one
    /// would have. Source of the idea: the thesis, §5.3.1.4, snapshots of pheromone configurations.
    pub fn to_snapshot(&self) -> String {
        let mut text = format!(
            "{SNAPSHOT_HEADER}\nwidth {}\nheight {}\ncell_size_m {}\ndeposits {}\n",
            self.width(),
            self.height(),
            self.cell_size_m(),
            self.deposits.len()
        );
        for (&cell_index, Deposit { base, peak, age_ns }) in &self.deposits {
            // Writing to a string cannot fail.
            writeln!(text, "deposit {cell_index} {base} {peak} {age_ns}").ok();
        }
        text.push_str("values\n");
        text.push_str(&self.to_text());
        let check = check_value(&text);
        writeln!(text, "check {check:016x}").ok();
        text
    }

    /// Reads what [`to_snapshot`](Self::to_snapshot) wrote. Windows line ends are accepted.
    ///
    /// # Errors
    ///
    /// [`SnapshotError`] for any change of the text, however small.
    pub fn from_snapshot(text: &str) -> Result<Self, SnapshotError> {
        let text = text.replace("\r\n", "\n");
        let mut lines = Lines { rest: text.lines(), line: 0 };
        let header = lines.next_or_empty();
        if header != SNAPSHOT_HEADER {
            return Err(SnapshotError::Header { found: shortened(header) });
        }
        let [width] = lines.numbers("width", "`width` and a whole number")?;
        let [height] = lines.numbers("height", "`height` and a whole number")?;
        let cell_size_m = lines.cell_size_m()?;
        let mut field = Self::new(width as usize, height as usize, cell_size_m)?;
        lines.read_deposits(&mut field)?;
        if lines.next_or_empty() != "values" {
            return Err(lines.wrong("`values`"));
        }
        for row in 0..field.height() {
            lines.read_row(&mut field, row)?;
        }
        let check_line = lines.next_or_empty();
        let found = check_line.strip_prefix("check ");
        let hex = found.filter(|hex| hex.len() == 16 && hex.bytes().all(is_lower_hex));
        let Some(found) = hex.and_then(|hex| u64::from_str_radix(hex, 16).ok()) else {
            return Err(lines.wrong("`check` and sixteen hexadecimal digits"));
        };
        let until = text.rfind("check ").unwrap_or(text.len());
        let computed = check_value(&text[..until]);
        if found != computed {
            return Err(SnapshotError::Checksum { found, computed });
        }
        if lines.rest.next().is_some() {
            lines.line += 1;
            return Err(lines.wrong("the end"));
        }
        Ok(field)
    }
}

/// The lines of a snapshot, counted.
struct Lines<'a> {
    rest: std::str::Lines<'a>,
    line: usize,
}

impl<'a> Lines<'a> {
    fn next_or_empty(&mut self) -> &'a str {
        self.line += 1;
        self.rest.next().unwrap_or("")
    }

    /// `keyword` and `N` whole numbers, nothing else.
    fn numbers<const N: usize>(
        &mut self,
        keyword: &str,
        expected: &'static str,
    ) -> Result<[u64; N], SnapshotError> {
        let found = self.next_or_empty();
        let mut words = found.split(' ');
        let mut numbers = [0; N];
        let mut sound = words.next() == Some(keyword);
        for number in &mut numbers {
            match words.next().map(str::parse) {
                Some(Ok(value)) => *number = value,
                _ => sound = false,
            }
        }
        if sound && words.next().is_none() {
            Ok(numbers)
        } else {
            Err(self.line_error(expected, found))
        }
    }

    fn cell_size_m(&mut self) -> Result<f64, SnapshotError> {
        let found = self.next_or_empty();
        let number = found.strip_prefix("cell_size_m ").and_then(|number| number.parse().ok());
        number.ok_or_else(|| self.line_error("`cell_size_m` and a number", found))
    }

    fn read_deposits(&mut self, field: &mut Field) -> Result<(), SnapshotError> {
        let [n_deposits] = self.numbers("deposits", "`deposits` and how many")?;
        for _ in 0..n_deposits {
            let expected =
                "`deposit` with cell index, base, peak (together at most 127) and age in ns";
            let [cell_index, base, peak, age_ns] = self.numbers("deposit", expected)?;
            let in_field = (cell_index as usize) < field.values().len();
            let sound = in_field && peak >= 1 && base.saturating_add(peak) <= u64::from(VALUE_MAX);
            if !sound {
                return Err(
                    self.line_error(expected, &format!("{cell_index} {base} {peak} {age_ns}"))
                );
            }
            // Both are at most 127 now.
            let deposit = Deposit { base: base as u8, peak: peak as u8, age_ns };
            field.deposits.insert(cell_index as usize, deposit);
        }
        Ok(())
    }

    fn read_row(&mut self, field: &mut Field, row: usize) -> Result<(), SnapshotError> {
        let found = self.next_or_empty();
        let mut n_values = 0;
        for (col, word) in found.split_ascii_whitespace().enumerate() {
            let value = word.parse().ok().filter(|_| col < field.width());
            let Some(value) = value else {
                return Err(self.line_error("one value of 0 to 255 per column", found));
            };
            field.put(row * field.width() + col, value);
            n_values += 1;
        }
        if n_values == field.width() {
            Ok(())
        } else {
            Err(self.line_error("one value of 0 to 255 per column", found))
        }
    }

    fn wrong(&self, expected: &'static str) -> SnapshotError {
        SnapshotError::Line { line: self.line, expected, found: "something else".to_owned() }
    }

    fn line_error(&self, expected: &'static str, found: &str) -> SnapshotError {
        SnapshotError::Line { line: self.line, expected, found: shortened(found) }
    }
}

fn is_lower_hex(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'a'..=b'f')
}

fn shortened(text: &str) -> String {
    text.chars().take(60).collect()
}

/// FNV-1a, 64 bits, over the bytes of a text.
fn check_value(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::{Expect, expect};
    use proptest::prelude::*;
    use std::time::Duration;

    fn small() -> Field {
        let mut field = Field::from_text("0 1 200\n127 0 0", 0.25).unwrap();
        field.deposit(0, 0, 5).unwrap();
        field.deposit(1, 0, 2).unwrap();
        field.evaporate(Duration::from_millis(1500), Duration::from_secs(10));
        field
    }

    #[test]
    fn a_snapshot_can_be_read_by_people() {
        expect![[r#"
            cairn pheromone snapshot 1
            width 3
            height 2
            cell_size_m 0.25
            deposits 2
            deposit 0 0 5 1500000000
            deposit 1 1 2 1500000000
            values
              5   3 200
            127   0   0
            check 677de768470447d9
        "#]]
        .assert_eq(&small().to_snapshot());
    }

    /// The published check value of 64-bit FNV-1a for "foobar".
    #[test]
    fn the_check_value_is_the_published_one() {
        assert_eq!(check_value("foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn a_restored_field_evaporates_on_as_the_saved_one() {
        let (mut saved, lifetime) = (small(), Duration::from_secs(10));
        let mut restored = Field::from_snapshot(&saved.to_snapshot()).unwrap();
        for _ in 0..12 {
            assert_eq!(saved, restored);
            saved.evaporate(Duration::from_millis(999), lifetime);
            restored.evaporate(Duration::from_millis(999), lifetime);
        }
        assert_eq!(restored.n_deposits(), 0);
    }

    #[test]
    fn windows_line_ends_do_no_harm() {
        let text = small().to_snapshot().replace('\n', "\r\n");
        assert_eq!(Field::from_snapshot(&text).unwrap(), small());
    }

    fn check_damage(from: &str, to: &str, expected: &Expect) {
        let text = small().to_snapshot();
        assert!(text.contains(from), "{text}");
        let error = Field::from_snapshot(&text.replacen(from, to, 1)).unwrap_err();
        expected.assert_eq(&error.to_string());
    }

    #[test]
    fn damage_is_described() {
        check_damage(
            "snapshot 1",
            "snapshot 2",
            &expect![
                "line 1: found `cairn pheromone snapshot 2`, a snapshot begins with `cairn pheromone snapshot 1`"
            ],
        );
        check_damage(
            "width 3",
            "width three",
            &expect!["line 2: expected `width` and a whole number, found `width three`"],
        );
        check_damage(
            "width 3",
            "width 4",
            &expect!["line 9: expected one value of 0 to 255 per column, found `  5   3 200`"],
        );
        check_damage(
            "width 3",
            "width 0",
            &expect![
                "a pheromone field of 0 x 2 cells: each side must be at least 1 and the whole at most 67108864 cells; use larger cells"
            ],
        );
        check_damage(
            "cell_size_m 0.25",
            "cell_size_m NaN",
            &expect!["pheromone cell size NaN m: must be from 0.001 to 100 m"],
        );
        check_damage(
            "deposits 2",
            "deposits 3",
            &expect![
                "line 8: expected `deposit` with cell index, base, peak (together at most 127) and age in ns, found `values`"
            ],
        );
        check_damage(
            "127",
            "126",
            &expect![
                "the snapshot is damaged: its check value is 677de768470447d9, its contents give f3a0ffaf40236454"
            ],
        );
        check_damage(
            "127",
            "327",
            &expect!["line 10: expected one value of 0 to 255 per column, found `327   0   0`"],
        );
        check_damage(
            "check ",
            "czech ",
            &expect![
                "line 11: expected `check` and sixteen hexadecimal digits, found `something else`"
            ],
        );
    }

    proptest! {
        #[test]
        fn every_field_survives(
            (width, height) in (1_usize..9, 1_usize..9),
            cell_size_m in 0.001..2.0,
            values in proptest::collection::vec(any::<u8>(), 64),
            deposits in proptest::collection::vec((0_usize..8, 0_usize..8, any::<u8>()), 0..9),
            millis in 0_u64..9000,
        ) {
            let mut field = Field::new(width, height, cell_size_m).unwrap();
            for (i, &value) in values.iter().take(width * height).enumerate() {
                field.set(i % width, i / width, value).unwrap();
            }
            for (col, row, amount) in deposits {
                field.deposit(col, row, amount).ok();
            }
            field.evaporate(Duration::from_millis(millis), Duration::from_secs(10));
            prop_assert_eq!(Field::from_snapshot(&field.to_snapshot()).unwrap(), field);
        }

        #[test]
        fn any_changed_byte_is_noticed(at in any::<proptest::sample::Index>(), byte in 32_u8..127) {
            let mut bytes = small().to_snapshot().into_bytes();
            // The last line end may go without harm.
            let n_bytes = bytes.len() - 1;
            let place = &mut bytes[at.index(n_bytes)];
            prop_assume!(*place != byte);
            *place = byte;
            prop_assert!(Field::from_snapshot(&String::from_utf8(bytes).unwrap()).is_err());
        }

        #[test]
        fn no_text_makes_it_panic(text in "(cairn pheromone snapshot 1\n)?[a-z0-9 \n.]{0,80}") {
            prop_assert!(Field::from_snapshot(&text).is_err());
        }
    }
}
