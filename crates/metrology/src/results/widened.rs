//! Uncertainties of a fit that includes more than uncorrelated noise.
//!
//! A least-squares fit takes readings as independent. A finding of a diagnosis has an uncertainty that also contains the autocorrelation of the readings, the
//! scatter of the runs, and the choice between explanations ([`crate::diagnose::AcceptedCause::amounts`]). In simulated readings whose runs differ by a drift
//! of 2 µm or by 8 µm/m, the interval of the fit was a half to a quarter of the scatter of its values. So the larger one counts.

use crate::calibrate::{Column, Fit, Parameter};
use crate::diagnose::extend::Change;
use crate::diagnose::{AcceptedCause, EXPANDED};
use ncfix_model::ParameterName;

/// Enlarges the uncertainty of one parameter, and its row of the factor of the covariance.
pub(super) fn enlarge(fit: &mut Fit, place: usize, times: f64) {
    if let Some(estimate) = fit.estimates.get_mut(place) {
        estimate.sigma *= times;
        estimate.inflation *= times * times;
    }
    fit.factor.get_mut(place).into_iter().flatten().for_each(|part| *part *= times);
}

/// Enlarges the uncertainties of parameters by given factors.
pub(super) fn widen(fit: &mut Fit, growth: &[(ParameterName, f64)]) {
    for place in 0..fit.estimates.len() {
        let Some(Column::Parameter(name)) = fit.estimates.get(place).map(|one| &one.column) else { continue };
        let found = growth.iter().find(|(own, _)| own == name).map(|(_, times)| *times);
        found.into_iter().for_each(|times| enlarge(fit, place, times));
    }
}

/// Gives the parameters of findings at least the uncertainties of the findings. Several findings may contain one parameter: its amount is their sum.
pub(super) fn widen_to(fit: &mut Fit, findings: &[(&AcceptedCause, &[Change])]) {
    for place in 0..fit.estimates.len() {
        let Some(estimate) = fit.estimates.get(place) else { continue };
        let Some(parameter) = estimate.column.parameter() else { continue };
        let of = |(one, changes): &(&AcceptedCause, &[Change])| sigma(&parameter, estimate.value, one, changes);
        let found = findings.iter().filter_map(of).map(|sigma| sigma * sigma).sum::<f64>().sqrt();
        let times = found / estimate.sigma;
        if times.is_finite() && times > 1.0 {
            enlarge(fit, place, times);
        }
    }
}

/// Standard uncertainty that a finding gives a parameter with this value; `None` if the parameter is not one of its amounts.
fn sigma(parameter: &Parameter, value: f64, one: &AcceptedCause, changes: &[Change]) -> Option<f64> {
    let of_column = |column: usize| one.amounts.u95(column) / EXPANDED;
    if let Parameter::Geometry(name) = parameter {
        // The names of its terms are in the order of its columns; constants that set-ups absorb have no change.
        let is_changed =
            changes.iter().any(|change| matches!(change, Change::Parameter { name: own, .. } if own == name));
        return one.candidate.place_of(name).filter(|_| is_changed).map(of_column);
    }
    // A drift or an expansion has one amount, in another unit.
    let [amount] = one.amounts.values.as_slice() else { return None };
    let is_own = parameter.is_linear() && changes.iter().any(|change| change.is_of(parameter));
    (is_own && *amount != 0.0).then(|| of_column(0) / amount.abs() * value.abs())
}
