//! Drilling cycles that the output may keep: marks around the moves of each hole, with the words of the cycle.

use super::channel::Channel;
use super::codes::{G80, Group, name_of};
use super::cycles::rs274;
use super::drill::Call;
use super::gathered::Gathered;
use super::modes;
use super::text;
use crate::exec::core::step::{Flat, Step};
use ncfix_machine::snc::{CycleArgument, DrillingCycle, HoleTrigger, Kind, Peck};
use std::sync::Arc as Shared;

/// Largest remainder of the depth that a Fanuc does not drill as a peck, mm.
const FANUC_SLACK_MM: f64 = 1e-6;

/// The holes of a block.
pub(super) struct KeptCycle {
    cycle: Shared<DrillingCycle>,
    /// Index of the first step of each hole.
    pub(super) starts: Vec<usize>,
}

/// The holes of a block with these steps, drilled from a position in the plane; `None` if the moves must be written.
pub(super) fn of(channel: &Channel<'_>, call: &Call, from: Flat, holes: usize, steps: &[Step]) -> Option<KeptCycle> {
    let is_rs274 = channel.is_rs274();
    let firmware = channel.settings.machine.control.firmware;
    if firmware.is_some_and(|firmware| !firmware.has_g(u32::from(call.code))) {
        return None;
    }
    let drill = &channel.cycles.drill;
    let mut arguments = Vec::new();
    let mut peck = None;
    match call.code {
        // The operator moves the tool, or it moves below the workpiece.
        870 | 880 => return None,
        740 | 840 | 842 | 843 => {
            if channel.cycles.is_rigid {
                let speed = channel.modal.modes.speed.map(|_| channel.modal.speed_word);
                let start = speed.map_or_else(|| "M29".to_owned(), |speed| format!("M29 S{speed:.0}"));
                arguments.push(CycleArgument::Text(start));
            }
            if let Some(q) = drill.peck().filter(|q| *q != 0.0) {
                arguments.push(length_word(channel, b'Q', q));
            }
        }
        730 | 830 if !drill.has_no_peck() => {
            let slack_mm = if is_rs274 { 0.0 } else { FANUC_SLACK_MM };
            peck = Some(Peck { depth_mm: drill.equal_pecks()?, slack_mm });
        }
        760 => {
            if holes > 1 {
                return None;
            }
            if let Some(q) = call.q.or(drill.peck()) {
                arguments.push(length_word(channel, b'Q', q));
            }
        }
        _ => {}
    }
    let has_dwell = steps.iter().any(|step| matches!(step, Step::Dwell(_)));
    if let Some(seconds) = drill.dwell_s().filter(|_| has_dwell || is_rs274 && rs274::WITH_DWELL.contains(&call.code)) {
        let word = if is_rs274 { format!("P{seconds}") } else { format!("P{:.0}", seconds * 1000.0) };
        arguments.push(CycleArgument::Text(word));
    }
    let cycle = DrillingCycle {
        name: name_of(call.code),
        is_own: false,
        plane: channel.modal.modes.plane,
        ends_at_reference: call.to_r,
        is_end_stated: !is_rs274 || channel.modal.states_retract(),
        peck,
        arguments,
        trigger: HoleTrigger::Position,
    };
    Some(KeptCycle { cycle: Shared::new(cycle), starts: starts(from, holes, steps)? })
}

/// A word with a length in mm.
fn length_word(channel: &Channel<'_>, letter: u8, value_mm: f64) -> CycleArgument {
    let mut word = String::new();
    text::append_length(channel.settings.machine, channel.language, &mut word, letter, value_mm);
    CycleArgument::Text(word.trim_start().to_owned())
}

/// Index of the first step of each hole; `None` if the holes cannot be distinguished.
fn starts(from: Flat, holes: usize, steps: &[Step]) -> Option<Vec<usize>> {
    if holes == 1 {
        return Some(vec![0]);
    }
    let mut plane = from;
    let mut starts = Vec::with_capacity(holes);
    for (index, step) in steps.iter().enumerate() {
        if let Step::Rapid { plane: Some(to), .. } = *step
            && to != plane
        {
            plane = to;
            starts.push(index);
        }
    }
    // The tool is at the first hole already.
    if starts.len() + 1 == holes && starts.first().is_none_or(|&first| first > 0) {
        starts.insert(0, 0);
    }
    *starts.first_mut()? = 0;
    // Holes at one place have no motion between them.
    (starts.len() == holes && starts.is_sorted_by(|one, next| one < next)).then_some(starts)
}

/// Marks the beginning of a hole.
pub(super) fn begin(channel: &mut Channel<'_>, kept: &KeptCycle) {
    channel.cycles.is_tap_kept = !channel.settings.keeps_cycles;
    channel.push(Kind::Cycle(Some(Shared::clone(&kept.cycle))));
    if stops_exactly(channel) {
        channel.push(Kind::Keep("G61"));
    }
}

/// Marks the end of a hole.
pub(super) fn end(channel: &mut Channel<'_>) {
    if stops_exactly(channel) {
        channel.outlet.begin_line();
        modes::restore_path_control(channel);
    }
    channel.push(Kind::Cycle(None));
}

/// `true` if single moves instead of the cycle must stop exactly, but the program does not. Grbl and its relatives have no G64: they always follow the
/// exact path.
fn stops_exactly(channel: &Channel<'_>) -> bool {
    channel.settings.writes_cycles()
        && channel.is_rs274()
        && channel.settings.machine.control.firmware.is_none()
        && !channel.modal.codes.is(Group::Control, 610)
        && !channel.cycles.is_exact
}

/// Passes on the end of the cycles.
pub(super) fn note_end(channel: &mut Channel<'_>, gathered: &Gathered) {
    let group = if channel.is_rs274() { Group::Motion } else { Group::Cycle };
    let is_end = gathered.code(group) == Some(G80);
    if is_end
        && (std::mem::take(&mut channel.cycles.is_tap_kept) && channel.settings.strict
            || channel.settings.writes_cycles())
    {
        channel.push(Kind::Keep("G80"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::core::step::Place;

    #[test]
    fn a_hole_begins_where_the_plane_changes() {
        let to = |x: f64, height: f64| Step::rapid(Place { plane: [x, 0.0], height });
        let cut = |x: f64| Step::line(Place { plane: [x, 0.0], height: -5.0 });
        let two = [to(0.0, 2.0), cut(0.0), to(0.0, 2.0), to(9.0, 2.0), cut(9.0), to(9.0, 2.0)];
        assert_eq!(starts([0.0; 2], 2, &two), Some(vec![0, 3]));
        assert_eq!(starts([1.0, 0.0], 2, &two), Some(vec![0, 3]));
        assert_eq!(starts([0.0; 2], 3, &two), None);
        assert_eq!(starts([0.0; 2], 1, &two), Some(vec![0]));
    }
}
