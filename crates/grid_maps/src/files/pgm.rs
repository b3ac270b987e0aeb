//! Grey pictures, and the portable greymap that holds them.
//!
//! Source: Netpbm, "PGM Format Specification" (man page pgm(5)): P5 is binary, P2 is plain text.

use crate::{MapError, WINDOW_CELLS_MAX};

const FORMAT: &str = "PGM";

/// A grey picture, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GreyImage {
    width: usize,
    values: Vec<u8>,
    alpha: Option<Vec<u8>>,
}

impl GreyImage {
    /// A picture of the given pixels, 0 black to 255 white, row by row from the top; `alpha` is 255
    /// for opaque, one for each pixel.
    ///
    /// # Errors
    ///
    /// [`MapError::Length`] when the numbers of pixels do not fit the size.
    pub fn new(
        width: usize,
        height: usize,
        values: Vec<u8>,
        alpha: Option<Vec<u8>>,
    ) -> Result<Self, MapError> {
        let expected = width.saturating_mul(height);
        for found in [values.len(), alpha.as_ref().map_or(expected, Vec::len)] {
            if found != expected {
                let (format, unit) = ("picture", "pixels");
                return Err(MapError::Length { format, found, expected, unit });
            }
        }
        Ok(Self { width, values, alpha })
    }

    /// Pixels of a row.
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.values.len().checked_div(self.width).unwrap_or(0)
    }

    /// All pixels, row by row from the top.
    pub fn values(&self) -> &[u8] {
        &self.values
    }

    /// How opaque each pixel is, if the picture says so.
    pub fn alpha(&self) -> Option<&[u8]> {
        self.alpha.as_deref()
    }
}

/// Writes P5 with 255 for white; what the picture says of opacity is lost.
pub fn write_pgm(image: &GreyImage) -> Vec<u8> {
    let mut bytes = format!("P5\n{} {}\n255\n", image.width(), image.height()).into_bytes();
    bytes.extend_from_slice(image.values());
    bytes
}

/// Reads P5 or P2 with comments; pictures whose white is not 255 are scaled to it.
///
/// # Errors
///
/// [`MapError::Text`] for anything but a PGM of at most 8 bits, with the line;
/// [`MapError::Length`] for a file that is cut short or goes on; [`MapError::TooLarge`] above
/// [`WINDOW_CELLS_MAX`] pixels. Memory is taken only for pixels that are there.
pub fn read_pgm(bytes: &[u8]) -> Result<GreyImage, MapError> {
    let mut reader = Reader { bytes, at: 0, line: 1 };
    let plain = match bytes.get(..2) {
        Some(b"P5") => false,
        Some(b"P2") => true,
        _ => {
            let found =
                String::from_utf8_lossy(&bytes[..bytes.len().min(8)]).escape_debug().to_string();
            let found =
                if bytes.is_empty() { "an empty file".to_owned() } else { format!("`{found}`") };
            return Err(reader.error(found, "P5 or P2, the mark of a grey PGM picture"));
        }
    };
    reader.at = 2;
    let width = reader.number("the width", 1..=WINDOW_CELLS_MAX)?;
    let height = reader.number("the height", 1..=WINDOW_CELLS_MAX)?;
    let n_pixels = width.saturating_mul(height);
    if n_pixels > WINDOW_CELLS_MAX {
        return Err(MapError::TooLarge { width, height, n_max: WINDOW_CELLS_MAX });
    }
    let white = reader.number("the value of white", 1..=65_535)?;
    if white > 255 {
        let expected = "at most 255 for white: save the picture with 8 bits";
        return Err(reader.error(format!("{white}"), expected));
    }
    let values = if plain {
        reader.plain_pixels(n_pixels, white)?
    } else {
        reader.binary_pixels(n_pixels)?
    };
    let scale = |value: u8| {
        let value = usize::from(value).min(white);
        ((value * 255 + white / 2) / white) as u8
    };
    let values = if white == 255 { values } else { values.into_iter().map(scale).collect() };
    GreyImage::new(width, height, values, None)
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl Reader<'_> {
    fn error(&self, found: String, expected: impl Into<String>) -> MapError {
        MapError::Text { format: FORMAT, line: self.line, found, expected: expected.into() }
    }

    /// The next number of the head or of a plain picture; comments go from `#` to the end of a
    /// line.
    fn number(
        &mut self,
        what: &str,
        allowed: std::ops::RangeInclusive<usize>,
    ) -> Result<usize, MapError> {
        self.skip_blanks();
        let start = self.at;
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_digit) {
            self.at += 1;
        }
        let digits = &self.bytes[start..self.at];
        // No number in such a file needs more digits; longer ones are out of range anyway.
        let value = digits.iter().take(12).fold(0_usize, |n, d| n * 10 + usize::from(d - b'0'));
        if digits.is_empty() || !allowed.contains(&value) {
            let found = match (digits, self.bytes.get(self.at)) {
                ([], None) => "the end of the file".to_owned(),
                ([], Some(&byte)) => format!("`{}`", byte.escape_ascii()),
                (digits, _) => {
                    String::from_utf8_lossy(&digits[..digits.len().min(20)]).into_owned()
                }
            };
            let (low, high) = (allowed.start(), allowed.end());
            return Err(self.error(found, format!("{what}, a number from {low} to {high}")));
        }
        Ok(value)
    }

    fn skip_blanks(&mut self) {
        let mut comment = false;
        while let Some(&byte) = self.bytes.get(self.at) {
            match byte {
                b'\n' => {
                    self.line += 1;
                    comment = false;
                }
                b'#' => comment = true,
                _ if comment || byte.is_ascii_whitespace() => {}
                _ => return,
            }
            self.at += 1;
        }
    }

    fn binary_pixels(&self, n_pixels: usize) -> Result<Vec<u8>, MapError> {
        // Exactly one blank ends the head.
        let pixels = self.bytes.get(self.at + 1..).unwrap_or(&[]);
        let (found, expected) = (pixels.len(), n_pixels);
        let rest = pixels.get(n_pixels..);
        if !rest.is_some_and(|rest| rest.iter().all(u8::is_ascii_whitespace)) {
            return Err(MapError::Length { format: FORMAT, found, expected, unit: "pixels" });
        }
        Ok(pixels[..n_pixels].to_vec())
    }

    fn plain_pixels(&mut self, n_pixels: usize, white: usize) -> Result<Vec<u8>, MapError> {
        // Each pixel takes at least two bytes, so what the head announces is checked first.
        let expected = n_pixels;
        let too_short =
            |found| MapError::Length { format: FORMAT, found, expected, unit: "pixels" };
        if self.bytes.len() - self.at.min(self.bytes.len()) < 2 * n_pixels {
            return Err(too_short((self.bytes.len() - self.at) / 2));
        }
        let mut values = Vec::with_capacity(n_pixels);
        for _ in 0..n_pixels {
            self.skip_blanks();
            if self.at == self.bytes.len() {
                return Err(too_short(values.len()));
            }
            values.push(self.number("a pixel", 0..=white)? as u8);
        }
        self.skip_blanks();
        if self.at < self.bytes.len() {
            let rest = self.bytes[self.at].escape_ascii();
            return Err(self.error(format!("`{rest}` after the last pixel"), "the end of the file"));
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;
    use proptest::{collection::vec, prelude::*};

    fn image(width: usize, values: &[u8]) -> GreyImage {
        GreyImage::new(width, values.len() / width, values.to_vec(), None).unwrap()
    }

    #[test]
    fn both_forms_are_read_with_their_comments() {
        let binary = b"P5 # made by hand\n# 3 by 2\n3 2\n255\n\x00\x7f\xff\x0a\x20\x30";
        assert_eq!(read_pgm(binary).unwrap(), image(3, &[0, 127, 255, 10, 32, 48]));
        let plain = b"P2\n3\n2 # rows\n15\n0 7 15\n#middle\n1 2\n 3\n";
        assert_eq!(read_pgm(plain).unwrap(), image(3, &[0, 119, 255, 17, 34, 51]));
        // Some programs end every file with a line end.
        assert_eq!(read_pgm(b"P5\n1 1\n255\n\xcd\n").unwrap(), image(1, &[205]));
    }

    #[test]
    fn broken_files_are_refused_with_line_and_reason() {
        let cases: [&[u8]; 16] = [
            b"",
            b"P6\n1 1\n255\n",
            b"P5\n# a\n12 x",
            b"P5\n0 4\n255\n",
            b"P5\n4",
            b"P5\n4 4\n65535\n",
            b"P5\n4 4\n0\n",
            b"P5\n2 2\n255\nabc",
            b"P5\n2 2\n255\nabcdefg",
            b"P5\n2 2\n255",
            b"P5\n99999999999999999999 2\n255\n",
            b"P5\n100000 100000\n255\n",
            b"P2\n2 2\n9\n1 2 3\n11111",
            b"P2\n2 2\n9\n1 2 3      ",
            b"P2\n20000 2\n9\n1 2 3",
            b"P2\n2 1\n9\n1 2 3",
        ];
        let messages = cases.map(|case| read_pgm(case).unwrap_err().to_string());
        expect![[r##"
            PGM, line 1: found an empty file, expected P5 or P2, the mark of a grey PGM picture
            PGM, line 1: found `P6\n1 1\n2`, expected P5 or P2, the mark of a grey PGM picture
            PGM, line 3: found `x`, expected the height, a number from 1 to 268435456
            PGM, line 2: found 0, expected the width, a number from 1 to 268435456
            PGM, line 2: found the end of the file, expected the height, a number from 1 to 268435456
            PGM, line 3: found 65535, expected at most 255 for white: save the picture with 8 bits
            PGM, line 3: found 0, expected the value of white, a number from 1 to 65535
            PGM: 3 pixels, expected 4: the file is damaged or cut short
            PGM: 7 pixels, expected 4: the file is damaged or cut short
            PGM: 0 pixels, expected 4: the file is damaged or cut short
            PGM, line 2: found 99999999999999999999, expected the width, a number from 1 to 268435456
            100000 × 100000 cells at once: at most 268435456 cells; take a smaller piece, or look for readings or poses that lie far outside
            PGM, line 5: found 11111, expected a pixel, a number from 0 to 9
            PGM: 3 pixels, expected 4: the file is damaged or cut short
            PGM: 3 pixels, expected 40000: the file is damaged or cut short
            PGM, line 4: found `3` after the last pixel, expected the end of the file
        "##]]
        .assert_eq(&(messages.join("\n") + "\n"));
    }

    #[test]
    fn a_picture_has_as_many_pixels_as_it_says() {
        assert!(GreyImage::new(2, 2, vec![0; 3], None).is_err());
        assert!(GreyImage::new(2, 2, vec![0; 4], Some(vec![0; 5])).is_err());
        assert_eq!(GreyImage::new(0, 0, vec![], None).unwrap().height(), 0);
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(width in 1..9_usize, values in vec(any::<u8>(), 72)) {
            let picture = image(width, &values[..8 * width]);
            prop_assert_eq!(read_pgm(&write_pgm(&picture)).unwrap(), picture);
        }

        #[test]
        fn no_bytes_make_it_panic(bytes in vec(any::<u8>(), 0..40), plain: bool) {
            let head: &[u8] = if plain { b"P2\n2 2\n9\n" } else { b"P5 " };
            let _result = read_pgm(&[head, &bytes].concat());
            let _result = read_pgm(&bytes);
        }
    }
}
