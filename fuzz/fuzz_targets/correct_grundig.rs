//! See `ncfix_fuzz::correction::grundig`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::correction::grundig(data));
