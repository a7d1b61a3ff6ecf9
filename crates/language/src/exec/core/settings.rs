//! Constants of a run: the machine, and the options of the caller.

use super::options::{Options, RapidOrder};
use super::radius::Radius;
use ncfix_machine::machine::Machine;

/// The machine, and the options of the caller.
#[derive(Clone, Copy, Debug)]
pub(in crate::exec) struct RunSettings<'a> {
    pub(in crate::exec) machine: &'a Machine,
    /// Rejects input that a correction must not assume.
    pub(in crate::exec) strict: bool,
    /// Rejects zero offsets and tools without value.
    pub(in crate::exec) requires_values: bool,
    /// Leaves rigid tapping to the control.
    pub(in crate::exec) keeps_tapping: bool,
    /// Leaves tilted planes to the control.
    pub(in crate::exec) keeps_tilt: bool,
    /// Marks the holes of drilling cycles.
    pub(in crate::exec) keeps_cycles: bool,
    /// Marks the holes of rigid tapping.
    pub(in crate::exec) keeps_taps: bool,
    /// Radius for G41 and G42.
    pub(in crate::exec) radius: Radius,
    /// Splitting of rapid moves.
    pub(in crate::exec) rapid_order: RapidOrder,
}

impl<'a> RunSettings<'a> {
    /// `true` if the output may have drilling cycles, with the words that end them.
    pub(in crate::exec) fn writes_cycles(&self) -> bool {
        self.keeps_cycles && self.strict
    }

    pub(in crate::exec) fn new(machine: &'a Machine, options: &Options) -> Self {
        let &Options { strict, keeps_tapping, keeps_tilt, keeps_cycles, keeps_taps, radius, rapid_order, .. } = options;
        RunSettings {
            machine,
            strict,
            requires_values: strict || options.requires_values,
            keeps_tapping,
            keeps_tilt,
            keeps_cycles,
            keeps_taps: keeps_cycles || keeps_taps,
            radius,
            rapid_order,
        }
    }
}
