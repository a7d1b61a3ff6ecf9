//! Typed results of what a person asks of measured data as a whole, and what computes them: from texts of measurements to a calibration, a diagnosis,
//! figures, a division at speed. Nothing here opens a file, prints or stops a run: each function gives its result and the findings about the texts.
//!
//! The types are what `--json` prints; [`ncfix_report`](https://docs.rs/ncfix-report) draws them as text and pages.

mod calibrated;
pub mod calibration;
mod cells;
pub mod compared;
mod conditions;
pub mod corrected;
mod data_faults;
pub mod decomposition;
pub mod diagnosis;
pub mod extended;
pub mod figures;
mod held;
pub mod measurement;
mod not_told;
pub mod parameters;
pub mod planned;
pub mod readings;
mod repeated;
pub mod selection;
pub mod sensors;
pub mod simulated;
pub mod weighed;

use ncfix_base::diagnostic::Diagnostic;

/// Whether any of the findings forbids to go on.
fn has_errors(findings: &[Diagnostic]) -> bool {
    findings.iter().any(Diagnostic::is_error)
}
