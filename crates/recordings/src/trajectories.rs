//! Files of poses and of relations between poses: trajectories to compare, and what to compare them with.

use std::fmt::Write;

use geometry::Se2;
use run_context::Stamp;

use crate::{
    RecordingError,
    complaints::{Action, Complaints, Place, Trouble},
    contents::{first_words, with_complaints},
    numbers::{Fault, Fields, decimal_from_nanos, lines, text},
    raw::RawPose,
    recording::{StampedPose, exact_pose},
    unpack::{is_gzip, unpack},
};

/// Bytes that a compressed file of poses may unpack to.
const BYTES_MAX: usize = 1 << 28;
/// A relation that rises or tilts by more than this (metres, radians) is said to be none of the plane.
const PLANAR: f64 = 1e-3;

/// Poses from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Poses {
    /// In order of time.
    pub poses: Vec<StampedPose>,
    /// The file's own time at [`Stamp::ZERO`], nanoseconds.
    pub epoch_ns: i64,
    /// What was wrong.
    pub complaints: Complaints,
}

/// Where one pose lies as seen from another, as people or a survey found it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relation {
    /// The file's own time of the pose that looks, nanoseconds.
    pub first_ns: i64,
    /// The file's own time of the pose that is looked at, nanoseconds.
    pub second_ns: i64,
    /// The second pose in the frame of the first.
    pub first_from_second: Se2,
}

/// Relations from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Relations {
    /// In the order of the file.
    pub relations: Vec<Relation>,
    /// What was wrong.
    pub complaints: Complaints,
}

/// A trajectory as text in TUM's format: `timestamp tx ty tz qx qy qz qw`, one line for each pose. The time is the
/// file's own (`epoch_ns` plus the stamp), with all nine decimals.
///
/// Source: TUM RGB-D benchmark, "File Formats", ground-truth trajectories.
pub fn write_tum(poses: &[StampedPose], epoch_ns: i64) -> String {
    let mut out = String::with_capacity(100 * poses.len());
    for StampedPose { stamp, pose } in poses {
        let time = decimal_from_nanos(epoch_ns.saturating_add_unsigned(stamp.as_nanos()));
        let (sin, cos) = (0.5 * pose.yaw_rad).sin_cos();
        // Writing to a string does not fail.
        let _written = writeln!(out, "{time} {} {} 0 0 0 {sin} {cos}", pose.x_m, pose.y_m);
    }
    out
}

/// Reads poses, plain or as gzip: lines of `t x y yaw` (s, m, m, rad) or of TUM's eight fields, of which the motion
/// in the plane is taken. Lines that begin with `#` or `%` are remarks. Poses out of order are sorted.
///
/// # Errors
///
/// [`RecordingError::NoLines`] when no line can be read.
pub fn read_poses(name: &str, bytes: &[u8]) -> Result<Poses, RecordingError> {
    let mut complaints = Complaints::default();
    let unpacked = unpacked(name, bytes, &mut complaints)?;
    let content = unpacked.as_deref().unwrap_or(bytes);
    let mut raw = pose_lines(content, Place::Line, &mut complaints);
    let Some(epoch_ns) = raw.iter().map(|p| p.stamp_ns).min() else {
        let what = "poses (`t x y yaw` or `t x y z qx qy qz qw`)";
        return Err(no_lines(name, what, content, &complaints));
    };
    let mut latest = i64::MIN;
    for pose in &raw {
        if pose.stamp_ns < latest {
            let (now, before) = (decimal_from_nanos(pose.stamp_ns), decimal_from_nanos(latest));
            let text = || format!("time {now} s after {before} s; sorted into its place");
            complaints.add(pose.place, Trouble::OutOfOrder, Action::Repaired, text);
        }
        latest = latest.max(pose.stamp_ns);
    }
    raw.sort_by_key(|p| p.stamp_ns);
    let stamped = |p: &RawPose| StampedPose {
        stamp: Stamp::from_nanos(p.stamp_ns.abs_diff(epoch_ns)),
        pose: p.pose,
    };
    Ok(Poses { poses: raw.iter().map(stamped).collect(), epoch_ns, complaints })
}

/// Reads relations, plain or as gzip: lines of `t1 t2 dx dy dz roll pitch yaw` (s, m, rad), the pose of t2 in the
/// frame of t1. Height and tilt are left aside; where they are not small, that is said.
///
/// Source: the format of Kümmerle et al. (2009), "On measuring the accuracy of SLAM algorithms", Autonomous Robots
/// 27, as its published relation files have it.
///
/// # Errors
///
/// [`RecordingError::NoLines`] when no line can be read.
pub fn read_relations(name: &str, bytes: &[u8]) -> Result<Relations, RecordingError> {
    let mut complaints = Complaints::default();
    let unpacked = unpacked(name, bytes, &mut complaints)?;
    let content = unpacked.as_deref().unwrap_or(bytes);
    let mut relations = Vec::new();
    for (number, line) in lines(content) {
        let place = Place::Line(number);
        let outcome = text(line).and_then(|line| {
            if is_remark(line) {
                return Ok(());
            }
            let (relation, tilt) = relation(line)?;
            if tilt > PLANAR {
                let text = || format!("height or tilt of {tilt} is left aside");
                complaints.add(place, Trouble::NotSupported, Action::Kept, text);
            }
            relations.push(relation);
            Ok(())
        });
        if let Err(fault) = outcome {
            complaints.add(place, fault.trouble, Action::Skipped, || fault.found);
        }
    }
    if relations.is_empty() {
        let what = "relations (`t1 t2 dx dy dz roll pitch yaw`)";
        return Err(no_lines(name, what, content, &complaints));
    }
    Ok(Relations { relations, complaints })
}

/// The poses of a file of truth.
pub(crate) fn true_poses(bytes: &[u8], complaints: &mut Complaints) -> Vec<RawPose> {
    pose_lines(bytes, Place::SecondFileLine, complaints)
}

fn unpacked(
    name: &str,
    bytes: &[u8],
    complaints: &mut Complaints,
) -> Result<Option<Vec<u8>>, RecordingError> {
    is_gzip(bytes).then(|| unpack(name, bytes, BYTES_MAX, complaints)).transpose()
}

fn no_lines(
    name: &str,
    what: &'static str,
    content: &[u8],
    complaints: &Complaints,
) -> RecordingError {
    let contains = with_complaints(&first_words(content), complaints);
    RecordingError::NoLines { name: name.to_owned(), what, contains }
}

fn is_remark(line: &str) -> bool {
    let line = line.trim_start();
    line.is_empty() || line.starts_with(['#', '%'])
}

fn pose_lines(
    content: &[u8],
    place: fn(usize) -> Place,
    complaints: &mut Complaints,
) -> Vec<RawPose> {
    let mut poses = Vec::new();
    for (number, line) in lines(content) {
        let place = place(number);
        let outcome = text(line).and_then(|line| {
            if !is_remark(line) {
                poses.push(pose_line(place, line)?);
            }
            Ok(())
        });
        if let Err(fault) = outcome {
            complaints.add(place, fault.trouble, Action::Skipped, || fault.found);
        }
    }
    poses
}

fn pose_line(place: Place, line: &str) -> Result<RawPose, Fault> {
    let n = line.split_ascii_whitespace().count();
    let mut fields = Fields::new(line);
    let stamp_ns = fields.seconds_ns("the time")?;
    let (x_m, y_m) = (fields.number("x")?, fields.number("y")?);
    let yaw_rad = if n < 8 {
        fields.number("the heading")?
    } else {
        fields.number("z")?;
        quaternion_yaw_rad(&mut fields)?
    };
    if n != 4 && n != 8 {
        let trouble = if n < 8 { Trouble::Truncated } else { Trouble::BeamCount };
        return Err(Fault::new(trouble, format!("{n} fields where 4 or 8 are needed")));
    }
    Ok(RawPose { place, stamp_ns, pose: exact_pose(x_m, y_m, yaw_rad) })
}

fn quaternion_yaw_rad(fields: &mut Fields<'_>) -> Result<f64, Fault> {
    let (x, y) = (fields.number("qx")?, fields.number("qy")?);
    let (z, w) = (fields.number("qz")?, fields.number("qw")?);
    if x * x + y * y + z * z + w * w < 1e-6 {
        return Err(Fault::new(Trouble::Unreadable, "a quaternion of length zero"));
    }
    if x == 0.0 && y == 0.0 {
        return Ok(2.0 * z.atan2(w));
    }
    Ok((2.0 * (w * z + x * y)).atan2(w * w + x * x - y * y - z * z))
}

/// A relation, and the largest of its height and tilts.
fn relation(line: &str) -> Result<(Relation, f64), Fault> {
    let mut fields = Fields::new(line);
    let first_ns = fields.seconds_ns("t1")?;
    let second_ns = fields.seconds_ns("t2")?;
    let (x_m, y_m) = (fields.number("dx")?, fields.number("dy")?);
    let mut tilt = 0.0_f64;
    for what in ["dz", "roll", "pitch"] {
        tilt = tilt.max(fields.number(what)?.abs());
    }
    let first_from_second = exact_pose(x_m, y_m, fields.number("yaw")?);
    match fields.n_left() {
        0 => Ok((Relation { first_ns, second_ns, first_from_second }, tilt)),
        n => Err(Fault::new(Trouble::BeamCount, format!("{n} fields too many"))),
    }
}

#[cfg(test)]
#[path = "trajectories_tests.rs"]
mod tests;
