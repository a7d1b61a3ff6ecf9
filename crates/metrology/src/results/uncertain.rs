//! Uncertainties of a fit for `[uncertainty]` of the machine file.

use super::calibrated::CalibrationResult;
use super::measurement::Measurement;
use crate::calibrate::Fit;
use ncfix_base::units::{Unit, um_from_mm};
use ncfix_machine::machine::Uncertainty;
use ncfix_model::uncertainty::UncertainParameter;

/// Excess of a mean square over the described one, in its standard deviations, above which it is no scatter.
const CLEAR: f64 = 3.0;

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

/// The part of the residual that the described uncertainty of the instruments does not explain, root mean square of the lengths, µm: of held-out readings if
/// there are any, else of the `used` ones. `None` if no description states an uncertainty.
#[must_use]
pub fn unexplained_um(result: &CalibrationResult, used: &[Measurement]) -> Option<f64> {
    let described_um = |name: &str| {
        let own = used.iter().find(|one| one.data.name == name);
        own.and_then(|one| one.data.sigma).map(um_from_mm)
    };
    let of = |is_held_out: bool| {
        let own = result.data.iter().filter(|one| one.is_held_out == is_held_out && one.unit == Unit::Um);
        let squares = own.filter_map(|one| {
            let sigma = if is_held_out { one.sigma } else { described_um(&one.name) }?;
            let readings = one.readings as f64;
            let (square, expected) = (one.left_rms * one.left_rms, sigma * sigma);
            let is_scatter = square <= expected * (1.0 + CLEAR * (2.0 / readings.max(1.0)).sqrt());
            Some([readings, if is_scatter { 0.0 } else { readings * (square - expected) }])
        });
        let [count, sum] = squares.fold([0.0, 0.0], |[count, sum], one| [count + one[0], sum + one[1]]);
        (count > 0.0).then(|| (sum / count).sqrt())
    };
    // Nanometres suffice in a file that people read.
    of(true).or_else(|| of(false)).map(|um| (um * 1e3).round() / 1e3)
}
