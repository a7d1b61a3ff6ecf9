//! Description of a new machine: a template, statements of a person and data of its control become the text of a machine file.
//!
//! Every value has an origin: stated, taken from a line of a file, by convention, or assumed. A value whose error would be dangerous is never assumed: the
//! sense of a rotary axis and a point on it.

mod contradiction;
pub mod data;
mod description;
mod known;
mod setup;
mod stated;
mod template;
mod write;

pub use contradiction::contradictions;
pub use data::{AxisFacts, ControlFacts, DataNote, DataNoteKind};
pub use description::{Ask, AxisDescription, Description, DescriptionRequest, Question};
pub use known::{Known, KnownOrigin};
pub use setup::{has_same_setup, setup_text, worn_edges};
pub use stated::{StatedPivot, StatedSense, StatedTravel, TravelRange};
pub use template::{TEMPLATES, Template, TemplateRotary, template};
pub use write::{measured, text};
