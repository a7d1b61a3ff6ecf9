//! Drilling cycles that the output may keep: marks around the moves of each hole, with the arguments of the call.
//!
//! Of some cycles only the control knows the moves. Their calls always stay: they have the corrected position and heights, and the marks enclose the
//! axis of the hole.

use super::argument::Argument;
use super::channel::Channel;
use super::level::{Entry, Interpreter};
use super::value::Value;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_machine::snc::{CycleArgument, DrillingCycle, HoleTrigger, Kind};
use std::sync::Arc as Shared;

/// Places of the retraction plane, the reference plane, the depth and the relative depth in the arguments of all drilling cycles.
const RTP: usize = 0;
const RFP: usize = 1;
const DP: usize = 3;
const DPR: usize = 4;

/// A drilling cycle whose calls the output may keep.
struct StayingCycle {
    name: &'static str,
    /// Places of further heights.
    depths: &'static [usize],
    /// `true` if the control chooses the moves.
    is_own: bool,
}

const fn known(name: &'static str, depths: &'static [usize]) -> StayingCycle {
    StayingCycle { name, depths, is_own: false }
}

const fn own(name: &'static str, depths: &'static [usize]) -> StayingCycle {
    StayingCycle { name, depths, is_own: true }
}

const DRILLING: [StayingCycle; 12] = [
    own("CYCLE78", &[]),
    known("CYCLE81", &[]),
    known("CYCLE82", &[]),
    known("CYCLE83", &[5]),
    own("CYCLE830", &[4, 21, 23, 28]),
    known("CYCLE84", &[]),
    known("CYCLE840", &[]),
    known("CYCLE85", &[]),
    known("CYCLE86", &[]),
    known("CYCLE87", &[]),
    known("CYCLE88", &[]),
    known("CYCLE89", &[]),
];

impl Interpreter<'_> {
    /// `true` if a call is that of a drilling cycle.
    pub(super) fn makes_holes(&self, entry: &Entry) -> bool {
        let built_in = self.programs.get(entry.program).and_then(|loaded| loaded.own.built_in);
        built_in.and_then(drilling).is_some()
    }

    /// Marks the beginning of a hole if the program is a drilling cycle; the fault if only the call could make this hole, and it cannot stay.
    pub(super) fn mark_hole(&mut self, entry: &Entry) -> Option<Fault> {
        let built_in = self.programs.get(entry.program).and_then(|loaded| loaded.own.built_in);
        let kept = built_in.and_then(drilling)?;
        let is_metric = !self.channel.modal.modes.inch;
        if self.channel.settings.keeps_cycles && is_metric {
            let cycle = cycle_of(&self.channel, kept, &entry.arguments, entry.is_modal);
            self.channel.push(Kind::Cycle(Some(Shared::new(cycle))));
            return None;
        }
        kept.is_own.then(|| {
            let message = format!("only the control knows the moves of {}, and here no cycle can stay", kept.name);
            let help = "use a metric program, without --expand-cycles and other options that write holes as moves (--feed-limit, --step, --frame machine), or write the moves out";
            fault(Code::NOT_SUPPORTED, entry.span, message, help)
        })
    }

    /// Marks the end of a hole if the program that ends is a drilling cycle.
    pub(super) fn mark_hole_end(&mut self, program: usize) {
        let built_in = self.programs.get(program).and_then(|loaded| loaded.own.built_in);
        if self.channel.settings.keeps_cycles && built_in.and_then(drilling).is_some() {
            self.channel.push(Kind::Cycle(None));
        }
    }
}

fn drilling(name: &'static str) -> Option<&'static StayingCycle> {
    DRILLING.iter().find(|kept| kept.name == name)
}

/// The call with its values.
fn cycle_of(channel: &Channel<'_>, kept: &StayingCycle, given: &[Argument], is_modal: bool) -> DrillingCycle {
    let value = |place: usize| given.get(place)?.cells.as_ref()?.first();
    let number = |place: usize| value(place).and_then(Value::number);
    // Beyond the reference plane, as _CYC_EITHER reads it.
    let is_beyond = |depth: f64| {
        let [retraction, reference] = [RTP, RFP].map(|place| number(place).unwrap_or(0.0));
        (reference - depth) * (retraction - reference) > 0.0
    };
    let has_depth = if kept.is_own {
        is_beyond(number(DP).unwrap_or(0.0))
    } else {
        number(DP).is_some() || number(DPR).is_none_or(|depth| depth == 0.0)
    };
    let last = (0..given.len()).rev().find(|&place| value(place).is_some()).unwrap_or(0).max(DP);
    let arguments = (0..=last).map(|place| {
        let is_height = match place {
            RTP | RFP => true,
            DP => has_depth,
            _ => {
                kept.depths.contains(&place)
                    && number(place).is_some_and(|depth| !kept.is_own || depth != 0.0 && is_beyond(depth))
            }
        };
        match value(place) {
            _ if is_height => CycleArgument::Height(number(place).unwrap_or(0.0)),
            Some(Value::Text(text)) => CycleArgument::Text(format!("\"{}\"", String::from_utf8_lossy(text))),
            Some(value) => CycleArgument::Text(String::from_utf8_lossy(&value.text()).into_owned()),
            None => CycleArgument::Text(String::new()),
        }
    });
    DrillingCycle {
        name: kept.name.to_owned(),
        is_own: kept.is_own,
        plane: channel.modal.modes.plane,
        ends_at_reference: true,
        is_end_stated: true,
        peck: None,
        arguments: arguments.collect(),
        trigger: if is_modal { HoleTrigger::Motion } else { HoleTrigger::Call },
    }
}
