//! Formats the results of the other crates as text, pages and JSON: diagnostics, results of a correction, machines.
//!
//! The functions return text or serializable values, apart from the [`progress`] line. They do not open files and do not query the capabilities of a terminal.

pub mod calibration;
pub mod chain;
mod component;
pub mod correction;
pub mod coverage;
pub mod decomposition;
pub mod diagnosis;
mod excerpt;
pub mod feed;
pub mod figures;
pub mod guard;
pub mod inputs;
pub mod json;
pub mod load;
pub mod machine;
pub mod manual;
pub mod markup;
pub mod measured;
pub mod origin;
pub mod page;
pub mod plan;
pub mod plot;
pub mod prediction;
pub mod presets;
pub mod progress;
pub mod realtime;
pub mod residual;
pub mod review;
mod scale;
#[cfg(feature = "schema")]
pub mod schema;
pub mod selection;
pub mod sensors;
pub mod shares;
pub mod steps;
pub mod tables;
pub mod terminal;
pub mod verdict;
pub mod verification;
pub mod watch;

pub use ncfix_base::number;
pub use ncfix_metrology::results::compared;
