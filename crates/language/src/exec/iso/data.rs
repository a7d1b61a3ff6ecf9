//! G10: zero offsets and tool offsets set by the program. The control stores them permanently, so the output sets them too: as values, or, if the
//! control computes them from its position, in the same manner.

use super::data_origin;
use super::forbidden;
use super::measure;
use super::modal::Modal;
use super::offsets;
use super::origin;
use super::system;
use super::target;
use super::text;
use crate::exec::core::growing_offsets;
use crate::exec::core::motion_sink::MotionSink;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;

use super::channel::Channel;
use super::channel::ShownZero;
use super::channel::ToolOffset;
use super::codes::Group;
use super::gathered::Gathered;
use super::zero_offset::System;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, FrameParts};
use ncfix_base::source::Span;
use ncfix_machine::snc::{HereStatement, Kind};

/// `G10`
pub(super) fn set_data(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let span = gathered.code_span(Group::Action);
    check_unit(channel, gathered, span)?;
    let (l, p) = (gathered.raw(b'L'), gathered.raw(b'P'));
    let number = p.map(f64::round).filter(|number| (0.0..=9999.0).contains(number)).map(|number| number as u32);
    let l = l.map_or(-1, |l| l.round() as i64);
    match (l, number) {
        (2, number) => {
            set_offset(channel, gathered, System(system_number(channel.language, &channel.modal, number, span)?), span)
        }
        (20, number) if channel.is_rs274() => {
            set_offset(channel, gathered, System(system_number(channel.language, &channel.modal, number, span)?), span)
        }
        (20, Some(number @ 1..=300)) => set_offset(channel, gathered, System(System::ADDITIONAL + number as u16), span),
        (1 | 10 | 11, Some(number)) if channel.is_rs274() => set_tool(channel, gathered, l, number, span),
        (1 | 10..=13, Some(number)) if !channel.is_rs274() => set_tool_value(channel, gathered, l, number, span),
        (50, _) => {
            let message = "G10 L50 changes parameters of the control";
            Err(fault(Code::OWN_COMPENSATION, span, message, "set them at the control, not in the part program"))
        }
        _ => {
            let message = "this G10 is not supported";
            Err(fault(Code::NOT_SUPPORTED, span, message, "L2, L20, L1 and L10 to L13 with P are"))
        }
    }
}

/// Rejects lengths before the G20 of the program: the control keeps the unit of the program before, and the output begins with G20.
fn check_unit(channel: &Channel<'_>, gathered: &Gathered, span: Span) -> Result<(), Fault> {
    let is_later_inch = channel.settings.machine.control.output_inch == Some(true) && !channel.modal.modes.inch;
    let has_length = || b"XYZUVWR".iter().any(|&letter| gathered.raw_quietly(letter).is_some_and(|value| value != 0.0));
    if channel.is_rs274() || !is_later_inch || !has_length() {
        return Ok(());
    }
    let message = "G10 stands before the G20 of the program, so the unit of its values is that of the program before";
    Err(fault(Code::MIXED_UNITS, span, message, "write G20 before it, and its values in inches"))
}

/// The system for P of G10 L2.
fn system_number(language: Language, modal: &Modal, number: Option<u32>, span: Span) -> Result<u16, Fault> {
    let most = if language == Language::Rs274 { 9 } else { 6 };
    match number {
        // 0 is the active system, on a Fanuc the offset of all systems.
        Some(0) if language == Language::Rs274 => Ok(modal.system.0),
        Some(number) if number <= most => Ok(number as u16),
        None if language != Language::Rs274 => Ok(modal.system.0),
        _ => Err(bad_value(span, format!("G10 needs P from 0 to {most}"), "P1 is G54")),
    }
}

fn set_offset(channel: &mut Channel<'_>, gathered: &Gathered, system: System, span: Span) -> Result<(), Fault> {
    let is_relative = channel.is_rs274() && gathered.raw(b'L').is_some_and(|l| l.round() == 20.0);
    // The place of a compensated tool is not the programmed one.
    if system == channel.modal.system || is_relative {
        forbidden::no_compensation(channel.language, &channel.modal, span, "G10")?;
    }
    let known = target::offset_of(channel.settings.machine, &channel.written, system);
    let mut parts = known.unwrap_or_default();
    let mut sums = Vec::new();
    if let Some(angle) = gathered.raw(b'R').filter(|_| channel.is_rs274() && !is_relative) {
        parts.rotation[2] = angle.to_radians();
        sums.extend(sum_of(channel, gathered, b'R', false)?);
        let origin = gathered.origin(b'R');
        channel.written.state((system, ROTATION), origin.is_none());
        if origin.is_some_and(|origin| origin::adds_to(channel, origin, (system, ROTATION))) {
            channel.written.growing.entry((system, ROTATION)).or_insert(channel.outlet.origin);
        }
    }
    let mut here = None;
    // On a Fanuc, G91 adds to the existing value. The output adds too: the value of the control may differ from that of the machine file.
    let adds = channel.modal.modes.incremental && !channel.is_rs274();
    let mut steps = AxisVector::ZERO;
    if is_relative {
        here = Some(place_here(channel, gathered, system, &mut parts)?);
        // The zero depends on that of the control.
        channel.written.stated.retain(|(known, _)| *known != system);
    } else {
        for axis in gathered.axes.iter() {
            let value = target::axis_value(channel, gathered, axis)?;
            if adds && known.is_none() && channel.settings.strict {
                let words = offsets::words_of(channel.settings.machine, system);
                let message = format!("{words} is changed incrementally, but has no value in the machine file");
                return Err(fault(Code::NO_OFFSET, span, message, format!("add [zero_offset.\"{words}\"]")));
            }
            sums.extend(sum_of(channel, gathered, axis.letter(), adds)?);
            let place = if channel.is_rs274() { place_of_rs274(axis) } else { system::place_of(channel.axes, axis) };
            if let Some(place) = place {
                let was_stated = !adds || channel.written.stated.contains(&(system, place));
                let origin = gathered.origin(axis.letter());
                channel.written.state((system, place), was_stated && origin.is_none());
                if !was_stated || origin.is_some_and(|origin| origin::adds_to(channel, origin, (system, place))) {
                    channel.written.growing.entry((system, place)).or_insert(channel.outlet.origin);
                }
            }
            steps[axis] = value;
            parts.translation[axis] = value + if adds { parts.shift()[axis] } else { 0.0 };
            parts.fine[axis] = 0.0;
        }
    }
    match here {
        Some(here) => channel.push(Kind::Here(Box::new(here))),
        None => say_offset(
            channel.settings.machine,
            channel.language,
            &mut channel.outlet,
            system,
            (&parts, adds.then_some(&steps)),
            gathered.axes,
            (gathered.has(b'R'), &sums),
        ),
    }
    // Without a value in the machine file an offset is known once the program sets X, Y and Z. The offset of all systems counts as zero.
    let is_external = system == System::EXTERNAL;
    if known.is_some() || is_external || !channel.settings.strict || AxisSet::XYZ.difference(gathered.axes).is_empty() {
        channel.written.offsets.insert(system, parts);
        let is_whole = system == channel.modal.system || AxisSet::XYZ.difference(gathered.axes).is_empty();
        if is_relative && is_whole {
            let shown = ShownZero { index: channel.modal.zero, written: channel.modal.written_zero.clone() };
            channel.written.shown.insert(system, shown);
        } else {
            channel.written.shown.remove(&system);
        }
    }
    if system == channel.modal.system || is_external {
        offsets::load_offset(channel, span)?;
    }
    Ok(())
}

/// `G10 L20`: shifts a system so that the current position has the given values. Returns the statement for the output.
fn place_here(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    system: System,
    parts: &mut FrameParts,
) -> Result<HereStatement, Fault> {
    let order = channel.settings.machine.control.rotation_order;
    let mut wanted = target::frame_of(channel.settings.machine, &channel.written, system)
        .unapply(&target::tip(&channel.modal, &channel.standing));
    let shift = channel.modal.shift;
    wanted = wanted - shift;
    for axis in gathered.axes.iter() {
        target::check_here(channel.settings.strict, &channel.modal, axis, gathered.span_of(axis.letter()))?;
        wanted[axis] = target::axis_value(channel, gathered, axis)?;
    }
    // The rotated target position, subtracted from the tip position.
    let turned = FrameParts { translation: AxisVector::ZERO, ..*parts };
    let Some(turned) = turned.frame(order) else {
        let message = format!("the frame of {} cannot be undone", offsets::words_of(channel.settings.machine, system));
        return Err(fault(Code::NOT_COMPUTABLE, gathered.span, message, "check its factors"));
    };
    let in_plane: AxisSet = [Axis::X, Axis::Y].into_iter().collect();
    let of_plane = gathered.axes.intersection(in_plane);
    // In turned coordinates, a new value of X shifts the zero along X and Y of the machine.
    let is_mixed = !turned.is_translation() && !of_plane.is_empty();
    if is_mixed && of_plane != in_plane && system != channel.modal.system && channel.settings.strict {
        let words = offsets::words_of(channel.settings.machine, system);
        let message = format!("G10 L20 of {words}, which is turned and not in force, with only one of X and Y");
        return Err(fault(Code::NOT_SUPPORTED, gathered.span, message, "program both X and Y"));
    }
    let named = if is_mixed { gathered.axes.union(in_plane) } else { gathered.axes };
    let command = channel.modal.position.command;
    // The output has no G92: its shift is a part of the values.
    let values = wanted + shift;
    let place = target::tip(&channel.modal, &channel.standing) - turned.apply(&values);
    let touched = if turned.is_translation() { gathered.axes } else { gathered.axes.union(AxisSet::XYZ) };
    for axis in touched.iter() {
        parts.translation[axis] = place[axis];
    }
    Ok(HereStatement {
        words: format!("G10 L20 P{}", system.0),
        after: String::new(),
        command,
        frame: turned,
        values,
        named,
        unit_mm: text::output_unit_mm(channel.settings.machine),
        data: parts.shift(),
    })
}

fn say_offset(
    machine: &Machine,
    language: Language,
    outlet: &mut MotionSink<'_>,
    system: System,
    (parts, steps): (&FrameParts, Option<&AxisVector>),
    named: AxisSet,
    (with_angle, sums): (bool, &[(u8, String)]),
) {
    let shift = steps.copied().unwrap_or_else(|| parts.shift());
    let mut text = match system.0.checked_sub(System::ADDITIONAL) {
        Some(number) => format!("G10 L20 P{number}"),
        None => format!("G10 L2 P{}", system.0),
    };
    for axis in named.iter() {
        if append_sum(&mut text, axis.letter(), sums) {
            continue;
        }
        let value = shift[axis];
        let shown = if axis.is_rotary() { value.to_degrees() } else { value / text::output_unit_mm(machine) };
        text::append(language, &mut text, axis.letter(), shown);
    }
    if with_angle && !append_sum(&mut text, b'R', sums) {
        text::append(language, &mut text, b'R', parts.rotation[2].to_degrees());
    }
    push_data(outlet, text, steps.is_some());
}

/// The warnings for zero offsets to which the program has added something.
pub(super) fn growing_offsets(channel: &Channel<'_>) -> Vec<Fault> {
    let growing = &channel.written.growing;
    let mut systems: Vec<System> = growing.keys().map(|(system, _)| *system).collect();
    systems.dedup();
    let grown = |system: System| {
        let origin = growing.iter().find(|((own, _), _)| *own == system).map(|(_, origin)| *origin)?;
        let words = system.words();
        let before = channel.settings.machine.zero_offsets.get(&words).copied().unwrap_or_default();
        let after = channel.written.offsets.get(&system)?;
        let is_own = |axis: &Axis| {
            let place = if channel.is_rs274() { place_of_rs274(*axis) } else { system::place_of(channel.axes, *axis) };
            place.is_some_and(|place| growing.contains_key(&(system, place)))
        };
        let axes: AxisSet = channel.axes.iter().filter(is_own).collect();
        let turns = growing.contains_key(&(system, ROTATION));
        growing_offsets::grown(
            &offsets::words_of(channel.settings.machine, system),
            origin,
            [&before, after],
            (axes, turns),
        )
    };
    systems.into_iter().filter_map(grown).collect()
}

/// Index of the rotation among the parameters of a zero offset of RS274/NGC.
const ROTATION: u32 = 9;

/// The index of an axis among the parameters of a zero offset of RS274/NGC.
fn place_of_rs274(axis: Axis) -> Option<u32> {
    b"XYZABCUVW".iter().position(|&letter| letter == axis.letter()).map(|place| place as u32)
}

/// The letter and the sum of a word whose value is that of a variable of the control and a step; `None` if it does not depend on data of the control.
/// `adds` if the control adds the value of the word to its own.
fn sum_of(channel: &Channel<'_>, gathered: &Gathered, letter: u8, adds: bool) -> Result<Option<(u8, String)>, Fault> {
    let Some(origin) = gathered.origin(letter) else { return Ok(None) };
    let is_same_unit = (channel.modal.modes.scale() - text::output_unit_mm(channel.settings.machine)).abs() < 1e-9;
    let sum = origin.text(1.0).filter(|_| is_same_unit && !adds);
    if sum.is_none() && channel.settings.strict {
        return Err(data_origin::not_kept(gathered.span_of(letter)));
    }
    Ok(sum.map(|sum| (letter, sum)))
}

/// Appends a word with a sum; false if the letter has none.
fn append_sum(text: &mut String, letter: u8, sums: &[(u8, String)]) -> bool {
    let Some((_, sum)) = sums.iter().find(|(known, _)| *known == letter) else { return false };
    text.push_str(&format!(" {}[{sum}]", char::from(letter)));
    true
}

/// Writes a G10. One that adds to the value of the control needs G91, and the output is in G90.
fn push_data(outlet: &mut MotionSink<'_>, text: String, adds: bool) {
    if !adds {
        outlet.push(Kind::Verbatim(text.into_bytes()));
        return;
    }
    outlet.push(Kind::Verbatim(format!("G91 {text}").into_bytes()));
    outlet.push(Kind::Verbatim(b"G90".to_vec()));
}

/// `G10 L1`, `L10`, `L11` of RS274/NGC: length and radius of a tool.
fn set_tool(channel: &mut Channel<'_>, gathered: &Gathered, l: i64, number: u32, span: Span) -> Result<(), Fault> {
    if channel.settings.strict
        && let Some((letter, _)) = gathered.origins.first()
    {
        return Err(data_origin::not_kept(gathered.span_of(*letter)));
    }
    let mut offset = channel.written.tools.find(channel.settings.machine, number, 1).unwrap_or_default();
    // L10 and L11 measure the tool here: the place of a compensated tool is not the programmed one.
    if l != 1 {
        forbidden::no_compensation(channel.language, &channel.modal, span, "G10")?;
    }
    // The coordinates of L10 and L11; those of L10 include G92, which the output does not have.
    let (frame, shown) = match l {
        10 => (channel.modal.frame(), channel.modal.shown().frame),
        11 => {
            let frame = target::frame_of(channel.settings.machine, &channel.written, System(9));
            (frame, frame)
        }
        _ => (Frame::identity(), Frame::identity()),
    };
    // The tip position without tool length.
    let command = channel.modal.position.command;
    let bare = frame.unapply(&command);
    let shift = shown.unapply(&command) - bare;
    let (mut values, mut lengths) = (AxisVector::ZERO, AxisVector::ZERO);
    for axis in gathered.axes.iter() {
        if !AxisSet::XYZ.contains(axis) {
            let message = format!("a tool offset along {axis} is not supported");
            return Err(fault(Code::NOT_SUPPORTED, gathered.span_of(axis.letter()), message, "program X, Y or Z"));
        }
        let value = target::axis_value(channel, gathered, axis)?;
        let length = if l == 1 {
            value
        } else {
            target::check_here(channel.settings.strict, &channel.modal, axis, gathered.span_of(axis.letter()))?;
            bare[axis] - value
        };
        offset.length_mm[axis.slot()] = length;
        (values[axis], lengths[axis]) = (value + shift[axis], length);
    }
    let mut after = String::new();
    if let Some(radius) = measure::length(channel, gathered, b'R')? {
        channel.outlet.check_radius(&format!("tool {number}"), radius, span)?;
        offset.radius_mm = radius;
        text::append_length(channel.settings.machine, channel.language, &mut after, b'R', radius);
    }
    for letter in *b"IJQ" {
        if let Some(value) = gathered.raw(letter) {
            text::append(channel.language, &mut after, letter, value);
        }
    }
    if gathered.axes.is_empty() && !gathered.has_any(b"RIJQ") {
        return Err(bad_value(span, "G10 L1 without offsets", "name the axes or R"));
    }
    channel.written.tools.write(number, 1, offset);
    if l != 1 && !gathered.axes.is_empty() {
        channel.push(Kind::Here(Box::new(HereStatement {
            words: format!("G10 L{l} P{number}"),
            after,
            command,
            frame: shown,
            values,
            named: gathered.axes,
            unit_mm: text::output_unit_mm(channel.settings.machine),
            data: lengths,
        })));
        return Ok(());
    }
    let mut text = format!("G10 L1 P{number}");
    for axis in gathered.axes.iter() {
        text::append_length(channel.settings.machine, channel.language, &mut text, axis.letter(), lengths[axis]);
    }
    text.push_str(&after);
    channel.push(Kind::Verbatim(text.into_bytes()));
    Ok(())
}

/// `G10 L10` to `L13` of Fanuc: geometry and wear of length and radius, one value with R. Programs for older controls have L1 instead of L11.
fn set_tool_value(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    l: i64,
    number: u32,
    span: Span,
) -> Result<(), Fault> {
    let l = if l == 1 { 11 } else { l };
    let Some(value) = measure::length(channel, gathered, b'R')? else {
        return Err(bad_value(span, "G10 needs R with the value", "write for example G10 L10 P1 R100."));
    };
    let known = channel.written.tools.find(channel.settings.machine, number, 1);
    if known.is_none() && channel.settings.strict && (channel.modal.modes.incremental || matches!(l, 11 | 13)) {
        let message = format!("offset {number} is changed only in part, but has no value in the machine file");
        return Err(fault(Code::NO_TOOL, span, message, "add a [[tool]] entry of this number"));
    }
    let mut offset = known.unwrap_or_default();
    let incremental = channel.modal.modes.incremental;
    let place = match l {
        11 => &mut offset.length_wear_mm,
        12 => &mut offset.radius_mm,
        13 => &mut offset.radius_wear_mm,
        _ => &mut offset.length_mm[2],
    };
    *place = value + if incremental { *place } else { 0.0 };
    let radius = *place;
    if l == 12 {
        channel.outlet.check_radius(&format!("register {number}"), radius, span)?;
    }
    channel.written.tools.write(number, 1, ToolOffset { is_stated: true, ..offset });
    let mut text = format!("G10 L{l} P{number}");
    let sums: Vec<_> = sum_of(channel, gathered, b'R', incremental)?.into_iter().collect();
    if !append_sum(&mut text, b'R', &sums) {
        text::append_length(channel.settings.machine, channel.language, &mut text, b'R', value);
    }
    push_data(&mut channel.outlet, text, incremental);
    Ok(())
}
