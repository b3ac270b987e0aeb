//! A small closed loop for one navigator: a world of segments, one person, sonars, ideal wheels.
//!
//! No wire: observations are delayed as the wire would delay them, and commands act at once.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::allow_attributes,
    reason = "every test file uses a part of the bed"
)]

use std::time::Duration;

use geometry::{
    Base, ConeScene, ConeView, Map, Odom, Polygon, Ray, RayCaster, RayHit, Se2, Segment,
    SegmentWorld, Transform2, Twist, Vec2, wrap_to_pi,
};
use messages::{
    Command, Contacts, DeviceId, Motors, N_RING_MAX, Observations, OdometryReading,
    Order as GroundOrder, Report, Ring, Sensed, Smell,
};
use navigator::{Navigator, NavigatorConfig, NavigatorSettings, Phase};
use pheromones::{Field, SenseConfig};
use rand_core::Rng;
use robot_models::{BodyVelocity, RobotModel, WheelSpeeds, ramp};
use run_context::{RandomStream, RunSeed, Stamp};
use sensor_models::{BeamSight, PlanarScan, ScanBeam, SonarModel, materials};

pub const PLASTER: u32 = 0;
pub const CARDBOARD: u32 = 5;
pub const PERSON: u32 = 6;

/// A person who walks from one point to another and on, at constant speed, and stops before robots
/// only if `yields`.
#[derive(Clone, Copy, Debug)]
pub struct Person {
    pub from: Vec2,
    pub to: Vec2,
    pub speed_mps: f64,
    pub starts: Stamp,
    pub yields: bool,
}

/// What a robot feels.
#[derive(Clone, Copy)]
pub struct Skin {
    /// From that x on there is no floor, metres.
    pub floor_ends_m: f64,
}

/// A planar laser of the bed's robot.
pub struct Laser {
    pub base_from_sensor: Se2,
    pub n_beams: usize,
    pub field_of_view_rad: f64,
    /// It sends nothing from, to.
    pub silent: Option<(Stamp, Stamp)>,
    scan: PlanarScan,
    is_due: bool,
}

/// Whose the scans of the bed are.
pub const LASER: DeviceId = DeviceId(1);

impl Laser {
    /// 361 beams over a half turn, 10 times a second, up to 8 m, over the front of a Pioneer.
    pub fn new() -> Self {
        Self {
            base_from_sensor: Se2::new(0.1, 0.0, 0.0),
            n_beams: 361,
            field_of_view_rad: std::f64::consts::PI,
            silent: None,
            scan: PlanarScan { range_min_m: 0.05, range_max_m: 8.0, ..PlanarScan::default() },
            is_due: false,
        }
    }
}

pub const PERSON_RADIUS_M: f64 = 0.2;

pub struct Scene {
    pub walls: SegmentWorld,
    pub person: Option<Vec2>,
}

impl RayCaster for Scene {
    fn cast(&self, ray: &Ray, range_max_m: f64) -> Option<RayHit> {
        let wall = self.walls.cast(ray, range_max_m);
        let person = self.person.and_then(|centre| hit_circle(ray, centre, range_max_m));
        match (wall, person) {
            (Some(a), Some(b)) => Some(if a.distance_m < b.distance_m { a } else { b }),
            (a, b) => a.or(b),
        }
    }
}

impl ConeScene for Scene {
    fn show(&self, view: &mut ConeView) {
        self.walls.show(view);
        if let Some(centre) = self.person {
            view.offer_disc(centre, PERSON_RADIUS_M, PERSON);
        }
    }
}

fn hit_circle(ray: &Ray, centre: Vec2, range_max_m: f64) -> Option<RayHit> {
    let to = centre - ray.origin;
    let along = to.dot(&ray.direction);
    let across2 = to.norm_squared() - along * along;
    let half2 = PERSON_RADIUS_M * PERSON_RADIUS_M - across2;
    if half2 < 0.0 {
        return None;
    }
    let distance_m = along - half2.sqrt();
    (distance_m > 0.0 && distance_m <= range_max_m).then(|| {
        let at = ray.origin + ray.direction * distance_m;
        RayHit { distance_m, normal: (at - centre).normalize(), tag: PERSON }
    })
}

/// What the wheels were told.
#[derive(Clone, Copy, Debug)]
enum Order {
    Drive(WheelSpeeds),
    TurnTo(f64),
}

#[derive(Clone, Debug)]
pub struct Figures {
    pub phase: Phase,
    pub time_s: f64,
    pub n_touched: u32,
    pub clearance_min_m: f64,
    pub goal_error_m: f64,
    pub heading_error_rad: f64,
    pub way_m: f64,
    pub reports: Vec<Report>,
    /// Poses every 200 ms.
    pub track: Vec<Se2>,
}

pub struct Bed {
    pub navigator: Navigator,
    pub scene: Scene,
    pub field: Field,
    pub sense: SenseConfig,
    pub model: RobotModel,
    pub sonar: SonarModel,
    pub n_sonars: usize,
    pub person: Option<Person>,
    pub world_from_base: Se2,
    pub map_from_odom: Se2,
    pub wheels: WheelSpeeds,
    order: Order,
    pub now: Stamp,
    rng: RandomStream,
    ranges_m: [f64; N_RING_MAX],
    fresh: u16,
    next_sensor: usize,
    /// When it arrives, what time it is about, and what it is.
    pending: Vec<(Stamp, Stamp, Sensed)>,
    commands: Vec<Command>,
    due: Observations,
    pub figures: Figures,
    pub server_answers: bool,
    pub server_pause: Option<(Stamp, Stamp)>,
    pub cut_link_at: Option<Stamp>,
    pub count_allocations: bool,
    /// Allocations of the navigator's last step, if they are counted.
    pub n_allocations: u64,
    pub trace: bool,
    /// Walls are solid, it has no sonars, and feels what it touches. From that x on there is no floor.
    pub feels: Option<Skin>,
    /// A planar laser in the place of sonars.
    pub laser: Option<Laser>,
    pub goal: Se2,
}

pub fn boxed(centre: Vec2, size: Vec2, yaw_rad: f64) -> Vec<(Segment, u32)> {
    let pose = Se2::new(centre.x, centre.y, yaw_rad);
    let half = size / 2.0;
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| pose.transform_point(Vec2::new(x * half.x, y * half.y)));
    (0..4).map(|i| (Segment { a: corners[i], b: corners[(i + 1) % 4] }, CARDBOARD)).collect()
}

pub fn wall(x0: f64, y0: f64, x1: f64, y1: f64) -> (Segment, u32) {
    (Segment { a: Vec2::new(x0, y0), b: Vec2::new(x1, y1) }, PLASTER)
}

pub fn trail(points: &[(f64, f64)]) -> Field {
    let mut field = Field::new(101, 101, 0.2).unwrap();
    let points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    field.draw_trail(&points, 1);
    field
}

impl Bed {
    pub fn new(
        settings: impl FnOnce(NavigatorSettings) -> NavigatorSettings,
        walls: Vec<(Segment, u32)>,
        field: Field,
        start: Se2,
        seed: u64,
    ) -> Self {
        Self::of("pioneer3dx", settings, walls, field, start, seed)
    }

    /// The same with another robot of the catalogue.
    pub fn of(
        robot: &str,
        settings: impl FnOnce(NavigatorSettings) -> NavigatorSettings,
        walls: Vec<(Segment, u32)>,
        field: Field,
        start: Se2,
        seed: u64,
    ) -> Self {
        let model = RobotModel::by_name(robot).unwrap();
        let settings = settings(NavigatorSettings::for_robot(&model));
        let config = NavigatorConfig::try_from(settings).unwrap();
        let navigator = Navigator::new(config, Transform2::<Map, Odom>::new(start));
        Self {
            navigator,
            scene: Scene { walls: SegmentWorld::new(walls), person: None },
            field,
            sense: SenseConfig::default(),
            sonar: SonarModel::default(),
            n_sonars: 8,
            person: None,
            world_from_base: start,
            map_from_odom: start,
            wheels: WheelSpeeds::ZERO,
            order: Order::Drive(WheelSpeeds::ZERO),
            now: Stamp::ZERO,
            rng: RunSeed(seed).stream("bed"),
            ranges_m: [5.0; N_RING_MAX],
            fresh: 0,
            next_sensor: 0,
            pending: Vec::new(),
            commands: Vec::with_capacity(64),
            due: Observations::new(),
            figures: Figures {
                phase: Phase::Idle,
                time_s: 0.0,
                n_touched: 0,
                clearance_min_m: 5.0,
                goal_error_m: f64::NAN,
                heading_error_rad: f64::NAN,
                way_m: 0.0,
                reports: Vec::new(),
                track: Vec::new(),
            },
            server_answers: true,
            server_pause: None,
            cut_link_at: None,
            count_allocations: false,
            n_allocations: 0,
            trace: false,
            feels: None,
            laser: None,
            goal: Se2::new(8.0, 0.0, 0.0),
            model,
        }
    }

    /// Puts in another navigator, with changed settings.
    pub fn change_settings(&mut self, change: impl FnOnce(NavigatorSettings) -> NavigatorSettings) {
        let settings = change(NavigatorSettings::for_robot(&self.model));
        let config = NavigatorConfig::try_from(settings).unwrap();
        let map_from_odom = Transform2::<Map, Odom>::new(self.map_from_odom);
        self.navigator = Navigator::new(config, map_from_odom);
    }

    /// Sends the goal after a second and runs until the task has ended or the time is over.
    pub fn run_to(&mut self, goal: Se2, limit_s: f64) -> Figures {
        for _ in 0..100 {
            self.tick();
        }
        let goal_in_map = Transform2::<Map, Base>::new(goal);
        self.tell(Sensed::Order(GroundOrder::GoTo { goal_in_map }));
        let end = self.now + Duration::from_secs_f64(limit_s);
        let begin = self.now;
        while self.now < end {
            self.tick();
            let phase = self.navigator.phase();
            if matches!(phase, Phase::Arrived | Phase::Failed(_))
                && self.now > begin + Duration::from_secs(1)
            {
                break;
            }
        }
        let offset = goal.position() - self.world_from_base.position();
        self.figures.phase = self.navigator.phase();
        self.figures.time_s = self.now.since(begin).as_secs_f64();
        self.figures.goal_error_m = offset.norm();
        self.figures.heading_error_rad = wrap_to_pi(goal.yaw_rad - self.world_from_base.yaw_rad);
        self.figures.clone()
    }

    pub fn tell(&mut self, value: Sensed) {
        self.pending.push((self.now, self.now, value));
    }

    /// Ten milliseconds.
    pub fn tick(&mut self) {
        self.now += Duration::from_millis(10);
        let ms = self.now.as_nanos() / 1_000_000;
        self.move_person();
        self.move_robot();
        if ms.is_multiple_of(40) {
            self.ping();
        }
        if ms.is_multiple_of(100) {
            self.report_status();
        }
        if ms.is_multiple_of(20) {
            self.feel();
        }
        if ms.is_multiple_of(100) {
            self.scan();
        }
        self.run_navigator();
        self.judge(ms);
    }

    fn move_person(&mut self) {
        let Some(person) = self.person else { return };
        let along = person.to - person.from;
        let walked = person.speed_mps * self.now.since(person.starts).as_secs_f64();
        let at = person.from + along.normalize() * walked.min(along.norm());
        if person.yields && self.now >= person.starts {
            let gap = (at - self.world_from_base.position()).norm();
            if gap < 0.75 && walked < along.norm() {
                // Stands until the robot has gone: time stops for this person.
                let starts = person.starts + Duration::from_millis(10);
                self.person = Some(Person { starts, ..person });
                return;
            }
        }
        self.scene.person = (self.now >= person.starts).then_some(at);
    }

    fn move_robot(&mut self) {
        let step = Duration::from_millis(10);
        let drive = &self.model.drive;
        let reference = match self.order {
            Order::Drive(wheels) => wheels,
            Order::TurnTo(heading_rad) => {
                let error_rad = wrap_to_pi(heading_rad - self.world_from_base.yaw_rad);
                // As fast as still stops in time: ω² = 2 α |error|, α = 2 a / b.
                let alpha = 0.8 * 2.0 * 0.3 / drive.wheelbase_m;
                let omega = (2.0 * alpha * error_rad.abs()).sqrt().min(0.9).copysign(error_rad);
                let omega = if error_rad.abs() < 0.01 { 0.0 } else { omega };
                drive.wheel_speeds(BodyVelocity { linear_mps: 0.0, angular_radps: omega })
            }
        };
        self.wheels = ramp(self.wheels, reference, 0.3, step);
        let velocity = drive.body_velocity(self.wheels);
        let seconds = step.as_secs_f64();
        self.figures.way_m += velocity.linear_mps.abs() * seconds;
        let before = self.world_from_base;
        self.world_from_base = before.compose(Se2::exp(Twist {
            dx_m: velocity.linear_mps * seconds,
            dy_m: 0.0,
            dyaw_rad: velocity.angular_radps * seconds,
        }));
        if self.feels.is_some() && self.scene.walls.touches_polygon(self.outline().corners()) {
            // Its wheels slip; it turns where it is.
            let yaw_rad = self.world_from_base.yaw_rad;
            self.world_from_base = Se2::new(before.x_m, before.y_m, yaw_rad);
        }
    }

    /// One sensor of each array, as the real ring does.
    fn ping(&mut self) {
        for index in (self.next_sensor..self.n_sonars).step_by(8) {
            let mount = self.model.sonars[index].base_from_sensor.se2();
            let world_from_sensor = self.world_from_base.compose(mount);
            let echo = self.sonar.ping(world_from_sensor, &self.scene, materials(), &mut self.rng);
            self.ranges_m[index] = echo.range_m;
            self.fresh |= 1 << index;
        }
        self.next_sensor = (self.next_sensor + 1) % 8;
    }

    /// The bumpers and cliff sensors of a round robot, as often as it streams.
    fn feel(&mut self) {
        let Some(skin) = self.feels else { return };
        let devices = &self.model.devices;
        let radius_m = self.model.bounding_radius_m();
        let is_pressed = |bearing_deg: f64| {
            let away = Se2::new(0.0, 0.0, bearing_deg.to_radians()).heading() * radius_m;
            let at = self.world_from_base.transform_point(away);
            self.scene.walls.nearest_distance(at, 0.008).is_some()
        };
        let mut contacts = Contacts::default();
        for (bit, bumper) in devices.bumpers.iter().enumerate() {
            let [right_deg, left_deg] = bumper.between_deg;
            let mut bearings =
                (0..=20).map(|k| right_deg + (left_deg - right_deg) * f64::from(k) / 20.0);
            contacts.bumpers |= u16::from(bearings.any(is_pressed)) << bit;
        }
        for (bit, cliff) in devices.cliffs.iter().enumerate() {
            let no_floor = self.world_from_base.transform_point(cliff.place).x > skin.floor_ends_m;
            contacts.cliffs |= u8::from(no_floor) << bit;
        }
        let arrives = self.now + Duration::from_millis(20);
        self.pending.push((arrives, self.now, Sensed::Contact(contacts)));
    }

    /// A laser that looks all at once and is heard of in the next step.
    fn scan(&mut self) {
        let Some(laser) = &mut self.laser else { return };
        if laser.silent.is_some_and(|(from, to)| self.now >= from && self.now < to) {
            return;
        }
        let sensor = self.world_from_base.compose(laser.base_from_sensor);
        laser.scan.about = self.now;
        laser.scan.number += 1;
        laser.is_due = true;
        laser.scan.beams.clear();
        for k in 0..laser.n_beams {
            let bearing_rad =
                laser.field_of_view_rad * (k as f64 / (laser.n_beams - 1) as f64 - 0.5);
            let direction = sensor.rotate(Se2::new(0.0, 0.0, bearing_rad).heading());
            let ray = Ray { origin: sensor.position(), direction };
            let noise_m = 0.03 * (f64::from(self.rng.next_u32()) / f64::from(u32::MAX) - 0.5);
            let sight = self
                .scene
                .cast(&ray, laser.scan.range_max_m)
                .map_or(BeamSight::NoReturn, |hit| BeamSight::Surface(hit.distance_m + noise_m));
            laser.scan.beams.push(ScanBeam {
                bearing_rad,
                after_s: 0.0,
                sight,
                strength_ratio: 0.0,
            });
        }
    }

    fn report_status(&mut self) {
        if self.cut_link_at.is_some_and(|at| self.now >= at) {
            return;
        }
        let odom_from_base = self.map_from_odom.inverse().compose(self.world_from_base);
        let odometry = OdometryReading {
            odom_from_base: Transform2::<Odom, Base>::new(odom_from_base),
            wheel_speeds: self.wheels,
            moving: self.wheels != WheelSpeeds::ZERO,
        };
        if self.laser.is_some() || self.feels.is_some() {
            let arrives = self.now + Duration::from_millis(20);
            self.pending.push((arrives, self.now, Sensed::Odometry(odometry)));
            return;
        }
        let ring = Ring {
            ranges_m: self.ranges_m,
            ages_ms: [0; N_RING_MAX],
            n_sensors: self.n_sonars,
            fresh: self.fresh,
        };
        self.fresh = 0;
        let arrives = self.now + Duration::from_millis(20);
        let motors = Sensed::Motors(Motors { enabled: true });
        for value in [motors, Sensed::Odometry(odometry), Sensed::Ring(ring)] {
            self.pending.push((arrives, self.now, value));
        }
    }

    fn run_navigator(&mut self) {
        let now = self.now;
        self.due.clear();
        let due = &mut self.due;
        self.pending.retain(|(at, about, value)| {
            let is_due = *at <= now;
            if is_due {
                due.push(*about, *value);
            }
            !is_due
        });
        if let Some(laser) = &mut self.laser
            && std::mem::take(&mut laser.is_due)
        {
            self.due.push_scan(LASER, &laser.scan);
        }
        self.commands.clear();
        if self.count_allocations {
            let (navigator, due, commands) = (&mut self.navigator, &self.due, &mut self.commands);
            let info = allocation_counter::measure(|| navigator.step(now, due, commands));
            self.n_allocations = info.count_total;
        } else {
            self.navigator.step(now, &self.due, &mut self.commands);
        }
        for k in 0..self.commands.len() {
            self.obey(self.commands[k]);
        }
    }

    fn obey(&mut self, command: Command) {
        match command {
            Command::Drive(wheels) => self.order = Order::Drive(wheels),
            Command::Stop => self.order = Order::Drive(WheelSpeeds::ZERO),
            Command::TurnTo { heading_in_odom_rad } => {
                let heading = wrap_to_pi(heading_in_odom_rad + self.map_from_odom.yaw_rad);
                self.order = Order::TurnTo(heading);
            }
            Command::EnableMotors(_) => {}
            Command::QueryPheromones { query, map_from_base } => {
                let paused = self.server_pause.is_some_and(|(a, b)| self.now >= a && self.now < b);
                if self.server_answers && !paused {
                    let felt = self.field.sense(map_from_base.se2(), &self.sense);
                    let (left, right) =
                        (felt.left.min(255.0).floor(), felt.right.min(255.0).floor());
                    let value = Sensed::Smell(Smell { query, left, right });
                    let arrives = self.now + Duration::from_millis(45);
                    self.pending.push((arrives, self.now, value));
                }
            }
            Command::Report(report) => {
                if self.trace {
                    println!("{} {report:?}", self.now);
                }
                self.figures.reports.push(report);
            }
        }
    }

    fn judge(&mut self, ms: u64) {
        let outline = self.outline();
        let mut touched = self.scene.walls.touches_polygon(outline.corners());
        if let Some(person) = self.scene.person {
            let gap_m = distance_to_polygon(&outline, person) - PERSON_RADIUS_M;
            self.figures.clearance_min_m = self.figures.clearance_min_m.min(gap_m);
            touched |= gap_m <= 0.0;
        }
        self.figures.n_touched += u32::from(touched);
        if ms.is_multiple_of(200) {
            self.figures.track.push(self.world_from_base);
            for corner in outline.corners() {
                let near = self.scene.walls.nearest_distance(*corner, 1.0).unwrap_or(1.0);
                self.figures.clearance_min_m = self.figures.clearance_min_m.min(near);
            }
            if self.trace {
                let view = self.navigator.view();
                let pose = self.world_from_base;
                println!(
                    "{} {:?}/{} at {:.2} {:.2} {:.0}° v {:.2}/{:.2} target {:?} P {:?} ahead {} echoes {} hit {} ranges {:.2?}",
                    self.now,
                    view.phase,
                    view.avoider_state,
                    pose.x_m,
                    pose.y_m,
                    pose.yaw_rad.to_degrees(),
                    self.wheels.left_mps,
                    self.wheels.right_mps,
                    view.target_in_map
                        .map(|t| ((t.x * 100.0).round() / 100.0, (t.y * 100.0).round() / 100.0)),
                    view.intensities,
                    view.preview_in_map.len(),
                    view.n_echoes,
                    if touched { "TOUCH" } else { "" },
                    &self.ranges_m[..8],
                );
            }
        }
    }

    fn outline(&self) -> Polygon {
        self.model.footprint.transformed(self.world_from_base)
    }
}

fn distance_to_polygon(polygon: &Polygon, point: Vec2) -> f64 {
    if polygon.contains(point) {
        return 0.0;
    }
    polygon.edges().map(|edge| edge.distance(point)).fold(f64::INFINITY, f64::min)
}
