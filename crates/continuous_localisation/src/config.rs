//! What can be chosen about continuous localisation, with the reasons for the defaults.

use sensor_models::ConeModel;

use crate::{classic::Score, maturity::Maturity};

/// All parameters of a [`Localiser`](crate::Localiser). [`Default`] is one set for every recording.
#[derive(Clone, Debug, PartialEq)]
pub struct LocaliserConfig {
    /// Side of a cell of both maps, metres, from 0.01 to 0.5; 0.035 as in the source.
    pub resolution_m: f64,
    /// When a short-term map is registered; 1 m of way. Small and often: within it odometry's own
    /// error stays small, and corrections are not late.
    pub maturity: Maturity,
    /// A short-term map lives on until it has so many echoes (open areas); 12.
    pub n_echoes_min: usize,
    /// But never longer than this way, so that drift inside it stays small, metres; 2.
    pub life_max_m: f64,
    /// What readings say about cells.
    pub cone: ConeModel,
    /// Which readings are used.
    pub filter: ReadingFilter,
    /// What odometry is trusted with.
    pub odometry: OdometryTrust,
    /// Which poses are tried, level by level, each around the best of the one before; empty: none.
    pub search: Vec<SearchLevel>,
    /// What decides between them.
    pub score: Score,
    /// When the minimum counts.
    pub distinct: Distinctness,
    /// Straight walls as landmarks; `None` matches grids only.
    pub walls: Option<WallTrust>,
    /// Walls of a building are mostly parallel or square to each other; `None` does without this.
    pub squareness: Option<Squareness>,
    /// Whether corrections are applied at all; off, the map is what odometry alone gives.
    pub is_correcting: bool,
}

/// Which readings are used for what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingFilter {
    /// Readings are dropped while the robot moved less than this, metres …
    pub standstill_m: f64,
    /// … and turned less than this since the last used row, radians.
    pub standstill_rad: f64,
    /// Silence (nothing came back) clears the cone up to this range, metres; beyond, a smooth wall
    /// may have mirrored the sound away.
    pub silence_clears_m: f64,
    /// Echoes that nothing supports wait for so much way before they are judged by the map, metres.
    pub wait_m: f64,
    /// A cell from these log-odds on contradicts a cone that goes through it.
    pub contradiction_logodds: f64,
}

/// What odometry is trusted with; standard deviations grow with the root of the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryTrust {
    /// Of the heading after one metre, radians.
    pub heading_std_rad: f64,
    /// Of the position along the way after one metre, metres.
    pub position_std_m: f64,
    /// Of the heading after one radian of turning, radians.
    pub turn_std_rad: f64,
    /// Of the systematic error of heading per metre, before anything is known, radians per metre.
    pub drift_std_radpm: f64,
    /// How much the systematic error changes within a metre, radians per metre.
    pub drift_walk_std_radpm: f64,
}

/// One level of the pose search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchLevel {
    /// Shifts to each side in x and in y.
    pub n_shifts: usize,
    /// From one shift to the next, cells.
    pub shift_step_cells: f64,
    /// Headings to each side.
    pub n_headings: usize,
    /// From one heading to the next, radians.
    pub heading_step_rad: f64,
}

/// When the best candidate is a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distinctness {
    /// A pose whose score is worse than the best by this may be the right one as well: how far one
    /// can go until then is the standard deviation of what is measured.
    pub rise_min_ratio: f64,
    /// The best must not be worse than this.
    pub score_max_ratio: f64,
    /// Part of the short-term map's cells that the long-term one must know: on new ground the little
    /// that both know is what was just driven past, and says what odometry says.
    pub overlap_min_ratio: f64,
    /// Standard deviation of a shift, at least, metres: maps smear, and their errors are alike.
    pub shift_std_m: f64,
    /// Standard deviation of a heading, at least, radians.
    pub heading_std_rad: f64,
    /// With more echoes of recognised walls than this the grids are searched, and the result is
    /// reported, but not used: walls are the sharper measurement, and grids are drawn from the same
    /// echoes.
    pub n_wall_echoes_max: usize,
}

/// Straight walls: how they are found, and how far they are trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallTrust {
    /// Shorter pieces are no walls, metres.
    pub length_min_m: f64,
    /// Echoes in one piece, at least.
    pub n_echoes_min: usize,
    /// Greatest deviation of a piece's echoes from its line (RMS), metres.
    pub straight_within_m: f64,
    /// A wall is expected to go on straight so far beyond what was seen of it, metres.
    pub goes_on_m: f64,
    /// A piece belongs to a wall, if at all, when it is no farther from its line than this, metres.
    pub gate_m: f64,
    /// An echo outside all pieces belongs to a wall, if at all, when its range is as predicted up to
    /// this, metres. Far less than [`gate_m`](Self::gate_m), because nothing but its range speaks for
    /// it: it has been left out of a piece next to a jump, where sound comes from an edge, or from a
    /// door that lies a hand's breadth deeper than the wall. One such echo is within what a wall's
    /// direction leaves uncertain; a row of them turns the wall, and the robot with it. More than a
    /// step of coarse ranges (an inch), less than half the depth of a doorway (0.12 m).
    pub lone_gate_m: f64,
    /// A piece belongs to a wall only when their directions differ less than this, radians.
    pub direction_gate_rad: f64,
    /// Standard deviation of an echo's range from a wall that does not depend on it, metres: more
    /// than the sensor's own, because errors of neighbouring echoes have much in common.
    pub range_std_m: f64,
    /// Standard deviation of the range per metre of range, a ratio.
    pub range_std_ratio: f64,
    /// Echoes farther away are not used, metres.
    pub range_max_m: f64,
    /// No more walls than these are kept: each echo costs the square of their number.
    pub n_walls_max: usize,
}

/// How far walls are trusted to be parallel or square to each other.
///
/// A short wall says little about how the robot turned while it passed: one metre of it bends by two
/// millimetres with a drift of one degree per metre. That the next wall is square to it says all.
/// Walls at other angles than these do no harm: they fit no multiple of 90° within the gate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squareness {
    /// Standard deviation of a wall's direction from the building's, radians.
    pub std_rad: f64,
    /// A wall that is farther off is one of those at other angles, radians.
    pub gate_rad: f64,
    /// Shorter walls are not asked, metres.
    pub length_min_m: f64,
}

/// A parameter outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: must be {requirement}")]
pub struct ConfigError {
    /// The parameter.
    pub key: &'static str,
    /// What it is.
    pub value: f64,
    /// What it must be, as prose.
    pub requirement: &'static str,
}

impl SearchLevel {
    /// The source's ±1 cell and so many degrees to each side, degree by degree: 27, 63 and 117
    /// candidates for 1, 3 and 6.
    pub fn source(n_degrees: usize) -> Self {
        Self {
            n_shifts: 1,
            shift_step_cells: 1.0,
            n_headings: n_degrees,
            heading_step_rad: 1.0_f64.to_radians(),
        }
    }

    /// ±4 cells and ±4°, two by two: 125 candidates, to be followed by a fine level.
    pub fn wide() -> Self {
        Self {
            n_shifts: 2,
            shift_step_cells: 2.0,
            n_headings: 2,
            heading_step_rad: 2.0_f64.to_radians(),
        }
    }

    /// Candidates at this level.
    pub fn n_candidates(&self) -> usize {
        (2 * self.n_shifts + 1).pow(2) * (2 * self.n_headings + 1)
    }
}

impl Default for LocaliserConfig {
    fn default() -> Self {
        Self {
            resolution_m: 0.035,
            maturity: Maturity::Distance(1.0),
            n_echoes_min: 12,
            life_max_m: 2.0,
            cone: ConeModel::default(),
            filter: ReadingFilter::default(),
            odometry: OdometryTrust::default(),
            search: vec![SearchLevel::wide(), SearchLevel::source(3)],
            score: Score::Evidence { n_cells_min: 150 },
            distinct: Distinctness::default(),
            walls: Some(WallTrust::default()),
            squareness: Some(Squareness::default()),
            is_correcting: true,
        }
    }
}

impl Default for ReadingFilter {
    fn default() -> Self {
        Self {
            standstill_m: 0.01,
            standstill_rad: 0.02,
            silence_clears_m: 0.6,
            wait_m: 3.0,
            contradiction_logodds: 0.7,
        }
    }
}

impl Default for OdometryTrust {
    fn default() -> Self {
        Self {
            heading_std_rad: 0.6_f64.to_radians(),
            position_std_m: 0.02,
            turn_std_rad: 0.02,
            drift_std_radpm: 1.5_f64.to_radians(),
            drift_walk_std_radpm: 0.05_f64.to_radians(),
        }
    }
}

impl Default for Distinctness {
    fn default() -> Self {
        Self {
            rise_min_ratio: 0.006,
            score_max_ratio: 0.7,
            overlap_min_ratio: 0.6,
            shift_std_m: 0.06,
            heading_std_rad: 2.0_f64.to_radians(),
            n_wall_echoes_max: 11,
        }
    }
}

impl Default for Squareness {
    fn default() -> Self {
        Self { std_rad: 1.0_f64.to_radians(), gate_rad: 12.0_f64.to_radians(), length_min_m: 0.4 }
    }
}

impl Default for WallTrust {
    fn default() -> Self {
        Self {
            length_min_m: 0.3,
            n_echoes_min: 5,
            straight_within_m: 0.015,
            goes_on_m: 1.5,
            gate_m: 0.3,
            lone_gate_m: 0.05,
            direction_gate_rad: 0.25,
            range_std_m: 0.03,
            range_std_ratio: 0.01,
            range_max_m: 4.0,
            n_walls_max: 200,
        }
    }
}

impl LocaliserConfig {
    /// Odometry alone: the same map, nothing corrected.
    pub fn odometry_only() -> Self {
        Self {
            search: Vec::new(),
            walls: None,
            squareness: None,
            is_correcting: false,
            ..Self::default()
        }
    }

    /// Refuses parameters outside their ranges.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] for the first such one; NaN is outside every range.
    pub fn checked(self) -> Result<Self, ConfigError> {
        let f = &self.filter;
        let o = &self.odometry;
        let n_candidates: usize = self.search.iter().map(SearchLevel::n_candidates).sum();
        let mut checks = vec![
            ("resolution_m", self.resolution_m, 0.01, 0.5, "from 0.01 to 0.5 m"),
            ("life_max_m", self.life_max_m, 0.1, 100.0, "from 0.1 to 100 m"),
            ("cone.half_angle_rad", self.cone.half_angle_rad, 0.01, 0.78, "from 0.01 to 0.78 rad"),
            ("cone.free_logodds", self.cone.free_logodds, 0.0, 20.0, "from 0 to 20"),
            ("cone.free_range_m", self.cone.free_range_m, 0.1, 20.0, "from 0.1 to 20 m"),
            ("cone.occupied_logodds", self.cone.occupied_logodds, 0.0, 20.0, "from 0 to 20"),
            ("cone.occupied_range_m", self.cone.occupied_range_m, 0.1, 20.0, "from 0.1 to 20 m"),
            ("cone.whole_arc_m", self.cone.whole_arc_m, 0.001, 20.0, "from 0.001 to 20 m"),
            ("cone.tolerance_m", self.cone.tolerance_m, 0.001, 1.0, "from 0.001 to 1 m"),
            ("filter.standstill_m", f.standstill_m, 0.0, 1.0, "from 0 to 1 m"),
            ("filter.standstill_rad", f.standstill_rad, 0.0, 1.0, "from 0 to 1 rad"),
            ("filter.silence_clears_m", f.silence_clears_m, 0.0, 20.0, "from 0 to 20 m"),
            ("filter.wait_m", f.wait_m, 0.0, 100.0, "from 0 to 100 m"),
            ("odometry.heading_std_rad", o.heading_std_rad, 1e-6, 3.0, "from 1e-6 to 3 rad"),
            ("odometry.position_std_m", o.position_std_m, 1e-6, 3.0, "from 1e-6 to 3 m"),
            ("odometry.turn_std_rad", o.turn_std_rad, 0.0, 3.0, "from 0 to 3 rad"),
            ("odometry.drift_std_radpm", o.drift_std_radpm, 1e-9, 3.0, "from 1e-9 to 3 rad/m"),
            (
                "odometry.drift_walk_std_radpm",
                o.drift_walk_std_radpm,
                0.0,
                3.0,
                "from 0 to 3 rad/m",
            ),
            ("search: candidates", n_candidates as f64, 0.0, 1e6, "at most a million"),
        ];
        if let Some(walls) = &self.walls {
            checks.extend([
                ("walls.length_min_m", walls.length_min_m, 0.05, 10.0, "from 0.05 to 10 m"),
                ("walls.goes_on_m", walls.goes_on_m, 0.0, 10.0, "from 0 to 10 m"),
                ("walls.gate_m", walls.gate_m, 0.001, 2.0, "from 0.001 to 2 m"),
                ("walls.lone_gate_m", walls.lone_gate_m, 0.001, 2.0, "from 0.001 to 2 m"),
                ("walls.range_std_m", walls.range_std_m, 0.001, 1.0, "from 0.001 to 1 m"),
            ]);
        }
        for (key, value, min, max, requirement) in checks {
            if !(min..=max).contains(&value) {
                return Err(ConfigError { key, value, requirement });
            }
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_source_s_search_spaces_have_their_published_sizes() {
        let n = |degrees| SearchLevel::source(degrees).n_candidates();
        assert_eq!([n(1), n(3), n(6)], [27, 63, 117]);
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        assert!(LocaliserConfig::default().checked().is_ok());
        assert!(LocaliserConfig::odometry_only().checked().is_ok());
        let bad = LocaliserConfig { resolution_m: f64::NAN, ..Default::default() };
        let message = bad.checked().unwrap_err().to_string();
        assert_eq!(message, "resolution_m = NaN: must be from 0.01 to 0.5 m");
        let level = SearchLevel { n_shifts: 1000, ..SearchLevel::source(3) };
        let bad = LocaliserConfig { search: vec![level], ..Default::default() };
        assert!(bad.checked().is_err());
    }
}
