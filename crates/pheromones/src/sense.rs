//! What two antennas perceive: only sources in front, within reach.
//!
//! Method: a window scan. Only the cells of the square around an antenna are looked at, so a query's
//! cost depends on (σ / cell size)², not on the map or on how many sources it has. A narrow window is
//! added up without branches, whatever its cells hold; where a window's rows are longer than a word of
//! the occupancy bits, empty stretches of 64 cells are skipped. Both add in the same order and give
//! the same bits.

use geometry::{Se2, Vec2};

use crate::{
    Field, VALUE_MAX,
    field::ones,
    model::{diffused, equivalent_distance_m},
};

/// What one unit source is perceived as by an antenna that stands on it.
pub(crate) const UNIT_INTENSITY: f64 = 100.0;

/// A source this far behind the antennas' line (m) still counts as on it: rounding must not decide
/// which half of a row that lies on the line is smelled.
const FRONT_TOLERANCE_M: f64 = 1e-9;

/// Windows with rows longer than this many cells skip empty words of the occupancy bits. Below it, looking at
/// every cell is quicker, and its cost does not depend on what the cells hold.
const WIDE_WINDOW_CELLS: usize = 48;

/// How the contributions of several sources become one intensity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Perception {
    /// As the thesis's server program: a vector sum whose direction comes from an arcsine, which folds
    /// it about the map's x axis. For comparison with the thesis; turning the map changes the result.
    Listing,
    /// The vector sum of (5.41) with true directions. Sound on trails one cell wide only: on wider ones,
    /// sources at both sides cancel and the difference of the antennas can have the wrong sign.
    VectorAtan2,
    /// The plain sum of intensities, a concentration. Right on trails of any width.
    #[default]
    ScalarSum,
}

settings::choices!(Perception {
    ScalarSum = "scalar_sum": "the sum of the intensities; right on trails of any width",
    VectorAtan2 = "vector_atan2": "the vector sum with true directions; for trails one cell wide",
    Listing = "listing": "the vector sum as the thesis's program has it, which folds directions",
});

/// The antennas and how they perceive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SenseConfig {
    /// How contributions are added.
    pub perception: Perception,
    /// Reach of an antenna (σ), metres, > 0. The thesis's experiment has 0.6, its program 0.68.
    pub sigma_m: f64,
    /// Between the two antennas (b), metres, ≥ 0.
    pub antenna_spacing_m: f64,
    /// The listing's arithmetic: π = 3.14, antennas at whole millimetres, each source's contribution
    /// rounded down to a whole number. Off unless golden values are to be met.
    pub strict: bool,
}

impl Default for SenseConfig {
    /// The experiment of the thesis's §7.4, with the perception that suits trails of any width.
    fn default() -> Self {
        Self {
            perception: Perception::default(),
            sigma_m: 0.6,
            antenna_spacing_m: 0.38,
            strict: false,
        }
    }
}

/// What the two antennas perceive; 100 is one unit source right at the antenna. ≥ 0, no upper limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Intensities {
    /// Left antenna.
    pub left: f64,
    /// Right antenna.
    pub right: f64,
}

impl Intensities {
    /// Neither antenna perceives anything: the trail is lost.
    pub fn is_lost(&self) -> bool {
        self.left == 0.0 && self.right == 0.0
    }

    /// Left minus right: positive when the trail is on the left.
    pub fn difference(&self) -> f64 {
        self.left - self.right
    }
}

/// The one source that would be perceived like all that are in front of the robot together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquivalentSource {
    /// What is perceived of it at the robot's centre, `P_R`; 100 per unit source.
    pub intensity: f64,
    /// What it has at its place: N p₀, the sum of the sources perceived; 100 per unit source.
    pub total_intensity: f64,
    /// Its direction `φ_R` from the robot's heading, radians, left positive, in [−π/2, π/2].
    pub bearing_rad: f64,
    /// Its distance L ahead, metres, in [0, σ]; (5.48).
    pub distance_m: f64,
}

impl Field {
    /// What the antennas of a robot at `map_from_base` perceive.
    ///
    /// The antennas stand at ±b/2 beside the robot's centre (5.43). A source counts when it is not
    /// behind the line through them, within σ, and has a value of 1..=127; it contributes
    /// p = 100 p₀ (1 − d/σ) (5.39). For the two vector modes a source nearer than a hundredth of a cell
    /// has no direction and is left out, as in the listing.
    ///
    /// A pose or configuration that is not finite, or σ ≤ 0, perceives nothing. O((σ / cell size)²).
    ///
    /// Source: the thesis, (5.38)–(5.43) and Annex B1.
    pub fn sense(&self, map_from_base: Se2, config: &SenseConfig) -> Intensities {
        let half = 0.5 * config.antenna_spacing_m;
        let usable =
            pose_is_finite(map_from_base) && half.is_finite() && config.sigma_m.is_finite();
        if !usable || config.sigma_m <= 0.0 {
            return Intensities::default();
        }
        if config.strict {
            return strict::sense(self, map_from_base, config);
        }
        let view = View::new(self, map_from_base, config.sigma_m);
        let left = map_from_base.transform_point(Vec2::new(0.0, half));
        let right = map_from_base.transform_point(Vec2::new(0.0, -half));
        match config.perception {
            Perception::ScalarSum => Intensities {
                left: view.collect::<ScalarSum>(left).0,
                right: view.collect::<ScalarSum>(right).0,
            },
            Perception::VectorAtan2 => Intensities {
                left: view.collect::<VectorSum>(left).norm(),
                right: view.collect::<VectorSum>(right).norm(),
            },
            Perception::Listing => Intensities {
                left: view.collect::<FoldedSum>(left).0.norm(),
                right: view.collect::<FoldedSum>(right).0.norm(),
            },
        }
    }

    /// The single source equivalent to all that the robot's centre perceives in front of it, or `None`
    /// where nothing is perceived. Uses `sigma_m` only. O((σ / cell size)²).
    ///
    /// Source: the thesis, (5.41), (5.42), (5.47), (5.48). Differences: the direction is a true one
    /// (arctangent of both components) and is given from the robot's heading.
    pub fn equivalent_source(
        &self,
        map_from_base: Se2,
        config: &SenseConfig,
    ) -> Option<EquivalentSource> {
        if !pose_is_finite(map_from_base) || !config.sigma_m.is_finite() || config.sigma_m <= 0.0 {
            return None;
        }
        let view = View::new(self, map_from_base, config.sigma_m);
        let sum = view.collect::<VectorSum>(map_from_base.position());
        let intensity = sum.norm();
        if intensity <= 0.0 {
            return None;
        }
        let in_base = map_from_base.inverse().rotate(Vec2::new(sum.east, sum.north));
        let distance_m = equivalent_distance_m(intensity, sum.total, config.sigma_m);
        Some(EquivalentSource {
            intensity,
            total_intensity: sum.total,
            bearing_rad: in_base.y.atan2(in_base.x),
            distance_m,
        })
    }

    /// Visits all sources within `reach_m` of a point, row by row from the top: column, row, position
    /// (m) and value. O((reach / cell size)² / 64 + sources visited).
    pub(crate) fn visit_within(
        &self,
        point_in_map: Vec2,
        reach_m: f64,
        mut visit: impl FnMut(usize, usize, Vec2, u8),
    ) {
        for (row, first_col, last_col) in self.window(point_in_map, reach_m) {
            for col in self.occupied(row, first_col, last_col) {
                let in_map = self.cell_centre(col, row);
                if (in_map - point_in_map).norm() < reach_m {
                    visit(col, row, in_map, self.value(col, row));
                }
            }
        }
    }

    /// Rows of the window around a point, each with its first and last column, inclusive.
    fn window(
        &self,
        centre: Vec2,
        reach_m: f64,
    ) -> impl Iterator<Item = (usize, usize, usize)> + use<> {
        let size = self.cell_size_m();
        let clip = |from: f64, to: f64, n: usize| {
            let first = from.ceil().max(0.0);
            let last = to.floor().min(n as f64 - 1.0);
            (first <= last).then_some((first as usize, last as usize))
        };
        let middle = Vec2::new((self.width() / 2) as f64, (self.height() / 2) as f64);
        let (col, row) = (centre.x / size + middle.x, middle.y - centre.y / size);
        let reach = reach_m / size;
        let columns = clip(col - reach, col + reach, self.width());
        let rows = clip(row - reach, row + reach, self.height());
        let span = columns.zip(rows);
        span.into_iter().flat_map(|((first, last), (top, bottom))| {
            (top..=bottom).map(move |row| (row, first, last))
        })
    }

    /// The columns of the sources in part of a row.
    fn occupied(&self, row: usize, first: usize, last: usize) -> impl Iterator<Item = usize> + '_ {
        let words = &self.occupancy_row(row)[first / 64..=last / 64];
        words.iter().enumerate().flat_map(move |(i, &word)| {
            let base = (first / 64 + i) * 64;
            let mut wanted = word;
            if base < first {
                wanted &= u64::MAX << (first - base);
            }
            if base + 63 > last {
                wanted &= u64::MAX >> (base + 63 - last);
            }
            ones(wanted).map(move |bit| base + bit)
        })
    }
}

fn pose_is_finite(pose: Se2) -> bool {
    pose.x_m.is_finite() && pose.y_m.is_finite() && pose.yaw_rad.is_finite()
}

/// What is added up at one antenna.
trait Sum: Default {
    /// Adds one cell: its intensity at its place, what arrives of it (both ≥ 0, 100 per unit source),
    /// and where it lies from the antenna (m), `distance_m` away. Zero must add nothing.
    fn add(&mut self, arriving: f64, at_source: f64, offset: Vec2, distance_m: f64);

    /// Nearer than this many cells a source has no direction.
    const BLIND_CELLS: f64;
}

#[derive(Default)]
struct ScalarSum(f64);

impl Sum for ScalarSum {
    const BLIND_CELLS: f64 = 0.0;

    #[inline]
    fn add(&mut self, arriving: f64, _at_source: f64, _offset: Vec2, _distance_m: f64) {
        self.0 += arriving;
    }
}

#[derive(Default)]
struct VectorSum {
    east: f64,
    north: f64,
    total: f64,
}

impl VectorSum {
    fn norm(&self) -> f64 {
        self.east.hypot(self.north)
    }
}

impl Sum for VectorSum {
    const BLIND_CELLS: f64 = 0.01;

    #[inline]
    fn add(&mut self, arriving: f64, at_source: f64, offset: Vec2, distance_m: f64) {
        // The blind spot keeps the distance from 0; max() is for cells that add nothing.
        let scale = arriving / distance_m.max(f64::MIN_POSITIVE);
        self.east += scale * offset.x;
        self.north += scale * offset.y;
        self.total += if arriving > 0.0 { at_source } else { 0.0 };
    }
}

/// cos(arcsin(x/d)) = |y|/d: the arcsine forgets on which side of the x axis a source lies.
#[derive(Default)]
struct FoldedSum(VectorSum);

impl Sum for FoldedSum {
    const BLIND_CELLS: f64 = VectorSum::BLIND_CELLS;

    #[inline]
    fn add(&mut self, arriving: f64, at_source: f64, offset: Vec2, distance_m: f64) {
        self.0.add(arriving, at_source, Vec2::new(offset.x, offset.y.abs()), distance_m);
    }
}

/// A robot's view of the field: which sources are in front and within reach.
struct View<'a> {
    field: &'a Field,
    position: Vec2,
    heading: Vec2,
    sigma_m: f64,
}

impl<'a> View<'a> {
    fn new(field: &'a Field, map_from_base: Se2, sigma_m: f64) -> Self {
        let (position, heading) = (map_from_base.position(), map_from_base.heading());
        Self { field, position, heading, sigma_m }
    }

    fn collect<S: Sum>(&self, antenna: Vec2) -> S {
        let mut sum = S::default();
        for (row, first, last) in self.field.window(antenna, self.sigma_m) {
            if last - first < WIDE_WINDOW_CELLS {
                self.add_every(&mut sum, antenna, row, first..=last);
            } else {
                self.add_every(&mut sum, antenna, row, self.field.occupied(row, first, last));
            }
        }
        sum
    }

    /// Adds the given cells of a row.
    #[inline]
    fn add_every<S: Sum>(
        &self,
        sum: &mut S,
        antenna: Vec2,
        row: usize,
        columns: impl Iterator<Item = usize>,
    ) {
        let y_m = self.field.row_y_m(row);
        let ahead_of_row_m = (y_m - self.position.y) * self.heading.y;
        let dy_m = y_m - antenna.y;
        let blind_m = S::BLIND_CELLS * self.field.cell_size_m();
        let values = &self.field.values()[row * self.field.width()..][..self.field.width()];
        for col in columns {
            let x_m = self.field.column_x_m(col);
            let ahead_m = (x_m - self.position.x) * self.heading.x + ahead_of_row_m;
            let dx_m = x_m - antenna.x;
            let distance_m = (dx_m * dx_m + dy_m * dy_m).sqrt();
            let value = values[col];
            let counts =
                value <= VALUE_MAX && ahead_m >= -FRONT_TOLERANCE_M && distance_m >= blind_m;
            // Selected, not branched over: the cost must not depend on what the cells hold.
            let at_source = if counts { UNIT_INTENSITY * f64::from(value) } else { 0.0 };
            let arriving = at_source * (1.0 - distance_m / self.sigma_m).max(0.0);
            sum.add(arriving, at_source, Vec2::new(dx_m, dy_m), distance_m);
        }
    }
}

/// The listing's arithmetic, step by step, in millimetres.
mod strict {
    use super::{Field, Intensities, Perception, Se2, SenseConfig, UNIT_INTENSITY, Vec2, diffused};

    /// The listing's π.
    #[expect(clippy::approx_constant, reason = "the listing's value is what is wanted")]
    const PI: f64 = 3.14;

    pub(super) fn sense(field: &Field, map_from_base: Se2, config: &SenseConfig) -> Intensities {
        // The listing converts degrees with 3.14/180; the true number of degrees comes in.
        let phi = map_from_base.yaw_rad / std::f64::consts::PI * PI;
        let (sin, cos) = phi.sin_cos();
        let (x, y) = (millimetres(map_from_base.x_m), millimetres(map_from_base.y_m));
        let half = 0.5 * millimetres(config.antenna_spacing_m);
        let right = Vec2::new((x + half * sin).floor(), (y - half * cos).floor());
        let left = Vec2::new((x - half * sin).floor(), (y + half * cos).floor());
        // The line through both antennas: a x + b y + c ≥ 0 in front.
        let a = left.y - right.y;
        let b = right.x - left.x;
        let c = left.x * right.y - right.x * left.y;
        let in_front = |cell: Vec2| a * cell.x + b * cell.y + c >= 0.0;
        Intensities {
            left: antenna(field, left, config, in_front),
            right: antenna(field, right, config, in_front),
        }
    }

    fn antenna(
        field: &Field,
        antenna: Vec2,
        config: &SenseConfig,
        in_front: impl Fn(Vec2) -> bool,
    ) -> f64 {
        let sigma = millimetres(config.sigma_m);
        let blind = 0.01 * millimetres(field.cell_size_m());
        let (mut s1, mut s2, mut scalar) = (0.0, 0.0, 0.0);
        field.visit_within(antenna / 1000.0, config.sigma_m, |_, _, in_map, value| {
            let cell = Vec2::new(millimetres(in_map.x), millimetres(in_map.y));
            let offset = cell - antenna;
            let d = offset.norm();
            if !in_front(cell) || d < blind {
                return;
            }
            let u = diffused(UNIT_INTENSITY * f64::from(value), d, sigma).floor();
            // sin φ and cos φ of φ = arcsin(Δx/d); the arcsine forgets the sign of Δy.
            s1 += u * offset.x / d;
            s2 += u * match config.perception {
                Perception::VectorAtan2 => offset.y / d,
                Perception::Listing | Perception::ScalarSum => offset.y.abs() / d,
            };
            scalar += u;
        });
        match config.perception {
            Perception::ScalarSum => scalar,
            Perception::Listing | Perception::VectorAtan2 => f64::hypot(s1, s2),
        }
    }

    /// Metres in millimetres; what should be whole is made whole, so that rounding down afterwards does not lose one.
    fn millimetres(metres: f64) -> f64 {
        let exact = metres * 1000.0;
        let whole = exact.round();
        if (exact - whole).abs() < 1e-6 { whole } else { exact }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact")]
#[path = "sense_tests.rs"]
mod tests;
