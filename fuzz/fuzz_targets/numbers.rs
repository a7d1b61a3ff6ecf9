//! See `ncfix_fuzz::numbers::agree`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::numbers::agree(data));
