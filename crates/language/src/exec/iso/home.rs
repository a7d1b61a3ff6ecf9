//! Reference points: G28, G30 and their positions.

use super::channel::Channel;
use super::codes::{Group, name_of};
use super::forbidden;
use super::gathered::Gathered;
use super::step;
use super::step::Step;
use super::target;
use super::variables::Variables;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AXES, Axis, AxisSet, Vector};
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Kind, MotionMode};

/// First parameter of the position of G28, then of G30; one for each axis X Y Z A B C U V W.
const PARAMETERS: [u32; 2] = [5161, 5181];

/// `G28`, `G30`: rapid through the named intermediate point to the reference point, with the named axes or all of them.
pub(super) fn home(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    let span = gathered.code_span(Group::Action);
    forbidden::no_compensation(channel.language, &channel.modal, span, &name_of(code))?;
    let is_second = code == 300;
    let point = match gathered.raw(b'P').filter(|_| is_second && !channel.is_rs274()) {
        None => 1 + u8::from(is_second),
        Some(number) if (2.0..=4.0).contains(&number) => number.round() as u8,
        Some(_) => return Err(bad_value(gathered.span_of(b'P'), "G30 has the points 2, 3 and 4", "write P2")),
    };
    // Through the current axis position, wherever it is: `G91 G28 Z0` at the start of a program.
    let mut stays = channel.modal.modes.incremental;
    for axis in gathered.axes.iter() {
        stays &= target::axis_value(channel, gathered, axis)? == 0.0;
    }
    let is_on_the_way = stays || leads_home(channel, gathered, point, span)?;
    let (through, named) = if is_on_the_way {
        (target::here(&channel.modal, &channel.standing), gathered.axes)
    } else {
        step::end(channel, gathered)?
    };
    // Directly after G40 the tool of LinuxCNC is beside the programmed position, and goes there first.
    let is_beside = channel.is_rs274() && channel.outlet.is_holding();
    if !named.is_empty() && (through != target::here(&channel.modal, &channel.standing) || is_beside) {
        step::step(channel, Step::straight(gathered, true, through, named))?;
        channel.outlet.begin_line();
    }
    channel.written.via.note(channel.modal.position.command);
    let is_all = channel.is_rs274() || channel.settings.machine.control.iso.is_haas();
    let homed = if named.is_empty() && is_all { channel.axes } else { named };
    if homed.is_empty() {
        let help = "name the axes; for a Haas, where all axes return, set controller = \"haas\" in the machine file";
        return Err(bad_value(span, format!("{} without axis words", name_of(code)), help));
    }
    let mut end = channel.modal.position.command;
    for axis in homed.iter() {
        end[axis] = reference(channel.settings.machine, channel.language, &channel.variables, point, axis, span)?;
    }
    let motion_mode = MotionMode::Reference;
    let step = Step { feed_named: false, motion_mode, ..Step::straight(gathered, true, end, homed) };
    step::machine_step(channel, step)?;
    let is_haas = channel.settings.machine.control.iso.is_haas();
    if is_haas && code == 280 && channel.modal.tool.length_mm != Vector::zeros() {
        // Mill operator's manual 96-8000, G28: it cancels tool length offsets for the blocks after it.
        channel.modal.length_ended = true;
    }
    Ok(())
}

/// `true` if one axis of unknown position moves by its increment to the intermediate point: `G91 G28 Z1.` at the start of a program. Both motions are
/// along this axis, so they pass all places of the direct way. A motion away from a reference point at the end of the travel is not accepted.
fn leads_home(channel: &mut Channel<'_>, gathered: &Gathered, point: u8, span: Span) -> Result<bool, Fault> {
    let mut axes = gathered.axes.iter();
    let (Some(axis), None) = (axes.next(), axes.next()) else { return Ok(false) };
    let is_open = channel.modal.modes.incremental && !channel.modal.position.known.contains(axis);
    if !is_open || channel.is_rs274() || !channel.standing.setup.frame.is_translation() {
        return Ok(false);
    }
    let by = target::axis_value(channel, gathered, axis)?;
    let machine = channel.settings.machine;
    let Some([low, high]) = machine.axis(axis).and_then(|data| data.travel) else { return Ok(true) };
    let home = reference(machine, channel.language, &channel.variables, point, axis, span)?;
    Ok(if by > 0.0 { home > low } else { home < high })
}

/// Position of a reference point of an axis, mm or rad.
fn reference(
    machine: &Machine,
    language: Language,
    variables: &Variables,
    point: u8,
    axis: Axis,
    span: Span,
) -> Result<f64, Fault> {
    if language == Language::Rs274 {
        let first = PARAMETERS.get(usize::from(point) - 1).copied().unwrap_or_default();
        let value = variables.get(first + axis.slot() as u32).unwrap_or_default();
        return Ok(if axis.is_rotary() { value.to_radians() } else { value });
    }
    let points = &machine.control.iso.reference_points;
    match points.get(&(point, axis)) {
        Some(&value) => Ok(value),
        // The first reference point is usually the machine zero.
        None if point == 1 => Ok(0.0),
        None => {
            let message = format!("the machine file does not give reference point {point} of {axis}");
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            let help = format!("set control.reference_point_{point}_{axis}_{unit} there");
            Err(fault(Code::NO_SYSTEM_VALUE, span, message, help))
        }
    }
}

/// `G28.1`, `G30.1`: stores the current position as the reference point.
pub(super) fn save_home(channel: &mut Channel<'_>, code: u16, span: Span) -> Result<(), Fault> {
    forbidden::no_compensation(channel.language, &channel.modal, span, &name_of(code))?;
    if let Some(axis) =
        AxisSet::XYZ.iter().find(|&axis| channel.settings.strict && !channel.modal.position.known.contains(axis))
    {
        return Err(channel.modal.position.unknown(span, axis));
    }
    if channel.settings.strict {
        let message = format!("{} would store the corrected axis positions", name_of(code));
        let help = "omit it, and move there with G53 G0 instead of G28 or G30";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    let first = PARAMETERS[usize::from(code == 301)];
    for axis in AXES {
        let value = channel.modal.position.command[axis];
        let saved = if axis.is_rotary() { value.to_degrees() } else { value };
        channel.variables.set(first + axis.slot() as u32, Some(saved));
    }
    channel.push(Kind::Keep(if code == 281 { "G28.1" } else { "G30.1" }));
    Ok(())
}
