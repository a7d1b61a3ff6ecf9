//! G87: a rectangular pocket X by Y about the position, with corners rounded by R or by the tool radius.

use super::basis::{At, CycleFault, CycleWords, fault};
use super::pocket::Pocket;
use crate::exec::core::step::Flat;
use crate::exec::core::step::Step;

pub(super) fn steps(words: &CycleWords, at: &At) -> Result<Vec<Step>, CycleFault> {
    let pocket = Pocket::new(words, at)?;
    let (length, width) = (words.value(b'X').abs(), words.value(b'Y').abs());
    let corner = words.get(b'R', 0).unwrap_or(0.0);
    let across = [length / 2.0 - at.tool_radius_mm, width / 2.0 - at.tool_radius_mm];
    if across.iter().any(|&half| half < 0.0) {
        return Err(fault("the tool is wider than the pocket", "use a smaller tool"));
    }
    if corner < 0.0 || corner > length.min(width) / 2.0 + 1e-9 {
        return Err(fault(
            format!("R={corner} is not a valid corner radius of this pocket"),
            "at most half the shorter side",
        ));
    }
    let shorter = across[0].min(across[1]);
    let beyond = [across[0] - shorter, across[1] - shorter];
    let count = pocket.loops(shorter)?;
    // Of the path of the tool center.
    let rounding = (corner - at.tool_radius_mm).max(0.0).min(shorter);
    Ok(pocket.steps([0.0, 0.0], |steps| {
        if beyond[0] > 0.0 || beyond[1] > 0.0 {
            steps.push(Step::to(pocket.place(beyond)));
            steps.push(Step::to(pocket.place([-beyond[0], -beyond[1]])));
        }
        for k in (1..=count).filter(|_| shorter > 0.0) {
            let out = shorter * f64::from(k) / f64::from(count);
            let half = [beyond[0] + out, beyond[1] + out];
            around(&pocket, half, if k == count { rounding } else { 0.0 }, steps);
        }
        steps.push(Step::to(pocket.place([0.0, 0.0])));
    }))
}

/// One loop, from the middle of the side at the positive abscissa.
fn around(pocket: &Pocket<'_>, half: Flat, rounding: f64, steps: &mut Vec<Step>) {
    // Mirroring the ordinate makes the loop clockwise.
    let sense = if pocket.clockwise { -1.0 } else { 1.0 };
    let place = |x: f64, y: f64| pocket.place([x, y * sense]);
    let start = place(half[0], 0.0);
    steps.push(Step::to(start));
    for (x, y, is_upright) in [(1.0, 1.0, true), (-1.0, 1.0, false), (-1.0, -1.0, true), (1.0, -1.0, false)] {
        let corner = [x * half[0], y * half[1]];
        if rounding <= 0.0 {
            steps.push(Step::to(place(corner[0], corner[1])));
            continue;
        }
        let center = [corner[0] - x * rounding, corner[1] - y * rounding];
        let (upright, level) = ([corner[0], center[1]], [center[0], corner[1]]);
        let (from, end) = if is_upright { (upright, level) } else { (level, upright) };
        steps.push(Step::to(place(from[0], from[1])));
        let (end, center) = (place(end[0], end[1]), place(center[0], center[1]));
        steps.push(Step::Arc { end, center, clockwise: pocket.clockwise });
    }
    steps.push(Step::to(start));
}

#[cfg(test)]
mod tests {
    use super::super::basis::{At, CycleWords};
    use super::*;
    use crate::exec::core::step::Step;

    /// Largest distance of an uncut inner point from the cut region, and `true` if anything outside was cut, on a grid: the region is sampled by the
    /// tool disc along the path.
    fn left_and_gouged(length: f64, width: f64, corner: f64, radius: f64, percent: f64, sense: f64) -> (f64, bool) {
        let mut words = CycleWords::default();
        for (letter, value) in
            [(b'X', length), (b'Y', width), (b'Z', -2.0), (b'B', 1.0), (b'R', corner), (b'I', percent), (b'J', sense)]
        {
            words.set(letter, 0, value);
        }
        let at = At { tool_radius_mm: radius, ..At::default() };
        let mut way: Vec<Flat> = vec![[0.0, 0.0]];
        for step in steps(&words, &at).unwrap() {
            let from = *way.last().unwrap();
            match step {
                Step::Line { plane: Some(to), .. } => {
                    let count = ((to[0] - from[0]).hypot(to[1] - from[1]) / 0.02).ceil().max(1.0);
                    (1..=count as u32).for_each(|k| {
                        let share = f64::from(k) / count;
                        way.push([from[0] + (to[0] - from[0]) * share, from[1] + (to[1] - from[1]) * share]);
                    });
                }
                Step::Arc { end, center, clockwise } => {
                    let angle = |p: Flat| (p[1] - center[1]).atan2(p[0] - center[0]);
                    let size = (from[0] - center[0]).hypot(from[1] - center[1]);
                    assert!((size - (end[0] - center[0]).hypot(end[1] - center[1])).abs() < 1e-9);
                    let mut sweep = angle(end) - angle(from);
                    if clockwise && sweep >= 0.0 {
                        sweep -= std::f64::consts::TAU;
                    } else if !clockwise && sweep <= 0.0 {
                        sweep += std::f64::consts::TAU;
                    }
                    assert!(sweep.abs() < 1.6, "a corner is a quarter");
                    for k in 1..=50 {
                        let at = angle(from) + sweep * f64::from(k) / 50.0;
                        way.push([center[0] + size * at.cos(), center[1] + size * at.sin()]);
                    }
                }
                _ => {}
            }
        }
        let inside = |p: Flat, by: f64| {
            let (x, y) = (p[0].abs() - (length / 2.0 - corner), p[1].abs() - (width / 2.0 - corner));
            if x > 0.0 && y > 0.0 { x.hypot(y) <= corner - by } else { x <= corner - by && y <= corner - by }
        };
        let mut left = 0.0_f64;
        let grid = 0.25;
        let count = |size: f64| (size / 2.0 / grid) as i32;
        for i in -count(length)..=count(length) {
            for j in -count(width)..=count(width) {
                let p = [f64::from(i) * grid, f64::from(j) * grid];
                if inside(p, 0.0) {
                    let near = way.iter().map(|w| (w[0] - p[0]).hypot(w[1] - p[1])).fold(f64::INFINITY, f64::min);
                    left = left.max(near - radius);
                }
            }
        }
        (left, way.iter().any(|&p| !inside(p, radius - 1e-9)))
    }

    #[test]
    fn the_pocket_is_cleared_and_nothing_else() {
        for (length, width, corner, radius, percent, sense) in
            [(40.0, 24.0, 6.0, 4.0, 85.0, 1.0), (20.0, 30.0, 5.0, 3.0, 60.0, -1.0), (16.0, 16.0, 8.0, 2.5, 85.0, 1.0)]
        {
            let (left, gouged) = left_and_gouged(length, width, corner, radius, percent, sense);
            // The path is sampled every 0.02 mm.
            assert!(left < 0.01, "{left} mm is left of {length} x {width}");
            assert!(!gouged, "{length} x {width} is gouged");
        }
    }
}
