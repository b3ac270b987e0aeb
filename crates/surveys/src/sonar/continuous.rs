//! Continuous localisation, scan by scan, behind a survey's face.

use continuous_localisation::{Localiser, Outcome, Registration as Registered, Score};
use geometry::Se2;
use recordings::{Recording, RingRig, StampedPose};

use super::prior::SurveyPrior;
use crate::{
    clock::Stages,
    config::SurveyConfig,
    drawing::SurveyMap,
    mapper::{Candidate, Counter, Event, Mapper, Registration, ShortTerm, SurveyError},
};

/// How sure a given start in a known map is: standard deviations of position (m) and heading (rad).
const START_STD: (f64, f64) = (0.1, 0.05);

#[derive(Debug)]
pub(crate) struct ContinuousMapper {
    localiser: Localiser,
    score: &'static str,
    poses: Vec<StampedPose>,
    /// The first scan that is not in a registered short-term map.
    open_from: usize,
    /// Odometry lines that were taken.
    n_odometry: usize,
    map: Option<SurveyMap>,
    map_from_odom: Se2,
    n_registered: usize,
    n_applied: usize,
}

impl ContinuousMapper {
    pub(crate) fn new(
        recording: &Recording,
        ring: &RingRig,
        config: &SurveyConfig,
        prior: Option<SurveyPrior>,
    ) -> Result<Self, SurveyError> {
        let config = config.values().sonar.localiser();
        let score = score_in_words(config.score);
        let mut localiser = Localiser::new(ring, config)
            .map_err(|error| SurveyError::Unsuitable(format!("sonar: {error}")))?;
        let odom_from_base = recording.scans.iter().find_map(|scan| scan.odom_from_base);
        let Some(odom_from_base) = odom_from_base else {
            let text = "no scan has odometry, and sonars alone do not tell where they are";
            return Err(SurveyError::Unsuitable(text.to_owned()));
        };
        let mut map_from_odom = Se2::IDENTITY;
        if let Some(SurveyPrior { map, start }) = prior {
            localiser.set_prior(map, Vec::new());
            let map_from_base = start.unwrap_or(odom_from_base);
            localiser.begin_at(map_from_base, START_STD.0, START_STD.1);
            map_from_odom = map_from_base.compose(odom_from_base.inverse());
        }
        Ok(Self {
            localiser,
            score,
            poses: Vec::new(),
            open_from: 0,
            n_odometry: 0,
            map: None,
            map_from_odom,
            n_registered: 0,
            n_applied: 0,
        })
    }

    /// Moves the poses of a registered short-term map to where it was found to be.
    fn take(&mut self, recording: &Recording, registered: &Registered, events: &mut Vec<Event>) {
        let last = self.poses.len().saturating_sub(1);
        let first = self.open_from.min(last);
        for index in first..self.poses.len() {
            let stamp = self.poses[index].stamp;
            let found = registered.poses.binary_search_by_key(&stamp, |p| p.stamp);
            if let Ok(place) = found {
                self.poses[index].pose = registered.poses[place].pose;
            } else if index > 0 {
                // It stood still, and was not used: where it is follows from the scan before.
                let odom = |i: usize| recording.scans[i].odom_from_base;
                let step = odom(index - 1).zip(odom(index)).map(|(a, b)| a.inverse().compose(b));
                let before = self.poses[index - 1].pose;
                self.poses[index].pose = before.compose(step.unwrap_or(Se2::IDENTITY));
            }
        }
        self.open_from = self.poses.len();
        self.n_registered += 1;
        self.n_applied += usize::from(registered.outcome.is_applied());
        events.push(Event::Registered(told(registered, self.score, (first, last))));
        if registered.outcome.is_applied() {
            events.push(Event::Moved);
        }
    }
}

impl Mapper for ContinuousMapper {
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
            self.localiser.add_odometry(line.stamp, line.pose);
        }
        let begun = stages.now();
        let registered = self.localiser.step(scan);
        let stage =
            if registered.is_some() { "compare short-term maps" } else { "collect readings" };
        stages.add(stage, stages.now().saturating_sub(begun));
        let before = self.poses.last().map(|last| last.pose);
        let pose = self.localiser.map_from_base().or(before).unwrap_or(self.map_from_odom);
        self.poses.push(StampedPose { stamp: scan.stamp, pose });
        if let Some(registered) = registered {
            self.map = None;
            self.take(recording, &registered, events);
        }
        let how = if scan.odom_from_base.is_some() { "dead reckoning" } else { "lost" };
        let map_from_base = self.poses[index].pose;
        events.push(Event::Placed { scan: index, map_from_base, how });
        Ok(())
    }

    fn finish(
        &mut self,
        recording: &Recording,
        stages: &mut Stages,
        events: &mut Vec<Event>,
    ) -> Result<(), SurveyError> {
        let last = stages.measure("compare short-term maps", || self.localiser.finish());
        self.map = None;
        if let Some(registered) = last {
            self.take(recording, &registered, events);
        }
        Ok(())
    }

    fn trajectory(&self) -> Vec<StampedPose> {
        self.poses.clone()
    }

    fn map_from_base(&self) -> Option<Se2> {
        self.poses.last().map(|last| last.pose)
    }

    fn map(&mut self, _recording: &Recording) -> Result<&SurveyMap, SurveyError> {
        let localiser = &self.localiser;
        Ok(self.map.get_or_insert_with(|| SurveyMap::Evidence(localiser.map().clone())))
    }

    fn map_from_odom(&self) -> Option<Se2> {
        Some(self.map_from_odom)
    }

    fn short_term(&self) -> Option<ShortTerm> {
        let map = SurveyMap::Evidence(self.localiser.short_term_map().clone());
        Some(ShortTerm { map_from_patch: Se2::IDENTITY, map })
    }

    fn counters(&self) -> Vec<Counter> {
        let counts = self.localiser.counts();
        let counter = |name, label, n| Counter { name, label, n };
        vec![
            counter("registrations", "short-term maps", self.n_registered),
            counter("corrections", "of them moved the robot", self.n_applied),
            counter("readings_used", "readings in the map", counts.n_inserted),
            counter(
                "readings_at_standstill",
                "readings at standstill, dropped",
                counts.n_at_standstill,
            ),
            counter("ghosts", "echoes that the map contradicts, dropped", counts.n_ghosts),
            counter("odometry_jumps", "jumps of odometry, left out", counts.n_jumps),
            counter(
                "scans_without_odometry",
                "scans without odometry",
                counts.n_rows_without_odometry,
            ),
        ]
    }
}

/// What a score measures.
pub(super) fn score_in_words(score: Score) -> &'static str {
    match score {
        Score::Evidence { .. } => "one minus the correlation of evidence (less is better)",
        Score::CommonCells { .. } => "mean difference of common cells (less is better)",
        Score::WholeWindow => "sum of differences over the whole window (less is better)",
    }
}

/// A registration of the scans from `first` to `last`, in a survey's words.
pub(super) fn told(
    registered: &Registered,
    score: &'static str,
    (first, last): (usize, usize),
) -> Registration {
    let candidates = registered.candidates.iter();
    let candidate = |c: &continuous_localisation::search::Candidate| Candidate {
        offset: Se2::new(c.shift.x, c.shift.y, c.turn_rad),
        score_ratio: c.score_ratio,
    };
    let Se2 { x_m, y_m, yaw_rad } = registered.correction;
    let moved = format!("by {:.3} m and {:.2}°", x_m.hypot(y_m), yaw_rad.to_degrees());
    let verdict = match registered.outcome {
        Outcome::ByGridsAndWalls => format!("moved {moved}: maps and walls agree"),
        Outcome::ByGrids => format!("moved {moved}: the maps fit"),
        Outcome::ByWalls => format!(
            "moved {moved}: walls were recognised (the maps alone had no distinct best, and did not count)"
        ),
        Outcome::NothingRecognised => "new ground: nothing was corrected".to_owned(),
        Outcome::NotDistinct => "no distinct best: nothing was corrected".to_owned(),
        Outcome::SwitchedOff => "corrections are switched off".to_owned(),
    };
    let applied = registered.outcome.is_applied();
    Registration {
        first_scan: first,
        last_scan: last,
        candidates: candidates.map(candidate).collect(),
        best: registered.chosen,
        applied,
        verdict,
        score,
        correction: applied.then_some(registered.correction),
    }
}
