//! The checked tables of a mission.

use std::{sync::Arc, time::Duration};

use super::{
    plan::{DecisionPlan, DevicePlan, EventPlan, PheromonePlan, RobotPlan, TagsPlan, WorldPlan},
    success::{Cast, Requirement},
};

/// The checked tables.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub(crate) duration_max: Duration,
    pub(crate) world: WorldPlan,
    pub(crate) devices: Vec<DevicePlan>,
    pub(crate) robots: Vec<RobotPlan>,
    pub(crate) pheromones: Option<PheromonePlan>,
    pub(crate) tags: Option<TagsPlan>,
    pub(crate) decision: Option<DecisionPlan>,
    pub(crate) events: Vec<EventPlan>,
    pub(crate) success: Vec<Arc<dyn Requirement>>,
}

impl Parts {
    /// What requirements can be about.
    pub(super) fn cast(&self) -> Cast<'_> {
        Cast {
            duration_max_s: self.duration_max.as_secs_f64(),
            robots: &self.robots,
            devices: &self.devices,
            events: &self.events,
            decision: self.decision.as_ref(),
        }
    }
}
