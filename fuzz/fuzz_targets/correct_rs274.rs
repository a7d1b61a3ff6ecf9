//! See `ncfix_fuzz::correction::rs274`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::correction::rs274(data));
