//! The same law and trail with an ideal robot: its wheels turn at once as asked, and nothing is delayed.
//!
//! What is left is what the law itself makes of the trail; the closed loop's difference from it is the drive
//! and the links.

use std::time::Duration;

use geometry::{Se2, Twist, Vec2};
use path_following::{
    SettingError, TrailFollower, TrailFollowerConfig, TrailLaw, TrailSense,
    fuzzy::{FuzzyConfig, Sets},
};
use pheromones::{Field, FieldError, SenseConfig};

use super::setting::{LOST_M, SETTLED_M, Setting};
use crate::ExperimentError;

/// Pieces into which a control period is divided to record the way.
const N_PIECES: u32 = 10;
/// As the mission `trail-45deg` has it.
const CELL_M: f64 = 0.2;
const GOAL_X_M: f64 = 7.6;
const TIME_MAX_S: f64 = 60.0;
/// As the navigator bounds the wheels, times the cruising speed.
const WHEEL_SPEED_MAX_RATIO: f64 = 1.6;

/// The trail of the mission `trail-45deg`.
fn field() -> Result<Field, FieldError> {
    let mut field = Field::new(101, 31, CELL_M)?;
    field.draw_trail(&[Vec2::new(0.0, 0.0), Vec2::new(8.0, 0.0)], 1);
    Ok(field)
}

/// Root mean square distance from the trail once settled, mm, of an ideal robot that starts at `start`;
/// `None` when it loses the trail.
pub(super) fn settled_rms_mm(setting: Setting, start: Se2) -> Result<Option<f64>, ExperimentError> {
    let field = field().map_err(|e| ExperimentError::Ideal(e.to_string()))?;
    let way = drive(setting, start, &field).map_err(|e| ExperimentError::Ideal(e.to_string()))?;
    let kept = way.iter().all(|p| p.y.abs() <= LOST_M) && way.iter().any(|p| p.x >= SETTLED_M.end);
    let settled: Vec<f64> =
        way.iter().filter(|p| SETTLED_M.contains(&p.x)).map(|p| p.y * p.y).collect();
    let mean = settled.iter().sum::<f64>() / settled.len() as f64;
    Ok((kept && !settled.is_empty()).then(|| 1e3 * mean.sqrt()))
}

fn drive(setting: Setting, start: Se2, field: &Field) -> Result<Vec<Vec2>, SettingError> {
    let sets = if setting.five_sets { Sets::Five } else { Sets::Three };
    let config = TrailFollowerConfig {
        law: TrailLaw::Fuzzy { fuzzy: FuzzyConfig { sets, ..FuzzyConfig::default() } },
        wheel_speed_max_mps: WHEEL_SPEED_MAX_RATIO * setting.speed_mps,
        ..TrailFollowerConfig::default()
    };
    let wheelbase_m = config.wheelbase_m;
    let mut follower = TrailFollower::new(config)?;
    let sense = SenseConfig { sigma_m: setting.sigma_m, ..SenseConfig::default() };
    let period = Duration::from_millis(u64::from(setting.period_ms));
    let piece_s = period.as_secs_f64() / f64::from(N_PIECES);
    let n_steps = (TIME_MAX_S / period.as_secs_f64()) as usize;
    let (mut pose, mut way) = (start, Vec::new());
    for _ in 0..n_steps {
        let smell = field.sense(pose, &sense);
        // The server answers bytes.
        let byte = |intensity: f64| intensity.floor().min(255.0);
        let sensed =
            TrailSense { left: byte(smell.left), right: byte(smell.right), equivalent: None };
        let wheels = follower.step(sensed, setting.speed_mps, period);
        let twist = Twist {
            dx_m: 0.5 * (wheels.left_mps + wheels.right_mps) * piece_s,
            dy_m: 0.0,
            dyaw_rad: (wheels.right_mps - wheels.left_mps) / wheelbase_m * piece_s,
        };
        for _ in 0..N_PIECES {
            pose = pose.compose(Se2::exp(twist));
            way.push(pose.position());
        }
        if pose.x_m >= GOAL_X_M || pose.y_m.abs() > LOST_M {
            break;
        }
    }
    Ok(way)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rms_mm(speed_mps: f64, period_ms: u32) -> f64 {
        let setting = Setting { speed_mps, period_ms, ..Setting::THESIS };
        let start = Se2::new(0.0, 0.0, 45_f64.to_radians());
        settled_rms_mm(setting, start).unwrap().unwrap_or(f64::INFINITY)
    }

    /// What an ideal loop can be trusted in without another: mirrored starts, and the trend that the guide
    /// states: more with the period at every speed, and more at 0.7 m/s than at 0.3 m/s.
    #[test]
    fn swings_grow_with_the_period_and_the_speed() {
        for speed_mps in [0.3, 0.5, 0.7] {
            let by_period = [100, 600].map(|period_ms| rms_mm(speed_mps, period_ms));
            assert!(by_period[0] < by_period[1], "{speed_mps} m/s: {by_period:?}");
        }
        for period_ms in [200, 400, 600] {
            assert!(rms_mm(0.3, period_ms) < rms_mm(0.7, period_ms), "{period_ms} ms");
        }
        let mirrored = |yaw_deg: f64| {
            let start = Se2::new(0.07, 0.0, yaw_deg.to_radians());
            settled_rms_mm(Setting::THESIS, start).unwrap().unwrap()
        };
        assert!((mirrored(45.0) - mirrored(-45.0)).abs() < 1e-6);
    }
}
