//! Laser scans as text: a line for each scan, with its time in seconds, its ranges in metres and as many flags that say
//! which of them are valid.
//!
//! Lines that begin with `%` are remarks. Nothing is said about the laser: the beams are taken to cover 180°,
//! from the right to the left, and the laser to sit 0.20 m ahead of the robot's centre. There is no odometry. A range whose flag is 0 means that nothing came back,
//! and so does one of 80 m or more, the reach of the simulated scanner. True poses come in a file of
//! their own (`t x y yaw`), as an option.
//!
//! Source: sample data of MRPT (BSD-3), `*_LASER_SIM.txt` and `*.GT.txt`.

use std::f64::consts::PI;

use geometry::Se2;

use crate::{
    Format, ReadOptions, RecordingError,
    carmen::{laser_range, spread},
    complaints::{Action, Complaints, Place, Trouble},
    contents::{first_words, no_scans},
    numbers::{Fault, Fields, lines, text},
    raw::{RawRecording, RawScan, usual_count},
    recording::{LaserRig, Rig},
};

/// Readings from here on mean that nothing came back, metres.
const RANGE_MAX_M: f64 = 80.0;
/// Where MRPT's simulated scanner sits, metres ahead of the robot's centre: the files do not say it, and with it
/// the scans of one wall, laid out at the true poses, fall on one line.
const MOUNTED_AHEAD_M: f64 = 0.20;
/// A line with fewer fields is none of ours: time, and ten ranges with flags.
const FIELDS_MIN: usize = 21;

/// Whether a line is a scan: an odd number of numbers, the second half of them 0 or 1.
fn is_scan(line: &str) -> bool {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let n = words.len() / 2;
    words.len() >= FIELDS_MIN
        && words.len() % 2 == 1
        && words[..=n].iter().all(|w| w.parse::<f64>().is_ok())
        && words[n + 1..].iter().all(|w| matches!(*w, "0" | "1"))
}

/// Whether such a text begins so: with a remark or a scan.
pub(crate) fn is_beginning(line: &str) -> bool {
    line.trim_ascii_start().starts_with('%') || is_scan(line)
}

pub(crate) fn read(
    name: &str,
    content: &[u8],
    options: &ReadOptions<'_>,
    complaints: &mut Complaints,
) -> Result<RawRecording, RecordingError> {
    let range_max_m = options.range_max_m.unwrap_or(RANGE_MAX_M);
    let mut scans = Vec::new();
    for (number, line) in lines(content) {
        let place = Place::Line(number);
        let outcome = text(line).and_then(|line| {
            if line.trim().is_empty() || line.trim_start().starts_with(['%', '#']) {
                return Ok(());
            }
            let (scan, n_bad) = scan_line(place, line, range_max_m)?;
            if n_bad > 0 {
                let text =
                    || format!("{n_bad} readings are no distances; taken as nothing came back");
                complaints.add(place, Trouble::NotFinite, Action::Repaired, text);
            }
            scans.push(scan);
            Ok(())
        });
        if let Err(fault) = outcome {
            complaints.add(place, fault.trouble, Action::Skipped, || fault.found);
        }
    }
    if scans.is_empty() {
        return Err(no_scans(name, Format::MrptLaser, &first_words(content), complaints));
    }
    let n_beams = usual_count(&scans);
    let (first_beam_rad, beam_spacing_rad) =
        spread(n_beams, options.field_of_view_rad.unwrap_or(PI));
    let base_from_sensor = options.base_from_sensor.unwrap_or(Se2::new(MOUNTED_AHEAD_M, 0.0, 0.0));
    let laser =
        LaserRig { base_from_sensor, first_beam_rad, beam_spacing_rad, n_beams, range_max_m };
    Ok(RawRecording::new(Rig::Laser(laser), scans))
}

fn scan_line(place: Place, line: &str, range_max_m: f64) -> Result<(RawScan, usize), Fault> {
    let n_fields = line.split_ascii_whitespace().count();
    if n_fields < FIELDS_MIN || n_fields.is_multiple_of(2) {
        let found = format!("{n_fields} fields: not a time, ranges, and as many flags");
        return Err(Fault::new(Trouble::Truncated, found));
    }
    let n = n_fields / 2;
    let mut fields = Fields::new(line);
    let stamp_ns = fields.seconds_ns("the time")?;
    let mut ranges_m = Vec::with_capacity(n);
    let mut n_bad = 0;
    for _ in 0..n {
        let (range_m, is_bad) = laser_range(fields.any_number("a range")?, range_max_m);
        n_bad += usize::from(is_bad);
        ranges_m.push(range_m);
    }
    for range in &mut ranges_m {
        match fields.word("a flag")? {
            "1" => {}
            "0" => *range = f64::INFINITY,
            other => {
                let found =
                    format!("the flag {:?} is neither 0 nor 1", crate::numbers::shown(other));
                return Err(Fault::new(Trouble::Truncated, found));
            }
        }
    }
    if 2 * n_bad > n {
        let found = format!("{n_bad} of {n} readings are no distances");
        return Err(Fault::new(Trouble::NotFinite, found));
    }
    Ok((RawScan { place, stamp_ns, ranges_m, ..RawScan::default() }, n_bad))
}

#[cfg(test)]
#[path = "mrpt_tests.rs"]
pub(crate) mod tests;
