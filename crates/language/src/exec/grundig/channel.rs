//! The channel: executes the words of one block in their fixed order and puts elements into the stream.

use super::cycles::Flat;
use super::geometry::Choice;
use super::geometry::Element;
use std::collections::BTreeMap;

use super::expression::Parameters;
use super::modal::Modal;
use crate::exec::core::contour::{Corner, Soft};
use crate::exec::core::options::{Options, RapidOrder};
use crate::exec::core::outlet::{HasOutlet, Outlet};
use crate::exec::core::radius::Radius;
use crate::exec::core::standing::Standing;
use ncfix_base::source::Span;
use ncfix_dialect::CodeTable;
use ncfix_machine::machine::{Machine, Tool};
use ncfix_machine::snc::{Kind, Word};

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
    pub(super) radius: Radius,
    /// Wear in the radii of the tools, mm.
    pub(super) radius_wear: BTreeMap<(u32, u32), f64>,
    /// Which rapid moves are taken apart.
    pub(super) rapid_order: RapidOrder,
    /// Frame, tool length and plane in force.
    pub(super) standing: Standing,
    /// Whether the block has moved already.
    pub(super) has_moved: bool,
    /// M3 or M4 while the spindle turns.
    pub(super) spindle: Option<u16>,
    /// Whether the block names F.
    pub(super) feed_named: bool,
    /// S and M words of the block that act before its motion.
    pub(super) before: Vec<Word>,
    pub(super) feed_warned: bool,
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
        Channel {
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
            standing: Standing { changed: true, ..Standing::default() },
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
        }
    }

    /// Puts a comment into the stream.
    pub(super) fn comment(&mut self, comment: Option<Vec<u8>>) {
        if let Some(comment) = comment {
            self.outlet.push(Kind::Comment(comment));
        }
    }
}

/// An element that waits for its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    pub(super) start: Flat,
    pub(super) element: Element,
    pub(super) choice: Choice,
    pub(super) span: Span,
}
