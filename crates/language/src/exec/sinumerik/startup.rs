//! A channel in its state at the start of a program.

use super::channel::Channel;
use super::modal::initial_zero_offset;
use super::save;
use super::setup;
use crate::exec::core::options::Options;
use ncfix_base::geometry::Frame;
use ncfix_dialect::CodeTable;
use ncfix_machine::machine::Machine;
/// A channel in its state at the start of a program.
pub(super) fn begin<'a>(machine: &'a Machine, options: &Options, codes: &'static CodeTable) -> Channel<'a> {
    let mut channel = Channel::new(machine, options, codes);
    let order = machine.control.rotation_order;
    channel.modal.base = channel.system.frames.base(order).unwrap_or_else(Frame::identity);
    if let Some(offset) = machine.zero_offsets.get(initial_zero_offset(machine)) {
        channel.modal.settable = offset.frame(order).unwrap_or_else(Frame::identity);
        channel.modal.zero = machine.zero_index(initial_zero_offset(machine));
    }
    setup::refresh_setup(&mut channel.modal, &mut channel.standing, &mut channel.outlet);
    save::note_initial_codes(&channel.settings, channel.codes, &mut channel.modal);
    channel.modal.programmed = channel.standing.setup.programmed(&channel.modal.position.command);
    channel
}
