//! The source's local map of one row of readings.

use sensor_models::{ArcProfile, Region};

/// One sonar of the ring, in the source's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassicSonar {
    /// Forward of the robot's centre.
    pub x_mm: f64,
    /// Left of it.
    pub y_mm: f64,
    /// Direction of the axis from straight ahead, counter-clockwise positive.
    pub azimuth_deg: f64,
}

/// The eight sonars of the annex's program, left to right.
pub const LISTING_RING: [ClassicSonar; 8] = [
    sonar(69.0, 136.0, 90.0),
    sonar(114.0, 119.0, 50.0),
    sonar(148.0, 78.0, 30.0),
    sonar(166.0, 27.0, 10.0),
    sonar(166.0, -27.0, -10.0),
    sonar(148.0, -78.0, -30.0),
    sonar(114.0, -119.0, -50.0),
    sonar(69.0, -136.0, -90.0),
];

const fn sonar(x_mm: f64, y_mm: f64, azimuth_deg: f64) -> ClassicSonar {
    ClassicSonar { x_mm, y_mm, azimuth_deg }
}

/// How a row of readings becomes a local map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelShape {
    /// The law of probabilities.
    pub profile: ArcProfile,
    /// Half of the cone's opening; 7 in the annex.
    pub half_angle_deg: f64,
    /// Side of a cell; 35 in the annex.
    pub scale_mm: f64,
    /// Rows and columns; 150 in the annex. The robot is in the middle: row and column 75 of 150.
    pub n_cells: usize,
    /// Only nearer readings are used; 2000 in the annex.
    pub reading_below_mm: f64,
}

/// A cell near a sonar.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConeCell {
    /// Of the local map, counted from 1.
    pub row: usize,
    /// Of the local map, counted from 1.
    pub column: usize,
    range_cells: f64,
    off_ratio: f64,
    reading_cells: f64,
}

impl ModelShape {
    /// What the profile says of a cell.
    pub(super) fn occupied_prob(&self, cell: &ConeCell) -> Option<f64> {
        self.profile.occupied_prob(cell.range_cells, cell.off_ratio, cell.reading_cells)
    }

    /// Where the cell lies for the reading.
    pub(super) fn region(&self, cell: &ConeCell) -> Region {
        self.profile.region(cell.range_cells, cell.off_ratio, cell.reading_cells)
    }

    /// Hands out all cells of the local map within a reading's range of the sonar, whatever their
    /// angle.
    pub(super) fn visit_cone(
        &self,
        sonar: &ClassicSonar,
        reading_mm: f64,
        heading_deg: f64,
        mut visit: impl FnMut(ConeCell),
    ) {
        let (sin, cos) = heading_deg.to_radians().sin_cos();
        let x = (sonar.x_mm * cos - sonar.y_mm * sin) / self.scale_mm;
        let y = (sonar.x_mm * sin + sonar.y_mm * cos) / self.scale_mm;
        let axis_deg = sonar.azimuth_deg + heading_deg;
        let reading_cells = reading_mm / self.scale_mm;
        let reach = reading_cells + self.profile.tolerance_behind_cells;
        let half = (self.n_cells / 2) as f64;
        // Counted from 1: cell i lies at i − n/2.
        let span = |centre: f64| {
            let first = (centre - reach + half).ceil().max(1.0) as usize;
            let last = (centre + reach + half).floor().clamp(0.0, self.n_cells as f64) as usize;
            first..=last
        };
        for row in span(x) {
            let dx = row as f64 - half - x;
            for column in span(y) {
                let dy = column as f64 - half - y;
                let range_cells = (dx * dx + dy * dy).sqrt();
                if range_cells > reach {
                    continue;
                }
                let off_deg = turned_deg(dy.atan2(dx).to_degrees() - axis_deg);
                let off_ratio = off_deg / self.half_angle_deg;
                visit(ConeCell { row, column, range_cells, off_ratio, reading_cells });
            }
        }
    }

    /// The annex's numbers.
    pub const fn listing() -> Self {
        Self {
            profile: ArcProfile::listing(),
            half_angle_deg: 7.0,
            scale_mm: 35.0,
            n_cells: 150,
            reading_below_mm: 2000.0,
        }
    }
}

/// Probabilities around the robot by one row of readings; NaN where none says anything.
///
/// Row r and column c, counted from 1, lie (r − n/2, c − n/2) cells forward and left of the robot
/// at heading 0. Where cones overlap, the sonar that comes later in the ring has the last word.
#[derive(Clone, Debug)]
pub struct LocalMap {
    n_cells: usize,
    probs: Vec<f64>,
}

impl LocalMap {
    /// A map of which nothing is known.
    pub fn new(n_cells: usize) -> Self {
        Self { n_cells, probs: vec![f64::NAN; n_cells * n_cells] }
    }

    /// Replaces the content by what the ring says at `heading_deg`; one reading (mm) for each sonar,
    /// further ones are not looked at. Does not allocate.
    pub fn fill(
        &mut self,
        shape: &ModelShape,
        ring: &[ClassicSonar],
        readings_mm: &[f64],
        heading_deg: f64,
    ) {
        self.probs.fill(f64::NAN);
        for (sonar, &reading_mm) in ring.iter().zip(readings_mm) {
            if reading_mm < shape.reading_below_mm {
                self.add_cone(shape, sonar, reading_mm, heading_deg);
            }
        }
    }

    /// Probability at a row and column counted from 1, or `None` where nothing is known.
    pub fn prob(&self, row: usize, column: usize) -> Option<f64> {
        let prob = *self.probs.get((row - 1) * self.n_cells + column - 1)?;
        (!prob.is_nan()).then_some(prob)
    }

    /// Cells of a row, counted from 0; NaN where nothing is known.
    pub(super) fn row(&self, row: usize) -> &[f64] {
        &self.probs[row * self.n_cells..(row + 1) * self.n_cells]
    }

    fn add_cone(
        &mut self,
        shape: &ModelShape,
        sonar: &ClassicSonar,
        reading_mm: f64,
        heading_deg: f64,
    ) {
        shape.visit_cone(sonar, reading_mm, heading_deg, |cell| {
            if let Some(prob) = shape.occupied_prob(&cell) {
                self.probs[(cell.row - 1) * self.n_cells + cell.column - 1] = prob;
            }
        });
    }
}

/// The angle's size, at most half a turn.
fn turned_deg(angle_deg: f64) -> f64 {
    let angle_deg = angle_deg.abs() % 360.0;
    if angle_deg > 180.0 { 360.0 - angle_deg } else { angle_deg }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells, sum, cells above one half, greatest and smallest with their places.
    struct Sums {
        n: usize,
        sum: f64,
        n_above: usize,
        max: (f64, usize, usize),
        min: (f64, usize, usize),
    }

    fn sums(shape: &ModelShape, readings_mm: [f64; 8], heading_deg: f64) -> Sums {
        let mut map = LocalMap::new(shape.n_cells);
        map.fill(shape, &LISTING_RING, &readings_mm, heading_deg);
        let mut s = Sums { n: 0, sum: 0.0, n_above: 0, max: (0.0, 0, 0), min: (9.0, 0, 0) };
        for row in 1..=150 {
            for column in 1..=150 {
                let Some(p) = map.prob(row, column) else { continue };
                s.n += 1;
                s.sum += p;
                s.n_above += usize::from(p > 0.5);
                if p > s.max.0 {
                    s.max = (p, row, column);
                }
                if p < s.min.0 {
                    s.min = (p, row, column);
                }
            }
        }
        s
    }

    const SILENT: f64 = 5000.0;

    fn only(sonars: &[usize], mm: f64) -> [f64; 8] {
        let mut readings = [SILENT; 8];
        for &sonar in sonars {
            readings[sonar - 1] = mm;
        }
        readings
    }

    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 5.1e-10, "{found}, not {expected}");
    }

    #[test]
    fn one_sonar_at_700_mm() {
        let shape = ModelShape::listing();
        let s = sums(&shape, only(&[4], 700.0), 0.0);
        assert_eq!((s.n, s.n_above), (52, 7));
        close(s.sum, 15.744_390_021);
        close(s.max.0, 0.789_116_724);
        assert_eq!((s.max.1, s.max.2), (99, 79));
        close(s.min.0, 0.023_173_462);
        assert_eq!((s.min.1, s.min.2), (81, 76));

        let mut map = LocalMap::new(150);
        map.fill(&shape, &LISTING_RING, &only(&[4], 700.0), 0.0);
        close(map.prob(85, 77).unwrap(), 0.164_543_883);
        close(map.prob(95, 79).unwrap(), 0.219_527_909);
        close(map.prob(99, 80).unwrap(), 0.720_750_207);
        assert_eq!(map.prob(100, 79), None);

        let turned = sums(&shape, only(&[4], 700.0), 90.0);
        assert_eq!((turned.n, turned.max.1, turned.max.2), (52, 71, 99));
        close(turned.sum, 15.744_390_021);
    }

    #[test]
    fn several_sonars_and_far_ones() {
        let shape = ModelShape::listing();
        let sides = sums(&shape, only(&[1, 8], 500.0), 0.0);
        // Left and right mirror each other: the maximum is on both sides, but for the last bit.
        assert_eq!((sides.n, sides.max.1), (54, 77));
        assert!(sides.max.2 == 93 || sides.max.2 == 57, "{}", sides.max.2);
        close(sides.sum, 13.219_826_518);
        close(sides.max.0, 0.852_940_315);

        let all = sums(&shape, [700.0; 8], 30.0);
        assert_eq!((all.n, all.n_above), (416, 61));
        close(all.sum, 129.209_137_916);

        let far = sums(&shape, only(&[4], 1900.0), 0.0);
        assert_eq!((far.n, far.n_above), (367, 153));
        close(far.sum, 168.131_184_594);
        let fixed = ModelShape { profile: ArcProfile::fixed(), ..shape };
        let far = sums(&fixed, only(&[4], 1900.0), 0.0);
        assert_eq!((far.n, far.n_above), (367, 21));
        close(far.sum, 98.512_567_890);

        let farthest = sums(&shape, [1999.0; 8], 0.0);
        assert_eq!((farthest.n, farthest.n_above), (3256, 1520));
        close(farthest.sum, 1_544.476_079_235);
        assert_eq!(sums(&shape, [2000.0; 8], 0.0).n, 0);
    }

    #[test]
    fn readings_that_are_no_numbers_say_nothing() {
        let shape = ModelShape::listing();
        assert_eq!(sums(&shape, [f64::NAN; 8], 0.0).n, 0);
        assert_eq!(sums(&shape, [-300.0; 8], 0.0).n, 0);
        assert_eq!(sums(&shape, [f64::INFINITY; 8], 0.0).n, 0);
    }
}
