//! Zero offsets and programmable frames.

use super::channel::Channel;
use super::fault::{Fault, fault};
use super::gathered::Gathered;
use crate::diagnostic::Code;
use crate::geometry::{AxisVector, Frame};
use crate::snc::{FrameWords, Kind};
use crate::source::Span;

impl Channel<'_> {
    pub(super) fn offset(&mut self, gathered: &Gathered) -> Result<(), Fault> {
        let Some((name, span)) = &gathered.offset else { return Ok(()) };
        let value = self.machine.zero_offsets.get(name).copied();
        let missing = value.is_none() && name != "G500";
        if missing {
            let message = format!("{name} has no value in the machine file");
            if self.strict {
                return Err(fault(
                    Code::NO_OFFSET,
                    *span,
                    message,
                    format!("add [zero_offset.{name}] there or in a file given with --setup"),
                ));
            }
            self.warnings.push(fault(
                Code::OFFSET_ASSUMED,
                *span,
                format!("{message}; zero is used"),
                format!("add [zero_offset.{name}] there"),
            ));
        }
        self.modal.settable = Frame::translation(value.unwrap_or_default());
        self.modal.offset_assumed = missing;
        self.refresh_setup();
        self.push(Kind::Frame(FrameWords::Settable(name.clone())));
        Ok(())
    }

    pub(super) fn translate(&mut self, gathered: &Gathered, additive: bool, span: Span) -> Result<(), Fault> {
        let strange = gathered.center.iter().any(Option::is_some)
            || gathered.feed.is_some()
            || gathered.tool.is_some()
            || gathered.motion.is_some()
            || gathered.offset.is_some()
            || gathered.dwell.is_some()
            || !gathered.after.is_empty()
            || !gathered.before.is_empty()
            || !gathered.as_incremental.is_empty();
        if strange {
            return Err(fault(
                Code::MUST_STAND_ALONE,
                span,
                "TRANS and ATRANS share their block with nothing but axis words",
                "move the other words to another block",
            ));
        }
        let mut shift = AxisVector::ZERO;
        for axis in gathered.named.iter() {
            let unit = if axis.is_rotary() { 1_f64.to_radians() } else { self.modal.scale() };
            shift[axis] = gathered.axes[axis] * unit;
        }
        let added = Frame::translation(shift);
        self.modal.programmable = if additive { self.modal.programmable.compose(&added) } else { added };
        self.refresh_setup();
        self.push(Kind::Frame(FrameWords::Translate { additive, shift, named: gathered.named }));
        Ok(())
    }
}
