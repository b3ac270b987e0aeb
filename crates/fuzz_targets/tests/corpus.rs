//! Replays every file of the fuzzers' corpus, and each of them damaged, through its target.

use fuzz_targets::TARGETS;

/// Damaged copies: cut short, a bit turned at every few places, doubled.
fn damaged(bytes: &[u8]) -> Vec<Vec<u8>> {
    let step = (bytes.len() / 40).max(1);
    let places = (0..bytes.len()).step_by(step);
    let cut = places.clone().map(|end| bytes[..end].to_vec());
    let turned = places.map(|place| {
        let mut copy = bytes.to_vec();
        copy[place] ^= 1 << (place % 8);
        copy
    });
    cut.chain(turned).chain([bytes.repeat(2), Vec::new()]).collect()
}

#[test]
fn every_file_of_the_corpus_is_read_without_harm() {
    for (name, target) in TARGETS {
        let folder = testkit::workspace_root().join("fuzz/corpus").join(name);
        for (path, bytes) in testkit::corpus(&folder) {
            println!("{}", path.display());
            target(&bytes);
            for bytes in damaged(&bytes) {
                target(&bytes);
            }
        }
    }
}

#[test]
fn every_target_has_a_fuzzer_and_every_folder_a_target() {
    let fuzz = testkit::workspace_root().join("fuzz");
    let manifest = std::fs::read_to_string(fuzz.join("Cargo.toml")).unwrap();
    for (name, _) in TARGETS {
        assert!(manifest.contains(&format!("name = \"{name}\"")), "fuzz/Cargo.toml lacks {name}");
    }
    for entry in std::fs::read_dir(fuzz.join("corpus")).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        assert!(TARGETS.iter().any(|(target, _)| *target == name), "no target for corpus/{name}");
    }
}
