//! What can be wrong with a graph that somebody builds or asks about.

use thiserror::Error;

/// Why a graph refuses a part or cannot answer; the graph is left as it was.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GraphError {
    /// A vertex is named that does not exist.
    #[error("there is no vertex {vertex}: the graph has {n_vertices}, counted from 0")]
    UnknownVertex {
        /// The index that was asked for.
        vertex: usize,
        /// How many there are.
        n_vertices: usize,
    },
    /// An edge is named that does not exist.
    #[error("there is no edge {edge}: the graph has {n_edges}, counted from 0")]
    UnknownEdge {
        /// The index that was asked for.
        edge: usize,
        /// How many there are.
        n_edges: usize,
    },
    /// An edge from a vertex to itself says nothing about where it is.
    #[error("an edge joins vertex {vertex} with itself: leave it out, it cannot move anything")]
    SelfLoop {
        /// The vertex.
        vertex: usize,
    },
    /// A number is NaN or infinite.
    #[error("{what} is not a finite number: measure again or leave the edge out")]
    NotFinite {
        /// Which number.
        what: &'static str,
    },
    /// An information matrix is not one.
    #[error(
        "the information matrix is not symmetric and positive semi-definite (least eigenvalue {least}, \
         greatest {greatest}): it must be the inverse of a covariance"
    )]
    NotAnInformation {
        /// The least eigenvalue of its symmetric part.
        least: f64,
        /// The greatest.
        greatest: f64,
    },
    /// A robust kernel has a width that is zero, negative or not a number.
    #[error("a robust kernel has the width {found}: it must be finite and greater than 0")]
    KernelWidth {
        /// The width.
        found: f64,
    },
    /// The equations have no unique solution.
    #[error(
        "the edges do not determine all poses: the information of some direction is zero; \
         add edges or fix vertices"
    )]
    Undetermined,
    /// Two vertices that no chain of edges joins have no relative pose.
    #[error("no chain of edges joins vertices {from} and {to}: their relative pose is unknown")]
    NotConnected {
        /// The one vertex.
        from: usize,
        /// The other.
        to: usize,
    },
    /// More than 32 bits of index or than the memory can hold.
    #[error("a graph of {n_vertices} vertices and {n_edges} edges is too large for this machine")]
    TooLarge {
        /// How many vertices it has.
        n_vertices: usize,
        /// How many edges it has.
        n_edges: usize,
    },
}
