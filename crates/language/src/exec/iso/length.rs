//! Tool length compensation: G43, G44, G49 and the offset tables.

use super::channel::Channel;
use super::channel::WrittenData;
use super::codes::{Group, name_of};
use super::forbidden;
use super::gathered::Gathered;
use super::measure::whole;
use super::modal::Modal;
use super::setup;
use super::target;
use super::text;
use super::tilt;
use super::tip;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::settings::RunSettings;
use crate::exec::core::tool::without_value;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, Vector};
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::machine::LengthAxis;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Kind, Word, WordValue};

/// Lengths that differ by less are those of one tool, for example with another wear, mm.
const SAME_TOOL_MM: f64 = 1.0;

/// Executes the code of length compensation. Returns `true` if it consumed the axis words, so that the block has no motion.
pub(super) fn length_codes(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<bool, Fault> {
    let code = gathered.code(Group::Length);
    let Some(code) = code.or_else(|| again(channel.language, &channel.modal, gathered)) else { return Ok(false) };
    let span =
        if gathered.code(Group::Length).is_some() { gathered.code_span(Group::Length) } else { gathered.span_of(b'H') };
    if channel.is_rs274() {
        forbidden::no_compensation(channel.language, &channel.modal, span, &name_of(code))?;
        rs274_length(channel, gathered, code, span)
    } else {
        fanuc_length(channel, gathered, code, span)?;
        Ok(false)
    }
}

/// H alone changes the offset while compensation is active (Fanuc), also in the block of a reference motion: `G91 G28 Z0 H0`.
fn again(language: Language, modal: &Modal, gathered: &Gathered) -> Option<u16> {
    let code = modal.code(Group::Length);
    let is_free = matches!(gathered.code(Group::Action), None | Some(280 | 300));
    (language != Language::Rs274 && code != 490 && gathered.has(b'H') && is_free).then_some(code)
}

fn rs274_length(channel: &mut Channel<'_>, gathered: &Gathered, code: u16, span: Span) -> Result<bool, Fault> {
    let mut length = if code == 490 || code == 430 { Vector::zeros() } else { channel.modal.tool.length_mm };
    let mut text = name_of(code);
    let (mut takes_axes, mut assumed) = (false, false);
    match code {
        430 => {
            let number = match gathered.raw(b'H') {
                Some(value) => whole(value, gathered.span_of(b'H'), "H")?,
                None => channel.modal.tool.active.unwrap_or(0),
            };
            if gathered.has(b'H') {
                text::append(channel.language, &mut text, b'H', f64::from(number));
            }
            (length, assumed) = table_length(&channel.settings, &channel.written, &mut channel.outlet, number, span)?;
            channel.modal.h = number;
        }
        432 if gathered.has(b'H') => {
            let number = whole(gathered.raw(b'H').unwrap_or(0.0), gathered.span_of(b'H'), "H")?;
            text::append(channel.language, &mut text, b'H', f64::from(number));
            let (more, is_assumed) =
                table_length(&channel.settings, &channel.written, &mut channel.outlet, number, span)?;
            length += more;
            assumed = is_assumed;
        }
        431 | 432 => {
            takes_axes = true;
            for axis in gathered.axes.iter() {
                if !AxisSet::XYZ.contains(axis) {
                    let message = format!("a tool offset along {axis} is not supported");
                    let at = gathered.span_of(axis.letter());
                    return Err(fault(Code::NOT_SUPPORTED, at, message, "program X, Y or Z"));
                }
                let value = target::axis_value(channel, gathered, axis)?;
                let place = &mut length[axis.slot()];
                *place = if code == 431 { value } else { *place + value };
                text::append_length(channel.settings.machine, channel.language, &mut text, axis.letter(), value);
            }
        }
        _ => {}
    }
    channel.modal.codes.set(Group::Length, code);
    setup::put_length(channel, length, assumed);
    channel.push(Kind::Verbatim(text.into_bytes()));
    Ok(takes_axes)
}

/// The offset for a number, and `true` if it is assumed.
fn table_length(
    settings: &RunSettings<'_>,
    written: &WrittenData,
    outlet: &mut MotionSink<'_>,
    number: u32,
    span: Span,
) -> Result<(Vector, bool), Fault> {
    if number == 0 {
        return Ok((Vector::zeros(), false));
    }
    if let Some(size) = written.tools.size(settings.machine, number, 1) {
        let [along_z, along_y, along_x] = size.length_mm;
        return Ok((Vector::new(along_x, along_y, along_z), false));
    }
    let message = format!("tool offset {number} has no value in the machine file");
    let help = "add a [[tool]] entry of this number there or in a file given with --setup";
    without_value(settings.requires_values, &mut outlet.warnings, span, &message, "length 0", help)?;
    Ok((Vector::zeros(), true))
}

/// Warns once if H is the number of another tool than the one in the spindle, and both lengths are known and differ.
fn warn_of_other_tool(channel: &mut Channel<'_>, length_mm: f64, span: Span) {
    let (h, Some(number)) = (channel.modal.h, channel.modal.tool.active) else { return };
    if channel.warned.length || h == number || h == 0 || number == 0 {
        return;
    }
    let Some(tool) = channel.written.tools.size(channel.settings.machine, number, 1) else { return };
    let own_mm = tool.length_mm[0];
    if (own_mm - length_mm).abs() <= SAME_TOOL_MM {
        return;
    }
    channel.warned.length = true;
    let message = format!(
        "T{number} is in the spindle with the length of H{h}: {length_mm:.3} mm in the machine file, and T{number} has {own_mm:.3} mm"
    );
    let help = format!(
        "write H{number}, if H{h} is the length of another tool; if T{number} has two offsets, nothing is wrong"
    );
    channel.outlet.warnings.push(fault(Code::OTHER_LENGTH, span, message, help));
}

fn fanuc_length(channel: &mut Channel<'_>, gathered: &Gathered, code: u16, span: Span) -> Result<(), Fault> {
    if code == 431 {
        let message = "G43.1 is not supported";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "use G43 H with the length of the tool"));
    }
    if let Some(value) = gathered.raw(b'H') {
        channel.modal.h = whole(value, gathered.span_of(b'H'), "H")?;
        channel.modal.has_h = true;
    }
    let is_off = code == 490;
    channel.modal.length_ended = false;
    if !is_off && !channel.modal.has_h {
        let message = format!("{} without H: the control would use the H of an earlier program", name_of(code));
        let number = channel.modal.tool.active.filter(|number| *number > 0).unwrap_or(1);
        let help = format!(
            "write the number of the offset with it, for example {} H{number}; a program of LinuxCNC, where G43 takes the tool in the spindle, needs a machine file with controller = \"rs274\"",
            name_of(code)
        );
        without_value(
            channel.settings.requires_values,
            &mut channel.outlet.warnings,
            span,
            &message,
            "length 0",
            &help,
        )?;
    }
    let (table, assumed) = if is_off {
        (Vector::zeros(), false)
    } else {
        table_length(&channel.settings, &channel.written, &mut channel.outlet, channel.modal.h, span)?
    };
    if !is_off {
        warn_of_other_tool(channel, table[2], span);
    }
    let size = if code == 440 { -table[2] } else { table[2] };
    // Along several axes if several blocks command it; G49 ends all of them, H0 that of its axis.
    let mut length = Vector::zeros();
    if !is_off {
        if channel.settings.machine.control.iso.length_axis != LengthAxis::Z {
            length = channel.modal.tool.length_mm;
        }
        if size != 0.0 || length != Vector::zeros() {
            let is_along_tool = matches!(code, 434 | 435);
            let axis = if is_along_tool {
                Axis::Z
            } else {
                length_axis(channel.settings.machine, &channel.modal, gathered, span)?
            };
            length[axis.slot()] = size;
        }
    }
    if channel.modal.transforms.turns(&length) {
        return Err(setup::turned_length(span));
    }
    let (was_turning, tool_mm, axes) = (
        channel.modal.turning.is_some(),
        channel.standing.setup.tool_mm,
        tip::axis_command(&channel.modal, &channel.standing, &channel.outlet),
    );
    tip::switch_tip(channel, code, gathered, span)?;
    channel.modal.codes.set(Group::Length, code);
    setup::put_length(channel, length, assumed);
    if !is_off {
        tilt::stand_anew(channel, span)?;
    }
    if was_turning || channel.modal.turning.is_some() {
        tip::forget_moved_tip(&mut channel.modal, &channel.standing, &mut channel.outlet, &axes, &tool_mm);
    }
    match code {
        430 => channel.push(Kind::Keep("G43")),
        440 => channel.push(Kind::Keep("G44")),
        // The output gives positions of the rotary axes, even if the program gives directions.
        434 | 435 if channel.settings.machine.control.iso.is_haas() => channel.push(Kind::Keep("G234")),
        434 | 435 => channel.push(Kind::Keep("G43.4")),
        _ => channel.push(Kind::Keep("G49")),
    }
    if gathered.has(b'H') {
        let value = WordValue::Number(f64::from(channel.modal.h));
        channel.block.before.push(Word { letter: b'H', extension: None, value });
    }
    Ok(())
}

/// The axis along which a Fanuc compensates (parameter 5001).
fn length_axis(machine: &Machine, modal: &Modal, gathered: &Gathered, span: Span) -> Result<Axis, Fault> {
    match machine.control.iso.length_axis {
        LengthAxis::Z => Ok(Axis::Z),
        LengthAxis::Plane => {
            let [.., applicate] = modal.modes.plane.axes();
            Ok(applicate)
        }
        LengthAxis::Programmed => {
            let mut named = gathered.axes.intersection(AxisSet::XYZ).iter();
            match (named.next(), named.next()) {
                (Some(axis), None) => Ok(axis),
                (None, _) => {
                    let has_length = |axis: &Axis| modal.tool.length_mm[axis.slot()] != 0.0;
                    let mut in_force = AxisSet::XYZ.iter().filter(has_length);
                    match (in_force.next(), in_force.next()) {
                        (Some(_), Some(_)) => Err(unclear_axis(span)),
                        (axis, _) => Ok(axis.unwrap_or(Axis::Z)),
                    }
                }
                _ => Err(unclear_axis(span)),
            }
        }
    }
}

fn unclear_axis(span: Span) -> Fault {
    bad_value(span, "the axis of the length offset is ambiguous", "name one of X, Y, Z with G43")
}
