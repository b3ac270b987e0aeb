//! Sonar submaps in a pose graph, scan by scan, behind a survey's face.

use geometry::Se2;
use least_squares::PoseGraph;
use recordings::{Recording, RingRig, StampedPose};
use run_context::Stamp;
use slam::sonar_graph::{SonarGraph, SonarGraphConfig, SubmapReport};

use super::continuous::{score_in_words, told};
use crate::{
    clock::Stages,
    config::SurveyConfig,
    drawing::SurveyMap,
    mapper::{Closed, Counter, Event, Mapper, ShortTerm, SurveyError},
};

#[derive(Debug)]
pub(crate) struct GraphMapper {
    slam: SonarGraph,
    score: &'static str,
    /// Stamp and odometry of each scan so far.
    scans: Vec<(Stamp, Option<Se2>)>,
    /// The first scan that is in no submap yet.
    open_from: usize,
    n_odometry: usize,
    map: Option<SurveyMap>,
}

impl GraphMapper {
    pub(crate) fn new(ring: &RingRig, config: &SurveyConfig) -> Result<Self, SurveyError> {
        let localiser = config.values().sonar.localiser();
        let score = score_in_words(localiser.score);
        let config = SonarGraphConfig { localiser, ..SonarGraphConfig::default() };
        let slam = SonarGraph::new(ring, config)
            .map_err(|error| SurveyError::Unsuitable(format!("sonar: {error}")))?;
        Ok(Self { slam, score, scans: Vec::new(), open_from: 0, n_odometry: 0, map: None })
    }

    fn scan_at(&self, stamp: Stamp) -> usize {
        let after = self.scans.partition_point(|&(scan, _)| scan <= stamp);
        after.saturating_sub(1)
    }

    fn take(&mut self, report: Option<SubmapReport>, events: &mut Vec<Event>) {
        let Some(SubmapReport { registration, closed }) = report else { return };
        let last = self.scan_at(registration.stamp);
        let first = self.open_from.min(last);
        self.open_from = last + 1;
        self.map = None;
        events.push(Event::Registered(told(&registration, self.score, (first, last))));
        events.push(Event::Vertex { scan: last });
        if registration.outcome.is_applied() || closed.is_some() {
            events.push(Event::Moved);
        }
        let stamps = self.slam.submap_stamps();
        events.extend(closed.map(|closed| {
            Event::Closed(Closed {
                from_scan: self.scan_at(stamps[closed.from]),
                to_scan: self.scan_at(stamps[closed.to]),
                shift_m: closed.shift_m,
                shift_rad: closed.shift_rad,
            })
        }));
    }
}

impl Mapper for GraphMapper {
    fn step(
        &mut self,
        recording: &Recording,
        index: usize,
        stages: &mut Stages,
        events: &mut Vec<Event>,
    ) -> Result<(), SurveyError> {
        let scan = &recording.scans[index];
        let between = recording.odometry.iter().skip(self.n_odometry);
        for line in between.take_while(|line| line.stamp < scan.stamp) {
            self.n_odometry += 1;
            self.slam.add_odometry(line.stamp, line.pose);
        }
        self.scans.push((scan.stamp, scan.odom_from_base));
        let begun = stages.now();
        let report = self.slam.step(scan)?;
        let stage = match &report {
            None => "collect readings",
            Some(SubmapReport { closed: None, .. }) => "compare short-term maps",
            Some(_) => "compare short-term maps, optimise the graph",
        };
        stages.add(stage, stages.now().saturating_sub(begun));
        self.take(report, events);
        let how = if scan.odom_from_base.is_some() { "dead reckoning" } else { "lost" };
        let map_from_base = self.map_from_base().unwrap_or(Se2::IDENTITY);
        events.push(Event::Placed { scan: index, map_from_base, how });
        Ok(())
    }

    fn finish(
        &mut self,
        _recording: &Recording,
        stages: &mut Stages,
        events: &mut Vec<Event>,
    ) -> Result<(), SurveyError> {
        let report = stages.measure("compare short-term maps", || self.slam.finish())?;
        self.take(report, events);
        self.map = None;
        events.push(Event::Moved);
        Ok(())
    }

    /// Scans in a submap stand where the graph has it; the others follow by dead reckoning.
    fn trajectory(&self) -> Vec<StampedPose> {
        let placed = self.slam.trajectory();
        let mut poses: Vec<StampedPose> = Vec::with_capacity(self.scans.len());
        let mut before: Option<Se2> = None;
        for &(stamp, odom) in &self.scans {
            let known = placed.binary_search_by_key(&stamp, |p| p.stamp).ok();
            let pose = known.map(|i| placed[i].pose).or_else(|| {
                let step = before?.inverse().compose(odom?);
                Some(poses.last()?.pose.compose(step))
            });
            let last = poses.last().map(|last| last.pose);
            let pose = pose.or(last).or(odom).unwrap_or(Se2::IDENTITY);
            poses.push(StampedPose { stamp, pose });
            before = odom.or(before);
        }
        poses
    }

    fn map_from_base(&self) -> Option<Se2> {
        self.slam.map_from_base()
    }

    fn map(&mut self, _recording: &Recording) -> Result<&SurveyMap, SurveyError> {
        let map = match self.map.take() {
            Some(map) => map,
            None => SurveyMap::Evidence(self.slam.map()?),
        };
        Ok(self.map.insert(map))
    }

    fn map_from_odom(&self) -> Option<Se2> {
        Some(Se2::IDENTITY)
    }

    fn graph(&self) -> Option<(&PoseGraph, Vec<usize>)> {
        let stamps = self.slam.submap_stamps().into_iter();
        Some((self.slam.graph(), stamps.map(|stamp| self.scan_at(stamp)).collect()))
    }

    fn short_term(&self) -> Option<ShortTerm> {
        let map = SurveyMap::Evidence(self.slam.localiser().short_term_map().clone());
        // Drawn in the frame of continuous localisation, which no loop corrects.
        let own = self.slam.localiser().map_from_base();
        let frames = self.slam.map_from_base().zip(own);
        let map_from_patch = frames.map_or(Se2::IDENTITY, |(map, own)| map.compose(own.inverse()));
        Some(ShortTerm { map_from_patch, map })
    }

    fn counters(&self) -> Vec<Counter> {
        let counter = |name, label, n| Counter { name, label, n };
        let counts = self.slam.localiser().counts();
        vec![
            counter("registrations", "submaps", self.slam.graph().poses().len()),
            counter("edges", "edges of the graph", self.slam.graph().edges().len()),
            counter("loops_tried", "loops looked for", self.slam.n_tried()),
            counter("closures", "loops closed", self.slam.loops().len()),
            counter("readings_used", "readings in the map", counts.n_inserted),
            counter("ghosts", "echoes that the map contradicts, dropped", counts.n_ghosts),
        ]
    }
}
