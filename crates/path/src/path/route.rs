//! The path of one move in axis space, straight or circular, by its parameter.
//!
//! The parameter runs from 0 to 1 in proportion to the travel of every axis (straight) or to the swept angle (arc).

use std::f64::consts::{FRAC_PI_2, TAU};

use ncfix_base::geometry::{AXES, Arc, Axis, AxisSet, AxisVector};

/// Arm at which radians of a rotary axis count as mm in sizes of pieces: about the extent of a workpiece on a table.
const ROTARY_ARM_MM: f64 = 100.0;
/// Parameters nearer to each other than this are one point.
const SAME_PARAMETER: f64 = 1e-9;
/// Difference below which the radii at start and end are equal, mm.
const SAME_RADIUS_MM: f64 = 1e-9;

/// A straight line or an arc from start to end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Route {
    pub(super) start: AxisVector,
    pub(super) end: AxisVector,
    circle: Option<Circle>,
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
}

impl Route {
    pub(super) fn new(start: AxisVector, end: AxisVector, arc: Option<Arc>) -> Route {
        let circle = arc.map(|arc| {
            let [abscissa, ordinate, _] = arc.plane.axes();
            let across = [start[abscissa] - arc.center_mm[0], start[ordinate] - arc.center_mm[1]];
            let radius_mm = across[0].hypot(across[1]);
            let widening_mm = arc.radius_mm(&end) - radius_mm;
            Circle {
                arc,
                abscissa,
                ordinate,
                radius_mm,
                // Rounding errors of a circle do not make a spiral.
                widening_mm: if widening_mm.abs() < SAME_RADIUS_MM { 0.0 } else { widening_mm },
                start_rad: across[1].atan2(across[0]),
                sweep_rad: arc.sweep_rad(&start, &end),
            }
        });
        Route { start, end, circle }
    }

    /// Length in axis space, mm, rotary axes at an arm of 100 mm.
    pub(super) fn size_mm(&self) -> f64 {
        let mut squares = 0.0;
        for (slot, axis) in AXES.into_iter().enumerate() {
            let step = self.end.0[slot] - self.start.0[slot];
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
        AXES.into_iter()
            .map(|axis| self.travel(axis) * if axis.is_rotary() { ROTARY_ARM_MM } else { 1.0 })
            .fold(0.0, f64::max)
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

    /// The position at a parameter; exact at both ends.
    pub(super) fn at(&self, parameter: f64) -> AxisVector {
        if parameter <= 0.0 {
            return self.start;
        }
        if parameter >= 1.0 {
            return self.end;
        }
        let mut position = self.start.lerp(&self.end, parameter);
        if let Some(circle) = &self.circle {
            let (sine, cosine) = (circle.start_rad + circle.sweep_rad * parameter).sin_cos();
            let radius_mm = circle.radius_mm + circle.widening_mm * parameter;
            position[circle.abscissa] = circle.arc.center_mm[0] + radius_mm * cosine;
            position[circle.ordinate] = circle.arc.center_mm[1] + radius_mm * sine;
        }
        position
    }

    /// An upper bound of the travel of an axis over the whole route, mm or rad.
    pub(super) fn travel(&self, axis: Axis) -> f64 {
        match &self.circle {
            Some(circle) if axis == circle.abscissa || axis == circle.ordinate => {
                ((circle.radius_mm + circle.widening_mm.abs()) * circle.sweep_rad).abs()
            }
            _ => (self.end[axis] - self.start[axis]).abs(),
        }
    }

    /// Adds the parameters between two others at which an axis is at `position`.
    pub(super) fn crossings(&self, axis: Axis, position: f64, between: [f64; 2], parameters: &mut Vec<f64>) {
        let mut add = |parameter: f64| {
            if parameter > between[0] && parameter < between[1] {
                parameters.push(parameter);
            }
        };
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

    /// The parameter of the next turning point of one of the axes on an arc after `parameter`; 1 if there is none.
    pub(super) fn next_turning(&self, axes: AxisSet, parameter: f64) -> f64 {
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
}

impl Circle {
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

    fn helix() -> Route {
        // From +X counter-clockwise one and a quarter turns, rising 5 mm.
        let arc = Arc { plane: Plane::XY, clockwise: false, center_mm: [20.0, 30.0], extra_turns: 1 };
        let start = AxisVector([30.0, 30.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let end = AxisVector([20.0, 40.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        Route::new(start, end, Some(arc))
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
