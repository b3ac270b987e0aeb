//! From what people write to a checked configuration.

use settings::Wrong;

use super::{
    SurveyConfig,
    error::ConfigError,
    key::Key,
    keys::{self, MODE},
    method::Mode,
    presets,
    values::Values,
};

impl SurveyConfig {
    /// Reads a settings file, with `overrides` of the form `table.key=value` applied in order.
    ///
    /// `origin` is what errors call the text. Keys that are absent have the defaults of the mode (`survey.mode`).
    ///
    /// # Errors
    ///
    /// [`ConfigError`]: no TOML, an unknown key, a value that is not allowed; each says where, what was found and what
    /// is allowed.
    pub fn parse(origin: &str, text: &str, overrides: &[String]) -> Result<Self, ConfigError> {
        let mut table: toml::Table = toml::from_str(text).map_err(|e| ConfigError::Syntax {
            origin: origin.to_owned(),
            message: match files::Sort::of(std::path::Path::new(origin), text.as_bytes()) {
                Some(sort) if sort != files::Sort::SETTINGS => {
                    format!("are no settings: it is {sort}")
                }
                _ => settings::told(&e, text),
            },
        })?;
        overrides.iter().try_for_each(|given| settings::apply(&mut table, given))?;
        let values = values(&table).map_err(|wrong| {
            ConfigError::Setting(Box::new(wrong.located(origin, text, overrides)))
        })?;
        Ok(Self { values })
    }

    /// This configuration with some keys changed. Keys that were not set follow a change of `survey.mode`.
    ///
    /// # Errors
    ///
    /// As [`SurveyConfig::parse`].
    pub fn with(&self, overrides: &[String]) -> Result<Self, ConfigError> {
        // What differs from the mode's own values stays; the rest follows a change of the mode.
        let own = presets::of(self.values.mode);
        let mut table = toml::Table::new();
        for key in keys::all() {
            let value = key.read(&self.values);
            if value != key.read(&own) || key.name == MODE {
                settings::apply(&mut table, &format!("{}={value}", key.name))?;
            }
        }
        overrides.iter().try_for_each(|given| settings::apply(&mut table, given))?;
        let values = values(&table).map_err(|wrong| {
            ConfigError::Setting(Box::new(wrong.located("the settings", "", overrides)))
        })?;
        Ok(Self { values })
    }
}

fn values(table: &toml::Table) -> Result<Values, Wrong> {
    let mut values = presets::of(mode(table)?);
    fill(&mut values, table)?;
    Ok(values)
}

/// The mode is read before everything else: it says what the other keys are by default.
fn mode(table: &toml::Table) -> Result<Mode, Wrong> {
    let found = table.get("survey").and_then(|survey| survey.get("mode"));
    let (Some(found), Some(key)) = (found, keys::all().find(|key| key.name == MODE)) else {
        return Ok(Mode::default());
    };
    let mut probe = Values::default();
    written(key, &mut probe, found)?;
    Ok(probe.mode)
}

fn fill(values: &mut Values, table: &toml::Table) -> Result<(), Wrong> {
    for (name, value) in leaves("", table) {
        match keys::all().find(|key| key.name == name) {
            Some(key) => written(key, values, value)?,
            None => return Err(unknown(&name, value)),
        }
    }
    Ok(())
}

fn written(key: &Key, values: &mut Values, found: &toml::Value) -> Result<(), Wrong> {
    key.write(values, found)
        .ok_or_else(|| Wrong::prose(key.name, found.to_string(), key.requirement()))
}

/// Every value with its dotted name; an array counts as a value.
fn leaves<'t>(prefix: &str, table: &'t toml::Table) -> Vec<(String, &'t toml::Value)> {
    let mut found = Vec::new();
    for (name, value) in table {
        let name = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        match value {
            toml::Value::Table(inner) => found.extend(leaves(&name, inner)),
            _ => found.push((name, value)),
        }
    }
    found
}

fn unknown(name: &str, found: &toml::Value) -> Wrong {
    let short = name.rsplit('.').next().unwrap_or(name);
    let same_name = keys::all().find(|key| key.short_name() == short);
    let nearest = same_name.or_else(|| keys::all().min_by_key(|key| distance(key.name, name)));
    let hint = nearest.map(|key| format!("; did you mean {}?", key.name)).unwrap_or_default();
    let allowed = format!("a key that exists (`cairn map --keys` lists them){hint}");
    Wrong::prose(name, found.to_string(), allowed)
}

/// How many letters must be changed, added or left out to make one word of another (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &other) in b.iter().enumerate() {
            let changed = diagonal + usize::from(letter != other);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    fn refused(text: &str, overrides: &[&str]) -> String {
        let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
        SurveyConfig::parse("a.toml", text, &overrides).unwrap_err().to_string()
    }

    #[test]
    fn the_whole_configuration_is_printed_and_read_back() {
        for mode in ["default", "thesis", "listing"] {
            let set = [format!("survey.mode={mode}")];
            let config = SurveyConfig::default().with(&set).unwrap();
            let again = SurveyConfig::parse("again", &config.to_toml(), &[]).unwrap();
            assert_eq!(again, config, "{mode}");
        }
        let template = SurveyConfig::template();
        let read = SurveyConfig::parse("template", &template, &[]).unwrap();
        assert_eq!(read, SurveyConfig::default());
        let n_described = template.lines().filter(|line| line.contains(" # ")).count();
        assert_eq!(n_described, SurveyConfig::keys().count(), "every key is described");
    }

    #[test]
    fn names_of_keys_are_unique_and_defaults_allowed() {
        let names: Vec<&str> = SurveyConfig::keys().map(|key| key.name).collect();
        let mut unique = names.clone();
        unique.sort_unstable();
        unique.dedup();
        assert_eq!(unique.len(), names.len());
        for key in SurveyConfig::keys() {
            let mut values = Values::default();
            let own = key.read(&values);
            assert!(key.write(&mut values, &own).is_some(), "{} = {own} is refused", key.name);
            assert_eq!(values, Values::default(), "{}", key.name);
        }
    }

    /// A key that changed another one's value, or none, would go unnoticed otherwise.
    #[test]
    fn every_key_changes_its_own_value_only() {
        let before = SurveyConfig::default();
        for key in SurveyConfig::keys().filter(|key| key.name != MODE) {
            let own = key.read(before.values());
            let other = match key.kind {
                super::super::key::KeyKind::Number(low, high) => {
                    let value = own.as_float().unwrap();
                    toml::Value::Float(if value > low { low } else { high })
                }
                super::super::key::KeyKind::Count(low, high) => {
                    let low = i64::try_from(low).unwrap();
                    let is_low = own.as_integer() == Some(low);
                    toml::Value::Integer(if is_low { i64::try_from(high).unwrap() } else { low })
                }
                super::super::key::KeyKind::Flag => toml::Value::Boolean(!own.as_bool().unwrap()),
                super::super::key::KeyKind::Choice(words) => {
                    let word = words.iter().find(|&&word| own.as_str() != Some(word)).unwrap();
                    toml::Value::String((*word).to_owned())
                }
            };
            let after = before.with(&[format!("{}={other}", key.name)]).unwrap();
            for looked_at in SurveyConfig::keys() {
                let changed = looked_at.read(before.values()) != looked_at.read(after.values());
                assert_eq!(
                    changed,
                    looked_at.name == key.name,
                    "{} by {}",
                    looked_at.name,
                    key.name
                );
            }
        }
    }

    #[test]
    fn degrees_in_files_are_radians_inside() {
        let sets = ["laser.loops.window_max_deg=90".to_owned(), "map.hit_logodds=1".to_owned()];
        let config = SurveyConfig::default().with(&sets).unwrap();
        let inside = config.values().laser.loops.window_max_rad;
        assert!((inside - std::f64::consts::FRAC_PI_2).abs() < 1e-12, "{inside}");
        assert_eq!(config.get("laser.loops.window_max_deg").as_deref(), Some("90.0"));
        assert_eq!(config.get("map.hit_logodds").as_deref(), Some("1.0"), "a whole number will do");
        assert_eq!(config.get("no.such_key"), None);
    }

    #[test]
    fn what_cannot_be_used_is_said_with_its_place() {
        expect!["a.toml:2:16: map.resolution_m = 7.5: must be from 0.005 to 1"]
            .assert_eq(&refused("[map]\nresolution_m = 7.5\n", &[]));
        expect!["a.toml:2:1: map.resolutoin_m = 0.1: must be a key that exists (`cairn map --keys` lists them); did you mean map.resolution_m?"]
            .assert_eq(&refused("[map]\nresolutoin_m = 0.1\n", &[]).replace("2:16", "2:1"));
        expect![[r#"--set survey.method=radar: survey.method = "radar": must be one of "auto", "laser", "sonar", "odometry""#]]
            .assert_eq(&refused("", &["survey.method=radar"]));
        expect!["--set laser.loops.candidates_max=2.5: laser.loops.candidates_max = 2.5: must be a whole number from 0 to 50"]
            .assert_eq(&refused("", &["laser.loops.candidates_max=2.5"]));
        expect!["--set map.resolution_m=nan: map.resolution_m = nan: must be from 0.005 to 1"]
            .assert_eq(&refused("", &["map.resolution_m=nan"]));
        expect!["--set resolution_m: must look like table.key=value, with an equals sign"]
            .assert_eq(&refused("", &["resolution_m"]));
        assert!(refused("[map\n", &[]).contains("line 1"));
    }

    #[test]
    fn a_mode_sets_its_table_and_single_keys_stay_above_it() {
        let sets = ["map.resolution_m=0.1".to_owned()];
        let config = SurveyConfig::default().with(&sets).unwrap();
        let thesis = config.with(&["survey.mode=thesis".to_owned()]).unwrap();
        assert_eq!((thesis.mode(), thesis.map().resolution_m), (Mode::Thesis, 0.1));
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
    }
}
