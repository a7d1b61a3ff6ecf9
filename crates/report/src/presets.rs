//! Presets as pages for people: the list, and the content of one preset for a machine.

use std::fmt::Write as _;

use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::Machine;
use ncfix_model::preset::{PRESETS, Preset, Rest, Unsuitable, rest};
use ncfix_model::{ErrorModel, ParameterName};

/// Lists the presets with description and source; for a machine also the number of parameters, or why the preset does not fit.
#[must_use]
pub fn list(machine: Option<&Machine>) -> String {
    let mut out = String::from(if machine.is_some() { "preset    parameters  " } else { "preset    " });
    out.push_str("what it has\n");
    for preset in PRESETS {
        // Writing into a String cannot fail.
        let _ = write!(out, "{:<10}", preset.name);
        let indent = if machine.is_some() { 22 } else { 10 };
        let parameters = machine.map(preset.parameters);
        match &parameters {
            None => {}
            Some(Ok(parameters)) => {
                let _ = write!(out, "{:>10}  ", parameters.len());
            }
            Some(Err(_)) => out.push_str("         -  "),
        }
        let _ = writeln!(out, "{}\n{:indent$}{}", preset.title, "", preset.source);
        if let Some(Err(Unsuitable(reason))) = parameters {
            let _ = writeln!(out, "{:indent$}not applicable: {reason}", "");
        }
    }
    out
}

/// Returns the parameters of a preset with their values in a machine file, and further content of the file. With the errors of a later calibration,
/// such as with compensation, also those, the ratio of the values (Esmaeili 2021, Table 7-2), and the share of the size that was removed (eq. 38).
#[must_use]
pub fn page(
    preset: &Preset,
    parameters: &[ParameterName],
    machine: &Machine,
    errors: &ErrorModel,
    after: Option<&ErrorModel>,
) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "preset      {}: {}", preset.name, preset.title);
    let _ = writeln!(out, "source      {}", preset.source);
    let _ = writeln!(out, "machine     {}, {}", machine.name, machine.topology);
    let _ = writeln!(out, "parameters  {}\n", parameters.len());
    if let Some(after) = after {
        out.push_str(&changes(parameters, [errors, after]));
        return out;
    }
    let _ = writeln!(out, "parameter         value  unit");
    for parameter in parameters {
        line(&mut out, parameter, errors);
    }
    let others = rest(errors, parameters);
    if others.is_empty() {
        out.push_str("\nThe file has no other errors.\n");
        return out;
    }
    out.push_str("\nThe file also has:\n");
    for other in &others {
        match other {
            Rest::Parameter(parameter) => line(&mut out, parameter, errors),
            Rest::Function(component, kind) => {
                let _ = writeln!(out, "{component:<10}{:>13}  {kind}", "");
            }
            Rest::Source(title) => {
                let _ = writeln!(out, "{title}");
            }
        }
    }
    out
}

/// Returns the parameters before and after: the ratio of the values, and the share of the size that was removed.
fn changes(parameters: &[ParameterName], both: [&ErrorModel; 2]) -> String {
    let mut out = String::from("parameter        before        after  unit            ratio   removed\n");
    for parameter in parameters {
        let [(before, unit), (after, _)] = both.map(|errors| in_micro(parameter, parameter.get(errors)));
        let (ratio, removed) = if before == 0.0 {
            ("–".to_owned(), "–".to_owned())
        } else {
            let removed = 100.0 * (before.abs() - after.abs()) / before.abs();
            (format!("{:.2}", after / before), format!("{removed:.0} %"))
        };
        let (name, before, after) = (parameter.to_string(), number(before), number(after));
        let _ = writeln!(out, "{name:<10}{before:>13}{after:>13}  {unit:<10}{ratio:>10}{removed:>10}");
    }
    out
}

/// Writes one parameter with its value.
fn line(out: &mut String, parameter: &ParameterName, errors: &ErrorModel) {
    let (value, unit) = in_micro(parameter, parameter.get(errors));
    // The name as text, so that it is padded.
    let _ = writeln!(out, "{:<10}{:>13}  {unit}", parameter.to_string(), number(value));
}

/// Returns a value and its unit with µm instead of mm and µrad instead of rad; positions stay in mm and rad.
fn in_micro(parameter: &ParameterName, value: f64) -> (f64, String) {
    let unit = parameter.unit();
    match unit.strip_prefix("mm") {
        Some(rest) => (um_from_mm(value), format!("µm{rest}")),
        None => (urad_from_rad(value), format!("µ{unit}")),
    }
}

/// Formats four significant digits.
fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    match value.abs() {
        size if size >= 1e6 => format!("{value:.3e}"),
        size if size >= 99.995 => format!("{value:.1}"),
        size if size >= 9.9995 => format!("{value:.2}"),
        size if size >= 0.099_995 => format!("{value:.3}"),
        _ => format!("{value:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 7-2 of Esmaeili 2021: EZOS 55.6 → -7.4 µm is a ratio of -0.13; the removed share is (55.6 - 7.4)/55.6 = 87 %. EBOZ grows.
    #[test]
    fn the_ratio_has_the_sign_and_the_removed_share_the_sizes() {
        let [ez, eb]: [ParameterName; 2] = ["EZ0S", "EB0Z"].map(|name| name.parse().unwrap());
        let errors = |values: [f64; 2]| {
            let mut errors = ErrorModel::default();
            ez.set(&mut errors, values[0] * 1e-3);
            eb.set(&mut errors, values[1] * 1e-6);
            errors
        };
        let page = changes(&[ez, eb], [&errors([55.6, 22.0]), &errors([-7.4, 39.0])]);
        let rows: Vec<Vec<&str>> = page.lines().skip(1).map(|row| row.split_whitespace().collect()).collect();
        assert_eq!(rows[0], ["EZ0S", "55.60", "-7.400", "µm", "-0.13", "87", "%"]);
        assert_eq!(rows[1], ["EB0Z", "22.00", "39.00", "µrad", "1.77", "-77", "%"]);
    }

    #[test]
    fn values_are_in_micrometers_and_microradians() {
        let shown = |name: &str, value: f64| {
            let (value, unit) = in_micro(&name.parse().unwrap(), value);
            format!("{} {unit}", number(value))
        };
        assert_eq!(shown("EX0C", -0.0956), "-95.60 µm");
        assert_eq!(shown("EA0C", -1.2e-5), "-12.00 µrad");
        assert_eq!(shown("EXX1", 2.59e-5), "2.590e-2 µm/mm");
        assert_eq!(shown("EAB3", 5.03e-5), "50.30 µrad/rad^3");
        assert_eq!(shown("EXX2", 0.0), "0 µm/mm^2");
        assert_eq!(shown("EXX0", 12_346.0), "1.235e7 µm");
    }
}
