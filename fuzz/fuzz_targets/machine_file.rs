//! See `ncfix_fuzz::files::machine`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::files::machine(data));
