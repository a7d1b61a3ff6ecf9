//! Motions: rapid with or without positioning logic, straight, and what each becomes.

use std::sync::Arc as Shared;

use super::channel::Channel;
use super::gathered::Gathered;
use super::modal::MotionKind;
use super::target::Target;
use crate::exec::core::contour::{Shown, Wish, unstated};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::path::{Path, Shape};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, PlaneBasis};
use ncfix_base::source::Span;
use ncfix_machine::snc::{FeedUnit, Kind, Manner, Move, Way};

/// Nearer than this, mm or rad, nothing moves.
pub(super) const STILL: f64 = 1e-9;
/// Positioning logic: ways shorter than this, mm or rad, go along with the others. A correction adds some micrometers to every axis of
/// a move that is in order already.
const ALONG: f64 = 0.2;

impl Channel<'_> {
    /// The motion of a block, if it has one.
    pub(super) fn motion_words(&mut self, gathered: &mut Gathered) -> Result<(), Fault> {
        let block_feed = self.block_feed(gathered)?;
        let modal_feed = self.modal.feed;
        if let Some(feed) = block_feed {
            self.modal.feed = feed;
            self.feed_named = true;
        }
        let done = self.motion(gathered);
        if block_feed.is_some() {
            self.modal.feed = modal_feed;
        }
        done
    }

    /// `F6=`: the feed of this block only.
    fn block_feed(&self, gathered: &mut Gathered) -> Result<Option<f64>, Fault> {
        let Some((feed, span)) = gathered.once(b'F', Some(6))? else { return Ok(None) };
        if feed <= 0.0 {
            return Err(bad_value(span, "a feed must be above 0", "correct F6="));
        }
        Ok(Some(feed * self.modal.scale()))
    }

    fn motion(&mut self, gathered: &mut Gathered) -> Result<(), Fault> {
        if self.modal.geometry {
            self.corner_words(gathered)?;
            if self.open_element(gathered)? {
                return Ok(());
            }
        }
        let points = self.points(gathered)?;
        let is_arc = matches!(self.modal.motion, MotionKind::Clockwise | MotionKind::CounterClockwise);
        let incremental = self.modal.incremental;
        let target = self.target(gathered, incremental)?;
        if points.is_empty() {
            if is_arc {
                return self.arc_words(gathered, target);
            }
            if !target.named.is_empty() {
                return self.straight(target);
            }
            if self.feed_named {
                self.outlet.push(Kind::Feed(self.modal.feed));
            } else if gathered.items.is_empty() && gathered.codes.is_empty() && gathered.functions.is_empty() {
                self.outlet.push(Kind::Empty);
            }
            return Ok(());
        }
        if is_arc || (points.len() > 1 && !target.named.is_empty()) {
            let message = "a stored point in a block where it is not clear what it means";
            return Err(fault(
                Code::NOT_SUPPORTED,
                gathered.span,
                message,
                "program coordinates, or one point a block",
            ));
        }
        for point in points {
            let mut to = target;
            for axis in point.named.difference(target.named).iter() {
                to.to[axis] = point.values[axis];
            }
            to.named = to.named.union(point.named);
            // What the block does not name stays where the motion before has led.
            let here = self.here();
            for axis in [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C] {
                if !to.named.contains(axis) {
                    to.to[axis] = here[axis];
                }
            }
            self.straight(to)?;
        }
        Ok(())
    }

    /// A straight motion of the kind in force.
    pub(super) fn straight(&mut self, target: Target) -> Result<(), Fault> {
        match self.modal.motion {
            MotionKind::Rapid => self.rapid(target),
            _ => self.feed_line(&target.to, target.named, self.modal.feed),
        }
    }

    /// A rapid motion: with positioning logic first the tool axis where it leads off the work, else it comes last.
    pub(super) fn rapid(&mut self, target: Target) -> Result<(), Fault> {
        let Target { to, named } = target;
        let [.., applicate] = self.modal.plane.axes();
        let others = named.difference([applicate].into_iter().collect());
        let here = self.here();
        let is_moving = |axis: Axis| (to[axis] - here[axis]).abs() > ALONG;
        let is_split =
            self.may_split(named) && named.contains(applicate) && is_moving(applicate) && others.iter().any(is_moving);
        if !is_split {
            return self.rapid_line(&to, named);
        }
        let tool: AxisSet = [applicate].into_iter().collect();
        let away = (to[applicate] > here[applicate]) != self.modal.tool.reversed;
        let mut between = if away { here } else { to };
        between[applicate] = if away { to[applicate] } else { here[applicate] };
        let (first, second) = if away { (tool, others) } else { (others, tool) };
        self.rapid_line(&between, first)?;
        self.rapid_line(&to, second)
    }

    /// One straight line at rapid.
    pub(super) fn rapid_line(&mut self, to: &AxisVector, named: AxisSet) -> Result<(), Fault> {
        self.elementary(to, named, true, self.modal.feed, |_| Ok(Shape::Line))
    }

    /// One straight line with feed.
    pub(super) fn feed_line(&mut self, to: &AxisVector, named: AxisSet, feed: f64) -> Result<(), Fault> {
        self.check_feed(feed, self.outlet.origin.span)?;
        self.elementary(to, named, false, feed, |_| Ok(Shape::Line))
    }

    /// One elementary motion. `shape` gets its ends in base coordinates, and the working plane behind the frame.
    pub(super) fn elementary(
        &mut self,
        to: &AxisVector,
        named: AxisSet,
        rapid: bool,
        feed: f64,
        shape: impl FnOnce([&AxisVector; 2]) -> Result<Shape, Fault>,
    ) -> Result<(), Fault> {
        let span = self.outlet.origin.span;
        let start = self.modal.command;
        let target = self.reach(to, named);
        if let Some(axis) = AXES_OF_MOTION.into_iter().find(|&axis| target[axis].is_nan() || target[axis].abs() > 1e9) {
            return Err(bad_value(span, format!("{axis} would move to {}", target[axis]), "check the values"));
        }
        let basis = PlaneBasis::behind(&self.setup.frame, self.modal.plane)
            .ok_or_else(|| bad_value(span, "the frame squeezes the working plane flat", "check G73"))?;
        let start_known = self.shown_axes(self.modal.known, false);
        // What follows begins where the block leads, also where its way is faulty.
        let found = shape([&start, &target]);
        self.modal.command = target;
        self.modal.known = self.modal.known.union(named);
        let shape = found?;
        let (moving, stated) = (self.shown_axes(named, true), self.shown_axes(self.modal.known, false));
        // A turned axis moves two of the output: where the other one stands decides where both end.
        if let Some(axis) = moving.difference(stated).iter().next().filter(|_| self.strict) {
            let message = format!("where {axis} goes depends on an axis that the program has not stated yet");
            let help = "begin with a block that names all axes of the rotation, or give --start";
            return Err(fault(Code::UNKNOWN_START, span, message, help));
        }
        if std::mem::replace(&mut self.has_moved, true) {
            self.outlet.begin_line();
        }
        self.show_setup();
        let motion = Move {
            rapid,
            arc: None,
            target,
            named: moving,
            known: stated,
            feed,
            feed_named: std::mem::take(&mut self.feed_named),
            unit: if self.modal.per_turn { FeedUnit::PerTurn } else { FeedUnit::PerMinute },
            ways: [Way::Plain; 3],
            in_machine_frame: false,
            manner: Manner::Path,
            off_curve_mm: 0.0,
        };
        let path = Path { motion, start, start_known, basis, shape, setup: Shared::clone(&self.setup), span };
        self.put(path);
        Ok(())
    }

    /// Puts a motion into the stream, through the contour stage where it must.
    fn put(&mut self, path: Path) {
        let (mut contour, corner, soft) =
            (self.modal.contour, self.corner.take(), self.soft.take().map(|(soft, _)| soft));
        let is_free = corner.is_none() && soft.is_none() && !self.is_open;
        if is_free && contour.is_plain() && !self.outlet.is_holding() {
            self.outlet.pass_plain(&path);
            return;
        }
        if self.outlet.keeps_wear && contour.compensates() {
            contour.shown = Shown::of(&path.basis, &self.shown.frame, self.modal.plane);
        }
        let wish = Wish::of(contour, self.radius_mm(), path.span, self.outlet.origin.file);
        let wish = Wish { corner, soft, ..wish };
        if self.strict {
            self.outlet.warnings.extend(unstated(&path, &wish, self.modal.plane));
        }
        let tool = self.modal.tool.number;
        self.outlet.name_register(&wish, || tool.map_or_else(|| "the tool".to_owned(), |tool| format!("T{tool}")));
        let element = self.outlet.element(Kind::Empty);
        if self.is_open {
            self.outlet.open(path, element, wish);
        } else {
            self.outlet.pass_path(path, element, wish);
        }
    }

    /// Axis commands of programmed positions; those of axes that nothing names keep their last bit where the frame only shifts.
    pub(super) fn reach(&self, to: &AxisVector, named: AxisSet) -> AxisVector {
        let frame = &self.setup.frame;
        if !frame.is_translation() {
            return self.setup.command(to);
        }
        let mut target = self.modal.command;
        for axis in named.iter() {
            let tool = if axis.slot() < 3 { self.setup.tool_mm[axis.slot()] } else { 0.0 };
            target[axis] = to[axis] + frame.shift(axis) - tool;
        }
        target
    }

    /// A finding at the block.
    pub(super) fn block_fault(&self, code: Code, message: impl Into<String>, help: &str) -> Fault {
        let span: Span = self.outlet.origin.span;
        fault(code, span, message, help)
    }
}

/// Axes whose positions are checked.
const AXES_OF_MOTION: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C];
