//! Notation of positions of modulo axes, chosen so that the control takes the intended direction.

use std::f64::consts::{PI, TAU};

use ncfix_base::geometry::ROTARY_AXES;
use ncfix_machine::machine::{Machine, Rollover};
use ncfix_machine::snc::{Move, RotaryDirection, Turning};

use super::RotaryWord;
use super::place::{CommandSolver, Placed};
use super::standing::PathState;

/// Margin around half a turn within which the shortest direction is ambiguous, rad.
const HALF_TURN_ROOM: f64 = 1e-3;

/// The words of A, B and C at the end of a piece.
pub(super) fn words(
    placer: &CommandSolver<'_>,
    machine: &Machine,
    standing: &PathState,
    motion: &Move,
    placed: &Placed,
) -> [RotaryWord; 3] {
    let mut out = [RotaryWord::Plain; 3];
    if !machine.axes.iter().flatten().any(|data| data.modulo) {
        return out;
    }
    // With ORIWKS a word states the direction of the tool, and the axes go the short way to it.
    let follows_tool = placer.is_transformed() && placer.setup.transform == Some(Turning::Vector);
    let programmed = [&standing.command, &placed.command].map(|command| placer.programmed(command));
    for (axis, word) in ROTARY_AXES.into_iter().zip(&mut out) {
        // If positions count turns, they are written with them.
        let counts_turns = machine.control.rollover == Some(Rollover::None);
        if counts_turns || !machine.axis(axis).is_some_and(|data| data.modulo) {
            continue;
        }
        if !standing.known.contains(axis) {
            // The direction is unknown: written as in the program.
            *word = RotaryWord::Within(motion.ways.get(axis.dimension()).copied().unwrap_or_default());
            continue;
        }
        if motion.ways.get(axis.dimension()) == Some(&RotaryDirection::Either) {
            // The control decides, as in the program.
            *word = RotaryWord::Within(RotaryDirection::Either);
            continue;
        }
        let [from, to] = [programmed[0][axis], programmed[1][axis]];
        let step = to - from;
        let is_shortest =
            follows_tool || machine.control.modulo_shortest || machine.control.rollover == Some(Rollover::Shortest);
        let is_plain =
            if is_shortest { step.abs() < PI - HALF_TURN_ROOM } else { (from / TAU).floor() == (to / TAU).floor() };
        *word = if is_plain {
            RotaryWord::Within(RotaryDirection::Plain)
        } else if step.abs() < PI - HALF_TURN_ROOM {
            RotaryWord::Within(RotaryDirection::Shortest)
        } else if step.abs() >= TAU - HALF_TURN_ROOM {
            let slot = axis.slot();
            let last = standing.counts.get(slot).copied().unwrap_or_default();
            RotaryWord::Step(placed.counts.get(slot).copied().unwrap_or_default() - last)
        } else {
            RotaryWord::Within(if step > 0.0 { RotaryDirection::Positive } else { RotaryDirection::Negative })
        };
    }
    out
}
