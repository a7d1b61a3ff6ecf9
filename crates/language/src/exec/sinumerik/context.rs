//! What a motion needs beside the modal state.

use ncfix_base::source::Span;
use ncfix_machine::machine::Control;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Setup;
use std::sync::Arc as Shared;
/// What a motion needs beside the modal state.
#[derive(Clone, Copy)]
pub(super) struct MotionContext<'a> {
    pub(super) machine: &'a Machine,
    pub(super) control: &'a Control,
    /// The frame and tool that hold in this block (G53 suppresses the modal frame).
    pub(super) setup: &'a Shared<Setup>,
    /// Whether this block suppresses the frame.
    pub(super) is_suppressed: bool,
    /// Refuse motions whose start is not known.
    pub(super) strict: bool,
    /// Where the block stands.
    pub(super) span: Span,
}
