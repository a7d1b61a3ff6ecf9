//! What does not change in a run: the machine, and what the caller has chosen.

use super::options::{Options, RapidOrder};
use super::radius::Radius;
use ncfix_machine::machine::Machine;

/// The machine, and what the caller has chosen.
#[derive(Clone, Copy, Debug)]
pub(in crate::exec) struct RunSettings<'a> {
    pub(in crate::exec) machine: &'a Machine,
    /// Refuse what a correction must not assume.
    pub(in crate::exec) strict: bool,
    /// Which radius G41 and G42 work with.
    pub(in crate::exec) radius: Radius,
    /// Which rapid moves are taken apart.
    pub(in crate::exec) rapid_order: RapidOrder,
}

impl<'a> RunSettings<'a> {
    pub(in crate::exec) fn new(machine: &'a Machine, options: &Options) -> Self {
        let &Options { strict, radius, rapid_order, .. } = options;
        RunSettings { machine, strict, radius, rapid_order }
    }
}
