//! Machine and its errors as a page for people.

use std::fmt::Write as _;

use ncfix_base::geometry::{AXES, Vector};
use ncfix_machine::machine::{AxisData, Machine, MeasuredRanges};
use ncfix_model::uncertainty::{UncertainParameter, unknown_of};
use ncfix_model::volume_shares::volume_shares;
use ncfix_model::{Effect, ErrorModel};

use super::number::significant;

/// Smaller standard uncertainties are written with a power of ten.
const LEAST_DECIMAL: f64 = 0.01;

/// Returns the page: chain, axes, zero offsets, tools, error functions. Lengths in mm, angles in degrees.
#[must_use]
pub fn table(machine: &Machine, errors: &ErrorModel) -> String {
    let mut out = String::new();
    // Writing into a String cannot fail.
    let mut line = |text: &str| {
        let _ = writeln!(out, "{}", text.trim_end());
    };
    line(&format!("machine     {}", machine.name));
    line(&format!("topology    {}", machine.topology));
    line(&format!("controller  {}", machine.controller));
    let control = &machine.control;
    line(&format!(
        "increment   {} mm, {} deg",
        decimal(control.increment_mm),
        decimal(control.increment_rad.to_degrees())
    ));
    if !machine.active_tables.files.is_empty() {
        let who = if machine.active_tables.is_offline { "added to programs" } else { "active in the control" };
        line(&format!("tables      {who}: {}", machine.active_tables.files.join(", ")));
    }
    line("");
    line("axis  travel                 direction in F");
    for axis in AXES.into_iter().filter_map(|axis| machine.axis(axis)) {
        let [x, y, z] = [0, 1, 2].map(|row| decimal(axis.direction[row]));
        line(&format!("{:<6}{:<23}{x} {y} {z}", char::from(axis.axis.letter()), travel(axis)));
    }
    if !machine.heads.is_empty() {
        line("");
        line("head              words         gauge point            axis");
        let shown = machine.heads.len().min(if machine.has_fixed_head { 1 } else { usize::MAX });
        for (index, head) in machine.heads.iter().take(shown).enumerate() {
            let of = |vector: &Vector| [0, 1, 2].map(|row| decimal(vector[row])).join(" ");
            let note = if index == 0 && !machine.has_fixed_head { "  at the start" } else { "" };
            let (origin, axis) = (of(&head.spindle.origin_mm), of(&head.spindle.axis));
            line(&format!("{:<18}{:<14}{origin:<23}{axis}{note}", head.name, head.words()));
        }
    }
    if !machine.zero_offsets.is_empty() {
        line("");
        line("zero offset");
        let longest = machine.zero_offsets.keys().map(|name| machine.shown_offset(name).len()).max();
        let width = longest.unwrap_or_default().max(5) + 1;
        for (name, offset) in &machine.zero_offsets {
            let name = machine.shown_offset(name);
            let shift = offset.shift();
            let mut parts: Vec<String> = AXES
                .into_iter()
                .filter(|&axis| machine.axis(axis).is_some())
                .map(|axis| {
                    let value = if axis.is_rotary() { shift[axis].to_degrees() } else { shift[axis] };
                    format!("{}{}", char::from(axis.letter()), decimal(value))
                })
                .collect();
            let listed = |values: [f64; 3]| values.map(decimal).join(" ");
            if offset.rotation != [0.0; 3] {
                parts.push(format!("rotated {} deg", listed(offset.rotation.map(f64::to_degrees))));
            }
            if offset.scale != [1.0; 3] {
                parts.push(format!("scaled {}", listed(offset.scale)));
            }
            for (letter, _) in ["X", "Y", "Z"].iter().zip(offset.mirror).filter(|(_, mirror)| *mirror) {
                parts.push(format!("mirrored {letter}"));
            }
            line(&format!("{name:<width$}{}", parts.join(" ")));
        }
    }
    if !machine.tools.is_empty() {
        line("");
        line("tool  edge  length       radius   name");
        for tool in &machine.tools {
            let [length, radius] = [tool.length_mm[0], tool.radius_mm].map(decimal);
            let name = tool.name.as_deref().unwrap_or("");
            line(&format!("{:<6}{:<6}{length:<13}{radius:<9}{name}", tool.number, tool.edge));
        }
    }
    let names = machine.heads.iter().map(|head| head.name.as_str());
    for (name, errors) in names.zip(&errors.heads) {
        line("");
        line(&format!("error source                with the head {name}"));
        source_rows(errors).iter().for_each(|row| line(row));
    }
    if errors.heads.is_empty() {
        line("");
        line("error source                data");
        source_rows(errors).iter().for_each(|row| line(row));
        share_rows(machine, errors).iter().for_each(|row| line(row));
    }
    let sensors = errors.sensors();
    if !sensors.is_empty() {
        line("");
        line("sensor                      reference");
        for sensor in sensors {
            let reference_c =
                machine.sensor_references_c.get(sensor).copied().unwrap_or(machine.reference_temperature_c);
            line(&format!("{sensor:<28}{} °C", decimal(reference_c)));
        }
    }
    if let Some(measured) = &machine.measured {
        line("");
        line("measured");
        measured_rows(measured).iter().for_each(|row| line(row));
    }
    if errors.effects().next().is_some() {
        line("");
        uncertainty_rows(machine, errors).iter().for_each(|row| line(row));
    }
    if let Some(strain) = &machine.strain {
        line("");
        line(&format!("strain      a gauge along {}", strain.axis));
    }
    if !machine.load_sensors.is_empty() {
        let names: Vec<&str> = machine.load_sensors.iter().map(|sensor| sensor.name.as_str()).collect();
        line("");
        line(&format!("load        by {}", names.join(", ")));
    }
    out
}

/// Formats the error sources, a row for each.
fn source_rows(errors: &ErrorModel) -> Vec<String> {
    let mut rows = Vec::new();
    for source in errors.sources() {
        let mut labels: Vec<String> = errors.effects_of(source.name).map(Effect::label).collect();
        labels.sort_unstable();
        labels.dedup();
        let count = labels.len();
        rows.push(format!("{:<12}{:<34}{count:>3}: {}", source.name, source.title, labels.join(" ")));
    }
    if rows.is_empty() {
        rows.push("none".to_owned());
    }
    rows
}

/// Formats the shares of the groups of axes in the tip error, a row for each; none with a single group.
fn share_rows(machine: &Machine, errors: &ErrorModel) -> Vec<String> {
    let length_mm = machine.tools.iter().map(|tool| tool.length_mm[0].abs()).fold(0.0, f64::max);
    let groups = volume_shares(machine, errors, &(-machine.spindle.axis * length_mm));
    if groups.len() < 2 {
        return Vec::new();
    }
    let mut rows = vec![
        String::new(),
        format!("share of the tip error over the travel, each alone; tool {} mm", decimal(length_mm)),
    ];
    for group in groups {
        let axes: String = group.axes.iter().map(|axis| format!(" {axis}")).collect();
        let name = format!("{}{axes}", group.name);
        rows.push(format!("{name:<26}{:>9} µm  {:>4.0} %", significant(group.mean_um), 100.0 * group.share));
    }
    rows
}

/// Formats the measured ranges, a row for each.
fn measured_rows(measured: &MeasuredRanges) -> Vec<String> {
    let mut rows = Vec::new();
    let mut row = |name: &str, text: &str| rows.push(format!("{name:<12}{text}"));
    let range = |[low, high]: [f64; 2], unit: &str| format!("{} … {} {unit}", decimal(low), decimal(high));
    for (axis, &ends) in &measured.axes {
        let (ends, unit) = if axis.is_rotary() { (ends.map(f64::to_degrees), "deg") } else { (ends, "mm") };
        row(&axis.to_string(), &range(ends, unit));
    }
    if let Some(ends) = measured.tool_length_mm {
        row("tool length", &range(ends, "mm"));
    }
    for (sensor, &ends) in &measured.temperatures_c {
        row(sensor, &range(ends, "°C"));
    }
    if let Some(ends) = measured.load_n {
        row("load", &range(ends, "N"));
    }
    if let Some(date) = &measured.date {
        row("date", date);
    }
    if !measured.instruments.is_empty() {
        row("instruments", &measured.instruments.join(", "));
    }
    if let Some(names) = measured.not_shown.as_ref().filter(|names| !names.is_empty()) {
        row("not shown", &names.join(", "));
    }
    if let Some(residual_um) = measured.residual_um {
        row("residual", &format!("{} µm of the held-out data", decimal(residual_um)));
    }
    rows
}

/// Formats the standard uncertainties, a row for each, and the errors without one.
fn uncertainty_rows(machine: &Machine, errors: &ErrorModel) -> Vec<String> {
    let Some(uncertainty) = &machine.uncertainty else {
        return vec!["uncertainty not known: the machine file does not state it".to_owned()];
    };
    let mut rows = vec!["uncertainty (standard, k = 1)".to_owned()];
    for (name, row) in &uncertainty.rows {
        let sigma = row.sigma();
        // Coefficients are in mm and rad per power.
        let size = if sigma < LEAST_DECIMAL { format!("{sigma:.2e}") } else { significant(sigma) };
        let unit = UncertainParameter::find(name, errors).map_or_else(String::new, |one| one.file_unit());
        rows.push(format!("{name:<12}± {size} {unit}").trim_end().to_owned());
    }
    if uncertainty.is_correlated() {
        rows.push(format!(
            "correlated  the parameters share {} independent sources of uncertainty",
            uncertainty.causes()
        ));
    }
    if let Some(um) = uncertainty.unexplained_um {
        rows.push(format!(
            "unexplained {} µm RMS: scatter of the readings that neither model nor instruments explain",
            decimal(um)
        ));
    }
    let unknown = unknown_of(errors, uncertainty);
    if !unknown.is_empty() {
        rows.push(format!("not known    {}", unknown.join(", ")));
    }
    rows
}

/// Formats the lowest and highest position of an axis.
fn travel(axis: &AxisData) -> String {
    let unit = if axis.axis.is_rotary() { "deg" } else { "mm" };
    match axis.travel {
        None => "not limited".into(),
        Some(limits) => {
            let [low, high] =
                limits.map(|limit| decimal(if axis.axis.is_rotary() { limit.to_degrees() } else { limit }));
            format!("{low} … {high} {unit}")
        }
    }
}

/// Formats a number with up to six decimals, without trailing zeros.
pub(super) fn decimal(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::decimal;

    #[test]
    fn decimals_are_short() {
        assert_eq!(decimal(0.0001), "0.0001");
        assert_eq!(decimal(-1e-9), "0");
        assert_eq!(decimal(350.0), "350");
        assert_eq!(decimal(-0.123_456_78), "-0.123457");
    }
}
