//! Polar coordinates: the pole, angle and radius.

use super::address::Named;
use super::context::MotionContext;
use super::gathered;
use super::gathered::shares_its_block;
use super::gathered::{Gathered, NamedValue};
use super::modal::Modal;
use super::pole::Polar;
use super::pole::PoleBase;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::settings::RunSettings;
use crate::syntax::sinumerik::DimensionFunction;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_base::source::Span;

/// Abscissa and ordinate of a polar end point; `None` if the block has none.
pub(super) fn end(
    gathered: &Gathered,
    modal: &mut Modal,
    context: MotionContext<'_>,
) -> Result<Option<[f64; 2]>, Fault> {
    if !gathered::is_programmed(gathered) {
        return Ok(None);
    }
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    let in_plane: AxisSet = [abscissa, ordinate].into_iter().collect();
    if let Some(axis) = gathered.named.intersection(in_plane).iter().next() {
        let span = gathered.axis_spans[axis.slot()];
        let message = format!("{axis} and a polar position in one block");
        return Err(fault(
            Code::BAD_POLAR,
            span,
            message,
            "only the axis perpendicular to the plane is allowed with AP and RP",
        ));
    }
    let pole = modal.polar.pole(modal.modes.plane, context.span)?;
    let (scale, incremental) = (modal.modes.scale(), modal.modes.incremental);
    let angle = coordinate(gathered, Named::Ap, modal.polar.angle_rad, 1_f64.to_radians(), incremental, context)?;
    let radius = coordinate(gathered, Named::Rp, modal.polar.radius, scale, incremental, context)?;
    if radius < 0.0 {
        let span = gathered.named(Named::Rp).map_or(context.span, |value| value.span);
        return Err(bad_value(span, "a polar radius must not be negative", "turn the angle by 180 degrees instead"));
    }
    modal.polar = Polar { pole, plane: Some(modal.modes.plane), radius: Some(radius), angle_rad: Some(angle) };
    let (sine, cosine) = angle.sin_cos();
    Ok(Some([pole[0] + radius * cosine, pole[1] + radius * sine]))
}

/// Angle or radius of a block, or the active one of an earlier block.
fn coordinate(
    gathered: &Gathered,
    word: Named,
    held: Option<f64>,
    unit: f64,
    incremental: bool,
    context: MotionContext<'_>,
) -> Result<f64, Fault> {
    let name = if word == Named::Ap { "AP" } else { "RP" };
    let lacking = |span| {
        let message = format!("{name} has not been programmed since the pole was set");
        fault(Code::BAD_POLAR, span, message, "give angle and radius in the first block after the pole")
    };
    let Some(&NamedValue { value, dimension, span, .. }) = gathered.named(word) else {
        return held.ok_or_else(|| lacking(context.span));
    };
    let value = value * unit;
    if !value.is_finite() || value.abs() > 1e9 {
        return Err(bad_value(span, "this value is too large", "check the value"));
    }
    match dimension {
        Some(DimensionFunction::Incremental) => Ok(held.ok_or_else(|| lacking(span))? + value),
        Some(DimensionFunction::Absolute) => Ok(value),
        None if !incremental => Ok(value),
        None => {
            let message = format!("{name} under G91 is ambiguous");
            Err(fault(Code::BAD_POLAR, span, message, "write AC(…) or IC(…)"))
        }
        Some(_) => Err(bad_value(span, format!("{name} takes AC(…) or IC(…)"), "correct the word")),
    }
}

/// `G110`, `G111`, `G112`.
pub(super) fn set_pole(
    settings: &RunSettings<'_>,
    modal: &mut Modal,
    gathered: &Gathered,
    (base, span): (PoleBase, Span),
) -> Result<(), Fault> {
    if shares_its_block(gathered) {
        let message = "a pole allows only its position in its block";
        return Err(fault(Code::MUST_STAND_ALONE, span, message, "move the other words to another block"));
    }
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    let mut pole = match base {
        PoleBase::Zero => [0.0; 2],
        PoleBase::Pole => modal.polar.pole(modal.modes.plane, span)?,
        PoleBase::Position => {
            let unknown = [abscissa, ordinate].into_iter().find(|&axis| !modal.position.known.contains(axis));
            if let Some(axis) = unknown.filter(|_| settings.strict) {
                return Err(modal.unknown_start(span, axis));
            }
            let here = modal.setup().programmed(&modal.position.command);
            [here[abscissa], here[ordinate]]
        }
    };
    let words = [Named::Ap, Named::Rp].map(|word| gathered.named(word).copied());
    let in_plane = [abscissa, ordinate].into_iter().any(|axis| gathered.named.contains(axis));
    let step = match words {
        [None, None] => [abscissa, ordinate].map(|axis| gathered.axes[axis] * modal.modes.scale()),
        [Some(angle), Some(radius)] if !in_plane && angle.dimension.is_none() && radius.dimension.is_none() => {
            let (sine, cosine) = angle.value.to_radians().sin_cos();
            [radius.value * modal.modes.scale() * cosine, radius.value * modal.modes.scale() * sine]
        }
        _ => {
            let help = "give its position either by axes or by both AP and RP";
            return Err(fault(Code::BAD_POLAR, span, "the position of this pole is ambiguous", help));
        }
    };
    pole[0] += step[0];
    pole[1] += step[1];
    if !pole.iter().all(|part| part.abs() < 1e9) {
        return Err(bad_value(span, "the pole is too far away", "check the values"));
    }
    modal.polar = Polar { pole, plane: Some(modal.modes.plane), radius: None, angle_rad: None };
    Ok(())
}
