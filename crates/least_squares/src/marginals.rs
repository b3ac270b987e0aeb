//! How uncertain poses are, read from the factor without inverting it.
//!
//! With H = L Lᵀ, the block of H⁻¹ at (a, b) is Y_aᵀ Y_b with Y_a = L⁻¹ E_a, and Y_a is zero off the
//! path from a to the root of the elimination tree. So a covariance costs two short substitutions.

use geometry::Se2;
use nalgebra::{Matrix3, Matrix6, SMatrix};

use crate::{
    GraphError, PoseGraph, Workspace,
    linear::TooLarge,
    optimise::System,
    residual::{Heading, linearise},
    start::parts,
    substitution::{Column, Scratch, product},
};

/// Covariances of the poses of a graph, at the poses that it had when this was made.
///
/// They hold to first order, and only near a minimum. Edges count with the weights of their
/// kernels. Everything is relative to the fixed vertices (in parts of the graph without one, to the
/// vertex of least index).
#[derive(Debug)]
pub struct Marginals<'a> {
    system: &'a mut System,
    poses: &'a [Se2],
    /// For every vertex the least one of its part of the graph; the same for all parts that have a
    /// fixed vertex, for their places in the frame of the graph are known.
    part: Vec<usize>,
}

impl<'a> Marginals<'a> {
    /// Factorises the equations at the present poses. Cost: as one iteration of
    /// [`optimise`](crate::optimise), without the ordering when the workspace knows the structure.
    ///
    /// # Errors
    ///
    /// [`GraphError::Undetermined`] when the edges leave some direction open or a pose is not
    /// finite, [`GraphError::TooLarge`].
    pub fn new(graph: &'a PoseGraph, scratch: &'a mut Workspace) -> Result<Self, GraphError> {
        let (n_vertices, n_edges) = (graph.poses.len(), graph.edges.len());
        let too_large = GraphError::TooLarge { n_vertices, n_edges };
        scratch.prepare(graph).map_err(|TooLarge| too_large)?;
        let system = scratch.system.as_mut().ok_or(too_large)?;
        system.linearise(&graph.edges, &graph.poses);
        if !system.equations.factorise() {
            return Err(GraphError::Undetermined);
        }
        let fresh = || Scratch::new(&system.equations, &system.pattern);
        let columns = system.marginals.get_or_insert_with(fresh);
        columns.first.clear();
        columns.second.clear();
        Ok(Self { system, poses: &graph.poses, part: placed_parts(graph) })
    }

    /// Covariance of a pose in the frame of the graph, order x, y, yaw (m², m rad, rad²); zero for
    /// a held vertex. Cost: the entries of the factor on the vertex's path to the root.
    ///
    /// # Errors
    ///
    /// [`GraphError::UnknownVertex`].
    pub fn covariance(&mut self, vertex: usize) -> Result<Matrix3<f64>, GraphError> {
        self.known(vertex)?;
        let covariance = self.with_columns(vertex, vertex, |a, _| product(a, a));
        Ok(covariance.unwrap_or_else(Matrix3::zeros))
    }

    /// Covariance of two poses together, in the frame of the graph, order x, y, yaw of `first`, then
    /// of `second`. Cost: as for two vertices.
    ///
    /// # Errors
    ///
    /// [`GraphError::UnknownVertex`].
    pub fn joint(&mut self, first: usize, second: usize) -> Result<Matrix6<f64>, GraphError> {
        self.known(first)?;
        self.known(second)?;
        let zero = [Matrix3::zeros(); 3];
        let [aa, ab, bb] = self
            .with_columns(first, second, |a, b| [product(a, a), product(a, b), product(b, b)])
            .unwrap_or(zero);
        let mut joint = Matrix6::zeros();
        joint.fixed_view_mut::<3, 3>(0, 0).copy_from(&aa);
        joint.fixed_view_mut::<3, 3>(0, 3).copy_from(&ab);
        joint.fixed_view_mut::<3, 3>(3, 0).copy_from(&ab.transpose());
        joint.fixed_view_mut::<3, 3>(3, 3).copy_from(&bb);
        Ok(joint)
    }

    /// Covariance of the pose of `to` in the frame of `from`, order x, y, yaw (m², m rad, rad²):
    /// what a loop closure between the two may differ by. Cost: as for [`joint`](Self::joint); half
    /// of it when one question after another has the same `to`.
    ///
    /// # Errors
    ///
    /// [`GraphError::UnknownVertex`], [`GraphError::NotConnected`].
    pub fn relative(&mut self, from: usize, to: usize) -> Result<Matrix3<f64>, GraphError> {
        let joint = self.joint(from, to)?;
        if self.part[from] != self.part[to] {
            return Err(GraphError::NotConnected { from, to });
        }
        let jacobian = derivative_of_relative(self.poses[from], self.poses[to]);
        let covariance = jacobian * joint * jacobian.transpose();
        Ok((covariance + covariance.transpose()) * 0.5)
    }

    fn known(&self, vertex: usize) -> Result<(), GraphError> {
        let n_vertices = self.poses.len();
        let is_known = vertex < n_vertices;
        is_known.then_some(()).ok_or(GraphError::UnknownVertex { vertex, n_vertices })
    }

    /// Asks about the columns of two vertices; those of held vertices are zero.
    fn with_columns<T>(
        &mut self,
        first: usize,
        second: usize,
        ask: impl FnOnce(&Column, &Column) -> T,
    ) -> Option<T> {
        let System { pattern, equations, marginals, .. } = &mut *self.system;
        let Scratch { supernodes, first: a, second: b } = marginals.as_mut()?;
        a.become_that_of(first, pattern, equations, supernodes)?;
        if first == second {
            return Some(ask(a, a));
        }
        b.become_that_of(second, pattern, equations, supernodes)?;
        Some(ask(a, b))
    }
}

/// The parts of a graph, those with a fixed vertex taken as one.
fn placed_parts(graph: &PoseGraph) -> Vec<usize> {
    let mut part = parts(graph);
    let mut has_fixed = vec![false; part.len()];
    for vertex in (0..part.len()).filter(|v| graph.is_fixed[*v]) {
        has_fixed[part[vertex]] = true;
    }
    for number in part.iter_mut().filter(|number| has_fixed[**number]) {
        *number = usize::MAX;
    }
    part
}

/// Derivative of the pose of `to` in the frame of `from` by both poses.
fn derivative_of_relative(from: Se2, to: Se2) -> SMatrix<f64, 3, 6> {
    let heading = Heading::of(from.yaw_rad);
    let at = linearise(from, heading, to, Se2::IDENTITY, Heading { cos: 1.0, sin: 0.0 });
    let by_to = at.by_to();
    let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
    jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&-(by_to * at.transport()));
    jacobian.fixed_view_mut::<3, 3>(0, 3).copy_from(&by_to);
    jacobian
}
