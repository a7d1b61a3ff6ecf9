//! The data that expressions and words of a block can access.

use super::channel::Channel;
use super::expression::Scope;
use super::gatherer::Gatherer;
use super::level::Loaded;
use ncfix_machine::machine::Machine;

/// The scope of a block's expressions.
pub(super) fn scope_of<'s>(loaded: &'s Loaded, channel: &'s Channel<'_>) -> Scope<'s> {
    Scope {
        program: &loaded.program,
        variables: &channel.variables,
        modal: &channel.modal,
        machine: channel.settings.machine,
        system: &channel.system,
    }
}

/// Gathers the words of one block.
pub(super) fn gatherer<'s>(loaded: &'s Loaded, channel: &'s Channel<'_>, machine: &Machine) -> Gatherer<'s> {
    Gatherer {
        scope: scope_of(loaded, channel),
        meanings: &loaded.own.meanings,
        codes: loaded.program.dialect.codes(),
        machine_axes: machine.axis_set(),
    }
}
