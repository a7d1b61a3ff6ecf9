//! The treatment of a move: corrected along its path, at its end, or not at all.

use ncfix_base::geometry::AxisVector;
use ncfix_machine::machine::Machine;

use super::Rapids;
use super::findings::ON_LIMIT;

/// The treatment of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MoveTreatment {
    /// The named axes go to their programmed positions, the others stay.
    Programmed,
    /// The axes named are corrected at its end, the others stay.
    Named,
    /// Corrected at its end, in one piece.
    End,
    /// Corrected along the path.
    RotaryDirection,
}

impl MoveTreatment {
    /// Treatment of a cut or of the approach to one; `is_placed` if its start and all axes that place the tool are known.
    pub(super) fn of(rapid: bool, rapids: Rapids, is_placed: bool) -> MoveTreatment {
        match (rapid, rapids) {
            (true, Rapids::None) => MoveTreatment::Programmed,
            (true, Rapids::Ends) => MoveTreatment::End,
            _ if is_placed => MoveTreatment::RotaryDirection,
            _ => MoveTreatment::End,
        }
    }

    /// `true` if axes that the program does not move stay.
    pub(super) fn leaves_others(self) -> bool {
        matches!(self, MoveTreatment::Programmed | MoveTreatment::Named)
    }
}

/// `true` if a correction leads out of the travel of an axis from a place within it. A program that moves to the end of an axis, typically to a
/// reference point, means that end and not a place relative to the workpiece.
pub(super) fn is_pushed_out(machine: &Machine, nominal: &AxisVector, command: &AxisVector) -> bool {
    machine.axes.iter().flatten().any(|data| {
        data.travel.is_some_and(|[low, high]| {
            let is_within = |position: f64| (low - ON_LIMIT..=high + ON_LIMIT).contains(&position);
            is_within(nominal[data.axis]) && !is_within(command[data.axis])
        })
    })
}
