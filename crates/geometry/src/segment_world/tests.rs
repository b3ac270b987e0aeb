//! Against loops over all primitives with formulas of their own, and against parry2d.

use std::{f64::consts::TAU, io::Read};

use parry2d::{
    math::{Pose2, Vec2 as ParryVec},
    query::{Ray as ParryRay, RayCast},
    shape,
};
use proptest::prelude::*;

use super::*;

const POINT_M: f64 = 0.1;

fn v(x: f64, y: f64) -> Vec2 {
    Vec2::new(x, y)
}

fn wall(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
    Segment { a: v(ax, ay), b: v(bx, by) }
}

fn ray(x: f64, y: f64, angle: f64) -> Ray {
    Ray { origin: v(x, y), direction: v(angle.cos(), angle.sin()) }
}

/// A wall of one metre's grid or of anywhere, some without length.
fn any_wall() -> impl Strategy<Value = Segment> {
    let whole = || (-8..=8_i32).prop_map(f64::from);
    let free = || -8.0..8.0_f64;
    prop_oneof![
        (whole(), whole(), whole(), whole()).prop_map(|(a, b, c, d)| wall(a, b, c, d)),
        (free(), free(), free(), free()).prop_map(|(a, b, c, d)| wall(a, b, c, d)),
        (free(), free()).prop_map(|(a, b)| wall(a, b, a, b)),
    ]
}

/// Points on a common raster, where they are merged, and off it.
fn any_point() -> impl Strategy<Value = Vec2> {
    prop_oneof![
        4 => (-20..20_i32, -20..20_i32).prop_map(|(x, y)| v(f64::from(x), f64::from(y)) * POINT_M),
        1 => (-8.0..8.0_f64, -8.0..8.0_f64).prop_map(|(x, y)| v(x, y)),
    ]
}

type Parts = (Vec<Segment>, Vec<Vec2>);

fn any_parts() -> impl Strategy<Value = Parts> {
    (proptest::collection::vec(any_wall(), 0..40), proptest::collection::vec(any_point(), 0..60))
}

fn build((walls, points): &Parts) -> SegmentWorld {
    let walls = walls.iter().copied().zip(0..);
    let points = points.iter().copied().zip(1000..);
    SegmentWorld::with_points(walls, points, POINT_M)
}

/// The same world with one tag for all points, so that they can be merged.
fn build_merged((walls, points): &Parts) -> SegmentWorld {
    let walls = walls.iter().copied().zip(0..);
    SegmentWorld::with_points(walls, points.iter().map(|&p| (p, 1000)), POINT_M)
}

/// Oracle: Cramer's rule on o + t d = a + s (b - a). Parallel ones are never met here.
fn wall_by_definition(r: &Ray, w: Segment) -> Option<f64> {
    let (ox, oy, dx, dy) = (r.origin.x, r.origin.y, r.direction.x, r.direction.y);
    let (ex, ey) = (w.b.x - w.a.x, w.b.y - w.a.y);
    let det = ex * dy - ey * dx;
    let (px, py) = (w.a.x - ox, w.a.y - oy);
    let t = (ex * py - ey * px) / det;
    let s = (dx * py - dy * px) / det;
    (det != 0.0 && t >= 0.0 && (0.0..=1.0).contains(&s)).then_some(t)
}

/// Oracle: a square is met at its nearest side, or at once from inside.
fn square_by_definition(r: &Ray, centre: Vec2) -> Option<f64> {
    let h = 0.5 * POINT_M;
    if (r.origin.x - centre.x).abs() <= h && (r.origin.y - centre.y).abs() <= h {
        return Some(0.0);
    }
    let c = [(-h, -h), (h, -h), (h, h), (-h, h)].map(|(x, y)| v(centre.x + x, centre.y + y));
    let sides =
        (0..4).filter_map(|i| wall_by_definition(r, Segment { a: c[i], b: c[(i + 1) % 4] }));
    sides.min_by(f64::total_cmp)
}

fn cast_by_definition((walls, points): &Parts, r: &Ray, range_m: f64) -> Option<f64> {
    let walls = walls.iter().filter_map(|&w| wall_by_definition(r, w));
    let squares = points.iter().filter_map(|&p| square_by_definition(r, p));
    walls.chain(squares).filter(|&t| t <= range_m).min_by(f64::total_cmp)
}

fn cast_by_parry((walls, points): &Parts, r: &Ray, range_m: f64) -> Option<f64> {
    let ours = |p: Vec2| ParryVec::new(p.x, p.y);
    let theirs = ParryRay::new(ours(r.origin), ours(r.direction));
    let square = shape::Cuboid::new(ParryVec::new(0.5 * POINT_M, 0.5 * POINT_M));
    let walls = walls.iter().filter_map(|w| {
        shape::Segment::new(ours(w.a), ours(w.b)).cast_local_ray(&theirs, range_m, true)
    });
    let squares = points.iter().filter_map(|p| {
        let place = Pose2::translation(p.x, p.y);
        square.cast_ray(&place, &theirs, range_m, true)
    });
    walls.chain(squares).min_by(f64::total_cmp)
}

/// Whether the ray passes so near an end or a corner that rounding may decide.
fn is_close_call((walls, points): &Parts, r: &Ray) -> bool {
    let h = 0.5 * POINT_M;
    let corner = |p: &Vec2| [(-h, -h), (h, -h), (h, h), (-h, h)].map(|(x, y)| p + v(x, y));
    let ends = walls.iter().flat_map(|w| [w.a, w.b]).chain(points.iter().flat_map(corner));
    let mut near = ends.map(|p| (p - r.origin).perp(&r.direction).abs());
    let starts_on = |w: &Segment| w.distance(r.origin) < 1e-9;
    near.any(|across| across < 1e-9) || walls.iter().any(starts_on)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn casts_agree_with_the_definition_and_with_parry(
        parts in any_parts(),
        rays in proptest::collection::vec((-9.0..9.0, -9.0..9.0, 0.0..TAU), 20),
        range in prop_oneof![Just(0.5), Just(5.0), Just(f64::INFINITY)],
    ) {
        let (world, merged) = (build(&parts), build_merged(&parts));
        let without_grid = SegmentWorld { grid: None, ..world.clone() };
        for (x, y, angle) in rays {
            let r = ray(x, y, angle);
            prop_assert_eq!(world.cast(&r, range), without_grid.cast(&r, range));
            let found = world.cast(&r, range).map(|h| h.distance_m);
            prop_assert_eq!(found, merged.cast(&r, range).map(|h| h.distance_m));
            if is_close_call(&parts, &r) {
                continue;
            }
            let far = if range.is_finite() { range } else { 1e9 };
            for wanted in [cast_by_definition(&parts, &r, range), cast_by_parry(&parts, &r, far)] {
                prop_assert_eq!(found.is_some(), wanted.is_some(), "{:?} {:?}", found, wanted);
                let apart = found.unwrap_or(0.0) - wanted.unwrap_or(0.0);
                prop_assert!(apart.abs() < 1e-9, "{:?} {:?}", found, wanted);
            }
        }
    }

    /// A ray at an end point must meet the wall, or else go on past it: never come to a stop
    /// before it, and never pass a corner that two walls close.
    #[test]
    fn a_ray_at_a_corner_never_slips_through(
        (x, y) in (-8.0..8.0, -8.0..8.0),
        (cx, cy) in (-8.0..8.0, -8.0..8.0),
    ) {
        let corner = v(cx, cy);
        let way = corner - v(x, y);
        prop_assume!(way.norm() > 0.1);
        let across = v(-way.y, way.x);
        let walls = [
            Segment { a: corner, b: corner + across - 0.1 * way },
            Segment { a: corner - across + 0.3 * way, b: corner },
        ];
        let world = SegmentWorld::new(walls.into_iter().zip(0..));
        let hit = world.cast(&Ray { origin: v(x, y), direction: way.normalize() }, 100.0);
        let hit = hit.expect("the corner is closed");
        prop_assert!((hit.distance_m - way.norm()).abs() < 1e-9);
        prop_assert!(world.is_blocked(v(x, y), corner + 0.1 * way));
        prop_assert!(!world.is_blocked(v(x, y), corner - 0.1 * way));
    }

    /// Normals are unit vectors against the ray; the hit point lies on what was hit.
    #[test]
    fn a_hit_lies_on_its_surface_and_faces_the_ray(
        parts in any_parts(), x in -9.0..9.0, y in -9.0..9.0, angle in 0.0..TAU,
    ) {
        let r = ray(x, y, angle);
        let Some(hit) = build(&parts).cast(&r, 30.0) else { return Ok(()) };
        let point = r.origin + hit.distance_m * r.direction;
        prop_assert!((hit.normal.norm() - 1.0).abs() < 1e-9);
        prop_assert!(hit.normal.dot(&r.direction) <= 0.0);
        let off = match hit.tag.checked_sub(1000) {
            None => parts.0[hit.tag as usize].distance(point),
            Some(i) => ((point - parts.1[i as usize]).amax() - 0.5 * POINT_M).max(0.0),
        };
        prop_assert!(off < 1e-6, "{off} m off the surface");
    }

    #[test]
    fn the_nearest_distance_agrees_with_looking_at_everything(
        parts in any_parts(), x in -9.0..9.0, y in -9.0..9.0, within in 0.0..5.0_f64,
    ) {
        let to_wall = |w: &Segment| {
            // Oracle: ternary search for the least distance, which is convex along the wall.
            let (mut low, mut high) = (0.0, 1.0);
            let at = |s: f64| {
                f64::hypot(w.a.x + s * (w.b.x - w.a.x) - x, w.a.y + s * (w.b.y - w.a.y) - y)
            };
            for _ in 0..100 {
                let (p, q) = ((2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0);
                if at(p) < at(q) { high = q } else { low = p }
            }
            at(low)
        };
        let to_square = |p: &Vec2| {
            let beyond = |d: f64| (d.abs() - 0.5 * POINT_M).max(0.0);
            beyond(x - p.x).hypot(beyond(y - p.y))
        };
        let all = parts.0.iter().map(to_wall).chain(parts.1.iter().map(to_square));
        let best = all.fold(f64::INFINITY, f64::min);
        prop_assume!((best - within).abs() > 1e-9);
        for world in [build(&parts), build_merged(&parts)] {
            let found = world.nearest_distance(v(x, y), within);
            prop_assert_eq!(found.is_some(), best < within);
            prop_assert!(found.is_none_or(|found| (found - best).abs() < 1e-7));
        }
    }

    /// Oracle: parry's distance between convex figures.
    #[test]
    fn touching_a_polygon_agrees_with_parry(
        parts in any_parts(),
        (x, y, angle) in (-8.0..8.0, -8.0..8.0, 0.0..TAU),
        (length, width) in (0.05..3.0, 0.05..1.0),
    ) {
        let pose = crate::Se2::new(x, y, angle);
        let corners = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.5), (-1.0, -0.5)]
            .map(|(a, b)| pose.transform_point(v(a * length, b * width)));
        let theirs: Vec<_> = corners.iter().map(|c| ParryVec::new(c.x, c.y)).collect();
        let theirs = shape::ConvexPolygon::from_convex_polyline(theirs).unwrap();
        let here = Pose2::IDENTITY;
        let gap_to_wall = |w: &Segment| {
            let s = shape::Segment::new(ParryVec::new(w.a.x, w.a.y), ParryVec::new(w.b.x, w.b.y));
            parry2d::query::distance(&here, &theirs, &here, &s).unwrap().distance
        };
        let square = shape::Cuboid::new(ParryVec::new(0.5 * POINT_M, 0.5 * POINT_M));
        let gap_to_square = |p: &Vec2| {
            let there = Pose2::translation(p.x, p.y);
            parry2d::query::distance(&here, &theirs, &there, &square).unwrap().distance
        };
        let long = parts.0.iter().filter(|w| w.length() > 0.0).map(gap_to_wall);
        let gap = long.chain(parts.1.iter().map(gap_to_square)).fold(f64::INFINITY, f64::min);
        // A close call, or a wall without length, which parry takes for a line.
        prop_assume!(!(1e-12..1e-6).contains(&gap));
        let walls = parts.0.iter().filter(|w| w.length() > 0.0).copied().collect();
        let world = build_merged(&(walls, parts.1.clone()));
        prop_assert_eq!(world.touches_polygon(&corners), gap <= 1e-12);
        let found = world.polygon_distance(&corners, 4.0);
        prop_assert_eq!(found.is_some(), gap <= 4.0);
        // parry stops iterating at about 1e-7.
        prop_assert!(found.is_none_or(|found| (found - gap).abs() < 1e-5), "{:?} {}", found, gap);
    }

    #[test]
    fn numbers_that_are_none_never_panic(
        numbers in proptest::collection::vec(
            prop_oneof![
                Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY), Just(0.0), Just(-0.0),
                Just(f64::MAX), Just(f64::MIN_POSITIVE), -3.0..3.0_f64,
            ],
            16,
        ),
    ) {
        let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] = numbers[..].try_into().unwrap();
        let walls = [(wall(a, b, c, d), 1), (wall(0.0, 1.0, 2.0, 3.0), 2), (wall(i, j, k, l), 3)];
        let world = SegmentWorld::with_points(walls, [(v(e, f), 4), (v(0.0, 0.0), 5)], g);
        let probe = Ray { origin: v(h, i), direction: v(j, k) };
        for range in [1.0, l, f64::INFINITY] {
            if let Some(hit) = world.cast(&probe, range) {
                prop_assert!(hit.distance_m.is_finite() && hit.distance_m >= 0.0);
            }
        }
        let _ = world.is_blocked(v(m, n), v(o, p));
        let _ = world.nearest_distance(v(m, n), o);
        let _ = world.touches_polygon(&[v(a, b), v(m, n), v(o, p)]);
        let _ = world.bounds();
    }
}

#[test]
fn an_empty_world_is_met_by_nothing() {
    let world = SegmentWorld::new([]);
    assert!(world.is_empty() && world.bounds().is_empty());
    assert_eq!(world.cast(&ray(0.0, 0.0, 0.0), f64::INFINITY), None);
    assert_eq!(world.nearest_distance(v(0.0, 0.0), f64::INFINITY), None);
    assert!(!world.touches_polygon(&[v(0.0, 0.0), v(1.0, 0.0), v(0.0, 1.0)]));
    assert!(!world.is_blocked(v(0.0, 0.0), v(9.0, 9.0)));
}

#[test]
fn a_wall_in_line_with_the_ray_is_met_at_its_nearer_end() {
    let world = SegmentWorld::new([(wall(4.0, 0.0, 2.0, 0.0), 9)]);
    let east = Ray { origin: v(0.0, 0.0), direction: v(1.0, 0.0) };
    let hit = world.cast(&east, 9.0).unwrap();
    assert_eq!((hit.distance_m, hit.normal, hit.tag), (2.0, v(-1.0, 0.0), 9));
    let from_inside = world.cast(&Ray { origin: v(3.0, 0.0), ..east }, 9.0).unwrap();
    assert!(from_inside.distance_m.abs() < 1e-15);
    assert_eq!(world.cast(&Ray { origin: v(4.5, 0.0), ..east }, 9.0), None, "behind");
    assert_eq!(world.cast(&Ray { origin: v(0.0, 1e-9), ..east }, 9.0), None, "beside");
}

#[test]
fn the_range_ends_where_it_says() {
    let world = SegmentWorld::new([(wall(2.0, -1.0, 2.0, 1.0), 0)]);
    let east = Ray { origin: v(0.0, 0.0), direction: v(1.0, 0.0) };
    assert!(world.cast(&east, 2.0).is_some(), "the limit belongs to the range");
    assert!(world.cast(&east, 2.0 - 1e-12).is_none());
    assert!(world.cast(&east, f64::NAN).is_none() && world.cast(&east, -1.0).is_none());
    assert!(world.cast(&Ray { direction: v(0.0, 0.0), ..east }, 9.0).is_none());
}

#[test]
fn of_equally_near_walls_the_lower_index_answers() {
    // Ten fans of walls that share one end, met exactly there, in both orders of their ends.
    let fan = |i: i32| {
        // No round numbers at the far ends: a place worked out from there would miss the tip.
        let far = f64::from(i);
        let (tip, end) = (v(0.1, 0.0), v(4.123_456_789 + 0.377 * far, 0.713 * far - 3.1));
        if i % 2 == 0 { Segment { a: tip, b: end } } else { Segment { a: end, b: tip } }
    };
    let east = Ray { origin: v(0.0, 0.0), direction: v(1.0, 0.0) };
    for first in 0..10_u32 {
        let walls = (0..10).map(|i| (fan(i), (i as u32 + 10 - first) % 10));
        let mut walls: Vec<_> = walls.collect();
        walls.sort_by_key(|&(_, place)| place);
        let hit = SegmentWorld::new(walls).cast(&east, 9.0).unwrap();
        assert_eq!((hit.distance_m, hit.tag), (0.1, 0));
    }
    let twice = [(wall(2.0, -1.0, 2.0, 1.0), 5), (wall(2.0, -3.0, 2.0, 3.0), 6)];
    let world = SegmentWorld::with_points(twice, [(v(2.5, 0.0), 7)], 1.0);
    assert_eq!(world.cast(&east, 9.0).unwrap().tag, 5, "walls come before points");
}

#[test]
fn a_block_is_solid() {
    let world = SegmentWorld::with_points([], [(v(1.0, 1.0), 3)], 0.5);
    let inside = world.cast(&ray(1.1, 0.9, 2.0), 9.0).unwrap();
    assert!(inside.distance_m.abs() < 1e-15);
    assert_eq!(inside.normal, -ray(0.0, 0.0, 2.0).direction);
    assert_eq!(world.nearest_distance(v(1.1, 0.9), 1.0), Some(0.0));
    assert!(world.touches_polygon(&[v(0.9, 0.9), v(1.1, 0.9), v(1.0, 1.1)]), "polygon inside");
    assert!(world.touches_polygon(&[v(-9.0, -9.0), v(9.0, -9.0), v(0.0, 30.0)]), "block inside");
    assert!(!world.touches_polygon(&[v(-9.0, -9.0), v(9.0, -9.0)]), "no polygon");
    let down = Ray { origin: v(1.0, 9.0), direction: v(0.0, -1.0) };
    assert_eq!(world.cast(&down, 9.0).unwrap().normal, v(0.0, 1.0));
    assert!(world.is_blocked(v(1.0, 1.0), v(1.0, 1.0)), "standing in it");
}

/// No edge of the polygon tells the two apart, only a side of the block.
#[test]
fn a_block_beside_the_tip_of_a_polygon_is_as_far_as_its_side() {
    let world = SegmentWorld::with_points([], [(v(1.0, 0.0), 3)], 1.0);
    for gap in [0.01, 0.2] {
        let tip = [v(0.5 - gap, 0.0), v(-3.0, 0.1), v(-3.0, -0.1)];
        assert!(!world.touches_polygon(&tip));
        let found = world.polygon_distance(&tip, 4.0).unwrap();
        assert!((found - gap).abs() < 1e-12, "{found}");
    }
    let inside = [v(0.6, 0.0), v(-3.0, 0.1), v(-3.0, -0.1)];
    assert_eq!(world.polygon_distance(&inside, 4.0), Some(0.0));
}

#[test]
fn many_walls_in_one_place_do_not_deepen_the_tree_past_its_limit() {
    // No cut tells these apart, so only halving by count keeps the depth.
    let same = (0..5000_u32).map(|i| (wall(1.0, -1.0, 1.0, 1.0), i));
    let steps = (0..5000_u32).map(|i| {
        let x = 2.0_f64.powi(-(i as i32 % 900));
        (wall(x, -x, x, x), 5000 + i)
    });
    let world = SegmentWorld::new(same.chain(steps));
    let west = Ray { origin: v(3.0, 0.0), direction: v(-1.0, 0.0) };
    assert_eq!(world.cast(&west, 9.0).unwrap().tag, 0);
    assert!(world.nearest_distance(v(0.5, 3.0), 9.0).is_some());
    assert!(world.touches_polygon(&[v(0.3, -0.1), v(0.4, 0.0), v(0.3, 0.1), v(0.2, 0.0)]));
}

#[test]
fn a_ray_from_far_outside_hits_as_precisely_as_its_numbers_allow() {
    let world = SegmentWorld::with_points([(wall(0.0, 0.0, 0.0, 1.0), 1)], [(v(5.0, 0.5), 2)], 0.1);
    let east = Ray { origin: v(-1e6, 0.4), direction: v(1.0, 0.0) };
    assert!((world.cast(&east, f64::INFINITY).unwrap().distance_m - 1e6).abs() < 1e-9);
    assert_eq!(world.cast(&Ray { origin: v(-1e6, 1.4), ..east }, f64::INFINITY), None);
}

/// The laboratory map of 63 311 points: every hit of a fan of rays against the definition.
#[test]
fn a_scanned_building_is_met_where_its_points_are() {
    let Some(file) = testkit::data_folder("maps/columbia.map.gz") else { return };
    let mut text = String::new();
    let packed = std::fs::File::open(file).unwrap();
    flate2::read::GzDecoder::new(packed).read_to_string(&mut text).unwrap();
    let numbers = |line: &str| -> Vec<f64> {
        line.split_whitespace().map_while(|w| w.parse().ok()).map(|mm: f64| mm * 1e-3).collect()
    };
    let (head, points) = text.split_once("\nDATA").unwrap();
    let (_, lines) = head.split_once("\nLINES").unwrap();
    let walls = lines.lines().map(numbers).filter(|n| n.len() == 4);
    let walls: Vec<_> = walls.map(|n| wall(n[0], n[1], n[2], n[3])).collect();
    let points = points.lines().map(numbers).filter(|n| n.len() == 2);
    let points: Vec<_> = points.map(|n| v(n[0], n[1])).collect();
    assert_eq!((walls.len(), points.len()), (470, 63_311));
    let world = SegmentWorld::with_points(
        walls.iter().map(|&w| (w, 0)),
        points.iter().map(|&p| (p, 1)),
        0.02,
    );
    for i in 0..48 {
        let r = ray(-0.182, 0.176, f64::from(i) * 0.131 + 0.01);
        let square = |p: &Vec2| {
            let shifted = Ray { origin: (r.origin - p) * 5.0, direction: r.direction };
            square_by_definition(&shifted, v(0.0, 0.0)).map(|t| t / 5.0)
        };
        let walls = walls.iter().filter_map(|&w| wall_by_definition(&r, w));
        let wanted = walls.chain(points.iter().filter_map(square)).min_by(f64::total_cmp);
        let found = world.cast(&r, f64::INFINITY).map(|h| h.distance_m);
        assert!((found.unwrap() - wanted.unwrap()).abs() < 1e-9, "{found:?} {wanted:?}");
    }
}
