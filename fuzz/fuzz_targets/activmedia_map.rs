//! Feeds bytes to `fuzz_targets::activmedia_map`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::activmedia_map(bytes));
