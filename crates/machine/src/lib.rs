//! Data of the machine tool, and SNC, the flat stream of moves that a program becomes; descriptions of new machines, and files in which controls save offsets and tools. This crate contains neither error models nor languages.

pub mod describe;
pub mod machine;
pub mod saved;
pub mod snc;
