//! Words to choose from: each list has one owner, the enum that it is about.
//!
//! Whoever reads such a word ([`chosen`]), lists what is allowed ([`words`]) or explains it (a guide, `about`) reads
//! the same table. A variant cannot be forgotten in it: [`choices!`](crate::choices) matches all of them.

use crate::{Wrong, did_you_mean};

/// One of a few, chosen by a word.
pub trait Choice: Copy + PartialEq + 'static {
    /// All, in the order in which they are offered.
    const ALL: &'static [Self];

    /// The word for it in files.
    fn key(self) -> &'static str;

    /// What it is, for people: a few words without a full stop.
    fn about(self) -> &'static str;
}

/// Makes an enum a [`Choice`]: each variant with its word and what it is.
///
/// ```
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// enum Side {
///     Left,
///     Right,
/// }
/// settings::choices!(Side {
///     Left = "left": "where the heart is",
///     Right = "right": "the other one",
/// });
/// assert_eq!(settings::chosen("wall.side", "right"), Ok(Side::Right));
/// assert_eq!(settings::words::<Side>(), "left or right");
/// ```
#[macro_export]
macro_rules! choices {
    ($name:ty { $($variant:ident = $key:literal: $about:literal),+ $(,)? }) => {
        impl $crate::Choice for $name {
            const ALL: &'static [Self] = &[$(Self::$variant),+];

            fn key(self) -> &'static str {
                match self {
                    $(Self::$variant => $key),+
                }
            }

            fn about(self) -> &'static str {
                match self {
                    $(Self::$variant => $about),+
                }
            }
        }
    };
}

/// What the word `found` at `key` chooses.
///
/// # Errors
///
/// [`Wrong`], which lists what is allowed and names the word that was probably meant.
pub fn chosen<C: Choice>(key: &str, found: &str) -> Result<C, Wrong> {
    chosen_of(key, found, C::ALL)
}

/// The same of some of the words.
///
/// # Errors
///
/// As [`chosen`].
pub fn chosen_of<C: Choice>(key: &str, found: &str, allowed: &[C]) -> Result<C, Wrong> {
    picked(key, found, allowed.iter().map(|choice| (choice.key(), *choice)))
}

/// What `found` at `key` stands for among words that mean something only where they are.
///
/// # Errors
///
/// As [`chosen`].
pub fn picked<'w, T>(
    key: &str,
    found: &str,
    allowed: impl Iterator<Item = (&'w str, T)> + Clone,
) -> Result<T, Wrong> {
    let words = allowed.clone().map(|(word, _)| word);
    allowed.into_iter().find(|(word, _)| *word == found).map(|(_, meant)| meant).ok_or_else(|| {
        let quoted: Vec<String> = words.clone().map(|word| format!("`{word}`")).collect();
        let meant = did_you_mean(found, words);
        let meant = meant.map(|meant| format!(" (did you mean `{meant}`?)")).unwrap_or_default();
        Wrong::new(key, found, format!("one of {}{meant}", quoted.join(", ")))
    })
}

/// The words of a list as prose: `a, b or c`.
pub fn words<C: Choice>() -> String {
    listed(C::ALL.iter().map(|choice| choice.key()))
}

/// Words as prose: `a, b or c`.
pub fn listed<'w>(words: impl IntoIterator<Item = &'w str>) -> String {
    let words: Vec<&str> = words.into_iter().collect();
    match words.split_last() {
        None => String::new(),
        Some((last, [])) => (*last).to_owned(),
        Some((last, before)) => format!("{} or {last}", before.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Kind {
        Memory,
        Direct,
        Serial,
    }
    crate::choices!(Kind {
        Memory = "memory": "simulated bytes",
        Direct = "direct": "no bytes",
        Serial = "serial": "a real port",
    });

    #[test]
    fn a_word_chooses_and_another_is_answered_with_the_list() {
        for &kind in Kind::ALL {
            assert_eq!(chosen("link.kind", kind.key()), Ok(kind));
        }
        let wrong = chosen::<Kind>("link.kind", "memroy").unwrap_err();
        assert_eq!((wrong.key.as_str(), wrong.found.as_str()), ("link.kind", "\"memroy\""));
        let allowed = "one of `memory`, `direct`, `serial` (did you mean `memory`?)";
        assert_eq!(wrong.allowed, allowed);
        let few = [Kind::Memory, Kind::Direct];
        assert!(chosen_of("link.kind", "serial", &few).is_err());
        assert_eq!(chosen_of("link.kind", "direct", &few), Ok(Kind::Direct));
    }

    #[test]
    fn lists_read_as_prose() {
        assert_eq!(words::<Kind>(), "memory, direct or serial");
        assert_eq!(listed(["a", "b"]), "a or b");
        assert_eq!(listed(["a"]), "a");
        assert_eq!(listed([]), "");
    }
}
