//! Turns the gathered words of a block into motions: targets, ways, and what the stream is told of them.

use std::sync::Arc as Shared;

use super::channel::Channel;
use super::codes::Group;
use super::gathered::Gathered;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::path::{Path, Shape};
use crate::exec::core::rollover;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, PlaneBasis};
use ncfix_base::source::Span;
use ncfix_machine::snc::{FeedUnit, Kind, Manner, Move, Setup};

/// Positions beyond this are no positions, mm or rad.
const FARTHEST: f64 = 1e9;

/// One motion to a position.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) rapid: bool,
    /// Where it ends, as programmed.
    pub(super) end: AxisVector,
    /// Axes that it names.
    pub(super) named: AxisSet,
    /// Whether its block has F.
    pub(super) feed_named: bool,
    pub(super) manner: Manner,
    pub(super) span: Span,
}

impl Step {
    /// A straight motion of a block.
    pub(super) fn straight(gathered: &Gathered, rapid: bool, end: AxisVector, named: AxisSet) -> Step {
        let feed_named = gathered.has(b'F');
        Step { rapid, end, named, feed_named, manner: Manner::Path, span: gathered.span }
    }
}

impl Channel<'_> {
    /// The motion of a block with axis words or a center, by a kind in tenths.
    pub(super) fn motion(&mut self, gathered: &Gathered, code: u16) -> Result<(), Fault> {
        if let Some(span) = gathered.machine_frame {
            return self.machine_motion(gathered, code, span);
        }
        self.direction = self.tool_direction(gathered, code)?;
        let done = self.way(gathered, code);
        self.direction = None;
        done
    }

    fn way(&mut self, gathered: &Gathered, code: u16) -> Result<(), Fault> {
        match code {
            0 | 10 => {
                let (end, named) = self.end(gathered)?;
                self.corner_words(gathered)?;
                self.step(Step::straight(gathered, code == 0, end, named))
            }
            20 | 30 => {
                let (end, named) = self.end(gathered)?;
                self.corner_words(gathered)?;
                self.arc(gathered, code, end, named)
            }
            _ => self.special_motion(gathered, code),
        }
    }

    /// The programmed end of a block, and the axes that it names.
    pub(super) fn end(&mut self, gathered: &Gathered) -> Result<(AxisVector, AxisSet), Fault> {
        let here = self.here();
        let (mut end, mut named) = (here, gathered.axes);
        for axis in gathered.axes.iter() {
            let value = self.axis_value(gathered, axis)?;
            if self.modal.incremental {
                self.check_stated(axis, gathered.span_of(axis.letter()))?;
                end[axis] += value;
            } else {
                end[axis] = self.absolute(gathered, axis, value, here[axis])?;
            }
        }
        if let Some((others, values)) = self.other_axes(gathered, named)? {
            others.iter().for_each(|axis| end[axis] = values[axis]);
            named = named.union(others);
        }
        self.polar_end(gathered, &here, &mut end, &mut named)?;
        Ok((end, named))
    }

    /// A straight motion to a programmed position.
    pub(super) fn step(&mut self, step: Step) -> Result<(), Fault> {
        let setup = Shared::clone(&self.setup);
        let target = self.reach(&setup, step.named, &step.end, step.span)?;
        self.send(step, target, Shape::Line, setup)
    }

    /// `G53`: positions of the machine, for this block.
    fn machine_motion(&mut self, gathered: &Gathered, code: u16, span: Span) -> Result<(), Fault> {
        if !matches!(code, 0 | 10) {
            let message = "G53 stands with G0 or G1";
            return Err(fault(Code::NOT_SUPPORTED, span, message, "program G0 or G1 in the block of G53"));
        }
        if self.modal.incremental {
            // A Fanuc ignores it; a motion that somebody has programmed does not vanish.
            return Err(fault(Code::BAD_WORD_VALUE, span, "G53 under G91", "program G90 in the block"));
        }
        self.no_compensation(span, "G53")?;
        let here = self.modal.command;
        let mut end = here;
        for axis in gathered.axes.iter() {
            let value = self.axis_value(gathered, axis)?;
            end[axis] = self.absolute(gathered, axis, value, here[axis])?;
        }
        self.machine_step(Step::straight(gathered, code == 0, end, gathered.axes))
    }

    /// A straight motion to a position of the machine.
    pub(super) fn machine_step(&mut self, step: Step) -> Result<(), Fault> {
        // Positions of the axes: what the tool takes off is added before, so that the place of the tip stays known.
        let tool_mm = self.setup.tool_mm;
        let mut shift = AxisVector::ZERO;
        shift.set_xyz(tool_mm);
        let frame = Frame::translation(shift);
        let bare = Shared::new(Setup { frame, tool_mm, plane: self.modal.plane, transform: None, assumed: false });
        self.settle_axes(step.named);
        self.push(Kind::Keep("G53"));
        self.push(Kind::Setup(Shared::clone(&bare)));
        self.setup_changed = true;
        let full = self.setup.frame;
        self.modal.known = known_behind(self.modal.known, &full, &bare.frame);
        let target = self.reach(&bare, step.named, &step.end, step.span);
        let sent = target.and_then(|target| self.send(step, target, Shape::Line, Shared::clone(&bare)));
        self.modal.known = known_behind(self.modal.known, &bare.frame, &full);
        sent
    }

    /// Axis commands of programmed positions of the named axes.
    pub(super) fn reach(
        &self,
        setup: &Setup,
        named: AxisSet,
        end: &AxisVector,
        span: Span,
    ) -> Result<AxisVector, Fault> {
        let mut target = self.modal.command;
        if setup.frame.is_translation() {
            // Axis by axis, so that the command of an axis that the block does not name keeps its last bit.
            for axis in named.iter() {
                let tool = if axis.slot() < 3 { setup.tool_mm[axis.slot()] } else { 0.0 };
                target[axis] = end[axis] + setup.frame.shift(axis) - tool;
            }
        } else {
            target = setup.command(end);
        }
        match named.iter().find(|&axis| !target[axis].is_finite() || target[axis].abs() > FARTHEST) {
            Some(axis) => Err(bad_value(span, format!("{axis} would move to {}", target[axis]), "check the value")),
            None => Ok(target),
        }
    }

    /// Puts a motion into the stream.
    pub(super) fn send(
        &mut self,
        step: Step,
        target: AxisVector,
        shape: Shape,
        setup: Shared<Setup>,
    ) -> Result<(), Fault> {
        let in_machine_frame = !Shared::ptr_eq(&setup, &self.setup);
        if !in_machine_frame {
            self.check_offset(step.span);
            if std::mem::take(&mut self.setup_changed) {
                self.push(Kind::Setup(Shared::clone(&self.shown)));
            }
        }
        self.check_feed(&step);
        if self.modal.transforms.tilt().is_some() && !in_machine_frame {
            self.check_tilt(step.named, step.span)?;
        }
        let basis = PlaneBasis::behind(&setup.frame, self.modal.plane)
            .ok_or_else(|| bad_value(step.span, "the frame squeezes the working plane flat", "check its factors"))?;
        let (start, start_known) = (self.modal.command, self.modal.known);
        self.modal.known = start_known.union(step.named);
        self.modal.command = target;
        let (mut named, mut known, mut begun) = (step.named, self.modal.known, start_known);
        if !in_machine_frame && !Shared::ptr_eq(&self.setup, &self.shown) && !setup.frame.is_translation() {
            let inner = &self.shown.frame;
            named = inner.inverse().mixed_with(setup.frame.mixed_with(named));
            known = known_behind(known, &setup.frame, inner);
            begun = known_behind(begun, &setup.frame, inner);
            // A turned axis moves two of the output: where the other one stands decides where both end.
            if let Some(axis) = named.difference(known).iter().next().filter(|_| self.strict) {
                return Err(unknown_mixed(step.span, axis));
            }
        }
        // What the spindle drives has no feed of its own.
        let is_driven = matches!(step.manner, Manner::Thread(thread) if thread.code.is_spindle_driven());
        let motion = Move {
            rapid: step.rapid,
            arc: None,
            target,
            named,
            known,
            feed: if is_driven { 0.0 } else { self.modal.feed },
            feed_named: step.feed_named && !is_driven,
            unit: if is_driven { FeedUnit::PerMinute } else { self.modal.feed_mode },
            ways: Default::default(),
            in_machine_frame,
            manner: step.manner,
            off_curve_mm: 0.0,
        };
        let mut path = Path { motion, start, start_known: begun, basis, shape, setup, span: step.span };
        if let Some((direction, span)) = self.direction {
            self.orient(&mut path, direction, span)?;
        }
        self.has_moved = true;
        self.pass(path);
        Ok(())
    }

    fn check_feed(&mut self, step: &Step) {
        if step.rapid || self.modal.feed > 0.0 && (step.feed_named || self.modal.feed_mode != FeedUnit::InverseTime) {
            return;
        }
        if matches!(step.manner, Manner::Thread(thread) if thread.code.is_spindle_driven()) {
            return;
        }
        let (message, help) = match self.modal.feed_mode {
            FeedUnit::InverseTime => ("a feed motion in G93 without F", "program F in each block with G93"),
            _ => ("a feed motion, and no F was programmed yet", "program F before it or in it"),
        };
        if self.strict {
            self.outlet.warnings.push(fault(Code::MISSING_FEED, step.span, message, help));
        } else if !std::mem::replace(&mut self.feed_warned, true) {
            self.outlet.warnings.push(fault(Code::FEED_ASSUMED, step.span, message, help));
        }
    }

    /// The value of an axis word, mm or rad.
    pub(super) fn axis_value(&mut self, gathered: &Gathered, axis: Axis) -> Result<f64, Fault> {
        let value =
            if axis.is_rotary() { self.angle(gathered, axis.letter())? } else { self.length(gathered, axis.letter())? };
        Ok(value.unwrap_or_default())
    }

    /// The position that an absolute word means, with its turns.
    pub(super) fn absolute(&self, gathered: &Gathered, axis: Axis, value: f64, here: f64) -> Result<f64, Fault> {
        let here = Some(here).filter(|_| self.modal.known.contains(axis));
        rollover::position(self.machine, axis, value, here, gathered.span_of(axis.letter()))
    }

    /// Refuses axes that the machine lacks.
    pub(super) fn check_axes(&self, gathered: &Gathered) -> Result<(), Fault> {
        if gathered.code(Group::Action) == Some(40) && !self.is_rs274() {
            // The time of a dwell is no position.
            return Ok(());
        }
        match gathered.axes.difference(self.axes).iter().next() {
            None => Ok(()),
            Some(axis) => {
                let message = format!("the machine has no axis {axis}");
                let help = "choose the right --machine, or add the axis to its file";
                Err(fault(Code::NO_AXIS, gathered.span_of(axis.letter()), message, help))
            }
        }
    }

    /// The kind of motion of a block that names a code of motion or has words for the one in force.
    pub(super) fn motion_of(&self, gathered: &Gathered) -> Option<u16> {
        if let Some(code) = self.code_of_motion(gathered) {
            return Some(code);
        }
        let is_arc = matches!(self.modal.motion, 20 | 30) || self.has_directions();
        let moves = !gathered.axes.is_empty() || gathered.has_any(b"@^") || is_arc && gathered.has_any(b"IJKR");
        moves.then_some(self.modal.motion)
    }
}

/// Which axes of a new frame are stated, where those in `known` of an old one are.
pub(super) fn known_behind(known: AxisSet, old: &Frame, new: &Frame) -> AxisSet {
    new.known_across(old.known_across(known, false), true)
}

fn unknown_mixed(span: Span, axis: Axis) -> Fault {
    let message = format!("where {axis} goes depends on an axis that the program has not stated yet");
    fault(Code::UNKNOWN_START, span, message, "begin with a block that names all axes of the rotation, or give --start")
}

pub(super) fn unknown_start(span: Span, axis: Axis) -> Fault {
    fault(
        Code::UNKNOWN_START,
        span,
        format!("the program has not stated where {axis} is"),
        "begin with an absolute position of this axis, or give --start",
    )
}
