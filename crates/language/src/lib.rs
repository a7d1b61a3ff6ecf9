//! Part programs of controls: what was written, and what the control would do. It knows no error model.

pub mod exec;
pub mod syntax;
