//! The speed-independent part: link errors, motion errors, and the set-up of the instrument.
//!
//! All from the slowest run, which is the reference state (Andolfatto, Lavernhe and Mayer 2011, section 3.3): the link errors by the Jacobian of the
//! machine's own chain, then smooth functions of the residual. Along one path a part of the motion errors resembles link errors, and counts as such:
//! this decomposes the measurements on this path, and is not a calibration of the machine.

use crate::measure::trace::TraceUnknown;
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_base::numeric::{Solution, System};
use ncfix_machine::machine::State;
use ncfix_model::{Model, ParameterName};

use super::basis::Basis;
use super::poses::RunPoses;

/// Maximum number of fitted samples.
const SAMPLES: usize = 8_000;
/// Relative singular value below which smooth functions are equal along the path. Otherwise they would diverge off the path, by the lag of an axis, a
/// thousandth of its range.
const SMOOTH_LIMIT: f64 = 2e-3;

/// A link error as a first fit along the path gives it: motion errors that act like it on this path are part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PathLink {
    /// Its name.
    pub(super) name: ParameterName,
    /// Value relative to the machine file, mm or rad.
    pub(super) value: f64,
    /// `true` if this path separates it from the other links.
    pub(super) is_separate: bool,
}

/// The contribution of links and set-up.
#[derive(Clone, Debug)]
pub(super) struct LinkPart {
    /// The links.
    pub(super) links: Vec<PathLink>,
    /// Unknowns of the set-up, with their three values, mm.
    pub(super) setup: Vec<(TraceUnknown, [f64; 3])>,
}

/// The smooth part: coefficients along X, Y, Z; the constant comes first.
#[derive(Clone, Debug)]
pub(super) struct SmoothMotion {
    basis: Basis,
    coefficients: [Vec<f64>; 3],
}

/// Estimates the links from the residual `left` of a run by sample, mm; `None` for samples without reading.
#[must_use]
pub(super) fn links(
    model: &Model,
    names: &[ParameterName],
    free: &[TraceUnknown],
    tool_mm: &Vector,
    poses: &RunPoses,
    left: &[Option<Vector>],
) -> Option<LinkPart> {
    let columns = names.len() + 3 * free.len();
    let mut system = System::new(columns);
    let every = poses.count().div_ceil(SAMPLES).max(1);
    let mut rows = vec![vec![0.0; columns]; 3];
    for number in (0..poses.count()).step_by(every) {
        let Some(value) = left.get(number).copied().flatten() else { continue };
        for (column, name) in names.iter().enumerate() {
            let effect = effect(model, *name, tool_mm, poses, number);
            (0..3).for_each(|k| rows[k][column] = effect[k]);
        }
        for (place, unknown) in free.iter().enumerate() {
            for along in 0..3 {
                let effect = of_setup(*unknown, along, poses, number);
                (0..3).for_each(|k| rows[k][names.len() + 3 * place + along] = effect[k]);
            }
        }
        for (k, row) in rows.iter().enumerate() {
            system.add(row, value[k], 1.0);
        }
    }
    if system.rows() < columns.max(1) {
        return None;
    }
    let Solution { unknowns, inflation, .. } = system.solve()?;
    let links = names
        .iter()
        .enumerate()
        .map(|(k, &name)| PathLink { name, value: unknowns[k], is_separate: inflation[k].is_finite() })
        .collect();
    let setup = free.iter().enumerate().map(|(k, &unknown)| {
        let at = names.len() + 3 * k;
        (unknown, [unknowns[at], unknowns[at + 1], unknowns[at + 2]])
    });
    Some(LinkPart { links, setup: setup.collect() })
}

impl LinkPart {
    /// Contribution of the links at a sample, mm.
    #[must_use]
    pub(super) fn at(&self, model: &Model, tool_mm: &Vector, poses: &RunPoses, number: usize) -> Vector {
        self.links.iter().map(|link| effect(model, link.name, tool_mm, poses, number) * link.value).sum()
    }

    /// Contribution of the set-up to a reading, mm.
    #[must_use]
    pub(super) fn setup_at(&self, poses: &RunPoses, number: usize) -> Vector {
        let all = self.setup.iter().flat_map(|(unknown, values)| (0..3).map(move |k| (*unknown, k, values[k])));
        all.map(|(unknown, along, value)| of_setup(unknown, along, poses, number) * value).sum()
    }
}

/// Effect of a link error of 1 mm or rad.
pub(super) fn effect(model: &Model, name: ParameterName, tool_mm: &Vector, poses: &RunPoses, number: usize) -> Vector {
    let weight = name.weight(&poses.encoder[number], &State::default());
    poses.effect(model, name.component, tool_mm, number) * weight
}

/// Effect of 1 mm of a set-up unknown.
pub(super) fn of_setup(unknown: TraceUnknown, along: usize, poses: &RunPoses, number: usize) -> Vector {
    match unknown {
        TraceUnknown::Offset => Vector::ith(along, 1.0),
        TraceUnknown::Place => -poses.to_f[number].column(along),
    }
}

/// Fits smooth functions to the residual `left` of a run.
#[must_use]
pub(super) fn motion(basis: Basis, poses: &RunPoses, left: &[Option<Vector>]) -> Option<SmoothMotion> {
    let every = poses.count().div_ceil(SAMPLES).max(1);
    let mut coefficients = [const { Vec::new() }; 3];
    for (direction, out) in coefficients.iter_mut().enumerate() {
        let mut system = System::new(1 + basis.len());
        for number in (0..poses.count()).step_by(every) {
            let Some(value) = left.get(number).copied().flatten() else { continue };
            let mut row = vec![1.0];
            basis.push(&poses.encoder[number], poses.share[number], &mut row);
            system.add(&row, value[direction], 1.0);
        }
        if system.rows() < 2 * (1 + basis.len()) {
            return None;
        }
        *out = system.solve_to(SMOOTH_LIMIT)?.unknowns.iter().copied().collect();
    }
    Some(SmoothMotion { basis, coefficients })
}

impl SmoothMotion {
    /// The functions.
    #[must_use]
    pub(super) fn basis(&self) -> &Basis {
        &self.basis
    }

    /// Its value at a pose and a relative path position, mm.
    #[must_use]
    pub(super) fn at(&self, position: &AxisVector, share: f64) -> Vector {
        let mut row = vec![1.0];
        self.basis.push(position, share, &mut row);
        Vector::from_fn(|k, _| self.coefficients[k].iter().zip(&row).map(|(a, b)| a * b).sum())
    }
}
