//! G88: a slot. The longer of X and Y is its length, from the position in the direction of its sign; the other is its width.

use super::basis::{At, CycleFault, CycleWords, fault};
use super::pocket::Pocket;
use crate::exec::core::step::Step;

pub(super) fn steps(words: &CycleWords, at: &At) -> Result<Vec<Step>, CycleFault> {
    let pocket = Pocket::new(words, at)?;
    let (x, y) = (words.value(b'X'), words.value(b'Y'));
    let is_along = x.abs() >= y.abs();
    let (length, width) = if is_along { (x, y.abs()) } else { (y, x.abs()) };
    let sign = length.signum();
    let out = width / 2.0 - at.tool_radius_mm;
    if out < 0.0 {
        return Err(fault("the tool is wider than the slot", "use a smaller tool"));
    }
    // From the center of one arc to that of the other.
    let ends = if at.slot_from_arc_center {
        [0.0, length - sign * width]
    } else {
        [sign * width / 2.0, length - sign * width / 2.0]
    };
    let place = |along: f64, across: f64| pocket.place(if is_along { [along, across] } else { [-across, along] });
    let count = pocket.loops(out)?;
    let [near, far] = ends;
    let entry = if is_along { [near, 0.0] } else { [0.0, near] };
    Ok(pocket.steps(entry, |steps| {
        steps.push(Step::to(place(far, 0.0)));
        steps.push(Step::to(place(near, 0.0)));
        for k in (1..=count).filter(|_| out > 0.0) {
            let aside = out * f64::from(k) / f64::from(count);
            // Counter-clockwise: forward on the right side, back on the left.
            let side = if pocket.clockwise { sign } else { -sign } * aside;
            let arc = |at: f64, end: f64| Step::Arc {
                end: place(at, end),
                center: place(at, 0.0),
                clockwise: pocket.clockwise,
            };
            steps.push(Step::to(place(near, side)));
            steps.push(Step::to(place(far, side)));
            steps.push(arc(far, -side));
            steps.push(Step::to(place(near, -side)));
            steps.push(arc(near, side));
        }
        steps.push(Step::to(place(near, 0.0)));
    }))
}

#[cfg(test)]
mod tests {
    use super::super::basis::{At, CycleWords};
    use super::*;
    use crate::exec::core::step::Step;

    #[test]
    fn the_edge_touches_length_and_width() {
        let lists = [(40.0, 12.0, [0.0, 40.0, -6.0, 6.0]), (-40.0, 12.0, [-40.0, 0.0, -6.0, 6.0])];
        for (x, y, expected) in lists.into_iter().chain([(12.0, 40.0, [-6.0, 6.0, 0.0, 40.0])]) {
            let mut words = CycleWords::default();
            for (letter, value) in [(b'X', x), (b'Y', y), (b'Z', -2.0), (b'B', 1.0)] {
                words.set(letter, 0, value);
            }
            let at = At { tool_radius_mm: 4.0, engagement_percent: 60.0, ..At::default() };
            let mut bounds = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
            let mut note = |point: [f64; 2], reach: f64| {
                for axis in 0..2 {
                    bounds[2 * axis] = bounds[2 * axis].min(point[axis] - reach);
                    bounds[2 * axis + 1] = bounds[2 * axis + 1].max(point[axis] + reach);
                }
            };
            let mut last = [0.0; 2];
            for step in steps(&words, &at).unwrap() {
                match step {
                    Step::Line { plane: Some(point), .. } => {
                        note(point, 4.0);
                        last = point;
                    }
                    Step::Arc { end, center, clockwise } => {
                        // Half a turn about the center; its middle is on the outer side if counter-clockwise.
                        assert!(!clockwise);
                        let radius = [last[0] - center[0], last[1] - center[1]];
                        let middle = [center[0] - radius[1], center[1] + radius[0]];
                        note(middle, 4.0);
                        last = end;
                    }
                    _ => {}
                }
            }
            for (found, expected) in bounds.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9, "{bounds:?} of {x} {y}");
            }
        }
    }
}
