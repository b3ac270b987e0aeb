//! `[success]`: what counts as success. Each requirement is one file, with its table, its check, its judgement and its
//! words; here is the list of them, which missions, the judge, the template and the guide read.

mod arrived;
mod cast;
mod contacts;
mod counts;
mod facts;
mod gave_up;
mod kind;
mod on_path;
mod stayed;
mod switched_on;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use arrived::ArrivedFile;
pub(crate) use cast::Cast;
use counts::Counted;
pub(crate) use facts::Facts;
pub use gave_up::GaveUpFile;
use kind::About;
pub(crate) use kind::{Progress, Requirement, State};
pub use on_path::OnPathFile;
pub use stayed::StayedFile;
pub use switched_on::SwitchedOnFile;

use super::check::common::Checked;

/// `[success]`: every requirement must hold.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SuccessFile {
    /// No robot touches anything.
    pub no_contact: bool,
    /// The decision program sends exactly this many MOVE.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moves_sent: Option<u64>,
    /// `EVENT` writes exactly this many entries into the decision node's log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub events_logged: Option<u64>,
    /// The watchdog restarts the decision program exactly so often.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub watchdog_resets: Option<u64>,
    /// Every robot keeps at least this distance from everything, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance_min_m: Option<f64>,
    /// `[[success.arrived]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub arrived: Vec<ArrivedFile>,
    /// `[[success.switched_on]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub switched_on: Vec<SwitchedOnFile>,
    /// `[[success.stayed]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stayed: Vec<StayedFile>,
    /// `[[success.gave_up]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gave_up: Vec<GaveUpFile>,
    /// `[[success.on_path]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub on_path: Vec<OnPathFile>,
}

/// What a mission's `[success]` makes of one key.
type Make = fn(&SuccessFile, &Cast<'_>) -> Checked<Vec<Arc<dyn Requirement>>>;

/// Every requirement, in the order in which they are judged and told.
const KINDS: &[(About, Make)] = &[
    (arrived::ABOUT, |file, cast| arrived::requirements(&file.arrived, cast)),
    (switched_on::ABOUT, |file, cast| switched_on::requirements(&file.switched_on, cast)),
    (stayed::ABOUT, |file, cast| stayed::requirements(&file.stayed, cast)),
    (gave_up::ABOUT, |file, cast| gave_up::requirements(&file.gave_up, cast)),
    (Counted::Moves.about(), |file, cast| {
        counts::requirements(Counted::Moves, file.moves_sent, cast)
    }),
    (Counted::Events.about(), |file, cast| {
        counts::requirements(Counted::Events, file.events_logged, cast)
    }),
    (Counted::WatchdogResets.about(), |file, cast| {
        counts::requirements(Counted::WatchdogResets, file.watchdog_resets, cast)
    }),
    (contacts::CLEARANCE, |file, _| contacts::clearance(file.clearance_min_m)),
    (on_path::ABOUT, |file, cast| on_path::requirements(&file.on_path, cast)),
    (contacts::NO_CONTACT, |file, _| Ok(contacts::no_contact(file.no_contact))),
];

/// The requirements of a mission.
pub(super) fn requirements(
    file: &SuccessFile,
    cast: &Cast<'_>,
) -> Checked<Vec<Arc<dyn Requirement>>> {
    let mut all = Vec::new();
    for (_, make) in KINDS {
        all.extend(make(file, cast)?);
    }
    Ok(all)
}

/// Each key and what it asks for.
pub(super) fn texts() -> Vec<(&'static str, &'static str)> {
    KINDS.iter().map(|(about, _)| (about.key, about.text)).collect()
}

/// The lines of `[success]` in the template: single keys first, as TOML wants them.
pub(super) fn template() -> String {
    let (tables, keys): (Vec<&str>, Vec<&str>) =
        KINDS.iter().map(|(about, _)| about.template).partition(|text| text.starts_with('['));
    let head = "[success]                # every requirement must hold; without any, a run that ends has passed\n";
    format!("{head}{}\n{}", keys.concat(), tables.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A key of the file without a row here would be accepted and judged by nobody.
    #[test]
    fn every_key_of_the_file_is_in_the_list_and_in_the_template() {
        let unknown = toml::from_str::<SuccessFile>("no_such_key = 1").unwrap_err().to_string();
        let (_, expected) = unknown.split_once("expected one of").unwrap();
        let keys: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
        let listed: Vec<&str> = texts().iter().map(|(key, _)| *key).collect();
        assert_eq!(keys.len(), listed.len(), "{keys:?} {listed:?}");
        for key in keys {
            assert!(listed.contains(&key), "{key} has no row");
        }
        for (about, _) in KINDS {
            let (single, table) =
                (format!("{} =", about.key), format!("[[success.{}]]", about.key));
            let begins = about.template.starts_with(&single) || about.template.starts_with(&table);
            assert!(begins, "{}: {}", about.key, about.template);
        }
    }
}
