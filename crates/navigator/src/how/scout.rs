//! The scout: finds out, by asking, which network of trails lies around the robot and how it leads
//! to the goal.
//!
//! The pheromone server answers for any pose, also for poses at which nobody is. The scout asks
//! around one *place* after the other: ahead and to both sides of it, and where more than one trail
//! may be, in between. What it smells there are the next places, 0.33 m on; a place that is known
//! already closes a loop. Of all places not asked about yet the one comes next through which the
//! goal could be reached by the shortest way (A*), so the first way found is the shortest, branches
//! that lead away are not walked, and dead ends cost what they are long.
//!
//! What it cannot tell apart: trails side by side nearer than about 0.9 m (one and a half times the
//! antennas' reach) count as connected, and so do trails across a gap of up to 0.6 m.
//!
//! An extension of ours; a trail by itself has no direction, and the thesis's robot follows one
//! without junctions.

mod route;

use geometry::{Se2, Vec2, wrap_to_pi};

/// Distance from a place at which the scout asks, metres: the trail through the place itself lies
/// behind the antennas there, so only what leads away is smelled.
const STEP_M: f64 = 0.33;

/// Places nearer to each other than this are one, metres.
const SAME_M: f64 = 0.22;

/// How far aside of a question the trail lies for (P_L − P_R) / (P_L + P_R) = 1, metres, and at most.
const ASIDE_M: f64 = 0.35;
const ASIDE_MAX_M: f64 = 0.22;

/// How much of a change in direction is taken over at once: a trail of cells zigzags.
const TURN_RATIO: f64 = 0.7;

/// A place so near to the goal is at it, metres.
const AT_GOAL_M: f64 = 0.4;

/// Most places that are kept: 300 m of trail.
pub(crate) const N_PLACES_MAX: usize = 1024;

/// Most questions of one search: two and a half minutes at 20 a second.
const N_QUESTIONS_MAX: u32 = 3000;

/// Most ways that meet in one place.
const N_LINKS_MAX: usize = 6;

/// What a branch smells of at least, relative to the trail ahead.
const BRANCH_RATIO: f64 = 0.35;

/// The same obliquely backwards, after what the trail that the scout came on adds there.
const BACK_BRANCH_RATIO: f64 = 0.4;
const BACK_TRAIL_RATIO: f64 = 0.4;

/// A place is looked at more closely when its sides smell of more, or the way ahead of less.
const SIDE_RATIO: f64 = 0.3;
const AHEAD_RATIO: f64 = 0.6;

/// Circles around the robot on which trails are looked for, metres; the next when all before are
/// used up.
const RINGS_M: [f64; 4] = [0.15, 0.45, 0.95, 1.45];

/// How far beyond a circle the trail is that is smelled there, metres, roughly.
const RING_BEYOND_M: f64 = 0.12;

/// Directions of questions around a place, in eighths of a turn to the left.
const N_DIRECTIONS: usize = 8;
const AHEAD: usize = 0;
const LEFT: usize = 2;
const RIGHT: usize = 6;

/// The order in which directions are asked: the first three always, the others where there may be
/// a branch.
const DIRECTIONS: [usize; 7] = [AHEAD, LEFT, RIGHT, 1, 7, 3, 5];
const N_FIRST: usize = 3;

/// How a search stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Search {
    /// There is more to ask.
    Going,
    /// The shortest way to the goal is known.
    Found,
    /// All trails were walked to their ends; none passes the goal.
    Exhausted,
    /// There is more to ask, or trails go on, than is permitted.
    LimitReached,
}

/// No place.
const NONE: u16 = u16::MAX;

/// A place on a trail.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: Vec2,
    /// The direction in which the scout came to it.
    heading_rad: f64,
    /// Length of the shortest known way from the robot, and the place before it on this way.
    way_m: f64,
    before: u16,
    asked: bool,
    links: [u16; N_LINKS_MAX],
    n_links: u8,
}

impl Place {
    fn links(&self) -> impl Iterator<Item = usize> + '_ {
        self.links[..usize::from(self.n_links)].iter().map(|index| usize::from(*index))
    }
}

/// What is being asked about, and what was answered so far.
#[derive(Clone, Copy, Debug)]
struct Round {
    around: Around,
    answers: [Option<(f64, f64)>; N_DIRECTIONS],
    /// Whether all directions are asked.
    closely: bool,
}

#[derive(Clone, Copy, Debug)]
enum Around {
    Place(usize),
    /// The robot, on a circle of this radius (m).
    Robot(f64),
}

impl Round {
    fn new(around: Around) -> Self {
        Self { around, answers: [None; N_DIRECTIONS], closely: false }
    }

    fn next_direction(&self) -> Option<usize> {
        let open = |k: &usize| self.answers[*k].is_none();
        match self.around {
            Around::Robot(_) => (0..N_DIRECTIONS).find(open),
            Around::Place(_) => {
                let n = if self.closely { DIRECTIONS.len() } else { N_FIRST };
                DIRECTIONS[..n].iter().copied().find(open)
            }
        }
    }

    /// P_L + P_R in this direction; 0 where it was not asked.
    fn strength(&self, direction: usize) -> f64 {
        self.answers[direction % N_DIRECTIONS].map_or(0.0, |(left, right)| left + right)
    }
}

/// What a search has come to; for people.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scouting {
    /// Questions asked.
    pub n_questions: u32,
    /// Length of all trails walked, metres.
    pub searched_m: f64,
    /// Distance from the goal to the nearest trail found, metres; `None` when there is none.
    pub nearest_m: Option<f64>,
    /// Whether trails went on where the search had to end.
    pub is_cut_short: bool,
}

/// One search and the network it found.
#[derive(Clone, Debug)]
pub(crate) struct Scout {
    places: Vec<Place>,
    /// Working memory for a route: the places it passes, last first.
    route: Vec<u16>,
    start: Se2,
    goal: Vec2,
    way_max_m: f64,
    status: Search,
    round: Option<Round>,
    n_rings: usize,
    /// What the trail ahead of a place smells of where it is alone, on average.
    alone: f64,
    n_questions: u32,
    searched_m: f64,
    is_cut_short: bool,
}

impl Scout {
    pub(crate) fn new() -> Self {
        Self {
            places: Vec::new(),
            route: Vec::new(),
            start: Se2::IDENTITY,
            goal: Vec2::zeros(),
            way_max_m: 0.0,
            status: Search::Exhausted,
            round: None,
            n_rings: 0,
            alone: 0.0,
            n_questions: 0,
            searched_m: 0.0,
            is_cut_short: false,
        }
    }

    /// The same with room for the largest network, which a clone has not.
    pub(crate) fn with_room(mut self) -> Self {
        self.places.reserve_exact(N_PLACES_MAX);
        self.route.reserve_exact(N_PLACES_MAX);
        self
    }

    /// Begins to look for a way of at most `way_max_m` from the robot at `start` to `goal`.
    pub(crate) fn begin(&mut self, start: Se2, goal: Vec2, way_max_m: f64) {
        self.clear();
        self.start = start;
        self.goal = goal;
        self.way_max_m = way_max_m;
        self.status = Search::Going;
        // The robot's own place: everything is reached from it.
        self.places.push(Place {
            at: start.position(),
            heading_rad: start.yaw_rad,
            way_m: 0.0,
            before: NONE,
            asked: true,
            links: [NONE; N_LINKS_MAX],
            n_links: 0,
        });
        self.next_round();
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.places.clear();
        self.status = Search::Exhausted;
        self.round = None;
        self.n_rings = 0;
        self.alone = 0.0;
        self.n_questions = 0;
        self.searched_m = 0.0;
        self.is_cut_short = false;
    }

    pub(crate) fn status(&self) -> Search {
        self.status
    }

    /// Whether any trail was found.
    pub(crate) fn has_found_trails(&self) -> bool {
        self.places.len() > 1
    }

    pub(crate) fn figures(&self) -> Scouting {
        Scouting {
            n_questions: self.n_questions,
            searched_m: self.searched_m,
            nearest_m: self.nearest().map(|(_, distance_m)| distance_m),
            is_cut_short: self.is_cut_short,
        }
    }

    /// The pose of the next question; `None` when there is none.
    pub(crate) fn question(&self) -> Option<Se2> {
        let round = self.round.as_ref()?;
        Some(self.pose_of(round, round.next_direction()?))
    }

    /// Takes the answer to [`question`](Self::question): P_L, P_R.
    pub(crate) fn answer(&mut self, intensities: (f64, f64)) {
        let Some(mut round) = self.round else { return };
        let Some(direction) = round.next_direction() else { return };
        self.n_questions += 1;
        round.answers[direction] = Some(intensities);
        if round.next_direction().is_none() && !round.closely && self.is_unclear(&round) {
            round.closely = true;
        }
        self.round = Some(round);
        if round.next_direction().is_some() {
            return;
        }
        match round.around {
            Around::Place(index) => self.leave_place(index, &round),
            Around::Robot(_) => self.leave_ring(&round),
        }
        self.next_round();
    }

    fn pose_of(&self, round: &Round, direction: usize) -> Se2 {
        let (at, ahead_rad, out_m) = match round.around {
            Around::Place(index) => (self.places[index].at, self.places[index].heading_rad, STEP_M),
            Around::Robot(radius_m) => {
                let way = self.goal - self.start.position();
                let far = way.norm() > 0.1;
                let goal_rad = if far { way.y.atan2(way.x) } else { self.start.yaw_rad };
                (self.start.position(), goal_rad, radius_m)
            }
        };
        let yaw_rad = wrap_to_pi(ahead_rad + direction as f64 * std::f64::consts::FRAC_PI_4);
        let out = Se2::new(at.x, at.y, yaw_rad).transform_point(Vec2::new(out_m, 0.0));
        Se2::new(out.x, out.y, yaw_rad)
    }

    /// Whether there may be more, or less, than one trail that goes on straight.
    fn is_unclear(&self, round: &Round) -> bool {
        if matches!(round.around, Around::Robot(_)) {
            return false;
        }
        let ahead = round.strength(AHEAD);
        let sides = round.strength(LEFT).max(round.strength(RIGHT));
        ahead < AHEAD_RATIO * self.alone || sides >= SIDE_RATIO * self.alone.max(ahead)
    }

    /// Takes the ways on from a place: strongest first, because what is near to a place that was
    /// found just now is this place.
    fn leave_place(&mut self, index: usize, round: &Round) {
        let ahead = round.strength(AHEAD);
        if !round.closely {
            let first = self.alone <= 0.0;
            self.alone = if first { ahead } else { 0.9 * self.alone + 0.1 * ahead };
        }
        let alone = self.alone.max(1.0);
        let branch = |direction: usize| match direction {
            3 | 5 => round.strength(direction) - BACK_TRAIL_RATIO * alone,
            _ => round.strength(direction),
        };
        let mut open = [false; N_DIRECTIONS];
        for direction in DIRECTIONS {
            let least = match direction {
                AHEAD => 0.0,
                3 | 5 => BACK_BRANCH_RATIO * alone,
                _ => BRANCH_RATIO * alone,
            };
            open[direction] = branch(direction) > least;
        }
        // The first of equals, as `max_by` gives the last.
        let strongest = |open: &[bool; N_DIRECTIONS]| {
            let candidates = DIRECTIONS.into_iter().rev().filter(|k| open[*k]);
            candidates.max_by(|a, b| branch(*a).total_cmp(&branch(*b)))
        };
        while let Some(direction) = strongest(&open) {
            open[direction] = false;
            self.go(index, round, direction);
        }
        self.places[index].asked = true;
    }

    /// Takes what was smelled around the robot: where it was strongest, between weaker neighbours.
    fn leave_ring(&mut self, round: &Round) {
        for direction in 0..N_DIRECTIONS {
            let here = round.strength(direction);
            let left = round.strength(direction + 1);
            let right = round.strength(direction + N_DIRECTIONS - 1);
            // Of equal neighbours the one to the left counts, except at the seam.
            if here > 0.0 && here >= left && (here > right || direction == 0 && here >= right) {
                self.go(0, round, direction);
            }
        }
    }

    /// From a place into a direction: to a new place, or to one that is known.
    fn go(&mut self, from: usize, round: &Round, direction: usize) {
        let Some((left, right)) = round.answers[direction] else { return };
        let asked = self.pose_of(round, direction);
        let from_robot = matches!(round.around, Around::Robot(_));
        let aside_m = ASIDE_M * (left - right) / (left + right);
        let out_m = if from_robot { RING_BEYOND_M } else { 0.0 };
        let aside = Vec2::new(out_m, aside_m.clamp(-ASIDE_MAX_M, ASIDE_MAX_M));
        let at = asked.transform_point(aside);
        if let Some(known) = self.known_at(at, from, from_robot) {
            if !from_robot {
                self.link(from, known);
            }
            return;
        }
        let way = at - self.places[from].at;
        let way_m = self.places[from].way_m + way.norm();
        if self.places.len() >= N_PLACES_MAX || way_m > self.way_max_m {
            self.is_cut_short = true;
            return;
        }
        let way_rad = if way.norm() > 0.05 { way.y.atan2(way.x) } else { asked.yaw_rad };
        let turn_rad = TURN_RATIO * wrap_to_pi(way_rad - asked.yaw_rad);
        self.places.push(Place {
            at,
            heading_rad: wrap_to_pi(asked.yaw_rad + turn_rad),
            way_m,
            before: index_u16(from),
            asked: false,
            links: [NONE; N_LINKS_MAX],
            n_links: 0,
        });
        if !from_robot {
            self.searched_m += way.norm();
        }
        self.link(from, self.places.len() - 1);
    }

    /// The nearest known place that `at` is the same as, other than `from`.
    fn known_at(&self, at: Vec2, from: usize, from_robot: bool) -> Option<usize> {
        let first = usize::from(from_robot);
        let others = self.places.iter().enumerate().skip(first).filter(|(m, _)| *m != from);
        let distances = others.map(|(m, place)| ((place.at - at).norm(), m));
        let near = distances.filter(|(distance_m, _)| *distance_m < SAME_M);
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, m)| m)
    }

    /// Connects two places, and shortens what is shorter through the new link.
    fn link(&mut self, a: usize, b: usize) {
        for (from, to) in [(a, b), (b, a)] {
            let place = &mut self.places[from];
            let n_links = usize::from(place.n_links);
            if n_links < N_LINKS_MAX && !place.links[..n_links].contains(&index_u16(to)) {
                place.links[n_links] = index_u16(to);
                place.n_links += 1;
            }
        }
        // Ends: each change makes a way shorter, over a finite number of them.
        let mut has_changed = true;
        while has_changed {
            has_changed = false;
            for index in 0..self.places.len() {
                let place = self.places[index];
                for to in place.links() {
                    let way_m = place.way_m + (self.places[to].at - place.at).norm();
                    if way_m < self.places[to].way_m - 1e-9 {
                        self.places[to].way_m = way_m;
                        self.places[to].before = index_u16(index);
                        has_changed = true;
                    }
                }
            }
        }
    }

    /// The place at the goal with the shortest way to the goal, and the length of this way.
    fn at_goal(&self) -> Option<(usize, f64)> {
        let places = self.places.iter().enumerate().skip(1);
        let near = places.map(|(index, place)| (index, place, (place.at - self.goal).norm()));
        let at_goal = near.filter(|(_, _, distance_m)| *distance_m < AT_GOAL_M);
        let ways = at_goal.map(|(index, place, distance_m)| (index, place.way_m + distance_m));
        ways.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The place nearest to the goal, and its distance to it (m).
    fn nearest(&self) -> Option<(usize, f64)> {
        let places = self.places.iter().enumerate().skip(1);
        let distances = places.map(|(index, place)| (index, (place.at - self.goal).norm()));
        distances.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The place not asked about yet through which the goal could be nearest, and that way's length.
    fn most_promising(&self) -> Option<(usize, f64)> {
        let open = self.places.iter().enumerate().filter(|(_, place)| !place.asked);
        let ways = open.map(|(index, place)| (index, place.way_m + (place.at - self.goal).norm()));
        ways.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn next_round(&mut self) {
        self.round = None;
        let goal_way_m = self.at_goal().map(|(_, way_m)| way_m);
        match (self.most_promising(), goal_way_m) {
            (Some((_, open_m)), Some(goal_m)) if open_m >= goal_m => self.status = Search::Found,
            (None, Some(_)) => self.status = Search::Found,
            _ if self.n_questions >= N_QUESTIONS_MAX => {
                self.is_cut_short = true;
                self.status = Search::LimitReached;
            }
            (Some((index, _)), _) => self.round = Some(Round::new(Around::Place(index))),
            (None, None) => match RINGS_M.get(self.n_rings) {
                Some(radius_m) => {
                    self.n_rings += 1;
                    self.round = Some(Round::new(Around::Robot(*radius_m)));
                }
                None if self.is_cut_short => self.status = Search::LimitReached,
                None => self.status = Search::Exhausted,
            },
        }
    }
}

/// Places are fewer than 2¹⁶.
fn index_u16(index: usize) -> u16 {
    debug_assert!(index < N_PLACES_MAX, "place {index}");
    index as u16
}

#[cfg(test)]
mod tests;
