//! Position-dependent errors: one file per kind of function, and their sum per axis.
//!
//! A function returns one component (mm or rad) from the commanded position of its axis, of another axis ([`cross`], [`grid`]) or from the direction of the last
//! motion ([`backlash`]). A kind is a file here and a line in `BUILT_IN`. A caller adds others to the registry [`MotionKinds`], with its own functions
//! ([`MotionFunction`]).

pub mod backlash;
pub mod cross;
pub mod dynamic;
mod entry;
pub mod grid;
mod intervals;
mod own;
pub mod periodic;
pub mod piecewise;
pub mod polynomial;
pub mod table;

pub use entry::Entry;
pub use own::{MotionFunction, Own, Sampling};

use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_base::register::{Register, Registered};
use ncfix_machine::machine::State;

use super::Features;
use super::name::ErrorName;

/// Position-dependent error: one entry of the machine file.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionError {
    /// Component to which it adds.
    pub name: ErrorName,
    /// Function that gives its value.
    pub function: EntryFunction,
}

/// Function of one kind.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum EntryFunction {
    /// See [`polynomial`].
    Polynomial(polynomial::Polynomial),
    /// See [`table`].
    Table(table::ErrorTable),
    /// See [`piecewise`].
    Piecewise(piecewise::Piecewise),
    /// See [`periodic`].
    Periodic(periodic::Periodic),
    /// See [`backlash`].
    Backlash(backlash::Backlash),
    /// See [`cross`].
    Cross(cross::Cross),
    /// See [`grid`].
    Grid(grid::ErrorGrid),
    /// See [`dynamic`]; it has its own section.
    Dynamic(dynamic::Dynamic),
    /// Of a custom kind; see [`MotionFunction`].
    Own(Own),
}

/// Kind of function as named in the machine file.
///
/// To add one, pass it to `ncfix::Registry::with_motion_kind`, and read the machine file with `ncfix::Machine::from_file_with`.
pub trait MotionKind: Send + Sync {
    /// Returns its name: `kind = "…"` in `[[motion]]` and `[[load]]`.
    fn name(&self) -> &str;

    /// Reads the keys of the kind with the methods of the entry. These know the units that follow from the component and its axis, and report faults. `None`
    /// if the entry is not valid.
    fn read(&self, entry: &mut Entry<'_>) -> Option<EntryFunction>;

    /// Returns the lines of an example entry below its `[[motion]]`, for a machine with the axes X, Y and Z.
    fn example(&self) -> &str;
}

impl<K: MotionKind + 'static> From<K> for Box<dyn MotionKind> {
    fn from(kind: K) -> Self {
        Box::new(kind)
    }
}

/// Kinds of functions that a machine file may have. [`Register::default`](ncfix_base::register::Register::default) contains the built-in ones.
pub type MotionKinds = Register<dyn MotionKind>;

impl Registered for dyn MotionKind {
    const KIND: &'static str = "kind of motion error";

    fn name(&self) -> &str {
        MotionKind::name(self)
    }

    fn built_in() -> Vec<Box<Self>> {
        BUILT_IN.iter().map(|&kind| Box::new(kind) as Box<dyn MotionKind>).collect()
    }
}

/// Built-in kind.
#[derive(Clone, Copy)]
struct BuiltIn {
    name: &'static str,
    read: fn(&mut Entry<'_>) -> Option<EntryFunction>,
    example: &'static str,
}

impl MotionKind for BuiltIn {
    fn name(&self) -> &str {
        self.name
    }

    fn read(&self, entry: &mut Entry<'_>) -> Option<EntryFunction> {
        (self.read)(entry)
    }

    fn example(&self) -> &str {
        self.example
    }
}

/// Built-in kinds.
const BUILT_IN: &[BuiltIn] = &[
    BuiltIn { name: "polynomial", read: polynomial::read, example: polynomial::EXAMPLE },
    BuiltIn { name: "table", read: table::read, example: table::EXAMPLE },
    BuiltIn { name: "piecewise", read: piecewise::read, example: piecewise::EXAMPLE },
    BuiltIn { name: "periodic", read: periodic::read, example: periodic::EXAMPLE },
    BuiltIn { name: "backlash", read: backlash::read, example: backlash::EXAMPLE },
    BuiltIn { name: "cross", read: cross::read, example: cross::EXAMPLE },
    BuiltIn { name: "grid", read: grid::read, example: grid::EXAMPLE },
];

impl EntryFunction {
    /// Returns the value of a function of `axis`, mm or rad.
    #[must_use]
    pub fn value(&self, axis: Axis, command: &AxisVector, state: &State) -> f64 {
        let own = command[axis];
        match self {
            EntryFunction::Polynomial(polynomial) => polynomial.value(own),
            EntryFunction::Table(table) => table.value(own),
            EntryFunction::Piecewise(piecewise) => piecewise.value(own),
            EntryFunction::Periodic(periodic) => periodic.value(own),
            EntryFunction::Backlash(backlash) => backlash.value(own, state.direction(axis)),
            EntryFunction::Cross(cross) => cross.value(own, command[cross.with]),
            EntryFunction::Grid(grid) => grid.value(own, command[grid.with]),
            EntryFunction::Dynamic(dynamic) => dynamic.value(axis, state),
            EntryFunction::Own(own) => own.function().value(axis, command, state),
        }
    }

    /// True if the value is zero everywhere.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        let all_zero = |values: &[f64]| values.iter().all(|&value| value == 0.0);
        match self {
            EntryFunction::Polynomial(polynomial) => all_zero(&polynomial.coefficients),
            EntryFunction::Table(table) => all_zero(&table.values),
            EntryFunction::Piecewise(piecewise) => {
                all_zero(&piecewise.coefficients) && piecewise.knots.iter().all(|knot| all_zero(&knot.coefficients))
            }
            EntryFunction::Periodic(periodic) => periodic.amplitude == 0.0,
            EntryFunction::Backlash(backlash) => all_zero(&backlash.reversal.values),
            EntryFunction::Cross(cross) => all_zero(&cross.coefficients) || all_zero(&cross.with_coefficients),
            EntryFunction::Grid(grid) => grid.values.iter().all(|row| all_zero(row)),
            EntryFunction::Dynamic(dynamic) => all_zero(&[dynamic.by_acceleration, dynamic.by_jerk]),
            EntryFunction::Own(own) => own.is_zero(),
        }
    }

    /// Visits every value to which the function is proportional, with its name.
    pub fn visit_values(&mut self, visit: &mut dyn FnMut(&str, &mut f64)) {
        let mut list = |name: &str, values: &mut [f64]| {
            for (index, value) in values.iter_mut().enumerate() {
                visit(&format!("{name}[{index}]"), value);
            }
        };
        match self {
            EntryFunction::Polynomial(polynomial) => list("coefficients", &mut polynomial.coefficients),
            EntryFunction::Table(table) => list("values", &mut table.values),
            EntryFunction::Piecewise(piecewise) => {
                list("coefficients", &mut piecewise.coefficients);
                for (index, knot) in piecewise.knots.iter_mut().enumerate() {
                    list(&format!("knots[{index}].coefficients"), &mut knot.coefficients);
                }
            }
            EntryFunction::Periodic(periodic) => visit("amplitude", &mut periodic.amplitude),
            EntryFunction::Backlash(backlash) => match backlash.reversal.values.as_mut_slice() {
                [value] => visit("value", value),
                values => list("values", values),
            },
            EntryFunction::Cross(cross) => list("coefficients", &mut cross.coefficients),
            EntryFunction::Dynamic(dynamic) => {
                visit("by_acceleration", &mut dynamic.by_acceleration);
                visit("by_jerk", &mut dynamic.by_jerk);
            }
            EntryFunction::Own(own) => own.function_mut().visit_values(visit),
            EntryFunction::Grid(grid) => {
                for (index, row) in grid.values.iter_mut().enumerate() {
                    list(&format!("values[{index}]"), row);
                }
            }
        }
    }

    /// Returns the other axis on whose position it depends, if any.
    #[must_use]
    pub fn with(&self) -> Option<Axis> {
        match self {
            EntryFunction::Cross(cross) => Some(cross.with),
            EntryFunction::Grid(grid) => Some(grid.with),
            EntryFunction::Own(own) => own.function().with(),
            _ => None,
        }
    }

    /// Returns the function multiplied by a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> EntryFunction {
        let mut scaled = self.clone();
        scaled.visit_values(&mut |_, value| *value *= factor);
        scaled
    }

    /// Notes the required sampling in the features of `axis`, whose function this is, and of other axes on which it depends. `travels` are the lengths of
    /// travel, mm or rad, by slot.
    pub(super) fn note_features(&self, axis: Axis, travels: &[f64], features: &mut [Features]) {
        let travel = travels[axis.slot()];
        let own = &mut features[axis.slot()];
        match self {
            EntryFunction::Polynomial(polynomial) => {
                own.note_degree(polynomial::degree(&polynomial.coefficients), travel)
            }
            EntryFunction::Table(table) => own.note_knots(table.knots().iter().copied()),
            EntryFunction::Piecewise(piecewise) => {
                own.note_degree(piecewise.degree(), travel);
                own.note_knots(piecewise.knots.iter().map(|knot| knot.at));
            }
            EntryFunction::Periodic(periodic) => own.note_length(periodic.period / 2.0),
            EntryFunction::Backlash(backlash) => {
                own.backlash = true;
                own.note_knots(backlash.reversal.knots().iter().copied());
            }
            EntryFunction::Cross(cross) => {
                own.note_degree(polynomial::degree(&cross.coefficients), travel);
                let with = cross.with.slot();
                features[with].note_degree(polynomial::degree(&cross.with_coefficients), travels[with]);
            }
            EntryFunction::Grid(grid) => {
                let [along, across] = grid.knots();
                own.note_knots(along.iter().copied());
                features[grid.with.slot()].note_knots(across.iter().copied());
            }
            // It is constant over all positions.
            EntryFunction::Dynamic(_) => {}
            EntryFunction::Own(function) => {
                let function = function.function();
                for along in [Some(axis), function.with()].into_iter().flatten() {
                    let Sampling { length, knots, has_senses } = function.sampling(along, travels[along.slot()]);
                    let feature = &mut features[along.slot()];
                    feature.note_length(length);
                    feature.note_knots(knots.into_iter());
                    feature.backlash |= has_senses;
                }
            }
        }
    }
}

/// All motion errors of one axis, prepared for evaluation: polynomials of all components are summed and evaluated side by side.
#[derive(Clone, Debug, Default)]
pub(super) struct Functions {
    /// Coefficients of the six components, highest degree first.
    polynomial: Vec<[f64; 6]>,
    others: Vec<(usize, EntryFunction)>,
    /// Functions tabulated for a control.
    intervals: Option<intervals::Intervals>,
}

impl Functions {
    /// Collects the functions of one axis.
    pub(super) fn of(axis: Axis, errors: &[MotionError]) -> Functions {
        let mut functions = Functions::default();
        let own = errors.iter().filter(|error| error.name.axis() == Some(axis) && !error.function.is_zero());
        for error in own {
            let row = error.name.direction.index();
            match &error.function {
                EntryFunction::Polynomial(polynomial) => functions.add_polynomial(row, &polynomial.coefficients),
                EntryFunction::Piecewise(piecewise) => {
                    functions.add_polynomial(row, &piecewise.coefficients);
                    let knots = piecewise.knots.clone();
                    let rest = EntryFunction::Piecewise(piecewise::Piecewise { coefficients: Vec::new(), knots });
                    functions.others.push((row, rest));
                }
                other => functions.others.push((row, other.clone())),
            }
        }
        functions
    }

    fn add_polynomial(&mut self, row: usize, coefficients: &[f64]) {
        while self.polynomial.len() < coefficients.len() {
            self.polynomial.insert(0, [0.0; 6]);
        }
        for (sum, coefficient) in self.polynomial.iter_mut().rev().zip(coefficients) {
            sum[row] += coefficient;
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.polynomial.is_empty() && self.others.is_empty() && self.intervals.is_none()
    }

    /// Returns EX EY EZ (mm) and EA EB EC (rad) of the axis.
    #[inline(always)]
    pub(super) fn evaluate(&self, axis: Axis, command: &AxisVector, state: &State) -> [f64; 6] {
        let own = command[axis];
        let mut components = [0.0; 6];
        for coefficients in &self.polynomial {
            for (component, coefficient) in components.iter_mut().zip(coefficients) {
                *component = *component * own + coefficient;
            }
        }
        // Sums of polynomials stay in registers; a sum at a row known only at run time goes through memory.
        if self.intervals.is_none() && self.others.is_empty() {
            return components;
        }
        self.with_others(components, axis, command, state)
    }

    /// Adds the non-polynomial functions to the components.
    #[inline(never)]
    fn with_others(&self, mut components: [f64; 6], axis: Axis, command: &AxisVector, state: &State) -> [f64; 6] {
        if let Some(intervals) = &self.intervals {
            let on_grid = intervals.value(command[axis], state.direction(axis));
            components.iter_mut().zip(on_grid).for_each(|(sum, value)| *sum += value);
        }
        for (row, function) in &self.others {
            components[*row] += function.value(axis, command, state);
        }
        components
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Direction;

    #[test]
    fn entries_of_one_component_add_up() {
        let exx = ErrorName::motion(Direction::X, Axis::X);
        let eax = ErrorName::motion(Direction::A, Axis::X);
        let polynomial = |coefficients: &[f64]| {
            EntryFunction::Polynomial(polynomial::Polynomial { coefficients: coefficients.to_vec() })
        };
        let errors = [
            MotionError { name: exx, function: polynomial(&[1.0, 2.0]) },
            MotionError { name: exx, function: polynomial(&[0.5, 0.0, 0.25, 0.125]) },
            MotionError { name: eax, function: polynomial(&[0.0, 1.0]) },
            MotionError { name: exx, function: EntryFunction::Backlash(backlash::Backlash::constant(6.0)) },
            MotionError { name: ErrorName::motion(Direction::X, Axis::Y), function: polynomial(&[100.0]) },
        ];
        let functions = Functions::of(Axis::X, &errors);
        let mut command = AxisVector::ZERO;
        command[Axis::X] = 2.0;
        let mut state = State::default();
        state.direction[0] = -1;
        // 1 + 4, 0.5 + 1 + 1, −3; and 2 for the roll.
        assert_eq!(functions.evaluate(Axis::X, &command, &state), [4.5, 0.0, 0.0, 2.0, 0.0, 0.0]);
    }

    #[test]
    fn a_function_of_zeros_is_left_out() {
        let zero = EntryFunction::Polynomial(polynomial::Polynomial { coefficients: vec![0.0, 0.0] });
        let errors = [MotionError { name: ErrorName::motion(Direction::X, Axis::X), function: zero }];
        assert!(Functions::of(Axis::X, &errors).is_empty());
    }
}
