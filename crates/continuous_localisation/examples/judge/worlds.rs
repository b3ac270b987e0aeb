//! The source's environments, with dimensions where it gives them and plausible ones where not.

use geometry::{Segment, SegmentWorld, Vec2};

/// Tags of `sensor_models::materials`.
const PLASTER: u32 = 0;
const WOOD: u32 = 1;

pub(crate) struct World {
    pub(crate) name: &'static str,
    pub(crate) walls: Vec<(Segment, u32)>,
    /// The way, as corners to be rounded; driven so many times.
    pub(crate) corners: Vec<Vec2>,
    pub(crate) n_laps: usize,
    pub(crate) is_closed: bool,
}

impl World {
    pub(crate) fn scene(&self) -> SegmentWorld {
        SegmentWorld::new(self.walls.iter().copied())
    }
}

/// All of them.
pub(crate) fn all() -> [World; 5] {
    [e1(), e2(), e3(), e4(), e4_with_doors()]
}

fn polyline(points: &[(f64, f64)], tag: u32, walls: &mut Vec<(Segment, u32)>) {
    for pair in points.windows(2) {
        let [a, b] = [pair[0], pair[1]].map(|(x, y)| Vec2::new(x, y));
        walls.push((Segment { a, b }, tag));
    }
}

fn block(x: f64, y: f64, w: f64, h: f64, walls: &mut Vec<(Segment, u32)>) {
    polyline(&[(x, y), (x + w, y), (x + w, y + h), (x, y + h), (x, y)], WOOD, walls);
}

fn way(points: &[(f64, f64)]) -> Vec<Vec2> {
    points.iter().map(|&(x, y)| Vec2::new(x, y)).collect()
}

/// E1: a room of 6 × 5 m with furniture along its border.
pub(crate) fn e1() -> World {
    let mut walls = Vec::new();
    polyline(&[(0.0, 0.0), (6.0, 0.0), (6.0, 5.0), (0.0, 5.0), (0.0, 0.0)], PLASTER, &mut walls);
    block(0.0, 1.9, 0.5, 1.2, &mut walls);
    block(2.2, 0.0, 1.4, 0.45, &mut walls);
    block(5.4, 1.5, 0.6, 1.0, &mut walls);
    block(4.2, 4.4, 1.2, 0.6, &mut walls);
    block(1.2, 4.5, 0.8, 0.5, &mut walls);
    block(2.6, 2.1, 0.9, 0.8, &mut walls);
    let corners = way(&[(1.2, 1.15), (4.5, 1.15), (4.5, 3.6), (3.2, 3.6), (1.3, 3.6)]);
    World { name: "E1", walls, corners, n_laps: 3, is_closed: true }
}

/// E2: a larger room with an open area in which nothing is within range of most sonars.
pub(crate) fn e2() -> World {
    let mut walls = Vec::new();
    polyline(&[(0.0, 0.0), (11.0, 0.0), (11.0, 8.0), (0.0, 8.0), (0.0, 0.0)], PLASTER, &mut walls);
    block(0.0, 3.0, 0.6, 1.5, &mut walls);
    block(4.0, 0.0, 2.0, 0.6, &mut walls);
    block(10.3, 4.5, 0.7, 1.6, &mut walls);
    block(6.0, 7.4, 1.5, 0.6, &mut walls);
    let corners = way(&[
        (1.4, 1.4),
        (9.2, 1.5),
        (9.2, 3.4),
        (5.5, 4.0),
        (1.8, 4.6),
        (1.5, 6.6),
        (8.8, 6.5),
        (9.0, 4.0),
        (5.5, 3.8),
        (1.6, 3.6),
    ]);
    World { name: "E2", walls, corners, n_laps: 1, is_closed: true }
}

/// E3: two joined rooms of about 5 × 5 m.
pub(crate) fn e3() -> World {
    let mut walls = Vec::new();
    polyline(
        &[
            (0.0, 0.0),
            (4.6, 0.0),
            (4.6, 2.4),
            (6.2, 2.4),
            (6.2, 6.0),
            (1.0, 6.0),
            (1.0, 3.2),
            (0.0, 3.2),
            (0.0, 0.0),
        ],
        PLASTER,
        &mut walls,
    );
    block(0.0, 0.0, 0.5, 0.9, &mut walls);
    block(5.6, 4.0, 0.6, 0.9, &mut walls);
    block(2.2, 5.5, 1.0, 0.5, &mut walls);
    let corners = way(&[
        (1.3, 1.0),
        (3.7, 1.0),
        (3.8, 3.3),
        (5.2, 3.4),
        (5.0, 5.2),
        (1.9, 5.0),
        (1.9, 2.6),
        (1.1, 2.3),
    ]);
    World { name: "E3", walls, corners, n_laps: 2, is_closed: true }
}

/// E4: the corridor in the shape of an upturned U: branches of 14.8 m, 26.6 m between them, 2.7 m
/// wide. The way covers one branch, the hall between, and a metre of the other branch.
pub(crate) fn e4() -> World {
    let (l, d, w) = (14.8, 26.6, 2.7);
    let mut walls = Vec::new();
    polyline(&[(0.0, 0.0), (0.0, l), (d, l), (d, 0.0)], PLASTER, &mut walls);
    polyline(&[(w, 0.0), (w, l - w), (d - w, l - w), (d - w, 0.0)], PLASTER, &mut walls);
    polyline(&[(0.0, 0.0), (w, 0.0)], PLASTER, &mut walls);
    polyline(&[(d - w, 0.0), (d, 0.0)], PLASTER, &mut walls);
    let corners = way(&[(1.1, 0.8), (1.1, l - 1.2), (d - 1.3, l - 1.2), (d - 1.2, l - 3.6)]);
    World { name: "E4", walls, corners, n_laps: 1, is_closed: false }
}

/// E4 with doors: its walls lie in short pieces between doors a hand's breadth deeper, as in the
/// mission of the same name. A cone hears wall, edge and door within a few steps of the way, and none
/// of the ranges jumps by much.
pub(crate) fn e4_with_doors() -> World {
    const DEEP_M: f64 = 0.12;
    const WIDE_M: f64 = 0.95;
    let (l, d, w) = (14.8, 26.6, 2.7);
    let mut walls = Vec::new();
    // A wall from one point to another, with doors that begin so far along it, to its right.
    let mut wall = |from: (f64, f64), to: (f64, f64), doors: &[f64]| {
        let (a, b) = (Vec2::new(from.0, from.1), Vec2::new(to.0, to.1));
        let along = (b - a).normalize();
        let deep = Vec2::new(along.y, -along.x) * DEEP_M;
        let mut begin = a;
        for &door in doors {
            let (p, q) = (a + along * door, a + along * (door + WIDE_M));
            let corners = [begin, p, p + deep, q + deep, q];
            let tags = [PLASTER, PLASTER, WOOD, PLASTER];
            for (pair, tag) in corners.windows(2).zip(tags) {
                walls.push((Segment { a: pair[0], b: pair[1] }, tag));
            }
            begin = q;
        }
        walls.push((Segment { a: begin, b }, PLASTER));
    };
    wall((0.0, l), (0.0, 0.0), &[5.0, 8.7, 12.3]);
    wall((d, l), (0.0, l), &[3.4, 7.2, 11.0, 15.8, 19.6, 22.6]);
    wall((d, 0.0), (d, l), &[2.7, 7.9]);
    wall((w, 0.0), (w, l - w), &[3.3, 7.4]);
    wall((w, l - w), (d - w, l - w), &[2.4, 6.2, 10.5, 14.8, 18.6]);
    wall((d - w, l - w), (d - w, 0.0), &[1.8, 6.7]);
    wall((0.0, 0.0), (w, 0.0), &[]);
    wall((d - w, 0.0), (d, 0.0), &[]);
    let corners = way(&[(1.35, 0.8), (1.35, l - 1.35), (d - 1.35, l - 1.35)]);
    World { name: "E4d", walls, corners, n_laps: 1, is_closed: false }
}
