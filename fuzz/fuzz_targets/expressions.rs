//! See `ncfix_fuzz::expressions::agree`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::expressions::agree(data));
