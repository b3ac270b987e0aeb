//! Meeting and distance of small outlines: convex corner lists, polygons, circles, rays.
//!
//! Corner lists are counter-clockwise and convex unless said otherwise, in metres, all in one
//! frame. Touching counts as meeting. Nothing here allocates.

use geometry::{Polygon, Ray, Segment, Vec2};

/// The edges of a corner list.
pub(crate) fn edges(corners: &[Vec2]) -> impl Iterator<Item = Segment> + '_ {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| Segment { a, b })
}

/// Whether two convex outlines share a point: no edge of either separates them.
pub(crate) fn convex_meet(first: &[Vec2], second: &[Vec2]) -> bool {
    let separated_by = |one: &[Vec2], other: &[Vec2]| {
        edges(one).any(|Segment { a, b }| {
            let along = b - a;
            // Counter-clockwise: the outside of an edge is on its right.
            other.iter().all(|corner| along.perp(&(corner - a)) < 0.0)
        })
    };
    !separated_by(first, second) && !separated_by(second, first)
}

/// Whether a simple polygon, convex or not, shares a point with a convex outline.
pub(crate) fn polygon_meets_convex(polygon: &Polygon, convex: &[Vec2]) -> bool {
    polygon.contains(convex[0])
        || contains(convex, polygon.corners()[0])
        || polygon.edges().any(|p| edges(convex).any(|c| p.intersects(c)))
}

/// Whether a convex outline holds a point.
pub(crate) fn contains(convex: &[Vec2], point: Vec2) -> bool {
    edges(convex).all(|Segment { a, b }| (b - a).perp(&(point - a)) >= 0.0)
}

/// The point of a convex outline, inside included, that is closest to `point`.
pub(crate) fn closest_point(convex: &[Vec2], point: Vec2) -> Vec2 {
    if contains(convex, point) {
        return point;
    }
    let mut best = (f64::INFINITY, point);
    for edge in edges(convex) {
        let candidate = edge.closest_point(point);
        let squared = (candidate - point).norm_squared();
        if squared < best.0 {
            best = (squared, candidate);
        }
    }
    best.1
}

/// Whether a circle shares a point with a convex outline.
pub(crate) fn circle_meets_convex(centre: Vec2, radius_m: f64, convex: &[Vec2]) -> bool {
    (closest_point(convex, centre) - centre).norm_squared() <= radius_m * radius_m
}

/// Distance between the borders of two outlines of any shape, metres.
pub(crate) fn borders_distance(first: &[Vec2], second: &[Vec2]) -> f64 {
    let mut best = f64::INFINITY;
    for a in edges(first) {
        for b in edges(second) {
            best = best.min(a.distance_to_segment(b));
        }
    }
    best
}

/// Where a ray first crosses the border of an outline within `range_max_m`: distance, and the
/// normal on the ray's side.
pub(crate) fn ray_meets_outline(
    ray: &Ray,
    corners: &[Vec2],
    range_max_m: f64,
) -> Option<(f64, Vec2)> {
    let mut best = None;
    let mut within_m = range_max_m;
    for Segment { a, b } in edges(corners) {
        let along = b - a;
        let slope = ray.direction.perp(&along);
        if slope == 0.0 {
            continue;
        }
        // origin + t · direction = a + u · along
        let to_a = a - ray.origin;
        let t = to_a.perp(&along) / slope;
        let u = to_a.perp(&ray.direction) / slope;
        if (0.0..=1.0).contains(&u) && (0.0..=within_m).contains(&t) {
            let normal = Vec2::new(along.y, -along.x).normalize();
            let facing = if normal.dot(&ray.direction) > 0.0 { -normal } else { normal };
            within_m = t;
            best = Some((t, facing));
        }
    }
    best
}

/// Where a ray first crosses a circle from outside within `range_max_m`: distance and normal.
pub(crate) fn ray_meets_circle(
    ray: &Ray,
    centre: Vec2,
    radius_m: f64,
    range_max_m: f64,
) -> Option<(f64, Vec2)> {
    let to_centre = centre - ray.origin;
    let along_m = to_centre.dot(&ray.direction);
    let beside_m = to_centre.perp(&ray.direction);
    let half_chord = radius_m * radius_m - beside_m * beside_m;
    if half_chord < 0.0 {
        return None;
    }
    let distance_m = along_m - half_chord.sqrt();
    if !(0.0..=range_max_m).contains(&distance_m) {
        return None;
    }
    let normal = (ray.origin + distance_m * ray.direction - centre) / radius_m;
    Some((distance_m, normal))
}

/// The parts of a convex outline with y ≥ 0 and with y ≤ 0; either may be empty.
pub(crate) fn halves(corners: &[Vec2]) -> [Vec<Vec2>; 2] {
    [1.0, -1.0].map(|side| {
        let mut part = Vec::with_capacity(corners.len() + 2);
        for Segment { a, b } in edges(corners) {
            let (from, to) = (side * a.y, side * b.y);
            if from >= 0.0 {
                part.push(a);
            }
            if (from < 0.0) != (to < 0.0) && from != 0.0 && to != 0.0 {
                part.push(a + (b - a) * (from / (from - to)));
            }
        }
        part
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{RayCaster, Se2, SegmentWorld};
    use proptest::prelude::*;

    fn moved(corners: &[[f64; 2]], pose: Se2) -> Vec<Vec2> {
        corners.iter().map(|&[x, y]| pose.transform_point(Vec2::new(x, y))).collect()
    }

    const SQUARE: [[f64; 2]; 4] = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    const KITE: [[f64; 2]; 5] = [[-0.6, 0.0], [0.0, -0.3], [0.7, -0.2], [0.8, 0.1], [0.1, 0.4]];
    /// Not convex: an L.
    const ELL: [[f64; 2]; 6] =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 0.3], [0.3, 0.3], [0.3, 1.0], [0.0, 1.0]];

    fn pose() -> impl Strategy<Value = Se2> {
        (-1.5..1.5, -1.5..1.5, -3.1..3.1).prop_map(|(x, y, yaw)| Se2::new(x, y, yaw))
    }

    /// Points all over an outline's bounding box: slow and obvious.
    fn samples(corners: &[Vec2]) -> impl Iterator<Item = Vec2> {
        let around = geometry::Aabb::around(corners.iter().copied());
        let size = around.size();
        (0..=60).flat_map(move |i| {
            (0..=60).map(move |j| {
                around.min + Vec2::new(size.x * f64::from(i) / 60.0, size.y * f64::from(j) / 60.0)
            })
        })
    }

    proptest! {
        #[test]
        fn outlines_meet_when_some_point_is_in_both(p in pose(), q in pose()) {
            let (a, b) = (moved(&SQUARE, p), moved(&KITE, q));
            let (pa, pb) = (Polygon::new(a.clone()).unwrap(), Polygon::new(b.clone()).unwrap());
            let shared = samples(&b).any(|s| pa.contains(s) && pb.contains(s));
            if shared {
                prop_assert!(convex_meet(&a, &b) && convex_meet(&b, &a));
                prop_assert!(polygon_meets_convex(&pa, &b));
            }
            // And the other way: what does not meet has a distance.
            if !convex_meet(&a, &b) {
                prop_assert!(borders_distance(&a, &b) > 0.0);
                prop_assert!(!polygon_meets_convex(&pb, &a));
            }
        }

        #[test]
        fn a_polygon_with_a_notch_is_met_only_where_it_is_solid(q in pose()) {
            let ell = Polygon::new(moved(&ELL, Se2::IDENTITY)).unwrap();
            let kite = moved(&KITE, q);
            let whole = Polygon::new(kite.clone()).unwrap();
            let shared = samples(&kite).any(|s| ell.contains(s) && whole.contains(s));
            let meets = polygon_meets_convex(&ell, &kite);
            prop_assert!(!shared || meets);
            prop_assert_eq!(!meets, borders_distance(ell.corners(), &kite) > 0.0 && !shared);
        }

        #[test]
        fn the_closest_point_is_no_farther_than_any_sample(q in pose()) {
            let kite = moved(&KITE, q);
            let whole = Polygon::new(kite.clone()).unwrap();
            let closest = closest_point(&kite, Vec2::zeros());
            prop_assert!(whole.distance(closest) < 1e-9);
            let best = samples(&kite).filter(|&s| whole.contains(s)).map(|s| s.norm());
            prop_assert!(closest.norm() <= best.fold(f64::INFINITY, f64::min) + 1e-9);
            prop_assert!((closest.norm() - whole.distance(Vec2::zeros())).abs() < 1e-9);
            prop_assert!(circle_meets_convex(Vec2::zeros(), closest.norm() + 1e-9, &kite));
            prop_assert!(closest.norm() < 1e-6
                || !circle_meets_convex(Vec2::zeros(), closest.norm() - 1e-9, &kite));
        }

        /// The oracle is the ray caster of the walls, which shares no code.
        #[test]
        fn a_ray_meets_an_outline_where_it_meets_its_edges(q in pose(), angle in -3.1..3.1) {
            let kite = moved(&KITE, q);
            let walls = SegmentWorld::new(edges(&kite).map(|edge| (edge, 0)));
            let ray = Ray {
                origin: Vec2::zeros(),
                direction: Se2::new(0.0, 0.0, angle).heading(),
            };
            let expected = walls.cast(&ray, 2.0);
            let found = ray_meets_outline(&ray, &kite, 2.0);
            prop_assert_eq!(found.is_some(), expected.is_some());
            if let (Some((distance_m, normal)), Some(hit)) = (found, expected) {
                prop_assert!((distance_m - hit.distance_m).abs() < 1e-9);
                prop_assert!((normal - hit.normal).norm() < 1e-9);
            }
        }

        #[test]
        fn a_ray_meets_a_circle_on_its_border(x in 0.5..3.0, y in -1.0..1.0, r in 0.1..0.4) {
            let centre = Vec2::new(x, y);
            let ray = Ray { origin: Vec2::zeros(), direction: Vec2::x() };
            let found = ray_meets_circle(&ray, centre, r, 2.0);
            let expected = (y.abs() < r).then(|| x - (r * r - y * y).sqrt()).filter(|&d| d <= 2.0);
            prop_assert_eq!(found.is_some(), expected.is_some());
            if let Some((distance_m, normal)) = found {
                prop_assert!((ray.origin + distance_m * ray.direction - centre).norm() - r < 1e-9);
                prop_assert!(normal.dot(&ray.direction) <= 0.0);
                prop_assert!((normal.norm() - 1.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_circle_behind_or_around_the_origin_is_not_met() {
        let ray = Ray { origin: Vec2::zeros(), direction: Vec2::x() };
        assert_eq!(ray_meets_circle(&ray, Vec2::new(-1.0, 0.0), 0.3, 5.0), None);
        assert_eq!(ray_meets_circle(&ray, Vec2::new(0.1, 0.0), 0.3, 5.0), None);
    }

    #[test]
    fn touching_is_meeting() {
        let a = moved(&SQUARE, Se2::IDENTITY);
        let b = moved(&SQUARE, Se2::new(1.0, 0.0, 0.0));
        assert!(convex_meet(&a, &b));
        assert!(!convex_meet(&a, &moved(&SQUARE, Se2::new(1.0 + 1e-9, 0.0, 0.0))));
        assert!(circle_meets_convex(Vec2::new(1.0, 0.0), 0.5, &a));
    }

    #[test]
    fn halves_make_a_whole() {
        let kite = moved(&KITE, Se2::IDENTITY);
        let area = |corners: &[Vec2]| Polygon::new(corners.to_vec()).unwrap().area_m2();
        let [left, right] = halves(&kite);
        assert!((area(&left) + area(&right) - area(&kite)).abs() < 1e-12);
        assert!(left.iter().all(|c| c.y >= -1e-12) && right.iter().all(|c| c.y <= 1e-12));
    }
}
