//! Beams fired one after the other, while time passes and the robot moves.

use std::time::Duration;

use geometry::{Ray, RayCaster, Se2, Vec2, wrap_to_pi};
use run_context::{RandomStream, Stamp, StateHash};

use super::{LaserEcho, LaserModel, Luck};
use crate::material::Material;

/// Between two calls a robot does not drive this far (m): it was lifted, and beams start from where it is
/// now.
const LIFTED_M: f64 = 0.5;

/// One beam that was fired.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Its index, from 0 to the model's `n_beams` − 1.
    pub index: usize,
    /// When it was fired.
    pub at: Stamp,
    /// Where it looked, from the sensor's x axis, radians, counter-clockwise, not wrapped.
    pub bearing_rad: f64,
    /// What came back.
    pub echo: LaserEcho,
    /// Whether it is the first that its scan fired.
    pub is_first: bool,
    /// Whether it is the last that its scan fired.
    pub is_last: bool,
}

/// A turning laser. Give it the time and where its sensor is every few milliseconds; it fires the beams that have
/// become due, each from where the sensor was at that instant.
///
/// It stands still until it is [`start`](Self::start)ed. Cost: one [`RayCaster::cast`] per beam and up
/// to four more behind glass or in mirrors, one random number per scan. Allocates only when it is made.
#[derive(Clone, Debug)]
pub struct Sweep {
    model: LaserModel,
    /// In the order in which they are fired.
    beams: Vec<Due>,
    rng: RandomStream,
    luck: Luck,
    /// When the present scan began; `None` while the head stands.
    began: Option<Stamp>,
    next: usize,
    /// Where the sensor was when it was asked last.
    last: Option<(Stamp, Se2)>,
}

/// When a beam is due, and where it looks.
#[derive(Clone, Copy, Debug)]
struct Due {
    index: u32,
    after: Duration,
    direction_in_sensor: Vec2,
}

impl Sweep {
    /// A laser whose head stands still. `model` should be [`checked`](LaserModel::checked).
    pub fn new(model: LaserModel, mut rng: RandomStream) -> Self {
        let mut sweep = Self {
            beams: Vec::with_capacity(model.n_beams),
            luck: Luck::draw(&mut rng),
            model,
            rng,
            began: None,
            next: 0,
            last: None,
        };
        sweep.set_model(model);
        sweep
    }

    /// How it measures.
    pub fn model(&self) -> &LaserModel {
        &self.model
    }

    /// Whether the head turns.
    pub fn is_turning(&self) -> bool {
        self.began.is_some()
    }

    /// Other beams from now on, as when a client chooses another resolution; a scan under way is
    /// given up and a new one begins with the next call of [`fire`](Self::fire), if the head turns.
    /// Allocates when there are more beams than ever.
    pub fn set_model(&mut self, model: LaserModel) {
        self.model = model;
        self.beams.clear();
        self.beams.extend((0..model.n_beams).map(|index| {
            let (s, c) = model.bearing_rad(index).sin_cos();
            let after = model.fired_after(index);
            Due { index: index as u32, after, direction_in_sensor: Vec2::new(c, s) }
        }));
        self.beams.sort_unstable_by_key(|due| (due.after, due.index));
        self.next = 0;
        if let (Some(began), Some((now, _))) = (&mut self.began, self.last) {
            *began = now;
        }
    }

    /// Starts the head; the first beam is fired at `now`. Changes nothing when it turns already.
    pub fn start(&mut self, now: Stamp) {
        if self.began.is_none() {
            self.began = Some(now);
            self.next = 0;
            self.last = None;
            self.luck = Luck::draw(&mut self.rng);
        }
    }

    /// Stops the head; the scan under way is lost.
    pub fn stop(&mut self) {
        self.began = None;
    }

    /// Absorbs where the head stands, what decides its next errors included.
    pub fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.began.map_or(u64::MAX, Stamp::as_nanos));
        hash.absorb_u64(self.next as u64);
        hash.absorb_u64(self.beams.len() as u64);
        self.luck.absorb(hash);
    }

    /// Fires the beams that are due by `now` into `scene`, whose tags are indices into `materials`, and gives
    /// each to `take`. Between two calls the sensor is taken to have moved evenly on a straight line.
    ///
    /// After a pause of more than two scans the beams that were missed are left out and a scan begins
    /// anew.
    pub fn fire(
        &mut self,
        now: Stamp,
        world_from_sensor: Se2,
        scene: &impl RayCaster,
        materials: &[Material],
        mut take: impl FnMut(Beam),
    ) {
        let last = self.last.replace((now, world_from_sensor));
        let Some(mut began) = self.began else { return };
        let period = self.model.scan_period();
        if period.is_zero() || self.beams.is_empty() {
            return;
        }
        if now.since(began) > 3 * period {
            began = now;
            self.next = 0;
        }
        let way = Way::between(last, now, world_from_sensor);
        while let Some(&due) = self.beams.get(self.next) {
            let at = began + due.after;
            if at > now {
                break;
            }
            let echo = self.model.measure(
                &way.ray(at, due.direction_in_sensor),
                scene,
                materials,
                self.luck.of(due.index as usize),
            );
            self.next += 1;
            let is_last = self.next == self.beams.len();
            take(Beam {
                index: due.index as usize,
                at,
                bearing_rad: self.model.bearing_rad(due.index as usize),
                echo,
                is_first: self.next == 1,
                is_last,
            });
            if is_last {
                began += period;
                self.next = 0;
                self.luck = Luck::draw(&mut self.rng);
            }
        }
        self.began = Some(began);
    }
}

/// The sensor's way between two calls.
struct Way {
    from: Stamp,
    took_s: f64,
    start: Se2,
    dx_m: f64,
    dy_m: f64,
    dyaw_rad: f64,
    /// Cosine and sine of the yaw, while it does not change.
    steady: Option<(f64, f64)>,
}

impl Way {
    fn between(last: Option<(Stamp, Se2)>, now: Stamp, end: Se2) -> Self {
        let stays = (now, end);
        let (from, start) = last.unwrap_or(stays);
        let (dx_m, dy_m) = (end.x_m - start.x_m, end.y_m - start.y_m);
        let took_s = now.since(from).as_secs_f64();
        if took_s <= 0.0 || dx_m.hypot(dy_m) > LIFTED_M {
            let (s, c) = end.yaw_rad.sin_cos();
            let steady = Some((c, s));
            let [dx_m, dy_m, dyaw_rad] = [0.0; 3];
            return Self { from: now, took_s: 1.0, start: end, dx_m, dy_m, dyaw_rad, steady };
        }
        let dyaw_rad = wrap_to_pi(end.yaw_rad - start.yaw_rad);
        let steady = (dyaw_rad == 0.0).then(|| {
            let (s, c) = end.yaw_rad.sin_cos();
            (c, s)
        });
        Self { from, took_s, start, dx_m, dy_m, dyaw_rad, steady }
    }

    /// The beam that leaves at `at` in a direction of the sensor.
    fn ray(&self, at: Stamp, direction: Vec2) -> Ray {
        let part = (at.since(self.from).as_secs_f64() / self.took_s).min(1.0);
        let (c, s) = self.steady.unwrap_or_else(|| {
            let (s, c) = (self.start.yaw_rad + part * self.dyaw_rad).sin_cos();
            (c, s)
        });
        Ray {
            origin: Vec2::new(self.start.x_m + part * self.dx_m, self.start.y_m + part * self.dy_m),
            direction: Vec2::new(
                c * direction.x - s * direction.y,
                s * direction.x + c * direction.y,
            ),
        }
    }
}
