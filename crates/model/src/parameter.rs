//! One number of an error model by its name, as fitted by a calibration, with access to its value in the model.
//!
//! | name | number | unit |
//! | --- | --- | --- |
//! | `EC0Y`, `EX0C`, `EX0S` | a location error, of an axis or of the spindle | mm, rad |
//! | `EXX1`, `EAY0` | coefficient of degree 1 of `EXX`, of degree 0 of `EAY` | mm, rad per power of mm, rad |
//! | `EXXb` | coefficient of the direction of the last motion, +1 or −1: **half** of the reversal value | mm, rad |
//! | `EXX2@150` | coefficient of (x − 150)₊², a truncated power that begins at 150 mm (degrees for a rotary axis) | that of its degree |
//!
//! Coefficients and backlash are those of Esmaeili 2021, eq. 19: E = Σ cₖ qᵏ + s·b with the direction s; truncated powers are those of Spaan, eq. 3.3.
//! Entries of the machine file for one component add up, so a parameter is their sum. Reading adds them; writing changes the first entry that can hold the
//! parameter, or adds one. All values are in mm and rad.

use std::fmt;
use std::str::FromStr;

use super::motion::backlash::Backlash;
use super::motion::piecewise::{Knot, Piecewise};
use super::motion::polynomial::Polynomial;
use super::motion::{EntryFunction, MotionError};
use super::name::{ErrorKind, ErrorName, NoSuchComponent};
use super::{ErrorModel, LocationError};
use ncfix_base::geometry::AxisVector;
use ncfix_machine::machine::State;

/// Number of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ComponentTerm {
    /// The only number of a location error.
    Whole,
    /// The coefficient of this degree; names have degrees up to 9.
    Coefficient(u8),
    /// The coefficient of the direction of the last motion.
    Backlash,
    /// The coefficient of a truncated power.
    Knot {
        /// Degree; names have degrees up to 9.
        degree: u8,
        /// Position where it begins, whole mm, or degrees on a rotary axis.
        at: i32,
    },
}

/// Name of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ParameterName {
    /// Error component.
    pub component: ErrorName,
    /// Number of the component; [`ComponentTerm::Whole`] for a location error, another for a motion error.
    pub term: ComponentTerm,
}

impl ParameterName {
    /// Returns the parameter of a location error.
    #[must_use]
    pub fn location(component: ErrorName) -> ParameterName {
        ParameterName { component, term: ComponentTerm::Whole }
    }

    /// Returns the parameter of a coefficient of a motion error.
    #[must_use]
    pub fn coefficient(component: ErrorName, degree: u8) -> ParameterName {
        ParameterName { component, term: ComponentTerm::Coefficient(degree) }
    }

    /// Returns the parameter of the backlash in a motion error.
    #[must_use]
    pub fn backlash(component: ErrorName) -> ParameterName {
        ParameterName { component, term: ComponentTerm::Backlash }
    }

    /// Returns the factor from the parameter to the component at a command: 1, qᵏ, the direction of motion, (q − t)₊ᵏ − (−t)₊ᵏ.
    ///
    /// A truncated power is 0 at the origin of its axis, as the powers are. Otherwise a knot below the origin would displace the origin, by an amount that
    /// only the free zero of a measurement takes up.
    #[must_use]
    pub fn weight(&self, command: &AxisVector, state: &State) -> f64 {
        let Some(axis) = self.component.axis() else { return 1.0 };
        let own = command[axis];
        match self.term {
            ComponentTerm::Whole => 1.0,
            ComponentTerm::Coefficient(degree) => own.powi(i32::from(degree)),
            ComponentTerm::Backlash => f64::from(state.direction(axis)),
            ComponentTerm::Knot { degree, at } => {
                let at = self.knot_at(at);
                truncated(own - at, degree) - truncated(-at, degree)
            }
        }
    }

    /// Returns the power of mm or rad in the denominator of the unit; 0 for a deviation.
    #[must_use]
    pub fn degree(&self) -> u8 {
        match self.term {
            ComponentTerm::Whole | ComponentTerm::Backlash => 0,
            ComponentTerm::Coefficient(degree) | ComponentTerm::Knot { degree, .. } => degree,
        }
    }

    /// Returns the unit: `mm`, `rad`, `mm/mm^2`, `rad/rad`.
    #[must_use]
    pub fn unit(&self) -> String {
        let deviation = if self.component.direction.is_rotation() { "rad" } else { "mm" };
        let position = if self.is_of_rotary_axis() { "rad" } else { "mm" };
        match self.degree() {
            0 => deviation.to_owned(),
            1 => format!("{deviation}/{position}"),
            degree => format!("{deviation}/{position}^{degree}"),
        }
    }

    /// Returns its value in a model, mm or rad per power; 0 if the model does not contain it. The constant of a component is its value at the origin.
    #[must_use]
    pub fn get(&self, errors: &ErrorModel) -> f64 {
        let motion = errors.motion.iter().filter(|error| error.name == self.component).map(|error| &error.function);
        match self.term {
            ComponentTerm::Whole => {
                let own = errors.location.iter().filter(|error| error.name == self.component);
                own.map(|error| error.value).sum()
            }
            ComponentTerm::Coefficient(0) => motion.map(at_origin).sum(),
            ComponentTerm::Coefficient(degree) => {
                motion.filter_map(global_part).map(|part| part.get(usize::from(degree)).copied().unwrap_or(0.0)).sum()
            }
            ComponentTerm::Backlash => motion.map(|function| self.backlash_of(function)).sum(),
            ComponentTerm::Knot { degree, at } => motion
                .filter_map(|function| match function {
                    EntryFunction::Piecewise(piecewise) => Some(&piecewise.knots),
                    _ => None,
                })
                .flatten()
                .filter(|knot| is_at(knot, self.knot_at(at)))
                .map(|knot| knot.coefficients.get(usize::from(degree)).copied().unwrap_or(0.0))
                .sum(),
        }
    }

    /// Changes a model so that [`Self::get`] returns this value, mm or rad per power.
    pub fn set(&self, errors: &mut ErrorModel, value: f64) {
        // The values of the other entries stay.
        let change = value - self.get(errors);
        if self.term == ComponentTerm::Whole {
            match errors.location.iter_mut().find(|error| error.name == self.component) {
                Some(error) => error.value += change,
                None => errors.location.push(LocationError { name: self.component, value }),
            }
            return;
        }
        let own = errors.motion.iter_mut().filter(|error| error.name == self.component);
        let mut functions = own.map(|error| &mut error.function);
        let changed = match self.term {
            ComponentTerm::Whole => None,
            ComponentTerm::Coefficient(degree) => {
                functions.find_map(global_part_mut).map(|part| add(part, degree, change))
            }
            ComponentTerm::Backlash => functions.find(|function| is_constant_backlash(function)).map(|function| {
                *function = backlash(self.backlash_of(function) + change);
            }),
            ComponentTerm::Knot { degree, at } => functions
                .find_map(|function| match function {
                    EntryFunction::Piecewise(piecewise) => Some(piecewise),
                    _ => None,
                })
                .map(|piecewise| self.add_knot(piecewise, (degree, at), change)),
        }
        .is_some();
        if !changed {
            errors.motion.push(MotionError { name: self.component, function: self.function(value) });
        }
    }

    /// Returns a function with only this parameter.
    fn function(&self, value: f64) -> EntryFunction {
        let alone = |degree| {
            let mut coefficients = Vec::new();
            add(&mut coefficients, degree, value);
            coefficients
        };
        match self.term {
            ComponentTerm::Whole => EntryFunction::Polynomial(Polynomial { coefficients: alone(0) }),
            ComponentTerm::Coefficient(degree) => EntryFunction::Polynomial(Polynomial { coefficients: alone(degree) }),
            ComponentTerm::Backlash => backlash(value),
            ComponentTerm::Knot { degree, at } => {
                let mut piecewise = Piecewise::default();
                self.add_knot(&mut piecewise, (degree, at), value);
                EntryFunction::Piecewise(piecewise)
            }
        }
    }

    /// Adds to a coefficient of a knot. The value at the origin stays.
    fn add_knot(&self, piecewise: &mut Piecewise, (degree, at): (u8, i32), change: f64) {
        let at = self.knot_at(at);
        add(knot_at(&mut piecewise.knots, at), degree, change);
        let at_origin = change * truncated(-at, degree);
        if at_origin != 0.0 {
            add(&mut piecewise.coefficients, 0, -at_origin);
        }
    }

    /// Returns the deviation after a positive motion if the function is a backlash, else 0.
    fn backlash_of(&self, function: &EntryFunction) -> f64 {
        match (function, self.component.axis()) {
            (EntryFunction::Backlash(_), Some(axis)) if is_constant_backlash(function) => {
                let mut forward = State::default();
                forward.direction.fill(1);
                function.value(axis, &AxisVector::ZERO, &forward)
            }
            _ => 0.0,
        }
    }

    fn is_of_rotary_axis(&self) -> bool {
        self.component.axis().is_some_and(|axis| axis.is_rotary())
    }

    /// Returns the command at which a truncated power begins, mm or rad.
    fn knot_at(&self, at: i32) -> f64 {
        if self.is_of_rotary_axis() { f64::from(at).to_radians() } else { f64::from(at) }
    }
}

/// Returns x₊ᵏ.
fn truncated(beyond: f64, degree: u8) -> f64 {
    if beyond >= 0.0 { beyond.powi(i32::from(degree)) } else { 0.0 }
}

/// Returns the value of a polynomial, or of one with knots, at the origin of its axis; 0 for other functions.
fn at_origin(function: &EntryFunction) -> f64 {
    match function {
        EntryFunction::Polynomial(polynomial) => polynomial.coefficients.first().copied().unwrap_or(0.0),
        EntryFunction::Piecewise(piecewise) => piecewise.value(0.0),
        _ => 0.0,
    }
}

/// Returns the coefficients of a function that apply everywhere.
fn global_part(function: &EntryFunction) -> Option<&Vec<f64>> {
    match function {
        EntryFunction::Polynomial(polynomial) => Some(&polynomial.coefficients),
        EntryFunction::Piecewise(piecewise) => Some(&piecewise.coefficients),
        _ => None,
    }
}

fn global_part_mut(function: &mut EntryFunction) -> Option<&mut Vec<f64>> {
    match function {
        EntryFunction::Polynomial(polynomial) => Some(&mut polynomial.coefficients),
        EntryFunction::Piecewise(piecewise) => Some(&mut piecewise.coefficients),
        _ => None,
    }
}

/// True for a constant backlash; one that changes along the axis is not a single parameter.
fn is_constant_backlash(function: &EntryFunction) -> bool {
    matches!(function, EntryFunction::Backlash(backlash) if backlash.reversal.positions.len() == 1)
}

/// Returns a backlash from its coefficient of the direction.
fn backlash(half: f64) -> EntryFunction {
    EntryFunction::Backlash(Backlash::constant(2.0 * half))
}

fn add(coefficients: &mut Vec<f64>, degree: u8, change: f64) {
    let index = usize::from(degree);
    if coefficients.len() <= index {
        coefficients.resize(index + 1, 0.0);
    }
    if let Some(coefficient) = coefficients.get_mut(index) {
        *coefficient += change;
    }
}

/// True if a knot of a file, whose degrees have been converted, begins here.
fn is_at(knot: &Knot, at: f64) -> bool {
    (knot.at - at).abs() < 1e-9
}

/// Returns the coefficients of the knot at a command; inserts the knot if it is missing.
fn knot_at(knots: &mut Vec<Knot>, at: f64) -> &mut Vec<f64> {
    let place = knots.iter().position(|knot| is_at(knot, at)).unwrap_or_else(|| {
        let place = knots.partition_point(|knot| knot.at < at);
        knots.insert(place, Knot { at, coefficients: Vec::new() });
        place
    });
    &mut knots[place].coefficients
}

impl fmt::Display for ParameterName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.component.fmt(f)?;
        match self.term {
            ComponentTerm::Whole => Ok(()),
            ComponentTerm::Coefficient(degree) => degree.fmt(f),
            ComponentTerm::Backlash => f.write_str("b"),
            ComponentTerm::Knot { degree, at } => write!(f, "{degree}@{at}"),
        }
    }
}

/// Error for a text that is not a parameter name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoSuchParameter;

impl fmt::Display for NoSuchParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a parameter is a location error (EC0Y), a motion error with a degree (EXX1) or b for backlash (EXXb), or a \
             degree and where a truncated power begins (EXX2@150)",
        )
    }
}

impl std::error::Error for NoSuchParameter {}

impl From<NoSuchComponent> for NoSuchParameter {
    fn from(_: NoSuchComponent) -> Self {
        NoSuchParameter
    }
}

impl FromStr for ParameterName {
    type Err = NoSuchParameter;

    fn from_str(text: &str) -> Result<Self, NoSuchParameter> {
        if let Ok(component) = text.parse::<ErrorName>()
            && component.kind == ErrorKind::Location
        {
            return Ok(ParameterName::location(component));
        }
        let (component, term) = text.split_at_checked(3).ok_or(NoSuchParameter)?;
        let component: ErrorName = component.parse()?;
        let term = match *term.as_bytes() {
            [b'b'] => ComponentTerm::Backlash,
            [degree @ b'0'..=b'9'] => ComponentTerm::Coefficient(degree - b'0'),
            [degree @ b'0'..=b'9', b'@', ..] => {
                let place = &term[2..];
                let at: i32 = place.parse().map_err(|_| NoSuchParameter)?;
                // One name per parameter: neither +5 nor 05.
                if at.to_string() != place {
                    return Err(NoSuchParameter);
                }
                ComponentTerm::Knot { degree: degree - b'0', at }
            }
            _ => return Err(NoSuchParameter),
        };
        Ok(ParameterName { component, term })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::Axis;

    fn name(text: &str) -> ParameterName {
        text.parse().unwrap()
    }

    #[test]
    fn names_read_back_as_written() {
        for text in ["EC0Y", "EX0S", "EXX1", "EAX0", "EBB3", "EXXb", "ECCb", "EZY2@-150", "EAW9", "EXX0@0"] {
            assert_eq!(name(text).to_string(), text);
        }
        for text in
            ["", "EXX", "EXX10", "EXXB", "EC0Y1", "EXS1", "EXXé", "E", "EXX2@", "EXX2@+5", "EXX2@05", "EXX2@1.5"]
        {
            assert_eq!(text.parse::<ParameterName>(), Err(NoSuchParameter), "{text}");
        }
    }

    #[test]
    fn units_follow_deviation_and_axis() {
        let units =
            ["EX0C", "EA0C", "EXX0", "EXX1", "EAX2", "EXB3", "ECC1", "ECCb", "EXX2@50"].map(|text| name(text).unit());
        assert_eq!(units, ["mm", "rad", "mm", "mm/mm", "rad/mm^2", "mm/rad^3", "rad/rad", "rad", "mm/mm^2"]);
    }

    #[test]
    fn a_knot_below_the_origin_leaves_the_origin_where_it_is() {
        let mut errors = ErrorModel::default();
        // 2e-6 (q + 300)² beyond -300 would be 180 µm at the origin.
        let (knot, constant, other) = (name("EZZ2@-300"), name("EZZ0"), name("EZZ1@100"));
        constant.set(&mut errors, 5e-3);
        knot.set(&mut errors, 2e-6);
        other.set(&mut errors, 1e-5);
        let value = |errors: &ErrorModel, q: f64| -> f64 {
            let axis = Axis::Z;
            let mut command = AxisVector::ZERO;
            command[axis] = q;
            errors.motion.iter().map(|one| one.function.value(axis, &command, &State::default())).sum()
        };
        assert!((value(&errors, 0.0) - 5e-3).abs() < 1e-12);
        // -180 µm below the knot; the other knot adds 1e-5 · 100 mm at 200 mm.
        assert!((value(&errors, -400.0) - (5e-3 - 0.18)).abs() < 1e-12);
        assert!((value(&errors, 200.0) - (5e-3 + 2e-6 * (500.0_f64.powi(2) - 300.0_f64.powi(2)) + 1e-3)).abs() < 1e-12);
        // Again, in another order, as a fit does in each step.
        knot.set(&mut errors, 1e-6);
        constant.set(&mut errors, 0.0);
        assert!(value(&errors, 0.0).abs() < 1e-12 && (knot.get(&errors) - 1e-6).abs() < 1e-18);
        assert!((value(&errors, -400.0) + 0.09).abs() < 1e-12, "{}", value(&errors, -400.0));
        // The derivative is the same function.
        let mut command = AxisVector::ZERO;
        for q in [-400.0, -200.0, 0.0, 50.0, 200.0] {
            command[Axis::Z] = q;
            let mut changed = errors.clone();
            knot.set(&mut changed, 2e-6);
            let change = value(&changed, q) - value(&errors, q);
            assert!((change - 1e-6 * knot.weight(&command, &State::default())).abs() < 1e-12, "{q}: {change}");
        }
    }
}
