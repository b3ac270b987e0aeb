//! What is varied, over which values, and what counts as better.

use rand_core::Rng as _;
use run_context::RunSeed;
use serde::Deserialize;

use crate::config::{ConfigError, SurveyConfig};

/// Settings of a grid at most; more would never end.
const SETTINGS_MAX: usize = 1_000_000;
/// Values of one key at most.
const VALUES_MAX: usize = 10_000;

/// A plan that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{origin}: {problem}")]
pub struct PlanError {
    /// The file.
    pub origin: String,
    /// What is wrong and what is allowed.
    pub problem: String,
}

/// One combination: keys of the configuration with the values that they get.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting(pub Vec<(String, toml::Value)>);

impl Setting {
    /// The combination as overrides, `key=value`.
    pub fn overrides(&self) -> Vec<String> {
        self.0.iter().map(|(key, value)| format!("{key}={value}")).collect()
    }

    /// The values as one text; equal for equal settings only.
    pub(crate) fn name(&self) -> String {
        self.overrides().join(" ")
    }
}

/// What makes one setting better than another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Goal {
    /// Less of this figure is better.
    Minimise(String),
    /// More of this figure is better.
    Maximise(String),
}

impl Goal {
    /// The figure.
    pub fn figure(&self) -> &str {
        match self {
            Self::Minimise(figure) | Self::Maximise(figure) => figure,
        }
    }

    /// The figure turned so that less is better.
    pub(crate) fn cost(&self, value: f64) -> f64 {
        match self {
            Self::Minimise(_) => value,
            Self::Maximise(_) => -value,
        }
    }
}

/// A checked plan.
///
/// ```
/// let plan = surveys::SweepPlan::parse("plan.toml", r#"
///     minimise = "entropy_bits"
///     [[keys]]
///     key = "map.resolution_m"
///     values = [0.03, 0.05]
///     [[keys]]
///     key = "laser.loops.radius_m"
///     from = 2.0
///     to = 8.0
///     steps = 3
///     scale = "log"
/// "#)?;
/// assert_eq!(plan.settings().len(), 6);
/// # Ok::<(), surveys::PlanError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPlan {
    goal: Goal,
    sampling: Sampling,
    rounds_max: usize,
    keys: Vec<KeyPlan>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Sampling {
    Grid,
    Random { n_samples: usize, seed: RunSeed },
}

#[derive(Clone, Debug, PartialEq)]
struct KeyPlan {
    key: String,
    range: Range,
}

#[derive(Clone, Debug, PartialEq)]
enum Range {
    Values(Vec<toml::Value>),
    Between { from: f64, to: f64, steps: usize, log: bool, whole: bool },
}

/// What people write.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanFile {
    minimise: Option<String>,
    maximise: Option<String>,
    #[serde(default)]
    sampling: SamplingFile,
    samples: Option<usize>,
    #[serde(default = "one")]
    seed: u64,
    #[serde(default = "five")]
    rounds: usize,
    keys: Vec<KeyFile>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum SamplingFile {
    #[default]
    Grid,
    Random,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyFile {
    key: String,
    values: Option<Vec<toml::Value>>,
    from: Option<toml::Value>,
    to: Option<toml::Value>,
    steps: Option<usize>,
    #[serde(default)]
    scale: ScaleFile,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum ScaleFile {
    #[default]
    Linear,
    Log,
}

fn one() -> u64 {
    1
}

fn five() -> usize {
    5
}

impl SweepPlan {
    /// Reads a plan; `origin` is what errors call it.
    ///
    /// # Errors
    ///
    /// [`PlanError`] for text that is not TOML, an unknown key, a range without an end, no goal or two.
    pub fn parse(origin: &str, text: &str) -> Result<Self, PlanError> {
        let wrong = |problem: String| PlanError { origin: origin.to_owned(), problem };
        let file: PlanFile = toml::from_str(text).map_err(|e| {
            wrong(match files::Sort::of(std::path::Path::new(origin), text.as_bytes()) {
                Some(sort) => format!("is no plan: it is {sort}"),
                None => settings::told(&e, text),
            })
        })?;
        let goal = match (file.minimise, file.maximise) {
            (Some(figure), None) => Goal::Minimise(figure),
            (None, Some(figure)) => Goal::Maximise(figure),
            _ => return Err(wrong("must have one of `minimise` and `maximise`".into())),
        };
        let sampling = match (file.sampling, file.samples) {
            (SamplingFile::Grid, None) => Sampling::Grid,
            (SamplingFile::Random, Some(n @ 1..=SETTINGS_MAX)) => {
                Sampling::Random { n_samples: n, seed: RunSeed(file.seed) }
            }
            (SamplingFile::Grid, Some(_)) => {
                return Err(wrong("`samples` needs `sampling = \"random\"`".into()));
            }
            (SamplingFile::Random, _) => {
                let needed = format!("random sampling needs `samples`, from 1 to {SETTINGS_MAX}");
                return Err(wrong(needed));
            }
        };
        if file.keys.is_empty() {
            return Err(wrong("must have at least one [[keys]]".into()));
        }
        let keys = file.keys.into_iter().map(KeyPlan::of).collect::<Result<Vec<_>, _>>();
        let keys = keys.map_err(wrong)?;
        let doubled = |(i, k): (usize, &KeyPlan)| keys[..i].iter().any(|other| other.key == k.key);
        if let Some((_, twice)) = keys.iter().enumerate().find(|&pair| doubled(pair)) {
            return Err(wrong(format!("`{}` is varied twice", twice.key)));
        }
        let plan = Self { goal, sampling, rounds_max: file.rounds.clamp(1, 1000), keys };
        if plan.n_settings().is_none_or(|n| n > SETTINGS_MAX) {
            let many = format!("has more than {SETTINGS_MAX} combinations; sample them at random");
            return Err(wrong(many));
        }
        Ok(plan)
    }

    /// What makes a setting better.
    pub fn goal(&self) -> &Goal {
        &self.goal
    }

    /// The names of the keys that are varied, in the order of the file.
    pub fn keys(&self) -> Vec<&str> {
        self.keys.iter().map(|k| k.key.as_str()).collect()
    }

    /// All settings of the sweep in their order: the last key of the file changes fastest.
    pub fn settings(&self) -> Vec<Setting> {
        match self.sampling {
            Sampling::Grid => self.grid(),
            Sampling::Random { n_samples, seed } => self.random(n_samples, seed),
        }
    }

    /// Refuses keys and values that `config` does not allow, before the long work.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] of the first such value.
    pub fn check(&self, config: &SurveyConfig) -> Result<(), ConfigError> {
        for (key, values) in self.values() {
            for value in values {
                config.with(&[format!("{key}={value}")])?;
            }
        }
        Ok(())
    }

    /// Rounds of tuning at most.
    pub(crate) fn rounds_max(&self) -> usize {
        self.rounds_max
    }

    /// The values of each key, in order.
    pub(crate) fn values(&self) -> Vec<(String, Vec<toml::Value>)> {
        self.keys.iter().map(|k| (k.key.clone(), k.range.values())).collect()
    }

    fn n_settings(&self) -> Option<usize> {
        match self.sampling {
            Sampling::Random { n_samples, .. } => Some(n_samples),
            Sampling::Grid => {
                self.keys.iter().try_fold(1_usize, |n, key| n.checked_mul(key.range.n_values()))
            }
        }
    }

    fn grid(&self) -> Vec<Setting> {
        let mut settings = vec![Setting(Vec::new())];
        for (key, values) in self.values() {
            let with = |setting: &Setting, value: &toml::Value| {
                let mut longer = setting.clone();
                longer.0.push((key.clone(), value.clone()));
                longer
            };
            settings =
                settings.iter().flat_map(|s| values.iter().map(move |v| with(s, v))).collect();
        }
        settings
    }

    fn random(&self, n_samples: usize, seed: RunSeed) -> Vec<Setting> {
        let mut settings = vec![Setting(Vec::new()); n_samples];
        for KeyPlan { key, range } in &self.keys {
            let mut stream = seed.stream(&format!("sweep/{key}"));
            for setting in &mut settings {
                // 53 random bits fill a double's mantissa: from 0 to 1 - 2⁻⁵³, evenly.
                let part = (stream.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
                setting.0.push((key.clone(), range.at(part)));
            }
        }
        settings
    }
}

impl KeyPlan {
    fn of(file: KeyFile) -> Result<Self, String> {
        let KeyFile { key, values, from, to, steps, scale } = file;
        let range = match (values, from, to) {
            (Some(values), None, None) if (1..=VALUES_MAX).contains(&values.len()) => {
                if steps.is_some() || scale != ScaleFile::Linear {
                    return Err(format!("`{key}`: `steps` and `scale` need `from` and `to`"));
                }
                Range::Values(values)
            }
            (None, Some(from), Some(to)) => between(&key, &from, &to, steps, scale)?,
            _ => return Err(format!("`{key}` needs either `values` or `from` and `to`")),
        };
        Ok(Self { key, range })
    }
}

fn between(
    key: &str,
    from: &toml::Value,
    to: &toml::Value,
    steps: Option<usize>,
    scale: ScaleFile,
) -> Result<Range, String> {
    let number = |v: &toml::Value| v.as_float().or_else(|| v.as_integer().map(|i| i as f64));
    let (Some(low), Some(high)) = (number(from), number(to)) else {
        return Err(format!("`{key}`: `from` and `to` must be numbers"));
    };
    if !(low < high && low.is_finite() && high.is_finite()) {
        return Err(format!("`{key}`: `from` must be less than `to`, and both finite"));
    }
    let log = scale == ScaleFile::Log;
    if log && low <= 0.0 {
        return Err(format!("`{key}`: a logarithmic scale needs `from` above 0"));
    }
    let steps = steps.unwrap_or(5);
    if !(2..=VALUES_MAX).contains(&steps) {
        return Err(format!("`{key}`: `steps` must be from 2 to {VALUES_MAX}"));
    }
    let whole = from.is_integer() && to.is_integer();
    Ok(Range::Between { from: low, to: high, steps, log, whole })
}

impl Range {
    fn n_values(&self) -> usize {
        match self {
            Self::Values(values) => values.len(),
            Self::Between { steps, .. } => *steps,
        }
    }

    /// Every value of a grid; of whole numbers that come out equal only the first.
    fn values(&self) -> Vec<toml::Value> {
        match self {
            Self::Values(values) => values.clone(),
            Self::Between { steps, .. } => {
                let last = (steps - 1) as f64;
                let mut values: Vec<_> = (0..*steps).map(|i| self.at(i as f64 / last)).collect();
                values.dedup();
                values
            }
        }
    }

    /// The value at a part (0 to 1) of the range.
    fn at(&self, part: f64) -> toml::Value {
        match self {
            Self::Values(values) => {
                let index = (part * values.len() as f64) as usize;
                values[index.min(values.len() - 1)].clone()
            }
            Self::Between { from, to, log, whole, .. } => {
                let value = if *log {
                    (from.ln() + part * (to.ln() - from.ln())).exp()
                } else {
                    from + part * (to - from)
                };
                // Six digits are more than any setting needs, and are read back as they are printed.
                let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
                let kept = rounded.clamp(*from, *to);
                if *whole {
                    toml::Value::Integer(kept.round() as i64)
                } else {
                    toml::Value::Float(kept)
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    fn names(text: &str) -> Vec<String> {
        SweepPlan::parse("plan.toml", text).unwrap().settings().iter().map(Setting::name).collect()
    }

    fn problem(text: &str) -> String {
        SweepPlan::parse("plan.toml", text).unwrap_err().to_string()
    }

    #[test]
    fn a_grid_has_every_combination_in_order() {
        let text = "minimise = \"e\"\n\
            [[keys]]\nkey = \"a.x\"\nvalues = [1, 2]\n\
            [[keys]]\nkey = \"b\"\nfrom = 0.01\nto = 1.0\nsteps = 3\nscale = \"log\"\n";
        assert_eq!(
            names(text),
            [
                "a.x=1 b=0.01",
                "a.x=1 b=0.1",
                "a.x=1 b=1.0",
                "a.x=2 b=0.01",
                "a.x=2 b=0.1",
                "a.x=2 b=1.0"
            ]
        );
        let words = "maximise = \"e\"\n[[keys]]\nkey = \"m\"\nvalues = [\"default\", \"thesis\"]\n";
        assert_eq!(names(words), ["m=\"default\"", "m=\"thesis\""]);
        let whole = "maximise = \"e\"\n[[keys]]\nkey = \"n\"\nfrom = 1\nto = 3\n";
        assert_eq!(names(whole), ["n=1", "n=2", "n=3"], "doubles are left out");
    }

    #[test]
    fn random_samples_fill_their_ranges_and_follow_the_seed() {
        let text = |seed, rest| {
            format!(
                "minimise = \"e\"\nsampling = \"random\"\nsamples = 400\nseed = {seed}\n\
                 [[keys]]\nkey = \"a\"\nfrom = -1.0\nto = 3.0\n\
                 [[keys]]\nkey = \"b\"\nvalues = [1, 2, 3]\n{rest}"
            )
        };
        let plan = SweepPlan::parse("p", &text(1, "")).unwrap();
        let settings = plan.settings();
        let a: Vec<f64> = settings.iter().map(|s| s.0[0].1.as_float().unwrap()).collect();
        assert!(a.iter().all(|v| (-1.0..=3.0).contains(v)));
        // The mean of 400 even samples over 4 m has a standard deviation of 4/√12/20 = 0.058.
        assert!((a.iter().sum::<f64>() / 400.0 - 1.0).abs() < 0.3);
        for value in 1..=3 {
            let n = settings.iter().filter(|s| s.0[1].1.as_integer() == Some(value)).count();
            assert!((90..=180).contains(&n), "{value} came {n} times");
        }
        assert_eq!(settings, plan.settings());
        assert_ne!(settings, SweepPlan::parse("p", &text(2, "")).unwrap().settings());
        let more = "[[keys]]\nkey = \"c\"\nvalues = [1]\n";
        let longer = SweepPlan::parse("p", &text(1, more)).unwrap().settings();
        let same = settings.iter().zip(&longer).all(|(s, l)| s.0[..] == l.0[..2]);
        assert!(same, "a key more disturbs the others");
    }

    #[test]
    fn what_cannot_be_planned_is_explained() {
        expect!["p: must have one of `minimise` and `maximise`"]
            .assert_eq(&SweepPlan::parse("p", "keys = []").unwrap_err().to_string());
        let key = |rest: &str| problem(&format!("minimise = \"e\"\n[[keys]]\nkey = \"a\"\n{rest}"));
        expect!["plan.toml: `a` needs either `values` or `from` and `to`"].assert_eq(&key(""));
        expect!["plan.toml: `a` needs either `values` or `from` and `to`"]
            .assert_eq(&key("values = []"));
        expect!["plan.toml: `a`: `from` must be less than `to`, and both finite"]
            .assert_eq(&key("from = 2\nto = 1"));
        expect!["plan.toml: `a`: a logarithmic scale needs `from` above 0"]
            .assert_eq(&key("from = 0\nto = 1\nscale = \"log\""));
        expect!["plan.toml: `a`: `steps` must be from 2 to 10000"]
            .assert_eq(&key("from = 0\nto = 1\nsteps = 1"));
        expect!["plan.toml: `a` is varied twice"]
            .assert_eq(&key("values = [1]\n[[keys]]\nkey = \"a\"\nvalues = [2]"));
        let many = "values = [1,2,3,4,5,6,7,8,9,10]\n";
        let key = |i: i32| format!("[[keys]]\nkey = \"k{i}\"\n{many}");
        let keys = (0..7).map(key).collect::<Vec<_>>().concat();
        expect!["plan.toml: has more than 1000000 combinations; sample them at random"]
            .assert_eq(&problem(&format!("minimise = \"e\"\n{keys}")));
        expect!["plan.toml: `samples` needs `sampling = \"random\"`"].assert_eq(&problem(
            "minimise = \"e\"\nsamples = 3\n[[keys]]\nkey = \"a\"\nvalues = [1]",
        ));
        assert!(problem("minimise = \"e\"\nfoo = 1\nkeys = []").contains("line 2"));
    }
}
