//! Feeds bytes to `fuzz_targets::arcos_decoder`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::arcos_decoder(bytes));
