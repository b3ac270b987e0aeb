//! Files of any kind: what they are, gzip, and damage of every sort.

use std::io::Write as _;

use super::*;
use crate::{
    Ring,
    complaints::{Action, Place, Trouble},
};
use flate2::{Compression, write::GzEncoder};
use proptest::prelude::*;

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// One small file of each format, with its second file.
fn files() -> Vec<(Format, Vec<u8>, Option<Vec<u8>>)> {
    let file = |reader: &Reader| {
        let (bytes, second) = (reader.sample)();
        (reader.format, bytes, second)
    };
    READERS.iter().map(file).collect()
}

#[test]
fn every_format_has_a_reader() {
    let read: Vec<Format> = READERS.iter().map(|reader| reader.format).collect();
    assert!(Format::ALL.iter().all(|format| read.contains(format)), "{read:?}");
    assert_eq!(read.len(), Format::ALL.len());
}

fn read_pair(bytes: &[u8], second: Option<&[u8]>) -> Result<Loaded, RecordingError> {
    let options = ReadOptions { poses: second, truth: second, ..ReadOptions::default() };
    read("some file", bytes, &options)
}

#[test]
fn the_content_tells_the_format() {
    for (format, bytes, second) in files() {
        let loaded = read_pair(&bytes, second.as_deref()).unwrap();
        assert_eq!(loaded.format, format);
        let packed = gzip(&bytes);
        let unpacked = read_pair(&packed, second.as_deref()).unwrap();
        assert_eq!(unpacked.recording, loaded.recording, "{format}: gzip makes no difference");
    }
}

/// What a recording promises, whatever file it came from.
fn check(loaded: &Loaded) {
    let recording = &loaded.recording;
    assert!(!recording.scans.is_empty());
    assert!(recording.scans.is_sorted_by_key(|s| s.stamp));
    assert!(recording.odometry.is_sorted_by_key(|p| p.stamp));
    let n = recording.rig.n_readings();
    let finite =
        |p: &geometry::Se2| p.x_m.is_finite() && p.y_m.is_finite() && p.yaw_rad.is_finite();
    for scan in &recording.scans {
        assert_eq!(scan.ranges_m.len(), n);
        assert!(scan.ranges_m.iter().all(|r| *r >= 0.0), "neither NaN nor negative");
        assert!(scan.stamps.is_empty() || scan.stamps.len() == n);
        assert!(scan.odom_from_base.iter().all(finite));
    }
    for poses in [&recording.reference, &recording.truth] {
        assert!(poses.is_empty() || poses.len() == recording.scans.len());
        assert!(poses.iter().all(|p| finite(&p.pose)));
    }
    let extra = &recording.extra_columns_m;
    assert!(extra.is_empty() || extra.len() == recording.scans.len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn damage_never_harms(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
        doubled in prop::option::of(any::<(prop::sample::Index, prop::sample::Index)>()),
        packed: bool,
    ) {
        for (format, bytes, second) in files() {
            let mut bytes = bytes;
            if let Some((a, b)) = doubled {
                let (a, b) = (a.index(bytes.len()), b.index(bytes.len()));
                let part = bytes[a.min(b)..a.max(b)].to_vec();
                bytes.splice(a..a, part);
            }
            for (at, byte) in &changes {
                let at = at.index(bytes.len());
                bytes[at] = *byte;
            }
            if packed {
                bytes = gzip(&bytes);
            }
            if let Some(cut) = cut {
                bytes.truncate(cut.index(bytes.len()));
            }
            match read_pair(&bytes, second.as_deref()) {
                Ok(loaded) => check(&loaded),
                Err(error) => prop_assert!(!error.to_string().is_empty(), "{format}"),
            }
            // The second file may be anything too.
            let whole = files().into_iter().find(|f| f.0 == format && f.2.is_some());
            if let Some(Ok(loaded)) = whole.map(|whole| read_pair(&whole.1, Some(&bytes))) {
                check(&loaded);
            }
        }
    }

    #[test]
    fn random_bytes_never_harm(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _outcome = read("x.clf", &bytes, &ReadOptions::default());
        let mcap = [mcap_records::MAGIC, &bytes].concat();
        let _outcome = read("x", &mcap, &ReadOptions::default());
        let mat = [&[b' '; 124][..], b"\x00\x01IM", &bytes].concat();
        let _outcome = read("x", &mat, &ReadOptions::default());
    }
}

#[test]
fn a_gzip_that_was_cut_gives_what_there_is() {
    let text = carmen::tests::log_of_300();
    let packed = gzip(text.as_bytes());
    let whole = read("x", &packed, &ReadOptions::default()).unwrap();
    let cut = &packed[..packed.len() / 2];
    let loaded = read("x.clf.gz", cut, &ReadOptions::default()).unwrap();
    let n = loaded.recording.scans.len();
    assert!(n > 50 && n < 300, "{n}");
    assert_eq!(loaded.recording.scans, whole.recording.scans[..n]);
    let complaint = &loaded.complaints.kept()[0];
    assert_eq!((complaint.trouble, complaint.action), (Trouble::EndsEarly, Action::Skipped));
    assert!(matches!(complaint.place, Place::Byte(bytes) if bytes > 1000), "{complaint}");
    assert!(complaint.found.contains("gzip"), "{complaint}");
    // The line in which it broke off is named.
    let broken = loaded.complaints.kept().iter().find(|c| c.trouble != Trouble::EndsEarly);
    if let Some(broken) = broken {
        assert!(matches!(broken.place, Place::Line(_)), "{broken}");
    }
    let error = read("x.clf.gz", &packed[..12], &ReadOptions::default()).unwrap_err();
    assert!(matches!(error, RecordingError::Gzip { .. }), "{error}");
}

#[test]
fn a_gzip_may_not_grow_without_bounds() {
    let packed = gzip(&vec![b'\n'; 3_000_000]);
    assert!(packed.len() < 5000);
    let options = ReadOptions { bytes_max: 1_000_000, ..ReadOptions::default() };
    let error = read("bomb.gz", &packed, &options).unwrap_err();
    assert_eq!(error, RecordingError::TooLarge { name: "bomb.gz".into(), bytes_max: 1_000_000 });
    let text = carmen::tests::log_of_300();
    let options = ReadOptions { bytes_max: text.len(), ..ReadOptions::default() };
    assert!(read("x", &gzip(text.as_bytes()), &options).is_ok(), "exactly at the limit");
}

#[test]
fn hopeless_files_are_refused_in_words() {
    let error = |name: &str, bytes: &[u8]| {
        read(name, bytes, &ReadOptions::default()).unwrap_err().to_string()
    };
    assert_eq!(error("a.clf", b""), "a.clf: the file is empty");
    let unknown = error("a.png", b"\x89PNG\r\n\x1a\nxyz");
    assert!(unknown.contains("unknown format") && unknown.contains("CARMEN"), "{unknown}");
    assert!(!unknown.contains('\u{1a}'), "nothing that a terminal would obey");
    assert!(error("a.mat", b"\x89HDF\r\n\x1a\n").contains("-v7"));
    assert!(error("a.clf", b"hello\n").contains("CARMEN"), "the name helps");
    assert!(error("a.txt", b"hello\n").contains("unknown format"));
}

#[test]
fn options_are_checked() {
    for (options, name) in [
        (ReadOptions { period_s: Some(0.0), ..ReadOptions::default() }, "period_s"),
        (ReadOptions { range_max_m: Some(f64::NAN), ..ReadOptions::default() }, "range_max_m"),
        (
            ReadOptions { field_of_view_rad: Some(7.0), ..ReadOptions::default() },
            "field_of_view_rad",
        ),
    ] {
        let error = read("x", carmen::tests::log_of_300().as_bytes(), &options).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    }
    let options = ReadOptions { ring: Ring::Listing8, ..ReadOptions::default() };
    assert!(read("x", carmen::tests::log_of_300().as_bytes(), &options).is_ok());
}

#[test]
fn complaints_are_bounded() {
    let text = format!("{}{}", carmen::tests::log_of_300(), "FLASER 5 1\n".repeat(10_000));
    let options = ReadOptions { complaints_max: 7, ..ReadOptions::default() };
    let loaded = read("x", text.as_bytes(), &options).unwrap();
    assert_eq!(loaded.complaints.kept().len(), 7);
    assert_eq!(loaded.complaints.count(Trouble::Truncated), 10_000);
}

fn reader(format: Format) -> &'static Reader {
    READERS.iter().find(|reader| reader.format == format).unwrap()
}

/// What was read takes no more than was said before, whatever the format; and a limit just below is kept.
#[test]
fn what_is_read_was_foretold() {
    let flaser = "FLASER 5 1.5 2.5 3.5 81.91 2.0 0 0 0 0 0 0 1.25 host 1.25\n".repeat(40);
    let odom = "ODOM 0 0 0 0 0 0 1.25 host 1.25\n".repeat(40);
    let rig = "# rig: {\"kind\":\"ring\",\"base_from_sensors\":[[0.1,0.0,0.0]],\"half_angle_rad\":0.26,\
               \"range_min_m\":0.1,\"range_max_m\":5.0}\nstamp_s,range_0_m\n";
    let rows = |n: usize| (0..n).map(|i| format!("{i}.5,1.35\n")).collect::<Vec<_>>().concat();
    let files = [
        ("a.log", format!("{flaser}{odom}").into_bytes()),
        ("b.csv", format!("{rig}{}", rows(40)).into_bytes()),
    ];
    for (name, bytes) in files {
        let loaded = read(name, &bytes, &ReadOptions::default()).unwrap();
        let foretold = needed_bytes(reader(loaded.format), &bytes, None, None);
        assert!(loaded.recording.memory_bytes() <= foretold, "{name}");
        let options = |memory_max_bytes| ReadOptions { memory_max_bytes, ..Default::default() };
        assert!(read(name, &bytes, &options(foretold)).is_ok(), "{name}");
        let refused = read(name, &bytes, &options(foretold - 1)).unwrap_err();
        assert!(
            matches!(refused, RecordingError::TooMuchMemory { needed, .. } if needed == foretold),
            "{name}: {refused}"
        );
    }
}

/// Odometry lines are cheaper than scans, and a file of many numbers dearer than one of few.
#[test]
fn what_costs_more_is_said_to_cost_more() {
    let of = |text: &str| needed_bytes(reader(Format::Carmen), text.as_bytes(), None, None);
    assert!(of("ODOM 0 0 0 0 0 0 1 h 1\n") < of("FLASER 1 1.5 0 0 0 0 0 0 1 h 1\n"));
    let more = of("FLASER 2 1.5 1.5 0 0 0 0 0 0 1 h 1\n");
    assert_eq!(more, of("FLASER 1 1.5 0 0 0 0 0 0 1 h 1\n") + size_of::<f64>());
}
