//! Paths of a plan: to further poses, from above them, away from the workpiece and on a sphere.

use super::PlanRefused;
use super::builder::{Builder, Extra, PlanReach, ROOM};
use crate::measure::data::Observation;
use crate::measure::kind::Measurand;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::snc::Kind;

/// Distance from the end of travel at which a path is bent that would leave it, mm.
const BEND_MM: f64 = 0.01;

impl Builder {
    /// The axis along the spindle, and its end away from the workpiece.
    fn away(&self) -> Option<(Axis, f64)> {
        let (which, sign) = super::along_spindle(&self.machine);
        let axis = [Axis::X, Axis::Y, Axis::Z][which.min(2)];
        self.travel(axis).map(|[low, high]| (axis, if sign > 0.0 { high } else { low }))
    }

    /// Adds a candidate as a row, with the path to it.
    ///
    /// # Errors
    /// A reason if the path leaves the travel.
    pub fn visit(&mut self, candidate: &Observation, run: &str) -> Result<(), PlanRefused> {
        let position = self.on_increments(&candidate.reading.position);
        let tool_mm = candidate.reading.tool_mm;
        let mut extra = Extra { run: run.to_owned(), ..Extra::default() };
        if self.data.observations.last().is_some_and(|last| last.setup != candidate.setup) {
            let label = self.data.setups.get(candidate.setup).map_or_else(String::new, |setup| setup.label.clone());
            self.retract()?;
            self.stop(&format!("set-up {label}"));
        }
        match self.reach.clone() {
            PlanReach::Never => return Err(PlanRefused("the plan has no further poses".into())),
            PlanReach::Sphere { chord, feed } => {
                let setup = self.data.setups.get(candidate.setup);
                let centre = setup.map_or_else(Vector::zeros, |setup| setup.centre_mm);
                self.on_sphere(&centre, &tool_mm, &position, chord, feed)?;
                extra.feed = Some(feed);
            }
            PlanReach::Above { clearance_mm, above_mm, retract, feed } => {
                self.above(&position, &tool_mm, [clearance_mm, above_mm], retract, feed)?;
            }
        }
        // A probed ball position is not commanded: the row is exact.
        let exact = self.data.kind.measurand == Measurand::BallPlace;
        let row = if exact { candidate.reading.position } else { position };
        self.row(&row, tool_mm, candidate.setup, extra)?;
        self.of_last(candidate.target, candidate.component);
        self.at_pose();
        if let PlanReach::Above { clearance_mm, retract, feed, .. } = self.reach {
            // After manual probing the tool may be next to the ball: the first path is along the tool.
            let is_tilting = self.machine.topology.tool.iter().any(|axis| axis.is_rotary());
            if !retract || is_tilting {
                let up = self.raised(&position, &tool_mm, clearance_mm)?;
                self.go(&up, Some(feed))?;
            }
            if retract {
                self.retract()?;
            }
        }
        Ok(())
    }

    /// The position whose tip is offset along the tool towards the spindle, or on the side from which poses are reached.
    pub(super) fn raised(
        &self,
        position: &AxisVector,
        tool_mm: &Vector,
        by_mm: f64,
    ) -> Result<AxisVector, PlanRefused> {
        let side = self.side.unwrap_or_else(|| self.kinematics.direction(position));
        let tip = self.kinematics.tip_mm(position, tool_mm) + side * by_mm;
        let missing = || PlanRefused(format!("the linear axes of {} cannot place the tool", self.machine.name));
        self.kinematics.placed(&tip, position, tool_mm).ok_or_else(missing)
    }

    /// Moves down to a pose from above it.
    fn above(
        &mut self,
        position: &AxisVector,
        tool_mm: &Vector,
        [clearance_mm, above_mm]: [f64; 2],
        retract: bool,
        feed: f64,
    ) -> Result<(), PlanRefused> {
        let high = self.raised(position, tool_mm, clearance_mm)?;
        let low = self.raised(position, tool_mm, above_mm)?;
        // The first path starts at an unknown position.
        if retract || self.is_away || self.last.is_none() {
            self.approach(&high, feed)?;
        } else {
            self.go(&high, Some(feed))?;
        }
        self.go(&low, Some(feed))
    }

    /// Retracts the tool from the workpiece along the spindle.
    pub(super) fn retract(&mut self) -> Result<(), PlanRefused> {
        if let (Some((axis, end)), Some(mut here)) = (self.away(), self.last) {
            here[axis] = end;
            let here = self.on_increments(&here);
            self.push_named(here, None, None, [axis].into_iter().collect())?;
            self.is_away = true;
        }
        Ok(())
    }

    /// Moves to a position from anywhere: first away from the workpiece, then the other axes, last along the spindle.
    pub(super) fn approach(&mut self, to: &AxisVector, feed: f64) -> Result<(), PlanRefused> {
        if let Some((axis, end)) = self.away() {
            let mut over = *to;
            over[axis] = end;
            if self.last.is_some() {
                self.retract()?;
            } else {
                // The positions of the others are unknown.
                let over = self.on_increments(&over);
                self.push_named(over, None, None, [axis].into_iter().collect())?;
            }
            self.go(&over, None)?;
        }
        self.go(to, Some(feed))
    }

    /// States the lowest points of the path along the spindle, in a note and at the beginning of the program: no machine file says where the table is.
    pub(super) fn state_lowest(&mut self, tool_mm: &Vector) {
        let (which, sign) = super::along_spindle(&self.machine);
        let lowest = |tool_mm: &Vector| {
            let of = |kind: &Kind| match kind {
                Kind::Move(one) => Some(sign * self.kinematics.tip_mm(&one.target, tool_mm)[which]),
                _ => None,
            };
            sign * self.path.iter().filter_map(of).fold(f64::INFINITY, f64::min)
        };
        let letter = ['X', 'Y', 'Z'][which.min(2)];
        let [nose, tip] = [Vector::zeros(), *tool_mm].map(|tool| (1000.0 * lowest(&tool)).round() / 1000.0);
        if !nose.is_finite() {
            return;
        }
        let with_tool =
            if tool_mm.norm() > 0.0 { format!(", and the measuring point to {letter} {tip}") } else { String::new() };
        let sentence = format!(
            "the spindle nose moves down to {letter} {nose} mm{with_tool}, relative to the zero of the machine"
        );
        self.path.insert(0, Kind::Comment(sentence.clone().into_bytes()));
        self.notes.push(format!(
            "{sentence}; the machine file does not state where the table and the instrument are: compare before the start"
        ));
    }

    /// A position on a sphere, or a nearby one on the sphere if it is outside the travel.
    fn bent_inside(&self, position: AxisVector, centre: &Vector, radius: f64) -> AxisVector {
        let mut out = position;
        let mut is_held = [false; 3];
        for _ in 0..3 {
            if self.outside(&self.on_increments(&out)).is_none() {
                break;
            }
            for (axis, is_held) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(&mut is_held) {
                let room = self.travel(axis).filter(|[low, high]| high - low > 2.0 * BEND_MM);
                if let Some([low, high]) = room.filter(|[low, high]| !(low..=high).contains(&&out[axis])) {
                    out[axis] = out[axis].clamp(low + BEND_MM, high - BEND_MM);
                    *is_held = true;
                }
            }
            // Axes at an end of travel stay there, the others return to the sphere.
            let off = out.xyz() - centre;
            let square = |held: bool| -> f64 { (0..3).filter(|&k| is_held[k] == held).map(|k| off[k] * off[k]).sum() };
            let left = radius * radius - square(true);
            let free = square(false);
            if left <= 0.0 || free <= 0.0 {
                break;
            }
            let factor = (left / free).sqrt();
            out.set_xyz(centre + Vector::from_fn(|k, _| off[k] * if is_held[k] { 1.0 } else { factor }));
        }
        out
    }

    /// Moves to a position on the sphere about a center along a great circle, in chords; across the pole on the spindle's side if the path is
    /// ambiguous.
    pub(super) fn on_sphere(
        &mut self,
        centre_mm: &Vector,
        tool_mm: &Vector,
        to: &AxisVector,
        chord: f64,
        feed: f64,
    ) -> Result<(), PlanRefused> {
        let centre = self.at_tip(centre_mm, tool_mm).xyz();
        let Some(from) = self.last.map(|last| last.xyz() - centre) else { return self.go(to, Some(feed)) };
        let target = to.xyz() - centre;
        let (start, end) = (from.norm(), target.norm());
        if start < ROOM || end < ROOM {
            return self.go(to, Some(feed));
        }
        let (one, other) = (from / start, target / end);
        let (which, sign) = super::along_spindle(&self.machine);
        let mut way = vec![one, other];
        if one.dot(&other) < -0.999 {
            let mut pole = Vector::zeros();
            pole[which] = sign;
            way.insert(1, if one.dot(&pole).abs() > 0.9 { Vector::ith((which + 1) % 3, 1.0) } else { pole });
        }
        let legs = way.len() - 1;
        for (leg, pair) in way.windows(2).enumerate() {
            let is_last = leg + 1 == legs;
            let &[one, other] = pair else { continue };
            let angle = one.dot(&other).clamp(-1.0, 1.0).acos();
            let pieces = (angle / chord.max(1e-4)).ceil().max(1.0) as usize;
            for piece in 1..=pieces {
                let share = piece as f64 / pieces as f64;
                let turned = if angle > 1e-9 {
                    (one * ((1.0 - share) * angle).sin() + other * (share * angle).sin()) / angle.sin()
                } else {
                    other
                };
                let mut next = *to;
                let radius = if is_last { start + (end - start) * share } else { start };
                next.set_xyz(centre + turned * radius);
                let next = self.bent_inside(next, &centre, radius);
                self.go(&next, Some(feed))?;
            }
        }
        Ok(())
    }
}
