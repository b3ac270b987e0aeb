//! From rows as they stand in a file to a recording: counts, duplicates, order, time.

use std::collections::BTreeMap;

use geometry::Se2;
use run_context::{Stamp, StateHash};

use crate::{
    complaints::{Action, Complaints, Place, Trouble},
    numbers::decimal_from_nanos,
    order::{Shift, put_in_order},
    raw::{RawPose, RawRecording, RawScan},
    recording::{Recording, Rig, Scan, StampedPose, interpolate_pose},
};

/// Odometry may be this far from that of a scan of the same moment, metres.
const JUMP_SLACK_M: f64 = 0.5;
/// No robot is taken to be slower than this when its odometry is judged, metres per second.
const SPEED_FLOOR_MPS: f64 = 1.0;
/// The first and the last true pose hold so long before and after.
const TRUTH_REACH_NS: u64 = 100_000_000;

/// Puts everything in order; `None` when no scan is left.
pub(crate) fn assemble(raw: RawRecording, complaints: &mut Complaints) -> Option<Recording> {
    let RawRecording { rig, mut scans, odometry, truth } = raw;
    drop_wrong_counts(rig.n_readings(), &mut scans, complaints);
    drop_duplicates(&mut scans, complaints);
    if scans.is_empty() {
        return None;
    }
    let useless = has_useless_stamps(&scans);
    let shifts = put_in_order(&mut scans, complaints);
    let mut odometry = if useless {
        say_useless(scans.len(), odometry.len(), complaints);
        Vec::new()
    } else {
        timed(odometry, &shifts, complaints)
    };
    fill_odometry(&mut scans, &odometry, complaints);
    if scans.is_empty() {
        return None;
    }
    drop_jumps(&scans, &mut odometry, complaints);
    fill_truth(&mut scans, truth, complaints);
    Some(finish(rig, scans, &odometry))
}

fn drop_wrong_counts(n: usize, scans: &mut Vec<RawScan>, complaints: &mut Complaints) {
    scans.retain(|scan| {
        let found = scan.ranges_m.len();
        if found != n {
            let text = || format!("{found} readings, the rig has {n}");
            complaints.add(scan.place, Trouble::BeamCount, Action::Skipped, text);
        }
        found == n
    });
}

/// Keeps the first of scans with equal stamp, ranges and odometry.
fn drop_duplicates(scans: &mut Vec<RawScan>, complaints: &mut Complaints) {
    let mut seen: BTreeMap<(i64, u64), Vec<usize>> = BTreeMap::new();
    let mut keep = vec![true; scans.len()];
    for (index, scan) in scans.iter().enumerate() {
        let alike = seen.entry((scan.stamp_ns, content_hash(scan))).or_default();
        let same = |&&other: &&usize| {
            let other = &scans[other];
            other.ranges_m == scan.ranges_m && other.odom == scan.odom
        };
        if let Some(&first) = alike.iter().find(same) {
            keep[index] = false;
            let text = || format!("the same scan as at {}", scans[first].place);
            complaints.add(scan.place, Trouble::Duplicate, Action::Skipped, text);
        } else {
            alike.push(index);
        }
    }
    let mut keep = keep.into_iter();
    scans.retain(|_| keep.next().unwrap_or(true));
}

fn content_hash(scan: &RawScan) -> u64 {
    let mut hash = StateHash::new();
    let pose = scan.odom.map(|p| [p.x_m, p.y_m, p.yaw_rad]);
    for value in pose.iter().flatten().chain(&scan.ranges_m) {
        hash.absorb_u64(value.to_bits());
    }
    hash.value()
}

/// Whether most scans have the stamp of the scan before.
fn has_useless_stamps(scans: &[RawScan]) -> bool {
    let equal = scans.windows(2).filter(|w| w[0].stamp_ns == w[1].stamp_ns).count();
    2 * equal > scans.len()
}

fn say_useless(n_scans: usize, n_odometry: usize, complaints: &mut Complaints) {
    let text = || {
        format!("most of the {n_scans} scans have equal stamps; they stay in the order of the file")
    };
    complaints.add(Place::File, Trouble::StampsUseless, Action::Kept, text);
    if n_odometry > 0 {
        let text = || {
            format!(
                "{n_odometry} odometry lines, of which nobody can say between which scans they belong"
            )
        };
        complaints.add(Place::File, Trouble::OdometryUnusable, Action::Skipped, text);
    }
}

/// Odometry in order of time, on the mended clock.
fn timed(
    mut odometry: Vec<RawPose>,
    shifts: &[Shift],
    complaints: &mut Complaints,
) -> Vec<RawPose> {
    for pose in &mut odometry {
        let last = shifts.iter().take_while(|(place, _)| *place <= pose.place).last();
        pose.stamp_ns = pose.stamp_ns.saturating_add(last.map_or(0, |s| s.1));
    }
    let mut latest = i64::MIN;
    for pose in &odometry {
        if pose.stamp_ns < latest {
            let (now, before) = (decimal_from_nanos(pose.stamp_ns), decimal_from_nanos(latest));
            let text = || format!("odometry of {now} s after {before} s; sorted into its place");
            complaints.add(pose.place, Trouble::OutOfOrder, Action::Repaired, text);
        }
        latest = latest.max(pose.stamp_ns);
    }
    odometry.sort_by_key(|pose| pose.stamp_ns);
    odometry
}

/// Gives scans without odometry that of the odometry lines, where there is any.
fn fill_odometry(scans: &mut Vec<RawScan>, odometry: &[RawPose], complaints: &mut Complaints) {
    let with = scans.iter().filter(|s| s.odom.is_some()).count();
    if with == scans.len() || (with == 0 && odometry.is_empty()) {
        return;
    }
    let Some(epoch) = odometry.first().map(|p| p.stamp_ns) else { return };
    let track = track(odometry, epoch);
    scans.retain_mut(|scan| {
        if scan.odom.is_none() {
            let time = u64::try_from(scan.stamp_ns.saturating_sub(epoch)).ok();
            scan.odom = time.and_then(|t| interpolate_pose(&track, Stamp::from_nanos(t)));
        }
        if scan.odom.is_none() {
            let text = || "a scan at whose time there is no odometry".to_owned();
            complaints.add(scan.place, Trouble::OdometryUnusable, Action::Skipped, text);
        }
        scan.odom.is_some()
    });
}

fn track(poses: &[RawPose], epoch: i64) -> Vec<StampedPose> {
    let at = |p: &RawPose| {
        let nanos = u64::try_from(p.stamp_ns.saturating_sub(epoch)).ok()?;
        Some(StampedPose { stamp: Stamp::from_nanos(nanos), pose: p.pose })
    };
    poses.iter().filter_map(at).collect()
}

/// Leaves out odometry that could not be reached from the odometry of the scan before and after it; before the first and
/// after the last scan, from the odometry that was taken last on the way there.
///
/// The robot is granted twice the speed that 99 of 100 steps between scans keep to.
fn drop_jumps(scans: &[RawScan], odometry: &mut Vec<RawPose>, complaints: &mut Complaints) {
    let known: Vec<Anchor> =
        scans.iter().filter_map(|s| Some(Anchor { stamp_ns: s.stamp_ns, pose: s.odom? })).collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else { return };
    let limit_mps = speed_limit_mps(&known);
    let start = odometry.partition_point(|p| p.stamp_ns < first.stamp_ns);
    let end = odometry.partition_point(|p| p.stamp_ns <= last.stamp_ns);
    let mut faults: Vec<Option<(f64, f64)>> = vec![None; odometry.len()];
    for index in start..end {
        let after = known.partition_point(|k| k.stamp_ns <= odometry[index].stamp_ns);
        let around = [after.checked_sub(1), Some(after)].into_iter().flatten();
        let jump =
            |i: usize| known.get(i).and_then(|a: &Anchor| a.jump(&odometry[index], limit_mps));
        faults[index] = around.into_iter().find_map(jump);
    }
    let mut follow = |indices: &mut dyn Iterator<Item = usize>, mut anchor: Anchor| {
        for index in indices {
            let pose = &odometry[index];
            faults[index] = anchor.jump(pose, limit_mps);
            if faults[index].is_none() {
                anchor = Anchor { stamp_ns: pose.stamp_ns, pose: pose.pose };
            }
        }
    };
    follow(&mut (0..start).rev(), first);
    follow(&mut (end..odometry.len()), last);
    let mut index = 0;
    odometry.retain(|pose| {
        let fault = faults[index];
        index += 1;
        if let Some((away_m, apart_s)) = fault {
            let text = || {
                let at = decimal_from_nanos(pose.stamp_ns);
                format!("odometry of {at} s is {away_m:.3} m from where the robot is {apart_s:.3} s away")
            };
            complaints.add(pose.place, Trouble::OdometryJump, Action::Skipped, text);
        }
        fault.is_none()
    });
}

/// Odometry that is trusted.
#[derive(Clone, Copy)]
struct Anchor {
    stamp_ns: i64,
    pose: Se2,
}

impl Anchor {
    /// Metres and seconds from here to a pose that is out of reach; `None` if it is within.
    fn jump(&self, other: &RawPose, limit_mps: f64) -> Option<(f64, f64)> {
        let away_m = (self.pose.position() - other.pose.position()).norm();
        let apart_s = self.stamp_ns.abs_diff(other.stamp_ns) as f64 * 1e-9;
        (away_m > JUMP_SLACK_M + limit_mps * apart_s).then_some((away_m, apart_s))
    }
}

fn speed_limit_mps(known: &[Anchor]) -> f64 {
    let speed = |w: &[Anchor]| {
        let time_s = w[1].stamp_ns.abs_diff(w[0].stamp_ns) as f64 * 1e-9;
        (time_s > 0.0).then(|| (w[1].pose.position() - w[0].pose.position()).norm() / time_s)
    };
    let mut speeds: Vec<f64> = known.windows(2).filter_map(speed).collect();
    speeds.sort_by(f64::total_cmp);
    let usual_mps = speeds.get(speeds.len() * 99 / 100).copied().unwrap_or(0.0);
    (2.0 * usual_mps).max(SPEED_FLOOR_MPS)
}

/// Gives scans the truth of their moment.
fn fill_truth(scans: &mut [RawScan], mut truth: Vec<RawPose>, complaints: &mut Complaints) {
    truth.sort_by_key(|pose| pose.stamp_ns);
    let Some(epoch) = truth.first().map(|p| p.stamp_ns) else { return };
    let track = track(&truth, epoch);
    for scan in scans {
        let time = u64::try_from(scan.stamp_ns.saturating_sub(epoch)).ok();
        scan.truth = time.and_then(|t| interpolate_pose(&track, Stamp::from_nanos(t)));
        let (first, last) = (&truth[0], &truth[truth.len() - 1]);
        let end = if scan.stamp_ns < first.stamp_ns { first } else { last };
        if scan.truth.is_none() && end.stamp_ns.abs_diff(scan.stamp_ns) <= TRUTH_REACH_NS {
            scan.truth = Some(end.pose);
        }
        if scan.truth.is_none() {
            let text = || {
                let at = decimal_from_nanos(scan.stamp_ns);
                format!(
                    "a scan of {at} s, for which there is no true pose; so all truth is left out"
                )
            };
            complaints.add(scan.place, Trouble::TruthMissing, Action::Kept, text);
        }
    }
}

fn finish(rig: Rig, scans: Vec<RawScan>, odometry: &[RawPose]) -> Recording {
    let stamps = scans.iter().flat_map(|s| s.stamps_ns.iter().chain([&s.stamp_ns]));
    let epoch_ns = stamps.chain(odometry.iter().map(|o| &o.stamp_ns)).copied().min().unwrap_or(0);
    let stamp = |ns: i64| Stamp::from_nanos(ns.abs_diff(epoch_ns));
    let poses = |pose: fn(&RawScan) -> Option<Se2>| {
        let all: Option<Vec<StampedPose>> = scans
            .iter()
            .map(|s| Some(StampedPose { stamp: stamp(s.stamp_ns), pose: pose(s)? }))
            .collect();
        all.unwrap_or_default()
    };
    let reference = poses(|s| s.reference);
    let truth = poses(|s| s.truth);
    let has_extra = scans.iter().any(|s| !s.extra_m.is_empty());
    let mut extra_columns_m = Vec::new();
    let mut finished = Vec::with_capacity(scans.len());
    for scan in scans {
        finished.push(Scan {
            stamp: stamp(scan.stamp_ns),
            odom_from_base: scan.odom,
            ranges_m: scan.ranges_m,
            stamps: scan.stamps_ns.iter().map(|&ns| stamp(ns)).collect(),
        });
        if has_extra {
            extra_columns_m.push(scan.extra_m);
        }
    }
    Recording {
        rig,
        scans: finished,
        odometry: track(odometry, epoch_ns),
        reference,
        truth,
        extra_columns_m,
        epoch_ns,
    }
}

#[cfg(test)]
#[path = "assemble_tests.rs"]
mod tests;
