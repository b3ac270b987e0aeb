//! Values on the command line: what is wrong with one is said with what it must be.

use std::{net::SocketAddr, num::NonZeroU16};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use robot_models::RobotModel;
use settings::Choice;

/// A seed.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_unusable| format!("must be a whole number from 0 to {}", u64::MAX))
}

/// One of the words of a list; `also` are other words for some, which the help does not show.
pub(crate) fn choice<C: Choice + Send + Sync>(
    also: &'static [(&'static str, &'static str)],
) -> impl TypedValueParser<Value = C> {
    let value = |choice: &C| {
        let key = choice.key();
        let aliases = also.iter().filter(move |(_, of)| *of == key).map(|(alias, _)| *alias);
        PossibleValue::new(key).help(choice.about()).aliases(aliases)
    };
    let key_of = move |word: String| {
        also.iter().find(|(alias, _)| *alias == word).map_or(word, |(_, key)| (*key).to_owned())
    };
    PossibleValuesParser::new(C::ALL.iter().map(value)).try_map(move |word| {
        let key = key_of(word);
        C::ALL.iter().copied().find(|choice| choice.key() == key).ok_or("no word of the list")
    })
}

/// How fast the studio runs.
pub(crate) fn speed(text: &str) -> Result<f64, String> {
    within(text, 0.1, 20.0, "a number from 0.1 to 20")
}

/// Charge of a battery.
pub(crate) fn percent(text: &str) -> Result<f64, String> {
    within(text, 0.0, 100.0, "a number from 0 to 100")
}

/// How much faster than a real one a battery drains.
pub(crate) fn drain_ratio(text: &str) -> Result<f64, String> {
    within(text, 0.0, 1e6, "a number from 0 to 1000000")
}

/// How many robots are served.
pub(crate) fn n_robots(text: &str) -> Result<NonZeroU16, String> {
    let number = text.parse().ok().filter(|n: &NonZeroU16| n.get() <= 64);
    number.ok_or_else(|| "must be a whole number from 1 to 64".to_owned())
}

/// The robots whose bytes are simulated.
fn served_models() -> Vec<String> {
    let models = RobotModel::catalogue().into_iter().filter(virtual_robots::has_board);
    models.map(|model| model.name).collect()
}

/// The robots whose bytes are simulated, as prose.
pub(crate) fn served() -> String {
    listed(&served_models(), "and")
}

/// What the help says of a robot's name.
pub(crate) fn model_help() -> String {
    format!("Which robot: {}", listed(&served_models(), "or"))
}

/// The name of a robot that is in the catalogue.
pub(crate) fn model(text: &str) -> Result<String, String> {
    if RobotModel::by_name(text).is_ok() {
        return Ok(text.to_owned());
    }
    let names = served_models();
    let hint = settings::did_you_mean(text, names.iter().map(String::as_str))
        .map(|name| format!("; did you mean {name}?"));
    Err(format!("there are {}{}", self::served(), hint.unwrap_or_default()))
}

/// `a, b and c`.
pub(crate) fn listed(names: &[String], before_last: &str) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} {before_last} {last}", first.join(", ")),
    }
}

/// A length of the pheromone model.
pub(crate) fn length_m(text: &str) -> Result<f64, String> {
    within(text, 0.01, 100.0, "a number of metres from 0.01 to 100")
}

/// Where to listen.
pub(crate) fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_unusable| {
        "must be an address and a port, such as 127.0.0.1:8101, or 0.0.0.0:8101 for other computers"
            .to_owned()
    })
}

fn within(text: &str, least: f64, most: f64, allowed: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (least..=most).contains(value));
    value.ok_or_else(|| format!("must be {allowed}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_taken_up_to_their_limits_and_refused_beyond() {
        assert_eq!(seed("0"), Ok(0));
        assert_eq!(seed("18446744073709551615"), Ok(u64::MAX));
        assert!(seed("18446744073709551616").is_err() && seed("-1").is_err() && seed("x").is_err());
        assert_eq!((speed("0.1"), speed("20")), (Ok(0.1), Ok(20.0)));
        assert!(speed("0.09").is_err() && speed("20.1").is_err() && speed("NaN").is_err());
        assert_eq!(length_m("0.2"), Ok(0.2));
        assert!(length_m("-0.2").unwrap_err().contains("0.01 to 100"));
        assert_eq!((percent("0"), percent("100")), (Ok(0.0), Ok(100.0)));
        assert!(percent("-1").is_err() && percent("100.1").is_err());
        assert!(n_robots("0").is_err() && n_robots("65").is_err() && n_robots("64").is_ok());
        assert!(address("127.0.0.1:8101").is_ok() && address("[::1]:1").is_ok());
        assert!(address("127.0.0.1:99999").unwrap_err().contains("127.0.0.1:8101"));
    }

    #[test]
    fn a_robot_that_is_nearly_spelled_right_is_offered() {
        assert_eq!(model("peoplebot").as_deref(), Ok("peoplebot"));
        for (typed, meant) in [
            ("pioner3dx", "pioneer3dx"),
            ("Pioneer-3DX", "pioneer3dx"),
            ("peoplbot", "peoplebot"),
            ("creat2", "create2"),
        ] {
            let error = model(typed).unwrap_err();
            assert!(error.ends_with(&format!("did you mean {meant}?")), "{error}");
        }
        assert_eq!(model("nosuch").unwrap_err(), "there are pioneer3dx, peoplebot and create2");
    }
}
