//! Sparse non-linear least squares on SE(2): robust kernels, sparse Cholesky, marginals, g2o text.
//!
//! A pose graph has vertices (poses in one frame) and edges (what was measured of one pose in the
//! frame of another, with an information matrix). [`optimise`] moves the poses so that the sum of
//! the edges' squared, weighted errors becomes least, [`Marginals`] says how uncertain they are
//! then, and [`g2o`] reads and writes the usual text.
//!
//! | to | use |
//! | --- | --- |
//! | build a graph | [`PoseGraph`], [`Edge`] |
//! | keep a wrong edge from bending everything | [`Kernel`] |
//! | make poses when there are none, or bad ones | [`odometry_start`], [`chordal_start`], [`Start`] |
//! | optimise again and again while a graph grows | one [`Workspace`], kept |
//! | decide whether two places may be the same | [`Marginals::relative`] |
//!
//! Not for landmarks, ranges or anything that is not a pose measured from a pose. The tests compare
//! with a dense solver written apart, with central differences and with published optima.
//!
//! ```
//! use geometry::Se2;
//! use least_squares::{Config, Edge, PoseGraph, Workspace, optimise};
//!
//! # fn main() -> Result<(), least_squares::GraphError> {
//! let mut graph = PoseGraph::new();
//! let start = graph.add_vertex(Se2::IDENTITY);
//! let end = graph.add_vertex(Se2::new(0.9, 0.1, 0.0));
//! graph.add_edge(Edge::new(start, end, Se2::new(1.0, 0.0, 0.2), nalgebra::Matrix3::identity()))?;
//! let report = optimise(&mut graph, &Config::default(), &mut Workspace::new());
//! assert!(report.chi2_after < 1e-12 && (graph.poses()[end].x_m - 1.0).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```

mod error;
pub mod g2o;
mod graph;
mod kernel;
mod linear;
mod marginals;
mod optimise;
mod residual;
mod start;
mod substitution;

pub use error::GraphError;
pub use graph::{Edge, PoseGraph};
pub use kernel::Kernel;
pub use marginals::Marginals;
pub use optimise::{Config, Outcome, Report, Workspace, chordal_start, optimise};
pub use start::{Start, odometry_start};

#[cfg(test)]
mod tests;
