//! Tools as a caller states them: a length along the spindle, or a vector.

use std::str::FromStr;

use crate::error::Error;
use ncfix_base::geometry::Vector;
use ncfix_machine::machine::Machine;

/// The vector from the spindle gauge point to the tip of a tool.
///
/// ```
/// use ncfix::prelude::*;
///
/// assert_eq!("120".parse::<ToolVector>()?, ToolVector::Length(120.0));
/// assert_eq!("0, 1,-120".parse::<ToolVector>()?, ToolVector::Tip([0.0, 1.0, -120.0].into()));
/// assert!("1,2".parse::<ToolVector>().is_err());
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ToolVector {
    /// Its length along the spindle, mm.
    Length(f64),
    /// The vector itself, in F at the zero pose, mm.
    Tip(Vector),
}

impl ToolVector {
    /// In F at the zero pose, mm.
    pub(crate) fn vector_mm(self, machine: &Machine) -> Vector {
        match self {
            ToolVector::Length(length_mm) => machine.spindle.axis * -length_mm,
            ToolVector::Tip(tip_mm) => tip_mm,
        }
    }
}

impl FromStr for ToolVector {
    type Err = Error;

    /// `120` or `0,0,-120`.
    fn from_str(text: &str) -> Result<ToolVector, Error> {
        let number = |part: &str| part.trim().parse().ok().filter(|value: &f64| value.is_finite());
        let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
        match numbers.as_deref() {
            Some([length_mm]) => Ok(ToolVector::Length(*length_mm)),
            Some([x, y, z]) => Ok(ToolVector::Tip(Vector::new(*x, *y, *z))),
            _ => Err(Error::usage(format!(
                "'{text}' is neither a length nor a vector; write for example 120 or 0,0,-120"
            ))),
        }
    }
}
