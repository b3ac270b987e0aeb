//! Recordings of a ring of sonars as the mapping programs of ARTEMIC exchange them: MAT files, and pairs of texts.
//!
//! | format | readings | poses | time |
//! | --- | --- | --- | --- |
//! | MAT | matrix `saved_readings`, a row for each moment, mm | matrix `saved_pose`: x mm, y mm, heading deg | 0.25 s a row |
//! | ARTEMIC's texts | `12 \| 34 \| … `, cm | `x y yaw `, m and rad | 0.05 s a row |
//! | sonar text | `stamp r1 r2 …`, ms and mm | `stamp x y heading`, ms, mm and tenths of a degree | stamps |
//!
//! Readings keep their number also where it means that nothing came back (5000 mm in the MAT files of the simulator,
//! 5110 mm in the sonar text): [`Rig::is_echo`](crate::Rig::is_echo) tells. Columns beyond the ring are kept
//! in [`Recording::extra_columns_m`]. Rows of the two texts belong together by their number, whether or not
//! each can be read; rows of a sonar text by their stamp. A row without its other half is left out.
//!
//! What was read and is written again gives the same numbers when it is read again, bit by bit.

use std::{collections::BTreeMap, fmt::Write};

use geometry::Se2;

use crate::{
    Format, ReadOptions, RecordingError, Ring,
    complaints::{Action, Complaints, Place, Trouble},
    contents::{first_words, no_scans},
    mat::{self, Class, MatFile, Matrix},
    memory::{afford, scans_bytes},
    numbers::{Fault, Fields, is_measurable, lines, text},
    raw::{RawRecording, RawScan},
    recording::{Recording, Rig, RingRig, exact_pose},
};

/// Names of the matrices.
const READINGS: &str = "saved_readings";
const POSES: &str = "saved_pose";
/// Time between rows of the MAT files: App. A of the specification, 180 s in 720 rows.
const MAT_PERIOD_S: f64 = 0.25;
/// Time between rows of ARTEMIC's texts: its control cycle.
const ARTEMIC_PERIOD_S: f64 = 0.05;

/// How a heading is written.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Heading {
    Radians,
    Degrees,
    TenthsOfDegrees,
}

/// How the numbers of a format become metres and radians, and back.
#[derive(Clone, Copy, Debug)]
struct Units {
    readings_per_m: f64,
    positions_per_m: f64,
    heading: Heading,
}

const MAT_UNITS: Units =
    Units { readings_per_m: 1000.0, positions_per_m: 1000.0, heading: Heading::Degrees };
const ARTEMIC_UNITS: Units =
    Units { readings_per_m: 100.0, positions_per_m: 1.0, heading: Heading::Radians };
const TEXT_UNITS: Units =
    Units { readings_per_m: 1000.0, positions_per_m: 1000.0, heading: Heading::TenthsOfDegrees };

impl Units {
    fn range_m(self, value: f64) -> f64 {
        value / self.readings_per_m
    }

    fn pose(self, [x, y, heading]: [f64; 3]) -> Se2 {
        exact_pose(x / self.positions_per_m, y / self.positions_per_m, self.radians(heading))
    }

    fn radians(self, heading: f64) -> f64 {
        match self.heading {
            Heading::Radians => heading,
            Heading::Degrees => heading.to_radians(),
            Heading::TenthsOfDegrees => (heading / 10.0).to_radians(),
        }
    }

    fn reading(self, range_m: f64) -> f64 {
        inverted(range_m * self.readings_per_m, range_m, |v| self.range_m(v))
    }

    fn numbers(self, pose: Se2) -> [f64; 3] {
        let k = self.positions_per_m;
        let heading = match self.heading {
            Heading::Radians => pose.yaw_rad,
            Heading::Degrees => pose.yaw_rad.to_degrees(),
            Heading::TenthsOfDegrees => 10.0 * pose.yaw_rad.to_degrees(),
        };
        let wrapped = |v: f64| exact_pose(0.0, 0.0, self.radians(v)).yaw_rad;
        [
            inverted(pose.x_m * k, pose.x_m, |v| v / k),
            inverted(pose.y_m * k, pose.y_m, |v| v / k),
            inverted(heading, pose.yaw_rad, wrapped),
        ]
    }
}

/// The number near `guess` that reads back as exactly `wanted`, if there is one; else `guess`.
///
/// The roundest number that does is taken, so that 117 mm stay 117 and do not become 116.99999999999999.
fn inverted(guess: f64, wanted: f64, read: impl Fn(f64) -> f64) -> f64 {
    let round = |unit: f64| (guess * unit).round() / unit;
    let neighbours = [
        round(1.0),
        round(1e3),
        round(1e6),
        round(1e9),
        guess,
        guess.next_up(),
        guess.next_down(),
        guess.next_up().next_up(),
        guess.next_down().next_down(),
    ];
    let exact = |v: &f64| read(*v).to_bits() == wanted.to_bits();
    neighbours.into_iter().find(exact).unwrap_or(guess)
}

/// A recording of a ring as a MAT file of level 5: `saved_readings` (mm) and `saved_pose` (mm, mm, deg). Rows
/// lose their stamps; `None` odometry is written as NaN, and nothing that came back as infinity.
pub fn write_mat(recording: &Recording) -> Vec<u8> {
    let rows: Vec<Vec<f64>> =
        all_columns(recording).map(|row| row.map(|r| MAT_UNITS.reading(r)).collect()).collect();
    let poses: Vec<Vec<f64>> = recording
        .scans
        .iter()
        .map(|s| s.odom_from_base.map_or([f64::NAN; 3], |p| MAT_UNITS.numbers(p)).to_vec())
        .collect();
    mat::write(&[matrix(READINGS, &rows), matrix(POSES, &poses)])
}

/// A recording of a ring as ARTEMIC's two texts: `saved_readings` (whole cm) and `saved_pose` (m, m, rad, six
/// decimals). Rows lose their stamps; missing odometry is written as zeros, nothing that came back as the
/// ring's limit.
pub fn write_artemic_text(recording: &Recording) -> (String, String) {
    let limit = recording.rig.range_max_m();
    let mut readings = String::new();
    for row in all_columns(recording) {
        let words: Vec<String> = row
            .map(|r| format!("{:.0}", (r.min(limit) * ARTEMIC_UNITS.readings_per_m).round()))
            .collect();
        readings.push_str(&words.join(" | "));
        readings.push_str(" \n");
    }
    let mut poses = String::new();
    for scan in &recording.scans {
        let pose = scan.odom_from_base.unwrap_or(Se2::IDENTITY);
        // Writing to a string does not fail.
        let _written = writeln!(poses, "{:.6} {:.6} {:.6} ", pose.x_m, pose.y_m, pose.yaw_rad);
    }
    (readings, poses)
}

fn all_columns(recording: &Recording) -> impl Iterator<Item = impl Iterator<Item = f64> + '_> + '_ {
    let extra = |index: usize| recording.extra_columns_m.get(index).into_iter().flatten();
    let scans = recording.scans.iter().enumerate();
    scans.map(move |(index, scan)| scan.ranges_m.iter().chain(extra(index)).copied())
}

fn matrix(name: &str, rows: &[Vec<f64>]) -> Matrix {
    let n_columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let cell = |row: &Vec<f64>, column: usize| row.get(column).copied().unwrap_or(f64::NAN);
    let values = (0..n_columns).flat_map(|c| rows.iter().map(move |row| cell(row, c)));
    Matrix {
        name: name.to_owned(),
        dimensions: vec![rows.len(), n_columns],
        class: Class::Double,
        values: values.collect(),
    }
}

/// Reads a MAT file.
pub(crate) fn read_mat(
    name: &str,
    content: &[u8],
    options: &ReadOptions<'_>,
    complaints: &mut Complaints,
) -> Result<RawRecording, RecordingError> {
    let named = |problem: String| RecordingError::Unsupported { name: name.to_owned(), problem };
    let file = MatFile::parse(content, options.bytes_max).map_err(|e| named(e.to_string()))?;
    let missing = |what: &str| {
        let contains = format!("no matrix {what}: {}", file.contents());
        no_scans(name, Format::Mat, &contains, complaints)
    };
    let readings = file.matrix(READINGS).ok_or_else(|| missing(READINGS))?;
    let poses = file.matrix(POSES).ok_or_else(|| missing(POSES))?;
    if poses.n_columns() != 3 {
        let found =
            format!("{POSES} has {} columns; x, y and heading are needed", poses.n_columns());
        return Err(named(found));
    }
    for part in &file.unread {
        let at = Place::Byte(part.byte);
        complaints.add(at, Trouble::NotSupported, Action::Skipped, || part.what.clone());
    }
    let rows = readings.n_rows().min(poses.n_rows());
    if readings.n_rows() != poses.n_rows() {
        let (r, p) = (readings.n_rows(), poses.n_rows());
        let text = || format!("{r} rows of readings and {p} poses; the first {rows} are used");
        complaints.add(Place::Row(rows + 1), Trouble::EndsEarly, Action::Skipped, text);
    }
    afford(name, scans_bytes(rows, readings.n_columns()), options.memory_max_bytes)?;
    let ring = rig(name, readings.n_columns(), Ring::Listing8, options)?;
    let clock = Clock::new(options.period_s.unwrap_or(MAT_PERIOD_S));
    let mut scans = Vec::new();
    for row in 0..rows {
        let place = Place::Row(row + 1);
        let pose = [poses.at(row, 0), poses.at(row, 1), poses.at(row, 2)];
        let values: Vec<f64> = readings.row(row).collect();
        let line = Row { place, stamp_ns: clock.stamp_ns(row), pose, values };
        scans.extend(line.scan(MAT_UNITS, &ring, complaints));
    }
    Ok(RawRecording::new(Rig::Ring(ring), scans))
}

/// Reads ARTEMIC's two texts.
pub(crate) fn read_artemic(
    name: &str,
    content: &[u8],
    options: &ReadOptions<'_>,
    complaints: &mut Complaints,
) -> Result<RawRecording, RecordingError> {
    let readings = table(content, Place::Line, complaints);
    let second = second_file(name, options)?;
    let poses = table(second, Place::SecondFileLine, complaints);
    let n_columns = usual_width(&readings);
    if n_columns == 0 {
        return Err(no_scans(name, Format::ArtemicText, &first_words(content), complaints));
    }
    let ring = rig(name, n_columns, Ring::Artemic5, options)?;
    let clock = Clock::new(options.period_s.unwrap_or(ARTEMIC_PERIOD_S));
    say_uneven(&readings, &poses, complaints);
    let mut scans = Vec::new();
    for (index, (line, pose)) in readings.into_iter().zip(poses).enumerate() {
        let Some(values) = line.of_width(n_columns, complaints) else { continue };
        let Some(pose) = pose.of_width(3, complaints) else { continue };
        let pose = [pose[0], pose[1], pose[2]];
        let row = Row { place: line.place, stamp_ns: clock.stamp_ns(index), pose, values };
        scans.extend(row.scan(ARTEMIC_UNITS, &ring, complaints));
    }
    Ok(RawRecording::new(Rig::Ring(ring), scans))
}

/// Reads a sonar text with its poses.
pub(crate) fn read_sonar_text(
    name: &str,
    content: &[u8],
    options: &ReadOptions<'_>,
    complaints: &mut Complaints,
) -> Result<RawRecording, RecordingError> {
    let readings = table(content, Place::Line, complaints);
    let second = second_file(name, options)?;
    let mut poses: BTreeMap<u64, [f64; 3]> = BTreeMap::new();
    for line in table(second, Place::SecondFileLine, complaints) {
        let Some(values) = line.of_width(4, complaints) else { continue };
        if values.iter().any(|v| !v.is_finite()) {
            let text = || "a pose that is NaN or infinite".to_owned();
            complaints.add(line.place, Trouble::NotFinite, Action::Skipped, text);
            continue;
        }
        poses.insert(values[0].to_bits(), [values[1], values[2], values[3]]);
    }
    let width = usual_width(&readings);
    if width < 2 {
        return Err(no_scans(name, Format::SonarText, &first_words(content), complaints));
    }
    let ring = rig(name, width - 1, Ring::Course8, options)?;
    let mut scans = Vec::new();
    for line in readings {
        let Some(mut values) = line.of_width(width, complaints) else { continue };
        let stamp = values.remove(0);
        let Some(stamp_ns) = nanos_from_ms(stamp) else {
            let text = || format!("the stamp is {stamp}");
            complaints.add(line.place, Trouble::NotFinite, Action::Skipped, text);
            continue;
        };
        let Some(&pose) = poses.get(&stamp.to_bits()) else {
            let text = || format!("no pose of stamp {stamp} ms in the second file");
            complaints.add(line.place, Trouble::OdometryUnusable, Action::Skipped, text);
            continue;
        };
        let row = Row { place: line.place, stamp_ns, pose, values };
        scans.extend(row.scan(TEXT_UNITS, &ring, complaints));
    }
    Ok(RawRecording::new(Rig::Ring(ring), scans))
}

/// Whether a line could be ARTEMIC's readings: numbers between bars.
pub(crate) fn is_artemic_line(line: &str) -> bool {
    line.contains('|')
        && line.split('|').all(|w| w.trim().is_empty() || w.trim().parse::<f64>().is_ok())
}

/// Whether a line could be of a sonar text: a stamp and at least two readings, all of them whole numbers.
pub(crate) fn is_sonar_line(line: &str) -> bool {
    let words = line.split_ascii_whitespace();
    words.clone().count() >= 3 && words.into_iter().all(|w| w.parse::<u64>().is_ok())
}

/// The ring of the options or the format, with the range of the options.
fn rig(
    name: &str,
    n_columns: usize,
    default: Ring,
    options: &ReadOptions<'_>,
) -> Result<RingRig, RecordingError> {
    let (mut rig, ring) = options.ring.or(default);
    let mounts = rig.base_from_sensors.len();
    if mounts > n_columns {
        let name = name.to_owned();
        return Err(RecordingError::RingTooLarge { name, columns: n_columns, ring, mounts });
    }
    rig.range_max_m = options.range_max_m.unwrap_or(rig.range_max_m);
    Ok(rig)
}

/// Rows at equal distances of time.
struct Clock {
    period_ns: i64,
}

impl Clock {
    fn new(period_s: f64) -> Self {
        // At least a nanosecond: the options allow any period above zero.
        Self { period_ns: ((period_s * 1e9).round() as i64).max(1) }
    }

    fn stamp_ns(&self, row: usize) -> i64 {
        i64::try_from(row).unwrap_or(i64::MAX).saturating_mul(self.period_ns)
    }
}

fn nanos_from_ms(stamp_ms: f64) -> Option<i64> {
    let nanos = (stamp_ms * 1e6).round();
    (nanos.abs() < 9.2e18).then_some(nanos as i64)
}

/// Readings and pose of one moment, in the format's units.
struct Row {
    place: Place,
    stamp_ns: i64,
    pose: [f64; 3],
    values: Vec<f64>,
}

impl Row {
    fn scan(self, units: Units, ring: &RingRig, complaints: &mut Complaints) -> Option<RawScan> {
        if !self.pose.iter().all(|v| is_measurable(*v)) {
            let [x, y, heading] = self.pose;
            let text = || format!("the pose is ({x}, {y}, {heading})");
            complaints.add(self.place, Trouble::NotFinite, Action::Skipped, text);
            return None;
        }
        let mut ranges_m = self.values;
        let mut n_bad = 0;
        for value in &mut ranges_m {
            let is_bad = value.is_nan() || *value < 0.0;
            n_bad += usize::from(is_bad);
            *value = if is_bad { f64::INFINITY } else { units.range_m(*value) };
        }
        if 2 * n_bad > ranges_m.len() {
            let text = || format!("{n_bad} of {} readings are no distances", ranges_m.len());
            complaints.add(self.place, Trouble::NotFinite, Action::Skipped, text);
            return None;
        }
        if n_bad > 0 {
            let text = || format!("{n_bad} readings are no distances; taken as nothing came back");
            complaints.add(self.place, Trouble::NotFinite, Action::Repaired, text);
        }
        let extra_m = ranges_m.split_off(ring.base_from_sensors.len().min(ranges_m.len()));
        let odom = Some(units.pose(self.pose));
        let (place, stamp_ns) = (self.place, self.stamp_ns);
        Some(RawScan { place, stamp_ns, odom, ranges_m, extra_m, ..RawScan::default() })
    }
}

/// A line of a table: its numbers, or nothing if it could not be read (then that is complained about already).
struct Line {
    place: Place,
    values: Option<Vec<f64>>,
}

impl Line {
    /// The numbers, if they are so many.
    fn of_width(&self, n: usize, complaints: &mut Complaints) -> Option<Vec<f64>> {
        let values = self.values.as_ref()?;
        if values.len() == n {
            return Some(values.clone());
        }
        let found = values.len();
        let trouble = if found < n { Trouble::Truncated } else { Trouble::BeamCount };
        complaints.add(self.place, trouble, Action::Skipped, || {
            format!("{found} numbers where {n} are needed")
        });
        None
    }
}

/// All lines that are not empty and no remarks (`#`, `%`); numbers are separated by blanks or bars.
fn table(content: &[u8], place: fn(usize) -> Place, complaints: &mut Complaints) -> Vec<Line> {
    let mut table = Vec::new();
    for (number, line) in lines(content) {
        let place = place(number);
        let values = text(line).and_then(numbers);
        match values {
            Ok(None) => {}
            Ok(values) => table.push(Line { place, values }),
            Err(fault) => {
                complaints.add(place, fault.trouble, Action::Skipped, || fault.found);
                table.push(Line { place, values: None });
            }
        }
    }
    table
}

fn numbers(line: &str) -> Result<Option<Vec<f64>>, Fault> {
    if line.trim().is_empty() || line.trim_start().starts_with(['#', '%']) {
        return Ok(None);
    }
    let line = line.replace('|', " ");
    let mut fields = Fields::new(&line);
    let mut values = Vec::new();
    for _ in 0..line.split_ascii_whitespace().count() {
        values.push(fields.any_number("a number")?);
    }
    Ok(Some(values))
}

/// How many numbers most lines have; the smaller of equally frequent counts; 0 without any.
fn usual_width(table: &[Line]) -> usize {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for values in table.iter().filter_map(|l| l.values.as_ref()) {
        *counts.entry(values.len()).or_insert(0) += 1;
    }
    let most = counts.values().copied().max().unwrap_or(0);
    counts.iter().find(|(_, n)| **n == most).map_or(0, |(width, _)| *width)
}

fn second_file<'a>(name: &str, options: &ReadOptions<'a>) -> Result<&'a [u8], RecordingError> {
    let what = "the poses";
    options.poses.ok_or_else(|| RecordingError::SecondFileMissing { name: name.to_owned(), what })
}

fn say_uneven(readings: &[Line], poses: &[Line], complaints: &mut Complaints) {
    let (r, p) = (readings.len(), poses.len());
    if r == p {
        return;
    }
    let rows = r.min(p);
    let text = || format!("{r} lines of readings and {p} poses; the first {rows} are used");
    let longer = if r > p { readings } else { poses };
    let place = longer.get(rows).map_or(Place::File, |line| line.place);
    complaints.add(place, Trouble::EndsEarly, Action::Skipped, text);
}

#[cfg(test)]
#[path = "sonar_files_tests.rs"]
pub(crate) mod tests;
