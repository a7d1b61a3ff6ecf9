//! Readings that keep one value while the machine moves: a dead channel, a stuck probe.

use super::{DataDefect, DefectCheck, DefectKind, Then, View};
use crate::measure::data::DataSet;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "constant readings",
    made_by: "a channel without a signal, a probe that sticks, a logger that repeats its last value",
    shown_by: "one number at many positions, identical in every digit, while other readings differ",
    source: "noise: no two readings in fine steps are the same so often",
    look,
};

/// Number of equal consecutive readings that are not a coincidence if the readings differ elsewhere.
const MANY: usize = 20;
/// The limit for a column in which all readings are equal.
const ALL: usize = 8;
/// Share of equal neighbors elsewhere above which the display has few digits.
const USUAL: f64 = 0.1;
/// Share of constant readings above which the measurement is refused.
const MOST: f64 = 0.5;

/// A run of equal readings.
struct Run {
    first: usize,
    last: usize,
    count: usize,
}

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        for (target, value) in columns(data) {
            let of = |row: &usize| {
                let one = &data.observations[*row];
                (one.component.is_none() || one.target == target).then(|| one.values.get(value).copied().flatten())?
            };
            let rows: Vec<usize> = (0..data.observations.len()).filter(|row| of(row).is_some()).collect();
            let runs = runs(&rows, &|row| of(&row).map(f64::to_bits));
            let is_long = |run: &Run| run.count >= ALL.max(MANY.min(rows.len())) && !is_one_place(data, run);
            let (long, other): (Vec<Run>, Vec<Run>) = runs.into_iter().partition(is_long);
            // Equal neighbors among all others.
            let same: usize = other.iter().map(|run| run.count - 1).sum();
            let pairs: usize = other.iter().map(|run| run.count).sum();
            let constant: usize = long.iter().map(|run| run.count).sum();
            if long.is_empty() || same as f64 > USUAL * pairs as f64 {
                continue;
            }
            let is_all = constant as f64 > MOST * rows.len() as f64;
            for run in long {
                let excluded = rows.iter().filter(|row| (run.first..=run.last).contains(row));
                let excluded = excluded.map(|&row| (row, value)).collect();
                out.push(DataDefect {
                    kind: DefectKind::Reading,
                    set,
                    name: target.and_then(|number| data.targets.get(number)).unwrap_or(&data.name).clone(),
                    what: "constant".into(),
                    rows: [run.first, run.last],
                    evidence: format!(
                        "{} readings on and on are the same number while the machine goes elsewhere",
                        run.count
                    ),
                    then: if is_all { Then::Refuse } else { Then::WithoutReadings(excluded) },
                });
            }
        }
    }
}

/// The columns of readings: target and value.
pub(super) fn columns(data: &DataSet) -> Vec<(Option<usize>, usize)> {
    let by_target = data.observations.iter().any(|one| one.component.is_some());
    let targets: Vec<Option<usize>> = if by_target { (0..data.targets.len()).map(Some).collect() } else { vec![None] };
    targets.into_iter().flat_map(|target| (0..3).map(move |value| (target, value))).collect()
}

/// Runs of equal consecutive readings.
fn runs(rows: &[usize], bits: &dyn Fn(usize) -> Option<u64>) -> Vec<Run> {
    let runs = rows.chunk_by(|one, next| bits(*one) == bits(*next));
    runs.filter_map(|run| Some(Run { first: *run.first()?, last: *run.last()?, count: run.len() })).collect()
}

/// True if all readings of a run are at one pose.
fn is_one_place(data: &DataSet, run: &Run) -> bool {
    let rows = data.observations.get(run.first..=run.last).unwrap_or_default();
    rows.windows(2).all(|pair| pair[0].reading.position == pair[1].reading.position)
}
