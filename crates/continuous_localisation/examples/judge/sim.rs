//! A closed little simulation: a given way, a ring of cones, odometry that drifts.

use geometry::{Se2, SegmentWorld, Twist, Vec2, wrap_to_pi};
use rand_distr::{Distribution, StandardNormal};
use recordings::{Recording, Rig, RingRig, Scan, StampedPose};
use run_context::{RandomStream, RunSeed, Stamp};
use sensor_models::{SonarModel, materials};

use crate::worlds::World;

const TICK_MS: u64 = 7;
const SPEED_MPS: f64 = 0.2;
const TURN_MAX_RADPS: f64 = 0.8;
const LOOK_AHEAD_M: f64 = 0.3;

/// A ring: sensors in firing order, one every so many milliseconds.
pub(crate) struct Ring {
    pub(crate) name: &'static str,
    pub(crate) base_from_sensors: Vec<Se2>,
    pub(crate) period_ms: u64,
    /// Readings are whole multiples of this, metres.
    pub(crate) range_step_m: f64,
    pub(crate) range_max_m: f64,
}

/// What odometry gets wrong.
#[derive(Clone, Copy)]
pub(crate) struct Drift {
    pub(crate) systematic_degpm: f64,
    pub(crate) heading_std_deg: f64,
    pub(crate) way_std_ratio: f64,
}

pub(crate) fn ring5() -> Ring {
    let at = |x: f64, y: f64, deg: f64| Se2::new(x * 1e-3, y * 1e-3, deg.to_radians());
    // On the arc of the listing's ring.
    let base_from_sensors = vec![
        at(69.0, 136.0, 90.0),
        at(124.0, 108.0, 45.0),
        at(168.0, 0.0, 0.0),
        at(124.0, -108.0, -45.0),
        at(69.0, -136.0, -90.0),
    ];
    Ring { name: "5", base_from_sensors, period_ms: 49, range_step_m: 0.0254, range_max_m: 6.4516 }
}

pub(crate) fn ring8() -> Ring {
    let sensors = continuous_localisation::classic::LISTING_RING;
    let base_from_sensors = sensors
        .iter()
        .map(|s| Se2::new(s.x_mm * 1e-3, s.y_mm * 1e-3, s.azimuth_deg.to_radians()))
        .collect();
    Ring { name: "8", base_from_sensors, period_ms: 42, range_step_m: 0.0, range_max_m: 5.0 }
}

fn sonar(ring: &Ring) -> SonarModel {
    let Ring { range_max_m, range_step_m, .. } = *ring;
    SonarModel { range_max_m, range_step_m, n_rays: 15, ..SonarModel::default() }
}

/// Truth at every tick along the way.
fn drive(world: &World) -> Vec<Se2> {
    let mut corners = Vec::new();
    for _ in 0..world.n_laps {
        corners.extend_from_slice(&world.corners);
    }
    if world.is_closed {
        corners.push(world.corners[0]);
    }
    let first = corners[1] - corners[0];
    let mut pose = Se2::new(corners[0].x, corners[0].y, first.y.atan2(first.x));
    let mut poses = vec![pose];
    let dt = TICK_MS as f64 * 1e-3;
    let mut next = 1;
    while next < corners.len() {
        let (a, b) = (corners[next - 1], corners[next]);
        let along = (b - a).normalize();
        let done = (pose.position() - a).dot(&along);
        if done > (b - a).norm() - LOOK_AHEAD_M {
            next += 1;
            continue;
        }
        let target: Vec2 = a + along * (done + LOOK_AHEAD_M);
        let to = target - pose.position();
        let off = wrap_to_pi(to.y.atan2(to.x) - pose.yaw_rad);
        let turn = (2.5 * off).clamp(-TURN_MAX_RADPS, TURN_MAX_RADPS);
        let speed = SPEED_MPS * (1.0 - off.abs() / 1.2).clamp(0.1, 1.0);
        pose = pose.compose(Se2::exp(Twist { dx_m: speed * dt, dy_m: 0.0, dyaw_rad: turn * dt }));
        poses.push(pose);
    }
    poses
}

fn gauss(rng: &mut RandomStream) -> f64 {
    StandardNormal.sample(rng)
}

/// A recording of a drive, with truth.
pub(crate) fn record(
    world: &World,
    scene: &SegmentWorld,
    ring: &Ring,
    drift: Drift,
    seed: u64,
) -> Recording {
    let seed = RunSeed(seed);
    let (mut slip, mut sound) = (seed.stream("odometry"), seed.stream("sonar"));
    let sonar = sonar(ring);
    let truth = drive(world);
    let mut odom = truth[0];
    let mut recording = Recording {
        rig: Rig::Ring(RingRig {
            base_from_sensors: ring.base_from_sensors.clone(),
            half_angle_rad: sonar.half_angle_rad,
            range_min_m: sonar.range_min_m,
            range_max_m: sonar.range_max_m,
        }),
        scans: Vec::new(),
        odometry: Vec::new(),
        reference: Vec::new(),
        truth: Vec::new(),
        extra_columns_m: Vec::new(),
        epoch_ns: 0,
    };
    let n_sensors = ring.base_from_sensors.len();
    let ticks_per_ping = (ring.period_ms / TICK_MS) as usize;
    let (mut ranges_m, mut stamps) = (Vec::new(), Vec::new());
    for tick in 1..truth.len() {
        let step = truth[tick - 1].inverse().compose(truth[tick]).log();
        let way = step.dx_m.abs();
        let yaw = drift.systematic_degpm.to_radians() * way
            + drift.heading_std_deg.to_radians() * way.sqrt() * gauss(&mut slip);
        // Errors of the way add up like those of heading: the ratio is that of one metre.
        let dx_m = step.dx_m + drift.way_std_ratio * way.sqrt() * gauss(&mut slip);
        odom = odom.compose(Se2::exp(Twist { dx_m, dyaw_rad: step.dyaw_rad + yaw, ..step }));
        if tick % ticks_per_ping != 0 {
            continue;
        }
        let stamp = Stamp::from_millis(tick as u64 * TICK_MS);
        let sensor = ranges_m.len();
        let world_from_sensor = truth[tick].compose(ring.base_from_sensors[sensor]);
        let echo = sonar.ping(world_from_sensor, scene, materials(), &mut sound);
        ranges_m.push(echo.range_m);
        stamps.push(stamp);
        if ranges_m.len() == n_sensors {
            recording.scans.push(Scan {
                stamp,
                odom_from_base: Some(odom),
                ranges_m: std::mem::take(&mut ranges_m),
                stamps: std::mem::take(&mut stamps),
            });
            recording.truth.push(StampedPose { stamp, pose: truth[tick] });
        }
    }
    recording
}
