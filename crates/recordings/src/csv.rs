//! Recordings as CSV, for people with a spreadsheet or a script.
//!
//! ```text
//! # rig: {"kind":"ring","base_from_sensors":[[0.1,0.0,0.0]],"half_angle_rad":0.26,"range_min_m":0.1,"range_max_m":5.0}
//! stamp_s,odom_x_m,odom_y_m,odom_yaw_rad,range_0_m
//! 1700000000.250000000,0.1,0.0,0.0,1.35
//! 1700000000.500000000,0.2,0.0,0.0,inf
//! 1700000000.600000000,0.24,0.0,0.0,
//! ```
//!
//! The first line, `# rig: ` with JSON, says what took the readings; without it the options must name a ring. The
//! header names the columns, in any order:
//!
//! | columns | meaning |
//! | --- | --- |
//! | `stamp_s` | when, seconds of any clock; needed |
//! | `range_0_m`, `range_1_m`, … | the readings, metres, `inf` for nothing; needed |
//! | `odom_x_m`, `odom_y_m`, `odom_yaw_rad` | dead reckoning |
//! | `truth_x_m`, `truth_y_m`, `truth_yaw_rad` | the true pose |
//! | `reference_x_m`, `reference_y_m`, `reference_yaw_rad` | somebody else's pose |
//! | `range_0_stamp_s`, … | when each reading was taken, if not at `stamp_s` |
//! | `extra_0_m`, … | readings of sonars whose place is not known |
//!
//! A row without any reading is odometry alone. Empty fields are absent values. Lines that begin with `#` are remarks.
//! Nothing is quoted. What is written reads back as the same recording, bit by bit.

use std::fmt::Write;

use geometry::Se2;

use crate::{
    Format, ReadOptions, RecordingError, Ring,
    cairn_mcap::{decode_rig, encode_rig},
    carmen::laser_range,
    complaints::{Action, Complaints, Place, Trouble},
    contents::{first_words, no_scans},
    numbers::{Fault, decimal_from_nanos, is_measurable, lines, nanos_from_decimal, shown, text},
    raw::{RawPose, RawRecording, RawScan},
    recording::{Recording, Rig, Scan, StampedPose, exact_pose},
};

const RIG: &str = "# rig:";
const POSES: [&str; 3] = ["odom", "truth", "reference"];

/// A recording as CSV, with its rig; stamps are the file's own, exact to the nanosecond. Odometry between scans gets
/// rows of its own.
pub fn write(recording: &Recording) -> String {
    let columns = Columns::of(recording);
    let mut out = format!("{RIG} {}\n", String::from_utf8_lossy(&encode_rig(&recording.rig)));
    out.push_str(&columns.header());
    let mut odometry = recording.odometry.iter().peekable();
    let epoch_ns = recording.epoch_ns;
    for (index, scan) in recording.scans.iter().enumerate() {
        while let Some(pose) = odometry.next_if(|pose| pose.stamp < scan.stamp) {
            columns.odometry_row(*pose, epoch_ns, &mut out);
        }
        columns.scan_row(recording, index, scan, &mut out);
    }
    for pose in odometry {
        columns.odometry_row(*pose, epoch_ns, &mut out);
    }
    out
}

/// Which columns are written.
struct Columns {
    /// In the order of [`POSES`].
    has_poses: [bool; 3],
    n_ranges: usize,
    /// Stamps of readings: none, or as many as readings.
    n_stamps: usize,
    n_extra: usize,
}

impl Columns {
    fn of(recording: &Recording) -> Self {
        let scans = &recording.scans;
        let has_odom =
            !recording.odometry.is_empty() || scans.iter().any(|s| s.odom_from_base.is_some());
        let has_stamps = scans.iter().any(|s| !s.stamps.is_empty());
        let n_ranges = recording.rig.n_readings();
        Self {
            has_poses: [has_odom, !recording.truth.is_empty(), !recording.reference.is_empty()],
            n_ranges,
            n_stamps: if has_stamps { n_ranges } else { 0 },
            n_extra: recording.extra_columns_m.iter().map(Vec::len).max().unwrap_or(0),
        }
    }

    fn header(&self) -> String {
        let mut names = vec!["stamp_s".to_owned()];
        for (name, _) in POSES.iter().zip(self.has_poses).filter(|(_, has)| *has) {
            names.extend(["x_m", "y_m", "yaw_rad"].map(|part| format!("{name}_{part}")));
        }
        names.extend((0..self.n_ranges).map(|i| format!("range_{i}_m")));
        names.extend((0..self.n_stamps).map(|i| format!("range_{i}_stamp_s")));
        names.extend((0..self.n_extra).map(|i| format!("extra_{i}_m")));
        names.join(",") + "\n"
    }

    fn scan_row(&self, recording: &Recording, index: usize, scan: &Scan, out: &mut String) {
        let epoch_ns = recording.epoch_ns;
        out.push_str(&own_time(epoch_ns, scan.stamp.as_nanos()));
        let at = |poses: &[StampedPose]| poses.get(index).map(|p| p.pose);
        self.poses([scan.odom_from_base, at(&recording.truth), at(&recording.reference)], out);
        numbers(&scan.ranges_m, self.n_ranges, out);
        for index in 0..self.n_stamps {
            out.push(',');
            if let Some(stamp) = scan.stamps.get(index) {
                out.push_str(&own_time(epoch_ns, stamp.as_nanos()));
            }
        }
        let extra = recording.extra_columns_m.get(index).map_or(&[][..], Vec::as_slice);
        numbers(extra, self.n_extra, out);
        out.push('\n');
    }

    fn odometry_row(&self, pose: StampedPose, epoch_ns: i64, out: &mut String) {
        out.push_str(&own_time(epoch_ns, pose.stamp.as_nanos()));
        self.poses([Some(pose.pose), None, None], out);
        numbers(&[], self.n_ranges + self.n_stamps + self.n_extra, out);
        out.push('\n');
    }

    fn poses(&self, poses: [Option<Se2>; 3], out: &mut String) {
        for (pose, _) in poses.into_iter().zip(self.has_poses).filter(|(_, has)| *has) {
            let values = pose.map(|p| [p.x_m, p.y_m, p.yaw_rad]);
            numbers(values.as_ref().map_or(&[], <[f64; 3]>::as_slice), 3, out);
        }
    }
}

fn own_time(epoch_ns: i64, nanos: u64) -> String {
    decimal_from_nanos(epoch_ns.saturating_add_unsigned(nanos))
}

/// `n` fields, each after a comma; empty where there is no value.
fn numbers(values: &[f64], n: usize, out: &mut String) {
    for index in 0..n {
        out.push(',');
        if let Some(value) = values.get(index) {
            // Writing to a string does not fail.
            let _written = write!(out, "{value}");
        }
    }
}

/// Whether a CSV of ours begins so.
pub(crate) fn is_beginning(line: &str) -> bool {
    line.starts_with(RIG) || Header::parse(line).is_some()
}

/// Where in a row each value is.
struct Header {
    n_columns: usize,
    stamp: usize,
    poses: [Option<[usize; 3]>; 3],
    ranges: Vec<usize>,
    stamps: Vec<usize>,
    extra: Vec<usize>,
    unknown: Vec<String>,
}

impl Header {
    /// `None` when it is no header of ours: without a stamp or any range.
    fn parse(line: &str) -> Option<Self> {
        let names: Vec<&str> = line.split(',').map(str::trim).collect();
        let place = |name: &str| names.iter().position(|n| *n == name);
        let row = |before: &str, after: &str| -> Vec<usize> {
            (0..names.len()).map_while(|i| place(&format!("{before}{i}{after}"))).collect()
        };
        let stamp = place("stamp_s")?;
        let ranges = row("range_", "_m");
        if ranges.is_empty() {
            return None;
        }
        let pose = |name: &str| {
            let part = |part: &str| place(&format!("{name}_{part}"));
            Some([part("x_m")?, part("y_m")?, part("yaw_rad")?])
        };
        let mut header = Self {
            n_columns: names.len(),
            stamp,
            poses: POSES.map(pose),
            stamps: row("range_", "_stamp_s"),
            extra: row("extra_", "_m"),
            ranges,
            unknown: Vec::new(),
        };
        let mut known = vec![false; names.len()];
        let poses = header.poses.iter().flatten().flatten();
        let all = header.ranges.iter().chain(&header.stamps).chain(&header.extra).chain(poses);
        all.chain([&stamp]).for_each(|&at| known[at] = true);
        let unknown = names.iter().zip(known).filter(|(_, known)| !known);
        header.unknown = unknown.map(|(name, _)| shown(name)).collect();
        Some(header)
    }
}

pub(crate) fn read(
    name: &str,
    content: &[u8],
    options: &ReadOptions<'_>,
    complaints: &mut Complaints,
) -> Result<RawRecording, RecordingError> {
    let no_rig = |problem: String| RecordingError::NoRig { name: name.to_owned(), problem };
    let mut rig: Option<Rig> = None;
    let mut header: Option<Header> = None;
    let mut scans = Vec::new();
    let mut odometry = Vec::new();
    for (number, line) in lines(content) {
        let place = Place::Line(number);
        let outcome = text(line).and_then(|line| {
            if let Some(json) = line.strip_prefix(RIG) {
                let found = decode_rig(json.trim().as_bytes()).map_err(|e| {
                    Fault::new(Trouble::Damaged, format!("a rig that is none: {e}"))
                })?;
                rig = rig.take().or(Some(found));
                return Ok(());
            }
            if line.trim().is_empty() || line.starts_with('#') {
                return Ok(());
            }
            let Some(header) = &header else {
                header = Some(named_columns(place, line, complaints)?);
                return Ok(());
            };
            match row(place, line, header)? {
                Entry::Scan(scan) => scans.push(scan),
                Entry::Odometry(pose) => odometry.push(pose),
            }
            Ok(())
        });
        if let Err(fault) = outcome {
            complaints.add(place, fault.trouble, Action::Skipped, || fault.found);
        }
    }
    if scans.is_empty() {
        return Err(no_scans(name, Format::Csv, &first_words(content), complaints));
    }
    let preset = if options.ring == Ring::File { None } else { options.ring.rig() };
    let Some(mut rig) = preset.map(Rig::Ring).or(rig) else {
        let problem = format!("no readable line `{RIG} {{…}}`; name a ring, or write the line");
        return Err(no_rig(problem));
    };
    match &mut rig {
        Rig::Laser(laser) => laser.range_max_m = options.range_max_m.unwrap_or(laser.range_max_m),
        Rig::Ring(ring) => ring.range_max_m = options.range_max_m.unwrap_or(ring.range_max_m),
    }
    let max_m = if matches!(rig, Rig::Laser(_)) { rig.range_max_m() } else { f64::INFINITY };
    scans.retain_mut(|scan| mend_ranges(scan, max_m, complaints));
    Ok(RawRecording { odometry, ..RawRecording::new(rig, scans) })
}

/// The header, with a complaint about columns of unknown names.
fn named_columns(place: Place, line: &str, complaints: &mut Complaints) -> Result<Header, Fault> {
    let Some(header) = Header::parse(line) else {
        let found = "no header: columns `stamp_s` and `range_0_m` are needed";
        return Err(Fault::new(Trouble::Unreadable, found));
    };
    if !header.unknown.is_empty() {
        let text = || format!("columns of unknown names: {}", header.unknown.join(", "));
        complaints.add(place, Trouble::NotSupported, Action::Skipped, text);
    }
    Ok(header)
}

enum Entry {
    Scan(RawScan),
    Odometry(RawPose),
}

fn row(place: Place, line: &str, header: &Header) -> Result<Entry, Fault> {
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    if fields.len() != header.n_columns {
        let (found, needed) = (fields.len(), header.n_columns);
        let trouble = if found < needed { Trouble::Truncated } else { Trouble::BeamCount };
        return Err(Fault::new(trouble, format!("{found} fields where {needed} are needed")));
    }
    let stamp_ns = time(fields[header.stamp], "stamp_s")?;
    let mut poses = [None; 3];
    for ((pose, at), name) in poses.iter_mut().zip(header.poses).zip(POSES) {
        let Some(at) = at else { continue };
        *pose = pose_of(at.map(|i| fields[i]), name)?;
    }
    let [odom, truth, reference] = poses;
    let is_empty = |at: &Vec<usize>| at.iter().all(|&i| fields[i].is_empty());
    if is_empty(&header.ranges) {
        let Some(pose) = odom else {
            return Err(Fault::new(Trouble::Truncated, "neither readings nor odometry"));
        };
        return Ok(Entry::Odometry(RawPose { place, stamp_ns, pose }));
    }
    let values = |at: &Vec<usize>, what: &str| -> Result<Vec<f64>, Fault> {
        at.iter().map(|&i| number(fields[i], what)).collect()
    };
    let times = |at: &Vec<usize>| -> Result<Vec<i64>, Fault> {
        at.iter().map(|&i| time(fields[i], "a reading's stamp")).collect()
    };
    let stamps_ns = if is_empty(&header.stamps) { Vec::new() } else { times(&header.stamps)? };
    let extra_m =
        if is_empty(&header.extra) { Vec::new() } else { values(&header.extra, "a reading")? };
    let ranges_m = values(&header.ranges, "a reading")?;
    Ok(Entry::Scan(RawScan {
        place,
        stamp_ns,
        odom,
        reference,
        truth,
        ranges_m,
        stamps_ns,
        extra_m,
    }))
}

fn number(field: &str, what: &str) -> Result<f64, Fault> {
    field.parse().map_err(|_e| {
        Fault::new(Trouble::Unreadable, format!("{what} is no number: {:?}", shown(field)))
    })
}

fn time(field: &str, what: &str) -> Result<i64, Fault> {
    if let Some(ns) = nanos_from_decimal(field) {
        return Ok(ns);
    }
    let is_not_finite = field.parse::<f64>().is_ok_and(|v| !v.is_finite());
    let trouble = if is_not_finite { Trouble::NotFinite } else { Trouble::Unreadable };
    Err(Fault::new(trouble, format!("{what} is no time: {:?}", shown(field))))
}

/// `None` for three empty fields.
fn pose_of(fields: [&str; 3], name: &str) -> Result<Option<Se2>, Fault> {
    if fields.iter().all(|f| f.is_empty()) {
        return Ok(None);
    }
    let [x, y, yaw] = fields;
    let values = [number(x, name)?, number(y, name)?, number(yaw, name)?];
    if !values.iter().all(|v| is_measurable(*v)) {
        return Err(Fault::new(Trouble::NotFinite, format!("the pose {name} is {values:?}")));
    }
    Ok(Some(exact_pose(values[0], values[1], values[2])))
}

/// Makes readings of nothing infinite; `false` for a scan that is to be left out.
fn mend_ranges(scan: &mut RawScan, max_m: f64, complaints: &mut Complaints) -> bool {
    let mut n_bad = 0;
    for value in &mut scan.ranges_m {
        let (range_m, is_bad) = laser_range(*value, max_m);
        n_bad += usize::from(is_bad);
        if is_bad || max_m.is_finite() {
            *value = range_m;
        }
    }
    let n = scan.ranges_m.len();
    if n_bad > 0 {
        let action = if 2 * n_bad > n { Action::Skipped } else { Action::Repaired };
        let text =
            || format!("{n_bad} of {n} readings are no distances; taken as nothing came back");
        complaints.add(scan.place, Trouble::NotFinite, action, text);
    }
    2 * n_bad <= n
}

#[cfg(test)]
#[path = "csv_tests.rs"]
pub(crate) mod tests;
