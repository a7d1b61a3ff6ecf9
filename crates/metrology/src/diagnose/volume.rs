//! What errors do to the tool anywhere in the travel of the machine, beyond what moves the workpiece as a whole.

use std::collections::HashMap;

use super::cause::Candidate;
use super::row::{NOWHERE, SceneRow};
use super::scene::{Scene, Through};
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_base::numeric::sums::dot;
use ncfix_model::{ErrorModel, Model};

/// Places along the travel of a linear axis, and along what was measured of a rotary one.
const LINEAR: usize = 7;
const ROTARY: usize = 3;
/// Of a direction of which less than this share is left the others have all.
const OWN: f64 = 1e-6;

/// Places all over the travel.
pub(super) struct Volume {
    places: Vec<SceneRow>,
    /// Between where and where was measured.
    low: AxisVector,
    high: AxisVector,
    tool: Vector,
    model: Model,
    /// Directions of fields that move the workpiece as a whole, of unit length.
    rigid: Vec<Vec<f64>>,
}

impl Volume {
    /// Of the machine of a scene, with the tool of the first of the rows that count; `None` where there is none.
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
        let tool = Vector::from(first.tool_mm);
        let model = Model::new(scene.machine, &ErrorModel::default());
        let mut volume = Volume { places, low, high, tool, model, rigid: Vec::new() };
        let tips: Vec<Vector> =
            volume.places.iter().map(|row| volume.model.nominal(&row.position, &tool).translation).collect();
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

    /// What each column of a candidate does per amount: displacements of the tip at all places. A law that the file has as a table stays beyond the last
    /// places that were measured what it is there.
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

    /// The nearest place that was measured.
    fn within(&self, row: &SceneRow) -> SceneRow {
        let mut out = row.clone();
        AXES.into_iter()
            .for_each(|axis| out.position[axis] = row.position[axis].clamp(self.low[axis], self.high[axis]));
        out
    }

    fn units(&self, through: Through) -> Vec<Vector> {
        let unit = |row: &SceneRow| {
            let nominal = self.model.nominal(&row.position, &self.tool);
            match through {
                Through::Component(name) => {
                    nominal.rotation * self.model.sensitivity(name, &row.position, &self.tool).translation
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
