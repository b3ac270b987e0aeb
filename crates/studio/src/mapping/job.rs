//! A survey as the page sees it: how it stands, and its picture on a board.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
    time::Instant,
};

use geometry::{Se2, Vec2};
use recordings::{LaserRig, Recording, Rig, RingRig, Scan, StampedPose};
use surveys::{Clock, Event, Known, Survey, SurveyConfig};

use super::{
    board::{Board, Graph, Sight, TrackKind},
    cells::{self, array},
    parameters::values_of,
    protocol::{Counter, Pose, Registration, StageInfo},
    source::Loaded,
};

/// A survey under way, or at its end.
#[derive(Debug)]
pub(crate) struct Job {
    survey: Survey,
    recording: Arc<Recording>,
    known: Known,
    map_from_odom: Option<Se2>,
    /// Of the newest scan.
    pose: Option<Se2>,
    tracking: &'static str,
    n_registrations: usize,
    /// Scans whose poses are on the board.
    n_painted: usize,
    /// Earlier poses moved since they were painted.
    has_moved: bool,
    graph_changed: bool,
    figures: Vec<(String, f64)>,
    truth_in_map: Vec<Se2>,
}

impl Job {
    /// Begins a survey under these parameters.
    ///
    /// # Errors
    ///
    /// A sentence for the person at the page: which parameter is wrong, or why the recording cannot be mapped.
    pub(crate) fn start(
        loaded: &Loaded,
        values: &BTreeMap<String, String>,
    ) -> Result<Self, String> {
        let set: Vec<String> = values.iter().map(|(key, value)| format!("{key}={value}")).collect();
        let config = SurveyConfig::default()
            .with(&set)
            .map_err(|error| error.to_string().replace("--set ", ""))?;
        let begun = Instant::now();
        let clock = Clock::new(move || begun.elapsed());
        let recording = loaded.recording.clone();
        let survey = Survey::with_prior(recording.clone(), config, clock, loaded.prior.clone())
            .map_err(|error| error.to_string())?;
        let first = recording.scans.iter().find_map(|scan| scan.odom_from_base);
        Ok(Self {
            survey,
            map_from_odom: first.map(Se2::inverse),
            recording,
            known: loaded.known.clone(),
            pose: None,
            tracking: "",
            n_registrations: 0,
            n_painted: 0,
            has_moved: false,
            graph_changed: false,
            figures: Vec::new(),
            truth_in_map: Vec::new(),
        })
    }

    /// The parameters that are not at their defaults, by key.
    pub(crate) fn values(&self) -> BTreeMap<String, String> {
        values_of(self.survey.config())
    }

    /// All its parameters.
    pub(crate) fn config(&self) -> &SurveyConfig {
        self.survey.config()
    }

    /// Scans done.
    pub(crate) fn n_done(&self) -> usize {
        self.survey.progress().n_done
    }

    /// All scans.
    pub(crate) fn n_scans(&self) -> usize {
        self.survey.progress().n_scans
    }

    /// Time of the newest scan since the first, s.
    pub(crate) fn t_s(&self) -> f64 {
        self.time_of(self.n_done().saturating_sub(1)).unwrap_or(0.0)
    }

    /// Time of the next scan since the first, s; `None` when all are in.
    pub(crate) fn next_t_s(&self) -> Option<f64> {
        self.time_of(self.n_done())
    }

    /// Takes the next scan.
    ///
    /// # Errors
    ///
    /// Why it cannot go on.
    pub(crate) fn step(&mut self) -> Result<(), String> {
        let events = self.survey.step().map_err(|error| error.to_string())?;
        self.take(&events);
        Ok(())
    }

    /// Does what can only be done when all scans are in, and judges the result.
    ///
    /// # Errors
    ///
    /// Why it cannot be done.
    pub(crate) fn finish(&mut self) -> Result<(), String> {
        let events = self.survey.complete().map_err(|error| error.to_string())?;
        self.take(&events);
        (self.has_moved, self.graph_changed) = (true, true);
        let outcome = self.survey.outcome_so_far().map_err(|error| error.to_string())?;
        let judgement = outcome.judge(&self.recording, &self.known);
        let figures = outcome
            .figures(&judgement, self.survey.config().map())
            .map_err(|error| error.to_string())?;
        self.figures = figures.into_iter().map(|figure| (figure.name, figure.value)).collect();
        self.figures
            .push(("computing_time_s".to_owned(), self.survey.stages().total().as_secs_f64()));
        self.pose = outcome.trajectory.last().map(|last| last.pose);
        self.truth_in_map = judgement.truth_in_map;
        Ok(())
    }

    /// Where the robot is.
    pub(crate) fn pose(&self) -> Option<Pose> {
        self.pose.map(array)
    }

    /// Where odometry puts it.
    pub(crate) fn odometry(&self) -> Option<Pose> {
        self.dead_reckoning(self.n_done().checked_sub(1)?)
    }

    /// How the newest scan was placed, in a word or two.
    pub(crate) fn tracking(&self) -> &'static str {
        self.tracking
    }

    pub(crate) fn counters(&self) -> Vec<Counter> {
        let counters = self.survey.counters().into_iter();
        counters.map(|c| Counter { name: c.name, label: c.label, value: c.n }).collect()
    }

    pub(crate) fn stages(&self) -> Vec<StageInfo> {
        let stage = |(name, spent): (&&'static str, &surveys::Spent)| StageInfo {
            name,
            n_times: spent.n_times,
            total_s: spent.total.as_secs_f64(),
            longest_s: spent.longest.as_secs_f64(),
        };
        self.survey.stages().all().iter().map(stage).collect()
    }

    /// Named numbers about the whole; empty before the end.
    pub(crate) fn figures(&self) -> &[(String, f64)] {
        &self.figures
    }

    /// Puts on an empty board what is known before the first scan.
    pub(crate) fn begin(&self, board: &mut Board) {
        let known = &self.known.truth;
        let truth = if known.is_empty() { &self.recording.truth } else { known };
        let map_from_world = truth.first().map(|first| first.pose.inverse());
        let in_map = |p: &StampedPose| Some(array(map_from_world?.compose(p.pose)));
        board.set_track(TrackKind::Truth, truth.iter().filter_map(in_map));
    }

    /// Brings a board up to date, but for the maps.
    pub(crate) fn paint(&mut self, board: &mut Board) {
        let n_done = self.n_done();
        if self.has_moved {
            let poses = self.survey.trajectory();
            board.set_track(TrackKind::Corrected, poses.iter().map(|p| array(p.pose)));
        }
        let new = (self.n_painted..n_done).filter_map(|index| self.dead_reckoning(index));
        board.extend_track(TrackKind::Odometry, new);
        if !self.has_moved && board.track_length(TrackKind::Corrected) < n_done {
            let poses = self.survey.trajectory();
            let known = board.track_length(TrackKind::Corrected);
            board.extend_track(
                TrackKind::Corrected,
                poses.iter().skip(known).map(|p| array(p.pose)),
            );
        }
        if !self.truth_in_map.is_empty() {
            let truth = std::mem::take(&mut self.truth_in_map);
            board.set_track(TrackKind::Truth, truth.into_iter().map(array));
        }
        self.n_painted = n_done;
        self.has_moved = false;
        if std::mem::take(&mut self.graph_changed) {
            board.set_graph(self.graph());
        }
        board.set_sight(self.sight());
        if self.n_registrations > 0
            && let Some(registration) = self.registration()
        {
            board.set_registration(registration);
        }
    }

    /// Brings the map and the short-term map of a board up to date: looks at every cell.
    ///
    /// # Errors
    ///
    /// Why the map cannot be drawn.
    pub(crate) fn paint_map(&mut self, board: &mut Board) -> Result<(), String> {
        let short_term = self.survey.short_term();
        board.set_patch(short_term.as_ref().and_then(cells::patch));
        cells::paint(self.survey.map().map_err(|error| error.to_string())?, board);
        Ok(())
    }

    fn take(&mut self, events: &[Event]) {
        for event in events {
            match event {
                Event::Placed { map_from_base, how, .. } => {
                    self.pose = Some(*map_from_base);
                    self.tracking = how;
                }
                Event::Vertex { .. } | Event::Closed(_) => self.graph_changed = true,
                Event::Registered(_) => self.n_registrations += 1,
                Event::Moved => (self.has_moved, self.graph_changed) = (true, true),
                _ => {}
            }
        }
    }

    fn time_of(&self, index: usize) -> Option<f64> {
        let first = self.recording.scans.first()?.stamp;
        Some(self.recording.scans.get(index)?.stamp.since(first).as_secs_f64())
    }

    fn dead_reckoning(&self, index: usize) -> Option<Pose> {
        let odom_from_base = self.recording.scans.get(index)?.odom_from_base?;
        Some(array(self.map_from_odom?.compose(odom_from_base)))
    }

    fn graph(&self) -> Graph {
        let Some((graph, scans)) = self.survey.graph() else { return Graph::default() };
        let closed: BTreeSet<(usize, usize)> =
            self.survey.closed().iter().map(|loop_| (loop_.from_scan, loop_.to_scan)).collect();
        let closes = |from: usize, to: usize| {
            let pair = (scans.get(from).copied(), scans.get(to).copied());
            matches!(pair, (Some(a), Some(b)) if closed.contains(&(a, b)) || closed.contains(&(b, a)))
        };
        Graph {
            vertices_m: graph.poses().iter().map(|pose| [pose.x_m, pose.y_m]).collect(),
            edges: graph.edges().iter().map(|e| (e.from, e.to, closes(e.from, e.to))).collect(),
        }
    }

    /// What the newest scan saw, in the map.
    fn sight(&self) -> Option<Sight> {
        let scan = self.recording.scans.get(self.n_done().checked_sub(1)?)?;
        let map_from_base = self.pose?;
        Some(match &self.recording.rig {
            Rig::Laser(rig) => Sight::Points(points(rig, scan, map_from_base)),
            Rig::Ring(rig) => Sight::Cones {
                half_angle_rad: rig.half_angle_rad,
                cones: cones(rig, scan, map_from_base),
            },
        })
    }

    fn registration(&self) -> Option<Registration> {
        let last = self.survey.registration()?;
        let candidate =
            |c: &surveys::Candidate| (c.offset.x_m, c.offset.y_m, c.offset.yaw_rad, c.score_ratio);
        Some(Registration {
            number: self.n_registrations,
            scan: last.last_scan,
            applied: last.applied,
            verdict: last.verdict.clone(),
            score: last.score.to_owned(),
            best: last.best,
            candidates: last.candidates.iter().map(candidate).collect(),
            ..Registration::default()
        })
    }
}

fn points(rig: &LaserRig, scan: &Scan, map_from_base: Se2) -> Vec<[f64; 2]> {
    let map_from_sensor = map_from_base.compose(rig.base_from_sensor);
    let echoes =
        scan.ranges_m.iter().enumerate().filter(|(_, range_m)| **range_m < rig.range_max_m);
    let point = |(beam, &range_m): (usize, &f64)| {
        let direction = Se2::new(0.0, 0.0, rig.bearing_rad(beam));
        let at = map_from_sensor.compose(direction).transform_point(Vec2::new(range_m, 0.0));
        [at.x, at.y]
    };
    echoes.map(point).collect()
}

fn cones(rig: &RingRig, scan: &Scan, map_from_base: Se2) -> Vec<(Pose, f64, bool)> {
    let sonars = rig.base_from_sensors.iter().zip(&scan.ranges_m);
    let cone = |(base_from_sensor, &range_m): (&Se2, &f64)| {
        let is_echo = range_m < rig.range_max_m;
        (array(map_from_base.compose(*base_from_sensor)), range_m.min(rig.range_max_m), is_echo)
    };
    sonars.map(cone).collect()
}
