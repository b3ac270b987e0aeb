//! What the guard looks at.

use geometry::Vec2;

use crate::{
    around::Surroundings,
    values::{Situation, Way},
};

/// What the guard looks at in one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene<'a> {
    pub(crate) situation: &'a Situation,
    pub(crate) around: &'a Surroundings,
    /// The way that the robot is about to take.
    pub(crate) way: &'a Way,
    /// The points of its route from the robot's on (m, map), as far apart as those of previews.
    pub(crate) points: &'a [Vec2],
}
