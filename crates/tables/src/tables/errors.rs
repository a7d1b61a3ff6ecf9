//! Error functions for a control that puts them through its own kinematic model (Spaan 1995, Table 6.1; ISO 230-1 sets of other controls).

use ncfix_base::geometry::Axis;
use ncfix_model::ErrorName;

/// The errors that a control is told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorTables {
    /// Motion errors of each axis.
    pub axes: Vec<AxisErrors>,
    /// Location errors that the format has beside them, mm or rad.
    pub location: Vec<(ErrorName, f64)>,
}

/// The six motion errors of an axis at points of its travel.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisErrors {
    /// Whose.
    pub axis: Axis,
    /// Positions, strictly increasing, mm or degrees.
    pub positions: Vec<f64>,
    /// EX EY EZ in mm, EA EB EC in rad, at each, linear between.
    pub values: Vec<[f64; 6]>,
}
