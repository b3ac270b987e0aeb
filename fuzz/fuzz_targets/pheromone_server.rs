//! Feeds bytes to `fuzz_targets::pheromone_server`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::pheromone_server(bytes));
