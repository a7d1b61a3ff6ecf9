//! Parameters of RS274/NGC that stand for the state of the control: numbers from 5161 on, and the names that begin with an underscore.

use super::channel::Channel;
use super::expression::Missing;
use super::offsets::System;
use crate::exec::core::contour::Side;
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::snc::{FeedUnit, Kind};

/// The axes in the order of the parameters.
const ORDER: [Axis; 9] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C, Axis::U, Axis::V, Axis::W];
/// The version of LinuxCNC whose rules are followed.
const VERSION: f64 = 2.9;
/// Zero offsets lie this far apart.
const APART: u32 = 20;
/// The place of the rotation of a zero offset.
const ROTATION: u32 = 9;

/// What a parameter of the zero offsets stands for: the system, and the place of the axis or [`ROTATION`].
fn offset_place(number: u32) -> Option<(System, u32)> {
    let from = number.checked_sub(5221)?;
    let (system, place) = (from / APART + 1, from % APART);
    (system <= 9 && place <= ROTATION).then_some((System(system as u16), place))
}

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

impl Channel<'_> {
    /// The value of a numbered parameter that stands for something; `None` for plain ones. Persistent ones are in mm and degrees.
    pub(super) fn special_parameter(&self, number: u32) -> Option<Result<f64, Missing>> {
        let axis_of = |start: u32| ORDER.get((number - start) as usize).copied().unwrap_or(Axis::X);
        let in_mm = |axis: Axis, value: f64| if axis.is_rotary() { value.to_degrees() } else { value };
        Some(match number {
            5061..=5070 if self.strict && self.variables.probed.is_some() => Err(Missing::OnlyMachine),
            5021..=5029 => self.machine_of(axis_of(5021)),
            5210 => {
                let is_applied = self.modal.shift == self.modal.stored_shift;
                Ok(truth(is_applied && self.modal.shift != AxisVector::ZERO))
            }
            5211..=5219 => {
                let axis = axis_of(5211);
                Ok(in_mm(axis, self.modal.stored_shift[axis]))
            }
            5220 => Ok(f64::from(self.modal.system.0)),
            5221..=5390 => {
                let (system, place) = offset_place(number)?;
                let parts = self.offset_of(system);
                match (parts, ORDER.get(place as usize)) {
                    (None, _) if self.strict => Err(Missing::OnlyMachine),
                    (None, _) => Ok(0.0),
                    (Some(parts), Some(&axis)) => Ok(in_mm(axis, parts.shift()[axis])),
                    (Some(parts), None) => Ok(parts.rotation[2].to_degrees()),
                }
            }
            5399 => Err(Missing::OnlyMachine),
            5400 => self.tool_in_spindle(),
            5404..=5409 | 5411..=5413 => Ok(0.0),
            // What the table says of the tool in the spindle, whether it is in force or not.
            5401..=5403 | 5410 => match self.modal.active.and_then(|tool| self.tool_offset(tool)) {
                Some(offset) if number == 5410 => Ok(2.0 * offset.radius_mm),
                Some(offset) => Ok(offset.length_mm[(number - 5401) as usize]),
                None if self.strict => Err(Missing::OnlyMachine),
                None => Ok(0.0),
            },
            5420..=5428 if self.modal.contour.compensates() => Err(Missing::Compensated),
            5420..=5428 => self.here_of(axis_of(5420)),
            _ => return None,
        })
    }

    /// A probe has come to the end of its way without touching: that is what is taken where nothing must be known for certain.
    pub(super) fn note_probe(&mut self) {
        let end = if self.is_rs274() { self.here() } else { self.work_frame().unapply(&self.tip()) };
        let mut shown = end;
        for axis in ORDER {
            shown[axis] = self.shown_value(axis, end[axis]);
        }
        self.variables.probed = Some(shown);
        if self.is_rs274() {
            (5061..).zip(ORDER).for_each(|(number, axis)| self.variables.set(number, Some(shown[axis])));
            self.variables.set(5070, Some(0.0));
        }
    }

    /// Which tool is in the spindle before the first M6, only the machine knows.
    fn tool_in_spindle(&self) -> Result<f64, Missing> {
        match self.modal.active {
            Some(tool) => Ok(f64::from(tool)),
            None if self.strict => Err(Missing::OnlyMachine),
            None => Ok(0.0),
        }
    }

    /// Where an axis is, as the program would say it.
    fn here_of(&self, axis: Axis) -> Result<f64, Missing> {
        if self.strict && !self.modal.known.contains(axis) {
            return Err(Missing::Unstated);
        }
        Ok(self.shown_value(axis, self.here()[axis]))
    }

    /// A value that an assignment to a parameter of a zero offset changes. It takes effect when the program selects the offset.
    pub(super) fn write_parameter(&mut self, number: u32, value: f64) -> bool {
        let Some((system, place)) = offset_place(number) else { return false };
        let mut parts = self.offset_of(system).unwrap_or_default();
        match ORDER.get(place as usize) {
            Some(&axis) => {
                parts.translation[axis] = if axis.is_rotary() { value.to_radians() } else { value };
                parts.fine[axis] = 0.0;
            }
            None => parts.rotation[2] = value.to_radians(),
        }
        self.offsets.insert(system, parts);
        self.push(Kind::Verbatim(format!("#{number}={value}").into_bytes()));
        true
    }

    /// The value of a predefined name, upper case.
    pub(super) fn predefined_name(&self, name: &str) -> Option<Result<f64, Missing>> {
        let modal = &self.modal;
        let code = |tenths: u16| Ok(f64::from(tenths));
        let is = |holds: bool| Ok(truth(holds));
        if let Some(axis) = name.strip_prefix("_ABS_").and_then(one_axis) {
            return Some(self.machine_of(axis));
        }
        if let Some(axis) = name.strip_prefix('_').and_then(one_axis) {
            return Some(self.here_of(axis));
        }
        Some(match name {
            "_VMAJOR" => Ok(VERSION),
            "_VMINOR" | "_TASK" | "_REMAP_LEVEL" | "_LATHE_DIAMETER_MODE" => Ok(0.0),
            "_METRIC_MACHINE" | "_LATHE_RADIUS_MODE" | "_SPEED_OVERRIDE" | "_FEED_OVERRIDE" => Ok(1.0),
            "_ADAPTIVE_FEED" | "_FEED_HOLD" => Err(Missing::OnlyMachine),
            "_LINE" => Ok(f64::from(self.outlet.origin.line)),
            "_MOTION_MODE" => code(modal.motion),
            "_PLANE" => Ok(10.0 * f64::from(modal.plane.number())),
            "_CCOMP" => code(match modal.contour.side {
                Side::Off => 400,
                Side::Left => 410,
                Side::Right => 420,
            }),
            "_METRIC" => is(!modal.inch),
            "_IMPERIAL" => is(modal.inch),
            "_ABSOLUTE" => is(!modal.incremental),
            "_INCREMENTAL" => is(modal.incremental),
            "_INVERSE_TIME" => is(modal.feed_mode == FeedUnit::InverseTime),
            "_UNITS_PER_MINUTE" => is(modal.feed_mode == FeedUnit::PerMinute),
            "_UNITS_PER_REV" => is(modal.feed_mode == FeedUnit::PerTurn),
            "_COORD_SYSTEM" if modal.system.0 < 7 => Ok(530.0 + 10.0 * f64::from(modal.system.0)),
            "_COORD_SYSTEM" => Ok(584.0 + f64::from(modal.system.0)),
            "_TOOL_OFFSET" => is(modal.length_mm.iter().any(|&value| value != 0.0)),
            "_RETRACT_R_PLANE" => is(modal.to_r_plane),
            "_RETRACT_OLD_Z" => is(!modal.to_r_plane),
            "_SPINDLE_RPM_MODE" => is(modal.spindle_mode != 960),
            "_SPINDLE_CSS_MODE" => is(modal.spindle_mode == 960),
            "_IJK_ABSOLUTE_MODE" => is(modal.arc_absolute),
            "_SPINDLE_ON" => is(matches!(modal.spindle, 3 | 4)),
            "_SPINDLE_CW" => is(modal.spindle == 3),
            "_MIST" => is(modal.coolant[0]),
            "_FLOOD" => is(modal.coolant[1]),
            "_FEED" if modal.feed_mode == FeedUnit::InverseTime => Ok(modal.feed),
            "_FEED" => Ok(modal.feed / modal.scale()),
            "_RPM" => Ok(modal.speed.unwrap_or(0.0).abs()),
            "_CURRENT_TOOL" => self.tool_in_spindle(),
            "_SELECTED_TOOL" => Ok(modal.selected.map_or(-1.0, f64::from)),
            "_CURRENT_POCKET" | "_SELECTED_POCKET" => Err(Missing::OnlyMachine),
            "_VALUE" => Ok(self.variables.returned.unwrap_or(0.0)),
            "_VALUE_RETURNED" => is(self.variables.returned.is_some()),
            "_CALL_LEVEL" => Ok(self.variables.depth() as f64),
            _ => return None,
        })
    }

    /// Where an axis of the machine is.
    fn machine_of(&self, axis: Axis) -> Result<f64, Missing> {
        if self.strict && !self.modal.known.contains(axis) {
            return Err(Missing::Unstated);
        }
        Ok(self.shown_value(axis, self.tip()[axis]))
    }
}

fn one_axis(text: &str) -> Option<Axis> {
    match text.as_bytes() {
        &[letter] => Axis::from_letter(letter),
        _ => None,
    }
}
