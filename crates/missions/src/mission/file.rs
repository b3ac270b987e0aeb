//! The mission as people write it: one TOML table per component, units in the keys.
//!
//! Degrees are allowed here and nowhere else. Unknown keys are refused. Every field has a default
//! that works; [`Mission::template`](crate::Mission::template) lists them all with their documents. What is written
//! here is only relied on after [`Mission`](crate::Mission) has checked it.

mod decision;
mod devices;
mod events;
mod head;
mod lasers;
mod lines;
mod mind;
mod pheromones;
mod robots;
mod tags;
mod world;

use serde::{Deserialize, Serialize};

pub use super::success::{
    ArrivedFile, GaveUpFile, OnPathFile, StayedFile, SuccessFile, SwitchedOnFile,
};
pub use decision::DecisionFile;
pub use devices::DeviceFile;
pub use events::EventFile;
pub use head::HeadFile;
pub use lasers::LaserFile;
pub use lines::LineFile;
pub use mind::{
    FollowFile, FuzzyFile, GuardFile, HealthFile, HowFile, MindFile, TagFollowingFile,
    WhereAmIFile, WhereToFile,
};
pub use pheromones::PheromonesFile;
pub use robots::{OdometryFile, RobotFile, SonarFile, TeleoperatorFile};
pub use tags::{TagReadersFile, TagsFile};
pub use world::{PersonFile, RandomBoxesFile, RoomFile, ThingFile, WallFile, WorldFile};

/// A whole mission file.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct MissionFile {
    /// `[mission]`: what it is called and how long it may take.
    pub mission: HeadFile,
    /// `[world]`: walls, rooms, things, people.
    pub world: WorldFile,
    /// `[[devices]]`: what the smart environment can sense and do.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub devices: Vec<DeviceFile>,
    /// `[[robots]]`: who drives.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub robots: Vec<RobotFile>,
    /// `[pheromones]`: the trail and its server; absent: there is no server.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pheromones: Option<PheromonesFile>,
    /// `[tags]`: tags in the floor with a trail in them; absent: there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tags: Option<TagsFile>,
    /// `[decision]`: the decision program; absent: goals come from events only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decision: Option<DecisionFile>,
    /// `[[events]]`: what happens at which time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<EventFile>,
    /// `[success]`: what counts as success.
    pub success: SuccessFile,
}
