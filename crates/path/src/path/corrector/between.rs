//! Elements between moves: words, frames, tool changes.

use std::sync::Arc;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::AxisSet;
use ncfix_machine::snc::{Element, HereStatement, Kind, Origin, Setup};

use super::{Corrector, sampler_of};
use crate::path::lead::Lead;
use crate::path::{Output, lost_axes};

/// The calls of single taps that the control executes with the words of the program.
const TAPS: [&[u8]; 4] = [b"G98 G74 ", b"G98 G84 ", b"G98 G84.2 ", b"G98 G84.3 "];

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Begins a move, or passes an element on.
    pub(super) fn take_in(&mut self, mut element: Element) {
        self.keep_pace(&element);
        if element.starts_block {
            self.prediction.repeated.note(&element.origin);
        }
        match &mut element.kind {
            Kind::Here(here) => self.here(&element.origin, here),
            Kind::Move(motion) => {
                let motion = *motion;
                self.begin(&element, &motion);
                return;
            }
            Kind::Setup(setup) => self.set_up(Arc::clone(setup)),
            Kind::Verbatim(text) if TAPS.iter().any(|call| text.starts_with(call)) => {
                self.check_tap(&element.origin);
                self.forget(lost_axes(&element, self.machine));
            }
            Kind::Keep(word) if self.placer.drops(word) => {
                self.pending.push_back(Ok(Output::Element(Element { kind: Kind::Empty, ..element })));
                return;
            }
            Kind::Before(words) | Kind::After(words) => {
                self.clamps.note(words);
                self.forget(lost_axes(&element, self.machine));
            }
            _ => self.forget(lost_axes(&element, self.machine)),
        }
        self.pending.push_back(Ok(Output::Element(element)));
    }

    /// Reports a tap whose depth and reference plane stay as programmed, if the tip is off there by more than the tolerance of holes.
    fn check_tap(&mut self, origin: &Origin) {
        let standing = &self.standing;
        let [.., along] = self.placer.setup.plane.axes();
        if !self.placer.is_parallel() || !AxisSet::XYZ.difference(standing.known).is_empty() {
            return;
        }
        let mut command = standing.command;
        command[along] = standing.nominal[along];
        let sides = [-1, 1].map(|side| {
            let mut state = standing.state;
            state.direction[along.slot()] = side;
            self.placer.tip_error_mm(&standing.nominal, &command, &state)
        });
        // Nobody states the side on which a call begins: the better one counts.
        let off_mm = sides[0].min(sides[1]);
        let tolerance_mm = self.options.hole_tolerance_mm.max(self.options.tolerance_mm);
        if off_mm > self.placer.increments.allowed_mm(tolerance_mm) {
            self.findings.tolerance_missed(origin, true, off_mm, tolerance_mm);
        }
    }

    /// Gives data that the control computes from its position the values of the corrected position.
    fn here(&mut self, origin: &Origin, here: &mut HereStatement) {
        let frame = &self.placer.setup.frame;
        let known = if self.placer.is_parallel() {
            self.standing.known
        } else {
            frame.known_across(self.standing.known, false)
        };
        let mixed = if here.frame.is_translation() { here.named } else { here.named.union(AxisSet::XYZ) };
        if self.placer.setup.transform.is_some() {
            self.findings.here_in_transform(origin, &here.words);
        } else if let Some(axis) = mixed.difference(known).iter().find(|axis| self.machine.axis(*axis).is_some()) {
            self.findings.here_unknown(origin, &here.words, axis);
        } else {
            here.stand_at(self.standing.command);
        }
    }

    /// Marks the positions of axes as unknown, after a tool change or motion outside the stream.
    fn forget(&mut self, axes: AxisSet) {
        self.standing.known = self.standing.known.difference(axes);
        self.standing.written = self.standing.written.difference(axes);
        self.standing.state.forget(axes);
        self.standing.band.forget(axes);
        self.standing.nominal_band.forget(axes);
    }

    /// Changes the meaning of coordinates; the machine stays.
    fn set_up(&mut self, setup: Arc<Setup>) {
        let standing = &mut self.standing;
        standing.is_doubtful |= setup.tool_mm != self.placer.setup.tool_mm;
        let (old, new) = (&self.placer.setup.frame, &setup.frame);
        if old.linear() != new.linear() {
            // Heights of one frame do not belong to another.
            self.initial = None;
        }
        if old.linear() != new.linear() && !self.placer.is_machine_frame() {
            standing.known = new.known_across(old.known_across(standing.known, false), true);
            standing.written = standing.written.intersection(standing.known);
        }
        let (before, head) = (self.placer.setup.head, setup.head);
        self.placer.set_up(setup, &standing.command, &mut standing.counts, &mut standing.written);
        if head != before {
            let model = self.placer.base.for_head(head);
            self.lead = Lead::new(model, self.machine);
            self.sampler = sampler_of(model, self.machine, &self.options);
            self.findings.set_head(head);
        }
        self.lead.model = self.placer.model;
    }
}
