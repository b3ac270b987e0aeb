//! *Where am I*: the robot's pose in the map, from its wheels and from whatever corrects them.
//!
//! Takes odometry and fixes, gives a [`PoseEstimate`]. A method is a file below and a line in `Method`.

mod particles;
mod stillness;
mod tag_fixes;
mod track;

use geometry::{Base, Map, Odom, Se2, Transform2, Vec2, wrap_to_pi};
use localisation::{Health, ParticleFilter};
use messages::{OdometryReading, TagRead};
use robot_models::{BodyVelocity, DriveGeometry, OdometryNoise, PoseCovariance};
use run_context::Stamp;

use crate::{
    around::Sweep,
    says::Sentence,
    settings::{LaserMount, NavigatorSettings, PoseMethod},
    values::{PoseEstimate, PoseHealth, Rest},
};
use particles::Particles;
use stillness::Stillness;
use tag_fixes::TagFixes;
use track::Track;

/// What was remembered around the robot is in the wrong place when a fix moves the robot by more, metres.
const JUMP_M: f64 = 0.1;

/// How well tags say where the robot is, metres and radians (standard deviations): a reader sees a tag from up
/// to 6 cm away.
const TAG_STD_M: f64 = 0.03;
const TAG_STD_RAD: f64 = 0.03;

/// A way counts as straight as long as the heading stays within this, radians.
const STRAIGHT_RAD: f64 = 0.12;

/// What corrects the dead reckoning.
#[derive(Clone, Debug)]
enum Method {
    DeadReckoning,
    TagFixes {
        fixes: Box<TagFixes>,
        readers_in_base: Vec<Vec2>,
    },
    /// Nothing until there is a map.
    Particles(Option<Box<Particles>>),
}

/// The part; see the module.
#[derive(Clone, Debug)]
pub(crate) struct Locator {
    method: Method,
    drive: DriveGeometry,
    noise: OdometryNoise,
    odom_from_base: Option<Transform2<Odom, Base>>,
    track: Track,
    stillness: Stillness,
    straight_yaw_rad: f64,
    straight_from: Vec2,
    estimate: PoseEstimate,
}

impl Locator {
    pub(crate) fn new(s: &NavigatorSettings) -> Self {
        let method = match s.pose_method {
            PoseMethod::DeadReckoning => Method::DeadReckoning,
            PoseMethod::TagFixes => Method::TagFixes {
                fixes: Box::new(TagFixes::new()),
                readers_in_base: s.tags.readers_in_base.clone(),
            },
            PoseMethod::Particles => Method::Particles(None),
        };
        let estimate = PoseEstimate {
            pose: Se2::IDENTITY,
            covariance: PoseCovariance::zero(),
            map_from_odom: Transform2::new(Se2::IDENTITY),
            about: Stamp::ZERO,
            heard_at: Stamp::ZERO,
            is_heard: false,
            velocity: BodyVelocity::default(),
            is_moving: false,
            rest: Rest::Stands,
            straight_m: 0.0,
            driven_m: 0.0,
            health: PoseHealth::Sure,
        };
        Self {
            method,
            drive: s.drive,
            noise: s.odometry_noise,
            odom_from_base: None,
            track: Track::default(),
            stillness: Stillness::default(),
            straight_yaw_rad: 0.0,
            straight_from: Vec2::zeros(),
            estimate,
        }
    }

    /// The dead reckoning begins there.
    pub(crate) fn begin(&mut self, map_from_odom: Transform2<Map, Odom>) {
        let pose = map_from_odom.se2();
        self.estimate.map_from_odom = map_from_odom;
        self.estimate.pose = pose;
        self.straight_yaw_rad = pose.yaw_rad;
        self.straight_from = pose.position();
    }

    /// What is known.
    pub(crate) fn estimate(&self) -> PoseEstimate {
        self.estimate
    }

    pub(crate) fn says(&self) -> Sentence {
        let by = match self.method {
            Method::DeadReckoning => "its wheels alone",
            Method::TagFixes { .. } => "its wheels and the tags it reads",
            Method::Particles(_) => "particles on its map, weighed by its lasers",
        };
        let within_m = self.estimate.covariance.ellipse(1.0).semi_major_m;
        let at = Sentence::At { by, within_m, health: self.estimate.health };
        if self.estimate.is_heard { at } else { Sentence::NotHeard }
    }

    /// Takes what the wheels said; from where to where the robot went, if both are known.
    pub(crate) fn take_odometry(
        &mut self,
        now: Stamp,
        about: Stamp,
        odometry: &OdometryReading,
    ) -> Option<(Se2, Se2)> {
        let seen = &mut self.estimate;
        let pose = (seen.map_from_odom * odometry.odom_from_base).se2();
        let before = seen.pose;
        let rolled = seen.is_heard.then_some((before, pose));
        if rolled.is_some() {
            let moved = before.inverse().compose(pose).log();
            seen.driven_m += moved.dx_m.abs();
            let half_turn_m = 0.5 * moved.dyaw_rad * self.drive.wheelbase_m;
            seen.covariance = seen.covariance.propagated(
                before.yaw_rad,
                moved.dx_m - half_turn_m,
                moved.dx_m + half_turn_m,
                &self.drive,
                &self.noise,
            );
        }
        let wheels = odometry.wheel_speeds;
        self.stillness.note(about, wheels);
        self.track.note(about, odometry.odom_from_base.se2());
        self.odom_from_base = Some(odometry.odom_from_base);
        seen.pose = pose;
        seen.about = about;
        seen.heard_at = now;
        seen.is_heard = true;
        seen.velocity = self.drive.body_velocity(wheels);
        seen.is_moving = odometry.moving;
        seen.rest = self.stillness.rest(wheels);
        if wrap_to_pi(pose.yaw_rad - self.straight_yaw_rad).abs() > STRAIGHT_RAD {
            self.straight_yaw_rad = pose.yaw_rad;
            self.straight_from = pose.position();
        }
        let way = pose.position() - self.straight_from;
        seen.straight_m = way.dot(&pose.heading()).max(0.0);
        rolled
    }

    /// Where the robot was at that time (m, rad, map): remembered, or by its speed since the last report. `None` before
    /// what is remembered.
    pub(crate) fn pose_at(&self, time: Stamp) -> Option<Se2> {
        let seen = &self.estimate;
        if seen.is_heard && time >= seen.about {
            return Some(seen.pose_now(time));
        }
        self.track.at(time).map(|odom_from_base| seen.map_from_odom.se2().compose(odom_from_base))
    }

    /// The particles of the method of that name; the others need none.
    pub(crate) fn set_particles(&mut self, filter: ParticleFilter, lasers: &[LaserMount]) {
        if let Method::Particles(particles) = &mut self.method {
            *particles = Some(Box::new(Particles::new(filter, lasers)));
        }
    }

    /// A laser has scanned; whether the robot was moved so far in the map that what is around it must be forgotten.
    pub(crate) fn take_scan(&mut self, sweep: &Sweep<'_>) -> bool {
        let Method::Particles(Some(particles)) = &mut self.method else { return false };
        let seen = &mut self.estimate;
        let odom_from_map = seen.map_from_odom.se2().inverse();
        let odom_from_scan = odom_from_map.compose(sweep.last);
        let Some(found) = particles.take(odom_from_scan, sweep) else { return false };
        seen.health = match found.health {
            Health::Sure => PoseHealth::Sure,
            Health::Unsure => PoseHealth::Unsure,
            Health::Lost => PoseHealth::Lost,
        };
        let before = seen.position();
        let map_from_odom = found.map_from_base.se2().compose(odom_from_scan.inverse());
        seen.map_from_odom = Transform2::new(map_from_odom);
        seen.covariance = found.covariance;
        if let Some(odom_from_base) = self.odom_from_base {
            seen.pose = (seen.map_from_odom * odom_from_base).se2();
        }
        (seen.position() - before).norm() > JUMP_M
    }

    /// A reader has read a tag; whether the robot was moved so far in the map that what is around it must be
    /// forgotten.
    pub(crate) fn take_tag(&mut self, now: Stamp, read: &TagRead) -> bool {
        let Method::TagFixes { fixes, readers_in_base } = &mut self.method else { return false };
        let Some(reader) = readers_in_base.get(usize::from(read.reader)) else { return false };
        let reader_in_map = self.estimate.pose_now(now).transform_point(*reader);
        let map_from_odom = self.estimate.map_from_odom.se2();
        let reader_in_odom = map_from_odom.inverse().transform_point(reader_in_map);
        fixes.note(read.tag, read.memory.in_map, reader_in_odom);
        let (corrected, knows_heading) = fixes.corrected(map_from_odom);
        self.estimate.map_from_odom = Transform2::new(corrected);
        let Some(odom_from_base) = self.odom_from_base else { return false };
        let before = self.estimate.position();
        self.estimate.pose = (self.estimate.map_from_odom * odom_from_base).se2();
        let std_rad = knows_heading.then_some(TAG_STD_RAD);
        self.estimate.covariance = self.estimate.covariance.fixed(TAG_STD_M, std_rad);
        (self.estimate.position() - before).norm() > JUMP_M
    }

    /// Replaces the place of the dead reckoning in the map.
    pub(crate) fn relocate(&mut self, map_from_odom: Transform2<Map, Odom>) {
        self.estimate.map_from_odom = map_from_odom;
        if let Some(odom_from_base) = self.odom_from_base {
            self.estimate.pose = (map_from_odom * odom_from_base).se2();
        }
        if let Method::TagFixes { fixes, .. } = &mut self.method {
            fixes.clear();
        }
    }
}
