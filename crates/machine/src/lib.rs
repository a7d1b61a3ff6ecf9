//! The machine tool as data, and SNC, the flat stream of moves that a program becomes. It knows no errors and no languages.

pub mod machine;
pub mod snc;
