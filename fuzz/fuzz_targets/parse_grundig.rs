//! See `ncfix_fuzz::programs::parse_grundig`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::programs::parse_grundig(data));
