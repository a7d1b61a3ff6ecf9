//! What the control holds beside the variables: frames, tools, what a program has looked at.

use super::frame_store::FrameStore;
use super::tool_data::ToolData;
use super::value::Value;
use std::cell::Cell;
use std::collections::HashMap;
/// The system variables of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct System {
    pub(super) values: HashMap<String, Value>,
    pub(super) frames: FrameStore,
    pub(super) tools: ToolData,
    /// Whether nothing may be assumed.
    pub(super) strict: bool,
    /// Whether MCALL is in force.
    pub(super) modal_call: bool,
    /// A variable of the main run that was read since [`Self::looked`]: the control stops to read it.
    pub(super) looked: Cell<Option<&'static str>>,
}
