//! Angles of linear axes that no measurement shows, and the arms over which they displace the tool.

use ncfix_base::geometry::{Axis, AxisVector, Vector};

use super::{CoverageGap, GapKind, Survey, is_angle};
use crate::name::ErrorName;

/// Arm up to which an angle has no effect, mm: 10 µrad displace the tool by 0.01 µm.
const LEAST_ARM_MM: f64 = 1.0;

/// A pose of the axes with a tool.
type Place = (AxisVector, Vector);

impl Survey<'_> {
    /// Axes that move, and whose angles the calibration could not show, if an angle displaces the tool of the program as no straightness does.
    pub(super) fn angles(&self, gaps: &mut Vec<CoverageGap>) {
        let open: Vec<ErrorName> = self.not_shown().filter(is_angle).collect();
        if open.is_empty() {
            return;
        }
        let lengths_mm = self.measured.tool_length_mm.into_iter().flatten();
        let measured_tools: Vec<Vector> = lengths_mm.map(|length_mm| self.machine.spindle.axis * -length_mm).collect();
        let used_tools = self.used.tools_mm.map_or_else(Vec::new, |tools| tools.to_vec());
        let tools = [used_tools, measured_tools];
        for (axis, used) in self.moving() {
            let places = [false, true].map(|is_measured| self.corners(axis, is_measured, &tools));
            let own = open.iter().filter(|name| name.axis() == Some(axis));
            let arms = own.map(|name| (*name, self.arm_mm(*name, used, &places)));
            let (components, arms_mm): (Vec<ErrorName>, Vec<f64>) = arms.filter(|(_, mm)| *mm > LEAST_ARM_MM).unzip();
            if components.is_empty() {
                continue;
            }
            gaps.push(CoverageGap {
                axis: Some(axis),
                components,
                measured: self.measured.axes.get(&axis).copied(),
                arm_mm: arms_mm.into_iter().reduce(f64::max),
                ..CoverageGap::new(GapKind::Angle, used)
            });
        }
    }

    /// The corners of the used or of the measured ranges of all axes but one, with the shortest and the longest tool. Where nothing states a range or a tool of
    /// the measurement, that of the program counts.
    fn corners(&self, except: Axis, is_measured: bool, [used_tools, measured_tools]: &[Vec<Vector>; 2]) -> Vec<Place> {
        let mut poses = vec![AxisVector::ZERO];
        for (&axis, &used) in self.used.axes.iter().filter(|(axis, _)| **axis != except) {
            let measured = self.measured.axes.get(&axis).copied().filter(|_| is_measured);
            let [low, high] = measured.unwrap_or(used);
            // The ends of a turn are not its extremes.
            let middle = axis.is_rotary().then(|| low.midpoint(high));
            let places = [low, high].into_iter().chain(middle);
            let at = |pose: &AxisVector, place: f64| {
                let mut pose = *pose;
                pose[axis] = place;
                pose
            };
            poses = places.flat_map(|place| poses.iter().map(move |pose| at(pose, place))).collect();
        }
        let tools = if is_measured && !measured_tools.is_empty() { measured_tools } else { used_tools };
        let none = [Vector::zeros()];
        let tools: &[Vector] = if tools.is_empty() { &none } else { tools };
        poses.into_iter().flat_map(|pose| tools.iter().map(move |tool| (pose, *tool))).collect()
    }

    /// Returns the longest arm of an angle, mm. The straightness errors and the scale contain its effect at the place of their measurement, which may be any
    /// measured one. So an arm is the way from there to a place of the program, as far as the angle moves the tool.
    fn arm_mm(&self, name: ErrorName, used: [f64; 2], places: &[Vec<Place>; 2]) -> f64 {
        let Some(axis) = name.axis() else { return 0.0 };
        let moved = |own: f64, (pose, tool_mm): &Place| {
            let mut pose = *pose;
            pose[axis] = own;
            self.model.tool_orientation(&pose) * self.model.sensitivity(name, &pose, tool_mm).translation
        };
        let arm_mm = |own: f64| {
            let [used, measured] = [0, 1].map(|k| places[k].iter().map(|place| moved(own, place)).collect::<Vec<_>>());
            let ways = used.iter().flat_map(|one| measured.iter().map(move |other| (one - other).norm()));
            ways.fold(0.0, f64::max)
        };
        used.map(arm_mm).into_iter().fold(0.0, f64::max)
    }
}
