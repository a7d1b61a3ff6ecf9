//! See `ncfix_fuzz::programs::parse_sinumerik`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::programs::parse_sinumerik(data));
