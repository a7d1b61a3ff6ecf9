//! ncfix (map to be completed)

pub mod diagnostic;
pub mod dialect;
pub mod exec;
pub mod geometry;
pub mod machine;
pub mod model;
pub mod report;
pub mod snc;
pub mod source;
pub mod syntax;
pub mod units;
