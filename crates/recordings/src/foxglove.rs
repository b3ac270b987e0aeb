//! Messages with the public Foxglove schemas, in JSON: what viewers of MCAP files draw by themselves.
//!
//! | schema | message |
//! | --- | --- |
//! | `foxglove.FrameTransforms` | [`FrameTransforms`] |
//! | `foxglove.PoseInFrame`, `foxglove.PosesInFrame` | [`PoseInFrame`], [`PosesInFrame`] |
//! | `foxglove.LaserScan` | [`LaserScan`] |
//! | `foxglove.SceneUpdate` | [`SceneUpdate`] |
//! | `foxglove.Log` | [`Log`] |
//!
//! A viewer knows a schema by its name; its text ([`schema_text`]) says the fields to everybody else. Lengths are
//! metres, angles radians, z is 0 unless said; places are rounded to a tenth of a millimetre and directions to a
//! microradian, because digits take room. JSON has no infinity: what saw nothing is `null`.
//!
//! Source: names and fields of the schemas, <https://docs.foxglove.dev/docs/sdk/schemas> (read as of foxglove-sdk,
//! `schemas/jsonschema`, 2026-11); JSON in MCAP, <https://mcap.dev/spec/registry> (message encoding `json`, schema
//! encoding `jsonschema`).

use geometry::{Se2, Vec2};
use run_context::Stamp;
use serde::Serialize;
use serde_json::{Map, Value, json};

/// Encoding of messages in a channel.
pub const MESSAGE_ENCODING: &str = "json";
/// Encoding of schemas.
pub const SCHEMA_ENCODING: &str = "jsonschema";

/// What a field holds.
#[derive(Clone, Copy)]
enum Kind {
    Number,
    Integer,
    Text,
    Flag,
    Numbers,
    Integers,
    /// A list that is always empty here: shapes that are not drawn.
    Unused,
    One(&'static str),
    Many(&'static str),
}

use Kind::{Flag, Integer, Integers, Many, Number, Numbers, One, Text, Unused};

type Fields = &'static [(&'static str, Kind)];

/// The types that are written here, each with all of its fields.
const TYPES: [(&str, Fields); 18] = [
    ("time", &[("sec", Integer), ("nsec", Integer)]),
    ("Vector3", &[("x", Number), ("y", Number), ("z", Number)]),
    ("Point3", &[("x", Number), ("y", Number), ("z", Number)]),
    ("Quaternion", &[("x", Number), ("y", Number), ("z", Number), ("w", Number)]),
    ("Color", &[("r", Number), ("g", Number), ("b", Number), ("a", Number)]),
    ("Pose", &[("position", One("Vector3")), ("orientation", One("Quaternion"))]),
    (
        "FrameTransform",
        &[
            ("timestamp", One("time")),
            ("parent_frame_id", Text),
            ("child_frame_id", Text),
            ("translation", One("Vector3")),
            ("rotation", One("Quaternion")),
        ],
    ),
    ("FrameTransforms", &[("transforms", Many("FrameTransform"))]),
    ("PoseInFrame", &[("timestamp", One("time")), ("frame_id", Text), ("pose", One("Pose"))]),
    ("PosesInFrame", &[("timestamp", One("time")), ("frame_id", Text), ("poses", Many("Pose"))]),
    (
        "LaserScan",
        &[
            ("timestamp", One("time")),
            ("frame_id", Text),
            ("pose", One("Pose")),
            ("start_angle", Number),
            ("end_angle", Number),
            ("ranges", Numbers),
            ("intensities", Numbers),
        ],
    ),
    (
        "Log",
        &[
            ("timestamp", One("time")),
            ("level", Integer),
            ("message", Text),
            ("name", Text),
            ("file", Text),
            ("line", Integer),
        ],
    ),
    ("SceneEntityDeletion", &[("timestamp", One("time")), ("type", Integer), ("id", Text)]),
    (
        "LinePrimitive",
        &[
            ("type", Integer),
            ("pose", One("Pose")),
            ("thickness", Number),
            ("scale_invariant", Flag),
            ("points", Many("Point3")),
            ("color", One("Color")),
            ("colors", Many("Color")),
            ("indices", Integers),
        ],
    ),
    (
        "CylinderPrimitive",
        &[
            ("pose", One("Pose")),
            ("size", One("Vector3")),
            ("bottom_scale", Number),
            ("top_scale", Number),
            ("color", One("Color")),
        ],
    ),
    (
        "TextPrimitive",
        &[
            ("pose", One("Pose")),
            ("billboard", Flag),
            ("font_size", Number),
            ("scale_invariant", Flag),
            ("color", One("Color")),
            ("text", Text),
        ],
    ),
    (
        "SceneEntity",
        &[
            ("timestamp", One("time")),
            ("frame_id", Text),
            ("id", Text),
            ("lifetime", One("time")),
            ("frame_locked", Flag),
            ("metadata", Unused),
            ("arrows", Unused),
            ("cubes", Unused),
            ("spheres", Unused),
            ("cylinders", Many("CylinderPrimitive")),
            ("lines", Many("LinePrimitive")),
            ("triangles", Unused),
            ("texts", Many("TextPrimitive")),
            ("models", Unused),
        ],
    ),
    (
        "SceneUpdate",
        &[("deletions", Many("SceneEntityDeletion")), ("entities", Many("SceneEntity"))],
    ),
];

/// The JSON schema of a type, such as `PoseInFrame`, with those that it is made of; `None` for one that is not
/// written here.
///
/// ```
/// let text = recordings::foxglove::schema_text("PoseInFrame").unwrap();
/// assert!(text.contains("\"title\":\"foxglove.PoseInFrame\""));
/// ```
pub fn schema_text(name: &str) -> Option<String> {
    schema(name).map(|schema| schema.to_string())
}

/// The types are a list without circles, so this ends.
fn schema(name: &str) -> Option<Value> {
    let (_, fields) = TYPES.iter().find(|(known, _)| *known == name)?;
    let mut properties = Map::new();
    for (field, kind) in *fields {
        let of = |item: Value| json!({"type": "array", "items": item});
        let value = match *kind {
            Number => json!({"type": "number"}),
            Integer => json!({"type": "integer"}),
            Text => json!({"type": "string"}),
            Flag => json!({"type": "boolean"}),
            // A beam that saw nothing has no number.
            Numbers => of(json!({"type": ["number", "null"]})),
            Integers => of(json!({"type": "integer"})),
            Unused => json!({"type": "array"}),
            One(name) => schema(name)?,
            Many(name) => of(schema(name)?),
        };
        properties.insert((*field).to_owned(), value);
    }
    let title = if name == "time" { name.to_owned() } else { schema_name(name) };
    Some(json!({"title": title, "type": "object", "properties": properties}))
}

/// The name under which viewers know a type.
pub fn schema_name(name: &str) -> String {
    format!("foxglove.{name}")
}

/// A moment, or a duration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Time {
    /// Whole seconds.
    pub sec: u64,
    /// And nanoseconds.
    pub nsec: u32,
}

/// A place or a direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Vector3 {
    /// x, m.
    #[serde(rename = "x")]
    pub x_m: f64,
    /// y, m.
    #[serde(rename = "y")]
    pub y_m: f64,
    /// z, m.
    #[serde(rename = "z")]
    pub z_m: f64,
}

/// A rotation; here always about z. x and y are 0, z and w the sine and cosine of half the yaw.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

/// A place with its heading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pose {
    /// Where.
    pub position: Vector3,
    /// Which way.
    pub orientation: Quaternion,
}

/// A colour.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Color {
    r: f64,
    g: f64,
    b: f64,
    a: f64,
}

/// Where one frame lies in another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameTransform {
    /// When.
    pub timestamp: Time,
    /// In which frame.
    pub parent_frame_id: String,
    /// Which frame.
    pub child_frame_id: String,
    /// Its origin.
    pub translation: Vector3,
    /// Its axes.
    pub rotation: Quaternion,
}

/// Where frames lie.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameTransforms {
    /// One for each frame.
    pub transforms: Vec<FrameTransform>,
}

/// A pose and the frame that it is given in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PoseInFrame {
    /// When.
    pub timestamp: Time,
    /// In which frame.
    pub frame_id: String,
    /// Where.
    pub pose: Pose,
}

/// Poses one after the other, such as a path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PosesInFrame {
    /// When.
    pub timestamp: Time,
    /// In which frame.
    pub frame_id: String,
    /// The poses.
    pub poses: Vec<Pose>,
}

/// A scan of a laser.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LaserScan {
    /// When it was whole.
    pub timestamp: Time,
    /// The frame that the laser is mounted in.
    pub frame_id: String,
    /// Where the laser sits in it; its x axis is the bearing 0.
    pub pose: Pose,
    /// Bearing of the first reading, rad, counter-clockwise.
    #[serde(rename = "start_angle")]
    pub start_angle_rad: f64,
    /// Bearing of the last one, rad.
    #[serde(rename = "end_angle")]
    pub end_angle_rad: f64,
    /// Distances, m; `None` where nothing was seen.
    pub ranges: Vec<Option<f64>>,
    /// How strongly each came back; empty where that is not known.
    pub intensities: Vec<f64>,
}

/// How a log entry is meant.
pub mod level {
    /// News.
    pub const INFO: u8 = 2;
    /// Something to look at.
    pub const WARNING: u8 = 3;
    /// A failure.
    pub const ERROR: u8 = 4;
}

/// An event in words.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Log {
    /// When.
    pub timestamp: Time,
    /// One of [`level`].
    pub level: u8,
    /// What happened.
    pub message: String,
    /// Who says so.
    pub name: String,
    /// Always empty.
    pub file: String,
    /// Always 0.
    pub line: u32,
}

/// Lines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinePrimitive {
    /// 0 through all points, 1 and back to the first, 2 between each two.
    #[serde(rename = "type")]
    pub kind: u8,
    /// Where the points' own frame lies.
    pub pose: Pose,
    /// Pixels, because it does not change with the scale.
    #[serde(rename = "thickness")]
    pub thickness_px: f64,
    /// Always true.
    pub scale_invariant: bool,
    /// Their ends and corners.
    pub points: Vec<Vector3>,
    /// Of all of them.
    pub color: Color,
    /// Always empty: they have one colour.
    pub colors: [Color; 0],
    /// Always empty: points are taken in their order.
    pub indices: [u32; 0],
}

/// A body around an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CylinderPrimitive {
    /// Its middle.
    pub pose: Pose,
    /// Its diameters along x and y, and its height, m.
    pub size: Vector3,
    /// Part of the diameter at its foot.
    #[serde(rename = "bottom_scale")]
    pub bottom_ratio: f64,
    /// Part of the diameter at its head.
    #[serde(rename = "top_scale")]
    pub top_ratio: f64,
    /// Its colour.
    pub color: Color,
}

/// A text that turns to whoever looks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TextPrimitive {
    /// Where.
    pub pose: Pose,
    /// Whether it turns.
    pub billboard: bool,
    /// Height of a line, m.
    #[serde(rename = "font_size")]
    pub font_size_m: f64,
    /// Always false: the text grows with the scale.
    pub scale_invariant: bool,
    /// Its colour.
    pub color: Color,
    /// What it says.
    pub text: String,
}

/// A thing in a scene; one of the same name replaces it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneEntity {
    /// When.
    pub timestamp: Time,
    /// In which frame.
    pub frame_id: String,
    /// Its name.
    pub id: String,
    /// How long it stays; 0: until it is replaced or deleted.
    pub lifetime: Time,
    /// Whether it moves with its frame.
    pub frame_locked: bool,
    /// Always empty.
    pub metadata: [(); 0],
    /// Always empty.
    pub arrows: [(); 0],
    /// Always empty.
    pub cubes: [(); 0],
    /// Always empty.
    pub spheres: [(); 0],
    /// Bodies.
    pub cylinders: Vec<CylinderPrimitive>,
    /// Lines.
    pub lines: Vec<LinePrimitive>,
    /// Always empty.
    pub triangles: [(); 0],
    /// Texts.
    pub texts: Vec<TextPrimitive>,
    /// Always empty.
    pub models: [(); 0],
}

/// What goes from a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneEntityDeletion {
    /// When.
    pub timestamp: Time,
    /// 0 the one of that name, 1 all.
    #[serde(rename = "type")]
    pub kind: u8,
    /// Its name.
    pub id: String,
}

/// What comes into a scene or changes there, and what goes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SceneUpdate {
    /// What goes.
    pub deletions: Vec<SceneEntityDeletion>,
    /// What is there.
    pub entities: Vec<SceneEntity>,
}

impl From<Stamp> for Time {
    fn from(stamp: Stamp) -> Self {
        let nanos = stamp.as_nanos();
        Self { sec: nanos / 1_000_000_000, nsec: (nanos % 1_000_000_000) as u32 }
    }
}

impl From<Vec2> for Vector3 {
    fn from(at: Vec2) -> Self {
        Self { x_m: rounded(at.x, 1e4), y_m: rounded(at.y, 1e4), z_m: 0.0 }
    }
}

/// The nearest of the multiples of which there are so many in one.
fn rounded(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}

impl Color {
    /// Red, green, blue and opacity, each from 0 to 1.
    pub const fn of([r, g, b, a]: [f64; 4]) -> Self {
        Self { r, g, b, a }
    }
}

impl Quaternion {
    /// A yaw (rad).
    pub fn of_yaw(yaw_rad: f64) -> Self {
        let (z, w) = (0.5 * yaw_rad).sin_cos();
        Self { x: 0.0, y: 0.0, z: rounded(z, 1e6), w: rounded(w, 1e6) }
    }
}

impl From<Se2> for Pose {
    fn from(pose: Se2) -> Self {
        Self { position: pose.position().into(), orientation: Quaternion::of_yaw(pose.yaw_rad) }
    }
}

impl FrameTransform {
    /// The frame `child` at a pose of the frame `parent`.
    pub fn new(stamp: Stamp, parent: &str, child: &str, parent_from_child: Se2) -> Self {
        Self {
            timestamp: stamp.into(),
            parent_frame_id: parent.to_owned(),
            child_frame_id: child.to_owned(),
            translation: parent_from_child.position().into(),
            rotation: Quaternion::of_yaw(parent_from_child.yaw_rad),
        }
    }
}

impl LinePrimitive {
    /// Lines of one colour, `kind` as in the type, with a thickness in pixels.
    pub fn new(kind: u8, points: Vec<Vector3>, thickness_px: f64, color: Color) -> Self {
        Self {
            kind,
            pose: Se2::IDENTITY.into(),
            thickness_px,
            scale_invariant: true,
            points,
            color,
            colors: [],
            indices: [],
        }
    }
}

impl SceneEntity {
    /// A thing without shape yet, which stays until it is replaced.
    pub fn new(stamp: Stamp, frame: &str, id: &str) -> Self {
        Self {
            timestamp: stamp.into(),
            frame_id: frame.to_owned(),
            id: id.to_owned(),
            lifetime: Time::default(),
            frame_locked: true,
            metadata: [],
            arrows: [],
            cubes: [],
            spheres: [],
            cylinders: Vec::new(),
            lines: Vec::new(),
            triangles: [],
            texts: Vec::new(),
            models: [],
        }
    }
}

impl LaserScan {
    /// A scan of a rig, whose readings are infinite where nothing was seen; `frame` is the robot's.
    pub fn new(stamp: Stamp, frame: &str, rig: &crate::LaserRig, ranges_m: &[f64]) -> Self {
        let last = rig.n_beams.saturating_sub(1);
        Self {
            timestamp: stamp.into(),
            frame_id: frame.to_owned(),
            pose: rig.base_from_sensor.into(),
            start_angle_rad: rig.bearing_rad(0),
            end_angle_rad: rig.bearing_rad(last),
            ranges: ranges_m
                .iter()
                .map(|range| range.is_finite().then(|| rounded(*range, 1e4)))
                .collect(),
            intensities: Vec::new(),
        }
    }
}

#[cfg(test)]
#[path = "foxglove_tests.rs"]
mod tests;
