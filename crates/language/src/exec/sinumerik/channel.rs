//! The channel: executes the gathered words of one block in their fixed order and puts elements into the stream.

use std::sync::Arc;

use super::angle::OpenAngle;
use super::frames;
use super::gathered::Gathered;
use super::modal::{Modal, initial_zero_offset, unit_behind};
use super::motion::{MotionContext, motion};
use super::rotary;
use super::spline::{self, Splines};
use super::system::System;
use super::variables::Variables;
use crate::exec::core::contour::{Corner, Soft};
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::options::Options;
use crate::exec::core::outlet::{HasOutlet, Outlet};
use crate::exec::core::radius::Radius;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, Frame, LINEAR_AXES, Plane};
use ncfix_base::source::Span;
use ncfix_base::units::MM_PER_INCH;
use ncfix_dialect::CodeTable;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{BlockNumber, FeedUnit, Kind, Manner, Origin, Setup, Word, WordValue};

/// State and output of the channel.
pub(super) struct Channel<'a> {
    pub(super) machine: &'a Machine,
    pub(super) outlet: Outlet<'a>,
    pub(super) modal: Modal,
    pub(super) variables: Variables,
    pub(super) system: System,
    pub(super) codes: &'static CodeTable,
    /// Whether the block has moved a geometry axis.
    pub(super) has_moved: bool,
    pub(super) splines: Splines,
    /// What the motion to come wants of the contour stage.
    pub(super) corner: Option<Corner>,
    /// FRC of a block without a transition of its own.
    pub(super) corner_feed: Option<f64>,
    pub(super) soft: Option<Soft>,
    /// A motion whose end the next one tells.
    pub(super) open_angle: Option<OpenAngle>,
    pub(super) strict: bool,
    /// Which radius G41 and G42 work with.
    pub(super) radius: Radius,
    pub(super) setup: Arc<Setup>,
    setup_changed: bool,
    /// Line of the first length or feed that was programmed before any unit code.
    unitless: Option<u32>,
    unit_stated: bool,
    feed_warned: bool,
}

impl<'a> HasOutlet<'a> for Channel<'a> {
    fn outlet(&mut self) -> &mut Outlet<'a> {
        &mut self.outlet
    }
}

impl<'a> Channel<'a> {
    pub(super) fn new(machine: &'a Machine, options: &Options, codes: &'static CodeTable) -> Self {
        let mut channel = Channel {
            machine,
            modal: Modal::new(options.start, machine),
            variables: Variables::new(machine, options.strict),
            system: System::new(options.strict, machine),
            outlet: Outlet::new(machine, options),
            splines: Splines::default(),
            corner: None,
            corner_feed: None,
            soft: None,
            open_angle: None,
            codes,
            has_moved: false,
            strict: options.strict,
            radius: options.radius,
            setup: Arc::default(),
            setup_changed: true,
            unitless: None,
            unit_stated: false,
            feed_warned: false,
        };
        let order = machine.control.rotation_order;
        channel.modal.base = channel.system.frames.base(order).unwrap_or_else(Frame::identity);
        if let Some(offset) = machine.zero_offsets.get(initial_zero_offset(machine)) {
            channel.modal.settable = offset.frame(order).unwrap_or_else(Frame::identity);
        }
        channel.refresh_setup();
        channel.note_initial_codes();
        channel.modal.programmed = channel.setup.programmed(&channel.modal.command);
        channel
    }

    /// A new block: its elements carry this origin and number.
    pub(super) fn begin_block(&mut self, origin: Origin, number: Option<BlockNumber>) {
        self.outlet.begin_block(origin, number);
        self.has_moved = false;
    }

    /// Puts an element into the stream.
    pub(super) fn push(&mut self, kind: Kind) {
        if self.splines.is_holding() {
            let element = self.outlet.element(kind);
            self.hold(element);
        } else {
            self.outlet.push(kind);
        }
    }

    /// Executes a block's words.
    pub(super) fn execute(
        &mut self,
        gathered: &mut Gathered,
        comment: Option<Vec<u8>>,
        span: Span,
    ) -> Result<(), Fault> {
        self.contour_words(gathered)?;
        self.check_state(gathered, span)?;
        self.modal_codes(gathered)?;
        for &word in &gathered.keep {
            self.keep(word);
        }
        if gathered.is_complete {
            self.feed_for_call();
        }
        for text in std::mem::take(&mut gathered.verbatim) {
            self.push(Kind::Verbatim(text));
        }
        self.outlet.warnings.extend(gathered.warning.take());
        self.check_diameter(gathered)?;
        self.transform(gathered)?;
        self.surface(gathered)?;
        self.offset(gathered)?;
        if let Some(statement) = gathered.frame {
            self.frame_statement(gathered, statement)?;
            self.comment(comment);
            return Ok(());
        }
        frames::without_statement(gathered)?;
        if let Some(pole) = gathered.pole {
            self.set_pole(gathered, pole)?;
            self.comment(comment);
            return Ok(());
        }
        self.tool(gathered)?;
        self.check_edge(gathered, span);
        if let Some(at) = gathered.dwell {
            self.dwell(gathered, at)?;
            self.comment(comment);
            return Ok(());
        }
        self.feed_and_speed(gathered);
        if let Some(text) = gathered.message.take() {
            self.push(Kind::Message(text));
        }
        let before = std::mem::take(&mut gathered.before);
        if before.iter().chain(&gathered.after).any(|word| self.is_moved_by(word)) {
            gathered.lost = AxisSet::ALL;
        }
        if !before.is_empty() {
            self.push(Kind::Before(before));
        }
        let moves = !gathered.named.is_empty()
            || gathered.center.iter().any(Option::is_some)
            || gathered.addresses.iter().any(|value| value.address.moves());
        if moves {
            self.comment(comment);
            self.angle(gathered, span)?;
            self.motion(gathered, span)?;
        } else {
            if gathered.feed.is_some() {
                self.push(Kind::Feed(self.modal.feed));
            }
            self.comment(comment);
        }
        let after = std::mem::take(&mut gathered.after);
        if !after.is_empty() {
            self.push(Kind::After(after));
        }
        if !gathered.lost.is_empty() {
            let lost = self.modal.forget(gathered.lost);
            self.push(Kind::Lost(lost));
        }
        Ok(())
    }

    /// Before the call of a program of the control, which finds the feed of this one.
    pub(super) fn feed_for_call(&mut self) {
        if self.modal.feed_unit != FeedUnit::InverseTime && !self.splines.is_holding() {
            self.outlet.feed_for_call(self.modal.feed);
        }
    }

    /// Whether a word is an M function that moves axes by what the machine file says.
    fn is_moved_by(&self, word: &Word) -> bool {
        let is_function = word.letter == b'M' && word.extension.is_none();
        matches!(word.value, WordValue::Number(number) if is_function && self.outlet.function_moves(number))
    }

    /// Puts a comment into the stream.
    pub(super) fn comment(&mut self, comment: Option<Vec<u8>>) {
        if let Some(comment) = comment {
            self.push(Kind::Comment(comment));
        }
    }

    fn modal_codes(&mut self, gathered: &Gathered) -> Result<(), Fault> {
        if let Some((inch, with_feed)) = gathered.inch {
            if let Some(first) = self.unitless.filter(|_| inch && !self.unit_stated) {
                return Err(fault(
                    Code::UNITS_DOUBT,
                    self.outlet.origin.span,
                    format!(
                        "the program switches to inch here, and has lengths or feeds from line {first} on without a unit"
                    ),
                    "state the unit (G71 or G710, G70 or G700) in the first block",
                ));
            }
            self.unit_stated = true;
            self.modal.inch = inch;
            self.modal.inch_feed = inch && with_feed;
            self.modal.technological = with_feed;
        }
        let has_length =
            gathered.named.iter().any(|axis| !axis.is_rotary()) || gathered.feed.is_some() && gathered.dwell.is_none();
        if !self.unit_stated && self.unitless.is_none() && has_length {
            self.unitless = Some(self.outlet.origin.line);
        }
        if let Some((kind, _)) = gathered.motion {
            self.modal.motion = kind;
        }
        for &(is_end, end) in &gathered.curve.ends {
            self.modal.spline_ends[usize::from(is_end)] = end;
        }
        let unit = gathered.feed_mode.map_or(self.modal.feed_unit, |word| unit_behind(self.modal.feed_unit, word));
        if unit != self.modal.feed_unit {
            // F meant something else: it must be programmed again.
            self.modal.feed_unit = unit;
            self.modal.feed = 0.0;
        }
        if let Some(incremental) = gathered.incremental {
            self.modal.incremental = incremental;
        }
        if let Some(plane) = gathered.plane.and_then(Plane::from_number)
            && plane != self.modal.plane
        {
            self.modal.plane = plane;
            let stated = self.modal.known.union(self.modal.moved_by_plane);
            self.refresh_setup();
            self.modal.moved_by_plane = stated.difference(self.modal.known);
        }
        Ok(())
    }

    fn feed_and_speed(&mut self, gathered: &mut Gathered) {
        self.lead_change(gathered);
        if let Some((feed, _)) = gathered.feed {
            let is_inch = self.modal.inch_feed && self.modal.feed_unit != FeedUnit::InverseTime;
            self.modal.feed = if is_inch { feed * MM_PER_INCH } else { feed };
        }
        if let Some((speed, _)) = gathered.speed {
            self.modal.speed = Some(speed);
            let word = Word { letter: b'S', extension: None, value: WordValue::Number(speed) };
            // Behind D, before M.
            let place = gathered.before.iter().take_while(|word| word.letter == b'D').count();
            gathered.before.insert(place, word);
        }
    }

    fn motion(&mut self, gathered: &Gathered, span: Span) -> Result<(), Fault> {
        self.check_swivelled(span)?;
        let geometry = || LINEAR_AXES.into_iter().take(3).any(|axis| gathered.named.contains(axis));
        self.has_moved = gathered.named.is_empty() || geometry();
        let setup = if let Some(word) = gathered.suppress {
            let bare = Arc::new(self.suppressed(word));
            self.push(Kind::Setup(Arc::clone(&bare)));
            self.setup_changed = true;
            self.modal.known = known_behind(self.modal.known, &self.setup.frame, &bare.frame);
            bare
        } else {
            if std::mem::take(&mut self.setup_changed) {
                self.push(Kind::Setup(Arc::clone(&self.setup)));
            }
            Arc::clone(&self.setup)
        };
        self.corner_words(gathered)?;
        let context = MotionContext {
            machine: self.machine,
            control: &self.machine.control,
            setup: &setup,
            is_suppressed: gathered.suppress.is_some(),
            strict: self.strict,
            span,
        };
        let modal_feed = self.modal.feed;
        if let Some(feed) = gathered.block_feed {
            self.modal.feed = feed;
        }
        let found = motion(gathered, &mut self.modal, context);
        self.modal.feed = modal_feed;
        if gathered.suppress.is_some() {
            self.modal.known = known_behind(self.modal.known, &setup.frame, &self.setup.frame);
        }
        let mut path = found?;
        if path.motion.rapid {
            path.motion.feed = modal_feed;
        } else {
            path.motion.feed_named |= gathered.block_feed.is_some();
        }
        self.outlet.warnings.extend(rotary::either_way(&path.motion.ways, span));
        self.check_manner(&mut path)?;
        let step = &path.motion;
        let is_driven = matches!(step.manner, Manner::Thread(thread) if thread.code.is_spindle_driven());
        if !step.rapid && !is_driven && step.feed <= 0.0 && !std::mem::replace(&mut self.feed_warned, true) {
            let message = "a feed motion, and no F was programmed yet";
            self.outlet.warnings.push(fault(Code::FEED_ASSUMED, span, message, "program F before it or in it"));
        }
        self.orient(gathered, &mut path)?;
        let node = spline::node(gathered, &self.modal)?;
        self.push_path(path, node)
    }

    /// Puts frame and tool in force. An axis along which the tool length changes is taken as unknown until the program states it
    /// again: how and when a control traverses the change is a setting of the control (Sinumerik SD42940, SD42442).
    pub(super) fn refresh_setup(&mut self) {
        let setup = self.modal.setup();
        self.keep_pose(&setup);
        for axis in LINEAR_AXES.into_iter().take(3) {
            if setup.tool_mm[axis.slot()] != self.setup.tool_mm[axis.slot()] {
                self.modal.known.remove(axis);
                self.modal.moved_by_plane.remove(axis);
            }
        }
        let (old, new) = (&self.setup.frame, &setup.frame);
        if old.linear() != new.linear() {
            self.modal.known = known_behind(self.modal.known, old, new);
            let is_other = |axis: &Axis| old.unapply_row(*axis) != new.unapply_row(*axis);
            self.modal.stale = self.modal.stale.union(AxisSet::XYZ.iter().filter(is_other).collect());
        }
        self.setup = Arc::new(setup);
        self.setup_changed = true;
    }

    /// What holds in a block with a word that suppresses frames: G53 leaves the base frame.
    fn suppressed(&self, word: &str) -> Setup {
        let frame = if word == "G53" { self.modal.base } else { Frame::identity() };
        Setup { frame, ..(*self.setup).clone() }
    }
}

/// Which axes of a new frame are stated, where those in `known` of an old one are.
fn known_behind(known: AxisSet, old: &Frame, new: &Frame) -> AxisSet {
    new.known_across(old.known_across(known, false), true)
}
