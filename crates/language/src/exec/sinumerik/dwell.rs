//! `G4`: a dwell in seconds or turns.

use super::channel::Channel;
use super::gathered::Gathered;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_machine::snc::{Dwell, Kind};

/// Executes `G4`.
pub(super) fn dwell(channel: &mut Channel<'_>, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
    let dwell = match (gathered.feed, gathered.speed) {
        (Some((seconds, _)), None) => Dwell::Seconds(seconds),
        (None, Some((turns, _))) if turns >= 0.0 => Dwell::Turns(turns),
        _ => {
            return Err(bad_value(span, "G4 needs either F with seconds or S with turns", "write for example G4 F1.5"));
        }
    };
    if !gathered.named.is_empty() {
        return Err(fault(Code::MUST_STAND_ALONE, span, "G4 in a block with a motion", "give the dwell its own block"));
    }
    let before = std::mem::take(&mut gathered.before);
    if !before.is_empty() {
        channel.push(Kind::Before(before));
    }
    channel.push(Kind::Dwell(dwell));
    let after = std::mem::take(&mut gathered.after);
    if !after.is_empty() {
        channel.push(Kind::After(after));
    }
    Ok(())
}
