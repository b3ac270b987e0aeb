//! Of which materials does the sonar model fail as the thesis says that sonars do (section 7.5)?
//!
//! At 0.3 m/s obstacles practically never went undetected; at 0.5 m/s 5 to 10 % did. It does not say what
//! they were made of. Here a robot drives straight at a box of chance orientation and offset, of each
//! material in turn, and brakes with its 0.3 m/s² as soon as any of the sonars 1 to 6, heard through 100 ms
//! of reporting and 200 ms of control period, is inside the bubble 10 · V · Δt. That is less than an avoider
//! does; it isolates what the sensor contributes. The cause is the thesis's too: a box that stands askew
//! mirrors the sound away and is heard only from near, which is enough for a slow robot.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{fmt::Write as _, sync::Arc, time::Duration};

use expect_test::expect;
use geometry::{Polygon, Se2, Vec2};
use robot_models::{OdometryErrors, RobotModel, WheelSpeeds};
use run_context::RunSeed;
use sensor_models::{FiringSchedule, SonarModel, material_by_name, materials};
use simulator::{RobotPlacement, ThingKind, ThingSpec, World, WorldSpec};

const STEP: Duration = Duration::from_millis(10);
const TRIALS: u64 = 600;
const BUBBLE_GAIN: f64 = 10.0;

/// A box of 0.4 m, three metres ahead.
fn askew_box(trial: u64, material: u32) -> ThingSpec {
    // Two incommensurate steps fill the square of orientations and offsets evenly.
    let fraction = |step: f64| (trial as f64 * step).fract();
    let yaw_rad = fraction(0.618_034) * std::f64::consts::FRAC_PI_2;
    let place = Se2::new(3.0, 0.5 * fraction(0.754_878) - 0.25, yaw_rad);
    let corner = |x_m, y_m| place.transform_point(Vec2::new(x_m, y_m));
    let corners = vec![corner(-0.2, -0.2), corner(0.2, -0.2), corner(0.2, 0.2), corner(-0.2, 0.2)];
    ThingSpec {
        name: "box".to_owned(),
        kind: ThingKind::Box,
        polygon: Polygon::new(corners).unwrap(),
        material,
        movable: true,
    }
}

/// Whether the robot runs into the box.
fn runs_into_it(model: &Arc<RobotModel>, speed_mps: f64, trial: u64, material: u32) -> bool {
    let seed = RunSeed(trial);
    let mut world = World::new(WorldSpec::empty(), seed, STEP).unwrap();
    let placement = RobotPlacement {
        name: "rover".to_owned(),
        model: Arc::clone(model),
        world_from_base: Se2::IDENTITY,
        errors: OdometryErrors::default(),
        sonar: SonarModel::default(),
    };
    let id = world.add_robot(placement).unwrap();
    world.place_thing(askew_box(trial, material)).unwrap();
    let ahead = WheelSpeeds { left_mps: speed_mps, right_mps: speed_mps };
    world.set_wheel_reference(id, ahead);
    let schedule = FiringSchedule::pioneer(8);
    let mut rng = seed.stream("sonar");
    let mut fresh_m = [5.0; 8];
    let mut reported_m = fresh_m;
    for tick in 1..1500 {
        let before = world.now();
        world.step();
        for firing in schedule.due(before, world.now()) {
            let echo = world.ping(id, firing.sensor_index, &mut rng);
            fresh_m[firing.sensor_index] = echo.range_m;
        }
        if tick % 10 == 0 {
            reported_m = fresh_m;
        }
        let bubble_m = BUBBLE_GAIN * speed_mps * 0.2;
        if tick % 20 == 5 && reported_m[1..7].iter().any(|&range_m| range_m <= bubble_m) {
            world.set_wheel_reference(id, WheelSpeeds::ZERO);
        }
        let body = world.body(id);
        if body.contacts > 0 || (body.wheel_speeds.is_zero() && body.wheel_reference.is_zero()) {
            break;
        }
    }
    world.body(id).contacts > 0
}

fn failures_percent(material: &str, speed_mps: f64) -> f64 {
    let model = Arc::new(RobotModel::by_name("pioneer3dx").unwrap());
    let (tag, _) = material_by_name(material).unwrap();
    let failed = (0..TRIALS).filter(|&trial| runs_into_it(&model, speed_mps, trial, tag)).count();
    100.0 * failed as f64 / TRIALS as f64
}

/// Every material there is, not a chosen one; 600 fixed seeds, so a rate of 7 % has a standard deviation
/// of 1 %. *Fits*: at most 0.5 % at 0.3 m/s and 5 to 10 % at 0.5 m/s.
#[test]
fn which_materials_are_missed_as_the_thesis_reports() {
    let mut table = String::from("material   0.3 m/s  0.5 m/s  fits\n");
    for material in materials() {
        let [slow, fast] = [0.3, 0.5].map(|speed_mps| failures_percent(material.name, speed_mps));
        let fits = slow <= 0.5 && (5.0..=10.0).contains(&fast);
        let fits = if fits { "yes" } else { "no" };
        writeln!(table, "{:10} {slow:7.1}  {fast:7.1}  {fits}", material.name).unwrap();
    }
    expect![[r#"
        material   0.3 m/s  0.5 m/s  fits
        plaster        0.3     20.0  no
        wood           0.0      7.2  yes
        glass         35.7     43.2  no
        fabric         0.0      0.0  no
        metal         32.3     39.8  no
        cardboard      0.0      3.0  no
        person         0.0      0.0  no
        mirror        35.7     43.2  no
    "#]]
    .assert_eq(&table);
}
