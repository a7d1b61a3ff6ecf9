//! Drilling cycles that the output may keep: marks around the moves of each hole, with the words of the definition.

use super::channel::Channel;
use super::defined::Defined;
use super::target;
use ncfix_machine::snc::{CycleArgument, DrillingCycle, HoleTrigger, Kind};
use std::fmt::Write as _;
use std::sync::Arc as Shared;

/// Cycles of holes. A tap stays one with and without a compensating chuck: the control starts its own reversal.
const DRILLING: [u16; 5] = [81, 83, 84, 85, 86];

/// Marks the beginning of a hole with this surface, mm in the coordinates of the program; `true` if it is marked.
pub(super) fn begin(
    channel: &mut Channel<'_>,
    defined: &Defined,
    words: &[(u8, u16)],
    feed: f64,
    surface_mm: f64,
) -> bool {
    let number = defined.cycle.number;
    if !channel.settings.keeps_cycles || !DRILLING.contains(&number) || channel.modal.modes.scale() != 1.0 {
        return false;
    }
    let along = channel.modal.modes.plane.axes()[2];
    let mut place = target::here(&channel.modal, &channel.standing);
    place[along] = surface_mm;
    let shown_mm = channel.standing.shown.programmed(&channel.standing.setup.command(&place))[along];
    let mut text = String::new();
    for &(letter, index) in words {
        let Some(value) = defined.words.get(letter, index) else { continue };
        let letter = char::from(letter);
        // Writing to a string cannot fail.
        let _ = match index {
            0 => write!(text, " {letter}{value}"),
            _ => write!(text, " {letter}{index}={value}"),
        };
    }
    // The feed of a tap follows from its pitch.
    if defined.pitch.is_none() {
        let _ = write!(text, " F{feed}");
    }
    let cycle = DrillingCycle {
        name: format!("G{number}"),
        is_own: false,
        plane: channel.modal.modes.plane,
        ends_at_reference: true,
        is_end_stated: true,
        peck: None,
        arguments: vec![CycleArgument::Height(shown_mm), CycleArgument::Text(text.trim_start().to_owned())],
        trigger: HoleTrigger::Position,
    };
    if channel.block.has_moved {
        channel.outlet.begin_line();
    }
    channel.outlet.push(Kind::Cycle(Some(Shared::new(cycle))));
    true
}
