//! Rays, what they hit, and the shape of everything that can be hit.

use crate::Vec2;

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts (m).
    pub origin: Vec2,
    /// Where it goes: a unit vector.
    pub direction: Vec2,
}

/// The nearest thing on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// From the origin to the hit, metres.
    pub distance_m: f64,
    /// Unit normal of the surface that was hit, on the side of the ray's origin.
    pub normal: Vec2,
    /// What the owner of the surface attached to it; by convention the index of its material.
    pub tag: u32,
}

/// Something rays can be cast into.
pub trait RayCaster {
    /// The nearest hit within `range_max_m`, or `None`.
    fn cast(&self, ray: &Ray, range_max_m: f64) -> Option<RayHit>;
}
