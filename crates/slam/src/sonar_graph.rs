//! Sonar in a pose graph: short-term maps as submaps, continuous localisation between them, loops.
//!
//! [`continuous_localisation`] fuses each short-term map into one long-term map for good: what was
//! laid wrong once stays wrong. Here every short-term map keeps its own frame and is a vertex; what
//! continuous localisation found between two of them is an edge; and where the robot returns, the newest
//! submaps together are searched for on the old ones. A loop becomes an edge when the minimum of the
//! scores is distinct and lies where the graph allows it; directions that the scores do not show (along
//! a corridor) get next to no information. The map is drawn from the submaps at their optimised poses.
//!
//! Source: the combination is ours. For submaps as vertices see M. Bosse et al. (2004), IJRR 23(12).

use continuous_localisation::{
    ConfigError, Localiser, LocaliserConfig, Registration, SearchLevel,
    search::{Evidence, search},
};
use geometry::{Se2, Vec2, wrap_to_pi};
use grid_maps::{LogOddsMap, MapError};
use least_squares::{Config as SolverConfig, Edge, Kernel, PoseGraph, Workspace, optimise};
use nalgebra::{Matrix3, Vector3};
use recordings::{RingRig, Scan, StampedPose};
use run_context::Stamp;

use crate::uncertainty::{Links, adjoint, in_own_axes};

/// What can be set about sonar in a graph, beside continuous localisation itself.
#[derive(Clone, Debug, PartialEq)]
pub struct SonarGraphConfig {
    /// Continuous localisation, which makes the submaps and the edges between neighbours.
    pub localiser: LocaliserConfig,
    /// Way between two visits that makes a loop, metres.
    pub way_min_m: f64,
    /// Submaps nearer than this are tried, metres.
    pub radius_m: f64,
    /// Newest submaps that are searched for together; one alone says too little.
    pub together: usize,
    /// Poses that are tried, level by level.
    pub search: Vec<SearchLevel>,
    /// A loop's variances are this many times those of its score surface: neighbouring cells are alike.
    pub inflation_ratio: f64,
}

impl Default for SonarGraphConfig {
    fn default() -> Self {
        let coarse = SearchLevel {
            n_shifts: 6,
            shift_step_cells: 3.0,
            n_headings: 4,
            heading_step_rad: 2.0_f64.to_radians(),
        };
        Self {
            localiser: LocaliserConfig::default(),
            way_min_m: 8.0,
            radius_m: 2.0,
            together: 4,
            search: vec![coarse, SearchLevel::wide(), SearchLevel::source(3)],
            inflation_ratio: 4.0,
        }
    }
}

/// A loop between two short-term maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SonarLoop {
    /// The older submap.
    pub from: usize,
    /// The newest submap.
    pub to: usize,
    /// How far the estimate was off, metres.
    pub shift_m: f64,
    /// The same, radians.
    pub shift_rad: f64,
}

/// What became of a short-term map that was mature.
#[derive(Clone, Debug, PartialEq)]
pub struct SubmapReport {
    /// What continuous localisation made of it.
    pub registration: Registration,
    /// The loop that it closed.
    pub closed: Option<SonarLoop>,
}

/// A short-term map in the frame of the robot's pose at its end.
#[derive(Clone, Debug)]
struct Submap {
    map: LogOddsMap,
    /// Where the robot's pose at the end lies in the frame in which `map` was drawn.
    drawn_from_base: Se2,
    /// The rows of the short-term map, seen from the pose at the end.
    rows: Vec<StampedPose>,
    travelled_m: f64,
    ended: Stamp,
}

/// Sonar SLAM with a graph. Feed it rows in order; ask for trajectory and map whenever you like.
#[derive(Debug)]
pub struct SonarGraph {
    config: SonarGraphConfig,
    localiser: Localiser,
    submaps: Vec<Submap>,
    poses: Vec<Se2>,
    graph: PoseGraph,
    links: Links,
    workspace: Workspace,
    loops: Vec<SonarLoop>,
    /// Where continuous localisation saw the robot at the end of the last submap.
    last_end: Option<Se2>,
    n_tried: usize,
}

impl SonarGraph {
    /// Begins empty; the frame is that of the first pose of odometry.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] for a parameter outside its range.
    pub fn new(ring: &RingRig, config: SonarGraphConfig) -> Result<Self, ConfigError> {
        Ok(Self {
            localiser: Localiser::new(ring, config.localiser.clone())?,
            config,
            submaps: Vec::new(),
            poses: Vec::new(),
            graph: PoseGraph::default(),
            links: Links::default(),
            workspace: Workspace::default(),
            loops: Vec::new(),
            last_end: None,
            n_tried: 0,
        })
    }

    /// Takes one row. Returns the registration of a short-term map that became a submap, and a loop.
    ///
    /// # Errors
    ///
    /// [`MapError`] when submaps spread over more cells than a map may have.
    pub fn step(&mut self, scan: &Scan) -> Result<Option<SubmapReport>, MapError> {
        let registration = self.localiser.step(scan);
        self.take(registration)
    }

    /// Odometry between the rows, in order of time.
    pub fn add_odometry(&mut self, stamp: Stamp, odom_from_base: Se2) {
        self.localiser.add_odometry(stamp, odom_from_base);
    }

    /// Takes what is left and optimises to the end.
    ///
    /// # Errors
    ///
    /// As [`step`](Self::step).
    pub fn finish(&mut self) -> Result<Option<SubmapReport>, MapError> {
        let registration = self.localiser.finish();
        let taken = self.take(registration)?;
        self.solve();
        Ok(taken)
    }

    /// One pose (`map_from_base`) for each row in a submap, in order of time.
    pub fn trajectory(&self) -> Vec<StampedPose> {
        let placed = self.submaps.iter().zip(&self.poses).flat_map(|(submap, pose)| {
            submap
                .rows
                .iter()
                .map(|row| StampedPose { stamp: row.stamp, pose: pose.compose(row.pose) })
        });
        placed.collect()
    }

    /// When each submap ended: the times of the graph's vertices.
    pub fn submap_stamps(&self) -> Vec<Stamp> {
        self.submaps.iter().map(|submap| submap.ended).collect()
    }

    /// Where the robot is now, by the graph and what continuous localisation knows since the last submap.
    pub fn map_from_base(&self) -> Option<Se2> {
        let now = self.localiser.map_from_base()?;
        match (self.poses.last(), self.last_end) {
            (Some(pose), Some(end)) => Some(pose.compose(end.inverse().compose(now))),
            _ => Some(now),
        }
    }

    /// The map drawn from all submaps where the graph has them.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`] when they spread over more cells than a map may have.
    pub fn map(&self) -> Result<LogOddsMap, MapError> {
        self.drawn(0..self.submaps.len())
    }

    /// The loops that were believed.
    pub fn loops(&self) -> &[SonarLoop] {
        &self.loops
    }

    /// How many times a loop was looked for.
    pub fn n_tried(&self) -> usize {
        self.n_tried
    }

    /// The graph: a vertex for each submap, at the robot's pose at its end; the first is fixed.
    pub fn graph(&self) -> &PoseGraph {
        &self.graph
    }

    /// Continuous localisation beneath, with its own long-term map, which no loop corrects.
    pub fn localiser(&self) -> &Localiser {
        &self.localiser
    }

    fn take(
        &mut self,
        registration: Option<Registration>,
    ) -> Result<Option<SubmapReport>, MapError> {
        let (Some(registration), Some(end)) = (registration, self.localiser.map_from_base()) else {
            return Ok(None);
        };
        let base_from_map = end.inverse();
        let row = |row: &StampedPose| StampedPose { pose: base_from_map.compose(row.pose), ..*row };
        let step = self.last_end.map(|last| last.inverse().compose(end));
        let way_m = step.map_or(0.0, |step| step.position().norm());
        let travelled_m = self.submaps.last().map_or(0.0, |last| last.travelled_m) + way_m;
        self.submaps.push(Submap {
            map: self.localiser.short_term_map().clone(),
            drawn_from_base: registration.drawn_end,
            rows: registration.poses.iter().map(row).collect(),
            travelled_m,
            ended: registration.stamp,
        });
        self.links.add_vertex();
        let pose = match (step, self.poses.last()) {
            (Some(step), Some(last)) => last.compose(step),
            _ => end,
        };
        self.poses.push(pose);
        self.graph.add_vertex(pose);
        self.last_end = Some(end);
        let index = self.submaps.len() - 1;
        if let Some(step) = step {
            let information = self.step_information(step);
            self.add_edge(Edge {
                from: index - 1,
                to: index,
                to_in_from: step,
                information,
                kernel: Kernel::None,
            });
        }
        let found = self.close_loop(index)?;
        Ok(Some(SubmapReport { registration, closed: found }))
    }

    /// What continuous localisation knows of a step: odometry's growth over its way.
    fn step_information(&self, step: Se2) -> Matrix3<f64> {
        let trust = &self.config.localiser.odometry;
        let way_m = step.position().norm();
        let position_var = trust.position_std_m.powi(2) * way_m.max(0.1);
        let heading_var = trust.heading_std_rad.powi(2) * way_m.max(0.1)
            + trust.turn_std_rad.powi(2) * step.yaw_rad.abs();
        Matrix3::from_diagonal(&Vector3::new(
            position_var.recip(),
            position_var.recip(),
            heading_var.recip(),
        ))
    }

    /// Looks for the newest submaps on the old ones about them; ties them when that is distinct.
    fn close_loop(&mut self, index: usize) -> Result<Option<SonarLoop>, MapError> {
        let pose = self.poses[index];
        let travelled_m = self.submaps[index].travelled_m;
        let apart_m = |j: &usize| (self.poses[*j].position() - pose.position()).norm();
        let is_old =
            |j: &usize| travelled_m - self.submaps[*j].travelled_m >= self.config.way_min_m;
        let old: Vec<usize> = (0..(index + 1).saturating_sub(self.config.together))
            .filter(|j| is_old(j) && apart_m(j) < 2.0 * self.config.radius_m)
            .collect();
        let nearest = old.iter().copied().min_by(|a, b| apart_m(a).total_cmp(&apart_m(b)));
        let Some(from) = nearest.filter(|j| apart_m(j) < self.config.radius_m) else {
            return Ok(None);
        };
        self.n_tried += 1;
        let there = self.drawn(old.into_iter())?;
        let here = self.drawn((index + 1).saturating_sub(self.config.together)..=index)?;
        let pivot: Vec2 = pose.position();
        let evidence = Evidence::of(&here, pivot);
        let config = &self.config.localiser;
        let result = search(&there, &evidence, pivot, &self.config.search, config.score)?;
        let Some((by, covariance)) = result.measured(&config.distinct) else { return Ok(None) };
        let found = Se2::new(pose.x_m + by.x, pose.y_m + by.y, pose.yaw_rad + by.z);
        let covariance = covariance * self.config.inflation_ratio;
        if !self.is_allowed(from, index, by, &covariance) {
            return Ok(None);
        }
        let Some(information) = covariance.try_inverse() else { return Ok(None) };
        self.add_edge(Edge {
            from,
            to: index,
            to_in_from: self.poses[from].inverse().compose(found),
            information: in_own_axes(&information, found),
            kernel: Kernel::Cauchy { width_ratio: 2.0 },
        });
        let (shift_m, shift_rad) = (by.xy().norm(), wrap_to_pi(by.z).abs());
        let found = SonarLoop { from, to: index, shift_m, shift_rad };
        self.loops.push(found);
        self.solve();
        Ok(Some(found))
    }

    /// Whether a shift (x, y, yaw in the map's axes) is within three deviations of what is uncertain.
    fn is_allowed(
        &self,
        from: usize,
        to: usize,
        by: Vector3<f64>,
        covariance: &Matrix3<f64>,
    ) -> bool {
        let Some(seen) = self.links.seen_from(from, &self.poses)[to] else { return false };
        let mut turn = adjoint(self.poses[to]);
        turn.fixed_view_mut::<2, 1>(0, 2).fill(0.0);
        let expected = turn * seen * turn.transpose() + covariance;
        expected.cholesky().is_some_and(|factor| by.dot(&factor.solve(&by)) < 9.0)
    }

    /// Ties two submaps; an edge that is not finite is left out, since it would say nothing.
    fn add_edge(&mut self, edge: Edge) {
        let Edge { from, to, to_in_from, information, .. } = edge;
        let Some(covariance) = information.try_inverse() else { return };
        if self.graph.add_edge(edge).is_ok() {
            self.links.add(from, to, to_in_from, covariance);
        }
    }

    fn solve(&mut self) {
        if self.loops.is_empty() {
            return;
        }
        optimise(&mut self.graph, &SolverConfig::default(), &mut self.workspace);
        self.poses.clear();
        self.poses.extend_from_slice(self.graph.poses());
    }

    /// The map of some submaps at their poses in the graph.
    fn drawn(&self, members: impl Iterator<Item = usize>) -> Result<LogOddsMap, MapError> {
        let mut map = self.localiser.map().clone();
        map.clear();
        for i in members {
            let submap = &self.submaps[i];
            let map_from_drawn = self.poses[i].compose(submap.drawn_from_base.inverse());
            map.merge_at(&submap.map, map_from_drawn)?;
        }
        Ok(map)
    }
}
