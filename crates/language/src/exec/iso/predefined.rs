//! Parameters of RS274/NGC with control state: numbers from 5161 on, and names with a leading underscore.

use super::channel::Channel;
use super::channel::WrittenData;
use super::data_origin::DataOrigin;
use super::modal::Modal;
use super::system;
use super::target;
use super::variables::Missing;
use super::zero_offset::System;
use crate::exec::core::contour::Side;
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::standing::InForce;
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{FeedUnit, Kind};

/// The axes in the order of the parameters.
const ORDER: [Axis; 9] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C, Axis::U, Axis::V, Axis::W];
/// The LinuxCNC version of the implemented rules.
const VERSION: f64 = 2.9;
/// Number of parameters per zero offset.
const APART: u32 = 20;
/// Index of the rotation of a zero offset.
const ROTATION: u32 = 9;

/// Meaning of a zero offset parameter: the system, and the index of the axis or [`ROTATION`].
fn offset_place(number: u32) -> Option<(System, u32)> {
    let from = number.checked_sub(5221)?;
    let (system, place) = (from / APART + 1, from % APART);
    (system <= 9 && place <= ROTATION).then_some((System(system as u16), place))
}

/// The place of a number with data of the control: `None` for other numbers, `Some(None)` for values of tools.
pub(super) fn control_data(number: u32) -> Option<Option<(System, u32)>> {
    match number {
        5221..=5390 => offset_place(number).map(Some),
        5401..=5403 | 5410 => Some(None),
        _ => None,
    }
}

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

/// The value of a numbered parameter with control state; `None` for plain ones. Persistent ones are in mm and degrees.
pub(super) fn special_parameter(channel: &Channel<'_>, number: u32) -> Option<Result<f64, Missing>> {
    let axis_of = |start: u32| ORDER.get((number - start) as usize).copied().unwrap_or(Axis::X);
    let in_mm = |axis: Axis, value: f64| if axis.is_rotary() { value.to_degrees() } else { value };
    Some(match number {
        5061..=5070 if channel.settings.strict && channel.variables.probed.is_some() => Err(Missing::OnlyMachine),
        5021..=5029 => machine_of(channel.settings.strict, &channel.modal, &channel.standing, axis_of(5021)),
        5210 => {
            let is_applied = channel.modal.shift == channel.modal.stored_shift;
            Ok(truth(is_applied && channel.modal.shift != AxisVector::ZERO))
        }
        5211..=5219 => {
            let axis = axis_of(5211);
            Ok(in_mm(axis, channel.modal.stored_shift[axis]))
        }
        5220 => Ok(f64::from(channel.modal.system.0)),
        5221..=5390 => {
            let (system, place) = offset_place(number)?;
            let parts = target::offset_of(channel.settings.machine, &channel.written, system);
            match (parts, ORDER.get(place as usize)) {
                (None, _) if channel.settings.strict => Err(Missing::OnlyMachine),
                (None, _) => Ok(0.0),
                (Some(parts), Some(&axis)) => Ok(in_mm(axis, parts.shift()[axis])),
                (Some(parts), None) => Ok(parts.rotation[2].to_degrees()),
            }
        }
        5399 => Err(Missing::OnlyMachine),
        5400 => tool_in_spindle(channel.settings.strict, &channel.modal),
        5404..=5409 | 5411..=5413 => Ok(0.0),
        // Table values of the tool in the spindle, whether active or not.
        5401..=5403 | 5410 => match channel
            .modal
            .tool
            .active
            .and_then(|tool| channel.written.tools.find(channel.settings.machine, tool, 1))
        {
            Some(offset) if number == 5410 => Ok(2.0 * offset.radius_mm),
            Some(offset) => Ok(offset.length_mm[(number - 5401) as usize]),
            None if channel.settings.strict => Err(Missing::OnlyMachine),
            None => Ok(0.0),
        },
        5420..=5428 if channel.modal.contour.compensates() => Err(Missing::Compensated),
        5420..=5428 => here_of(channel.settings.strict, &channel.modal, &channel.standing, axis_of(5420)),
        _ => return None,
    })
}

/// Records the programmed end of a probing motion without contact as its result; used if assumptions are permitted.
pub(super) fn note_probe(channel: &mut Channel<'_>) {
    let end = if channel.is_rs274() {
        target::here(&channel.modal, &channel.standing)
    } else {
        system::work_frame(&channel.modal).unapply(&target::tip(&channel.modal, &channel.standing))
    };
    let mut shown = end;
    for axis in ORDER {
        shown[axis] = system::shown_value(&channel.modal, axis, end[axis]);
    }
    channel.variables.probed = Some(shown);
    if channel.is_rs274() {
        (5061..).zip(ORDER).for_each(|(number, axis)| channel.variables.set(number, Some(shown[axis])));
        channel.variables.set(5070, Some(0.0));
    }
}

/// The tool in the spindle before the first M6, which only the machine knows.
fn tool_in_spindle(strict: bool, modal: &Modal) -> Result<f64, Missing> {
    match modal.tool.active {
        Some(tool) => Ok(f64::from(tool)),
        None if strict => Err(Missing::OnlyMachine),
        None => Ok(0.0),
    }
}

/// Position of an axis in program coordinates.
fn here_of(strict: bool, modal: &Modal, standing: &InForce, axis: Axis) -> Result<f64, Missing> {
    if strict && !modal.position.known.contains(axis) {
        return Err(Missing::Unstated);
    }
    Ok(system::shown_value(modal, axis, target::here(modal, standing)[axis]))
}

/// Assigns to a parameter of a zero offset. It takes effect when the program selects the offset.
pub(super) fn write_parameter(
    machine: &Machine,
    written: &mut WrittenData,
    outlet: &mut MotionSink<'_>,
    number: u32,
    (value, origin): (f64, Option<DataOrigin>),
) -> bool {
    let Some((system, place)) = offset_place(number) else { return false };
    written.state((system, place), origin.is_none());
    if origin.is_some_and(|origin| origin.adds_to(number)) {
        written.growing.entry((system, place)).or_insert(outlet.origin);
    }
    let mut parts = target::offset_of(machine, written, system).unwrap_or_default();
    match ORDER.get(place as usize) {
        Some(&axis) => {
            parts.translation[axis] = if axis.is_rotary() { value.to_radians() } else { value };
            parts.fine[axis] = 0.0;
        }
        None => parts.rotation[2] = value.to_radians(),
    }
    written.offsets.insert(system, parts);
    written.shown.remove(&system);
    let text = match origin.and_then(|origin| origin.text(1.0)) {
        Some(sum) => format!("#{number}=[{sum}]"),
        None => format!("#{number}={value}"),
    };
    outlet.push(Kind::Verbatim(text.into_bytes()));
    true
}

/// The value of a predefined name, upper case.
pub(super) fn predefined_name(channel: &Channel<'_>, name: &str) -> Option<Result<f64, Missing>> {
    let modal = &channel.modal;
    let code = |tenths: u16| Ok(f64::from(tenths));
    let is = |holds: bool| Ok(truth(holds));
    if let Some(axis) = name.strip_prefix("_ABS_").and_then(one_axis) {
        return Some(machine_of(channel.settings.strict, &channel.modal, &channel.standing, axis));
    }
    if let Some(axis) = name.strip_prefix('_').and_then(one_axis) {
        return Some(here_of(channel.settings.strict, &channel.modal, &channel.standing, axis));
    }
    Some(match name {
        "_VMAJOR" => Ok(VERSION),
        "_VMINOR" | "_TASK" | "_REMAP_LEVEL" | "_LATHE_DIAMETER_MODE" => Ok(0.0),
        "_METRIC_MACHINE" | "_LATHE_RADIUS_MODE" | "_SPEED_OVERRIDE" | "_FEED_OVERRIDE" => Ok(1.0),
        "_ADAPTIVE_FEED" | "_FEED_HOLD" => Err(Missing::OnlyMachine),
        "_LINE" => Ok(f64::from(channel.outlet.origin.line)),
        "_MOTION_MODE" => code(modal.modes.motion),
        "_PLANE" => Ok(10.0 * f64::from(modal.modes.plane.number())),
        "_CCOMP" => code(match modal.contour.side {
            Side::Off => 400,
            Side::Left => 410,
            Side::Right => 420,
        }),
        "_METRIC" => is(!modal.modes.inch),
        "_IMPERIAL" => is(modal.modes.inch),
        "_ABSOLUTE" => is(!modal.modes.incremental),
        "_INCREMENTAL" => is(modal.modes.incremental),
        "_INVERSE_TIME" => is(modal.modes.feed_unit == FeedUnit::InverseTime),
        "_UNITS_PER_MINUTE" => is(modal.modes.feed_unit == FeedUnit::PerMinute),
        "_UNITS_PER_REV" => is(modal.modes.feed_unit == FeedUnit::PerTurn),
        "_COORD_SYSTEM" if modal.system.0 < 7 => Ok(530.0 + 10.0 * f64::from(modal.system.0)),
        "_COORD_SYSTEM" => Ok(584.0 + f64::from(modal.system.0)),
        "_TOOL_OFFSET" => is(modal.tool.length_mm.iter().any(|&value| value != 0.0)),
        "_RETRACT_R_PLANE" => is(modal.ends_at_r()),
        "_RETRACT_OLD_Z" => is(!modal.ends_at_r()),
        "_SPINDLE_RPM_MODE" => is(!modal.has_cutting_speed()),
        "_SPINDLE_CSS_MODE" => is(modal.has_cutting_speed()),
        "_IJK_ABSOLUTE_MODE" => is(modal.has_absolute_centers()),
        "_SPINDLE_ON" => is(matches!(modal.spindle, 3 | 4)),
        "_SPINDLE_CW" => is(modal.spindle == 3),
        "_MIST" => is(modal.coolant[0]),
        "_FLOOD" => is(modal.coolant[1]),
        "_FEED" if modal.modes.feed_unit == FeedUnit::InverseTime => Ok(modal.modes.feed),
        "_FEED" => Ok(modal.modes.feed / modal.modes.scale()),
        "_RPM" => Ok(modal.modes.speed.unwrap_or(0.0).abs()),
        "_CURRENT_TOOL" => tool_in_spindle(channel.settings.strict, &channel.modal),
        "_SELECTED_TOOL" => Ok(modal.tool.selected.map_or(-1.0, f64::from)),
        "_CURRENT_POCKET" | "_SELECTED_POCKET" => Err(Missing::OnlyMachine),
        "_VALUE" => Ok(channel.variables.returned.unwrap_or(0.0)),
        "_VALUE_RETURNED" => is(channel.variables.returned.is_some()),
        "_CALL_LEVEL" => Ok(channel.variables.depth() as f64),
        _ => return None,
    })
}

/// Machine position of an axis.
fn machine_of(strict: bool, modal: &Modal, standing: &InForce, axis: Axis) -> Result<f64, Missing> {
    if strict && !modal.position.known.contains(axis) {
        return Err(Missing::Unstated);
    }
    Ok(system::shown_value(modal, axis, target::tip(modal, standing)[axis]))
}

fn one_axis(text: &str) -> Option<Axis> {
    match text.as_bytes() {
        &[letter] => Axis::from_letter(letter),
        _ => None,
    }
}
