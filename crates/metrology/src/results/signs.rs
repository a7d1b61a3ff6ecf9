//! The file whose readings have the opposite sign of those of all other files.
//!
//! A wrong sign is the commonest fault of a file of readings, and the fit then spoils the errors that several files share. The residual of the file need
//! not be the largest. So each file is turned around once: if one with the opposite sign fits far better together with the others, this is the fault.

use super::measurement::{Measurement, data_of};
use crate::calibrate::{Fit, FitOptions, Parameter, fit};
use crate::measure::data::DataSet;
use crate::measure::kind::Measurand;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::number::significant;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// Factor by which the sum of squares must fall: a missing error of the model does not turn with a sign.
const FALLS: f64 = 9.0;
/// Two signs explain the readings equally well if the sums of squares differ by less than this factor.
const EQUAL: f64 = 2.0;
/// Most files that are turned around, and product of readings and parameters beyond which this would take too long.
const MOST_FILES: usize = 24;
const MOST: usize = 5_000_000;

/// A refusal that names the file, or the files of which one is wrong, if its opposite sign explains the readings far better; else `None`.
pub(super) fn wrong_sign(
    (machine, start): (&Machine, &ErrorModel),
    parameters: &[Parameter],
    (used, found): (&[Measurement], &Fit),
    options: FitOptions,
) -> Option<Diagnostic> {
    let data = data_of(used);
    let rows: usize = data.iter().map(|set| set.observations.len()).sum();
    if data.len() < 2 || data.len() > MOST_FILES || rows.saturating_mul(parameters.len()) > MOST {
        return None;
    }
    let turned = |number: usize| {
        let mut data = data.clone();
        let set = data.get_mut(number).filter(|set| has_sign(set))?;
        for value in set.observations.iter_mut().flat_map(|row| &mut row.values) {
            *value = value.map(|value| -value);
        }
        let turned = fit(machine, start, parameters, &data, options).ok()?;
        let [before, after] = sums(&data, [found, &turned]);
        (after * FALLS < before).then_some((number, before, after))
    };
    let mut better: Vec<(usize, f64, f64)> = (0..data.len()).filter_map(turned).collect();
    better.sort_by(|one, other| (one.2 / one.1).total_cmp(&(other.2 / other.1)));
    let &(_, before, after) = better.first()?;
    let names: Vec<&str> = better
        .iter()
        .take_while(|one| one.2 / one.1 <= EQUAL * after / before)
        .filter_map(|one| data.get(one.0))
        .map(|set| set.name.as_str())
        .collect();
    let times = significant((before / after).sqrt());
    let message = match names.as_slice() {
        [name] => format!(
            "the fitted model contradicts {name}: with the opposite sign of its readings, the residual of all files is {times} times smaller"
        ),
        several => format!(
            "the signs of the files contradict each other: with the opposite sign of one of {}, the residual of all files is {times} times smaller",
            several.join(", ")
        ),
    };
    let help = format!(
        "check the sign of the readings of {} at the machine: one reading of known direction shows it; ncfix diagnose with these files tests the sign of each file",
        names.join(" and ")
    );
    Some(Diagnostic::nowhere(Code::NOT_SETTLED, message, help))
}

/// True if the readings of a measurement have a sign: a probed place has none.
fn has_sign(set: &DataSet) -> bool {
    !matches!(set.kind.measurand, Measurand::BallPlace | Measurand::Other)
}

/// Sums of the squares of the residuals of two fits, in the smaller of the two standard uncertainties of each file.
fn sums(data: &[DataSet], fits: [&Fit; 2]) -> [f64; 2] {
    let smaller = |of: fn(&Fit) -> &Vec<f64>, set: usize| {
        let all = fits.iter().filter_map(|fit| of(fit).get(set)).copied().filter(|sigma| *sigma > 0.0);
        all.fold(f64::INFINITY, f64::min)
    };
    fits.map(|fit| {
        let square = |&(set, row, residual, _): &(usize, usize, f64, f64)| {
            let is_angle = data.get(set).and_then(|set| set.observations.get(row)).is_some_and(|row| row.is_angle());
            let sigma = smaller(if is_angle { |fit| &fit.angle_sigmas } else { |fit| &fit.sigmas }, set);
            (residual / sigma).powi(2)
        };
        fit.residuals.iter().map(square).sum()
    })
}
