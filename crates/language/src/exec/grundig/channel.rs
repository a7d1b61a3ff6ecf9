//! The channel: executes the words of one block in a fixed order and emits elements.

use super::geometry::Choice;
use super::geometry::Element;
use crate::exec::core::step::Flat;

use super::expression::Parameters;
use super::modal::Modal;
use crate::exec::core::contour::{Corner, Soft};
use crate::exec::core::motion_sink::{HasOutlet, MotionSink};
use crate::exec::core::options::Options;
use crate::exec::core::settings::RunSettings;
use crate::exec::core::standing::InForce;
use crate::exec::core::tool::{ToolSize, ToolTable};
use ncfix_base::source::Span;
use ncfix_dialect::CodeTable;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Kind, Word};

/// State and output of the channel.
pub(super) struct Channel<'a> {
    /// The machine and the options of the caller.
    pub(super) settings: RunSettings<'a>,
    pub(super) outlet: MotionSink<'a>,
    pub(super) modal: Modal,
    pub(super) parameters: Parameters,
    pub(super) codes: &'static CodeTable,
    /// Tool tables outside the program.
    pub(super) tools: ToolTable<ToolSize>,
    /// Active frame, tool length and plane.
    pub(super) standing: InForce,
    /// State of the current block.
    pub(super) block: GrundigAtHand,
    /// M3 or M4 while the spindle turns.
    pub(super) spindle: Option<u16>,
    pub(super) feed_warned: bool,
    /// A motion whose end is determined by the next one.
    pub(super) open: Option<Open>,
}

/// State of the current block.
#[derive(Default)]
pub(super) struct GrundigAtHand {
    /// `true` if the block has moved already.
    pub(super) has_moved: bool,
    /// `true` if that was only a step of micrometers to a level: the next motion belongs to it.
    pub(super) is_leveled: bool,
    /// `true` if the block names F.
    pub(super) feed_named: bool,
    /// S and M words of the block that act before its motion.
    pub(super) before: Vec<Word>,
    /// Corner request of the next motion for the contour stage.
    pub(super) corner: Option<Corner>,
    pub(super) soft: Option<(Soft, Span)>,
    /// `true` if the emitted motion has an open end.
    pub(super) is_open: bool,
    /// Number of cycle steps of the block so far.
    pub(super) cycle_steps: usize,
}

impl<'a> HasOutlet<'a> for Channel<'a> {
    fn outlet(&mut self) -> &mut MotionSink<'a> {
        self.outlet.warnings.extend(self.parameters.assumed.take('E', "0"));
        &mut self.outlet
    }
}

impl<'a> Channel<'a> {
    pub(super) fn new(machine: &'a Machine, options: &Options, codes: &'static CodeTable) -> Self {
        Channel {
            settings: RunSettings::new(machine, options),
            outlet: MotionSink::new(machine, options),
            modal: Modal::new(options.start, machine),
            parameters: Parameters::new(machine, options),
            codes,
            tools: ToolTable::default(),
            standing: InForce { changed: true, ..InForce::default() },
            block: GrundigAtHand::default(),
            spindle: None,
            feed_warned: false,
            open: None,
        }
    }

    /// Emits a comment.
    pub(super) fn comment(&mut self, comment: Option<Vec<u8>>) {
        if let Some(comment) = comment {
            self.outlet.push(Kind::Comment(comment));
        }
    }
}

/// An element whose end is not known yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    pub(super) start: Flat,
    pub(super) element: Element,
    pub(super) choice: Choice,
    pub(super) span: Span,
}
