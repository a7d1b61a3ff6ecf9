//! Uncertainties of a fit for `[uncertainty]` of the machine file.

use crate::calibrate::Fit;
use ncfix_machine::machine::Uncertainty;
use ncfix_model::uncertainty::UncertainParameter;

/// The uncertainties of a machine file after a fit: those of its parameters are new, the others stay. `unexplained_um` is the error that the model does
/// not contain, if it is known.
#[must_use]
pub fn uncertainty_of(before: Option<&Uncertainty>, fit: &Fit, unexplained_um: Option<f64>) -> Uncertainty {
    let mut out = before.cloned().unwrap_or_default();
    let parameters = fit.estimates.iter().filter_map(|one| one.column.parameter());
    let rows = parameters.zip(&fit.factor).filter_map(|(parameter, row)| {
        let name = parameter.to_string();
        let factor = UncertainParameter::find(&name, &fit.errors)?.file_factor();
        Some((name, row.iter().map(|part| part * factor).collect()))
    });
    out.extend_by(rows.collect());
    out.unexplained_um = unexplained_um.or(out.unexplained_um);
    out
}
