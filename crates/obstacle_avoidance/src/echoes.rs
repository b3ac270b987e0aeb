//! A short memory of echoes: where things were heard in the last seconds, around the robot.
//!
//! Eight sonars that fire in turn see the world through a keyhole. Remembering a few seconds of
//! echoes in the dead-reckoned frame lets a robot check a straight leg or a turn in place before it
//! drives them. This is no map: it is small, forgets by age, and forgets what a later reading saw
//! through. An extension of ours; the thesis reacts to the latest readings only.

mod rays;

use std::time::Duration;

use geometry::{Se2, Vec2};
use run_context::Stamp;

pub use rays::{Ray, Rays};

use crate::{Footprint, RangeSensor, footprint::distance_to_segment_m};

/// Settings of an [`EchoMemory`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EchoMemoryConfig {
    /// Greatest number of echoes; the oldest makes room.
    pub capacity: usize,
    /// How long an echo is believed without being heard again.
    pub lifetime: Duration,
    /// A reading of this or more means that nothing was heard, metres.
    pub silence_m: f64,
    /// Longer ranges are not remembered, metres: far echoes are vague across the beam.
    pub range_max_m: f64,
    /// Half the opening of a beam, radians.
    pub half_angle_rad: f64,
    /// Echoes nearer to each other than this are one, metres.
    pub merge_m: f64,
}

impl Default for EchoMemoryConfig {
    fn default() -> Self {
        Self {
            capacity: 256,
            lifetime: Duration::from_secs(12),
            silence_m: 4.9,
            range_max_m: 2.0,
            half_angle_rad: 15.0_f64.to_radians(),
            merge_m: 0.03,
        }
    }
}

/// One remembered echo.
#[derive(Clone, Copy, Debug)]
struct Echo {
    at: Vec2,
    /// Unit vector from the sensor to the echo when it was first heard.
    away: Vec2,
    heard: Stamp,
    n_seen_through: u8,
    /// Whose it is: each sensor forgets only its own, since a laser sees through glass that a sonar hears.
    by: u8,
}

/// Echoes of rings of sonars.
const BY_RING: u8 = 0;

/// Where things were heard lately. All points are in one fixed frame, the one of the poses given.
#[derive(Clone, Debug)]
pub struct EchoMemory {
    config: EchoMemoryConfig,
    echoes: Vec<Echo>,
}

/// A later reading must exceed an echo's distance by this much to see through it, metres.
const SEE_THROUGH_M: f64 = 0.25;

/// So many votes must see through an echo before it is forgotten: one may be a lost echo.
const N_SEE_THROUGH: u8 = 6;

/// Votes of a reading that heard something else farther away.
const VOTES_OF_ECHO: u8 = 3;

/// Votes of a reading that heard nothing: a smooth surface that is seen obliquely is silent, too.
const VOTES_OF_SILENCE: u8 = 1;

/// Neighbouring sensors whose ranges differ by less than this hear the same thing, metres.
const SAME_THING_M: f64 = 0.2;

impl EchoMemory {
    /// An empty memory; allocates all it will ever need.
    pub fn new(config: EchoMemoryConfig) -> Self {
        Self { config, echoes: Vec::with_capacity(config.capacity.max(1)) }
    }

    /// Number of echoes remembered.
    pub fn len(&self) -> usize {
        self.echoes.len()
    }

    /// Whether nothing is remembered.
    pub fn is_empty(&self) -> bool {
        self.echoes.is_empty()
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.echoes.clear();
    }

    /// Forgets what lies more than `depth_m` inside the outline at `pose`: the robot is there.
    pub fn forget_inside(&mut self, pose: Se2, footprint: &Footprint, depth_m: f64) {
        let to_base = pose.inverse();
        self.echoes.retain(|e| footprint.depth_m(to_base.transform_point(e.at)) < depth_m);
    }

    /// The remembered places (m), oldest first only by chance.
    pub fn points(&self) -> impl Iterator<Item = Vec2> + '_ {
        self.echoes.iter().map(|e| e.at)
    }

    /// Takes in the readings of the sensors whose bit in `fresh` is set, made at `pose`.
    ///
    /// `ranges_m[i]` belongs to `sensors[i]`. O(sensors × echoes), no allocation.
    pub fn observe(
        &mut self,
        now: Stamp,
        pose: Se2,
        sensors: &[RangeSensor],
        ranges_m: &[f64],
        fresh: u32,
    ) {
        let lifetime = self.config.lifetime;
        self.echoes.retain(|e| now.since(e.heard) <= lifetime);
        for (index, (sensor, &range_m)) in sensors.iter().zip(ranges_m).enumerate() {
            if fresh >> index & 1 == 1 && range_m.is_finite() && range_m > 0.0 {
                self.forget_seen_through(pose, sensor, range_m);
                if range_m <= self.config.range_max_m && range_m < self.config.silence_m {
                    let bearing_rad = self.bearing_of_echo(sensors, ranges_m, index);
                    let mouth = pose.transform_point(sensor.in_base);
                    let away = Se2::new(0.0, 0.0, pose.yaw_rad + bearing_rad).heading();
                    self.remember(now, mouth + away * range_m, away);
                }
            }
        }
    }

    /// Least distance (m) from any echo to the segment from `from` to `to`; infinite without echoes.
    ///
    /// Every echo is taken to be `depth_m` deep, away from where it was first heard, because the
    /// far side of a thing is not heard.
    pub fn clearance_of_leg_m(&self, from: Vec2, to: Vec2, depth_m: f64) -> f64 {
        let mut least_m = f64::INFINITY;
        for echo in &self.echoes {
            for share in [0.0, 0.5, 1.0] {
                let point = echo.at + echo.away * (share * depth_m);
                least_m = least_m.min(distance_to_segment_m(point, from, to));
                if depth_m <= 0.0 {
                    break;
                }
            }
        }
        least_m
    }

    /// How far along a polyline (m) the first thing lies that is within `half_width_m` of it, of those
    /// heard at or after `heard_since`; `None` when the way is free.
    ///
    /// Things beside or behind its first point do not count. O(points × echoes).
    pub fn first_on_path_m(
        &self,
        path: &[Vec2],
        half_width_m: f64,
        heard_since: Stamp,
    ) -> Option<f64> {
        let mut before_m = 0.0;
        let mut first_m: Option<f64> = None;
        for pair in path.windows(2) {
            let along = pair[1] - pair[0];
            let length_m = along.norm();
            if length_m < 1e-9 {
                continue;
            }
            let direction = along / length_m;
            // Most echoes lie far from this piece of the way.
            let slack = Vec2::repeat(half_width_m + 1e-9);
            let (low, high) = (pair[0].inf(&pair[1]) - slack, pair[0].sup(&pair[1]) + slack);
            let is_near = |at: Vec2| at >= low && at <= high;
            for echo in self.echoes.iter().filter(|e| e.heard >= heard_since) {
                if !is_near(echo.at) {
                    continue;
                }
                let offset = echo.at - pair[0];
                let share_m = offset.dot(&direction).clamp(0.0, length_m);
                let here_m = before_m + share_m;
                let near = (offset - direction * share_m).norm() <= half_width_m;
                if near && here_m > 0.0 && first_m.is_none_or(|first| here_m < first) {
                    first_m = Some(here_m);
                }
            }
            before_m += length_m;
        }
        first_m
    }

    /// Forgets what lies within `half_width_m` of a polyline and was not heard at or after `heard_since`: a robot
    /// that stood and listened found the way clear. O(points × echoes).
    pub fn forget_on_path(&mut self, path: &[Vec2], half_width_m: f64, heard_since: Stamp) {
        self.echoes.retain(|e| {
            let on_path =
                |pair: &[Vec2]| distance_to_segment_m(e.at, pair[0], pair[1]) <= half_width_m;
            e.heard >= heard_since || !path.windows(2).any(on_path)
        });
    }

    /// Least distance (m) between the outline at `pose` and any echo; infinite without echoes.
    pub fn clearance_m(&self, pose: Se2, footprint: &Footprint) -> f64 {
        let to_base = pose.inverse();
        let distances =
            self.echoes.iter().map(|e| footprint.distance_m(to_base.transform_point(e.at)));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Least distance (m) to any echo while turning in place from `pose` by `turn_rad`.
    pub fn clearance_of_turn_m(&self, pose: Se2, turn_rad: f64, footprint: &Footprint) -> f64 {
        let near_m = footprint.turning_radius_m() + 0.3;
        let near = self.echoes.iter().filter(|e| (e.at - pose.position()).norm() < near_m);
        let distances = near.map(|e| footprint.distance_while_turning_m(pose, turn_rad, e.at));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Which way an echo came from: the axis, drawn towards a neighbour that hears the same.
    ///
    /// When two neighbours report about the same distance, the thing lies where their beams meet.
    fn bearing_of_echo(&self, sensors: &[RangeSensor], ranges_m: &[f64], index: usize) -> f64 {
        let own = sensors[index].bearing_rad;
        let same = |other: Option<usize>| {
            let other = other.filter(|&o| o < sensors.len().min(ranges_m.len()))?;
            let gap = sensors[other].bearing_rad - own;
            let alike = (ranges_m[other] - ranges_m[index]).abs() < SAME_THING_M;
            (alike && gap.abs() < 3.0 * self.config.half_angle_rad).then_some(gap)
        };
        let gaps = [same(index.checked_sub(1)), same(Some(index + 1))];
        match gaps {
            // Between two that agree, the axis itself is the best guess.
            [Some(gap), None] | [None, Some(gap)] => {
                own + (0.5 * gap).clamp(-self.config.half_angle_rad, self.config.half_angle_rad)
            }
            _ => own,
        }
    }

    fn forget_seen_through(&mut self, pose: Se2, sensor: &RangeSensor, range_m: f64) {
        let mouth = pose.transform_point(sensor.in_base);
        let axis = Se2::new(0.0, 0.0, pose.yaw_rad + sensor.bearing_rad).heading();
        // Only the middle of the beam: at its rim an echo is easily missed.
        let core = (0.6 * self.config.half_angle_rad).cos();
        let heard_something = range_m < self.config.silence_m;
        let votes = if heard_something { VOTES_OF_ECHO } else { VOTES_OF_SILENCE };
        self.echoes.retain_mut(|echo| {
            if echo.by != BY_RING {
                return true;
            }
            let offset = echo.at - mouth;
            let distance_m = offset.norm();
            if distance_m + SEE_THROUGH_M < range_m && offset.dot(&axis) > core * distance_m {
                echo.n_seen_through += votes;
            }
            echo.n_seen_through < N_SEE_THROUGH
        });
    }

    fn remember(&mut self, now: Stamp, at: Vec2, away: Vec2) {
        let merge_m = self.config.merge_m;
        if let Some(known) =
            self.echoes.iter_mut().find(|e| e.by == BY_RING && (e.at - at).norm() < merge_m)
        {
            known.heard = now;
            known.n_seen_through = 0;
            return;
        }
        self.add(Echo { at, away, heard: now, n_seen_through: 0, by: BY_RING });
    }

    fn add(&mut self, echo: Echo) {
        if self.echoes.len() < self.config.capacity.max(1) {
            self.echoes.push(echo);
        } else if let Some(oldest) = self.echoes.iter_mut().min_by_key(|e| e.heard) {
            *oldest = echo;
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;

    const AHEAD: RangeSensor = RangeSensor { in_base: Vec2::new(0.2, 0.0), bearing_rad: 0.0 };

    fn memory() -> EchoMemory {
        EchoMemory::new(EchoMemoryConfig { capacity: 3, ..EchoMemoryConfig::default() })
    }

    fn at(ms: u64) -> Stamp {
        Stamp::from_millis(ms)
    }

    #[test]
    fn an_echo_is_placed_where_it_was_heard() {
        let mut memory = memory();
        let pose = Se2::new(1.0, 2.0, std::f64::consts::FRAC_PI_2);
        memory.observe(at(0), pose, &[AHEAD], &[0.5], 1);
        let point = memory.points().next().unwrap();
        assert!((point - Vec2::new(1.0, 2.7)).norm() < 1e-12, "{point}");
        // Not fresh, too far, or not a number: nothing is remembered.
        for (range, fresh) in [(0.9, 0), (2.1, 1), (f64::NAN, 1), (0.0, 1)] {
            memory.observe(at(1), pose, &[AHEAD], &[range], fresh);
        }
        assert_eq!(memory.len(), 1);
    }

    #[test]
    fn silence_of_a_short_sensor_leaves_no_echo() {
        let config = EchoMemoryConfig { silence_m: 1.96, ..EchoMemoryConfig::default() };
        let mut memory = EchoMemory::new(config);
        // A sensor that reaches 2 m reads 2 m when it hears nothing.
        memory.observe(at(0), Se2::IDENTITY, &[AHEAD], &[2.0], 1);
        assert_eq!(memory.len(), 0);
        memory.observe(at(0), Se2::IDENTITY, &[AHEAD], &[1.9], 1);
        assert_eq!(memory.len(), 1);
    }

    #[test]
    fn echoes_are_forgotten_by_age_and_by_being_seen_through() {
        let mut memory = memory();
        memory.observe(at(0), Se2::IDENTITY, &[AHEAD], &[0.5], 1);
        memory.observe(at(100), Se2::IDENTITY, &[AHEAD], &[3.0], 1);
        assert_eq!(memory.len(), 1, "one reading may be a lost echo");
        memory.observe(at(200), Se2::IDENTITY, &[AHEAD], &[3.0], 1);
        assert!(memory.is_empty());

        // Silence counts less than an echo from farther away.
        memory.observe(at(210), Se2::IDENTITY, &[AHEAD], &[0.5], 1);
        for ms in 0..5 {
            memory.observe(at(211 + ms), Se2::IDENTITY, &[AHEAD], &[5.0], 1);
            assert_eq!(memory.len(), 1);
        }
        memory.observe(at(220), Se2::IDENTITY, &[AHEAD], &[5.0], 1);
        assert!(memory.is_empty());

        memory.observe(at(300), Se2::IDENTITY, &[AHEAD], &[0.5], 1);
        memory.observe(at(12_300), Se2::IDENTITY, &[AHEAD], &[3.0], 0);
        assert_eq!(memory.len(), 1);
        memory.observe(at(12_301), Se2::IDENTITY, &[AHEAD], &[3.0], 0);
        assert!(memory.is_empty());
    }

    #[test]
    fn the_oldest_makes_room_and_equal_places_merge() {
        let mut memory = memory();
        for (ms, range) in [(0, 0.5), (10, 0.7), (20, 0.71), (30, 0.9), (40, 1.1)] {
            memory.observe(at(ms), Se2::IDENTITY, &[AHEAD], &[range], 1);
        }
        let mut ranges: Vec<f64> = memory.points().map(|p| p.x - 0.2).collect();
        ranges.sort_by(f64::total_cmp);
        assert_eq!(memory.len(), 3);
        assert!((ranges[0] - 0.7).abs() < 1e-9 && (ranges[2] - 1.1).abs() < 1e-9, "{ranges:?}");
    }

    #[test]
    fn two_neighbours_that_agree_share_the_bearing() {
        let mut memory = memory();
        let sensor =
            |deg: f64| RangeSensor { in_base: Vec2::new(0.0, 0.0), bearing_rad: deg.to_radians() };
        let sensors = [sensor(30.0), sensor(10.0), sensor(-10.0)];
        memory.observe(at(0), Se2::IDENTITY, &sensors, &[1.0, 1.1, 4.0], 0b001);
        let point = memory.points().next().unwrap();
        assert!((point.y.atan2(point.x).to_degrees() - 20.0).abs() < 1e-9);
    }

    #[test]
    fn the_first_thing_on_a_bent_path_is_found() {
        let mut memory = memory();
        memory.observe(at(100), Se2::IDENTITY, &[AHEAD], &[0.8], 1); // an echo at (1, 0)
        let path = [Vec2::new(0.0, 0.0), Vec2::new(0.5, 0.0), Vec2::new(0.5, 2.0)];
        assert_eq!(memory.first_on_path_m(&path, 0.3, at(0)), None);
        assert_eq!(memory.first_on_path_m(&path[..2], 0.6, at(0)), Some(0.5));
        let straight = [Vec2::new(-1.0, 0.2), Vec2::new(3.0, 0.2)];
        assert_eq!(memory.first_on_path_m(&straight, 0.3, at(0)), Some(2.0));
        assert_eq!(memory.first_on_path_m(&straight, 0.3, at(101)), None);
        assert_eq!(memory.first_on_path_m(&straight, 0.1, at(0)), None);
        // Behind the start.
        let beyond = [Vec2::new(1.1, 0.0), Vec2::new(3.0, 0.0)];
        assert_eq!(memory.first_on_path_m(&beyond, 0.3, at(0)), None);
        assert_eq!(memory.first_on_path_m(&[], 0.3, at(0)), None);
    }

    #[test]
    fn a_path_that_was_found_clear_is_forgotten_and_nothing_else() {
        let mut memory = memory();
        memory.observe(at(0), Se2::IDENTITY, &[AHEAD], &[0.8], 1); // an echo at (1, 0)
        let path = [Vec2::new(0.0, 0.2), Vec2::new(2.0, 0.2)];
        memory.forget_on_path(&path, 0.19, at(1));
        memory.forget_on_path(&path, 0.3, at(0));
        memory.forget_on_path(&path[..1], 0.3, at(1));
        assert_eq!(memory.len(), 1, "beside it, heard since, no path");
        memory.forget_on_path(&path, 0.3, at(1));
        assert!(memory.is_empty());
    }

    #[test]
    fn legs_turns_and_depth_are_measured() {
        let mut memory = memory();
        memory.observe(at(0), Se2::IDENTITY, &[AHEAD], &[0.8], 1); // an echo at (1, 0)
        let leg = |y: f64, x0: f64, x1: f64, depth| {
            memory.clearance_of_leg_m(Vec2::new(x0, y), Vec2::new(x1, y), depth)
        };
        assert!((leg(0.4, 0.0, 2.0, 0.0) - 0.4).abs() < 1e-12);
        assert!((leg(0.0, 0.0, 0.5, 0.0) - 0.5).abs() < 1e-12);
        // Passing behind it is only free if it is not deep.
        assert!((leg(0.0, 1.4, 2.0, 0.0) - 0.4).abs() < 1e-12);
        assert!(leg(0.0, 1.4, 2.0, 0.4) < 1e-12);
        let outline = Footprint::rectangle(0.21, 0.301, 0.2125).unwrap();
        assert!((memory.clearance_m(Se2::IDENTITY, &outline) - 0.79).abs() < 1e-12);
        let beside = Se2::new(1.05, -0.30, 0.0);
        assert!(memory.clearance_of_turn_m(beside, -0.9, &outline) < 0.01);
        assert!(memory.clearance_of_turn_m(beside, 0.0, &outline) > 0.08);
        memory.forget_inside(Se2::new(0.8, 0.0, 0.0), &outline, 0.02);
        assert_eq!(memory.len(), 1, "only 10 mm inside");
        memory.forget_inside(Se2::new(0.9, 0.0, 0.0), &outline, 0.02);
        assert!(memory.is_empty());
        assert_eq!(self::memory().clearance_m(Se2::IDENTITY, &outline), f64::INFINITY);
    }
}
