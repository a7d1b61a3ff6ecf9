//! Temperatures to which the lengths of measurements refer.
//!
//! Readings of a laser refer to 20 °C. An artifact or a bar with a temperature of its own shows the lengths of the machine at this temperature. If files of
//! both kinds are fitted together, their scales differ by the expansion of the machine between the two temperatures (ISO 1, ISO 230-1: reference 20 °C).

use super::measurement::Measurement;
use crate::diagnose::cause::own;
use crate::measure::data::{DataSet, Free, Observation};
use crate::measure::kind::Measurand;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::number::significant;

/// Reference temperature of direct readings, °C.
const REFERENCE_C: f64 = 20.0;
/// Difference of temperatures that does not count, K: 2 µm/m of steel.
const ALIKE_K: f64 = 0.2;
/// Expansion of steel, µm/m per K, for the size in the message.
const STEEL: f64 = 11.5;

/// Use of several files together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Together {
    /// A fit of parameters.
    Fit,
    /// A search for causes.
    Search,
}

/// Warns of measurements that show lengths at different temperatures.
pub(super) fn check<'a>(
    used: impl Iterator<Item = &'a Measurement>,
    together: Together,
    findings: &mut Vec<Diagnostic>,
) {
    let mut found: Vec<(&str, f64)> =
        used.filter_map(|one| Some((one.data.name.as_str(), reference_c(&one.data)?))).collect();
    found.sort_by(|(_, one), (_, other)| one.total_cmp(other));
    let (Some((first, low)), Some((last, high))) = (found.first(), found.last()) else { return };
    if high - low <= ALIKE_K {
        return;
    }
    let (command, verb) = match together {
        Together::Fit => ("a fit", "calibrate"),
        Together::Search => ("a search", "diagnose"),
    };
    let message = format!(
        "the lengths of {first} refer to {} °C and those of {last} to {} °C: for a machine of steel their scales differ by {} µm/m, and {command} of both mixes them",
        significant(*low),
        significant(*high),
        significant(STEEL * (high - low))
    );
    let help = format!(
        "{verb} them apart, or refer all to one temperature: beside a laser that refers to 20 °C, import the part, plate or bar with --material 20C"
    );
    findings.push(Diagnostic::nowhere(Code::REFERENCES_DIFFER, message, help));
}

/// Temperature to which the lengths of a measurement refer, °C; `None` if it shows no lengths, or states no temperature.
fn reference_c(data: &DataSet) -> Option<f64> {
    let is_free = [Free::Length, Free::Rod, Free::RodTemperature].iter().any(|one| data.free.contains(one));
    match data.kind.measurand {
        Measurand::Component => {
            let is_length = |row: &Observation| {
                row.component.is_some_and(|name| name.axis().is_some_and(|axis| !axis.is_rotary() && name == own(axis)))
            };
            data.observations.iter().any(is_length).then_some(REFERENCE_C)
        }
        Measurand::Displacement | Measurand::BallDistance if !is_free => {
            let temperatures = data.observations.iter().filter_map(|row| {
                let setup = data.setups.get(row.setup).filter(|setup| setup.expansion_per_k > 0.0)?;
                row.temperature_c.or(setup.temperature_c)
            });
            let [sum, count] = temperatures.fold([0.0, 0.0], |[sum, count], celsius| [sum + celsius, count + 1.0]);
            (count > 0.0).then(|| sum / count)
        }
        _ => None,
    }
}
