//! Data of the machine tool, and SNC, the flat stream of moves that is the result of executing a program. This crate does not contain error models or languages.

pub mod machine;
pub mod snc;
