//! See `ncfix_fuzz::files::saved_data`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ncfix_fuzz::files::saved_data(data));
