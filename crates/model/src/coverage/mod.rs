//! Coverage: where positions, tools and the condition of a machine go beyond the ranges in which its errors were measured.
//!
//! A gap is an assumption: the error model has a value there, but no measurement supports it. The machine file states the ranges in `[measured]`, and a
//! table of an axis states its own by its positions.

mod angles;
mod text;

use std::collections::BTreeMap;

use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, LINEAR_AXES, Vector};
use ncfix_machine::machine::condition::change_readings;
use ncfix_machine::machine::{Condition, Load, Machine, MeasuredRanges, State};

use super::ErrorModel;
use super::accumulator::Accumulator;
use super::forward::Model;
use super::motion::EntryFunction;
use super::name::{ErrorKind, ErrorName};
use super::source::Effect;

/// Positions nearer to each other than this are equal: rounding noise, mm or rad.
const ON_LIMIT: f64 = 1e-6;
/// Values up to this beyond a measured range are within it, mm, K or N: half of the last digit of 0.01 with which ranges and readings are written.
const WITHIN: f64 = 5e-3;
/// Share of a turn from which a measurement of a modulo axis counts as a whole turn: one of twelve steps may be missing.
const WHOLE_TURN: f64 = 11.0 / 12.0;
/// Rise of the first sensor in the condition that reveals which axes an effect concerns, K. The next ones rise by more, so that they do not cancel.
const PROBE_K: f64 = 10.0;
/// Weight in the same condition, N.
const PROBE_N: f64 = 1000.0;

/// Positions and tools that a program or a set of tables uses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UsedRanges {
    /// Lowest and highest position of each axis, mm or rad.
    pub axes: BTreeMap<Axis, [f64; 2]>,
    /// Shortest and longest tool, from the gauge point of the spindle to the tip, in F at the zero pose, mm; `None` if no tool is in use.
    pub tools_mm: Option<[Vector; 2]>,
}

/// Kind of a gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum GapKind {
    /// An axis moves, and the machine file has no error that depends on it.
    NoErrors,
    /// The machine file has errors of an axis and does not state in which range they were measured.
    RangeNotStated,
    /// Two axes move, and no measurement shows their squareness.
    Squareness,
    /// An axis moves, and no measurement shows its positioning or a straightness.
    Component,
    /// An axis moves, and no measurement shows one of its angles.
    Angle,
    /// Position beyond the measured range.
    Position,
    /// Tool shorter or longer than the tools of the measurement.
    ToolLength,
    /// Temperature beyond the measured range.
    Temperature,
    /// Weight on the table beyond the measured range.
    Load,
}

/// Place that no measurement covers.
#[derive(Clone, Debug, PartialEq)]
pub struct CoverageGap {
    /// Kind.
    pub kind: GapKind,
    /// Axis; `None` if the gap does not concern an axis.
    pub axis: Option<Axis>,
    /// Sensor of a temperature.
    pub sensor: Option<String>,
    /// Error whose table ends; `None` if `[measured]` states the range.
    pub table: Option<ErrorName>,
    /// Squareness that no measurement shows.
    pub squareness: Option<ErrorName>,
    /// Positioning, straightness and angular errors, and places of rotary axes, that no measurement shows.
    pub components: Vec<ErrorName>,
    /// Longest arm over which one of these angles displaces the tool, mm: 1 µrad of it over 1000 mm are 1 µm.
    pub arm_mm: Option<f64>,
    /// Lowest and highest value in use: mm, rad, °C or N.
    pub used: [f64; 2],
    /// Measured range in the same unit, if it is known.
    pub measured: Option<[f64; 2]>,
    /// Distance from the measured range, positive above it, negative below it; 0 without a range.
    pub beyond: f64,
    /// Part of the error of the tool tip that is extrapolated, mm; `None` if it cannot be bounded.
    pub size_mm: Option<f64>,
}

/// Coverage of a program or of tables by the measurements of a machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coverage {
    /// True if the machine file states measured ranges.
    pub is_stated: bool,
    /// Gaps, by kind and axis.
    pub gaps: Vec<CoverageGap>,
}

impl GapKind {
    /// Returns its name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            GapKind::NoErrors => "no-errors",
            GapKind::RangeNotStated => "range-not-stated",
            GapKind::Squareness => "squareness",
            GapKind::Component => "component",
            GapKind::Angle => "angle",
            GapKind::Position => "position",
            GapKind::ToolLength => "tool-length",
            GapKind::Temperature => "temperature",
            GapKind::Load => "load",
        }
    }

    /// Returns the code of its diagnostic.
    #[must_use]
    pub fn code(self) -> Code {
        match self {
            GapKind::NoErrors => Code::AXIS_WITHOUT_ERRORS,
            GapKind::RangeNotStated => Code::RANGE_NOT_STATED,
            GapKind::Squareness => Code::SQUARENESS_NOT_SHOWN,
            GapKind::Component | GapKind::Angle => Code::COMPONENT_NOT_SHOWN,
            GapKind::Position => Code::BEYOND_MEASURED,
            GapKind::ToolLength => Code::TOOL_BEYOND_MEASURED,
            GapKind::Temperature | GapKind::Load => Code::STATE_BEYOND_MEASURED,
        }
    }
}

impl CoverageGap {
    /// Returns a gap of a kind for used values, mm, rad, °C or N, of which nothing else is known.
    fn new(kind: GapKind, used: [f64; 2]) -> CoverageGap {
        CoverageGap {
            kind,
            axis: None,
            sensor: None,
            table: None,
            squareness: None,
            components: Vec::new(),
            arm_mm: None,
            used,
            measured: None,
            beyond: 0.0,
            size_mm: None,
        }
    }
}

impl Coverage {
    /// Compares the used ranges and the condition with those in which the errors were measured. A machine without errors has no gaps, as nothing is corrected.
    #[must_use]
    pub fn of(machine: &Machine, errors: &ErrorModel, condition: &Condition, used: &UsedRanges) -> Coverage {
        let is_stated = machine.measured.is_some();
        if errors.effects().next().is_none() {
            return Coverage { is_stated, gaps: Vec::new() };
        }
        let survey = Survey::new(machine, errors, condition, used);
        let mut gaps = Vec::new();
        for (&axis, &range) in &used.axes {
            survey.axis(axis, range, &mut gaps);
        }
        survey.squareness(&mut gaps);
        survey.components(&mut gaps);
        survey.angles(&mut gaps);
        survey.tools(&mut gaps);
        survey.temperatures(&mut gaps);
        gaps.extend(survey.load());
        gaps.sort_by_key(|gap| gap.kind);
        Coverage { is_stated, gaps }
    }

    /// Largest change of the error of the tip over the used ranges if its tool has the length of `tools_mm[1]` instead of `tools_mm[0]`, mm.
    #[must_use]
    pub fn change_with_tool(
        machine: &Machine,
        errors: &ErrorModel,
        condition: &Condition,
        used: &UsedRanges,
        tools_mm: [&Vector; 2],
    ) -> f64 {
        let survey = Survey::new(machine, errors, condition, used);
        let error = |pose: &AxisVector, tool_mm| survey.model.deviation(pose, tool_mm, &State::default()).translation;
        let [one, other] = tools_mm;
        let change = |pose: &AxisVector| (error(pose, other) - error(pose, one)).norm();
        survey.poses.iter().map(change).fold(0.0, f64::max)
    }

    /// True if the measured ranges are known and nothing goes beyond them.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.is_stated && self.gaps.is_empty()
    }
}

/// Comparison in progress.
struct Survey<'a> {
    machine: &'a Machine,
    errors: &'a ErrorModel,
    condition: &'a Condition,
    used: &'a UsedRanges,
    measured: MeasuredRanges,
    model: Model,
    /// Axes on which an error depends.
    with_errors: AxisSet,
    /// True if the direction of the tool matters: rotary axes or angular errors.
    has_angles: bool,
    /// Poses at which sizes are computed: lowest, middle and highest position of every axis.
    poses: [AxisVector; 3],
}

impl<'a> Survey<'a> {
    fn new(machine: &'a Machine, errors: &'a ErrorModel, condition: &'a Condition, used: &'a UsedRanges) -> Survey<'a> {
        let names = names_of(machine, errors);
        let mut poses = [AxisVector::ZERO; 3];
        for (&axis, &[low, high]) in &used.axes {
            for (pose, value) in poses.iter_mut().zip([low, low.midpoint(high), high]) {
                pose[axis] = value;
            }
        }
        Survey {
            machine,
            errors,
            condition,
            used,
            measured: machine.measured.clone().unwrap_or_default(),
            model: Model::at(machine, errors, condition),
            with_errors: axes_of(machine, &names),
            has_angles: machine.axes.iter().flatten().any(|data| data.axis.is_rotary())
                || names.iter().any(|(name, _)| name.direction.is_rotation()),
            poses,
        }
    }

    /// The longest tool in use, mm.
    fn tool_mm(&self) -> Vector {
        self.used.tools_mm.map_or_else(Vector::zeros, |[_, longest]| longest)
    }

    fn axis(&self, axis: Axis, used: [f64; 2], gaps: &mut Vec<CoverageGap>) {
        let gap = |kind| CoverageGap { axis: Some(axis), ..CoverageGap::new(kind, used) };
        // The zero offset contains the error of a linear axis that stands still. A rotary axis in its zero position is where the others were measured.
        let is_zero = used.iter().all(|end| end.abs() <= ON_LIMIT);
        let stays = if axis.is_rotary() { is_zero } else { used[1] - used[0] <= ON_LIMIT };
        if let Some(&measured) = self.measured.axes.get(&axis) {
            let used = self.in_turn(axis, used, measured);
            let within = if axis.is_rotary() { WITHIN.to_radians() } else { WITHIN };
            for beyond in beyond(used, measured).into_iter().filter(|beyond| beyond.abs() > within) {
                let size_mm = Some(self.extrapolated(axis, measured, beyond));
                let position =
                    CoverageGap { used, measured: Some(measured), beyond, size_mm, ..gap(GapKind::Position) };
                gaps.push(position);
            }
        } else if !self.with_errors.contains(axis) {
            gaps.extend((!stays).then(|| gap(GapKind::NoErrors)));
        } else {
            let tables = self.tables(axis);
            for is_above in [false, true] {
                let ends = tables.iter().map(|&(name, range)| (name, range, self.in_turn(axis, used, range)));
                let outside = ends.filter_map(|(name, range, used)| {
                    let far = beyond(used, range).into_iter().find(|far| (*far > 0.0) == is_above)?;
                    Some((name, range, used, far))
                });
                let farthest = outside.max_by(|one, other| one.3.abs().total_cmp(&other.3.abs()));
                gaps.extend(farthest.map(|(name, range, used, beyond)| CoverageGap {
                    table: Some(name),
                    used,
                    measured: Some(range),
                    beyond,
                    size_mm: Some(self.extrapolated(axis, range, beyond)),
                    ..gap(GapKind::Position)
                }));
            }
            // The positions of one table are not the range in which other errors of the axis were measured.
            let is_in_tables = |error: &super::MotionError| {
                error.name.axis() != Some(axis)
                    || matches!(error.function, EntryFunction::Table(_) | EntryFunction::Grid(_))
            };
            let is_ranged = !tables.is_empty() && self.errors.motion.iter().all(is_in_tables);
            if !is_ranged && !stays && self.machine.measured.is_some() {
                gaps.push(gap(GapKind::RangeNotStated));
            }
        }
    }

    /// Returns the used range of a modulo axis in the turn of a measured one.
    fn in_turn(&self, axis: Axis, used: [f64; 2], measured: [f64; 2]) -> [f64; 2] {
        const TURN: f64 = std::f64::consts::TAU;
        if !self.machine.axis(axis).is_some_and(|data| data.modulo) {
            return used;
        }
        if measured[1] - measured[0] >= WHOLE_TURN * TURN {
            return measured;
        }
        if used[1] - used[0] >= TURN {
            return [measured[0], measured[0] + TURN];
        }
        let turns = ((used[0] - measured[0] + ON_LIMIT) / TURN).floor();
        used.map(|end| end - turns * TURN)
    }

    /// Returns the errors whose tables end along an axis, with the positions between which they are known, mm or rad.
    fn tables(&self, axis: Axis) -> Vec<(ErrorName, [f64; 2])> {
        let ends = |positions: &[f64]| match positions {
            [first, .., last] => Some([*first, *last]),
            _ => None,
        };
        let along = |error: &super::MotionError| {
            let range = match &error.function {
                EntryFunction::Table(table) if error.name.axis() == Some(axis) => ends(&table.positions),
                EntryFunction::Grid(grid) if error.name.axis() == Some(axis) => ends(&grid.positions),
                EntryFunction::Grid(grid) if grid.with == axis => ends(&grid.with_positions),
                _ => None,
            };
            range.map(|range| (error.name, range))
        };
        self.errors.motion.iter().filter_map(along).collect()
    }

    /// Returns the part of the error that is extrapolated `beyond` a measured range, mm: the change that the model has there, or the one that it has over the same distance
    /// inside, whichever is larger.
    fn extrapolated(&self, axis: Axis, measured: [f64; 2], beyond: f64) -> f64 {
        let end = if beyond > 0.0 { measured[1] } else { measured[0] };
        let inside = end - beyond.signum() * beyond.abs().min(measured[1] - measured[0]);
        let tool_mm = self.tool_mm();
        let sizes = self.poses.iter().map(|pose| {
            let [inside, end, outside] = [inside, end, end + beyond].map(|position| {
                let mut pose = *pose;
                pose[axis] = position;
                self.model.deviation(&pose, &tool_mm, &State::default()).translation
            });
            (outside - end).norm().max((end - inside).norm())
        });
        sizes.fold(0.0, f64::max)
    }

    /// Pairs of axes that both move, and whose squareness the calibration could not show.
    fn squareness(&self, gaps: &mut Vec<CoverageGap>) {
        for name in self.measured.not_shown.iter().flatten() {
            let named = name.parse().ok().filter(is_squareness);
            let Some((name, axes)) = named.and_then(|name| Some((name, pair_of(name)?))) else {
                continue;
            };
            let moves = |axis: Axis| self.used.axes.get(&axis).is_some_and(|[low, high]| high - low > ON_LIMIT);
            if !axes.into_iter().all(moves) || states_squareness(self.errors, name, axes) {
                continue;
            }
            let Some(axis) = name.axis() else { continue };
            gaps.push(CoverageGap {
                axis: Some(axis),
                squareness: Some(name),
                measured: self.measured.axes.get(&axis).copied(),
                ..CoverageGap::new(GapKind::Squareness, self.used.axes.get(&axis).copied().unwrap_or_default())
            });
        }
    }

    /// Axes that move, and whose positioning or straightness, or whose place if they turn, the calibration could not show. An error that the file states is known
    /// from elsewhere.
    fn components(&self, gaps: &mut Vec<CoverageGap>) {
        let open: Vec<ErrorName> = self.not_shown().filter(|name| !is_squareness(name) && !is_angle(name)).collect();
        let moving = self.moving();
        // The place of the spindle belongs to the first axis that turns it.
        let turns_spindle = |axis: &Axis| axis.is_rotary() && self.machine.topology.tool.contains(axis);
        let of_spindle = moving.iter().map(|(axis, _)| *axis).find(turns_spindle);
        // A spindle that nothing turns displaces its tools by their lengths, whichever axis moves.
        let is_fixed = !self.machine.topology.tool.iter().any(|axis| axis.is_rotary());
        let of_spindle = of_spindle.or_else(|| moving.first().map(|(axis, _)| *axis).filter(|_| is_fixed));
        for (axis, used) in moving {
            let is_own = |name: &&ErrorName| match name.axis() {
                Some(own) => own == axis,
                None => of_spindle == Some(axis),
            };
            let components: Vec<ErrorName> = open.iter().filter(is_own).copied().collect();
            if components.is_empty() {
                continue;
            }
            gaps.push(CoverageGap {
                axis: Some(axis),
                components,
                measured: self.measured.axes.get(&axis).copied(),
                ..CoverageGap::new(GapKind::Component, used)
            });
        }
    }

    /// The errors that no measurement shows and the file does not state. One that it states is known from elsewhere.
    fn not_shown(&self) -> impl Iterator<Item = ErrorName> {
        let names = self.measured.not_shown.iter().flatten().filter_map(|name| name.parse::<ErrorName>().ok());
        names.filter(|name| match name.kind {
            ErrorKind::Motion => !self.errors.motion.iter().any(|error| error.name == *name),
            ErrorKind::Location => !states_place(self.errors, *name),
        })
    }

    /// Axes that move, with their used ranges. A rotary axis in its zero position is where the others were measured.
    fn moving(&self) -> Vec<(Axis, [f64; 2])> {
        let moves = |axis: Axis, [low, high]: [f64; 2]| {
            if axis.is_rotary() { low.abs().max(high.abs()) > ON_LIMIT } else { high - low > ON_LIMIT }
        };
        let all = self.used.axes.iter().map(|(&axis, &used)| (axis, used));
        all.filter(|&(axis, used)| moves(axis, used)).collect()
    }

    fn tools(&self, gaps: &mut Vec<CoverageGap>) {
        let (Some(measured), Some(tools_mm)) = (self.measured.tool_length_mm, self.used.tools_mm) else { return };
        // With one length, an angular error looks like a straightness or a scale: that the file has none says nothing.
        let is_one_length = measured[1] - measured[0] <= WITHIN;
        if !self.has_angles && !is_one_length {
            return;
        }
        let used = tools_mm.map(|tool_mm| tool_mm.norm());
        for beyond in beyond(used, measured).into_iter().filter(|beyond| beyond.abs() > WITHIN) {
            let tool_mm = if beyond > 0.0 { tools_mm[1] } else { tools_mm[0] };
            let end_mm = if beyond > 0.0 { measured[1] } else { measured[0] };
            let direction = tool_mm.try_normalize(ON_LIMIT).unwrap_or(-self.machine.spindle.axis);
            let deviation = |pose: &AxisVector, tool_mm: &Vector| {
                self.model.deviation(pose, tool_mm, &State::default()).translation
            };
            let size = |pose: &AxisVector| (deviation(pose, &tool_mm) - deviation(pose, &(direction * end_mm))).norm();
            gaps.push(CoverageGap {
                measured: Some(measured),
                beyond,
                size_mm: self.has_angles.then(|| self.poses.iter().map(size).fold(0.0, f64::max)),
                ..CoverageGap::new(GapKind::ToolLength, used)
            });
        }
    }

    fn temperatures(&self, gaps: &mut Vec<CoverageGap>) {
        for sensor in self.errors.sensors() {
            let measured = self.measured.temperatures_c.get(sensor).copied();
            let now_c = self.condition.temperature_c(sensor, 0.0);
            let (Some(measured), Some(now_c)) = (measured, now_c) else { continue };
            for beyond in beyond([now_c; 2], measured) {
                let mut inside = [self.condition.clone()];
                change_readings(&mut inside, sensor, &|value| value.clamp(measured[0], measured[1]));
                gaps.push(CoverageGap {
                    sensor: Some(sensor.to_owned()),
                    measured: Some(measured),
                    beyond,
                    size_mm: Some(self.unlike(&inside[0])),
                    ..CoverageGap::new(GapKind::Temperature, [now_c; 2])
                });
            }
        }
    }

    fn load(&self) -> Option<CoverageGap> {
        let measured = self.measured.load_n?;
        if !self.errors.effects().any(Effect::needs_load) {
            return None;
        }
        let now_n: f64 = self.condition.loads().iter().map(|load| load.force_n).sum();
        let beyond = beyond([now_n; 2], measured).into_iter().next()?;
        let end_n = if beyond > 0.0 { measured[1] } else { measured[0] };
        let mut inside = self.condition.clone();
        inside.clear_loads();
        for load in self.condition.loads().iter().filter(|load| load.force_n > 0.0) {
            inside.add_load(Load { force_n: load.force_n * end_n / now_n, ..*load });
        }
        Some(CoverageGap {
            measured: Some(measured),
            beyond,
            size_mm: Some(self.unlike(&inside)),
            ..CoverageGap::new(GapKind::Load, [now_n; 2])
        })
    }

    /// Returns the largest difference of the error in another condition, mm.
    fn unlike(&self, condition: &Condition) -> f64 {
        let other = Model::at(self.machine, self.errors, condition);
        let tool_mm = self.tool_mm();
        let sizes = self.poses.iter().map(|pose| {
            let [one, other] =
                [&self.model, &other].map(|model| model.deviation(pose, &tool_mm, &State::default()).translation);
            (one - other).norm()
        });
        sizes.fold(0.0, f64::max)
    }
}

/// Returns the two linear axes whose angle a squareness describes, in order.
fn pair_of(name: ErrorName) -> Option<[Axis; 2]> {
    let axis = name.axis()?;
    let about = name.direction.index() % 3;
    let other = LINEAR_AXES.into_iter().find(|other| ![about, axis.dimension()].contains(&other.dimension()))?;
    Some(if axis < other { [axis, other] } else { [other, axis] })
}

/// True for an angle of a linear axis that depends on its position.
fn is_angle(name: &ErrorName) -> bool {
    !name.is_location() && name.direction.is_rotation() && name.axis().is_some_and(|axis| !axis.is_rotary())
}

/// True for the rotation of a linear axis as a whole.
fn is_squareness(name: &ErrorName) -> bool {
    name.is_location() && name.direction.is_rotation() && name.axis().is_some_and(|axis| !axis.is_rotary())
}

/// True if an error model states a location error: as such, or as the constant of a motion error of the same axis.
#[must_use]
pub fn states_place(errors: &ErrorModel, name: ErrorName) -> bool {
    errors.location.iter().any(|error| error.name == name)
        || name.axis().is_some_and(|axis| {
            let motion = ErrorName::motion(name.direction, axis);
            errors.motion.iter().any(|error| error.name == motion && coefficient(error, 0) != 0.0)
        })
}

/// True if an error model states the squareness of two axes: as a location error of one of them, or as the constant of a rotation.
#[must_use]
pub fn states_squareness(errors: &ErrorModel, name: ErrorName, axes: [Axis; 2]) -> bool {
    let is_own =
        |error: ErrorName| error.direction == name.direction && error.axis().is_some_and(|axis| axes.contains(&axis));
    errors.location.iter().any(|error| is_own(error.name))
        || errors.motion.iter().any(|error| is_own(error.name) && coefficient(error, 0) != 0.0)
}

/// True if the straightness of one of two axes along the other has a slope, which states their squareness as well.
#[must_use]
pub fn states_slope(errors: &ErrorModel, [one, two]: [Axis; 2]) -> bool {
    errors.motion.iter().any(|error| {
        let along = |axis: Axis, other: Axis| {
            error.name.axis() == Some(axis) && error.name.direction.index() == other.dimension()
        };
        (along(one, two) || along(two, one)) && coefficient(error, 1) != 0.0
    })
}

/// Returns a coefficient of a polynomial; 0 for any other function.
fn coefficient(error: &super::MotionError, degree: usize) -> f64 {
    let EntryFunction::Polynomial(polynomial) = &error.function else { return 0.0 };
    polynomial.coefficients.get(degree).copied().unwrap_or(0.0)
}

/// Returns the distances by which a used range exceeds a measured one: negative below it, positive above it.
fn beyond(used: [f64; 2], measured: [f64; 2]) -> Vec<f64> {
    let far = [used[0] - measured[0], used[1] - measured[1]];
    let is_outside = [far[0] < -ON_LIMIT, far[1] > ON_LIMIT];
    far.into_iter().zip(is_outside).filter(|(_, is)| *is).map(|(far, _)| far).collect()
}

/// Returns the error components of a model, each with the other axis on which it depends. Effects of temperatures and loads are revealed by a warm, loaded
/// machine.
fn names_of(machine: &Machine, errors: &ErrorModel) -> Vec<(ErrorName, Option<Axis>)> {
    let mut names: Vec<(ErrorName, Option<Axis>)> = errors.location.iter().map(|error| (error.name, None)).collect();
    names.extend(errors.motion.iter().map(|error| (error.name, error.function.with())));
    let mut probe = Condition::default();
    for (number, sensor) in errors.sensors().into_iter().enumerate() {
        let reference_c = machine.sensor_references_c.get(sensor).copied().unwrap_or(machine.reference_temperature_c);
        probe.add_reading(sensor, 0.0, reference_c + PROBE_K + number as f64);
    }
    probe.add_load(Load { force_n: PROBE_N, position_mm: Vector::new(1.0, 2.0, 3.0) });
    let others = Accumulator::sum(machine, errors, &probe, |_| true);
    names.extend(others.parts().into_iter().map(|(name, function, _)| (name, function.and_then(EntryFunction::with))));
    names
}

/// Returns the axes on which these errors depend. A squareness concerns both axes of its pair; an offset of a linear axis concerns none.
fn axes_of(machine: &Machine, names: &[(ErrorName, Option<Axis>)]) -> AxisSet {
    let mut axes = AxisSet::EMPTY;
    for (name, with) in names {
        let Some(axis) = name.axis() else { continue };
        let is_offset = name.kind == ErrorKind::Location && !axis.is_rotary() && !name.direction.is_rotation();
        if is_offset {
            continue;
        }
        axes.insert(axis);
        with.iter().for_each(|&with| axes.insert(with));
        let about = name.direction.index() % 3;
        if name.kind == ErrorKind::Location && !axis.is_rotary() && about != axis.dimension() {
            let partners = machine.axes.iter().flatten().map(|data| data.axis);
            partners
                .filter(|other| {
                    !other.is_rotary() && other.dimension() != about && other.dimension() != axis.dimension()
                })
                .for_each(|other| axes.insert(other));
        }
    }
    axes
}
