//! The way to the goal, planned on a map when the goal is given; then it is a path like any other.

use geometry::{Vec2, wrap_to_pi};
use messages::FailureReason;
use path_following::Path;
use path_planning::{MapPlanner, MapWay, NoWay};

use super::{given_path::GivenPath, leg::Leg, preview::Preview};
use crate::{around::Surroundings, settings::NavigatorSettings, values::Situation};

/// A corner may be cut by this part of the room that a way keeps.
const CUT_RATIO: f64 = 0.8;

/// Widest arc around a corner, metres.
const RADIUS_MAX_M: f64 = 0.4;

/// Times that another way is planned for one goal.
const N_ANEW_MAX: u32 = 4;

/// Corners with less room than this are turned at on the spot, metres.
const ROUND_FROM_M: f64 = 0.05;

/// A map, and the way that was planned on it last.
#[derive(Clone, Debug)]
pub(crate) struct Planned {
    map: MapPlanner,
    settings: NavigatorSettings,
    radius_m: f64,
    path: Option<GivenPath>,
    /// What was heard where a way was given up (m, map).
    obstacles: Vec<Vec2>,
    n_anew: u32,
}

impl Planned {
    pub(crate) fn new(map: MapPlanner, settings: &NavigatorSettings) -> Self {
        let radius_m = settings.outline_m.iter().map(Vec2::norm).fold(0.0, f64::max);
        Self {
            map,
            settings: settings.clone(),
            radius_m,
            path: None,
            obstacles: Vec::new(),
            n_anew: 0,
        }
    }

    pub(crate) fn path(&self) -> Option<&GivenPath> {
        self.path.as_ref()
    }

    pub(crate) fn path_mut(&mut self) -> Option<&mut GivenPath> {
        self.path.as_mut()
    }

    /// A new task: plans, and sets out; see [`GivenPath::begin`]. O(cells).
    pub(crate) fn begin(&mut self, situation: &Situation, preview: &mut Preview) -> (Leg, bool) {
        self.n_anew = 0;
        self.obstacles.clear();
        match self.set_out(situation, preview) {
            Ok(begun) => begun,
            Err(NoWay::GoalBlocked) => (Leg::Failed(FailureReason::GoalBlocked), false),
            Err(NoWay::Enclosed | NoWay::NotConnected) => {
                (Leg::Failed(FailureReason::NoWay), false)
            }
        }
    }

    /// Another way, around all that was heard when the ways before were given up.
    pub(crate) fn plan_anew(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        preview: &mut Preview,
    ) -> Option<Leg> {
        self.n_anew += 1;
        if self.n_anew > N_ANEW_MAX {
            return None;
        }
        self.obstacles.extend(around.echoes().points());
        self.set_out(situation, preview).ok().map(|(leg, _)| leg)
    }

    fn set_out(
        &mut self,
        situation: &Situation,
        preview: &mut Preview,
    ) -> Result<(Leg, bool), NoWay> {
        self.path = None;
        let goal = situation.goal_point().ok_or(NoWay::NotConnected)?;
        let from = situation.at.position();
        let way = self.map.plan(from, goal, self.radius_m, &self.obstacles)?;
        let Some(path) = driven(&way) else {
            // It stands there.
            return Ok((Leg::ToGoal, false));
        };
        let path = self.path.insert(GivenPath::new(path, &self.settings));
        preview.reserve(path.n_preview_points());
        Ok(path.begin(situation, preview))
    }
}

/// A way as it is driven: around its corners in arcs where there is room for that. An arc of radius r around a corner of θ
/// cuts it by r (1 / cos(θ/2) − 1).
fn driven(way: &MapWay) -> Option<Path> {
    let sharp = Path::polyline(&way.corners).ok()?;
    let sharpest_rad = way.corners.windows(3).map(|c| {
        let (into, out) = (c[1] - c[0], c[2] - c[1]);
        wrap_to_pi(out.y.atan2(out.x) - into.y.atan2(into.x)).abs()
    });
    let cosine = (0.5 * sharpest_rad.fold(0.0, f64::max)).cos().max(1e-3);
    let cut_per_radius = 1.0 / cosine - 1.0;
    let radius_m = (CUT_RATIO * way.room_m / cut_per_radius.max(1e-3)).min(RADIUS_MAX_M);
    if way.room_m < ROUND_FROM_M {
        return Some(sharp);
    }
    Some(Path::rounded(&way.corners, radius_m).unwrap_or(sharp))
}
