//! The names of the library: `use ncfix::prelude::*`.

pub use crate::correction::{Correction, Pieces};
pub use crate::diagnostics::{Diagnostics, Located};
pub use crate::error::Error;
pub use crate::feed::{ControlLink, FeedEnd, FeedOptions, FeedView, Sent, Transfer};
pub use crate::machine::Machine;
pub use crate::moves::Elements;
pub use crate::options::{Compensation, DialectChoice, Options};
pub use crate::program::Program;
pub use crate::registry::Registry;
pub use crate::simulate::{Recorded, SimulateOptions};
pub use crate::tool::ToolVector;
pub use ncfix_base::diagnostic::{Code, Severity};
pub use ncfix_base::geometry::{Axis, AxisVector, Vector};
pub use ncfix_dnc::feed::Port;
pub use ncfix_dnc::sense::Panel;
pub use ncfix_machine::machine::{Condition, Load, State};
pub use ncfix_machine::snc::{Element, Kind, Move};
pub use ncfix_path::path::{Arcs, FiveAxis, Output, OutputFrame, Piece, Rapids, Rotary};
pub use ncfix_report::correction::Correction as CorrectionReport;
pub use ncfix_report::feed::{Before as FeedForecast, FeedEvent, Status as FeedStatus};
pub use ncfix_report::json::{Spread, Verification};
pub use ncfix_report::review::Review;
pub use ncfix_report::shares::Deviation;
