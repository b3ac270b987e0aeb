//! Damage of recordings: every byte is covered, and what is damaged or cut is named with its place.

#![expect(
    clippy::default_trait_access,
    reason = "the set of options is of a crate that is not among ours"
)]

use std::collections::BTreeMap;

use mcap::{WriteOptions, records::MessageHeader};

use super::*;

/// A file of two chunks as the recorder writes it; `end` finishes it.
fn file(end: bool) -> Vec<u8> {
    let library = format!("cairn{LIBRARY_MARK}");
    let mut writer = WriteOptions::new()
        .compression(None)
        .profile("cairn")
        .library(library)
        .disable_seeking(true)
        .create(std::io::Cursor::new(Vec::new()))
        .unwrap();
    let channel = writer.add_channel(0, "/t", "json", &BTreeMap::new()).unwrap();
    let mut bytes = Vec::new();
    // The writer gives no look at what it wrote: it is written once more for each part.
    for upto in 1..=2 {
        let mut again = WriteOptions::new()
            .compression(None)
            .profile("cairn")
            .library(format!("cairn{LIBRARY_MARK}"))
            .disable_seeking(true)
            .create(std::io::Cursor::new(Vec::new()))
            .unwrap();
        let id = again.add_channel(0, "/t", "json", &BTreeMap::new()).unwrap();
        assert_eq!(id, channel);
        for part in 0..upto {
            for k in 0..3_u32 {
                let time = u64::from(part * 3 + k);
                let header = MessageHeader {
                    channel_id: id,
                    sequence: k,
                    log_time: time,
                    publish_time: time,
                };
                again
                    .write_to_known_channel(&header, format!("{{\"n\":{time}}}").as_bytes())
                    .unwrap();
            }
            again.flush().unwrap();
            if part + 1 < upto {
                let mut crc = flate2::Crc::new();
                crc.update(&bytes);
                let record = check_record(bytes.len() as u64, crc.sum());
                again.write_private_record(CHECK_OPCODE, &record, Default::default()).unwrap();
            }
        }
        if upto == 2 && end {
            again.finish().unwrap();
            return again.into_inner().into_inner();
        }
        // Dropping would finish it; what is there until now is what was flushed.
        bytes = flushed(again);
    }
    let mut crc = flate2::Crc::new();
    crc.update(&bytes);
    let record = check_record(bytes.len() as u64, crc.sum());
    bytes.push(CHECK_OPCODE);
    bytes.extend((record.len() as u64).to_le_bytes());
    bytes.extend(record);
    bytes
}

/// What a writer wrote before it was finished: everything before its `Data End`.
fn flushed(mut writer: mcap::Writer<std::io::Cursor<Vec<u8>>>) -> Vec<u8> {
    writer.finish().unwrap();
    let bytes = writer.into_inner().into_inner();
    let end = Tail::of(&bytes).unwrap().data_end;
    bytes[..end].to_vec()
}

#[test]
fn whole_files_are_whole() {
    for end in [true, false] {
        let bytes = file(end);
        let found = Integrity::of(&bytes);
        assert_eq!(found.damage, [], "finished: {end}");
        assert_eq!((found.finished, found.n_verified, found.has_checks), (end, bytes.len(), true));
    }
}

/// Every byte, every bit of it: nothing is covered by nothing.
#[test]
fn every_changed_byte_is_found() {
    for end in [true, false] {
        let whole = file(end);
        let mut bytes = whole.clone();
        for at in 0..whole.len() {
            for flip in [0x01, 0x80, 0xFF, whole[at]] {
                if flip == 0 {
                    continue;
                }
                bytes[at] = whole[at] ^ flip;
                let found = Integrity::of(&bytes);
                assert!(!found.damage.is_empty(), "byte {at} ^ {flip:#x}, finished: {end}");
                let near = found.damage.iter().any(|d| d.bytes.contains(&at) || d.bytes.end >= at);
                assert!(near, "byte {at}: {:?}", found.damage);
            }
            bytes[at] = whole[at];
        }
    }
}

/// A cut is damage unless it falls between two check records, where a killed program leaves the file.
#[test]
fn a_cut_file_is_whole_only_between_check_records() {
    let whole = file(false);
    let clean: Vec<usize> =
        (0..whole.len()).filter(|&n| Integrity::of(&whole[..n]).damage.is_empty()).collect();
    let one_chunk = Integrity::of(&whole[..whole.len() - 1]).n_verified;
    assert_eq!(clean, [one_chunk]);
    assert!(one_chunk > 0);
}

/// Files of other writers: no check records, and checksums that are left out are no damage.
#[test]
fn foreign_files_may_leave_checksums_out() {
    for sums in [true, false] {
        let mut writer = WriteOptions::new()
            .compression(None)
            .calculate_chunk_crcs(sums)
            .calculate_data_section_crc(sums)
            .calculate_summary_section_crc(sums)
            .create(std::io::Cursor::new(Vec::new()))
            .unwrap();
        let id = writer.add_channel(0, "/t", "json", &BTreeMap::new()).unwrap();
        let header = MessageHeader { channel_id: id, sequence: 0, log_time: 1, publish_time: 1 };
        writer.write_to_known_channel(&header, b"{}").unwrap();
        writer.finish().unwrap();
        let mut bytes = writer.into_inner().into_inner();
        let found = Integrity::of(&bytes);
        assert_eq!((found.finished, found.has_checks, found.damage), (true, false, Vec::new()));
        bytes[60] ^= 1;
        assert_eq!(Integrity::of(&bytes).damage.is_empty(), !sums);
    }
}

#[test]
fn what_is_no_mcap_is_said() {
    for bytes in [&b""[..], b"these are notes", b"\x89MCAP1\r\n"] {
        assert_eq!(Integrity::of(bytes).damage.len(), 1);
    }
}
