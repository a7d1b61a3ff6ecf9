//! G38.2 to G38.5 and G31: motions that a probe or signal ends. Their end is known only to the machine.

use super::channel::Channel;
use super::codes::name_of;
use super::gathered::Gathered;
use super::predefined;
use super::step;
use super::step::Step;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_machine::snc::{FeedUnit, Kind, MotionMode};

/// Moves to the programmed end; afterwards the position is unknown.
pub(super) fn probe(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    let (name, span) = (name_of(code), gathered.span);
    if channel.modal.contour.compensates() || channel.modal.turning.is_some() {
        let message = format!("{name} under radius compensation or tool center point control");
        return Err(fault(Code::NOT_SUPPORTED, span, message, "end it before probing"));
    }
    if channel.is_rs274() && channel.modal.modes.feed_unit == FeedUnit::PerTurn {
        let message = format!("{name} under a feed per revolution (G95)");
        return Err(fault(Code::NOT_SUPPORTED, span, message, "program G94: LinuxCNC refuses it too"));
    }
    let (end, named) = step::end(channel, gathered)?;
    let word = match code {
        382 => "G38.2",
        383 => "G38.3",
        384 => "G38.4",
        385 => "G38.5",
        _ => "G31",
    };
    let motion_mode = MotionMode::Probe(word);
    step::step(channel, Step { rapid: false, end, named, feed_named: gathered.has(b'F'), motion_mode, span })?;
    predefined::note_probe(channel);
    if channel.settings.strict {
        let lost = channel.modal.forget(named);
        channel.modal.position.probed = channel.modal.position.probed.union(lost);
        channel.push(Kind::Lost(lost));
    }
    Ok(())
}
