//! Part programs of controls: their syntax trees, and the moves that the control would make. This crate does not depend on the error model.

pub mod exec;
pub mod syntax;
