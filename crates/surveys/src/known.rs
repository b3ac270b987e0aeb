//! What is known beside the recording: true poses and measured relations, brought to the recording's time.

use geometry::{Se2, wrap_to_pi};
use recordings::{
    Complaints, Recording, RecordingError, StampedPose,
    trajectories::{read_poses, read_relations},
};
use run_context::Stamp;
use slam::evaluate::{Relation, pose_at};

/// Two moments nearer than this are the same, nanoseconds: loggers write the time of arrival, not of measurement.
const SAME_NS: i64 = 60_000_000;
/// A shift of the clock is believed when it brings this part of the moments onto scans …
const MATCHED_MIN_RATIO: f64 = 0.8;
/// … and without it no more than this part is.
const UNMATCHED_MAX_RATIO: f64 = 0.7;
/// Steps in which a shift is refined, nanoseconds.
const FINE_NS: i64 = 4_000_000;
/// Shifts that fit in time of which motions choose one.
const CANDIDATES_MAX: usize = 120;
/// Steps in which the motions refine a shift, nanoseconds, and how many to either side.
const NEAR_NS: i64 = 10_000_000;
const NEAR_STEPS: i64 = 100;
/// Relations over at most this time are compared with odometry, nanoseconds.
const SHORT_NS: u64 = 5_000_000_000;
/// A radian of turn counts as much as so much distance, metres: turns tell moments apart better than ways do.
const M_PER_RAD: f64 = 0.5;
/// Poses of odometry farther apart say nothing about what is between them, seconds.
const GAP_MAX_S: f64 = 2.0;
/// Moments that decide about a shift.
const MOMENTS_MAX: usize = 200;

/// True poses, in the recording's time.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthFile {
    /// In order of time.
    pub poses: Vec<StampedPose>,
    /// What was wrong in the file.
    pub complaints: Complaints,
}

/// Measured relations, in the recording's time.
#[derive(Clone, Debug, PartialEq)]
pub struct RelationsFile {
    /// In the order of the file.
    pub relations: Vec<Relation>,
    /// What was added to the file's time, seconds.
    pub clock_shift_s: f64,
    /// What was wrong in the file.
    pub complaints: Complaints,
}

/// Reads true poses (`t x y yaw` or TUM's eight fields, plain or gzip) whose time is the recording's own.
///
/// Poses before the recording's first scan are left out.
///
/// # Errors
///
/// [`RecordingError`] when no line can be read.
pub fn read_truth(
    name: &str,
    bytes: &[u8],
    recording: &Recording,
) -> Result<TruthFile, RecordingError> {
    let file = read_poses(name, bytes)?;
    let shift_ns = i128::from(file.epoch_ns) - i128::from(recording.epoch_ns);
    let moved = |p: &StampedPose| {
        let nanos = i128::from(p.stamp.as_nanos()) + shift_ns;
        Some(StampedPose { stamp: Stamp::from_nanos(u64::try_from(nanos).ok()?), pose: p.pose })
    };
    let poses = file.poses.iter().filter_map(moved).collect();
    Ok(TruthFile { poses, complaints: file.complaints })
}

/// Reads relations (`t1 t2 dx dy dz roll pitch yaw`, plain or gzip).
///
/// Published relations often have another clock than the log that they belong to. When hardly any of their moments is
/// one of a scan, the shift is looked for that makes them so; `clock_shift_s` gives one instead.
///
/// # Errors
///
/// [`RecordingError`] when no line can be read.
pub fn read_known_relations(
    name: &str,
    bytes: &[u8],
    recording: &Recording,
    clock_shift_s: Option<f64>,
) -> Result<RelationsFile, RecordingError> {
    let file = read_relations(name, bytes)?;
    let scans: Vec<i64> = recording
        .scans
        .iter()
        .map(|scan| recording.epoch_ns.saturating_add_unsigned(scan.stamp.as_nanos()))
        .collect();
    let mut moments: Vec<i64> =
        file.relations.iter().flat_map(|r| [r.first_ns, r.second_ns]).collect();
    moments.sort_unstable();
    moments.dedup();
    let track: Vec<StampedPose> = recording
        .scans
        .iter()
        .filter_map(|scan| Some(StampedPose { stamp: scan.stamp, pose: scan.odom_from_base? }))
        .collect();
    let timed = |r: &recordings::trajectories::Relation| Timed {
        first_ns: r.first_ns.saturating_sub(recording.epoch_ns),
        second_ns: r.second_ns.saturating_sub(recording.epoch_ns),
        second_in_first: r.first_from_second,
    };
    let timed: Vec<Timed> = file.relations.iter().map(timed).collect();
    let shift_ns = match clock_shift_s {
        Some(seconds) => (seconds * 1e9).round() as i64,
        None => {
            clock_shift_ns(&moments, &scans, &|shift_ns| motion_error_m(&timed, &track, shift_ns))
        }
    };
    let stamp = |ns: i64| {
        let nanos = i128::from(ns) + i128::from(shift_ns) - i128::from(recording.epoch_ns);
        // A logger's jitter is forgiven; what is earlier is outside of every trajectory.
        let nanos = if (-i128::from(SAME_NS)..0).contains(&nanos) { 0 } else { nanos };
        Stamp::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX))
    };
    let relation = |r: &recordings::trajectories::Relation| Relation {
        first: stamp(r.first_ns),
        second: stamp(r.second_ns),
        second_in_first: r.first_from_second,
    };
    Ok(RelationsFile {
        relations: file.relations.iter().map(relation).collect(),
        clock_shift_s: shift_ns as f64 * 1e-9,
        complaints: file.complaints,
    })
}

/// A relation with moments in nanoseconds of the recording's time.
#[derive(Clone, Copy, Debug)]
struct Timed {
    first_ns: i64,
    second_ns: i64,
    second_in_first: Se2,
}

/// How far the short ones of `relations` are from what a track says of the same moments: the mean of distance and turn
/// (half a metre for a radian), where no single one counts more than a metre. `None` where too few are short enough and
/// within the track.
fn motion_error_m(relations: &[Timed], track: &[StampedPose], shift_ns: i64) -> Option<f64> {
    let pose = |ns: i64| {
        let nanos = u64::try_from(ns.saturating_add(shift_ns)).ok()?;
        pose_at(track, Stamp::from_nanos(nanos), GAP_MAX_S)
    };
    let short = |r: &&Timed| r.first_ns.abs_diff(r.second_ns) <= SHORT_NS;
    let error = |r: &Timed| {
        let moved = pose(r.first_ns)?.inverse().compose(pose(r.second_ns)?);
        let away_m = (moved.position() - r.second_in_first.position()).norm();
        let turned_rad = wrap_to_pi(moved.yaw_rad - r.second_in_first.yaw_rad).abs();
        Some((away_m + M_PER_RAD * turned_rad).min(1.0))
    };
    let every = relations.len().div_ceil(MOMENTS_MAX).max(1);
    let some = relations.iter().filter(short).step_by(every);
    let n = some.clone().count();
    let errors: Vec<f64> = some.filter_map(error).collect();
    let is_enough = errors.len() >= 10.max(n / 2);
    is_enough.then(|| errors.iter().sum::<f64>() / errors.len() as f64)
}

/// The relations on the clock that fits a trajectory best, within a second, and what was added to their time, seconds.
///
/// A clock that is off by a tenth of a second makes relations of a turning robot wrong by degrees; which clock fits is as
/// little a merit of the trajectory as the frame in which it lies.
pub(crate) fn on_the_best_clock(
    relations: &[Relation],
    trajectory: &[StampedPose],
) -> (Vec<Relation>, f64) {
    let nanos = |stamp: Stamp| i64::try_from(stamp.as_nanos()).unwrap_or(i64::MAX);
    let timed = |r: &Relation| Timed {
        first_ns: nanos(r.first),
        second_ns: nanos(r.second),
        second_in_first: r.second_in_first,
    };
    let timed: Vec<Timed> = relations.iter().map(timed).collect();
    let shifts = (-NEAR_STEPS..=NEAR_STEPS).map(|i| i * NEAR_NS);
    let rated = shifts.filter_map(|ns| Some((motion_error_m(&timed, trajectory, ns)?, ns)));
    let best = rated.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.abs().cmp(&b.1.abs())));
    let shift_ns = best.map_or(0, |(_, ns)| ns);
    // What is left between a moment and its scan is the loggers' doing, and would turn with the robot.
    let scans: Vec<i64> = trajectory.iter().map(|p| nanos(p.stamp)).collect();
    let moved = |stamp: Stamp| {
        let moment = nanos(stamp).saturating_add(shift_ns);
        let off_ns = distance_ns(moment, &scans);
        let moment = if off_ns.abs() <= SAME_NS { moment + off_ns } else { moment };
        Stamp::from_nanos(u64::try_from(moment).unwrap_or(u64::MAX))
    };
    let relation = |r: &Relation| Relation {
        first: moved(r.first),
        second: moved(r.second),
        second_in_first: r.second_in_first,
    };
    (relations.iter().map(relation).collect(), shift_ns as f64 * 1e-9)
}

/// What must be added to `moments` so that they are those of `scans`; both in order. 0 when they are already, or when
/// no shift makes them so. Of shifts that fit in time, that one is taken in which the motions fit, too.
fn clock_shift_ns(
    moments: &[i64],
    scans: &[i64],
    motion_error_m: &dyn Fn(i64) -> Option<f64>,
) -> i64 {
    let every = moments.len().div_ceil(MOMENTS_MAX).max(1);
    let some: Vec<i64> = moments.iter().step_by(every).copied().collect();
    let matched = |shift_ns: i64| {
        let near =
            |moment: i64| distance_ns(moment.saturating_add(shift_ns), scans).abs() <= SAME_NS;
        some.iter().filter(|&&moment| near(moment)).count() as f64 / some.len().max(1) as f64
    };
    let Some(&first) = some.first() else { return 0 };
    let badness = |shift_ns: i64| {
        let distance = |&moment: &i64| distance_ns(moment.saturating_add(shift_ns), scans).abs();
        some.iter().map(|moment| distance(moment).min(SAME_NS)).sum::<i64>()
    };
    // The first moment is one of the scans, up to an error of its own.
    let around = |coarse: i64| (-15..=15).map(move |i| coarse.saturating_add(i * FINE_NS));
    let fine = |coarse: i64| around(coarse).min_by_key(|&ns| (badness(ns), ns)).unwrap_or(coarse);
    let mut coarse: Vec<i64> = scans.iter().map(|scan| scan.saturating_sub(first)).collect();
    coarse.sort_by_cached_key(|&shift_ns| (badness(shift_ns), shift_ns));
    let candidates = coarse.into_iter().take(CANDIDATES_MAX).map(fine);
    let believed = candidates.filter(|&ns| matched(ns) >= MATCHED_MIN_RATIO);
    let rated = believed.map(|ns| (motion_error_m(ns).unwrap_or(f64::INFINITY), ns));
    let best = rated.min_by(|a, b| a.0.total_cmp(&b.0).then(badness(a.1).cmp(&badness(b.1))));
    let now_m = motion_error_m(0).unwrap_or(f64::INFINITY);
    match best {
        Some((error_m, shift_ns)) if error_m < now_m => shift_ns,
        // Without odometry only time can tell, and it must tell clearly.
        Some((_, shift_ns)) if now_m.is_infinite() && matched(0) <= UNMATCHED_MAX_RATIO => shift_ns,
        _ => 0,
    }
}

/// From a moment to the nearest of `scans`, which are in order; positive when that is later.
fn distance_ns(moment: i64, scans: &[i64]) -> i64 {
    let after = scans.partition_point(|&scan| scan < moment);
    let beside = [after.checked_sub(1), Some(after)];
    let distances = beside.into_iter().flatten().filter_map(|i| scans.get(i)?.checked_sub(moment));
    distances.min_by_key(|distance| distance.unsigned_abs()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scans about every 200 ms, never evenly; every seventh is a moment.
    fn times() -> (Vec<i64>, Vec<i64>) {
        let scan = |i: i64| i * 200_000_000 + (i * i * 7_919) % 50_000_000;
        let scans: Vec<i64> = (0..2000).map(scan).collect();
        (scans.iter().copied().skip(100).step_by(7).take(200).collect(), scans)
    }

    #[test]
    fn a_shifted_clock_is_set_right_on_both_sides() {
        let (moments, scans) = times();
        let shift = |moments: &[i64]| clock_shift_ns(moments, &scans, &|_| None);
        assert_eq!(shift(&moments), 0);
        for shift_ns in [1_211_440_000_000_i64, -77_123_456_789, 90_100_000_000] {
            let late: Vec<i64> = moments
                .iter()
                .enumerate()
                .map(|(i, m)| m + shift_ns + (i as i64 % 5 - 2) * 6_000_000)
                .collect();
            let found = shift(&late);
            assert!((found + shift_ns).abs() < 8_000_000, "{shift_ns}: {found}");
        }
    }

    /// Scans that come evenly fit at every period; only the motions tell which one is meant.
    #[test]
    fn motions_decide_where_times_do_not() {
        let scans: Vec<i64> = (0..500).map(|i| i * 200_000_000).collect();
        let late: Vec<i64> = scans[100..200].iter().map(|t| t + 3_030_000_000).collect();
        let meant_ns = -3_030_000_000_i64;
        let error = |ns: i64| Some(if (ns - meant_ns).abs() < 50_000_000 { 0.01 } else { 0.5 });
        let found = clock_shift_ns(&late, &scans, &error);
        assert!((found - meant_ns).abs() < 50_000_000, "{found}");
        // Where they are already right, nothing is shifted.
        assert_eq!(clock_shift_ns(&scans[100..200], &scans, &|ns| error(ns + meant_ns)), 0);
    }

    /// A robot that turns this way and that; its relations are half a second late.
    #[test]
    fn a_late_clock_is_set_by_the_motions() {
        let pose = |t: f64| Se2::new(0.3 * t, (0.7 * t).sin(), 1.2 * (0.9 * t).sin());
        let stamp = |t: f64| Stamp::from_nanos((t * 1e9).round() as u64);
        let track: Vec<StampedPose> = (0..600)
            .map(|i| f64::from(i) * 0.1)
            .map(|t| StampedPose { stamp: stamp(t), pose: pose(t) })
            .collect();
        for late_s in [0.5, -0.24, 0.0] {
            let relation = |i: i32| {
                let (a, b) = (2.0 + f64::from(i) * 0.37, 3.1 + f64::from(i) * 0.37);
                Relation {
                    first: stamp(a + late_s),
                    second: stamp(b + late_s),
                    second_in_first: pose(a).inverse().compose(pose(b)),
                }
            };
            let relations: Vec<Relation> = (0..140).map(relation).collect();
            let (moved, shift_s) = on_the_best_clock(&relations, &track);
            assert!((shift_s + late_s).abs() < 0.011, "{late_s}: {shift_s}");
            let first = moved[0].first.as_secs_f64();
            assert!((first - 2.0).abs() < 0.011, "{first}");
        }
    }

    #[test]
    fn a_moment_beside_a_scan_is_the_scans_own() {
        let pose = |t: f64| Se2::new(t, 0.0, (2.0 * t).sin());
        let stamp = |t: f64| Stamp::from_nanos((t * 1e9).round() as u64);
        let track: Vec<StampedPose> = (0..200)
            .map(|i| f64::from(i) * 0.3)
            .map(|t| StampedPose { stamp: stamp(t), pose: pose(t) })
            .collect();
        let relation = |i: i32| {
            let (a, b) = (f64::from(3 * i) * 0.3, f64::from(3 * i + 4) * 0.3);
            let jitter_s = if i % 2 == 0 { 0.04 } else { -0.04 };
            Relation {
                first: stamp(a + 0.1 + jitter_s),
                second: stamp(b + 0.1 - jitter_s),
                second_in_first: pose(a).inverse().compose(pose(b)),
            }
        };
        let relations: Vec<Relation> = (0..60).map(relation).collect();
        let (moved, _) = on_the_best_clock(&relations, &track);
        let scans: Vec<Stamp> = track.iter().map(|p| p.stamp).collect();
        for (i, relation) in moved.iter().enumerate() {
            assert_eq!(relation.first, scans[3 * i], "{i}");
            assert_eq!(relation.second, scans[3 * i + 4], "{i}");
        }
    }

    #[test]
    fn moments_of_another_log_are_left_alone() {
        let (_, scans) = times();
        let strange: Vec<i64> = (0..150).map(|i| i * 5_431_000_000 + i * i * 1_234_567).collect();
        assert_eq!(clock_shift_ns(&strange, &scans, &|_| None), 0);
        assert_eq!(clock_shift_ns(&[], &scans, &|_| None), 0);
        assert_eq!(clock_shift_ns(&strange, &[], &|_| None), 0);
    }
}
