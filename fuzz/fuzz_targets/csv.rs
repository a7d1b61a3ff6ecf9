//! See `ncfix_fuzz::measured::table`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::measured::table(data));
