//! Maps as ROS's map server keeps them: a grey picture and a small text.
//!
//! With x the grey of a pixel, its occupancy is p = (255 − x) / 255, or x / 255 when the text says
//! `negate`. Then
//!
//! | mode | p > `occupied_thresh` | p < `free_thresh` | else |
//! | --- | --- | --- | --- |
//! | trinary | 100 | 0 | −1 |
//! | scale | 100 | 0 | 100 · (p − free) / (occupied − free), rounded; −1 where transparent |
//! | raw | x from 0 to 100 is the value, other greys are −1; `negate` and thresholds do not count | | |
//!
//! Source: documentation of ROS's package `map_server`, "Map format", and the behaviour of
//! `nav2_map_server`. Where they differ this follows the latter: the older server has `negate`
//! turn raw greys too, and maps the middle of scale to 1 … 99. Differences: opacity counts in
//! scale only; nav2 lets it brighten the pixels of trinary pictures.

use geometry::Se2;

use super::{GreyImage, MapYaml, Mode};
use crate::{
    Cell, CellBox, EvidenceModel, Lattice, LogOddsMap, MapError, State, Thresholds, Window,
    logodds_of,
};

/// Greys of a trinary picture.
const OCCUPIED_GREY: u8 = 0;
const UNKNOWN_GREY: u8 = 205;
const FREE_GREY: u8 = 254;

/// The value of cells that nobody observed.
pub const UNKNOWN_PERCENT: i8 = -1;

/// A map that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct ServedMap {
    /// Where the lower left corner of cell (0, 0) lies, and how the picture is turned about it.
    pub map_from_picture: Se2,
    /// Side of a cell, metres.
    pub resolution_m: f64,
    /// Occupancy, percent from 0 to 100, or [`UNKNOWN_PERCENT`]; cell (0, 0) is the lower left.
    pub occupancy: Window<i8>,
}

/// What the picture and the text mean together. O(pixels).
///
/// # Errors
///
/// [`MapError::Resolution`], [`MapError::Origin`] and [`MapError::TooLarge`]. A text from
/// [`MapYaml::parse`] has no other faults.
pub fn read(image: &GreyImage, yaml: &MapYaml) -> Result<ServedMap, MapError> {
    Lattice::new(yaml.origin.position(), yaml.resolution_m)?;
    let area = CellBox { min: Cell::new(0, 0), width: image.width(), height: image.height() };
    // A grey means the same everywhere.
    let meanings: Vec<i8> = (0..=255_u8).map(|grey| percent_of(grey, yaml)).collect();
    let mut occupancy = Window::filled(area, UNKNOWN_PERCENT)?;
    let width = image.width().max(1);
    let rows = image.values().chunks_exact(width);
    for (y, row) in rows.rev().enumerate() {
        for (to, grey) in occupancy.row_mut(y as i32).iter_mut().zip(row) {
            *to = meanings[usize::from(*grey)];
        }
    }
    if let (Mode::Scale, Some(alpha)) = (yaml.mode, image.alpha()) {
        for (y, row) in alpha.chunks_exact(width).rev().enumerate() {
            let transparent = |(to, alpha): (_, &u8)| (*alpha < 255).then_some(to);
            occupancy
                .row_mut(y as i32)
                .iter_mut()
                .zip(row)
                .filter_map(transparent)
                .for_each(|to| *to = UNKNOWN_PERCENT);
        }
    }
    let (map_from_picture, resolution_m) = (yaml.origin, yaml.resolution_m);
    Ok(ServedMap { map_from_picture, resolution_m, occupancy })
}

/// Draws verdicts: occupied black, free nearly white, unknown grey 205.
///
/// `image` is the file name that the text gives the picture; `lattice` says where cells lie.
///
/// # Errors
///
/// [`MapError::Empty`] for a window without cells.
pub fn draw_states(
    states: &Window<State>,
    lattice: &Lattice,
    image: &str,
) -> Result<(GreyImage, MapYaml), MapError> {
    let grey = |state| match state {
        State::Occupied => OCCUPIED_GREY,
        State::Free => FREE_GREY,
        State::Unknown => UNKNOWN_GREY,
    };
    let yaml = described(states.area(), lattice, image, Mode::Trinary);
    Ok((picture(states, grey, None)?, yaml))
}

/// Draws probabilities, NaN for unknown, in any mode; in trinary with the given thresholds.
///
/// In scale the grey has steps of 1/255, and unknown cells are half-way grey and transparent: a
/// PNG keeps that, a PGM does not and makes them 0.5. In raw there are whole percents.
///
/// # Errors
///
/// [`MapError::Empty`] for a window without cells.
pub fn draw_probs(
    probs: &Window<f64>,
    lattice: &Lattice,
    image: &str,
    mode: Mode,
    thresholds: &Thresholds,
) -> Result<(GreyImage, MapYaml), MapError> {
    let yaml = described(probs.area(), lattice, image, mode);
    let picture = match mode {
        Mode::Trinary => {
            let states = probs.map(|prob| thresholds.state_of(prob));
            return draw_states(&states, lattice, image);
        }
        Mode::Raw => {
            let grey = |prob: f64| if prob.is_nan() { 255 } else { (100.0 * prob).round() as u8 };
            picture(probs, grey, None)?
        }
        Mode::Scale => {
            let shade = |prob: f64| (255.0 * (1.0 - prob)).round() as u8;
            let grey = |prob: f64| if prob.is_nan() { 128 } else { shade(prob) };
            let opacity = |prob: f64| if prob.is_nan() { 0 } else { 255 };
            let alpha = picture(probs, opacity, None)?;
            let is_opaque = alpha.values().iter().all(|a| *a == 255);
            picture(probs, grey, (!is_opaque).then(|| alpha.values().to_vec()))?
        }
    };
    Ok((picture, yaml))
}

/// The same map with black and white exchanged; raw pictures stay, as they have no negative.
///
/// # Errors
///
/// None that a picture from here can cause; see [`GreyImage::new`].
pub fn negated(image: &GreyImage, yaml: &MapYaml) -> Result<(GreyImage, MapYaml), MapError> {
    if yaml.mode == Mode::Raw {
        return Ok((image.clone(), yaml.clone()));
    }
    let values = image.values().iter().map(|grey| 255 - grey).collect();
    let alpha = image.alpha().map(<[u8]>::to_vec);
    let negative = GreyImage::new(image.width(), image.height(), values, alpha)?;
    Ok((negative, MapYaml { negate: !yaml.negate, ..yaml.clone() }))
}

impl ServedMap {
    /// Verdicts on the cells: occupied above `occupied_prob` or at 100, free below `free_prob` or
    /// at 0.
    pub fn states(&self, thresholds: &Thresholds) -> Window<State> {
        self.occupancy.map(|percent| match percent {
            UNKNOWN_PERCENT => State::Unknown,
            100 => State::Occupied,
            0 => State::Free,
            _ => thresholds.state_of(f64::from(percent) / 100.0),
        })
    }

    /// The map as evidence, in its own frame: 100 % and 0 % have the largest that `model` allows.
    ///
    /// A turned picture is laid on a lattice that is not turned; each cell takes what lies at its
    /// centre. O(cells).
    ///
    /// # Errors
    ///
    /// [`MapError::Setting`] for a model without sense, and those of [`Lattice::new`] and
    /// [`LogOddsMap::merge_at`].
    pub fn to_log_odds(&self, model: EvidenceModel) -> Result<LogOddsMap, MapError> {
        let turned = self.map_from_picture.yaw_rad != 0.0;
        let corner = self.map_from_picture.position();
        let origin = if turned { geometry::Vec2::zeros() } else { corner };
        let mut picture = LogOddsMap::new(Lattice::new(origin, self.resolution_m)?, model)?;
        for (cell, percent) in self.occupancy.iter().filter(|(_, p)| *p != UNKNOWN_PERCENT) {
            // The ends of the scale are infinite, and stop at the limits.
            picture.set(cell, Some(logodds_of(f64::from(percent) / 100.0)));
        }
        if !turned {
            return Ok(picture);
        }
        let mut map = LogOddsMap::new(Lattice::new(corner, self.resolution_m)?, model)?;
        map.merge_at(&picture, self.map_from_picture)?;
        Ok(map)
    }
}

fn percent_of(grey: u8, yaml: &MapYaml) -> i8 {
    if yaml.mode == Mode::Raw {
        return if grey <= 100 { grey as i8 } else { UNKNOWN_PERCENT };
    }
    let occupied = if yaml.negate { grey } else { 255 - grey };
    let prob = f64::from(occupied) / 255.0;
    if prob > yaml.occupied_prob {
        100
    } else if prob < yaml.free_prob {
        0
    } else if yaml.mode == Mode::Scale {
        let ratio = (prob - yaml.free_prob) / (yaml.occupied_prob - yaml.free_prob);
        (100.0 * ratio).round_ties_even() as i8
    } else {
        UNKNOWN_PERCENT
    }
}

fn described(area: CellBox, lattice: &Lattice, image: &str, mode: Mode) -> MapYaml {
    let corner = lattice.corner_of(area.min);
    let origin = Se2::new(corner.x, corner.y, 0.0);
    MapYaml { mode, ..MapYaml::new(image, lattice.resolution_m, origin) }
}

/// A window as a picture: its last row comes first.
fn picture<T: Copy>(
    window: &Window<T>,
    grey: impl Fn(T) -> u8,
    alpha: Option<Vec<u8>>,
) -> Result<GreyImage, MapError> {
    let CellBox { width, height, .. } = window.area();
    if window.area().is_empty() {
        return Err(MapError::Empty);
    }
    let rows = window.values().chunks_exact(width).rev();
    let values = rows.flat_map(|row| row.iter().map(|value| grey(*value))).collect();
    GreyImage::new(width, height, values, alpha)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::{read_pgm, read_png, write_pgm, write_png};
    use Mode::{Raw, Scale, Trinary};
    use State::{Free, Occupied, Unknown};
    use geometry::Vec2;
    use proptest::{collection::vec, prelude::*};

    fn yaml(mode: Mode, negate: bool, occupied_prob: f64, free_prob: f64) -> MapYaml {
        let usual = MapYaml::new("m.pgm", 0.05, Se2::new(-1.0, 2.0, 0.0));
        MapYaml { mode, negate, occupied_prob, free_prob, ..usual }
    }

    fn percents(yaml: &MapYaml, greys: &[u8]) -> Vec<i8> {
        let image = GreyImage::new(greys.len(), 1, greys.to_vec(), None).unwrap();
        read(&image, yaml).unwrap().occupancy.values().to_vec()
    }

    #[test]
    fn greys_mean_what_the_documentation_says() {
        // The usual three greys, with the usual thresholds, and with those of newer tools.
        assert_eq!(percents(&yaml(Trinary, false, 0.65, 0.196), &[0, 205, 254]), [100, -1, 0]);
        assert_eq!(percents(&yaml(Trinary, false, 0.65, 0.25), &[0, 205, 254]), [100, 0, 0]);
        // 51/255 = 0.2 and 153/255 = 0.6 are thresholds themselves: neither above nor below.
        let fifths = [203, 204, 205, 101, 102, 103];
        assert_eq!(percents(&yaml(Trinary, false, 0.6, 0.2), &fifths), [-1, -1, 0, 100, -1, -1]);
        let fifths = fifths.map(|grey| 255 - grey);
        assert_eq!(percents(&yaml(Trinary, true, 0.6, 0.2), &fifths), [-1, -1, 0, 100, -1, -1]);
        // Half-way between the thresholds is 50 %.
        assert_eq!(
            percents(&yaml(Scale, false, 0.6, 0.2), &[0, 101, 102, 153, 204, 205]),
            [100, 100, 100, 50, 0, 0]
        );
        assert_eq!(percents(&yaml(Scale, true, 0.6, 0.2), &[255, 102, 51, 50]), [100, 50, 0, 0]);
        assert_eq!(
            percents(&yaml(Raw, false, 0.6, 0.2), &[0, 1, 100, 101, 255]),
            [0, 1, 100, -1, -1]
        );
        assert_eq!(percents(&yaml(Raw, true, 0.6, 0.2), &[0, 100, 101]), [0, 100, -1]);
    }

    #[test]
    fn the_picture_hangs_from_its_last_row() {
        let area = CellBox::spanning(Cell::new(-1, 4), Cell::new(0, 6));
        let states = [Occupied, Free, Unknown, Unknown, Free, Free];
        let states = Window::from_values(area, states.to_vec()).unwrap();
        let lattice = Lattice::new(Vec2::new(0.5, 0.0), 0.25).unwrap();
        let (image, yaml) = draw_states(&states, &lattice, "a.pgm").unwrap();
        assert_eq!(image.values(), &[254, 254, 205, 205, 0, 254]);
        assert_eq!(yaml.origin, Se2::new(0.25, 1.0, 0.0));
        let back = read(&image, &yaml).unwrap();
        assert_eq!(back.states(&Thresholds::default()), states.moved_to(Cell::new(0, 0)));
        let nothing = Window::filled(CellBox { width: 0, ..area }, Free).unwrap();
        assert_eq!(draw_states(&nothing, &lattice, "a.pgm").unwrap_err(), MapError::Empty);
    }

    #[test]
    fn a_turned_picture_is_laid_on_a_straight_lattice() {
        let greys = vec![254, 254, 0, 205];
        let image = GreyImage::new(4, 1, greys, None).unwrap();
        let mut yaml = yaml(Mode::Trinary, false, 0.65, 0.196);
        let straight = read(&image, &yaml).unwrap().to_log_odds(EvidenceModel::default()).unwrap();
        assert_eq!(straight.logodds(Cell::new(2, 0)), Some(4.0));
        assert_eq!(straight.lattice().corner_of(Cell::new(0, 0)), Vec2::new(-1.0, 2.0));
        // A quarter turn to the left: the row stands up, to the left of the corner.
        yaml.origin = Se2::new(-1.0, 2.0, std::f64::consts::FRAC_PI_2);
        let turned = read(&image, &yaml).unwrap().to_log_odds(EvidenceModel::default()).unwrap();
        let known: Vec<_> = turned.grid().known().map(|(c, _)| (c.column, c.row)).collect();
        assert_eq!(known, [(-1, 0), (-1, 1), (-1, 2)]);
        assert_eq!(turned.logodds(Cell::new(-1, 2)), Some(4.0));
        assert_eq!(turned.logodds(Cell::new(-1, 0)), Some(-4.0));
    }

    fn prob() -> impl Strategy<Value = f64> {
        prop_oneof![3 => 0.0..=1.0_f64, 1 => Just(f64::NAN)]
    }

    proptest! {
        /// Window to picture to bytes and back, in every mode and form.
        #[test]
        fn what_is_written_is_read_to_the_last_bit(
            width in 1..7_usize,
            probs in vec(prob(), 42),
            mode in prop_oneof![Just(Mode::Trinary), Just(Mode::Scale), Just(Mode::Raw)],
            negate: bool,
        ) {
            let area = CellBox { min: Cell::new(-3, 8), width, height: 7 };
            let probs = Window::from_values(area, probs[..7 * width].to_vec()).unwrap();
            let lattice = Lattice::new(Vec2::new(0.1, 0.2), 0.05).unwrap();
            let thresholds = Thresholds::default();
            let (mut image, mut yaml) = draw_probs(&probs, &lattice, "m", mode, &thresholds).unwrap();
            let first = read(&image, &yaml).unwrap();
            if negate {
                (image, yaml) = negated(&image, &yaml).unwrap();
                prop_assert_eq!(yaml.negate, mode != Mode::Raw);
            }
            let text = MapYaml::parse(&yaml.to_text()).unwrap();
            let from_png = read_png(&write_png(&image).unwrap()).unwrap();
            prop_assert_eq!(&from_png, &image);
            let again = read(&from_png, &text).unwrap();
            prop_assert_eq!(&again, &first);
            let from_pgm = read_pgm(&write_pgm(&image)).unwrap();
            prop_assert_eq!(from_pgm.values(), image.values());
            for ((_, percent), (_, prob)) in first.occupancy.iter().zip(probs.iter()) {
                match mode {
                    _ if prob.is_nan() => prop_assert_eq!(percent, -1),
                    Mode::Raw => prop_assert!((f64::from(percent) - 100.0 * prob).abs() <= 0.5 + 1e-9),
                    Mode::Trinary => prop_assert_eq!(percent, if prob > 0.65 { 100 } else if prob < 0.35 { 0 } else { -1 }),
                    Mode::Scale => {
                        let expected = (100.0 * (prob - 0.196) / 0.454).clamp(0.0, 100.0);
                        prop_assert!((f64::from(percent) - expected).abs() < 1.0, "{} {}", percent, prob);
                    }
                }
            }
        }
    }
}
