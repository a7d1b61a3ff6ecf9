//! See `ncfix_fuzz::correction::sinumerik`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::correction::sinumerik(data));
