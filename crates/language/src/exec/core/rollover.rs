//! Absolute positions of modulo axes on controls without words for the direction: a parameter of the control determines it (Fanuc parameter 1008;
//! WRAPPED_ROTARY of LinuxCNC).

use std::f64::consts::{PI, TAU};

use super::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_base::source::Span;
use ncfix_machine::machine::{Machine, Rollover};

/// Target of an absolute word, counted from `here` with its turns, rad. `here` is `None` if the program has not stated it.
pub(in crate::exec) fn position(
    machine: &Machine,
    axis: Axis,
    value: f64,
    here: Option<f64>,
    span: Span,
) -> Result<f64, Fault> {
    if !machine.axis(axis).is_some_and(|data| data.modulo) {
        return Ok(value);
    }
    let open = |message: String, help: &str| Err(fault(Code::WAY_OPEN, span, message, help));
    match (machine.control.rollover, here) {
        (None, _) => open(
            format!(
                "the direction in which {axis} turns to an absolute position depends on a parameter of the control"
            ),
            "set control.rollover in the machine file: \"none\" or \"shortest\" (Fanuc parameter 1008, WRAPPED_ROTARY), or program G91",
        ),
        (Some(Rollover::None), _) | (_, None) => Ok(value),
        (Some(Rollover::Shortest), Some(here)) => {
            let forward = (value - here).rem_euclid(TAU);
            if (forward - PI).abs() <= machine.control.increment_rad {
                return open(
                    format!(
                        "{axis} turns by exactly half a turn in the shortest direction: the control may turn in either direction"
                    ),
                    "move in two blocks, or program G91",
                );
            }
            Ok(here + if forward > PI { forward - TAU } else { forward })
        }
    }
}
