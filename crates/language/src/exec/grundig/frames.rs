//! Zero offsets, and the frames of G92, G93 and G73.
//!
//! `machine = T(G52) · T(G5x) · R(G5x) · T · R(G92, G93) · mirror and scale (G73) · programmed`, the innermost on the right.

use super::modal::Modal;
use super::setup;
use super::shifts;
use super::shifts::PALLET;
use crate::exec::core::motion_sink::MotionSink;

use super::channel::Channel;
use super::gathered::Gathered;
use super::modal::plus;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, ROTARY_AXES};
use ncfix_base::source::Span;
use ncfix_machine::machine::ScaledAxes;
use ncfix_machine::snc::{FrameWords, Kind};

/// Axes of zero offsets and shifts.
const AXES: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C];
/// Angles nearer to each other are equal, rad.
const WITHIN_RAD: f64 = 1e-9;

/// G51 to G59, G54 I, G92, G93, G72, G73.
pub(super) fn frame_codes(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    for (number, on) in [(51, false), (52, true)] {
        if let Some(span) = gathered.take_code(number) {
            pallet(channel, on, span)?;
        }
    }
    if let Some(at) = gathered.codes.iter().position(|code| (53..=59).contains(&code.number)) {
        let code = gathered.codes.remove(at);
        settable(channel, gathered, code.number, code.span)?;
    }
    if let Some(span) = gathered.take_code(93) {
        programmed_shift(channel, gathered, false, span)?;
    }
    if let Some(span) = gathered.take_code(92) {
        programmed_shift(channel, gathered, true, span)?;
    }
    if gathered.take_code(72).is_some() {
        channel.modal.frames.mirrored = AxisSet::EMPTY;
        channel.modal.frames.scaled = AxisSet::EMPTY;
        channel.modal.frames.factor = 1.0;
        setup::refresh_setup(channel)?;
    }
    if let Some(span) = gathered.take_code(73) {
        mirror_and_scale(channel, gathered, span)?;
    }
    Ok(())
}

fn pallet(channel: &mut Channel<'_>, on: bool, span: Span) -> Result<(), Fault> {
    if on {
        check_value(channel.settings.requires_values, &mut channel.modal, &mut channel.outlet, PALLET, span)?;
    }
    channel.modal.frames.pallet = on;
    setup::refresh_setup(channel)?;
    push_settable(&mut channel.outlet, if on { "G52" } else { "G51" });
    Ok(())
}

/// G53 to G59; `I` is an index in the long table, axis words set a new value.
fn settable(channel: &mut Channel<'_>, gathered: &mut Gathered, number: u16, span: Span) -> Result<(), Fault> {
    let mut text = format!("G{number}");
    if number == 54
        && let Some((index, span)) = gathered.take(b'I', None)
    {
        if index.fract() != 0.0 || !(0.0..=99.0).contains(&index) {
            return Err(bad_value(span, format!("I{index} is not a zero offset"), "write I0 to I99"));
        }
        text = format!("G54 I{index}");
    }
    let name = (number != 53).then(|| text.clone());
    let motion = gathered.codes.iter().any(|code| matches!(code.number, 0..=3 | 77..=79 | 92 | 93));
    if let Some(name) = &name
        && name.contains('I')
        && !motion
    {
        let (values, named) = stored_words(&channel.modal, gathered)?;
        if !named.is_empty() || gathered.peek(b'B', Some(4)).is_some() {
            let angle = gathered.take(b'B', Some(4));
            let parts = channel.modal.frames.table.entry(name.clone()).or_default();
            for axis in named.iter() {
                parts.translation[axis] = values[axis];
                text.push_str(&format!(" {axis}{}", shown_value(axis, values[axis])));
            }
            if let Some((angle, _)) = angle {
                let tool = channel.modal.modes.plane.axes()[2].slot();
                parts.rotation = [0.0; 3];
                if let Some(place) = parts.rotation.get_mut(tool) {
                    *place = angle.to_radians();
                }
                text.push_str(&format!(" B4={angle}"));
            }
        }
    }
    if let Some(name) = &name {
        check_value(channel.settings.requires_values, &mut channel.modal, &mut channel.outlet, name, span)?;
    } else {
        channel.modal.frames.assumed = false;
    }
    channel.modal.frames.settable = name;
    if channel.settings.machine.control.grundig.offset_cancels_shift {
        channel.modal.frames.cancel_programmed();
    }
    setup::refresh_setup(channel)?;
    push_settable(&mut channel.outlet, &text);
    Ok(())
}

/// Values of axis words for a table, mm and rad.
fn stored_words(modal: &Modal, gathered: &mut Gathered) -> Result<(AxisVector, AxisSet), Fault> {
    let (mut values, mut named) = (AxisVector::ZERO, AxisSet::EMPTY);
    for axis in AXES {
        if let Some((value, _)) = gathered.once(axis.letter(), None)? {
            values[axis] = if axis.is_rotary() { value.to_radians() } else { value * modal.modes.scale() };
            named.insert(axis);
        }
    }
    Ok((values, named))
}

fn push_settable(outlet: &mut MotionSink<'_>, text: &str) {
    outlet.push(Kind::Frame(FrameWords::Settable(text.to_owned())));
}

/// Checks that a stored offset has a value.
fn check_value(
    requires_values: bool,
    modal: &mut Modal,
    outlet: &mut MotionSink<'_>,
    name: &str,
    span: Span,
) -> Result<(), Fault> {
    let missing = !modal.frames.table.contains_key(name);
    modal.frames.assumed = missing;
    if !missing {
        return Ok(());
    }
    let help = format!("add [zero_offset.\"{name}\"] there, or give the table of the control with --setup");
    if requires_values {
        return Err(fault(Code::NO_OFFSET, span, format!("{name} has no value in the machine file"), help));
    }
    let message = format!("{name} has no value in the machine file; zero is used");
    outlet.warnings.push(fault(Code::OFFSET_ASSUMED, span, message, help));
    Ok(())
}

/// G92 adds to the active shift, G93 replaces it.
fn programmed_shift(
    channel: &mut Channel<'_>,
    gathered: &mut Gathered,
    additive: bool,
    span: Span,
) -> Result<(), Fault> {
    if !additive {
        reset_turns(channel, gathered)?;
    }
    let (mut values, mut named) = stored_words(&channel.modal, gathered)?;
    if let Some((angle, span)) = gathered.take(b'B', Some(2)) {
        let Some((length, _)) = gathered.take(b'L', Some(2)) else {
            return Err(bad_value(span, "B2= without L2=", "write angle and length of the shift"));
        };
        let way = channel.modal.direction(angle);
        values = plus(&values, &way, length * channel.modal.modes.scale());
        let [abscissa, ordinate, _] = channel.modal.modes.plane.axes();
        named.insert(abscissa);
        named.insert(ordinate);
    }
    let angle = gathered.take(b'B', Some(4));
    let plane = channel.modal.modes.plane;
    let frames = &mut channel.modal.frames;
    if frames.angle_rad != 0.0 && frames.turned_in != plane && (angle.is_some() || additive) {
        let message = "the zero point is rotated in another plane";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "cancel the rotation with G93 B4=0 first"));
    }
    let settings = &channel.settings.machine.control.grundig;
    let before = if additive { frames.angle_rad } else { 0.0 };
    let turn = angle.map_or(0.0, |(degrees, _)| degrees.to_radians());
    // Along the axes in their rotation at the time of the shift.
    let mut along = if additive && settings.shift_is_turned { before } else { 0.0 };
    if settings.turns_first {
        along += turn;
    }
    let mut way = values;
    way.set_xyz(shifts::turned_about(plane, along) * values.xyz());
    if additive {
        frames.shift = plus(&frames.shift, &way, 1.0);
    } else {
        for axis in named.iter() {
            frames.shift[axis] = way[axis];
        }
    }
    if angle.is_some() {
        let sum = before + turn;
        frames.angle_rad = if sum.abs() < 1e-13 { 0.0 } else { sum };
        frames.turned_in = plane;
    }
    setup::refresh_setup(channel)
}

/// `A3=1`, `B3=1`, `C3=1` of G93: the control forgets the whole turns of a rotary axis. Within one turn this changes no position, and the output has no such
/// word.
fn reset_turns(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    for axis in ROTARY_AXES {
        let Some((value, span)) = gathered.once(axis.letter(), Some(3))? else { continue };
        if value == 0.0 {
            continue;
        }
        if value != 1.0 {
            return Err(bad_value(span, format!("{axis}3={value} is neither 0 nor 1"), "write 1 to reset the turns"));
        }
        if channel.settings.machine.axis(axis).is_none() {
            let message = format!("{axis}3= of G93, and the machine has no axis {axis}");
            return Err(fault(Code::NO_AXIS, span, message, "check the program, or the topology of the machine"));
        }
        if !channel.modal.position.known.contains(axis) {
            // The program has not stated the axis yet: the control may reset its turns.
            channel.outlet.push_line(Kind::Verbatim(format!("G93 {axis}3=1").into_bytes()));
            continue;
        }
        let command = channel.modal.position.command[axis];
        let own = command - channel.standing.setup.frame.shift(axis);
        let is_within = |angle: f64| angle > -WITHIN_RAD && angle < std::f64::consts::TAU - WITHIN_RAD;
        if !is_within(command) || !is_within(own) {
            let message = format!("{axis}3=1 resets the turns of {axis}, which is at {:.3} degrees", own.to_degrees());
            let help = "turn the axis to 0 to 360 degrees before it, of the program and of the machine: only then no position changes";
            return Err(fault(Code::NOT_SUPPORTED, span, message, help));
        }
    }
    Ok(())
}

fn mirror_and_scale(channel: &mut Channel<'_>, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
    if channel.modal.contour.compensates() {
        let message = "G73 while radius compensation is on";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "end the compensation with G40 first"));
    }
    for axis in AXES {
        let Some((value, span)) = gathered.once(axis.letter(), None)? else { continue };
        match value {
            -1.0 => channel.modal.frames.mirrored.insert(axis),
            1.0 => channel.modal.frames.mirrored.remove(axis),
            other => {
                let message = format!("{axis}{other} is not a valid mirror value");
                return Err(bad_value(span, message, "write -1 to mirror the axis, 1 to cancel it"));
            }
        }
    }
    if let Some((value, span)) = gathered.once(b'A', Some(4))? {
        let settings = &channel.settings.machine.control.grundig;
        let factor = if settings.scale_in_percent { value / 100.0 } else { value };
        if !(1e-6..=1e6).contains(&factor) {
            return Err(bad_value(span, format!("A4={value} is not a valid factor"), "write a factor above 0"));
        }
        channel.modal.frames.factor = factor;
        let [abscissa, ordinate, applicate] = channel.modal.modes.plane.axes();
        channel.modal.frames.scaled = match settings.scaled_axes {
            ScaledAxes::Plane => [abscissa, ordinate].into_iter().collect(),
            ScaledAxes::All => [abscissa, ordinate, applicate].into_iter().collect(),
        };
    }
    setup::refresh_setup(channel)
}

/// G149 reads an entry of the zero offset table into parameters, G150 writes it.
pub(super) fn table_access(
    channel: &mut Channel<'_>,
    gathered: &mut Gathered,
    writes: bool,
    span: Span,
) -> Result<(), Fault> {
    let help = "write for example G149 N1=54.01 X7=84 or G150 N1=54.01 X7=12.5";
    let Some((entry, at)) = gathered.take(b'N', Some(1)) else {
        return Err(fault(Code::NOT_SUPPORTED, span, "only zero offsets can be read and written here", help));
    };
    let name = entry_name(entry).ok_or_else(|| bad_value(at, format!("N1={entry} is not a zero offset"), help))?;
    if !writes {
        check_value(channel.settings.requires_values, &mut channel.modal, &mut channel.outlet, &name, span)?;
    }
    let mut text = format!("G150 N1={entry}");
    for axis in AXES {
        let Some((value, at)) = gathered.take(axis.letter(), Some(7)) else { continue };
        if writes {
            let inside = if axis.is_rotary() { value.to_radians() } else { value * channel.modal.modes.scale() };
            channel.modal.frames.table.entry(name.clone()).or_default().translation[axis] = inside;
            text.push_str(&format!(" {axis}7={}", shown_value(axis, inside)));
            continue;
        }
        let stored = channel.modal.frames.table.get(&name).map_or(0.0, |parts| parts.shift()[axis]);
        let own = if axis.is_rotary() { stored.to_degrees() } else { stored / channel.modal.modes.scale() };
        if value.fract() != 0.0 || value < 0.0 {
            return Err(bad_value(at, format!("{value} is not a parameter number"), help));
        }
        // Within the range that the store checks.
        channel.parameters.set(value as usize, own, at)?;
    }
    if writes {
        setup::refresh_setup(channel)?;
        channel.outlet.push(ncfix_machine::snc::Kind::Verbatim(text.into_bytes()));
    }
    Ok(())
}

/// The zero offset for `54.01`, `55`.
pub(super) fn entry_name(entry: f64) -> Option<String> {
    let (number, index) = (entry.trunc(), (entry.fract() * 100.0).round());
    match number {
        54.0 if index > 0.0 => Some(format!("G54 I{index}")),
        52.0 | 54.0..=59.0 if index == 0.0 => Some(format!("G{number}")),
        _ => None,
    }
}

/// A value in program units, mm or degrees, without rounding noise.
fn shown_value(axis: Axis, value: f64) -> String {
    let own = if axis.is_rotary() { value.to_degrees() } else { value };
    ((own * 1e9).round() / 1e9).to_string()
}
