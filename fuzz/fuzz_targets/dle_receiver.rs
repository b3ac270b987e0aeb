//! Feeds bytes to `fuzz_targets::dle_receiver`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::dle_receiver(bytes));
