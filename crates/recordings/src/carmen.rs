//! Logs of the CARMEN toolkit: `FLASER`, `ROBOTLASER1`, `RAWLASER1`, `ODOM` and `TRUEPOS` lines.
//!
//! One message in a line: name, content, stamp of the message, host, stamp of the logger; the stamp of the message is
//! taken. A log often holds the same laser under two names: the one kind is read that comes first of
//! `FLASER`, `ROBOTLASER1`, `RAWLASER1` among those with at least half as many lines as the most frequent.
//!
//! `FLASER` has two poses. The second is the robot's odometry. The first is the laser's pose: in a raw log the
//! odometry again, moved by where the laser sits (then that place is found from them); in a log that was
//! corrected by a mapper it is the mapper's, and goes to the recording's `reference`.
//!
//! Beams without a description: 181 and 361 cover 180°; 180 and 360 are those without the last one, so
//! that the spacing stays 1° and 0.5°; 401 and 400 have 0.25° around 100°; any other number covers 180°, which is
//! complained about, because it is a guess. Readings from 50 m on mean that nothing came back (SICK
//! scanners write 81.91 or 8.19 m; 8.19 is inside what others measure, so give the range where it matters),
//! and so does 0.
//!
//! Source: CARMEN, "logger, playback", <https://carmen.sourceforge.net/logger_playback.html> (messages and
//! their fields); CARMEN's log library (what is guessed for a number of beams). Differences: for 400 beams that
//! library computes the angle with π/100 instead of π/180, a slip.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use geometry::Se2;

use crate::{
    Format, ReadOptions, RecordingError,
    complaints::{Action, Complaints, Place, Trouble},
    contents::{first_words, no_scans},
    numbers::{Fault, Fields, lines, text},
    raw::{RawPose, RawRecording, RawScan, usual_count},
    recording::{LaserRig, Rig, exact_pose},
};

/// Readings from here on mean that nothing came back, metres.
pub(crate) const RANGE_MAX_M: f64 = 50.0;
/// First poses that lie this close to one place on the robot are where the laser sits: metres, radians. Logs
/// have six decimals; a mapper's correction changes by far more.
const MOUNT_SPREAD: f64 = 1e-4;
/// Names of messages by which a log is known.
const KEYWORDS: [&str; 12] = [
    "FLASER",
    "RLASER",
    "ROBOTLASER1",
    "ROBOTLASER2",
    "RAWLASER1",
    "RAWLASER2",
    "ODOM",
    "PARAM",
    "SYNC",
    "TRUEPOS",
    "SONAR",
    "LASER3",
];
/// Messages that hold the front laser, the best first.
const SCANS: [&str; 3] = ["FLASER", "ROBOTLASER1", "RAWLASER1"];

/// Whether lines of a log begin so.
fn is_keyword(word: &str) -> bool {
    KEYWORDS.contains(&word)
}

/// Whether a log begins so.
pub(crate) fn is_beginning(line: &str) -> bool {
    line.starts_with("# CARMEN") || line.split_ascii_whitespace().next().is_some_and(is_keyword)
}

/// Whether a line of a log holds a pose and no scan.
pub(crate) fn is_pose_line(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    line.starts_with(b"ODOM ") || line.starts_with(b"TRUEPOS ")
}

/// A scan, with the laser's description if the line has one.
struct ScanLine {
    scan: RawScan,
    laser: Option<LaserRig>,
    n_bad: usize,
}

pub(crate) fn read(
    name: &str,
    content: &[u8],
    options: &ReadOptions<'_>,
    complaints: &mut Complaints,
) -> Result<RawRecording, RecordingError> {
    let Some(kind) = chosen_kind(content) else {
        return Err(no_scans(name, Format::Carmen, &first_words(content), complaints));
    };
    let mut scans = Vec::new();
    let mut lasers = Vec::new();
    let mut odometry = Vec::new();
    let mut truth = Vec::new();
    for (number, line) in lines(content) {
        let place = Place::Line(number);
        let outcome = text(line).and_then(|line| {
            let mut fields = Fields::new(line);
            let Ok(word) = fields.word("") else { return Ok(()) };
            if word == kind {
                let found = scan_line(kind, place, fields, options)?;
                if found.n_bad > 0 {
                    let n = found.n_bad;
                    let text =
                        || format!("{n} readings are no distances; taken as nothing came back");
                    complaints.add(place, Trouble::NotFinite, Action::Repaired, text);
                }
                lasers.extend(found.laser);
                scans.push(found.scan);
            } else if word == "ODOM" {
                odometry.push(pose_line(place, fields, 3)?);
            } else if word == "TRUEPOS" {
                truth.push(pose_line(place, fields, 3)?);
            }
            Ok(())
        });
        if let Err(fault) = outcome {
            complaints.add(place, fault.trouble, Action::Skipped, || fault.found);
        }
    }
    if scans.is_empty() {
        return Err(no_scans(name, Format::Carmen, &first_words(content), complaints));
    }
    let rig = rig(&mut scans, &lasers, options, complaints);
    Ok(RawRecording { rig: Rig::Laser(rig), scans, odometry, truth })
}

fn chosen_kind(content: &[u8]) -> Option<&'static str> {
    let mut counts = [0_usize; SCANS.len()];
    for (_, line) in lines(content) {
        let word = line.split(u8::is_ascii_whitespace).find(|w| !w.is_empty());
        if let Some(at) = SCANS.iter().position(|s| Some(s.as_bytes()) == word) {
            counts[at] += 1;
        }
    }
    let most = counts.into_iter().max().unwrap_or(0);
    let at = counts.iter().position(|&n| n > 0 && 2 * n >= most)?;
    Some(SCANS[at])
}

/// `x y yaw`, then `n_skipped` numbers, then the stamp.
fn pose_line(place: Place, mut fields: Fields<'_>, n_skipped: usize) -> Result<RawPose, Fault> {
    let pose = pose(&mut fields)?;
    for _ in 0..n_skipped {
        fields.number("a number that is not used")?;
    }
    let stamp_ns = fields.seconds_ns("the stamp")?;
    fields.word("the host")?;
    Ok(RawPose { place, stamp_ns, pose })
}

fn pose(fields: &mut Fields<'_>) -> Result<Se2, Fault> {
    let x_m = fields.number("x")?;
    let y_m = fields.number("y")?;
    Ok(exact_pose(x_m, y_m, fields.number("the heading")?))
}

fn scan_line(
    kind: &str,
    place: Place,
    mut fields: Fields<'_>,
    options: &ReadOptions<'_>,
) -> Result<ScanLine, Fault> {
    if kind == "FLASER" {
        return flaser(place, fields, options);
    }
    fields.number("the laser's type")?;
    let first_beam_rad = fields.number("the start angle")?;
    let field_of_view_rad = fields.number("the field of view")?;
    let spacing_rad = fields.number("the angular resolution")?;
    let max_m = fields.number("the maximum range")?;
    fields.number("the accuracy")?;
    fields.number("the remission mode")?;
    let range_max_m = options.range_max_m.unwrap_or(if max_m > 0.0 { max_m } else { RANGE_MAX_M });
    let (ranges_m, n_bad) = ranges(&mut fields, range_max_m)?;
    let n_remissions = fields.count("the number of remissions")?;
    for _ in 0..n_remissions {
        fields.any_number("a remission")?;
    }
    let n = ranges_m.len();
    let mut scan = RawScan { place, ranges_m, ..RawScan::default() };
    let mut base_from_sensor = options.base_from_sensor.unwrap_or(Se2::IDENTITY);
    if kind == "ROBOTLASER1" {
        let odom_from_sensor = pose(&mut fields)?;
        let odom_from_base = pose(&mut fields)?;
        base_from_sensor = odom_from_base.inverse().compose(odom_from_sensor);
        scan.odom = Some(odom_from_base);
        for what in [
            "the speed",
            "the turn rate",
            "a safety distance",
            "a safety distance",
            "the turn axis",
        ] {
            fields.number(what)?;
        }
    }
    end_of_scan(&mut scan, fields)?;
    let gaps = n.saturating_sub(1).max(1) as f64;
    let spacing_rad = if spacing_rad > 0.0 { spacing_rad } else { field_of_view_rad / gaps };
    let laser = LaserRig {
        base_from_sensor,
        first_beam_rad,
        beam_spacing_rad: spacing_rad,
        n_beams: n,
        range_max_m,
    };
    Ok(ScanLine { scan, laser: Some(laser), n_bad })
}

fn flaser(
    place: Place,
    mut fields: Fields<'_>,
    options: &ReadOptions<'_>,
) -> Result<ScanLine, Fault> {
    let (ranges_m, n_bad) = ranges(&mut fields, options.range_max_m.unwrap_or(RANGE_MAX_M))?;
    let mut scan = RawScan { place, ranges_m, ..RawScan::default() };
    scan.reference = Some(pose(&mut fields)?);
    scan.odom = Some(pose(&mut fields)?);
    end_of_scan(&mut scan, fields)?;
    Ok(ScanLine { scan, laser: None, n_bad })
}

/// A number of readings and that many: infinite where nothing came back, with the number of bad ones.
fn ranges(fields: &mut Fields<'_>, range_max_m: f64) -> Result<(Vec<f64>, usize), Fault> {
    let n = fields.count("the number of readings")?;
    if n == 0 {
        return Err(Fault::new(Trouble::BeamCount, "a scan of no readings"));
    }
    let mut ranges_m = Vec::with_capacity(n);
    let mut n_bad = 0;
    for _ in 0..n {
        let (range_m, is_bad) = laser_range(fields.any_number("a reading")?, range_max_m);
        n_bad += usize::from(is_bad);
        ranges_m.push(range_m);
    }
    if 2 * n_bad > n {
        let found = format!("{n_bad} of {n} readings are no distances");
        return Err(Fault::new(Trouble::NotFinite, found));
    }
    Ok((ranges_m, n_bad))
}

/// A laser's reading, infinite for nothing; and whether it is none at all (NaN or negative).
pub(crate) fn laser_range(value: f64, range_max_m: f64) -> (f64, bool) {
    let is_bad = value.is_nan() || value < 0.0;
    let is_echo = value > 0.0 && value < range_max_m;
    (if is_echo { value } else { f64::INFINITY }, is_bad)
}

/// Stamp, host, stamp of the logger, and nothing more: a line of another length has its fields elsewhere.
fn end_of_scan(scan: &mut RawScan, mut fields: Fields<'_>) -> Result<(), Fault> {
    scan.stamp_ns = fields.seconds_ns("the stamp")?;
    fields.word("the host")?;
    fields.seconds_ns("the logger's stamp")?;
    match fields.n_left() {
        0 => Ok(()),
        n => {
            let found = format!(
                "{n} fields too many: the number of readings is wrong, or two lines are one"
            );
            Err(Fault::new(Trouble::BeamCount, found))
        }
    }
}

/// The laser; scans whose description is another one are left out, as are first poses that are none of a mapper's.
fn rig(
    scans: &mut Vec<RawScan>,
    lasers: &[LaserRig],
    options: &ReadOptions<'_>,
    complaints: &mut Complaints,
) -> LaserRig {
    let n_beams = usual_count(scans);
    let Some(first) = lasers.iter().find(|l| l.n_beams == n_beams).cloned() else {
        let mount = mount(scans);
        if let Some(base_from_sensor) = mount {
            for scan in scans.iter_mut() {
                scan.reference = None;
            }
            return undescribed(n_beams, base_from_sensor, options, complaints);
        }
        return undescribed(
            n_beams,
            options.base_from_sensor.unwrap_or(Se2::IDENTITY),
            options,
            complaints,
        );
    };
    let mut index = 0;
    scans.retain(|scan| {
        let laser = &lasers[index];
        index += 1;
        let same = laser.n_beams != n_beams || is_same(laser, &first);
        if !same {
            let text = || "the laser is described otherwise than at first".to_owned();
            complaints.add(scan.place, Trouble::RigChanges, Action::Skipped, text);
        }
        same
    });
    LaserRig { range_max_m: options.range_max_m.unwrap_or(first.range_max_m), ..first }
}

fn is_same(a: &LaserRig, b: &LaserRig) -> bool {
    let d = a.base_from_sensor.inverse().compose(b.base_from_sensor);
    // Poses have six decimals, and a turned offset loses some of them.
    d.position().norm() < 1e-3
        && d.yaw_rad.abs() < 1e-3
        && (a.first_beam_rad - b.first_beam_rad).abs() < 1e-4
        && (a.beam_spacing_rad - b.beam_spacing_rad).abs() < 1e-6
}

/// Where the laser sits, if the first poses of all scans are the odometry moved by one place.
fn mount(scans: &[RawScan]) -> Option<Se2> {
    let offset = |s: &RawScan| Some(s.odom?.inverse().compose(s.reference?));
    let first = scans.first().and_then(offset)?;
    let is_there = |s: &RawScan| {
        let d = offset(s).map(|o| first.inverse().compose(o));
        d.is_some_and(|d| d.position().norm() < MOUNT_SPREAD && d.yaw_rad.abs() < MOUNT_SPREAD)
    };
    scans.iter().all(is_there).then_some(first)
}

fn undescribed(
    n_beams: usize,
    base_from_sensor: Se2,
    options: &ReadOptions<'_>,
    complaints: &mut Complaints,
) -> LaserRig {
    let (first_beam_rad, beam_spacing_rad) = match options.field_of_view_rad {
        Some(angle) => spread(n_beams, angle),
        None => guessed(n_beams, complaints),
    };
    LaserRig {
        base_from_sensor,
        first_beam_rad,
        beam_spacing_rad,
        n_beams,
        range_max_m: options.range_max_m.unwrap_or(RANGE_MAX_M),
    }
}

/// First bearing and spacing (radians) of beams from one end of an angle to the other, symmetric ahead. A whole turn
/// ends one spacing before it begins.
pub(crate) fn spread(n_beams: usize, angle_rad: f64) -> (f64, f64) {
    let gaps = if angle_rad >= TAU { n_beams } else { n_beams.saturating_sub(1) };
    (-angle_rad / 2.0, angle_rad / gaps.max(1) as f64)
}

fn guessed(n_beams: usize, complaints: &mut Complaints) -> (f64, f64) {
    match n_beams {
        180 | 181 => (-FRAC_PI_2, PI / 180.0),
        360 | 361 => (-FRAC_PI_2, PI / 360.0),
        400 | 401 => (-50.0_f64.to_radians(), PI / 720.0),
        _ => {
            let text = || {
                format!(
                    "{n_beams} beams are taken to cover 180°; give the field of view if they do not"
                )
            };
            complaints.add(Place::File, Trouble::Assumed, Action::Kept, text);
            spread(n_beams, PI)
        }
    }
}

#[cfg(test)]
#[path = "carmen_tests.rs"]
pub(crate) mod tests;
