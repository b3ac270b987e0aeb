//! Feeds bytes to `fuzz_targets::ld06_decoder`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::ld06_decoder(bytes));
