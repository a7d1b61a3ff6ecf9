//! Diagnostics about unidentifiable parameters: rejected fits, and reduced models.

use serde::Serialize;

use super::measurement::{Measurement, data_of, first_line};
use crate::calibrate::words::listed;
use crate::calibrate::{Confused, Estimate, Fit, FitError, Lost, Parameter, Unsettled, reduce};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::number::{micrometers, significant};
use ncfix_base::units::um_from_mm;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// Parameters that were left out for one reason.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LeftOut {
    /// Their names.
    pub parameters: Vec<String>,
    /// Reason why the data do not determine them.
    pub reason: String,
}

/// Maximum number of reported kinds of combinations, the most frequent ones.
const MOST_SAID: usize = 10;
/// Deviation of a known distance in standard uncertainties above which it is contradictory.
const CONTRADICTS: f64 = 5.0;
/// Implausible size of residuals.
const RUNS_AWAY: f64 = 1e6;

/// Adds diagnostics for an impossible fit; `of` names the fitted parameters.
pub(super) fn refuse(fault: FitError, of: &str, all: &[Measurement], findings: &mut Vec<Diagnostic>) {
    let described = |set: usize| all.get(set).or(all.first()).map(|one| first_line(&one.sources[1]));
    let refused = refusals(fault, of).into_iter();
    findings.extend(refused.map(|(set, found)| Diagnostic { place: described(set.unwrap_or(0)), ..found }));
}

/// Diagnostics, each with the index of its measurement.
fn refusals(fault: FitError, of: &str) -> Vec<(Option<usize>, Diagnostic)> {
    match fault {
        FitError::TooFew { equations, unknowns, lost } => {
            let message = format!("{of}{equations} readings cannot determine {unknowns} unknowns");
            let help =
                "measure more, describe what is known of the set-ups, choose a smaller model, or let --reduce do it";
            let mut out = vec![(None, Diagnostic::nowhere(Code::NOT_TOLD, message, help))];
            out.extend(not_identified(*lost, of));
            out
        }
        FitError::NotIdentified(lost) => not_identified(*lost, of),
        FitError::NotSettled(why) => vec![not_settled(why, of)],
    }
}

/// The first message of a failure, as a part of a sentence.
pub(super) fn words(fault: FitError) -> String {
    refusals(fault, "")
        .into_iter()
        .next()
        .map_or_else(|| "nothing can be determined".to_owned(), |(_, found)| found.message)
}

fn not_identified(lost: Lost, of: &str) -> Vec<(Option<usize>, Diagnostic)> {
    let more = lost.confused.len().saturating_sub(MOST_SAID);
    let mut out: Vec<(Option<usize>, Diagnostic)> = lost
        .confused
        .into_iter()
        .take(MOST_SAID)
        .map(|one| (one.set, Diagnostic::nowhere(Code::NOT_TOLD, format!("{of}{}", one.sentence), one.remedy)))
        .collect();
    for sentence in lost.unknowns.iter().filter(|_| lost.leave_out.is_empty()).take(MOST_SAID) {
        let help = "describe what is known of the set-up";
        out.push((None, Diagnostic::nowhere(Code::NOT_TOLD, format!("{of}{sentence}"), help)));
    }
    let count = lost.leave_out.len();
    if count > 1 {
        let rest = if more > 0 { format!(" ({more} more reasons are not shown)") } else { String::new() };
        let message = format!(
            "{of}without these {count} parameters the data determine all others{rest}: {}",
            listed(&lost.leave_out, usize::MAX)
        );
        let help = "measure as described above, remove them from --model, or let --reduce omit them";
        out.push((None, Diagnostic::nowhere(Code::NOT_TOLD, message, help)));
    }
    out
}

fn not_settled(why: Option<Unsettled>, of: &str) -> (Option<usize>, Diagnostic) {
    let Some(Unsettled { set, times, rejected: [rejected, readings] }) = why else {
        let message = format!("{of}the fit does not converge");
        let help = "check signs and set-ups in the description, --machine, and sigma_um; --no-robust gives all rows the same weight";
        return (None, Diagnostic::nowhere(Code::NOT_SETTLED, message, help));
    };
    if times > RUNS_AWAY {
        let message = format!(
            "{of}the fit diverges: the parameters are determined too poorly, or positions or readings are in another unit"
        );
        let help = "check units of positions and set-ups, choose a smaller model, or measure where the parameters have more effect";
        return (Some(set), Diagnostic::nowhere(Code::NOT_SETTLED, message, help));
    }
    let size = if times > 1.0 {
        format!("the residual is {} times sigma_um", significant(times))
    } else {
        "the residual is not noise".to_owned()
    };
    let message = format!(
        "{of}the fit does not converge: {size}, and {rejected} of {readings} readings are rejected as outliers"
    );
    let help = "check the columns of positions, the signs and the set-ups, then write a larger sigma_um, or none; --no-robust gives all rows the same weight";
    (Some(set), Diagnostic::nowhere(Code::NOT_SETTLED, message, help))
}

/// Reports parameters so uncertain that their uncertainty alone moves the tool by more than `max_mm`, which is rejected. Returns `true` if there are
/// any.
pub(super) fn badly_told(fit: &Fit, all: &[Measurement], max_mm: f64, findings: &mut Vec<Diagnostic>) -> bool {
    let uncertain = |one: &Estimate| {
        let share = if one.value == 0.0 { 0.0 } else { one.sigma / one.value.abs() };
        one.effect_mm * share
    };
    let of_machine = fit.estimates.iter().filter(|one| one.column.is_of_machine());
    let badly: Vec<(f64, Parameter)> = of_machine
        .filter(|one| uncertain(one) > max_mm)
        .filter_map(|one| Some((uncertain(one), one.column.parameter()?)))
        .collect();
    let Some(worst) = badly.iter().map(|(mm, _)| *mm).max_by(f64::total_cmp) else { return false };
    let names: Vec<Parameter> = badly.into_iter().map(|(_, parameter)| parameter).collect();
    let message = format!(
        "determined so poorly that their uncertainty alone moves the tool by up to {}: {}",
        micrometers(um_from_mm(worst)),
        listed(&names, MOST_SAID)
    );
    let help = "measure where they have more effect, remove them from the model, or let --reduce omit them";
    let place = all.first().map(|one| first_line(&one.sources[1]));
    let found = Diagnostic { place, ..Diagnostic::nowhere(Code::NOT_TOLD, message, help) };
    findings.push(found);
    true
}

/// Reports known distances that do not fit: they contradict each other or the probings.
pub(super) fn distances(fit: &Fit, all: &[Measurement], findings: &mut Vec<Diagnostic>) {
    for &(set, tie, left, sigma) in fit.ties.iter().filter(|(.., left, sigma)| left.abs() > CONTRADICTS * sigma) {
        let Some(one) = all.get(set) else { continue };
        let Some(length) = one.data.lengths.get(tie) else { continue };
        let name = |number: usize| one.data.targets.get(number).map_or("?", String::as_str);
        let [from, to] = length.between.map(name);
        let message = format!(
            "{}: a residual of {} remains in the distance from {from} to {to} ({} mm), {} times its uncertainty",
            one.data.name,
            micrometers(um_from_mm(left.abs())),
            length.value_mm,
            significant(left.abs() / sigma)
        );
        let help = "check value_mm and sigma_um of [[length]], and whether another [[length]] contradicts it";
        let found = Diagnostic {
            place: Some(first_line(&one.sources[1])),
            ..Diagnostic::nowhere(Code::POOR_FIT, message, help)
        };
        findings.push(found);
    }
}

/// Leaves out unidentifiable parameters, with a diagnostic for each reason. Returns the remaining parameters.
pub(super) fn reduced(
    (machine, start): (&Machine, &ErrorModel),
    parameters: &[Parameter],
    all: &[Measurement],
    findings: &mut Vec<Diagnostic>,
    left_out: &mut Vec<LeftOut>,
) -> Vec<Parameter> {
    let data = data_of(all);
    // If numbers are not finite, the fit reports it.
    let Some(found) = reduce(machine, start, parameters, &data) else { return parameters.to_vec() };
    for Confused { sentence, remedy, parameters, set } in found.left_out {
        let one = all.get(set.unwrap_or(0)).or(all.first());
        let names: Vec<String> = parameters.iter().map(ToString::to_string).collect();
        let listed = listed(&parameters, usize::MAX);
        // The sentence usually names them itself.
        let message = if sentence.starts_with(&listed) {
            format!("left out: {sentence}")
        } else {
            format!("left out: {listed}: {sentence}")
        };
        let place = one.map(|one| first_line(&one.sources[1]));
        let found = Diagnostic { place, ..Diagnostic::nowhere(Code::REDUCED, message, remedy) };
        findings.push(found);
        left_out.push(LeftOut { parameters: names, reason: sentence });
    }
    found.parameters
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_model::parameter::ParameterName;

    #[test]
    fn every_fault_is_a_refusal() {
        let named = |names: &[&str]| -> Vec<Parameter> {
            names.iter().map(|name| Parameter::from(name.parse::<ParameterName>().unwrap())).collect()
        };
        let confused = |names: &[&str], sentence: &str| Confused {
            sentence: sentence.into(),
            remedy: "do".into(),
            parameters: named(names),
            set: None,
        };
        let mut lost = Lost::default();
        lost.confused = vec![confused(&["EXX1"], "a"), confused(&["EYY1"], "b")];
        lost.leave_out = named(&["EXX1", "EYY1"]);
        let strange = Unsettled { set: 1, times: 40.0, rejected: [3, 9] };
        let faults = [
            FitError::TooFew { equations: 2, unknowns: 3, lost: Box::default() },
            FitError::NotIdentified(Box::new(lost)),
            FitError::NotSettled(None),
            FitError::NotSettled(Some(strange)),
        ];
        let found: Vec<(String, String)> = faults
            .into_iter()
            .flat_map(|fault| refusals(fault, "set: "))
            .map(|(_, one)| (one.code.to_string(), one.message))
            .collect();
        let expected = [
            ("E0606", "set: 2 readings cannot determine 3 unknowns"),
            ("E0606", "set: a"),
            ("E0606", "set: b"),
            ("E0606", "set: without these 2 parameters the data determine all others: EXX1 and EYY1"),
            ("E0607", "set: the fit does not converge"),
            (
                "E0607",
                "set: the fit does not converge: the residual is 40.0 times sigma_um, and 3 of 9 readings are rejected as outliers",
            ),
        ];
        assert_eq!(found, expected.map(|(code, message)| (code.to_owned(), message.to_owned())));
    }
}
