//! Tool center point control: G43.4 and G43.5.
//!
//! Under it the positions of the channel are those of the tip, fixed to the workpiece; [`crate::exec::core::five_axis`] converts them to axis
//! commands.

use super::modal::Modal;
use super::target;
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::standing::InForce;
use std::f64::consts::TAU;

use super::channel::Channel;
use super::gathered::Gathered;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, AxisVector, LINEAR_AXES, ROTARY_AXES, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::Kinematics;
use ncfix_machine::snc::Turning;

/// Angles nearer to each other than this are equal, rad.
const SAME_ANGLE_RAD: f64 = 1e-9;
/// Upper bound of rotary axis corrections, rad.
const CORRECTED_ANGLE_RAD: f64 = 1e-3;
/// Positions nearer to each other than this are equal, mm.
const SAME_PLACE_MM: f64 = 1e-9;

/// Switches tip control by the code of length compensation, in tenths.
pub(super) fn switch_tip(channel: &mut Channel<'_>, code: u16, gathered: &Gathered, span: Span) -> Result<(), Fault> {
    let turning = match code {
        434 | 435 => Some(Turning::Axes),
        _ => None,
    };
    if turning == channel.modal.turning {
        return Ok(());
    }
    if channel.modal.contour.compensates() {
        let message = "tool center point control begins or ends while radius compensation is on";
        let help = "program G40 with a motion in the plane before it";
        return Err(fault(Code::BAD_COMPENSATION, span, message, help));
    }
    if turning.is_some() && channel.modal.turned_zero.is_some() {
        let message = "tool center point control (G234) while G254 is in force";
        return Err(fault(Code::FORBIDDEN_STATE, span, message, "program G255 before it"));
    }
    if turning.is_some() && !channel.modal.transforms.is_empty() {
        let message = "tool center point control (G43.4) within a rotation, scaling, mirror or tilted plane";
        let help = "end them with G69, G50 and G50.1 before G43.4";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    if turning.is_some() {
        let (machine, head) = (channel.settings.machine, channel.modal.tool.head);
        let kinematics = channel.outlet.kinematics.get_or_insert_with(|| Box::new(Kinematics::of_head(machine, head)));
        let rotary = kinematics.rotary_axes().count();
        let can = (1..=2).contains(&rotary)
            && kinematics
                .command_on_workpiece(&channel.modal.position.command, &channel.standing.setup.tool_mm)
                .is_some();
        if !can {
            let message = format!("G43.4 needs X, Y, Z and one or two rotary axes, and the machine has {rotary}");
            return Err(fault(Code::NO_AXIS, span, message, "check the topology in the machine file"));
        }
    }
    let is_table_turned = turning.is_some() && check_table(channel, gathered, span)?;
    channel.outlet.finish();
    let Some(kinematics) = &channel.outlet.kinematics else { return Ok(()) };
    let tool_mm = channel.standing.setup.tool_mm;
    let modal = &mut channel.modal;
    modal.turning = turning;
    modal.position.command = if turning.is_some() {
        kinematics.on_workpiece(&modal.position.command, &tool_mm)
    } else {
        kinematics.command_on_workpiece(&modal.position.command, &tool_mm).unwrap_or(modal.position.command)
    };
    // Each linear coordinate depends on all axes.
    let needed: AxisSet = LINEAR_AXES.into_iter().take(3).chain(kinematics.rotary_axes()).collect();
    // With a turned table, no manual states whether an axis without a word keeps its place or its value.
    if is_table_turned || !needed.difference(modal.position.known).is_empty() {
        modal.position.keep(modal.position.known.intersection(ROTARY_AXES.into_iter().collect()));
    }
    Ok(())
}

/// Checks the table at the start of tip control, and returns true if it is turned there.
///
/// The tip coordinates are those of the work coordinate system on the table at that moment, even within that block (Fanuc parameter 19696, bit 5 as
/// delivered), or those on the table at zero (a Haas, `tip_coordinates`). Both equal those of the zero offset if the table is at zero.
fn check_table(channel: &mut Channel<'_>, gathered: &Gathered, span: Span) -> Result<bool, Fault> {
    let iso = &channel.settings.machine.control.iso;
    let (is_of_zero, name) = (iso.tip_of_table_at_zero, if iso.is_haas() { "G234" } else { "G43.4" });
    let mut is_turned = false;
    for &axis in channel.settings.machine.topology.workpiece.iter().filter(|axis| axis.is_rotary()) {
        let (here, is_known) = (channel.modal.position.command[axis], channel.modal.position.known.contains(axis));
        let shift = channel.standing.setup.frame.shift(axis);
        let mut places = vec![here];
        if gathered.axes.contains(axis) {
            let value = target::axis_value(channel, gathered, axis)?;
            let end = value + if channel.modal.modes.incremental { here } else { shift };
            places = if is_known { vec![here, end] } else { vec![end] };
        } else {
            target::check_stated(channel.settings.strict, &channel.modal, axis, span)?;
        }
        // In a corrected program the table is at its corrected position.
        let most = if channel.settings.strict { SAME_ANGLE_RAD } else { CORRECTED_ANGLE_RAD };
        let is_zero = |place: &f64| (place - (place / TAU).round() * TAU).abs() < most;
        if places.iter().all(is_zero) {
            continue;
        }
        if is_of_zero && shift != 0.0 {
            let message = format!("{name} while {axis}, which carries the workpiece, is turned and has a work offset");
            let help = format!("set the work offset of {axis} to 0, or program {name} while the table is at zero");
            return Err(fault(Code::NOT_SUPPORTED, span, message, help));
        }
        if !is_of_zero {
            let message = format!("{name} while {axis}, which carries the workpiece, is not at machine zero");
            let help = "program G43.4 while the table is at zero, and turn it afterwards; if the coordinates of the program are \
                        those with the table at zero, and the control reads them so, set control.tip_coordinates = \
                        \"table_at_zero\"";
            return Err(fault(Code::NOT_SUPPORTED, span, message, help));
        }
        is_turned = true;
    }
    Ok(is_turned)
}

/// Current axis commands.
pub(super) fn axis_command(modal: &Modal, standing: &InForce, outlet: &MotionSink<'_>) -> AxisVector {
    let turning = modal.turning.and(outlet.kinematics.as_deref());
    let command =
        turning.and_then(|chain| chain.command_on_workpiece(&modal.position.command, &standing.setup.tool_mm));
    command.unwrap_or(modal.position.command)
}

/// Records a change of the tool length from `tool_mm` with the axes at `axes`. Along a tilted tool it affects other axes too: their position in the
/// control is unknown until the program states it.
pub(super) fn forget_moved_tip(
    modal: &mut Modal,
    standing: &InForce,
    outlet: &mut MotionSink<'_>,
    axes: &AxisVector,
    tool_mm: &Vector,
) {
    let Some(kinematics) = &outlet.kinematics else { return };
    let before = kinematics.on_workpiece(axes, tool_mm);
    let now = kinematics.on_workpiece(axes, &standing.setup.tool_mm);
    for axis in AxisSet::XYZ.iter().filter(|&axis| (before[axis] - now[axis]).abs() > SAME_PLACE_MM) {
        modal.position.keep(modal.position.known.difference([axis].into_iter().collect()));
    }
    if modal.turning.is_some() {
        modal.position.command = now;
    }
}
