//! Causes: one file each, registered in [`CAUSES`].
//!
//! A cause looks at a [`Scene`] and proposes [`Candidate`]s: what the readings would have in addition if it were at work. It says what reveals it, with
//! what it is confused and which measurement tells them apart, and what a program can do about it. A candidate that is accepted extends the
//! model by its [`Term`]; one without is reported only.

mod backlash;
pub mod catalogue;
pub(in crate::diagnose) mod circle;
mod cross;
pub(in crate::diagnose) mod drift;
mod load;
mod location;
pub(in crate::diagnose) mod motion;
pub(in crate::diagnose) mod periodic;
mod servo;
mod setup;
mod spike;
pub(in crate::diagnose) mod thermal;
mod unnamed;
pub(in crate::diagnose) mod vibration;

use std::fmt;
use std::sync::Arc;

use super::row::Row;
use super::scene::{Scene, Through};
use crate::measure::data::DataSet;
use ncfix_base::geometry::Axis;
use ncfix_model::ParameterName;
use ncfix_model::name::{DIRECTIONS, ErrorKind, ErrorName};
pub(in crate::diagnose) use unnamed::CAUSE as UNNAMED;

/// What kind of effect it is, as programs read it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    /// An error of the location of an axis.
    Location,
    /// An error of the motion of an axis: scale, straightness, angle.
    Motion,
    /// One that repeats with a pitch.
    Periodic,
    /// Play of the own axis.
    Backlash,
    /// Play across the axis.
    LateralPlay,
    /// A peak behind a turn.
    ReversalSpike,
    /// An error of one axis that depends on another one.
    Cross,
    /// Axes that follow with different lags.
    ServoMismatch,
    /// Lag behind the command.
    Following,
    /// Deflection by acceleration.
    Dynamic,
    /// Readings and positions of different instants.
    Delay,
    /// Displacement with a temperature.
    ThermalDrift,
    /// A scale that grows with a temperature.
    ThermalExpansion,
    /// An angle between axes that changes with a temperature.
    ThermalSquareness,
    /// Displacement with time.
    Drift,
    /// Weight of the workpiece.
    Load,
    /// The set-up of the instrument.
    Setup,
    /// The probe.
    Probe,
    /// A sensor of temperature.
    Sensor,
    /// Single readings.
    Outlier,
    /// The program that was measured.
    Program,
    /// None that has a name.
    Unknown,
}

/// What can be done about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Correctable {
    /// A corrected program takes it away.
    Program,
    /// With live readings while it runs only.
    Live,
    /// Reported only.
    No,
}

/// A cause.
#[derive(Debug)]
pub struct Cause {
    /// Its name.
    pub name: &'static str,
    /// Which effect it makes.
    pub effect: Effect,
    /// What makes it: a sentence for people.
    pub made_by: &'static str,
    /// What shows it.
    pub shown_by: &'static str,
    /// Which measurement tells it from what it is confused with.
    pub separate_by: &'static str,
    /// What can be done about it.
    pub correctable: Correctable,
    /// What it may be here.
    pub propose: fn(&Scene<'_>, &mut Vec<Candidate>),
}

/// All causes.
pub const CAUSES: &[&Cause] = &[
    &location::CAUSE,
    &motion::CAUSE,
    &backlash::BACKLASH,
    &backlash::WIND_UP,
    &backlash::LATERAL_PLAY,
    &spike::CAUSE,
    &periodic::CAUSE,
    &cross::CAUSE,
    &servo::MISMATCH,
    &servo::FOLLOWING,
    &servo::DYNAMIC,
    &servo::DELAY,
    &servo::STICK_SLIP,
    &vibration::CAUSE,
    &circle::CHORDS,
    &circle::OCTANTS,
    &circle::CUP,
    &circle::LOBES,
    &load::GUIDE,
    &load::TABLE,
    &setup::PLACE,
    &setup::TOOL,
    &setup::SCALE,
    &setup::PROBE,
    &drift::CAUSE,
    &drift::EVENT,
    &thermal::DRIFT,
    &thermal::ON,
    &thermal::EXPANSION,
    &thermal::SQUARENESS,
    &unnamed::CAUSE,
];

/// Location errors of linear axes as they are named where several names mean the same.
const USUAL: [&str; 3] = ["EC0Y", "EB0Z", "EA0Z"];

/// What a row has of a driver: the factor of a deviation.
#[derive(Clone)]
pub struct Weight(Arc<dyn Fn(&Row) -> f64 + Send + Sync>);

impl Weight {
    /// By a function of the row.
    pub fn new(of: impl Fn(&Row) -> f64 + Send + Sync + 'static) -> Weight {
        Weight(Arc::new(of))
    }

    /// The same for weights that are clones of each other.
    pub(in crate::diagnose) fn key(&self) -> usize {
        Arc::as_ptr(&self.0).cast::<()>() as usize
    }

    /// Its value; 0 where it is not finite: a row that does not say is no evidence.
    #[must_use]
    pub fn of(&self, row: &Row) -> f64 {
        let value = (self.0)(row);
        if value.is_finite() { value } else { 0.0 }
    }
}

impl fmt::Debug for Weight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Weight")
    }
}

/// How a candidate extends the model.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// By parameters, one for each column.
    Parameters(Vec<ParameterName>),
    /// Not: it is no error of the machine, or none that has an entry in the machine file.
    None,
}

/// What the readings would have in addition.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Its cause.
    pub cause: &'static Cause,
    /// ISO 230-1 name where there is one, else axes or a direction: `EYY`, `XY`, `Z`.
    pub parameter: String,
    /// What it depends on, by columns of the table: `X`, `X_dir`, `T_nose_C`, `t_s`.
    pub drivers: Vec<String>,
    /// A number that goes with it and was searched: a period, a length, a time constant, with its unit.
    pub constant: Option<(f64, &'static str)>,
    /// The sensor of temperature, where it is one.
    pub sensor: Option<String>,
    /// Its columns, each a sum; an amount of each column is found.
    pub columns: Vec<Vec<(Through, Weight)>>,
    /// Where each column stands for, in the order of `drivers`: the amounts are the values of a shape at these points. Empty where columns have a meaning
    /// of their own.
    pub points: Vec<Vec<f64>>,
    /// The drivers of such a shape by row of the scene, where they are searched for: a place in the workpiece is no position of an axis.
    pub along: Vec<(String, Arc<Vec<f64>>)>,
    /// How it extends the model.
    pub term: Term,
}

impl Candidate {
    /// With one column.
    #[must_use]
    pub fn one(cause: &'static Cause, parameter: impl fmt::Display, through: Through, weight: Weight) -> Candidate {
        Candidate {
            cause,
            parameter: parameter.to_string(),
            drivers: Vec::new(),
            constant: None,
            sensor: None,
            columns: vec![vec![(through, weight)]],
            points: Vec::new(),
            along: Vec::new(),
            term: Term::None,
        }
    }

    /// The same with what it depends on.
    #[must_use]
    pub fn driven_by(mut self, drivers: &[&dyn fmt::Display]) -> Candidate {
        self.drivers = drivers.iter().map(ToString::to_string).collect();
        self
    }

    /// How far-fetched it is: of those that explain as much as each other the least is named.
    #[must_use]
    pub fn far_fetched(&self) -> u32 {
        let of_effect = match self.cause.effect {
            Effect::Location => 0,
            Effect::Backlash => 2,
            Effect::ServoMismatch => 4,
            Effect::Motion => 10,
            Effect::LateralPlay => 12,
            Effect::Periodic => 14,
            Effect::Load => 15,
            Effect::ThermalDrift => 15,
            Effect::ThermalExpansion => 16,
            Effect::ThermalSquareness => 18,
            Effect::ReversalSpike => 20,
            Effect::Following => 22,
            Effect::Drift => 24,
            Effect::Dynamic => 26,
            Effect::Delay => 28,
            Effect::Setup | Effect::Probe | Effect::Sensor | Effect::Outlier | Effect::Program => 30,
            Effect::Cross => 40,
            Effect::Unknown => 50,
        };
        let component = match self.columns.first().and_then(|parts| parts.first()) {
            Some((Through::Component(name), _)) => Some(*name),
            _ => None,
        };
        // An angle that is seen at one arm only looks like a displacement.
        let is_angle = component.is_some_and(|name| name.kind == ErrorKind::Motion && name.direction.is_rotation());
        // Squareness is that of the later axis (ISO 230-1: EC0Y, EB0Z, EA0Z).
        let is_usual = component.is_none_or(|name| {
            name.kind == ErrorKind::Motion
                || USUAL.contains(&name.to_string().as_str())
                || name.axis().is_none_or(Axis::is_rotary)
        });
        let degree = u32::try_from(self.columns.len()).unwrap_or(u32::MAX);
        10 * (of_effect + if is_angle { 30 } else { 0 } + if is_usual { 0 } else { 3 }) + degree.min(9)
    }

    /// The same with what it adds to the model.
    #[must_use]
    pub fn extends(mut self, parameters: &[ParameterName]) -> Candidate {
        self.term = Term::Parameters(parameters.to_vec());
        self
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Effect::Location => "location",
            Effect::Motion => "motion",
            Effect::Periodic => "periodic",
            Effect::Backlash => "backlash",
            Effect::LateralPlay => "lateral-play",
            Effect::ReversalSpike => "reversal-spike",
            Effect::Cross => "cross",
            Effect::ServoMismatch => "servo-mismatch",
            Effect::Following => "following",
            Effect::Dynamic => "dynamic",
            Effect::Delay => "delay",
            Effect::ThermalDrift => "thermal-drift",
            Effect::ThermalExpansion => "thermal-expansion",
            Effect::ThermalSquareness => "thermal-squareness",
            Effect::Drift => "drift",
            Effect::Load => "load",
            Effect::Setup => "setup",
            Effect::Probe => "probe",
            Effect::Sensor => "sensor",
            Effect::Outlier => "outlier",
            Effect::Program => "program",
            Effect::Unknown => "unknown",
        })
    }
}

/// The axes of a scene.
pub(in crate::diagnose) fn axes(scene: &Scene<'_>) -> impl Iterator<Item = Axis> {
    scene.machine.axes.iter().flatten().map(|data| data.axis)
}

/// Its linear ones.
fn linear(scene: &Scene<'_>) -> impl Iterator<Item = Axis> {
    axes(scene).filter(|axis| !axis.is_rotary())
}

/// Between where and where an axis was; `None` where it stood.
pub(in crate::diagnose) fn range(scene: &Scene<'_>, axis: Axis) -> Option<[f64; 2]> {
    spread(scene.rows.iter().map(|row| row.position[axis])).filter(|[low, high]| high - low > 1e-3)
}

/// From when to when was measured; `None` where it is not known.
pub(in crate::diagnose) fn times(scene: &Scene<'_>) -> Option<[f64; 2]> {
    spread(scene.rows.iter().filter_map(|row| row.time_s)).filter(|[start, end]| end > start)
}

fn spread(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.filter(|value| value.is_finite());
    finite.fold(None, |known: Option<[f64; 2]>, value| {
        let [low, high] = known.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}

/// The name of a direction of F.
fn tip(direction: usize) -> &'static str {
    ["X", "Y", "Z"].get(direction).copied().unwrap_or("Z")
}

/// Values by measurement and row.
pub(in crate::diagnose) type Values = Arc<Vec<Vec<f64>>>;

/// The values of a column of numbers at the rows of a scene, as [`Row`]s number them; `None` where no measurement has it.
fn column(sets: &[DataSet], name: &str) -> Option<Values> {
    let values: Vec<Vec<f64>> = sets
        .iter()
        .map(|set| set.drivers.iter().find(|driver| driver.name == name).map_or(Vec::new(), |one| one.values.clone()))
        .collect();
    values.iter().any(|values| !values.is_empty()).then(|| Arc::new(values))
}

/// The error of an axis along or about itself.
pub(in crate::diagnose) fn own(axis: Axis) -> ErrorName {
    ErrorName::motion(DIRECTIONS[axis.dimension() + if axis.is_rotary() { 3 } else { 0 }], axis)
}
