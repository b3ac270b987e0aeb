//! Runs and tables.

use continuous_localisation::{
    LocaliserConfig, SonarRun,
    metrics::{self, MapAgreement},
    run, run_twice,
};
use geometry::{Ray, RayCaster, Se2, Segment, SegmentWorld, Vec2};
use recordings::{Recording, Rig, StampedPose};

use crate::{
    sim::{self, Drift, Ring},
    worlds::{self, World},
};

/// Root of the mean square of position errors, metres.
pub(crate) fn rms_m(found: impl Iterator<Item = Se2>, truth: &[StampedPose]) -> f64 {
    let squares = found.zip(truth).map(|(a, b)| (a.position() - b.pose.position()).norm_squared());
    let (sum, n) = squares.fold((0.0, 0), |(sum, n), s| (sum + s, n + 1));
    (sum / f64::from(n)).sqrt()
}

pub(crate) fn odometry_rms_m(recording: &Recording) -> f64 {
    rms_m(recording.scans.iter().filter_map(|s| s.odom_from_base), &recording.truth)
}

/// Which points of the walls the ring can have heard: within 15° of square in some cone, nearer than
/// 3 m, and with nothing between.
fn heard_points(recording: &Recording, scene: &SegmentWorld) -> impl Fn(&Segment, Vec2) -> bool {
    let Rig::Ring(ring) = &recording.rig else { unreachable!("a ring was simulated") };
    let sensors: Vec<Se2> = recording
        .truth
        .iter()
        .step_by(2)
        .flat_map(|t| ring.base_from_sensors.iter().map(|s| t.pose.compose(*s)))
        .collect();
    let scene = scene.clone();
    let half = ring.half_angle_rad;
    move |wall, point| {
        let along = (wall.b - wall.a).normalize();
        sensors.iter().any(|sensor| {
            let to = point - sensor.position();
            let range_m = to.norm();
            if !(0.15..3.0).contains(&range_m) {
                return false;
            }
            let direction = to / range_m;
            let is_square = direction.perp(&along).abs() > half.cos();
            let in_cone = direction.dot(&sensor.heading()) > half.cos();
            let clear = || {
                let ray = Ray { origin: sensor.position(), direction };
                scene.cast(&ray, range_m + 0.1).is_some_and(|h| h.distance_m > range_m - 0.02)
            };
            is_square && in_cone && clear()
        })
    }
}

struct Outcome {
    odometry_m: f64,
    online_m: f64,
    twice_m: f64,
    online: MapAgreement,
    twice: MapAgreement,
    twice_all: MapAgreement,
    aligned: MapAgreement,
    entropy_bits: f64,
}

fn judge(world: &World, scene: &SegmentWorld, recording: &Recording) -> Outcome {
    let config = LocaliserConfig::default();
    let once = run(recording, config.clone()).expect("in range");
    let twice = run_twice(recording, config).expect("in range");
    let (truth, heard) = truth_cells(world, scene, recording, &once.localiser);
    let error_m = |run: &SonarRun| rms_m(run.online.iter().map(|p| p.pose), &recording.truth);
    let agreement =
        |run: &SonarRun, asked| metrics::agreement(run.localiser.map(), 0.7, asked, &truth);
    Outcome {
        odometry_m: odometry_rms_m(recording),
        online_m: error_m(&once),
        twice_m: error_m(&twice),
        online: agreement(&once, &heard),
        twice: agreement(&twice, &heard),
        twice_all: agreement(&twice, &truth),
        aligned: aligned(world, scene, recording, &twice),
        entropy_bits: twice.localiser.map().entropy().mean_bits(),
    }
}

/// The map against the truth as the robot's trajectory lies on it best: what is wrong inside the map,
/// without where the whole lies.
fn aligned(
    world: &World,
    scene: &SegmentWorld,
    recording: &Recording,
    run: &SonarRun,
) -> MapAgreement {
    let mean_of = |poses: &mut dyn Iterator<Item = Vec2>| {
        let all: Vec<Vec2> = poses.collect();
        (all.iter().sum::<Vec2>() / all.len() as f64, all)
    };
    let (found_mean, found) = mean_of(&mut run.online.iter().map(|p| p.pose.position()));
    let (true_mean, truth) = mean_of(&mut recording.truth.iter().map(|p| p.pose.position()));
    let (mut dot, mut cross) = (0.0, 0.0);
    for (a, b) in truth.iter().zip(&found) {
        let (a, b) = (a - true_mean, b - found_mean);
        dot += a.dot(&b);
        cross += a.perp(&b);
    }
    let turn = Se2::new(0.0, 0.0, cross.atan2(dot));
    let shift = found_mean - turn.rotate(true_mean);
    let map_from_world = Se2::new(shift.x, shift.y, turn.yaw_rad);
    let map = run.localiser.map();
    let heard = heard_points(recording, scene);
    let (mut asked, mut all) = (Vec::new(), Vec::new());
    for (wall, _) in &world.walls {
        let moved = Segment {
            a: map_from_world.transform_point(wall.a),
            b: map_from_world.transform_point(wall.b),
        };
        all.extend(metrics::wall_cells(map, &[moved], |_| true));
        let back = map_from_world.inverse();
        asked.extend(metrics::wall_cells(map, &[moved], |p| heard(wall, back.transform_point(p))));
    }
    asked.sort();
    asked.dedup();
    metrics::agreement(map, 0.7, &asked, &all)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0), |(s, n), v| (s + v, n + 1));
    sum / f64::from(n)
}

pub(crate) fn rooms(n_seeds: u64) {
    println!(
        "Position RMS over the trajectory, metres; walls within one cell of 35 mm, p from 0.7.\n\
         recall of what could be heard (and of all walls of the world)\n\
         world ring drift  way    | odometry  online   max of it | twice  | online: prec. recall | \
         twice: prec. recall (all)  IoU | aligned: prec. recall | bits"
    );
    for world in worlds::all() {
        let scene = world.scene();
        for ring in [sim::ring5(), sim::ring8()] {
            for systematic in [1.0, 0.0] {
                row(&world, &scene, &ring, systematic, n_seeds);
            }
        }
    }
}

fn row(world: &World, scene: &SegmentWorld, ring: &Ring, systematic: f64, n_seeds: u64) {
    let mut results = Vec::new();
    let mut way_m = 0.0;
    for seed in 0..n_seeds {
        let sign = if seed % 2 == 0 { 1.0 } else { -1.0 };
        let drift = Drift { systematic_degpm: sign * systematic, ..RANDOM };
        let recording = sim::record(world, scene, ring, drift, seed);
        way_m = recording.path_length_m();
        results.push(judge(world, scene, &recording));
    }
    let m = |f: &dyn Fn(&Outcome) -> f64| mean(results.iter().map(f));
    let worst = results.iter().map(|r| r.online_m / r.odometry_m).fold(0.0, f64::max);
    let odometry_m = m(&|r| r.odometry_m);
    let online_m = m(&|r| r.online_m);
    println!(
        "{:4} {:4} {:3.1}°/m {:5.1} m | {:6.3} {:6.3} = {:5.1} % {:6.1} % | {:6.3} | {:5.3} {:5.3} | {:5.3} {:5.3} ({:5.3}) {:5.3} | {:5.3} {:5.3} | {:5.3}",
        world.name,
        ring.name,
        systematic,
        way_m,
        odometry_m,
        online_m,
        100.0 * online_m / odometry_m,
        100.0 * worst,
        m(&|r| r.twice_m),
        m(&|r| r.online.precision_ratio),
        m(&|r| r.online.recall_ratio),
        m(&|r| r.twice.precision_ratio),
        m(&|r| r.twice.recall_ratio),
        m(&|r| r.twice_all.recall_ratio),
        m(&|r| r.twice.iou_ratio),
        m(&|r| r.aligned.precision_ratio),
        m(&|r| r.aligned.recall_ratio),
        m(&|r| r.entropy_bits),
    );
}

/// What odometry gets wrong at random: 0.3° and 1 cm after one metre.
const RANDOM: Drift = Drift { systematic_degpm: 0.0, heading_std_deg: 0.3, way_std_ratio: 0.01 };

/// Every registration of one run, with its error in the robot's frame.
pub(crate) fn trace(name: &str) {
    let Some(world) = worlds::all().into_iter().find(|world| world.name == name) else { return };
    let scene = world.scene();
    let drift = Drift { systematic_degpm: 1.0, ..RANDOM };
    let recording = sim::record(&world, &scene, &sim::ring5(), drift, 0);
    let found = run(&recording, LocaliserConfig::default()).expect("in range");
    for r in &found.registrations {
        let Some(p) = r.poses.last() else { continue };
        let Some(t) = recording.truth.iter().find(|t| t.stamp == p.stamp) else { continue };
        let (e, std) = (t.pose.inverse().compose(p.pose), r.covariance.diagonal().map(f64::sqrt));
        println!(
            "{} at ({:.2} {:.2} {:.0}°) echoes {} of walls {} rms {:.3} {:?} error {:.3} {:.3} \
             {:.2}° std {:.3} {:.3} {:.2}° missed {:.2}°/m",
            r.stamp,
            t.pose.x_m,
            t.pose.y_m,
            t.pose.yaw_rad.to_degrees(),
            r.collected.n_readings,
            r.n_wall_echoes,
            r.wall_rms_m,
            r.outcome,
            e.x_m,
            e.y_m,
            e.yaw_rad.to_degrees(),
            std[0],
            std[1],
            std[2].to_degrees(),
            r.missed_yaw_radpm.to_degrees(),
        );
        if let Some(best) = r.chosen.map(|i| r.candidates[i]) {
            println!("    best of {}: {best:?}", r.candidates.len());
        }
    }
    for w in found.localiser.walls() {
        println!("wall {:?} n {}", w.ends().map(|p| (p.x, p.y)), w.n_echoes);
    }
    println!("{:?}", found.localiser.counts());
}

/// Maps at true poses: what the sensor and the drawing alone cost.
pub(crate) fn bound() {
    println!(
        "world ring | precision recall(all) recall(heard) IoU(heard), p from 0.6, 0.7, 0.8, 0.9"
    );
    for world in worlds::all() {
        let scene = world.scene();
        for ring in [sim::ring5(), sim::ring8()] {
            let none = Drift { systematic_degpm: 0.0, heading_std_deg: 0.0, way_std_ratio: 0.0 };
            let recording = sim::record(&world, &scene, &ring, none, 0);
            print!("{:4} {:4} |", world.name, ring.name);
            let SonarRun { localiser, .. } =
                run(&recording, LocaliserConfig::odometry_only()).expect("in range");
            let (truth, heard) = truth_cells(&world, &scene, &recording, &localiser);
            for p in [0.6, 0.7, 0.8, 0.9] {
                let all = metrics::agreement(localiser.map(), p, &truth, &truth);
                let a = metrics::agreement(localiser.map(), p, &heard, &truth);
                print!(
                    " {:.3} {:.3} {:.3} {:.3} |",
                    a.precision_ratio, all.recall_ratio, a.recall_ratio, a.iou_ratio
                );
            }
            println!(" {:?}", localiser.counts());
        }
    }
}

fn truth_cells(
    world: &World,
    scene: &SegmentWorld,
    recording: &Recording,
    localiser: &continuous_localisation::Localiser,
) -> (Vec<grid_maps::Cell>, Vec<grid_maps::Cell>) {
    let map = localiser.map();
    let heard = heard_points(recording, scene);
    let walls: Vec<Segment> = world.walls.iter().map(|w| w.0).collect();
    let truth = metrics::wall_cells(map, &walls, |_| true);
    let mut cells = Vec::new();
    for wall in &walls {
        cells.extend(metrics::wall_cells(map, &[*wall], |p| heard(wall, p)));
    }
    cells.sort();
    cells.dedup();
    (truth, cells)
}
