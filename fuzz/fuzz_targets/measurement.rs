//! See `ncfix_fuzz::measured::pair`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::measured::pair(data));
