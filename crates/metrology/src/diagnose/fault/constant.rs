//! Readings that keep one value while the machine moves, or at rest although readings at rest have noise: a dead channel, a stuck probe, a logger that
//! repeats its last row.

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
/// Smallest share of changes at rest that reverse from row to row with noise; for pure noise it is two thirds.
const REVERSED: f64 = 0.25;
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
            let is_evidence = |run: &Run| !is_one_place(data, run) || has_noise_at_rest(data, &rows, &of, run);
            let is_long = |run: &Run| run.count >= ALL.max(MANY.min(rows.len())) && is_evidence(run);
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
                    evidence: if is_one_place(data, &run) {
                        format!(
                            "{} consecutive readings are the same number, but other readings at rest have noise",
                            run.count
                        )
                    } else {
                        format!("{} consecutive readings are the same number while the machine moves", run.count)
                    },
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

/// True if readings at rest outside a run have noise: their changes often reverse.
fn has_noise_at_rest(data: &DataSet, rows: &[usize], of: &dyn Fn(&usize) -> Option<f64>, run: &Run) -> bool {
    let position = |row: usize| data.observations.get(row).map(|one| one.reading.position);
    let is_at_rest = |three: &&[usize]| {
        three.iter().all(|row| !(run.first..=run.last).contains(row) && position(*row) == position(three[0]))
    };
    let reversals = rows.windows(3).filter(is_at_rest).filter_map(|three| {
        let [first, second, third] = [of(&three[0])?, of(&three[1])?, of(&three[2])?];
        Some((second - first) * (third - second) < 0.0)
    });
    let reversals: Vec<bool> = reversals.collect();
    let reversed = reversals.iter().filter(|is_reversed| **is_reversed).count();
    reversals.len() >= MANY && reversed as f64 > REVERSED * reversals.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::fault::{Checks, find_with};

    /// Rows of the faults in 100 readings at one pose: a function of the row in the first 60, its last value in the others.
    fn found(um: impl Fn(usize) -> f64) -> Vec<[usize; 2]> {
        let rows: String = (0..100).map(|row| format!("0,0,0,{},{}\n", 60 * row, um(usize::min(row, 59)))).collect();
        let machine = bench::machine();
        let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 1\nfree = [\"offset\"]\n";
        let sets = [bench::table(&machine, &format!("X,Y,Z,t_s,dx_um\n{rows}"), description)];
        find_with(&Checks::empty().with(&CHECK), &bench::scene(&machine, &sets)).iter().map(|one| one.rows).collect()
    }

    #[test]
    fn a_last_row_that_is_repeated_at_rest_is_a_fault_only_beside_noise() {
        // The fractional parts of multiples of the golden ratio rise and fall.
        assert_eq!(found(|row| (row as f64 * 1.618_034).fract()), [[59, 99]]);
        // A simulated log without noise drifts and comes to rest.
        assert!(found(|row| 0.1 * row as f64).is_empty());
    }
}
