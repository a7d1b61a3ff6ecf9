//! Files of a calibration that contradict each other: a warning for each parameter, and an uncertainty that contains the values of both.
//!
//! A least-squares fit of inconsistent values has an uncertainty that is too small by their Birge ratio, √(χ²/(n − 1)) (Birge, Physical Review 40, 1932;
//! Bodnar & Elster, Metrologia 51, 2014). Of two values, this ratio gives the distance of the mean from both if they count equally, and less than the distance
//! from the lesser one otherwise. Which of the two is right is not known, so the larger distance counts: it is never below the ratio.

use super::cells::unit_of;
use super::measurement::Measurement;
use super::widened::enlarge;
use crate::calibrate::{Contradiction, FileValue, Fit};
use crate::measure::data::DataSet;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::number::significant;

/// Warns of the contradictions, and enlarges the uncertainties.
pub(super) fn apply(
    found: &[Contradiction],
    used: &[Measurement],
    data: &[DataSet],
    fit: &mut Fit,
    findings: &mut Vec<Diagnostic>,
) {
    for one in found {
        let Some(estimate) = fit.estimates.get(one.parameter) else { continue };
        let covered = one.files.iter().map(|file| (file.value - estimate.value).abs()).fold(0.0, f64::max);
        let (factor, unit) = unit_of(&estimate.column, data);
        let name = estimate.column.name(data).to_string();
        let times = covered / estimate.sigma;
        let path = |file: &FileValue| used.get(file.file).map_or("?", |own| own.sources[0].name());
        let value = |file: &FileValue| {
            let [value, sigma] = [file.value, file.sigma].map(|own| significant(own * factor));
            format!("{value} ± {sigma} {unit} in {}", path(file))
        };
        let [first, second] = &one.files;
        let message = format!(
            "files contradict each other: {name} is {} and {}, {} combined standard uncertainties apart; its ± is now {} {unit}",
            value(first),
            value(second),
            significant(one.sigmas),
            significant(covered.max(estimate.sigma) * factor)
        );
        let help = format!(
            "one of them measured another state of the machine: compare dates, temperatures, offsets and signs; leave one out, or test it with \
             --hold-out {}",
            path(second)
        );
        findings.push(Diagnostic::nowhere(Code::FILES_CONTRADICT, message, help));
        if times.is_finite() && times > 1.0 {
            enlarge(fit, one.parameter, times);
        }
    }
}
