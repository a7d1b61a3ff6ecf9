//! The channel: executes the gathered words of one block in their fixed order and puts elements into the stream.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::call::Call;
use super::codes::{G80, Group};
use super::cycle::Cycles;
use super::gathered::Gathered;
use super::length::ToolOffset;
use super::modal::Modal;
use super::motion::known_behind;
use super::offsets::System;
use super::passes::Passes;
use super::special::Special;
use super::state::SavedState;
use super::variables::Variables;
use crate::exec::core::contour::Corner;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::options::Options;
use crate::exec::core::outlet::{HasOutlet, Outlet};
use crate::exec::core::radius::Radius;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, AxisVector, FrameParts, LINEAR_AXES, Plane, Vector};
use ncfix_base::source::Span;
use ncfix_dialect::{Dialect, Language};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{BlockNumber, Kind, Origin, Setup, Word};

/// State and output of the channel.
pub(super) struct Channel<'a> {
    pub(super) machine: &'a Machine,
    pub(super) language: Language,
    pub(super) axes: AxisSet,
    pub(super) outlet: Outlet<'a>,
    pub(super) modal: Modal,
    /// Zero offsets that the program has set.
    pub(super) offsets: BTreeMap<System, FrameParts>,
    /// Tool offsets that the program has set.
    pub(super) tools: BTreeMap<u32, ToolOffset>,
    /// The point by way of which G28 and G30 went, machine positions.
    pub(super) through: Option<AxisVector>,
    /// States that M70 and M73 have saved, one place per program level.
    pub(super) saved: Vec<Option<Box<SavedState>>>,
    /// Whether the block has moved an axis.
    pub(super) has_moved: bool,
    /// Whether the block ends the program.
    pub(super) ends_program: bool,
    /// S, M and H words of the block that act before its motion.
    pub(super) before: Vec<Word>,
    /// M words that act behind it.
    pub(super) after: Vec<Word>,
    /// What the motion to come wants of the contour stage.
    pub(super) corner: Option<Corner>,
    pub(super) strict: bool,
    /// Which radius G41 and G42 work with.
    pub(super) radius: Radius,
    pub(super) variables: Variables,
    pub(super) loops: Passes,
    /// Calls of G66 in force, the last one the innermost.
    pub(super) modal_calls: Vec<Call>,
    /// How programmed positions relate to axis commands.
    pub(super) setup: Arc<Setup>,
    /// What of it the control that runs the output knows; the same one where there is nothing else.
    pub(super) shown: Arc<Setup>,
    pub(super) setup_changed: bool,
    /// The direction of the tool at the end of the motion at hand, and where it stands.
    pub(super) direction: Option<(Vector, Span)>,
    pub(super) feed_warned: bool,
    /// The zero offset whose missing value was reported.
    pub(super) offset_warned: Option<System>,
    /// Whether it was reported that numbers lack a decimal point and what they mean is not stated.
    pub(super) point_warned: bool,
    pub(super) cycles: Cycles,
    pub(super) special: Special,
    gathered: Option<Box<Gathered>>,
}

impl<'a> HasOutlet<'a> for Channel<'a> {
    fn outlet(&mut self) -> &mut Outlet<'a> {
        &mut self.outlet
    }
}

impl<'a> Channel<'a> {
    pub(super) fn new(machine: &'a Machine, options: &Options, dialect: &'static Dialect) -> Self {
        let language = dialect.language;
        let mut channel = Channel {
            machine,
            language,
            axes: machine.axis_set(),
            outlet: Outlet::new(machine, options),
            modal: Modal::new(options.start, machine, language),
            offsets: BTreeMap::new(),
            tools: BTreeMap::new(),
            through: None,
            saved: vec![None],
            has_moved: false,
            ends_program: false,
            before: Vec::new(),
            after: Vec::new(),
            corner: None,
            strict: options.strict,
            radius: options.radius,
            variables: Variables::new(language, machine),
            loops: Passes::default(),
            modal_calls: Vec::new(),
            setup: Arc::default(),
            shown: Arc::default(),
            setup_changed: true,
            direction: None,
            feed_warned: false,
            offset_warned: None,
            point_warned: false,
            cycles: Cycles::default(),
            special: Special::default(),
            gathered: None,
        };
        // G54 is in force when a program starts.
        if let Err(found) = channel.load_offset(Span::default()) {
            channel.outlet.warnings.push(found);
        }
        channel.modal.known = if options.start.is_some() { channel.axes } else { AxisSet::EMPTY };
        channel
    }

    pub(super) fn is_rs274(&self) -> bool {
        self.language == Language::Rs274
    }

    /// A new block: its elements carry this origin and number.
    pub(super) fn begin_block(&mut self, origin: Origin, number: Option<BlockNumber>) {
        self.outlet.begin_block(origin, number);
        self.has_moved = false;
    }

    /// Puts an element into the stream.
    pub(super) fn push(&mut self, kind: Kind) {
        self.outlet.push(kind);
    }

    /// A block that only has a number.
    pub(super) fn empty(&mut self) {
        self.push(Kind::Empty);
    }

    /// Words to gather a block into; give them back with [`Self::put_back`].
    pub(super) fn take_gathered(&mut self, span: Span) -> Box<Gathered> {
        let mut gathered = self.gathered.take().unwrap_or_default();
        gathered.clear(span);
        gathered
    }

    pub(super) fn put_back(&mut self, gathered: Box<Gathered>) {
        self.gathered = Some(gathered);
    }

    /// Executes a block's words.
    pub(super) fn execute(&mut self, gathered: &mut Gathered) -> Result<(), Fault> {
        self.before.clear();
        self.after.clear();
        self.corner = None;
        self.check_axes(gathered)?;
        let done = if self.is_rs274() { self.execute_rs274(gathered) } else { self.execute_fanuc(gathered) };
        // Even where the block has a fault, the program ends where it says so.
        done?;
        if !self.is_rs274() && self.modal.length_code == 490 && gathered.raw_quietly(b'H') == Some(0.0) {
            // No offset, where none is in force.
            gathered.use_up(b"H");
        }
        match gathered.unused() {
            None => Ok(()),
            Some((letter, span)) => {
                let message = format!("no code of the block uses {letter}");
                Err(fault(Code::BAD_WORD_VALUE, span, message, "take the word out, or add the code that it belongs to"))
            }
        }
    }

    /// The order of RS274/NGC as LinuxCNC executes it.
    fn execute_rs274(&mut self, gathered: &mut Gathered) -> Result<(), Fault> {
        self.feed_mode(gathered)?;
        self.feed(gathered)?;
        self.speed(gathered)?;
        self.tool_word(gathered)?;
        self.m_codes(gathered)?;
        self.flush_before();
        self.dwell(gathered)?;
        self.plane(gathered)?;
        self.lathe(gathered)?;
        self.units(gathered)?;
        self.compensation_codes(gathered)?;
        let mut takes_axes = self.length_codes(gathered)?;
        self.coordinates(gathered)?;
        self.path_control(gathered)?;
        self.distance(gathered);
        if gathered.code(Group::Retract).is_some() {
            self.no_compensation(gathered.code_span(Group::Retract), "another retract mode")?;
        }
        self.retract(gathered);
        takes_axes |= self.action(gathered)?;
        self.shift_codes(gathered)?;
        self.move_axes(gathered, takes_axes)
    }

    /// The order of a Fanuc: the modal codes of a block hold for all its words.
    fn execute_fanuc(&mut self, gathered: &mut Gathered) -> Result<(), Fault> {
        self.check_state(gathered)?;
        self.units(gathered)?;
        self.plane(gathered)?;
        self.distance(gathered);
        self.feed_mode(gathered)?;
        self.retract(gathered);
        let mut takes_axes = self.passed_on(gathered)?;
        self.path_control(gathered)?;
        if gathered.code(Group::Action) != Some(40) {
            self.feed(gathered)?;
        }
        self.tool_word(gathered)?;
        self.compensation_codes(gathered)?;
        self.coordinates(gathered)?;
        takes_axes |= self.length_codes(gathered)?;
        self.speed(gathered)?;
        self.m_codes(gathered)?;
        self.flush_before();
        self.dwell(gathered)?;
        takes_axes |= self.transform_codes(gathered)?;
        takes_axes |= self.action(gathered)?;
        self.move_axes(gathered, takes_axes)
    }

    /// The motion of a block, and what acts behind it.
    fn move_axes(&mut self, gathered: &Gathered, takes_axes: bool) -> Result<(), Fault> {
        let code = if takes_axes { self.code_of_motion(gathered) } else { self.motion_of(gathered) };
        let mut done = Ok(());
        if let Some(code) = code {
            if !takes_axes && code == G80 && !gathered.axes.is_empty() {
                let message = "axis words, and no kind of motion is in force";
                let help = "program G0 or G1 first";
                done = Err(fault(Code::BAD_WORD_VALUE, gathered.span, message, help));
                gathered.use_up(b"XYZABCUVW");
            } else {
                self.note_motion(code);
                let moves = !takes_axes && (code > 30 && code != G80 || self.has_way(gathered, code));
                if moves {
                    done = self.motion(gathered, code);
                } else {
                    self.feed_alone(gathered);
                }
            }
        } else {
            self.feed_alone(gathered);
        }
        if !self.after.is_empty() {
            let after = std::mem::take(&mut self.after);
            self.push(Kind::After(after));
        }
        self.lose_by_functions(gathered);
        done
    }

    /// Whether a block has words for a line or an arc.
    fn has_way(&self, gathered: &Gathered, code: u16) -> bool {
        let is_arc = matches!(code, 20 | 30) || self.has_directions();
        !gathered.axes.is_empty() || gathered.has_any(b"@^") || is_arc && gathered.has_any(b"IJKR")
    }

    /// F of a block without a motion.
    fn feed_alone(&mut self, gathered: &Gathered) {
        if gathered.has(b'F') && gathered.code(Group::Action) != Some(40) {
            self.push(Kind::Feed(self.modal.feed));
        }
    }

    /// What is done once: G4, G10, G28, G52, G92 … Whether it took the axis words.
    fn action(&mut self, gathered: &Gathered) -> Result<bool, Fault> {
        let Some(code) = gathered.code(Group::Action) else { return Ok(false) };
        match code {
            40 => return Ok(gathered.code(Group::Motion).is_none() && !self.is_rs274()),
            100 => self.set_data(gathered)?,
            280 | 300 => self.home(gathered, code)?,
            270 | 290 => self.back_to_work(gathered, code)?,
            110 => return Ok(false),
            281 | 301 => {
                self.save_home(code, gathered.code_span(Group::Action))?;
                return Ok(false);
            }
            520 | 920 => self.axis_offsets(gathered, code)?,
            921 => self.axis_offsets(gathered, code)?,
            _ => {
                self.special_motion(gathered, code)?;
            }
        }
        Ok(true)
    }

    fn plane(&mut self, gathered: &Gathered) -> Result<(), Fault> {
        let Some(code) = gathered.code(Group::Plane) else { return Ok(()) };
        let Some(plane) = u8::try_from(code / 10).ok().and_then(Plane::from_number) else { return Ok(()) };
        if plane != self.modal.plane {
            if self.is_rs274() {
                self.no_compensation(gathered.code_span(Group::Plane), "another plane")?;
            }
            self.modal.plane = plane;
            self.refresh_setup();
        }
        self.push(Kind::Keep(match plane.number() {
            17 => "G17",
            18 => "G18",
            _ => "G19",
        }));
        Ok(())
    }

    fn units(&mut self, gathered: &Gathered) -> Result<(), Fault> {
        let Some(code) = gathered.code(Group::Units) else { return Ok(()) };
        self.modal.inch = code == 200;
        match self.machine.control.output_inch {
            Some(inch) if inch != self.modal.inch && !self.is_rs274() => {
                let message = "the program is in inches in one part and in millimeters in another";
                let help = "correct them as two programs: what the control keeps in tool and zero offsets follows the unit in force";
                Err(fault(Code::MIXED_UNITS, gathered.code_span(Group::Units), message, help))
            }
            _ => Ok(()),
        }
    }

    fn distance(&mut self, gathered: &Gathered) {
        if let Some(code) = gathered.code(Group::Distance) {
            self.modal.incremental = code == 910;
        }
        if let Some(code) = gathered.code(Group::ArcDistance) {
            self.modal.arc_absolute = code == 901;
        }
    }

    fn retract(&mut self, gathered: &Gathered) {
        if let Some(code) = gathered.code(Group::Retract) {
            self.modal.to_r_plane = code == 990;
        }
    }

    /// Puts the S, M and H words of the block into the stream.
    pub(super) fn flush_before(&mut self) {
        if !self.before.is_empty() {
            let before = std::mem::take(&mut self.before);
            self.push(Kind::Before(before));
        }
    }

    /// Puts frame and tool in force. Of a Fanuc an axis along which the tool length changes is taken as unknown until the program
    /// states it again: whether the control moves it at once is a parameter.
    pub(super) fn refresh_setup(&mut self) {
        let (setup, shown) = (self.modal.setup(), self.modal.shown());
        self.keep_pose(&setup);
        for axis in LINEAR_AXES.into_iter().take(3) {
            if !self.is_rs274() && setup.tool_mm[axis.slot()] != self.setup.tool_mm[axis.slot()] {
                self.modal.known.remove(axis);
            }
        }
        let (old, new) = (&self.setup.frame, &setup.frame);
        if old.linear() != new.linear() {
            self.modal.known = known_behind(self.modal.known, old, new);
        }
        if *self.shown != shown {
            self.shown = Arc::new(shown);
            self.setup_changed = true;
        }
        self.setup = if setup == *self.shown { Arc::clone(&self.shown) } else { Arc::new(setup) };
    }
}
