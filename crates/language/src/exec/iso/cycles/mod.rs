//! Canned cycles: the steps at one hole along the tool axis. [`super::drill`] determines the holes.
//!
//! To add a cycle, add a function in the file of its control, and an arm in the `steps` there.

pub(super) mod fanuc;
pub(super) mod rs274;
pub(super) mod threading;

use super::pattern::PeckWords;
use crate::exec::core::step::Turn;

/// Maximum number of steps of one hole.
const MOST_STEPS: usize = 100_000;

/// One step at a hole. Heights are program coordinates along the tool axis, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum HoleStep {
    /// At rapid along the tool axis.
    Rapid(f64),
    /// With feed along the tool axis.
    Feed(f64),
    /// At rapid in the plane, to this offset from the hole.
    Aside([f64; 2]),
    /// Dwell, s.
    Dwell(f64),
    /// A spindle command.
    Spindle(Turn),
    /// Program stop M0, for the operator.
    Stop,
    /// The operator has withdrawn the tool to this height.
    DrawnOut(f64),
}

/// One hole: heights are program coordinates along the tool axis, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Hole {
    /// The plane R.
    pub(super) r: f64,
    /// The bottom.
    pub(super) bottom: f64,
    /// Height of the tool after the hole.
    pub(super) clear: f64,
    /// P, s.
    pub(super) dwell_s: Option<f64>,
    /// Q: depth of one peck, or shift of the tool.
    pub(super) q: Option<f64>,
    /// Further words of the pecks of a Haas.
    pub(super) pecks: PeckWords,
    /// Clearance of a peck cycle from the remaining material, or its chip-breaking retraction, mm.
    pub(super) clearance: f64,
    /// Largest remainder of the depth that is not a peck, mm: rounding errors of sums if the control counts increments.
    pub(super) slack: f64,
    /// Shift of the tool with oriented spindle.
    pub(super) aside: Option<[f64; 2]>,
}

/// Reason why a hole has no steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct HoleFault {
    /// The error message without the code of the cycle.
    pub(super) message: String,
    /// The help text.
    pub(super) help: &'static str,
    /// `true` if the control supports it, but this program does not.
    pub(super) is_unsupported: bool,
}

fn wrong(message: impl Into<String>, help: &'static str) -> HoleFault {
    HoleFault { message: message.into(), help, is_unsupported: false }
}

/// Depths of the pecks from R on, ending at the bottom.
fn depths(hole: &Hole) -> Result<Vec<f64>, HoleFault> {
    if let Some(first) = hole.pecks.first {
        return decreasing(hole, first);
    }
    let Some(peck) = hole.q.filter(|peck| *peck > 0.0) else {
        return Err(wrong("the depth of one peck (Q) is not above 0", "give Q, the depth of one peck"));
    };
    let count = ((hole.r - hole.bottom) / peck).abs();
    if !count.is_finite() || count > (MOST_STEPS / 3) as f64 {
        return Err(wrong(format!("{count:.0} pecks in one hole"), "correct Q, R or Z"));
    }
    let towards = if hole.bottom < hole.r { -1.0 } else { 1.0 };
    let mut depths = Vec::new();
    // Summed one by one, as in the controls.
    let mut depth = hole.r + towards * peck;
    while (hole.bottom - depth) * towards > hole.slack {
        depths.push(depth);
        depth += towards * peck;
    }
    depths.push(hole.bottom);
    Ok(depths)
}

/// Depths of pecks that become smaller by J, down to K (G73 and G83 of a Haas).
fn decreasing(hole: &Hole, first: f64) -> Result<Vec<f64>, HoleFault> {
    let less = hole.pecks.less.unwrap_or(0.0);
    let least = hole.pecks.last.unwrap_or(first);
    if !(first > 0.0 && less >= 0.0 && least > 0.0) {
        return Err(wrong("I, J and K of the pecks are not above 0", "give I, J and K without a sign"));
    }
    let count = ((hole.r - hole.bottom) / least.min(first)).abs();
    if !count.is_finite() || count > (MOST_STEPS / 3) as f64 {
        return Err(wrong(format!("{count:.0} pecks in one hole"), "correct I, J, K, R or Z"));
    }
    let towards = if hole.bottom < hole.r { -1.0 } else { 1.0 };
    let (mut depths, mut peck) = (Vec::new(), first);
    let mut depth = hole.r + towards * peck;
    while (hole.bottom - depth) * towards > hole.slack {
        depths.push(depth);
        peck = (peck - less).max(least.min(peck));
        depth += towards * peck;
    }
    depths.push(hole.bottom);
    Ok(depths)
}

/// Pecks that clear the hole: out to R after each, and back to a clearance above the reached depth.
fn deep_hole(hole: &Hole) -> Result<Vec<HoleStep>, HoleFault> {
    let depths = depths(hole)?;
    let towards = if hole.bottom < hole.r { -1.0 } else { 1.0 };
    let mut steps = Vec::with_capacity(3 * depths.len() + 1);
    for (place, depth) in depths.iter().enumerate() {
        if let Some(reached) = place.checked_sub(1).and_then(|last| depths.get(last)) {
            steps.extend([HoleStep::Rapid(hole.r), HoleStep::Rapid(reached - towards * hole.clearance)]);
        }
        steps.push(HoleStep::Feed(*depth));
    }
    steps.push(HoleStep::Rapid(hole.clear));
    Ok(steps)
}

/// Pecks that break the chip: back by a clearance after each.
fn chip_breaking(hole: &Hole) -> Result<Vec<HoleStep>, HoleFault> {
    let depths = depths(hole)?;
    let towards = if hole.bottom < hole.r { -1.0 } else { 1.0 };
    let mut steps = Vec::with_capacity(2 * depths.len() + 1);
    // With Q, K of a Haas is the depth after which the tool clears the hole.
    let clears_after = hole.pecks.last.filter(|_| hole.pecks.first.is_none());
    let mut cleared = hole.r;
    for (place, depth) in depths.iter().enumerate() {
        if let Some(reached) = place.checked_sub(1).and_then(|last| depths.get(last)) {
            if clears_after.is_some_and(|after| (reached - cleared).abs() >= after - hole.slack) {
                steps.push(HoleStep::Rapid(hole.r));
                cleared = *reached;
            }
            steps.push(HoleStep::Rapid(reached - towards * hole.clearance));
        }
        steps.push(HoleStep::Feed(*depth));
    }
    steps.push(HoleStep::Rapid(hole.clear));
    Ok(steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pecks_end_at_the_bottom_whether_it_divides_or_not() {
        let hole = Hole { r: 2.0, bottom: -20.0, q: Some(8.0), ..Hole::default() };
        assert_eq!(depths(&hole).unwrap(), [-6.0, -14.0, -20.0]);
        let even = Hole { bottom: -22.0, ..hole };
        assert_eq!(depths(&even).unwrap(), [-6.0, -14.0, -22.0]);
        let deep = Hole { q: Some(100.0), ..hole };
        assert_eq!(depths(&deep).unwrap(), [-20.0]);
        let upwards = Hole { bottom: 20.0, ..hole };
        assert_eq!(depths(&upwards).unwrap(), [10.0, 18.0, 20.0]);
    }

    #[test]
    fn a_peck_of_nothing_or_of_next_to_nothing_is_refused() {
        let hole = Hole { r: 2.0, bottom: -20.0, ..Hole::default() };
        for q in [None, Some(0.0), Some(-1.0), Some(1e-9), Some(f64::NAN)] {
            assert!(depths(&Hole { q, ..hole }).is_err(), "{q:?}");
        }
        assert!(depths(&Hole { bottom: f64::NEG_INFINITY, q: Some(1.0), ..hole }).is_err());
    }
}
