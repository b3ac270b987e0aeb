//! The environments E1 to E4 as the robot's own frame sees them, with what of them can be heard at all.

use std::collections::BTreeSet;

use continuous_localisation::{Localiser, LocaliserConfig, OdometryTrust, Wall, metrics, run};
use geometry::{Ray, RayCaster, Se2, Segment, SegmentWorld, Vec2};
use grid_maps::{Cell, EvidenceModel, Lattice, LogOddsMap};
use missions::{Mission, Run, sense};
use recordings::{Recording, Rig, RingRig};
use run_context::RunSeed;

use crate::ExperimentError;

/// Between places from which a wall is looked for, metres of way.
const STATION_M: f64 = 0.25;
/// Only every so many rows are asked what they could have heard; a row is 2 cm of way.
const ROWS_PER_LISTENING: usize = 4;
/// An echo from farther away says too little about where its cell is to count as heard, metres.
const HEARD_WITHIN_M: f64 = 3.0;
/// Between points of the floor, metres.
const FLOOR_STEP_M: f64 = 0.14;
/// Floor within this of the way, and in sight of it, is near, metres.
const NEAR_M: f64 = 2.0;
/// No floor goes on farther than so many steps from the start.
const FLOOR_STEPS_MAX: i32 = 300;
/// A ray that ends so much before a point on a wall does not reach it, metres.
const REACH_M: f64 = 0.02;

/// An environment with a ring of sonars; everything in the frame in which odometry begins at zero.
#[derive(Debug)]
pub(super) struct Room {
    /// E1 to E4.
    pub(super) name: &'static str,
    /// The ring's name.
    pub(super) ring: &'static str,
    mission: &'static str,
    /// Pose of that frame in the world.
    pub(super) world_from_map: Se2,
    /// What stands there, as polygons; walls with two corners each.
    pub(super) outlines: Vec<Vec<Vec2>>,
    /// Cells of walls and things.
    pub(super) truth: Truth,
    /// A drive ends at the latest after so long, seconds.
    pub(super) duration_s: f64,
    /// Driven, metres.
    pub(super) way_m: f64,
    /// What an earlier visit knows, drawn at known poses.
    pub(super) prior: (LogOddsMap, Vec<Wall>),
}

/// Cells with a wall or a thing's side in them, and floor.
#[derive(Debug)]
pub(super) struct Truth {
    /// All of them.
    pub(super) all: Vec<Cell>,
    /// Those in a straight line of sight of the way, within the sonars' range.
    pub(super) exposed: Vec<Cell>,
    /// Those which a cone met squarely within 3 m.
    pub(super) heard: Vec<Cell>,
    /// Parts of the environment by name.
    pub(super) parts: Vec<(&'static str, Vec<Cell>)>,
    /// Points of the floor that can be reached from the start, metres.
    pub(super) floor: Vec<Vec2>,
    /// Those near the way.
    pub(super) near_floor: Vec<Vec2>,
}

/// The four environments with their missions.
pub(super) static ROOMS: [(&str, &str); 4] =
    [("E1", "artemic-e1"), ("E2", "artemic-e2"), ("E3", "artemic-e3"), ("E4", "artemic-e4")];

/// The lattice of all maps here, of 35 mm as in the document.
pub(super) fn empty_map() -> Result<LogOddsMap, ExperimentError> {
    let lattice = Lattice::new(Vec2::zeros(), LocaliserConfig::default().resolution_m)?;
    Ok(LogOddsMap::new(lattice, EvidenceModel::default())?)
}

/// The same readings at the poses where they were truly taken; as if odometry knew no error.
pub(super) fn at_true_poses(recording: &Recording, world_from_map: Se2) -> Recording {
    let mut known = recording.clone();
    known.odometry.clear();
    let map_from_world = world_from_map.inverse();
    for (scan, truth) in known.scans.iter_mut().zip(&recording.truth) {
        scan.odom_from_base = Some(map_from_world.compose(truth.pose));
    }
    known
}

impl Room {
    /// Drives it once without errors of odometry: what can be heard follows from the way, and what it
    /// heard is the prior map.
    pub(super) fn new(
        (name, mission): (&'static str, &'static str),
        ring: &'static str,
        duration_max_s: f64,
        seed: RunSeed,
    ) -> Result<Self, ExperimentError> {
        let whole_s = Mission::load(mission, &[])?.duration_max().as_secs_f64();
        let mut room = Self {
            name,
            ring,
            mission,
            world_from_map: Se2::IDENTITY,
            outlines: Vec::new(),
            truth: Truth::nothing(),
            duration_s: whole_s.min(duration_max_s),
            way_m: 0.0,
            prior: (empty_map()?, Vec::new()),
        };
        let perfect = room.mission(0.0, &["robots.odometry.slip_std_ratio=0.0".to_owned()])?;
        let (_, start) = missions::world_of(&perfect, seed)?;
        room.world_from_map = start.unwrap_or(Se2::IDENTITY);
        let scene = Run::new(perfect.clone(), seed)?.scene();
        let map_from_world = room.world_from_map.inverse();
        let walls = scene.walls.iter().map(|wall| vec![wall.a, wall.b]);
        let things = scene.things.iter().map(|thing| thing.corners_m.clone());
        room.outlines = walls
            .chain(things)
            .map(|corners| corners.into_iter().map(|p| map_from_world.transform_point(p)).collect())
            .collect();
        let recording = sense(perfect, seed)?.recordings.remove(0).1;
        room.way_m = recording.path_length_m();
        let known = at_true_poses(&recording, room.world_from_map);
        room.prior = prior(&known)?;
        if let Rig::Ring(rig) = &known.rig {
            room.truth = room.listen(&known, rig)?;
        }
        Ok(room)
    }

    /// The mission with such a drift and other overrides.
    pub(super) fn mission(
        &self,
        drift_degpm: f64,
        more: &[String],
    ) -> Result<Mission, ExperimentError> {
        let mut overrides = vec![
            format!("robots.model={}", self.ring),
            format!("robots.odometry.drift_degpm={drift_degpm:?}"),
            format!("mission.duration_max_s={:?}", self.duration_s),
        ];
        overrides.extend_from_slice(more);
        Ok(Mission::load(self.mission, &overrides)?)
    }

    /// Sides of all outlines.
    fn sides(&self) -> Vec<Segment> {
        let mut sides = Vec::new();
        for corners in &self.outlines {
            let n = corners.len();
            let n_sides = if n > 2 { n } else { n.saturating_sub(1) };
            sides.extend((0..n_sides).map(|i| Segment { a: corners[i], b: corners[(i + 1) % n] }));
        }
        sides
    }

    fn listen(&self, known: &Recording, rig: &RingRig) -> Result<Truth, ExperimentError> {
        let sides = self.sides();
        let scene = SegmentWorld::new(sides.iter().map(|&side| (side, 0)));
        let poses: Vec<Se2> = known.scans.iter().filter_map(|scan| scan.odom_from_base).collect();
        let stations = stations(&poses);
        let listening: Vec<Se2> = poses
            .iter()
            .step_by(ROWS_PER_LISTENING)
            .flat_map(|pose| rig.base_from_sensors.iter().map(|sensor| pose.compose(*sensor)))
            .collect();
        let map = empty_map()?;
        let all = metrics::wall_cells(&map, &sides, |_| true);
        let in_sight =
            |p: Vec2| stations.iter().any(|&from| is_in_sight(&scene, from, p, rig.range_max_m));
        let exposed = metrics::wall_cells(&map, &sides, in_sight);
        let mut heard = BTreeSet::new();
        for side in &sides {
            let is_heard = |p: Vec2| is_heard(&scene, &listening, rig.half_angle_rad, *side, p);
            heard.extend(metrics::wall_cells(&map, &[*side], is_heard));
        }
        let floor = floor(&scene);
        let is_near = |p: &Vec2| stations.iter().any(|&from| is_in_sight(&scene, from, *p, NEAR_M));
        Ok(Truth {
            parts: self.parts(&map, &all),
            near_floor: floor.iter().copied().filter(is_near).collect(),
            all,
            exposed,
            heard: heard.into_iter().collect(),
            floor,
        })
    }

    /// The corridor's three arms; other environments have no parts.
    fn parts(&self, map: &LogOddsMap, all: &[Cell]) -> Vec<(&'static str, Vec<Cell>)> {
        if self.name != "E4" {
            return Vec::new();
        }
        let part_of = |cell: Cell| {
            let p = self.world_from_map.transform_point(map.lattice().centre_of(cell));
            // The hall's inner wall is at y = 11.1 m; the arms' middles at x = 0 and 26.6 m.
            match (p.y < 11.0, p.x < 13.3) {
                (false, _) => "hall",
                (true, true) => "left arm",
                (true, false) => "right arm",
            }
        };
        ["left arm", "hall", "right arm"]
            .map(|part| (part, all.iter().copied().filter(|&cell| part_of(cell) == part).collect()))
            .into()
    }
}

impl Truth {
    fn nothing() -> Self {
        Self {
            all: Vec::new(),
            exposed: Vec::new(),
            heard: Vec::new(),
            parts: Vec::new(),
            floor: Vec::new(),
            near_floor: Vec::new(),
        }
    }
}

/// Map and walls from a recording whose odometry is true and is told to be.
fn prior(known: &Recording) -> Result<(LogOddsMap, Vec<Wall>), ExperimentError> {
    let sure = OdometryTrust {
        heading_std_rad: 1e-5,
        position_std_m: 1e-5,
        turn_std_rad: 0.0,
        drift_std_radpm: 1e-7,
        drift_walk_std_radpm: 0.0,
    };
    let config = LocaliserConfig { odometry: sure, ..LocaliserConfig::default() };
    let localiser: Localiser = run(known, config)?.localiser;
    Ok((localiser.map().clone(), localiser.walls().to_vec()))
}

/// Places along the way, evenly spaced.
pub(super) fn stations(poses: &[Se2]) -> Vec<Vec2> {
    let mut stations: Vec<Vec2> = Vec::new();
    for pose in poses {
        let here = pose.position();
        if stations.last().is_none_or(|last| (here - last).norm() >= STATION_M) {
            stations.push(here);
        }
    }
    stations
}

fn is_in_sight(scene: &SegmentWorld, from: Vec2, to: Vec2, range_max_m: f64) -> bool {
    let range_m = (to - from).norm();
    range_m <= range_max_m && is_clear(scene, from, to, range_m)
}

fn is_clear(scene: &SegmentWorld, from: Vec2, to: Vec2, range_m: f64) -> bool {
    if range_m < REACH_M {
        return true;
    }
    let ray = Ray { origin: from, direction: (to - from) / range_m };
    scene.cast(&ray, range_m).is_none_or(|hit| hit.distance_m > range_m - REACH_M)
}

/// Whether one of the sensors had the point in its cone, near enough, square enough and with nothing
/// between. The angle of the cone is also the one by which sound may come in aslant.
fn is_heard(
    scene: &SegmentWorld,
    sensors: &[Se2],
    half_angle_rad: f64,
    side: Segment,
    point: Vec2,
) -> bool {
    let along = (side.b - side.a) / side.length().max(1e-9);
    let least = half_angle_rad.cos();
    sensors.iter().any(|sensor| {
        let to = point - sensor.position();
        let range_m = to.norm();
        let reach =
            to.dot(&sensor.heading()) > least * range_m && to.perp(&along).abs() > least * range_m;
        reach && range_m < HEARD_WITHIN_M && is_clear(scene, sensor.position(), point, range_m)
    })
}

/// Points that a walk from the start reaches without crossing a wall.
fn floor(scene: &SegmentWorld) -> Vec<Vec2> {
    let point = |(i, j): (i32, i32)| Vec2::new(f64::from(i), f64::from(j)) * FLOOR_STEP_M;
    let mut reached: BTreeSet<(i32, i32)> = BTreeSet::from([(0, 0)]);
    let mut open: Vec<(i32, i32)> = vec![(0, 0)];
    while let Some((i, j)) = open.pop() {
        for next in [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)] {
            let is_far = next.0.abs() > FLOOR_STEPS_MAX || next.1.abs() > FLOOR_STEPS_MAX;
            if !is_far && !reached.contains(&next) && !scene.is_blocked(point((i, j)), point(next))
            {
                reached.insert(next);
                open.push(next);
            }
        }
    }
    reached.into_iter().map(point).collect()
}
