//! Positions of rotary axes: DC, ACP, ACN, and modulo axes.
//!
//! Internally, the position of a modulo axis counts its turns; the output contains positions within a turn.

use std::f64::consts::{PI, TAU};

use super::context::MotionContext;
use super::gathered::Gathered;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::syntax::sinumerik::DimensionFunction;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, ROTARY_AXES};
use ncfix_base::source::Span;
use ncfix_machine::snc::{RotaryDirection, Turning};

/// Difference below which a position equals the current one, rad: no full turn is intended.
const SAME_RAD: f64 = 1e-9;

/// Sets the meaning of an axis word; `false` if the function is unknown.
pub(super) fn set_way(axis: Axis, function: DimensionFunction, span: Span, out: &mut Gathered) -> Result<bool, Fault> {
    let way = match function {
        DimensionFunction::Absolute => RotaryDirection::Plain,
        DimensionFunction::Incremental => {
            out.as_incremental.insert(axis);
            return Ok(true);
        }
        DimensionFunction::Shortest => RotaryDirection::Shortest,
        DimensionFunction::Positive => RotaryDirection::Positive,
        DimensionFunction::Negative => RotaryDirection::Negative,
        DimensionFunction::Other => return Ok(false),
    };
    if way != RotaryDirection::Plain && !axis.is_rotary() {
        return Err(bad_value(span, format!("{axis} is not a rotary axis"), "DC, ACP and ACN are for rotary axes"));
    }
    out.as_absolute.insert(axis);
    if let Some(place) = out.ways.get_mut(axis.dimension()).filter(|_| axis.is_rotary()) {
        *place = way;
    }
    Ok(true)
}

/// The position of an absolute word. If the control may choose the direction, it becomes [`RotaryDirection::Either`].
pub(super) fn position(
    axis: Axis,
    value: f64,
    here: f64,
    (gathered, is_known): (&Gathered, bool),
    context: MotionContext<'_>,
    ways: &mut [RotaryDirection; 3],
) -> Result<f64, Fault> {
    if !axis.is_rotary() {
        return Ok(value);
    }
    let way = gathered.ways.get(axis.dimension()).copied().unwrap_or_default();
    let is_modulo = context.machine.axis(axis).is_some_and(|data| data.modulo);
    let span = gathered.axis_spans.get(axis.slot()).copied().unwrap_or_default();
    if !is_modulo {
        return match way {
            RotaryDirection::Plain => Ok(value),
            _ => {
                let message = format!("DC, ACP and ACN need a modulo axis; {axis} is not one");
                Err(bad_value(
                    span,
                    message,
                    "if it is one, set modulo = true instead of a travel in its section of the machine file",
                ))
            }
        };
    }
    if !(0.0..TAU).contains(&value) {
        let shown = value.to_degrees();
        let message =
            format!("{axis} is a modulo axis, and {shown} degrees is not a position from 0 to below 360 degrees");
        let help = "write a position within the turn, or IC(…); if the control executes the word, its axis is not modulo: write \
                    travel_deg instead of modulo in the machine file";
        return Err(bad_value(span, message, help));
    }
    let within = here.rem_euclid(TAU);
    let forward = (value - within).rem_euclid(TAU);
    let is_same = !(SAME_RAD..=TAU - SAME_RAD).contains(&forward);
    let increment = context.control.increment_rad;
    let is_near = !(increment..=TAU - increment).contains(&forward);
    if is_known && is_near && matches!(way, RotaryDirection::Positive | RotaryDirection::Negative) {
        let message = format!("{axis} is already there: with ACP and ACN it makes a full turn, or does not move");
        return Err(fault(Code::WAY_OPEN, span, message, "program DC(…) to stay, IC(360) or IC(-360) for a full turn"));
    }
    // With ORIWKS the tool turns along a great circle between both directions, and the axes follow it: never around the rest of the turn.
    let follows_tool = context.setup.transform == Some(Turning::Vector)
        && context.machine.axis_set().iter().filter(|axis| axis.is_rotary()).count() > 1;
    let is_plain_shortest = context.control.modulo_shortest || follows_tool;
    let is_shortest = way == RotaryDirection::Shortest || way == RotaryDirection::Plain && is_plain_shortest;
    if is_known
        && is_shortest
        && (forward - PI).abs() <= increment
        && let Some(place) = ways.get_mut(axis.dimension())
    {
        *place = RotaryDirection::Either;
    }
    let step = match way {
        RotaryDirection::Plain if !is_plain_shortest => value - within,
        RotaryDirection::Positive | RotaryDirection::Negative if is_same => 0.0,
        RotaryDirection::Positive => forward,
        RotaryDirection::Negative => forward - TAU,
        _ if forward > PI => forward - TAU,
        _ => forward,
    };
    Ok(here + step)
}

/// Rejects a path motion in which the control may choose the direction: the other direction would cut elsewhere.
pub(super) fn check_either(
    ways: &[RotaryDirection; 3],
    is_positioning: bool,
    context: MotionContext<'_>,
) -> Result<(), Fault> {
    let Some(dimension) = ways.iter().position(|way| *way == RotaryDirection::Either) else { return Ok(()) };
    if is_positioning && context.setup.transform.is_none() {
        return Ok(());
    }
    let axis = ROTARY_AXES.get(dimension).copied().unwrap_or(Axis::C);
    let message = format!(
        "{axis} turns by exactly half a turn in the shortest direction: the control may turn in either direction"
    );
    Err(fault(Code::WAY_OPEN, context.span, message, "program ACP(…) or ACN(…), or IC(180) or IC(-180)"))
}

/// The warning for a rapid motion in which the control may choose the direction.
pub(super) fn either_way(ways: &[RotaryDirection; 3], span: Span) -> Option<Fault> {
    let dimension = ways.iter().position(|way| *way == RotaryDirection::Either)?;
    let axis = ROTARY_AXES.get(dimension).copied().unwrap_or(Axis::C);
    let message = format!(
        "{axis} turns by exactly half a turn in the shortest direction: the control may turn in either direction, and the correction may reverse it"
    );
    Some(fault(
        Code::EITHER_WAY,
        span,
        message,
        "check that it may turn in both directions here, or program ACP(…) or ACN(…); for CYCLE800, position the rotary axes before it, or choose the other solution with _DIR",
    ))
}
