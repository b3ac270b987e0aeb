//! The names a program defines, and guesses at what a misspelt name meant.

use std::{collections::BTreeMap, fmt};

use crate::{Mnemonic, ResourceId, instruction_set::WORDS};

/// What `EQU` gave a name to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symbol {
    /// A number of 16 bits, signed or not.
    Value(i32),
    /// A resource.
    Resource(ResourceId),
}

impl fmt::Display for Symbol {
    /// The number, or the name of the resource.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(value) => write!(f, "{value}"),
            Self::Resource(id) => write!(f, "{id}"),
        }
    }
}

/// A name and where it was defined.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Definition {
    pub(crate) line: usize,
    /// `None` for a label, or when the value was wrong.
    pub(crate) symbol: Option<Symbol>,
}

/// Every name defined so far, in upper case.
pub(crate) type Names = BTreeMap<String, Definition>;

/// Names longer than this get no guess; keeps the work on garbage bounded.
const GUESS_LENGTH_MAX: usize = 24;
/// Names of the program considered for one guess.
const GUESS_NAMES_MAX: usize = 256;

/// The function whose name is nearest to `word`, if any is near.
pub(crate) fn nearest_mnemonic(word: &str) -> Option<&'static str> {
    nearest(word, Mnemonic::ALL.iter().map(|m| m.name()).chain(["EQU"]))
}

/// The resource, word or name of the program nearest to `word`, if any is near.
pub(crate) fn nearest_name(word: &str, names: &Names) -> Option<String> {
    let resources: Vec<String> = ResourceId::all().map(|id| id.to_string()).collect();
    let own = names.keys().map(String::as_str).take(GUESS_NAMES_MAX);
    // The first of equals wins, and `OL` is rather 0L than O1.
    let words = ["0L", "1L"].into_iter().chain(WORDS.iter().map(|word| word.name));
    nearest(word, words.chain(own).chain(resources.iter().map(String::as_str))).map(str::to_owned)
}

/// The first of the nearest candidates, when it is near enough to be a slip of the hand.
fn nearest<'c>(word: &str, candidates: impl Iterator<Item = &'c str>) -> Option<&'c str> {
    let word: Vec<char> = word.to_ascii_uppercase().chars().collect();
    if word.len() > GUESS_LENGTH_MAX {
        return None;
    }
    // One slip in a short name, two in a longer one. A slip costs 2, a look-alike costs 1.
    let cost_max = if word.len() < 5 { 2 } else { 4 };
    candidates
        .map(|candidate| (distance(&word, candidate), candidate))
        .filter(|&(cost, _)| cost <= cost_max)
        .min_by_key(|&(cost, _)| cost)
        .map(|(_, candidate)| candidate)
}

/// Optimal string alignment distance with neighbours swapped at the price of one slip.
///
/// Source: Damerau (1964), "A technique for computer detection and correction of spelling
/// errors", CACM 7(3). Differences: characters that look alike in print cost half.
fn distance(word: &[char], candidate: &str) -> usize {
    let mut before: Vec<usize> = Vec::new();
    let mut above: Vec<usize> = (0..=word.len()).map(|i| i.saturating_mul(2)).collect();
    let mut last_char = None;
    for (row, c) in candidate.chars().enumerate() {
        let mut costs = Vec::with_capacity(above.len());
        costs.push(row.saturating_add(1).saturating_mul(2));
        let mut last_typed = None;
        for (column, &typed) in word.iter().enumerate() {
            let at = |list: &[usize], i: usize| list.get(i).copied().unwrap_or(usize::MAX);
            let replaced = at(&above, column).saturating_add(replacement_cost(typed, c));
            let dropped = at(&above, column.saturating_add(1)).saturating_add(2);
            let added = at(&costs, column).saturating_add(2);
            let mut cost = replaced.min(dropped).min(added);
            if last_char == Some(typed) && last_typed == Some(c) && column > 0 {
                cost = cost.min(at(&before, column.saturating_sub(1)).saturating_add(2));
            }
            costs.push(cost);
            last_typed = Some(typed);
        }
        before = std::mem::replace(&mut above, costs);
        last_char = Some(c);
    }
    above.last().copied().unwrap_or(usize::MAX)
}

fn replacement_cost(a: char, b: char) -> usize {
    const ALIKE: [[char; 2]; 4] = [['0', 'O'], ['1', 'I'], ['1', 'L'], ['I', 'L']];
    match a == b {
        true => 0,
        false if ALIKE.contains(&[a, b]) || ALIKE.contains(&[b, a]) => 1,
        false => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_lead_to_the_function_meant() {
        let guesses = [
            ("ADN", Some("AND")),
            ("TIMR", Some("TIMER")),
            ("CONTER", Some("COUNTER")),
            ("NANDD", Some("NAND")),
            ("DCOMPP", Some("DCOMP")),
            ("EQ", Some("EQU")),
            ("BRANCH", None),
            ("", None),
        ];
        for (word, guess) in guesses {
            assert_eq!(nearest_mnemonic(word), guess, "{word}");
        }
    }

    #[test]
    fn look_alikes_lead_to_the_resource_meant() {
        let guess = |word: &str| nearest_name(word, &Names::new());
        let guesses = [
            ("00", "O0"),
            ("IO", "I0"),
            ("OL", "0L"),
            ("LL", "1L"),
            ("YO", "Y0"),
            ("YMTR16", "YTMR16"),
            ("RAISE", "RISE"),
            ("STATSU", "STATUS"),
            ("STAUS", "STATUS"),
        ];
        for (word, expected) in guesses {
            assert_eq!(guess(word).as_deref(), Some(expected), "{word}");
        }
        assert_eq!(guess("KITCHEN"), None);
        assert_eq!(guess(&"Y".repeat(1000)), None);
    }

    #[test]
    fn names_of_the_program_are_guessed_too() {
        let definition = Definition { line: 1, symbol: Some(Symbol::Value(3)) };
        let names = Names::from([("DOORBELL".to_owned(), definition)]);
        assert_eq!(nearest_name("DORBELL", &names).as_deref(), Some("DOORBELL"));
    }
}
