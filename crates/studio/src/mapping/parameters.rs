//! The parameters of a survey for the page's form: their defaults, what they mean, and which of them are set.

use std::collections::BTreeMap;

use surveys::{KeyKind, SurveyConfig};

use super::protocol::Parameter;

/// The key that says which form of a method is meant; it changes the defaults of the others.
const MODE_KEY: &str = "survey.mode";

/// Every parameter of a survey with its default.
pub(crate) fn parameters() -> Vec<Parameter> {
    let defaults = SurveyConfig::default();
    let modes: Vec<(&'static str, SurveyConfig)> = modes().filter_map(of_mode).collect();
    let parameter = |key: &'static surveys::Key| Parameter {
        key: key.name,
        table: key.table(),
        name: key.short_name(),
        about: key.about,
        kind: match key.kind {
            KeyKind::Number(..) => "number",
            KeyKind::Count(..) => "count",
            KeyKind::Flag => "flag",
            KeyKind::Choice(_) => "choice",
        },
        allowed: key.requirement(),
        default: defaults.get(key.name).unwrap_or_default(),
        by_mode: {
            let default = defaults.get(key.name);
            let of_mode =
                modes.iter().filter_map(|(mode, config)| Some((*mode, config.get(key.name)?)));
            of_mode
                .filter(|(_, value)| key.name != MODE_KEY && Some(value) != default.as_ref())
                .collect()
        },
        choices: if let KeyKind::Choice(words) = key.kind { words.to_vec() } else { Vec::new() },
    };
    SurveyConfig::keys().map(parameter).collect()
}

/// The names of the modes.
fn modes() -> impl Iterator<Item = &'static str> {
    let key = SurveyConfig::keys().find(|key| key.name == MODE_KEY);
    let words: &'static [&'static str] = match key.map(|key| key.kind) {
        Some(KeyKind::Choice(words)) => words,
        _ => &[],
    };
    words.iter().copied()
}

/// A mode as it is by default.
fn of_mode(mode: &'static str) -> Option<(&'static str, SurveyConfig)> {
    let config = SurveyConfig::default().with(&[format!("{MODE_KEY}={mode}")]);
    config.ok().map(|config| (mode, config))
}

/// The keys that must be set to get `config` from the defaults.
pub(crate) fn values_of(config: &SurveyConfig) -> BTreeMap<String, String> {
    let default = SurveyConfig::default();
    let mode = config.get(MODE_KEY);
    let of_mode = modes().filter_map(of_mode).find(|(name, _)| Some(*name) == mode.as_deref());
    let of_mode = of_mode.map_or_else(SurveyConfig::default, |(_, config)| config);
    let is_set = |key: &str, value: &str| {
        let by_default = if key == MODE_KEY { &default } else { &of_mode };
        by_default.get(key).as_deref() != Some(value)
    };
    let values = SurveyConfig::keys().filter_map(|key| Some((key.name, config.get(key.name)?)));
    values
        .filter(|(key, value)| is_set(key, value))
        .map(|(key, value)| (key.to_owned(), value))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(values: &BTreeMap<String, String>) -> SurveyConfig {
        let set: Vec<String> = values.iter().map(|(key, value)| format!("{key}={value}")).collect();
        SurveyConfig::default().with(&set).unwrap()
    }

    #[test]
    fn the_values_that_are_set_make_the_same_configuration_again() {
        assert_eq!(values_of(&SurveyConfig::default()), BTreeMap::new());
        let set = ["map.resolution_m=0.1", "survey.mode=thesis"].map(str::to_owned);
        let config = SurveyConfig::default().with(&set).unwrap();
        let values = values_of(&config);
        assert_eq!(values.keys().collect::<Vec<_>>(), ["map.resolution_m", "survey.mode"]);
        assert_eq!(with(&values), config);
    }

    #[test]
    fn every_parameter_has_a_meaning_and_a_default_that_is_allowed() {
        let parameters = parameters();
        assert!(parameters.len() > 20);
        for p in &parameters {
            assert!(!p.about.is_empty() && !p.default.is_empty() && !p.allowed.is_empty(), "{p:?}");
            assert_eq!(p.key, format!("{}.{}", p.table, p.name));
            assert_eq!(p.kind == "choice", !p.choices.is_empty());
            let default = BTreeMap::from([(p.key.to_owned(), p.default.clone())]);
            assert_eq!(with(&default), SurveyConfig::default(), "{p:?}");
        }
        assert!(parameters.iter().any(|p| !p.by_mode.is_empty()), "modes differ");
    }
}
