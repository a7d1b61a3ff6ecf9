//! Motions whose end is determined by the next one: they wait in the stage until it is known.

use super::curve::{Curve, Flat, add};
use super::moving::{Item, Moving};
use super::stage::{ContourStage, OpenLine};
use ncfix_base::geometry::{AxisSet, AxisVector};

/// Maximum number of items waiting after a motion without end.
const MOST_WAITING: usize = 1000;

impl ContourStage {
    pub(in crate::exec) fn open(&mut self, moving: Box<Moving>) {
        self.open = Some(OpenLine { moving, behind: Vec::new() });
    }

    /// Stores an item after a motion without end; returns it if there is none.
    pub(super) fn behind_open(&mut self, item: Item) -> Option<Item> {
        match &mut self.open {
            Some(open) if open.behind.len() < MOST_WAITING => {
                open.behind.push(item);
                None
            }
            _ => Some(item),
        }
    }

    /// Sets the end, or that there is none: the motion and the items after it proceed.
    pub(in crate::exec) fn close(&mut self, end: Option<AxisVector>, axes: AxisSet, out: &mut Vec<Item>) {
        let Some(mut open) = self.open.take() else { return };
        if let Some(end) = end {
            let motion = &mut open.moving.path.motion;
            motion.target = end;
            motion.named = motion.named.union(axes);
            motion.known = motion.known.union(axes);
        }
        self.take(Item::Path(open.moving), out);
        for item in open.behind {
            self.take(item, out);
        }
    }
}

/// The intersection of two straight lines, each given by a point and the angle to the abscissa, rad; `None` if they are parallel.
pub(in crate::exec) fn crossing(first: (Flat, f64), second: (Flat, f64)) -> Option<Flat> {
    let line = |(start, angle): (Flat, f64)| Curve::Line { start, end: add(start, [angle.cos(), angle.sin()]) };
    let found = line(first).crossings(&line(second)).iter().next();
    found.filter(|point| point.iter().all(|value| value.abs() < 1e9))
}
