//! The gathered words of one block.

use super::address::Named;
use super::curve::CurveWords;
use super::five_axis::TransformWords;
use super::modal::MotionKind;
use super::pole::PoleBase;
use crate::exec::core::fault::Fault;
use crate::syntax::sinumerik::{ArgumentRange, DimensionFunction};
use ncfix_base::geometry::{AXIS_COUNT, AxisSet, AxisVector};
use ncfix_base::source::Span;
use ncfix_machine::snc::{FrameKind, RotaryDirection, Word as AuxWord, WordValue};

/// A call found in a block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Call {
    pub(super) name: String,
    pub(super) arguments: Option<ArgumentRange>,
    pub(super) repeats: u32,
    pub(super) span: Span,
}

/// The value of a named address, as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NamedValue {
    pub(super) address: Named,
    pub(super) value: f64,
    /// `AC(…)`, `IC(…)`; `None` for a plain value.
    pub(super) dimension: Option<DimensionFunction>,
    pub(super) span: Span,
}

/// The gathered words of one block, with values as written (program units, degrees).
#[derive(Debug)]
pub(super) struct Gathered {
    pub(super) groups: u64,
    pub(super) motion: Option<(MotionKind, Span)>,
    pub(super) dwell: Option<Span>,
    pub(super) plane: Option<u8>,
    /// `true` for inch, and `true` if the unit includes the feed.
    pub(super) inch: Option<(bool, bool)>,
    pub(super) incremental: Option<bool>,
    pub(super) offset: Option<(String, Span)>,
    pub(super) suppress: Option<&'static str>,
    /// Contour words: G41, KONT, G247 …
    pub(super) contour: Vec<&'static str>,
    pub(super) frame: Option<(FrameKind, bool, Span)>,
    pub(super) pole: Option<(PoleBase, Span)>,
    pub(super) keep: Vec<&'static str>,
    pub(super) axes: AxisVector,
    pub(super) axis_spans: [Span; AXIS_COUNT],
    pub(super) named: AxisSet,
    pub(super) as_absolute: AxisSet,
    pub(super) as_incremental: AxisSet,
    /// `DC`, `ACP`, `ACN` of rotary axes.
    pub(super) ways: [RotaryDirection; 3],
    pub(super) center: [Option<(f64, bool)>; 3],
    pub(super) center_span: Span,
    /// Splines and polynomials.
    pub(super) curve: CurveWords,
    /// Five-axis transformation.
    pub(super) transform: TransformWords,
    /// Values of named addresses, see [`Self::named`].
    pub(super) addresses: Vec<NamedValue>,
    pub(super) feed: Option<(f64, Span)>,
    pub(super) speed: Option<(f64, Span)>,
    pub(super) tool: Option<(WordValue, Span)>,
    pub(super) edge: Option<(u32, Span)>,
    pub(super) before: Vec<AuxWord>,
    pub(super) after: Vec<AuxWord>,
    pub(super) tool_change: bool,
    pub(super) program_end: Option<u32>,
    pub(super) is_return: bool,
    /// `RET(…)`
    pub(super) return_arguments: Option<ArgumentRange>,
    pub(super) message: Option<Vec<u8>>,
    /// Words that are passed through, with evaluated values.
    pub(super) verbatim: Vec<Vec<u8>>,
    /// `true` if they are the whole content of the block.
    pub(super) is_complete: bool,
    /// Words of axes that the machine file names as passed on, as the output has them, and the place of the last one.
    pub(super) passed_axes: Vec<Vec<u8>>,
    pub(super) passed_span: Span,
    /// Axes at unknown positions after the block.
    pub(super) lost: AxisSet,
    /// `true` under G63.
    pub(super) taps: bool,
    /// Change of the lead of G34 and G35, as written.
    pub(super) lead_change: Option<f64>,
    /// Axes of `POS[…]=`.
    pub(super) positioned: AxisSet,
    /// G74, G75: the block is passed through.
    pub(super) is_reference: bool,
    /// G25, G26.
    pub(super) limits: Option<Span>,
    /// Diameter programming on or off.
    pub(super) diameter: Option<(bool, Span)>,
    /// Code of the feed mode.
    pub(super) feed_mode: Option<&'static str>,
    /// FB, mm/min.
    pub(super) block_feed: Option<f64>,
    pub(super) warning: Option<Fault>,
    pub(super) call: Option<Call>,
    pub(super) call_repeats: Option<(u32, Span)>,
}

impl Gathered {
    pub(super) fn new() -> Self {
        Gathered {
            groups: 0,
            motion: None,
            dwell: None,
            plane: None,
            inch: None,
            incremental: None,
            offset: None,
            suppress: None,
            contour: Vec::new(),
            frame: None,
            pole: None,
            keep: Vec::new(),
            axes: AxisVector::ZERO,
            axis_spans: [Span::default(); AXIS_COUNT],
            named: AxisSet::EMPTY,
            as_absolute: AxisSet::EMPTY,
            as_incremental: AxisSet::EMPTY,
            ways: [RotaryDirection::Plain; 3],
            center: [None; 3],
            center_span: Span::default(),
            addresses: Vec::new(),
            curve: CurveWords::default(),
            transform: TransformWords::default(),
            feed: None,
            speed: None,
            tool: None,
            edge: None,
            before: Vec::new(),
            after: Vec::new(),
            tool_change: false,
            program_end: None,
            is_return: false,
            return_arguments: None,
            message: None,
            verbatim: Vec::new(),
            is_complete: false,
            passed_axes: Vec::new(),
            passed_span: Span::default(),
            lost: AxisSet::EMPTY,
            taps: false,
            lead_change: None,
            positioned: AxisSet::EMPTY,
            is_reference: false,
            limits: None,
            diameter: None,
            feed_mode: None,
            block_feed: None,
            warning: None,
            call: None,
            call_repeats: None,
        }
    }

    /// The value of a named address, if the block has it.
    pub(super) fn named(&self, address: Named) -> Option<&NamedValue> {
        self.addresses.iter().find(|value| value.address == address)
    }
}

/// `true` if AP or RP gives the end of a block.
pub(super) fn is_programmed(gathered: &Gathered) -> bool {
    !gathered.addresses.is_empty() && (gathered.named(Named::Ap).is_some() || gathered.named(Named::Rp).is_some())
}

/// `true` if a block has words that a frame statement or pole must not accompany.
pub(super) fn shares_its_block(gathered: &Gathered) -> bool {
    gathered.center.iter().any(Option::is_some)
        || gathered.feed.is_some()
        || gathered.tool.is_some()
        || gathered.motion.is_some()
        || gathered.offset.is_some()
        || gathered.dwell.is_some()
        || !gathered.after.is_empty()
        || !gathered.before.is_empty()
        || !gathered.as_incremental.is_empty()
}
