//! Feeds bytes to `fuzz_targets::decision_image`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::decision_image(bytes));
