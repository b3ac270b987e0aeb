//! Poses to begin with: along the edges, or from linear equations.

use geometry::Se2;
use nalgebra::{Matrix2, Vector2};

use crate::{
    PoseGraph,
    graph::Edge,
    linear::{BlockCholesky, Pattern},
    residual::wrapped,
};

/// Where optimisation begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Start {
    /// At the poses that the graph has.
    #[default]
    Given,
    /// At those of [`odometry_start`].
    Odometry,
    /// At those of [`chordal_start`](crate::chordal_start); when that has no solution, at those of `Odometry`.
    Chordal,
    /// At that of the three where the cost is least; the earlier one when it is equal.
    Auto,
}

/// Places all vertices along edges, from the held vertices outwards.
///
/// Edges between vertices whose indices differ by one are followed first, in the order in which
/// they were added; the others only join what is not joined yet. The fixed vertices, and in parts
/// without one the vertex of least index, keep their poses. Cost: nearly linear.
pub fn odometry_start(graph: &mut PoseGraph) {
    let is_held = held_vertices(graph);
    place_along_edges(graph, &is_held);
}

/// For every vertex whether it is held: fixed by the caller, or the first of a part without one.
pub(crate) fn held_vertices(graph: &PoseGraph) -> Vec<bool> {
    let mut parts = Parts::new(graph.poses.len());
    for edge in &graph.edges {
        parts.join(edge.from, edge.to);
    }
    let mut has_fixed = vec![false; graph.poses.len()];
    for vertex in (0..graph.poses.len()).filter(|v| graph.is_fixed[*v]) {
        has_fixed[parts.root(vertex)] = true;
    }
    let mut is_held = graph.is_fixed.clone();
    for vertex in 0..graph.poses.len() {
        // The root of a part is its least vertex.
        if parts.root(vertex) == vertex && !has_fixed[vertex] {
            is_held[vertex] = true;
        }
    }
    is_held
}

/// For every vertex the least one of its part of the graph.
pub(crate) fn parts(graph: &PoseGraph) -> Vec<usize> {
    let mut parts = Parts::new(graph.poses.len());
    for edge in &graph.edges {
        parts.join(edge.from, edge.to);
    }
    (0..graph.poses.len()).map(|vertex| parts.root(vertex)).collect()
}

/// Places every vertex that a chain of edges joins with a known one.
pub(crate) fn place_along_edges(graph: &mut PoseGraph, is_known: &[bool]) {
    let n = graph.poses.len();
    let mut parts = Parts::new(n + 1);
    // All known vertices are one part, through a vertex that does not exist.
    for vertex in (0..n).filter(|v| is_known[*v]) {
        parts.join(vertex, n);
    }
    let is_consecutive = |edge: &&Edge| edge.from.abs_diff(edge.to) == 1;
    let is_other = |edge: &&Edge| edge.from.abs_diff(edge.to) != 1;
    let mut tree: Vec<(usize, usize, Se2)> = Vec::with_capacity(n);
    let edges =
        graph.edges.iter().filter(is_consecutive).chain(graph.edges.iter().filter(is_other));
    for edge in edges {
        if parts.join(edge.from, edge.to) {
            tree.push((edge.from, edge.to, edge.to_in_from));
        }
    }
    let mut both_ways: Vec<(usize, usize, Se2)> = Vec::with_capacity(2 * tree.len());
    both_ways.extend(&tree);
    both_ways.extend(tree.iter().map(|&(from, to, to_in_from)| (to, from, to_in_from.inverse())));
    both_ways.sort_by_key(|&(from, to, _)| (from, to));
    let mut is_placed = is_known.to_vec();
    let mut open: Vec<usize> = (0..n).filter(|v| is_known[*v]).collect();
    while let Some(vertex) = open.pop() {
        let first = both_ways.partition_point(|step| step.0 < vertex);
        for &(_, to, to_in_from) in both_ways[first..].iter().take_while(|step| step.0 == vertex) {
            if !is_placed[to] {
                is_placed[to] = true;
                graph.poses[to] = graph.poses[vertex].compose(to_in_from);
                open.push(to);
            }
        }
    }
}

/// Memory of the two linear problems.
#[derive(Debug)]
pub(crate) struct ChordalSystem {
    equations: BlockCholesky<2>,
    right_side: Vec<f64>,
}

impl ChordalSystem {
    pub(crate) fn new(pattern: &Pattern) -> Result<Self, crate::linear::TooLarge> {
        let equations = BlockCholesky::new(pattern)?;
        Ok(Self { equations, right_side: vec![0.0; 2 * pattern.n_variables()] })
    }

    /// Puts the poses of the chordal start into `poses`, which holds those of held vertices; false
    /// when there is no unique solution.
    pub(crate) fn place(&mut self, pattern: &Pattern, edges: &[Edge], poses: &mut [Se2]) -> bool {
        self.turn(pattern, edges, poses) && self.shift(pattern, edges, poses)
    }

    fn turn(&mut self, pattern: &Pattern, edges: &[Edge], poses: &mut [Se2]) -> bool {
        self.equations.clear();
        self.right_side.fill(0.0);
        for (index, edge) in edges.iter().enumerate() {
            let w = edge.information.m33;
            let (sin, cos) = edge.to_in_from.yaw_rad.sin_cos();
            // w |r_to - R r_from|²: the blocks are w 1, w 1 and -w Rᵀ at (from, to).
            let turn = Matrix2::new(cos, -sin, sin, cos);
            let (from, to) = (pattern.variable(edge.from), pattern.variable(edge.to));
            let unit = Matrix2::from_diagonal_element(w);
            if let Some(from) = from {
                self.equations.add_diagonal(pattern, from, &unit);
            }
            if let Some(to) = to {
                self.equations.add_diagonal(pattern, to, &unit);
            }
            match (from, to) {
                (Some(_), Some(_)) => {
                    self.equations.add_edge(pattern, index, &(turn.transpose() * -w));
                }
                (Some(from), None) => {
                    self.add(from, turn.transpose() * poses[edge.to].heading() * w);
                }
                (None, Some(to)) => self.add(to, turn * poses[edge.from].heading() * w),
                (None, None) => {}
            }
        }
        if !self.equations.factorise() {
            return false;
        }
        self.equations.solve(&mut self.right_side);
        for (vertex, pose) in poses.iter_mut().enumerate() {
            if let Some(variable) = pattern.variable(vertex) {
                let (x, y) = (self.right_side[2 * variable], self.right_side[2 * variable + 1]);
                pose.yaw_rad = wrapped(y.atan2(x));
            }
        }
        poses.iter().all(|pose| pose.yaw_rad.is_finite())
    }

    fn shift(&mut self, pattern: &Pattern, edges: &[Edge], poses: &mut [Se2]) -> bool {
        self.equations.clear();
        self.right_side.fill(0.0);
        for (index, edge) in edges.iter().enumerate() {
            let z = edge.to_in_from;
            let (from, to) = (pattern.variable(edge.from), pattern.variable(edge.to));
            // e_t = M (t_to - t_from) - R_zᵀ t_z with M = R(yaw_from + yaw_z)ᵀ; e_yaw is given.
            let (sin, cos) = (poses[edge.from].yaw_rad + z.yaw_rad).sin_cos();
            let m = Matrix2::new(cos, sin, -sin, cos);
            let (sin, cos) = z.yaw_rad.sin_cos();
            let mut e = -(Matrix2::new(cos, sin, -sin, cos) * z.position());
            if from.is_none() {
                e -= m * poses[edge.from].position();
            }
            if to.is_none() {
                e += m * poses[edge.to].position();
            }
            let turned = poses[edge.to].yaw_rad - poses[edge.from].yaw_rad - z.yaw_rad;
            let information: Matrix2<f64> = edge.information.fixed_view::<2, 2>(0, 0).into_owned();
            let coupling: Vector2<f64> = edge.information.fixed_view::<2, 1>(0, 2).into_owned();
            let pull = m.transpose() * (information * e + coupling * wrapped(turned));
            let mut block = m.transpose() * information * m;
            block.m12 = block.m21;
            if let Some(from) = from {
                self.equations.add_diagonal(pattern, from, &block);
                self.add(from, pull);
            }
            if let Some(to) = to {
                self.equations.add_diagonal(pattern, to, &block);
                self.add(to, -pull);
            }
            if from.is_some() && to.is_some() {
                self.equations.add_edge(pattern, index, &-block);
            }
        }
        if !self.equations.factorise() {
            return false;
        }
        self.equations.solve(&mut self.right_side);
        for (vertex, pose) in poses.iter_mut().enumerate() {
            if let Some(variable) = pattern.variable(vertex) {
                pose.x_m = self.right_side[2 * variable];
                pose.y_m = self.right_side[2 * variable + 1];
            }
        }
        poses.iter().all(|pose| pose.x_m.is_finite() && pose.y_m.is_finite())
    }

    fn add(&mut self, variable: usize, value: Vector2<f64>) {
        self.right_side[2 * variable] += value.x;
        self.right_side[2 * variable + 1] += value.y;
    }
}

/// Union–find; the root of a part is its least member.
struct Parts(Vec<usize>);

impl Parts {
    fn new(n: usize) -> Self {
        Self((0..n).collect())
    }

    fn root(&mut self, mut member: usize) -> usize {
        while self.0[member] != member {
            self.0[member] = self.0[self.0[member]];
            member = self.0[member];
        }
        member
    }

    /// Joins two parts; false when they were one.
    fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
        a != b
    }
}
