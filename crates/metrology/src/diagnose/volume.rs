//! Effects of errors on the tool over the travel of the machine, except displacements of the workpiece as a whole.

use std::collections::HashMap;

use super::cause::Candidate;
use super::row::{NOWHERE, SceneRow};
use super::scene::{Scene, Through};
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_base::numeric::sums::dot;
use ncfix_model::{ErrorModel, Model};

/// Number of places along the travel of a linear axis, and along the measured range of a rotary axis.
const LINEAR: usize = 7;
const ROTARY: usize = 3;
/// Tool lengths are equal if they differ by less than this share.
const OTHER_LENGTH: f64 = 0.1;
/// A direction with less than this share remaining is dependent on the others.
const OWN: f64 = 1e-6;

/// Places distributed over the travel.
pub(super) struct Volume {
    places: Vec<SceneRow>,
    /// Lowest and highest measured positions.
    low: AxisVector,
    high: AxisVector,
    model: Model,
    /// Fields that displace the workpiece as a whole, of unit length.
    rigid: Vec<Vec<f64>>,
}

/// Assumed tools of programs: the shortest and the longest measured tool. If only one length was measured, half of it and one and a half times it.
fn tools(scene: &Scene<'_>, counts: &impl Fn(&SceneRow) -> bool) -> Vec<[f64; 3]> {
    let length = |tool: &[f64; 3]| Vector::from(*tool).norm();
    let mut all: Vec<[f64; 3]> = scene.rows.iter().filter(|row| counts(row)).map(|row| row.tool_mm).collect();
    all.sort_by(|a, b| length(a).total_cmp(&length(b)));
    let (Some(&short), Some(&long)) = (all.first(), all.last()) else { return Vec::new() };
    if length(&long) - length(&short) > OTHER_LENGTH * length(&long) {
        return vec![short, long];
    }
    vec![long.map(|value| 0.5 * value), long, long.map(|value| 1.5 * value)]
}

impl Volume {
    /// Builds the places of a scene, with the tools of the included rows and others; `None` without rows.
    pub(super) fn new(scene: &Scene<'_>, counts: impl Fn(&SceneRow) -> bool) -> Option<Volume> {
        let mut rows = scene.rows.iter().filter(|row| counts(row));
        let first = rows.next()?;
        let (mut low, mut high) = (first.position, first.position);
        for row in rows {
            for axis in AXES {
                low[axis] = low[axis].min(row.position[axis]);
                high[axis] = high[axis].max(row.position[axis]);
            }
        }
        let mut places = vec![SceneRow { number: NOWHERE, sense: [0; _], ..first.clone() }];
        for data in scene.machine.axes.iter().flatten() {
            let axis = data.axis;
            let measured = [low[axis], high[axis]];
            let (count, [from, until]) =
                if axis.is_rotary() { (ROTARY, measured) } else { (LINEAR, data.travel.unwrap_or(measured)) };
            let [from, until] = [from.min(measured[0]), until.max(measured[1])];
            if !(until > from && (until - from).is_finite()) {
                continue;
            }
            let at = |k: usize| from + (until - from) * k as f64 / (count - 1) as f64;
            places = (0..count).flat_map(|k| places.iter().map(move |row| moved(row, axis, at(k)))).collect();
        }
        let tools = tools(scene, &counts);
        places = tools
            .iter()
            .flat_map(|&tool_mm| places.iter().map(move |row| SceneRow { tool_mm, ..row.clone() }))
            .collect();
        let model = Model::new(scene.machine, &ErrorModel::default());
        let mut volume = Volume { places, low, high, model, rigid: Vec::new() };
        let tip = |row: &SceneRow| volume.model.nominal(&row.position, &Vector::from(row.tool_mm)).translation;
        let tips: Vec<Vector> = volume.places.iter().map(tip).collect();
        for direction in 0..6 {
            let unit = Vector::ith(direction % 3, 1.0);
            let of = |tip: &Vector| if direction < 3 { unit } else { unit.cross(tip) };
            let mut field: Vec<f64> = tips.iter().flat_map(|tip| of(tip).iter().copied().collect::<Vec<_>>()).collect();
            let whole = dot(&field, &field);
            volume.leave_rigid(&mut field);
            let rest = dot(&field, &field);
            if rest > OWN * whole {
                field.iter_mut().for_each(|value| *value /= rest.sqrt());
                volume.rigid.push(field);
            }
        }
        Some(volume)
    }

    /// Returns the displacements of the tip at all places per amount of each column of a candidate. A term that the file holds as a table stays constant
    /// beyond the last measured places.
    pub(super) fn fields(&self, candidate: &Candidate, is_table: bool) -> Vec<Vec<f64>> {
        let mut known: HashMap<Through, Vec<Vector>> = HashMap::new();
        let mut out = Vec::new();
        for parts in &candidate.columns {
            let mut field = vec![0.0; 3 * self.places.len()];
            for (through, weight) in parts {
                let units = known.entry(*through).or_insert_with(|| self.units(*through));
                for ((row, unit), own) in self.places.iter().zip(units.iter()).zip(field.chunks_exact_mut(3)) {
                    let factor = if is_table { weight.of(&self.within(row)) } else { weight.of(row) };
                    own.iter_mut().zip(unit.iter()).for_each(|(sum, unit)| *sum += factor * unit);
                }
            }
            self.leave_rigid(&mut field);
            out.push(field);
        }
        out
    }

    /// Number of values of a field for one tool; those of the next tool follow.
    pub(super) fn numbers_of_a_tool(&self) -> usize {
        let first = self.places.first().map(|row| row.tool_mm);
        3 * self.places.iter().take_while(|row| Some(row.tool_mm) == first).count()
    }

    /// Returns the nearest measured place.
    fn within(&self, row: &SceneRow) -> SceneRow {
        let mut out = row.clone();
        AXES.into_iter()
            .for_each(|axis| out.position[axis] = row.position[axis].clamp(self.low[axis], self.high[axis]));
        out
    }

    fn units(&self, through: Through) -> Vec<Vector> {
        let unit = |row: &SceneRow| {
            let tool = Vector::from(row.tool_mm);
            let nominal = self.model.nominal(&row.position, &tool);
            match through {
                Through::Component(name) => {
                    nominal.rotation * self.model.sensitivity(name, &row.position, &tool).translation
                }
                Through::Tip(direction) => {
                    let to_f = self.model.tool_orientation(&row.position) * nominal.rotation.transpose();
                    to_f.row(direction.min(2)).transpose()
                }
                Through::Reading(_) | Through::Value(_) => Vector::zeros(),
            }
        };
        self.places.iter().map(unit).collect()
    }

    fn leave_rigid(&self, field: &mut [f64]) {
        for direction in &self.rigid {
            let share = dot(field, direction);
            field.iter_mut().zip(direction).for_each(|(value, part)| *value -= share * part);
        }
    }
}

fn moved(row: &SceneRow, axis: Axis, place: f64) -> SceneRow {
    let mut out = row.clone();
    out.position[axis] = place;
    out
}
