//! Look-ahead in a stream of elements: the successor of a move, and the rotary axes that the current operation turns with feed.
//!
//! An operation lasts from one change of the tool, of a tilted frame or of a five-axis transformation to the next. It is examined up to [`MOST_HELD`]
//! elements ahead. In a longer operation, an axis counts as turned from the element on that shows it.

use std::collections::VecDeque;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Matrix, ROTARY_AXES};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, HoleTrigger, Kind, Move};

use super::lost_axes;
use super::tip_divider::{DividedTips, TipDivider};

/// Maximum number of held elements.
const MOST_HELD: usize = 2048;
/// Maximum bytes of held texts: comments may be long.
const MOST_BYTES: usize = 1 << 20;
/// Positions that differ by less are equal within rounding noise, mm or rad.
const SAME_POSITION: f64 = 1e-9;

/// The successor of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly all are the large one; a box would be an allocation for each")]
pub(super) enum Upcoming {
    /// Another move, which begins where this one ends.
    Move(Move),
    /// A tool change, or axis motion by something other than a move.
    Change,
    /// No move in sight.
    Nothing,
}

impl Upcoming {
    /// `true` if a cut begins at the end of the move.
    pub(super) fn is_cut(&self) -> bool {
        matches!(self, Upcoming::Move(motion) if !motion.rapid)
    }
}

/// The stream, read some elements ahead of the consumer.
#[derive(Debug)]
pub(super) struct Ahead<'a, I> {
    /// Divided if the output leaves the transformation: its moves are straight in the axes.
    elements: DividedTips<'a, I>,
    machine: &'a Machine,
    held: VecDeque<Result<Element, Diagnostic>>,
    held_bytes: usize,
    /// The rotary axes to look for.
    rotary: AxisSet,
    operation: Operation,
    /// Number of held elements of the operation that were examined.
    seen: usize,
    /// `true` if the operation ends after them.
    is_closed: bool,
}

/// The current operation, as far as examined.
#[derive(Debug)]
struct Operation {
    /// Axes that it turns with feed.
    turned: AxisSet,
    /// Axis positions at its end, and which of them are known.
    last: AxisVector,
    known: AxisSet,
    /// Linear part of the frame that tilts the tool.
    linear: Matrix,
    is_transformed: bool,
}

impl<'a, I> Ahead<'a, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Creates a look-ahead for these rotary axes. With `tips`, paths of the tip are divided into chords that are straight in the axes.
    pub(super) fn new(elements: I, machine: &'a Machine, rotary: AxisSet, tips: Option<TipDivider<'a>>) -> Self {
        let operation = Operation {
            turned: AxisSet::EMPTY,
            last: AxisVector::ZERO,
            known: AxisSet::EMPTY,
            linear: Matrix::identity(),
            is_transformed: false,
        };
        let held = VecDeque::new();
        let elements = DividedTips { elements, tips };
        Ahead { elements, machine, held, held_bytes: 0, rotary, operation, seen: 0, is_closed: false }
    }

    /// The underlying stream.
    pub(super) fn elements(&self) -> &I {
        &self.elements.elements
    }

    /// The rotary axes that the operation of the last taken element turns with feed.
    pub(super) fn turned(&self) -> AxisSet {
        self.operation.turned
    }

    /// Takes the next element.
    pub(super) fn take(&mut self) -> Option<Result<Element, Diagnostic>> {
        let Some(item) = self.held.pop_front() else {
            // Without axes to look for, nothing is held.
            if self.rotary.is_empty() {
                return self.elements.next();
            }
            if !self.pull() {
                return None;
            }
            return self.take();
        };
        self.held_bytes -= bytes(&item);
        if self.rotary.is_empty() {
            return Some(item);
        }
        if self.seen > 0 {
            self.seen -= 1;
        } else if let Ok(element) = &item {
            if self.operation.ends_at(element, self.machine) {
                self.operation.turned = AxisSet::EMPTY;
            }
            self.is_closed = false;
            self.operation.see(element);
        }
        self.look();
        Some(item)
    }

    /// `true` if the last taken move triggers a drilling cycle.
    pub(super) fn triggers_cycle(&mut self) -> bool {
        if self.held.is_empty() {
            self.pull();
        }
        matches!(self.held.front(), Some(Ok(Element { kind: Kind::Cycle(Some(cycle)), .. })) if cycle.trigger == HoleTrigger::Motion)
    }

    /// Puts elements that were taken back to the front.
    pub(super) fn put_back(&mut self, elements: Vec<Element>) {
        if !self.rotary.is_empty() {
            self.seen += elements.len();
        }
        for element in elements.into_iter().rev() {
            let item = Ok(element);
            self.held_bytes += bytes(&item);
            self.held.push_front(item);
        }
    }

    /// The successor of the last taken element.
    pub(super) fn next(&mut self) -> Upcoming {
        for at in 0..MOST_HELD {
            if at == self.held.len() && (self.held_bytes > MOST_BYTES || !self.pull()) {
                break;
            }
            let Some(Ok(element)) = self.held.get(at) else { continue };
            if let Kind::Move(motion) = &element.kind {
                return Upcoming::Move(*motion);
            }
            if !lost_axes(element, self.machine).is_empty() {
                return Upcoming::Change;
            }
        }
        Upcoming::Nothing
    }

    /// Examines the rest of the operation, or as much of it as may be held.
    fn look(&mut self) {
        while !self.is_closed && !self.rotary.difference(self.operation.turned).is_empty() {
            let is_full = self.held.len() >= MOST_HELD || self.held_bytes > MOST_BYTES;
            if self.seen == self.held.len() && (is_full || !self.pull()) {
                break;
            }
            if let Some(Ok(element)) = self.held.get(self.seen) {
                if self.operation.ends_at(element, self.machine) {
                    self.is_closed = true;
                    break;
                }
                self.operation.see(element);
            }
            self.seen += 1;
        }
    }

    /// Holds one more element. Returns `false` at the end of the stream.
    fn pull(&mut self) -> bool {
        let item = self.elements.next();
        self.held_bytes += item.as_ref().map_or(0, bytes);
        let is_there = item.is_some();
        self.held.extend(item);
        is_there
    }
}

impl Operation {
    /// `true` if an element belongs to another operation.
    fn ends_at(&self, element: &Element, machine: &Machine) -> bool {
        match &element.kind {
            Kind::Move(_) => false,
            Kind::Setup(setup) => {
                setup.transform.is_some() != self.is_transformed || *setup.frame.linear() != self.linear
            }
            _ => !lost_axes(element, machine).is_empty(),
        }
    }

    /// Updates the operation with an element.
    fn see(&mut self, element: &Element) {
        match &element.kind {
            Kind::Move(motion) => {
                if !motion.rapid {
                    let turns = |&axis: &Axis| {
                        let was_known = self.known.contains(axis);
                        let is_named = motion.named.contains(axis);
                        let way = (motion.target[axis] - self.last[axis]).abs();
                        if was_known { way > SAME_POSITION } else { is_named }
                    };
                    let turned = ROTARY_AXES.into_iter().filter(turns).collect();
                    self.turned = self.turned.union(turned);
                }
                (self.last, self.known) = (motion.target, motion.known);
            }
            Kind::Setup(setup) => {
                self.linear = *setup.frame.linear();
                self.is_transformed = setup.transform.is_some();
            }
            _ => {}
        }
    }
}

/// Size of the texts of an element, bytes.
fn bytes(item: &Result<Element, Diagnostic>) -> usize {
    match item.as_ref().map(|element| &element.kind) {
        Ok(Kind::Comment(text) | Kind::Message(text) | Kind::Header(text) | Kind::Verbatim(text)) => text.len(),
        _ => 0,
    }
}
