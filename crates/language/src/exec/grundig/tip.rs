//! G141: the tip follows the programmed path while rotary axes turn (`MillPlus`).
//!
//! Positions are those of the tip, fixed to the workpiece, and rotary words are positions of the axes. G40 ends it. The output has positions of the
//! axes instead.

use super::channel::Channel;
use super::gathered::Gathered;
use super::setup;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, LINEAR_AXES, ROTARY_AXES};
use ncfix_base::source::Span;
use ncfix_machine::machine::Kinematics;
use ncfix_machine::snc::Turning;

/// Codes with which a block needs coordinates of the axes.
const OF_AXES: [u16; 8] = [41, 42, 43, 44, 61, 62, 73, 74];

/// G141, and G40 that ends it.
pub(super) fn switch(channel: &mut Channel<'_>, gathered: &mut Gathered, ends: bool) -> Result<(), Fault> {
    if ends && channel.modal.turning.is_some() {
        set(channel, None)?;
    }
    if let Some(span) = gathered.take_code(141) {
        begin(channel, gathered, span)?;
    }
    Ok(())
}

/// Rejects codes that need coordinates of the axes while G141 is in force.
pub(super) fn check(channel: &Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    if channel.modal.turning.is_none() {
        return Ok(());
    }
    let is_cycle = |number: u16| matches!(number, 77 | 79) || super::cycles::find(number).is_some();
    let refused = gathered.codes.iter().find(|code| OF_AXES.contains(&code.number) || is_cycle(code.number));
    match refused {
        Some(code) => {
            let message = format!("G{} under G141", code.number);
            Err(fault(Code::FORBIDDEN_STATE, code.span, message, "end G141 with G40 before it"))
        }
        None => Ok(()),
    }
}

fn begin(channel: &mut Channel<'_>, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
    let unsupported = |at: Span, message: &str, help: &str| fault(Code::NOT_SUPPORTED, at, message, help);
    for index in [None, Some(1)] {
        if let Some((_, at)) = gathered.once(b'R', index)?.filter(|(value, _)| *value != 0.0) {
            let help = "the path is corrected along surface normals by the radius; write the path of the tip without R";
            return Err(unsupported(at, "G141 with the radius of a tool", help));
        }
    }
    // L2 tells the way of the rotary axes, F2 their largest feed: neither changes the path.
    gathered.once(b'L', Some(2))?;
    gathered.once(b'F', Some(2))?;
    if channel.modal.contour.compensates() {
        let message = "G141 while radius compensation is on";
        return Err(fault(Code::BAD_COMPENSATION, span, message, "program G40 with a motion in the plane before it"));
    }
    if channel.modal.tilted.is_some() {
        let message = "G141 in the tilted plane of G7";
        return Err(fault(Code::FORBIDDEN_STATE, span, message, "end the plane with G7 before it"));
    }
    let machine = channel.settings.machine;
    let frame = &channel.standing.setup.frame;
    if !frame.is_translation() || ROTARY_AXES.into_iter().any(|axis| frame.shift(axis) != 0.0) {
        let help = "use a zero offset and shift without rotation, mirror, scale and without values of rotary axes";
        return Err(unsupported(span, "G141 with a zero offset or shift that turns", help));
    }
    let head = channel.modal.tool.head;
    let kinematics = channel.outlet.kinematics.get_or_insert_with(|| Box::new(Kinematics::of_head(machine, head)));
    let count = kinematics.rotary_axes().count();
    let tool_mm = channel.standing.setup.tool_mm;
    let can_place = kinematics.command_on_workpiece(&channel.modal.position.command, &tool_mm).is_some();
    if !(1..=2).contains(&count) || !can_place {
        let message = format!("G141 needs X, Y, Z and one or two rotary axes, and the machine has {count}");
        return Err(fault(Code::NO_AXIS, span, message, "check the topology in the machine file"));
    }
    set(channel, Some(Turning::Axes))
}

/// Changes the meaning of positions; the axes stay.
fn set(channel: &mut Channel<'_>, turning: Option<Turning>) -> Result<(), Fault> {
    channel.outlet.finish();
    let Some(kinematics) = &channel.outlet.kinematics else { return Ok(()) };
    let tool_mm = channel.standing.setup.tool_mm;
    let modal = &mut channel.modal;
    if turning != modal.turning {
        let command = &modal.position.command;
        modal.position.command = match turning {
            Some(_) => kinematics.on_workpiece(command, &tool_mm),
            None => kinematics.command_on_workpiece(command, &tool_mm).unwrap_or(*command),
        };
        // Each linear coordinate depends on all axes.
        let needed: AxisSet = LINEAR_AXES.into_iter().take(3).chain(kinematics.rotary_axes()).collect();
        if !needed.difference(modal.position.known).is_empty() {
            modal.position.keep(modal.position.known.intersection(ROTARY_AXES.into_iter().collect()));
        }
        modal.turning = turning;
    }
    setup::refresh_setup(channel)
}
