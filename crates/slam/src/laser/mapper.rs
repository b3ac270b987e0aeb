//! One scan at a time: track it, make it a keyframe when there is news, close loops, keep the graph.

use geometry::{Se2, Twist, Vec2};
use least_squares::{Config as SolverConfig, Edge, Kernel, PoseGraph, Workspace, optimise};
use nalgebra::Matrix3;
use recordings::{LaserRig, Scan, StampedPose};
use run_context::Stamp;

use crate::uncertainty::Links;

use super::{
    closure::{Closure, Rejection, edge_information},
    config::LaserConfig,
    correlative::pose_distance,
    keyframe::Keyframe,
    local_map::{LocalMap, isotropic},
    loops::{Known, LoopCloser},
    points::{PointScan, points_of, range_std_m},
    sight::Sight,
    surfels::Refined,
};

/// Scans from which the noise of the ranges is learnt.
const NOISE_SCANS: usize = 31;

/// How a scan was placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tracking {
    /// The first scan: it is where the map begins.
    First,
    /// The robot did not move; the scan is where the last one was.
    Standing,
    /// It fits the local map.
    Matched,
    /// It does not fit; dead reckoning places it.
    Lost,
}

/// What one step did.
#[derive(Clone, Debug, PartialEq)]
pub struct StepReport {
    /// The pose of this scan, in `Map`.
    pub map_from_base: Se2,
    /// How it was placed.
    pub tracking: Tracking,
    /// Share of its points that the local map explained.
    pub inlier_ratio: f64,
    /// The keyframe that it became, if it did.
    pub keyframe: Option<usize>,
    /// Loops that were closed.
    pub closures: Vec<Closure>,
    /// Whether the graph was optimised, so that earlier poses moved.
    pub graph_moved: bool,
}

/// Where a scan stands: a keyframe, and its pose in that keyframe's frame.
#[derive(Clone, Copy, Debug)]
struct Placed {
    stamp: Stamp,
    keyframe: usize,
    keyframe_from_base: Se2,
}

/// SLAM with a scanning laser. Feed it scans in order; ask for the trajectory whenever you like.
///
/// The same scans and configuration give the same bits.
#[derive(Debug)]
pub struct LaserSlam {
    rig: LaserRig,
    /// As given, and as it fits the noise of the ranges.
    given: LaserConfig,
    config: LaserConfig,
    /// Noise of the first scans' ranges, in order of size.
    noise_m: Vec<f64>,
    keyframes: Vec<Keyframe>,
    poses: Vec<Se2>,
    scans: Vec<Placed>,
    graph: PoseGraph,
    links: Links,
    workspace: Workspace,
    local: LocalMap,
    loops: LoopCloser,
    closures: Vec<Closure>,
    last_odom: Option<Se2>,
    /// Motion of the last step and its time (s), for scans without odometry.
    last_step: (Twist, f64),
    travelled_m: f64,
    /// Variances of the guess since the last scan that was matched: position (m²), yaw (rad²).
    drift: (f64, f64),
    edges_since_solve: usize,
}

impl LaserSlam {
    /// Begins with an empty map whose frame is that of the first scan's pose.
    pub fn new(rig: LaserRig, config: LaserConfig) -> Self {
        Self {
            rig,
            given: config,
            config,
            noise_m: Vec::new(),
            keyframes: Vec::new(),
            poses: Vec::new(),
            scans: Vec::new(),
            graph: PoseGraph::default(),
            links: Links::default(),
            workspace: Workspace::default(),
            local: LocalMap::default(),
            loops: LoopCloser::new(config.loops),
            closures: Vec::new(),
            last_odom: None,
            last_step: (Twist { dx_m: 0.0, dy_m: 0.0, dyaw_rad: 0.0 }, 0.0),
            travelled_m: 0.0,
            drift: (0.0, 0.0),
            edges_since_solve: 0,
        }
    }

    /// Takes the next scan.
    pub fn step(&mut self, scan: &Scan) -> StepReport {
        self.watch_noise(scan);
        let points = points_of(&self.rig, &scan.ranges_m, &self.config.points);
        let Some(&last) = self.scans.last() else { return self.begin(scan, points) };
        let motion = self.motion(scan);
        let guess = last.keyframe_from_base.compose(motion);
        let anchor = self.local.anchor();
        debug_assert_eq!(anchor, last.keyframe, "the local map is that of the newest keyframe");
        let still = scan.odom_from_base.is_some()
            && motion.position().norm() < 1e-4
            && motion.yaw_rad.abs() < 1e-4;
        let (placed, std) = self.place(&points, guess);
        let tracking = match &placed {
            None => Tracking::Lost,
            // The wheels stood and the scan agrees: its own noise is no reason to move.
            Some(placed) if still && stands(placed.pose, guess) => Tracking::Standing,
            Some(_) => Tracking::Matched,
        };
        let still = tracking == Tracking::Standing;
        let inlier_ratio = placed.map_or(0.0, |p| p.inlier_ratio);
        let placed = if still { None } else { placed };
        let keyframe_from_base = placed.map_or(guess, |p| p.pose);
        let step = last.keyframe_from_base.inverse().compose(keyframe_from_base).log();
        self.last_step = (step, scan.stamp.since(last.stamp).as_secs_f64());
        if !still {
            self.travelled_m += step.dx_m.hypot(step.dy_m);
        }
        if tracking != Tracking::Lost {
            self.drift = (0.0, 0.0);
        }
        self.scans.push(Placed { stamp: scan.stamp, keyframe: anchor, keyframe_from_base });
        let mut report = StepReport {
            map_from_base: self.poses[anchor].compose(keyframe_from_base),
            tracking,
            inlier_ratio,
            keyframe: None,
            closures: Vec::new(),
            graph_moved: false,
        };
        let sees = !points.is_empty();
        // A blind scan is no news, and would push what was seen out of the local map.
        if !still && sees && self.is_news(keyframe_from_base, tracking, inlier_ratio) {
            self.add_keyframe(scan, points, placed.as_ref(), std, &mut report);
        }
        report
    }

    /// Closes what can still be closed now that all is known, and optimises to the end.
    ///
    /// May be called at any time; the next [`step`](Self::step) goes on from there. Returns the loops
    /// that were added.
    pub fn finish(&mut self) -> Vec<Closure> {
        self.solve();
        let mut added = Vec::new();
        for keyframe in 0..self.keyframes.len() {
            let found = self.find_loops(keyframe, true);
            for (closure, information) in found {
                self.tie(&closure, information);
                added.push(closure);
            }
        }
        self.solve();
        added
    }

    /// One pose (`map_from_base`) for each scan, with its stamp, in the order in which they came.
    pub fn trajectory(&self) -> Vec<StampedPose> {
        let pose = |p: &Placed| self.poses[p.keyframe].compose(p.keyframe_from_base);
        self.scans.iter().map(|p| StampedPose { stamp: p.stamp, pose: pose(p) }).collect()
    }

    /// The keyframes, in order.
    pub fn keyframes(&self) -> &[Keyframe] {
        &self.keyframes
    }

    /// Poses of the keyframes in `Map`.
    pub fn keyframe_poses(&self) -> &[Se2] {
        &self.poses
    }

    /// The loops that were believed.
    pub fn closures(&self) -> &[Closure] {
        &self.closures
    }

    /// How many candidates were not believed, by reason.
    pub fn rejections(&self) -> Vec<(Rejection, usize)> {
        self.loops.rejections()
    }

    /// The graph: a vertex for each keyframe; the first is fixed.
    pub fn graph(&self) -> &PoseGraph {
        &self.graph
    }

    /// Learns the noise of the ranges from the first scans and sets the lengths that depend on it.
    fn watch_noise(&mut self, scan: &Scan) {
        if self.noise_m.len() >= NOISE_SCANS {
            return;
        }
        let Some(std_m) = range_std_m(&self.rig, &scan.ranges_m, &self.given.points) else {
            return;
        };
        let place = self.noise_m.partition_point(|&n| n < std_m);
        self.noise_m.insert(place, std_m);
        self.config = self.given.for_noise(self.noise_m[self.noise_m.len() / 2]);
    }

    fn begin(&mut self, scan: &Scan, points: PointScan) -> StepReport {
        self.last_odom = scan.odom_from_base;
        self.keyframes.push(Keyframe {
            scan_index: 0,
            stamp: scan.stamp,
            points,
            sight: Sight::of(&self.rig, &scan.ranges_m),
            travelled_m: 0.0,
        });
        self.poses.push(Se2::IDENTITY);
        self.graph.add_vertex(Se2::IDENTITY);
        self.links.add_vertex();
        let placed = Placed { stamp: scan.stamp, keyframe: 0, keyframe_from_base: Se2::IDENTITY };
        self.scans.push(placed);
        self.rebuild_local();
        StepReport {
            map_from_base: Se2::IDENTITY,
            tracking: Tracking::First,
            inlier_ratio: 0.0,
            keyframe: Some(0),
            closures: Vec::new(),
            graph_moved: false,
        }
    }

    /// What dead reckoning says of the way since the last scan; adds to the drift.
    fn motion(&mut self, scan: &Scan) -> Se2 {
        let config = &self.config.motion;
        let measured = match (self.last_odom, scan.odom_from_base) {
            (Some(before), Some(now)) => Some(before.inverse().compose(now)),
            _ => None,
        };
        self.last_odom = scan.odom_from_base;
        let (motion, position_std_m, yaw_std_rad) = match measured {
            Some(motion) => {
                let (way_m, turn_rad) = (motion.position().norm(), motion.yaw_rad.abs());
                let position_std_m = config.position_std_m
                    + config.position_std_ratio * way_m
                    + config.position_per_turn_std_m * turn_rad;
                let yaw_std_rad = config.yaw_std_rad
                    + config.yaw_per_metre_std_rad * way_m
                    + config.yaw_std_ratio * turn_rad;
                (motion, position_std_m, yaw_std_rad)
            }
            None => self.guessed_motion(scan.stamp),
        };
        self.drift.0 += position_std_m * position_std_m;
        self.drift.1 += yaw_std_rad * yaw_std_rad;
        motion
    }

    /// Where the scan lies on the local map, if anywhere, and how sure the guess was (m, rad).
    ///
    /// Wheels slip now and then far beyond their usual error, and robots are lifted and turned: a scan
    /// that does not fit where it should is looked for in wider windows, for which it must fit better.
    fn place(&mut self, points: &PointScan, guess: Se2) -> (Option<Refined>, (f64, f64)) {
        let (motion, tracking) = (&self.config.motion, &self.config.tracking);
        let usual = (self.drift.0.sqrt(), self.drift.1.sqrt());
        let placed = self.local.place(points, guess, usual.0, usual.1, &self.config);
        let mut best = (placed.inlier_ratio >= tracking.inlier_min_ratio, placed, usual);
        if placed.inlier_ratio >= tracking.inlier_doubt_ratio {
            return (Some(placed), usual);
        }
        for std_rad in [motion.slip_yaw_std_rad, std::f64::consts::FRAC_PI_3] {
            let std = (usual.0.max(motion.slip_position_std_m), usual.1.max(std_rad));
            let placed = self.local.place(points, guess, std.0, std.1, &self.config);
            if placed.inlier_ratio >= tracking.inlier_anywhere_ratio {
                best = (true, placed, std);
                break;
            }
        }
        let slip = (usual.0.max(motion.slip_position_std_m), usual.1.max(motion.slip_yaw_std_rad));
        if best.0 { (Some(best.1), best.2) } else { (None, slip) }
    }

    /// Without odometry: the last velocity goes on, and may change by so much each second.
    fn guessed_motion(&self, stamp: Stamp) -> (Se2, f64, f64) {
        let config = &self.config.motion;
        let since_s = self.scans.last().map_or(0.0, |last| stamp.since(last.stamp).as_secs_f64());
        let (step, last_s) = self.last_step;
        // Logs without stamps of any use: every step like the last one.
        let ratio = if since_s > 0.0 && last_s > 0.0 { since_s / last_s } else { 1.0 };
        let motion = Se2::exp(Twist {
            dx_m: step.dx_m * ratio,
            dy_m: step.dy_m * ratio,
            dyaw_rad: step.dyaw_rad * ratio,
        });
        let position_std_m = config.unknown_position_std_m + config.unknown_speed_std_mps * since_s;
        let yaw_std_rad = config.unknown_yaw_std_rad + config.unknown_turn_std_radps * since_s;
        (motion, position_std_m, yaw_std_rad)
    }

    fn is_news(&self, keyframe_from_base: Se2, tracking: Tracking, inlier_ratio: f64) -> bool {
        let config = &self.config.tracking;
        tracking == Tracking::Lost
            || inlier_ratio < config.keyframe_inlier_ratio
            || keyframe_from_base.position().norm() > config.keyframe_distance_m
            || keyframe_from_base.yaw_rad.abs() > config.keyframe_turn_rad
    }

    fn add_keyframe(
        &mut self,
        scan: &Scan,
        points: PointScan,
        placed: Option<&Refined>,
        (std_m, std_rad): (f64, f64),
        report: &mut StepReport,
    ) {
        let index = self.keyframes.len();
        let from = index - 1;
        let stamp = scan.stamp;
        let scan_index = self.scans.len() - 1;
        let to_in_from = self.scans[scan_index].keyframe_from_base;
        self.scans[scan_index] =
            Placed { stamp, keyframe: index, keyframe_from_base: Se2::IDENTITY };
        let information = match placed {
            Some(placed) => edge_information(placed, std_m, std_rad, &self.config),
            None => isotropic(std_m, std_rad),
        };
        self.drift = (0.0, 0.0);
        let sight = Sight::of(&self.rig, &scan.ranges_m);
        let travelled_m = self.travelled_m;
        self.keyframes.push(Keyframe { scan_index, stamp, points, sight, travelled_m });
        let pose = self.poses[from].compose(to_in_from);
        self.poses.push(pose);
        self.graph.add_vertex(pose);
        self.links.add_vertex();
        self.add_edge(Edge { from, to: index, to_in_from, information, kernel: Kernel::None });
        report.keyframe = Some(index);

        let found = self.find_loops(index, false);
        let mut surprise = 0.0_f64;
        for (closure, information) in found {
            surprise = surprise.max(closure.shift_m + 3.0 * closure.shift_rad);
            self.tie(&closure, information);
            report.closures.push(closure);
        }
        // Small corrections can wait for company; large ones move the map that is tracked on.
        if surprise > 0.05 || self.edges_since_solve >= 50 {
            self.solve();
            report.graph_moved = true;
            report.map_from_base = self.poses[index];
        }
        self.rebuild_local();
    }

    fn find_loops(&mut self, index: usize, later_too: bool) -> Vec<(Closure, Matrix3<f64>)> {
        let known = Known {
            keyframes: &self.keyframes,
            poses: &self.poses,
            links: &self.links,
            config: &self.config,
        };
        self.loops.search(index, &known, later_too)
    }

    fn tie(&mut self, closure: &Closure, information: Matrix3<f64>) {
        let &Closure { from, to, to_in_from, .. } = closure;
        let kernel = Kernel::Cauchy { width_ratio: 3.0 };
        self.add_edge(Edge { from, to, to_in_from, information, kernel });
        self.closures.push(*closure);
        self.edges_since_solve += 1;
    }

    /// Ties two keyframes; one that is not finite is left out, since it would say nothing.
    fn add_edge(&mut self, edge: Edge) {
        let Edge { from, to, to_in_from, information, .. } = edge;
        let Some(covariance) = information.try_inverse() else { return };
        if self.graph.add_edge(edge).is_ok() {
            self.links.add(from, to, to_in_from, covariance);
        }
    }

    fn solve(&mut self) {
        if self.edges_since_solve == 0 {
            return;
        }
        self.edges_since_solve = 0;
        optimise(&mut self.graph, &SolverConfig::default(), &mut self.workspace);
        self.poses.clear();
        self.poses.extend_from_slice(self.graph.poses());
    }

    fn rebuild_local(&mut self) {
        let newest = self.keyframes.len() - 1;
        let oldest = newest.saturating_sub(self.config.tracking.local_keyframes - 1);
        self.local.rebuild(
            &self.keyframes,
            &self.poses,
            newest,
            oldest..=newest,
            &self.config.tracking,
        );
    }

    /// Every point of every keyframe, in `Map`, metres; for pictures.
    pub fn cloud(&self) -> impl Iterator<Item = Vec2> + '_ {
        self.keyframes
            .iter()
            .zip(&self.poses)
            .flat_map(|(k, pose)| k.points.points.iter().map(|&p| pose.transform_point(p)))
    }
}

/// Whether a match differs from where the wheels say the robot stands by no more than its noise.
fn stands(pose: Se2, guess: Se2) -> bool {
    let (apart_m, turned_rad) = pose_distance(pose, guess);
    apart_m < 0.03 && turned_rad < 0.01
}
