//! Converts paths in base coordinates to axis moves.

use super::curve_arcs;
use super::five_axis;
use super::motion_sink::MotionSink;
use super::path::{Path, Shape, tilted_arc};
use super::sagitta;
use ncfix_base::geometry::AxisVector;
use ncfix_machine::snc::{Element, Kind, MotionMode, Move};

impl MotionSink<'_> {
    /// Emits the moves of a path.
    pub(in crate::exec) fn resolve(&mut self, path: &Path, mut element: Element) {
        let queue = &mut self.queue;
        let first = queue.len();
        if let (Some(turning), Some(kinematics)) = (path.setup.transform, &self.kinematics) {
            let found = five_axis::moves(kinematics, turning, path, &self.machine.control, |step| {
                queue.push_back(Element { kind: Kind::Move(step), ..element.clone() });
                element.starts_block = false;
                element.number = None;
            });
            self.warnings.extend(found.err());
            return;
        }
        moves(path, self.machine.control.chord_tolerance_mm, self.fits_arcs, |step| {
            let kind = Kind::Move(step);
            queue.push_back(Element { kind, ..element.clone() });
            element.starts_block = false;
            element.number = None;
        });
        if path.motion.is_inverse_time() && queue.len() > first + 1 {
            share_time(&path.start, queue.range_mut(first..));
        }
    }
}

/// Calls `out` with every move of a path, in order.
fn moves(path: &Path, chord_tolerance_mm: f64, fits_arcs: bool, mut out: impl FnMut(Move)) {
    match &path.shape {
        Shape::Line => out(path.motion),
        Shape::Arc { clockwise, center, extra_turns } => {
            match path.basis.principal_arc(*clockwise, *center, *extra_turns) {
                Some(arc) => out(Move { arc: Some(arc), ..path.motion }),
                None => {
                    let (arc, arc_basis) = tilted_arc(&path.basis, *clockwise, *center, *extra_turns);
                    out(Move { arc: Some(arc), arc_basis, ..path.motion });
                }
            }
        }
        // A frame that makes ellipses of circles has no words for arcs of the machine.
        Shape::Chords(ends)
            if fits_arcs && path.motion.motion_mode == MotionMode::Path && path.setup.frame.keeps_shapes() =>
        {
            curve_arcs::pieces(&path.start, ends, &path.basis, chord_tolerance_mm, |piece| {
                let step = Move { target: piece.target, off_curve_mm: piece.off_mm, ..path.motion };
                out(match piece.arc {
                    Some((clockwise, center)) => {
                        let (arc, arc_basis) = tilted_arc(&path.basis, clockwise, center, 0);
                        Move { arc: Some(arc), arc_basis, ..step }
                    }
                    None => step,
                });
            });
        }
        Shape::Chords(ends) => {
            for (k, &target) in ends.iter().enumerate() {
                let off_curve_mm = sagitta::off_mm(&path.start, ends, k, chord_tolerance_mm);
                out(Move { target, off_curve_mm, ..path.motion });
            }
        }
    }
}

/// Assigns each move of a block its share of the block's time (G93), by length.
fn share_time<'a>(start: &AxisVector, elements: impl Iterator<Item = &'a mut Element>) {
    let mut from = *start;
    let mut parts: Vec<(&mut Move, f64)> = Vec::new();
    for element in elements {
        if let Kind::Move(step) = &mut element.kind {
            let straight = || (step.target - from).0.iter().map(|part| part * part).sum::<f64>().sqrt();
            let way = match (&step.arc, &step.arc_basis) {
                (Some(arc), None) => arc.length_mm(&from, &step.target),
                (Some(arc), Some(columns)) => {
                    let [start, end] = [&from, &step.target].map(|place| {
                        let mut flat = *place;
                        flat.set_xyz(columns.tr_mul(&place.xyz()));
                        flat
                    });
                    arc.length_mm(&start, &end)
                }
                (None, _) => straight(),
            };
            from = step.target;
            parts.push((step, way));
        }
    }
    let whole: f64 = parts.iter().map(|(_, way)| way).sum();
    for (step, way) in parts {
        if way > 0.0 {
            step.feed *= whole / way;
        }
    }
}
