//! A piece as an arc: its center and plane as written, and the resulting arc.

use std::f64::consts::{FRAC_PI_4, TAU};

use ncfix_base::geometry::{AXES, Arc, Axis, AxisVector, Matrix, Plane, Vector};
use ncfix_machine::machine::ArcCenter;

use super::route::flat_in;
use super::segment_candidate::{PieceEnds, SAME_PLACE_MM, SegmentCandidate, SegmentFitter, state_of};
use super::standing::PathState;
use super::{Centers, PieceArc, Turns, arc_fit};

/// Used share of the control's tolerance for arc centers, so that the control's arithmetic agrees.
const CENTER_SHARE: f64 = 0.5;
/// Tolerance within which a sweep is full turns, rad.
const SAME_ANGLE: f64 = 1e-7;

impl<'m> SegmentFitter<'_, 'm> {
    /// The piece as an arc, without measured deviation; `None` if the rounded ends allow none.
    pub(super) fn unmeasured_arc(&self, standing: &PathState, between: [f64; 2]) -> Option<SegmentCandidate<'m>> {
        let arc = *self.route.arc()?;
        if self.route.is_of_tip() != self.placer.is_transformed() {
            return None;
        }
        let basis = self.route.basis().copied();
        let Some((plane, clockwise)) = self.emitted_plane(arc.plane, basis.as_ref(), arc.clockwise) else {
            return self.unmeasured_spatial_arc(standing, between);
        };
        let ends = self.ends(standing, between, true);
        if ends.end.is_held_back {
            return None;
        }
        let [abscissa, ordinate, _] = arc.plane.axes();
        let flat = |command: &AxisVector| {
            let position = flat_in(basis.as_ref(), &self.placer.position(command));
            [position[abscissa], position[ordinate]]
        };
        let (start, end) = (flat(&ends.start), flat(&ends.end.command));
        let swept = self.route.sweep_rad().abs() * (between[1] - between[0]);
        let turns = (swept / TAU).round();
        let is_full = turns >= 1.0 && (swept - turns * TAU).abs() < SAME_ANGLE;
        let gap_mm = (end[0] - start[0]).hypot(end[1] - start[1]);
        if is_full != (gap_mm < SAME_PLACE_MM) {
            return None;
        }
        let extra_turns = if is_full { turns - 1.0 } else { (swept / TAU).floor() };
        // At most the TURN of the program: a small whole number.
        let extra_turns = extra_turns as u32;
        let leads_aside = || {
            let [from, to] =
                [&ends.start, &ends.end.command].map(|end| flat_in(basis.as_ref(), &self.placer.position(end)));
            let way = to - from;
            AXES.into_iter().any(|axis| axis != abscissa && axis != ordinate && way[axis].abs() > SAME_PLACE_MM)
        };
        let is_too_far = match self.placer.turns {
            Turns::Several => false,
            Turns::One => extra_turns > 0,
            Turns::OneFlat => extra_turns > 0 || is_full && leads_aside(),
        };
        if is_too_far {
            return None;
        }
        let centers = match self.control.arc_center {
            Some(ArcCenter::Moved) => Centers::OnBisector,
            Some(ArcCenter::Kept) => Centers::AsWritten,
            None => self.placer.centers,
        };
        let center = self.center(&ends, between, (&arc, centers), flat)?;
        let mut from_start = Vector::zeros();
        from_start[abscissa.slot()] = center[0] - start[0];
        from_start[ordinate.slot()] = center[1] - start[1];
        let turned = basis.map_or(from_start, |basis| basis * from_start);
        let (center_counts, rounded) = self.round_direction(turned);
        let rounded = basis.map_or(rounded, |basis| basis.tr_mul(&rounded));
        let center = [start[0] + rounded[abscissa.slot()], start[1] + rounded[ordinate.slot()]];
        // The control accepts the arc of the source with the whole tolerance.
        let share = if self.placer.model.is_empty() { 1.0 } else { CENTER_SHARE };
        let tolerance =
            |radius_mm: f64| share * self.control.arc_tolerance_mm.max(self.control.arc_tolerance_ratio * radius_mm);
        let [from, to] =
            &[&ends.start, &ends.end.command].map(|end| flat_in(basis.as_ref(), &self.placer.position(end)));
        let done = match centers {
            Centers::OnBisector => Arc::through(arc.plane, arc.clockwise, from, to, center, extra_turns, tolerance),
            Centers::AsWritten => Arc::spiral(arc.plane, arc.clockwise, from, to, center, extra_turns, tolerance),
        };
        let done = done.ok()?;
        let emitted = self.placer.emitted_arc(ends.start, ends.end.command, Some((done, basis)));
        let standing = self.placer.programmed(&ends.start);
        let start_counts = [Axis::X, Axis::Y, Axis::Z].map(|axis| self.placer.increments.count(axis, standing[axis]));
        let circle = PieceArc { plane, clockwise, center_counts, start_counts, extra_turns, through_counts: None };
        Some(self.trial(between, ends, emitted, Some(circle)))
    }

    /// The center nearest to the corrected path, in the plane of the axes, mm.
    fn center(
        &self,
        ends: &PieceEnds,
        between: [f64; 2],
        (arc, centers): (&Arc, Centers),
        flat: impl Fn(&AxisVector) -> [f64; 2],
    ) -> Option<[f64; 2]> {
        let (start, end) = (flat(&ends.start), flat(&ends.end.command));
        if self.placer.model.is_empty() {
            // Without errors, a spiral stays the spiral of the source.
            return Some(match centers {
                Centers::AsWritten => arc.center_mm,
                Centers::OnBisector => arc_fit::center(start, end, arc.center_mm, &[]),
            });
        }
        let [from, to] = between;
        let swept = self.route.sweep_rad().abs() * (to - from);
        // The conversion is exact: between 3 and 16.
        let count = (swept / FRAC_PI_4).ceil().clamp(3.0, 16.0) as u32;
        let mut points = [[0.0; 2]; 16];
        let mut shift = [0.0; 2];
        let correction = ends.end.command - self.route.at(to);
        let state = state_of(ends.sense);
        for (k, point) in (1..=count).zip(&mut points) {
            let nominal = self.route.at(from + (to - from) * f64::from(k) / f64::from(count + 1));
            let exact = self.placer.exact(&nominal, self.known, &state, &correction, f64::INFINITY).ok()?;
            *point = flat(&exact);
            let straight = flat(&nominal);
            shift[0] += (point[0] - straight[0]) / f64::from(count);
            shift[1] += (point[1] - straight[1]) / f64::from(count);
        }
        let guess = [arc.center_mm[0] + shift[0], arc.center_mm[1] + shift[1]];
        Some(arc_fit::center(start, end, guess, &points[..count as usize]))
    }

    /// Plane and direction of an arc in the emitted frame; `None` if the plane is not a principal plane there, or not the selected one.
    ///
    /// An arc that is counter-clockwise about n is counter-clockwise about sign(det L) · L · n in the frame L.
    fn emitted_plane(&self, plane: Plane, basis: Option<&Matrix>, clockwise: bool) -> Option<(Plane, bool)> {
        let setup = &self.placer.setup;
        if self.placer.is_parallel() {
            return (plane == setup.plane && basis.is_none()).then_some((plane, clockwise));
        }
        let mut normal = Vector::zeros();
        normal[plane.axes()[2].slot()] = setup.frame.linear().determinant().signum();
        let normal = basis.map_or(normal, |basis| basis * normal);
        let normal = setup.frame.unapply_direction(normal).normalize();
        let across = normal[setup.plane.axes()[2].slot()];
        // Across the plane the frame may scale by another factor.
        let is_principal = setup.frame.keeps_circles(setup.plane) && (across.abs() - 1.0).abs() < SAME_PLACE_MM;
        is_principal.then_some((setup.plane, clockwise == (across > 0.0)))
    }

    /// A direction of the axes in counts of the emitted frame, and the direction that the counts represent.
    pub(super) fn round_direction(&self, direction: Vector) -> ([i64; 3], Vector) {
        let is_parallel = self.placer.is_parallel();
        let frame = &self.placer.setup.frame;
        let programmed = if is_parallel { direction } else { frame.unapply_direction(direction) };
        let mut counts = [0; 3];
        let mut rounded = Vector::zeros();
        for (slot, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
            counts[slot] = self.placer.increments.count(axis, programmed[slot]);
            rounded[slot] = self.placer.increments.position(axis, counts[slot]);
        }
        (counts, if is_parallel { rounded } else { frame.apply_direction(rounded) })
    }
}
