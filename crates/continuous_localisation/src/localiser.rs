//! The step of continuous localisation: readings in, now and then a registration out.

mod registering;

use geometry::{Map, Odom, Se2, Transform2, Vec2};
use grid_maps::{EvidenceModel, Lattice, LogOddsMap};
use nalgebra::Vector4;
use recordings::{RingRig, Scan};
use run_context::Stamp;

use crate::{
    chain::{Chain, Moment, Start, Step},
    config::{ConfigError, LocaliserConfig},
    filter::Filter,
    insertion::{PlacedReading, RingInserter},
    maturity::Collected,
    registration::Registration,
    walls::{Before, Wall},
};

/// An odometry step longer or turning more than this is a jump (m, rad): the robot was carried, or its
/// odometry was reset. The pose is kept.
const JUMP_M: f64 = 2.0;
const JUMP_RAD: f64 = 2.5;
/// A step below this is standing still (m, rad).
const STILL: f64 = 1e-7;
/// Walls of a prior map are known to this (rad, m).
const PRIOR_DIRECTION_STD_RAD: f64 = 0.004;
const PRIOR_OFFSET_STD_M: f64 = 0.01;
/// What an earlier look learnt of the drift is trusted to this at best, radians per metre.
const LEARNT_DRIFT_STD_RADPM: f64 = 0.002;
/// A short-term map is registered when it has so many readings, however little way there was: a
/// robot that turns on the spot for an hour must not fill the memory.
const READINGS_MAX: usize = 4096;
/// Log-odds of a cell stay within ± this.
const CERTAIN_LOGODDS: f64 = 6.0;

/// Localises a robot with a ring of sonars while it maps, reading by reading.
///
/// The same step serves online and offline. Rows go in with [`step`](Self::step); now and then, when
/// the short-term map is mature, a [`Registration`] comes out: the short-term map has been compared
/// with the long-term one and with its straight walls, the pose has been corrected as far as the
/// evidence goes, and the readings have become part of the long-term map at their corrected poses.
///
/// Readings are placed at their own stamps on odometry's way. Rows taken at standstill are not used.
/// Echoes that no wall and no second look supports wait until the map is known around them; those
/// whose cone goes through something occupied by then are ghosts and are dropped.
#[derive(Clone, Debug)]
pub struct Localiser {
    config: LocaliserConfig,
    ring: RingRig,
    chain: Option<Chain>,
    /// Where it was told to begin, with variances.
    begin: Option<(Se2, Vector4<f64>)>,
    /// What was believed at the begin of the short-term map.
    filter: Filter,
    odom_from_base: Se2,
    used_odom: Option<Se2>,
    pending: Vec<(Stamp, usize, f64)>,
    readings: Vec<StmReading>,
    row_stamps: Vec<Stamp>,
    collected: Collected,
    way_m: f64,
    waiting: Vec<Waiting>,
    /// Of each sensor, the last reading before the short-term map.
    last_arcs: Vec<Before>,
    inserter: RingInserter,
    long_term: LogOddsMap,
    short_term: LogOddsMap,
    counts: ReadingCounts,
}

/// What became of the readings so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadingCounts {
    /// Written into the long-term map.
    pub n_inserted: usize,
    /// Dropped because the robot stood still.
    pub n_at_standstill: usize,
    /// Dropped because their cone goes through something occupied.
    pub n_ghosts: usize,
    /// Rows without odometry that is finite; they cannot be placed.
    pub n_rows_without_odometry: usize,
    /// Jumps of odometry.
    pub n_jumps: usize,
}

/// A reading that is placed but not believed yet.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    reading: PlacedReading,
    since_m: f64,
}

/// One reading of the short-term map.
#[derive(Clone, Copy, Debug)]
struct StmReading {
    at: Moment,
    sensor: usize,
    range_m: f64,
    is_echo: bool,
}

impl Localiser {
    /// For a ring, with nothing known of the world; the map's frame is odometry's at the first row.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] for a parameter outside its range, or a ring that cannot measure.
    pub fn new(ring: &RingRig, config: LocaliserConfig) -> Result<Self, ConfigError> {
        let mut config = config.checked()?;
        config.cone.half_angle_rad = ring.half_angle_rad;
        let config = config.checked()?;
        let lattice = Lattice { origin: Vec2::zeros(), resolution_m: config.resolution_m };
        let model = EvidenceModel {
            min_logodds: -CERTAIN_LOGODDS,
            max_logodds: CERTAIN_LOGODDS,
            ..EvidenceModel::default()
        };
        // Both were checked, so that neither can fail.
        let refused = |_| ConfigError {
            key: "resolution_m",
            value: config.resolution_m,
            requirement: "from 0.01 to 0.5 m, at least a thousandth of the cone's range",
        };
        let map = LogOddsMap::new(lattice, model).map_err(refused)?;
        let inserter = RingInserter::new(config.cone, config.resolution_m).map_err(refused)?;
        let drift_var = config.odometry.drift_std_radpm.powi(2);
        Ok(Self {
            filter: Filter::new(Se2::IDENTITY, Vector4::new(1e-8, 1e-8, 1e-8, drift_var)),
            ring: ring.clone(),
            chain: None,
            begin: None,
            odom_from_base: Se2::IDENTITY,
            used_odom: None,
            pending: Vec::new(),
            readings: Vec::new(),
            row_stamps: Vec::new(),
            collected: Collected::default(),
            way_m: 0.0,
            waiting: Vec::new(),
            inserter,
            short_term: map.clone(),
            last_arcs: vec![Before::Nothing; ring.base_from_sensors.len()],
            long_term: map,
            counts: ReadingCounts::default(),
            config,
        })
    }

    /// Begins at a known pose instead of odometry's, with standard deviations of position (m) and
    /// heading (rad). Before the first row only; later it does nothing.
    pub fn begin_at(&mut self, map_from_base: Se2, position_std_m: f64, heading_std_rad: f64) {
        if self.chain.is_some() {
            return;
        }
        let var = |std: f64| (std * std).max(1e-8);
        let (p, h) = (var(position_std_m), var(heading_std_rad));
        let drift = self.config.odometry.drift_std_radpm.powi(2);
        let variances = Vector4::new(p, p, h, drift);
        self.begin = Some((map_from_base, variances));
        self.filter.set_robot_variances(map_from_base, variances);
        self.chain = Some(Chain::new(Start { map_from_base, missed_yaw_radpm: 0.0 }, Stamp::ZERO));
        self.used_odom = None;
    }

    /// Gives it a map to begin with, of the resolution of the configuration, and the walls that
    /// [`walls`](Self::walls) had at the end of an earlier run (or none).
    pub fn set_prior(&mut self, map: LogOddsMap, walls: Vec<Wall>) {
        self.long_term = map;
        for wall in walls {
            self.filter.add_known_wall(wall, PRIOR_DIRECTION_STD_RAD, PRIOR_OFFSET_STD_M);
        }
    }

    /// A new one that knows what odometry misses and begins where this one began: for a second look at
    /// the same recording. Walls that were drawn before the drift was known were drawn wrong; now they
    /// are drawn right. Nothing else is kept, so that no reading counts twice in the map.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn again(&self) -> Result<Self, ConfigError> {
        let mut again = Self::new(&self.ring, self.config.clone())?;
        if let Some((map_from_base, variances)) = self.begin {
            again.begin = self.begin;
            again.filter.set_robot_variances(map_from_base, variances);
            again.chain =
                Some(Chain::new(Start { map_from_base, missed_yaw_radpm: 0.0 }, Stamp::ZERO));
        }
        let (missed_radpm, std_radpm) = self.filter.missed_yaw();
        again.filter.set_missed_yaw(missed_radpm, std_radpm.max(LEARNT_DRIFT_STD_RADPM));
        if let Some(chain) = &mut again.chain {
            chain.start.missed_yaw_radpm = missed_radpm;
        }
        Ok(again)
    }

    /// Takes one row of readings. `None` while the short-term map is not mature.
    pub fn step(&mut self, scan: &Scan) -> Option<Registration> {
        let Some(odom_from_base) = scan.odom_from_base.filter(is_finite) else {
            self.counts.n_rows_without_odometry += 1;
            return None;
        };
        self.advance(scan.stamp, odom_from_base);
        self.take_pending(scan.stamp);
        if self.is_standstill(odom_from_base) {
            self.counts.n_at_standstill += scan.ranges_m.len();
            return None;
        }
        self.used_odom = Some(odom_from_base);
        self.row_stamps.push(scan.stamp);
        self.collected.n_scans += 1;
        for (sensor, &range_m) in scan.ranges_m.iter().enumerate() {
            let stamp = scan.stamps.get(sensor).copied().unwrap_or(scan.stamp);
            self.pending.push((stamp, sensor, range_m));
        }
        self.take_pending(scan.stamp);
        if self.is_mature() { self.register() } else { None }
    }

    /// Odometry between the rows, for a robot that has more of it. In order of time.
    pub fn add_odometry(&mut self, stamp: Stamp, odom_from_base: Se2) {
        if !is_finite(&odom_from_base) {
            return;
        }
        self.advance(stamp, odom_from_base);
        self.take_pending(stamp);
    }

    /// Registers what is left, and judges all readings that still wait. At the end of a run.
    pub fn finish(&mut self) -> Option<Registration> {
        self.take_pending(Stamp::from_nanos(u64::MAX));
        let last = if self.readings.is_empty() { None } else { self.register() };
        self.judge_waiting(f64::INFINITY);
        last
    }

    /// The long-term map.
    pub fn map(&self) -> &LogOddsMap {
        &self.long_term
    }

    /// The short-term map as last drawn: at the last registration.
    pub fn short_term_map(&self) -> &LogOddsMap {
        &self.short_term
    }

    /// Straight walls found so far.
    pub fn walls(&self) -> &[Wall] {
        &self.filter.walls
    }

    /// Where the robot is now; `None` before the first row.
    pub fn map_from_base(&self) -> Option<Se2> {
        self.chain.as_ref().map(Chain::end)
    }

    /// Corrects odometry's pose of now into the map's.
    pub fn map_from_odom(&self) -> Transform2<Map, Odom> {
        let map_from_base = self.map_from_base().unwrap_or(self.filter.map_from_base);
        Transform2::new(map_from_base.compose(self.odom_from_base.inverse()))
    }

    /// What became of the readings.
    pub fn counts(&self) -> ReadingCounts {
        self.counts
    }

    /// The parameters, with the ring's cone.
    pub fn config(&self) -> &LocaliserConfig {
        &self.config
    }

    fn advance(&mut self, stamp: Stamp, odom_from_base: Se2) {
        let Some(chain) = &mut self.chain else {
            self.filter.map_from_base = odom_from_base;
            let missed_yaw_radpm = self.filter.missed_yaw_radpm;
            let start = Start { map_from_base: odom_from_base, missed_yaw_radpm };
            self.chain = Some(Chain::new(start, stamp));
            self.odom_from_base = odom_from_base;
            return;
        };
        let is_first = self.used_odom.is_none() && chain.n_steps() == 0 && self.way_m == 0.0;
        let twist = self.odom_from_base.inverse().compose(odom_from_base).log();
        let way_m = twist.dx_m.hypot(twist.dy_m);
        self.odom_from_base = odom_from_base;
        let stamp = stamp.max(chain.end_stamp());
        if is_first && chain.start_stamp == Stamp::ZERO {
            chain.wait_until(stamp);
        } else if !(way_m <= JUMP_M && twist.dyaw_rad.abs() <= JUMP_RAD) {
            self.counts.n_jumps += 1;
            chain.wait_until(stamp);
        } else if way_m < STILL && twist.dyaw_rad.abs() < STILL {
            chain.wait_until(stamp);
        } else {
            chain.push(Step { stamp, twist });
            self.way_m += way_m;
        }
    }

    fn is_standstill(&self, odom_from_base: Se2) -> bool {
        let filter = &self.config.filter;
        self.used_odom.is_some_and(|used| {
            let moved = used.inverse().compose(odom_from_base);
            moved.position().norm() < filter.standstill_m
                && moved.yaw_rad.abs() < filter.standstill_rad
        })
    }

    /// Places the readings whose moment odometry has reached.
    fn take_pending(&mut self, until: Stamp) {
        let Some(chain) = &self.chain else { return };
        let (base_from_sensors, ring) = (&self.ring.base_from_sensors, &self.ring);
        let readings = &mut self.readings;
        let collected = &mut self.collected;
        self.pending.retain(|&(stamp, sensor, range_m)| {
            if stamp > until {
                return true;
            }
            let is_echo = range_m < ring.range_max_m;
            if sensor < base_from_sensors.len() && range_m >= ring.range_min_m {
                readings.push(StmReading { at: chain.moment(stamp), sensor, range_m, is_echo });
                collected.n_readings += usize::from(is_echo);
            }
            false
        });
        collected.distance_m = chain.length_m();
        let begin = self.row_stamps.first().copied().unwrap_or(until);
        let last = self.row_stamps.last().copied().unwrap_or(begin);
        collected.duration_s = last.since(begin).as_secs_f64();
    }

    fn is_mature(&self) -> bool {
        let c = &self.collected;
        if self.readings.len() >= READINGS_MAX {
            return true;
        }
        let has_seen = c.n_readings >= self.config.n_echoes_min;
        (self.config.maturity.is_reached(c) && has_seen) || c.distance_m >= self.config.life_max_m
    }
}

fn is_finite(pose: &Se2) -> bool {
    [pose.x_m, pose.y_m, pose.yaw_rad].iter().all(|value| value.is_finite())
}

#[cfg(test)]
mod tests;
