//! What a survey leaves behind, and how far it is from what is known.

use std::collections::BTreeMap;

use geometry::{Se2, wrap_to_pi};
use least_squares::PoseGraph;
use recordings::{Recording, StampedPose};
use slam::evaluate::{
    Errors, Relation, RelationErrors, absolute_errors, align, pose_at, relation_errors,
};

use crate::{
    clock::Spent,
    config::{MapSettings, Method, Mode},
    drawing::SurveyMap,
    known::on_the_best_clock,
    mapper::{Closed, Counter, Registration, SurveyError},
};

/// Known poses farther apart in time than this say nothing about what is between them, seconds.
const GAP_MAX_S: f64 = 2.0;
/// Relations over less time than this are between consecutive places, seconds.
const CONSECUTIVE_S: f64 = 30.0;

/// The results of a survey.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Who made the map; never [`Method::Auto`].
    pub method: Method,
    /// Which form of the sonar method.
    pub mode: Mode,
    /// Scans of the recording; there are fewer poses when the survey is not at its end.
    pub n_scans: usize,
    /// One pose in `Map` for each scan.
    pub trajectory: Vec<StampedPose>,
    /// Dead reckoning of the same scans, moved so that it begins where the map does; `None` where there is none.
    pub odometry: Vec<Option<Se2>>,
    /// The map.
    pub map: SurveyMap,
    /// The pose graph with the scan of each vertex, if the method has one.
    pub graph: Option<(PoseGraph, Vec<usize>)>,
    /// The loops that were closed.
    pub closed: Vec<Closed>,
    /// How short-term maps were compared.
    pub registrations: Vec<Registration>,
    /// Scans that did not fit and were placed by dead reckoning.
    pub n_lost: usize,
    /// Numbers of things.
    pub counters: Vec<Counter>,
    /// Time spent by stage.
    pub stages: BTreeMap<&'static str, Spent>,
    /// What each scan took, milliseconds.
    pub scan_ms: Vec<f64>,
}

/// What a trajectory is judged by.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// True poses in order of time, in any frame; empty for none.
    pub truth: Vec<StampedPose>,
    /// Measured relative poses.
    pub relations: Vec<Relation>,
    /// Whether the relations have a clock of their own, known to within a second: then the one that fits best counts.
    pub clock_is_free: bool,
}

/// How far results are from what is known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judgement {
    /// Against true poses: of the survey, and of dead reckoning alone.
    pub truth: Option<[Errors; 2]>,
    /// Against poses that came with the file: of the survey, and of dead reckoning alone.
    pub reference: Option<[Errors; 2]>,
    /// Against relations: of the survey, and of dead reckoning alone.
    pub relations: Option<[RelationErrors; 2]>,
    /// What was added to the relations' time so that they fit best, seconds.
    pub clock_shift_s: f64,
    /// True poses as they lie in the map after alignment, for drawing.
    pub truth_in_map: Vec<Se2>,
}

/// A named number.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name; the unit ends it.
    pub name: String,
    /// The value.
    pub value: f64,
}

impl Outcome {
    /// Whether all scans are in it.
    pub fn is_whole(&self) -> bool {
        self.trajectory.len() == self.n_scans
    }

    /// Dead reckoning as a trajectory, of the scans that have it.
    pub fn odometry_trajectory(&self) -> Vec<StampedPose> {
        let pairs = self.trajectory.iter().zip(&self.odometry);
        pairs.filter_map(|(p, odom)| Some(StampedPose { stamp: p.stamp, pose: (*odom)? })).collect()
    }

    /// How far each pose is from dead reckoning: seconds since the first scan, metres, radians. The turn is not
    /// wrapped: it goes on from scan to scan.
    pub fn corrections(&self) -> Vec<(f64, f64, f64)> {
        let pairs = self.trajectory.iter().zip(&self.odometry);
        let mut unwrapped_rad = 0.0;
        let correction = |(p, odom): (&StampedPose, &Option<Se2>)| {
            let odom = (*odom)?;
            let away_m = (p.pose.position() - odom.position()).norm();
            unwrapped_rad += wrap_to_pi(p.pose.yaw_rad - odom.yaw_rad - unwrapped_rad);
            Some((p.stamp.as_secs_f64(), away_m, unwrapped_rad))
        };
        pairs.filter_map(correction).collect()
    }

    /// Way along the trajectory, metres.
    pub fn path_m(&self) -> f64 {
        let step =
            |pair: &[StampedPose]| (pair[1].pose.position() - pair[0].pose.position()).norm();
        self.trajectory.windows(2).map(step).sum()
    }

    /// Compares with what is known; also with poses that the recording brought along.
    pub fn judge(&self, recording: &Recording, known: &Known) -> Judgement {
        // What came with the recording is there for each scan; its stamps may say nothing.
        let by_index = |poses: &[StampedPose]| poses.iter().map(|p| Some(p.pose)).collect();
        let by_stamp = |poses: &[StampedPose]| {
            let stamps = self.trajectory.iter().map(|p| p.stamp);
            stamps.map(|stamp| pose_at(poses, stamp, GAP_MAX_S)).collect()
        };
        let truth: Vec<Option<Se2>> = match known.truth.as_slice() {
            [] => by_index(&recording.truth),
            poses => by_stamp(poses),
        };
        let reference: Vec<Option<Se2>> = by_index(&recording.reference);
        let survey: Vec<Option<Se2>> = self.trajectory.iter().map(|p| Some(p.pose)).collect();
        let both = |against: &[Option<Se2>]| {
            let errors = [&survey, &self.odometry].map(|estimate| {
                let (estimate, truth) = paired(estimate, against);
                absolute_errors(&estimate, &truth)
            });
            (errors[0].n > 0).then_some(errors)
        };
        let odometry = self.odometry_trajectory();
        let (relations, clock_shift_s) = if known.clock_is_free {
            on_the_best_clock(&known.relations, &self.trajectory)
        } else {
            (known.relations.clone(), 0.0)
        };
        let related = |trajectory: &[StampedPose]| {
            relation_errors(trajectory, &relations, CONSECUTIVE_S, GAP_MAX_S)
        };
        let (estimate, in_world) = paired(&survey, &truth);
        let map_from_world = align(&estimate, &in_world).inverse();
        Judgement {
            truth: both(&truth),
            reference: both(&reference),
            relations: (!relations.is_empty())
                .then(|| [related(&self.trajectory), related(&odometry)]),
            clock_shift_s,
            truth_in_map: in_world.iter().map(|pose| map_from_world.compose(*pose)).collect(),
        }
    }

    /// Everything that is one number, for tables, files and sweeps.
    ///
    /// # Errors
    ///
    /// [`SurveyError::Map`] when the map does not fit into memory.
    pub fn figures(
        &self,
        judgement: &Judgement,
        map: &MapSettings,
    ) -> Result<Vec<Figure>, SurveyError> {
        let mut list = Vec::new();
        let mut add = |name: &str, value: f64| list.push(Figure { name: name.to_owned(), value });
        let entropy = self.map.entropy();
        let [n_occupied, n_free] = self.map.counts(&map.thresholds())?;
        let side_m = self.map.lattice().resolution_m;
        add("scans", self.trajectory.len() as f64);
        add("path_m", self.path_m());
        if let (Some(first), Some(last)) = (self.trajectory.first(), self.trajectory.last()) {
            add("duration_s", last.stamp.since(first.stamp).as_secs_f64());
        }
        if let Some((_, away_m, turned_rad)) = self.corrections().last() {
            add("last_correction_m", *away_m);
            add("last_correction_deg", wrap_to_pi(*turned_rad).to_degrees());
        }
        add("lost_scans", self.n_lost as f64);
        for counter in &self.counters {
            add(counter.name, counter.n as f64);
        }
        if let Some((graph, _)) = &self.graph {
            add("graph.chi2", graph.chi2());
        }
        add("map.occupied_cells", n_occupied as f64);
        add("map.free_cells", n_free as f64);
        add("map.known_m2", entropy.n_known as f64 * side_m * side_m);
        add("map.entropy_mean_bits", entropy.mean_bits());
        add("map.entropy_sum_bits", entropy.sum_bits);
        for (name, errors) in [("truth", &judgement.truth), ("reference", &judgement.reference)] {
            if let Some([survey, odometry]) = errors {
                list.extend(error_figures(name, survey));
                if odometry.n > 0 {
                    list.extend(error_figures(&format!("{name}.odometry"), odometry));
                }
            }
        }
        if let Some([survey, odometry]) = &judgement.relations {
            for (name, errors) in [
                ("relations", &survey.all),
                ("relations.consecutive", &survey.consecutive),
                ("relations.revisiting", &survey.revisiting),
                ("relations.odometry", &odometry.all),
            ] {
                list.extend(error_figures(name, errors));
            }
        }
        Ok(list)
    }
}

fn error_figures(name: &str, errors: &Errors) -> Vec<Figure> {
    let figure = |end: &str, value: f64| Figure { name: format!("{name}.{end}"), value };
    if errors.n == 0 {
        // No pair is no error, but no merit either: a sweep must not take it for the best.
        return vec![figure("pairs", 0.0)];
    }
    vec![
        figure("pairs", errors.n as f64),
        figure("mean_m", errors.mean_m),
        figure("std_m", errors.std_m),
        figure("rms_m", errors.rms_m),
        figure("max_m", errors.max_m),
        figure("mean_deg", errors.mean_rad.to_degrees()),
        figure("std_deg", errors.std_rad.to_degrees()),
        figure("max_deg", errors.max_rad.to_degrees()),
    ]
}

/// The scans of which both poses are known.
fn paired(estimate: &[Option<Se2>], known: &[Option<Se2>]) -> (Vec<Se2>, Vec<Se2>) {
    estimate.iter().zip(known).filter_map(|(estimate, known)| (*estimate).zip(*known)).unzip()
}

/// Dead reckoning of the first `n` scans in `Map`; without `map_from_odom`, moved so that the first of them is where
/// the map begins.
pub(crate) fn dead_reckoning(
    recording: &Recording,
    n: usize,
    map_from_odom: Option<Se2>,
) -> Vec<Option<Se2>> {
    let first = recording.scans.iter().find_map(|scan| scan.odom_from_base);
    let map_from_odom = map_from_odom.unwrap_or(first.unwrap_or(Se2::IDENTITY).inverse());
    let moved = |odom: Option<Se2>| odom.map(|odom| map_from_odom.compose(odom));
    recording.scans.iter().take(n).map(|scan| moved(scan.odom_from_base)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Clock, Survey, SurveyConfig, testing::room};
    use std::sync::Arc;

    fn dead(recording: &Arc<Recording>) -> Outcome {
        let config = SurveyConfig::default().with(&["survey.method=odometry".to_owned()]).unwrap();
        Survey::new(Arc::clone(recording), config, Clock::stopped()).unwrap().finish().unwrap()
    }

    #[test]
    fn poses_of_the_recording_are_paired_scan_by_scan_even_without_useful_stamps() {
        let mut recording = room(60);
        recording.reference = recording.truth.clone();
        let timed = dead(&Arc::new(recording.clone()));
        let timed = timed.judge(&recording, &Known::default()).reference.unwrap();
        for scan in 0..60 {
            recording.scans[scan].stamp = run_context::Stamp::ZERO;
            recording.reference[scan].stamp = run_context::Stamp::ZERO;
        }
        let untimed = dead(&Arc::new(recording.clone()));
        let untimed = untimed.judge(&recording, &Known::default()).reference.unwrap();
        assert_eq!(untimed, timed);
        assert!(timed[0].mean_m > 0.1 && timed[0] == timed[1]);
    }

    #[test]
    fn true_poses_of_a_file_are_found_by_their_stamps() {
        let recording = Arc::new(room(60));
        let outcome = dead(&recording);
        // Every second pose, as another clock rate would have it: between them lies the arc.
        let truth: Vec<StampedPose> = recording.truth.iter().step_by(2).copied().collect();
        let known = Known { truth, ..Known::default() };
        let own = outcome.judge(&recording, &Known::default()).truth.unwrap();
        let found = outcome.judge(&recording, &known).truth.unwrap();
        assert_eq!((own[0].n, found[0].n), (60, 59), "the last one has no neighbour");
        assert!((own[0].rms_m - found[0].rms_m).abs() < 0.02, "{own:?} {found:?}");
    }

    /// The room's odometry turns by 2° too much for each metre; nobody corrects, so the correction is nothing.
    #[test]
    fn corrections_go_on_beyond_half_a_turn() {
        let mut recording = room(60);
        for (i, scan) in recording.scans.iter_mut().enumerate() {
            let odom = scan.odom_from_base.unwrap();
            scan.odom_from_base = Some(Se2::new(odom.x_m, odom.y_m, odom.yaw_rad - 0.1 * i as f64));
        }
        let outcome = Outcome {
            odometry: dead_reckoning(&recording, 60, Some(Se2::IDENTITY)),
            ..dead(&Arc::new(room(60)))
        };
        let last = *outcome.corrections().last().unwrap();
        assert!((last.2 - 5.9).abs() < 1e-9, "{last:?}");
    }
}
