//! The channel: executes the gathered words of one block in a fixed order and emits elements.

use super::control::System;
use super::modal::Modal;
use super::splines::Splines;
use super::variables::Variables;
use crate::exec::core::contour::{Corner, Soft};
use crate::exec::core::fault::Fault;
use crate::exec::core::fault::bad_value;
use crate::exec::core::motion_sink::{HasOutlet, MotionSink};
use crate::exec::core::options::Options;
use crate::exec::core::settings::RunSettings;
use crate::exec::core::standing::InForce;
use ncfix_base::source::Span;
use ncfix_dialect::CodeTable;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{BlockNumber, Kind, Origin};

/// State and output of the channel.
pub(super) struct Channel<'a> {
    /// The machine and the options of the caller.
    pub(super) settings: RunSettings<'a>,
    pub(super) outlet: MotionSink<'a>,
    pub(super) modal: Modal,
    pub(super) variables: Variables,
    pub(super) system: System,
    pub(super) codes: &'static CodeTable,
    /// State of the current block.
    pub(super) block: SinumerikAtHand,
    pub(super) splines: Splines,
    /// A motion whose end is determined by the next one.
    pub(super) open_angle: Option<OpenAngle>,
    /// Active frame, tool length and plane.
    pub(super) standing: InForce,
    /// Line of the first length or feed programmed before any unit code.
    pub(super) unitless: Option<u32>,
    pub(super) unit_stated: bool,
    pub(super) feed_warned: bool,
}

/// State of the current block.
#[derive(Default)]
pub(super) struct SinumerikAtHand {
    /// `true` if the block has moved a geometry axis.
    pub(super) has_moved: bool,
    /// `true` if the block has moved only other axes, or positioning axes: MCALL may react to it or not.
    pub(super) has_moved_beside: bool,
    /// Corner request of the next motion for the contour stage.
    pub(super) corner: Option<Corner>,
    /// FRC of a block without its own transition.
    pub(super) corner_feed: Option<f64>,
    pub(super) soft: Option<Soft>,
}

impl<'a> HasOutlet<'a> for Channel<'a> {
    fn outlet(&mut self) -> &mut MotionSink<'a> {
        self.outlet.warnings.extend(self.variables.assumed.take('R', "0"));
        self.outlet.warnings.extend(self.variables.fixed.take());
        &mut self.outlet
    }
}

impl<'a> Channel<'a> {
    pub(super) fn new(machine: &'a Machine, options: &Options, codes: &'static CodeTable) -> Self {
        Channel {
            settings: RunSettings::new(machine, options),
            modal: Modal::new(options.start, machine),
            variables: Variables::new(machine, options),
            system: System::new(options.strict, machine),
            outlet: MotionSink::new(machine, options),
            splines: Splines::default(),
            block: SinumerikAtHand::default(),
            open_angle: None,
            codes,
            standing: InForce { changed: true, ..InForce::default() },
            unitless: None,
            unit_stated: false,
            feed_warned: false,
        }
    }

    /// Begins a block: its elements carry this origin and number.
    pub(super) fn begin_block(&mut self, origin: Origin, number: Option<BlockNumber>) {
        self.outlet.begin_block(origin, number);
        self.block.has_moved = false;
        self.block.has_moved_beside = false;
    }

    /// Emits an element.
    pub(super) fn push(&mut self, kind: Kind) {
        if self.splines.is_holding() {
            let element = self.outlet.element(kind);
            let found = self.splines.hold(element);
            self.outlet.warnings.extend(found);
        } else {
            self.outlet.push(kind);
        }
    }

    /// Emits a comment.
    pub(super) fn comment(&mut self, comment: Option<Vec<u8>>) {
        if let Some(comment) = comment {
            self.push(Kind::Comment(comment));
        }
    }
}

/// Start and direction of a motion without end, in program coordinates of the plane, mm and rad.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpenAngle {
    pub(super) start: [f64; 2],
    pub(super) angle_rad: f64,
    pub(super) span: Span,
}

impl OpenAngle {
    pub(super) fn span(&self) -> Span {
        self.span
    }
}

/// The error for a motion whose end is never given.
pub(super) fn without_end(span: Span) -> Fault {
    bad_value(
        span,
        "this element has an angle but no end",
        "give one coordinate of its end, or program an element with both coordinates and ANG next",
    )
}
