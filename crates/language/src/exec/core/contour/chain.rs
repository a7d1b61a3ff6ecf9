//! The tool center path while it may still change: pieces that are cut back at intersections, or left out without one.

use std::collections::VecDeque;

use super::check::NARROW;
use super::curve::{Curve, Flat, SAME_MM};
use super::link::{Link, Role};
use super::moving::Item;
use crate::exec::core::fault::Fault;
use ncfix_base::diagnostic::Code;

/// Largest violation of the radius at an element that is left out, mm.
const GOUGE_MM: f64 = 1e-6;

/// Minimum distance of a crossing from the ends of pieces that are not neighbors, mm.
const INSIDE_MM: f64 = 1e-4;
/// Violation of the radius at an element that may result from the decimals of the program, mm.
const CLEAR_MM: f64 = 1e-3;

/// Pieces, oldest first.
#[derive(Debug, Default)]
pub(super) struct Chain {
    pub(super) links: VecDeque<Link>,
    /// Elements after the pieces without intersection with the chain: too short for the tool.
    pub(super) waiting: Vec<Link>,
    /// Items before the first piece.
    pub(super) first_items: Vec<Item>,
}

/// The intersection of two pieces.
struct Meeting {
    index: usize,
    /// Length along the piece of the chain, and along the new one.
    end: f64,
    start: f64,
}

impl Chain {
    /// Items after the last piece.
    pub(super) fn tail(&mut self) -> &mut Vec<Item> {
        match (self.waiting.last_mut(), self.links.back_mut()) {
            (Some(link), _) | (None, Some(link)) => &mut link.items,
            (None, None) => &mut self.first_items,
        }
    }

    /// Appends a piece that begins at the end of the last one.
    pub(super) fn push(&mut self, link: Link) {
        self.links.push_back(link);
    }

    /// Appends a piece that touches the end of the last element; if that was too short for the tool, cuts back.
    pub(super) fn push_touching(&mut self, link: Link, most: usize, findings: &mut Vec<Fault>) {
        if self.waiting.is_empty() {
            self.push(link);
        } else {
            self.cut(link, most, findings);
        }
    }

    /// Appends a piece that crosses the last ones: both are cut at the crossing, and pieces between are left out. `hint` is an intersection to use if
    /// the last piece and this one almost cross.
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
        let later = self.links.split_off(found.index + 1);
        let dropped: Vec<Link> = later.into_iter().chain(self.waiting.drain(..)).collect();
        self.leave_out(dropped, found.end, findings);
        link.from = found.start;
        self.links.push_back(link);
    }

    /// Cuts the last piece back and leaves out the pieces after it.
    fn leave_out(&mut self, dropped: Vec<Link>, end: f64, findings: &mut Vec<Fault>) {
        let mut items = Vec::new();
        for dropped in dropped {
            if dropped.role == Role::Contour {
                findings.push(dropped.moving.fault(
                    Code::ELEMENT_LEFT_OUT,
                    format!(
                        "the tool, {:.4} mm from the contour, cannot reach this element; the control skips it",
                        dropped.clearance_mm
                    ),
                    "check whether a smaller tool is intended",
                ));
            }
            dropped.into_items(&mut items);
        }
        if let Some(old) = self.links.back_mut() {
            old.to = end;
            old.items.append(&mut items);
        }
    }

    /// CDON: if a piece crosses an earlier one that is not its neighbor, pieces between them that would damage the contour are left out. The last
    /// piece can still be cut back and is examined only if nothing follows it.
    pub(super) fn skip_bottlenecks(&mut self, is_end: bool, most: usize, findings: &mut Vec<Fault>) {
        let mut index = 0;
        while index + usize::from(!is_end) < self.links.len() {
            let Some(link) = self.links.get_mut(index) else { return };
            if !std::mem::replace(&mut link.is_checked, true)
                && link.moving.wish.modal.collision
                && let Some(found) = self.bottleneck(index, most)
            {
                let mut later = self.links.split_off(found.index + 1);
                let behind = later.split_off(index - found.index - 1);
                self.leave_out(later.into(), found.end, findings);
                index = found.index + 1;
                self.links.extend(behind);
                if let Some(link) = self.links.get_mut(index) {
                    link.from = found.start;
                }
            }
            index += 1;
        }
    }

    /// The crossing of a piece with one before its neighbor, if the path between them damages the contour.
    fn bottleneck(&self, later: usize, most: usize) -> Option<Meeting> {
        let link = self.links.get(later)?;
        let mut left_out = 0;
        for index in (0..later).rev() {
            let old = self.links.get(index)?;
            if old.is_sealed || left_out > most {
                return None;
            }
            // Touching pieces are neighbors or intended.
            if old.contour.gap(&link.contour, CLEAR_MM) < CLEAR_MM {
                left_out += usize::from(old.role == Role::Contour);
                continue;
            }
            let mut best: Option<Meeting> = None;
            for point in old.curve.crossings(&link.curve).iter() {
                let end = old.curve.along(point, old.to);
                let start = link.curve.along(point, link.from);
                let is_inside = |at: f64, link: &Link| at > link.from + INSIDE_MM && at < link.to - INSIDE_MM;
                let found = Meeting { index, end, start };
                let is_better = best.as_ref().is_none_or(|best| end < best.end);
                if is_inside(end, old) && is_inside(start, link) && is_better && self.is_damaged(&found, later, point) {
                    best = Some(found);
                }
            }
            if best.is_some() {
                return best;
            }
            left_out += usize::from(old.role == Role::Contour);
        }
        None
    }

    /// `true` if the path between two crossing pieces damages the contour, and does not after removing it.
    fn is_damaged(&self, found: &Meeting, later: usize, point: Flat) -> bool {
        let loops: Vec<&Link> = self.links.range(found.index..=later).collect();
        let part = |at: usize, link: &Link| match at {
            0 => link.curve.part(found.end, link.to),
            _ if at == later - found.index => link.curve.part(link.from, found.start),
            _ => link.curve.part(link.from, link.to),
        };
        let keeps = |link: &Link| link.clearance_mm - CLEAR_MM;
        loops.iter().all(|link| link.contour.distance(point) >= keeps(link))
            && loops.iter().enumerate().any(|(at, link)| {
                let way = part(at, link);
                loops.iter().any(|wall| way.gap(&wall.contour, keeps(wall)) < keeps(wall))
            })
    }

    /// The crossing of a new piece with one of the last `depth` pieces.
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

    /// The intersection of the last piece and a new one at a point that is almost on both.
    fn meeting_at(&self, link: &Link, point: Flat) -> Option<Meeting> {
        let old = self.links.back().filter(|old| self.waiting.is_empty() && !old.is_sealed)?;
        let (end, start) = (old.curve.along(point, old.to), link.curve.along(point, 0.0));
        let fits = end > old.from && start < link.to;
        fits.then_some(Meeting { index: self.links.len() - 1, end, start })
    }

    /// `true` if the tool at a point keeps clear of everything that would be left out after a piece.
    fn is_clear(&self, point: Flat, index: usize) -> bool {
        let dropped = self.links.iter().skip(index + 1).chain(&self.waiting);
        dropped.into_iter().all(|link| link.contour.distance(point) >= link.clearance_mm - GOUGE_MM)
    }

    /// Stores a new piece without intersection: a following one may intersect.
    fn wait(&mut self, link: Link, most: usize, findings: &mut Vec<Fault>) {
        self.waiting.push(link);
        if self.waiting.iter().filter(|link| link.role == Role::Contour).count() > most {
            self.give_up(findings);
        }
    }

    /// Reports waiting elements without intersection. Returns `true` if there were any.
    pub(super) fn give_up(&mut self, findings: &mut Vec<Fault>) -> bool {
        let Some(first) = self.waiting.first() else { return false };
        let message = match first.contour {
            Curve::Arc { radius, .. } => format!(
                "this arc of radius {radius:.4} mm cannot be followed at a distance of {:.4} mm: the tool center paths do not meet",
                first.clearance_mm
            ),
            Curve::Line { .. } => format!(
                "this element cannot be followed at a distance of {:.4} mm: the tool center paths do not meet",
                first.clearance_mm
            ),
        };
        findings.push(first.moving.fault(
            Code::CONTOUR_NOT_FOLLOWED,
            message,
            &format!("{NARROW}; the look-ahead is control.compensation_look_ahead"),
        ));
        for link in std::mem::take(&mut self.waiting) {
            self.links.push_back(link);
        }
        true
    }

    /// The contour elements of the chain.
    pub(super) fn elements(&self) -> usize {
        self.links.iter().filter(|link| link.role != Role::Corner).count()
    }
}
