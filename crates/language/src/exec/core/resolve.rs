//! Converts paths in base coordinates to axis moves.

use super::five_axis;
use super::motion_sink::MotionSink;
use super::path::{Path, Shape};
use super::sagitta::{self, chord_count};
use ncfix_base::geometry::{Arc, AxisVector};
use ncfix_machine::snc::{Element, Kind, Move};

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
        moves(path, self.machine.control.chord_tolerance_mm, |step| {
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
fn moves(path: &Path, chord_tolerance_mm: f64, mut out: impl FnMut(Move)) {
    match &path.shape {
        Shape::Line => out(path.motion),
        Shape::Arc { clockwise, center, extra_turns } => {
            match path.basis.principal_arc(*clockwise, *center, *extra_turns) {
                Some(arc) => out(Move { arc: Some(arc), ..path.motion }),
                None => {
                    let (chords, off_curve_mm) =
                        arc_chords(path, *clockwise, *center, *extra_turns, chord_tolerance_mm);
                    for target in chords {
                        out(Move { target, off_curve_mm, ..path.motion });
                    }
                }
            }
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
            let way = (step.target - from).0.iter().map(|part| part * part).sum::<f64>().sqrt();
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

/// Ends of the chords of an arc in a tilted plane, and their distance from the arc, mm.
fn arc_chords(
    path: &Path,
    clockwise: bool,
    center: [f64; 2],
    extra_turns: u32,
    tolerance_mm: f64,
) -> (impl Iterator<Item = AxisVector>, f64) {
    // An arc of the XY plane represents it in plane coordinates.
    let arc = Arc { plane: ncfix_base::geometry::Plane::XY, clockwise, center_mm: center, extra_turns };
    let place = |position: &AxisVector| {
        let flat = path.basis.flat(position);
        AxisVector([flat[0], flat[1], path.basis.height(position), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    };
    let (start, end) = (place(&path.start), place(&path.motion.target));
    let (radius_mm, sweep_rad) = (arc.radius_mm(&start), arc.sweep_rad(&start, &end));
    let count = chord_count(radius_mm, sweep_rad, tolerance_mm);
    let off_mm = radius_mm * (1.0 - (0.5 * sweep_rad / f64::from(count)).cos());
    let (first, last, basis) = (path.start, path.motion.target, path.basis);
    let chords = (1..=count).map(move |k| {
        if k == count {
            return last;
        }
        let share = f64::from(k) / f64::from(count);
        let local = arc.at(&start, &end, share);
        let mut out = first.lerp(&last, share);
        out.set_xyz(basis.lift([local.0[0], local.0[1]], local.0[2]));
        out
    });
    (chords, off_mm)
}
