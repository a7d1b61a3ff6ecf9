//! The datum of a workpiece: how a zero offset was set, and where the axes stood.
//!
//! A zero that was touched off contains the error of the machine at the pose of the touch. A program in this zero is right relative to the touched sides
//! if only the difference to this error is corrected.

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXIS_COUNT, Axis, AxisSet, AxisVector};

use super::section::Section;
use super::{AxisData, Machine, ZeroPose};

/// Rounding of a display, mm or degrees.
const ROOM: f64 = 1e-3;

/// Method by which a zero offset was set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZeroSetting {
    /// A side was touched with a tool or an edge finder.
    Touched,
    /// A side was touched with a probe of the machine.
    Probed,
    /// The zero is at its true position in the machine.
    Absolute,
}

impl ZeroSetting {
    /// All methods.
    pub const ALL: [ZeroSetting; 3] = [ZeroSetting::Touched, ZeroSetting::Probed, ZeroSetting::Absolute];

    /// Returns its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            ZeroSetting::Touched => "touched",
            ZeroSetting::Probed => "probed",
            ZeroSetting::Absolute => "absolute",
        }
    }

    /// Returns the method of a name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<ZeroSetting> {
        ZeroSetting::ALL.into_iter().find(|one| one.name() == name)
    }

    /// True if the zero contains the error of the machine.
    #[must_use]
    pub fn is_relative(self) -> bool {
        self != ZeroSetting::Absolute
    }
}

/// Stated part of the pose at which a side was touched.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TouchedAt {
    /// Axes whose position is stated.
    pub stated: AxisSet,
    /// Their positions in machine coordinates, mm and rad.
    pub command: AxisVector,
    /// Length of the tool or probe, mm; `None` if it is not stated.
    pub tool_length_mm: Option<f64>,
    /// Direction of the last motion of each axis at the touch: −1, 0 (not stated) or 1.
    pub direction: [i8; AXIS_COUNT],
}

/// Statement about a zero offset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Datum {
    /// Method, if it is stated.
    pub setting: Option<ZeroSetting>,
    /// Poses at which the sides along X, Y and Z were touched.
    pub at: [TouchedAt; 3],
    /// `true` if the method was stated as absolute beside another value than the present one: somebody has set the zero since, maybe by touching off.
    pub is_of_other_value: bool,
}

impl Datum {
    /// Returns the method; a zero without a statement counts as touched, because most zeros are.
    #[must_use]
    pub fn method(&self) -> ZeroSetting {
        self.setting.unwrap_or(ZeroSetting::Touched)
    }

    /// Returns the pose at which a side (0 for X, 1 for Y, 2 for Z) was touched. Positions that are not stated are those at which the tip is at the
    /// workpiece zero, which `shift` is; a tool that is not stated has no length.
    #[must_use]
    pub fn pose(&self, side: usize, shift: &AxisVector, machine: &Machine) -> ZeroPose {
        let at = self.at.get(side).copied().unwrap_or_default();
        let tool_mm = machine.spindle.axis * -at.tool_length_mm.unwrap_or(0.0);
        let mut command = *shift;
        command.set_xyz(command.xyz() - tool_mm);
        at.stated.iter().for_each(|axis| command[axis] = at.command[axis]);
        ZeroPose { command, tool_mm, direction: at.direction }
    }

    /// Reads `set` and `set_at` of a zero offset; `None` if it has neither.
    pub(super) fn read(
        section: &mut Section<'_>,
        (axes, data): (AxisSet, &[Option<AxisData>]),
        findings: &mut Vec<Diagnostic>,
    ) -> Option<Datum> {
        let mut datum = Datum::default();
        if let Some(text) = section.text("set") {
            datum.setting = ZeroSetting::of_name(text);
            if datum.setting.is_none() {
                let message = format!("\"{text}\" is not a method of setting a zero");
                let help = "write \"touched\", \"probed\" or \"absolute\"";
                section.report(Code::BAD_VALUE, section.place_of("set"), message, help);
            }
        }
        let Some(mut at) = section.section("set_at") else { return datum.setting.map(|_| datum) };
        let common = TouchedAt::read(&mut at, (axes, data), TouchedAt::default());
        datum.at = [common; 3];
        for (side, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
            if let Some(mut own) = at.section(&axis.to_string()) {
                datum.at[side] = TouchedAt::read(&mut own, (axes, data), common);
                own.finish(findings);
            }
        }
        at.finish(findings);
        Some(datum)
    }
}

impl TouchedAt {
    /// Reads positions of axes and the length of the tool over those of `base`.
    fn read(section: &mut Section<'_>, (axes, data): (AxisSet, &[Option<AxisData>]), base: TouchedAt) -> TouchedAt {
        let mut out = base;
        for axis in axes.iter() {
            let key = format!("{axis}_dir");
            if let Some(direction) = section.number_where(&key, "1 or -1", |value| value.abs() == 1.0) {
                out.direction[axis.slot()] = if direction > 0.0 { 1 } else { -1 };
            }
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            let key = format!("{axis}_{unit}");
            let Some(value) = section.number(&key) else { continue };
            let travel = data.iter().flatten().find(|one| one.axis == axis).and_then(|one| one.travel);
            let travel = travel.map(|ends| ends.map(|end| if axis.is_rotary() { end.to_degrees() } else { end }));
            if let Some([low, high]) = travel.filter(|[low, high]| !(low - ROOM..=high + ROOM).contains(&value)) {
                let message =
                    format!("the touch at {axis} {value} {unit} is outside the travel of {low} to {high} {unit}");
                let help = "write the position of the axis at the touch in machine coordinates (G53), not that of the edge in the workpiece";
                section.report(Code::OUT_OF_TRAVEL, section.place_of(&key), message, help);
            }
            out.command[axis] = if axis.is_rotary() { value.to_radians() } else { value };
            out.stated.insert(axis);
        }
        let length = section.number_where("tool_length_mm", "a number that is not negative", |length| length >= 0.0);
        out.tool_length_mm = length.or(base.tool_length_mm);
        out
    }
}
