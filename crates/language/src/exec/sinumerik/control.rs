//! State of the control other than variables: frames, tools, and the program's read accesses.

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
    /// `true` if nothing may be assumed.
    pub(super) strict: bool,
    /// `true` if MCALL is active.
    pub(super) modal_call: bool,
    /// A main-run variable that was read since [`Self::looked`]: the control stops to read it.
    pub(super) looked: Cell<Option<&'static str>>,
}
