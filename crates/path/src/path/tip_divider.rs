//! Paths of the tip as chords that are straight in the axes, for an output without the five-axis transformation.

use std::collections::VecDeque;

use ncfix_base::geometry::{AxisSet, AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Machine, TipPath};
use ncfix_machine::snc::{Element, Kind, Move, Turning};

/// A stream whose paths of the tip are divided, if there is a divider.
#[derive(Debug)]
pub(super) struct DividedTips<'a, I> {
    pub(super) elements: I,
    pub(super) tips: Option<TipDivider<'a>>,
}

impl<I, E> Iterator for DividedTips<'_, I>
where
    I: Iterator<Item = Result<Element, E>>,
{
    type Item = Result<Element, E>;

    fn next(&mut self) -> Option<Self::Item> {
        let Some(tips) = &mut self.tips else { return self.elements.next() };
        if let Some(chord) = tips.chords.pop_front() {
            return Some(Ok(chord));
        }
        Some(self.elements.next()?.map(|element| tips.take(element)))
    }
}

/// Divides the moves of a stream whose tip follows a path in the workpiece.
#[derive(Debug)]
pub(super) struct TipDivider<'a> {
    machine: &'a Machine,
    kinematics: Kinematics,
    tolerance_mm: f64,
    tool_mm: Vector,
    /// Command at the end of the last move.
    standing: AxisVector,
    /// Further chords of the last move.
    chords: VecDeque<Element>,
}

impl<'a> TipDivider<'a> {
    /// Starts at a position, within the chord tolerance of the control.
    pub(super) fn new(machine: &'a Machine, start: AxisVector) -> TipDivider<'a> {
        TipDivider {
            machine,
            kinematics: Kinematics::new(machine),
            tolerance_mm: machine.control.chord_tolerance_mm,
            tool_mm: Vector::zeros(),
            standing: start,
            chords: VecDeque::new(),
        }
    }

    /// Takes an element, and returns it or its first chord.
    fn take(&mut self, element: Element) -> Element {
        let motion = match &element.kind {
            Kind::Setup(setup) => {
                self.tool_mm = setup.tool_mm;
                self.kinematics.set_head(self.machine, setup.head);
                return element;
            }
            Kind::Move(motion) => *motion,
            _ => return element,
        };
        let start = std::mem::replace(&mut self.standing, motion.target);
        let Some(turning) = motion.tip else { return element };
        let path = TipPath::new(&self.kinematics, turning == Turning::Vector, [&start, &motion.target], &self.tool_mm);
        let arc = motion.arc.as_ref().map(|arc| (arc, motion.arc_basis.as_ref()));
        let chords = &mut self.chords;
        path.divide(arc, self.tolerance_mm, |target, share, off_mm| {
            let is_first = chords.is_empty();
            let chord = Move {
                target,
                arc: None,
                arc_basis: None,
                tip: None,
                named: if is_first { motion.named } else { AxisSet::EMPTY },
                feed: if motion.is_inverse_time() { motion.feed / share } else { motion.feed },
                feed_named: is_first && motion.feed_named,
                off_curve_mm: motion.off_curve_mm + off_mm,
                ..motion
            };
            let (starts_block, number) = if is_first { (element.starts_block, element.number) } else { (false, None) };
            chords.push_back(Element { starts_block, number, kind: Kind::Move(chord), ..element.clone() });
        });
        // The last chord ends where the move does.
        if let Some(Element { kind: Kind::Move(last), .. }) = chords.back_mut() {
            last.target = motion.target;
        }
        chords.pop_front().unwrap_or(element)
    }
}
