//! Typed results of what is done with compensation tables (made, checked, compared) and in the cycle of a control; what `--json` prints and pages draw.

pub mod compared;
pub mod made;
pub mod realtime;
pub mod request;
pub mod result;
