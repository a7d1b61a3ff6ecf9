//! See `ncfix_fuzz::programs::execute_grundig`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::programs::execute_grundig(data));
