//! The messages against the schemas, and the schemas against the public ones.

use super::*;

/// The public fields of each schema, read from foxglove-sdk's `schemas/jsonschema` on 2026-11-30: every field that is
/// written must be one of them. `o` object, `a` array, `n` number, `i` integer or choice, `s` text, `b` truth.
const PUBLIC: [(&str, &str); 17] = [
    ("Vector3", "x:n y:n z:n"),
    ("Point3", "x:n y:n z:n"),
    ("Quaternion", "x:n y:n z:n w:n"),
    ("Color", "r:n g:n b:n a:n"),
    ("Pose", "position:o orientation:o"),
    ("FrameTransform", "timestamp:o parent_frame_id:s child_frame_id:s translation:o rotation:o"),
    ("FrameTransforms", "transforms:a"),
    ("PoseInFrame", "timestamp:o frame_id:s pose:o"),
    ("PosesInFrame", "timestamp:o frame_id:s poses:a"),
    ("LaserScan", "timestamp:o frame_id:s pose:o start_angle:n end_angle:n ranges:a intensities:a"),
    ("Log", "timestamp:o level:i message:s name:s file:s line:i"),
    ("SceneEntityDeletion", "timestamp:o type:i id:s"),
    (
        "LinePrimitive",
        "type:i pose:o thickness:n scale_invariant:b points:a color:o colors:a indices:a",
    ),
    ("CylinderPrimitive", "pose:o size:o bottom_scale:n top_scale:n color:o"),
    ("TextPrimitive", "pose:o billboard:b font_size:n scale_invariant:b color:o text:s"),
    (
        "SceneEntity",
        "timestamp:o frame_id:s id:s lifetime:o frame_locked:b metadata:a arrows:a cubes:a \
         spheres:a cylinders:a lines:a triangles:a texts:a models:a",
    ),
    ("SceneUpdate", "deletions:a entities:a"),
];

#[test]
fn every_field_is_a_public_one() {
    for (name, fields) in TYPES.iter().filter(|(name, _)| *name != "time") {
        let (_, public) = PUBLIC.iter().find(|(known, _)| known == name).unwrap();
        let public: Vec<_> = public.split(' ').filter_map(|field| field.split_once(':')).collect();
        for (field, kind) in *fields {
            let kind = match kind {
                Number => "n",
                Integer => "i",
                Text => "s",
                Flag => "b",
                One(_) => "o",
                Numbers | Integers | Unused | Many(_) => "a",
            };
            assert!(public.contains(&(field, kind)), "{name}.{field}: {kind}");
        }
        assert_eq!(
            public.len(),
            fields.len(),
            "{name}: the public schema asks for all of its fields"
        );
    }
}

/// Whether a value has exactly the fields of its type, and they hold what they must.
fn check(name: &str, value: &Value, way: &str) {
    let (_, fields) = TYPES.iter().find(|(known, _)| *known == name).unwrap();
    let object = value.as_object().unwrap_or_else(|| panic!("{way}: {value}"));
    assert_eq!(object.len(), fields.len(), "{way}: {value}");
    for (field, kind) in *fields {
        let (way, value) = (format!("{way}.{field}"), &value[field]);
        let items = || value.as_array().unwrap_or_else(|| panic!("{way}: {value}"));
        let fits = match kind {
            Number => value.is_number(),
            Integer => value.is_u64(),
            Text => value.is_string(),
            Flag => value.is_boolean(),
            Numbers => items().iter().all(|v| v.is_number() || v.is_null()),
            Integers => items().iter().all(Value::is_u64),
            Unused => items().is_empty(),
            One(name) => {
                check(name, value, &way);
                true
            }
            Many(name) => {
                for item in items() {
                    check(name, item, &way);
                }
                true
            }
        };
        assert!(fits, "{way}: {value}");
    }
}

fn checked(name: &str, message: &impl Serialize) -> Value {
    // Through text, as a reader would.
    let text = serde_json::to_string(message).unwrap();
    let value = serde_json::from_str(&text).unwrap();
    check(name, &value, name);
    assert!(schema_text(name).is_some());
    value
}

#[test]
fn messages_have_the_fields_of_their_schemas() {
    let stamp = Stamp::from_millis(1_250);
    let pose = Se2::new(1.0, -2.0, std::f64::consts::FRAC_PI_2);
    let timestamp = Time::from(stamp);
    assert_eq!(timestamp, Time { sec: 1, nsec: 250_000_000 });
    let frame_id = "map".to_owned();
    let in_frame = PoseInFrame { timestamp, frame_id: frame_id.clone(), pose: pose.into() };
    let value = checked("PoseInFrame", &in_frame);
    assert_eq!(value["pose"]["position"], json!({"x": 1.0, "y": -2.0, "z": 0.0}));
    // A quarter turn to the left.
    let half = 0.5_f64.sqrt();
    let orientation = &value["pose"]["orientation"];
    assert!((orientation["z"].as_f64().unwrap() - half).abs() < 1e-6);
    assert!((orientation["w"].as_f64().unwrap() - half).abs() < 1e-6);
    checked("PosesInFrame", &PosesInFrame { timestamp, frame_id, poses: vec![pose.into()] });
    let transforms = vec![FrameTransform::new(stamp, "map", "robot", pose)];
    let value = checked("FrameTransforms", &FrameTransforms { transforms });
    assert_eq!(value["transforms"][0]["child_frame_id"], "robot");
    let log = Log {
        timestamp,
        level: level::WARNING,
        message: "a \"word\"".to_owned(),
        name: "cairn".to_owned(),
        file: String::new(),
        line: 0,
    };
    assert_eq!(checked("Log", &log)["message"], "a \"word\"");
}

#[test]
fn scenes_have_the_fields_of_their_schema() {
    let (stamp, grey) = (Stamp::from_millis(10), Color::of([0.5, 0.5, 0.5, 1.0]));
    let place = Vec2::new(1.0, 2.0);
    let mut entity = SceneEntity::new(stamp, "map", "walls");
    entity.lines.push(LinePrimitive::new(2, vec![place.into(), Vector3::default()], 2.0, grey));
    entity.cylinders.push(CylinderPrimitive {
        pose: Se2::IDENTITY.into(),
        size: Vector3 { x_m: 0.5, y_m: 0.5, z_m: 1.7 },
        bottom_ratio: 1.0,
        top_ratio: 1.0,
        color: grey,
    });
    entity.texts.push(TextPrimitive {
        pose: Se2::IDENTITY.into(),
        billboard: true,
        font_size_m: 0.3,
        scale_invariant: false,
        color: grey,
        text: "Hall".to_owned(),
    });
    let gone = SceneEntityDeletion { timestamp: stamp.into(), kind: 0, id: "box".to_owned() };
    let update = SceneUpdate { deletions: vec![gone], entities: vec![entity] };
    let value = checked("SceneUpdate", &update);
    assert_eq!(value["entities"][0]["lines"][0]["type"], 2);
}

#[test]
fn a_beam_that_saw_nothing_is_null() {
    let rig = crate::LaserRig {
        base_from_sensor: Se2::new(0.2, 0.0, 0.0),
        first_beam_rad: -1.0,
        beam_spacing_rad: 0.5,
        n_beams: 3,
        range_max_m: 8.0,
    };
    let scan = LaserScan::new(Stamp::ZERO, "robot", &rig, &[1.5, f64::INFINITY, 2.0]);
    let value = checked("LaserScan", &scan);
    assert_eq!(value["ranges"], json!([1.5, null, 2.0]));
    assert_eq!((scan.start_angle_rad, scan.end_angle_rad), (-1.0, 0.0));
}

#[test]
fn a_schema_says_all_of_its_fields() {
    for (name, _) in TYPES {
        let text = schema_text(name).unwrap();
        let value: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(value["type"], "object");
    }
    assert_eq!(schema_text("PointCloud"), None);
    let text = schema_text("PosesInFrame").unwrap();
    assert!(text.contains("\"poses\":{\"items\":{\"properties\":{\"orientation\""), "{text}");
}
