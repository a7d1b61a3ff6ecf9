//! Forward kinematics: pose of the tool in the workpiece for given axis commands, with and without errors.
//!
//! wTt = (F→w)⁻¹ (F→t). The tool frame has its origin at the tip and is parallel to F at the zero pose. It is carried through the spindle, through the axes
//! of the tool side to the foundation F, and through the inverse transforms of the workpiece side to the workpiece ([`super::link`]). The spindle has only a
//! location error D(e0), which acts at its gauge point.

use std::f64::consts::TAU;
use std::sync::Arc;

use ncfix_base::geometry::{AXIS_COUNT, Axis, AxisSet, AxisVector, Matrix, ROTARY_AXES, Vector};
use ncfix_machine::machine::{ActiveCompensation, AxisData, Condition, Kinematics, Machine, State, ZeroPose};

use super::body::{BodyPlace, Pointer, Ray, RigidBody, Witness};
use super::linear::{LinearAxes, LinearStep, Singular};
use super::link::{AxisLink, Displacement};
use super::motion::Functions;
use super::name::{Carrier, ErrorKind, ErrorName};
use super::rotation::vector_of;
use super::{Accumulator, ErrorModel, Features, Pose, features};

/// Machine with its errors, prepared for fast evaluation.
#[derive(Clone, Debug)]
pub struct Model {
    /// From the spindle to F.
    pub(super) tool_side: Vec<AxisLink>,
    /// From F to the workpiece.
    pub(super) workpiece_side: Vec<AxisLink>,
    spindle_mm: Vector,
    spindle_axis: Vector,
    spindle_error: Option<Displacement>,
    /// Axes that correct the position.
    pub(super) linear: LinearAxes,
    /// Axes that correct the orientation.
    pub(super) rotary: AxisSet,
    features: [Features; AXIS_COUNT],
    /// Axes whose errors repeat with every turn.
    pub(super) modulo: AxisSet,
    /// Compensation that the control adds to every command.
    active: Option<Arc<dyn ActiveCompensation>>,
    is_empty: bool,
    /// Constants of a machine without rotary axes.
    straight: Option<Straight>,
    /// The machine without errors, as its control knows it.
    kinematics: Kinematics,
    /// Displacement of the tip, in the workpiece frame, that the zero offset contains, mm.
    zero_mm: Vector,
    /// The same machine by the index of the zero offset, for those that contain a displacement.
    zeros: Arc<[Option<Model>]>,
    /// Displacements that the zero offsets contain if they were touched, by their index, mm.
    touches_mm: Arc<[Vector]>,
    /// The same machine with its other heads, by their index minus one.
    heads: Arc<[Model]>,
}

/// Constants of a machine with linear axes only: the nominal tip is a sum, and the step that brings the tip to its position is constant.
#[derive(Clone, Debug)]
struct Straight {
    /// Axes, and the displacement of the tip per mm of each.
    columns: Vec<(Axis, Vector)>,
    step: Result<LinearStep, Singular>,
}

/// Small displacement of the actual tool frame from the nominal one, in the nominal tool frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// Displacement of the tip, mm.
    pub translation: Vector,
    /// Rotation vector, rad.
    pub rotation: Vector,
}

impl Model {
    /// Prepares a machine and its errors in the reference condition. Errors of axes that the machine lacks have no effect.
    #[must_use]
    pub fn new(machine: &Machine, errors: &ErrorModel) -> Model {
        Model::at(machine, errors, &Condition::default())
    }

    /// Prepares a machine and its errors in a condition.
    #[must_use]
    pub fn at(machine: &Machine, errors: &ErrorModel, condition: &Condition) -> Model {
        Model::summed(&Accumulator::sum(machine, errors, condition, |_| true))
    }

    /// Prepares a machine and summed errors.
    #[must_use]
    pub fn summed(sum: &Accumulator<'_>) -> Model {
        let machine = sum.machine();
        let link = |data: &AxisData| {
            AxisLink::new(data, &sum.location(Carrier::Axis(data.axis)), Functions::of(data.axis, sum.motion()))
        };
        let branch = |axes: &[Axis]| axes.iter().filter_map(|&axis| machine.axis(axis)).map(link).collect::<Vec<_>>();
        let mut tool_side = branch(&machine.topology.tool);
        tool_side.reverse();
        let workpiece_side = branch(&machine.topology.workpiece);
        let spindle_error = Displacement::unless_zero(&sum.location(Carrier::Spindle));
        let axes: AxisSet = tool_side.iter().chain(&workpiece_side).map(|link| link.axis).collect();
        let active = machine.active_tables.control.clone();
        let is_empty = active.is_none()
            && spindle_error.is_none()
            && tool_side.iter().chain(&workpiece_side).all(AxisLink::is_ideal);
        let linear = LinearAxes::of(axes);
        let straight =
            axes.iter().all(|axis| !axis.is_rotary()).then(|| Straight::of(&tool_side, &workpiece_side, &linear));
        Model {
            straight,
            tool_side,
            workpiece_side,
            spindle_mm: machine.spindle.origin_mm,
            spindle_axis: machine.spindle.axis,
            spindle_error,
            linear,
            rotary: axes.intersection(ROTARY_AXES.into_iter().collect()),
            features: features::of(machine, sum.motion()),
            modulo: machine.axes.iter().flatten().filter(|data| data.modulo).map(|data| data.axis).collect(),
            active,
            is_empty,
            kinematics: Kinematics::new(machine),
            zero_mm: Vector::zeros(),
            zeros: Arc::new([]),
            touches_mm: Arc::new([]),
            heads: Arc::new([]),
        }
    }

    /// Returns the kinematics of the machine without errors.
    #[must_use]
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Returns the model with the displacements of the tip that touched zero offsets contain, by their index: in the workpiece frame, mm. For
    /// `relative` zeros, errors are relative to those at the touched place.
    #[must_use]
    pub fn with_zeros(self, touches_mm: &[Vector], relative: &[bool]) -> Model {
        let of = |(&zero_mm, &is_relative): (&Vector, &bool)| {
            (is_relative && zero_mm != Vector::zeros()).then(|| Model { zero_mm, ..self.clone() })
        };
        let zeros = touches_mm.iter().zip(relative).map(of).collect();
        Model { zeros, touches_mm: touches_mm.into(), ..self }
    }

    /// Returns the model with those of the other heads of the machine, from the second on, each with its zero offsets.
    #[must_use]
    pub fn with_heads(self, heads: Vec<Model>) -> Model {
        Model { heads: heads.into(), ..self }
    }

    /// True if an error of any head can differ from zero.
    #[must_use]
    pub fn has_errors(&self) -> bool {
        !self.is_empty || self.heads.iter().any(Model::has_errors)
    }

    /// Returns the model with a head by its index, without zero offsets in force.
    #[must_use]
    pub fn for_head(&self, head: u16) -> &Model {
        usize::from(head).checked_sub(1).and_then(|place| self.heads.get(place)).unwrap_or(self)
    }

    /// Returns the model with a head, in which errors count from the given zero offset.
    #[must_use]
    pub fn for_setup(&self, head: u16, zero: Option<u16>) -> &Model {
        self.for_head(head).for_zero(zero)
    }

    /// Returns the model with the zero offsets of another model of this machine.
    #[must_use]
    pub fn with_zeros_of(self, other: &Model) -> Model {
        let relative: Vec<bool> = other.zeros.iter().map(Option::is_some).collect();
        self.with_zeros(&other.touches_mm, &relative)
    }

    /// Returns the error of the tip beyond the displacement that a touched zero offset takes up, mm. `error_mm` is an error of the model for this zero
    /// offset, in the workpiece frame.
    #[must_use]
    pub fn form_mm(&self, zero: Option<u16>, error_mm: &Vector) -> f64 {
        let touch_mm = zero.map(|index| self.touch_mm(index)).unwrap_or_default();
        (error_mm + self.for_zero(zero).zero_mm - touch_mm).norm()
    }

    /// Returns the model in which errors count from the given zero offset. Without one, or if it contains no error, they count from the true position.
    #[must_use]
    pub fn for_zero(&self, zero: Option<u16>) -> &Model {
        zero.and_then(|index| self.zeros.get(usize::from(index))?.as_ref()).unwrap_or(self)
    }

    /// Returns the displacement of the tip that a zero offset contains if it was touched, in the workpiece frame, mm.
    #[must_use]
    pub fn touch_mm(&self, zero: u16) -> Vector {
        self.touches_mm.get(usize::from(zero)).copied().unwrap_or_default()
    }

    /// Returns the displacement of the tip that a zero touched with these poses for its sides X, Y and Z contains, in the workpiece frame at the
    /// pose of each, mm. A side gives the component of its own axis of F. An axis without a stated direction of motion is in the middle of its backlash.
    #[must_use]
    pub fn displacement_at(&self, sides: &[ZeroPose; 3]) -> Vector {
        let mut out = Vector::zeros();
        for (side, ZeroPose { command, tool_mm, direction }) in sides.iter().enumerate() {
            let state = State { direction: *direction, ..State::default() };
            let own = Vector::ith(side, self.deviation(command, tool_mm, &state).translation[side]);
            // From the directions of F through the tool frame to those of the workpiece.
            let in_tool = self.tool_orientation(command).transpose() * own;
            out += self.nominal(command, tool_mm).rotation * in_tool;
        }
        out
    }

    /// True if no error can ever differ from zero.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.is_empty
    }

    /// Returns the required sampling of the errors of an axis.
    #[must_use]
    pub fn features(&self, axis: Axis) -> &Features {
        &self.features[axis.slot()]
    }

    /// Returns the distance that the command of an axis must travel after a reversal until its body follows, mm or rad: the loss of the axis minus the
    /// addition by the tables of the control.
    #[must_use]
    pub fn lost_motion(&self, axis: Axis, command: &AxisVector) -> f64 {
        let lost = self.features[axis.slot()].lost_motion(command[axis]);
        match &self.active {
            Some(active) if lost > 0.0 && active.has_senses(axis) => {
                let [behind, ahead] = [-1, 1].map(|sense| {
                    let mut state = State::default();
                    state.direction[axis.slot()] = sense;
                    active.correction(command, &Vector::zeros(), &state)[axis]
                });
                (lost - (ahead - behind)).max(0.0)
            }
            _ => lost,
        }
    }

    /// Returns the pose of the tool in the workpiece without errors. `tool_mm` runs from the spindle gauge point to the tip, in F at the zero pose.
    #[must_use]
    pub fn nominal(&self, command: &AxisVector, tool_mm: &Vector) -> Pose {
        self.carry(Pose::parallel_at(*tool_mm), command, None)
    }

    /// Returns the pose of the tool in the workpiece frame with errors, with the tip in mm. `command` is in mm and rad, `tool_mm` as for [`Model::nominal`].
    ///
    /// This is the single forward function of correction and prediction. `tip`, `ray` and `pointer` evaluate the same chain for less or more data: the formula
    /// is in `carry` and in `link.rs` only.
    #[must_use]
    pub fn actual(&self, command: &AxisVector, tool_mm: &Vector, state: &State) -> Pose {
        self.carry(Pose::parallel_at(*tool_mm), &self.controlled(command, tool_mm, Some(state)), Some(state))
    }

    /// Returns the volumetric error: the actual tool frame as seen from the nominal one at the same command (Esmaeili 2021, eq. 4).
    #[must_use]
    pub fn volumetric_error(&self, command: &AxisVector, tool_mm: &Vector, state: &State) -> Twist {
        let seen = self.nominal(command, tool_mm).inverse_times(&self.actual(command, tool_mm, state));
        Twist { translation: seen.translation, rotation: vector_of(&seen.rotation) }
    }

    /// Returns the deviation of the tool from the workpiece point that nominally coincides with its tip, along the directions of F: the volumetric error,
    /// rotated from the nominal tool frame to F.
    #[must_use]
    pub fn deviation(&self, command: &AxisVector, tool_mm: &Vector, state: &State) -> Twist {
        let error = self.volumetric_error(command, tool_mm, state);
        let turn = self.tool_orientation(command);
        Twist { translation: turn * error.translation, rotation: turn * error.rotation }
    }

    /// Returns the directions of the nominal tool frame in F, as columns.
    #[must_use]
    pub fn tool_orientation(&self, command: &AxisVector) -> Matrix {
        let mut pose = Pose::parallel_at(Vector::zeros());
        self.tool_side.iter().for_each(|link| link.carry(&mut pose, command, None));
        pose.rotation
    }

    /// Returns the tip at `command` with errors minus the nominal tip at `nominal`, in the workpiece frame, mm.
    #[must_use]
    pub fn tip_error_mm(&self, nominal: &AxisVector, command: &AxisVector, tool_mm: &Vector, state: &State) -> Vector {
        self.tip(command, tool_mm, Some(state)) - self.nominal_tip(nominal, tool_mm)
    }

    /// Returns the first-order effect of one error component on the volumetric error, per mm or rad of the component, in the nominal tool frame.
    ///
    /// With Q the tool frame as seen from the place where the error ε, ω acts: rotation Qᵀω, translation Qᵀ(ε + ω × t). The sign is negative on the workpiece
    /// side, because the workpiece moves instead of the tool (transport matrices of Esmaeili 2021, eq. 53). Zero for an axis that the machine lacks.
    #[must_use]
    pub fn sensitivity(&self, name: ErrorName, command: &AxisVector, tool_mm: &Vector) -> Twist {
        let place = if name.kind == ErrorKind::Location { BodyPlace::Location } else { BodyPlace::Motion };
        let witness = Witness::new(Pose::parallel_at(*tool_mm), name.carrier, place);
        let Some(seen) = self.carry(witness, command, None).seen else {
            return Twist { translation: Vector::zeros(), rotation: Vector::zeros() };
        };
        let on_workpiece_side = self.workpiece_side.iter().any(|link| name.axis() == Some(link.axis));
        let back = seen.rotation.transpose() * if on_workpiece_side { -1.0 } else { 1.0 };
        let unit = Vector::ith(name.direction.index() % 3, 1.0);
        if name.direction.is_rotation() {
            Twist { translation: back * unit.cross(&seen.translation), rotation: back * unit }
        } else {
            Twist { translation: back * unit, rotation: Vector::zeros() }
        }
    }

    /// Returns a location error, mm or rad; 0 for a motion error, and for an axis that the machine lacks.
    #[must_use]
    pub fn location(&self, name: ErrorName) -> f64 {
        let of_axis = |link: &AxisLink| (Carrier::Axis(link.axis) == name.carrier).then_some(link.location)?;
        let own = match name.carrier {
            Carrier::Spindle => self.spindle_error,
            Carrier::Axis(_) => self.tool_side.iter().chain(&self.workpiece_side).find_map(of_axis),
        };
        let own = own.filter(|_| name.kind == ErrorKind::Location);
        own.map_or(0.0, |own| own.component(name.direction.index()))
    }

    /// Returns a motion error of an axis at a command, mm or rad; 0 for a location error, and for an axis that the machine lacks.
    #[must_use]
    pub fn motion(&self, name: ErrorName, command: &AxisVector, state: &State) -> f64 {
        let mut links = self.tool_side.iter().chain(&self.workpiece_side);
        let own = links.find(|link| Carrier::Axis(link.axis) == name.carrier && name.kind == ErrorKind::Motion);
        let error = own.and_then(|link| link.motion_error(command, Some(state)));
        error.map_or(0.0, |error| error.component(name.direction.index()))
    }

    /// Returns tip and axis of the tool with their derivatives by the commands, in the workpiece frame.
    pub(super) fn pointer(&self, command: &AxisVector, tool_mm: &Vector, errors: Option<&State>) -> Pointer {
        self.carry(Pointer::new(*tool_mm, self.spindle_axis), &self.controlled(command, tool_mm, errors), errors)
    }

    /// Returns tip and axis of the tool in the workpiece frame, with errors.
    pub(super) fn ray(&self, command: &AxisVector, tool_mm: &Vector, state: &State) -> Ray {
        let command = self.controlled(command, tool_mm, Some(state));
        self.carry(Ray { tip: *tool_mm, axis: self.spindle_axis }, &command, Some(state))
    }

    /// Returns the axes that correct the position (X or U, Y or V, Z or W) of a machine without rotary axes; otherwise `None`.
    #[must_use]
    pub fn straight_axes(&self) -> Option<[Option<Axis>; 3]> {
        self.straight.as_ref().map(|_| self.linear.0)
    }

    /// Returns the step of the linear axes on a machine without rotary axes; `None` if it has rotary axes.
    pub(super) fn straight_step(&self) -> Option<&Result<LinearStep, Singular>> {
        self.straight.as_ref().map(|straight| &straight.step)
    }

    /// Returns the tip in the workpiece frame without errors, mm: that of [`Self::nominal`].
    pub(super) fn nominal_tip(&self, command: &AxisVector, tool_mm: &Vector) -> Vector {
        let Some(straight) = &self.straight else { return self.carry(*tool_mm, command, None) };
        straight.columns.iter().fold(self.spindle_mm + tool_mm, |tip, (axis, column)| tip + column * command[*axis])
    }

    /// Returns the tip in the workpiece frame, mm.
    pub(super) fn tip(&self, command: &AxisVector, tool_mm: &Vector, errors: Option<&State>) -> Vector {
        self.carry(*tool_mm, &self.controlled(command, tool_mm, errors), errors)
    }

    /// Returns the command that the control really executes: the command plus the correction of its tables. Without errors it is the command itself.
    fn controlled(&self, command: &AxisVector, tool_mm: &Vector, errors: Option<&State>) -> AxisVector {
        match (&self.active, errors) {
            (Some(active), Some(state)) => *command + active.correction(command, tool_mm, state),
            _ => *command,
        }
    }

    /// Carries a body from the spindle to the workpiece; with errors if there is a state.
    fn carry<B: RigidBody>(&self, mut body: B, command: &AxisVector, errors: Option<&State>) -> B {
        let mut within_turn;
        let mut command = command;
        if !self.modulo.is_empty() {
            within_turn = *command;
            for axis in self.modulo.iter() {
                within_turn[axis] = command[axis].rem_euclid(TAU);
            }
            command = &within_turn;
        }
        body.visit(Carrier::Spindle, BodyPlace::Location);
        if let (Some(error), Some(_)) = (&self.spindle_error, errors) {
            error.apply(&mut body);
        }
        body.translate(&self.spindle_mm);
        for link in &self.tool_side {
            link.carry(&mut body, command, errors);
        }
        for link in &self.workpiece_side {
            link.uncarry(&mut body, command, errors);
        }
        if errors.is_some() {
            body.translate(&-self.zero_mm);
        }
        body
    }
}

impl Straight {
    fn of(tool_side: &[AxisLink], workpiece_side: &[AxisLink], linear: &LinearAxes) -> Straight {
        let mut columns = [Vector::zeros(); AXIS_COUNT];
        for (links, sense) in [(tool_side, 1.0), (workpiece_side, -1.0)] {
            for link in links {
                columns[link.axis.slot()] = link.direction * sense;
            }
        }
        let correcting = linear.0.map(|axis| axis.map_or(Vector::zeros(), |axis| columns[axis.slot()]));
        let moving = tool_side.iter().chain(workpiece_side).map(|link| (link.axis, columns[link.axis.slot()]));
        Straight { columns: moving.collect(), step: LinearStep::new(linear, correcting) }
    }
}
