//! The integration tests, one binary.

mod exec;
mod machines;
mod grammar;
//mod architecture;
