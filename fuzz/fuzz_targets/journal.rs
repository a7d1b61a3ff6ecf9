//! See `ncfix_fuzz::links::journal`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::links::journal(data));
