//! Following a trail of tags in the floor: a part with a state of its own.
//!
//! It is told what readers read and how far the robot rolled, and says what to do next: where to turn to look for
//! the trail, how to follow it, how to look for it when it is lost. It knows neither the server nor the phases of
//! the navigator.
//!
//! Source: the thesis, 5.3.2. Differences: it says nothing on how a robot finds a trail of tags, its direction, or
//! the trail again; here it turns once around itself, and drives on towards the side that smelled the trail last.

use geometry::{Se2, Vec2, wrap_to_pi};
use path_following::{
    SettingError, Side, TagFollower, TagFollowerConfig, TagStep, WheelReference, pursue,
};

use messages::TagRead;

use crate::settings::{N_TAG_READERS_MAX, TagController, TagSettings};

/// Pieces in which the robot turns around itself.
const N_LOOKS: u32 = 3;

/// Directions that are told apart while looking around.
const N_BINS: usize = 24;

/// A direction counts as one of the trail from this part of the strongest on.
const TRAIL_RATIO: f64 = 0.6;

/// A robot on the trail that looks so nearly towards its goal sets off without looking around, radians.
const TOWARDS_GOAL_RAD: f64 = 1.05;

/// A look-ahead point so nearly ahead is driven to without turning first, radians.
const TOWARDS_POINT_RAD: f64 = 0.3;

/// Speed without a trail, metres per second: as on other trails.
const LOST_MPS: f64 = 0.08;

/// Speed of the outer wheel on the arc towards the side that smelled the trail last, metres per second; the inner one
/// stands.
const ARC_MPS: f64 = 0.2;

/// A robot that has turned so far on that arc in vain goes straight on, radians.
const ARC_MAX_RAD: f64 = 2.6;

/// The way that the robot remembers having come: a place every so many metres, and how many.
const CRUMB_M: f64 = 0.1;
const N_CRUMBS: usize = 40;

/// It goes back where it came when it meets a place that it passed so long ago at least, so near, and looks so much the
/// other way (m, m, rad).
const BACK_AFTER_M: f64 = 0.4;
const BACK_NEAR_M: f64 = 0.2;
const BACK_TURNED_RAD: f64 = 2.0;

/// Back at the place where it was on the trail last is a robot so near it, metres; it turns there first if it looks further
/// beside it, radians.
const HOME_M: f64 = 0.08;
const HOME_ASIDE_RAD: f64 = 0.4;

/// Where it came from is where it was so long before, metres.
const CAME_M: f64 = 0.6;

/// Times that it may look around itself within so many metres.
const N_AIMS_MAX: u32 = 4;
const HERE_M: f64 = 0.5;

/// The tightest arc to a look-ahead point, metres.
const RADIUS_MIN_M: f64 = 0.2;

/// So near a look-ahead point is reached, metres.
const PURSUED_M: f64 = 0.12;

/// What the robot should do to find the trail and its direction, standing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Aim {
    /// Turn to that heading (rad, map), then ask again.
    Turn(f64),
    /// The trail lies ahead.
    Go,
    /// There is none here.
    Nothing,
}

/// What it should do to find it again, under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Search {
    /// Here it is.
    Found,
    Drive(WheelReference),
    /// Turn to that heading (rad, map), then ask again.
    Turn(f64),
    GaveUp,
}

/// What was smelled in which direction while the robot turned around itself.
#[derive(Clone, Copy, Debug, Default)]
struct Looks {
    begun: bool,
    from_rad: f64,
    n_turns: u32,
    /// Sum and number of reads by direction in the map.
    bins: [(f64, u32); N_BINS],
    chosen: bool,
}

/// Where and how the trail was lost.
#[derive(Clone, Copy, Debug)]
enum Leg {
    /// On an arc towards the side that smelled it last.
    Arc { side: Side, last_rad: f64, turned_rad: f64 },
    /// Straight on.
    On { from: Vec2 },
    /// To where it was on the trail last, whatever it smells on the way: a trail that is met from aside has no direction.
    Home { to: Vec2, turned: bool },
}

/// The last way along the trail: a trail itself has no direction, and a robot that finds it again may be on its way back.
#[derive(Clone, Copy, Debug)]
struct Crumbs {
    places: [Se2; N_CRUMBS],
    n_places: usize,
    next: usize,
    since_m: f64,
}

/// The part; see the module.
#[derive(Clone, Debug)]
pub(crate) struct TagTrail {
    settings: TagSettings,
    wheelbase_m: f64,
    follower: TagFollower,
    looks: Looks,
    leg: Option<Leg>,
    crumbs: Crumbs,
    /// Where it came from when it went back: the heading to turn to.
    about_turn_rad: Option<f64>,
    goal: Option<Vec2>,
    /// Where it was on the trail last, and some way before (m, map).
    last_on: Option<Vec2>,
    came_from: Option<Vec2>,
    /// Where it looked around itself last (m, map), and how often there.
    aimed_at: Vec2,
    n_aims: u32,
    /// The look-ahead point of the last tag that had one (m, map), and the way since it was read.
    pursued: Option<(Vec2, f64)>,
}

impl TagTrail {
    pub(crate) fn new(
        settings: &TagSettings,
        wheelbase_m: f64,
        wheel_speed_max_mps: f64,
    ) -> Result<Self, SettingError> {
        let n_readers = settings.readers_in_base.len();
        let fits = match settings.controller {
            TagController::Gradient => n_readers == 2,
            TagController::LookAhead => (1..=N_TAG_READERS_MAX).contains(&n_readers),
        };
        if !fits {
            let requirement =
                "two for the gradient, left and right; one or two for look-ahead points";
            return Err(SettingError { key: "tag readers", value: n_readers as f64, requirement });
        }
        let config = TagFollowerConfig { wheel_speed_max_mps, ..settings.follower };
        Ok(Self {
            settings: settings.clone(),
            wheelbase_m,
            follower: TagFollower::new(config)?,
            looks: Looks::default(),
            leg: None,
            crumbs: Crumbs::NONE,
            about_turn_rad: None,
            goal: None,
            last_on: None,
            came_from: None,
            aimed_at: Vec2::zeros(),
            n_aims: 0,
            pursued: None,
        })
    }

    /// A new goal (m, map); nothing of the one before counts.
    pub(crate) fn set_goal(&mut self, goal: Option<Vec2>) {
        self.goal = goal;
        // A look-ahead point leads to the goal before.
        self.pursued = None;
        self.last_on = None;
        self.came_from = None;
        self.n_aims = 0;
    }

    /// Begins to look for the trail around the robot; whether that may still help here.
    pub(crate) fn begin(&mut self, pose: Se2) -> bool {
        // As long as no trail was found, wherever that was counts as one place.
        let never = self.last_on.is_none();
        let here = never || (pose.position() - self.aimed_at).norm() < HERE_M;
        self.n_aims = if here { self.n_aims + 1 } else { 1 };
        self.aimed_at = pose.position();
        self.looks = Looks::default();
        self.leg = None;
        self.came_from = self.crumbs.before(CAME_M).or(self.came_from);
        self.crumbs = Crumbs::NONE;
        self.about_turn_rad = None;
        self.n_aims <= N_AIMS_MAX
    }

    /// Whether it has looked around itself here more than once.
    pub(crate) fn has_looked_twice(&self) -> bool {
        self.n_aims > 1
    }

    /// Where a reader is (m, map) on a robot at that pose.
    pub(crate) fn reader_in_map(&self, pose: Se2, reader: u8) -> Option<Vec2> {
        let at = self.settings.readers_in_base.get(usize::from(reader))?;
        Some(pose.transform_point(*at))
    }

    /// A reader has read a tag while the robot was at that pose.
    pub(crate) fn take(&mut self, pose: Se2, read: &TagRead) {
        let Some(reader) = self.reader_in_map(pose, read.reader) else { return };
        if self.settings.readers_in_base.len() == 2 {
            let side = if read.reader == 0 { Side::Left } else { Side::Right };
            self.follower.read(side, read.memory.strength);
        }
        if self.looks.begun && !self.looks.chosen {
            let away = reader - pose.position();
            let bin = bin_of(away.y.atan2(away.x));
            self.looks.bins[bin].0 += f64::from(read.memory.strength);
            self.looks.bins[bin].1 += 1;
        }
        let Some(goal) = self.goal else { return };
        let towards = |end: Vec2| (end - goal).norm_squared();
        let hints = read.memory.hints.iter().flatten();
        let hint = hints.min_by(|a, b| towards(a.end_in_map).total_cmp(&towards(b.end_in_map)));
        if let Some(hint) = hint {
            // Seen from the tag, not from where the robot believes to be.
            let target = reader + (hint.look_ahead_in_map - read.memory.in_map);
            self.pursued = Some((target, 0.0));
        }
    }

    /// The robot went from one pose to the next.
    pub(crate) fn roll(&mut self, from: Se2, to: Se2) {
        let readers = &self.settings.readers_in_base;
        let middle = readers.iter().sum::<Vec2>() / readers.len().max(1) as f64;
        let way_m = (to.transform_point(middle) - from.transform_point(middle)).norm();
        self.follower.roll(way_m);
        if self.goal.is_some() && self.about_turn_rad.is_none() {
            // Not the way of the readers: on the spot nothing is left behind.
            self.crumbs.note(to, (to.position() - from.position()).norm());
        }
        if let Some((_, since_m)) = &mut self.pursued {
            *since_m += way_m;
        }
    }

    /// What to do next to set out, standing at that pose.
    pub(crate) fn aim(&mut self, pose: Se2) -> Aim {
        // To its goal or, once it is under way, away from where it came.
        let onward = match (self.came_from, self.goal) {
            (Some(came_from), _) => pose.position() - came_from,
            (None, Some(goal)) => goal - pose.position(),
            (None, None) => pose.heading(),
        };
        let to_goal_rad = onward.y.atan2(onward.x);
        if let (TagController::LookAhead, Some((target, _))) =
            (self.settings.controller, self.pursued)
        {
            let way = target - pose.position();
            let heading_rad = way.y.atan2(way.x);
            let near = wrap_to_pi(heading_rad - pose.yaw_rad).abs() < TOWARDS_POINT_RAD;
            let often = self.looks.n_turns > N_LOOKS + 2;
            return if near || often { Aim::Go } else { Aim::Turn(heading_rad) };
        }
        if !self.looks.begun {
            let ahead = wrap_to_pi(to_goal_rad - pose.yaw_rad).abs() < TOWARDS_GOAL_RAD;
            if ahead && self.follower.smells_on_both_sides() {
                return Aim::Go;
            }
            self.looks.begun = true;
            self.looks.from_rad = pose.yaw_rad;
        }
        if self.looks.n_turns < N_LOOKS {
            let turn_rad = std::f64::consts::TAU / f64::from(N_LOOKS);
            let heading_rad = self.looks.from_rad + turn_rad * f64::from(self.looks.n_turns + 1);
            return Aim::Turn(wrap_to_pi(heading_rad));
        }
        if self.looks.n_turns > N_LOOKS {
            return Aim::Go;
        }
        self.looks.chosen = true;
        self.looks.direction_rad(to_goal_rad).map_or(Aim::Nothing, Aim::Turn)
    }

    /// The turn that was asked for is done.
    pub(crate) fn turned(&mut self) {
        self.looks.n_turns += 1;
        if let Some(Leg::Home { turned, .. }) = &mut self.leg {
            *turned = true;
        }
        if self.about_turn_rad.take().is_some() {
            self.crumbs = Crumbs::NONE;
            self.follower.restart();
        }
    }

    /// The heading (rad, map) to turn to when the robot has come to go back where it came from.
    pub(crate) fn about_turn_rad(&mut self, pose: Se2) -> Option<f64> {
        if self.about_turn_rad.is_none() {
            self.about_turn_rad = self.crumbs.heading_before_rad(pose);
        }
        self.about_turn_rad
    }

    /// The trail lies ahead, or was found again.
    pub(crate) fn set_out(&mut self) {
        self.leg = None;
        self.follower.restart();
    }

    /// One step along the trail, around that speed.
    pub(crate) fn follow(&mut self, pose: Se2, speed_mps: f64) -> TagStep {
        if self.smells(pose) {
            self.last_on = Some(pose.position());
        }
        match self.settings.controller {
            TagController::Gradient => self.follower.step(speed_mps),
            TagController::LookAhead => {
                let Some(target) = self.pursued_in_base(pose) else { return TagStep::Lost(None) };
                TagStep::Drive(pursue(target, speed_mps, RADIUS_MIN_M, self.wheelbase_m))
            }
        }
    }

    /// The look-ahead point (m, base), until it is reached or passed.
    fn pursued_in_base(&self, pose: Se2) -> Option<Vec2> {
        let (target, since_m) = self.pursued?;
        let in_base = pose.inverse().transform_point(target);
        // One that was passed without a new read is none.
        let counts = since_m <= self.settings.follower.hold_m || in_base.x > 0.0;
        (counts && in_base.norm() > PURSUED_M).then_some(in_base)
    }

    /// Whether the trail is there.
    fn smells(&self, pose: Se2) -> bool {
        match self.settings.controller {
            TagController::Gradient => self.follower.smells(),
            TagController::LookAhead => self.pursued_in_base(pose).is_some(),
        }
    }

    /// The trail was lost at that pose.
    pub(crate) fn lose(&mut self, pose: Se2, side: Option<Side>) {
        self.leg = Some(match side {
            Some(side) => Leg::Arc { side, last_rad: pose.yaw_rad, turned_rad: 0.0 },
            None => Leg::On { from: pose.position() },
        });
    }

    /// Something stands in the way of the search.
    pub(crate) fn turn_back(&mut self) {
        self.leg = self.last_on.map(|to| Leg::Home { to, turned: false });
    }

    /// What to do next to find it again, at most so far straight on, metres.
    pub(crate) fn search(&mut self, pose: Se2, on_max_m: f64) -> Search {
        let goes_home = matches!(self.leg, Some(Leg::Home { .. }));
        if !goes_home && self.smells(pose) {
            return Search::Found;
        }
        match self.leg {
            None => Search::GaveUp,
            Some(Leg::Arc { side, last_rad, turned_rad }) => {
                let turned_rad = turned_rad + wrap_to_pi(pose.yaw_rad - last_rad).abs();
                self.leg = Some(Leg::Arc { side, last_rad: pose.yaw_rad, turned_rad });
                if turned_rad > ARC_MAX_RAD {
                    self.turn_back();
                }
                let (left_mps, right_mps) =
                    if side == Side::Left { (0.0, ARC_MPS) } else { (ARC_MPS, 0.0) };
                Search::Drive(WheelReference { left_mps, right_mps })
            }
            Some(Leg::On { from }) => {
                if (pose.position() - from).norm() >= on_max_m {
                    self.turn_back();
                }
                Search::Drive(WheelReference::straight(LOST_MPS))
            }
            Some(Leg::Home { to, turned }) => self.go_home(pose, to, turned),
        }
    }

    fn go_home(&mut self, pose: Se2, to: Vec2, turned: bool) -> Search {
        let in_base = pose.inverse().transform_point(to);
        let aside_rad = in_base.y.atan2(in_base.x).abs();
        if in_base.norm() < HOME_M || turned && in_base.x < 0.0 {
            self.leg = None;
            return Search::GaveUp;
        }
        if !turned && aside_rad > HOME_ASIDE_RAD {
            return Search::Turn(wrap_to_pi(pose.yaw_rad + in_base.y.atan2(in_base.x)));
        }
        self.leg = Some(Leg::Home { to, turned: true });
        Search::Drive(pursue(in_base, LOST_MPS, RADIUS_MIN_M, self.wheelbase_m))
    }

    /// What the antennas smell, left and right.
    pub(crate) fn levels(&self) -> (f64, f64) {
        let [left, right] = self.follower.levels();
        (left, right)
    }
}

impl Crumbs {
    const NONE: Self =
        Self { places: [Se2::IDENTITY; N_CRUMBS], n_places: 0, next: 0, since_m: 0.0 };

    fn note(&mut self, pose: Se2, way_m: f64) {
        self.since_m += way_m;
        if self.since_m >= CRUMB_M {
            self.since_m = 0.0;
            self.places[self.next] = pose;
            self.next = (self.next + 1) % N_CRUMBS;
            self.n_places = (self.n_places + 1).min(N_CRUMBS);
        }
    }

    /// Where it was about so much way ago (m, map); `None` when it has not come so far.
    fn before(&self, way_m: f64) -> Option<Vec2> {
        let k = ((way_m / CRUMB_M) as usize).min(N_CRUMBS - 1);
        let index = (self.next + 2 * N_CRUMBS - 1 - k) % N_CRUMBS;
        (k < self.n_places).then(|| self.places[index].position())
    }

    /// How the robot looked where it is now when it came the other way; `None` where it did not.
    fn heading_before_rad(&self, pose: Se2) -> Option<f64> {
        let newest = (BACK_AFTER_M / CRUMB_M) as usize;
        let old = (newest..self.n_places)
            .map(|k| self.places[(self.next + 2 * N_CRUMBS - 1 - k) % N_CRUMBS]);
        let near = |place: &Se2| (place.position() - pose.position()).norm() < BACK_NEAR_M;
        let turned = |place: &Se2| wrap_to_pi(place.yaw_rad - pose.yaw_rad).abs() > BACK_TURNED_RAD;
        old.filter(near).find(turned).map(|place| place.yaw_rad)
    }
}

fn bin_of(direction_rad: f64) -> usize {
    let turn = wrap_to_pi(direction_rad) / std::f64::consts::TAU + 0.5;
    ((turn * N_BINS as f64) as usize).min(N_BINS - 1)
}

impl Looks {
    /// The direction (rad, map) in which the trail leads on, of several the one nearest to the goal's; `None`
    /// without a trail.
    fn direction_rad(&self, to_goal_rad: f64) -> Option<f64> {
        let mean = |bin: usize| {
            let (sum, n) = self.bins[bin % N_BINS];
            if n == 0 { 0.0 } else { sum / f64::from(n) }
        };
        let strongest = (0..N_BINS).map(mean).fold(0.0, f64::max);
        if strongest <= 0.0 {
            return None;
        }
        let width_rad = std::f64::consts::TAU / N_BINS as f64;
        let centre_rad = |bin: usize| (bin as f64 + 0.5) * width_rad - std::f64::consts::PI;
        let off_goal = |bin: usize| wrap_to_pi(centre_rad(bin) - to_goal_rad).abs();
        let strong = (0..N_BINS).filter(|bin| mean(*bin) >= TRAIL_RATIO * strongest);
        let best = strong.min_by(|a, b| off_goal(*a).total_cmp(&off_goal(*b)))?;
        // The middle of what belongs to it: two bins to either side of the strongest near it.
        let peak = (best + N_BINS - 2..=best + N_BINS + 2)
            .max_by(|a, b| mean(*a).total_cmp(&mean(*b)))
            .unwrap_or(best);
        let around = (peak + N_BINS - 2..=peak + N_BINS + 2).map(|bin| {
            let direction_rad = centre_rad(bin % N_BINS);
            Vec2::new(direction_rad.cos(), direction_rad.sin()) * mean(bin)
        });
        let sum: Vec2 = around.sum();
        Some(sum.y.atan2(sum.x))
    }
}

#[cfg(test)]
#[path = "tag_trail_tests.rs"]
mod tests;
