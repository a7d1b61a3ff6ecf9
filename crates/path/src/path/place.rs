//! Corrects a nominal position and rounds it to the grid of increments, so that the tool is at its nominal place.
//!
//! Rotary axes are rounded first; the linear axes are then solved for the rounded rotary commands and rounded last. The tip error is therefore only
//! the rounding of the linear axes, independent of the lever arm of rotary axes.

mod partly;

use std::cell::RefCell;
use std::sync;

use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisSet, AxisVector, LINEAR_AXES, Matrix, ROTARY_AXES};
use ncfix_machine::machine::{Kinematics, Machine, State, TipPath};
use ncfix_machine::snc::{Move, Setup, Turning};
use ncfix_model::{Model, NotConverged, Solve};

use super::cut::MOST_FEED;
use super::route::{Route, RouteArc};
use super::slope::Slope;
use super::way::turned_deg;
use super::{Centers, CorrectionOptions, Increments, OutputFrame, Rotary, Turns};

/// Resolution of axis feeds, parts of a mm/min.
const FEED_PARTS: f64 = 1e3;
/// Tolerance within which a count is a whole number: rounding noise.
const WHOLE_COUNT: f64 = 1e-4;
/// Deviation of a frame from a rigid one that is rounding noise.
const SAME_LENGTH: f64 = 1e-9;
/// Paths shorter than this are rounding noise, mm.
pub(super) const SHORT_MM: f64 = 1e-7;

/// A position that can be written: counts in the emitted frame, and the corresponding axis command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub(super) counts: [i64; AXIS_COUNT],
    pub(super) command: AxisVector,
    /// Reason why the position is not corrected.
    pub(super) failure: Option<NotConverged>,
    /// `true` if the correction of a rotary axis is limited near a singularity ([`super::singularity`]).
    pub(super) is_held_back: bool,
}

/// Corrects and rounds positions.
#[derive(Clone, Debug)]
pub(super) struct CommandSolver<'a> {
    /// The model in the zero offset in force.
    pub(super) model: &'a Model,
    /// The model with all heads and zero offsets.
    pub(super) base: &'a Model,
    pub(super) setup: sync::Arc<Setup>,
    pub(super) increments: Increments,
    pub(super) turns: Turns,
    pub(super) centers: Centers,
    kinematics: &'a Kinematics,
    frame: OutputFrame,
    keeps_transform: bool,
    /// `true` if an arc may be a circle through an intermediate point.
    pub(super) has_spatial_arcs: bool,
    /// The axes of the machine.
    axes: AxisSet,
    pub(super) has_rotary: bool,
    /// The rotary axes that participate in the correction.
    turning: AxisSet,
    /// Axes that stay during a move, and their positions.
    fixed: AxisSet,
    fixed_at: AxisVector,
    is_empty: bool,
    /// Improved guesses on a machine without rotary axes.
    slope: Option<RefCell<Slope>>,
}

impl<'a> CommandSolver<'a> {
    pub(super) fn new(machine: &Machine, model: &'a Model, options: &CorrectionOptions) -> CommandSolver<'a> {
        let axes = machine.axis_set();
        let has_rotary = axes.iter().any(Axis::is_rotary);
        CommandSolver {
            model,
            base: model,
            axes,
            setup: sync::Arc::default(),
            increments: Increments::new(&machine.control),
            turns: options.turns,
            centers: options.centers,
            kinematics: model.kinematics(),
            frame: options.frame,
            keeps_transform: options.keeps_transform(),
            has_spatial_arcs: options.has_spatial_arcs && options.frame == OutputFrame::Work,
            has_rotary,
            turning: match options.rotary {
                Rotary::Correct => axes.iter().filter(|axis| axis.is_rotary()).collect(),
                Rotary::Auto | Rotary::Hold => AxisSet::EMPTY,
            },
            fixed: AxisSet::EMPTY,
            fixed_at: AxisVector::ZERO,
            is_empty: model.is_empty(),
            slope: slope_of(model),
        }
    }

    /// Changes the meaning of coordinates. The axes stay: `counts` becomes their position in the new coordinates, and axes without such a position
    /// leave `written`.
    pub(super) fn set_up(
        &mut self,
        setup: sync::Arc<Setup>,
        command: &AxisVector,
        counts: &mut [i64; AXIS_COUNT],
        written: &mut AxisSet,
    ) {
        let of_head = self.base.for_head(setup.head);
        if setup.head != self.setup.head {
            self.kinematics = of_head.kinematics();
            self.is_empty = of_head.is_empty();
            self.slope = slope_of(of_head);
        }
        self.model = of_head.for_zero(setup.zero);
        self.setup = setup;
        let programmed = self.programmed(command);
        for axis in written.iter() {
            let ratio = self.increments.ratio(axis, programmed[axis]);
            if (ratio - ratio.round()).abs() < WHOLE_COUNT {
                counts[axis.slot()] = self.increments.count(axis, programmed[axis]);
            } else {
                written.remove(axis);
            }
        }
    }

    /// Sets the rotary axes that participate in the correction.
    pub(super) fn set_turning(&mut self, turning: AxisSet) {
        self.turning = turning;
    }

    /// The rotary axes that participate.
    pub(super) fn turning(&self) -> AxisSet {
        self.turning
    }

    /// Fixes axes at their position in `command` for the next move.
    pub(super) fn fix(&mut self, fixed: AxisSet, command: &AxisVector) {
        self.fixed = fixed;
        self.fixed_at = *command;
    }

    /// Sets the fixed axes to their positions.
    fn at_rest(&self, mut command: AxisVector) -> AxisVector {
        if !self.fixed.is_empty() {
            self.fixed.iter().for_each(|axis| command[axis] = self.fixed_at[axis]);
        }
        command
    }

    /// Coordinates in the emitted frame.
    pub(super) fn programmed(&self, command: &AxisVector) -> AxisVector {
        let mut position = *command;
        if self.is_transformed() {
            position = self.kinematics.on_workpiece(command, &self.setup.tool_mm);
        }
        match self.frame {
            OutputFrame::Work => self.setup.programmed(&position),
            OutputFrame::Machine => {
                let mut out = position;
                out.set_xyz(out.xyz() + self.setup.tool_mm);
                out
            }
        }
    }

    fn command(&self, programmed: &AxisVector) -> AxisVector {
        let position = match self.frame {
            OutputFrame::Work => self.setup.command(programmed),
            OutputFrame::Machine => {
                let mut out = *programmed;
                out.set_xyz(out.xyz() - self.setup.tool_mm);
                out
            }
        };
        if !self.is_transformed() {
            return position;
        }
        // The execution rejects machines that have no transformation.
        self.kinematics.command_on_workpiece(&position, &self.setup.tool_mm).unwrap_or(position)
    }

    /// `true` if the emitted coordinates are those of the tip in the workpiece.
    pub(super) fn is_transformed(&self) -> bool {
        self.keeps_transform && self.setup.transform.is_some()
    }

    /// `true` if the program has a transformation here that the output resolves.
    pub(super) fn leaves_transform(&self) -> bool {
        !self.keeps_transform && self.setup.transform.is_some()
    }

    /// Converts a tip feed to the axes if the output has no transformation: the path feed of a control then refers to X, Y, Z. If only rotary axes
    /// move, or the tip stays, it refers to these in degrees.
    pub(super) fn feed(&self, start: &AxisVector, motion: &Move) -> f64 {
        if self.keeps_transform || self.setup.transform.is_none() || motion.is_inverse_time() {
            return motion.feed;
        }
        let end = &motion.target;
        let tip = |command: &AxisVector| self.kinematics.tip_mm(command, &self.setup.tool_mm);
        let tip_mm = (tip(end) - tip(start)).norm();
        let linear_mm = (end.xyz() - start.xyz()).norm();
        let turned_deg = turned_deg(start, end);
        let [way, of_tip] = [linear_mm, tip_mm].map(|way| if way > SHORT_MM { way } else { turned_deg });
        let ratio = if way > 0.0 && of_tip > 0.0 { way / of_tip } else { 1.0 };
        ((motion.feed * ratio * FEED_PARTS).round() / FEED_PARTS).min(motion.feed.max(MOST_FEED))
    }

    /// The path of the output between two axis commands: under a transformation that of the tip if the tool turns, otherwise straight in the axes.
    pub(super) fn emitted(&self, start: AxisVector, end: AxisVector) -> Route<'a> {
        self.emitted_arc(start, end, None)
    }

    /// The path of the output as an arc in the coordinates of [`Self::position`], or as a line.
    pub(super) fn emitted_arc(&self, start: AxisVector, end: AxisVector, arc: RouteArc) -> Route<'a> {
        let turns = |axis: &Axis| start[*axis] != end[*axis];
        match self.setup.transform {
            Some(turning) if self.is_transformed() && (arc.is_some() || ROTARY_AXES.iter().any(turns)) => {
                self.of_tip(turning, [start, end], arc)
            }
            _ => Route::new(start, end, arc),
        }
    }

    /// The path of a move of the program that begins at an axis command.
    pub(super) fn nominal(&self, start: AxisVector, motion: &Move) -> Route<'a> {
        let arc = motion.arc.map(|arc| (arc, motion.arc_basis));
        match motion.tip {
            Some(turning) => self.of_tip(turning, [start, motion.target], arc),
            None => Route::new(start, motion.target, arc),
        }
    }

    fn of_tip(&self, turning: Turning, ends: [AxisVector; 2], arc: RouteArc) -> Route<'a> {
        let follows_circle = turning == Turning::Vector;
        let tip = TipPath::new(self.kinematics, follows_circle, ends.each_ref(), &self.setup.tool_mm);
        Route::of_tip(ends[0], ends[1], arc, tip)
    }

    /// The position that the output interpolates: fixed to the workpiece under a transformation, otherwise the axis command.
    pub(super) fn position(&self, command: &AxisVector) -> AxisVector {
        if self.is_transformed() { self.kinematics.on_workpiece(command, &self.setup.tool_mm) } else { *command }
    }

    /// Length of the tip path of a move, mm, or, if the tip stays, its turn in degrees.
    pub(super) fn tip_way(&self, route: &Route<'_>) -> f64 {
        let [start, end] = [&route.start, &route.end].map(|end| self.kinematics.on_workpiece(end, &self.setup.tool_mm));
        let way_mm = if route.is_of_tip() { route.length_mm() } else { (end.xyz() - start.xyz()).norm() };
        if way_mm > SHORT_MM { way_mm } else { turned_deg(&route.start, &route.end) }
    }

    /// `true` if a word belongs to the transformation and the output has none.
    pub(super) fn drops(&self, word: &str) -> bool {
        !self.keeps_transform && ["TRA", "ORI"].iter().any(|start| word.starts_with(start))
    }

    /// `true` if directions in the emitted frame are those of the axes.
    pub(super) fn is_parallel(&self) -> bool {
        !self.is_transformed() && (self.frame == OutputFrame::Machine || self.setup.frame.is_translation())
    }

    /// `true` if the emitted frame shifts, rotates and mirrors, and does not scale.
    pub(super) fn keeps_lengths(&self) -> bool {
        let linear = self.setup.frame.linear();
        let is_rigid = || (linear.tr_mul(linear) - Matrix::identity()).amax() < SAME_LENGTH;
        self.is_parallel() || !self.is_transformed() && is_rigid()
    }

    /// A command in coordinates along the axes of the emitted frame: the command itself if these are the axes of the machine.
    pub(super) fn in_frame(&self, command: &AxisVector) -> AxisVector {
        if self.is_parallel() { *command } else { self.programmed(command) }
    }

    /// The command at these coordinates; the inverse of [`Self::in_frame`].
    pub(super) fn of_frame(&self, place: &AxisVector) -> AxisVector {
        if self.is_parallel() { *place } else { self.command(place) }
    }

    /// The command on the grid that brings the tip to its nominal place at `nominal`. Axes outside `known` stay at `nominal`. `guess` is a correction
    /// nearby; those of rotary axes differ from it by at most `most_turn_rad`.
    pub(super) fn place(
        &self,
        nominal: &AxisVector,
        known: AxisSet,
        state: &State,
        guess: &AxisVector,
        most_turn_rad: f64,
    ) -> Placed {
        match self.exact(nominal, known, state, guess, most_turn_rad) {
            Ok(exact) => self.round(&exact, known),
            Err(failure) => Placed { failure: Some(failure), ..self.round(&self.at_rest(*nominal), known) },
        }
    }

    /// As [`Self::place`], before the linear axes are rounded.
    pub(super) fn exact(
        &self,
        nominal: &AxisVector,
        known: AxisSet,
        state: &State,
        guess: &AxisVector,
        most_turn_rad: f64,
    ) -> Result<AxisVector, NotConverged> {
        if self.is_empty && !self.has_rotary {
            return Ok(self.at_rest(*nominal));
        }
        let tool_mm = &self.setup.tool_mm;
        if let Some(learnt) = &self.slope {
            let mut slope = learnt.borrow_mut();
            let guess = slope.guess(nominal);
            let exact = self.model.solve(nominal, tool_mm, state, &guess, Solve::PositionOnly)?;
            slope.learn(nominal, &exact, &guess);
            return Ok(self.at_rest(self.keep_unknown(exact, nominal, known)));
        }
        let mut start = *nominal + *guess;
        if !self.turning.is_empty() && !self.is_empty {
            let mut turned = self.model.solve(nominal, tool_mm, state, &start, Solve::Full)?;
            for axis in ROTARY_AXES {
                let near = nominal[axis] + guess[axis];
                turned[axis] = if self.turning.contains(axis) {
                    turned[axis].max(near - most_turn_rad).min(near + most_turn_rad)
                } else {
                    nominal[axis]
                };
            }
            start = self.round_axes(&self.keep_unknown(turned, nominal, known), &ROTARY_AXES, known);
        } else if self.has_rotary {
            for axis in ROTARY_AXES {
                start[axis] = nominal[axis];
            }
            start = self.round_axes(&start, &ROTARY_AXES, known);
        }
        let exact = self.model.solve(nominal, tool_mm, state, &self.at_rest(start), Solve::PositionOnly)?;
        Ok(self.at_rest(self.keep_unknown(exact, nominal, known)))
    }

    /// Solves the linear axes for a command whose rotary axes stay.
    pub(super) fn around(
        &self,
        nominal: &AxisVector,
        known: AxisSet,
        state: &State,
        command: &AxisVector,
    ) -> Result<AxisVector, NotConverged> {
        let exact = self.model.solve(nominal, &self.setup.tool_mm, state, command, Solve::PositionOnly)?;
        Ok(self.at_rest(self.keep_unknown(exact, nominal, known)))
    }

    /// The nearest position on the grid.
    pub(super) fn round(&self, command: &AxisVector, known: AxisSet) -> Placed {
        let mut programmed = self.programmed(command);
        let mut counts = [0; AXIS_COUNT];
        let axes: &[Axis] = if self.has_rotary { &AXES } else { &LINEAR_AXES };
        for &axis in axes {
            if known.contains(axis) {
                let count = self.increments.count(axis, programmed[axis]);
                counts[axis.slot()] = count;
                programmed[axis] = self.increments.position(axis, count);
            }
        }
        Placed {
            counts,
            command: self.keep_unknown(self.command(&programmed), command, known),
            failure: None,
            is_held_back: false,
        }
    }

    fn round_axes(&self, command: &AxisVector, axes: &[Axis], known: AxisSet) -> AxisVector {
        let programmed = self.programmed(command);
        let mut rounded = programmed;
        for &axis in axes {
            if known.contains(axis) {
                rounded[axis] = self.increments.position(axis, self.increments.count(axis, programmed[axis]));
            }
        }
        let rounded = self.command(&rounded);
        let mut out = *command;
        for &axis in axes {
            out[axis] = rounded[axis];
        }
        out
    }

    /// `true` if programs are written in machine coordinates.
    pub(super) fn is_machine_frame(&self) -> bool {
        self.frame == OutputFrame::Machine
    }

    /// `true` if the axes of the output are not those of the program.
    pub(super) fn turns_output(&self) -> bool {
        self.is_machine_frame() && !self.setup.frame.is_translation()
    }

    /// The axes of the output that a move names, those that are known after it, and the first axis that must be written but is unknown.
    pub(super) fn in_output_axes(&self, motion: &Move) -> (AxisSet, AxisSet, Option<Axis>) {
        let frame = &self.setup.frame;
        if !self.is_machine_frame() || frame.is_translation() {
            return (motion.named, motion.known, None);
        }
        let (named, known) = (frame.mixed_with(motion.named), frame.known_across(motion.known, false));
        let unknown = named.difference(known).iter().next();
        (named.intersection(known), known, unknown)
    }

    fn keep_unknown(&self, mut command: AxisVector, nominal: &AxisVector, known: AxisSet) -> AxisVector {
        if !self.is_parallel() {
            // Unknown axes are axes of the program here.
            if !AxisSet::XYZ.difference(known).is_empty() {
                let (mut programmed, stays) = (self.programmed(&command), self.programmed(nominal));
                for axis in AxisSet::XYZ.difference(known).iter() {
                    programmed[axis] = stays[axis];
                }
                command = self.command(&programmed);
            }
            for axis in unknown_others(known) {
                command[axis] = nominal[axis];
            }
            return command;
        }
        for axis in self.axes.difference(known).iter() {
            command[axis] = nominal[axis];
        }
        command
    }

    /// Angle between the tool at `command` with errors and its nominal direction at `nominal`, rad.
    pub(super) fn tilt_rad(&self, nominal: &AxisVector, command: &AxisVector, state: &State) -> f64 {
        let tool_mm = &self.setup.tool_mm;
        let turn = self.model.nominal(nominal, tool_mm).turn_to(&self.model.actual(command, tool_mm, state));
        let tool_axis = self.kinematics.tool_axis();
        (turn - tool_axis * turn.dot(tool_axis)).norm()
    }

    /// Distance of the tip at `command` with errors from the nominal tip at `nominal`, mm.
    pub(super) fn tip_error_mm(&self, nominal: &AxisVector, command: &AxisVector, state: &State) -> f64 {
        self.model.tip_error_mm(nominal, command, &self.setup.tool_mm, state).norm()
    }
}

/// Guesses of a machine without rotary axes.
fn slope_of(model: &Model) -> Option<RefCell<Slope>> {
    model.straight_axes().map(|axes| RefCell::new(Slope::new(axes)))
}

/// Unknown axes other than X Y Z.
fn unknown_others(known: AxisSet) -> impl Iterator<Item = Axis> {
    AXES.into_iter().skip(3).filter(move |&axis| !known.contains(axis))
}
