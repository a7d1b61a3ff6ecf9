//! Sheets as pairs of text: the table and its description.

use super::fault::Values;
use super::machine::{DIRECTIONS, LETTERS, Machine};
use super::row::{Column, Kind, Sheet};

/// A number with some decimals, without zeros behind.
fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// The table.
pub(crate) fn csv(machine: &Machine, sheet: &Sheet, values: &Values) -> String {
    let axes = machine.axes();
    let has = |column| sheet.columns.contains(&column);
    let reads = ["dx_um", "dy_um", "dz_um"];
    let mut head: Vec<String> = axes.iter().map(|&axis| LETTERS[axis].to_owned()).collect();
    head.extend(axes.iter().map(|&axis| format!("{}_dir", LETTERS[axis])));
    head.extend(["tool_x_mm", "tool_y_mm", "tool_z_mm", "setup", "run"].map(str::to_owned));
    let more = [
        (Column::Time, &["t_s"][..]),
        (Column::Feed, &["feed_mm_min"]),
        (Column::Speed, &["spindle_rpm"]),
        (Column::Load, &["load_N", "load_x_mm", "load_y_mm"]),
        (Column::Spindle, &["spindle_deg"]),
    ];
    for (column, names) in more {
        if has(column) {
            head.extend(names.iter().map(|&name| name.to_owned()));
        }
    }
    if let Some(climate) = &sheet.climate {
        head.extend(climate.names.iter().map(|name| format!("{name}_C")));
    }
    match sheet.kind {
        Kind::Displacement => head.extend((0..3).filter(|&k| sheet.reads[k]).map(|k| reads[k].to_owned())),
        Kind::Ballbar => head.push("dr_um".into()),
        Kind::Probe => head.push("target".into()),
        Kind::Direct => head.extend(["component".into(), format!("value_{}", sheet.unit())]),
    }
    let mut out = head.join(",");
    out.push('\n');
    for (index, (row, reading)) in sheet.rows.iter().zip(&values.readings).enumerate() {
        let mut cells = Vec::with_capacity(head.len());
        for &axis in &axes {
            let is_probed = axis < 3 && sheet.kind == Kind::Probe;
            let q = if is_probed {
                reading[axis]
            } else if axis < 3 {
                row.q[axis]
            } else {
                row.q[axis].to_degrees()
            };
            cells.push(number(q, 6));
        }
        cells.extend(axes.iter().map(|&axis| number(row.dir[axis], 0)));
        cells.extend(row.tool.iter().map(|&value| number(value, 4)));
        cells.extend([sheet.setups[row.setup].label.clone(), row.run.clone()]);
        if has(Column::Time) {
            cells.push(number(row.t - row.began, 4));
        }
        if has(Column::Feed) {
            cells.push(number(row.feed, 3));
        }
        if has(Column::Speed) {
            cells.push(number(row.rpm, 0));
        }
        if has(Column::Load) {
            cells.extend([row.load, row.load_at[0], row.load_at[1]].map(|value| number(value, 2)));
        }
        if has(Column::Spindle) {
            cells.push(number(row.spindle.to_degrees(), 3));
        }
        cells.extend(values.sensors.iter().map(|sensor| sensor[index].map_or(String::new(), |value| number(value, 3))));
        match sheet.kind {
            Kind::Probe => cells.push(format!("b{}", row.target + 1)),
            Kind::Direct => {
                let [direction, axis] = row.component;
                cells.extend([format!("E{}{}", DIRECTIONS[direction], LETTERS[axis]), number(reading[0], 4)]);
            }
            _ => cells.extend((0..3).filter(|&k| sheet.reads[k]).map(|k| number(reading[k], 4))),
        }
        out += &cells.join(",");
        out.push('\n');
    }
    out
}

/// The description.
pub(crate) fn toml(sheet: &Sheet) -> String {
    let free: Vec<String> = sheet.free.iter().map(|word| format!("\"{word}\"")).collect();
    let sigma = number(sheet.sigma * if sheet.angles { 1e6 } else { 1e3 }, 4);
    let mut out = format!(
        "[measurement]\nkind = \"{}\"\nsigma_{} = {sigma}\nfree = [{}]\n",
        sheet.kind.word(),
        sheet.unit(),
        free.join(", ")
    );
    // These lines are exact: their slopes are those of the machine.
    if sheet.kind == Kind::Direct && !sheet.angles {
        out += "reference = \"square\"\n";
    }
    for setup in sheet.setups.iter().filter(|_| sheet.kind == Kind::Ballbar) {
        let [x, y, z] = setup.centre.map(|value| number(value, 4));
        let length = number(setup.length, 4);
        out += &format!("\n[setup.{}]\ncentre_mm = [{x}, {y}, {z}]\nlength_mm = {length}\n", setup.label);
    }
    out
}
