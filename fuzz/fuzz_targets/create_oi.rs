//! Feeds bytes to `fuzz_targets::create_oi`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::create_oi(bytes));
