//! The channel: executes the gathered words of one block in their fixed order and puts elements into the stream.

use super::drill::Drill;
use super::nurbs::Curve;
use super::polar::Polar;
use super::tilted::Collected;
use std::collections::BTreeMap;

use super::call::Call;
use super::gathered::Gathered;
use super::modal::Modal;
use super::passes::Passes;
use super::variables::Variables;
use super::zero_offset::System;
use crate::exec::core::contour::Corner;
use crate::exec::core::options::Options;
use crate::exec::core::outlet::{HasOutlet, Outlet};
use crate::exec::core::reference::Via;
use crate::exec::core::settings::RunSettings;
use crate::exec::core::standing::InForce;
use crate::exec::core::tool::{ToolEntry, ToolSize, ToolTable};
use ncfix_base::geometry::{AxisSet, AxisVector, FrameParts, Vector};
use ncfix_base::source::Span;
use ncfix_dialect::{Dialect, Language};
use ncfix_machine::machine::{Machine, Tool};
use ncfix_machine::snc::{BlockNumber, Kind, Origin, Word};

/// State and output of the channel.
pub(super) struct Channel<'a> {
    /// The machine, and what the caller has chosen.
    pub(super) settings: RunSettings<'a>,
    pub(super) language: Language,
    pub(super) axes: AxisSet,
    pub(super) outlet: Outlet<'a>,
    pub(super) modal: Modal,
    /// What the program has set in the control.
    pub(super) written: WrittenData,
    /// States that M70 and M73 have saved, one place per program level.
    pub(super) saved: Vec<Option<Box<SavedState>>>,
    /// What the block at hand says and does.
    pub(super) block: IsoAtHand,
    pub(super) variables: Variables,
    pub(super) loops: Passes,
    /// Calls of G66 in force, the last one the innermost.
    pub(super) modal_calls: Vec<Call>,
    /// Frame, tool length and plane in force.
    pub(super) standing: InForce,
    /// What was said already.
    pub(super) warned: Warned,
    pub(super) cycles: Cycles,
    pub(super) special: Special,
    pub(super) gathered: Option<Box<Gathered>>,
}

/// What the program has set in the control.
#[derive(Default)]
pub(super) struct WrittenData {
    /// Zero offsets that the program has set.
    pub(super) offsets: BTreeMap<System, FrameParts>,
    /// Tool offsets that the program has set.
    pub(super) tools: ToolTable<ToolOffset>,
    /// The point by way of which G28 and G30 went.
    pub(super) via: Via,
}

/// What the block at hand says and does.
#[derive(Default)]
pub(super) struct IsoAtHand {
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
    /// The direction of the tool at the end of the motion at hand, and where it stands.
    pub(super) direction: Option<(Vector, Span)>,
}

/// What was said already.
#[derive(Default)]
pub(super) struct Warned {
    pub(super) feed: bool,
    /// The zero offset whose missing value was reported.
    pub(super) offset: Option<System>,
    /// Whether it was reported that numbers lack a decimal point and what they mean is not stated.
    pub(super) point: bool,
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
            settings: RunSettings::new(machine, options),
            language,
            axes: machine.axis_set(),
            outlet: Outlet::new(machine, options),
            modal: Modal::new(options.start, machine, language),
            written: WrittenData::default(),
            saved: vec![None],
            block: IsoAtHand::default(),
            variables: Variables::new(language, machine),
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

    /// A new block: its elements carry this origin and number.
    pub(super) fn begin_block(&mut self, origin: Origin, number: Option<BlockNumber>) {
        self.outlet.begin_block(origin, number);
        self.block.has_moved = false;
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
        if !self.block.before.is_empty() {
            let before = std::mem::take(&mut self.block.before);
            self.push(Kind::Before(before));
        }
    }
}

/// What cycles keep from block to block.
#[derive(Clone, Debug, Default)]
pub(super) struct Cycles {
    pub(super) drill: Drill,
    /// The kind of motion, in tenths, to which a Fanuc returns with G80.
    pub(super) line: u16,
    /// The output is in G61, the program is not.
    pub(super) is_exact: bool,
    /// M29 announced rigid tapping.
    pub(super) is_rigid: bool,
}

/// What M70 or M73 saved at a program level.
#[derive(Debug)]
pub(super) struct SavedState {
    pub(super) modal: Modal,
    /// M73: it comes back by itself when the level ends.
    pub(super) returns: bool,
}

/// Offsets of one number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ToolOffset {
    /// Along X, Y, Z; of a Fanuc the length is that along Z.
    pub(super) length_mm: Vector,
    pub(super) length_wear_mm: f64,
    pub(super) radius_mm: f64,
    pub(super) radius_wear_mm: f64,
    /// Whether the program has set it.
    pub(super) is_stated: bool,
}

impl ToolEntry for ToolOffset {
    fn of(tool: &Tool, _: &Machine) -> Self {
        let [first, second, third] = tool.length_mm;
        // Lengths 1, 2, 3 lie along Z, Y, X.
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

/// What the kinds of motion here keep from block to block.
#[derive(Clone, Debug, Default)]
pub(super) struct Special {
    /// G16
    pub(super) polar: Option<Polar>,
    pub(super) curve: Curve,
    /// Blocks of G68.2 that have come so far.
    pub(super) tilt_parts: Collected,
    /// Where a rotation, scaling or mirror has begun or ended, and the program has not stated all axes of the plane since.
    pub(super) doubt: Option<Doubt>,
}

/// Axes whose value depends on the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Doubt {
    /// What the program gave them, mm.
    pub(super) values: AxisVector,
    pub(super) open: AxisSet,
    /// Axes that turn together.
    pub(super) group: AxisSet,
    /// Nothing is in force any more.
    pub(super) has_ended: bool,
}
