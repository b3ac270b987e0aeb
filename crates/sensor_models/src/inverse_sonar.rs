//! What one sonar reading says about the cells around it: inverse models.
//!
//! The echo came from somewhere on an arc; the space before the arc is probably free; behind it and
//! outside the cone nothing is known. [`Region`] tells these four apart. [`ArcProfile`] is the
//! source's law of probabilities, in its printed and its programmed form. [`ConeModel`] is our own,
//! in log-odds and calibrated, for maps that are to be used.
//!
//! Source: Axenie (2011), "Maparea mediului pentru roboți mobili cu structură senzorială limitată",
//! MSc dissertation, Univ. Dunărea de Jos Galați, eq. (10) to (13) and annex.

/// Where a cell lies for one reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// I: on the arc that the echo came from.
    Arc,
    /// II: inside the cone, before the arc.
    Before,
    /// III: inside the cone, behind the arc.
    Behind,
    /// IV: outside the cone, or beyond the sensor's range.
    Outside,
}

/// Which law [`ArcProfile`] follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileForm {
    /// Equations (10) to (13) as printed: one reading may be nearly certain.
    Document,
    /// The annex's program: the same, then halved towards one half.
    Listing,
}

/// The source's profile over range and angle. Lengths are in cells, as there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcProfile {
    /// The law.
    pub form: ProfileForm,
    /// R: range at which certainty has fallen to what the angle alone gives.
    pub certain_range_cells: f64,
    /// Half of the arc's thickness towards the sensor.
    pub tolerance_before_cells: f64,
    /// Half of the arc's thickness away from the sensor.
    pub tolerance_behind_cells: f64,
    /// Greatest probability that an arc is given.
    pub max_occupied_prob: f64,
}

impl ArcProfile {
    /// The annex's program with its range of 26 cells.
    ///
    /// Readings beyond 26 cells are accepted there although certainty is then negative: free cells
    /// far away come out occupied. [`Self::fixed`] has a range that fits.
    pub const fn listing() -> Self {
        Self {
            form: ProfileForm::Listing,
            certain_range_cells: 26.0,
            tolerance_before_cells: 1.0,
            tolerance_behind_cells: 0.5,
            max_occupied_prob: 0.98,
        }
    }

    /// The annex's program with 2.6 m in cells of 35 mm: 74.29.
    pub const fn fixed() -> Self {
        Self { certain_range_cells: 2600.0 / 35.0, ..Self::listing() }
    }

    /// Equations (10) to (13) as printed, with the range of [`Self::fixed`].
    pub const fn document() -> Self {
        Self { form: ProfileForm::Document, ..Self::fixed() }
    }

    /// Where a cell lies that is `range_cells` from the sensor and `off_axis_ratio` half cone
    /// angles (0 to 1 inside) from its axis, for an echo from `reading_cells`.
    pub fn region(&self, range_cells: f64, off_axis_ratio: f64, reading_cells: f64) -> Region {
        if off_axis_ratio > 1.0 {
            Region::Outside
        } else if range_cells > reading_cells + self.tolerance_behind_cells {
            Region::Behind
        } else if (range_cells - reading_cells).abs() <= self.tolerance_before_cells {
            Region::Arc
        } else {
            Region::Before
        }
    }

    /// Probability that the cell is occupied, by this reading alone; `None` where the reading says
    /// nothing. Arguments as for [`Self::region`].
    ///
    /// From 0 to 1 while the cell is within `certain_range_cells`; farther it may leave that
    /// interval by the source's own defect, which the [`Self::listing`] preset keeps. The printed
    /// form is clamped.
    pub fn occupied_prob(
        &self,
        range_cells: f64,
        off_axis_ratio: f64,
        reading_cells: f64,
    ) -> Option<f64> {
        let region = self.region(range_cells, off_axis_ratio, reading_cells);
        let reach = self.certain_range_cells;
        // ½ [(R - r)/R + (β - α)/β], eq. (10) and (13).
        let certainty = 0.5 * ((reach - range_cells) / reach + (1.0 - off_axis_ratio));
        match (self.form, region) {
            (_, Region::Behind | Region::Outside) => None,
            (ProfileForm::Document, Region::Arc) => {
                Some(certainty.clamp(0.0, 1.0) * self.max_occupied_prob)
            }
            (ProfileForm::Document, Region::Before) => Some(1.0 - certainty.clamp(0.0, 1.0)),
            (ProfileForm::Listing, Region::Arc) => {
                Some(0.5 * (self.max_occupied_prob * certainty) + 0.5)
            }
            (ProfileForm::Listing, Region::Before) => Some(1.0 - (0.5 * certainty + 0.5)),
        }
    }
}

/// Our inverse model: log-odds over a cone of physical aperture.
///
/// Before the arc a cell loses [`free_logodds`](Self::free_logodds) times two weights, one falling
/// with the square of the range over [`free_range_m`](Self::free_range_m), one falling to zero at
/// the edge of the cone. On the arc it gains [`occupied_logodds`](Self::occupied_logodds) times the
/// weight of the angle and the arc's share: one reflector explains the echo, so the longer the arc
/// is, the less each of its cells has of it. Everything is a rational function of the cell's
/// coordinates in the sensor's frame, without root or arc tangent, so that a map can be filled fast.
///
/// The default was chosen by the maps that it draws from true poses in four simulated environments
/// with furniture, cells of 35 mm, p from 0.7: on average 94 % of the occupied cells lie within a cell
/// of a wall, and 92 % of the walls that could be heard are found. More free weight wears walls away
/// by cones that graze them, more occupied weight leaves arcs where no wall is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeModel {
    /// Half of the cone's opening, radians, from 0.01 to 0.78.
    pub half_angle_rad: f64,
    /// Log-odds that a cell right before the sensor loses, at least 0.
    pub free_logodds: f64,
    /// Range at which that has fallen to nothing, metres.
    pub free_range_m: f64,
    /// Log-odds that a cell gains which is the whole arc, at least 0.
    pub occupied_logodds: f64,
    /// Range at which a reading says nothing any more about its arc, metres.
    pub occupied_range_m: f64,
    /// Arcs up to this length are not shared out, metres.
    pub whole_arc_m: f64,
    /// Half of the arc's thickness, metres.
    pub tolerance_m: f64,
}

/// Where on its arc an echo came from, as far as the readings before and after it tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcFocus {
    /// From the axis, counter-clockwise positive, radians.
    pub bearing_rad: f64,
    /// Half of the part of the arc that is left, radians.
    pub half_width_rad: f64,
}

impl Default for ConeModel {
    fn default() -> Self {
        Self {
            half_angle_rad: 15.0_f64.to_radians(),
            free_logodds: 0.6,
            free_range_m: 4.0,
            occupied_logodds: 3.0,
            occupied_range_m: 4.0,
            whole_arc_m: 0.12,
            tolerance_m: 0.03,
        }
    }
}

impl ConeModel {
    /// Where a point lies for an echo from `reading_m`: `range_m` from the sensor, `off_axis_rad`
    /// from its axis, either sign.
    pub fn region(&self, range_m: f64, off_axis_rad: f64, reading_m: f64) -> Region {
        if off_axis_rad.abs() > self.half_angle_rad {
            Region::Outside
        } else if range_m > reading_m + self.tolerance_m {
            Region::Behind
        } else if range_m >= reading_m - self.tolerance_m {
            Region::Arc
        } else {
            Region::Before
        }
    }

    /// What the point's log-odds of being occupied change by. Arguments as for [`Self::region`];
    /// `focus` narrows the arc.
    pub fn change_logodds(
        &self,
        range_m: f64,
        off_axis_rad: f64,
        reading_m: f64,
        focus: Option<ArcFocus>,
    ) -> f64 {
        match self.region(range_m, off_axis_rad, reading_m) {
            Region::Behind | Region::Outside => 0.0,
            Region::Before => {
                let off = off_axis_rad.tan() / self.half_angle_rad.tan();
                -self.free_at_logodds(range_m) * (1.0 - off * off).max(0.0)
            }
            Region::Arc => {
                let ArcFocus { bearing_rad, half_width_rad } = self.whole(focus);
                let off = (off_axis_rad.tan() - bearing_rad.tan()) / half_width_rad.tan();
                self.arc_logodds(reading_m, focus) * (1.0 - off * off).max(0.0)
            }
        }
    }

    /// Log-odds that a cell on the axis loses, `range_m` from the sensor and before the arc.
    pub fn free_at_logodds(&self, range_m: f64) -> f64 {
        let ratio = range_m / self.free_range_m;
        self.free_logodds * (1.0 - ratio * ratio).max(0.0)
    }

    /// Log-odds that the middle of the arc of `reading_m` gains.
    pub fn arc_logodds(&self, reading_m: f64, focus: Option<ArcFocus>) -> f64 {
        let ratio = reading_m / self.occupied_range_m;
        let length_m = 2.0 * self.whole(focus).half_width_rad * reading_m;
        let share = if length_m > self.whole_arc_m { self.whole_arc_m / length_m } else { 1.0 };
        self.occupied_logodds * share * (1.0 - ratio * ratio).max(0.0)
    }

    /// The focus that is given, or the whole arc.
    pub fn whole(&self, focus: Option<ArcFocus>) -> ArcFocus {
        focus.unwrap_or(ArcFocus { bearing_rad: 0.0, half_width_rad: self.half_angle_rad })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn published(profile: ArcProfile, reading_cells: f64, rows: &[(f64, f64, f64)]) {
        for &(range, off_deg, expected) in rows {
            // In the arc the reading is the range; before it, far enough behind.
            let reading = if reading_cells > 0.0 { reading_cells } else { range };
            let p = profile.occupied_prob(range, off_deg / 7.0, reading).unwrap();
            assert!((p - expected).abs() < 5.1e-7, "({range}, {off_deg}): {p}, not {expected}");
        }
    }

    #[test]
    fn the_programmed_profile_has_its_published_values() {
        let arc = [
            (0.0, 0.0, 0.99),
            (13.0, 0.0, 0.8675),
            (20.0, 0.0, 0.801_538),
            (20.0, 3.5, 0.679_038),
            (20.0, 7.0, 0.556_538),
            (26.0, 7.0, 0.5),
            (40.0, 0.0, 0.613_077),
            (40.0, 7.0, 0.368_077),
            (57.0, 7.0, 0.207_885),
        ];
        published(ArcProfile::listing(), 0.0, &arc);
        let before = [
            (0.0, 0.0, 0.0),
            (13.0, 0.0, 0.125),
            (20.0, 0.0, 0.192_308),
            (20.0, 7.0, 0.442_308),
            (26.0, 7.0, 0.5),
            (57.0, 7.0, 0.798_077),
        ];
        published(ArcProfile::listing(), 100.0, &before);
    }

    #[test]
    fn the_printed_profile_has_its_published_values() {
        let printed = ArcProfile { certain_range_cells: 26.0, ..ArcProfile::document() };
        published(printed, 0.0, &[(20.0, 0.0, 0.603_077), (13.0, 0.0, 0.735)]);
        published(printed, 100.0, &[(13.0, 0.0, 0.25), (20.0, 0.0, 0.384_615)]);
    }

    #[test]
    fn a_range_that_fits_keeps_free_cells_free() {
        let far = |profile: ArcProfile| profile.occupied_prob(50.0, 0.9, 57.0).unwrap();
        assert!(far(ArcProfile::listing()) > 0.5, "the source's defect");
        assert!(far(ArcProfile::fixed()) < 0.5);
        assert!((ArcProfile::fixed().certain_range_cells - 74.29).abs() < 0.005);
    }

    #[test]
    fn the_four_regions_meet_where_they_are_said_to() {
        let profile = ArcProfile::listing();
        assert_eq!(profile.region(20.5, 1.0, 20.0), Region::Arc);
        assert_eq!(profile.region(20.51, 0.0, 20.0), Region::Behind);
        assert_eq!(profile.region(19.0, 0.0, 20.0), Region::Arc);
        assert_eq!(profile.region(18.99, 0.0, 20.0), Region::Before);
        assert_eq!(profile.region(18.0, 1.001, 20.0), Region::Outside);
        assert_eq!(profile.occupied_prob(20.51, 0.0, 20.0), None);
        assert_eq!(profile.occupied_prob(10.0, 1.1, 20.0), None);
        let cone = ConeModel::default();
        assert_eq!(cone.region(1.03, 0.0, 1.0), Region::Arc);
        assert_eq!(cone.region(1.04, 0.0, 1.0), Region::Behind);
        assert_eq!(cone.region(0.98, -0.26, 1.0), Region::Arc);
        assert_eq!(cone.region(0.96, -0.26, 1.0), Region::Before);
        assert_eq!(cone.region(0.96, -0.27, 1.0), Region::Outside);
    }

    #[test]
    fn our_weights_fall_with_range_and_angle_and_have_the_right_sign() {
        let cone = ConeModel::default();
        let at = |range_m, off_rad| cone.change_logodds(range_m, off_rad, 2.0, None);
        assert!(at(0.5, 0.0) < at(1.5, 0.0) && at(1.5, 0.0) < 0.0);
        assert!(at(0.5, 0.0) < at(0.5, 0.2) && at(0.5, 0.2) < 0.0);
        assert!(at(2.0, 0.0) > at(2.0, -0.2) && at(2.0, -0.2) > 0.0);
        assert!(at(2.5, 0.0).abs() < 1e-15 && at(1.0, 0.3).abs() < 1e-15);
        assert!(cone.arc_logodds(0.5, None) > 3.0 * cone.arc_logodds(2.0, None));
        assert!(cone.arc_logodds(5.0, None).abs() < 1e-15 && cone.free_at_logodds(5.0) < 1e-15);
    }

    #[test]
    fn a_focus_gives_its_part_of_the_arc_the_whole_weight() {
        let cone = ConeModel::default();
        let focus = Some(ArcFocus { bearing_rad: 0.2, half_width_rad: 0.05 });
        let at = |off_rad, focus| cone.change_logodds(1.0, off_rad, 1.0, focus);
        assert!(at(0.2, focus) > 3.0 * at(0.0, None), "narrower, so each cell has more");
        assert!(at(0.0, focus).abs() < 1e-15, "outside the focus nothing is known");
        assert!(at(-0.2, focus).abs() < 1e-15);
    }
}
