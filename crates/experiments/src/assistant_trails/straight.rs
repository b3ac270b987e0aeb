//! The straight trail: where runs begin, and the ideal loop on it.

use geometry::Se2;
use missions::{Mission, MissionError};
use run_context::{RandomStream, RunSeed};

use super::{ideal, setting::Setting};
use crate::{ExperimentError, Options, batch::uniform, statistics::median};

/// Where a run begins: x (m) within the trail's first 40 mm, and yaw (degrees), 45° to either side. Elsewhere in
/// the cell the scout's way begins farther away, and the navigator turns in place to get there, which the
/// thesis's robot does not.
fn straight_start(rng: &mut RandomStream) -> (f64, f64) {
    let sign = if uniform(rng, -1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
    (uniform(rng, 0.0, 0.04), 45.0 * sign)
}

pub(super) fn straight_mission(
    setting: Setting,
    rng: &mut RandomStream,
) -> Result<Mission, MissionError> {
    let (x_m, yaw_deg) = straight_start(rng);
    let mut overrides = setting.overrides();
    overrides.push(format!("robots.start=[{x_m}, 0.0, {yaw_deg}]"));
    Mission::load("trail-45deg", &overrides)
}

/// Settled distances (mm, median over the starts of all runs) of an ideal loop, whose wheels turn at once
/// as asked, by setting; `None` where most lose the trail.
pub(super) fn ideal_medians(
    settings: &[Setting],
    options: &Options,
) -> Result<Vec<Option<f64>>, ExperimentError> {
    let of = |setting: &Setting| {
        let mut kept = Vec::new();
        for run in 0..options.n_runs {
            let seed = RunSeed(options.seed.0.wrapping_add(u64::from(run)));
            let (x_m, yaw_deg) = straight_start(&mut seed.stream("experiment/situation"));
            let start = Se2::new(x_m, 0.0, yaw_deg.to_radians());
            kept.extend(ideal::settled_rms_mm(*setting, start)?);
        }
        let most = 2 * kept.len() > options.n_runs as usize;
        Ok(median(&kept).filter(|_| most))
    };
    settings.iter().map(of).collect()
}
