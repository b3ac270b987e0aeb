//! Where was I, and what did it look like: trajectories and maps from a laser's scans or a ring's echoes.
//!
//! | from | use |
//! | --- | --- |
//! | a scanning laser | [`laser::LaserSlam`], scan by scan |
//! | a ring of sonars, with loops in a graph | [`sonar_graph::SonarGraph`], row by row |
//! | a trajectory and what is known of it | [`evaluate`] |
//!
//! Continuous localisation without a graph is a crate of its own, `continuous_localisation`.

pub mod evaluate;
pub mod laser;
pub mod sonar_graph;
mod uncertainty;
