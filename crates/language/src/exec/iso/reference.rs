//! G27 and G29 of Fanuc: to the reference point for a check, and back from it.

use super::step;
use std::sync::Arc as Shared;

use super::channel::Channel;
use super::codes::Group;
use super::gathered::Gathered;
use super::step::Step;
use crate::exec::core::fault::{Fault, bad_value};
use crate::exec::core::path::Shape;

/// `G27` moves to its point, which should be the reference point; `G29` moves through the intermediate point of the last G28 or G30.
pub(super) fn back_to_work(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    let span = gathered.code_span(Group::Action);
    if gathered.axes.is_empty() {
        return Err(bad_value(span, "G27 and G29 need axis words", "name the axes"));
    }
    if code == 290 {
        let Some(target) = channel.written.via.back(gathered.axes, channel.modal.position.command) else {
            let help = "program G28 or G30 before it";
            return Err(bad_value(span, "G29 without a preceding G28 or G30 that sets its point", help));
        };
        let setup = Shared::clone(&channel.standing.setup);
        let step = Step::straight(gathered, true, setup.programmed(&target), gathered.axes);
        step::send(channel, step, target, Shape::Line, setup)?;
        channel.outlet.begin_line();
    }
    let (end, named) = step::end(channel, gathered)?;
    step::step(channel, Step::straight(gathered, true, end, named))
}
