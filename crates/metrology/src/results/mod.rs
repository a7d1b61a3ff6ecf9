//! Typed results of evaluations of measured data, and the functions that compute them: from texts of measurements to a calibration, a diagnosis,
//! figures, or a decomposition at speed. Nothing here opens a file, prints or ends a run: each function returns its result and the diagnostics about
//! the texts.
//!
//! The types are printed by `--json`; [`ncfix_report`](https://docs.rs/ncfix-report) draws them as text and pages.

mod alignment;
mod angles;
mod calibrated;
pub mod calibration;
mod cells;
pub mod compared;
mod conditions;
mod contradicting;
pub mod corrected;
mod data_faults;
pub mod decomposition;
pub mod diagnosis;
pub mod extended;
pub mod features;
mod figure;
pub mod figures;
mod frame;
mod held;
pub mod hypotheses;
pub mod measurement;
mod not_identified;
pub mod not_shown;
mod omitted;
pub mod parameters;
pub mod planned;
pub mod readings;
mod references;
mod relative;
mod repeated;
mod repeats;
mod residuals;
mod rotary_places;
pub mod selection;
pub mod sensors;
mod signs;
pub mod simulated;
mod size_range;
mod slope;
mod sorted_rows;
pub mod stated;
pub mod uncertain;
pub mod weighed;
mod widened;

use ncfix_base::diagnostic::Diagnostic;

/// `true` if any of the diagnostics forbids to continue.
fn has_errors(findings: &[Diagnostic]) -> bool {
    findings.iter().any(Diagnostic::is_error)
}
