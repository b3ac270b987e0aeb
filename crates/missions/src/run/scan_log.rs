//! What the lasers of one robot saw: whole scans with dead reckoning and the truth of the moment at which their first beam
//! was fired.
//!
//! It reads along behind the drivers, so a scan holds what the navigator was told. A scan waits for the report of the
//! robot that is about a later moment, so that dead reckoning can be read between two of them; one for which none comes
//! has the last one there was.

use std::{collections::VecDeque, time::Duration};

use geometry::Se2;
use messages::{DeviceId, Observations, Sensed};
use recordings::{LaserRig, Rig, StampedPose, interpolate_pose};
use run_context::Stamp;
use sensor_models::{BeamSight, LaserModel, ScanBeam};

use crate::{
    mission::plan::{LaserPlan, RobotPlan},
    node::laser::device,
    sensing::step::ScanRow,
    view::{SceneScanner, ViewScan},
};

/// How long a scan waits for the robot's next report.
const WAIT_MAX: Duration = Duration::from_secs(1);
/// Reports that are kept to read between: more than come in the longest way of a scan.
const N_REPORTS: usize = 200;
/// Scans that may wait.
const N_WAITING_MAX: usize = 128;

/// Reads along with the lasers of one robot.
#[derive(Debug)]
pub(super) struct ScanLog {
    scanners: Vec<Scanner>,
    odometry: Vec<StampedPose>,
    waiting: VecDeque<ScanRow>,
    done: Vec<ScanRow>,
    /// Rows whose memory is used again.
    spare: Vec<ScanRow>,
}

/// One laser: how its beams lie, and what it saw last.
#[derive(Debug)]
struct Scanner {
    device: DeviceId,
    fan: Fan,
    base_from_sensor: Se2,
    latest: ViewScan,
    has_scan: bool,
}

/// Equally spaced beams, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fan {
    first_rad: f64,
    spacing_rad: f64,
    n_beams: usize,
    is_whole_turn: bool,
}

impl Fan {
    fn of(model: &LaserModel) -> Self {
        let spacing_rad = model.beam_spacing_rad.abs();
        let span_rad = spacing_rad * model.n_beams as f64;
        let is_whole_turn = span_rad > std::f64::consts::TAU - 0.5 * spacing_rad;
        let last_rad = model.bearing_rad(model.n_beams.saturating_sub(1));
        let first_rad =
            if is_whole_turn { -std::f64::consts::PI } else { model.first_beam_rad.min(last_rad) };
        Self { first_rad, spacing_rad, n_beams: model.n_beams, is_whole_turn }
    }

    /// The beam that looks there; `None` outside of the fan.
    fn place(&self, bearing_rad: f64) -> Option<usize> {
        let steps = ((bearing_rad - self.first_rad) / self.spacing_rad).round();
        let n_beams = self.n_beams as f64;
        let steps = if self.is_whole_turn { steps.rem_euclid(n_beams) } else { steps };
        // Within the range that is checked the cast is exact.
        (0.0..n_beams).contains(&steps).then_some(steps as usize)
    }
}

/// What the scans of a laser are, as they are recorded.
pub(crate) fn laser_rig(laser: &LaserPlan) -> Rig {
    let fan = Fan::of(&laser.model);
    Rig::Laser(LaserRig {
        base_from_sensor: laser.base_from_sensor,
        first_beam_rad: fan.first_rad,
        beam_spacing_rad: fan.spacing_rad,
        n_beams: fan.n_beams,
        range_max_m: laser.model.range_max_m,
    })
}

/// A laser as screens show it.
pub(super) fn scene(laser: &LaserPlan) -> SceneScanner {
    let fan = Fan::of(&laser.model);
    SceneScanner {
        name: laser.name.clone(),
        base_from_sensor: laser.base_from_sensor,
        first_angle_rad: fan.first_rad,
        step_rad: fan.spacing_rad,
        n_beams: fan.n_beams,
        range_max_m: laser.model.range_max_m,
    }
}

impl ScanLog {
    pub(super) fn new(plan: &RobotPlan) -> Self {
        let scanner = |(number, laser): (usize, &LaserPlan)| Scanner {
            device: device(number),
            fan: Fan::of(&laser.model),
            base_from_sensor: laser.base_from_sensor,
            latest: ViewScan { scanner: number, ..ViewScan::default() },
            has_scan: false,
        };
        let has_lasers = !plan.lasers.is_empty();
        let room = |n: usize| if has_lasers { n } else { 0 };
        Self {
            scanners: plan.lasers.iter().enumerate().map(scanner).collect(),
            odometry: Vec::with_capacity(room(N_REPORTS)),
            waiting: VecDeque::with_capacity(room(N_WAITING_MAX)),
            done: Vec::with_capacity(room(N_WAITING_MAX)),
            spare: Vec::with_capacity(room(N_WAITING_MAX)),
        }
    }

    /// Takes what reached the navigator in this step; `truth_at` says where the robot truly was.
    pub(super) fn step(
        &mut self,
        now: Stamp,
        truth_at: impl Fn(Stamp) -> Option<Se2>,
        observations: &Observations,
    ) {
        self.spare.append(&mut self.done);
        if self.scanners.is_empty() {
            return;
        }
        for observation in observations {
            match &observation.value {
                Sensed::Odometry(odometry) => {
                    if self.odometry.len() == N_REPORTS {
                        self.odometry.remove(0);
                    }
                    let (stamp, pose) = (observation.about, odometry.odom_from_base.se2());
                    self.odometry.push(StampedPose { stamp, pose });
                }
                Sensed::Scan(scan) => {
                    let (about, beams) = (observation.about, observations.beams(scan));
                    self.take(observation.from, about, truth_at(about), beams);
                }
                _ => {}
            }
        }
        self.date(now);
    }

    fn take(&mut self, from: DeviceId, about: Stamp, truth: Option<Se2>, beams: &[ScanBeam]) {
        let Some(number) = self.scanners.iter().position(|scanner| scanner.device == from) else {
            return;
        };
        let scanner = &mut self.scanners[number];
        let mut row = self.spare.pop().unwrap_or_default();
        (row.laser, row.stamp, row.world_from_base) = (number, about, truth);
        row.ranges_m.clear();
        row.ranges_m.resize(scanner.fan.n_beams, f64::INFINITY);
        row.stamps.clear();
        row.stamps.resize(scanner.fan.n_beams, about);
        let shown = &mut scanner.latest.ranges_m;
        shown.clear();
        shown.resize(scanner.fan.n_beams, ViewScan::UNSEEN);
        for beam in beams {
            let Some(place) = scanner.fan.place(beam.bearing_rad) else { continue };
            let after = Duration::from_secs_f64(beam.after_s.clamp(0.0, 60.0));
            row.stamps[place] = about + after;
            // What a recording has no word for, a beam of which nothing is known, is as if nothing had come back there:
            // mappers take neither for free.
            (row.ranges_m[place], shown[place]) = match beam.sight {
                BeamSight::Surface(range_m) => (range_m, range_m as f32),
                BeamSight::Beyond => (f64::INFINITY, ViewScan::FREE),
                // Glass and black things send nothing back either: shown as free, it would be more than is known.
                BeamSight::NoReturn | BeamSight::Unseen => (f64::INFINITY, ViewScan::UNSEEN),
            };
        }
        scanner.has_scan = true;
        let sensor = truth.map(|pose| pose.compose(scanner.base_from_sensor));
        scanner.latest.at = sensor.unwrap_or(scanner.base_from_sensor).into();
        if self.waiting.len() == N_WAITING_MAX {
            self.spare.extend(self.waiting.pop_front());
        }
        self.waiting.push_back(row);
    }

    /// Gives the waiting scans their dead reckoning, in the order in which they came.
    fn date(&mut self, now: Stamp) {
        while let Some(row) = self.waiting.front_mut() {
            let Some(last) = self.odometry.last() else { return };
            row.odom_from_base = interpolate_pose(&self.odometry, row.stamp);
            if row.odom_from_base.is_none() && now.since(row.stamp) >= WAIT_MAX {
                row.odom_from_base = Some(last.pose);
            }
            // Before its first report nothing is known of the robot: such a scan is of no use.
            let is_before = self.odometry.first().is_some_and(|first| first.stamp > row.stamp);
            if row.odom_from_base.is_none() && !is_before {
                return;
            }
            let Some(row) = self.waiting.pop_front() else { return };
            let rows = if row.odom_from_base.is_some() { &mut self.done } else { &mut self.spare };
            rows.push(row);
        }
    }

    /// The scans that the last step dated, oldest first.
    pub(super) fn rows(&self) -> &[ScanRow] {
        &self.done
    }

    /// What each laser saw last, if anything.
    pub(super) fn latest(&self) -> impl Iterator<Item = &ViewScan> {
        self.scanners.iter().filter(|scanner| scanner.has_scan).map(|scanner| &scanner.latest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sensor_models::LaserKind;

    /// Every beam of every laser has a place of its own, wherever its first one looks and whichever way it turns.
    #[test]
    fn each_beam_has_its_place() {
        for kind in LaserKind::ALL {
            let model = kind.model();
            let fan = Fan::of(&model);
            let mut places: Vec<usize> = (0..model.n_beams)
                .map(|i| fan.place(geometry::wrap_to_pi(model.bearing_rad(i))).unwrap())
                .collect();
            places.sort_unstable();
            assert_eq!(places, (0..model.n_beams).collect::<Vec<_>>(), "{}", kind.title());
            let back = fan.first_rad + 7.0 * fan.spacing_rad;
            assert_eq!(fan.place(back), Some(7));
        }
        let half = Fan::of(&LaserKind::SickLms.model());
        assert_eq!(half.place(std::f64::consts::PI), None, "it does not look back");
    }
}
