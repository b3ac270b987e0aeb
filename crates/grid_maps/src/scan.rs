//! A whole laser scan at once: the free space is a star around the sensor, filled row by row.
//!
//! Each cell is changed once for a scan, however many beams pass it, so near cells do not become
//! surer than far ones. What a scan says:
//!
//! - **Hits.** A cell in which at least one beam ended gets one hit, and no miss.
//! - **Misses.** A cell gets one miss when its centre lies in the free space of a wedge.
//!
//! A wedge is what lies between two neighbouring beams. Each beam is free up to its reading less
//! [`free_margin_m`](ScanRules::free_margin_m); a wedge is free
//!
//! - up to the straight line between the two ends, when they differ by at most
//!   [`surface_step_max_m`](ScanRules::surface_step_max_m): one surface;
//! - otherwise up to the nearer of the two: nothing is cleared behind an edge or through a thin
//!   gap that only a single beam passed;
//! - not at all when the beams are more than 0.2 rad (11°) apart.
//!
//! A beam without return is free up to [`no_return_free_m`](ScanRules::no_return_free_m); one that
//! is no number, negative or too near counts as blind: free up to 0.
//!
//! The definition, ray by ray, is [`LogOddsMap::insert_ray`].

use std::f64::consts::TAU;

use geometry::{Se2, Vec2};

use crate::{
    Lattice, LogOddsMap, MapError,
    lattice::floor,
    spans::{SIDE_MAX_CELLS, SpanFill},
    tile_grid::Slot,
};

/// Beams further apart than this have nothing to say about what is between them: cos 0.2 rad.
const WEDGE_COS_MIN: f64 = 0.980_066_577_841_241_6;

/// No beam clears further, cells; it bounds the memory.
const REACH_MAX_CELLS: f64 = 0.5 * (SIDE_MAX_CELLS - 8.0);

/// Directions of the beams of a scanner, in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamFan {
    directions: Vec<Vec2>,
}

/// What a scan says about the space in front of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanRules {
    /// Nearer readings are dust or the robot itself: blind, metres; from 0.
    pub range_min_m: f64,
    /// Readings from here on count as "nothing came back", metres.
    pub range_max_m: f64,
    /// A beam without return clears so far, metres; 0 for not at all.
    pub no_return_free_m: f64,
    /// Neighbouring beams whose readings differ by less see one surface, metres.
    pub surface_step_max_m: f64,
    /// The last piece of a beam clears nothing, so that a wall is not nibbled at between two hits,
    /// metres; about half of a cell's diagonal.
    pub free_margin_m: f64,
}

/// What an insertion did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ScanReport {
    /// Beams that ended on something.
    pub n_hits: usize,
    /// Beams from which nothing came back.
    pub n_no_return: usize,
    /// Readings that are no number, negative or too near, and points beyond the limits of cells.
    pub n_blind: usize,
    /// Cells that got a miss.
    pub n_free_cells: usize,
}

/// Puts scans into maps; keeps its memory from scan to scan.
#[derive(Clone, Debug)]
pub struct ScanInserter {
    rules: ScanRules,
    fill: SpanFill,
    /// Directions in the frame of the map.
    directions: Vec<Vec2>,
    /// How far each beam clears, cells.
    reaches: Vec<f64>,
    hits: Vec<Hit>,
}

/// A cell that gets a hit, and what it was before the scan.
#[derive(Clone, Copy, Debug)]
struct Hit {
    slot: Slot,
    old: i16,
}

impl BeamFan {
    /// Beams of equal spacing; `beam_spacing_rad` is positive counter-clockwise, and all beams lie
    /// within one turn.
    ///
    /// # Errors
    ///
    /// [`MapError::Setting`] for numbers that are not finite, and for more than one turn.
    pub fn uniform(
        first_beam_rad: f64,
        beam_spacing_rad: f64,
        n_beams: usize,
    ) -> Result<Self, MapError> {
        if !first_beam_rad.is_finite() {
            let requirement = "a finite angle";
            return Err(MapError::Setting {
                key: "first_beam_rad",
                value: first_beam_rad,
                requirement,
            });
        }
        let turn = beam_spacing_rad.abs() * n_beams.saturating_sub(1) as f64;
        // A full turn that was added up may come out a little above.
        if !(beam_spacing_rad.is_finite() && turn <= TAU + 1e-6) {
            let requirement = "such that all beams lie within one turn";
            return Err(MapError::Setting {
                key: "beam_spacing_rad",
                value: beam_spacing_rad,
                requirement,
            });
        }
        let bearing = |i: usize| first_beam_rad + beam_spacing_rad * i as f64;
        Ok(Self { directions: (0..n_beams).map(|i| unit(bearing(i))).collect() })
    }

    /// Beams with the given bearings (rad), in the order of the readings, which goes round once
    /// in either direction.
    ///
    /// # Errors
    ///
    /// [`MapError::Setting`] for bearings that are not finite.
    pub fn of_bearings(bearings_rad: &[f64]) -> Result<Self, MapError> {
        if let Some(&value) = bearings_rad.iter().find(|bearing| !bearing.is_finite()) {
            let (key, requirement) = ("bearing", "a finite angle");
            return Err(MapError::Setting { key, value, requirement });
        }
        Ok(Self { directions: bearings_rad.iter().map(|&bearing| unit(bearing)).collect() })
    }

    /// One unit vector for each beam.
    pub fn directions(&self) -> &[Vec2] {
        &self.directions
    }
}

fn unit(bearing_rad: f64) -> Vec2 {
    let (s, c) = bearing_rad.sin_cos();
    Vec2::new(c, s)
}

impl ScanRules {
    /// Rules for a laser that sees as far as `range_max_m` and a map of that resolution: what did
    /// not come back clears nothing, a step of 0.15 m is an edge, and the margin is half a cell's
    /// diagonal.
    pub fn new(range_max_m: f64, resolution_m: f64) -> Self {
        Self {
            range_min_m: 0.05,
            range_max_m,
            no_return_free_m: 0.0,
            surface_step_max_m: 0.15,
            free_margin_m: 0.5 * 2.0_f64.sqrt() * resolution_m,
        }
    }
}

/// A reading by the rules.
enum Reading {
    Hit,
    NoReturn,
    Blind,
}

impl ScanRules {
    fn read(&self, range_m: f64) -> Reading {
        if range_m >= self.range_max_m {
            Reading::NoReturn
        } else if range_m >= self.range_min_m && range_m >= 0.0 {
            Reading::Hit
        } else {
            Reading::Blind
        }
    }

    /// How far a beam clears, cells.
    #[expect(clippy::manual_clamp, reason = "what is not a number becomes 0")]
    fn reach_cells(&self, reading: &Reading, range_m: f64, resolution_m: f64) -> f64 {
        let reach_m = match reading {
            Reading::Hit => range_m - self.free_margin_m,
            Reading::NoReturn => self.no_return_free_m,
            Reading::Blind => 0.0,
        };
        (reach_m / resolution_m).max(0.0).min(REACH_MAX_CELLS)
    }
}

impl ScanInserter {
    /// An inserter that follows `rules`.
    pub const fn new(rules: ScanRules) -> Self {
        Self {
            rules,
            fill: SpanFill::new(),
            directions: Vec::new(),
            reaches: Vec::new(),
            hits: Vec::new(),
        }
    }

    /// Its rules.
    pub const fn rules(&self) -> &ScanRules {
        &self.rules
    }

    /// Puts a scan into `map`, taken with the sensor at `map_from_sensor`.
    ///
    /// `ranges_m` belong to the beams of `fan` in order; those without a partner are left out. No
    /// allocation once the memory has grown to the size of the scans, but for new tiles of the
    /// map. O(beams + cells).
    pub fn insert(
        &mut self,
        map: &mut LogOddsMap,
        fan: &BeamFan,
        map_from_sensor: Se2,
        ranges_m: &[f64],
    ) -> ScanReport {
        let lattice = *map.lattice();
        let origin = map_from_sensor.position();
        let heading = map_from_sensor.heading();
        let mut report = self.begin();
        if lattice.cell_at(origin).is_none() || !map_from_sensor.yaw_rad.is_finite() {
            report.n_blind = ranges_m.len();
            return report;
        }
        for (beam, &range_m) in fan.directions.iter().zip(ranges_m) {
            let direction = Vec2::new(
                heading.x * beam.x - heading.y * beam.y,
                heading.y * beam.x + heading.x * beam.y,
            );
            self.beam(map, direction, range_m, origin + direction * range_m, &mut report);
        }
        self.finish(map, &lattice, origin, report)
    }

    /// Puts the end points (m, frame of the map) of beams from `origin` into `map`; in the order of
    /// their bearings, round once in either direction.
    ///
    /// For scans whose points were moved one by one, each at its own pose. Rules for ranges apply
    /// to the distance from `origin`.
    pub fn insert_points(
        &mut self,
        map: &mut LogOddsMap,
        origin: Vec2,
        points: &[Vec2],
    ) -> ScanReport {
        let lattice = *map.lattice();
        let mut report = self.begin();
        if lattice.cell_at(origin).is_none() {
            report.n_blind = points.len();
            return report;
        }
        for &point in points {
            let away = point - origin;
            let range_m = away.norm();
            if range_m.is_finite() && range_m > 0.0 {
                self.beam(map, away / range_m, range_m, point, &mut report);
            } else {
                report.n_blind += 1;
            }
        }
        self.finish(map, &lattice, origin, report)
    }

    fn begin(&mut self) -> ScanReport {
        self.directions.clear();
        self.reaches.clear();
        self.hits.clear();
        ScanReport::default()
    }

    /// Takes one beam; remembers what its last cell was before the scan.
    fn beam(
        &mut self,
        map: &mut LogOddsMap,
        direction: Vec2,
        range_m: f64,
        end: Vec2,
        report: &mut ScanReport,
    ) {
        let mut reading = self.rules.read(range_m);
        match reading {
            Reading::Hit => match map.lattice().cell_at(end) {
                Some(cell) => {
                    let grid = map.grid_mut();
                    let slot = grid.slot(cell);
                    self.hits.push(Hit { slot, old: grid.at(slot) });
                }
                None => reading = Reading::Blind,
            },
            Reading::NoReturn => report.n_no_return += 1,
            Reading::Blind => {}
        }
        report.n_blind += usize::from(matches!(reading, Reading::Blind));
        self.directions.push(direction);
        let resolution_m = map.lattice().resolution_m;
        self.reaches.push(self.rules.reach_cells(&reading, range_m, resolution_m));
    }

    fn finish(
        &mut self,
        map: &mut LogOddsMap,
        lattice: &Lattice,
        origin: Vec2,
        mut report: ScanReport,
    ) -> ScanReport {
        let shift = self.outline(lattice, origin);
        let steps = map.steps();
        self.fill.for_each_span(|row, start, end| {
            let columns = start + shift[0]..end + shift[0];
            map.add_step_to_span(row + shift[1], columns, steps.miss);
            report.n_free_cells += (end - start) as usize;
        });
        // A cell may be in the list more than once, but with the same old value each time: what is
        // written last is what was written first, and misses under a hit are undone.
        let grid = map.grid_mut();
        for hit in &self.hits {
            *grid.at_mut(hit.slot) = steps.sum(hit.old, steps.hit);
        }
        report.n_hits = self.hits.len();
        report
    }

    /// Draws the free space; returns the cell of its corner.
    fn outline(&mut self, lattice: &Lattice, origin: Vec2) -> [i32; 2] {
        let Self { fill, directions, reaches, rules, .. } = self;
        fill.begin();
        let reach_max = reaches.iter().fold(0.0_f64, |max, reach| max.max(*reach));
        let at = lattice.in_cells(origin);
        let shift = [at.x, at.y].map(|x| floor(x) - floor(reach_max) - 2);
        let centre = Vec2::new(at.x - f64::from(shift[0]), at.y - f64::from(shift[1]));
        let (Some(&first), Some(&last)) = (directions.first(), directions.last()) else {
            return shift;
        };
        let step_max = rules.surface_step_max_m / lattice.resolution_m;
        let is_wide = |a: Vec2, b: Vec2| a.dot(&b) < WEDGE_COS_MIN;
        // All round: the last beam is a neighbour of the first, and some beam looks back.
        let all_round =
            !is_wide(first, last) && directions.iter().any(|beam| beam.dot(&first) < 0.0);
        let n = directions.len();
        // How far the wedge between two beams is free, on the side of the first.
        let wedge = |a: usize, b: usize| {
            let (from, to) = (reaches[a], reaches[b]);
            if (from - to).abs() <= step_max { from } else { from.min(to) }
        };
        let mut corner = |direction: Vec2, reach: f64| {
            let corner = centre + direction * reach;
            fill.corner([corner.x, corner.y]);
        };
        let mut before = if all_round { wedge(0, n - 1) } else { reaches[0] };
        if !all_round {
            corner(first, 0.0);
        }
        for i in 0..n {
            corner(directions[i], before);
            let next = match i + 1 {
                next if next < n => next,
                _ if all_round => 0,
                _ => break,
            };
            let wide = is_wide(directions[i], directions[next]);
            if wide {
                corner(first, 0.0);
                before = reaches[next];
                continue;
            }
            let after = wedge(i, next);
            if (after - before).abs() > 0.0 {
                corner(directions[i], after);
            }
            before = wedge(next, i);
        }
        shift
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cell, EvidenceModel};
    use proptest::{collection::vec, prelude::*};
    use std::f64::consts::PI;

    const RESOLUTION_M: f64 = 0.1;
    const RULES: ScanRules = ScanRules {
        range_min_m: 0.1,
        range_max_m: 8.0,
        no_return_free_m: 0.0,
        surface_step_max_m: 0.15,
        free_margin_m: 0.0,
    };

    fn map() -> LogOddsMap {
        let lattice = Lattice::new(Vec2::new(0.03, -0.04), RESOLUTION_M).unwrap();
        LogOddsMap::new(lattice, EvidenceModel::default()).unwrap()
    }

    /// Log-odds of one hit and one miss, in steps.
    const HIT: Option<f64> = Some(870.0 / 1024.0);
    const MISS: Option<f64> = Some(-410.0 / 1024.0);

    /// The rules in words of one wedge and one point: `None` when the point is within 1e-9 of an
    /// edge of the wedge.
    fn is_free(
        rules: &ScanRules,
        ranges: [f64; 2],
        bearings: [f64; 2],
        at: [f64; 2],
    ) -> Option<bool> {
        let mut reach = ranges.map(|r| {
            let blind = r.is_nan() || r < rules.range_min_m;
            if blind {
                0.0
            } else if r >= rules.range_max_m {
                rules.no_return_free_m
            } else {
                (r - rules.free_margin_m).max(0.0)
            }
        });
        if (reach[0] - reach[1]).abs() > rules.surface_step_max_m {
            reach = [reach[0].min(reach[1]); 2];
        }
        let ends = [0, 1].map(|i| [reach[i] * bearings[i].cos(), reach[i] * bearings[i].sin()]);
        let triangle = [[0.0, 0.0], ends[0], ends[1]];
        let mut sides = [0.0; 3];
        for i in 0..3 {
            let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            if length < 1e-12 {
                return Some(false);
            }
            sides[i] = ((b[0] - a[0]) * (at[1] - a[1]) - (at[0] - a[0]) * (b[1] - a[1])) / length;
        }
        let inside = sides.iter().all(|s| *s > 1e-9) || sides.iter().all(|s| *s < -1e-9);
        let outside = sides.iter().any(|s| *s > 1e-9) && sides.iter().any(|s| *s < -1e-9);
        (inside || outside).then_some(inside)
    }

    fn range() -> impl Strategy<Value = f64> {
        prop_oneof![
            6 => 0.0..4.0_f64, 6 => 2.0..2.2_f64, 1 => Just(f64::INFINITY), 1 => Just(f64::NAN),
            1 => Just(-1.0)
        ]
    }

    proptest! {
        /// Every cell of a scan against the definition, wedge by wedge.
        #[test]
        fn cells_are_what_the_rules_say(
            ranges in vec(range(), 8..36),
            pose in (-3.0..3.0_f64, -3.0..3.0_f64, -PI..PI),
            spacing in prop_oneof![Just(0.18), Just(-0.18), Just(0.05), Just(0.21)],
            no_return_free_m in prop_oneof![Just(0.0), Just(3.0)],
            free_margin_m in prop_oneof![Just(0.0), Just(0.07)],
        ) {
            let rules = ScanRules { no_return_free_m, free_margin_m, ..RULES };
            let n = ranges.len().min((TAU / f64::abs(spacing)) as usize + 1);
            let fan = BeamFan::uniform(-1.3, spacing, n).unwrap();
            let pose = Se2::new(pose.0, pose.1, pose.2);
            let mut map = map();
            let report = ScanInserter::new(rules).insert(&mut map, &fan, pose, &ranges[..n]);
            let bearing = |i: usize| pose.yaw_rad - 1.3 + spacing * i as f64;
            let mut wedges: Vec<[usize; 2]> = Vec::new();
            if f64::abs(spacing) < 0.2 {
                wedges.extend((1..n).map(|i| [i - 1, i]));
            }
            if TAU - f64::abs(spacing) * (n - 1) as f64 <= 0.2 {
                wedges.push([n - 1, 0]);
            }
            let hits: Vec<Cell> = (0..n)
                .filter(|&i| (0.1..8.0).contains(&ranges[i]))
                .map(|i| {
                    let (s, c) = bearing(i).sin_cos();
                    map.lattice().cell_of(pose.position() + Vec2::new(c, s) * ranges[i])
                })
                .collect();
            prop_assert_eq!(report.n_hits, hits.len());
            prop_assert_eq!(report.n_hits + report.n_no_return + report.n_blind, n);
            let mut n_known = 0;
            for column in -75..75 {
                for row in -75..75 {
                    let cell = Cell::new(column, row);
                    let centre = map.lattice().centre_of(cell) - pose.position();
                    let wedges: Vec<_> = wedges
                        .iter()
                        .map(|&[i, j]| {
                            let (ranges, bearings) = ([ranges[i], ranges[j]], [bearing(i), bearing(j)]);
                            is_free(&rules, ranges, bearings, [centre.x, centre.y])
                        })
                        .collect();
                    let found = map.logodds(cell);
                    n_known += usize::from(found.is_some());
                    if hits.contains(&cell) {
                        prop_assert_eq!(found, HIT);
                    } else if wedges.contains(&Some(true)) {
                        prop_assert_eq!(found, MISS, "{:?}", cell);
                    } else if !wedges.contains(&None) {
                        prop_assert_eq!(found, None, "{:?}", cell);
                    }
                }
            }
            prop_assert_eq!(n_known, map.grid().known().count());
        }

        #[test]
        fn points_and_ranges_say_the_same(
            ranges in vec(0.2..4.0_f64, 30),
            pose in (-3.0..3.0_f64, -3.0..3.0_f64, -PI..PI),
        ) {
            let fan = BeamFan::uniform(-1.5, 0.1, 30).unwrap();
            let pose = Se2::new(pose.0, pose.1, pose.2);
            let points: Vec<Vec2> = fan.directions().iter().zip(&ranges)
                .map(|(beam, range_m)| pose.transform_point(beam * *range_m)).collect();
            let (mut a, mut b) = (map(), map());
            let mut inserter = ScanInserter::new(RULES);
            let by_ranges = inserter.insert(&mut a, &fan, pose, &ranges);
            let by_points = inserter.insert_points(&mut b, pose.position(), &points);
            prop_assert_eq!(by_ranges.n_hits, by_points.n_hits);
            // Rounding may move an edge over a centre, or an end over a border.
            let differ = a.grid().known().filter(|&(cell, step)| b.grid().get(cell) != step).count();
            prop_assert!(differ <= 2, "{} cells differ", differ);
        }
    }

    /// A room of 6 m × 6 m around the origin, seen from its middle.
    fn room(n_beams: usize) -> (BeamFan, Vec<f64>) {
        let fan = BeamFan::uniform(-PI, TAU / n_beams as f64, n_beams).unwrap();
        let range = |beam: &Vec2| 3.0 / beam.x.abs().max(beam.y.abs());
        let ranges = fan.directions().iter().map(range).collect();
        (fan, ranges)
    }

    #[test]
    fn a_scan_counts_each_cell_once_and_all_round_has_no_seam() {
        let (fan, ranges) = room(360);
        let mut map = map();
        let mut inserter = ScanInserter::new(RULES);
        let report = inserter.insert(&mut map, &fan, Se2::new(0.0, 0.0, 1.0), &ranges);
        assert_eq!((report.n_hits, report.n_no_return, report.n_blind), (360, 0, 0));
        let values: Vec<_> = map.grid().known().map(|(cell, _)| map.logodds(cell)).collect();
        assert!(values.iter().all(|v| *v == HIT || *v == MISS));
        let n_free = values.iter().filter(|v| **v == MISS).count();
        // 36 m² are 3600 cells, of which the hits along 24 m take some.
        assert!((3350..3600).contains(&n_free), "{n_free}");
        assert!(report.n_free_cells >= n_free);
        inserter.insert(&mut map, &fan, Se2::new(0.0, 0.0, 1.0), &ranges);
        assert_eq!(map.grid().known().count(), values.len());
    }

    #[test]
    fn nothing_is_cleared_behind_a_gap_that_one_beam_passed() {
        let fan = BeamFan::uniform(-0.1, 0.05, 5).unwrap();
        let mut map = map();
        let ranges = [2.0, 2.0, 6.0, 2.0, 2.0];
        ScanInserter::new(RULES).insert(&mut map, &fan, Se2::IDENTITY, &ranges);
        let free = |x: f64| map.prob(map.lattice().cell_of(Vec2::new(x, 0.0))).is_some();
        assert!(free(1.5) && !free(2.5) && !free(4.0) && free(6.0));
        // Two beams side by side have seen the space between them.
        let wide = [2.0, 2.0, 6.0, 6.0, 2.0];
        ScanInserter::new(RULES).insert(&mut map, &fan, Se2::IDENTITY, &wide);
        assert!(map.prob(map.lattice().cell_of(Vec2::new(4.0, 0.1))).is_some());
    }

    #[test]
    fn a_broken_pose_or_reading_changes_nothing() {
        let fan = BeamFan::uniform(-0.1, 0.05, 5).unwrap();
        let mut map = map();
        let mut inserter = ScanInserter::new(RULES);
        for (x, yaw) in [(f64::NAN, 0.0), (f64::INFINITY, 0.0), (1e300, 0.0), (0.0, f64::NAN)] {
            let pose = Se2 { x_m: x, y_m: 0.0, yaw_rad: yaw };
            let report = inserter.insert(&mut map, &fan, pose, &[1.0; 5]);
            assert_eq!((report.n_blind, report.n_hits), (5, 0));
        }
        let lasting = ScanRules { range_max_m: f64::INFINITY, no_return_free_m: f64::NAN, ..RULES };
        let mut inserter = ScanInserter::new(lasting);
        let ranges = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 0.05];
        let report = inserter.insert(&mut map, &fan, Se2::IDENTITY, &ranges);
        assert_eq!((report.n_blind, report.n_no_return, report.n_hits), (4, 1, 0));
        assert_eq!(inserter.insert(&mut map, &fan, Se2::IDENTITY, &[]), ScanReport::default());
        assert_eq!(inserter.insert_points(&mut map, Vec2::new(f64::NAN, 0.0), &[]).n_hits, 0);
        let nowhere = [Vec2::new(0.0, 0.0), Vec2::new(f64::NAN, 1.0)];
        assert_eq!(inserter.insert_points(&mut map, Vec2::zeros(), &nowhere).n_blind, 2);
        assert_eq!(map.bounds(), None);
    }

    #[test]
    fn a_laser_that_sees_for_miles_has_bounded_memory() {
        let fan = BeamFan::uniform(0.3, 0.02, 2).unwrap();
        let rules = ScanRules { range_max_m: 1e9, no_return_free_m: 1e9, ..RULES };
        let mut map = map();
        let report = ScanInserter::new(rules).insert(&mut map, &fan, Se2::IDENTITY, &[1e6; 2]);
        assert_eq!(report.n_hits, 2);
        // A triangle of 8196 cells and 0.02 rad, not of 10 million cells.
        assert!((660_000..680_000).contains(&report.n_free_cells), "{report:?}");
    }

    #[test]
    fn fans_that_go_round_twice_are_refused() {
        assert!(BeamFan::uniform(0.0, 0.1, 64).is_err());
        assert!(BeamFan::uniform(0.0, -0.1, 64).is_err());
        assert!(BeamFan::uniform(0.0, f64::NAN, 2).is_err());
        assert!(BeamFan::uniform(f64::INFINITY, 0.1, 2).is_err());
        assert!(BeamFan::uniform(0.0, TAU / 360.0, 361).is_ok());
        let one = BeamFan::of_bearings(&[0.0]).unwrap();
        assert_eq!(one.directions(), &[Vec2::new(1.0, 0.0)]);
        assert!(BeamFan::of_bearings(&[0.0, f64::NAN]).is_err());
    }

    #[test]
    fn the_second_scan_allocates_nothing() {
        let (fan, ranges) = room(361);
        let mut map = map();
        let mut inserter = ScanInserter::new(RULES);
        inserter.insert(&mut map, &fan, Se2::IDENTITY, &ranges);
        let measured = allocation_counter::measure(|| {
            inserter.insert(&mut map, &fan, Se2::IDENTITY, &ranges);
        });
        assert_eq!(measured.count_total, 0);
    }
}
