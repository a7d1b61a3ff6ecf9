//! System variables of Fanuc: the control state in variables from #1000 on.

use super::call::Call;
use super::channel::Channel;
use super::channel::ToolOffset;
use super::codes::Group;
use super::data_origin::{self, DataOrigin};
use super::forbidden;
use super::modal::Modal;
use super::offsets;
use super::target;
use super::text;
use super::variables::Missing;
use super::zero_offset::System;
use crate::exec::core::contour::Side;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_base::geometry::{AXES, Axis, AxisVector, Frame};
use ncfix_base::source::Span;
use ncfix_machine::snc::{FeedUnit, Kind};

use super::level::Loaded;
use crate::syntax::words::Block;

/// Meaning of a system variable.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meaning {
    /// A value of a zero offset: the system and the axis number.
    Offset(System, u32),
    /// A value of the tool table.
    Tool(u32, Part),
    /// A position: its kind and the axis number.
    Position(Position, u32),
    /// The G code of a group, or the value of an address, of the preceding block.
    Modal(u32),
    /// #3000
    Alarm,
    /// A written value for the control that moves nothing.
    Configured,
    /// A timer of the control: written by the program, known only to the machine.
    Timer,
    /// Known only to the machine.
    Machine,
}

/// Parts of the entry of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    LengthWear,
    Length,
    RadiusWear,
    Radius,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Position {
    /// Position of the program.
    Programmed,
    Machine,
    /// As [`Position::Programmed`], for the gauge point of the spindle.
    Gauge,
    /// Position at which G31 was skipped.
    Skip,
    /// Length compensation.
    Length,
}

const TOOL_PARTS: [Part; 4] = [Part::LengthWear, Part::Length, Part::RadiusWear, Part::Radius];
/// A Haas has the length before its wear (Haas, Mill operator's manual, system variables). Its setting 40 decides whether the others are radii or diameters.
const TOOL_PARTS_OF_HAAS: [Part; 2] = [Part::Length, Part::LengthWear];

/// The meaning of a number; `None` if not supported.
fn meaning(number: u32, is_haas: bool) -> Option<Meaning> {
    let position = |kind: Position, start: u32| Some(Meaning::Position(kind, number - start));
    // Zero offsets are 20 numbers apart.
    let offset = |first: u16, start: u32| {
        let (system, axis) = ((number - start) / 20, (number - start) % 20);
        u16::try_from(system).ok().map(|system| Meaning::Offset(System(first + system), axis))
    };
    match number {
        1000..=1035 => Some(Meaning::Machine),
        1100..=1135 => Some(Meaning::Configured),
        2401..=2800 if is_haas => Some(Meaning::Machine),
        2001..=2800 => {
            let parts: &[Part] = if is_haas { &TOOL_PARTS_OF_HAAS } else { &TOOL_PARTS };
            let part = parts.get((number as usize - 2001) / 200)?;
            Some(Meaning::Tool((number - 2001) % 200 + 1, *part))
        }
        // On a Haas these are inputs, not tools.
        10001..=13999 if is_haas => Some(Meaning::Machine),
        10001..=13999 if !number.is_multiple_of(1000) => {
            let part = TOOL_PARTS.get(number as usize / 1000 - 10)?;
            Some(Meaning::Tool(number % 1000, *part))
        }
        3000 => Some(Meaning::Alarm),
        3001 | 3002 => Some(Meaning::Timer),
        3003..=3007 | 3901 | 3902 => Some(Meaning::Configured),
        3001..=3999 => Some(Meaning::Machine),
        4001..=4130 => Some(Meaning::Modal(number - 4000)),
        4201..=4330 => Some(Meaning::Modal(number - 4200)),
        5001..=5020 => position(Position::Programmed, 5001),
        5021..=5040 => position(Position::Machine, 5021),
        5041..=5060 => position(Position::Gauge, 5041),
        5061..=5080 => position(Position::Skip, 5061),
        5081..=5100 => position(Position::Length, 5081),
        5201..=5220 => offset(0, 5201),
        5221..=5340 => offset(1, 5221),
        7001..=7960 => offset(System::ADDITIONAL + 1, 7001),
        14001..=19999 => offset(System::ADDITIONAL + 1, 14001),
        _ => None,
    }
}

/// The value of a system variable of Fanuc.
pub(super) fn system_variable(channel: &Channel<'_>, number: u32) -> Result<Option<f64>, Missing> {
    let is_haas = channel.settings.machine.control.iso.is_haas();
    let Some(meaning) = meaning(number, is_haas) else { return Err(Missing::Unknown) };
    match meaning {
        Meaning::Alarm | Meaning::Configured | Meaning::Timer | Meaning::Machine => Err(Missing::OnlyMachine),
        Meaning::Offset(system, place) => {
            let axis = axis_at(channel.axes, place).ok_or(Missing::Unknown)?;
            match target::offset_of(channel.settings.machine, &channel.written, system) {
                Some(parts) => Ok(Some(shown_value(&channel.modal, axis, parts.shift()[axis]))),
                None if system == System::EXTERNAL || !channel.settings.strict => Ok(Some(0.0)),
                None => Err(Missing::OnlyMachine),
            }
        }
        Meaning::Tool(number, part) => match channel.written.tools.find(channel.settings.machine, number, 1) {
            Some(mut offset) => Ok(Some(*part_of(&mut offset, part) / channel.modal.modes.scale())),
            None if channel.settings.strict => Err(Missing::OnlyMachine),
            None => Ok(Some(0.0)),
        },
        Meaning::Position(kind, place) => {
            let axis = axis_at(channel.axes, place).ok_or(Missing::Unknown)?;
            position(channel, kind, axis).map(Some)
        }
        Meaning::Modal(place) => {
            modal_value(&channel.modal, &channel.modal_calls, place).map(Some).ok_or(Missing::OnlyMachine)
        }
    }
}

/// The axis of an index in the order of the control: X, Y, Z, then the other axes of the machine.
fn axis_at(axes: AxisSet, place: u32) -> Option<Axis> {
    let place = place as usize;
    if place < 3 {
        return AXES.get(place).copied();
    }
    let rotary_first = [Axis::A, Axis::B, Axis::C, Axis::U, Axis::V, Axis::W];
    rotary_first.into_iter().filter(|&axis| axes.contains(axis)).nth(place - 3)
}

/// A value of an axis in program units.
pub(super) fn shown_value(modal: &Modal, axis: Axis, value: f64) -> f64 {
    if axis.is_rotary() { value.to_degrees() } else { value / modal.modes.scale() }
}

fn position(channel: &Channel<'_>, position: Position, axis: Axis) -> Result<f64, Missing> {
    if position == Position::Length {
        let place = axis.slot();
        return Ok(if place < 3 { channel.modal.tool.length_mm[place] / channel.modal.modes.scale() } else { 0.0 });
    }
    if position == Position::Skip {
        // Only the machine knows the skip position; if not strict, the end of the motion is used.
        let probed = channel.variables.probed.filter(|_| !channel.settings.strict);
        return probed.map(|values| values[axis]).ok_or(Missing::OnlyMachine);
    }
    if channel.settings.strict && !channel.modal.position.known.contains(axis) {
        return Err(Missing::Unstated);
    }
    if channel.modal.contour.compensates() && position != Position::Programmed {
        return Err(Missing::Compensated);
    }
    let values: AxisVector = match position {
        Position::Programmed => work_frame(&channel.modal).unapply(&target::tip(&channel.modal, &channel.standing)),
        Position::Machine => channel.modal.position.command,
        Position::Gauge => work_frame(&channel.modal).unapply(&channel.modal.position.command),
        Position::Skip | Position::Length => AxisVector::ZERO,
    };
    Ok(shown_value(&channel.modal, axis, values[axis]))
}

/// The workpiece coordinate system: zero offset and shifts, without the transformations nearest to the programmed values.
pub(super) fn work_frame(modal: &Modal) -> Frame {
    modal.settable.compose(&Frame::translation(modal.shift + modal.local))
}

/// The G code of a group, or the value of an address.
fn modal_value(modal: &Modal, modal_calls: &[Call], place: u32) -> Option<f64> {
    let either = |is_first: bool, first: u16, second: u16| f64::from(if is_first { first } else { second });
    Some(match place {
        1 if modal.modes.motion <= 330 => f64::from(modal.modes.motion) / 10.0,
        2 => f64::from(modal.modes.plane.number()),
        3 => either(modal.modes.incremental, 91, 90),
        5 => match modal.modes.feed_unit {
            FeedUnit::InverseTime => 93.0,
            FeedUnit::PerMinute => 94.0,
            FeedUnit::PerTurn => 95.0,
        },
        6 => either(modal.modes.inch, 20, 21),
        7 => match modal.contour.side {
            Side::Off => 40.0,
            Side::Left => 41.0,
            Side::Right => 42.0,
        },
        8 => f64::from(modal.code(Group::Length)) / 10.0,
        9 if modal.modes.motion >= 730 => f64::from(modal.modes.motion) / 10.0,
        9 => 80.0,
        10 => either(modal.ends_at_r(), 99, 98),
        12 => either(modal_calls.is_empty(), 67, 66),
        13 => f64::from(modal.code(Group::SpindleMode)) / 10.0,
        14 if modal.system.0 > System::ADDITIONAL => 54.1,
        14 => 53.0 + f64::from(modal.system.0),
        15 => f64::from(modal.code(Group::Control)) / 10.0,
        107 => f64::from(modal.d.unwrap_or(0)),
        109 => {
            modal.modes.feed / if modal.modes.feed_unit == FeedUnit::InverseTime { 1.0 } else { modal.modes.scale() }
        }
        111 => f64::from(modal.h),
        119 => modal.modes.speed?,
        120 => f64::from(modal.tool.selected.or(modal.tool.active)?),
        130 if modal.system.0 > System::ADDITIONAL => f64::from(modal.system.0 - System::ADDITIONAL),
        130 => 0.0,
        _ => return None,
    })
}

/// Executes the assignment to a system variable of Fanuc.
pub(super) fn write_system(
    channel: &mut Channel<'_>,
    number: u32,
    (value, origin): (Option<f64>, Option<DataOrigin>),
    span: Span,
    loaded: &Loaded,
    block: &Block,
) -> Result<(), Fault> {
    let number_value = value.unwrap_or(0.0);
    match meaning(number, channel.settings.machine.control.iso.is_haas()) {
        Some(Meaning::Alarm) => {
            let text = comment_of(loaded, block);
            let message = format!("the program stops with its alarm {number_value}: {text}");
            let help = "the program has raised this alarm itself; correct the cause that it states. If it is the check of --guard, offsets or tools have changed since the correction: correct the original again";
            channel.block.ends_program = true;
            let found = fault(Code::CYCLE_ALARM, span, message.trim_end_matches([':', ' ']), help);
            channel.outlet.warnings.push(found);
            Ok(())
        }
        Some(Meaning::Configured | Meaning::Timer) => {
            let text = if number == 3006 { format!("({})", comment_of(loaded, block)) } else { String::new() };
            tell(&mut channel.outlet, number, number_value, &text);
            Ok(())
        }
        Some(Meaning::Offset(system, place)) => {
            write_offset(channel, number, (system, place), (number_value, origin), span)
        }
        Some(Meaning::Tool(tool, part)) => write_tool(channel, number, (tool, part), (number_value, origin), span),
        Some(Meaning::Machine | Meaning::Position(..) | Meaning::Modal(_)) | None => {
            let message = format!("#{number} cannot be set here");
            Err(bad_value(span, message, "its value is set by the control only"))
        }
    }
}

/// Passes the assignment to a system variable through, with its evaluated value.
fn tell(outlet: &mut MotionSink<'_>, number: u32, value: f64, behind: &str) {
    outlet.push(Kind::Verbatim(format!("#{number}={}{behind}", data_origin::decimals(value)).into_bytes()));
}

/// Passes a new value of data of the control through: a sum with a value of the control, if the program computes it so. `unit` is the factor for the
/// unit of the output.
fn tell_new(
    channel: &mut Channel<'_>,
    number: u32,
    (value, unit): (f64, f64),
    origin: Option<DataOrigin>,
    span: Span,
) -> Result<(), Fault> {
    match origin.map(|origin| origin.text(unit)) {
        Some(Some(sum)) => channel.outlet.push(Kind::Verbatim(format!("#{number}={sum}").into_bytes())),
        Some(None) if channel.settings.strict => return Err(data_origin::not_kept(span)),
        Some(None) | None => tell(&mut channel.outlet, number, value * unit, ""),
    }
    Ok(())
}

/// The place of a number with data of the control: `None` for other numbers, `Some(None)` for values of tools.
pub(super) fn control_data(number: u32, is_haas: bool) -> Option<Option<(System, u32)>> {
    match meaning(number, is_haas)? {
        Meaning::Offset(system, place) => Some(Some((system, place))),
        Meaning::Tool(..) => Some(None),
        _ => None,
    }
}

/// The index of an axis in the order of the control.
pub(super) fn place_of(axes: AxisSet, axis: Axis) -> Option<u32> {
    (0..AXES.len() as u32).find(|&place| axis_at(axes, place) == Some(axis))
}

fn write_offset(
    channel: &mut Channel<'_>,
    number: u32,
    (system, place): (System, u32),
    (value, origin): (f64, Option<DataOrigin>),
    span: Span,
) -> Result<(), Fault> {
    let Some(axis) = axis_at(channel.axes, place) else {
        return Err(bad_value(
            span,
            format!("#{number} belongs to an axis that the machine does not have"),
            "check the number",
        ));
    };
    forbidden::no_compensation(channel.language, &channel.modal, span, "a change of zero offsets")?;
    if system == channel.modal.system || system == System::EXTERNAL {
        forbidden::check_offset_write(channel.settings.machine, channel.language, &channel.modal, number, span)?;
    }
    let known = target::offset_of(channel.settings.machine, &channel.written, system);
    if known.is_none() && channel.settings.strict {
        let words = offsets::words_of(channel.settings.machine, system);
        let message = format!("{words} is changed only in part, but has no value in the machine file");
        return Err(fault(Code::NO_OFFSET, span, message, format!("add [zero_offset.\"{words}\"]")));
    }
    let mut parts = known.unwrap_or_default();
    let inside = if axis.is_rotary() { value.to_radians() } else { value * channel.modal.modes.scale() };
    parts.translation[axis] = inside;
    parts.fine[axis] = 0.0;
    channel.written.offsets.insert(system, parts);
    channel.written.shown.remove(&system);
    let unit = if axis.is_rotary() {
        1.0
    } else {
        channel.modal.modes.scale() / text::output_unit_mm(channel.settings.machine)
    };
    channel.written.state((system, place), origin.is_none());
    if origin.is_some_and(|origin| origin.adds_to(number)) {
        channel.written.growing.entry((system, place)).or_insert(channel.outlet.origin);
    }
    tell_new(channel, number, (value, unit), origin, span)?;
    if system == channel.modal.system || system == System::EXTERNAL {
        offsets::load_offset(channel, span)?;
    }
    Ok(())
}

fn write_tool(
    channel: &mut Channel<'_>,
    number: u32,
    (tool, part): (u32, Part),
    (value, origin): (f64, Option<DataOrigin>),
    span: Span,
) -> Result<(), Fault> {
    let known = channel.written.tools.find(channel.settings.machine, tool, 1);
    if known.is_none() && channel.settings.strict {
        let message = format!("offset {tool} is changed only in part, but has no value in the machine file");
        return Err(fault(Code::NO_TOOL, span, message, "add a [[tool]] entry of this number"));
    }
    let mut offset = known.unwrap_or_default();
    let inside = value * channel.modal.modes.scale();
    if part == Part::Radius {
        channel.outlet.check_radius(&format!("register {tool}"), inside, span)?;
    }
    *part_of(&mut offset, part) = inside;
    channel.written.tools.write(tool, 1, ToolOffset { is_stated: true, ..offset });
    let unit = channel.modal.modes.scale() / text::output_unit_mm(channel.settings.machine);
    tell_new(channel, number, (value, unit), origin, span)
}

fn part_of(offset: &mut ToolOffset, part: Part) -> &mut f64 {
    match part {
        Part::LengthWear => &mut offset.length_wear_mm,
        Part::Length => &mut offset.length_mm[2],
        Part::RadiusWear => &mut offset.radius_wear_mm,
        Part::Radius => &mut offset.radius_mm,
    }
}

/// The text of the first comment of a block.
fn comment_of(loaded: &Loaded, block: &Block) -> String {
    let comment = loaded.program.comments_of(block).first();
    comment.map_or_else(String::new, |comment| {
        String::from_utf8_lossy(loaded.program.source.slice(comment.text)).trim().to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_mean_what_the_tables_of_the_control_say() {
        assert_eq!(meaning(2001, false), Some(Meaning::Tool(1, Part::LengthWear)));
        assert_eq!(meaning(2400, false), Some(Meaning::Tool(200, Part::Length)));
        assert_eq!(meaning(2601, false), Some(Meaning::Tool(1, Part::Radius)));
        // Haas, Mill operator's manual: lengths, and their wear.
        assert_eq!(meaning(2001, true), Some(Meaning::Tool(1, Part::Length)));
        assert_eq!(meaning(2201, true), Some(Meaning::Tool(1, Part::LengthWear)));
        assert_eq!(meaning(2401, true), Some(Meaning::Machine));
        assert_eq!(meaning(12005, true), Some(Meaning::Machine));
        assert_eq!(meaning(12005, false), Some(Meaning::Tool(5, Part::RadiusWear)));
        assert_eq!(meaning(5203, false), Some(Meaning::Offset(System::EXTERNAL, 2)));
        assert_eq!(meaning(5221, false), Some(Meaning::Offset(System(1), 0)));
        assert_eq!(meaning(5322, false), Some(Meaning::Offset(System(6), 1)));
        assert_eq!(meaning(7021, false), Some(Meaning::Offset(System(System::ADDITIONAL + 2), 0)));
        assert_eq!(meaning(5043, false), Some(Meaning::Position(Position::Gauge, 2)));
        assert_eq!(meaning(999_999, false), None);
    }
}
