//! Data of the machine tool, and SNC, the flat stream of moves that a program becomes. This crate contains neither error models nor languages.

pub mod machine;
pub mod snc;
