//! A laser's scans at dead reckoning's poses: no correction, and the map that follows from it.

use geometry::Se2;
use recordings::{LaserRig, Recording, StampedPose};

use crate::{
    clock::Stages,
    config::SurveyConfig,
    drawing::{LaserDrawing, SurveyMap},
    mapper::{Counter, Event, Mapper, SurveyError},
};

#[derive(Debug)]
pub(crate) struct OdometryMapper {
    drawing: LaserDrawing,
    /// Where the map begins: the first scan's odometry is undone.
    map_from_odom: Se2,
    trajectory: Vec<StampedPose>,
}

impl OdometryMapper {
    pub(crate) fn new(
        recording: &Recording,
        rig: &LaserRig,
        config: &SurveyConfig,
    ) -> Result<Self, SurveyError> {
        let missing = recording.scans.iter().position(|scan| scan.odom_from_base.is_none());
        if let Some(scan) = missing {
            let text = format!("scan {} has no odometry, which this method lives on", scan + 1);
            return Err(SurveyError::Unsuitable(text));
        }
        let first = recording.scans.first().and_then(|scan| scan.odom_from_base);
        let drawing = LaserDrawing::new(rig, config.map())?;
        let map_from_odom = first.unwrap_or(Se2::IDENTITY).inverse();
        Ok(Self { drawing, map_from_odom, trajectory: Vec::new() })
    }
}

impl Mapper for OdometryMapper {
    fn step(
        &mut self,
        recording: &Recording,
        index: usize,
        _stages: &mut Stages,
        events: &mut Vec<Event>,
    ) -> Result<(), SurveyError> {
        let scan = &recording.scans[index];
        let pose = self.map_from_odom.compose(scan.odom_from_base.unwrap_or(Se2::IDENTITY));
        self.trajectory.push(StampedPose { stamp: scan.stamp, pose });
        events.push(Event::Placed { scan: index, map_from_base: pose, how: "dead reckoning" });
        Ok(())
    }

    fn finish(
        &mut self,
        _recording: &Recording,
        _stages: &mut Stages,
        _events: &mut Vec<Event>,
    ) -> Result<(), SurveyError> {
        Ok(())
    }

    fn trajectory(&self) -> Vec<StampedPose> {
        self.trajectory.clone()
    }

    fn map_from_base(&self) -> Option<Se2> {
        self.trajectory.last().map(|last| last.pose)
    }

    fn map(&mut self, recording: &Recording) -> Result<&SurveyMap, SurveyError> {
        Ok(self.drawing.update(recording, &self.trajectory)?)
    }

    fn counters(&self) -> Vec<Counter> {
        Vec::new()
    }
}
