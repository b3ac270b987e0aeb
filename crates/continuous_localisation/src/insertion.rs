//! Writing readings into maps: cones, cell by cell, and the question whether a cone is believable.

use geometry::{Se2, Vec2};
use grid_maps::{Cell, ConeInserter, ConeShape, LogOddsMap, MapError};
use sensor_models::{ArcFocus, ConeModel, Region};

/// One reading in a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedReading {
    /// The sensor in the map, x along its axis.
    pub map_from_sensor: Se2,
    /// What it read, metres; for silence, how far that clears the cone.
    pub range_m: f64,
    /// Whether an echo came, so that there is an arc.
    pub is_echo: bool,
    /// Where on its arc the echo came from, if that is known.
    pub focus: Option<ArcFocus>,
}

/// Puts readings into maps of one resolution, by the laws of a [`ConeModel`].
#[derive(Clone, Debug)]
pub struct RingInserter {
    cone: ConeModel,
    cones: ConeInserter,
}

impl RingInserter {
    /// For maps of `resolution_m`. Makes a table of the model, with bins of half a cell.
    ///
    /// # Errors
    ///
    /// [`MapError`] for a resolution or a cone that no map can have.
    pub fn new(cone: ConeModel, resolution_m: f64) -> Result<Self, MapError> {
        let shape = ConeShape {
            half_angle_rad: cone.half_angle_rad,
            range_max_m: cone.free_range_m.max(cone.occupied_range_m),
            tolerance_m: cone.tolerance_m,
        };
        let before = |r: f64, off_rad: f64| cone.change_logodds(r, off_rad, f64::INFINITY, None);
        let arc = |r: f64, off_rad: f64| cone.change_logodds(r, off_rad, r, None);
        let cones = ConeInserter::new(shape, resolution_m, before, arc)?;
        Ok(Self { cone, cones })
    }

    /// Adds what `reading` says to `map`. Each cell takes the value of [`ConeModel::change_logodds`]
    /// at its centre, to within half a cell. O(cells of the cone); allocates only where the map grows.
    pub fn insert(&self, map: &mut LogOddsMap, reading: &PlacedReading) {
        let PlacedReading { map_from_sensor, range_m, is_echo, focus } = *reading;
        let shape = self.cones.shape();
        if !is_echo {
            self.cones.insert_silence(map, map_from_sensor, range_m, 1.0);
        } else if range_m > shape.range_max_m {
            // Too far for its arc to say anything, but not for what is before it.
            self.cones.insert_silence(map, map_from_sensor, shape.range_max_m, 1.0);
        } else if let Some(focus) = focus {
            let before_m = range_m - shape.tolerance_m;
            self.cones.insert_silence(map, map_from_sensor, before_m, 1.0);
            self.insert_arc(map, map_from_sensor, range_m, focus);
        } else {
            self.cones.insert_echo(map, map_from_sensor, range_m, 1.0);
        }
    }

    /// The cells of a narrow arc, one by one.
    fn insert_arc(&self, map: &mut LogOddsMap, sensor: Se2, range_m: f64, focus: ArcFocus) {
        let lattice = *map.lattice();
        let ArcFocus { bearing_rad, half_width_rad } = focus;
        let towards = Se2::new(sensor.x_m, sensor.y_m, sensor.yaw_rad + bearing_rad);
        let middle = towards.transform_point(Vec2::new(range_m, 0.0));
        let reach_m = self.cone.tolerance_m + range_m * half_width_rad.tan();
        if !reach_m.is_finite() {
            return;
        }
        let low = lattice.cell_of(middle - Vec2::repeat(reach_m));
        let high = lattice.cell_of(middle + Vec2::repeat(reach_m));
        let axis = sensor.heading();
        for row in low.row..=high.row {
            for column in low.column..=high.column {
                let cell = Cell { column, row };
                let p = lattice.centre_of(cell) - sensor.position();
                let off_rad = axis.perp(&p).atan2(axis.dot(&p));
                if self.cone.region(p.norm(), off_rad, range_m) != Region::Arc {
                    continue;
                }
                let change = self.cone.change_logodds(p.norm(), off_rad, range_m, Some(focus));
                if change > 0.0 {
                    map.add(cell, change);
                }
            }
        }
    }
}

/// Whether the middle of a cone, up to `margin_m` before its end, goes through a cell of at least
/// `contradiction_logodds`: then sound cannot have gone that way, and the reading is a ghost.
pub fn is_contradicted(
    map: &LogOddsMap,
    reading: &PlacedReading,
    margin_m: f64,
    contradiction_logodds: f64,
) -> bool {
    /// Angles looked along, radians: the part of a cone where most of the sound is.
    const LINES_RAD: [f64; 3] = [0.0, -0.09, 0.09];
    let lattice = map.lattice();
    let origin = reading.map_from_sensor.position();
    LINES_RAD.iter().any(|&line_rad| {
        let turn = Se2::new(0.0, 0.0, reading.map_from_sensor.yaw_rad + line_rad);
        let step = turn.heading() * lattice.resolution_m;
        let n_steps = ((reading.range_m - margin_m) / lattice.resolution_m).min(1000.0) as i32;
        (1..n_steps).any(|i| {
            let cell = lattice.cell_of(origin + step * f64::from(i));
            map.logodds(cell).is_some_and(|logodds| logodds >= contradiction_logodds)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use grid_maps::{EvidenceModel, Lattice};
    use proptest::prelude::*;

    fn map() -> LogOddsMap {
        let lattice = Lattice { origin: Vec2::zeros(), resolution_m: 0.035 };
        let wide =
            EvidenceModel { min_logodds: -20.0, max_logodds: 20.0, ..EvidenceModel::default() };
        LogOddsMap::new(lattice, wide).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// Oracle: the model, asked for range and angle of every cell in a large square.
        #[test]
        fn every_cell_gets_what_the_model_says(
            x in -1.0..1.0, y in -1.0..1.0, yaw in -3.2..3.2, range_m in 0.1..2.5,
            is_echo: bool, bearing in prop::option::of(-0.2..0.2),
        ) {
            let cone = ConeModel::default();
            let focus = bearing.map(|bearing_rad| ArcFocus { bearing_rad, half_width_rad: 0.08 });
            let map_from_sensor = Se2::new(x, y, yaw);
            let reading = PlacedReading { map_from_sensor, range_m, is_echo, focus };
            let mut map = map();
            RingInserter::new(cone, 0.035).unwrap().insert(&mut map, &reading);
            // What the model says at a centre and half a cell around it.
            let expected = |p: Vec2| {
                let (r, angle) = (p.norm(), geometry::wrap_to_pi(p.y.atan2(p.x) - yaw));
                match is_echo {
                    true => cone.change_logodds(r, angle, range_m, focus),
                    false if r < range_m => cone.change_logodds(r, angle, 9.0, None),
                    false => 0.0,
                }
            };
            for row in -110..110 {
                for column in -110..110 {
                    let cell = Cell { column, row };
                    let p = map.lattice().centre_of(cell) - map_from_sensor.position();
                    let (r, angle) = (p.norm(), geometry::wrap_to_pi(p.y.atan2(p.x) - yaw));
                    // Within rounding of a border either side is right.
                    let edges = [
                        (angle.abs() - cone.half_angle_rad) * r,
                        r - range_m, r - range_m - cone.tolerance_m, r - range_m + cone.tolerance_m,
                    ];
                    // The table's bins are too coarse for the first two cells.
                    if r < 0.07 || edges.iter().any(|e| e.abs() < 1e-4) { continue }
                    let found = map.logodds(cell).unwrap_or(0.0);
                    let here = expected(p);
                    let near = [-0.02, 0.0, 0.02].map(|dx| [-0.02, 0.0, 0.02].map(|dy| {
                        let near = expected(p + Vec2::new(dx, dy));
                        if near * here >= 0.0 { near } else { here }
                    }));
                    let all = near.iter().flatten();
                    let low = all.clone().copied().fold(here, f64::min);
                    let high = all.copied().fold(here, f64::max);
                    let slack = 0.01 + 0.15 * here.abs();
                    prop_assert!(found > low - slack && found < high + slack,
                        "{found} not {low} to {high}, r {r}, angle {angle}");
                }
            }
        }
    }

    #[test]
    fn a_cone_through_a_wall_is_a_ghost_and_one_that_ends_there_is_not() {
        let mut map = map();
        for column in 20..40 {
            map.set(Cell { column: 28, row: column - 30 }, Some(2.0));
        }
        let reading = |range_m| PlacedReading {
            map_from_sensor: Se2::IDENTITY,
            range_m,
            is_echo: true,
            focus: None,
        };
        assert!(!is_contradicted(&map, &reading(1.0), 0.1, 1.0));
        assert!(is_contradicted(&map, &reading(1.5), 0.1, 1.0));
        assert!(!is_contradicted(&map, &reading(1.5), 0.1, 3.0));
    }
}
