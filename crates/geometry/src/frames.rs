//! Rigid transforms in the plane that know which two frames they connect.

use std::{marker::PhantomData, ops::Mul};

use crate::{Vec2, se2::Se2};

/// The simulator's truth. Only the simulator and what judges a run may use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct World;
/// The map being built or given. Fixed to the world; poses in it jump at loop closure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map;
/// Dead reckoning. Drifts, but never jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odom;
/// The robot: x forward, y left, origin midway between the driven wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Base;
/// One range sensor: x along its axis, origin at its face; fixed to [`Base`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor;

/// Pose of frame `From` in frame `To`; also maps coordinates of `From` into `To`.
///
/// Name every value `to_from_from`, so that neighbouring names meet:
///
/// ```
/// # use geometry::{frames::*, Se2};
/// let map_from_odom = Transform2::<Map, Odom>::new(Se2::new(1.0, 0.0, 0.0));
/// let odom_from_base = Transform2::<Odom, Base>::new(Se2::new(0.5, 0.2, 0.1));
/// let map_from_base: Transform2<Map, Base> = map_from_odom * odom_from_base;
/// # assert_eq!(map_from_base.se2().x_m, 1.5);
/// ```
///
/// A product whose inner frames differ is a type error:
///
/// ```compile_fail
/// # use geometry::{frames::*, Se2};
/// # let map_from_odom = Transform2::<Map, Odom>::new(Se2::IDENTITY);
/// # let odom_from_base = Transform2::<Odom, Base>::new(Se2::IDENTITY);
/// let wrong = odom_from_base * map_from_odom;
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform2<To, From> {
    se2: Se2,
    frames: PhantomData<(To, From)>,
}

impl<To, From> Transform2<To, From> {
    /// Labels an untyped transform. The only place where frames are asserted, not derived.
    pub fn new(se2: Se2) -> Self {
        Self { se2, frames: PhantomData }
    }

    /// The untyped group element, for kernels that work in one frame only.
    pub fn se2(&self) -> Se2 {
        self.se2
    }

    /// Where a point (m) of `From` lies in `To`.
    pub fn transform_point(&self, point: Vec2) -> Vec2 {
        self.se2.transform_point(point)
    }

    /// Swaps the two frames.
    #[must_use]
    pub fn inverse(&self) -> Transform2<From, To> {
        Transform2::new(self.se2.inverse())
    }
}

impl<A, B, C> Mul<Transform2<B, C>> for Transform2<A, B> {
    type Output = Transform2<A, C>;

    fn mul(self, rhs: Transform2<B, C>) -> Transform2<A, C> {
        Transform2::new(self.se2.compose(rhs.se2))
    }
}
