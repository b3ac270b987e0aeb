//! Maps as PNG: grey as the map server wants them, and coloured for people.

use std::io::Cursor;

use image::{DynamicImage, GrayAlphaImage, GrayImage, ImageFormat, ImageReader, Limits, RgbImage};

use super::GreyImage;
use crate::{MapError, Window};

/// Pixels that a side of a picture may have.
const SIDE_MAX: u32 = 1 << 16;
/// Memory that a picture may take while it is read, bytes.
const MEMORY_MAX_BYTES: u64 = 1 << 31;

/// Colours of a map for people: red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColourScheme {
    /// Certainly free.
    pub free: [u8; 3],
    /// Observed as often free as occupied.
    pub undecided: [u8; 3],
    /// Certainly occupied.
    pub occupied: [u8; 3],
    /// Never observed.
    pub unknown: [u8; 3],
}

impl Default for ColourScheme {
    /// Ink on paper on a cool table.
    fn default() -> Self {
        Self {
            free: [253, 252, 247],
            undecided: [231, 196, 145],
            occupied: [27, 38, 59],
            unknown: [206, 212, 218],
        }
    }
}

fn failed(error: &image::ImageError) -> MapError {
    MapError::Png { reason: error.to_string() }
}

/// Writes a grey picture, with its opacity if it has one.
///
/// # Errors
///
/// [`MapError::Png`] for a picture without pixels or too large for the format.
pub fn write_png(picture: &GreyImage) -> Result<Vec<u8>, MapError> {
    let (width, height) = size(picture.width(), picture.height())?;
    let wrong_size = || MapError::Png { reason: "the picture has not the size it says".to_owned() };
    let coded = if let Some(alpha) = picture.alpha() {
        let pairs = picture.values().iter().zip(alpha).flat_map(|(grey, alpha)| [*grey, *alpha]);
        let image = GrayAlphaImage::from_raw(width, height, pairs.collect());
        DynamicImage::from(image.ok_or_else(wrong_size)?)
    } else {
        let image = GrayImage::from_raw(width, height, picture.values().to_vec());
        DynamicImage::from(image.ok_or_else(wrong_size)?)
    };
    encoded(&coded)
}

/// Reads a picture of any colours as grey: the mean of red, green and blue.
///
/// # Errors
///
/// [`MapError::Png`] for anything that is no PNG, is damaged, or has more than 65 536 pixels a side
/// or needs more than 2 GB.
pub fn read_png(bytes: &[u8]) -> Result<GreyImage, MapError> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let mut limits = Limits::default();
    limits.max_image_width = Some(SIDE_MAX);
    limits.max_image_height = Some(SIDE_MAX);
    limits.max_alloc = Some(MEMORY_MAX_BYTES);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| failed(&error))?;
    let has_alpha = image.color().has_alpha();
    let image = image.into_rgba8();
    let (width, height) = image.dimensions();
    let pixels = image.as_raw().chunks_exact(4);
    let grey = |pixel: &[u8]| {
        let sum: u16 = pixel[..3].iter().map(|channel| u16::from(*channel)).sum();
        ((sum + 1) / 3) as u8
    };
    let values = pixels.clone().map(grey).collect();
    let alpha = has_alpha.then(|| pixels.map(|pixel| pixel[3]).collect());
    GreyImage::new(width as usize, height as usize, values, alpha)
}

/// Draws probabilities, NaN for unknown, in colours: the last row of the window at the top.
///
/// # Errors
///
/// [`MapError::Png`] for a window without cells or too large for the format.
pub fn write_coloured_png(
    probs: &Window<f64>,
    colours: &ColourScheme,
) -> Result<Vec<u8>, MapError> {
    let area = probs.area();
    let (width, height) = size(area.width, area.height)?;
    let rows = probs.values().chunks_exact(area.width).rev();
    let pixels = rows.flat_map(|row| row.iter().flat_map(|prob| colours.of(*prob))).collect();
    let image = RgbImage::from_raw(width, height, pixels);
    let wrong_size = || MapError::Png { reason: "the window has not the size it says".to_owned() };
    encoded(&DynamicImage::from(image.ok_or_else(wrong_size)?))
}

impl ColourScheme {
    /// The colour of a probability; of NaN the one for unknown.
    pub fn of(&self, prob: f64) -> [u8; 3] {
        if prob.is_nan() {
            return self.unknown;
        }
        let (from, to, part) = if prob < 0.5 {
            (self.free, self.undecided, 2.0 * prob)
        } else {
            (self.undecided, self.occupied, 2.0 * prob - 1.0)
        };
        let mixed = |i: usize| {
            let (from, to) = (f64::from(from[i]), f64::from(to[i]));
            (from + (to - from) * part.clamp(0.0, 1.0)).round() as u8
        };
        [mixed(0), mixed(1), mixed(2)]
    }
}

fn size(width: usize, height: usize) -> Result<(u32, u32), MapError> {
    let side = |n: usize| u32::try_from(n).ok().filter(|n| (1..=SIDE_MAX).contains(n));
    side(width).zip(side(height)).ok_or_else(|| MapError::Png {
        reason: format!("{width} × {height} pixels: each side must have from 1 to {SIDE_MAX}"),
    })
}

fn encoded(image: &DynamicImage) -> Result<Vec<u8>, MapError> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).map_err(|error| failed(&error))?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cell, CellBox};

    #[test]
    fn colours_become_their_mean() {
        let image = RgbImage::from_raw(2, 1, vec![10, 20, 60, 255, 255, 254]).unwrap();
        let bytes = encoded(&DynamicImage::from(image)).unwrap();
        let grey = read_png(&bytes).unwrap();
        assert_eq!((grey.values(), grey.alpha()), (&[30, 255][..], None));
    }

    #[test]
    fn damaged_files_are_refused() {
        let image = GreyImage::new(40, 30, (0..1200).map(|i| i as u8).collect(), None).unwrap();
        let bytes = write_png(&image).unwrap();
        assert_eq!(read_png(&bytes).unwrap(), image);
        for end in [0, 8, 20, bytes.len() / 2] {
            assert!(matches!(read_png(&bytes[..end]), Err(MapError::Png { .. })), "{end}");
        }
        assert!(read_png(b"P5\n1 1\n255\n0").is_err());
        assert!(write_png(&GreyImage::new(0, 0, vec![], None).unwrap()).is_err());
    }

    #[test]
    fn the_coloured_picture_shows_probabilities() {
        let colours = ColourScheme::default();
        assert_eq!(colours.of(0.0), colours.free);
        assert_eq!(colours.of(0.5), colours.undecided);
        assert_eq!(colours.of(1.0), colours.occupied);
        assert_eq!(colours.of(f64::NAN), colours.unknown);
        assert_eq!(colours.of(7.0), colours.occupied);
        let area = CellBox { min: Cell::new(0, 0), width: 1, height: 2 };
        let probs = Window::from_values(area, vec![0.0, 1.0]).unwrap();
        let bytes = write_coloured_png(&probs, &colours).unwrap();
        let image = image::load_from_memory(&bytes).unwrap().into_rgb8();
        assert_eq!(image.get_pixel(0, 0).0, colours.occupied);
        assert_eq!(image.get_pixel(0, 1).0, colours.free);
    }
}
