//! Two maps instead of one: how far a cell is known empty, how far it is known occupied.
//!
//! The older way to compose sonar readings. Both maps begin at 0, unknown; evidence only ever adds
//! up; an occupied arc loses what the empty map contradicts; in the end the greater value wins.
//!
//! Source: Axenie (2011), "Maparea mediului pentru roboți mobili cu structură senzorială limitată",
//! MSc dissertation, Univ. Dunărea de Jos Galați, eq. (6) to (8). Differences: equation (9), which
//! decides between the two maps, is missing there; [`decide`] is the usual rule. Equation (7)
//! prints the occupied map where cancelling makes sense with the empty one only: both can be had.

/// Which map takes from an occupied arc what it contradicts; eq. (7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cancellation {
    /// The empty map: what is known empty is less likely the reflector.
    #[default]
    ByEmpty,
    /// The occupied map, as printed in the source.
    Literal,
}

/// What the two maps say together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CellState {
    /// Nothing known, or both alike.
    Unknown,
    /// More empty than occupied, with this certainty.
    Empty(f64),
    /// More occupied than empty, with this certainty.
    Occupied(f64),
}

/// Adds evidence from 0 to 1 to a value from 0 to 1: a + b - a b; eq. (6) and (8).
pub fn superposed_prob(known_prob: f64, added_prob: f64) -> f64 {
    known_prob + added_prob - known_prob * added_prob
}

/// What is left of an arc's occupied evidence in a cell with these two values; eq. (7), before the
/// arc is normalised.
pub fn cancelled_prob(
    arc_prob: f64,
    empty_prob: f64,
    occupied_prob: f64,
    cancellation: Cancellation,
) -> f64 {
    let against_prob = match cancellation {
        Cancellation::ByEmpty => empty_prob,
        Cancellation::Literal => occupied_prob,
    };
    arc_prob * (1.0 - against_prob)
}

/// The greater of the two values decides, and is the certainty.
pub fn decide(empty_prob: f64, occupied_prob: f64) -> CellState {
    if occupied_prob > empty_prob {
        CellState::Occupied(occupied_prob)
    } else if empty_prob > occupied_prob {
        CellState::Empty(empty_prob)
    } else {
        CellState::Unknown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-15, "{found}, not {expected}");
    }

    #[test]
    fn the_published_values_come_out() {
        close(superposed_prob(0.3, 0.4), 0.58);
        let literal = cancelled_prob(0.5, 0.9, 0.3, Cancellation::Literal);
        close(literal, 0.35);
        close(superposed_prob(0.3, literal), 0.545);
    }

    #[test]
    fn the_empty_map_takes_from_the_arc() {
        close(cancelled_prob(0.5, 0.9, 0.3, Cancellation::ByEmpty), 0.05);
        close(cancelled_prob(0.5, 0.0, 0.3, Cancellation::default()), 0.5);
    }

    #[test]
    fn evidence_adds_up_but_never_beyond_certainty() {
        let twenty = (0..20).fold(0.0, |known, _| superposed_prob(known, 0.3));
        close(twenty, 1.0 - 0.7_f64.powi(20));
        close(superposed_prob(1.0, 0.7), 1.0);
    }

    #[test]
    fn the_stronger_map_decides_and_equals_do_not() {
        assert_eq!(decide(0.2, 0.3), CellState::Occupied(0.3));
        assert_eq!(decide(0.3, 0.2), CellState::Empty(0.3));
        assert_eq!(decide(0.3, 0.3), CellState::Unknown);
        assert_eq!(decide(0.0, 0.0), CellState::Unknown);
    }
}
