//! Drilling cycles that the output may keep: marks around the moves of each hole, with the arguments of the call.

use super::argument::Argument;
use super::channel::Channel;
use super::level::{Entry, Interpreter};
use super::value::Value;
use ncfix_machine::snc::{CycleArgument, DrillingCycle, HoleTrigger, Kind};
use std::sync::Arc as Shared;

/// Places of the retraction plane, the reference plane, the depth and the relative depth in the arguments of all drilling cycles.
const RTP: usize = 0;
const RFP: usize = 1;
const DP: usize = 3;
const DPR: usize = 4;

/// Drilling cycles, with the place of a further height (the first depth).
const DRILLING: [(&str, Option<usize>); 10] = [
    ("CYCLE81", None),
    ("CYCLE82", None),
    ("CYCLE83", Some(5)),
    ("CYCLE84", None),
    ("CYCLE840", None),
    ("CYCLE85", None),
    ("CYCLE86", None),
    ("CYCLE87", None),
    ("CYCLE88", None),
    ("CYCLE89", None),
];

impl Interpreter<'_> {
    /// `true` if a call is that of a drilling cycle.
    pub(super) fn makes_holes(&self, entry: &Entry) -> bool {
        let built_in = self.programs.get(entry.program).and_then(|loaded| loaded.own.built_in);
        built_in.and_then(drilling).is_some()
    }

    /// Marks the beginning of a hole if the program is a drilling cycle.
    pub(super) fn mark_hole(&mut self, entry: &Entry) {
        let built_in = self.programs.get(entry.program).and_then(|loaded| loaded.own.built_in);
        let Some((name, first)) = built_in.and_then(drilling) else { return };
        let is_metric = !self.channel.modal.modes.inch;
        if self.channel.settings.keeps_cycles && is_metric {
            let cycle = cycle_of(&self.channel, name, first, &entry.arguments, entry.is_modal);
            self.channel.push(Kind::Cycle(Some(Shared::new(cycle))));
        }
    }

    /// Marks the end of a hole if the program that ends is a drilling cycle.
    pub(super) fn mark_hole_end(&mut self, program: usize) {
        let built_in = self.programs.get(program).and_then(|loaded| loaded.own.built_in);
        if self.channel.settings.keeps_cycles && built_in.and_then(drilling).is_some() {
            self.channel.push(Kind::Cycle(None));
        }
    }
}

fn drilling(name: &'static str) -> Option<(&'static str, Option<usize>)> {
    DRILLING.into_iter().find(|(known, _)| *known == name)
}

/// The call with its values.
fn cycle_of(
    channel: &Channel<'_>,
    name: &str,
    first: Option<usize>,
    given: &[Argument],
    is_modal: bool,
) -> DrillingCycle {
    let value = |place: usize| given.get(place)?.cells.as_ref()?.first();
    let number = |place: usize| value(place).and_then(Value::number);
    let has_depth = number(DP).is_some() || number(DPR).is_none_or(|depth| depth == 0.0);
    let last = (0..given.len()).rev().find(|&place| value(place).is_some()).unwrap_or(0).max(DP);
    let arguments = (0..=last).map(|place| {
        let is_height = match place {
            RTP | RFP => true,
            DP => has_depth,
            _ => Some(place) == first && number(place).is_some(),
        };
        match value(place) {
            _ if is_height => CycleArgument::Height(number(place).unwrap_or(0.0)),
            Some(Value::Text(text)) => CycleArgument::Text(format!("\"{}\"", String::from_utf8_lossy(text))),
            Some(value) => CycleArgument::Text(String::from_utf8_lossy(&value.text()).into_owned()),
            None => CycleArgument::Text(String::new()),
        }
    });
    DrillingCycle {
        name: name.to_owned(),
        plane: channel.modal.modes.plane,
        ends_at_reference: true,
        peck: None,
        arguments: arguments.collect(),
        trigger: if is_modal { HoleTrigger::Motion } else { HoleTrigger::Call },
    }
}
