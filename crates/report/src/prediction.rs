//! Intervals of predicted errors: the JSON object, the rows for people, and the reasons for a verdict.

use std::collections::BTreeMap;

use serde::Serialize;

use super::correction::push_row;
use super::number::significant;
use ncfix_base::units::um_from_mm;
use ncfix_path::path::{ErrorInterval, PredictedInterval, StationInterval};

/// Statement about a machine file without uncertainties.
pub const NOT_KNOWN: &str = "the machine file has no [uncertainty]";
/// Share of the repetitions without an improvement above which the correction does harm.
const HARMFUL: f64 = 0.975;
/// Maximum number of errors that a row names.
const MOST_NAMES: usize = 6;

/// Interval of the true errors of a program, from the uncertainty of the machine file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PredictionReport {
    /// True if the machine file states an uncertainty of every error that it has.
    pub is_known: bool,
    /// Errors without a known uncertainty; empty if the machine file states none at all.
    pub unknown: Vec<String>,
    /// Errors as programmed; `null` if no uncertainty is known.
    pub before: Option<IntervalReport>,
    /// Errors as written; `null` if no uncertainty is known.
    pub after: Option<IntervalReport>,
    /// Probability that the correction makes neither the largest nor the root mean square error larger; `null` if no uncertainty is known.
    pub improves: Option<f64>,
    /// Intervals at up to 200 places along the program, in its order; empty if no uncertainty is known.
    pub along: Vec<StationReport>,
}

/// Interval of the error of the tool tip at one place of a program, with a coverage probability of 95 %: lower and upper end.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StationReport {
    /// Line of the block in its file.
    pub line: u32,
    /// Error as programmed, µm.
    pub before_um: [f64; 2],
    /// Error as written, µm.
    pub after_um: [f64; 2],
}

impl StationReport {
    fn of(found: &StationInterval) -> StationReport {
        let StationInterval { origin, before_mm, after_mm } = found;
        let [before_um, after_um] = [before_mm, after_mm].map(|ends| ends.map(um_from_mm));
        StationReport { line: origin.line, before_um, after_um }
    }
}

/// Interval of the error of the tool tip: lower and upper end of each figure. The coverage probability is 95 % if the stated uncertainties are complete.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct IntervalReport {
    /// Mean, µm.
    pub mean_um: [f64; 2],
    /// Root mean square, µm.
    pub rms_um: [f64; 2],
    /// Maximum, µm.
    pub max_um: [f64; 2],
    /// Maximum along X, Y and Z of the workpiece, µm.
    pub axes_um: BTreeMap<&'static str, [f64; 2]>,
}

impl IntervalReport {
    fn of(found: &ErrorInterval) -> IntervalReport {
        let shown = |ends: [f64; 2]| ends.map(um_from_mm);
        IntervalReport {
            mean_um: shown(found.mean_mm),
            rms_um: shown(found.rms_mm),
            max_um: shown(found.max_mm),
            axes_um: ["X", "Y", "Z"].into_iter().zip(found.axes_mm.map(shown)).collect(),
        }
    }
}

/// An interval whose width is a smaller share of its upper end is a point.
const POINT: f64 = 1e-4;

/// Formats an interval: `1.23 … 4.56`.
fn range([low, high]: [f64; 2]) -> String {
    format!("{} … {}", significant(low), significant(high))
}

impl PredictionReport {
    /// Returns the report of an interval; `unknown` are the errors without a known uncertainty. Without an interval nothing is known.
    #[must_use]
    pub fn of(found: Option<&PredictedInterval>, unknown: Vec<String>) -> PredictionReport {
        PredictionReport {
            is_known: found.is_some() && unknown.is_empty(),
            unknown,
            before: found.map(|found| IntervalReport::of(&found.before)),
            after: found.map(|found| IntervalReport::of(&found.after)),
            improves: found.map(|found| found.better),
            along: found.map_or_else(Vec::new, |found| found.along.iter().map(StationReport::of).collect()),
        }
    }

    /// True if the uncertainty is known and the correction improves the program within it.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.is_known && self.improves.is_some_and(|share| share >= 1.0)
    }

    /// True if the correction makes the program worse within the uncertainty.
    pub(super) fn is_harmful(&self) -> bool {
        self.improves.is_some_and(|share| share <= 1.0 - HARMFUL)
    }

    /// Returns the rows for a terminal.
    #[must_use]
    pub fn rows(&self) -> String {
        let mut out = String::new();
        match (&self.before, &self.after) {
            (Some(before), Some(after)) => {
                let pair =
                    |of: fn(&IntervalReport) -> [f64; 2]| format!("{} → {} µm", range(of(before)), range(of(after)));
                let [max, rms] = [pair(|one| one.max_um), pair(|one| one.rms_um)];
                // Of unknown errors nothing is in it.
                let part = if self.unknown.is_empty() { "" } else { ", known part" };
                push_row(&mut out, "interval", &format!("95 %{part}: largest error {max}, RMS {rms}"));
                let moved = before.axes_um.iter().filter(|(_, ends)| ends[1] > 0.0);
                let parts: Vec<String> = moved
                    .filter_map(|(axis, ends)| {
                        let after = after.axes_um.get(axis)?;
                        // An interval of width 0 is no certainty: no uncertainty of the errors along this axis is known.
                        let is_point = |ends: &[f64; 2]| ends[1] - ends[0] <= POINT * ends[1];
                        if is_point(ends) && is_point(after) {
                            let [before, after] = [ends[1], after[1]].map(significant);
                            return Some(format!("{axis} {before} → {after} (uncertainty not known)"));
                        }
                        Some(format!("{axis} {} → {}", range(*ends), range(*after)))
                    })
                    .collect();
                if !parts.is_empty() {
                    push_row(&mut out, "", &format!("{} µm", parts.join(", ")));
                }
            }
            _ => push_row(&mut out, "interval", &format!("not known: {NOT_KNOWN}")),
        }
        if let Some(names) = self.names() {
            push_row(&mut out, "", &format!("without the uncertainty of {names}, which is not known"));
        }
        out
    }

    /// Returns the errors without a known uncertainty as a list for people; `None` if it is empty.
    pub(super) fn names(&self) -> Option<String> {
        let more = self.unknown.len().saturating_sub(MOST_NAMES);
        let mut shown: Vec<String> = self.unknown.iter().take(MOST_NAMES).cloned().collect();
        shown.extend((more > 0).then(|| format!("{more} more")));
        (!shown.is_empty()).then(|| shown.join(", "))
    }

    /// Returns the interval of the largest error as a part of a sentence.
    pub(super) fn largest(&self) -> Option<String> {
        let (before, after) = (self.before.as_ref()?, self.after.as_ref()?);
        Some(format!("{} µm before and {} µm after", range(before.max_um), range(after.max_um)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(better: f64) -> PredictedInterval {
        let of = |low: f64| ErrorInterval {
            mean_mm: [low, 2.0 * low],
            rms_mm: [1.5 * low, 3.0 * low],
            max_mm: [2.0 * low, 4.0 * low],
            axes_mm: [[low, 2.0 * low], [0.0; 2], [0.0, low]],
        };
        PredictedInterval { before: of(0.005), after: of(0.000_5), better, along: Vec::new() }
    }

    #[test]
    fn rows_show_both_ends_and_the_axes_that_have_an_error() {
        let report = PredictionReport::of(Some(&found(1.0)), vec!["EYX".into()]);
        insta::assert_snapshot!(report.rows(), @r"
        interval     95 %, known part: largest error 10.0 … 20.0 → 1.00 … 2.00 µm, RMS 7.50 … 15.0 → 0.750 … 1.50 µm
                     X 5.00 … 10.0 → 0.500 … 1.00, Z 0.000 … 5.00 → 0.000 … 0.500 µm
                     without the uncertainty of EYX, which is not known
        ");
        assert!(!report.is_certain() && PredictionReport::of(Some(&found(1.0)), Vec::new()).is_certain());
        assert!(!PredictionReport::of(Some(&found(0.99)), Vec::new()).is_certain());
        assert!(PredictionReport::of(Some(&found(0.01)), Vec::new()).is_harmful());
    }

    #[test]
    fn an_axis_without_any_known_uncertainty_has_no_interval() {
        let mut found = found(1.0);
        found.before.axes_mm[1] = [0.0138, 0.0138];
        found.after.axes_mm[1] = [0.000_092, 0.000_092];
        let report = PredictionReport::of(Some(&found), vec!["EYX".into()]);
        assert!(report.rows().contains("Y 13.8 → 0.092 (uncertainty not known)"), "{}", report.rows());
    }

    #[test]
    fn nothing_known_is_said() {
        let report = PredictionReport::of(None, Vec::new());
        assert_eq!(report.rows(), format!("interval     not known: {NOT_KNOWN}\n"));
        assert!(!report.is_known && !report.is_certain() && !report.is_harmful());
    }
}
