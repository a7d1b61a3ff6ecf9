//! Determines the last line that was certainly executed, from the acknowledgements and the capacity of the control.
//!
//! A planner holds blocks, not lines. A line without motion takes no place in it, and neither does a move shorter than one step. So only moves that are
//! certainly a block count. The planner holds N of them at most; everything acknowledged before the last N was executed.

use std::collections::BTreeMap;

use crate::feed::JournalContents;
use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_path::path::Output;

/// Shortest move that is a block on any control, mm: as few as 4 steps per mm, and temperatures may add 0.2 mm to each end (`--max-shift`).
const BLOCK_MM: f64 = 0.65;
/// Shortest rotary move that is a block on any control, rad: one step per degree.
const BLOCK_RAD: f64 = 0.0175;

/// Elements of a journal's lines and the commanded positions at their ends.
#[derive(Clone, Debug, Default)]
pub struct Ends {
    /// First and last element that are kept.
    kept: [u64; 2],
    element: u64,
    at: BTreeMap<u64, AxisVector>,
}

impl Ends {
    /// Prepares for the lines that a journal has kept.
    #[must_use]
    pub fn new(told: &JournalContents) -> Ends {
        let kept = [told.lines.front(), told.lines.back()].map(|line| line.map_or(0, |line| line.element));
        Ends { kept, ..Ends::default() }
    }

    /// Takes the next element of the program.
    pub fn element(&mut self, output: &Output) {
        self.element += 1;
        if let Output::Piece(piece) = output
            && (self.kept[0]..=self.kept[1]).contains(&self.element)
        {
            self.at.insert(self.element, piece.command);
        }
    }

    /// Returns the last line that was certainly executed. `at_most` is the number of blocks that the control may hold; `None` if it is not known. A line
    /// that has only left proves nothing. The same applies to an answer that may have come twice, and to a control that does not state its capacity.
    #[must_use]
    pub fn sure(&self, told: &JournalContents, at_most: Option<u64>) -> u64 {
        let by_planner = at_most.filter(|_| told.left == 0).map_or(0, |at_most| self.before(told, at_most));
        told.executed.max(by_planner)
    }

    fn before(&self, told: &JournalContents, at_most: u64) -> u64 {
        if at_most == 0 {
            return told.checked;
        }
        let (mut blocks, mut later): (u64, Option<&AxisVector>) = (0, None);
        for line in told.lines.iter().rev().filter(|line| line.number <= told.checked) {
            let Some(end) = self.at.get(&line.element) else { continue };
            if later.is_some_and(|later| !is_block(end, later)) {
                continue;
            }
            blocks += u64::from(later.is_some());
            later = Some(end);
            if blocks >= at_most {
                return line.number;
            }
        }
        0
    }
}

fn is_block(from: &AxisVector, to: &AxisVector) -> bool {
    AXES.into_iter().any(|axis| (to[axis] - from[axis]).abs() >= if axis.is_rotary() { BLOCK_RAD } else { BLOCK_MM })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::Frozen;
    use ncfix_base::geometry::Axis;

    /// Makes one line per element, ending at these X, mm; all are acknowledged.
    fn job(ends_mm: &[Option<f64>]) -> (JournalContents, Ends) {
        let mut told = JournalContents::default();
        let mut ends = Ends::default();
        for (number, end_mm) in (1..).zip(ends_mm) {
            told.lines.push_back(Frozen { number, element: number, ..Frozen::default() });
            (told.frozen, told.acknowledged, told.checked) = (number, number, number);
            if let Some(mm) = end_mm {
                let mut end = AxisVector::ZERO;
                end[Axis::X] = *mm;
                ends.at.insert(number, end);
            }
        }
        (told, ends)
    }

    #[test]
    fn what_a_planner_may_hold_was_not_carried_out() {
        let steps: Vec<Option<f64>> = (1..=10).map(|k| Some(f64::from(k))).collect();
        let (mut told, ends) = job(&steps);
        // Ten blocks of 1 mm; a planner of three holds the last three.
        assert_eq!(ends.sure(&told, Some(3)), 7);
        assert_eq!([Some(9), Some(10), Some(100), None].map(|most| ends.sure(&told, most)), [1, 0, 0, 0]);
        assert_eq!(ends.sure(&told, Some(0)), 10);
        told.executed = 8;
        assert_eq!([Some(3), None].map(|most| ends.sure(&told, most)), [8, 8]);
        // Answers without other confirmation may have come twice.
        (told.executed, told.checked) = (0, 6);
        assert_eq!(ends.sure(&told, Some(3)), 3);
        told.checked = 0;
        assert_eq!([Some(0), Some(3)].map(|most| ends.sure(&told, most)), [0, 0]);
        (told.executed, told.checked) = (8, 10);
        // A byte that has left may not have been received.
        (told.executed, told.left) = (0, 10);
        assert_eq!(ends.sure(&told, Some(3)), 0);
    }

    #[test]
    fn lines_that_take_no_place_in_a_planner_do_not_count() {
        // After each move of 1 mm: a line without motion, such as F or M8, and a move of 10 µm.
        let ends_mm: Vec<Option<f64>> =
            (0..30).map(|k| [Some(f64::from(k / 3)), None, Some(f64::from(k / 3) + 0.01)][k as usize % 3]).collect();
        let (told, ends) = job(&ends_mm);
        // Moves end at 9.01 (line 30), 8.01 (27), 7.01 (24), 6.01 (21): three blocks follow line 21.
        assert_eq!(ends.sure(&told, Some(3)), 21);
        let (told, ends) = job(&[Some(0.0); 50]);
        assert_eq!(ends.sure(&told, Some(3)), 0);
    }
}
