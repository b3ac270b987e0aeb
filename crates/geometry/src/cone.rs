//! What is in sight within a cone: exactly, however thin a thing is.
//!
//! A fan of rays misses what stands between two of them. Here everything that reaches into the
//! cone is offered to a [`ConeView`], which keeps the front: for each bearing the nearest surface.
//! In slope across the cone and inverse depth along it straight walls stay straight, so that
//! fronts are compared at the ends of intervals and cross at most once. The nearest point of all
//! is never hidden, because what hides it would be nearer.
//!
//! Use it where the nearest surface in a cone is wanted, with what hides what; for a single line of
//! sight a [`RayCaster`] is quicker.
//!
//! Source: the plane sweep of visibility as a lower envelope of segments: Atallah (1983),
//! "Dynamic computational geometry", 24th Symposium on Foundations of Computer Science;
//! differences: surfaces are inserted one by one, because a cone shows few of them.

use crate::{Aabb, Ray, RayCaster, Se2, Segment, Vec2};

mod front;
mod piece;

use front::Front;
use piece::Surface;
pub use piece::{Piece, Sighting};

/// Surfaces nearer to the apex than this are at distance zero, metres.
const APEX_M: f64 = 1e-9;
/// Half the width, as a slope, that is given to what is met end-on or touches the edge in a point.
const END_ON: f64 = 1e-9;

/// Something that can show what of it may lie in a cone.
pub trait ConeScene: RayCaster {
    /// Whether it holds a crowd of small surfaces, as scanned maps do: more than a front has room for.
    /// They are shown to views that [want crowds](ConeView::wants_crowds) only.
    fn is_crowded(&self) -> bool {
        false
    }

    /// Offers every surface that may reach into the cone; more is allowed and costs time only.
    fn show(&self, view: &mut ConeView);
}

/// A cone with its apex at a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    world_from_sensor: Se2,
    /// Tangent of half the opening.
    edge: f64,
    axis: Vec2,
    range_max_m: f64,
}

impl Cone {
    /// A cone around x of the sensor; half of its opening, radians, is from 0 to π/4 and its edges
    /// belong to it. Nothing farther than `range_max_m` matters.
    pub fn new(world_from_sensor: Se2, half_angle_rad: f64, range_max_m: f64) -> Self {
        let edge = half_angle_rad.tan().clamp(END_ON, 1.0);
        Self { world_from_sensor, edge, axis: world_from_sensor.heading(), range_max_m }
    }

    /// Up to another range, metres.
    #[must_use]
    pub fn within(self, range_max_m: f64) -> Self {
        Self { range_max_m, ..self }
    }

    /// How far it reaches, metres.
    pub fn range_max_m(&self) -> f64 {
        self.range_max_m
    }

    /// Its apex, with x along the axis.
    pub fn world_from_sensor(&self) -> Se2 {
        self.world_from_sensor
    }

    /// The point nearest to the apex of anything in the cone, if there is one within the range.
    ///
    /// It is never hidden, because what hides it would be nearer. Does not allocate; about the cost
    /// of one or two ray casts.
    pub fn nearest(&self, scene: &impl ConeScene) -> Option<Sighting> {
        let mut view = ConeView::new(self, Wanted::Nearest);
        scene.show(&mut view);
        view.nearest.filter(|sighting| sighting.distance_m <= self.range_max_m)
    }

    /// The front of `scene`; of one that [is crowded](ConeScene::is_crowded) without its crowd.
    ///
    /// Does not allocate; the cost grows with the surfaces in sight.
    pub fn front(&self, scene: &impl ConeScene) -> ConeView {
        let mut view = ConeView::new(self, Wanted::Front);
        scene.show(&mut view);
        view.is_complete = !(view.front.overflows() || scene.is_crowded());
        view
    }

    /// Whether a point in the cone (in the sensor's frame) is hidden by nothing.
    pub fn sees(&self, sighting: &Sighting, scene: &impl ConeScene) -> bool {
        let before_m = sighting.distance_m - 1e-6;
        let slope = sighting.point.y / sighting.point.x;
        self.within(before_m.max(0.0)).cast(slope, scene).is_none()
    }

    /// The first thing along one line of sight, within the range.
    pub fn cast(&self, slope_ratio: f64, scene: &impl ConeScene) -> Option<Sighting> {
        let axis = self.axis;
        let in_sensor = Vec2::new(1.0, slope_ratio).normalize();
        let left = Vec2::new(-axis.y, axis.x);
        let direction = in_sensor.x * axis + in_sensor.y * left;
        let ray = Ray { origin: self.world_from_sensor.position(), direction };
        let hit = scene.cast(&ray, self.range_max_m)?;
        Some(Sighting {
            point: hit.distance_m * in_sensor,
            distance_m: hit.distance_m,
            normal: Vec2::new(axis.dot(&hit.normal), left.dot(&hit.normal)),
            tag: hit.tag,
        })
    }

    /// The first of `n` lines of sight whose slope is at least `slope_ratio`; `n` if there is none.
    pub fn first_slope_from(&self, slope_ratio: f64, n: usize) -> usize {
        if n < 2 {
            return if slope_ratio <= 0.0 { 0 } else { n };
        }
        let edge = self.edge;
        let steps = (slope_ratio / edge + 1.0) * 0.5 * (n - 1) as f64;
        let guess = steps.floor().clamp(0.0, n as f64) as usize;
        (guess..n).find(|&index| self.slope(index, n) >= slope_ratio).unwrap_or(n)
    }

    /// Slope (tangent of the bearing) of line of sight `index` of `n` over the cone, the first along
    /// its right edge, equally far apart; of a single one, the axis.
    pub fn slope(&self, index: usize, n: usize) -> f64 {
        if n < 2 {
            return 0.0;
        }
        self.edge * (2.0 * index as f64 / (n - 1) as f64 - 1.0)
    }
}

/// What a view is kept for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    Nearest,
    Front,
}

/// A scene within a cone, as it is being shown.
///
/// Places are in the sensor's frame, x along the axis of the cone.
#[derive(Clone, Debug)]
pub struct ConeView {
    origin: Vec2,
    axis: Vec2,
    /// Slopes of the two edges, the right one first.
    edges: [f64; 2],
    range_max_m: f64,
    /// Nothing deeper than this can be seen, metres along the axis.
    depth_limit_m: f64,
    front: Front,
    is_complete: bool,
    nearest: Option<Sighting>,
    wanted: Wanted,
}

impl ConeView {
    fn new(cone: &Cone, wanted: Wanted) -> Self {
        Self {
            origin: cone.world_from_sensor.position(),
            axis: cone.axis,
            edges: [-cone.edge, cone.edge],
            range_max_m: cone.range_max_m,
            depth_limit_m: cone.range_max_m,
            front: Front::new(),
            is_complete: false,
            nearest: None,
            wanted,
        }
    }

    /// Nothing that begins deeper than this along the axis can be in sight, metres; it falls as the
    /// front closes.
    #[inline]
    pub fn depth_limit_m(&self) -> f64 {
        self.depth_limit_m
    }

    /// Whether the front is all that is in sight: no crowd was left out, and everything had room.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// Whether a crowd is to be shown too, or only what is beside it.
    pub fn wants_crowds(&self) -> bool {
        self.wanted == Wanted::Nearest
    }

    /// What is in sight, from right to left; no two pieces overlap.
    pub fn pieces(&self) -> &[Piece] {
        self.front.pieces()
    }

    /// A direction of the sensor's frame, in the frame of the scene.
    fn direction_in_scene(&self, in_sensor: Vec2) -> Vec2 {
        let left = Vec2::new(-self.axis.y, self.axis.x);
        in_sensor.x * self.axis + in_sensor.y * left
    }

    /// A box around everything in the cone within its range, in the frame of the scene.
    pub fn bounds(&self) -> Aabb {
        let corner = |slope: f64| {
            self.origin + self.range_max_m * self.direction_in_scene(Vec2::new(1.0, slope))
        };
        Aabb::around([self.origin, corner(self.edges[0]), corner(self.edges[1])])
    }

    /// How deep along the axis (m) a box begins, if something in it might be seen; never more than
    /// the depth of anything in it.
    #[inline]
    pub fn depth_of_box(&self, bounds: Aabb) -> Option<f64> {
        let half = 0.5 * (bounds.max - bounds.min);
        let centre = self.in_sensor(bounds.min + half);
        let reach_x = self.axis.x.abs() * half.x + self.axis.y.abs() * half.y;
        let reach_y = self.axis.y.abs() * half.x + self.axis.x.abs() * half.y;
        self.depth_of(centre, reach_x, reach_y)
    }

    /// The cone for quick tests of many boxes whose coordinates are given from `middle`.
    pub(crate) fn coarse(&self, middle: Vec2, half_size_m: f64) -> CoarseCone {
        let apex = self.origin - middle;
        let [right, left] = self.edges;
        // Single precision errs by some 10 ε of the largest number involved; this is 16.
        let slack_m = (half_size_m + apex.amax()) / f64::from(1 << 20);
        CoarseCone {
            apex: [apex.x as f32, apex.y as f32],
            axis: [self.axis.x as f32, self.axis.y as f32],
            reach: [self.axis.x.abs() as f32, self.axis.y.abs() as f32],
            edges: [right as f32, left as f32],
            slack_m: slack_m as f32,
        }
    }

    /// Whether something within `radius_m` of `centre` (m, in the scene) might be seen.
    pub fn may_see_disc(&self, centre: Vec2, radius_m: f64) -> bool {
        self.depth_of(self.in_sensor(centre), radius_m, radius_m).is_some()
    }

    /// The same for a box in the sensor's frame; `None` is certain, `Some` is not.
    #[inline]
    fn depth_of(&self, centre: Vec2, reach_x: f64, reach_y: f64) -> Option<f64> {
        let (near_m, far_m) = (centre.x - reach_x, centre.x + reach_x);
        let [right, left] = self.edges;
        let above = centre.y - right * centre.x + reach_y + right.abs() * reach_x;
        let below = left * centre.x - centre.y + reach_y + left.abs() * reach_x;
        let seen = near_m <= self.depth_limit_m && far_m >= 0.0 && above >= 0.0 && below >= 0.0;
        if !seen {
            return None;
        }
        Some(near_m)
    }

    /// A point of the scene in the sensor's frame (m).
    #[inline]
    fn in_sensor(&self, point: Vec2) -> Vec2 {
        let from_apex = point - self.origin;
        Vec2::new(self.axis.dot(&from_apex), self.axis.perp(&from_apex))
    }

    /// Offers a wall (m, in the scene). Both sides of it can be seen, and its ends.
    pub fn offer_segment(&mut self, segment: Segment, tag: u32) {
        let (a, b) = (self.in_sensor(segment.a), self.in_sensor(segment.b));
        let [right, left] = self.edges;
        let (a_right, b_right) = (a.y - right * a.x, b.y - right * b.x);
        let (a_left, b_left) = (left * a.x - a.y, left * b.x - b.y);
        let outside = |p: f64, q: f64| p < 0.0 && q < 0.0;
        let too_deep = a.x > self.depth_limit_m && b.x > self.depth_limit_m;
        if outside(a_right, b_right) || outside(a_left, b_left) || too_deep {
            return;
        }
        let mut part = [0.0, 1.0];
        cut(&mut part, a_right, b_right);
        cut(&mut part, a_left, b_left);
        let [from, to] = part;
        if from > to || from.is_nan() || to.is_nan() {
            return;
        }
        let (start, end) = (
            if from > 0.0 { a + from * (b - a) } else { a },
            if to < 1.0 { a + to * (b - a) } else { b },
        );
        if start.x.min(end.x) < APEX_M {
            self.cover(tag);
            return;
        }
        let (from_slope, to_slope) = (self.slope(start), self.slope(end));
        let depths = [1.0 / start.x, 1.0 / end.x];
        let piece = if (to_slope - from_slope).abs() < END_ON {
            let middle = 0.5 * (from_slope + to_slope);
            let slopes = [(middle - END_ON).max(right), (middle + END_ON).min(left)];
            Piece::new(slopes, Surface::Line { inverse: [depths[0].max(depths[1]); 2] }, tag)
        } else if from_slope < to_slope {
            Piece::new([from_slope, to_slope], Surface::Line { inverse: depths }, tag)
        } else {
            let inverse = [depths[1], depths[0]];
            Piece::new([to_slope, from_slope], Surface::Line { inverse }, tag)
        };
        self.insert(piece);
    }

    /// Offers a solid box with sides along the axes of the scene; from inside it is at distance 0.
    pub fn offer_box(&mut self, bounds: Aabb, tag: u32) {
        let Aabb { min, max } = bounds;
        if bounds.contains(self.origin) {
            self.cover(tag);
            return;
        }
        let corner = Vec2::new;
        let sides = [
            (self.origin.x < min.x, min, corner(min.x, max.y)),
            (self.origin.x > max.x, corner(max.x, min.y), max),
            (self.origin.y < min.y, min, corner(max.x, min.y)),
            (self.origin.y > max.y, corner(min.x, max.y), max),
        ];
        for (faces, a, b) in sides {
            if faces {
                self.offer_segment(Segment { a, b }, tag);
            }
        }
    }

    /// Offers a solid disc (m, in the scene); from inside it is at distance 0.
    pub fn offer_disc(&mut self, centre: Vec2, radius_m: f64, tag: u32) {
        if !self.may_see_disc(centre, radius_m) {
            return;
        }
        let centre = self.in_sensor(centre);
        let distance_m = centre.norm();
        if distance_m <= radius_m + APEX_M {
            self.cover(tag);
            return;
        }
        let bearing_rad = centre.y.atan2(centre.x);
        let half_rad = (radius_m / distance_m).asin();
        let [right, left] = self.edges;
        let (low_rad, high_rad) =
            ((bearing_rad - half_rad).max(right.atan()), (bearing_rad + half_rad).min(left.atan()));
        if low_rad > high_rad {
            return;
        }
        let slopes = [low_rad.tan().max(right), high_rad.tan().min(left)];
        if slopes[1] - slopes[0] < END_ON {
            return;
        }
        self.insert(Piece::new(slopes, Surface::Disc { centre, radius_m }, tag));
    }

    /// Something at the apex hides everything.
    fn cover(&mut self, tag: u32) {
        let surface = Surface::Line { inverse: [1.0 / APEX_M; 2] };
        self.insert(Piece::new(self.edges, surface, tag));
    }

    fn insert(&mut self, piece: Piece) {
        if self.wanted == Wanted::Nearest {
            let sighting = piece.nearest();
            if self.nearest.is_none_or(|best| sighting.distance_m < best.distance_m) {
                self.depth_limit_m = self.depth_limit_m.min(sighting.distance_m);
                self.nearest = Some(sighting);
            }
            return;
        }
        if self.front.insert(piece)
            && let Some(depth_m) = self.front.depth_where_closed(self.edges)
        {
            self.depth_limit_m = self.depth_limit_m.min(depth_m);
        }
        if self.front.overflows() {
            // There is no room for more.
            self.depth_limit_m = f64::NEG_INFINITY;
        }
    }

    /// The slope of a point of the cone; exactly that of the edge where it lies on one.
    fn slope(&self, point: Vec2) -> f64 {
        let slope = point.y / point.x;
        let [right, left] = self.edges;
        let snap = 1e-12;
        if slope - right < snap {
            right
        } else if left - slope < snap {
            left
        } else {
            slope
        }
    }
}

/// A cone in single precision; see [`ConeView::coarse`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoarseCone {
    apex: [f32; 2],
    axis: [f32; 2],
    reach: [f32; 2],
    edges: [f32; 2],
    slack_m: f32,
}

impl CoarseCone {
    /// How deep along the axis (m) each of some boxes begins (min x, min y, max x, max y, each of all
    /// boxes), not more than anything in it; infinite where it is outside the cone's edges.
    #[inline]
    pub(crate) fn depths<const N: usize>(&self, boxes: &[[f32; N]; 4]) -> [f32; N] {
        let [min_x, min_y, max_x, max_y] = boxes;
        let ([axis_x, axis_y], [reach_x, reach_y]) = (self.axis, self.reach);
        let [right, left] = self.edges;
        let mut depths = [0.0; N];
        for i in 0..N {
            let (half_x, half_y) = (0.5 * (max_x[i] - min_x[i]), 0.5 * (max_y[i] - min_y[i]));
            let (x, y) = (min_x[i] + half_x - self.apex[0], min_y[i] + half_y - self.apex[1]);
            let (along, across) = (axis_x * x + axis_y * y, axis_x * y - axis_y * x);
            let reach_along = reach_x * half_x + reach_y * half_y + self.slack_m;
            let reach_across = reach_y * half_x + reach_x * half_y + self.slack_m;
            let above = across - right * along + reach_across + right.abs() * reach_along;
            let below = left * along - across + reach_across + left.abs() * reach_along;
            let outside = (along + reach_along).min(above).min(below) < 0.0;
            depths[i] = if outside { f32::INFINITY } else { along - reach_along };
        }
        depths
    }
}

/// Keeps of a part of a segment what lies on the positive side, for the sides of its two ends.
#[inline]
fn cut(part: &mut [f64; 2], at_a: f64, at_b: f64) {
    if at_a < 0.0 {
        part[0] = part[0].max(at_a / (at_a - at_b));
    }
    if at_b < 0.0 {
        part[1] = part[1].min(at_a / (at_a - at_b));
    }
}

#[cfg(test)]
mod tests;
