//! See `ncfix_fuzz::sensors::config`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::sensors::config(data));
