//! Displacements that were measured at one arm, and angles that would differ from them at other arms.
//!
//! A laser along an axis reads the positioning error at the height of its beam. An angle of the same axis, times the arm, has the same readings (Abbe). It is
//! the rarer error, so the displacement is named; but at other heights of the tool the two differ, and only a second line at another height shows it.

use super::cause::{Candidate, EffectKind};
use super::doubt::{is_bounded, sum};
use super::scene::Through;
use super::search::Field;
use super::volume::Volume;
use ncfix_base::numeric::Series;
use ncfix_base::units::um_from_mm;
use ncfix_model::ErrorName;

/// A smaller share of the largest displacement is not reported.
const LEAST: f64 = 0.2;

/// An angle of the same axis that explains the readings of a displacement as well, because they have one arm.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ArmRisk {
    /// The angle: effect and parameter, as `motion EBX`.
    pub cause: String,
    /// Largest difference between the two in the travel.
    pub difference_um: f64,
}

impl Field<'_, '_> {
    /// Returns the angle whose effect differs most from that of a displacement in the travel; `None` if the readings separate all angles from it. Arguments:
    /// the other terms, the candidate with its amounts, and its class, itself first.
    pub(super) fn elsewhere(
        &self,
        volume: &Volume,
        beside: &Series,
        (one, amounts): (&Candidate, &[f64]),
        class: &[usize],
    ) -> Option<ArmRisk> {
        let own = motion(one).filter(|name| !name.direction.is_rotation())?;
        let moves = sum(&volume.fields(one, is_bounded(one)), amounts);
        let largest = |field: &[f64]| {
            let squares = field.chunks_exact(3).map(|tip| tip.iter().map(|value| value * value).sum::<f64>());
            squares.fold(0.0, f64::max).sqrt()
        };
        let of = |&number: &usize| {
            let other = self.candidates.get(number)?;
            motion(other).filter(|name| name.direction.is_rotation() && name.axis() == own.axis())?;
            let (parts, _) = beside.amounts(&self.columns(other));
            let field = sum(&volume.fields(other, is_bounded(other)), &parts);
            let apart: Vec<f64> = moves.iter().zip(&field).map(|(own, other)| own - other).collect();
            Some(ArmRisk { cause: other.title(), difference_um: um_from_mm(largest(&apart)) })
        };
        let worst = class.iter().skip(1).filter_map(of).max_by(|a, b| a.difference_um.total_cmp(&b.difference_um))?;
        (worst.difference_um.is_finite() && worst.difference_um > LEAST * um_from_mm(largest(&moves))).then_some(worst)
    }
}

/// The component of an error of the motion of a linear axis.
fn motion(one: &Candidate) -> Option<ErrorName> {
    let (through, _) = one.columns.first()?.first()?;
    let Through::Component(name) = through else { return None };
    let is_linear = name.axis().is_some_and(|axis| !axis.is_rotary());
    (one.cause.effect == EffectKind::Motion && is_linear).then_some(*name)
}
