//! Feeds bytes to `fuzz_targets::mission_file`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::mission_file(bytes));
