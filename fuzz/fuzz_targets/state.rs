//! See `ncfix_fuzz::files::state`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::files::state(data));
