//! Notes for terms added by a diagnosis: size, evidence, other explanations, needs of a correction.

use super::super::cause::{Correctable, EffectKind};
use super::super::verdict::AcceptedCause;
use super::{Change, remedy};
use ncfix_base::number::probability;

/// Beginning of a line on an added cause.
pub const HEAD: &str = "diagnosed:";
/// Beginning of a line on a cause that was found and not added.
pub const LEFT_OUT: &str = "# not corrected:";
/// Smallest p-value that is written as a number.
const LEAST_P: f64 = 1e-12;
/// Maximum numbers of other explanations, and of values with uncertainties, in a note.
const MOST: usize = 3;
const VALUES: usize = 16;

/// Names of the measurements that were used, and of the held-out ones.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// Used.
    pub used: Vec<String>,
    /// Held out.
    pub held_out: Vec<String>,
}

/// Size with uncertainty: `backlash EXX 3.01 ± 0.08 um (95 %)`.
fn size(one: &AcceptedCause) -> String {
    let digits = if one.size.u95 > 0.0 { (1.0 - one.size.u95.log10().floor()).clamp(0.0, 9.0) as usize } else { 4 };
    let name = format!("{} {}", one.candidate.cause.effect, one.candidate.parameter);
    format!("{} {:.digits$} ± {:.digits$} {} (95 %)", name.trim_end(), one.size.value, one.size.u95, one.size.unit)
}

/// The note for a term; `fitted` are its parameters from the joint fit: name, value, expanded uncertainty (95 %), unit.
#[must_use]
pub fn lines(
    one: &AcceptedCause,
    changes: &[Change],
    files: &Files,
    fitted: &[(String, f64, f64, String)],
) -> Vec<String> {
    let mut out = vec![format!("{HEAD} {}; {}", size(one), remedy(&one.candidate))];
    let p = if one.chance < LEAST_P { format!("p < {LEAST_P:e}") } else { format!("p = {:.0e}", one.chance) };
    let sure = one.probability.map_or_else(String::new, |sure| format!(", {}", probability(sure)));
    let judged_on = if files.held_out.is_empty() {
        "left-out readings".to_owned()
    } else {
        format!("held-out data ({})", files.held_out.join(", "))
    };
    out.push(format!(
        "  from {}; on {judged_on} the residual is {:.0} % smaller; {p}{sure}",
        files.used.join(", "),
        100.0 * one.gain_unseen
    ));
    let rivals: Vec<String> = one
        .class
        .iter()
        .skip(1)
        .take(MOST)
        .map(|(cause, parameter)| format!("{} {parameter}", cause.effect).trim_end().to_owned())
        .collect();
    if !rivals.is_empty() {
        let how = one.separate_by.as_ref().map_or(String::new(), |how| format!(", separated by: {how}"));
        out.push(format!("  not separable from {}{how}", rivals.join(", ")));
    }
    let needs = match one.candidate.cause.effect {
        EffectKind::Load => {
            Some("nothing is corrected without the weight on the table (--load, or a state file)".to_owned())
        }
        _ if one.candidate.cause.correctable == Correctable::Live => {
            let sensor = one.candidate.sensor.as_deref().unwrap_or_default();
            Some(format!(
                "nothing is corrected without a reading of {} (--state)",
                sensor.strip_suffix("_C").unwrap_or(sensor)
            ))
        }
        _ => None,
    };
    out.extend(needs.map(|needs| format!("  {needs}")));
    if !fitted.is_empty() {
        let all = fitted.iter().map(|(name, value, u95, unit)| format!("{name} {value:.4e} ± {u95:.1e} {unit}"));
        out.push(format!("  fitted again together with the others (95 %): {}", all.collect::<Vec<_>>().join(", ")));
    }
    for change in changes {
        if let Change::Shape { u95, kind, .. } = change {
            let all: Vec<f64> = u95.iter().flatten().copied().collect();
            let most = all.iter().copied().fold(0.0, f64::max);
            let what = if all.len() <= VALUES {
                all.iter().map(|value| format!("{value:.2}")).collect::<Vec<_>>().join(", ")
            } else {
                format!("{most:.2} at most")
            };
            out.push(format!("  ± of the values of the {kind} (95 %): {what}"));
        }
    }
    out
}

/// The line on a cause that the file does not hold.
#[must_use]
pub fn left_out(one: &AcceptedCause, why: &str) -> String {
    format!("{LEFT_OUT} {}: {}", size(one), why.trim()).replace(char::is_control, " ")
}

/// A text without the lines on causes that were not added: those of an earlier diagnosis.
#[must_use]
pub fn without_left_out(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    text.split_inclusive('\n').filter(|line| !line.starts_with(LEFT_OUT)).for_each(|line| out.push_str(line));
    out
}
