//! Kinds of motion beyond lines and arcs: cycles, threads, probing, splines.

use super::channel::Channel;
use super::codes::{Group, name_of};
use super::gathered::Gathered;
use crate::diagnostic::Code;
use crate::exec::fault::{Fault, fault};
use crate::geometry::{AxisSet, AxisVector};

impl Channel<'_> {
    /// A block under a kind of motion that is neither line nor arc; its words may be missing.
    pub(super) fn special_motion(&mut self, gathered: &Gathered, code: u16) -> Result<(), Fault> {
        let message = format!("{} is not supported yet", name_of(code));
        Err(fault(Code::NOT_SUPPORTED, gathered.code_span(Group::Motion), message, "program without it"))
    }

    /// Lets polar words replace those of the plane: changes the programmed end and the axes named.
    pub(super) fn polar_end(
        &mut self,
        _gathered: &Gathered,
        _here: &AxisVector,
        _end: &mut AxisVector,
        _named: &mut AxisSet,
    ) -> Result<(), Fault> {
        Ok(())
    }

    /// What `,C` and `,R` ask of the end of the motion to come.
    pub(super) fn corner_words(&mut self, _gathered: &Gathered) -> Result<(), Fault> {
        Ok(())
    }
}
