//! Displacements that act on the readings as an angle does.
//!
//! An angle moves the tool by its lever arm. Readings in one direction do not show whether the guideway turns, or displaces the tool by as much: of a carriage
//! that rolls with the product of X and Y, lines along X read X²·Y, and so they do of a sag along X that grows with Y. In the other direction across the axis of
//! the rotation, and for other tools, the two differ. Products of that degree are too many for the search, so each angle over two axes that it accepts proposes its own.

use std::sync::Arc;

use ncfix_base::geometry::Vector;
use ncfix_model::name::{DIRECTIONS, ErrorKind, ErrorName};
use ncfix_model::{ErrorModel, Model};

use super::cause::{Candidate, EffectKind, Weight, cross, linear};
use super::row::SceneRow;
use super::scene::Through;
use super::search::Field;

/// A lever arm that varies by less than this share over the readings is one arm: the displacement then has the form of the angle, and is a candidate already.
const ONE_ARM: f64 = 1e-6;

impl Field<'_, '_> {
    /// Adds the displacements over the same two axes that act on the readings as these angles do, unless the candidates have them. Returns their number.
    pub(super) fn add_levers(&mut self, numbers: &[usize]) -> usize {
        let mut found: Vec<Candidate> = Vec::new();
        let model = Arc::new(Model::new(self.scene.machine, &ErrorModel::default()));
        for one in numbers.iter().filter_map(|&number| self.candidates.get(number)) {
            let Some(angle) = angle(one) else { continue };
            for direction in (0..3).filter(|direction| direction + 3 != angle.direction.index()) {
                found.extend(self.lever(&model, one, (angle, direction)));
            }
        }
        let key = |one: &Candidate| (one.parameter.clone(), one.drivers.clone(), one.columns.len());
        let is_new = |one: &Candidate| {
            let own = key(one);
            !self.candidates.iter().any(|known| known.cause.name == cross::LEVER.name && key(known) == own)
        };
        found.retain(is_new);
        found.iter().for_each(|one| self.know(one));
        let count = found.len();
        self.candidates.extend(found);
        count
    }

    /// The displacement of an axis along a direction that has the effect of an angle at every reading; `None` if the lever arm is the same at all of them.
    fn lever(&self, model: &Arc<Model>, one: &Candidate, (angle, direction): (ErrorName, usize)) -> Option<Candidate> {
        let across = 3_usize.checked_sub(direction)?.checked_sub(angle.direction.index() - 3)?;
        // The axis along the lever arm. A displacement over a third axis is too rare to count.
        let along = linear(self.scene).find(|axis| axis.dimension() == across)?;
        if !one.drivers.contains(&along.to_string()) {
            return None;
        }
        let name = ErrorName::motion(*DIRECTIONS.get(direction)?, along);
        let model = Arc::clone(model);
        let arm = move |row: &SceneRow| {
            let tool = Vector::from(row.tool_mm);
            let [turn, shift] = [angle, name].map(|name| model.sensitivity(name, &row.position, &tool).translation);
            turn.dot(&shift)
        };
        let arms = self.scene.rows.iter().map(&arm).filter(|arm| arm.is_finite());
        let (low, high) =
            arms.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), arm| (low.min(arm), high.max(arm)));
        if high - low <= ONE_ARM * low.abs().max(high.abs()) || !(high - low).is_finite() {
            return None;
        }
        let through = Through::Component(name);
        let arm = Arc::new(arm);
        let column = |parts: &Vec<(Through, Weight)>| {
            let (own, arm) = (parts.first()?.1.clone(), Arc::clone(&arm));
            Some(vec![(through, Weight::new(move |row| arm(row) * own.of(row)))])
        };
        let columns: Option<Vec<_>> = one.columns.iter().map(column).collect();
        let mut out = Candidate::one(&cross::LEVER, name, through, Weight::new(|_| 0.0));
        out.columns = columns?;
        out.drivers.clone_from(&one.drivers);
        Some(out)
    }
}

/// The component of an angle of a linear axis that depends on the positions of two axes. An angle over one axis is far more usual than a displacement over two.
fn angle(one: &Candidate) -> Option<ErrorName> {
    let (first, _) = one.columns.first()?.first()?;
    let Through::Component(name) = *first else { return None };
    let is_one = one.cause.effect == EffectKind::Cross
        && name.kind == ErrorKind::Motion
        && name.direction.is_rotation()
        && name.axis().is_some_and(|axis| !axis.is_rotary())
        && one.columns.iter().all(|parts| matches!(parts.as_slice(), [(through, _)] if through == first));
    is_one.then_some(name)
}
