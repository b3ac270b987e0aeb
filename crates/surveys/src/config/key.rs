//! One key: its name, what it means, what its values are and where they live.

use super::values::Values;

/// One thing that can be set.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Table and key, such as `map.resolution_m`; the unit ends it.
    pub name: &'static str,
    /// What it means.
    pub about: &'static str,
    /// What its values are.
    pub kind: KeyKind,
    pub(super) access: Access,
}

/// What the values of a key are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyKind {
    /// A number from the first to the second.
    Number(f64, f64),
    /// A whole number from the first to the second.
    Count(usize, usize),
    /// `true` or `false`.
    Flag,
    /// One of these words.
    Choice(&'static [&'static str]),
}

/// Where a value lives.
#[derive(Clone, Copy, Debug)]
pub(super) enum Access {
    Number(fn(&mut Values) -> &mut f64),
    /// Degrees in files, radians inside.
    Degrees(fn(&mut Values) -> &mut f64),
    Count(fn(&mut Values) -> &mut usize),
    Flag(fn(&mut Values) -> &mut bool),
    Choice(fn(&Values) -> usize, fn(&mut Values, usize)),
}

impl Key {
    /// What a value must be, as prose.
    pub fn requirement(&self) -> String {
        match self.kind {
            KeyKind::Number(low, high) => format!("from {low} to {high}"),
            KeyKind::Count(low, high) => format!("a whole number from {low} to {high}"),
            KeyKind::Flag => "true or false".to_owned(),
            KeyKind::Choice(words) => {
                let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                format!("one of {}", quoted.join(", "))
            }
        }
    }

    /// The table that the key stands in.
    pub fn table(&self) -> &'static str {
        self.name.rsplit_once('.').map_or("", |(table, _)| table)
    }

    /// The key without its table.
    pub fn short_name(&self) -> &'static str {
        self.name.rsplit_once('.').map_or(self.name, |(_, key)| key)
    }

    pub(super) fn read(&self, values: &Values) -> toml::Value {
        let mut copy = values.clone();
        match self.access {
            Access::Number(at) => toml::Value::Float(*at(&mut copy)),
            Access::Degrees(at) => toml::Value::Float(tidy_degrees(*at(&mut copy))),
            Access::Count(at) => toml::Value::Integer(*at(&mut copy) as i64),
            Access::Flag(at) => toml::Value::Boolean(*at(&mut copy)),
            Access::Choice(get, _) => {
                let KeyKind::Choice(words) = self.kind else { return toml::Value::Boolean(false) };
                toml::Value::String(words.get(get(values)).copied().unwrap_or_default().to_owned())
            }
        }
    }

    /// Writes a value; `None` when it is not what the key allows.
    pub(super) fn write(&self, values: &mut Values, found: &toml::Value) -> Option<()> {
        let number = found.as_float().or_else(|| found.as_integer().map(|i| i as f64));
        match (self.kind, self.access) {
            (KeyKind::Number(low, high), Access::Number(at)) => {
                *at(values) = number.filter(|v| (low..=high).contains(v))?;
            }
            (KeyKind::Number(low, high), Access::Degrees(at)) => {
                let degrees = number.filter(|v| (low..=high).contains(v))?;
                // A value that is printed and read again keeps its bits.
                if tidy_degrees(*at(values)).to_bits() != degrees.to_bits() {
                    *at(values) = degrees.to_radians();
                }
            }
            (KeyKind::Count(low, high), Access::Count(at)) => {
                let count = usize::try_from(found.as_integer()?).ok()?;
                *at(values) = Some(count).filter(|c| (low..=high).contains(c))?;
            }
            (KeyKind::Flag, Access::Flag(at)) => *at(values) = found.as_bool()?,
            (KeyKind::Choice(words), Access::Choice(_, set)) => {
                let found = found.as_str()?;
                set(values, words.iter().position(|&word| word == found)?);
            }
            _ => return None,
        }
        Some(())
    }
}

/// Degrees without the last digits of a conversion.
fn tidy_degrees(rad: f64) -> f64 {
    (rad.to_degrees() * 1e9).round() / 1e9
}

pub(crate) const fn number(
    name: &'static str,
    about: &'static str,
    range: (f64, f64),
    at: fn(&mut Values) -> &mut f64,
) -> Key {
    Key { name, about, kind: KeyKind::Number(range.0, range.1), access: Access::Number(at) }
}

pub(crate) const fn degrees(
    name: &'static str,
    about: &'static str,
    range: (f64, f64),
    at: fn(&mut Values) -> &mut f64,
) -> Key {
    Key { name, about, kind: KeyKind::Number(range.0, range.1), access: Access::Degrees(at) }
}

pub(crate) const fn count(
    name: &'static str,
    about: &'static str,
    range: (usize, usize),
    at: fn(&mut Values) -> &mut usize,
) -> Key {
    Key { name, about, kind: KeyKind::Count(range.0, range.1), access: Access::Count(at) }
}

pub(crate) const fn flag(
    name: &'static str,
    about: &'static str,
    at: fn(&mut Values) -> &mut bool,
) -> Key {
    Key { name, about, kind: KeyKind::Flag, access: Access::Flag(at) }
}

pub(crate) const fn choice(
    name: &'static str,
    about: &'static str,
    words: &'static [&'static str],
    get: fn(&Values) -> usize,
    set: fn(&mut Values, usize),
) -> Key {
    Key { name, about, kind: KeyKind::Choice(words), access: Access::Choice(get, set) }
}
