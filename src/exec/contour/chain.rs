//! The way of the tool center while it may still change: pieces that are cut back where they meet, or left out where they do not.

use std::collections::VecDeque;

use super::curve::{Curve, Flat, SAME_MM};
use super::link::{Link, Role};
use super::moving::Item;
use crate::diagnostic::Code;
use crate::exec::fault::Fault;

/// How much nearer than the radius the tool may come to an element that is left out, mm.
const GOUGE_MM: f64 = 1e-6;

/// Pieces, oldest first.
#[derive(Debug, Default)]
pub(super) struct Chain {
    pub(super) links: VecDeque<Link>,
    /// Elements behind them that nothing of the chain meets: too short for the tool.
    pub(super) waiting: Vec<Link>,
    /// Items before the first piece.
    pub(super) first_items: Vec<Item>,
}

/// Where two pieces meet.
struct Meeting {
    index: usize,
    /// Length along the piece of the chain, and along the new one.
    end: f64,
    start: f64,
}

impl Chain {
    /// Items behind the last piece.
    pub(super) fn tail(&mut self) -> &mut Vec<Item> {
        match (self.waiting.last_mut(), self.links.back_mut()) {
            (Some(link), _) | (None, Some(link)) => &mut link.items,
            (None, None) => &mut self.first_items,
        }
    }

    /// Appends a piece that begins where the last one ends.
    pub(super) fn push(&mut self, link: Link) {
        self.links.push_back(link);
    }

    /// Appends a piece that touches the end of the last element; where that was too short for the tool, cuts back.
    pub(super) fn push_touching(&mut self, link: Link, most: usize, findings: &mut Vec<Fault>) {
        if self.waiting.is_empty() {
            self.push(link);
        } else {
            self.cut(link, most, findings);
        }
    }

    /// Appends a piece that crosses the last ones: both are cut at the crossing; pieces between are left out.
    /// `hint` is a place for both that does where the last piece and this one do not quite cross.
    pub(super) fn cut(&mut self, link: Link, most: usize, findings: &mut Vec<Fault>) {
        self.cut_at(link, None, most, findings);
    }

    pub(super) fn cut_at(&mut self, mut link: Link, hint: Option<Flat>, most: usize, findings: &mut Vec<Fault>) {
        let neighbor = if self.waiting.is_empty() { self.meeting(&link, self.links.len(), 1, most) } else { None };
        let neighbor = neighbor.or_else(|| self.meeting_at(&link, hint?));
        let Some(found) = neighbor.or_else(|| self.meeting(&link, self.links.len(), usize::MAX, most)) else {
            self.wait(link, most, findings);
            return;
        };
        let mut items = Vec::new();
        let later = self.links.split_off(found.index + 1);
        for dropped in later.into_iter().chain(self.waiting.drain(..)) {
            if dropped.role == Role::Contour {
                findings.push(dropped.moving.fault(
                    Code::ELEMENT_LEFT_OUT,
                    format!(
                        "the tool, {:.4} mm beside the contour, cannot reach this element; the control leaves it out",
                        dropped.clearance_mm
                    ),
                    "check that a smaller tool is not meant",
                ));
            }
            dropped.into_items(&mut items);
        }
        if let Some(old) = self.links.back_mut() {
            old.to = found.end;
            old.items.append(&mut items);
        }
        link.from = found.start;
        self.links.push_back(link);
    }

    /// Where a new piece crosses one of the last `depth` pieces.
    fn meeting(&self, link: &Link, count: usize, depth: usize, most: usize) -> Option<Meeting> {
        let mut left_out = self.waiting.iter().filter(|link| link.role == Role::Contour).count();
        for index in (0..count).rev().take(depth) {
            let old = self.links.get(index)?;
            if old.is_sealed || left_out > most {
                return None;
            }
            let mut best: Option<Meeting> = None;
            for point in old.curve.crossings(&link.curve).iter() {
                let end = old.curve.along(point, old.to);
                let start = link.curve.along(point, 0.0);
                // Of several, the one nearest to the start of the new element.
                let is_on_both =
                    end > old.from - SAME_MM && end <= old.to + SAME_MM && start >= -SAME_MM && start < link.to;
                let is_better = best.as_ref().is_none_or(|best| start < best.start);
                if is_on_both && is_better && self.is_clear(point, index) {
                    best = Some(Meeting { index, end: end.clamp(old.from, old.to), start: start.max(0.0) });
                }
            }
            if best.is_some() {
                return best;
            }
            left_out += usize::from(old.role == Role::Contour);
        }
        None
    }

    /// The last piece and a new one at a point that is nearly on both.
    fn meeting_at(&self, link: &Link, point: Flat) -> Option<Meeting> {
        let old = self.links.back().filter(|old| self.waiting.is_empty() && !old.is_sealed)?;
        let (end, start) = (old.curve.along(point, old.to), link.curve.along(point, 0.0));
        let fits = end > old.from && start < link.to;
        fits.then_some(Meeting { index: self.links.len() - 1, end, start })
    }

    /// Whether the tool at a point keeps clear of all that would be left out behind a piece.
    fn is_clear(&self, point: Flat, index: usize) -> bool {
        let dropped = self.links.iter().skip(index + 1).chain(&self.waiting);
        dropped.into_iter().all(|link| link.contour.distance(point) >= link.clearance_mm - GOUGE_MM)
    }

    /// Nothing meets the new piece: perhaps something does what follows.
    fn wait(&mut self, link: Link, most: usize, findings: &mut Vec<Fault>) {
        self.waiting.push(link);
        if self.waiting.iter().filter(|link| link.role == Role::Contour).count() > most {
            self.give_up(findings);
        }
    }

    /// Elements wait that nothing meets any more.
    pub(super) fn give_up(&mut self, findings: &mut Vec<Fault>) {
        let Some(first) = self.waiting.first() else { return };
        let message = match first.contour {
            Curve::Arc { radius, .. } => format!(
                "this arc of radius {radius:.4} mm cannot be followed {:.4} mm beside it: the ways of the tool center do not meet",
                first.clearance_mm
            ),
            Curve::Line { .. } => format!(
                "this element cannot be followed {:.4} mm beside it: the ways of the tool center do not meet",
                first.clearance_mm
            ),
        };
        findings.push(first.moving.fault(
            Code::CONTOUR_NOT_FOLLOWED,
            message,
            "use a smaller tool, or change the contour; the look-ahead is control.compensation_look_ahead",
        ));
        for link in std::mem::take(&mut self.waiting) {
            self.links.push_back(link);
        }
    }

    /// The contour elements of the chain.
    pub(super) fn elements(&self) -> usize {
        self.links.iter().filter(|link| link.role != Role::Corner).count()
    }
}
