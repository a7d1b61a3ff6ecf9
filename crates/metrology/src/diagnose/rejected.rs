//! Candidates that were tested and are not named: those that an acceptance test rejected, and the best remaining candidate of every cause.

use serde::Serialize;

use super::cause::{Candidate, Cause, Causes};
use super::parts::{FileShare, differing};
use super::search::{Field, Taken, Weights};
use super::size::{Amounts, Size, size};

/// The acceptance test that rejected a candidate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Gate {
    /// Its gain is not significant.
    #[default]
    #[serde(rename = "significance")]
    Chance,
    /// It does not improve the prediction of left-out readings.
    #[serde(rename = "gain on unseen parts")]
    Unseen,
    /// The held-out data do not confirm it.
    #[serde(rename = "held-out data")]
    HeldOut,
}

impl Gate {
    /// Its name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Gate::Chance => "significance",
            Gate::Unseen => "gain on unseen parts",
            Gate::HeldOut => "held-out data",
        }
    }
}

/// A candidate that an acceptance test rejected.
#[derive(Clone, Debug)]
pub struct Rejected {
    /// The candidate.
    pub candidate: Candidate,
    /// The acceptance test.
    pub gate: Gate,
    /// p-value of its gain, corrected for the number of candidates.
    pub chance: f64,
    /// Relative reduction of the RMS of left-out readings, if tested and determined.
    pub gain: Option<f64>,
    /// Its size over all files.
    pub size: Size,
    /// Its size in each file, if the files differ significantly: this explains why the unseen files lack it.
    pub by_file: Vec<FileShare>,
}

/// Final result for a cause.
#[derive(Clone, Debug)]
pub struct TriedCause {
    /// The cause.
    pub cause: &'static Cause,
    /// Number of its candidates.
    pub candidates: usize,
    /// Parameter of its best candidate that was not accepted, and the share of the sum of squares of the residual that it would explain.
    pub best: Option<(String, f64)>,
}

/// Collects rejections: number of the candidate, acceptance test, p-value and gain.
#[derive(Clone, Debug, Default)]
pub(super) struct Rejections(Vec<(usize, Gate, f64, Option<f64>)>);

impl Rejections {
    pub(super) fn add(&mut self, term: &Taken, gate: Gate, gain: Option<f64>) {
        self.0.push((term.candidate, gate, term.chance, gain));
    }

    /// Returns the rejected candidates that are not accepted in the end. For a candidate that was rejected twice, the last rejection counts.
    pub(super) fn list(
        &self,
        field: &Field<'_, '_>,
        weights: &Weights,
        (taken, used): (&[usize], usize),
        (memory, noise): (f64, f64),
    ) -> Vec<Rejected> {
        let mut out: Vec<Rejected> = Vec::new();
        let is_same = |one: &Candidate, other: &Candidate| {
            one.cause.name == other.cause.name && one.parameter == other.parameter && one.drivers == other.drivers
        };
        let found: Vec<&Candidate> = taken.iter().filter_map(|&number| field.candidates.get(number)).collect();
        for &(number, gate, chance, gain) in self.0.iter().rev() {
            let Some(candidate) = field.candidates.get(number) else { continue };
            let known = out.iter().map(|one| &one.candidate).chain(found.iter().copied());
            if known.into_iter().any(|other| is_same(candidate, other)) {
                continue;
            }
            let mut one = Rejected {
                candidate: candidate.clone(),
                gate,
                chance,
                gain,
                size: Size::default(),
                by_file: Vec::new(),
            };
            if gate == Gate::Unseen && used > 1 {
                let with: Vec<usize> = taken.iter().copied().chain([number]).collect();
                let inflation = field.inflation(weights, &with, taken, number);
                let variance = noise * inflation;
                let (values, covariance) = field.series(weights, taken, memory).amounts(&field.columns(candidate));
                one.by_file = differing(field, weights, (candidate, &values), taken, (memory, inflation));
                let count = values.len();
                let covariance =
                    (0..count).map(|k| (0..count).map(|l| covariance[(k, l)] * variance).collect()).collect();
                one.size = size(candidate, &Amounts { values, covariance }, field.scene, used);
            }
            out.push(one);
        }
        out.reverse();
        out
    }
}

/// Returns every cause of the catalog with its best candidate, in addition to the accepted terms.
pub(super) fn tried(
    (field, causes): (&Field<'_, '_>, &Causes),
    weights: &Weights,
    taken: &[usize],
    memory: f64,
) -> Vec<TriedCause> {
    let series = field.series(weights, taken, memory);
    let whole = series.squares();
    let gains = field.gains(weights, &series);
    let of = |cause: &'static Cause| {
        let own = || field.candidates.iter().enumerate().filter(|(_, one)| one.cause.name == cause.name);
        let open = own().filter(|(number, _)| !taken.contains(number));
        let best = open
            .filter_map(|(number, one)| Some((one, gains.get(number).filter(|gain| gain.rank > 0)?.squares)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let share = |squares: f64| if whole > 0.0 { squares / whole } else { 0.0 };
        TriedCause {
            cause,
            candidates: own().count(),
            best: best.map(|(one, squares)| (one.parameter.clone(), share(squares))),
        }
    };
    causes.iter().map(|cause| of(cause.cause())).collect()
}
