//! The errors that the tables of a control remove, as entries of a machine file.
//!
//! A correction δ of axis o over the position of axis i cancels an error e of the body of i along the axis o. To the first order the tool moves
//! relative to the workpiece by s·d·δ, with d the direction of o in F and s = +1 for an axis that carries the tool, −1 for one that carries the
//! workpiece; the error moves it by s′·e with the sign s′ of i. So e = −(s/s′)·d·δ. Error functions are taken as they are.

use crate::tables::{ErrorTables, Lookup, Sense, Tables};
use ncfix_base::geometry::{Axis, LINEAR_AXES};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::edit::{Edit, Given};
use ncfix_model::ErrorName;
use ncfix_model::name::{DIRECTIONS, Direction};

/// Values below this have no effect, mm or rad: a hundredth of a nanometer.
const NOTHING: f64 = 1e-8;
/// Largest deviation of an axis from the direction of its letter.
const ALIGNED: f64 = 1e-9;
/// Digits of written positions and values: below the resolution of every format.
const DECIMALS: i32 = 7;

/// The text of a machine file with the errors that the tables remove, and the number of errors.
///
/// # Errors
/// The reason, if the tables state no errors of single axes, or the text is not TOML.
pub fn machine_text(text: &str, machine: &Machine, tables: &Tables) -> Result<(String, usize), String> {
    let mut edit = Edit::parse(text).ok_or("the machine file is not TOML")?;
    if tables.grid.is_some() {
        return Err("a grid of corrections is the sum of the errors of three axes, which cannot be told apart from it; measure the axes".into());
    }
    let mut lookups = tables.lookups.clone();
    lookups.extend(of_matrix(machine, tables)?);
    let mut count = 0;
    let mut pairs: Vec<(Axis, Axis)> = Vec::new();
    for one in lookups.iter().filter(|one| one.is_enabled) {
        if one.factor.is_some() {
            return Err("products of tables are errors of several axes; tables of single axes can be converted".into());
        }
        if !pairs.contains(&(one.input, one.output)) {
            pairs.push((one.input, one.output));
        }
    }
    for (input, output) in pairs {
        let name = name_of(input, output)?;
        let factor = factor(machine, input, output)?;
        let own: Vec<&Lookup> =
            lookups.iter().filter(|one| one.is_enabled && one.input == input && one.output == output).collect();
        if own.iter().any(|one| one.modulo != own[0].modulo) {
            return Err(format!("some tables of {output} over {input} repeat, and others do not"));
        }
        let positions = positions_of(&own);
        let sided = |sense: Sense| -> Vec<f64> {
            let value = |at: f64| {
                let all = own.iter().filter(|one| one.sense == Sense::Both || one.sense == sense);
                let sum: f64 = all.map(|one| one.value(at)).sum();
                factor * if output.is_rotary() { sum.to_radians() } else { sum }
            };
            positions.iter().map(|&at| value(at)).collect()
        };
        let (up, down) = (sided(Sense::Positive), sided(Sense::Negative));
        let mean: Vec<f64> = up.iter().zip(&down).map(|(up, down)| f64::midpoint(*up, *down)).collect();
        let reversal: Vec<f64> = up.iter().zip(&down).map(|(up, down)| up - down).collect();
        for (kind, values) in [("table", mean), ("backlash", reversal)] {
            if values.iter().any(|value| value.abs() > NOTHING) {
                push(&mut edit, name, kind, &positions, &values)?;
                count += 1;
            }
        }
    }
    if let Some(errors) = &tables.errors {
        count += functions(&mut edit, errors)?;
    }
    Ok((edit.text(), count))
}

/// The component of an axis that a correction of another one cancels.
fn name_of(input: Axis, output: Axis) -> Result<ErrorName, String> {
    let index = output.dimension() + if output.is_rotary() { 3 } else { 0 };
    let direction: Direction = DIRECTIONS[index];
    if output.is_rotary() && output != input {
        return Err(format!("a correction of {output} over {input} is no error of one axis"));
    }
    if input.is_rotary() && !output.is_rotary() {
        return Err(format!(
            "a correction of {output} over {input} also depends on the place of the workpiece or the length of the tool"
        ));
    }
    Ok(ErrorName::motion(direction, input))
}

/// The error per correction.
fn factor(machine: &Machine, input: Axis, output: Axis) -> Result<f64, String> {
    let [from, to] = [input, output].map(|axis| machine.axis(axis).ok_or(axis));
    let missing = |axis: Axis| format!("the machine has no axis {axis}");
    from.map_err(missing)?;
    let direction = to.map_err(missing)?.direction;
    let along = direction[output.dimension()];
    if (along.abs() - 1.0).abs() > ALIGNED {
        return Err(format!("{output} is not parallel to the axis of F with its letter"));
    }
    let side = |axis: &Axis| if machine.topology.workpiece.contains(axis) { -1.0 } else { 1.0 };
    Ok(-side(&output) / side(&input) * along)
}

/// The positions of all points of some tables.
fn positions_of(tables: &[&Lookup]) -> Vec<f64> {
    let mut all: Vec<f64> =
        tables.iter().flat_map(|one| (0..one.nodes.count()).map(|index| one.nodes.position(index))).collect();
    all.retain(|position| position.is_finite());
    all.sort_by(f64::total_cmp);
    all.dedup_by(|next, last| *next - *last < NOTHING);
    all
}

/// A matrix as tables over the travel of the axes.
fn of_matrix(machine: &Machine, tables: &Tables) -> Result<Vec<Lookup>, String> {
    let mut out = Vec::new();
    for (row, output) in tables.matrix.iter().flatten().zip(&LINEAR_AXES[..3]) {
        for (column, input) in LINEAR_AXES[..3].iter().enumerate() {
            let slope = row[column] - f64::from(u8::from(input == output));
            if slope == 0.0 {
                continue;
            }
            let travel = machine.axis(*input).and_then(|axis| axis.travel);
            let [low, high] = travel.ok_or(format!("axis {input} has no travel; write its travel_mm"))?;
            let nodes = crate::tables::Nodes::At(vec![low, high]);
            out.push(Lookup::added(*input, *output, nodes, vec![slope * low, slope * high]));
        }
    }
    Ok(out)
}

/// The error functions and location errors of a control's own kinematics.
fn functions(edit: &mut Edit, errors: &ErrorTables) -> Result<usize, String> {
    let mut count = 0;
    for one in &errors.axes {
        for direction in DIRECTIONS {
            let values: Vec<f64> = one.values.iter().map(|row| row[direction.index()]).collect();
            if values.iter().any(|value| value.abs() > NOTHING) {
                push(edit, ErrorName::motion(direction, one.axis), "table", &one.positions, &values)?;
                count += 1;
            }
        }
    }
    for (name, value) in &errors.location {
        let is_rotation = name.direction.is_rotation();
        let given = Given::Number(tidy(if is_rotation { urad_from_rad(*value) } else { um_from_mm(*value) }));
        if !edit.set("location", &name.to_string(), &given) {
            return Err("the section [location] of the machine file cannot be changed".into());
        }
        count += 1;
    }
    Ok(count)
}

/// A number without conversion noise in its digits.
fn tidy(value: f64) -> f64 {
    let scale = 10_f64.powi(DECIMALS);
    (value * scale).round() / scale + 0.0
}

/// Adds an error, values in mm or rad, positions in mm or degrees.
fn push(edit: &mut Edit, name: ErrorName, kind: &str, positions: &[f64], values: &[f64]) -> Result<(), String> {
    let is_rotary = name.axis().is_some_and(|axis| axis.is_rotary());
    let is_rotation = name.direction.is_rotation();
    let unit = |value: &f64| tidy(if is_rotation { urad_from_rad(*value) } else { um_from_mm(*value) });
    let positions_key = if is_rotary { "positions_deg" } else { "positions_mm" };
    let values_key = if is_rotation { "values_urad" } else { "values_um" };
    let entries = [
        ("component".to_owned(), Given::Text(name.to_string())),
        ("kind".to_owned(), Given::Text(kind.to_owned())),
        (positions_key.to_owned(), Given::Numbers(positions.iter().map(|at| tidy(*at)).collect())),
        (values_key.to_owned(), Given::Numbers(values.iter().map(unit).collect())),
    ];
    let is_done = edit.push("motion", &entries);
    is_done.then_some(()).ok_or_else(|| "the list [[motion]] of the machine file cannot be changed".to_owned())
}
