//! The way of a short-term map: odometry's steps from a start, bent by what odometry misses.

use geometry::{Se2, Twist};
use run_context::Stamp;

/// One step of odometry, as measured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub stamp: Stamp,
    /// The motion since the step before, as a twist.
    pub twist: Twist,
}

/// Pose and yaw that odometry misses per metre; what is estimated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    pub map_from_base: Se2,
    pub missed_yaw_radpm: f64,
}

/// Steps from a start on, with what follows for every pose.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    pub start: Start,
    pub start_stamp: Stamp,
    steps: Vec<Step>,
    /// One more than steps: the start, then the pose after each step.
    poses: Vec<Se2>,
}

/// A place on the chain: so much (0 to 1) of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    pub step: usize,
    pub ratio: f64,
}

impl Chain {
    pub(crate) fn new(start: Start, start_stamp: Stamp) -> Self {
        Self { start, start_stamp, steps: Vec::new(), poses: vec![start.map_from_base] }
    }

    pub(crate) fn push(&mut self, step: Step) {
        self.steps.push(step);
        self.follow(self.steps.len() - 1);
    }

    /// Begins anew at its end. Keeps its memory.
    pub(crate) fn restart(&mut self, start: Start) {
        self.start_stamp = self.end_stamp();
        self.start = start;
        self.steps.clear();
        self.poses.clear();
        self.poses.push(start.map_from_base);
    }

    /// The same steps from another start.
    pub(crate) fn set_start(&mut self, start: Start) {
        self.start = start;
        self.poses.clear();
        self.poses.push(start.map_from_base);
        for step in 0..self.steps.len() {
            self.follow(step);
        }
    }

    fn follow(&mut self, step: usize) {
        let twist = self.corrected(step);
        let to = self.poses[step].compose(Se2::exp(twist));
        self.poses.push(to);
    }

    fn corrected(&self, step: usize) -> Twist {
        let twist = self.steps[step].twist;
        Twist { dyaw_rad: twist.dyaw_rad + self.start.missed_yaw_radpm * twist.dx_m, ..twist }
    }

    pub(crate) fn end(&self) -> Se2 {
        self.poses[self.poses.len() - 1]
    }

    pub(crate) fn end_stamp(&self) -> Stamp {
        self.steps.last().map_or(self.start_stamp, |step| step.stamp)
    }

    /// The last step continues until `stamp`, without motion.
    pub(crate) fn wait_until(&mut self, stamp: Stamp) {
        match self.steps.last_mut() {
            Some(step) => step.stamp = stamp,
            None => self.start_stamp = stamp,
        }
    }

    /// Way without sign, metres.
    pub(crate) fn length_m(&self) -> f64 {
        self.steps.iter().map(|step| step.twist.dx_m.hypot(step.twist.dy_m)).sum()
    }

    pub(crate) fn n_steps(&self) -> usize {
        self.steps.len()
    }

    /// Where `stamp` lies, among the last steps; before the start, the start.
    pub(crate) fn moment(&self, stamp: Stamp) -> Moment {
        let mut begin = self.start_stamp;
        if stamp <= begin || self.steps.is_empty() {
            return Moment { step: 0, ratio: 0.0 };
        }
        let step = self.steps.partition_point(|step| step.stamp < stamp);
        if step == self.steps.len() {
            return Moment { step: step - 1, ratio: 1.0 };
        }
        if step > 0 {
            begin = self.steps[step - 1].stamp;
        }
        let whole_s = self.steps[step].stamp.since(begin).as_secs_f64();
        let ratio = if whole_s > 0.0 { stamp.since(begin).as_secs_f64() / whole_s } else { 1.0 };
        Moment { step, ratio }
    }

    pub(crate) fn pose(&self, at: Moment) -> Se2 {
        let from = self.poses[at.step];
        if at.step >= self.steps.len() {
            return from;
        }
        let twist = self.corrected(at.step);
        from.compose(Se2::exp(Twist {
            dx_m: twist.dx_m * at.ratio,
            dy_m: twist.dy_m * at.ratio,
            dyaw_rad: twist.dyaw_rad * at.ratio,
        }))
    }

    /// The step's twist, as measured.
    pub(crate) fn twist(&self, step: usize) -> Twist {
        self.steps[step].twist
    }

    /// Bends the chain by another missed yaw and lays its end on `map_from_base`.
    pub(crate) fn end_at(&mut self, map_from_base: Se2, missed_yaw_radpm: f64) {
        self.set_start(Start { missed_yaw_radpm, ..self.start });
        let start_from_end = self.end().inverse().compose(self.start.map_from_base);
        let start = map_from_base.compose(start_from_end);
        self.set_start(Start { map_from_base: start, missed_yaw_radpm });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(start: Start) -> Chain {
        let mut chain = Chain::new(start, Stamp::ZERO);
        for k in 1..=20_u64 {
            let dyaw_rad = if k > 10 { 0.1 } else { 0.0 };
            let twist = Twist { dx_m: 0.1, dy_m: 0.0, dyaw_rad };
            chain.push(Step { stamp: Stamp::from_millis(k * 100), twist });
        }
        chain
    }

    fn start(x: f64, y: f64, yaw: f64, missed: f64) -> Start {
        Start { map_from_base: Se2::new(x, y, yaw), missed_yaw_radpm: missed }
    }

    #[test]
    fn a_moment_lies_within_its_step() {
        let c = chain(start(0.0, 0.0, 0.0, 0.0));
        let at = c.moment(Stamp::from_millis(250));
        assert_eq!(at.step, 2);
        assert!((at.ratio - 0.5).abs() < 1e-12);
        assert!((c.pose(at).x_m - 0.25).abs() < 1e-12);
        assert_eq!(c.moment(Stamp::ZERO), Moment { step: 0, ratio: 0.0 });
        assert_eq!(c.moment(Stamp::from_millis(9000)), Moment { step: 19, ratio: 1.0 });
        assert!((c.length_m() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_missed_yaw_bends_the_way() {
        let mut c = chain(start(0.0, 0.0, 0.0, 0.0));
        let straight = c.end().yaw_rad;
        c.set_start(start(0.0, 0.0, 0.0, 0.05));
        assert!((c.end().yaw_rad - straight - 0.1).abs() < 1e-12);
    }

    #[test]
    fn its_end_can_be_laid_anywhere() {
        let mut c = chain(start(0.0, 0.0, 0.0, 0.0));
        let to = Se2::new(3.0, -1.0, 2.0);
        c.end_at(to, -0.03);
        let off = c.end().inverse().compose(to);
        assert!(off.position().norm() < 1e-12 && off.yaw_rad.abs() < 1e-12);
        assert!((c.start.missed_yaw_radpm + 0.03).abs() < 1e-15);
    }
}
