//! See `ncfix_fuzz::tables::read_and_written`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::tables::read_and_written(data));
