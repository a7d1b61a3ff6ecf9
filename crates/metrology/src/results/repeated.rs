//! Simulated repetitions of a fit for checking its uncertainties.

use super::calibrated::CalibrationResult;
use super::cells::unit_of;
use super::measurement::{Measurement, data_of};
use super::not_identified;
use crate::calibrate::words::listed;
use crate::calibrate::{Fit, FitOptions, MonteCarlo, Parameter, monte_carlo};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::number::significant;
use ncfix_machine::machine::Machine;

/// Maximum number of names in the diagnostic.
const MOST_NAMES: usize = 6;

/// Repeats the fit, and fills in the scatter.
pub(super) fn repeat(
    (machine, parameters): (&Machine, &[Parameter]),
    all: &[Measurement],
    (fit, options): (&Fit, FitOptions),
    runs_and_seed: [u64; 2],
    progress: &mut dyn FnMut(f64),
    findings: &mut Vec<Diagnostic>,
    report: &mut CalibrationResult,
) {
    let data = data_of(all);
    let mut done = |done: u64| progress(done as f64 / runs_and_seed[0].max(1) as f64);
    let found = monte_carlo(machine, parameters, &data, fit, options, runs_and_seed, &mut done);
    let found = match found {
        Ok(found) => found,
        Err(fault) => return not_identified::refuse(fault, "repetitions: ", all, findings),
    };
    let (mut of_machine, mut of_setups) = (report.parameters.iter_mut(), report.unknowns.iter_mut());
    for (estimate, spread) in fit.estimates.iter().zip(&found.spreads) {
        let is_parameter = estimate.column.is_of_machine();
        let shown = if is_parameter { of_machine.next() } else { of_setups.next() };
        if let Some(shown) = shown.filter(|_| found.runs > 1) {
            shown.sigma_monte_carlo = Some(spread * unit_of(&estimate.column, &data).0);
        }
    }
    findings.extend(contradictions(fit, &found));
}

/// Diagnostics for uncertainties that the repetitions contradict.
fn contradictions(fit: &Fit, found: &MonteCarlo) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    let all = fit.estimates.iter().zip(&found.spreads);
    let wrong: Vec<(Parameter, f64)> = all
        .filter(|(one, spread)| found.contradicts(**spread, one.sigma))
        .filter_map(|(one, spread)| Some((one.column.parameter()?, spread / one.sigma)))
        .collect();
    let worst = wrong.iter().map(|(_, times)| *times).max_by(|one, other| one.ln().abs().total_cmp(&other.ln().abs()));
    if let (Some(worst), true) = (worst, found.runs > 1) {
        let names: Vec<Parameter> = wrong.into_iter().map(|(name, _)| name).collect();
        let times = significant(worst);
        let message =
            format!("{} scatter by up to {times} times ± 1σ in simulated repetitions", listed(&names, MOST_NAMES));
        let help = "use ± MC as the uncertainty; with more readings, or --no-robust, both agree better";
        out.push(Diagnostic::nowhere(Code::UNLIKE_REPEATED, message, help));
    }
    if found.failed > 0 {
        let message =
            format!("{} of {} simulated repetitions could not be fitted", found.failed, found.failed + found.runs);
        let help = "measure more: with other noise, these data do not determine the parameters";
        out.push(Diagnostic::nowhere(Code::UNLIKE_REPEATED, message, help));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::{Column, Estimate};
    use ncfix_model::ErrorModel;

    #[test]
    fn uncertainties_that_repetitions_contradict_are_named() {
        let estimate = |name: &str| Estimate {
            column: Column::Parameter(name.parse().unwrap()),
            value: 1.0,
            sigma: 2.0,
            inflation: 1.0,
            effect_mm: 0.0,
        };
        let fit = Fit {
            errors: ErrorModel::default(),
            estimates: vec![estimate("EXX1"), estimate("EYY1"), estimate("EZZ1")],
            sigmas: Vec::new(),
            angle_sigmas: Vec::new(),
            ties: Vec::new(),
            residuals: Vec::new(),
            condition: 1.0,
            freedom: 1,
            rounds: 1,
            factor: Vec::new(),
            mean_lines: Vec::new(),
        };
        // With 201 repetitions three standard deviations of a standard deviation are 15 %: the limit is 40 %.
        let found = MonteCarlo { spreads: vec![2.7, 2.9, 1.0], runs: 201, failed: 0 };
        let said = contradictions(&fit, &found);
        assert_eq!(said.len(), 1);
        assert_eq!(said[0].code, Code::UNLIKE_REPEATED);
        assert!(said[0].message.starts_with("EYY1 and EZZ1 scatter"), "{}", said[0].message);
        let found = MonteCarlo { spreads: vec![2.0; 3], runs: 1, failed: 4 };
        let said = contradictions(&fit, &found);
        assert_eq!(said[0].message, "4 of 5 simulated repetitions could not be fitted");
    }
}
