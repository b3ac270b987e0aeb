//! *What is around*: remembered echoes, the latest ranges, and what touches the robot.
//!
//! A scan of a planar laser is remembered like echoes, and what its beams passed through is forgotten at once; for a robot
//! without a ring it also stands for one, in sectors. A laser that is silent makes such a robot blind, not free.
//!
//! Only [`Surroundings::take_ring`] and its like change it; to all other parts it answers questions: what stands on a
//! way, whether a turn is free, how far the robot may back off.

mod lasers;
mod touch;

use std::time::Duration;

use geometry::{Se2, Vec2};
use messages::{Contacts, N_RING_MAX, Ring};
use obstacle_avoidance::{Bubble, EchoMemory, Footprint, RangeSensor};
use run_context::Stamp;

use lasers::Lasers;
use touch::Touch;

pub(crate) use lasers::{Sweep, sectors};

use crate::{
    says::Sentence,
    settings::{Avoidance, NavigatorSettings},
    values::{PoseEstimate, Situation, Way},
};

/// What a turn in place must leave free, metres: echoes are a few centimetres wrong.
const TURN_MARGIN_M: f64 = 0.02;

/// Way after which the side sensors have heard all that is beside the robot, metres.
const KNOWS_ITS_SIDES_AFTER_M: f64 = 0.4;

/// What lies so deep inside the outline of the robot cannot be there, metres.
const INSIDE_M: f64 = 0.02;

/// How far to back off for another look, metres: over ground the robot has just come from.
pub(crate) const RETREAT_M: f64 = 0.25;

/// The part; see the module.
#[derive(Clone, Debug)]
pub(crate) struct Surroundings {
    echoes: EchoMemory,
    ring: Option<Ring>,
    /// It has a ring of its own.
    hears: bool,
    lasers: Lasers,
    contacts: Option<Contacts>,
    /// It feels, and does not look where it goes.
    touch: Option<Touch>,
    sensors: Vec<RangeSensor>,
    floors_m: Vec<f64>,
    bubble: Bubble,
    footprint: Footprint,
    /// Somebody cares what is around.
    is_heeded: bool,
    cruise_mps: f64,
    period_s: f64,
    range_max_m: f64,
}

impl Surroundings {
    /// `hears` if the robot has a ring of its own; else what its lasers see in sectors stands for one.
    pub(crate) fn new(
        s: &NavigatorSettings,
        bubble: Bubble,
        footprint: Footprint,
        hears: bool,
    ) -> Self {
        let silent_after = Duration::from_secs_f64(s.laser_limit_s);
        Self {
            echoes: EchoMemory::new(s.echoes),
            ring: None,
            hears,
            lasers: Lasers::new(&s.lasers, silent_after, &footprint, s.range_max_m),
            contacts: None,
            touch: (s.avoidance == Avoidance::Contact)
                .then(|| Touch::new(&s.contacts, &s.sensors, s.range_max_m)),
            sensors: s.sensors.clone(),
            floors_m: s.bubble_floors_m.clone(),
            bubble,
            footprint,
            is_heeded: s.avoidance != Avoidance::Off,
            cruise_mps: s.speed_mps,
            period_s: s.control_period_s,
            range_max_m: s.range_max_m,
        }
    }

    /// The same with room for all echoes, which a clone has not.
    pub(crate) fn with_room(mut self, s: &NavigatorSettings) -> Self {
        self.echoes = EchoMemory::new(s.echoes);
        self.lasers = self.lasers.with_room();
        self
    }

    pub(crate) fn says(&self) -> Sentence {
        Sentence::Around {
            n_echoes: self.echoes.len(),
            nearest_m: self.ranges_m().iter().copied().reduce(f64::min),
            is_touched: self.is_touched(),
        }
    }

    /// Takes the ranges of a ring that were measured around `pose`.
    pub(crate) fn take_ring(&mut self, about: Stamp, pose: Se2, ring: &Ring) {
        if self.touch.is_none() {
            let fresh = u32::from(ring.fresh);
            self.echoes.observe(about, pose, &self.sensors, ring.ranges_m(), fresh);
        }
        self.ring = Some(*ring);
    }

    /// Takes a scan that has just come; whether one of the robot's lasers made it.
    pub(crate) fn take_scan(&mut self, now: Stamp, sweep: &Sweep<'_>) -> bool {
        let Some((laser, rays)) = self.lasers.take(now, sweep) else { return false };
        self.echoes.observe_rays(now, laser, rays);
        true
    }

    /// Whether the robot must not drive because what it looks with is silent: that is unseen, not free.
    pub(crate) fn is_blind(&self, now: Stamp) -> bool {
        self.is_heeded && !self.hears && self.touch.is_none() && self.lasers.is_one_silent(now)
    }

    pub(crate) fn take_contacts(&mut self, about: Stamp, contacts: Contacts) {
        if let Some(touch) = &mut self.touch {
            touch.take(about, contacts);
        }
        self.contacts = Some(contacts);
    }

    /// The robot is at `pose`, so nothing else is.
    pub(crate) fn stand_at(&mut self, pose: Se2) {
        self.echoes.forget_inside(pose, &self.footprint, INSIDE_M);
    }

    /// Forgets what was remembered in the map.
    pub(crate) fn forget(&mut self) {
        self.echoes.clear();
    }

    /// A robot that stood and listened found its way clear: what it heard there before has gone.
    pub(crate) fn forget_on_way(&mut self, way: &Way, beside_m: f64, heard_since: Stamp) {
        let width_m = self.footprint.half_width_m() + beside_m;
        self.echoes.forget_on_path(way.points(), width_m, heard_since);
    }

    pub(crate) fn footprint(&self) -> &Footprint {
        &self.footprint
    }

    pub(crate) fn echoes(&self) -> &EchoMemory {
        &self.echoes
    }

    pub(crate) fn sensors(&self) -> &[RangeSensor] {
        &self.sensors
    }

    /// The latest ranges of its ring, or of the sectors of its lasers or of its skin.
    pub(crate) fn ring(&self) -> Option<&Ring> {
        if let Some(touch) = &self.touch {
            return Some(touch.heard());
        }
        self.ring.as_ref().or(self.lasers.heard())
    }

    /// Sensors of its own ring.
    pub(crate) fn n_sonars(&self) -> usize {
        self.ring.as_ref().map_or(0, |ring| ring.n_sensors)
    }

    /// The latest ranges, metres; empty without a ring.
    pub(crate) fn ranges_m(&self) -> &[f64] {
        self.ring().map_or(&[], Ring::ranges_m)
    }

    /// Ranges of the first eight sensors for a report, metres; the greatest where there is none.
    pub(crate) fn reported_ranges_m(&self) -> [f64; 8] {
        let mut ranges_m = [self.range_max_m; 8];
        let known = self.ring.as_ref().map_or(&[][..], Ring::ranges_m);
        let known = &known[..known.len().min(8)];
        ranges_m[..known.len()].copy_from_slice(known);
        ranges_m
    }

    /// Whether anything touches the robot, as far as it has said.
    pub(crate) fn is_touched(&self) -> bool {
        self.contacts.is_some_and(|contacts| contacts.any())
    }

    /// How far along a way (m, from the axle) the first thing stands within `beside_m` of the robot's side, of those
    /// heard since.
    pub(crate) fn first_on_way_m(
        &self,
        way: &Way,
        beside_m: f64,
        heard_since: Stamp,
    ) -> Option<f64> {
        let width_m = self.footprint.half_width_m() + beside_m;
        self.echoes.first_on_path_m(way.points(), width_m, heard_since)
    }

    /// Whether the goal is within reach and nothing was heard on the straight way to it.
    pub(crate) fn goal_is_straight_ahead(&self, situation: &Situation, within_m: f64) -> bool {
        let Some(goal) = situation.goal_point() else { return false };
        let from = situation.at.position();
        let away_m = (goal - from).norm();
        if away_m > within_m {
            return false;
        }
        let half_width_m = self.footprint.half_width_m();
        away_m < 0.1 || self.echoes.clearance_of_leg_m(from, goal, 0.0) > half_width_m
    }

    /// Whether the bubble of a robot at that speed is hurt.
    pub(crate) fn bubble_is_hurt(&self, speed_mps: f64) -> bool {
        self.bubble.check(self.ranges_m(), speed_mps, self.period_s).first.is_some()
    }

    /// The bubble's boundary, for show (m).
    pub(crate) fn bubble_limits_m(&self, speed_mps: f64) -> [f64; N_RING_MAX] {
        let mut limits_m = [0.0; N_RING_MAX];
        let speed_mps = speed_mps.abs().max(0.5 * self.cruise_mps);
        self.bubble.limits(speed_mps, self.period_s, &mut limits_m);
        limits_m
    }

    /// The last line: sensors that look ahead read less than their floor, wherever we think we go, of a robot that
    /// drives, or was told to, at `speed_mps`. A slow robot needs less.
    pub(crate) fn something_is_at_the_nose(&self, speed_mps: f64, end_m: f64) -> bool {
        let pace = (speed_mps / self.cruise_mps).clamp(0.6, 1.0);
        let floors = self.sensors.iter().zip(&self.floors_m);
        floors.zip(self.ranges_m()).any(|((sensor, floor_m), range_m)| {
            let floor_m = (pace * floor_m).min(end_m + 0.05);
            sensor.bearing_rad.abs() < 1.1 && floor_m > 0.0 && *range_m <= floor_m
        })
    }

    /// Whether turning in place touches nothing that was heard lately.
    pub(crate) fn turn_is_safe(&self, at: &PoseEstimate, turn_rad: f64) -> bool {
        if !self.is_heeded {
            return true;
        }
        let clearance_m = self.echoes.clearance_of_turn_m(at.pose, turn_rad, &self.footprint);
        clearance_m > TURN_MARGIN_M && !self.tail_may_hit_a_wall(at, turn_rad)
    }

    /// Where the robot was switched on it has heard nothing beside its tail yet: what a side sensor
    /// hears then is taken to go on backwards, like a wall.
    pub(crate) fn tail_may_hit_a_wall(&self, at: &PoseEstimate, turn_rad: f64) -> bool {
        if !self.is_heeded || self.touch.is_some() || at.driven_m >= KNOWS_ITS_SIDES_AFTER_M {
            return false;
        }
        let footprint = &self.footprint;
        let reach_m = footprint.turning_radius_m() + TURN_MARGIN_M;
        let mut readings = self.sensors.iter().zip(self.ranges_m());
        readings.any(|(sensor, range_m)| {
            let sine = sensor.bearing_rad.sin();
            let aside_m = sensor.in_base.y + range_m * sine;
            // Turning to the right swings the tail to the left.
            let swings_there = aside_m * turn_rad < 0.0;
            sine.abs() > 0.94 && swings_there && aside_m.abs() < reach_m && {
                let wall = (0..8).map(|k| Vec2::new(-0.05 * f64::from(k), aside_m));
                let mut gaps =
                    wall.map(|p| footprint.distance_while_turning_m(Se2::IDENTITY, turn_rad, p));
                gaps.any(|gap_m| gap_m < TURN_MARGIN_M)
            }
        })
    }

    /// How far the robot may back off, metres: over the straight way it has just come, or where the side
    /// sonars have heard enough to know.
    pub(crate) fn retreat_room_m(&self, at: &PoseEstimate) -> f64 {
        let known_m = at.straight_m.min(RETREAT_M);
        let behind = |m: f64| {
            let heading = at.pose.heading();
            Se2::new(at.pose.x_m - heading.x * m, at.pose.y_m - heading.y * m, at.pose.yaw_rad)
        };
        let steps = (1..=5).map(|k| 0.05 * f64::from(k)).take_while(|m| {
            *m <= known_m + 0.02 && self.echoes.clearance_m(behind(*m), &self.footprint) > 0.03
        });
        steps.fold(0.0, f64::max)
    }
}
