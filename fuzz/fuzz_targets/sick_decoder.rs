//! Feeds bytes to `fuzz_targets::sick_decoder`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::sick_decoder(bytes));
