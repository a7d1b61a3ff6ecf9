//! The path of one move by its parameter: straight or circular, in axis space or of the tip in the workpiece.
//!
//! The parameter runs from 0 to 1 in proportion to the travel of every axis (straight) or to the swept angle (arc). On a path of the tip it is that of the tip
//! and of the rotary axes; X, Y and Z move along curves, whose turning points and crossings are searched.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use ncfix_base::geometry::{AXES, AXIS_COUNT, Arc, Axis, AxisSet, AxisVector, Matrix, ROTARY_AXES};
use ncfix_machine::machine::TipPath;

/// Arm at which radians of a rotary axis count as mm in sizes of pieces: about the extent of a workpiece on a table.
const ROTARY_ARM_MM: f64 = 100.0;
/// Parameters nearer to each other than this are one point.
const SAME_PARAMETER: f64 = 1e-9;
/// Difference below which the radii at start and end are equal, mm.
const SAME_RADIUS_MM: f64 = 1e-9;
/// Turn or sweep of a path of the tip in one interval of a search, rad: an axis turns back at most once in it.
const SEARCHED_RAD: f64 = PI / 18.0;
/// Maximum number of intervals of a search.
const MOST_INTERVALS: f64 = 4096.0;
/// Half the parameter step of a direction, as a share of an interval.
const DIRECTION_SHARE: f64 = 1e-4;
/// Motion of an axis below this is rounding noise, mm or rad.
const NOISE: f64 = 1e-11;
/// Halvings of an interval: the place is then known within 10⁻¹² of it.
const HALVINGS: usize = 40;

/// An arc, and orthonormal columns along which its coordinates count if its plane is tilted.
pub(super) type RouteArc = Option<(Arc, Option<Matrix>)>;

/// A straight line or an arc from start to end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Route<'k> {
    /// Axis commands.
    pub(super) start: AxisVector,
    pub(super) end: AxisVector,
    circle: Option<Circle>,
    /// The tip in the workpiece follows the line or the arc.
    tip: Option<TipPath<'k>>,
}

/// Constants of an arc.
#[derive(Clone, Copy, Debug)]
struct Circle {
    arc: Arc,
    abscissa: Axis,
    ordinate: Axis,
    radius_mm: f64,
    /// Radius at the end minus radius at the start, mm.
    widening_mm: f64,
    start_rad: f64,
    sweep_rad: f64,
    /// Columns along which its coordinates count, if its plane is tilted.
    basis: Option<Matrix>,
}

impl<'k> Route<'k> {
    /// A path in axis space.
    pub(super) fn new(start: AxisVector, end: AxisVector, arc: RouteArc) -> Route<'k> {
        Route { start, end, circle: arc.map(|arc| Circle::new(arc, &start, &end)), tip: None }
    }

    /// A path of the tip in the workpiece between two axis commands.
    pub(super) fn of_tip(start: AxisVector, end: AxisVector, arc: RouteArc, tip: TipPath<'k>) -> Route<'k> {
        let [from, to] = tip.ends();
        let circle = arc.map(|arc| Circle::new(arc, from, to));
        Route { start, end, circle, tip: Some(tip) }
    }

    /// `true` if the tip follows it in the workpiece.
    pub(super) fn is_of_tip(&self) -> bool {
        self.tip.is_some()
    }

    /// `true` if the rotary axes move in proportion, not along a great circle.
    pub(super) fn turns_in_proportion(&self) -> bool {
        self.tip.as_ref().is_none_or(|tip| tip.circle().is_none())
    }

    /// The positions between which it is a line or an arc: axis commands, or positions fixed to the workpiece.
    pub(super) fn ends(&self) -> [&AxisVector; 2] {
        match &self.tip {
            Some(tip) => tip.ends().each_ref(),
            None => [&self.start, &self.end],
        }
    }

    /// Length of the line or arc, mm, rotary axes at an arm of 100 mm.
    pub(super) fn size_mm(&self) -> f64 {
        let [start, end] = self.ends().map(|end| self.in_arc(end));
        let mut squares = 0.0;
        for (slot, axis) in AXES.into_iter().enumerate() {
            let step = end.0[slot] - start.0[slot];
            let in_plane =
                self.circle.as_ref().is_some_and(|circle| axis == circle.abscissa || axis == circle.ordinate);
            if !in_plane {
                let step = if axis.is_rotary() { step * ROTARY_ARM_MM } else { step };
                squares += step * step;
            }
        }
        if let Some(circle) = &self.circle {
            squares += (circle.radius_mm * circle.sweep_rad).powi(2);
        }
        squares.sqrt()
    }

    /// Travel of the axis that moves farthest, mm, rotary axes at an arm of 100 mm.
    pub(super) fn leading_mm(&self) -> f64 {
        let travels = self.travels();
        AXES.into_iter()
            .map(|axis| travels[axis.slot()] * if axis.is_rotary() { ROTARY_ARM_MM } else { 1.0 })
            .fold(0.0, f64::max)
    }

    /// A position in the coordinates of the arc.
    fn in_arc(&self, position: &AxisVector) -> AxisVector {
        self.circle.as_ref().map_or(*position, |circle| circle.flat(position))
    }

    /// The columns along which the coordinates of the arc count, if its plane is tilted.
    pub(super) fn basis(&self) -> Option<&Matrix> {
        self.circle.as_ref().and_then(|circle| circle.basis.as_ref())
    }

    /// Length of the path of X, Y and Z, or of the tip, mm.
    pub(super) fn length_mm(&self) -> f64 {
        let [start, end] = self.ends().map(|end| self.in_arc(end));
        self.arc().map_or_else(|| (end.xyz() - start.xyz()).norm(), |arc| arc.length_mm(&start, &end))
    }

    /// `true` if the axes move along curves that have no simple turning points.
    fn is_searched(&self) -> bool {
        self.tip.is_some() || self.basis().is_some()
    }

    pub(super) fn arc(&self) -> Option<&Arc> {
        self.circle.as_ref().map(|circle| &circle.arc)
    }

    /// Signed angle swept, rad, 0 for a straight line.
    pub(super) fn sweep_rad(&self) -> f64 {
        self.circle.as_ref().map_or(0.0, |circle| circle.sweep_rad)
    }

    /// Radius, mm, 0 for a straight line.
    pub(super) fn radius_mm(&self) -> f64 {
        self.circle.as_ref().map_or(0.0, |circle| circle.radius_mm)
    }

    /// The largest turn of the tool or of a rotary axis on a path of the tip, rad; 0 for a path in axis space.
    pub(super) fn turn_rad(&self) -> f64 {
        self.tip.as_ref().map_or(0.0, TipPath::turn_rad)
    }

    /// The largest turn of the tool or of a rotary axis over a share of the path, rad.
    pub(super) fn turned_rad(&self, share: f64) -> f64 {
        let turned = ROTARY_AXES.into_iter().map(|axis| (self.end[axis] - self.start[axis]).abs());
        share * turned.fold(self.turn_rad(), f64::max)
    }

    /// The axis command at a parameter; exact at both ends.
    pub(super) fn at(&self, parameter: f64) -> AxisVector {
        if parameter <= 0.0 {
            return self.start;
        }
        if parameter >= 1.0 {
            return self.end;
        }
        let [start, end] = self.ends();
        let mut position = start.lerp(end, parameter);
        if let Some(circle) = &self.circle {
            let (sine, cosine) = (circle.start_rad + circle.sweep_rad * parameter).sin_cos();
            let radius_mm = circle.radius_mm + circle.widening_mm * parameter;
            position = circle.flat(&position);
            position[circle.abscissa] = circle.arc.center_mm[0] + radius_mm * cosine;
            position[circle.ordinate] = circle.arc.center_mm[1] + radius_mm * sine;
            if let Some(basis) = &circle.basis {
                position.set_xyz(basis * position.xyz());
            }
        }
        match &self.tip {
            Some(tip) => tip.command(&position, parameter),
            None => position,
        }
    }

    /// The travel of every axis over the whole route, mm or rad, by slot: an upper bound in axis space, a sum over intervals of a path of the tip.
    pub(super) fn travels(&self) -> [f64; AXIS_COUNT] {
        if !self.is_searched() {
            return AXES.map(|axis| self.travel_in_axes(axis));
        }
        let mut travels = [0.0; AXIS_COUNT];
        let count = self.intervals();
        let mut last = self.start;
        for k in 1..=count {
            let next = self.at(f64::from(k) / f64::from(count));
            for (travel, (to, from)) in travels.iter_mut().zip(next.0.into_iter().zip(last.0)) {
                *travel += (to - from).abs();
            }
            last = next;
        }
        travels
    }

    /// The travel of an axis, as in [`Self::travels`].
    pub(super) fn travel(&self, axis: Axis) -> f64 {
        if self.is_searched() { self.travels()[axis.slot()] } else { self.travel_in_axes(axis) }
    }

    fn travel_in_axes(&self, axis: Axis) -> f64 {
        match &self.circle {
            Some(circle) if axis == circle.abscissa || axis == circle.ordinate => {
                ((circle.radius_mm + circle.widening_mm.abs()) * circle.sweep_rad).abs()
            }
            _ => (self.end[axis] - self.start[axis]).abs(),
        }
    }

    /// A bound for the distance by which linear axes leave the range of their ends on a path of the tip, mm; 0 for another path.
    pub(super) fn excess_mm(&self) -> f64 {
        if self.tip.is_none() {
            return 0.0;
        }
        let [from, to] = self.ends();
        let turned_rad: f64 = ROTARY_AXES.into_iter().map(|axis| (to[axis] - from[axis]).abs()).sum();
        // Each rotary axis displaces X, Y and Z by at most its turn times a lever, which both positions bound.
        let lever_mm = |position: &AxisVector, command: &AxisVector| position.xyz().norm() + command.xyz().norm();
        let lever_mm = lever_mm(from, &self.start).max(lever_mm(to, &self.end));
        self.length_mm() + 2.0 * turned_rad * lever_mm
    }

    /// Number of intervals of a search on a path of the tip.
    fn intervals(&self) -> u32 {
        let turned = self.turn_rad().max(self.sweep_rad().abs());
        // Bounded on both sides.
        (turned / SEARCHED_RAD).ceil().clamp(1.0, MOST_INTERVALS) as u32
    }

    /// Adds the parameters between two others at which an axis is at `position`.
    pub(super) fn crossings(&self, axis: Axis, position: f64, between: [f64; 2], parameters: &mut Vec<f64>) {
        let mut add = |parameter: f64| {
            if parameter > between[0] && parameter < between[1] {
                parameters.push(parameter);
            }
        };
        if self.is_searched() {
            self.search_crossings(axis, position, &mut add);
            return;
        }
        match &self.circle {
            Some(circle) if axis == circle.abscissa || axis == circle.ordinate => {
                let is_ordinate = usize::from(axis == circle.ordinate);
                let ratio = (position - circle.arc.center_mm[is_ordinate]) / circle.radius_mm;
                if ratio.abs() < 1.0 {
                    let half = ratio.acos();
                    let from = circle.start_rad - FRAC_PI_2 * is_ordinate as f64;
                    for angle in [half, -half] {
                        circle.parameters_of(angle - from, &mut add);
                    }
                }
            }
            _ => {
                let step = self.end[axis] - self.start[axis];
                if step != 0.0 {
                    add((position - self.start[axis]) / step);
                }
            }
        }
    }

    /// Crossings on a path of the tip.
    fn search_crossings(&self, axis: Axis, position: f64, add: &mut impl FnMut(f64)) {
        let count = self.intervals();
        let off = |parameter: f64| self.at(parameter)[axis] - position;
        let mut last = (0.0, off(0.0));
        for k in 1..=count {
            let next = (f64::from(k) / f64::from(count), off(f64::from(k) / f64::from(count)));
            if (last.1 < 0.0) != (next.1 < 0.0) {
                let is_rising = last.1 < 0.0;
                add(halved([last.0, next.0], |parameter| (off(parameter) < 0.0) == is_rising));
            }
            last = next;
        }
    }

    /// The parameter of the next turning point of one of the axes after `parameter`; 1 without one. In axis space only arcs have turning points.
    pub(super) fn next_turning(&self, axes: AxisSet, parameter: f64) -> f64 {
        if self.is_searched() {
            return if axes.is_empty() { 1.0 } else { self.search_turning(axes, parameter) };
        }
        self.next_quadrant(axes, parameter)
    }

    /// The next parameter after another at which the arc is parallel to one of the axes of its plane; 1 if there is none.
    pub(super) fn next_quadrant(&self, axes: AxisSet, parameter: f64) -> f64 {
        let Some(circle) = &self.circle else { return 1.0 };
        let mut next = 1.0_f64;
        for (axis, offset) in [(circle.abscissa, 0.0), (circle.ordinate, FRAC_PI_2)] {
            if axes.contains(axis) {
                for angle in [offset, offset + 2.0 * FRAC_PI_2] {
                    circle.parameters_of(angle - circle.start_rad, &mut |candidate| {
                        if candidate > parameter + SAME_PARAMETER && candidate < 1.0 - SAME_PARAMETER {
                            next = next.min(candidate);
                        }
                    });
                }
            }
        }
        next
    }

    /// The next turning point of axes on a path of the tip.
    fn search_turning(&self, axes: AxisSet, parameter: f64) -> f64 {
        let count = self.intervals();
        let half = DIRECTION_SHARE / f64::from(count);
        let sense = |axis: Axis, at: f64| {
            let step = self.at((at + half).min(1.0))[axis] - self.at((at - half).max(0.0))[axis];
            if step.abs() < NOISE { 0 } else { step.signum() as i8 }
        };
        let mut next = 1.0_f64;
        for axis in axes.iter() {
            // The first interval with a change; it begins after the given parameter.
            let mut last = (parameter + SAME_PARAMETER, sense(axis, parameter + SAME_PARAMETER + half));
            let first = (parameter * f64::from(count)).floor() as u32 + 1;
            for k in first..=count {
                let at = f64::from(k) / f64::from(count);
                let here = (at, sense(axis, at - half));
                if last.1 != 0 && here.1 != 0 && last.1 != here.1 {
                    let turning = halved([last.0, at], |place| sense(axis, place) == last.1);
                    if turning > parameter + SAME_PARAMETER && turning < 1.0 - SAME_PARAMETER {
                        next = next.min(turning);
                    }
                    break;
                }
                if here.1 != 0 {
                    last = here;
                }
                if at >= next {
                    break;
                }
            }
        }
        next
    }
}

/// A position along columns; as it is without any.
pub(super) fn flat_in(basis: Option<&Matrix>, position: &AxisVector) -> AxisVector {
    let mut flat = *position;
    if let Some(basis) = basis {
        flat.set_xyz(basis.tr_mul(&position.xyz()));
    }
    flat
}

/// The place between two parameters up to which `holds` is true.
fn halved([mut low, mut high]: [f64; 2], holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = low.midpoint(high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low.midpoint(high)
}

impl Circle {
    fn new((arc, basis): (Arc, Option<Matrix>), start: &AxisVector, end: &AxisVector) -> Circle {
        let [start, end] = &[start, end].map(|end| flat_in(basis.as_ref(), end));
        let [abscissa, ordinate, _] = arc.plane.axes();
        let across = [start[abscissa] - arc.center_mm[0], start[ordinate] - arc.center_mm[1]];
        let radius_mm = across[0].hypot(across[1]);
        let widening_mm = arc.radius_mm(end) - radius_mm;
        Circle {
            arc,
            abscissa,
            ordinate,
            radius_mm,
            // Rounding errors of a circle do not make a spiral.
            widening_mm: if widening_mm.abs() < SAME_RADIUS_MM { 0.0 } else { widening_mm },
            start_rad: across[1].atan2(across[0]),
            sweep_rad: arc.sweep_rad(start, end),
            basis,
        }
    }

    /// A position in the coordinates of the arc.
    fn flat(&self, position: &AxisVector) -> AxisVector {
        flat_in(self.basis.as_ref(), position)
    }

    /// Calls `add` with every parameter, also outside 0 … 1 by up to a turn, at which the angle from the start equals `turned` modulo full turns.
    fn parameters_of(&self, turned_rad: f64, add: &mut impl FnMut(f64)) {
        let turn = TAU / self.sweep_rad.abs();
        let first = (turned_rad / self.sweep_rad).rem_euclid(turn);
        let mut parameter = first;
        while parameter <= 1.0 {
            add(parameter);
            parameter += turn;
        }
    }
}

/// The distance of two positions in axis space, mm, rotary axes at an arm of 100 mm.
pub(super) fn distance_mm(a: &AxisVector, b: &AxisVector) -> f64 {
    let mut squares = 0.0;
    for (slot, axis) in AXES.into_iter().enumerate() {
        let step = (a.0[slot] - b.0[slot]) * if axis.is_rotary() { ROTARY_ARM_MM } else { 1.0 };
        squares += step * step;
    }
    squares.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::Plane;

    fn helix() -> Route<'static> {
        // From +X counter-clockwise one and a quarter turns, rising 5 mm.
        let arc = Arc { plane: Plane::XY, clockwise: false, center_mm: [20.0, 30.0], extra_turns: 1 };
        let start = AxisVector([30.0, 30.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let end = AxisVector([20.0, 40.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        Route::new(start, end, Some((arc, None)))
    }

    #[test]
    fn a_helix_is_as_long_as_its_unrolled_triangle() {
        let route = helix();
        assert!((route.size_mm() - (10.0 * 2.5 * std::f64::consts::PI).hypot(5.0)).abs() < 1e-9);
        assert!((route.sweep_rad() - 2.5 * std::f64::consts::PI).abs() < 1e-12);
        let half_turn = route.at(0.4);
        assert!((half_turn[Axis::X] - 10.0).abs() < 1e-12 && (half_turn[Axis::Z] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn turning_points_are_met_in_order() {
        let route = helix();
        let mut at = 0.0;
        let mut found = Vec::new();
        loop {
            at = route.next_turning(AxisSet::XYZ, at);
            if at >= 1.0 {
                break;
            }
            found.push(at);
        }
        // Quarter turns are fifths of the sweep.
        assert_eq!(found.len(), 4, "{found:?}");
        for (k, parameter) in found.iter().enumerate() {
            assert!((parameter - 0.2 * (k + 1) as f64).abs() < 1e-12);
        }
        assert_eq!(route.next_turning([Axis::X].into_iter().collect(), 0.0), 0.4);
    }

    #[test]
    fn crossings_are_on_the_knot() {
        let route = helix();
        for (axis, position) in [(Axis::X, 17.0), (Axis::Y, 33.0), (Axis::Z, 1.0)] {
            let mut parameters = Vec::new();
            route.crossings(axis, position, [0.0, 1.0], &mut parameters);
            assert!(parameters.len() >= 2 || axis == Axis::Z, "{axis}: {parameters:?}");
            for &parameter in &parameters {
                assert!((route.at(parameter)[axis] - position).abs() < 1e-9, "{axis} {parameter}");
            }
        }
        // Y 33 is passed on the way up in both turns and on the way down in the first.
        let mut parameters = Vec::new();
        route.crossings(Axis::Y, 33.0, [0.0, 1.0], &mut parameters);
        assert_eq!(parameters.len(), 3);
    }
}
