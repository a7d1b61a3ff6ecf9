//! See `ncfix_fuzz::links::profile`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::links::profile(data));
