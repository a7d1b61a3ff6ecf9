//! The measured range that the size of a cause belongs to. A reversal value that grows along an axis, a curve and an interaction of two axes are larger over a
//! longer range.

use ncfix_base::geometry::{AXES, Axis};
use serde::Serialize;

use crate::diagnose::cause::EffectKind;
use crate::diagnose::{AcceptedCause, Scene};

/// Measured range of an axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SizeRange {
    /// The axis.
    pub axis: String,
    /// Its lowest measured position, mm or degrees.
    pub low: f64,
    /// Its highest measured position, mm or degrees.
    pub high: f64,
    /// Unit of both.
    pub unit: PositionUnit,
}

/// Unit of a position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum PositionUnit {
    /// Of a linear axis.
    #[default]
    Mm,
    /// Of a rotary axis.
    Deg,
}

/// Returns the ranges of the axes that the size of a cause depends on; empty if it is the same everywhere, as a slope or a squareness is.
pub(super) fn ranges(found: &AcceptedCause, scene: &Scene<'_>, used: usize) -> Vec<SizeRange> {
    let one = &found.candidate;
    let is_of_range = match one.cause.effect {
        EffectKind::Backlash | EffectKind::LateralPlay | EffectKind::Cross => true,
        EffectKind::Motion => !found.size.unit.contains('/'),
        _ => false,
    };
    let axes = AXES.into_iter().filter(|axis| is_of_range && one.drivers.contains(&axis.to_string()));
    axes.filter_map(|axis| range(axis, scene, used)).collect()
}

fn range(axis: Axis, scene: &Scene<'_>, used: usize) -> Option<SizeRange> {
    let rows = scene.rows.iter().filter(|row| row.set < used);
    let [low, high] = rows
        .map(|row| row.position[axis])
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
    let unit = if axis.is_rotary() { PositionUnit::Deg } else { PositionUnit::Mm };
    let shown = |value: f64| match unit {
        PositionUnit::Mm => value,
        PositionUnit::Deg => value.to_degrees(),
    };
    (low < high).then(|| SizeRange { axis: axis.to_string(), low: shown(low), high: shown(high), unit })
}
