//! Straight walls, found by the arcs that touch them.
//!
//! A wall that a cone meets squarely answers with its perpendicular distance, from wherever inside
//! the cone its foot may lie. So while a sonar passes along a wall, all its arcs touch one line; two
//! of them fix it, more make it certain. A line holds what an arc cannot: a direction. Two echoes of
//! one wall taken a metre apart say how the robot turned in between, and a wall that goes on straight
//! says it for ever.
//!
//! Source: Leonard, Durrant-Whyte (1992), "Directed sonar sensing for mobile robot navigation", for
//! regions of constant depth and tangents; the fit and its use here are ours.

use std::ops::Range;

use geometry::{Se2, Vec2};

use crate::config::WallTrust;

/// A foot this far beyond the end of a wall still belongs to it, metres.
const END_SLACK_M: f64 = 0.08;

/// A straight wall seen from one side.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// A fixed point near it, about which direction and offset are told (m).
    pub anchor: Vec2,
    /// Direction of the normal, from the robot into the wall, radians.
    pub normal_rad: f64,
    /// From the anchor to the wall along the normal, metres.
    pub offset_m: f64,
    /// Where what was seen of it begins along the tangent (the normal turned left), from the anchor's
    /// foot, metres.
    pub from_m: f64,
    /// Where it ends, metres.
    pub to_m: f64,
    /// Echoes that were attributed to it.
    pub n_echoes: usize,
    /// Whether it has been compared with the directions of the others.
    pub(crate) is_squared: bool,
}

/// Arcs that touch one line: where the sensor was, and how far the echo.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    pub sensor: Se2,
    pub range_m: f64,
}

/// What a sonar measured before a list of arcs begins.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Before {
    Nothing,
    Silence,
    Echo(Arc),
}

/// A line through arcs.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub normal: Vec2,
    /// Its arcs, by their places in the list that was searched.
    pub arcs: Range<usize>,
    /// Feet of the perpendiculars of the first and the last arc.
    pub ends: [Vec2; 2],
}

impl Piece {
    /// The same piece after what it hangs on moved from one pose to another.
    pub(crate) fn moved(&self, from: Se2, to: Se2) -> Self {
        let motion = to.compose(from.inverse());
        Self {
            normal: motion.rotate(self.normal),
            arcs: self.arcs.clone(),
            ends: self.ends.map(|end| motion.transform_point(end)),
        }
    }
}

pub(crate) fn tangent_of(normal: Vec2) -> Vec2 {
    Vec2::new(-normal.y, normal.x)
}

impl Wall {
    /// Unit normal, from the robot into the wall.
    pub fn normal(&self) -> Vec2 {
        Vec2::new(self.normal_rad.cos(), self.normal_rad.sin())
    }

    /// Its ends, metres.
    pub fn ends(&self) -> [Vec2; 2] {
        let normal = self.normal();
        [self.from_m, self.to_m]
            .map(|t| self.anchor + normal * self.offset_m + tangent_of(normal) * t)
    }

    /// From a point in front of it to its line, metres; negative behind it.
    pub(crate) fn distance_m(&self, point: Vec2) -> f64 {
        self.normal().dot(&(self.anchor - point)) + self.offset_m
    }

    /// Where the foot of a point lies along the tangent, metres.
    pub(crate) fn along_m(&self, point: Vec2) -> f64 {
        tangent_of(self.normal()).dot(&(point - self.anchor))
    }

    /// How far the foot of a point lies beyond what was seen, metres; 0 within.
    pub(crate) fn beyond_m(&self, point: Vec2) -> f64 {
        let t = self.along_m(point);
        (self.from_m - t).max(t - self.to_m).max(0.0)
    }

    /// Whether the foot of a point lies on what was seen, with a little slack.
    pub(crate) fn is_seen_at(&self, point: Vec2) -> bool {
        self.beyond_m(point) <= END_SLACK_M
    }

    pub(crate) fn of(piece: &Piece) -> Self {
        Self {
            anchor: piece.ends[0],
            normal_rad: piece.normal.y.atan2(piece.normal.x),
            offset_m: 0.0,
            from_m: 0.0,
            to_m: 0.0,
            n_echoes: 0,
            is_squared: false,
        }
    }

    /// An echo whose sensor stood at `sensor` is one of this wall.
    pub(crate) fn take(&mut self, sensor: Vec2) {
        let t = self.along_m(sensor);
        if self.n_echoes == 0 {
            (self.from_m, self.to_m) = (t, t);
        }
        self.from_m = self.from_m.min(t);
        self.to_m = self.to_m.max(t);
        self.n_echoes += 1;
    }

    /// From the wall's end to the piece's nearer end along the wall, metres; negative where they
    /// overlap.
    pub(crate) fn gap_m(&self, piece: &Piece) -> f64 {
        let [a, b] = piece.ends.map(|end| self.along_m(end));
        (self.from_m - a.max(b)).max(a.min(b) - self.to_m)
    }
}

/// Lines that the arcs of one sonar touch, in the order in which it measured them.
///
/// Runs without a jump are fitted; where a run is not straight it is cut at its worst arc and both
/// parts are tried. O(n log n) on average.
///
/// At the edge of what stands out the arcs bend around the edge for as long as it is in the cone:
/// where a run begins or ends with a jump, so much of it is left out. `before` is the arc before the
/// first one, if there was an echo, or [`Before::Nothing`] at the begin of a recording; there, and where a
/// run is still going on, it is taken as it is.
pub(crate) fn pieces(
    arcs: &[Arc],
    before: Before,
    trust: &WallTrust,
    half_angle_rad: f64,
) -> Vec<Piece> {
    let mut found = Vec::new();
    let mut begin = 0;
    for i in 1..=arcs.len() {
        let goes_on = i == arcs.len();
        if goes_on || jumps(arcs[i - 1], arcs[i]) {
            let came_on = begin == 0
                && match before {
                    Before::Nothing => true,
                    Before::Silence => false,
                    Before::Echo(arc) => !jumps(arc, arcs[0]),
                };
            let mut run = begin..i;
            if !came_on {
                run.start += n_at_edge(arcs[run.clone()].iter(), half_angle_rad);
            }
            if !goes_on {
                let n = n_at_edge(arcs[run.clone()].iter().rev(), half_angle_rad);
                run.end -= n;
            }
            split(arcs, run, (trust, half_angle_rad), &mut found);
            begin = i;
        }
    }
    found
}

/// How many arcs from an end of a run on may be of an edge.
fn n_at_edge<'a>(mut arcs: impl Iterator<Item = &'a Arc>, half_angle_rad: f64) -> usize {
    let Some(first) = arcs.next() else { return 0 };
    let reach_m = first.range_m * half_angle_rad.tan();
    let near = |arc: &&Arc| (arc.sensor.position() - first.sensor.position()).norm() < reach_m;
    1 + arcs.take_while(near).count()
}

/// The echo moved more than the sonar could make it.
fn jumps(a: Arc, b: Arc) -> bool {
    let moved_m = (b.sensor.position() - a.sensor.position()).norm();
    (b.range_m - a.range_m).abs() > moved_m + 0.05
}

fn split(
    all: &[Arc],
    range: Range<usize>,
    (trust, half_angle_rad): (&WallTrust, f64),
    found: &mut Vec<Piece>,
) {
    let arcs = &all[range.clone()];
    if arcs.len() < trust.n_echoes_min.max(3) {
        return;
    }
    let Some(line) = Line::fit(arcs) else { return };
    let off = |arc: &Arc| (line.predicted_m(arc) - arc.range_m).abs();
    let rms_m = (arcs.iter().map(|a| off(a).powi(2)).sum::<f64>() / arcs.len() as f64).sqrt();
    let cos_half = half_angle_rad.cos();
    let is_square = arcs.iter().all(|arc| line.normal.dot(&arc.sensor.heading()) >= cos_half);
    if rms_m <= trust.straight_within_m && is_square {
        let tangent = tangent_of(line.normal);
        let along = arcs.iter().map(|arc| tangent.dot(&arc.sensor.position()));
        let (low, high) =
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
        if high - low >= trust.length_min_m {
            let foot = |a: &Arc| a.sensor.position() + line.normal * a.range_m;
            let ends = [foot(&arcs[0]), foot(&arcs[arcs.len() - 1])];
            found.push(Piece { normal: line.normal, arcs: range, ends });
        }
        return;
    }
    // The worst arc, but not so near an end that a part would be nothing.
    let inner = 1..arcs.len() - 1;
    let worst = inner.max_by(|&a, &b| off(&arcs[a]).total_cmp(&off(&arcs[b])).then(b.cmp(&a)));
    if let Some(worst) = worst {
        let middle = range.start + worst;
        split(all, range.start..middle, (trust, half_angle_rad), found);
        split(all, middle..range.end, (trust, half_angle_rad), found);
    }
}

/// A line that arcs touch: normal · sensor + range = offset for each.
#[derive(Clone, Copy, Debug)]
struct Line {
    normal: Vec2,
    offset_m: f64,
}

impl Line {
    /// Least squares over direction and offset, beginning along the middle arc's axis.
    fn fit(arcs: &[Arc]) -> Option<Self> {
        const N_ITERATIONS: usize = 8;
        let n = arcs.len() as f64;
        let mut yaw_rad = arcs[arcs.len() / 2].sensor.yaw_rad;
        for _ in 0..N_ITERATIONS {
            let normal = Se2::new(0.0, 0.0, yaw_rad).heading();
            let tangent = tangent_of(normal);
            let (mut t_sum, mut r_sum) = (0.0, 0.0);
            for arc in arcs {
                t_sum += tangent.dot(&arc.sensor.position());
                r_sum += normal.dot(&arc.sensor.position()) + arc.range_m;
            }
            let (t_mean, r_mean) = (t_sum / n, r_sum / n);
            let (mut tt, mut tr) = (0.0, 0.0);
            for arc in arcs {
                let t = tangent.dot(&arc.sensor.position()) - t_mean;
                tt += t * t;
                tr += t * (normal.dot(&arc.sensor.position()) + arc.range_m - r_mean);
            }
            if tt < 1e-6 {
                return None;
            }
            // d(normal · p)/dyaw = tangent · p: the residual's slope is undone by turning.
            let turn_rad = -tr / tt;
            yaw_rad += turn_rad.clamp(-0.3, 0.3);
            if turn_rad.abs() < 1e-9 {
                break;
            }
        }
        let normal = Se2::new(0.0, 0.0, yaw_rad).heading();
        let offsets = arcs.iter().map(|arc| normal.dot(&arc.sensor.position()) + arc.range_m);
        Some(Self { normal, offset_m: offsets.sum::<f64>() / n })
    }

    fn predicted_m(&self, arc: &Arc) -> f64 {
        self.offset_m - self.normal.dot(&arc.sensor.position())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: f64 = 0.2618;

    /// Arcs of a sonar that looks at `axis_deg` and moves along x, off a wall y = 1 and then y = 0.7.
    fn arcs(axis_deg: f64, n: usize, wall: impl Fn(f64) -> f64) -> Vec<Arc> {
        (0..n)
            .map(|i| {
                let x = 0.06 * i as f64;
                let wiggle = 0.004 * (i as f64 * 2.3).sin();
                let sensor = Se2::new(x, 0.0, axis_deg.to_radians());
                Arc { sensor, range_m: wall(x) + wiggle }
            })
            .collect()
    }

    fn offset_m(piece: &Piece) -> f64 {
        piece.normal.dot(&piece.ends[0])
    }

    #[test]
    fn a_wall_beside_the_way_is_found_wherever_in_the_cone_its_foot_lies() {
        for axis_deg in [80.0, 90.0, 100.0] {
            let found =
                pieces(&arcs(axis_deg, 30, |_| 1.0), Before::Nothing, &WallTrust::default(), HALF);
            assert_eq!(found.len(), 1, "{axis_deg}");
            assert!((found[0].normal - Vec2::new(0.0, 1.0)).norm() < 0.01, "{found:?}");
            assert!((offset_m(&found[0]) - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn a_step_in_the_wall_makes_two_pieces() {
        let step = |x: f64| if x < 1.5 { 1.0 } else { 0.7 };
        let found = pieces(&arcs(90.0, 50, step), Before::Nothing, &WallTrust::default(), HALF);
        assert_eq!(found.len(), 2);
        assert!((offset_m(&found[0]) - 1.0).abs() < 0.01);
        assert!((offset_m(&found[1]) - 0.7).abs() < 0.01);
        assert!(found[0].arcs.end <= found[1].arcs.start, "each arc is in one piece");
    }

    #[test]
    fn what_is_round_or_short_is_no_wall() {
        let post = |x: f64| ((x - 0.5).powi(2) + 0.25).sqrt() - 0.1;
        let trust = WallTrust { length_min_m: 0.8, ..WallTrust::default() };
        assert!(pieces(&arcs(90.0, 20, post), Before::Nothing, &trust, HALF).is_empty());
        assert!(
            pieces(&arcs(90.0, 4, |_| 1.0), Before::Nothing, &WallTrust::default(), HALF)
                .is_empty()
        );
    }
}
