//! An ideal differential drive and the promises that every follower keeps.

use geometry::Se2;
use path_following::WheelReference;

/// Between the wheels, metres.
pub(crate) const WHEELBASE_M: f64 = 0.38;

/// Drives at constant wheel speeds for a time: the arc in closed form, (2.1)–(2.6) of the thesis.
pub(crate) fn drive(pose: Se2, wheels: WheelReference, dt_s: f64) -> Se2 {
    let v = f64::midpoint(wheels.left_mps, wheels.right_mps);
    let w = (wheels.right_mps - wheels.left_mps) / WHEELBASE_M;
    let (yaw, turn) = (pose.yaw_rad, w * dt_s);
    let (dx, dy) = if turn.abs() < 1e-9 {
        (v * dt_s * yaw.cos(), v * dt_s * yaw.sin())
    } else {
        (v / w * ((yaw + turn).sin() - yaw.sin()), v / w * (yaw.cos() - (yaw + turn).cos()))
    };
    Se2::new(pose.x_m + dx, pose.y_m + dy, yaw + turn)
}

/// A follower as the suite sees it: from a pose to wheel speeds, on the x axis, towards +x, at 0.3 m/s and
/// 200 ms. Each call of the outer function gives a fresh one.
pub(crate) type Follower = Box<dyn FnMut(Se2) -> WheelReference>;

/// What a follower promises.
pub(crate) struct Promises {
    /// No wheel faster than this, metres per second.
    pub(crate) wheel_speed_max_mps: f64,
    /// Distance from the line that is left after 20 s, metres.
    pub(crate) residual_m: f64,
    /// Mirrored poses give mirrored wheels.
    pub(crate) mirrors: bool,
}

/// Checks every promise that followers share.
///
/// # Panics
///
/// When one is broken; the message names it.
pub(crate) fn check_follower(name: &str, fresh: impl Fn() -> Follower, promises: &Promises) {
    check_convergence(name, &fresh, promises);
    if promises.mirrors {
        check_mirror(name, &fresh);
    }
    check_nonsense(name, &fresh, promises);
}

fn check_convergence(name: &str, fresh: &impl Fn() -> Follower, promises: &Promises) {
    for (offset_m, yaw_deg) in [
        (0.0, 45.0),
        (0.0, -45.0),
        (0.25, 0.0),
        (-0.25, 0.0),
        (0.15, 20.0),
        (-0.15, -20.0),
        (0.0, 0.0),
    ] {
        let mut follower = fresh();
        let mut pose = Se2::new(0.03, offset_m, f64::to_radians(yaw_deg));
        for _ in 0..100 {
            let wheels = follower(pose);
            let fastest = wheels.left_mps.abs().max(wheels.right_mps.abs());
            assert!(
                fastest <= promises.wheel_speed_max_mps + 1e-12,
                "{name}: a wheel at {fastest} m/s, at most {} promised",
                promises.wheel_speed_max_mps
            );
            pose = drive(pose, wheels, 0.2);
        }
        assert!(
            pose.y_m.abs() <= promises.residual_m && pose.yaw_rad.abs() < 0.3 && pose.x_m > 2.0,
            "{name}: from y = {offset_m} m, {yaw_deg}° it ends at {pose:?}"
        );
    }
}

fn check_mirror(name: &str, fresh: &impl Fn() -> Follower) {
    let (mut here, mut there) = (fresh(), fresh());
    let mut pose = Se2::new(0.05, 0.21, -0.4);
    for step in 0..60 {
        let wheels = here(pose);
        let mirrored = there(Se2::new(pose.x_m, -pose.y_m, -pose.yaw_rad));
        let off = (wheels.left_mps - mirrored.right_mps).abs();
        let off = off.max((wheels.right_mps - mirrored.left_mps).abs());
        assert!(off < 1e-6, "{name}: step {step}: {wheels:?} but mirrored {mirrored:?}");
        pose = drive(pose, wheels, 0.2);
    }
}

fn check_nonsense(name: &str, fresh: &impl Fn() -> Follower, promises: &Promises) {
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    let mut follower = fresh();
    for (x_m, y_m, yaw_rad) in [
        (nan, 0.0, 0.0),
        (0.0, nan, 0.0),
        (0.0, 0.0, nan),
        (inf, 0.0, 0.0),
        (0.0, -inf, inf),
        (1e300, -1e300, 0.0),
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        (0.0, 1e9, 3.0),
        (-1e9, 0.0, -3.0),
    ] {
        let wheels = follower(Se2 { x_m, y_m, yaw_rad });
        for speed in [wheels.left_mps, wheels.right_mps] {
            assert!(speed.is_finite(), "{name}: {wheels:?} for ({x_m}, {y_m}, {yaw_rad})");
            assert!(speed.abs() <= promises.wheel_speed_max_mps + 1e-12, "{name}: {wheels:?}");
        }
    }
}
