//! Checks that the tool center path keeps its distance from contour elements that are not neighbors: bottlenecks.
//!
//! A piece that leaves the stage is compared with the elements near it in the program, before and after. A violation is held until it is known
//! whether the element is a wall: the first and last elements of a closed contour may lead onto it through the air.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::contour_request::Rules;
use super::curve::{Curve, distance};
use super::link::{Link, Role};
use super::moving::Moving;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::PlaneBasis;
use ncfix_base::source::{FileId, Span};

/// Tolerance of the distance, mm: rounding of the program's decimals.
const TOLERANCE_MM: f64 = 2e-3;
/// Missing angle below which an arc is a full circle, rad.
const FULL_CIRCLE: f64 = 1e-6;
/// Maximum number of elements that lead onto a closed contour, and off it.
const LEADING: usize = 3;
/// Length of the window as a multiple of the look-ahead.
const WINDOWS: usize = 3;

/// Common data of pieces and contour elements.
#[derive(Clone, Copy, Debug)]
struct Place {
    curve: Curve,
    /// Lowest and highest position of the tool.
    heights: (f64, f64),
    clearance_mm: f64,
    /// Distance of the curve's end from the programmed end.
    slack_mm: f64,
}

/// A contour element.
#[derive(Debug)]
struct Wall {
    place: Place,
    span: Span,
    file: FileId,
    /// `true` if it leads onto or off a closed contour.
    /// `true` if the language has CDON.
    has_cdon: bool,
    is_open: bool,
    /// The piece with the largest violation, `true` if under CDON, and the violation, mm.
    worst: Option<(Place, bool, f64)>,
}

/// The bottleneck check.
#[derive(Debug, Default)]
pub(super) struct Guard {
    /// The first ones are those of the whole contour, then the last ones.
    walls: VecDeque<Wall>,
    pieces: VecDeque<(Place, bool)>,
    /// Number of walls to come that lead off a closed contour.
    leading_off: usize,
    /// `true` after another error.
    is_off: bool,
}

impl Guard {
    /// The next contour element.
    pub(super) fn element(
        &mut self,
        basis: &PlaneBasis,
        moving: &Moving,
        contour: Curve,
        look_ahead: usize,
        findings: &mut Vec<Fault>,
    ) {
        // Rapid motion is in the air.
        if self.is_off || moving.path.motion.rapid {
            return;
        }
        let mut contour = contour;
        let closes = self.close(&mut contour);
        let mut wall = Wall {
            place: place(basis, moving, contour, moving.wish.distance_mm.abs()),
            span: moving.wish.span,
            file: moving.wish.file,
            is_open: self.leading_off > 0,
            has_cdon: moving.wish.modal.rules == Rules::Sinumerik,
            worst: None,
        };
        self.leading_off = if closes { LEADING } else { self.leading_off.saturating_sub(1) };
        for (piece, is_refused) in &self.pieces {
            wall.hold(piece, *is_refused);
        }
        self.walls.push_back(wall);
        if self.walls.len() > LEADING + (WINDOWS + 1) * look_ahead.max(1) + 2
            && let Some(old) = self.walls.remove(LEADING)
        {
            findings.extend(old.found());
        }
    }

    /// `true` if an element closes the contour; elements before and after the closing position are not part of it.
    fn close(&mut self, contour: &mut Curve) -> bool {
        if matches!(*contour, Curve::Arc { sweep, .. } if sweep.abs() > TAU - FULL_CIRCLE) {
            // A circle is closed by itself.
            self.walls.iter_mut().rev().take(LEADING).for_each(|wall| wall.is_open = true);
            return true;
        }
        let others = LEADING.min(self.walls.len().saturating_sub(1));
        for index in (0..others).rev() {
            let Some(wall) = self.walls.get_mut(index) else { break };
            let first = wall.place.curve;
            let through = first.crossings(contour).iter().find(|&point| first.passes(point) && contour.passes(point));
            if contour.passes(first.end()) {
                wall.is_open = true;
            } else if let Some(point) = through {
                wall.place.curve = first.part(first.along(point, 0.0), first.length());
                if let Some((piece, is_refused)) = wall.worst.take().map(|(piece, is_refused, _)| (piece, is_refused)) {
                    wall.hold(&piece, is_refused);
                }
                for (piece, is_refused) in &self.pieces {
                    wall.hold(piece, *is_refused);
                }
                *contour = contour.part(0.0, contour.along(point, contour.length()));
            } else if index > 0 || !contour.passes(first.start()) {
                continue;
            }
            for wall in self.walls.iter_mut().take(index) {
                wall.is_open = true;
            }
            return true;
        }
        false
    }

    /// Checks a final piece.
    pub(super) fn piece(&mut self, basis: &PlaneBasis, link: &Link, look_ahead: usize) {
        let moving = &link.moving;
        if self.is_off || link.role == Role::Approach || link.clearance_mm == 0.0 || moving.path.motion.rapid {
            return;
        }
        let piece = place(basis, moving, link.curve.part(link.from, link.to), link.clearance_mm);
        let is_refused = moving.wish.modal.collision;
        for wall in &mut self.walls {
            wall.hold(&piece, is_refused);
        }
        self.pieces.push_back((piece, is_refused));
        if self.pieces.len() > WINDOWS * look_ahead.max(1) {
            self.pieces.pop_front();
        }
    }

    /// Reports the violations; the check restarts.
    pub(super) fn end(&mut self, findings: &mut Vec<Fault>) {
        findings.extend(self.walls.drain(..).filter_map(|wall| wall.found()));
        *self = Guard::default();
    }

    /// Switches the check off, as the following motions cannot be evaluated.
    pub(super) fn switch_off(&mut self) {
        *self = Guard { is_off: true, ..Guard::default() };
    }
}

impl Wall {
    fn hold(&mut self, piece: &Place, is_refused: bool) {
        let wanted = piece.clearance_mm.min(self.place.clearance_mm) - piece.slack_mm - self.place.slack_mm;
        // Motion above the wall cuts material before it.
        if wanted <= TOLERANCE_MM || piece.heights.0 > self.place.heights.1 + TOLERANCE_MM {
            return;
        }
        let depth = wanted - piece.curve.gap(&self.place.curve, wanted);
        if depth > TOLERANCE_MM && self.worst.is_none_or(|(.., worst)| depth > worst) {
            self.worst = Some((*piece, is_refused, depth));
        }
    }

    fn found(&self) -> Option<Fault> {
        let (_, is_refused, depth) = self.worst.filter(|_| !self.is_open)?;
        let message = format!(
            "the tool cuts {depth:.4} mm into this element while it follows another one: the contour is narrower than the tool there"
        );
        let (code, help) = if is_refused {
            (Code::CONTOUR_NOT_FOLLOWED, "use a smaller tool; the look-ahead is control.compensation_look_ahead")
        } else if self.has_cdon {
            (Code::CONTOUR_DAMAGED, "use a smaller tool, or CDON, which skips what cannot be reached")
        } else {
            (Code::CONTOUR_DAMAGED, "use a smaller tool, or widen the contour")
        };
        Some(fault(code, self.span, message, help).of_file(self.file))
    }
}

/// Position and curve of a motion of a contour.
fn place(basis: &PlaneBasis, moving: &Moving, curve: Curve, clearance_mm: f64) -> Place {
    let (start, end) = (&moving.path.start, &moving.path.motion.target);
    let (from, to) = (basis.height(start), basis.height(end));
    let slack_mm = moving.curve(basis).map_or(0.0, |contour| distance(contour.end(), basis.flat(end)));
    Place { curve, heights: (from.min(to), from.max(to)), clearance_mm, slack_mm }
}
