//! The channel: executes the gathered words of one block in a fixed order and emits elements.

use super::drill::Drill;
use super::nurbs::Curve;
use super::polar::Polar;
use super::tilted::Collected;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::call::Call;
use super::gathered::Gathered;
use super::modal::Modal;
use super::passes::Passes;
use super::variables::Variables;
use super::zero_offset::System;
use crate::exec::core::contour::Corner;
use crate::exec::core::motion_sink::{HasOutlet, MotionSink};
use crate::exec::core::options::Options;
use crate::exec::core::reference::Via;
use crate::exec::core::settings::RunSettings;
use crate::exec::core::standing::InForce;
use crate::exec::core::tool::{ToolEntry, ToolSize, ToolTable};
use ncfix_base::geometry::{AxisSet, AxisVector, FrameParts, Vector};
use ncfix_base::source::Span;
use ncfix_dialect::{Dialect, Language};
use ncfix_machine::machine::{Machine, Tool};
use ncfix_machine::snc::{BlockNumber, Kind, Origin, Word, WrittenZero, WrittenZeros};

/// State and output of the channel.
pub(super) struct Channel<'a> {
    /// The machine and the options of the caller.
    pub(super) settings: RunSettings<'a>,
    pub(super) language: Language,
    pub(super) axes: AxisSet,
    pub(super) outlet: MotionSink<'a>,
    pub(super) modal: Modal,
    /// Control data set by the program.
    pub(super) written: WrittenData,
    /// States saved by M70 and M73, one slot per program level.
    pub(super) saved: Vec<Option<Box<SavedState>>>,
    /// State of the current block.
    pub(super) block: IsoAtHand,
    pub(super) variables: Variables,
    pub(super) loops: Passes,
    /// Active G66 calls; the last one is the innermost.
    pub(super) modal_calls: Vec<Call>,
    /// Active frame, tool length and plane.
    pub(super) standing: InForce,
    /// Warnings that were reported.
    pub(super) warned: Warned,
    pub(super) cycles: Cycles,
    pub(super) special: Special,
    pub(super) gathered: Option<Box<Gathered>>,
}

/// Control data set by the program.
#[derive(Default)]
pub(super) struct WrittenData {
    /// Zero offsets set by the program.
    pub(super) offsets: BTreeMap<System, FrameParts>,
    /// Their values that were used.
    pub(super) zeros: WrittenZeros,
    /// Zero offsets computed from the position (`G10 L20`), with the zero offset in force there. Nothing was touched: the point that the tool showed
    /// was corrected for that zero, and must stay where it is.
    pub(super) shown: BTreeMap<System, ShownZero>,
    /// Tool offsets set by the program.
    pub(super) tools: ToolTable<ToolOffset>,
    /// The intermediate point of the last G28 or G30.
    pub(super) via: Via,
    /// Values of zero offsets that the program has set to numbers: the system and the index of the axis in its parameters.
    pub(super) stated: BTreeSet<(System, u32)>,
    /// Values of zero offsets to which the program has added something, with the first place.
    pub(super) growing: BTreeMap<(System, u32), Origin>,
}

impl WrittenData {
    /// Notes whether a value of a zero offset is a number of the program, or depends on a value of the control.
    pub(super) fn state(&mut self, place: (System, u32), is_number: bool) {
        if is_number {
            self.stated.insert(place);
            self.growing.remove(&place);
        } else {
            self.stated.remove(&place);
        }
    }
}

/// The zero offset in force where another was computed from the position: its index and, if the program has set it, its value.
#[derive(Clone, Debug)]
pub(super) struct ShownZero {
    pub(super) index: Option<u16>,
    pub(super) written: Option<Arc<WrittenZero>>,
}

/// State of the current block.
#[derive(Default)]
pub(super) struct IsoAtHand {
    /// `true` if the block has moved an axis.
    pub(super) has_moved: bool,
    /// `true` if the block ends the program.
    pub(super) ends_program: bool,
    /// S, M and H words of the block that act before its motion.
    pub(super) before: Vec<Word>,
    /// M words that act after its motion.
    pub(super) after: Vec<Word>,
    /// Corner request of the next motion for the contour stage.
    pub(super) corner: Option<Corner>,
    /// The tool direction at the end of the current motion, and its span.
    pub(super) direction: Option<(Vector, Span)>,
}

/// Warnings that were reported.
#[derive(Default)]
pub(super) struct Warned {
    pub(super) feed: bool,
    /// `true` if the length of another tool was reported.
    pub(super) length: bool,
    /// The zero offset whose missing value was reported.
    pub(super) offset: Option<System>,
    /// `true` if numbers without decimal point were reported as ambiguous.
    pub(super) point: bool,
}

impl<'a> HasOutlet<'a> for Channel<'a> {
    fn outlet(&mut self) -> &mut MotionSink<'a> {
        let used = if self.language == Language::Rs274 { "0" } else { "null" };
        self.outlet.warnings.extend(self.variables.assumed.take('#', used));
        self.outlet.warnings.extend(self.variables.fixed.take());
        &mut self.outlet
    }
}

impl<'a> Channel<'a> {
    pub(super) fn new(machine: &'a Machine, options: &Options, dialect: &'static Dialect) -> Self {
        let language = dialect.language;
        Channel {
            settings: RunSettings::new(machine, options),
            language,
            axes: machine.axis_set(),
            outlet: MotionSink::new(machine, options),
            modal: Modal::new(options.start, machine, language),
            written: WrittenData::default(),
            saved: vec![None],
            block: IsoAtHand::default(),
            variables: Variables::new(language, machine, options.tells_assumed),
            loops: Passes::default(),
            modal_calls: Vec::new(),
            standing: InForce { changed: true, ..InForce::default() },
            warned: Warned::default(),
            cycles: Cycles::default(),
            special: Special::default(),
            gathered: None,
        }
    }

    pub(super) fn is_rs274(&self) -> bool {
        self.language == Language::Rs274
    }

    /// Begins a block: its elements carry this origin and number.
    pub(super) fn begin_block(&mut self, origin: Origin, number: Option<BlockNumber>) {
        self.outlet.begin_block(origin, number);
        self.block.has_moved = false;
    }

    /// Emits an element.
    pub(super) fn push(&mut self, kind: Kind) {
        self.outlet.push(kind);
    }

    /// Emits a block that only has a number.
    pub(super) fn empty(&mut self) {
        self.push(Kind::Empty);
    }

    /// Storage for the words of a block; return it with [`Self::put_back`].
    pub(super) fn take_gathered(&mut self, span: Span) -> Box<Gathered> {
        let mut gathered = self.gathered.take().unwrap_or_default();
        gathered.clear(span);
        gathered
    }

    pub(super) fn put_back(&mut self, gathered: Box<Gathered>) {
        self.gathered = Some(gathered);
    }

    /// Emits the S, M and H words of the block.
    pub(super) fn flush_before(&mut self) {
        if !self.block.before.is_empty() {
            let before = std::mem::take(&mut self.block.before);
            self.push(Kind::Before(before));
        }
    }
}

/// State of cycles between blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct Cycles {
    pub(super) drill: Drill,
    /// The motion mode, in tenths, to which a Fanuc returns at G80.
    pub(super) line: u16,
    /// `true` if the output is in G61 while the program is not.
    pub(super) is_exact: bool,
    /// `true` after M29, which announces rigid tapping.
    pub(super) is_rigid: bool,
    /// `true` if a tapping cycle is in force in the output although other cycles are not kept.
    pub(super) is_tap_kept: bool,
    /// `true` if the program was warned of levels under G91 that holes under G90 use.
    pub(super) is_step_named: bool,
}

/// State saved by M70 or M73 at a program level.
#[derive(Debug)]
pub(super) struct SavedState {
    pub(super) modal: Modal,
    /// `true` for M73: restored automatically when the level ends.
    pub(super) returns: bool,
}

/// Offsets of one number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ToolOffset {
    /// Along X, Y, Z; on a Fanuc the length is along Z.
    pub(super) length_mm: Vector,
    pub(super) length_wear_mm: f64,
    pub(super) radius_mm: f64,
    pub(super) radius_wear_mm: f64,
    /// `true` if the program has set it.
    pub(super) is_stated: bool,
}

impl ToolEntry for ToolOffset {
    fn of(tool: &Tool, _: &Machine) -> Self {
        let [first, second, third] = tool.length_mm;
        // Lengths 1, 2, 3 are along Z, Y, X.
        let length_mm = Vector::new(third, second, first);
        ToolOffset { length_mm, radius_mm: tool.radius_mm, ..ToolOffset::default() }
    }

    fn size(&self) -> ToolSize {
        let length = self.length_mm + Vector::new(0.0, 0.0, self.length_wear_mm);
        ToolSize {
            length_mm: [length.z, length.y, length.x],
            radius_mm: self.radius_mm + self.radius_wear_mm,
            radius_wear_mm: self.radius_wear_mm,
        }
    }
}

/// State of special motion modes between blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct Special {
    /// G16
    pub(super) polar: Option<Polar>,
    pub(super) curve: Curve,
    /// Blocks of G68.2 so far.
    pub(super) tilt_parts: Collected,
    /// Set after a start or end of rotation, scaling or mirroring, until the program has stated all axes of the plane.
    pub(super) doubt: Option<Doubt>,
}

/// Axes whose value depends on the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Doubt {
    /// Values that the program gave, mm.
    pub(super) values: AxisVector,
    pub(super) open: AxisSet,
    /// Axes that rotate together.
    pub(super) group: AxisSet,
    /// `true` if no transformation is active any more.
    pub(super) has_ended: bool,
}
