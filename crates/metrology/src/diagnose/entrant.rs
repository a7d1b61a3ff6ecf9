//! Candidates as entrants of the comparison: their family, their columns, their typical size.

use super::cause::{Candidate, CauseId, EffectKind, Term, Weight, common_scale, servo, setup};
use super::scene::Through;
use super::search::Field;
use crate::diagnose::explain::assumptions::Family;
use crate::diagnose::explain::contest::Entrant;
use crate::diagnose::explain::likelihood::ColumnGroup;
use ncfix_model::name::ErrorName;
use ncfix_model::parameter::ComponentTerm;

/// An entrant and its source.
pub(super) struct NamedEntrant {
    pub(super) candidate: EntrantSource,
    pub(super) entrant: Entrant,
}

/// Origin of the candidate of an entrant.
#[derive(Clone, Debug)]
pub(super) enum EntrantSource {
    /// Among the candidates of the field.
    Known(usize),
    /// A shape over the travel: an axis component with one column.
    Shape(Box<Candidate>),
}

impl EntrantSource {
    /// Effect and parameter: variants of one cause share a name.
    pub(super) fn key(&self, field: &Field<'_, '_>) -> (EffectKind, String) {
        let one = match self {
            EntrantSource::Known(number) => &field.candidates[*number],
            EntrantSource::Shape(one) => one,
        };
        (one.cause.effect, one.parameter.clone())
    }

    /// Identity in explanations, the same as that of a finding.
    pub(super) fn id(&self, field: &Field<'_, '_>) -> CauseId {
        let (effect, parameter) = self.key(field);
        CauseId::Effect(effect, parameter)
    }
}

/// The family of a candidate.
pub(super) fn family(one: &Candidate) -> Family {
    let component = match one.columns.first().and_then(|parts| parts.first()) {
        Some((Through::Component(name), _)) => Some(*name),
        _ => None,
    };
    let is_angle = component.is_some_and(|name| name.direction.is_rotation());
    let is_rotary = component.and_then(|name| name.axis()).is_some_and(|axis| axis.is_rotary());
    match one.cause.effect {
        EffectKind::Location if component.is_some_and(|name| name.axis().is_some_and(|axis| !axis.is_rotary())) => {
            Family::Squareness
        }
        EffectKind::Location if is_angle => Family::Tilt,
        EffectKind::Location => Family::Offset,
        EffectKind::Motion if one.cause.name == common_scale::CAUSE.name => Family::Scale,
        EffectKind::Motion if is_angle => Family::Angle,
        EffectKind::Motion if is_rotary => Family::Rotary,
        EffectKind::Motion
            if component.is_some_and(|name| name.axis().is_some_and(|axis| super::cause::own(axis) == name)) =>
        {
            Family::Positioning
        }
        EffectKind::Motion => Family::Straightness,
        EffectKind::Periodic => Family::Wave,
        EffectKind::Backlash => Family::Backlash,
        EffectKind::LateralPlay if is_angle => Family::AngularPlay,
        EffectKind::LateralPlay => Family::LateralPlay,
        EffectKind::ReversalSpike => Family::Spike,
        EffectKind::Cross if one.threshold.is_some() => Family::Threshold,
        EffectKind::Cross if is_angle => Family::CrossAngle,
        EffectKind::Cross => Family::Cross,
        EffectKind::ServoMismatch | EffectKind::Following | EffectKind::Delay => Family::Lag,
        EffectKind::Dynamic if is_by_acceleration(one) => Family::Deflection,
        EffectKind::Dynamic => Family::Dynamic,
        EffectKind::ThermalDrift | EffectKind::SpindleSpeed => Family::Drift,
        EffectKind::ThermalExpansion => Family::Expansion,
        EffectKind::ThermalSquareness => Family::ThermalSquareness,
        EffectKind::Drift => Family::Creep,
        EffectKind::Load => Family::Load,
        EffectKind::Setup if one.cause.name == setup::TOOL.name => Family::Probe,
        EffectKind::Setup => Family::Setup,
        EffectKind::Earlier => Family::Earlier,
        EffectKind::Probe => Family::Probe,
        EffectKind::Sensor | EffectKind::Outlier | EffectKind::Program | EffectKind::Unknown => Family::Unnamed,
        EffectKind::Own(_) => Family::Own,
    }
}

/// True for an angle, false for a displacement.
fn acts_as_angle(one: &Candidate) -> bool {
    let first = one.columns.first().and_then(|parts| parts.first());
    first.is_some_and(|(through, _)| matches!(through, Through::Component(name) if name.direction.is_rotation()))
}

/// True for a deflection that is proportional to the acceleration of an axis.
fn is_by_acceleration(one: &Candidate) -> bool {
    one.cause.name == servo::DYNAMIC.name
}

pub(super) fn is_of_rotary(one: &Candidate) -> bool {
    let name = one.parameter.parse::<ErrorName>().ok();
    name.and_then(|name| name.axis()).is_some_and(|axis| axis.is_rotary())
}

/// True for a slope alone.
pub(super) fn is_slope(one: &Candidate) -> bool {
    matches!(&one.term, Term::Parameters(names) if names.len() == 1 && names[0].term == ComponentTerm::Coefficient(1))
}

/// Columns of a candidate, each scaled to the typical size of its family at its maximum.
pub(super) fn group(field: &Field<'_, '_>, one: &Candidate) -> ColumnGroup {
    let columns = field.columns(one);
    let size = |parts: &Vec<(Through, Weight)>| {
        // The travel does not matter: the typical size is that of the maximum effect.
        let of = match family(one) {
            Family::Squareness | Family::Tilt | Family::Offset => return family(one).size(0.0),
            // Angles have their own typical size; displacements that differ between files do so as reversal values do.
            Family::Earlier if !acts_as_angle(one) => Family::Backlash.size(0.0),
            own @ (Family::Lag | Family::Deflection) => return own.size(0.0),
            other => other.size(1e3),
        };
        let largest = |(_, weight): &(Through, Weight)| match field.layout.table(weight) {
            Some(table) => table.iter().map(|value| value.abs()).fold(0.0, f64::max),
            None => field.scene.rows.iter().map(|row| weight.of(row).abs()).fold(0.0, f64::max),
        };
        let most = parts.iter().map(largest).fold(0.0, f64::max);
        // A reversal value acts with half its size on either side.
        let share = if one.cause.effect == EffectKind::Backlash { 0.5 } else { 1.0 };
        if most > 0.0 { share * of / most } else { 0.0 }
    };
    let sizes = one.columns.iter().map(size).collect();
    let is_of_instrument = matches!(family(one), Family::Setup | Family::Probe);
    ColumnGroup { columns, sizes, is_of_instrument }
}
