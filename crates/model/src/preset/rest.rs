//! Errors of a model beyond the parameters of a preset.

use std::collections::BTreeSet;

use crate::motion::EntryFunction;
use crate::parameter::{ComponentTerm, ParameterName};
use crate::{ErrorModel, ErrorName, MotionError};

/// Error that is not among given parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rest {
    /// A number with its own name.
    Parameter(ParameterName),
    /// A function of another kind.
    Function(ErrorName, &'static str),
    /// An error source other than geometry, by its title.
    Source(&'static str),
}

/// Returns the nonzero errors of a model that are not among the parameters; each once, sorted.
#[must_use]
pub fn rest(errors: &ErrorModel, parameters: &[ParameterName]) -> Vec<Rest> {
    let location = errors.location.iter().map(|error| Rest::Parameter(ParameterName::location(error.name)));
    let motion = errors.motion.iter().filter(|error| !error.function.is_zero()).flat_map(parts);
    let is_left = |rest: &Rest| match rest {
        Rest::Parameter(parameter) => !parameters.contains(parameter) && parameter.get(errors) != 0.0,
        Rest::Function(..) | Rest::Source(_) => true,
    };
    let sources = errors.effects.iter().map(|effect| Rest::Source(effect.source().title));
    location.chain(motion).chain(sources).filter(is_left).collect::<BTreeSet<_>>().into_iter().collect()
}

/// Returns the parameters in a function, or the function as a whole.
fn parts(error: &MotionError) -> Vec<Rest> {
    let component = error.name;
    let global = |coefficients: &[f64]| -> Vec<Rest> {
        let degrees = (0..=u8::MAX).take(coefficients.len());
        degrees.map(|degree| Rest::Parameter(ParameterName::coefficient(component, degree))).collect()
    };
    let kind = match &error.function {
        EntryFunction::Polynomial(polynomial) => return global(&polynomial.coefficients),
        EntryFunction::Backlash(backlash) if backlash.reversal.positions.len() == 1 => {
            return vec![Rest::Parameter(ParameterName::backlash(component))];
        }
        EntryFunction::Backlash(_) => "backlash along the axis",
        EntryFunction::Piecewise(piecewise) => {
            let mut parts = global(&piecewise.coefficients);
            for knot in &piecewise.knots {
                let is_rotary = component.axis().is_some_and(|axis| axis.is_rotary());
                let at = if is_rotary { knot.at.to_degrees() } else { knot.at };
                // Only knots at whole millimeters or degrees have a name.
                if (at - at.round()).abs() > 1e-9 || at.abs() > f64::from(i32::MAX) {
                    parts.push(Rest::Function(component, "piecewise"));
                    continue;
                }
                let degrees = (0..=u8::MAX).take(knot.coefficients.len());
                let term = |degree| ComponentTerm::Knot { degree, at: at.round() as i32 };
                parts.extend(degrees.map(|degree| Rest::Parameter(ParameterName { component, term: term(degree) })));
            }
            return parts;
        }
        EntryFunction::Table(_) => "table",
        EntryFunction::Periodic(_) => "periodic",
        EntryFunction::Cross(_) => "cross",
        EntryFunction::Grid(_) => "grid",
        EntryFunction::Dynamic(_) => "dynamic",
        EntryFunction::Own(own) => own.function().kind(),
    };
    vec![Rest::Function(component, kind)]
}
