//! The filter: particles moved, weighed, drawn anew.

use std::{f64::consts::TAU, sync::Arc};

use geometry::{Se2, Transform2, Twist, Vec2, wrap_to_pi};
use nalgebra::{Matrix3, Vector3};
use rand_core::Rng as _;
use rand_distr::{Distribution, StandardNormal};
use robot_models::PoseCovariance;
use run_context::{RandomStream, StateHash};

use crate::{
    config::{ConfigError, FilterConfig},
    estimate::{Estimate, Health},
    field::LikelihoodField,
    spread::{Spread, n_for},
};

/// Particles within so much of the heaviest bin belong to its group: metres, radians.
const GROUP_M: f64 = 0.5;
const GROUP_RAD: f64 = 0.4;

/// A group with so much of the weight is taken for all of it.
const GROUP_SHARE: f64 = 0.9;

/// Drawn anew when the particles are worth fewer than this part of their number.
const RESAMPLE_BELOW: f64 = 0.5;

/// Tries to draw a free place for a random particle.
const N_TRIES: usize = 50;

/// A robot that may have been anywhere is sure again after so much way on which so many of its beams fitted: a place that looks
/// alike seldom does so for long. Metres, part of the beams.
const PROOF_M: f64 = 2.0;
const PROOF_AGREEMENT: f64 = 0.85;

/// The same where people stand around it: what a way counts then.
const FAIR_AGREEMENT: f64 = 0.55;
const FAIR_PROOF_RATIO: f64 = 0.25;

/// Random particles among those drawn from which on it may be anywhere, a part of all.
const DOUBT_RATIO: f64 = 0.05;

/// Part of the beams that must fit before those that do not are left out.
const FITTING_MIN: f64 = 0.5;

/// Where a robot is on a map, as many poses with weights.
#[derive(Clone, Debug)]
pub struct ParticleFilter {
    config: FilterConfig,
    field: Arc<LikelihoodField>,
    rng: RandomStream,
    poses: Vec<Se2>,
    weights: Vec<f64>,
    drawn: Vec<Se2>,
    scores: Vec<u32>,
    points: [Vec<f32>; 2],
    used: Vec<Vec2>,
    spread: Spread,
    /// Averages of agreement, the slow one and the quick one.
    averages: Option<[f64; 2]>,
    /// Way for which what was seen has fitted well since it may have been anywhere, metres; infinite where it was told.
    proven_m: f64,
    /// Way since the last correction, metres.
    way_m: f64,
    estimate: Estimate,
}

/// What a correction did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// Beams used, and left out because somebody stands in their way.
    pub n_used: usize,
    /// Beams left out.
    pub n_left_out: usize,
    /// Particles that were drawn anew, and how many of them at random; 0 where none were.
    pub n_drawn: usize,
    /// Random ones among them.
    pub n_random: usize,
}

impl ParticleFilter {
    /// A filter that knows the robot to be at `map_from_base`, within standard deviations of `position_std_m` (m) and
    /// `heading_std_rad` (rad).
    ///
    /// # Errors
    ///
    /// [`ConfigError`].
    pub fn at(
        config: FilterConfig,
        field: Arc<LikelihoodField>,
        mut rng: RandomStream,
        map_from_base: Se2,
        [position_std_m, heading_std_rad]: [f64; 2],
    ) -> Result<Self, ConfigError> {
        let n = config.checked()?.n_min;
        let mut draw = || {
            let mut off = |std: f64| -> f64 {
                let normal: f64 = StandardNormal.sample(&mut rng);
                std * normal
            };
            Se2::new(
                map_from_base.x_m + off(position_std_m),
                map_from_base.y_m + off(position_std_m),
                wrap_to_pi(map_from_base.yaw_rad + off(heading_std_rad)),
            )
        };
        let poses: Vec<Se2> = (0..n).map(|_| draw()).collect();
        Ok(Self { proven_m: f64::INFINITY, ..Self::of(config, field, rng, poses) })
    }

    /// A filter that knows nothing: `n_max` particles all over the free cells of the map.
    ///
    /// # Errors
    ///
    /// [`ConfigError`].
    pub fn anywhere(
        config: FilterConfig,
        field: Arc<LikelihoodField>,
        mut rng: RandomStream,
    ) -> Result<Self, ConfigError> {
        let n = config.checked()?.n_max;
        let poses = (0..n).map(|_| random_pose(&field, &mut rng)).collect();
        Ok(Self::of(config, field, rng, poses))
    }

    fn of(
        config: FilterConfig,
        field: Arc<LikelihoodField>,
        rng: RandomStream,
        poses: Vec<Se2>,
    ) -> Self {
        let n_max = config.n_max;
        let mut all = Vec::with_capacity(n_max);
        all.extend(poses);
        let mut weights = Vec::with_capacity(n_max);
        weights.resize(all.len(), 1.0 / all.len() as f64);
        let mut filter = Self {
            config,
            field,
            rng,
            poses: all,
            weights,
            drawn: Vec::with_capacity(n_max),
            scores: Vec::with_capacity(n_max),
            points: Default::default(),
            used: Vec::new(),
            spread: Spread::with_capacity(n_max),
            averages: None,
            proven_m: 0.0,
            way_m: 0.0,
            estimate: Estimate {
                map_from_base: Transform2::new(Se2::IDENTITY),
                covariance: PoseCovariance::zero(),
                agreement_ratio: 1.0,
                share_ratio: 1.0,
                health: Health::Unsure,
            },
        };
        filter.describe();
        filter
    }

    /// The particles, and their weights, which sum to 1.
    pub fn particles(&self) -> impl Iterator<Item = (Se2, f64)> + '_ {
        self.poses.iter().copied().zip(self.weights.iter().copied())
    }

    /// Where the robot is.
    pub fn estimate(&self) -> Estimate {
        self.estimate
    }

    /// The robot says that it moved so, from the base frame before to the one now; each particle moves so, and each errs
    /// in its own way. O(particles).
    pub fn predict(&mut self, moved: Se2) {
        let Twist { dx_m, dy_m, dyaw_rad } = moved.log();
        self.way_m += dx_m.hypot(dy_m);
        let half_m = 0.5 * dyaw_rad * self.config.drive.wheelbase_m;
        let (left_m, right_m) = (dx_m - half_m, dx_m + half_m);
        let noise = self.config.noise;
        let left_std_m = noise.left_std_ratio * left_m.abs().sqrt();
        let right_std_m = noise.right_std_ratio * right_m.abs().sqrt();
        if left_m == 0.0 && right_m == 0.0 && dy_m == 0.0 {
            return;
        }
        for pose in &mut self.poses {
            let mut normal = || -> f64 { StandardNormal.sample(&mut self.rng) };
            let (left_m, right_m) =
                (left_m + left_std_m * normal(), right_m + right_std_m * normal());
            let twist = Twist {
                dx_m: 0.5 * (left_m + right_m),
                dy_m,
                dyaw_rad: (right_m - left_m) / self.config.drive.wheelbase_m,
            };
            *pose = pose.compose(Se2::exp(twist));
        }
        let guess = self.estimate.map_from_base.se2().compose(moved);
        self.estimate.map_from_base = Transform2::new(guess);
    }

    /// Weighs the particles by a scan: the places (m, base frame) where its beams ended; then draws them anew where that is
    /// worth it. Some 60 beams around the robot are enough. O(particles × beams).
    pub fn correct(&mut self, ends_in_base: &[Vec2]) -> Correction {
        let n_all = ends_in_base.len();
        self.choose(ends_in_base);
        let n_used = self.used.len();
        let none = Correction { n_used, n_left_out: n_all - n_used, n_drawn: 0, n_random: 0 };
        if n_used == 0 {
            return none;
        }
        self.weigh();
        // Of all that was seen: what was left out fits no less because of that.
        self.used.clear();
        self.used.extend_from_slice(ends_in_base);
        self.describe();
        let (n_drawn, n_random) = self.draw(self.estimate.agreement_ratio);
        self.doubt(n_random as f64 > DOUBT_RATIO * n_drawn as f64);
        Correction { n_drawn, n_random, ..none }
    }

    /// Leaves out beams that end where the map is empty around the best guess, as long as most fit there.
    fn choose(&mut self, ends_in_base: &[Vec2]) {
        let guess = self.estimate.map_from_base.se2();
        let fitting = self.field.steps_of(self.config.surprise_m).max(1);
        let fits = |end: &Vec2| self.field.steps_at(guess.transform_point(*end)) >= fitting;
        let n_fitting = ends_in_base.iter().filter(|end| fits(end)).count();
        let trusts = self.estimate.health == Health::Sure
            && n_fitting as f64 >= FITTING_MIN * ends_in_base.len() as f64;
        self.used.clear();
        self.used.extend(ends_in_base.iter().filter(|end| !trusts || fits(end)));
    }

    /// New weights.
    fn weigh(&mut self) {
        let Self { field, points, used, scores, poses, weights, config, .. } = self;
        field.scaled(used, points);
        let [xs, ys] = &*points;
        scores.clear();
        scores.extend(poses.iter().map(|pose| field.score(*pose, [xs, ys])));
        let best = scores.iter().copied().max().unwrap_or(0);
        let step = field.step() * (config.n_independent / used.len() as f64).min(1.0);
        let mut sum = 0.0;
        for (weight, score) in weights.iter_mut().zip(&*scores) {
            *weight *= (-step * f64::from(best - score)).exp();
            sum += *weight;
        }
        for weight in weights {
            *weight /= sum;
        }
    }

    /// Draws the particles anew where few of them carry the weight, or where random ones are wanted. `agreement` is that
    /// of the best guess. (Not the mean of all: random particles, mixed in because little fitted, would lower it, and more
    /// would be mixed in.)
    fn draw(&mut self, agreement: f64) -> (usize, usize) {
        let [slow_rate, quick_rate] = self.config.recovery;
        let [slow, quick] = self.averages.get_or_insert([agreement; 2]);
        *slow += slow_rate * (agreement - *slow);
        *quick += quick_rate * (agreement - *quick);
        let random_ratio = (1.0 - *quick / slow.max(1e-9)).max(0.0);
        let worth = 1.0 / self.weights.iter().map(|w| w * w).sum::<f64>();
        if worth > RESAMPLE_BELOW * self.poses.len() as f64 && random_ratio < 0.02 {
            return (0, 0);
        }
        self.spread.take(self.poses.iter().copied());
        let wanted = n_for(self.occupied_bins(), self.config.kld_max_ratio);
        let n = (wanted.ceil() as usize).clamp(self.config.n_min, self.config.n_max);
        let n_random = (random_ratio * n as f64) as usize;
        self.drawn.clear();
        // Low variance: one random number, and equal steps through the sums of weights.
        let n_kept = n - n_random;
        let step = 1.0 / n_kept.max(1) as f64;
        let mut at = uniform(&mut self.rng) * step;
        let mut sum = 0.0;
        for (pose, weight) in self.poses.iter().zip(&self.weights) {
            sum += weight;
            while at < sum && self.drawn.len() < n_kept {
                self.drawn.push(*pose);
                at += step;
            }
        }
        // Rounding may leave the last ones out.
        while self.drawn.len() < n_kept
            && let Some(&last) = self.poses.last()
        {
            self.drawn.push(last);
        }
        for _ in 0..n_random {
            let pose = random_pose(&self.field, &mut self.rng);
            self.drawn.push(pose);
        }
        std::mem::swap(&mut self.poses, &mut self.drawn);
        self.weights.clear();
        self.weights.resize(n, 1.0 / n as f64);
        (n, n_random)
    }

    /// Bins that hold more than a trifle of the weight.
    fn occupied_bins(&self) -> usize {
        self.spread.n_bins_of(&self.weights, 1e-3 / self.poses.len() as f64)
    }

    /// Mean and covariance of the heaviest group, and how they fit what was seen last.
    fn describe(&mut self) {
        self.spread.take(self.poses.iter().copied());
        let Some(index) = self.spread.heaviest(&self.weights) else { return };
        let centre = self.poses[index];
        let is_near = |pose: &Se2| {
            (pose.position() - centre.position()).norm() <= GROUP_M
                && wrap_to_pi(pose.yaw_rad - centre.yaw_rad).abs() <= GROUP_RAD
        };
        let (mut share, mut sums) = (0.0, [0.0; 4]);
        for (pose, weight) in self.poses.iter().zip(&self.weights).filter(|(pose, _)| is_near(pose))
        {
            let (s, c) = pose.yaw_rad.sin_cos();
            share += weight;
            for (sum, value) in sums.iter_mut().zip([pose.x_m, pose.y_m, c, s]) {
                *sum += weight * value;
            }
        }
        let mean = Se2::new(sums[0] / share, sums[1] / share, sums[3].atan2(sums[2]));
        // A few random particles elsewhere look for what might be; they say nothing about where it is.
        let in_group = share >= GROUP_SHARE;
        let total = if in_group { share } else { 1.0 };
        let mut covariance = Matrix3::zeros();
        for (pose, weight) in
            self.poses.iter().zip(&self.weights).filter(|(pose, _)| !in_group || is_near(pose))
        {
            let yaw_off_rad = wrap_to_pi(pose.yaw_rad - mean.yaw_rad);
            let off = Vector3::new(pose.x_m - mean.x_m, pose.y_m - mean.y_m, yaw_off_rad);
            covariance += *weight / total * off * off.transpose();
        }
        let fitting = self.field.steps_of(0.5 * self.config.surprise_m).max(1);
        let fits = |end: &&Vec2| self.field.steps_at(mean.transform_point(**end)) >= fitting;
        let agreement = match self.used.len() {
            0 => 1.0,
            n => self.used.iter().filter(fits).count() as f64 / n as f64,
        };
        self.estimate = Estimate {
            map_from_base: Transform2::new(mean),
            covariance: PoseCovariance(covariance),
            agreement_ratio: agreement,
            share_ratio: share,
            health: Health::Unsure,
        }
        .with_health();
    }

    /// Keeps a robot that may be anywhere from being sure before it has proved itself.
    fn doubt(&mut self, may_be_anywhere: bool) {
        let way_m = std::mem::take(&mut self.way_m);
        let Estimate { health, agreement_ratio: agreement, .. } = self.estimate;
        if health == Health::Lost || may_be_anywhere && agreement < FAIR_AGREEMENT {
            self.proven_m = 0.0;
        } else if self.proven_m < PROOF_M {
            self.proven_m = match agreement {
                _ if health != Health::Sure => 0.0,
                a if a >= PROOF_AGREEMENT => self.proven_m + way_m,
                a if a >= FAIR_AGREEMENT => self.proven_m + FAIR_PROOF_RATIO * way_m,
                _ => 0.0,
            };
        }
        if self.proven_m < PROOF_M && self.estimate.health == Health::Sure {
            self.estimate.health = Health::Unsure;
        }
    }

    /// Adds what decides its future to a hash.
    pub fn absorb_state(&self, hash: &mut StateHash) {
        for (pose, weight) in self.particles() {
            for value in [pose.x_m, pose.y_m, pose.yaw_rad, weight] {
                hash.absorb(value);
            }
        }
    }
}

/// An even draw from [0, 1).
fn uniform(rng: &mut RandomStream) -> f64 {
    (rng.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
}

/// Somewhere in the open cells of the map.
fn random_pose(field: &LikelihoodField, rng: &mut RandomStream) -> Se2 {
    let [width, height] = field.size();
    let mut place = Vec2::zeros();
    for _ in 0..N_TRIES {
        let at = Vec2::new(uniform(rng) * width as f64, uniform(rng) * height as f64);
        place = field.map_from_cells().transform_point(at * field.cell_m());
        if field.is_open(place) {
            break;
        }
    }
    Se2::new(place.x, place.y, wrap_to_pi(TAU * uniform(rng)))
}
