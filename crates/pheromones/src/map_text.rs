//! The map file: decimal numbers, separated by anything.

use std::fmt::Write as _;

use crate::{Field, FieldError};

/// A text that is no pheromone map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapTextError {
    /// A number beyond a byte.
    #[error(
        "line {line}, column {column}: the value {value} is too large; cells hold 0 (empty), 1 to 127 \
         (source) or 128 to 255 (reserved)"
    )]
    TooLarge {
        /// From 1.
        line: usize,
        /// Of the number's first digit, in characters from 1.
        column: usize,
        /// What the text says; 2⁶⁴ − 1 for anything larger.
        value: u64,
    },
    /// Lines of unequal length whose numbers do not fill a square either.
    #[error(
        "line {line}, column {column}: this row has {n_values} values, the first one has {width}, and all \
         {n_total} values do not fill a square; give every row the same number of values"
    )]
    Ragged {
        /// The first line that differs, from 1.
        line: usize,
        /// Where its last value stands, in characters from 1.
        column: usize,
        /// Values on that line.
        n_values: usize,
        /// Values on the first line that has any.
        width: usize,
        /// Values in the text.
        n_total: usize,
    },
    /// No number at all.
    #[error("line {line}, column {column}: the text ends without a single number")]
    Empty {
        /// The last line, from 1.
        line: usize,
        /// Its end, in characters from 1.
        column: usize,
    },
    /// Numbers that make no valid field.
    #[error(transparent)]
    Field(#[from] FieldError),
}

impl Field {
    /// Reads a map: decimal numbers separated by any other characters.
    ///
    /// Lines with equally many numbers are rows, whatever their number. Otherwise the line structure is
    /// ignored and the numbers fill a square, first row on top, as in the thesis's server. A minus sign
    /// separates like any other character. O(text).
    ///
    /// # Errors
    ///
    /// [`MapTextError`] with line and column.
    ///
    /// Source: the thesis, Annex B1, `read_map()`. Differences: a count that is no square is an error
    /// there unnoticed, here a rectangle or an error; values beyond 255 are refused.
    pub fn from_text(text: &str, cell_size_m: f64) -> Result<Self, MapTextError> {
        let table = NumberTable::read(text)?;
        let (width, height) = table.shape()?;
        let mut field = Self::new(width, height, cell_size_m)?;
        for (cell_index, &value) in table.values.iter().enumerate() {
            field.put(cell_index, value);
        }
        Ok(field)
    }

    /// The map as text: one row a line, columns aligned, first row on top. Reads back to the same values.
    pub fn to_text(&self) -> String {
        let digits = self.values().iter().max().map_or(1, |v| v.to_string().len());
        let mut text = String::with_capacity(self.values().len() * (digits + 1));
        for row in self.values().chunks(self.width()) {
            for (col, value) in row.iter().enumerate() {
                let gap = if col == 0 { "" } else { " " };
                // Writing to a string cannot fail.
                write!(text, "{gap}{value:>digits$}").ok();
            }
            text.push('\n');
        }
        text
    }
}

/// All numbers of a text and how they stand in lines.
struct NumberTable {
    values: Vec<u8>,
    /// Per line that has numbers: line, column of its last number, how many.
    rows: Vec<(usize, usize, usize)>,
    end: (usize, usize),
}

impl NumberTable {
    fn read(text: &str) -> Result<Self, MapTextError> {
        let mut table = Self { values: Vec::new(), rows: Vec::new(), end: (1, 1) };
        for (line_index, line) in text.lines().enumerate() {
            let n_before = table.values.len();
            let mut last_column = 1;
            let mut number: Option<Number> = None;
            // A blank after the end closes a number that ends the line.
            for (char_index, c) in line.chars().chain([' ']).enumerate() {
                if let Some(digit) = c.to_digit(10) {
                    number.get_or_insert(Number::starting_at(char_index + 1)).push(digit);
                } else if let Some(number) = number.take() {
                    last_column = number.column;
                    table.values.push(number.value(line_index + 1)?);
                }
            }
            let n_values = table.values.len() - n_before;
            if n_values > 0 {
                table.rows.push((line_index + 1, last_column, n_values));
            }
            table.end = (line_index + 1, line.chars().count() + 1);
        }
        Ok(table)
    }

    /// Width and height.
    fn shape(&self) -> Result<(usize, usize), MapTextError> {
        let (line, column) = self.end;
        let &(_, _, width) = self.rows.first().ok_or(MapTextError::Empty { line, column })?;
        let ragged = self.rows.iter().find(|&&(_, _, n_values)| n_values != width);
        let n_total = self.values.len();
        let side = n_total.isqrt();
        match ragged {
            // One long line is a square if it can be: so the listing reads it.
            None if self.rows.len() == 1 && side * side == n_total => Ok((side, side)),
            None => Ok((width, self.rows.len())),
            Some(_) if side * side == n_total => Ok((side, side)),
            Some(&(line, column, n_values)) => {
                Err(MapTextError::Ragged { line, column, n_values, width, n_total })
            }
        }
    }
}

/// One number being read.
struct Number {
    column: usize,
    value: u64,
}

impl Number {
    fn starting_at(column: usize) -> Self {
        Self { column, value: 0 }
    }

    fn push(&mut self, digit: u32) {
        self.value = self.value.saturating_mul(10).saturating_add(u64::from(digit));
    }

    fn value(&self, line: usize) -> Result<u8, MapTextError> {
        let too_large = |_| MapTextError::TooLarge { line, column: self.column, value: self.value };
        u8::try_from(self.value).map_err(too_large)
    }
}
