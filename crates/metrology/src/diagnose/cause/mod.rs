//! Causes: one file each, and their registry ([`Causes`]), which a caller can extend.
//!
//! A cause examines a [`Scene`] and proposes [`Candidate`]s: the additional effects on the readings if the cause is present. It states its evidence,
//! the measurement that separates it from similar causes, and its remedy. An accepted candidate extends the model by its [`Term`]; a candidate without
//! a term is only reported.
//!
//! To add a cause from another crate, write a static [`Cause`] with its function, or a type that implements [`Propose`] if it needs its own data.
//! Pass it to `ncfix::Registry::with_cause`, and read the machine file with `ncfix::Machine::from_file_with`. A diagnosis of this machine uses it.

mod backlash;
pub(in crate::diagnose) mod circle;
pub(in crate::diagnose) mod common_scale;
pub(in crate::diagnose) mod cross;
pub(in crate::diagnose) mod drift;
pub(in crate::diagnose) mod earlier;
mod id;
mod load;
pub(in crate::diagnose) mod location;
pub(in crate::diagnose) mod motion;
pub(in crate::diagnose) mod periodic;
pub(in crate::diagnose) mod serpentine;
pub(in crate::diagnose) mod servo;
pub(in crate::diagnose) mod setup;
mod spike;
mod spindle;
mod stand;
pub(in crate::diagnose) mod targets;
pub(in crate::diagnose) mod thermal;
mod threshold;
mod unnamed;
pub(in crate::diagnose) mod vibration;

use std::fmt;
use std::sync::Arc;

use serde::Serialize;

use super::extend::change::Change;
use super::row::SceneRow;
use super::scene::{Scene, Through};
use crate::measure::data::DataSet;
pub use id::CauseId;
use ncfix_base::geometry::Axis;
use ncfix_base::register::{Register, Registered};
use ncfix_model::ParameterName;
use ncfix_model::name::{DIRECTIONS, ErrorKind, ErrorName};
pub(in crate::diagnose) use unnamed::CAUSE as UNNAMED;

/// Kind of an effect, as programs read it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum EffectKind {
    /// An error of the location of an axis.
    Location,
    /// An error of the motion of an axis: scale, straightness, angle.
    Motion,
    /// An error that repeats with a period.
    Periodic,
    /// Backlash of the axis itself.
    Backlash,
    /// Backlash across the axis.
    LateralPlay,
    /// A reversal spike.
    ReversalSpike,
    /// An error of one axis that depends on another one.
    Cross,
    /// Axes that follow with different lags.
    ServoMismatch,
    /// Lag behind the command.
    Following,
    /// Deflection by acceleration.
    Dynamic,
    /// Readings and positions recorded at different times.
    Delay,
    /// Displacement with a temperature.
    ThermalDrift,
    /// Thermal expansion of a scale.
    ThermalExpansion,
    /// An angle between axes that changes with a temperature.
    ThermalSquareness,
    /// Displacement with time.
    Drift,
    /// Displacement with the speed of the spindle.
    SpindleSpeed,
    /// An error that has changed between files.
    Earlier,
    /// Displacement with the weight of the workpiece.
    Load,
    /// An error of the set-up of the instrument.
    Setup,
    /// An error of the probe.
    Probe,
    /// A fault of a temperature sensor.
    Sensor,
    /// Errors of single readings.
    Outlier,
    /// An error of the measured program.
    Program,
    /// An effect without a known cause.
    Unknown,
    /// The effect of a custom cause, with its name: small letters and hyphens, such as `beam-sag`.
    Own(&'static str),
}

/// Remedy for an effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Correctable {
    /// A corrected program removes it.
    Program,
    /// Only a correction with live readings during the run removes it.
    Live,
    /// Reported only.
    #[default]
    No,
}

/// A cause: its name, and the function that proposes its candidates.
#[derive(Debug)]
pub struct Cause {
    /// Its name, unique in a registry.
    pub name: &'static str,
    /// Its effect.
    pub effect: EffectKind,
    /// Its origin: a sentence for people.
    pub made_by: &'static str,
    /// Its evidence: a sentence for people.
    pub shown_by: &'static str,
    /// The measurement that separates it from similar causes.
    pub separate_by: &'static str,
    /// Its remedy.
    pub correctable: Correctable,
    /// Proposes its candidates; see [`Propose::propose`].
    pub propose: fn(&Scene<'_>, &mut Vec<Candidate>),
}

/// Proposes the effects of a cause on readings. `&'static Cause` uses its function; implement this trait for a cause that needs its own data.
pub trait Propose: Send + Sync {
    /// The cause: the same static at every call, and that of its candidates.
    fn cause(&self) -> &'static Cause;

    /// Pushes a candidate for each form that the cause can have: each axis, length, sensor. It is called once per diagnosis, before the search. The
    /// search finds the amount of each column. It accepts a candidate only if its gain is significant for the number of candidates proposed, also in
    /// readings that were not used. Each additional candidate raises the significance that the others must reach, so propose only effects that the measurements can show. If a driver is
    /// missing, propose nothing.
    fn propose(&self, scene: &Scene<'_>, out: &mut Vec<Candidate>);
}

impl Propose for &'static Cause {
    fn cause(&self) -> &'static Cause {
        self
    }

    fn propose(&self, scene: &Scene<'_>, out: &mut Vec<Candidate>) {
        (self.propose)(scene, out);
    }
}

impl<P: Propose + 'static> From<P> for Box<dyn Propose> {
    fn from(cause: P) -> Self {
        Box::new(cause)
    }
}

/// The causes that a diagnosis searches for: [`Register::default`](ncfix_base::register::Register::default) contains the built-in ones.
pub type Causes = Register<dyn Propose>;

impl Registered for dyn Propose {
    const KIND: &'static str = "cause";

    fn name(&self) -> &str {
        self.cause().name
    }

    fn built_in() -> Vec<Box<Self>> {
        BUILT_IN.iter().map(|&cause| Box::new(cause) as Box<dyn Propose>).collect()
    }
}

/// Built-in causes.
pub(in crate::diagnose) const BUILT_IN: &[&Cause] = &[
    &location::CAUSE,
    &motion::CAUSE,
    &common_scale::CAUSE,
    &targets::CAUSE,
    &backlash::BACKLASH,
    &backlash::WIND_UP,
    &serpentine::CAUSE,
    &backlash::LATERAL_PLAY,
    &spike::CAUSE,
    &periodic::CAUSE,
    &cross::CAUSE,
    &threshold::CAUSE,
    &servo::MISMATCH,
    &servo::MISMATCH_AT_USUAL_FEED,
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
    &stand::CAUSE,
    &setup::PLACE,
    &setup::TOOL,
    &setup::SCALE,
    &earlier::CAUSE,
    &setup::PROBE,
    &drift::CAUSE,
    &drift::EVENT,
    &spindle::CAUSE,
    &thermal::DRIFT,
    &thermal::ON,
    &thermal::EXPANSION,
    &thermal::SQUARENESS,
    &unnamed::CAUSE,
];

/// Weight of a row for a driver: the factor of a deviation. Keep it near 1, so that amounts are well determined.
#[derive(Clone)]
pub struct Weight(Arc<dyn Fn(&SceneRow) -> f64 + Send + Sync>);

impl Weight {
    /// By a function of the row.
    pub fn new(of: impl Fn(&SceneRow) -> f64 + Send + Sync + 'static) -> Weight {
        Weight(Arc::new(of))
    }

    /// By the number in a column of the tables; 0 in rows without one.
    pub fn of_column(values: Values, of: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Weight {
        Weight::new(move |row| values.get(row.set).and_then(|own| own.get(row.number)).map_or(0.0, |value| of(*value)))
    }

    /// Key, equal for weights that are clones of each other.
    pub(in crate::diagnose) fn key(&self) -> usize {
        Arc::as_ptr(&self.0).cast::<()>() as usize
    }

    /// Its value; 0 if it is not finite, because such a row is no evidence.
    #[must_use]
    pub fn of(&self, row: &SceneRow) -> f64 {
        let value = (self.0)(row);
        if value.is_finite() { value } else { 0.0 }
    }
}

impl fmt::Debug for Weight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Weight")
    }
}

/// Extension of the model by a candidate.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// By parameters, one for each column.
    Parameters(Vec<ParameterName>),
    /// By a function of the amounts: entries of a custom error source.
    File(FileTerm),
    /// None: it is not an error of the machine, or has no entry in the machine file.
    None,
}

/// Makes changes of the machine file from the amounts of the columns of a candidate, mm or rad per unit of their weights. If they cannot be written, it
/// gives the reason, in a sentence without a full stop.
#[derive(Clone)]
pub struct FileTerm(Arc<MakesChanges>);

/// From amounts to changes, or the reason for none.
type MakesChanges = dyn Fn(&[f64]) -> Result<Vec<Change>, String> + Send + Sync;

impl FileTerm {
    /// The changes for these amounts.
    ///
    /// # Errors
    /// The reason if no change is possible.
    pub fn changes(&self, amounts: &[f64]) -> Result<Vec<Change>, String> {
        (self.0)(amounts)
    }
}

impl PartialEq for FileTerm {
    /// Clones of each other are equal.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for FileTerm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("FileTerm")
    }
}

/// A candidate: the additional effect on the readings.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Its cause.
    pub cause: &'static Cause,
    /// ISO 230-1 name if it has one, else axes or a direction: `EYY`, `XY`, `Z`.
    pub parameter: String,
    /// Its drivers, by columns of the table: `X`, `X_dir`, `T_nose_C`, `t_s`.
    pub drivers: Vec<String>,
    /// A number that was searched with it: a period, a length, a time constant, with its unit.
    pub constant: Option<(f64, &'static str)>,
    /// The temperature sensor, if it has one.
    pub sensor: Option<String>,
    /// Its columns, each a sum of parts. The search determines the amount of each column.
    pub columns: Vec<Vec<(Through, Weight)>>,
    /// Positions of the columns, in the order of `drivers`: the amounts are then the values of a shape at these positions. Empty if the columns have
    /// another meaning.
    pub points: Vec<Vec<f64>>,
    /// Values of the drivers of such a shape, by row of the scene. A position in the workpiece is not the position of an axis.
    pub along: Vec<(String, Arc<Vec<f64>>)>,
    /// The axis and the two positions, mm, between which the effect begins, if it acts only on one side of them.
    pub threshold: Option<(Axis, [f64; 2])>,
    /// Its extension of the model.
    pub term: Term,
}

impl Candidate {
    /// A candidate with one column.
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
            threshold: None,
            term: Term::None,
        }
    }

    /// The column whose amount a parameter of the machine file takes; `None` if it takes none.
    #[must_use]
    pub fn place_of(&self, name: &ParameterName) -> Option<usize> {
        match &self.term {
            Term::Parameters(names) => names.iter().position(|own| own == name),
            _ => None,
        }
    }

    /// Its identity in explanations: its effect and parameter, which its variants share.
    #[must_use]
    pub fn id(&self) -> CauseId {
        CauseId::Effect(self.cause.effect, self.parameter.clone())
    }

    /// Its effect and parameter as text, as `location EC0X`.
    #[must_use]
    pub fn title(&self) -> String {
        self.id().to_string()
    }

    /// Adds its drivers.
    #[must_use]
    pub fn driven_by(mut self, drivers: &[&dyn fmt::Display]) -> Candidate {
        self.drivers = drivers.iter().map(ToString::to_string).collect();
        self
    }

    /// Plausibility rank: among equally good candidates, the one with the lowest rank is named.
    #[must_use]
    pub fn plausibility_rank(&self) -> u32 {
        let of_effect = match self.cause.effect {
            EffectKind::Location => 0,
            EffectKind::Backlash => 2,
            EffectKind::ServoMismatch => 4,
            // A caller who adds a cause has a reason to search for it.
            EffectKind::Own(_) => 6,
            EffectKind::Motion => 10,
            EffectKind::LateralPlay => 12,
            EffectKind::Periodic => 14,
            EffectKind::Load => 15,
            EffectKind::ThermalDrift => 15,
            EffectKind::ThermalExpansion => 16,
            EffectKind::ThermalSquareness => 18,
            EffectKind::ReversalSpike => 20,
            EffectKind::Following => 22,
            EffectKind::SpindleSpeed => 23,
            EffectKind::Drift => 24,
            EffectKind::Dynamic => 26,
            EffectKind::Delay => 28,
            EffectKind::Earlier => 29,
            EffectKind::Setup | EffectKind::Probe | EffectKind::Sensor | EffectKind::Outlier | EffectKind::Program => {
                30
            }
            EffectKind::Cross => 40,
            EffectKind::Unknown => 50,
        };
        let component = match self.columns.first().and_then(|parts| parts.first()) {
            Some((Through::Component(name), _)) => Some(*name),
            _ => None,
        };
        // An angle seen at one lever arm only looks like a displacement.
        let is_angle = component.is_some_and(|name| name.kind == ErrorKind::Motion && name.direction.is_rotation());
        let degree = u32::try_from(self.columns.len()).unwrap_or(u32::MAX);
        let rank = component.map_or(0, location::rank);
        // An offset of a linear axis is the zero of its scale.
        let is_zero = component.is_some_and(|name| {
            name.kind == ErrorKind::Location
                && !name.direction.is_rotation()
                && name.axis().is_some_and(|axis| !axis.is_rotary())
        });
        10 * (of_effect + if is_angle { 30 } else { 0 } + if is_zero { 3 } else { rank + u32::from(rank > 0) })
            + degree.min(9)
    }

    /// Sets its parameters of the error model, one for each column.
    #[must_use]
    pub fn extends(mut self, parameters: &[ParameterName]) -> Candidate {
        self.term = Term::Parameters(parameters.to_vec());
        self
    }

    /// Sets the function that converts the amounts of its columns, mm or rad per unit of their weights, into changes of the machine file.
    #[must_use]
    pub fn written(
        mut self,
        changes: impl Fn(&[f64]) -> Result<Vec<Change>, String> + Send + Sync + 'static,
    ) -> Candidate {
        self.term = Term::File(FileTerm(Arc::new(changes)));
        self
    }
}

impl fmt::Display for EffectKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            EffectKind::Location => "location",
            EffectKind::Motion => "motion",
            EffectKind::Periodic => "periodic",
            EffectKind::Backlash => "backlash",
            EffectKind::LateralPlay => "lateral-play",
            EffectKind::ReversalSpike => "reversal-spike",
            EffectKind::Cross => "cross",
            EffectKind::ServoMismatch => "servo-mismatch",
            EffectKind::Following => "following",
            EffectKind::Dynamic => "dynamic",
            EffectKind::Delay => "delay",
            EffectKind::ThermalDrift => "thermal-drift",
            EffectKind::ThermalExpansion => "thermal-expansion",
            EffectKind::ThermalSquareness => "thermal-squareness",
            EffectKind::Drift => "drift",
            EffectKind::SpindleSpeed => "spindle-speed",
            EffectKind::Earlier => "earlier",
            EffectKind::Load => "load",
            EffectKind::Setup => "setup",
            EffectKind::Probe => "probe",
            EffectKind::Sensor => "sensor",
            EffectKind::Outlier => "outlier",
            EffectKind::Program => "program",
            EffectKind::Unknown => "unknown",
            EffectKind::Own(name) => name,
        })
    }
}

/// The axes of a scene.
pub fn axes(scene: &Scene<'_>) -> impl Iterator<Item = Axis> {
    scene.machine.axes.iter().flatten().map(|data| data.axis)
}

/// The linear axes of a scene.
pub fn linear(scene: &Scene<'_>) -> impl Iterator<Item = Axis> {
    axes(scene).filter(|axis| !axis.is_rotary())
}

/// Smallest and largest position of an axis in the rows, mm or rad; `None` if it did not move.
#[must_use]
pub fn range(scene: &Scene<'_>, axis: Axis) -> Option<[f64; 2]> {
    spread(scene.rows.iter().map(|row| row.position[axis])).filter(|[low, high]| high - low > 1e-3)
}

/// Times of the first and the last reading, s; `None` if they are unknown or equal.
#[must_use]
pub fn times(scene: &Scene<'_>) -> Option<[f64; 2]> {
    spread(scene.rows.iter().filter_map(|row| row.time_s)).filter(|[start, end]| end > start)
}

fn spread(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.filter(|value| value.is_finite());
    finite.fold(None, |known: Option<[f64; 2]>, value| {
        let [low, high] = known.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}

/// For a displacement with the spindle speed: the shortest and the longest time constant to test, s, and the candidates as functions of the time
/// constant, one for each time at which the speed may change between two readings. `None` for another cause.
pub(in crate::diagnose) fn with_spindle_speed<'a>(
    scene: &'a Scene<'_>,
    one: &'a Candidate,
) -> Option<([f64; 2], Vec<WithLag<'a>>)> {
    if one.cause.effect != EffectKind::SpindleSpeed {
        return None;
    }
    let (lag_s, _) = one.constant?;
    let with = |change: f64| -> WithLag<'a> { Box::new(move |lag_s| spindle::with_lag(scene, one, lag_s, change)) };
    Some((spindle::around(lag_s), spindle::CHANGES.map(with).into()))
}

/// A candidate as a function of its time constant, s.
pub(in crate::diagnose) type WithLag<'a> = Box<dyn Fn(f64) -> Option<Candidate> + 'a>;

/// Letter of a direction of F.
fn tip(direction: usize) -> &'static str {
    ["X", "Y", "Z"].get(direction).copied().unwrap_or("Z")
}

/// Values by measurement and row.
pub type Values = Arc<Vec<Vec<f64>>>;

/// Values of a column of numbers by measurement and row, numbered as in [`SceneRow`]; `None` if no measurement has it.
#[must_use]
pub fn column(sets: &[DataSet], name: &str) -> Option<Values> {
    let values: Vec<Vec<f64>> = sets
        .iter()
        .map(|set| set.drivers.iter().find(|driver| driver.name == name).map_or(Vec::new(), |one| one.values.clone()))
        .collect();
    values.iter().any(|values| !values.is_empty()).then(|| Arc::new(values))
}

/// Sense of the motion of a body for a positive command of its axis. Errors are those of the moving body, and a table moves against its coordinate.
pub(in crate::diagnose) fn body_sense(scene: &Scene<'_>, axis: Axis) -> f64 {
    let data = scene.machine.axes.iter().flatten().find(|data| data.axis == axis);
    let along = data.and_then(|data| data.direction.get(axis.dimension()).copied()).unwrap_or(1.0);
    if along < 0.0 { -1.0 } else { 1.0 }
}

/// Error of an axis along itself, or about itself if it is rotary.
#[must_use]
pub fn own(axis: Axis) -> ErrorName {
    ErrorName::motion(DIRECTIONS[axis.dimension() + if axis.is_rotary() { 3 } else { 0 }], axis)
}

#[cfg(test)]
mod tests {
    use super::BUILT_IN;

    #[test]
    fn no_cause_is_without_words() {
        for cause in BUILT_IN {
            let words = [cause.name, cause.made_by, cause.shown_by, cause.separate_by];
            assert!(words.iter().all(|text| !text.is_empty()), "{}", cause.name);
            let twins = BUILT_IN.iter().filter(|other| other.name == cause.name).count();
            assert_eq!(twins, 1, "{}", cause.name);
        }
    }
}
