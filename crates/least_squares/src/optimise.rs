//! Gauss–Newton, and Levenberg–Marquardt where Gauss–Newton goes uphill.

use geometry::Se2;
use nalgebra::{Matrix3, Vector3};

use crate::{
    GraphError, PoseGraph, Start,
    graph::Edge,
    linear::{BlockCholesky, Pattern, TooLarge},
    residual::{Heading, Linearised, linearise, wrapped},
    start::{ChordalSystem, held_vertices, odometry_start},
    substitution::Scratch,
};

/// Predicted falls of the cost below this are rounding: the cost is a sum of squares in units of
/// standard deviations.
const NEGLIGIBLE_FALL: f64 = 1e-12;
/// First damping after a step uphill, relative to the diagonal.
const FIRST_DAMPING_RATIO: f64 = 1e-4;
/// Factor by which damping grows uphill and shrinks downhill.
const DAMPING_STEP: f64 = 10.0;
/// Damping below this is dropped: Gauss–Newton again.
const LEAST_DAMPING_RATIO: f64 = 1e-7;
/// Added to the diagonal with any damping, relative to its greatest entry: well above the rounding
/// of the factorisation, so that directions that no edge determines do not stop the rest.
const OPEN_DIRECTION_RATIO: f64 = 1e-10;
/// Damping above this: no direction leads downhill.
const GREATEST_DAMPING_RATIO: f64 = 1e10;

/// When to stop, where to begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// At most this many steps are taken or tried (each costs one factorisation).
    pub iterations_max: usize,
    /// Converged when a step promises to lower the cost by less than this part of it.
    pub tolerance_ratio: f64,
    /// Where to begin.
    pub start: Start,
}

/// How an optimisation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// At a minimum, within the tolerance.
    Converged,
    /// The limit of iterations came first; the poses are the best so far.
    IterationLimit,
    /// No step, however damped, lowers the cost, though one should; the poses are the best so far.
    Stalled,
    /// No edge has an end that may move: the poses are as they were.
    NothingToMove,
    /// A pose is NaN or infinite, or the errors overflow: the poses are as they were.
    NotFinite,
    /// The equations need more memory than there is: the poses are as they were.
    TooLarge,
}

/// What an optimisation did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// How it ended.
    pub outcome: Outcome,
    /// Steps taken or tried.
    pub iterations: usize,
    /// Σ eᵀΩe at the given poses, without kernels.
    pub chi2_before: f64,
    /// Σ eᵀΩe where optimisation began.
    pub chi2_at_start: f64,
    /// Σ eᵀΩe at the end.
    pub chi2_after: f64,
    /// Σ ρ(eᵀΩe) where optimisation began: what is made least.
    pub cost_at_start: f64,
    /// Σ ρ(eᵀΩe) at the end.
    pub cost_after: f64,
    /// Where it began; never `Auto`.
    pub start: Start,
    /// Vertices that were held because their part of the graph has no fixed one.
    pub n_anchors: usize,
}

/// Memory that optimisations of a graph share.
///
/// As long as the same vertices are joined and fixed, elimination order and pattern of the factor
/// are used again and nothing is allocated. It may be used for any graph at any time.
#[derive(Debug, Default)]
pub struct Workspace {
    ends: Vec<(usize, usize)>,
    is_fixed: Vec<bool>,
    is_held: Vec<bool>,
    n_anchors: usize,
    /// The poses that the graph came with.
    before: Vec<Se2>,
    pub(crate) system: Option<System>,
}

/// Equations and vectors for one structure.
#[derive(Debug)]
pub(crate) struct System {
    pub(crate) pattern: Pattern,
    pub(crate) equations: BlockCholesky<3>,
    chordal: Option<ChordalSystem>,
    /// Of the cost's half, in elimination order.
    gradient: Vec<f64>,
    diagonal: Vec<f64>,
    step: Vec<f64>,
    headings: Vec<Heading>,
    measured: Vec<Heading>,
    candidate: Vec<Se2>,
    pub(crate) marginals: Option<Scratch>,
}

/// Σ ρ and Σ eᵀΩe.
#[derive(Clone, Copy, Debug)]
struct Cost {
    robust: f64,
    chi2: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self { iterations_max: 100, tolerance_ratio: 1e-6, start: Start::Given }
    }
}

/// Moves the poses of a graph to where Σ ρ(eᵀΩe) is least, from the start that `config` names.
///
/// The minimum is local: from a bad start it may not be the least of all. Fixed vertices stay, and
/// in parts without one the vertex of least index. Poses afterwards have wrapped yaws. The cost
/// never rises above that of the start. The same graph gives the same bits, whatever the workspace
/// was used for. Cost: one sparse factorisation per iteration, plus ordering when the structure
/// has changed.
///
/// Source: Levenberg (1944) and Marquardt (1963) as in Nocedal and Wright (2006), "Numerical
/// optimization", chapter 10, with damping relative to the diagonal.
/// Differences: undamped until a step goes uphill; kernels by reweighting.
pub fn optimise(graph: &mut PoseGraph, config: &Config, scratch: &mut Workspace) -> Report {
    let mut report = Report {
        outcome: Outcome::NotFinite,
        iterations: 0,
        chi2_before: graph.chi2(),
        chi2_at_start: f64::NAN,
        chi2_after: f64::NAN,
        cost_at_start: f64::NAN,
        cost_after: f64::NAN,
        start: Start::Given,
        n_anchors: 0,
    };
    report.chi2_at_start = report.chi2_before;
    report.chi2_after = report.chi2_before;
    let is_finite = |p: &Se2| p.x_m.is_finite() && p.y_m.is_finite() && p.yaw_rad.is_finite();
    if !graph.poses.iter().all(is_finite) {
        return report;
    }
    let Ok(()) = scratch.prepare(graph) else {
        return Report { outcome: Outcome::TooLarge, ..report };
    };
    report.n_anchors = scratch.n_anchors;
    scratch.before.clone_from(&graph.poses);
    report.start = scratch.begin(graph, config.start);
    let Some(system) = &mut scratch.system else {
        return Report { outcome: Outcome::TooLarge, ..report };
    };
    let start = system.cost(&graph.edges, &graph.poses);
    report.chi2_at_start = start.chi2;
    report.cost_at_start = start.robust;
    if start.robust.is_finite() {
        system.descend(graph, config, start, &mut report);
    } else {
        graph.poses.clone_from(&scratch.before);
    }
    report
}

/// Finds poses from two linear problems: all headings first, then all positions.
///
/// Headings: unit vectors r with the sum of w |r_to − R(z) r_from|² least, where w is the
/// information about yaw; each is then scaled to length 1. Positions: the graph's own sum with the
/// headings held. The fixed vertices, and in parts without one the vertex of least index, keep
/// their poses. Kernels are not looked at. Cost: two sparse factorisations, about as much as one
/// step of [`optimise`](crate::optimise); the workspace keeps what can be used again.
///
/// Source: Carlone, Tron, Daniilidis, Dellaert (2015), "Initialization techniques for 3D SLAM: a
/// survey on rotation estimation and its use in pose graph optimization", ICRA, chordal relaxation
/// after Martinec and Pajdla (2007), "Robust rotation and translation estimation in multiview
/// reconstruction", CVPR.
/// Differences: in the plane; each edge is weighted by its own information.
///
/// # Errors
///
/// [`GraphError::Undetermined`] when the equations have no unique solution,
/// [`GraphError::TooLarge`]; the poses are left as they were.
pub fn chordal_start(graph: &mut PoseGraph, scratch: &mut Workspace) -> Result<(), GraphError> {
    scratch.chordal(graph)
}

impl Workspace {
    /// An empty one; it grows to what the graph needs.
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes the system fit the structure of the graph, if it does not.
    pub(crate) fn prepare(&mut self, graph: &PoseGraph) -> Result<(), TooLarge> {
        let is_same = self.is_fixed == graph.is_fixed
            && self.ends.len() == graph.edges.len()
            && self.ends.iter().zip(&graph.edges).all(|(ends, e)| *ends == (e.from, e.to));
        if !(is_same && self.system.is_some()) {
            self.system = None;
            self.ends.clear();
            self.ends.extend(graph.edges.iter().map(|e| (e.from, e.to)));
            self.is_fixed.clone_from(&graph.is_fixed);
            self.is_held = held_vertices(graph);
            let n_held = self.is_held.iter().filter(|held| **held).count();
            self.n_anchors = n_held - graph.is_fixed.iter().filter(|fixed| **fixed).count();
            let pattern = Pattern::new(&self.is_held, self.ends.iter().copied())?;
            self.system = Some(System::new(pattern, graph)?);
        }
        if let Some(system) = &mut self.system {
            system.measured.clear();
            let headings = graph.edges.iter().map(|e| Heading::of(e.to_in_from.yaw_rad));
            system.measured.extend(headings);
        }
        Ok(())
    }

    pub(crate) fn chordal(&mut self, graph: &mut PoseGraph) -> Result<(), GraphError> {
        let (n_vertices, n_edges) = (graph.poses.len(), graph.edges.len());
        let too_large = GraphError::TooLarge { n_vertices, n_edges };
        self.prepare(graph).map_err(|TooLarge| too_large)?;
        let system = self.system.as_mut().ok_or(too_large)?;
        system.candidate.clone_from(&graph.poses);
        let is_placed = system.place_candidate(&graph.edges).map_err(|TooLarge| too_large)?;
        if !is_placed {
            return Err(GraphError::Undetermined);
        }
        graph.poses.clone_from(&system.candidate);
        Ok(())
    }

    /// Puts the graph where optimisation shall begin; returns where that is.
    fn begin(&mut self, graph: &mut PoseGraph, start: Start) -> Start {
        match start {
            Start::Given => Start::Given,
            Start::Odometry => {
                odometry_start(graph);
                Start::Odometry
            }
            Start::Chordal => {
                if self.chordal(graph).is_ok() {
                    Start::Chordal
                } else {
                    self.begin(graph, Start::Odometry)
                }
            }
            Start::Auto => self.begin_at_best(graph),
        }
    }

    fn begin_at_best(&mut self, graph: &mut PoseGraph) -> Start {
        let mut best = Start::Given;
        let mut best_poses = graph.poses.clone();
        let mut least = self.robust_cost(graph);
        for start in [Start::Odometry, Start::Chordal] {
            if self.begin(graph, start) != start {
                continue;
            }
            let cost = self.robust_cost(graph);
            // Written so that a cost of NaN is no candidate, and any number beats it.
            if cost < least || (cost.is_finite() && !least.is_finite()) {
                (best, least) = (start, cost);
                best_poses.clone_from(&graph.poses);
            }
        }
        graph.poses = best_poses;
        best
    }

    fn robust_cost(&mut self, graph: &PoseGraph) -> f64 {
        self.system.as_mut().map_or(f64::NAN, |s| s.cost(&graph.edges, &graph.poses).robust)
    }
}

impl System {
    fn new(pattern: Pattern, graph: &PoseGraph) -> Result<Self, TooLarge> {
        let size = 3 * pattern.n_variables();
        Ok(Self {
            equations: BlockCholesky::new(&pattern)?,
            chordal: None,
            gradient: vec![0.0; size],
            diagonal: vec![0.0; size],
            step: vec![0.0; size],
            headings: Vec::with_capacity(graph.poses.len()),
            measured: Vec::with_capacity(graph.edges.len()),
            candidate: graph.poses.clone(),
            marginals: None,
            pattern,
        })
    }

    fn place_candidate(&mut self, edges: &[Edge]) -> Result<bool, TooLarge> {
        if self.chordal.is_none() {
            self.chordal = Some(ChordalSystem::new(&self.pattern)?);
        }
        let Some(chordal) = &mut self.chordal else { return Ok(false) };
        Ok(chordal.place(&self.pattern, edges, &mut self.candidate))
    }

    /// Steps until an outcome is found; the graph has the best poses then.
    fn descend(
        &mut self,
        graph: &mut PoseGraph,
        config: &Config,
        start: Cost,
        report: &mut Report,
    ) {
        let mut best = start;
        let mut damping = 0.0;
        report.outcome = Outcome::IterationLimit;
        if self.step.is_empty() {
            report.outcome = Outcome::NothingToMove;
        } else if best.robust <= NEGLIGIBLE_FALL {
            report.outcome = Outcome::Converged;
        } else if config.iterations_max > 0 {
            self.linearise(&graph.edges, &graph.poses);
        }
        while report.outcome == Outcome::IterationLimit && report.iterations < config.iterations_max
        {
            report.iterations += 1;
            let fall = self.solve(damping);
            // A damped step promises little even far away from the minimum.
            let enough = (config.tolerance_ratio * best.robust).max(NEGLIGIBLE_FALL);
            let is_last = damping <= FIRST_DAMPING_RATIO && fall.is_some_and(|f| f <= enough);
            let reached = fall.map(|_| {
                self.apply_step(&graph.poses);
                self.candidate_cost(&graph.edges)
            });
            let better = reached.filter(|cost| cost.robust < best.robust);
            if let Some(cost) = better {
                best = cost;
                std::mem::swap(&mut graph.poses, &mut self.candidate);
                damping /= DAMPING_STEP;
                if damping < LEAST_DAMPING_RATIO {
                    damping = 0.0;
                }
            } else {
                damping = (damping * DAMPING_STEP).max(FIRST_DAMPING_RATIO);
            }
            if is_last {
                report.outcome = Outcome::Converged;
            } else if better.is_some() {
                if report.iterations < config.iterations_max {
                    self.linearise(&graph.edges, &graph.poses);
                }
            } else if damping > GREATEST_DAMPING_RATIO {
                report.outcome = Outcome::Stalled;
            }
        }
        report.chi2_after = best.chi2;
        report.cost_after = best.robust;
    }

    /// Cost at some poses.
    fn cost(&mut self, edges: &[Edge], poses: &[Se2]) -> Cost {
        self.headings.clear();
        self.headings.extend(poses.iter().map(|pose| Heading::of(pose.yaw_rad)));
        let mut sum = Cost { robust: 0.0, chi2: 0.0 };
        for (edge, &z_heading) in edges.iter().zip(&self.measured) {
            let (i, j) = (poses[edge.from], poses[edge.to]);
            let e = linearise(i, self.headings[edge.from], j, edge.to_in_from, z_heading).error;
            let squared = e.dot(&(edge.information * e));
            sum.chi2 += squared;
            sum.robust += edge.kernel.cost_and_weight(squared.max(0.0)).0;
        }
        sum
    }

    fn candidate_cost(&mut self, edges: &[Edge]) -> Cost {
        let poses = std::mem::take(&mut self.candidate);
        let cost = self.cost(edges, &poses);
        self.candidate = poses;
        cost
    }

    /// Sets up the normal equations H and gradient at some poses, and keeps the diagonal of H.
    pub(crate) fn linearise(&mut self, edges: &[Edge], poses: &[Se2]) {
        self.headings.clear();
        self.headings.extend(poses.iter().map(|pose| Heading::of(pose.yaw_rad)));
        self.equations.clear();
        self.gradient.fill(0.0);
        for (index, edge) in edges.iter().enumerate() {
            let (i, j) = (poses[edge.from], poses[edge.to]);
            let (i_heading, z_heading) = (self.headings[edge.from], self.measured[index]);
            let at = linearise(i, i_heading, j, edge.to_in_from, z_heading);
            self.add_edge(index, edge, &at);
        }
        self.equations.diagonal(&self.pattern, &mut self.diagonal);
    }

    #[inline]
    fn add_edge(&mut self, index: usize, edge: &Edge, at: &Linearised) {
        let e = at.error;
        let pull = edge.information * e;
        let weight = edge.kernel.cost_and_weight(e.dot(&pull).max(0.0)).1;
        let j = at.by_to();
        let t = at.transport();
        // With the derivatives J and -J T: W = Jᵀ Ω J, blocks W, -Tᵀ W and Tᵀ W T.
        let w: Matrix3<f64> = symmetric(j.transpose() * (edge.information * weight) * j);
        let slope: Vector3<f64> = j.transpose() * pull * weight;
        let tw: Matrix3<f64> = t.transpose() * w;
        let (from, to) = (self.pattern.variable(edge.from), self.pattern.variable(edge.to));
        if let Some(to) = to {
            self.equations.add_diagonal(&self.pattern, to, &w);
            add(&mut self.gradient, to, slope);
        }
        if let Some(from) = from {
            self.equations.add_diagonal(&self.pattern, from, &symmetric(tw * t));
            add(&mut self.gradient, from, -(t.transpose() * slope));
            if to.is_some() {
                self.equations.add_edge(&self.pattern, index, &-tw);
            }
        }
    }

    /// Solves (H + damping · diag H) step = -gradient; returns by how much the step should lower
    /// the cost, or none when the matrix is not positive definite.
    fn solve(&mut self, damping: f64) -> Option<f64> {
        let greatest = self.diagonal.iter().fold(0.0, |a: f64, b| a.max(*b));
        // Directions of which nothing is known are damped as if a little were.
        let floor = if damping > 0.0 { greatest * OPEN_DIRECTION_RATIO } else { 0.0 };
        let damped = self.diagonal.iter().map(|d| d + damping * d + floor);
        self.equations.set_diagonal(&self.pattern, damped);
        if !self.equations.factorise() {
            return None;
        }
        for (step, slope) in self.step.iter_mut().zip(&self.gradient) {
            *step = -slope;
        }
        self.equations.solve(&mut self.step);
        // Cost falls by -2 gᵀs - sᵀHs with (H + D) s = -g: by -gᵀs + sᵀDs.
        let mut fall = 0.0;
        for ((step, slope), d) in self.step.iter().zip(&self.gradient).zip(&self.diagonal) {
            fall += step * ((damping * d + floor) * step - slope);
        }
        fall.is_finite().then_some(fall)
    }

    fn apply_step(&mut self, poses: &[Se2]) {
        self.candidate.clear();
        self.candidate.extend(poses.iter().enumerate().map(|(vertex, pose)| {
            let Some(variable) = self.pattern.variable(vertex) else { return *pose };
            let step = &self.step[3 * variable..3 * variable + 3];
            Se2 {
                x_m: pose.x_m + step[0],
                y_m: pose.y_m + step[1],
                yaw_rad: wrapped(pose.yaw_rad + step[2]),
            }
        }));
    }
}

fn symmetric(m: Matrix3<f64>) -> Matrix3<f64> {
    (m + m.transpose()) * 0.5
}

fn add(gradient: &mut [f64], variable: usize, value: Vector3<f64>) {
    for (sum, v) in gradient[3 * variable..3 * variable + 3].iter_mut().zip(value.iter()) {
        *sum += v;
    }
}
