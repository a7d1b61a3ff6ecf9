//! Forward and inverse kinematics in tables: the corrections of the machine's chain, term by term (Esmaeili 2021, chapter 7).
//!
//! To the first order a correction is Σ e·c(q) over the error components e. The factor c results from the linear inverse kinematics of the linear
//! forward kinematics, and is linear in the positions of the linear axes:
//!
//! ```text
//! c(q) = c₀(R) + Σ_l q_l · c_l(R)          R: the rotary axes
//! ```
//!
//! c₀ and c_l are evaluated on the chain of any machine, never entered by hand. If they depend on one rotary axis, and location errors are constant,
//! a correction consists of functions of one axis and products of a linear axis with a function of one axis: exactly what a control can add and
//! multiply. Equal products are combined. A motion error e(q) gives products of its own axis with an arm in the same way. A dependence on two rotary
//! axes without an arm – a head that swivels about both – is a sum of a few products, which are split off one by one. A product of three axes – a
//! motion error with the arm of another axis and a function of a rotary axis – is beyond the control and uses the function at the middle of the
//! region; the check shows the residual.

use std::collections::BTreeMap;

use super::assembly::{Assembly, AxisFunction};
use super::{Holds, Scheme, Task};
use crate::tables::{Orientation, Tables};
use ncfix_base::geometry::{AXES, Axis, AxisVector, LINEAR_AXES};
use ncfix_machine::machine::State;
use ncfix_model::ErrorName;
use ncfix_model::motion::EntryFunction;

pub(super) const SCHEME: Scheme = Scheme {
    name: "fik",
    title: "the terms of the linearized forward and inverse kinematics of the machine",
    needs: &[Holds::Own, Holds::Cross, Holds::Products],
    home: Orientation::Smooth,
    finds_nodes: false,
    fill: exact,
};

/// Arm length for detecting a dependence, mm.
const ARM_MM: f64 = 100.0;
/// Relative change that counts as a dependence.
const CHANGE: f64 = 1e-9;
/// Maximum number of products of a function of two rotary axes, and the size below which a product is dropped, mm or rad.
const MOST_PRODUCTS: usize = 8;
const NOTHING: f64 = 2e-6;
/// Maximum number of position pairs of two rotary axes.
const MOST_PLACES: usize = 100_000;
/// Number of positions of a rotary axis for detecting a dependence.
const PLACES: usize = 5;

/// The correction per unit of an error component at rotary positions: at linear positions 0, and per mm of each linear axis.
#[derive(Clone, Debug)]
struct Affine {
    alone: AxisVector,
    arms: Vec<(Axis, AxisVector)>,
}

fn exact(task: &Task<'_>) -> Result<Tables, String> {
    if task.target.orientation == Orientation::Exact {
        return Err("the scheme fik needs --orientation smooth or off: the exact one has poles".to_owned());
    }
    let mut terms = Terms { task, assembly: Assembly::new(task), arms: BTreeMap::new(), planes: BTreeMap::new() };
    for (name, function, value) in task.errors.parts() {
        terms.add(name, function, value)?;
    }
    Ok(terms.finish())
}

/// A dependence of a value in addition to the arm.
struct Driver {
    axis: Axis,
    values: Vec<f64>,
}

struct Terms<'a> {
    task: &'a Task<'a>,
    assembly: Assembly<'a>,
    /// Functions of an axis that are multiplied by the position of a linear axis, by output, arm and axis.
    arms: BTreeMap<(Axis, Axis, Axis), Vec<f64>>,
    /// Dependences on two rotary axes without an arm, by output and axes: rows along the first, columns along the second.
    planes: BTreeMap<(Axis, Axis, Axis), Vec<Vec<f64>>>,
}

impl<'a> Terms<'a> {
    /// Adds the correction of one entry of the error model.
    fn add(&mut self, name: ErrorName, function: Option<&EntryFunction>, value: f64) -> Result<(), String> {
        let (factor, drivers) = match (function, name.axis()) {
            (Some(function), Some(axis)) => self.drivers(function, axis)?,
            _ => (value, Vec::new()),
        };
        let turning = self.dependence(name)?;
        let middle = self.affine(name, &self.task.region.middle())?;
        // Along each relevant rotary axis, with the others at the middle.
        let along: Vec<(Axis, Vec<Affine>)> = turning
            .iter()
            .map(|&axis| {
                let positions = self.assembly.positions(axis);
                let at = positions.iter().map(|&position| {
                    let mut pose = self.task.region.middle();
                    pose[axis] = position;
                    self.affine(name, &pose)
                });
                Ok((axis, at.collect::<Result<_, String>>()?))
            })
            .collect::<Result<_, String>>()?;
        let is_plane = drivers.is_empty() && turning.len() == 2;
        if is_plane {
            self.add_plane(name, factor, [turning[0], turning[1]])?;
        }
        for output in AXES.into_iter().filter(|&axis| self.task.target.machine.axis(axis).is_some()) {
            let of = |affine: &Affine| affine.alone[output];
            if !is_plane {
                self.put(output, None, factor, &drivers, of(&middle), &functions(&along, of));
            }
            for (index, &(arm, _)) in middle.arms.iter().enumerate() {
                let of = |affine: &Affine| affine.arms[index].1[output];
                self.put(output, Some(arm), factor, &drivers, of(&middle), &functions(&along, of));
            }
        }
        Ok(())
    }

    /// The axes on which a motion error depends and its values at their nodes; their product times the factor is the error.
    fn drivers(&self, function: &EntryFunction, axis: Axis) -> Result<(f64, Vec<Driver>), String> {
        let state = State::default();
        let mut pose = self.task.region.middle();
        let mut along = |axis_along: Axis, others: &AxisVector| -> Vec<f64> {
            pose = *others;
            let at = self.assembly.positions(axis_along);
            at.iter()
                .map(|&at| {
                    pose[axis_along] = self.task.in_turn(axis_along, at);
                    function.value(axis, &pose, &state)
                })
                .collect()
        };
        let middle = self.task.region.middle();
        match function {
            EntryFunction::Grid(_) => {
                Err(format!("a motion error of {axis} is a grid over two axes; use another scheme"))
            }
            EntryFunction::Own(own) if own.function().with().is_some() => {
                Err(format!("a motion error of {axis} depends on two axes; use another scheme"))
            }
            EntryFunction::Cross(cross) => {
                // A product of two functions is determined by a line along each through a position where it is not zero.
                let mut place = middle;
                let lines = self.assembly.positions(axis);
                let with = self.assembly.positions(cross.with);
                let mut most = 0.0_f64;
                for &own in &lines {
                    for &other in &with {
                        let mut pose = middle;
                        pose[axis] = self.task.in_turn(axis, own);
                        pose[cross.with] = self.task.in_turn(cross.with, other);
                        let value = function.value(axis, &pose, &state);
                        if value.abs() > most.abs() {
                            (most, place) = (value, pose);
                        }
                    }
                }
                if most == 0.0 {
                    return Ok((0.0, Vec::new()));
                }
                let own = Driver { axis, values: along(axis, &place) };
                let other = Driver { axis: cross.with, values: along(cross.with, &place) };
                Ok((1.0 / most, vec![own, other]))
            }
            _ => Ok((1.0, vec![Driver { axis, values: along(axis, &middle) }])),
        }
    }

    /// The rotary axes on which the correction of an error component depends.
    fn dependence(&self, name: ErrorName) -> Result<Vec<Axis>, String> {
        let mut found = Vec::new();
        let at = |axis: Axis, fraction: f64| {
            let [low, high] = self.task.region.range(axis);
            low + (high - low) * fraction
        };
        // The others are at positions without symmetry: on an upright head its other axis has no effect.
        let mut place = self.task.region.middle();
        self.task.target.rotary().for_each(|axis| place[axis] = at(axis, 0.71));
        let first = self.affine(name, &place)?;
        for axis in self.task.target.rotary() {
            let mut pose = place;
            for step in 0..PLACES {
                pose[axis] = at(axis, (step as f64 + 0.37) / PLACES as f64);
                if first.differs(&self.affine(name, &pose)?) {
                    found.push(axis);
                    break;
                }
            }
        }
        Ok(found)
    }

    fn affine(&self, name: ErrorName, rotary: &AxisVector) -> Result<Affine, String> {
        let mut pose = *rotary;
        LINEAR_AXES.into_iter().for_each(|axis| pose[axis] = 0.0);
        let alone = self.first_order(name, &pose)?;
        let mut arms = Vec::new();
        for axis in LINEAR_AXES.into_iter().filter(|&axis| self.task.target.machine.axis(axis).is_some()) {
            let mut far = pose;
            far[axis] = ARM_MM;
            let mut arm = self.first_order(name, &far)? - alone;
            arm.0.iter_mut().for_each(|value| *value /= ARM_MM);
            arms.push((axis, arm));
        }
        Ok(Affine { alone, arms })
    }

    /// Adds factor · c₀ at all pairs of positions of two rotary axes.
    fn add_plane(&mut self, name: ErrorName, factor: f64, [first, second]: [Axis; 2]) -> Result<(), String> {
        let (rows, columns) = (self.assembly.positions(first), self.assembly.positions(second));
        if rows.len() * columns.len() > MOST_PLACES {
            return Err(format!("{first} and {second} together have too many points; choose fewer --points"));
        }
        let mut pose = self.task.region.middle();
        LINEAR_AXES.into_iter().for_each(|axis| pose[axis] = 0.0);
        for (i, &row) in rows.iter().enumerate() {
            for (j, &column) in columns.iter().enumerate() {
                (pose[first], pose[second]) = (row, column);
                let correction = self.first_order(name, &pose)?;
                for output in AXES.into_iter().filter(|&axis| self.task.target.machine.axis(axis).is_some()) {
                    let plane = self.planes.entry((output, first, second));
                    let plane = plane.or_insert_with(|| vec![vec![0.0; columns.len()]; rows.len()]);
                    plane[i][j] += factor * correction[output];
                }
            }
        }
        Ok(())
    }

    fn first_order(&self, name: ErrorName, pose: &AxisVector) -> Result<AxisVector, String> {
        let correction = self.task.target.first_order(name, pose);
        correction.ok_or_else(|| "the linear axes cannot place the tip: two are parallel".to_owned())
    }

    /// Splits a function of two axes into products, the largest first, until nothing remains (adaptive cross approximation, Bebendorf 2000). The
    /// residual after a product is zero along the row and the column through its largest value.
    fn split(&mut self, output: Axis, [first, second]: [Axis; 2], mut plane: Vec<Vec<f64>>) {
        for _ in 0..MOST_PRODUCTS {
            let all = plane
                .iter()
                .enumerate()
                .flat_map(|(i, row)| row.iter().enumerate().map(move |(j, value)| (i, j, *value)));
            let Some((i, j, most)) = all.max_by(|one, other| one.2.abs().total_cmp(&other.2.abs())) else { return };
            if most.abs() < NOTHING {
                return;
            }
            let row: Vec<f64> = plane[i].iter().map(|value| value / most).collect();
            let column: Vec<f64> = plane.iter().map(|row| row[j]).collect();
            for (line, along) in plane.iter_mut().zip(&column) {
                line.iter_mut().zip(&row).for_each(|(value, across)| *value -= along * across);
            }
            // A function of one axis needs no product.
            let is_flat = |values: &[f64]| values.iter().all(|value| (value - values[0]).abs() < CHANGE);
            if is_flat(&row) {
                let values: Vec<f64> = column.iter().map(|value| value * row[0]).collect();
                self.assembly.add(output, first, &values);
            } else if is_flat(&column) {
                let values: Vec<f64> = row.iter().map(|value| value * column[0]).collect();
                self.assembly.add(output, second, &values);
            } else {
                let sides = [AxisFunction { axis: first, values: column }, AxisFunction { axis: second, values: row }];
                self.assembly.add_product(output, sides);
            }
        }
    }

    /// Adds factor · drivers · c(R), times the position of the arm if there is one.
    fn put(
        &mut self,
        output: Axis,
        arm: Option<Axis>,
        factor: f64,
        drivers: &[Driver],
        middle: f64,
        turning: &[(Axis, Vec<f64>)],
    ) {
        if factor == 0.0 || middle == 0.0 && turning.iter().all(|(_, values)| values.iter().all(|&value| value == 0.0))
        {
            return;
        }
        // All factors, each a function of one axis.
        let mut sides: Vec<AxisFunction> =
            drivers.iter().map(|driver| AxisFunction { axis: driver.axis, values: driver.values.clone() }).collect();
        let mut common = factor;
        match turning {
            [] => common *= middle,
            [(axis, values)] => sides.push(AxisFunction { axis: *axis, values: values.clone() }),
            several => {
                // Additive: each along its axis, minus the middle, which would count twice. Joint effects of two axes are not represented.
                for (index, (axis, values)) in several.iter().enumerate() {
                    let less = if index == 0 { 0.0 } else { middle };
                    let one = vec![(*axis, values.iter().map(|value| value - less).collect())];
                    self.put(output, arm, factor, drivers, middle, &one);
                }
                return;
            }
        }
        self.multiply(output, arm, common, sides);
    }

    /// Adds a product of functions, after combining those of one axis.
    fn multiply(&mut self, output: Axis, arm: Option<Axis>, common: f64, sides: Vec<AxisFunction>) {
        let mut merged: Vec<AxisFunction> = Vec::new();
        for side in sides {
            match merged.iter_mut().find(|one| one.axis == side.axis) {
                Some(one) => one.values.iter_mut().zip(&side.values).for_each(|(one, other)| *one *= other),
                None => merged.push(side),
            }
        }
        let mut arm = arm;
        if let Some(axis) = arm
            && let Some(one) = merged.iter_mut().find(|one| one.axis == axis)
        {
            let positions = self.assembly.positions(axis);
            one.values.iter_mut().zip(positions).for_each(|(value, at)| *value *= at);
            arm = None;
        }
        // More than two axes: the last ones at the middle of their tables.
        let most = if arm.is_some() { 1 } else { 2 };
        let mut common = common;
        while merged.len() > most {
            if let Some(side) = merged.pop() {
                common *= side.values.get(side.values.len() / 2).copied().unwrap_or_default();
            }
        }
        for value in merged.first_mut().into_iter().flat_map(|side| &mut side.values) {
            *value *= common;
        }
        let mut sides = merged.into_iter();
        match (arm, sides.next(), sides.next()) {
            (None, None, _) => self.assembly.add_constant(output, common),
            (None, Some(one), None) => self.assembly.add(output, one.axis, &one.values),
            (None, Some(one), Some(other)) => self.assembly.add_product(output, [one, other]),
            (Some(arm), None, _) => {
                let values: Vec<f64> = self.assembly.positions(arm).iter().map(|at| common * at).collect();
                self.assembly.add(output, arm, &values);
            }
            (Some(arm), Some(one), _) => {
                let sum = self.arms.entry((output, arm, one.axis)).or_insert_with(|| vec![0.0; one.values.len()]);
                sum.iter_mut().zip(&one.values).for_each(|(sum, value)| *sum += value);
            }
        }
    }

    fn finish(mut self) -> Tables {
        for ((output, first, second), plane) in std::mem::take(&mut self.planes) {
            self.split(output, [first, second], plane);
        }
        for ((output, arm, axis), values) in std::mem::take(&mut self.arms) {
            let [low, high] = self.task.region.range(arm);
            // The mean of the function is not a product but a table of the arm.
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            let rest: Vec<f64> = values.iter().map(|value| value - mean).collect();
            let straight: Vec<f64> = self.assembly.positions(arm).iter().map(|at| mean * at).collect();
            self.assembly.add(output, arm, &straight);
            // The arm is measured from the middle of its range, which minimizes its product.
            let middle = f64::midpoint(low, high);
            let offset: Vec<f64> = rest.iter().map(|value| value * middle).collect();
            self.assembly.add(output, axis, &offset);
            let half = (high - low) / 2.0;
            let arm = AxisFunction { axis: arm, values: vec![-half, half] };
            self.assembly.add_product(output, [arm, AxisFunction { axis, values: rest }]);
        }
        self.assembly.finish()
    }
}

impl Affine {
    fn differs(&self, other: &Affine) -> bool {
        let pairs = self.arms.iter().zip(&other.arms).map(|((_, one), (_, other))| (one, other, ARM_MM));
        let mut all = pairs.chain([(&self.alone, &other.alone, 1.0)]);
        all.any(|(one, other, scale)| {
            one.0.iter().zip(&other.0).any(|(one, other)| ((one - other) * scale).abs() > CHANGE)
        })
    }
}

/// One component of the coefficients along rotary axes.
fn functions(along: &[(Axis, Vec<Affine>)], of: impl Fn(&Affine) -> f64) -> Vec<(Axis, Vec<f64>)> {
    let values = |affines: &[Affine]| affines.iter().map(&of).collect::<Vec<f64>>();
    let all = along.iter().map(|(axis, affines)| (*axis, values(affines)));
    // A component may not depend on an axis on which others depend.
    all.filter(|(_, values)| values.iter().any(|value| (value - values[0]).abs() > CHANGE / ARM_MM)).collect()
}
