//! The channel: executes the words of one block in their fixed order and puts elements into the stream.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::contour_words::Open;
use super::expression::Parameters;
use super::gathered::Gathered;
use super::modal::Modal;
use super::tables::Tables;
use super::tool::place;
use crate::exec::core::contour::{Corner, Soft};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::options::{Options, RapidOrder};
use crate::exec::core::outlet::{HasOutlet, Outlet};
use crate::exec::core::radius::Radius;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, Frame, LINEAR_AXES, Vector};
use ncfix_base::source::Span;
use ncfix_base::units::MM_PER_INCH;
use ncfix_dialect::CodeTable;
use ncfix_machine::machine::{Machine, Tool};
use ncfix_machine::snc::{Dwell, Kind, Setup, Word, WordValue};

/// M functions that act behind the motion of their block.
const BEHIND: &[u16] = &[0, 1, 2, 5, 9, 30];

/// G codes that say what a block does with its words, beside the cycles; one of them a block.
const ACTIONS: &[u16] = &[4, 9, 11, 61, 62, 74, 77, 78, 79, 149, 150];

/// State and output of the channel.
pub(super) struct Channel<'a> {
    pub(super) machine: &'a Machine,
    pub(super) outlet: Outlet<'a>,
    pub(super) modal: Modal,
    pub(super) parameters: Parameters,
    pub(super) codes: &'static CodeTable,
    pub(super) tools: Vec<Tool>,
    pub(super) strict: bool,
    /// Which radius G41 and G42 work with.
    radius: Radius,
    /// Wear in the radii of the tools, mm.
    radius_wear: BTreeMap<(u32, u32), f64>,
    /// Which rapid moves are taken apart.
    rapid_order: RapidOrder,
    /// All that lies between programmed positions and axis commands.
    pub(super) setup: Arc<Setup>,
    /// The part of it that the output keeps.
    pub(super) shown: Arc<Setup>,
    shown_changed: bool,
    /// Whether the block has moved already.
    pub(super) has_moved: bool,
    /// M3 or M4 while the spindle turns.
    pub(super) spindle: Option<u16>,
    /// Whether the block names F.
    pub(super) feed_named: bool,
    /// S and M words of the block that act before its motion.
    before: Vec<Word>,
    feed_warned: bool,
    /// What the motion to come wants of the contour stage.
    pub(super) corner: Option<Corner>,
    pub(super) soft: Option<(Soft, Span)>,
    /// A motion whose end the next one tells.
    pub(super) open: Option<Open>,
    /// Whether the motion that is put into the stream is such a one.
    pub(super) is_open: bool,
    /// Steps of the cycles of the block so far.
    pub(super) cycle_steps: usize,
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
            outlet: Outlet::new(machine, options),
            modal: Modal::new(options.start, machine),
            parameters: Parameters::new(machine),
            codes,
            tools: machine.tools.clone(),
            strict: options.strict,
            radius: options.radius,
            radius_wear: machine.radius_wear_mm.clone(),
            rapid_order: options.rapid_order,
            setup: Arc::default(),
            shown: Arc::default(),
            shown_changed: true,
            has_moved: false,
            spindle: None,
            feed_named: false,
            before: Vec::new(),
            feed_warned: false,
            corner: None,
            soft: None,
            open: None,
            is_open: false,
            cycle_steps: 0,
        };
        // The machine file has refused offsets that cannot be undone.
        let refreshed = channel.refresh_setup();
        channel.outlet.warnings.extend(refreshed.err());
        channel
    }

    /// Whether it is stated, or may be assumed, where these axes stand.
    pub(super) fn has_place(&self, axes: AxisSet) -> bool {
        let may_assume = !self.strict && self.rapid_order != RapidOrder::Stated;
        may_assume || axes.difference(self.modal.known).is_empty()
    }

    /// Whether a rapid move of these axes may be taken apart. Where it does not know where it starts, the control itself puts the motions
    /// of the block in order.
    pub(super) fn may_split(&self, axes: AxisSet) -> bool {
        self.modal.positioning_logic && self.rapid_order != RapidOrder::None && self.has_place(axes)
    }

    /// Executes a block's words.
    pub(super) fn execute(&mut self, gathered: &mut Gathered, comment: Option<Vec<u8>>) -> Result<(), Fault> {
        self.has_moved = false;
        self.before.clear();
        self.cycle_steps = 0;
        if gathered.codes.is_empty() && gathered.functions.is_empty() {
            if gathered.peek(b'T', None).is_some() {
                // A tool that is got ready: its change comes in a block of its own.
                self.tool(gathered)?;
            }
            self.feed_and_speed(gathered)?;
            self.comment(comment);
            self.motion_words(gathered)?;
            return gathered.check_all_used();
        }
        self.check_codes(gathered)?;
        self.passed_codes(gathered);
        self.modal_codes(gathered)?;
        self.frame_codes(gathered)?;
        self.tool(gathered)?;
        self.compensation_codes(gathered)?;
        self.check_supported(gathered)?;
        self.feed_and_speed(gathered)?;
        let behind = self.functions(gathered)?;
        self.comment(comment);
        if let Some(span) = gathered.take_code(4) {
            self.dwell(gathered, span)?;
        } else if let Some(span) = gathered.take_code(149) {
            self.table_access(gathered, false, span)?;
        } else if let Some(span) = gathered.take_code(150) {
            self.table_access(gathered, true, span)?;
        } else if let Some(span) = gathered.take_code(74) {
            self.reference(gathered, span)?;
        } else if let Some(span) = gathered.take_code(78) {
            self.define_point(gathered, span)?;
        } else if let Some(span) = gathered.take_code(9) {
            self.set_pole(gathered, span)?;
        } else if let Some(span) = gathered.take_code(11) {
            self.two_lines(gathered, span)?;
        } else if !self.cycle_codes(gathered)? {
            for (number, retracts) in [(61, false), (62, true)] {
                if let Some(span) = gathered.take_code(number) {
                    self.soft_words(gathered, retracts, span)?;
                }
            }
            self.motion_words(gathered)?;
        }
        if !behind.is_empty() {
            self.outlet.push(Kind::After(behind));
        }
        if let Some(code) = gathered.codes.first() {
            let message = format!("G{} beside another code that takes the words of the block", code.number);
            return Err(fault(Code::NOT_SUPPORTED, code.span, message, "write each in a block of its own"));
        }
        gathered.check_all_used()
    }

    /// A code that nothing carries out is said before what its words would mean to the motion in force.
    fn check_supported(&self, gathered: &Gathered) -> Result<(), Fault> {
        let is_left = |number: u16| !ACTIONS.contains(&number) && super::cycles::find(number).is_none();
        let Some(code) = gathered.codes.iter().find(|code| is_left(code.number)) else { return Ok(()) };
        let known = self.codes.g(usize::from(code.number)).map_or("no known code", |entry| entry.meaning);
        let message = format!("G{} ({known}) is not supported", code.number);
        let help = "the program cannot be corrected with it; program what it does directly";
        Err(fault(Code::NOT_SUPPORTED, code.span, message, help))
    }

    /// Two codes of one group in a block exclude each other.
    fn check_codes(&self, gathered: &Gathered) -> Result<(), Fault> {
        if gathered.codes.len() < 2 {
            return Ok(());
        }
        let group = |number: u16| self.codes.g(usize::from(number)).map_or(0, |entry| entry.group);
        for (index, code) in gathered.codes.iter().enumerate() {
            let own = group(code.number);
            let clash = gathered
                .codes
                .iter()
                .take(index)
                .find(|other| other.number == code.number || (own != 0 && group(other.number) == own));
            if let Some(other) = clash {
                let message = format!("G{} and G{} in one block", other.number, code.number);
                return Err(fault(Code::DOUBLE_WORD, code.span, message, "keep one of them"));
            }
        }
        Ok(())
    }

    /// Puts a comment into the stream.
    pub(super) fn comment(&mut self, comment: Option<Vec<u8>>) {
        if let Some(comment) = comment {
            self.outlet.push(Kind::Comment(comment));
        }
    }

    /// F and S; the F of a dwell, a cycle and a block are read there.
    fn feed_and_speed(&mut self, gathered: &mut Gathered) -> Result<(), Fault> {
        if let Some((feed, span)) = gathered.once(b'F', None)? {
            if feed < 0.0 {
                return Err(bad_value(span, "a feed below 0", "write a feed above 0"));
            }
            self.modal.feed = if self.modal.inch { feed * MM_PER_INCH } else { feed };
            self.feed_named = true;
        } else {
            self.feed_named = false;
        }
        if let Some((speed, _)) = gathered.once(b'S', None)? {
            self.modal.speed = Some(speed);
            self.before.push(Word { letter: b'S', extension: None, value: WordValue::Number(speed) });
        }
        if gathered.functions.is_empty() && !self.before.is_empty() {
            let before = std::mem::take(&mut self.before);
            self.outlet.push(Kind::Before(before));
        }
        Ok(())
    }

    /// M functions: pushes those that act before the motion and gives the others.
    fn functions(&mut self, gathered: &mut Gathered) -> Result<Vec<Word>, Fault> {
        let mut behind = Vec::new();
        for code in std::mem::take(&mut gathered.functions) {
            let word = Word { letter: b'M', extension: None, value: WordValue::Number(f64::from(code.number)) };
            if code.number == 19
                && let Some((angle, _)) = gathered.take(b'D', None)
            {
                self.before.push(Word { letter: b'D', extension: None, value: WordValue::Number(angle) });
            }
            match code.number {
                3 | 4 | 13 | 14 => self.spindle = Some(if matches!(code.number, 3 | 13) { 3 } else { 4 }),
                5 | 30 | 2 => self.spindle = None,
                53 | 54 => self.head(code.number, code.span)?,
                _ => {}
            }
            if BEHIND.contains(&code.number) { behind.push(word) } else { self.before.push(word) }
        }
        let before = std::mem::take(&mut self.before);
        if !before.is_empty() {
            self.outlet.push(Kind::Before(before));
        }
        Ok(behind)
    }

    /// M53, M54: the head turns. The machine file describes one of its positions.
    fn head(&self, number: u16, span: Span) -> Result<(), Fault> {
        if self.machine.control.grundig.head == Some(number) {
            return Ok(());
        }
        let message = format!("M{number} turns the head into a position that the machine file does not describe");
        let help = "say with control.grundig_head which of M53 and M54 the axes and errors of the machine file are for";
        Err(fault(Code::NOT_SUPPORTED, span, message, help))
    }

    fn dwell(&mut self, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
        let help = "write for example G4 X1.5";
        let dwell = match (gathered.once(b'X', None)?, gathered.once(b'D', None)?) {
            (Some((seconds, _)), None) if seconds >= 0.0 => Dwell::Seconds(seconds),
            (None, Some((turns, _))) if turns >= 0.0 => Dwell::Turns(turns),
            _ => return Err(bad_value(span, "G4 needs X with seconds or D with turns", help)),
        };
        self.outlet.push(Kind::Dwell(dwell));
        Ok(())
    }

    /// Whether a motion needs a feed and has none.
    pub(super) fn check_feed(&mut self, feed: f64, span: Span) -> Result<(), Fault> {
        if feed > 0.0 {
            return Ok(());
        }
        let (message, help) = ("a feed motion, and no F was programmed yet", "program F before it or in it");
        if self.strict {
            return Err(fault(Code::MISSING_FEED, span, message, help));
        }
        if !std::mem::replace(&mut self.feed_warned, true) {
            self.outlet.warnings.push(fault(Code::FEED_ASSUMED, span, message, help));
        }
        Ok(())
    }

    /// Puts frame and tool in force. The place along an axis whose tool length changes counts as not stated any more.
    pub(super) fn refresh_setup(&mut self) -> Result<(), Fault> {
        let span = self.outlet.origin.span;
        let flat = || bad_value(span, "this frame cannot be undone", "check the factors of the zero offset");
        let frames = &self.modal.frames;
        let stored = frames.shown(&self.machine.control).ok_or_else(flat)?;
        let frame = stored.compose(&frames.programmed(&self.machine.control.grundig).ok_or_else(flat)?);
        let tool = &self.modal.tool;
        let mut tool_mm = Vector::zeros();
        let length = tool.length_mm + tool.allowance_mm[0];
        if length != 0.0 {
            tool_mm[self.modal.plane.axes()[2].slot()] = if tool.reversed { length } else { -length };
        }
        let assumed = frames.assumed || tool.assumed;
        let plane = self.modal.plane;
        let setup = Setup { frame, tool_mm, plane, transform: None, assumed };
        let changes = |axis: &Axis| setup.tool_mm[axis.slot()] != self.setup.tool_mm[axis.slot()];
        let lost: AxisSet = LINEAR_AXES.into_iter().take(3).filter(changes).collect();
        if !lost.is_empty() {
            // The length that the control has may differ: nothing must lead to where the tip would be by this one.
            self.modal.known = self.modal.known.difference(lost);
            self.outlet.push(Kind::Lost(lost));
        }
        if setup.frame.linear() != self.setup.frame.linear() {
            let machine = self.setup.frame.known_across(self.modal.known, false);
            self.modal.known = setup.frame.known_across(machine, true);
        }
        let shown = Setup { frame: stored, ..setup.clone() };
        if shown != *self.shown {
            self.shown = Arc::new(shown);
            self.shown_changed = true;
        }
        if setup != *self.setup {
            self.setup = Arc::new(setup);
        }
        Ok(())
    }

    /// Tells the output what holds from here on, where that has changed.
    pub(super) fn show_setup(&mut self) {
        if std::mem::take(&mut self.shown_changed) {
            self.outlet.push(Kind::Setup(Arc::clone(&self.shown)));
        }
    }

    /// Axes of the program as axes of the output.
    pub(super) fn shown_axes(&self, axes: AxisSet, moving: bool) -> AxisSet {
        let (own, shown): (&Frame, &Frame) = (&self.setup.frame, &self.shown.frame);
        if own.is_translation() && shown.is_translation() {
            return axes;
        }
        if moving {
            return shown.inverse().mixed_with(own.mixed_with(axes));
        }
        shown.known_across(own.known_across(axes, false), true)
    }

    /// The radius that G41 and G42 work with, mm.
    pub(super) fn radius_mm(&self) -> f64 {
        let tool = &self.modal.tool;
        let wear = tool.number.and_then(|number| self.radius_wear.get(&place(number)));
        self.radius.of(tool.whole_radius_mm(), wear.copied().unwrap_or(0.0))
    }

    /// Takes tables of the control that stand beside the program.
    pub(super) fn take_tables(&mut self, tables: Tables) {
        self.radius_wear.extend(tables.radius_wear);
        self.modal.frames.table.extend(tables.offsets);
        for tool in tables.tools {
            self.tools.retain(|known| (known.number, known.edge) != (tool.number, tool.edge));
            self.tools.push(tool);
        }
        for (number, value) in tables.parameters {
            // A number that is none is said where the program uses it.
            let _ = self.parameters.set(number, value, Span::default());
        }
        self.modal.points.extend(tables.points);
    }

    /// Ends what is held back.
    pub(super) fn finish(&mut self, has_errors: bool) {
        self.end_open();
        self.end_soft();
        self.outlet.end(has_errors);
    }
}
