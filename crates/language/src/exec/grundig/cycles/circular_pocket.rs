//! G89: a circular pocket of radius R about the position.

use super::basis::{At, CycleFault, CycleWords, fault};
use super::pocket::Pocket;
use crate::exec::core::step::Step;

pub(super) fn steps(words: &CycleWords, at: &At) -> Result<Vec<Step>, CycleFault> {
    let pocket = Pocket::new(words, at)?;
    let widest = words.value(b'R') - at.tool_radius_mm;
    if widest < 0.0 {
        return Err(fault("the tool is wider than the pocket", "use a smaller tool"));
    }
    let count = pocket.loops(widest)?;
    let center = pocket.place([0.0, 0.0]);
    Ok(pocket.steps([0.0, 0.0], |steps| {
        if widest == 0.0 {
            return;
        }
        for k in 1..=count {
            let end = pocket.place([widest * f64::from(k) / f64::from(count), 0.0]);
            steps.push(Step::to(end));
            steps.push(Step::Arc { end, center, clockwise: pocket.clockwise });
        }
        steps.push(Step::to(center));
    }))
}
