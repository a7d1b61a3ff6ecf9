//! Zero offsets that the tool cannot reach: mostly a wrong sign, or a value of another machine.

use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Axis;
use ncfix_base::units::shown_position;

/// Length of the longest tool if the machine file has no tools, mm.
const LONGEST_MM: f64 = 500.0;
/// Rounding of a display, mm.
const ROOM_MM: f64 = 1e-3;

impl Machine {
    /// A warning for each zero offset whose zero no tool of the machine can reach: on a long part that is possible.
    pub(crate) fn unreachable_zeros(&self) -> Vec<Diagnostic> {
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
