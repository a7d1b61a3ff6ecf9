//! Uncertainties of a fit for `[uncertainty]` of the machine file.

use crate::calibrate::Fit;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_machine::machine::{Uncertainty, UncertaintyRow};
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

/// Names lists that a fit replaces although a person has appended an entry to them: a fit has no more causes than parameters. Lists of several fits do not show
/// it, unless all of them are replaced.
pub(super) fn replaced(before: Option<&Uncertainty>, fit: &Fit) -> Option<Diagnostic> {
    let fitted: Vec<String> =
        fit.estimates.iter().filter_map(|one| one.column.parameter()).map(|name| name.to_string()).collect();
    let lists: Vec<(&String, usize)> = before?
        .rows
        .iter()
        .filter_map(|(name, row)| match row {
            UncertaintyRow::Shared(row) => Some((name, row.len())),
            UncertaintyRow::Alone(_) => None,
        })
        .collect();
    let names: Vec<&str> =
        lists.iter().filter(|(_, length)| *length > lists.len()).map(|(name, _)| name.as_str()).collect();
    if names.is_empty() || !lists.iter().all(|(name, _)| fitted.contains(name)) {
        return None;
    }
    let message = format!(
        "[uncertainty] of the machine file has appended entries, and the new lists do not have them: {}",
        names.join(", ")
    );
    let help = "append them again in the new file if they still apply, as the uncertainty of a certificate does";
    Some(Diagnostic::nowhere(Code::UNCERTAINTY_REPLACED, message, help))
}
