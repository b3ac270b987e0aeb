//! How uncertain poses are, read from the factor without inverting it.
//!
//! With H = L Lᵀ, the block of H⁻¹ at (a, b) is Y_aᵀ Y_b with Y_a = L⁻¹ E_a, and Y_a is zero off the
//! path from a to the root of the elimination tree. So a covariance costs two short substitutions.

use geometry::Se2;
use nalgebra::{Matrix3, Matrix6, SMatrix};

use crate::{
    GraphError, PoseGraph, Workspace,
    linear::{BlockCholesky, Pattern, TooLarge},
    optimise::System,
    residual::{Heading, linearise},
    start::parts,
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

/// Memory of the substitutions.
#[derive(Debug)]
pub(crate) struct Scratch {
    /// The supernode of every column.
    supernodes: Vec<u32>,
    /// Y of the vertex asked about and of its partner, kept until another is asked about.
    first: Column,
    second: Column,
}

/// Three columns of L⁻¹, and the rows (begin, end) where they are not zero, ascending.
#[derive(Debug, Default)]
struct Column {
    /// Whose columns they are; none: all is zero.
    vertex: Option<usize>,
    rows: Vec<[f64; 3]>,
    path: Vec<(usize, usize)>,
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

impl Scratch {
    fn new(equations: &BlockCholesky<3>, pattern: &Pattern) -> Self {
        let size = 3 * pattern.n_variables();
        let mut supernodes = Vec::with_capacity(size);
        let mut n_supernodes = 0;
        if let Some(symbolic) = equations.symbolic_supernodes() {
            n_supernodes = symbolic.n_supernodes();
            let ends = symbolic.supernode_begin().iter().zip(symbolic.supernode_end());
            for (index, (begin, end)) in ends.enumerate() {
                supernodes.extend((*begin..*end).map(|_| index as u32));
            }
        }
        let column = || Column {
            vertex: None,
            rows: vec![[0.0; 3]; size],
            path: Vec::with_capacity(n_supernodes),
        };
        Self { supernodes, first: column(), second: column() }
    }
}

impl Column {
    fn become_that_of(
        &mut self,
        vertex: usize,
        pattern: &Pattern,
        equations: &BlockCholesky<3>,
        supernodes: &[u32],
    ) -> Option<()> {
        if self.vertex == Some(vertex) {
            return Some(());
        }
        self.clear();
        if let Some(variable) = pattern.variable(vertex) {
            self.substitute(equations, supernodes, variable)?;
        }
        self.vertex = Some(vertex);
        Some(())
    }

    /// Solves L Y = E for the three columns of a variable, along its path.
    fn substitute(
        &mut self,
        equations: &BlockCholesky<3>,
        supernodes: &[u32],
        variable: usize,
    ) -> Option<()> {
        let factor = equations.supernodes()?;
        for axis in 0..3 {
            self.rows[3 * variable + axis][axis] = 1.0;
        }
        let mut supernode = supernodes[3 * variable] as usize;
        loop {
            let part = factor.supernode(supernode);
            let (start, pattern) = (part.start(), part.pattern());
            let n_columns = part.val().ncols();
            self.path.push((start, start + n_columns));
            for column in 0..n_columns {
                // The columns of a supernode are contiguous: its own rows first, then the pattern.
                let entries = part.val().col(column).try_as_col_major()?.as_slice();
                let y = self.rows[start + column].map(|v| v / entries[column]);
                self.rows[start + column] = y;
                if y.iter().all(|v| *v == 0.0) {
                    continue;
                }
                let own = self.rows[start..start + n_columns].iter_mut().skip(column + 1);
                for (row, l) in own.zip(&entries[column + 1..n_columns]) {
                    subtract(row, *l, y);
                }
                for (row, l) in pattern.iter().zip(&entries[n_columns..]) {
                    subtract(&mut self.rows[*row as usize], *l, y);
                }
            }
            let Some(next) = pattern.first() else { return Some(()) };
            supernode = supernodes[*next as usize] as usize;
        }
    }

    /// Sets everything to zero again.
    fn clear(&mut self) {
        self.vertex = None;
        for (begin, end) in self.path.drain(..) {
            self.rows[begin..end].fill([0.0; 3]);
        }
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

/// Y_aᵀ Y_b.
fn product(a: &Column, b: &Column) -> Matrix3<f64> {
    let mut sum = Matrix3::zeros();
    for &(begin, end) in &a.path {
        for (x, y) in a.rows[begin..end].iter().zip(&b.rows[begin..end]) {
            for column in 0..3 {
                for row in 0..3 {
                    sum[(row, column)] += x[row] * y[column];
                }
            }
        }
    }
    sum
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

#[inline]
fn subtract(row: &mut [f64; 3], l: f64, y: [f64; 3]) {
    for axis in 0..3 {
        row[axis] -= l * y[axis];
    }
}
