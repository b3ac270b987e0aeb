//! Drivers of lasers against simulated ones, and against what goes wrong.

use std::sync::Arc;

use geometry::{Se2, Segment, SegmentWorld, Vec2};
use robot_models::{OdometryErrors, RobotModel};
use run_context::RunSeed;
use sensor_models::{SonarModel, WALL_TAG};
use simulator::{BodyId, RobotPlacement, World, WorldSpec};
use virtual_robots::{Board, LaserConfig, Port, laser_board};

use super::*;

const TICK: Duration = Duration::from_millis(10);

/// A robot at the origin of a room of 6 m by 4 m, its laser, and the laser's driver.
struct Bed {
    world: World,
    body: BodyId,
    board: Box<dyn Board>,
    driver: Box<dyn LaserDriver>,
    asked: Vec<u8>,
    scans: Vec<PlanarScan>,
    troubles: Vec<String>,
    n_well: u32,
}

impl Bed {
    fn new(kind: LaserKind, config: LaserDriverConfig) -> Self {
        let corners =
            [(-2.0, -1.0), (4.0, -1.0), (4.0, 3.0), (-2.0, 3.0)].map(|(x, y)| Vec2::new(x, y));
        let walls = (0..4).map(|i| (Segment { a: corners[i], b: corners[(i + 1) % 4] }, WALL_TAG));
        let spec = WorldSpec::of_walls(SegmentWorld::new(walls));
        let mut world = World::new(spec, RunSeed(1), TICK).unwrap();
        let body = world
            .add_robot(RobotPlacement {
                name: "robot".to_owned(),
                model: Arc::new(RobotModel::by_name("pioneer3dx").unwrap()),
                world_from_base: Se2::IDENTITY,
                errors: OdometryErrors::default(),
                sonar: SonarModel::ideal(),
            })
            .unwrap();
        let board = laser_board(LaserConfig::new(kind, Se2::IDENTITY), RunSeed(1).stream("laser"));
        Self {
            world,
            body,
            board,
            driver: laser_driver(kind, config),
            asked: Vec::new(),
            scans: Vec::new(),
            troubles: Vec::new(),
            n_well: 0,
        }
    }

    /// So many ticks; `line` may damage what the laser says.
    fn run(&mut self, n_ticks: usize, mut line: impl FnMut(&mut Vec<u8>)) {
        for _ in 0..n_ticks {
            let mut said = Vec::new();
            let received = std::mem::take(&mut self.asked);
            let port = Port { received: &received, out: &mut said };
            self.board.step(self.world.now(), &self.world, self.body, &mut [port]);
            line(&mut said);
            let (scans, troubles, n_well) = (&mut self.scans, &mut self.troubles, &mut self.n_well);
            let mut take = |news: LaserNews<'_>| match news {
                LaserNews::Scan(scan) => scans.push(scan.clone()),
                LaserNews::Trouble(trouble) => troubles.push(trouble.to_string()),
                LaserNews::Well => *n_well += 1,
            };
            self.driver.step(self.world.now(), &said, &mut take, &mut self.asked);
            self.world.step();
        }
    }

    fn latest(&self) -> Option<&PlanarScan> {
        self.driver.latest(self.world.now())
    }
}

fn whole(_: &mut Vec<u8>) {}

fn config() -> LaserDriverConfig {
    LaserDriverConfig::named("front")
}

/// Range to the room's walls from the origin.
fn expected_m(bearing_rad: f64) -> f64 {
    let (s, c) = bearing_rad.sin_cos();
    let x = if c > 0.0 { 4.0 / c } else { -2.0 / c };
    let y = match s {
        _ if s.abs() < 1e-9 => f64::INFINITY,
        _ if s > 0.0 => 3.0 / s,
        _ => -1.0 / s,
    };
    x.min(y)
}

#[test]
fn every_laser_is_started_and_read_counter_clockwise() {
    for (kind, n_beams, per_s) in [
        (LaserKind::SickLms, 181, 75.0),
        (LaserKind::RplidarA1, 360, 5.47),
        (LaserKind::Ld06, 450, 10.0),
    ] {
        let mut bed = Bed::new(kind, config());
        bed.run(500, whole);
        assert!(bed.troubles.is_empty(), "{:?}", bed.troubles);
        let rate = bed.scans.len() as f64 / 5.0;
        assert!(rate > 0.8 * per_s && rate < 1.05 * per_s, "{kind:?}: {rate}");
        for scan in &bed.scans {
            assert_eq!(scan.beams.len(), n_beams);
            for beam in &scan.beams {
                let Some(range_m) = beam.surface_m() else { continue };
                let error_m = range_m - expected_m(beam.bearing_rad);
                assert!(error_m.abs() < 0.1, "{kind:?} {beam:?} {error_m}");
            }
            assert!(scan.n_surfaces() > n_beams * 9 / 10);
            let took_s = scan.beams.last().unwrap().after_s;
            assert!(took_s > 0.4 / per_s && took_s < 1.1 / per_s, "{kind:?} {took_s}");
        }
        assert!(bed.scans.windows(2).all(|w| w[1].number == w[0].number + 1));
        assert!(bed.scans.windows(2).all(|w| w[1].about > w[0].about));
        assert!(bed.latest().is_some());
    }
}

/// Unplugged: nothing is seen after a second, and said once; plugged in again, scans come by themselves.
#[test]
fn a_silent_laser_is_unseen_and_found_again() {
    for kind in LaserKind::ALL {
        let mut bed = Bed::new(kind, config());
        bed.run(300, whole);
        assert!(bed.latest().is_some());
        bed.run(150, Vec::clear);
        assert!(bed.latest().is_none());
        assert_eq!(bed.troubles.len(), 1, "{:?}", bed.troubles);
        let text = &bed.troubles[0];
        for word in ["`front`", kind.title(), "silent for 1.0 s", "cable"] {
            assert!(text.contains(word), "{text}");
        }
        bed.run(1500, whole);
        assert!(bed.latest().is_some(), "{kind:?} {:?}", bed.troubles);
        assert!(bed.n_well >= 1 && bed.driver.trouble().is_none());
    }
}

/// The line's speed is wrong: bytes come that mean nothing.
#[test]
fn noise_is_told_from_silence() {
    for kind in LaserKind::ALL {
        let mut bed = Bed::new(kind, config());
        bed.run(300, |said| {
            said.clear();
            said.extend([0x81; 20]);
        });
        assert!(bed.latest().is_none());
        assert!(bed.troubles[0].contains("nothing can be read"), "{:?}", bed.troubles);
        assert!(bed.troubles[0].contains("speed"), "{:?}", bed.troubles);
        assert_eq!(bed.scans.len(), 0);
    }
}

#[test]
fn a_frozen_laser_is_unseen() {
    let mut bed = Bed::new(LaserKind::SickLms, config());
    bed.run(100, whole);
    let mut telegram = Vec::new();
    bed.run(10, |said| {
        if !said.is_empty() {
            telegram.clone_from(said);
        }
    });
    bed.run(290, |said| said.clone_from(&telegram));
    assert!(bed.latest().is_some() && bed.troubles.is_empty());
    bed.run(20, |said| said.clone_from(&telegram));
    assert!(bed.latest().is_none());
    assert!(bed.troubles[0].contains("repeats one scan for 3.0 s"), "{:?}", bed.troubles);
    bed.run(100, whole);
    assert!(bed.latest().is_some());
    assert_eq!(bed.n_well, 1);
}

#[test]
fn damage_is_told_with_its_rate_and_the_rest_is_used() {
    let mut bed = Bed::new(LaserKind::SickLms, config());
    bed.run(100, whole);
    let mut n = 0;
    bed.run(500, |said| {
        n += 1;
        if n % 3 == 0 && said.len() > 100 {
            said[77] ^= 0x40;
        }
    });
    assert!(bed.latest().is_some());
    let text = bed.troubles.last().unwrap();
    assert!(text.contains("packets are damaged") && text.contains("shield"), "{text}");
    bed.run(500, whole);
    assert!(bed.driver.trouble().is_none());
}

/// A SICK that kept 38 400 from its last owner is found at that speed.
#[test]
fn a_sick_is_found_at_another_speed_and_its_line_is_changed() {
    let config = LaserDriverConfig { change_baud_to: Some(38_400), ..config() };
    let mut bed = Bed::new(LaserKind::SickLms, config);
    assert_eq!(bed.driver.wanted_baud(), Some(9600));
    bed.run(300, whole);
    assert_eq!(bed.driver.wanted_baud(), Some(38_400));
    assert_eq!(bed.board.status().baud, Some(38_400));
    assert!(bed.latest().is_some());
    // Silent at 9600, whatever is asked: the next speeds are tried.
    let config =
        LaserDriverConfig { change_baud_to: Some(38_400), ..LaserDriverConfig::named("x") };
    let mut deaf = Bed::new(LaserKind::SickLms, config);
    let mut speeds = Vec::new();
    for _ in 0..14 {
        deaf.run(100, Vec::clear);
        speeds.push(deaf.driver.wanted_baud().unwrap());
    }
    speeds.dedup();
    assert_eq!(speeds[..4], [9600, 38_400, 19_200, 9600]);
}
