//! Unknowns of a calibration: parameters of the machine, and unknowns of the measurements.

use std::fmt;

use crate::measure::data::DataSet;
use crate::measure::kind::{Measurand, Unknown};
use ncfix_model::ErrorName;
use ncfix_model::parameter::ParameterName;

use super::effect::{EffectParameter, Parameter};

/// One unknown.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// A parameter of the geometry of the machine.
    Parameter(ParameterName),
    /// A parameter of an effect.
    Effect(EffectParameter),
    /// An unknown of the measurement with this index.
    Unknown(usize, Unknown),
}

impl From<Parameter> for Column {
    fn from(parameter: Parameter) -> Column {
        match parameter {
            Parameter::Geometry(name) => Column::Parameter(name),
            Parameter::Effect(parameter) => Column::Effect(parameter),
        }
    }
}

impl Column {
    /// Its display name.
    #[must_use]
    pub fn name<'a>(&'a self, data: &'a [DataSet]) -> impl fmt::Display + 'a {
        Named { column: self, data }
    }

    /// The parameter of the machine, if it is one.
    #[must_use]
    pub fn parameter(&self) -> Option<Parameter> {
        match self {
            Column::Parameter(name) => Some(Parameter::from(*name)),
            Column::Effect(parameter) => Some(Parameter::from(parameter.clone())),
            Column::Unknown(..) => None,
        }
    }

    /// `true` for a parameter of the machine, `false` for one of a measurement.
    #[must_use]
    pub fn is_of_machine(&self) -> bool {
        !matches!(self, Column::Unknown(..))
    }

    /// `true` for an angle, rad, `false` for a length, mm.
    #[must_use]
    pub fn is_angle(&self, data: &[DataSet]) -> bool {
        let (number, unknown) = match self {
            Column::Parameter(name) => return name.component.direction.is_rotation(),
            Column::Effect(_) => return false,
            Column::Unknown(number, unknown) => (*number, *unknown),
        };
        let Some(set) = data.get(number) else { return false };
        let target = match unknown {
            Unknown::Rotation(..) | Unknown::Slope(_) => return true,
            Unknown::Offset(which, _) if set.kind.measurand == Measurand::Component => which % set.targets.len().max(1),
            Unknown::Drift(which) | Unknown::Level(which) => set.cycles.get(which).map_or(0, |cycle| cycle.target),
            _ => return false,
        };
        set.targets
            .get(target)
            .and_then(|name| name.parse::<ErrorName>().ok())
            .is_some_and(|name| name.direction.is_rotation())
    }

    /// Elongation per 1 K of the ball-bar whose temperature it is, mm.
    #[must_use]
    pub fn mm_per_k(&self, data: &[DataSet]) -> Option<f64> {
        let Column::Unknown(number, Unknown::RodTemperature(which)) = self else { return None };
        let setup = data.get(*number)?.setups.get(*which)?;
        Some(setup.length_mm * setup.expansion_per_k).filter(|&mm_per_k| mm_per_k > 0.0)
    }
}

struct Named<'a> {
    column: &'a Column,
    data: &'a [DataSet],
}

impl fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (number, unknown) = match self.column {
            Column::Parameter(name) => return write!(f, "{name}"),
            Column::Effect(parameter) => return f.write_str(parameter.name()),
            Column::Unknown(number, unknown) => (*number, *unknown),
        };
        let Some(set) = self.data.get(number) else { return Ok(()) };
        let axis = |direction: usize| ["X", "Y", "Z"].get(direction).copied().unwrap_or("?");
        let setup = |which: usize| match set.setups.get(which).map(|setup| setup.label.as_str()) {
            Some("") | None => String::new(),
            Some(label) => format!(" of set-up {label}"),
        };
        let cycle = |which: usize| {
            let Some(cycle) = set.cycles.get(which) else { return String::new() };
            let component = set.targets.get(cycle.target).map_or("", String::as_str);
            format!("{component} in cycle {}{}", cycle.number, setup(cycle.setup))
        };
        match unknown {
            Unknown::Centre(which, direction) => write!(f, "{} of the table ball{}", axis(direction), setup(which)),
            Unknown::Drift(which) => write!(f, "drift of {}", cycle(which)),
            Unknown::Level(which) => write!(f, "zero of {}", cycle(which)),
            Unknown::Rod(which) => {
                let rod = set.rods.get(which).map(String::as_str).filter(|rod| !rod.is_empty());
                let own = set.setups.iter().position(|setup| setup.rod == which).map_or_else(String::new, setup);
                write!(f, "length of the {}", rod.map_or(format!("ball-bar{own}"), |rod| format!("rod {rod}")))
            }
            Unknown::RodTemperature(which) => write!(f, "temperature of the ball-bar{}", setup(which)),
            Unknown::Length(which) => write!(f, "length of the ball-bar{}", setup(which)),
            Unknown::Offset(which, _) if set.kind.measurand == Measurand::Component => {
                let count = set.targets.len().max(1);
                let component = set.targets.get(which % count).map_or("", String::as_str);
                write!(f, "zero of {component}{}", setup(which / count))
            }
            Unknown::Offset(which, direction) => write!(f, "{} of the artifact{}", axis(direction), setup(which)),
            Unknown::Slope(which) => {
                let count = set.targets.len().max(1);
                let component = set.targets.get(which % count).map_or("", String::as_str);
                write!(f, "alignment of {component}{}", setup(which / count))
            }
            Unknown::Rotation(which, direction) => {
                write!(f, "rotation of the artifact about {}{}", axis(direction), setup(which))
            }
            Unknown::Place(target, direction) => {
                let label = set.targets.get(target).map_or("?", String::as_str);
                write!(f, "{} of ball {label}", axis(direction))
            }
            Unknown::Tool(which, direction) => write!(f, "{} of the tool{}", axis(direction), setup(which)),
            Unknown::Own(what, which) => write!(f, "{what}{}", setup(which)),
        }?;
        if self.data.len() > 1 { write!(f, " ({})", set.name) } else { Ok(()) }
    }
}
