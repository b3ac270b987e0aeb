//! *How*: the way to the goal, by one of five methods, what lies ahead on it and how fast it may be driven.
//!
//! A method is a file below and a line in `Method`. What it finds is a preview, point by point, and what is to be done
//! next: a `Leg`. It stands beside the wheels: `follow` drives, `guard` stops.

mod by_tags;
mod given_path;
mod inquiry;
mod leg;
mod planned;
mod preview;
mod scout;
mod scouted;
mod tag_trail;

use std::time::Duration;

use geometry::{Se2, Vec2, wrap_to_pi};
use messages::{Command, FailureReason, TagRead};
use path_following::{Path, SettingError};
use path_planning::MapPlanner;
use run_context::Stamp;

use crate::{
    around::Surroundings,
    says::Sentence,
    settings::{self, NavigatorSettings},
    values::{CAREFUL_MPS, Limits, Situation, Way, braking_mps},
};
use by_tags::ByTags;
use given_path::GivenPath;
use planned::Planned;
use preview::Preview;
use scouted::{Answer, ScoutedTrail};

pub(crate) use leg::{CourseLeg, Leg, Scent};
pub(crate) use preview::PREVIEW_STEP_M;
pub use scout::Scouting;

/// Speed in a bend of a preview that is driven line by line, metres per second. At 0.3 m/s the robot swings so far out of a
/// junction's right angle that of 400 errands through doors 13 touched a post, at this one 3.
const LINE_BEND_MPS: f64 = 0.18;

/// A robot that looks further beside its preview than this is careful, radians.
const BESIDE_RAD: f64 = 0.25;

/// How the way is found.
#[derive(Clone, Debug)]
enum Method {
    Trail(Box<ScoutedTrail>),
    Straight,
    /// Nothing until it is given.
    Path(Option<GivenPath>),
    Tags(Box<ByTags>),
    /// Nothing until there is a map.
    Planned(Option<Box<Planned>>),
}

/// The part; see the module.
#[derive(Clone, Debug)]
pub(crate) struct Route {
    method: Method,
    preview: Preview,
    /// The last intensities at the robot's own pose: left, right.
    felt: Option<(f64, f64)>,
    limits: Limits,
    fit_to_speed: bool,
    approach_from_end_m: f64,
    n_shown: usize,
}

impl Route {
    pub(crate) fn new(s: &NavigatorSettings) -> Result<Self, SettingError> {
        // Refused whatever the method: nobody waits for it to be chosen.
        let tags = ByTags::new(s)?;
        let method = match s.method {
            settings::Method::Trail => Method::Trail(Box::new(ScoutedTrail::new(s))),
            settings::Method::Direct => Method::Straight,
            settings::Method::Path => Method::Path(None),
            settings::Method::Tags => Method::Tags(Box::new(tags)),
            settings::Method::Map => Method::Planned(None),
        };
        Ok(Self {
            method,
            preview: Preview::default(),
            felt: None,
            limits: s.limits(),
            fit_to_speed: s.fit_to_speed,
            approach_from_end_m: s.approach_from_trail_end_m,
            n_shown: (s.preview_m / PREVIEW_STEP_M) as usize + 1,
        })
    }

    /// The same with the room that it will need, which a clone has not.
    pub(crate) fn with_room(mut self) -> Self {
        self.preview = self.preview.with_room();
        if let Method::Trail(trail) = self.method {
            self.method = Method::Trail(Box::new(trail.with_room()));
        }
        self
    }

    pub(crate) fn says(&self) -> Sentence {
        let method = match &self.method {
            Method::Trail(_) => "along the trail that was found by asking",
            Method::Straight => "straight",
            Method::Path(_) => "along the path that was given",
            Method::Tags(_) => "along the tags in the floor",
            Method::Planned(_) => "along the way that it planned on its map",
        };
        Sentence::By { method, ahead_m: self.preview.ahead_m() }
    }

    /// The path that the path method follows; the others need none.
    pub(crate) fn set_path(&mut self, path: Path, s: &NavigatorSettings) {
        if let Method::Path(given) = &mut self.method {
            let path = given.insert(GivenPath::new(path, s));
            self.preview.reserve(path.n_preview_points());
        }
    }

    /// The map that the planning method plans on; the others need none.
    pub(crate) fn set_map(&mut self, map: MapPlanner, s: &NavigatorSettings) {
        if let Method::Planned(planned) = &mut self.method {
            *planned = Some(Box::new(Planned::new(map, s)));
        }
    }

    /// The path that is followed, given or planned.
    fn path(&self) -> Option<&GivenPath> {
        match &self.method {
            Method::Path(path) => path.as_ref(),
            Method::Planned(planned) => planned.as_ref()?.path(),
            Method::Trail(_) | Method::Straight | Method::Tags(_) => None,
        }
    }

    /// The same, and the preview beside it.
    fn path_mut(&mut self) -> Option<(&mut GivenPath, &mut Preview)> {
        let path = match &mut self.method {
            Method::Path(path) => path.as_mut(),
            Method::Planned(planned) => planned.as_mut()?.path_mut(),
            Method::Trail(_) | Method::Straight | Method::Tags(_) => None,
        };
        Some((path?, &mut self.preview))
    }

    /// The robot went from one pose to the next.
    pub(crate) fn roll(&mut self, from: Se2, to: Se2) {
        if let Method::Tags(tags) = &mut self.method {
            tags.roll(from, to);
        }
    }

    /// A reader has read a tag while the robot was at that pose.
    pub(crate) fn take_tag(&mut self, pose: Se2, read: &TagRead) {
        if let Method::Tags(tags) = &mut self.method {
            self.felt = Some(tags.take_tag(pose, read));
        }
    }

    /// The server has answered: whether that was about the robot's own pose, and whether it is progress.
    pub(crate) fn take_answer(
        &mut self,
        now: Stamp,
        query: u8,
        intensities: (f64, f64),
        aims: bool,
    ) -> (bool, bool) {
        let Method::Trail(trail) = &mut self.method else { return (false, false) };
        let answer = trail.answer(now, query, intensities, aims);
        if answer == Answer::Own {
            self.felt = Some(intensities);
        }
        (answer == Answer::Own, answer == Answer::Scout)
    }

    pub(crate) fn forget_task(&mut self) {
        self.preview.clear();
        if let Method::Trail(trail) = &mut self.method {
            trail.forget_task();
        }
    }

    /// The phase changes, to one in which the server is asked or not.
    pub(crate) fn change_phase(&mut self, goes_on_asking: bool) {
        if let Method::Trail(trail) = &mut self.method {
            trail.change_phase(goes_on_asking);
        }
    }

    /// A new task; and whether the robot is past its beginning already.
    pub(crate) fn begin(&mut self, situation: &Situation) -> (Leg, bool) {
        match &mut self.method {
            Method::Straight => (Leg::Straight, false),
            Method::Path(Some(path)) => path.begin(situation, &mut self.preview),
            Method::Path(None) | Method::Planned(None) => {
                (Leg::Failed(FailureReason::NoTrail), false)
            }
            Method::Planned(Some(planned)) => planned.begin(situation, &mut self.preview),
            Method::Tags(tags) => {
                tags.begin(situation.goal_point());
                (tags.look(situation.at.pose, &mut self.preview), false)
            }
            Method::Trail(_) => (self.look(situation), false),
        }
    }

    /// Another way from where the robot stands, around what it has heard and its map does not know; `None` where it plans
    /// none, or has planned often enough.
    pub(crate) fn plan_anew(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
    ) -> Option<Leg> {
        let Method::Planned(Some(planned)) = &mut self.method else { return None };
        planned.plan_anew(situation, around, &mut self.preview)
    }

    /// Begins to look for the way from where the robot stands.
    pub(crate) fn look(&mut self, situation: &Situation) -> Leg {
        match &mut self.method {
            Method::Trail(trail) => {
                trail.look(situation, &mut self.preview);
                Leg::Look
            }
            Method::Tags(tags) => tags.look(situation.at.pose, &mut self.preview),
            Method::Straight | Method::Path(_) | Method::Planned(_) => Leg::Rest,
        }
    }

    /// One control period of looking for the way.
    pub(crate) fn aim(&mut self, situation: &Situation, around: &Surroundings) -> Leg {
        match &mut self.method {
            Method::Trail(trail) => trail.aim(situation, around, &mut self.preview),
            Method::Tags(tags) => tags.aim(situation, around),
            Method::Straight | Method::Path(_) | Method::Planned(_) => Leg::Rest,
        }
    }

    /// Where the robot has come along its way; whether that is further than before.
    pub(crate) fn advance(&mut self, situation: &Situation) -> bool {
        match &mut self.method {
            Method::Trail(_) => ScoutedTrail::advance(situation, &mut self.preview),
            Method::Tags(_) => {
                self.preview.clear();
                false
            }
            Method::Straight | Method::Path(_) | Method::Planned(_) => {
                self.path_mut().is_some_and(|(path, preview)| path.advance(&situation.at, preview))
            }
        }
    }

    /// One control period of following it.
    pub(crate) fn follow(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        is_blocked: bool,
    ) -> Leg {
        let preview = &mut self.preview;
        match &mut self.method {
            Method::Trail(trail) => trail.follow(situation, around, preview, is_blocked),
            Method::Tags(tags) => tags.follow(situation, around, preview, is_blocked),
            Method::Straight => Leg::Rest,
            Method::Path(_) | Method::Planned(_) => match self.path_mut() {
                Some((path, _)) => path.follow(situation, around, is_blocked),
                None => Leg::Failed(FailureReason::NoTrail),
            },
        }
    }

    /// One control period of looking for a way that was lost at `since`.
    pub(crate) fn search(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        is_blocked: bool,
        since: Stamp,
    ) -> Leg {
        match &mut self.method {
            Method::Trail(trail) => trail.search(situation, around, is_blocked, since),
            Method::Tags(tags) => tags.search(situation, around, is_blocked),
            Method::Straight | Method::Path(_) | Method::Planned(_) => Leg::Rest,
        }
    }

    /// The turn that it asked for is done; what next.
    pub(crate) fn turned(&mut self) -> Leg {
        match &mut self.method {
            Method::Tags(tags) => tags.turned(),
            Method::Trail(_) => return Leg::TakeUp,
            Method::Straight | Method::Path(_) | Method::Planned(_) => {
                if let Some((path, _)) = self.path_mut() {
                    path.set_aligned(false);
                }
            }
        }
        Leg::Rest
    }

    /// The way is followed from where the robot is; whether that is further on.
    pub(crate) fn take_up(&mut self, situation: &Situation) -> bool {
        let position = situation.at.position();
        match &mut self.method {
            Method::Trail(trail) => trail.take_up(situation, &mut self.preview),
            Method::Tags(_) => self.preview.advance(position, scouted::RESUME_POINTS),
            Method::Straight | Method::Path(_) | Method::Planned(_) => {
                self.path_mut().is_some_and(|(path, preview)| path.take_up(position, preview))
            }
        }
    }

    /// Whether a way that was lost before an obstacle is looked for anew behind it.
    pub(crate) fn is_scouted(&self) -> bool {
        matches!(self.method, Method::Trail(_))
    }

    /// What an answer about the robot's own pose means for its way.
    pub(crate) fn scent(
        &mut self,
        situation: &Situation,
        intensities: (f64, f64),
        follows: bool,
    ) -> Scent {
        match &mut self.method {
            Method::Trail(trail) => trail.scent(situation, intensities, &self.preview, follows),
            _ => Scent::Trail,
        }
    }

    /// One step of the law over tags.
    pub(crate) fn step_by_tags(&mut self, pose: Se2, speed_mps: f64) -> Leg {
        match &mut self.method {
            Method::Tags(tags) => tags.step(pose, speed_mps),
            _ => Leg::Rest,
        }
    }

    /// The piece of the given path, at most as fast as the way allows.
    pub(crate) fn course(&self, situation: &Situation, way_mps: f64) -> Option<CourseLeg<'_>> {
        Some(self.path()?.course(situation, way_mps))
    }

    /// Asks the server what is to be asked next.
    pub(crate) fn ask(&mut self, situation: &Situation, aims: bool, commands: &mut Vec<Command>) {
        if let Method::Trail(trail) = &mut self.method {
            trail.ask(situation, aims, commands);
        }
    }

    /// How long the server has left questions unanswered.
    pub(crate) fn server_silence(&self, now: Stamp) -> Duration {
        match &self.method {
            Method::Trail(trail) => trail.silence(now),
            _ => Duration::ZERO,
        }
    }

    /// The speed on a trail, m/s: what the way allows (`way_mps`), its bends, and the goal at its end.
    /// The law for straight lines takes a bend of the preview in pieces, and swings out of it: see [`LINE_BEND_MPS`].
    pub(crate) fn speed_mps(&self, situation: &Situation, way_mps: f64, by_lines: bool) -> f64 {
        if !self.fit_to_speed {
            return way_mps;
        }
        let (now, at, limits) = (situation.now, &situation.at, &self.limits);
        let mut speed_mps = way_mps;
        if let Some(bend_m) = self.preview.first_bend_m() {
            let left_m = bend_m - at.way_until_command_m(now);
            let more_mps = braking_mps(left_m, limits.acceleration_mps2, limits.period_s);
            let bend_mps = if by_lines { LINE_BEND_MPS } else { CAREFUL_MPS };
            // v² ≤ v_bend² + 2 a d
            speed_mps = speed_mps.min(bend_mps.hypot(more_mps));
        }
        let ahead_rad = self.preview.heading_rad(at.position());
        let beside = |ahead_rad: f64| wrap_to_pi(ahead_rad - at.pose.yaw_rad).abs() > BESIDE_RAD;
        if ahead_rad.is_some_and(beside) {
            speed_mps = speed_mps.min(CAREFUL_MPS);
        }
        if let Some(rest_m) = self.rest_to_goal_m(situation) {
            speed_mps = speed_mps.min(at.speed_to_stand_mps(rest_m, now, limits));
        }
        speed_mps.max(limits.least_mps())
    }

    /// Way over the preview to the goal where the preview leads to it; straight where there is none.
    fn rest_to_goal_m(&self, situation: &Situation) -> Option<f64> {
        let goal = situation.goal_point()?;
        let Some(last) = self.preview.points().last() else {
            return Some((goal - situation.at.position()).norm());
        };
        let beyond_m = (goal - last).norm();
        (self.is_scouted() && beyond_m <= self.approach_from_end_m)
            .then(|| self.preview.ahead_m() + beyond_m)
    }

    /// The way that the robot is about to take.
    pub(crate) fn way(&self, situation: &Situation) -> Way {
        self.preview.way(situation.at.pose, self.limits.look_m())
    }

    /// Straight on, as far as is looked at.
    pub(crate) fn straight_way(&self, situation: &Situation) -> Way {
        Way::on(situation.at.pose, self.limits.look_m())
    }

    /// The points ahead (m, map), [`PREVIEW_STEP_M`] apart.
    pub(crate) fn ahead(&self) -> &[Vec2] {
        self.preview.ahead()
    }

    /// How many of them are shown.
    pub(crate) fn n_shown(&self) -> usize {
        self.n_shown
    }

    /// Their length, metres.
    pub(crate) fn ahead_m(&self) -> f64 {
        self.preview.ahead_m()
    }

    pub(crate) fn felt(&self) -> Option<(f64, f64)> {
        self.felt
    }

    pub(crate) fn scouting(&self) -> Scouting {
        match &self.method {
            Method::Trail(trail) => trail.figures(),
            _ => Scouting::default(),
        }
    }
}
