//! What viewers of MCAP files draw by themselves: poses, transforms, paths, the scene and the log, with the public
//! Foxglove schemas ([`recordings::foxglove`]).
//!
//! | topic | schema | when |
//! | --- | --- | --- |
//! | `/tf` | `foxglove.FrameTransforms` | five times a second: where each robot believes it is, and where it truly is |
//! | `/<robot>/pose`, `/<robot>/truth` | `foxglove.PoseInFrame` | the same, one topic for each |
//! | `/<robot>/path` | `foxglove.PosesInFrame` | the way ahead, when it changes, at most once a second |
//! | `/<robot>/sonar` | `foxglove.SceneUpdate` | rays as long as what its front sonars report, when that changes, at most every 0.4 s |
//! | `/<robot>/<laser>` | `foxglove.LaserScan` | each scan of each of its lasers |
//! | `/scene` | `foxglove.SceneUpdate` | walls, things, names of rooms, trails and outlines of robots at the beginning; people five times a second; things that come and go |
//! | `/log` | `foxglove.Log` | events in words |
//!
//! Nothing here is read back: a replay runs the mission again. With more than [`N_ROBOTS_MAX`] robots there are only
//! `/tf`, `/scene` and `/log`, and transforms once a second, so that a swarm's recording stays small.

use std::time::Duration;

use geometry::{Se2, Vec2};
use recordings::foxglove::{
    Color, CylinderPrimitive, FrameTransform, FrameTransforms, LaserScan, LinePrimitive, Log,
    MESSAGE_ENCODING, PoseInFrame, PosesInFrame, SCHEMA_ENCODING, SceneEntity, SceneEntityDeletion,
    SceneUpdate, TextPrimitive, Vector3, level, schema_name, schema_text,
};
use run_context::Stamp;
use serde::Serialize;

use crate::{
    sensing::ScanRow,
    view::{LogItem, LogLevel, Pose, Scene, SceneRobot, SceneThing, ViewRobot, ViewState},
};

/// The frame that everything is given in.
const MAP: &str = "map";
/// Robots up to which each has topics of its own.
const N_ROBOTS_MAX: usize = 16;
/// Steps between two views.
const VIEW_STEPS: u64 = 20;
/// Between two paths at least.
const PATH_PERIOD: Duration = Duration::from_secs(1);
/// Between two pictures of a robot's sonars: about a round of a Pioneer's ring.
const SONAR_PERIOD: Duration = Duration::from_millis(400);
/// Steps between two transforms of a swarm.
const SWARM_STEPS: u64 = 100;

const INK: Color = Color::of([0.11, 0.15, 0.23, 1.0]);
const WOOD: Color = Color::of([0.6, 0.45, 0.3, 1.0]);
const TRAIL: Color = Color::of([0.2, 0.6, 0.35, 0.8]);
const ROBOT: Color = Color::of([0.8, 0.25, 0.15, 1.0]);
const PERSON: Color = Color::of([0.35, 0.45, 0.75, 0.9]);
const ECHO: Color = Color::of([0.9, 0.6, 0.1, 0.7]);

/// The schemas, in the order in which the format's writer numbers them here.
pub(super) const SCHEMAS: [&str; 6] =
    ["FrameTransforms", "PoseInFrame", "PosesInFrame", "SceneUpdate", "Log", "LaserScan"];

/// A channel to be announced: topic, and place in [`SCHEMAS`].
pub(super) type Wanted = (String, usize);

/// The channels of one robot.
#[derive(Debug)]
struct RobotChannels {
    pose: u16,
    truth: u16,
    path: u16,
    sonar: u16,
    lasers: Vec<u16>,
}

/// Writes what viewers draw.
#[derive(Debug, Default)]
pub(super) struct Viewers {
    transforms: u16,
    scene: u16,
    log: u16,
    robots: Vec<RobotChannels>,
    fixed: Scene,
    /// The paths that were written last, and when.
    paths: Vec<(Stamp, Vec<Vec2>)>,
    /// The sonars' readings that were written last, and when.
    readings: Vec<(Stamp, Vec<f64>)>,
    /// The things that were put down and are still there: number and corners.
    things: Vec<(u64, Vec<Vec2>)>,
    bytes: Vec<u8>,
}

/// Where a message goes: its channel and its content.
pub(super) type Tell<'t, E> = dyn FnMut(u16, &[u8]) -> Result<(), E> + 't;

/// The text and encoding of a schema, by its place in [`SCHEMAS`].
pub(super) fn schema(place: usize) -> (String, &'static str, String) {
    let name = SCHEMAS[place];
    (schema_name(name), SCHEMA_ENCODING, schema_text(name).unwrap_or_default())
}

/// How messages are encoded.
pub(super) const ENCODING: &str = MESSAGE_ENCODING;

impl Viewers {
    /// The channels of a scene, in the order in which [`Viewers::new`] wants their numbers.
    pub(super) fn wanted(scene: &Scene) -> Vec<Wanted> {
        let mut wanted =
            vec![("/tf".to_owned(), 0), ("/scene".to_owned(), 3), ("/log".to_owned(), 4)];
        if scene.robots.len() <= N_ROBOTS_MAX {
            for SceneRobot { name, scanners, .. } in &scene.robots {
                let topics = [("pose", 1), ("truth", 1), ("path", 2), ("sonar", 3)];
                wanted.extend(topics.map(|(topic, schema)| (format!("/{name}/{topic}"), schema)));
                wanted.extend(scanners.iter().map(|s| (format!("/{name}/{}", s.name), 5)));
            }
        }
        wanted
    }

    pub(super) fn new(scene: Scene, channels: &[u16]) -> Self {
        let mut channels = channels.iter().copied();
        let mut next = || channels.next().unwrap_or_default();
        let (transforms, of_scene, log) = (next(), next(), next());
        let has_own = scene.robots.len() <= N_ROBOTS_MAX;
        let robots = scene.robots.iter().filter(|_| has_own).map(|robot| RobotChannels {
            pose: next(),
            truth: next(),
            path: next(),
            sonar: next(),
            lasers: robot.scanners.iter().map(|_| next()).collect(),
        });
        let robots = robots.collect();
        Self {
            transforms,
            scene: of_scene,
            log,
            robots,
            paths: vec![(Stamp::ZERO, Vec::new()); scene.robots.len()],
            readings: vec![(Stamp::ZERO, Vec::new()); scene.robots.len()],
            fixed: scene,
            things: Vec::new(),
            bytes: Vec::new(),
        }
    }

    /// What stays where it is.
    pub(super) fn begin<E>(&mut self, now: Stamp, tell: &mut Tell<'_, E>) -> Result<(), E> {
        let entities = fixed_scene(&self.fixed, now);
        let update = SceneUpdate { deletions: Vec::new(), entities };
        // Walls are asked for once; after that they would only take memory.
        (self.fixed.walls, self.fixed.points_m) = (Vec::new(), Vec::new());
        put(&mut self.bytes, self.scene, &update, tell)
    }

    /// A view of the run, as often as views are recorded.
    pub(super) fn view<E>(
        &mut self,
        now: Stamp,
        view: &ViewState,
        tell: &mut Tell<'_, E>,
    ) -> Result<(), E> {
        if !view.step.is_multiple_of(VIEW_STEPS) {
            return Ok(());
        }
        let is_swarm = self.fixed.robots.len() > N_ROBOTS_MAX;
        if !is_swarm || view.step.is_multiple_of(SWARM_STEPS) {
            let pairs = self.fixed.robots.iter().zip(&view.robots);
            let transforms = pairs.flat_map(|(fixed, robot)| transforms_of(now, fixed, robot));
            let transforms = FrameTransforms { transforms: transforms.collect() };
            put(&mut self.bytes, self.transforms, &transforms, tell)?;
        }
        for (i, robot) in view.robots.iter().enumerate().take(self.robots.len()) {
            self.robot(now, i, robot, tell)?;
        }
        let update = self.changes(now, view);
        if update.entities.is_empty() && update.deletions.is_empty() {
            return Ok(());
        }
        put(&mut self.bytes, self.scene, &update, tell)
    }

    /// An event in words.
    pub(super) fn log<E>(
        &mut self,
        now: Stamp,
        item: &LogItem,
        tell: &mut Tell<'_, E>,
    ) -> Result<(), E> {
        let entry = Log {
            timestamp: now.into(),
            level: match item.level {
                LogLevel::Info | LogLevel::Good => level::INFO,
                LogLevel::Warn => level::WARNING,
                LogLevel::Bad => level::ERROR,
            },
            message: item.text.clone(),
            name: "cairn".to_owned(),
            file: String::new(),
            line: 0,
        };
        put(&mut self.bytes, self.log, &entry, tell)
    }

    /// A scan of one of a robot's lasers.
    pub(super) fn scan<E>(
        &mut self,
        robot: usize,
        row: &ScanRow,
        tell: &mut Tell<'_, E>,
    ) -> Result<(), E> {
        let channel = self.robots.get(robot).and_then(|r| r.lasers.get(row.laser).copied());
        let fixed = self.fixed.robots.get(robot);
        let Some((channel, fixed)) = channel.zip(fixed) else { return Ok(()) };
        let Some(scanner) = fixed.scanners.get(row.laser) else { return Ok(()) };
        let last = scanner.n_beams.saturating_sub(1) as f64;
        let seen = |range_m: &f64| range_m.is_finite().then_some((1e4 * range_m).round() / 1e4);
        let scan = LaserScan {
            timestamp: row.stamp.into(),
            frame_id: fixed.name.clone(),
            pose: scanner.base_from_sensor.into(),
            start_angle_rad: scanner.first_angle_rad,
            end_angle_rad: scanner.first_angle_rad + last * scanner.step_rad,
            ranges: row.ranges_m.iter().map(seen).collect(),
            intensities: Vec::new(),
        };
        put(&mut self.bytes, channel, &scan, tell)
    }

    fn robot<E>(
        &mut self,
        now: Stamp,
        index: usize,
        robot: &ViewRobot,
        tell: &mut Tell<'_, E>,
    ) -> Result<(), E> {
        let (channels, fixed) = (&self.robots[index], &self.fixed.robots[index]);
        let in_map = |pose: Pose| PoseInFrame {
            timestamp: now.into(),
            frame_id: MAP.to_owned(),
            pose: se2(pose).into(),
        };
        put(&mut self.bytes, channels.pose, &in_map(robot.estimate), tell)?;
        if !fixed.is_elsewhere {
            put(&mut self.bytes, channels.truth, &in_map(robot.truth), tell)?;
        }
        let (written_at, written) = &mut self.paths[index];
        if now.since(*written_at) >= PATH_PERIOD && *written != robot.preview_m {
            (*written_at, *written) = (now, robot.preview_m.clone());
            let path = PosesInFrame {
                timestamp: now.into(),
                frame_id: MAP.to_owned(),
                poses: path_poses(&robot.preview_m).map(Into::into).collect(),
            };
            put(&mut self.bytes, channels.path, &path, tell)?;
        }
        let (written_at, written) = &mut self.readings[index];
        if now.since(*written_at) < SONAR_PERIOD || *written == robot.sonar_m {
            return Ok(());
        }
        (*written_at, *written) = (now, robot.sonar_m.clone());
        let mut entity = SceneEntity::new(now, &fixed.name, &format!("{} sonar", fixed.name));
        let rays = fixed.sonars.iter().zip(&robot.sonar_m);
        let seen = rays.filter(|(sonar, range_m)| **range_m < sonar.range_max_m);
        let ends = seen.flat_map(|(sonar, range_m)| {
            let ahead = Vec2::new(*range_m, 0.0);
            let pose = sonar.base_from_sensor;
            [pose.position(), pose.transform_point(ahead)].map(Vector3::from)
        });
        entity.lines.push(LinePrimitive::new(2, ends.collect(), 1.0, ECHO));
        let update = SceneUpdate { deletions: Vec::new(), entities: vec![entity] };
        put(&mut self.bytes, channels.sonar, &update, tell)
    }

    /// People, and things that came, moved or went.
    fn changes(&mut self, now: Stamp, view: &ViewState) -> SceneUpdate {
        let mut update = SceneUpdate::default();
        for person in &view.people {
            let mut entity = SceneEntity::new(now, MAP, &person.name);
            let mut pose: recordings::foxglove::Pose = se2(person.at).into();
            pose.position.z_m = 0.85;
            let size_m = 2.0 * person.radius_m;
            entity.cylinders.push(CylinderPrimitive {
                pose,
                size: Vector3 { x_m: size_m, y_m: size_m, z_m: 1.7 },
                bottom_ratio: 1.0,
                top_ratio: 1.0,
                color: PERSON,
            });
            update.entities.push(entity);
        }
        let known = |thing: &SceneThing| {
            self.things.iter().any(|(id, corners)| *id == thing.id && *corners == thing.corners_m)
        };
        let new = view.things.iter().filter(|thing| !known(thing));
        update.entities.extend(new.map(|thing| outline(now, thing)));
        let gone = self.things.iter().filter(|(id, _)| view.things.iter().all(|t| t.id != *id));
        update.deletions.extend(gone.map(|(id, _)| SceneEntityDeletion {
            timestamp: now.into(),
            kind: 0,
            id: thing_name(*id),
        }));
        if view.things.len() != self.things.len()
            || !update.deletions.is_empty()
            || view.things.iter().any(|t| !known(t))
        {
            self.things = view.things.iter().map(|t| (t.id, t.corners_m.clone())).collect();
        }
        update
    }
}

/// A message as text, told to whoever writes it.
fn put<E>(
    bytes: &mut Vec<u8>,
    channel: u16,
    message: &impl Serialize,
    tell: &mut Tell<'_, E>,
) -> Result<(), E> {
    bytes.clear();
    match serde_json::to_writer(&mut *bytes, message) {
        Ok(()) => tell(channel, bytes),
        // Writing to memory cannot fail, and numbers that are not finite become null.
        Err(_) => Ok(()),
    }
}

fn se2(pose: Pose) -> Se2 {
    Se2::new(pose.x_m, pose.y_m, pose.yaw_rad)
}

fn transforms_of(
    now: Stamp,
    fixed: &SceneRobot,
    robot: &ViewRobot,
) -> impl Iterator<Item = FrameTransform> {
    let believed = FrameTransform::new(now, MAP, &fixed.name, se2(robot.estimate));
    let frame = format!("{}/truth", fixed.name);
    let truth = FrameTransform::new(now, MAP, &frame, se2(robot.truth));
    std::iter::once(believed).chain((!fixed.is_elsewhere).then_some(truth))
}

/// A pose at each point, looking to the next one; the last looks as the one before.
fn path_poses(points: &[Vec2]) -> impl Iterator<Item = Se2> + '_ {
    let mut yaw_rad = 0.0;
    points.iter().enumerate().map(move |(i, at)| {
        if let Some(next) = points.get(i + 1) {
            yaw_rad = (next.y - at.y).atan2(next.x - at.x);
        }
        Se2::new(at.x, at.y, yaw_rad)
    })
}

fn thing_name(id: u64) -> String {
    format!("thing {id}")
}

fn outline(now: Stamp, thing: &SceneThing) -> SceneEntity {
    let mut entity = SceneEntity::new(now, MAP, &thing_name(thing.id));
    let corners = thing.corners_m.iter().map(|&corner| corner.into()).collect();
    entity.lines.push(LinePrimitive::new(1, corners, 2.0, WOOD));
    entity
}

fn fixed_scene(scene: &Scene, now: Stamp) -> Vec<SceneEntity> {
    let half_m = 0.5 * POINT_M;
    let mut walls = SceneEntity::new(now, MAP, "walls");
    let ends = scene.walls.iter().flat_map(|wall| [wall.a, wall.b]);
    // A point of a scanned map is a dash.
    let dashes =
        scene.points_m.iter().flat_map(|p| [-half_m, half_m].map(|x| p + Vec2::new(x, 0.0)));
    let lines = ends.chain(dashes).map(Vector3::from).collect();
    walls.lines.push(LinePrimitive::new(2, lines, 2.0, INK));
    let mut trail = SceneEntity::new(now, MAP, "planned path");
    let way = scene.planned_path_m.iter().map(|&p| p.into()).collect();
    trail.lines.push(LinePrimitive::new(0, way, 2.0, TRAIL));
    let mut rooms = SceneEntity::new(now, MAP, "rooms");
    rooms.texts.extend(scene.rooms.iter().map(|(name, at)| TextPrimitive {
        pose: Se2::new(at.x, at.y, 0.0).into(),
        billboard: true,
        font_size_m: 0.3,
        scale_invariant: false,
        color: INK,
        text: name.clone(),
    }));
    let things = scene.things.iter().map(|thing| outline(now, thing));
    let bodies = scene.robots.iter().map(|robot| {
        let mut entity = SceneEntity::new(now, &robot.name, &robot.name);
        let corners = robot.footprint_m.iter().map(|&corner| corner.into()).collect();
        entity.lines.push(LinePrimitive::new(1, corners, 2.0, ROBOT));
        entity
    });
    [walls, trail, rooms].into_iter().chain(things).chain(bodies).collect()
}

/// Length of the dash that stands for a point of a scanned map, m.
const POINT_M: f64 = 0.02;
