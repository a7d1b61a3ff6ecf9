//! A plan as the pair of files of a measurement, with empty readings.

use std::fmt::Write as _;

use crate::measure::data::{FEATURE_COLUMNS, MOVED, TURNED};
use crate::measure::kind::{self, Measurand, NOT_READ};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_model::name::Direction;

use super::builder::{Builder, Extra, PlannedFeature};

/// Decimals of positions, mm and degrees.
const DECIMALS: usize = 6;

/// The table.
#[must_use]
pub fn csv(plan: &Builder) -> String {
    let data = &plan.data;
    let axes: Vec<Axis> = AXES.into_iter().filter(|&axis| plan.machine.axis(axis).is_some()).collect();
    let has = |of: fn(&Extra) -> bool| plan.extras.iter().any(of);
    let [feature, run, time, speed, feed, load, moved, turned] = [
        has(|extra| extra.feature.is_some()),
        has(|extra| !extra.run.is_empty()),
        has(|extra| extra.time_s.is_some()),
        has(|extra| extra.speed.is_some()),
        has(|extra| extra.feed.is_some()),
        has(|extra| extra.load.is_some()),
        has(|extra| extra.moved_um.is_some()),
        has(|extra| extra.moved_urad.is_some()),
    ];
    let measurand = data.kind.measurand;
    let mut header: Vec<String> = Vec::new();
    let mut named = |is_there: bool, column: &str| {
        if is_there {
            header.push(column.to_owned());
        }
    };
    for column in FEATURE_COLUMNS {
        named(feature, column);
    }
    named(run, "run");
    named(true, "setup");
    named(measurand == Measurand::BallPlace, "target");
    named(measurand == Measurand::Component, "component");
    named(time, "t_s");
    for axis in &axes {
        named(true, &axis.to_string());
    }
    for axis in &axes {
        named(true, &format!("{axis}_dir"));
    }
    for column in ["tool_x_mm", "tool_y_mm", "tool_z_mm"] {
        named(true, column);
    }
    named(feed, "feed_mm_min");
    named(speed, "spindle_rpm");
    for column in ["load_N", "load_x_mm", "load_y_mm", "load_z_mm"] {
        named(load, column);
    }
    named(moved, MOVED);
    named(turned, TURNED);
    let readings = readings(plan);
    for column in &readings {
        named(true, column);
    }
    let mut out = header.join(",");
    out.push('\n');
    for (row, extra) in data.observations.iter().zip(&plan.extras) {
        let mut cells: Vec<String> = Vec::new();
        if feature {
            cells.extend(extra.feature.as_ref().map_or_else(Default::default, feature_cells));
        }
        if run {
            cells.push(extra.run.clone());
        }
        cells.push(data.setups.get(row.setup).map_or_else(String::new, |setup| setup.label.clone()));
        if measurand == Measurand::BallPlace {
            cells.push(row.target.and_then(|target| data.targets.get(target)).cloned().unwrap_or_default());
        }
        if measurand == Measurand::Component {
            cells.push(row.component.map_or_else(String::new, |component| component.to_string()));
        }
        if time {
            cells.push(extra.time_s.map_or_else(String::new, number));
        }
        let position = |axis: &Axis| {
            let value = row.reading.position[*axis];
            number(if axis.is_rotary() { value.to_degrees() } else { value })
        };
        cells.extend(axes.iter().map(position));
        cells.extend(axes.iter().map(|&axis| row.reading.state.direction(axis).to_string()));
        cells.extend(row.reading.tool_mm.iter().copied().map(number));
        if feed {
            cells.push(extra.feed.map_or_else(String::new, number));
        }
        if speed {
            cells.push(extra.speed.map_or_else(String::new, number));
        }
        if load {
            let (force_n, place_mm) = extra.load.unwrap_or_default();
            cells.push(number(force_n));
            cells.extend(place_mm.iter().copied().map(number));
        }
        if moved {
            cells.push(extra.moved_um.map_or_else(String::new, number));
        }
        if turned {
            cells.push(extra.moved_urad.map_or_else(String::new, number));
        }
        let reads = plan.reads_of(extra);
        let is_left_out = |column: &&str| {
            let own = data.kind.columns.iter().position(|known| known == column);
            measurand == Measurand::Displacement && own.and_then(|k| reads.get(k)) == Some(&false)
        };
        cells.extend(readings.iter().map(|column| if is_left_out(column) { NOT_READ } else { "" }.to_owned()));
        out.push_str(&cells.join(","));
        out.push('\n');
    }
    out
}

/// The cells of [`FEATURE_COLUMNS`].
fn feature_cells(feature: &PlannedFeature) -> [String; 5] {
    let [x, y, z] = [feature.nominal_mm.x, feature.nominal_mm.y, feature.nominal_mm.z].map(number);
    [feature.name.clone(), feature.level.to_string(), x, y, z]
}

/// The columns for readings.
fn readings(plan: &Builder) -> Vec<&'static str> {
    let of = |wanted: bool| {
        let components = plan.data.observations.iter().filter_map(|row| row.component);
        components.into_iter().any(|component| (component.direction >= Direction::A) == wanted)
    };
    match plan.data.kind.measurand {
        Measurand::BallDistance | Measurand::LineLength => plan.data.kind.columns.to_vec(),
        Measurand::Displacement => {
            let columns = plan.data.kind.columns.iter().copied().zip(plan.reads);
            columns.filter(|(_, is_read)| *is_read).map(|(column, _)| column).collect()
        }
        Measurand::Component => {
            let columns = [("value_um", of(false)), ("value_urad", of(true))];
            columns.into_iter().filter(|(_, is_read)| *is_read).map(|(column, _)| column).collect()
        }
        _ => Vec::new(),
    }
}

/// The description.
#[must_use]
pub fn toml(plan: &Builder) -> String {
    let data = &plan.data;
    let free: Vec<String> = data.free.iter().map(|&free| format!("\"{}\"", kind::word(free))).collect();
    let mut out = format!("[measurement]\nkind = \"{}\"\n", data.kind.name);
    // Writing into a String cannot fail.
    if !free.is_empty() {
        let _ = writeln!(out, "free = [{}]", free.join(", "));
    }
    if let Some(head) = &data.head {
        let _ = writeln!(out, "head = {head:?}");
    }
    if data.kind.measurand == Measurand::BallDistance {
        for setup in &data.setups {
            let [x, y, z] = [setup.centre_mm.x, setup.centre_mm.y, setup.centre_mm.z].map(number);
            let length = number(setup.length_mm);
            let _ = writeln!(out, "\n[setup.{}]\ncentre_mm = [{x}, {y}, {z}]\nlength_mm = {length}", setup.label);
        }
    }
    for setup in &data.setups {
        if let Some([x, y, z]) = setup.direction.map(|direction| [direction.x, direction.y, direction.z].map(number)) {
            let _ = writeln!(out, "\n[setup.{}]\ndirection = [{x}, {y}, {z}]", setup.label);
        }
    }
    out
}

/// A number without trailing zeros.
fn number(value: f64) -> String {
    let text = format!("{value:.DECIMALS$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}
