//! Rotation, scale, mirror and tilted planes: the part of the frame that is nearest to the programmed values.

use super::channel::Channel;
use super::codes::{Group, name_of};
use super::gathered::Gathered;
use crate::diagnostic::Code;
use crate::exec::fault::{Fault, fault};
use crate::geometry::Frame;

/// What is in force of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Transforms {}

impl Transforms {
    /// The frame of all of them; `None` where there is none.
    #[allow(clippy::unused_self, reason = "filled by the codes")]
    pub(super) fn frame(&self) -> Option<Frame> {
        None
    }
}

impl Channel<'_> {
    /// Executes the codes of a block that concern them. Whether they took the axis words, so that the block has no motion.
    pub(super) fn transform_codes(&mut self, gathered: &Gathered) -> Result<bool, Fault> {
        for (group, off) in [
            (Group::Polar, 150),
            (Group::Scale, 500),
            (Group::Mirror, 501),
            (Group::Rotation, 690),
            (Group::Interpolation, 131),
        ] {
            if let Some(code) = gathered.code(group).filter(|&code| code != off) {
                let message = format!("{} is not supported yet", name_of(code));
                return Err(fault(Code::NOT_SUPPORTED, gathered.code_span(group), message, "program without it"));
            }
        }
        Ok(false)
    }
}
