//! The writer.

use std::fmt::{self, Display};

use geometry::{Aabb, Vec2};

use super::{CairnObject, MapFile};

impl Display for MapFile {
    /// The file's text: what [`parse`](super::parse) reads back as the same map, except that
    /// lengths are rounded to a nanometre and warnings are gone.
    ///
    /// Extents and counts are worked out from the content. A part without entries is left out, and
    /// quotation marks and line breaks in texts become apostrophes and blanks.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "2D-Map")?;
        if !self.points.is_empty() {
            let extent = Aabb::around(self.points.iter().copied());
            writeln!(f, "MinPos: {}", Mm(extent.min))?;
            writeln!(f, "MaxPos: {}", Mm(extent.max))?;
            writeln!(f, "NumPoints: {}", self.points.len())?;
        }
        if let Some(resolution_m) = self.resolution_m {
            writeln!(f, "Resolution: {}", millimetres(resolution_m))?;
        }
        if !self.lines.is_empty() {
            let extent = Aabb::around(self.lines.iter().flat_map(|line| [line.a, line.b]));
            writeln!(f, "LineMinPos: {}", Mm(extent.min))?;
            writeln!(f, "LineMaxPos: {}", Mm(extent.max))?;
            writeln!(f, "NumLines: {}", self.lines.len())?;
        }
        for (key, value) in &self.info {
            writeln!(f, "{}: {}", plain(key), plain(value))?;
        }
        for thing in &self.things {
            write_cairn(f, thing)?;
        }
        if !self.lines.is_empty() {
            writeln!(f, "LINES")?;
            for line in &self.lines {
                writeln!(f, "{} {}", Mm(line.a), Mm(line.b))?;
            }
        }
        if !self.points.is_empty() {
            writeln!(f, "DATA")?;
            for &point in &self.points {
                writeln!(f, "{}", Mm(point))?;
            }
        }
        Ok(())
    }
}

fn write_cairn(f: &mut fmt::Formatter<'_>, thing: &CairnObject) -> fmt::Result {
    let CairnObject { kind, pose, name, description, icon, area } = thing;
    let (description, name) = (unquoted(description), unquoted(name));
    let th_deg = rounded(pose.yaw_rad.to_degrees(), 1e9);
    write!(
        f,
        "Cairn: {kind} {} {th_deg} \"{description}\" {icon} \"{name}\"",
        Mm(pose.position())
    )?;
    if let Some([a, b]) = area {
        write!(f, " {} {}", Mm(*a), Mm(*b))?;
    }
    writeln!(f)
}

/// A place, written in millimetres.
struct Mm(Vec2);

impl Display for Mm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", millimetres(self.0.x), millimetres(self.0.y))
    }
}

/// Millimetres to a nanometre, so that 0.3 m is written as 300 and not as 300.00000000000006.
fn millimetres(length_m: f64) -> f64 {
    rounded(length_m * 1000.0, 1e6)
}

fn rounded(value: f64, per_unit: f64) -> f64 {
    // Adding zero turns -0 into 0.
    (value * per_unit).round() / per_unit + 0.0
}

fn plain(text: &str) -> String {
    text.replace(['\n', '\r'], " ")
}

fn unquoted(text: &str) -> String {
    plain(text).replace('"', "'")
}
