//! The template: a mission file with every key, and the words that keys choose among.
//!
//! What a key may say stands in the template as the key in braces, and is filled in from the table that owns the words.

use std::sync::LazyLock;

use decision::{Mode, MoveSignal};
use messages::FailureReason;
use navigator::{Avoidance, Method, PoseMethod, TagController};
use obstacle_avoidance::Variant;
use path_following::{PathController, TrailController, fuzzy::TableKind};
use pheromones::Perception;
use robot_models::RobotModel;
use sensor_models::LaserKind;
use settings::Choice;

use super::{
    plan::{FailsafeOutput, PlannedKind},
    words::{DeviceKind, EventKind, LineKind, RingKind, UnknownCells},
};
use crate::cut::{Direction, Line};

/// Every key with its default and what it means; `[success]` comes from its own table.
const TEMPLATE: &str = include_str!("template.toml");

/// The words that one key of a mission file may have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WordList {
    /// The key with its tables.
    pub key: &'static str,
    /// Each word and what it is.
    pub words: Vec<(String, String)>,
}

/// A key and what lists its words.
type Row = (&'static str, fn() -> Vec<(String, String)>);

/// Every key that chooses among a few, in the order of the template.
const LISTS: &[Row] = &[
    ("world.unknown", of::<UnknownCells>),
    ("world.walls.material", materials),
    ("world.things.kind", of::<PlannedKind>),
    ("devices.kind", of::<DeviceKind>),
    ("devices.failsafe", of::<FailsafeOutput>),
    ("robots.model", models),
    ("robots.sonar.ring", of::<RingKind>),
    ("robots.line.kind", of::<LineKind>),
    ("robots.lasers.kind", of::<LaserKind>),
    ("robots.mind.where_am_i.method", of::<PoseMethod>),
    ("robots.mind.how.method", of::<Method>),
    ("robots.mind.follow.trail_law", of::<TrailController>),
    ("robots.mind.follow.path_law", of::<PathController>),
    ("robots.mind.follow.fuzzy.table", of::<TableKind>),
    ("robots.mind.follow.tags.law", of::<TagController>),
    ("robots.mind.guard.method", of::<Avoidance>),
    ("robots.mind.guard.aims_again", of::<Variant>),
    ("pheromones.perception", of::<Perception>),
    ("pheromones.line.kind", simulated_lines),
    ("decision.mode", of::<Mode>),
    ("decision.completion", of::<MoveSignal>),
    ("decision.line.kind", simulated_lines),
    ("events.do", of::<EventKind>),
    ("events.line", of::<Line>),
    ("events.direction", directions),
    ("success.gave_up.reason", of::<FailureReason>),
];

fn listed<C: Choice>(all: &[C]) -> Vec<(String, String)> {
    all.iter().map(|choice| (choice.key().to_owned(), choice.about().to_owned())).collect()
}

fn of<C: Choice>() -> Vec<(String, String)> {
    listed(C::ALL)
}

fn simulated_lines() -> Vec<(String, String)> {
    listed(LineKind::SIMULATED)
}

fn materials() -> Vec<(String, String)> {
    let all = sensor_models::materials();
    all.iter().map(|material| (material.name.to_owned(), String::new())).collect()
}

fn models() -> Vec<(String, String)> {
    RobotModel::catalogue().iter().map(|model| (model.name.clone(), model.title.clone())).collect()
}

/// The words of every line; `both` is one of each.
fn directions() -> Vec<(String, String)> {
    let mut all = vec![("both".to_owned(), "both ways".to_owned())];
    for line in Line::ALL {
        for direction in [Direction::Away, Direction::Back] {
            let what = line.describe(direction).to_owned();
            all.push((line.direction_name(direction).to_owned(), what));
        }
    }
    all
}

/// The template with the keys of lists in braces.
fn unfilled() -> String {
    format!("{TEMPLATE}\n{}", super::success::template())
}

/// The words of every key that chooses among a few.
pub(super) fn word_lists() -> Vec<WordList> {
    LISTS.iter().map(|&(key, words)| WordList { key, words: words() }).collect()
}

/// The template with the words filled in.
pub(super) fn template() -> &'static str {
    static FILLED: LazyLock<String> = LazyLock::new(|| {
        LISTS.iter().fold(unfilled(), |text, (key, words)| {
            let words = words();
            let prose = settings::listed(words.iter().map(|(word, _)| word.as_str()));
            text.replace(&format!("{{{key}}}"), &prose)
        })
    });
    &FILLED
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The raw text names every list once at least, and no list that there is not.
    #[test]
    fn the_template_has_a_place_for_every_list() {
        let in_comments = |line: &str| line.split_once('#').map(|(_, comment)| comment.to_owned());
        let comments: String = unfilled().lines().filter_map(in_comments).collect();
        let named: Vec<&str> = comments
            .split('{')
            .skip(1)
            .filter_map(|rest| rest.split_once('}').map(|(key, _)| key))
            .collect();
        for (key, words) in LISTS {
            assert!(named.contains(key), "the template does not list the words of {key}");
            assert!(words().len() > 1, "{key}");
        }
        for key in named {
            assert!(LISTS.iter().any(|(listed, _)| *listed == key), "{{{key}}} is no list");
        }
        assert!(!template().lines().filter_map(in_comments).any(|c| c.contains('{')));
    }

    /// A word means one thing.
    #[test]
    fn no_word_is_in_two_lists_of_one_key() {
        for WordList { key, words } in word_lists() {
            for (i, (word, _)) in words.iter().enumerate() {
                assert!(words[..i].iter().all(|(other, _)| other != word), "{key}: {word} twice");
            }
        }
    }
}
