//! The integration tests, one binary.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails here, which is what it is for")]

// mod architecture;
mod exec;
mod grammar;
mod hostile;
mod machines;
