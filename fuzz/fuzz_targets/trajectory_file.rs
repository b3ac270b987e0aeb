//! Feeds bytes to `fuzz_targets::trajectory_file`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::trajectory_file(bytes));
