//! Feeds bytes to `fuzz_targets::ground_link`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::ground_link(bytes));
