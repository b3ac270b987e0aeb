//! Feeds bytes to `fuzz_targets::cairn_scan`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::cairn_scan(bytes));
