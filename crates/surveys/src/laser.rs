//! The laser method behind a survey's face.

use geometry::Se2;
use least_squares::PoseGraph;
use recordings::{Recording, Rig, StampedPose};
use slam::laser::{Closure, LaserSlam, Rejection, Tracking};

use crate::{
    clock::Stages,
    config::SurveyConfig,
    drawing::{LaserDrawing, SurveyMap},
    mapper::{Closed, Counter, Event, Mapper, SurveyError},
};

#[derive(Debug)]
pub(crate) struct LaserMapper {
    slam: LaserSlam,
    drawing: LaserDrawing,
    newest: Option<Se2>,
}

impl LaserMapper {
    pub(crate) fn new(recording: &Recording, config: &SurveyConfig) -> Result<Self, SurveyError> {
        let Rig::Laser(rig) = &recording.rig else {
            return Err(SurveyError::Unsuitable("there is no laser in this recording".to_owned()));
        };
        let slam = LaserSlam::new(rig.clone(), config.values().laser);
        Ok(Self { slam, drawing: LaserDrawing::new(rig, config.map())?, newest: None })
    }

    fn closed(&self, closure: &Closure) -> Closed {
        let scan = |keyframe: usize| self.slam.keyframes()[keyframe].scan_index;
        Closed {
            from_scan: scan(closure.from),
            to_scan: scan(closure.to),
            shift_m: closure.shift_m,
            shift_rad: closure.shift_rad,
        }
    }
}

impl Mapper for LaserMapper {
    fn step(
        &mut self,
        recording: &Recording,
        index: usize,
        stages: &mut Stages,
        events: &mut Vec<Event>,
    ) -> Result<(), SurveyError> {
        let scan = &recording.scans[index];
        let begun = stages.now();
        let report = self.slam.step(scan);
        // The clock is looked at once; which part of the work it was is known only afterwards.
        let stage = match (report.keyframe, report.graph_moved) {
            (None, _) => "track the scan",
            (Some(_), false) => "track the scan, look for loops",
            (Some(_), true) => "track the scan, look for loops, optimise the graph",
        };
        stages.add(stage, stages.now().saturating_sub(begun));
        self.newest = Some(report.map_from_base);
        let how = match report.tracking {
            Tracking::First => "first",
            Tracking::Standing => "standing",
            Tracking::Matched => "matched",
            Tracking::Lost => "lost",
        };
        events.push(Event::Placed { scan: index, map_from_base: report.map_from_base, how });
        if report.keyframe.is_some() {
            events.push(Event::Vertex { scan: index });
        }
        events.extend(report.closures.iter().map(|c| Event::Closed(self.closed(c))));
        if report.graph_moved {
            self.drawing.forget();
            events.push(Event::Moved);
        }
        Ok(())
    }

    fn finish(
        &mut self,
        _recording: &Recording,
        stages: &mut Stages,
        events: &mut Vec<Event>,
    ) -> Result<(), SurveyError> {
        let closures = stages.measure("last loops and optimisation", || self.slam.finish());
        events.extend(closures.iter().map(|c| Event::Closed(self.closed(c))));
        self.drawing.forget();
        self.newest = self.slam.trajectory().last().map(|last| last.pose);
        events.push(Event::Moved);
        Ok(())
    }

    fn trajectory(&self) -> Vec<StampedPose> {
        self.slam.trajectory()
    }

    fn map_from_base(&self) -> Option<Se2> {
        self.newest
    }

    fn map(&mut self, recording: &Recording) -> Result<&SurveyMap, SurveyError> {
        let trajectory = self.slam.trajectory();
        Ok(self.drawing.update(recording, &trajectory)?)
    }

    fn graph(&self) -> Option<(&PoseGraph, Vec<usize>)> {
        let scans = self.slam.keyframes().iter().map(|keyframe| keyframe.scan_index).collect();
        Some((self.slam.graph(), scans))
    }

    fn counters(&self) -> Vec<Counter> {
        let mut counters = vec![
            Counter { name: "keyframes", label: "keyframes", n: self.slam.keyframes().len() },
            Counter {
                name: "edges",
                label: "edges of the graph",
                n: self.slam.graph().edges().len(),
            },
            Counter { name: "closures", label: "loops closed", n: self.slam.closures().len() },
        ];
        counters.extend(self.slam.rejections().into_iter().map(|(rejection, n)| {
            let (name, label) = match rejection {
                Rejection::Score => ("rejected_score", "candidates that did not fit"),
                Rejection::Inliers => ("rejected_inliers", "candidates with too few points"),
                Rejection::Through => ("rejected_through", "candidates seen through walls"),
                Rejection::BothWays => {
                    ("rejected_both_ways", "candidates that differ on the way back")
                }
                Rejection::Alone => ("rejected_alone", "candidates without a second one"),
            };
            Counter { name, label, n }
        }));
        counters
    }
}
