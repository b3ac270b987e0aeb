//! What a mode sets before anything else is read.

use super::{
    method::Mode,
    values::{MapSettings, Values},
};
use crate::sonar::SonarSettings;

/// A cell below it is written as free in the source's modes; the source itself only has occupied ones, from 0.7 on.
const FREE_PROB: f64 = 0.3;

/// The values that a mode begins with.
pub(super) fn of(mode: Mode) -> Values {
    let sonar = SonarSettings::of(mode);
    let map = match mode {
        Mode::Default | Mode::Graph => MapSettings::default(),
        // The source calls a cell occupied from 0.7 on.
        Mode::Thesis | Mode::Listing => MapSettings {
            occupied_prob: sonar.classic.occupied_from_prob,
            free_prob: FREE_PROB,
            ..MapSettings::default()
        },
    };
    Values { mode, map, sonar, ..Values::default() }
}
