//! Values on the command line: what is wrong with one is said with what it must be.

use std::net::SocketAddr;

/// A seed.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_unusable| format!("must be a whole number from 0 to {}", u64::MAX))
}

/// How fast the studio runs.
pub(crate) fn speed(text: &str) -> Result<f64, String> {
    within(text, 0.1, 20.0, "a number from 0.1 to 20")
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
        assert!(address("127.0.0.1:8101").is_ok() && address("[::1]:1").is_ok());
        assert!(address("127.0.0.1:99999").unwrap_err().contains("127.0.0.1:8101"));
    }
}
