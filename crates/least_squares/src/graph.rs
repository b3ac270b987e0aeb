//! The pose graph: vertices, edges, which vertices stay where they are.

use geometry::Se2;
use nalgebra::{Matrix3, Vector3};

use crate::{
    GraphError, Kernel,
    residual::{Heading, linearise},
};

/// An eigenvalue may be this far below zero, relative to the greatest: what decimals in files cost.
const ROUNDING_RATIO: f64 = 1e-6;

/// A pose measured from another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The vertex that measured.
    pub from: usize,
    /// The vertex that was measured.
    pub to: usize,
    /// Where `to` was seen in the frame of `from` (m, rad).
    pub to_in_from: Se2,
    /// Inverse covariance of the measurement, order x, y, yaw, in the frame of the measured pose
    /// (1/m², 1/(m rad), 1/rad²); symmetric, positive semi-definite.
    pub information: Matrix3<f64>,
    /// How far the edge may be wrong before it loses its say.
    pub kernel: Kernel,
}

/// Poses (m, rad, all in one frame) and what was measured between them.
///
/// Vertices and edges are counted from 0 in the order in which they came. Every edge was checked
/// when it was added, so a graph is always sound; only poses may be arbitrary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseGraph {
    pub(crate) poses: Vec<Se2>,
    pub(crate) edges: Vec<Edge>,
    pub(crate) is_fixed: Vec<bool>,
}

impl Edge {
    /// An edge without a robust kernel.
    pub fn new(from: usize, to: usize, to_in_from: Se2, information: Matrix3<f64>) -> Self {
        Self { from, to, to_in_from, information, kernel: Kernel::None }
    }

    /// The same edge with a kernel.
    #[must_use]
    pub fn with_kernel(self, kernel: Kernel) -> Self {
        Self { kernel, ..self }
    }
}

impl PoseGraph {
    /// A graph of nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a vertex where it is guessed to be; returns its index.
    pub fn add_vertex(&mut self, pose: Se2) -> usize {
        self.poses.push(pose);
        self.is_fixed.push(false);
        self.poses.len() - 1
    }

    /// Adds an edge between two vertices of the graph; returns its index. Several edges may join
    /// the same two.
    ///
    /// # Errors
    ///
    /// [`GraphError::UnknownVertex`], [`GraphError::SelfLoop`], [`GraphError::NotFinite`],
    /// [`GraphError::NotAnInformation`], [`GraphError::KernelWidth`].
    pub fn add_edge(&mut self, edge: Edge) -> Result<usize, GraphError> {
        self.known(edge.from)?;
        self.known(edge.to)?;
        if edge.from == edge.to {
            return Err(GraphError::SelfLoop { vertex: edge.from });
        }
        let z = edge.to_in_from;
        if !(z.x_m.is_finite() && z.y_m.is_finite() && z.yaw_rad.is_finite()) {
            return Err(GraphError::NotFinite { what: "the measured pose" });
        }
        check_information(&edge.information)?;
        check_kernel(edge.kernel)?;
        self.edges.push(edge);
        Ok(self.edges.len() - 1)
    }

    /// The poses, by vertex.
    pub fn poses(&self) -> &[Se2] {
        &self.poses
    }

    /// The edges, in the order in which they were added.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Puts a vertex somewhere else.
    ///
    /// # Errors
    ///
    /// [`GraphError::UnknownVertex`].
    pub fn set_pose(&mut self, vertex: usize, pose: Se2) -> Result<(), GraphError> {
        self.known(vertex)?;
        self.poses[vertex] = pose;
        Ok(())
    }

    /// Gives an edge another kernel.
    ///
    /// # Errors
    ///
    /// [`GraphError::UnknownEdge`], [`GraphError::KernelWidth`].
    pub fn set_kernel(&mut self, edge: usize, kernel: Kernel) -> Result<(), GraphError> {
        let n_edges = self.edges.len();
        check_kernel(kernel)?;
        let found = self.edges.get_mut(edge).ok_or(GraphError::UnknownEdge { edge, n_edges })?;
        found.kernel = kernel;
        Ok(())
    }

    /// Keeps the edges for which `is_kept` (index, edge) says so; the others are removed and those
    /// behind them move up.
    pub fn retain_edges(&mut self, mut is_kept: impl FnMut(usize, &Edge) -> bool) {
        let mut index = 0;
        self.edges.retain(|edge| {
            index += 1;
            is_kept(index - 1, edge)
        });
    }

    /// Makes a vertex stay where it is during optimisation.
    ///
    /// Parts of the graph without a fixed vertex are held at their vertex of least index.
    ///
    /// # Errors
    ///
    /// [`GraphError::UnknownVertex`].
    pub fn fix(&mut self, vertex: usize) -> Result<(), GraphError> {
        self.known(vertex)?;
        self.is_fixed[vertex] = true;
        Ok(())
    }

    /// Lets a vertex move again.
    ///
    /// # Errors
    ///
    /// [`GraphError::UnknownVertex`].
    pub fn release(&mut self, vertex: usize) -> Result<(), GraphError> {
        self.known(vertex)?;
        self.is_fixed[vertex] = false;
        Ok(())
    }

    /// For every vertex whether [`fix`](Self::fix) holds it.
    pub fn fixed(&self) -> &[bool] {
        &self.is_fixed
    }

    /// Error of an edge at the present poses: x, y (m), yaw (rad, wrapped) of the measured pose's
    /// inverse composed with the present relative pose.
    ///
    /// # Errors
    ///
    /// [`GraphError::UnknownEdge`].
    pub fn error_of_edge(&self, edge: usize) -> Result<Vector3<f64>, GraphError> {
        let n_edges = self.edges.len();
        let found = self.edges.get(edge).ok_or(GraphError::UnknownEdge { edge, n_edges })?;
        Ok(self.error_of(found))
    }

    /// Σ eᵀΩe over all edges at the present poses, without kernels: the figure by which results are
    /// compared. Cost: linear in the edges.
    pub fn chi2(&self) -> f64 {
        let squared = |edge: &Edge| {
            let e = self.error_of(edge);
            e.dot(&(edge.information * e))
        };
        self.edges.iter().map(squared).sum()
    }

    fn error_of(&self, edge: &Edge) -> Vector3<f64> {
        let (i, j) = (self.poses[edge.from], self.poses[edge.to]);
        let z = edge.to_in_from;
        linearise(i, Heading::of(i.yaw_rad), j, z, Heading::of(z.yaw_rad)).error
    }

    fn known(&self, vertex: usize) -> Result<(), GraphError> {
        let n_vertices = self.poses.len();
        let is_known = vertex < n_vertices;
        is_known.then_some(()).ok_or(GraphError::UnknownVertex { vertex, n_vertices })
    }
}

fn check_kernel(kernel: Kernel) -> Result<(), GraphError> {
    match kernel.width_ratio() {
        Some(found) if !(found > 0.0 && found.is_finite()) => {
            Err(GraphError::KernelWidth { found })
        }
        _ => Ok(()),
    }
}

fn check_information(information: &Matrix3<f64>) -> Result<(), GraphError> {
    if !information.iter().all(|v| v.is_finite()) {
        return Err(GraphError::NotFinite { what: "the information matrix" });
    }
    let is_symmetric = (information - information.transpose()).amax() <= 1e-9 * information.amax();
    // Nearly all are positive definite: three pivots say so quicker than the eigenvalues.
    if is_symmetric && information.cholesky().is_some() {
        return Ok(());
    }
    let eigenvalues = (0.5 * (information + information.transpose())).symmetric_eigenvalues();
    let (least, greatest) = (eigenvalues.min(), eigenvalues.max());
    if is_symmetric && least >= -ROUNDING_RATIO * greatest.abs() {
        return Ok(());
    }
    Err(GraphError::NotAnInformation { least, greatest })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two() -> PoseGraph {
        let mut graph = PoseGraph::new();
        graph.add_vertex(Se2::IDENTITY);
        graph.add_vertex(Se2::new(1.0, 0.0, 0.0));
        graph
    }

    #[test]
    fn what_cannot_be_an_edge_is_refused_and_leaves_the_graph_alone() {
        let good = Edge::new(0, 1, Se2::new(1.0, 0.0, 0.0), Matrix3::identity());
        let diagonal = |a, b, c| Matrix3::from_diagonal(&Vector3::new(a, b, c));
        let skew = Matrix3::new(1.0, 0.5, 0.0, -0.5, 1.0, 0.0, 0.0, 0.0, 1.0);
        let nan_pose = Se2 { x_m: f64::NAN, ..Se2::IDENTITY };
        let wide = |width_ratio| Kernel::Cauchy { width_ratio };
        for (edge, expected) in [
            (Edge { to: 2, ..good }, "there is no vertex 2"),
            (Edge { from: 9, ..good }, "there is no vertex 9"),
            (Edge { to: 0, ..good }, "joins vertex 0 with itself"),
            (Edge { to_in_from: nan_pose, ..good }, "the measured pose is not a finite"),
            (
                Edge { information: diagonal(1.0, f64::INFINITY, 1.0), ..good },
                "matrix is not a finite",
            ),
            (Edge { information: diagonal(1.0, -1.0, 1.0), ..good }, "least eigenvalue -1"),
            (Edge { information: skew, ..good }, "not symmetric"),
            (Edge { kernel: wide(0.0), ..good }, "width 0"),
            (Edge { kernel: wide(f64::NAN), ..good }, "width NaN"),
        ] {
            let mut graph = two();
            let message = graph.add_edge(edge).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
            assert_eq!(graph, two());
        }
        assert_eq!(two().add_edge(good), Ok(0));
        assert_eq!(two().add_edge(Edge { information: diagonal(1.0, 0.0, 1.0), ..good }), Ok(0));
        assert_eq!(two().add_edge(good.with_kernel(wide(2.0))), Ok(0));
    }

    #[test]
    fn edges_can_be_taken_out_again() {
        let mut graph = two();
        let edge = |x| Edge::new(0, 1, Se2::new(x, 0.0, 0.0), Matrix3::identity());
        for x in [1.0, 2.0, 3.0] {
            graph.add_edge(edge(x)).unwrap();
        }
        graph.retain_edges(|index, _| index != 1);
        assert_eq!(graph.edges(), [edge(1.0), edge(3.0)]);
        // The one agrees, the other is 2 m off.
        assert!((graph.chi2() - 4.0).abs() < 1e-12);
        assert!((graph.error_of_edge(1).unwrap().x + 2.0).abs() < 1e-12);
        assert!(graph.error_of_edge(2).is_err() && graph.set_kernel(2, Kernel::None).is_err());
    }

    #[test]
    fn unknown_vertices_cannot_be_moved_or_held() {
        let mut graph = two();
        let unknown = Err(GraphError::UnknownVertex { vertex: 2, n_vertices: 2 });
        assert_eq!(graph.fix(2), unknown);
        assert_eq!(graph.release(2), unknown);
        assert_eq!(graph.set_pose(2, Se2::IDENTITY), unknown);
        graph.fix(1).unwrap();
        assert_eq!(graph.fixed(), [false, true]);
        graph.release(1).unwrap();
        assert_eq!(graph.fixed(), [false, false]);
    }
}
