//! Fits the terms of a scheme to the exact corrections over the region, by least squares.
//!
//! The rotary axes are fitted first. The linear axes are then fitted to the corrections that place the tip with the actual rotary corrections of the
//! tables: position has priority over direction.

use super::Task;
use super::assembly::{Assembly, AxisFunction};
use crate::tables::{Control, Orientation, Tables};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_base::numeric::System;
use ncfix_machine::machine::State;
use ncfix_model::Solve;

/// Number of fitted poses per term, and minimum.
const POSES_A_TERM: usize = 25;
const LEAST_POSES: usize = 2000;
/// Maximum number of unknowns of a correction: the effort grows with the third power.
const MOST_TERMS: usize = 600;
/// Seed of the generator of these poses; the poses of a check have another.
const SEED: u64 = 0x4649_5454_4544;
/// Relative singular value below which directions of terms are set to zero.
const RANK_LIMIT: f64 = 1e-9;

/// A function of the commands with an unknown coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FitTerm {
    /// 1.
    One,
    /// A power of an axis in units of half its range, from its middle.
    Power(Axis, i32),
    /// 1 at a node, 0 at the others, linear between.
    Hat(Axis, usize),
    /// The same on an axis whose ends are one position: the first node is also the last.
    Ring(Axis, usize),
    /// A trigonometric function of a rotary axis, optionally times a linear axis.
    Wave(Option<Axis>, Axis, Wave),
}

/// The independent trigonometric functions of Esmaeili 2021, eq. 44: sin² + cos² is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wave {
    One,
    Cos,
    Sin,
    CosSin,
    SinSquared,
}

impl Wave {
    pub(super) const ALL: [Wave; 5] = [Wave::One, Wave::Cos, Wave::Sin, Wave::CosSin, Wave::SinSquared];

    fn value(self, angle: f64) -> f64 {
        let (sin, cos) = angle.sin_cos();
        match self {
            Wave::One => 1.0,
            Wave::Cos => cos,
            Wave::Sin => sin,
            Wave::CosSin => cos * sin,
            Wave::SinSquared => sin * sin,
        }
    }
}

/// The terms of a scheme with their nodes.
struct Basis<'a> {
    task: &'a Task<'a>,
    /// By slot of the axis.
    nodes: Vec<Vec<f64>>,
}

impl Basis<'_> {
    /// A position in units of half the range, from its middle.
    fn scaled(&self, axis: Axis, at: f64) -> f64 {
        let [low, high] = self.task.region.range(axis);
        if high > low { (2.0 * at - low - high) / (high - low) } else { 0.0 }
    }

    /// The factor of a term that depends on an axis.
    fn part(&self, term: FitTerm, axis: Axis, at: f64) -> f64 {
        match term {
            FitTerm::Power(own, power) if own == axis => self.scaled(axis, at).powi(power),
            FitTerm::Hat(own, node) if own == axis => hat(&self.nodes[axis.slot()], node, at),
            FitTerm::Ring(own, node) if own == axis => {
                let nodes = &self.nodes[axis.slot()];
                let end = if node == 0 { hat(nodes, nodes.len().saturating_sub(1), at) } else { 0.0 };
                hat(nodes, node, at) + end
            }
            FitTerm::Wave(_, turned, wave) if turned == axis => wave.value(at),
            FitTerm::Wave(Some(lever), _, _) if lever == axis => self.scaled(axis, at),
            _ => 1.0,
        }
    }

    fn value(&self, term: FitTerm, pose: &AxisVector) -> f64 {
        match term {
            FitTerm::One => 1.0,
            FitTerm::Power(axis, _) | FitTerm::Hat(axis, _) | FitTerm::Ring(axis, _) | FitTerm::Wave(None, axis, _) => {
                self.part(term, axis, pose[axis])
            }
            FitTerm::Wave(Some(lever), axis, _) => {
                self.part(term, lever, pose[lever]) * self.part(term, axis, pose[axis])
            }
        }
    }

    /// The tables of some axes for corrections at poses.
    fn fitted(
        &self,
        outputs: impl IntoIterator<Item = Axis>,
        terms_of: &dyn Fn(Axis) -> Vec<FitTerm>,
        poses: &[AxisVector],
        wanted: &[AxisVector],
    ) -> Result<Tables, String> {
        let mut assembly = Assembly::new(self.task);
        for axis in outputs {
            let terms = terms_of(axis);
            let values: Vec<f64> = wanted.iter().map(|correction| correction[axis]).collect();
            let coefficients = self.coefficients(&terms, poses, &values)?;
            self.put(&mut assembly, axis, &terms, &coefficients);
        }
        Ok(assembly.finish())
    }

    /// The coefficients of a correction at poses.
    fn coefficients(&self, terms: &[FitTerm], poses: &[AxisVector], wanted: &[f64]) -> Result<Vec<f64>, String> {
        let mut system = System::new(terms.len());
        let mut row = vec![0.0; terms.len()];
        for (pose, &value) in poses.iter().zip(wanted) {
            row.iter_mut().zip(terms).for_each(|(factor, &term)| *factor = self.value(term, pose));
            system.add(&row, value, 1.0);
        }
        let solution = system.solve_to(RANK_LIMIT).ok_or("the corrections are not finite numbers")?;
        Ok(solution.unknowns.iter().copied().collect())
    }

    /// Adds terms with their coefficients to an output.
    fn put(&self, assembly: &mut Assembly<'_>, output: Axis, terms: &[FitTerm], coefficients: &[f64]) {
        for (&term, &coefficient) in terms.iter().zip(coefficients) {
            let at_nodes = |axis: Axis| -> Vec<f64> {
                self.nodes[axis.slot()].iter().map(|&at| coefficient * self.part(term, axis, at)).collect()
            };
            match term {
                FitTerm::One => assembly.add_constant(output, coefficient),
                FitTerm::Power(axis, _) | FitTerm::Hat(axis, _) | FitTerm::Ring(axis, _) => {
                    assembly.add(output, axis, &at_nodes(axis))
                }
                FitTerm::Wave(None, axis, _) => assembly.add(output, axis, &at_nodes(axis)),
                // Linear in the linear axis: collected below.
                FitTerm::Wave(Some(_), ..) => {}
            }
        }
        for lever in self.task.region.axes().filter(|axis| !axis.is_rotary()) {
            let mine = terms
                .iter()
                .zip(coefficients)
                .filter(|(term, _)| matches!(term, FitTerm::Wave(Some(one), ..) if *one == lever));
            let mut sum: Option<AxisFunction> = None;
            for (&term, coefficient) in mine {
                let FitTerm::Wave(_, axis, _) = term else { continue };
                let nodes = &self.nodes[axis.slot()];
                let side = sum.get_or_insert_with(|| AxisFunction { axis, values: vec![0.0; nodes.len()] });
                side.values
                    .iter_mut()
                    .zip(nodes)
                    .for_each(|(sum, &at)| *sum += coefficient * self.part(term, axis, at));
            }
            if let Some(side) = sum {
                assembly.add_product(output, [AxisFunction { axis: lever, values: vec![-1.0, 1.0] }, side]);
            }
        }
    }
}

/// A hat function.
fn hat(nodes: &[f64], node: usize, at: f64) -> f64 {
    let Some(&here) = nodes.get(node) else { return 0.0 };
    let next = if at >= here { nodes.get(node + 1) } else { node.checked_sub(1).and_then(|before| nodes.get(before)) };
    match next {
        Some(next) => (1.0 - (at - here) / (next - here)).max(0.0),
        None => 1.0,
    }
}

/// The tables of terms fitted to the corrections of all axes; each axis has its own terms.
pub(super) fn fill(task: &Task<'_>, terms_of: &dyn Fn(Axis) -> Vec<FitTerm>) -> Result<Tables, String> {
    let mut nodes = vec![Vec::new(); ncfix_base::geometry::AXIS_COUNT];
    for axis in task.region.axes() {
        nodes[axis.slot()] = super::assembly::positions(axis, task.region, task.points);
    }
    let basis = Basis { task, nodes };
    let outputs = task.linear().into_iter().chain(task.target.rotary());
    let most = outputs.map(|axis| terms_of(axis).len()).max().unwrap_or(0);
    if most > MOST_TERMS {
        // The number of free terms of an output grows with the points, others do not.
        let points = MOST_TERMS * task.points / most;
        return Err(format!(
            "{most} values of one axis would be fitted at once, but the limit is {MOST_TERMS} (the time grows with their third power): choose --points {points} or fewer; the schemes polynomial, trigonometric and fik allow more"
        ));
    }
    let poses = task.region.poses((most * POSES_A_TERM).max(LEAST_POSES), SEED);
    let state = State::default();
    let mut tables = Tables { multiplication: task.multiplication, ..Tables::default() };
    if task.target.orientation != Orientation::Off {
        tables = basis.fitted(task.target.rotary(), terms_of, &poses, &task.exact(&poses)?)?;
    }
    let control = Control::new(task.target.machine, &tables);
    let mut wanted = Vec::with_capacity(poses.len());
    for pose in &poses {
        let start = *pose + control.correction(pose, &task.target.tool_mm, &state);
        let solved = task.target.model.solve(pose, &task.target.tool_mm, &state, &start, Solve::PositionOnly);
        wanted.push(solved.map_err(|_| "the tip cannot be brought to its position everywhere in the region")? - *pose);
    }
    super::append(&mut tables, basis.fitted(task.linear(), terms_of, &poses, &wanted)?);
    Ok(tables)
}
