//! Contribution of each error source to the position of the tool at one pose.

use serde::Serialize;

use crate::ErrorModel;
use crate::accumulator::Accumulator;
use crate::forward::Model;
use crate::inverse::Solve;
use crate::source::Effect;
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{ActiveTables, Condition, Machine, State};

/// Smallest share of a component that is listed, µm at the tip and µrad.
const LISTED: f64 = 0.05;

/// Errors at a pose: of the tool relative to the workpiece, along the directions of F.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorShares {
    /// Pose: `X_mm`, `C_deg`.
    #[cfg_attr(feature = "schema", schemars(with = "Vec<(String, f64)>"))]
    pub at: Vec<AxisValue>,
    /// From the spindle gauge point to the tip, in F at the zero pose.
    pub tool_mm: [f64; 3],
    /// Sources in their order, each with its components by size.
    pub sources: Vec<Share>,
    /// Sum of all sources.
    pub sum: Deviation,
    /// Correction that would be added to the commands: `X_um`, `C_urad`; empty if none was found.
    #[cfg_attr(feature = "schema", schemars(with = "Vec<(String, f64)>"))]
    pub correction: Vec<AxisValue>,
}

/// Contribution of one source.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Share {
    /// Error source.
    pub source: &'static str,
    /// Description of the source.
    pub title: &'static str,
    /// Deviation due to this source alone.
    pub deviation: Deviation,
    /// Its components, the largest first.
    pub components: Vec<(String, Deviation)>,
}

/// Number of an axis with its unit; in JSON a pair such as `["X_um", 12.5]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "(String, f64)")]
pub struct AxisValue {
    /// Axis.
    pub axis: Axis,
    /// Unit.
    pub unit: AxisUnit,
    /// Number in this unit.
    pub value: f64,
}

/// Unit of a number of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisUnit {
    /// Millimeters.
    Millimeter,
    /// Degrees.
    Degree,
    /// Micrometers.
    Micrometer,
    /// Microradians.
    Microradian,
}

impl AxisUnit {
    /// Returns the unit as in JSON keys: `mm`, `deg`, `um`, `urad`.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            AxisUnit::Millimeter => "mm",
            AxisUnit::Degree => "deg",
            AxisUnit::Micrometer => "um",
            AxisUnit::Microradian => "urad",
        }
    }
}

impl AxisValue {
    /// Converts a position from mm or rad to mm or degrees.
    fn position(axis: Axis, at: f64) -> AxisValue {
        match axis.is_rotary() {
            true => AxisValue { axis, unit: AxisUnit::Degree, value: at.to_degrees() },
            false => AxisValue { axis, unit: AxisUnit::Millimeter, value: at },
        }
    }

    /// Converts a correction from mm or rad to µm or µrad.
    fn correction(axis: Axis, correction: f64) -> AxisValue {
        match axis.is_rotary() {
            true => AxisValue { axis, unit: AxisUnit::Microradian, value: urad_from_rad(correction) },
            false => AxisValue { axis, unit: AxisUnit::Micrometer, value: um_from_mm(correction) },
        }
    }
}

impl From<AxisValue> for (String, f64) {
    fn from(value: AxisValue) -> (String, f64) {
        (format!("{}_{}", value.axis, value.unit.key()), value.value)
    }
}

/// Deviation of the tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Deviation {
    /// Displacement of the tip along X, Y, Z.
    pub position_um: [f64; 3],
    /// Rotation of the tool about X, Y, Z.
    pub rotation_urad: [f64; 3],
}

impl Deviation {
    /// Returns the distance of the tip.
    #[must_use]
    pub fn distance_um(&self) -> f64 {
        Vector::from(self.position_um).norm()
    }

    /// Returns the difference from another deviation.
    fn less(&self, other: &Deviation) -> Deviation {
        let apart = |own: [f64; 3], other: [f64; 3]| [0, 1, 2].map(|index| own[index] - other[index]);
        Deviation {
            position_um: apart(self.position_um, other.position_um),
            rotation_urad: apart(self.rotation_urad, other.rotation_urad),
        }
    }

    fn counts(&self) -> bool {
        self.distance_um() >= LISTED || Vector::from(self.rotation_urad).norm() >= LISTED
    }
}

impl ErrorShares {
    /// Returns the shares of all sources in the model.
    #[must_use]
    pub fn new(
        machine: &Machine,
        errors: &ErrorModel,
        condition: &Condition,
        at: &AxisVector,
        tool_mm: &Vector,
        state: &State,
    ) -> ErrorShares {
        // Active tables of the control have their own row; otherwise every row would include them.
        let bare = Machine { active_tables: ActiveTables::default(), ..machine.clone() };
        let of = |machine: &Machine, wanted: &dyn Fn(&dyn Effect) -> bool| {
            let model = Model::summed(&Accumulator::sum(machine, errors, condition, wanted));
            let found = model.deviation(at, tool_mm, state);
            Deviation {
                position_um: found.translation.map(um_from_mm).into(),
                rotation_urad: found.rotation.map(urad_from_rad).into(),
            }
        };
        let deviation = |wanted: &dyn Fn(&dyn Effect) -> bool| of(&bare, wanted);
        let sum = of(machine, &|_| true);
        let mut sources = Vec::new();
        for source in errors.sources() {
            let is_own = |effect: &dyn Effect| effect.source().name == source.name;
            let mut labels: Vec<String> = errors.effects_of(source.name).map(Effect::label).collect();
            labels.sort_unstable();
            labels.dedup();
            let mut components: Vec<(String, Deviation)> = labels
                .into_iter()
                .map(|label| {
                    let found = deviation(&|effect| is_own(effect) && effect.label() == label);
                    (label, found)
                })
                .filter(|(_, found)| found.counts())
                .collect();
            components.sort_by(|(_, one), (_, other)| other.distance_um().total_cmp(&one.distance_um()));
            sources.push(Share { source: source.name, title: source.title, deviation: deviation(&is_own), components });
        }
        if machine.active_tables.control.is_some() {
            let deviation = sum.less(&deviation(&|_| true));
            let title = "tables in the control";
            sources.push(Share { source: "tables", title, deviation, components: Vec::new() });
        }
        let model = Model::at(machine, errors, condition);
        let own = || AXES.into_iter().filter(|&axis| machine.axis(axis).is_some());
        let solved = model.solve(at, tool_mm, state, at, Solve::Full).ok();
        let correction = solved.map(|command| command - *at);
        ErrorShares {
            at: own().map(|axis| AxisValue::position(axis, at[axis])).collect(),
            tool_mm: (*tool_mm).into(),
            sources,
            sum,
            correction: correction.map_or(Vec::new(), |correction| {
                own().map(|axis| AxisValue::correction(axis, correction[axis])).collect()
            }),
        }
    }
}
