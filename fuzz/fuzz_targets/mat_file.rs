//! Feeds bytes to `fuzz_targets::mat_file`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::mat_file(bytes));
