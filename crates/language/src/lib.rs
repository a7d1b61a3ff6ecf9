//! Part programs of controls: what was written, and what the control would do. This crate does not depend on the error model.

pub mod exec;
pub mod syntax;
