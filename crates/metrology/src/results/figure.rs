//! A figure of a measurement, and a group of them.

use ncfix_base::units::Unit;
use serde::Serialize;

/// A group of figures: of a component, of circles in a plane, of a sphere, of features.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FigureGroup {
    /// Label of the set-up.
    pub setup: String,
    /// Their subject: `EXX`, `XY`, `sphere`, `features`, `level 2`.
    pub of: String,
    /// Their definition.
    pub standard: Standard,
    /// The unit of all.
    pub unit: Unit,
    /// The figures in the order of the standard.
    pub values: Vec<FigureValue>,
    /// Their conditions: runs, radius, feed, start.
    pub conditions: Vec<String>,
    /// Reason why no figures exist; `null` otherwise.
    pub reason: Option<String>,
}

/// Definition of figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Standard {
    /// None: there are no figures.
    #[default]
    #[serde(rename = "")]
    None,
    /// Straightness.
    #[serde(rename = "ISO 230-1")]
    Iso230Part1,
    /// Positioning.
    #[serde(rename = "ISO 230-2")]
    Iso230Part2,
    /// Circles.
    #[serde(rename = "ISO 230-4")]
    Iso230Part4,
    /// A sphere through all points, or features about a workpiece that was moved onto them.
    #[serde(rename = "least squares")]
    LeastSquares,
}

impl Standard {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Standard::None => "",
            Standard::Iso230Part1 => "ISO 230-1",
            Standard::Iso230Part2 => "ISO 230-2",
            Standard::Iso230Part4 => "ISO 230-4",
            Standard::LeastSquares => "least squares",
        }
    }
}

/// A figure.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FigureValue {
    /// `A`, `R+`, `G(ccw)` …
    pub name: &'static str,
    /// Its value.
    pub value: f64,
}
