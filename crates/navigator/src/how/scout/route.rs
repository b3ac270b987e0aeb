//! The way that a search has found, written out point by point.

use geometry::Vec2;

use super::{N_PLACES_MAX, NONE, Place, STEP_M, Scout, Search, index_u16};

/// A route passes a branch where another trail is at least so far from all of it, metres.
const BRANCH_ASIDE_M: f64 = 0.25;

impl Scout {
    /// Where the best route ends and how far from the goal that is (m): at the goal if a trail
    /// passes it, else where a trail is nearest to it, or, of a search that was cut short, where
    /// the way on looks shortest.
    pub(crate) fn route_end(&self) -> Option<(usize, f64)> {
        let (index, _) = self.at_goal().or_else(|| match self.status {
            Search::LimitReached => self.most_promising_end(),
            _ => self.nearest(),
        })?;
        Some((index, (self.places[index].at - self.goal).norm()))
    }

    /// As [`most_promising`](Self::most_promising), but also among places at the limit of the way.
    fn most_promising_end(&self) -> Option<(usize, f64)> {
        let at_limit = |place: &Place| place.way_m > self.way_max_m - 2.0 * STEP_M;
        let places = self.places.iter().enumerate().skip(1);
        let open = places.filter(|(_, place)| !place.asked || at_limit(place));
        let ways = open.map(|(index, place)| (index, place.way_m + (place.at - self.goal).norm()));
        ways.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Writes the route to a place: points every `spacing_m` from the trail's beginning (m, map),
    /// and for each whether the antennas smell another trail near it, too.
    ///
    /// `beyond` is appended at the end. At most what `points` has room for is written.
    pub(crate) fn route(
        &mut self,
        end: usize,
        beyond: Option<Vec2>,
        spacing_m: f64,
        points: &mut Vec<Vec2>,
        is_mixed: &mut Vec<bool>,
    ) {
        self.collect_route(end);
        points.clear();
        is_mixed.clear();
        let n_places = self.route.len();
        let mut last: Option<Vec2> = None;
        let mut carried_m = 0.0;
        for k in 0..n_places + usize::from(beyond.is_some()) {
            let to = if k < n_places { Some(self.smooth(k)) } else { beyond };
            let Some(to) = to else { break };
            let Some(from) = last.replace(to) else {
                points.push(to);
                continue;
            };
            let length_m = (to - from).norm();
            let mut along_m = spacing_m - carried_m;
            while along_m <= length_m && points.len() < points.capacity() {
                points.push(from + (to - from) * (along_m / length_m));
                along_m += spacing_m;
            }
            carried_m = length_m - (along_m - spacing_m);
        }
        if let Some(to) = last.filter(|_| carried_m > 0.02 && points.len() < points.capacity()) {
            points.push(to);
        }
        is_mixed.extend(points.iter().map(|_| false));
        self.mark_branches(points, is_mixed);
    }

    /// The places of the way to `end` in `self.route`, from the robot's; without the robot's own
    /// place when the trail is elsewhere.
    fn collect_route(&mut self, end: usize) {
        self.route.clear();
        let mut index = end;
        while self.route.len() < N_PLACES_MAX {
            self.route.push(index_u16(index));
            let before = self.places[index].before;
            if before == NONE {
                break;
            }
            index = usize::from(before);
        }
        self.route.reverse();
        if let [robot, first, ..] = self.route[..] {
            let gap = self.places[usize::from(first)].at - self.places[usize::from(robot)].at;
            if gap.norm() > STEP_M {
                self.route.remove(0);
            }
        }
    }

    /// The route's place `k`, a quarter of the way to each of its neighbours.
    fn smooth(&self, k: usize) -> Vec2 {
        let at = |k: usize| self.places[usize::from(self.route[k])].at;
        if k == 0 || k + 1 >= self.route.len() {
            return at(k);
        }
        0.25 * at(k - 1) + 0.5 * at(k) + 0.25 * at(k + 1)
    }

    /// Marks the points near branches that the route does not take.
    fn mark_branches(&self, points: &[Vec2], is_mixed: &mut [bool]) {
        /// Antennas smell a branch from so far, metres, with some room.
        const MIXED_WITHIN_M: f64 = 0.8;
        for index in &self.route {
            let place = &self.places[usize::from(*index)];
            let leads_aside = place.links().any(|to| {
                let gaps = points.iter().map(|point| (self.places[to].at - point).norm());
                to != 0 && gaps.fold(f64::INFINITY, f64::min) > BRANCH_ASIDE_M
            });
            if leads_aside {
                for (point, mixed) in points.iter().zip(is_mixed.iter_mut()) {
                    *mixed |= (place.at - point).norm() < MIXED_WITHIN_M;
                }
            }
        }
    }
}
