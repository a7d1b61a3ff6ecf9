//! What a calibration may find: parameters of the machine, and unknowns of the measurements.

use std::fmt;

use crate::measure::data::DataSet;
use crate::measure::kind::Unknown;
use crate::model::parameter::ParameterName;

use super::effect::{EffectParameter, Parameter};

/// One unknown number.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// A parameter of the geometry of the machine.
    Parameter(ParameterName),
    /// A parameter of an effect.
    Effect(EffectParameter),
    /// An unknown of the measurement of this number.
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
    /// Its name for people.
    #[must_use]
    pub fn name<'a>(&'a self, data: &'a [DataSet]) -> impl fmt::Display + 'a {
        Named { column: self, data }
    }

    /// Whether it is a parameter of the machine, not of a measurement.
    #[must_use]
    pub fn is_of_machine(&self) -> bool {
        !matches!(self, Column::Unknown(..))
    }

    /// Whether it is an angle, rad, rather than a length, mm.
    #[must_use]
    pub fn is_angle(&self) -> bool {
        match self {
            Column::Parameter(name) => name.component.direction.is_rotation(),
            Column::Effect(_) => false,
            Column::Unknown(_, unknown) => matches!(unknown, Unknown::Rotation(..)),
        }
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
        match unknown {
            Unknown::Centre(which, direction) => write!(f, "{} of the table ball{}", axis(direction), setup(which)),
            Unknown::Length(which) => write!(f, "length of the ball-bar{}", setup(which)),
            Unknown::Offset(which, _) if set.kind.name == "direct" => {
                let count = set.targets.len().max(1);
                let component = set.targets.get(which % count).map_or("", String::as_str);
                write!(f, "zero of {component}{}", setup(which / count))
            }
            Unknown::Offset(which, direction) => write!(f, "{} of the artefact{}", axis(direction), setup(which)),
            Unknown::Rotation(which, direction) => {
                write!(f, "rotation of the artefact about {}{}", axis(direction), setup(which))
            }
            Unknown::Place(target, direction) => {
                let label = set.targets.get(target).map_or("?", String::as_str);
                write!(f, "{} of ball {label}", axis(direction))
            }
            Unknown::Tool(which, direction) => write!(f, "{} of the tool{}", axis(direction), setup(which)),
        }?;
        if self.data.len() > 1 { write!(f, " ({})", set.name) } else { Ok(()) }
    }
}
