//! Typed results for compensation tables (made, checked, compared) and for the cycle of a control, as printed by `--json` and drawn on pages.

pub mod compared;
pub mod inverse;
pub mod made;
pub mod realtime;
pub mod request;
pub mod result;
pub mod single;
