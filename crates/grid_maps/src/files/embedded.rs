//! Pictures within texts: a map's YAML whose `image` is not a file's name but the picture itself.
//!
//! So a map is one text, which can stand in a mission or at the head of a recording.
//!
//! Source: RFC 2397, "The data URL scheme"; RFC 4648, "The Base16, Base32, and Base64 Data
//! Encodings", section 4.

use super::{GreyImage, MapYaml, read_pgm, read_png, write_png};
use crate::MapError;

const FORMAT: &str = "picture within the text";
const PNG: &str = "data:image/png;base64,";
const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Reads a picture of a map: PNG or PGM, told apart by how they begin.
///
/// # Errors
///
/// Those of [`read_png`] and [`read_pgm`].
pub fn read_picture(bytes: &[u8]) -> Result<GreyImage, MapError> {
    if bytes.starts_with(b"\x89PNG") { read_png(bytes) } else { read_pgm(bytes) }
}

impl MapYaml {
    /// The same description with the picture in it, as PNG.
    ///
    /// # Errors
    ///
    /// Those of [`write_png`].
    pub fn with_picture(&self, picture: &GreyImage) -> Result<Self, MapError> {
        Ok(Self { image: format!("{PNG}{}", base64(&write_png(picture)?)), ..self.clone() })
    }

    /// The picture that the text itself holds; `None` where `image` is a file's name.
    ///
    /// # Errors
    ///
    /// [`MapError::Text`] for a `data:` that is no PNG in base64, and those of [`read_png`].
    pub fn picture(&self) -> Option<Result<GreyImage, MapError>> {
        self.image.starts_with("data:").then(|| {
            let refused = |expected: &str| MapError::Text {
                format: FORMAT,
                line: 1,
                found: format!("`{}…`", self.image.chars().take(40).collect::<String>()),
                expected: expected.to_owned(),
            };
            let digits = self.image.strip_prefix(PNG);
            let digits =
                digits.ok_or_else(|| refused("`data:image/png;base64,` and the picture"))?;
            read_png(&bytes(digits).ok_or_else(|| refused("base64 without blanks"))?)
        })
    }
}

fn base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let at = |i: usize| u32::from(group.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= group.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

/// `None` for what is no base64 with its padding.
fn bytes(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=');
    let n_padding = text.len() - digits.len();
    if !text.len().is_multiple_of(4) || n_padding > 2 {
        return None;
    }
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    for group in digits.as_bytes().chunks(4) {
        let mut bits = 0_u32;
        for digit in group {
            bits = bits << 6 | u32::from(value_of(*digit)?);
        }
        bits <<= 6 * (4 - group.len());
        let n = group.len().checked_sub(1).filter(|n| *n > 0)?;
        bytes.extend_from_slice(&bits.to_be_bytes()[1..=n]);
    }
    Some(bytes)
}

fn value_of(digit: u8) -> Option<u8> {
    Some(match digit {
        b'A'..=b'Z' => digit - b'A',
        b'a'..=b'z' => digit - b'a' + 26,
        b'0'..=b'9' => digit - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Se2;
    use proptest::{collection::vec, prelude::*};

    #[test]
    fn the_examples_of_the_rfc() {
        let pairs =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (plain, coded) in pairs {
            assert_eq!(base64(plain.as_bytes()), coded);
            assert_eq!(bytes(coded).as_deref(), Some(plain.as_bytes()));
        }
        for broken in ["Zg", "Zg=", "Z===", "====", "Zm9v ", "Zm9\n", "Zm-v", "Zm9vZ"] {
            assert_eq!(bytes(broken), None, "{broken}");
        }
    }

    proptest! {
        #[test]
        fn a_map_in_one_text_keeps_its_pixels(values in vec(any::<u8>(), 12), alpha: bool) {
            let opacity = alpha.then(|| values.iter().map(|v| v.wrapping_mul(7)).collect());
            let picture = GreyImage::new(4, 3, values, opacity).unwrap();
            let yaml = MapYaml::new("a b.pgm", 0.05, Se2::new(1.0, -2.0, 0.3));
            let text = yaml.with_picture(&picture).unwrap().to_text();
            let read = MapYaml::parse(&text).unwrap();
            prop_assert_eq!(read.picture().unwrap().unwrap(), picture);
            prop_assert_eq!(MapYaml { image: yaml.image.clone(), ..read }, yaml.clone());
            prop_assert!(yaml.picture().is_none());
        }
    }

    #[test]
    fn damaged_pictures_are_refused() {
        let refused = |image: &str| {
            let yaml = MapYaml::new(image, 0.05, Se2::new(0.0, 0.0, 0.0));
            yaml.picture().unwrap().unwrap_err().to_string()
        };
        assert!(
            refused("data:image/jpeg;base64,Zm9v").contains("expected `data:image/png;base64,`")
        );
        assert!(refused("data:image/png;base64,Zm9").contains("expected base64"));
        assert!(refused("data:image/png;base64,Zm9v").starts_with("PNG: "));
        assert!(read_picture(b"P5 1 1 255 0").is_ok() && read_picture(b"GIF89a").is_err());
    }
}
