//! Context of a motion in addition to the modal state.

use ncfix_base::source::Span;
use ncfix_machine::machine::Control;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Setup;
use std::sync::Arc as Shared;
/// Context of a motion in addition to the modal state.
#[derive(Clone, Copy)]
pub(super) struct MotionContext<'a> {
    pub(super) machine: &'a Machine,
    pub(super) control: &'a Control,
    /// Frame and tool of this block (G53 suppresses the modal frame).
    pub(super) setup: &'a Shared<Setup>,
    /// `true` if this block suppresses the frame.
    pub(super) is_suppressed: bool,
    /// Rejects motions with unknown start.
    pub(super) strict: bool,
    /// Span of the block.
    pub(super) span: Span,
}
