//! The same perception, seen as a neural network whose input weights lie in the world.

use geometry::{Se2, Vec2};

use crate::{Field, SenseConfig, model::diffused};

/// The weights from one source to the two antennas: an "exo-synapse".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Synapse {
    /// Column of the source.
    pub col: usize,
    /// Row of the source, from the top.
    pub row: usize,
    /// The input: the source's value, 1..=127.
    pub value: u8,
    /// To the left antenna, 1 − d/σ in [0, 1].
    pub to_left_ratio: f64,
    /// To the right antenna, 1 − d/σ in [0, 1].
    pub to_right_ratio: f64,
}

/// All connections of the network at this pose whose weight is not zero, row by row from the top.
///
/// Inputs are the sources, the hidden layer the antennas; P = 100 Σ value · weight is exactly what
/// [`Field::sense`] gives with [`Perception::ScalarSum`](crate::Perception). From antennas to wheels the
/// weights are fixed: −1 to the wheel of their own side and +1 to the other, around the mean speed. Moving the robot or
/// writing the map changes the weights, so there is nothing to train.
///
/// For views and lessons: it allocates. O((σ / cell size)²).
///
/// Source: the thesis, §5.3.1.4, Fig 5.15.
pub fn exo_synapses(field: &Field, map_from_base: Se2, config: &SenseConfig) -> Vec<Synapse> {
    let half = 0.5 * config.antenna_spacing_m;
    let left = map_from_base.transform_point(Vec2::new(0.0, half));
    let right = map_from_base.transform_point(Vec2::new(0.0, -half));
    let reach_m = config.sigma_m + half;
    let finite = reach_m.is_finite() && left.iter().chain(right.iter()).all(|v| v.is_finite());
    let mut synapses = Vec::new();
    if !finite {
        return synapses;
    }
    field.visit_within(map_from_base.position(), reach_m, |col, row, in_map, value| {
        let ahead_m = (in_map - map_from_base.position()).dot(&map_from_base.heading());
        if ahead_m < -1e-9 {
            return;
        }
        let weight = |antenna: Vec2| diffused(1.0, (in_map - antenna).norm(), config.sigma_m);
        let (to_left_ratio, to_right_ratio) = (weight(left), weight(right));
        if to_left_ratio > 0.0 || to_right_ratio > 0.0 {
            synapses.push(Synapse { col, row, value, to_left_ratio, to_right_ratio });
        }
    });
    synapses
}
