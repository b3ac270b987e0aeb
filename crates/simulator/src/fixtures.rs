//! What is in a world beside solid things: floor that is missing, beams, places to charge.

use geometry::{Polygon, Se2, Vec2};

/// Farthest that the beam of a virtual wall is heard, metres.
pub const VIRTUAL_WALL_REACH_M: f64 = 2.5;
/// Half the angle of that beam, radians.
const VIRTUAL_WALL_HALF_ANGLE_RAD: f64 = 0.13;
/// So near to a place to charge its contacts touch, metres and radians.
const DOCKED_WITHIN: (f64, f64) = (0.05, 0.2);

/// What bodies do not run into but what their sensors tell them of.
#[derive(Clone, Debug, Default)]
pub struct Fixtures {
    /// Where there is no floor, world frame. Bodies do not fall; their sensors tell.
    pub holes: Vec<Polygon>,
    /// Virtual walls: where they stand and which way they send their beam, world frame.
    pub virtual_walls: Vec<Se2>,
    /// Places to charge: where a robot stands on them and which way it looks, world frame.
    pub docks: Vec<Se2>,
}

impl Fixtures {
    /// Whether there is floor at `place`, world frame, metres.
    pub fn has_floor(&self, place: Vec2) -> bool {
        !self.holes.iter().any(|hole| hole.contains(place))
    }

    /// Whether the beam of a virtual wall is heard at `place`, world frame, metres; walls and things are no hindrance.
    pub fn in_virtual_wall(&self, place: Vec2) -> bool {
        self.virtual_walls.iter().any(|wall| {
            let way = place - wall.position();
            let bearing_rad = geometry::wrap_to_pi(way.y.atan2(way.x) - wall.yaw_rad);
            way.norm() <= VIRTUAL_WALL_REACH_M && bearing_rad.abs() <= VIRTUAL_WALL_HALF_ANGLE_RAD
        })
    }

    /// Whether a robot that stands there, world frame, touches the contacts of a place to charge.
    pub fn is_docked(&self, world_from_base: Se2) -> bool {
        let (within_m, within_rad) = DOCKED_WITHIN;
        self.docks.iter().any(|dock| {
            let aside_rad = geometry::wrap_to_pi(world_from_base.yaw_rad - dock.yaw_rad);
            (world_from_base.position() - dock.position()).norm() <= within_m
                && aside_rad.abs() <= within_rad
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_beams_and_docks_are_where_they_were_put() {
        let world = Fixtures::default();
        assert!(world.has_floor(Vec2::zeros()) && !world.in_virtual_wall(Vec2::zeros()));
        let square = [(1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0)].map(|(x, y)| Vec2::new(x, y));
        let world = Fixtures {
            holes: vec![Polygon::new(square.to_vec()).unwrap()],
            virtual_walls: vec![Se2::new(0.0, 0.0, 1.57)],
            docks: vec![Se2::new(-1.0, 0.0, 3.1)],
        };
        for (x, y, floor) in [(0.9, 0.5, true), (1.1, 0.5, false), (1.5, -0.1, true)] {
            assert_eq!(world.has_floor(Vec2::new(x, y)), floor, "{x} {y}");
        }
        for (x, y, heard) in [
            (0.0, 1.0, true),
            (0.1, 1.0, true),
            (0.3, 1.0, false),
            (0.0, 2.6, false),
            (0.0, -1.0, false),
        ] {
            assert_eq!(world.in_virtual_wall(Vec2::new(x, y)), heard, "{x} {y}");
        }
        for (x, yaw, docked) in
            [(-1.0, -3.1, true), (-1.04, 3.1, true), (-1.06, 3.1, false), (-1.0, 0.0, false)]
        {
            assert_eq!(world.is_docked(Se2::new(x, 0.0, yaw)), docked, "{x} {yaw}");
        }
    }
}
