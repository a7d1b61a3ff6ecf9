//! See `ncfix_fuzz::correction::fanuc`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::correction::fanuc(data));
