//! The boxes of a node, side by side.

/// Children of a node: as many boxes as one vector register holds single-precision numbers.
pub(super) const WIDTH: usize = 4;

/// Four boxes side by side: min x, min y, max x, max y of each lane, metres from the middle of the
/// world, rounded outwards. An unused lane has an empty box. One line of the cache.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Boxes(pub(super) [[f32; WIDTH]; 4]);
