//! Values of a machine file that are possible, but mostly a wrong sign or a value of another machine.

use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Axis;
use ncfix_base::number::significant;
use ncfix_base::units::{shown_position, um_from_mm, urad_from_rad};
use ncfix_machine::machine::Branch;
use ncfix_model::MotionError;
use ncfix_model::motion::EntryFunction;

/// Length of the longest tool if the machine file has no tools, mm.
const LONGEST_MM: f64 = 500.0;
/// Rounding of a display, mm.
const ROOM_MM: f64 = 1e-3;

impl Machine {
    /// Warnings of `ncfix machine check`.
    pub(crate) fn doubts(&self) -> Vec<Diagnostic> {
        let mut found = self.unreachable_zeros();
        found.extend(self.negative_tools());
        found.extend(self.errors.motion.iter().filter_map(|error| self.reversed_backlash(error)));
        found
    }

    /// A warning for each tool of a negative length: controls show such lengths if the tool was measured against another one or from the machine zero.
    fn negative_tools(&self) -> Vec<Diagnostic> {
        let negative = self.machine.tools.iter().filter(|tool| tool.length_mm[0] < 0.0);
        let warned = negative.map(|tool| {
            let message = format!(
                "the length of tool {} is {} mm: its tip would be above the spindle nose",
                tool.number,
                shown_position(false, tool.length_mm[0])
            );
            let help = "write the distance from the spindle nose to the tip, which angular errors need; a length relative to another tool or to the machine zero is not that distance";
            Diagnostic::nowhere(Code::DOUBTFUL_SIGN, message, help)
        });
        warned.collect()
    }

    /// A warning of a backlash with which the body goes too far after a reversal. Nothing is said of one that a calibration has found.
    fn reversed_backlash(&self, error: &MotionError) -> Option<Diagnostic> {
        let (axis, EntryFunction::Backlash(backlash)) = (error.name.axis()?, &error.function) else { return None };
        let own = axis.dimension() + if axis.is_rotary() { 3 } else { 0 };
        if error.name.direction.index() != own {
            return None;
        }
        let name = error.name.to_string();
        if self.machine.uncertainty.iter().any(|known| known.rows.keys().any(|key| *key == format!("{name}b"))) {
            return None;
        }
        // A lagging body remains behind, against the direction of the command.
        let along = self.machine.axis(axis)?.direction[axis.dimension()];
        let farthest = backlash.reversal.values.iter().copied().fold(0.0, |most: f64, one| most.max(one * along));
        if farthest <= 0.0 {
            return None;
        }
        let value = farthest / along;
        let (value, unit) = if axis.is_rotary() { (urad_from_rad(value), "µrad") } else { (um_from_mm(value), "µm") };
        let [shown, other] = [value, -value].map(significant);
        let side = if self.machine.topology.branch(axis) == Some(Branch::Workpiece) { "workpiece" } else { "tool" };
        let message = format!(
            "the backlash {name} of {shown} {unit} is that of an axis that goes too far after a reversal: {axis} is on the {side} side"
        );
        let help = format!(
            "if the axis has lost motion, as most axes, write {other}; if the control compensates for too much backlash, the sign is right"
        );
        Some(Diagnostic::nowhere(Code::DOUBTFUL_SIGN, message, help))
    }

    /// A warning for each zero offset whose zero no tool of the machine can reach: on a long part that is possible.
    fn unreachable_zeros(&self) -> Vec<Diagnostic> {
        let machine = &self.machine;
        let lengths = machine.tools.iter().map(|tool| tool.length_mm[0]);
        let [shortest, longest] = lengths.fold([0.0_f64; 2], |[low, high], one| [low.min(one), high.max(one)]);
        let longest = if machine.tools.is_empty() { LONGEST_MM } else { longest };
        let mut found = Vec::new();
        for (name, parts) in &machine.zero_offsets {
            for (dimension, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
                let Some([low, high]) = machine.axis(axis).and_then(|data| data.travel) else { continue };
                let shift = parts.shift()[axis];
                // The axis stands one tool length from its zero, along the spindle.
                let along = machine.spindle.axis[dimension];
                let [near, far] = [shortest * along, longest * along].map(|mm| shift + mm);
                if near.min(far) <= high + ROOM_MM && near.max(far) >= low - ROOM_MM {
                    continue;
                }
                let [shift, low, high] = [shift, low, high].map(|one| shown_position(false, one));
                let message = format!(
                    "{axis} {shift} mm of {name} is outside the travel of {axis}, {low} to {high} mm: no tool reaches this zero"
                );
                let help = "compare value and sign with the control; on a part that is longer than the travel, the zero may be right";
                found.push(Diagnostic::nowhere(Code::ZERO_OUT_OF_REACH, message, help));
            }
        }
        found
    }
}
