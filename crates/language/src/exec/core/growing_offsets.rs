//! Zero offsets to which each run of a program adds.

use super::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, FrameParts};
use ncfix_machine::snc::Origin;

/// Smallest change of an offset in one run that is named, mm: errors of 50 µm/m change by 0.05 µm.
const NAMED_MM: f64 = 1.0;
/// Smallest change of a rotary axis or a rotation that is named, rad.
const NAMED_RAD: f64 = 1e-3;

/// The warning for a zero offset that differs after the run from its value before, because the program has added to it; `None` if the difference is small. `axes` and `turns`: the parts to which it has added.
pub(in crate::exec) fn grown(
    words: &str,
    origin: Origin,
    [before, after]: [&FrameParts; 2],
    (axes, turns): (AxisSet, bool),
) -> Option<Fault> {
    let shifts = axes.iter().filter_map(|axis| {
        let change = after.shift()[axis] - before.shift()[axis];
        let (named, shown) = if axis.is_rotary() { (NAMED_RAD, change.to_degrees()) } else { (NAMED_MM, change) };
        (change.abs() >= named)
            .then(|| format!("{axis} by {:.4}", shown).trim_end_matches('0').trim_end_matches('.').to_owned())
    });
    let turns = turns && (0..3).any(|slot| (after.rotation[slot] - before.rotation[slot]).abs() >= NAMED_RAD);
    let changes: Vec<String> = shifts.chain(turns.then(|| "its rotation".to_owned())).collect();
    if changes.is_empty() {
        return None;
    }
    let message = format!("each run of the program changes {words} again: {}", changes.join(", "));
    let help = "the correction is computed for the present value of the offset, thus for the next run only: correct the program again before each run, or set the offset to a number at the start of the program";
    Some(fault(Code::GROWING_OFFSET, origin.span, message, help).of_file(origin.file))
}
