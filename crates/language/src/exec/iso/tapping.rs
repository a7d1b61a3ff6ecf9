//! Tapping that the control executes: spindle and axis turn together, which single moves do not.
//!
//! The tool goes to the corrected place of the hole and to R. The cycle follows without X and Y, and G80 ends it. M29 stands in front of it, because no
//! axis may move between the two. Depth and R are those of the program.

use super::channel::Channel;
use super::codes::name_of;
use super::gathered::Gathered;
use super::text;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::step::Step;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisVector, Frame, Matrix};
use ncfix_base::source::Span;
use ncfix_machine::snc::Kind;
use std::fmt::Write as _;

/// A hole to tap.
pub(super) struct TappedHole<'a> {
    /// G74, G84, G84.2 or G84.3 in tenths.
    pub(super) code: u16,
    /// The programmed position at R.
    pub(super) level: AxisVector,
    /// Q: the depth of one peck, mm.
    pub(super) peck: Option<f64>,
    /// The moves in the hole.
    pub(super) steps: &'a [Step],
}

/// Largest deviation of a rotation matrix from one that keeps lengths.
const SAME_LENGTH: f64 = 1e-9;

/// `true` if a call at the corrected place can replace the cycle: the plane may be turned or mirrored, but not scaled, and no rotary axis turns in the block.
pub(super) fn may_stay(channel: &Channel<'_>, gathered: &Gathered) -> bool {
    let keeps_lengths = |frame: &Frame| {
        let linear = frame.linear();
        (linear.tr_mul(linear) - Matrix::identity()).amax() < SAME_LENGTH
    };
    let frames = [&channel.standing.setup.frame, &channel.standing.shown.frame];
    frames.into_iter().all(keeps_lengths) && gathered.axes.iter().all(|axis| !axis.is_rotary())
}

/// Rejects a tapping cycle that [`tap`] cannot write, and that `is_call` says is no call at the corrected place either.
pub(super) fn check(
    channel: &Channel<'_>,
    gathered: &Gathered,
    (code, is_call): (u16, bool),
    span: Span,
) -> Result<(), Fault> {
    let name = name_of(code);
    let (message, help) = if !may_stay(channel, gathered) {
        let message = format!("{name} is rigid tapping, which stays a cycle, in a scaled system or with a rotary axis");
        (message, "end the scaling before it, and turn the rotary axis in its own block")
    } else if is_call {
        return Ok(());
    } else {
        let frames = [&channel.standing.setup.frame, &channel.standing.shown.frame];
        if frames.iter().all(|frame| frame.is_translation()) && channel.special.polar.is_none() {
            return Ok(());
        }
        let message =
            format!("{name} is rigid tapping in a rotated system, where its holes cannot be written one by one");
        (message, "end the rotation before it, or correct without --expand-cycles and --feed-limit")
    };
    Err(fault(Code::NOT_SUPPORTED, span, message, help))
}

/// Writes the cycle of one hole.
pub(super) fn tap(channel: &mut Channel<'_>, hole: &TappedHole<'_>, span: Span) -> Result<(), Fault> {
    let applicate = channel.modal.modes.plane.axes()[2];
    let r = hole.level[applicate];
    let depths = hole.steps.iter().filter_map(|step| match step {
        Step::Line { height, .. } => *height,
        _ => None,
    });
    let bottom =
        depths.fold(r, |deepest, height| if (height - r).abs() > (deepest - r).abs() { height } else { deepest });
    if bottom == r {
        let message = format!("{} without a depth", name_of(hole.code));
        return Err(fault(Code::BAD_WORD_VALUE, span, message, "program Z below R"));
    }
    let shown = |height: f64| {
        let mut position = hole.level;
        position[applicate] = height;
        channel.standing.shown.programmed(&channel.standing.setup.command(&position))[applicate]
    };
    let (bottom, r) = (shown(bottom), shown(r));
    let (machine, language) = (channel.settings.machine, channel.language);
    let mut cycle = format!("G98 {}", name_of(hole.code));
    text::append_length(machine, language, &mut cycle, applicate.letter(), bottom);
    text::append_length(machine, language, &mut cycle, b'R', r);
    let dwell = hole.steps.iter().find_map(|step| match step {
        Step::Dwell(seconds) if *seconds > 0.0 => Some(*seconds),
        _ => None,
    });
    if let Some(seconds) = dwell {
        // Writing to a string cannot fail.
        let _ = write!(cycle, " P{:.0}", seconds * 1000.0);
    }
    if let Some(peck) = hole.peck.filter(|peck| *peck != 0.0) {
        text::append_length(machine, language, &mut cycle, b'Q', peck);
    }
    text::append_length(machine, language, &mut cycle, b'F', channel.modal.modes.feed);
    if channel.cycles.is_rigid {
        let speed = channel.modal.modes.speed.map(|_| channel.modal.speed_word);
        let start = speed.map_or_else(|| "M29".to_owned(), |speed| format!("M29 S{speed:.0}"));
        channel.push(Kind::Verbatim(start.into_bytes()));
        channel.outlet.begin_line();
    }
    channel.push(Kind::Verbatim(cycle.into_bytes()));
    channel.outlet.begin_line();
    channel.push(Kind::Verbatim(b"G80".to_vec()));
    Ok(())
}
