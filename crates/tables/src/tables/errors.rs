//! Error functions for a control that applies them in its own kinematic model (Spaan 1995, Table 6.1; ISO 230-1 sets of other controls).

use ncfix_base::geometry::Axis;
use ncfix_model::ErrorName;

/// Error functions and location errors of a control.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorTables {
    /// Motion errors of each axis.
    pub axes: Vec<AxisErrors>,
    /// Additional location errors of the format, mm or rad.
    pub location: Vec<(ErrorName, f64)>,
}

/// The six motion errors of an axis at points of its travel.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisErrors {
    /// The axis.
    pub axis: Axis,
    /// Positions, strictly increasing, mm or degrees.
    pub positions: Vec<f64>,
    /// EX EY EZ in mm, EA EB EC in rad, at each position, linear between.
    pub values: Vec<[f64; 6]>,
}
