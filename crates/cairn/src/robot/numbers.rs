//! Numbers with commas between them, as options have them.

use anyhow::bail;
use geometry::Se2;

/// `X,Y,DEG` of an option.
pub(super) fn parse_pose(option: &str, text: &str) -> anyhow::Result<Se2> {
    let allowed = "three numbers, such as -2.6,-3.1,90 (m, m, degrees)";
    let [x_m, y_m, heading_deg] = numbers(option, text, allowed)?;
    Ok(Se2::new(x_m, y_m, heading_deg.to_radians()))
}

/// So many finite numbers with commas between them.
pub(super) fn numbers<const N: usize>(
    option: &str,
    text: &str,
    allowed: &str,
) -> anyhow::Result<[f64; N]> {
    let parts = text.split(',').map(|n| n.trim().parse::<f64>());
    let numbers = parts.collect::<Result<Vec<f64>, _>>().unwrap_or_default();
    match <[f64; N]>::try_from(numbers) {
        Ok(numbers) if numbers.iter().all(|n| n.is_finite()) => Ok(numbers),
        _ => bail!("{option} {text}: give {allowed}"),
    }
}
