//! Tells builds apart: a hash of the sources that a run depends on, of the compiler and of the target. It stands at the
//! head of every recording, so that a replay can say that another build wrote it.
#![allow(
    clippy::allow_attributes,
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "cargo is spoken to by printing"
)]

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Crates that no run depends on.
const ABOVE: [&str; 13] = [
    "bench_suite",
    "cairn",
    "experiments",
    "figures",
    "files",
    "fuzz_targets",
    "least_squares",
    "slam",
    "studio",
    "surveys",
    "testkit",
    "xtask",
    "continuous_localisation",
];

fn main() {
    let here = PathBuf::from(env::var("CARGO_MANIFEST_DIR").unwrap());
    let crates = here.parent().unwrap();
    let root = crates.parent().unwrap();
    let mut sources = Vec::new();
    for entry in fs::read_dir(crates).unwrap().map(Result::unwrap) {
        let name = entry.file_name();
        if ABOVE.iter().any(|above| name == *above) {
            continue;
        }
        for part in ["src", "data"] {
            let folder = entry.path().join(part);
            if folder.is_dir() {
                println!("cargo::rerun-if-changed={}", folder.display());
                collect(&folder, &mut sources);
            }
        }
    }
    let lock = root.join("Cargo.lock");
    println!("cargo::rerun-if-changed={}", lock.display());
    sources.push(lock);
    sources.sort();
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    for path in &sources {
        // Where the sources lie makes no other build.
        hash.absorb(path.strip_prefix(root).unwrap().to_string_lossy().as_bytes());
        hash.absorb(&fs::read(path).unwrap_or_default());
    }
    let compiler = Command::new(env::var("RUSTC").unwrap()).arg("-V").output();
    hash.absorb(&compiler.map(|out| out.stdout).unwrap_or_default());
    hash.absorb(env::var("TARGET").unwrap().as_bytes());
    println!("cargo::rustc-env=CAIRN_BUILD={:016x}", hash.0);
}

fn collect(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, into);
        } else {
            into.push(path);
        }
    }
}

/// FNV-1a, 64 bits: a name for a build, not a protection.
struct Fnv(u64);

impl Fnv {
    fn absorb(&mut self, bytes: &[u8]) {
        for byte in bytes.iter().chain(&[0]) {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
