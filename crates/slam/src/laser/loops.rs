//! Places visited before: who comes into question, whether the match is to be believed.
//!
//! Candidates are keyframes whose distance is within the radius or the estimate's uncertainty. Each is
//! matched against the map about it, over a window as wide as the uncertainty; a match is believed when
//! enough points are explained, when the match back ends at the same place, and, where the guess was
//! unsure, when a second match of the next keyframes agrees with it through the graph.
//!
//! Source: E. Olson (2009), "Recognizing places using spectrally clustered local matches", Robotics
//! and Autonomous Systems 57, for pairwise consistency; differences: pairs instead of clusters.

use std::collections::BTreeMap;

use geometry::Se2;
use nalgebra::Matrix3;

use crate::uncertainty::{Links, adjoint};

use super::{
    closure::{Closure, Rejection, edge_information},
    config::{LaserConfig, LoopConfig},
    correlative::{SearchWindow, pose_distance},
    keyframe::Keyframe,
    local_map::{LocalMap, isotropic, thinned},
    points::PointScan,
    surfels::{PosePrior, Refined},
};

/// A radian of difference in yaw makes a candidate as much worse as so many metres.
const TURN_COSTS_M: f64 = 0.5;
/// What a loop's edge says of directions about which its match says nothing: almost nothing, metres.
const UNKNOWN_STD_M: f64 = 3.0;
/// The same for the yaw, radians.
const UNKNOWN_STD_RAD: f64 = 1.0;
/// Points that a candidate's window is searched with.
const SCAN_POINTS_MAX: usize = 180;

/// Finds loops; remembers those that wait for a second one.
#[derive(Debug)]
pub(crate) struct LoopCloser {
    config: LoopConfig,
    there: LocalMap,
    here: LocalMap,
    waiting: Vec<(Closure, Matrix3<f64>)>,
    rejected: BTreeMap<Rejection, usize>,
    /// Pairs that were tried, so that the last pass does not repeat them.
    tried: std::collections::BTreeSet<(usize, usize)>,
}

/// What is known when loops are looked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known<'a> {
    pub(crate) keyframes: &'a [Keyframe],
    pub(crate) poses: &'a [Se2],
    pub(crate) links: &'a Links,
    pub(crate) config: &'a LaserConfig,
}

/// A keyframe that may have seen the same.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    keyframe: usize,
    badness: f64,
    std_m: f64,
    std_rad: f64,
}

impl LoopCloser {
    pub(crate) fn new(config: LoopConfig) -> Self {
        Self {
            config,
            there: LocalMap::default(),
            here: LocalMap::default(),
            waiting: Vec::new(),
            rejected: BTreeMap::new(),
            tried: std::collections::BTreeSet::new(),
        }
    }

    pub(crate) fn rejections(&self) -> Vec<(Rejection, usize)> {
        self.rejected.iter().map(|(&reason, &n)| (reason, n)).collect()
    }

    /// Loops from keyframe `index` to earlier ones, with the information of their edges.
    ///
    /// `later_too` says whether what was seen after it may speak for it as well.
    pub(crate) fn search(
        &mut self,
        index: usize,
        known: &Known<'_>,
        later_too: bool,
    ) -> Vec<(Closure, Matrix3<f64>)> {
        let &Known { keyframes, poses, config, .. } = known;
        let agree = self.config.agree_keyframes;
        let before = self.waiting.len();
        self.waiting.retain(|(closure, _)| closure.to + agree >= index);
        let alone = before - self.waiting.len();
        if alone > 0 {
            *self.rejected.entry(Rejection::Alone).or_default() += alone;
        }
        let candidates = self.candidates(index, known);
        if candidates.is_empty() {
            return Vec::new();
        }
        let n = keyframes.len();
        let here = if later_too { self.around(index, n) } else { self.before(index) };
        self.here.rebuild(keyframes, poses, index, here.clone(), &config.tracking);
        let mut found = Vec::new();
        for candidate in candidates {
            self.tried.insert((candidate.keyframe, index));
            match self.verify(candidate, index, known) {
                Ok((closure, information)) if candidate.std_m <= self.config.sure_std_m => {
                    found.push((closure, information));
                }
                Ok(unsure) => self.wait(unsure, poses, &mut found),
                Err(reason) => *self.rejected.entry(reason).or_default() += 1,
            }
        }
        found
    }

    /// The best few of the keyframes that may be here, each of another stretch of the way.
    fn candidates(&self, index: usize, known: &Known<'_>) -> Vec<Candidate> {
        let &Known { keyframes, poses, links, .. } = known;
        let config = &self.config;
        let travelled_m = keyframes[index].travelled_m;
        let old = |j: &usize| travelled_m - keyframes[*j].travelled_m >= config.way_min_m;
        let in_reach = config.radius_m + 3.0 * config.window_max_m;
        let near = |j: &usize| pose_distance(poses[*j], poses[index]).0 < in_reach;
        let mut all: Vec<usize> = (0..index).filter(|j| old(j) && near(j)).collect();
        all.retain(|&j| !self.tried.contains(&(j, index)));
        if all.is_empty() {
            return Vec::new();
        }
        let covariances = links.seen_from(index, poses);
        let mut candidates: Vec<Candidate> = Vec::new();
        for j in all {
            let Some(seen) = covariances[j] else { continue };
            let a = adjoint(poses[index].inverse().compose(poses[j]));
            let here = a * seen * a.transpose();
            let std_m = (here[(0, 0)] + here[(1, 1)]).sqrt();
            let std_rad = here[(2, 2)].sqrt();
            let (apart_m, turned_rad) = pose_distance(poses[j], poses[index]);
            if apart_m - (2.0 * std_m).min(config.window_max_m) > config.radius_m {
                continue;
            }
            let badness = apart_m + TURN_COSTS_M * turned_rad;
            candidates.push(Candidate { keyframe: j, badness, std_m, std_rad });
        }
        candidates
            .sort_by(|a, b| a.badness.total_cmp(&b.badness).then(a.keyframe.cmp(&b.keyframe)));
        let mut chosen: Vec<Candidate> = Vec::new();
        for candidate in candidates {
            let apart =
                |c: &Candidate| c.keyframe.abs_diff(candidate.keyframe) > 2 * config.side_keyframes;
            if chosen.len() < config.candidates_max && chosen.iter().all(apart) {
                chosen.push(candidate);
            }
        }
        chosen
    }

    fn verify(
        &mut self,
        candidate: Candidate,
        index: usize,
        known: &Known<'_>,
    ) -> Result<(Closure, Matrix3<f64>), Rejection> {
        let &Known { keyframes, poses, config, .. } = known;
        let from = candidate.keyframe;
        let there = self.around(from, index);
        self.there.rebuild(keyframes, poses, from, there, &config.tracking);
        let guess = poses[from].inverse().compose(poses[index]);
        let scan = &keyframes[index].points;
        let (pose, std_m) = self.found_in_window(candidate, scan, guess, config)?;
        // Where the points say nothing, as along a corridor, the graph's own guess stays.
        let prior = PosePrior { pose: guess, information: isotropic(std_m, candidate.std_rad) };
        let placed = self.there.refine(scan, pose, Some(&prior), &config.refine);
        if placed.inlier_ratio < self.config.inlier_min_ratio {
            return Err(Rejection::Inliers);
        }
        let back = self.match_back(&keyframes[from], placed.pose, config);
        let (apart_m, apart_rad) = pose_distance(back.pose.inverse(), placed.pose);
        if back.inlier_ratio < 0.5 * self.config.inlier_min_ratio
            || apart_m > self.config.both_ways_m
            || apart_rad > self.config.both_ways_rad
        {
            return Err(Rejection::BothWays);
        }
        let there = (self.there.cloud(), placed.pose.inverse());
        let here = (self.here.cloud(), placed.pose);
        let through = keyframes[index].sight.through(there.0, there.1, config);
        let through_back = keyframes[from].sight.through(here.0, here.1, config);
        if through.max(through_back) > self.config.through_max_ratio {
            return Err(Rejection::Through);
        }
        let (shift_m, shift_rad) = pose_distance(guess, placed.pose);
        let information = edge_information(&placed, UNKNOWN_STD_M, UNKNOWN_STD_RAD, config);
        let closure = Closure {
            from,
            to: index,
            to_in_from: placed.pose,
            inlier_ratio: placed.inlier_ratio,
            shift_m,
            shift_rad,
        };
        Ok((closure, information))
    }

    /// The best pose of the window about the guess.
    fn found_in_window(
        &mut self,
        candidate: Candidate,
        scan: &PointScan,
        guess: Se2,
        config: &LaserConfig,
    ) -> Result<(Se2, f64), Rejection> {
        let std_m = candidate.std_m.max(0.05).min(self.config.window_max_m / 3.0);
        let std_rad = candidate.std_rad.max(0.02).min(self.config.window_max_rad / 3.0);
        let window = SearchWindow { half_m: 3.0 * std_m, half_rad: 3.0 * std_rad, std_m, std_rad };
        let points = thinned(&scan.points, SCAN_POINTS_MAX);
        let grid = self.there.grid(&config.tracking);
        let found = grid.correlate(&points, guess, &window, self.config.score_min_ratio);
        found.map(|found| (found.pose, std_m)).ok_or(Rejection::Score)
    }

    fn match_back(&self, from: &Keyframe, to_in_from: Se2, config: &LaserConfig) -> Refined {
        self.here.refine(&from.points, to_in_from.inverse(), None, &config.refine)
    }

    /// Believes `unsure` and one that waits, if they agree; otherwise it waits itself.
    fn wait(
        &mut self,
        unsure: (Closure, Matrix3<f64>),
        poses: &[Se2],
        found: &mut Vec<(Closure, Matrix3<f64>)>,
    ) {
        let agrees = |other: &Closure| {
            let closure = &unsure.0;
            let apart = closure.to.abs_diff(other.to);
            if apart == 0 || apart > self.config.agree_keyframes {
                return false;
            }
            // Round the square of the two loops and the two ways between them.
            let way_from = poses[other.from].inverse().compose(poses[closure.from]);
            let way_to = poses[other.to].inverse().compose(poses[closure.to]);
            let one = way_from.compose(closure.to_in_from);
            let two = other.to_in_from.compose(way_to);
            let (apart_m, apart_rad) = pose_distance(one, two);
            apart_m < 2.0 * self.config.both_ways_m && apart_rad < 2.0 * self.config.both_ways_rad
        };
        if let Some(i) = self.waiting.iter().position(|(other, _)| agrees(other)) {
            found.push(self.waiting.remove(i));
            found.push(unsure);
        } else {
            self.waiting.push(unsure);
        }
    }

    fn before(&self, index: usize) -> std::ops::RangeInclusive<usize> {
        index.saturating_sub(2 * self.config.side_keyframes)..=index
    }

    fn around(&self, index: usize, end: usize) -> std::ops::RangeInclusive<usize> {
        let side = self.config.side_keyframes;
        index.saturating_sub(side)..=(index + side).min(end - 1)
    }
}
