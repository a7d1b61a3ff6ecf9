//! Back-and-forth cycles of readings of one component: within each cycle a drift is linear in time.
//!
//! Readings of one component in one set-up follow each other in the order of the rows. A cycle ends when its axis returns to the direction of its
//! start, or when another run begins in the direction of the last one. Time is `t_s`, or the index of the reading without such a column.

use ncfix_base::csv::Table;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};

use super::DataSet;

/// A cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RepeatCycle {
    /// Index of its set-up.
    pub setup: usize,
    /// Index of its component among the targets.
    pub target: usize,
    /// Its number among the cycles of the component in the set-up, from 1.
    pub number: usize,
    /// Index of its zero among the zeros of cycles; the first one uses that of the set-up.
    pub level: Option<usize>,
}

/// A reading to be assigned to a cycle.
struct Member {
    row: usize,
    run: usize,
    sense: i8,
    /// Axis position, unless the table states its direction.
    place: Option<f64>,
    time: f64,
}

/// Finds the cycles of all readings, and records them in the rows.
pub(super) fn find(data: &mut DataSet, table: &Table, findings: &mut Vec<Diagnostic>) {
    let with_time = data.observations.iter().filter(|row| row.t_s.is_some()).count();
    if let Some(row) = data.observations.iter().find(|row| with_time > 0 && row.t_s.is_none()) {
        let help = "fill the column t_s, or remove it if readings are evenly spaced in time";
        findings.push(Diagnostic::at(Code::DATA_CELL, row.place, "a drift needs the time of every reading", help));
        return;
    }
    let components = data.targets.len();
    let mut groups: Vec<Vec<Member>> = Vec::new();
    groups.resize_with(data.setups.len().saturating_mul(components), Vec::new);
    for (row, observation) in data.observations.iter().enumerate() {
        let Some(axis) = observation.motion_axis() else { continue };
        let place = observation.setup * components + observation.target.unwrap_or(0);
        if let Some(group) = groups.get_mut(place) {
            let time = observation.t_s.unwrap_or(group.len() as f64);
            let place = table.column(&format!("{axis}_dir")).is_none().then(|| observation.reading.position[axis]);
            let sense = observation.reading.state.direction(axis);
            group.push(Member { row, run: observation.run, sense, place, time });
        }
    }
    let mut levels = 0;
    for (place, mut group) in groups.into_iter().enumerate().filter(|(_, group)| !group.is_empty()) {
        // The direction of approach of the first position is unknown: that of the next motion is assumed, also for a repeated position.
        for k in (0..group.len().saturating_sub(1)).rev() {
            let begins = group[k].place.is_some() && (k == 0 || group[k].place == group[k - 1].place);
            if group[k].sense == 0 || begins {
                group[k].sense = group[k + 1].sense;
            }
        }
        let mut from = 0;
        let mut number = 0;
        for until in 1..=group.len() {
            let ends = group.get(until).is_none_or(|next| {
                let [first, last] = [&group[from], &group[until - 1]];
                let comes_back = next.sense == first.sense && last.sense != first.sense;
                comes_back || (next.run != last.run && next.sense == last.sense)
            });
            if !ends {
                continue;
            }
            let own = group.get(from..until).unwrap_or_default();
            let (setup, target) = (place / components, place % components);
            let level = (number > 0).then_some(levels);
            levels += usize::from(number > 0);
            number += 1;
            note(data, own, RepeatCycle { setup, target, number, level }, findings);
            from = until;
        }
    }
    if data.cycles.is_empty() && findings.is_empty() {
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(None), "no reading can have a drift", HELP));
    }
}

const HELP: &str = "read each position in both directions, in the order of the rows (X_dir … gives the direction), or remove \"drift\" from free";

/// Adds a cycle.
fn note(data: &mut DataSet, own: &[Member], cycle: RepeatCycle, findings: &mut Vec<Diagnostic>) {
    let place = |data: &DataSet, member: Option<&Member>| {
        member.and_then(|member| data.observations.get(member.row)).map_or_else(Place::default, |row| row.place)
    };
    let component = data.targets.get(cycle.target).cloned().unwrap_or_default();
    let (first, last) = own.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), member| {
        (first.min(member.time), last.max(member.time))
    });
    let duration = last - first;
    let turns = own.iter().any(|member| member.sense != own.first().map_or(0, |first| first.sense));
    if !(turns && duration > 0.0) {
        let message = format!(
            "the readings of {component} from here are in one direction only: their drift is not separable from an error that increases along the axis"
        );
        findings.push(Diagnostic::at(Code::DRIFT_NOT_TOLD, place(data, own.first()), message, HELP));
        return;
    }
    if let Some(back) = own.windows(2).find(|pair| pair[1].time < pair[0].time) {
        let message = "the time decreases within a back-and-forth cycle";
        let help = "put the rows in the order in which they were read";
        findings.push(Diagnostic::at(Code::DATA_CELL, place(data, back.last()), message, help));
        return;
    }
    let number = data.cycles.len();
    data.cycles.push(cycle);
    for member in own {
        if let Some(row) = data.observations.get_mut(member.row) {
            row.cycle = Some((number, (member.time - first) / duration - 0.5));
        }
    }
}
