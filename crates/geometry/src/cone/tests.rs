//! Oracles: every candidate point tried by angles and Cramer's rule; parry2d along 2001 bearings.

use parry2d::math::{Pose2, Vec2 as ParryVec};
use parry2d::query::{Ray as ParryRay, RayCast};
use parry2d::shape::{Ball, Segment as ParrySegment};
use proptest::prelude::*;

use super::*;
use crate::{RayHit, SegmentWorld, wrap_to_pi};

const RANGE_M: f64 = 5.0;
const HALF_RAD: f64 = 0.261_799_387_799_149_4;

/// Walls and discs, offered one by one.
#[derive(Clone, Debug, Default)]
struct Things {
    walls: Vec<Segment>,
    discs: Vec<(Vec2, f64)>,
}

impl RayCaster for Things {
    fn cast(&self, _: &crate::Ray, _: f64) -> Option<RayHit> {
        None
    }
}

impl ConeScene for Things {
    fn show(&self, view: &mut ConeView) {
        for &(centre, radius_m) in &self.discs {
            view.offer_disc(centre, radius_m, 99);
        }
        for (tag, &wall) in (0..).zip(&self.walls) {
            view.offer_segment(wall, tag);
        }
    }
}

fn cone(sensor: Se2) -> Cone {
    Cone::new(sensor, HALF_RAD, RANGE_M)
}

fn nearest_m(cone: &Cone, scene: &impl ConeScene) -> Option<f64> {
    let view = cone.front(scene);
    let in_front = view.pieces().iter().map(|piece| piece.nearest().distance_m);
    let best = in_front.min_by(f64::total_cmp).filter(|&m| m <= RANGE_M);
    let nearest = cone.nearest(scene).map(|sighting| sighting.distance_m);
    assert!(!view.is_complete() || same(best, nearest), "front {best:?}, nearest {nearest:?}");
    nearest
}

/// The nearest point of a wall within the cone, of all that it can be: its foot, its ends, and
/// where it crosses an edge.
fn oracle_wall_m(sensor: Se2, wall: Segment) -> Option<f64> {
    let origin = sensor.position();
    let inside = |p: Vec2| {
        let to = p - origin;
        wrap_to_pi(to.y.atan2(to.x) - sensor.yaw_rad).abs() <= HALF_RAD + 1e-12
    };
    let along = wall.b - wall.a;
    let mut candidates = vec![wall.a, wall.b];
    let t = (origin - wall.a).dot(&along) / along.dot(&along);
    if (0.0..=1.0).contains(&t) {
        candidates.push(wall.a + t * along);
    }
    let mut best: Option<f64> = None;
    let mut offer = |d: f64| best = Some(best.map_or(d, |b| b.min(d)));
    candidates.into_iter().filter(|&p| inside(p)).for_each(|p| offer((p - origin).norm()));
    for side in [-HALF_RAD, HALF_RAD] {
        let (s, c) = (sensor.yaw_rad + side).sin_cos();
        // origin + d (c, s) = a + u along
        let det = s * along.x - c * along.y;
        let r = wall.a - origin;
        let (d, u) = ((r.y * along.x - r.x * along.y) / det, (c * r.y - s * r.x) / det);
        if d >= 0.0 && (0.0..=1.0).contains(&u) {
            offer(d);
        }
    }
    best.filter(|&d| d <= RANGE_M)
}

fn oracle_m(sensor: Se2, walls: &[Segment]) -> Option<f64> {
    walls.iter().filter_map(|&wall| oracle_wall_m(sensor, wall)).min_by(f64::total_cmp)
}

/// The nearest hit of anything along a bearing.
fn parry_m(sensor: Se2, bearing_rad: f64, things: &Things) -> Option<f64> {
    let (s, c) = (sensor.yaw_rad + bearing_rad).sin_cos();
    let ray = ParryRay::new(ParryVec::new(sensor.x_m, sensor.y_m), ParryVec::new(c, s));
    let walls = things.walls.iter().filter_map(|wall| {
        let v = |p: Vec2| ParryVec::new(p.x, p.y);
        ParrySegment::new(v(wall.a), v(wall.b)).cast_local_ray(&ray, RANGE_M, true)
    });
    let discs = things.discs.iter().filter_map(|&(centre, radius_m)| {
        let at = Pose2::translation(centre.x, centre.y);
        Ball::new(radius_m).cast_ray(&at, &ray, RANGE_M, true)
    });
    walls.chain(discs).min_by(f64::total_cmp)
}

fn square(centre: Vec2, side_m: f64, yaw_rad: f64) -> [Segment; 4] {
    let place = Se2::new(centre.x, centre.y, yaw_rad);
    let h = 0.5 * side_m;
    let corner = |x: f64, y: f64| place.transform_point(Vec2::new(x * h, y * h));
    let corners = [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)];
    std::array::from_fn(|i| Segment { a: corners[i], b: corners[(i + 1) % 4] })
}

fn same(a: Option<f64>, b: Option<f64>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() < 1e-8,
        (None, None) => true,
        // On the very edge, or at the very range.
        (Some(one), None) | (None, Some(one)) => (one - RANGE_M).abs() < 1e-8,
    }
}

/// The fault that this is for: a chair's leg of 4 cm fell between nine rays in most bearings.
#[test]
fn a_thin_leg_is_seen_at_every_bearing_of_the_cone() {
    for side_m in [0.005, 0.01, 0.02, 0.04, 0.06] {
        for distance_m in [0.2, 0.5, 1.0, 2.0, 4.0] {
            for step in -100..=100 {
                let bearing_rad = 0.0037 * f64::from(step);
                let centre = distance_m * Vec2::new(bearing_rad.cos(), bearing_rad.sin());
                let leg = square(centre, side_m, 1.3 * f64::from(step));
                let sensor = Se2::IDENTITY;
                let things = Things { walls: leg.to_vec(), ..Things::default() };
                let expected = oracle_m(sensor, &leg);
                let found = nearest_m(&cone(sensor), &things);
                assert!(
                    same(found, expected),
                    "{side_m} m at {distance_m} m, {bearing_rad} rad: {found:?}, not {expected:?}"
                );
                let world = SegmentWorld::new(leg.map(|wall| (wall, 0)));
                assert!(same(nearest_m(&cone(sensor), &world), expected));
            }
        }
    }
}

fn sensor() -> impl Strategy<Value = Se2> {
    (-2.0..2.0, -2.0..2.0, -3.1..3.1).prop_map(|(x, y, yaw)| Se2::new(x, y, yaw))
}

fn walls() -> impl Strategy<Value = Vec<Segment>> {
    let wall = (-4.0..4.0, -4.0..4.0, -3.1..3.1, 0.005..3.0_f64).prop_map(|(x, y, yaw, length)| {
        let (s, c) = f64::sin_cos(yaw);
        let a = Vec2::new(x, y);
        Segment { a, b: a + length * Vec2::new(c, s) }
    });
    proptest::collection::vec(wall, 0..40)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn the_nearest_point_is_the_best_of_all_candidates(sensor in sensor(), walls in walls()) {
        let expected = oracle_m(sensor, &walls);
        let world = SegmentWorld::new(walls.iter().map(|&wall| (wall, 0)));
        let things = Things { walls, ..Things::default() };
        prop_assert!(same(nearest_m(&cone(sensor), &things), expected));
        prop_assert!(same(nearest_m(&cone(sensor), &world), expected));
    }

    /// Along each of 2001 bearings the front is what the ray meets first, crossings included.
    #[test]
    fn the_front_is_what_rays_meet(
        sensor in sensor(), walls in walls(),
        discs in proptest::collection::vec((-4.0..4.0, -4.0..4.0, 0.01..0.5), 0..6),
    ) {
        let discs = discs.into_iter().map(|(x, y, r)| (Vec2::new(x, y), r)).collect();
        let things = Things { walls, discs };
        let inside_a_disc =
            things.discs.iter().any(|(c, r)| (c - sensor.position()).norm() <= *r);
        prop_assume!(!inside_a_disc);
        let view = cone(sensor).front(&things);
        prop_assert!(view.is_complete());
        let pieces = view.pieces();
        for pair in pieces.windows(2) {
            prop_assert!(pair[0].slopes()[1] <= pair[1].slopes()[0], "in order, apart");
        }
        let mut n_apart = 0;
        for step in -1000..=1000 {
            let bearing_rad = HALF_RAD * f64::from(step) / 1000.0;
            let slope = bearing_rad.tan();
            let expected = parry_m(sensor, bearing_rad, &things);
            let found = pieces
                .iter()
                .find(|piece| piece.slopes()[0] <= slope && slope <= piece.slopes()[1])
                .map(|piece| piece.at_slope(slope).distance_m)
                .filter(|&d| d <= RANGE_M);
            // A bearing may lie within rounding of an end.
            n_apart += usize::from(!match (found, expected) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-6 * b.max(1.0),
                (a, b) => a.is_none() == b.is_none(),
            });
        }
        prop_assert!(n_apart <= 1, "{n_apart} bearings of 2001");
    }

    /// Solid boxes show the sides that face the sensor, in a crowd that no front holds too.
    #[test]
    fn the_nearest_of_a_crowd_of_blocks_is_that_of_their_edges(
        sensor in sensor(),
        points in proptest::collection::vec((-60..60_i32, -60..60_i32), 1..600),
    ) {
        let side_m = 0.02;
        let centres: Vec<Vec2> = points
            .iter()
            .map(|&(i, j)| Vec2::new(0.06 * f64::from(i) + 0.013, 0.06 * f64::from(j) + 0.011))
            .collect();
        let edges: Vec<Segment> = centres.iter().flat_map(|&c| square(c, side_m, 0.0)).collect();
        let world = SegmentWorld::with_points([], centres.iter().map(|&c| (c, 0)), side_m);
        let inside = centres.iter().any(|c| (c - sensor.position()).amax() <= 0.5 * side_m);
        prop_assume!(!inside);
        let (found, expected) = (nearest_m(&cone(sensor), &world), oracle_m(sensor, &edges));
        prop_assert!(same(found, expected), "{:?}, not {:?}", found, expected);
    }
}

#[test]
fn what_stands_behind_is_seen_beside_what_hides_it() {
    // A leg at 1 m before a wall at 2 m: three pieces, the wall's nearest point beside the leg.
    let leg = square(Vec2::new(1.0, 0.0), 0.04, 0.0);
    let wall = Segment { a: Vec2::new(2.0, -3.0), b: Vec2::new(2.0, 3.0) };
    let walls = leg.into_iter().chain([wall]).collect();
    let things = Things { walls, ..Things::default() };
    let view = cone(Se2::IDENTITY).front(&things);
    let [right, leg, left] = view.pieces() else { panic!("{:?}", view.pieces()) };
    assert_eq!((right.nearest().tag, left.nearest().tag), (4, 4));
    assert!((leg.nearest().distance_m - 0.98).abs() < 1e-12);
    // The leg's near corners are at (0.98, ±0.02): past them the wall begins.
    let expected = 2.0 * f64::hypot(1.0, 0.02 / 0.98);
    assert!((left.nearest().distance_m - expected).abs() < 1e-9, "{left:?}");
    assert!((right.nearest().distance_m - expected).abs() < 1e-9, "{right:?}");
    assert!((left.nearest().cosine() - 2.0 / expected).abs() < 1e-9);
    // What the leg hides is not seen, what stands beside it is.
    let world = SegmentWorld::new(things.walls.iter().map(|&wall| (wall, 0)));
    let cone = cone(Se2::IDENTITY);
    let on_wall = |y: f64| {
        let point = Vec2::new(2.0, y);
        Sighting { point, distance_m: point.norm(), normal: Vec2::new(-1.0, 0.0), tag: 4 }
    };
    assert!(cone.sees(&on_wall(0.2), &world) && cone.sees(&on_wall(-0.2), &world));
    assert!(!cone.sees(&on_wall(0.0), &world));
}

#[test]
fn a_wall_seen_end_on_and_one_through_the_apex_count() {
    let sensor = Se2::IDENTITY;
    let at = |a: Vec2, b: Vec2| {
        let things = Things { walls: vec![Segment { a, b }], ..Things::default() };
        nearest_m(&cone(sensor), &things)
    };
    let end_on = at(Vec2::new(1.5, 0.0), Vec2::new(3.0, 0.0)).unwrap();
    assert!((end_on - 1.5).abs() < 1e-9, "{end_on}");
    assert!(at(Vec2::new(0.0, -1.0), Vec2::new(0.0, 1.0)).unwrap() < 1e-8);
    assert_eq!(at(Vec2::new(-0.001, -1.0), Vec2::new(-0.001, 1.0)), None);
    assert_eq!(at(Vec2::new(f64::NAN, -1.0), Vec2::new(1.0, 1.0)), None);
    // Something that ends on the cone's edge is in it.
    let (s, c) = HALF_RAD.sin_cos();
    let touch = at(Vec2::new(2.0 * c, 2.0 * s), Vec2::new(0.0, 3.0)).unwrap();
    assert!((touch - 2.0).abs() < 1e-8, "{touch}");
}

#[test]
fn a_disc_is_nearest_on_the_way_to_its_centre_or_at_the_edge() {
    let disc = |x: f64, y: f64, r: f64| {
        let things = Things { discs: vec![(Vec2::new(x, y), r)], ..Things::default() };
        nearest_m(&cone(Se2::IDENTITY), &things)
    };
    assert!((disc(2.0, 0.3, 0.2).unwrap() - (f64::hypot(2.0, 0.3) - 0.2)).abs() < 1e-9);
    // Centre beyond the edge: where the edge enters the disc.
    let (x, y, r) = (2.0, 0.65, 0.2);
    let (s, c) = HALF_RAD.sin_cos();
    let along = x * c + y * s;
    let aside = y * c - x * s;
    let expected = along - (r * r - aside * aside).sqrt();
    assert!((disc(x, y, r).unwrap() - expected).abs() < 1e-8);
    assert_eq!(disc(2.0, 0.9, 0.2), None);
    assert_eq!(disc(-2.0, 0.0, 0.2), None);
    assert!(disc(0.1, 0.0, 0.2).unwrap() < 1e-8);
}
