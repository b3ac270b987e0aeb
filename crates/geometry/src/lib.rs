//! Planar geometry: rigid motions with typed frames, arcs, polygons and fast ray casts.
//!
//! Everything is in metres and radians, counter-clockwise positive, yaw in [-π, π). Kernels that
//! live in one frame use the untyped [`Se2`] and [`Vec2`]; values that cross a crate's border carry
//! their frames in [`Transform2`]. FRAMES.md has the picture.
//!
//! | to describe | use |
//! | --- | --- |
//! | a place and a heading | [`Se2`], or [`Transform2`] where two frames meet |
//! | a wall | [`Segment`] |
//! | an outline | [`Polygon`] |
//! | a curve of constant radius | [`Arc`] |
//! | everything that does not move, to be asked millions of times | [`SegmentWorld`] |
//! | what is in sight within a cone, however thin | [`Cone`] |
//!
//! ```
//! use geometry::{Ray, RayCaster, Segment, SegmentWorld, Vec2};
//!
//! let wall = Segment { a: Vec2::new(2.0, -1.0), b: Vec2::new(2.0, 1.0) };
//! let world = SegmentWorld::new([(wall, 7)]);
//! let ray = Ray { origin: Vec2::new(0.0, 0.0), direction: Vec2::new(1.0, 0.0) };
//! let hit = world.cast(&ray, 5.0).expect("the wall is within 5 m");
//! assert_eq!((hit.distance_m, hit.tag), (2.0, 7));
//! ```

mod aabb;
mod arc;
mod cone;
pub mod frames;
mod polygon;
mod rays;
mod se2;
mod segment;
mod segment_world;

pub use aabb::Aabb;
pub use arc::Arc;
pub use cone::{Cone, ConeScene, ConeView, Piece, Sighting};
pub use frames::{Base, Map, Odom, Sensor, Transform2, World};
pub use polygon::{Polygon, PolygonError};
pub use rays::{Ray, RayCaster, RayHit};
pub use se2::{Se2, Twist, wrap_to_pi};
pub use segment::Segment;
pub use segment_world::SegmentWorld;

/// A point or direction in the plane: x, y (m, or a unit vector where said).
pub type Vec2 = nalgebra::Vector2<f64>;
