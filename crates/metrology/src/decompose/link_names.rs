//! Names of the link errors that a decomposition estimates.

use std::fmt;

use ncfix_base::geometry::Axis;
use ncfix_machine::machine::Machine;
use ncfix_model::ParameterName;

/// Reason why a list does not name link errors of a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoLinks {
    /// A word is not a parameter.
    NoParameter(String),
    /// The machine, of this name, has no such axis.
    NoAxis(String, String, Axis),
    /// A word is repeated.
    Twice(String),
}

impl fmt::Display for NoLinks {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoLinks::NoParameter(word) => write!(out, "--links {word} is not a parameter such as EC0Y or EXX1"),
            NoLinks::NoAxis(word, machine, axis) => {
                write!(out, "--links {word}: the machine {machine} has no axis {axis}")
            }
            NoLinks::Twice(word) => write!(out, "--links names {word} twice"),
        }
    }
}

impl std::error::Error for NoLinks {}

/// The parameters of a comma-separated list.
///
/// # Errors
/// An error if a word is not a parameter of the machine, or is repeated.
pub fn links(list: &str, machine: &Machine) -> Result<Vec<ParameterName>, NoLinks> {
    let mut links = Vec::new();
    for word in list.split(',').map(str::trim) {
        let name: ParameterName = word.parse().map_err(|_| NoLinks::NoParameter(word.to_owned()))?;
        if let Some(axis) = name.component.axis().filter(|&axis| machine.axis(axis).is_none()) {
            return Err(NoLinks::NoAxis(word.to_owned(), machine.name.clone(), axis));
        }
        if links.contains(&name) {
            return Err(NoLinks::Twice(word.to_owned()));
        }
        links.push(name);
    }
    Ok(links)
}
