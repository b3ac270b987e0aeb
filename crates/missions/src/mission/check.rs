//! From what is written to what may be relied on: every range, name and reference.

pub(super) mod common;
mod environment;
mod hints;
mod keys;
mod lasers;
mod map;
mod mind;
mod ring;
mod robots;
mod tags;
mod tasks;
mod unused;

pub(crate) use environment::{overlap, rectangle};
pub(super) use hints::warnings;
pub(super) use map::wrong_map;

use navigator::Method;
use settings::Choice as _;

use super::{error::Wrong, file::MissionFile};
use super::{
    parts::Parts,
    success::{self, Cast},
};
use common::{Checked, range, seconds};

/// Checks a whole mission whose files have been read in.
pub(super) fn check(file: &MissionFile) -> Checked<Parts> {
    let name_ok = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let head = &file.mission;
    if head.name.is_empty() || !head.name.chars().all(name_ok) {
        return Err(Wrong::new("mission.name", &head.name, "small letters, digits and `-`"));
    }
    range("mission.duration_max_s", head.duration_max_s, 0.1..=86_400.0, "from 0.1 to 86400 s")?;
    let duration_max = seconds(head.duration_max_s);
    let devices = environment::devices(file)?;
    let robots = robots::robots(file)?;
    let pheromones = file.pheromones.as_ref().map(environment::pheromones).transpose()?;
    let tags = file.tags.as_ref().map(|t| tags::tags(file, t)).transpose()?;
    let world = environment::world(file, pheromones.as_ref())?;
    environment::starts_are_free(file, &world, &robots)?;
    let decision = file.decision.as_ref();
    let decision = decision.map(|d| tasks::decision(d, &devices, &robots)).transpose()?;
    for (i, robot) in file.robots.iter().enumerate() {
        let (key, word) = (format!("robots[{i}].mind.how.method"), &robot.mind.how.method);
        match settings::chosen(&key, word)? {
            Method::Trail if pheromones.is_none() => {
                let straight = Method::Direct.key();
                let allowed = format!("`{straight}`, because the mission has no [pheromones]");
                return Err(Wrong::new(key, word, allowed));
            }
            Method::Tags if tags.is_none() => {
                let allowed = "another method, because the mission has no [tags]";
                return Err(Wrong::new(key, word, allowed));
            }
            Method::Trail | Method::Direct | Method::Path | Method::Tags | Method::Map => {}
        }
    }
    let events = tasks::events(file, &devices, &robots)?;
    let cast = Cast {
        duration_max_s: head.duration_max_s,
        robots: &robots,
        devices: &devices,
        events: &events,
        decision: decision.as_ref(),
    };
    let success = success::requirements(&file.success, &cast)?;
    Ok(Parts { duration_max, world, devices, robots, pheromones, tags, decision, events, success })
}
