//! See `ncfix_fuzz::programs::execute_rs274`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::programs::execute_rs274(data));
