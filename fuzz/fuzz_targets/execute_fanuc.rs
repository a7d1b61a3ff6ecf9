//! See `ncfix_fuzz::programs::execute_fanuc`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::programs::execute_fanuc(data));
