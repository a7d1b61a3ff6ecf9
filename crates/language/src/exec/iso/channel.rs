//! The channel: executes the gathered words of one block in their fixed order and puts elements into the stream.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::call::Call;
use super::cycle::Cycles;
use super::gathered::Gathered;
use super::length::ToolOffset;
use super::modal::Modal;
use super::offsets::System;
use super::passes::Passes;
use super::special::Special;
use super::state::SavedState;
use super::variables::Variables;
use crate::exec::core::contour::Corner;
use crate::exec::core::options::Options;
use crate::exec::core::outlet::{HasOutlet, Outlet};
use crate::exec::core::radius::Radius;
use ncfix_base::geometry::{AxisSet, AxisVector, FrameParts, Vector};
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
    pub(super) gathered: Option<Box<Gathered>>,
}

impl<'a> HasOutlet<'a> for Channel<'a> {
    fn outlet(&mut self) -> &mut Outlet<'a> {
        &mut self.outlet
    }
}

impl<'a> Channel<'a> {
    pub(super) fn new(machine: &'a Machine, options: &Options, dialect: &'static Dialect) -> Self {
        let language = dialect.language;
        Channel {
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
        }
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

    /// Puts the S, M and H words of the block into the stream.
    pub(super) fn flush_before(&mut self) {
        if !self.before.is_empty() {
            let before = std::mem::take(&mut self.before);
            self.push(Kind::Before(before));
        }
    }
}
