//! Converts the gathered words of a block into motions: targets, shapes, and their emission.

use super::arc;
use super::codes::name_of;
use super::cycle;
use super::direction;
use super::forbidden;
use super::probe;
use super::special;
use super::spline;
use super::step;
use super::step::Step;
use super::target;
use super::thread;
use super::tilt;

use super::channel::Channel;
use super::codes::Group;
use super::gathered::Gathered;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Executes the motion of a block with axis words or a center, by a motion mode in tenths.
pub(super) fn motion(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    if let Some(span) = gathered.machine_frame {
        return machine_motion(channel, gathered, code, span);
    }
    channel.block.direction = direction::tool_direction(channel.settings.machine, &channel.modal, gathered, code)?;
    let done = way(channel, gathered, code);
    channel.block.direction = None;
    done
}

fn way(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    match code {
        0 | 10 => {
            let (end, named) = step::end(channel, gathered)?;
            if named.is_empty() && !gathered.axes.is_empty() && !gathered.has_any(b"@^") {
                // Increments of zero from a position that is not known.
                return Ok(());
            }
            special::corner_words(channel, gathered)?;
            step::step(channel, Step::straight(gathered, code == 0, end, named))
        }
        20 | 30 => {
            let (end, named) = step::end(channel, gathered)?;
            special::corner_words(channel, gathered)?;
            arc::arc(channel, gathered, code, end, named)
        }
        _ => special_motion(channel, gathered, code),
    }
}

/// `G53`: machine positions, for this block.
fn machine_motion(channel: &mut Channel<'_>, gathered: &Gathered, code: u16, span: Span) -> Result<(), Fault> {
    // A canned cycle stays modal and does not drill here.
    let is_in_cycle =
        !channel.is_rs274() && gathered.code(Group::Cycle).is_none() && cycle::is_cycle(code, channel.is_rs274());
    if !matches!(code, 0 | 10) && !is_in_cycle {
        let message = "G53 requires G0 or G1";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "program G0 or G1 in the block of G53"));
    }
    if channel.modal.modes.incremental && !channel.settings.machine.control.iso.is_haas() {
        // A Fanuc ignores it, but a programmed motion must not vanish.
        let help = if channel.is_rs274() {
            "program G90 in the block"
        } else {
            "program G90 in the block; for a Haas, set controller = \"haas\" in the machine file"
        };
        return Err(fault(Code::BAD_WORD_VALUE, span, "G53 under G91", help));
    }
    forbidden::no_compensation(channel.language, &channel.modal, span, "G53")?;
    let here = channel.modal.position.command;
    let mut end = here;
    for axis in gathered.axes.iter() {
        let value = target::axis_value(channel, gathered, axis)?;
        end[axis] = target::absolute(channel.settings.machine, &channel.modal, gathered, axis, value, here[axis])?;
    }
    if is_in_cycle {
        channel.cycles.drill.moved();
    }
    step::machine_step(channel, Step::straight(gathered, code == 0 || is_in_cycle, end, gathered.axes))
}

/// A block in a motion mode other than line and arc; its words may be missing.
pub(super) fn special_motion(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    match code {
        50 | 51 => spline::spline(channel, gathered, code),
        52 => spline::nurbs_point(channel, gathered),
        53 => spline::nurbs_end(channel, gathered),
        310 | 382..=385 => probe::probe(channel, gathered, code),
        330 | 331 => thread::thread(channel, gathered, code),
        760 if channel.is_rs274() => thread::threading(channel, gathered),
        531 => tilt::tool_on_plane(channel, gathered),
        730..=890 => cycle::cycle(channel, gathered, code),
        _ => {
            let message = format!("{} is not supported", name_of(code));
            let group = if gathered.code(Group::Action) == Some(code) { Group::Action } else { Group::Motion };
            Err(fault(Code::NOT_SUPPORTED, gathered.code_span(group), message, "program without it"))
        }
    }
}
