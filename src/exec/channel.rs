//! The channel: executes the gathered words of one block in their fixed order and puts elements into the stream.

use std::collections::VecDeque;
use std::sync::Arc;

use super::Options;
use super::fault::{Fault, fault};
use super::gather::bad_value;
use super::gathered::Gathered;
use super::modal::Modal;
use super::motion::{MotionContext, motion};
use super::variables::Variables;
use crate::diagnostic::Code;
use crate::geometry::{AxisVector, Frame, LINEAR_AXES, Plane};
use crate::machine::{Machine, ToolChange};
use crate::snc::{BlockNumber, Dwell, Element, FrameWords, Kind, Origin, Setup, Word, WordValue};
use crate::source::Span;
use crate::units::MM_PER_INCH;

/// State and output of the channel.
pub(super) struct Channel<'a> {
    pub(super) machine: &'a Machine,
    pub(super) modal: Modal,
    pub(super) variables: Variables,
    pub(super) queue: VecDeque<Element>,
    /// Findings of the block that do not stop it.
    pub(super) warnings: Vec<Fault>,
    strict: bool,
    origin: Origin,
    number: Option<BlockNumber>,
    starts_block: bool,
    setup: Arc<Setup>,
    setup_changed: bool,
    /// Line of the first length or feed that was programmed before any unit code.
    unitless: Option<u32>,
    unit_stated: bool,
    feed_warned: bool,
}

impl<'a> Channel<'a> {
    pub(super) fn new(machine: &'a Machine, options: &Options) -> Self {
        let mut channel = Channel {
            machine,
            modal: Modal::new(options.start, machine),
            variables: Variables::new(),
            queue: VecDeque::with_capacity(16),
            warnings: Vec::new(),
            strict: options.strict,
            origin: Origin::default(),
            number: None,
            starts_block: false,
            setup: Arc::default(),
            setup_changed: true,
            unitless: None,
            unit_stated: false,
            feed_warned: false,
        };
        if let Some(offset) = machine.zero_offsets.get(&machine.control.initial_zero_offset) {
            channel.modal.offset = *offset;
            channel.refresh_setup();
        }
        channel.modal.programmed = channel.setup.programmed(&channel.modal.command);
        channel
    }

    /// A new block: its elements carry this origin and number.
    pub(super) fn begin_block(&mut self, origin: Origin, number: Option<BlockNumber>) {
        self.origin = origin;
        self.number = number;
        self.starts_block = true;
    }

    /// Puts an element into the stream.
    pub(super) fn push(&mut self, kind: Kind) {
        let starts_block = std::mem::take(&mut self.starts_block);
        let number = if starts_block { self.number } else { None };
        self.queue.push_back(Element { origin: self.origin, starts_block, number, kind });
    }

    /// Executes a block's words.
    pub(super) fn execute(
        &mut self,
        gathered: &mut Gathered,
        comment: Option<Vec<u8>>,
        span: Span,
    ) -> Result<(), Fault> {
        self.modal_codes(gathered)?;
        for &word in &gathered.keep {
            self.push(Kind::Keep(word));
        }
        self.offset(gathered)?;
        if let Some((additive, at)) = gathered.frame {
            self.translate(gathered, additive, at)?;
            self.comment(comment);
            return Ok(());
        }
        self.tool(gathered)?;
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
        if !before.is_empty() {
            self.push(Kind::Before(before));
        }
        let moves = !gathered.named.is_empty()
            || gathered.center.iter().any(Option::is_some)
            || gathered.addresses.iter().any(|value| value.address.moves());
        if moves {
            self.comment(comment);
            self.motion(gathered, span)?;
        } else {
            if let Some((feed, _)) = gathered.feed {
                let feed = if self.modal.inch_feed { feed * MM_PER_INCH } else { feed };
                self.push(Kind::Feed(feed));
            }
            self.comment(comment);
        }
        let after = std::mem::take(&mut gathered.after);
        if !after.is_empty() {
            self.push(Kind::After(after));
        }
        Ok(())
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
                    self.origin.span,
                    format!(
                        "the program switches to inch here, and has lengths or feeds from line {first} on without a unit"
                    ),
                    "state the unit (G71 or G710, G70 or G700) in the first block",
                ));
            }
            self.unit_stated = true;
            self.modal.inch = inch;
            self.modal.inch_feed = inch && with_feed;
        }
        let has_length =
            gathered.named.iter().any(|axis| !axis.is_rotary()) || gathered.feed.is_some() && gathered.dwell.is_none();
        if !self.unit_stated && self.unitless.is_none() && has_length {
            self.unitless = Some(self.origin.line);
        }
        if let Some((code, _)) = gathered.motion {
            self.modal.motion = code;
        }
        if let Some(incremental) = gathered.incremental {
            self.modal.incremental = incremental;
        }
        if let Some(plane) = gathered.plane.and_then(Plane::from_number)
            && plane != self.modal.plane
        {
            self.modal.plane = plane;
            self.refresh_setup();
        }
        Ok(())
    }

    fn offset(&mut self, gathered: &Gathered) -> Result<(), Fault> {
        let Some((name, span)) = &gathered.offset else { return Ok(()) };
        let value = self.machine.zero_offsets.get(name).copied();
        let missing = value.is_none() && name != "G500";
        if missing {
            let message = format!("{name} has no value in the machine file");
            if self.strict {
                return Err(fault(
                    Code::NO_OFFSET,
                    *span,
                    message,
                    format!("add [zero_offset.{name}] there or in a file given with --setup"),
                ));
            }
            self.warnings.push(fault(
                Code::OFFSET_ASSUMED,
                *span,
                format!("{message}; zero is used"),
                format!("add [zero_offset.{name}] there"),
            ));
        }
        self.modal.offset = value.unwrap_or_default();
        self.modal.offset_assumed = missing;
        self.refresh_setup();
        self.push(Kind::Frame(FrameWords::Settable(name.clone())));
        Ok(())
    }

    fn translate(&mut self, gathered: &Gathered, additive: bool, span: Span) -> Result<(), Fault> {
        let strange = gathered.center.iter().any(Option::is_some)
            || gathered.feed.is_some()
            || gathered.tool.is_some()
            || gathered.motion.is_some()
            || gathered.offset.is_some()
            || gathered.dwell.is_some()
            || !gathered.after.is_empty()
            || !gathered.before.is_empty()
            || !gathered.as_incremental.is_empty();
        if strange {
            return Err(fault(
                Code::MUST_STAND_ALONE,
                span,
                "TRANS and ATRANS share their block with nothing but axis words",
                "move the other words to another block",
            ));
        }
        let mut shift = AxisVector::ZERO;
        for axis in gathered.named.iter() {
            let unit = if axis.is_rotary() { 1_f64.to_radians() } else { self.modal.scale() };
            shift[axis] = gathered.axes[axis] * unit;
        }
        self.modal.programmable = if additive { self.modal.programmable + shift } else { shift };
        self.refresh_setup();
        self.push(Kind::Frame(FrameWords::Translate { additive, shift, named: gathered.named }));
        Ok(())
    }

    fn tool(&mut self, gathered: &mut Gathered) -> Result<(), Fault> {
        let mut changed = None;
        if let Some((tool, span)) = gathered.tool.take() {
            if self.machine.control.tool_change == ToolChange::T {
                self.modal.active = Some(tool.clone());
                changed = Some(span);
            } else {
                self.modal.selected = Some(tool.clone());
            }
            self.push(Kind::Tool(tool));
        }
        if gathered.tool_change && self.machine.control.tool_change == ToolChange::M6 {
            if let Some(selected) = &self.modal.selected {
                self.modal.active = Some(selected.clone());
            }
            changed = Some(self.origin.span);
        }
        if changed.is_some() || gathered.tool_change {
            self.modal.edge = self.machine.control.edge_after_tool_change;
            self.modal.forget_position();
        }
        if let Some((edge, span)) = gathered.edge {
            self.modal.edge = edge;
            changed = Some(span);
            let value = WordValue::Number(f64::from(edge));
            gathered.before.insert(0, Word { letter: b'D', extension: None, value });
        }
        match changed {
            Some(span) => self.activate_edge(span),
            None => Ok(()),
        }
    }

    /// Puts the length of the active tool's edge in force, and says where it is not known.
    fn activate_edge(&mut self, span: Span) -> Result<(), Fault> {
        let is_off = self.modal.edge == 0 || self.modal.active == Some(WordValue::Number(0.0));
        let tool =
            self.modal.active.as_ref().and_then(|active| self.modal.find_tool(self.machine, active, self.modal.edge));
        self.modal.length_mm = tool.filter(|_| !is_off).map_or([0.0; 3], |tool| tool.length_mm);
        self.modal.tool_assumed = !is_off && tool.is_none();
        self.refresh_setup();
        let tool_mm = self.setup.tool_mm;
        let lacking = LINEAR_AXES
            .into_iter()
            .take(3)
            .find(|&axis| tool_mm[axis.slot()] != 0.0 && self.machine.axis(axis).is_none());
        if let Some(axis) = lacking {
            let message = format!("the tool length lies along {axis}, which the machine lacks");
            return Err(fault(Code::NO_AXIS, span, message, "select another plane, or set control.tool_length_plane"));
        }
        if !self.modal.tool_assumed {
            return Ok(());
        }
        let (message, help) = match (&self.modal.active, &self.modal.selected) {
            (Some(active), _) => {
                let shown = match active {
                    WordValue::Number(number) => format!("T{number}"),
                    WordValue::Name(name) => format!("T=\"{}\"", String::from_utf8_lossy(name)),
                };
                let message = format!("{shown} D{} has no value in the machine file", self.modal.edge);
                (message, "add a [[tool]] entry there or in a file given with --setup")
            }
            (None, Some(_)) => (
                "a cutting edge is activated, but the selected tool was never changed to with M6".to_owned(),
                "program M6, or set control.tool_change = \"T\" where T changes the tool",
            ),
            (None, None) => (
                "a cutting edge is activated, and the program has not said which tool is in the spindle".to_owned(),
                "program T and M6 first",
            ),
        };
        if self.strict {
            return Err(fault(Code::NO_TOOL, span, message, help));
        }
        self.warnings.push(fault(Code::TOOL_ASSUMED, span, format!("{message}; length 0 is used"), help));
        Ok(())
    }

    fn dwell(&mut self, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
        let dwell = match (gathered.feed, gathered.speed) {
            (Some((seconds, _)), None) => Dwell::Seconds(seconds),
            (None, Some((turns, _))) if turns >= 0.0 => Dwell::Turns(turns),
            _ => {
                return Err(bad_value(
                    span,
                    "G4 needs either F with seconds or S with turns",
                    "write for example G4 F1.5",
                ));
            }
        };
        if !gathered.named.is_empty() {
            return Err(fault(
                Code::MUST_STAND_ALONE,
                span,
                "G4 shares its block with a motion",
                "give the dwell a block of its own",
            ));
        }
        let before = std::mem::take(&mut gathered.before);
        if !before.is_empty() {
            self.push(Kind::Before(before));
        }
        self.push(Kind::Dwell(dwell));
        let after = std::mem::take(&mut gathered.after);
        if !after.is_empty() {
            self.push(Kind::After(after));
        }
        Ok(())
    }

    fn feed_and_speed(&mut self, gathered: &mut Gathered) {
        if let Some((feed, _)) = gathered.feed {
            self.modal.feed = if self.modal.inch_feed { feed * MM_PER_INCH } else { feed };
        }
        if let Some((speed, _)) = gathered.speed {
            let word = Word { letter: b'S', extension: None, value: WordValue::Number(speed) };
            // Behind D, before M.
            let place = gathered.before.iter().take_while(|word| word.letter == b'D').count();
            gathered.before.insert(place, word);
        }
    }

    fn motion(&mut self, gathered: &Gathered, span: Span) -> Result<(), Fault> {
        if gathered.suppress.is_some() {
            let bare = Setup { frame: Frame::identity(), ..(*self.setup).clone() };
            self.push(Kind::Setup(Arc::new(bare.clone())));
            let context = self.context(&bare, span);
            let step = motion(gathered, &mut self.modal, context)?;
            self.push(Kind::Move(step));
            self.setup_changed = true;
            return Ok(());
        }
        if std::mem::take(&mut self.setup_changed) {
            self.push(Kind::Setup(Arc::clone(&self.setup)));
        }
        let setup = Arc::clone(&self.setup);
        let context = self.context(&setup, span);
        let step = motion(gathered, &mut self.modal, context)?;
        if !step.rapid && step.feed <= 0.0 && !std::mem::replace(&mut self.feed_warned, true) {
            let message = "a feed motion, and no F was programmed yet";
            self.warnings.push(fault(Code::FEED_ASSUMED, span, message, "program F before it or in it"));
        }
        self.push(Kind::Move(step));
        Ok(())
    }

    fn context<'c>(&self, setup: &'c Setup, span: Span) -> MotionContext<'c>
    where
        'a: 'c,
    {
        MotionContext { control: &self.machine.control, setup, strict: self.strict, span }
    }

    /// Puts frame and tool in force. An axis along which the tool length changes is taken as unknown until the program states it
    /// again: how and when a control traverses the change is a setting of the control (Sinumerik SD42940, SD42442).
    fn refresh_setup(&mut self) {
        let setup = self.modal.setup();
        for axis in LINEAR_AXES.into_iter().take(3) {
            if setup.tool_mm[axis.slot()] != self.setup.tool_mm[axis.slot()] {
                self.modal.known.remove(axis);
            }
        }
        self.setup = Arc::new(setup);
        self.setup_changed = true;
    }
}
