//! Kinds of measurement: one file each, and their registry ([`Instruments`]), which a caller may extend.
//!
//! A kind reads its columns and predicts its readings: [`Instrument::equations`] receives the tool pose from the error model – the one forward function –
//! and returns reading minus prediction, with the derivatives by the tool pose and by the unknowns of the set-up. To add one from another crate,
//! write a static [`Instrument`], pass it to `ncfix::Registry::with_instrument`, and read the machine file with `ncfix::Machine::from_file_with`.

mod ballbar;
pub(crate) mod direct;
mod displacement;
mod length;
pub(super) mod location;
mod probe;
mod trace;

pub use displacement::NOT_READ;

use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Matrix, Vector};
use ncfix_base::register::{Register, Registered};
use ncfix_machine::machine::Machine;
use ncfix_model::{ErrorName, Model, Pose};

use super::data::{DataSet, Free, Observation};
use super::reading::Reading;

/// An instrument: the columns and equations of one kind of measurement. Defaults exist for unused functions: [`zeros`], [`no_ties`].
#[derive(Debug)]
pub struct Instrument {
    /// Its name in the description: `kind = "ballbar"`. Unique in a registry.
    pub name: &'static str,
    /// Its title.
    pub title: &'static str,
    /// Measured quantity.
    pub measurand: Measurand,
    /// Possible unknowns of its set-ups.
    pub free: &'static [Free],
    /// Reads its values of a row into the observation, mm or rad, and reports missing ones ([`needed`], [`optional`]). Axes, tool, set-up, run and
    /// condition are already read. In a plan ([`DataSet::is_plan`]) every value to be read is 0.
    pub read: fn(&mut DataSet, &Row<'_>, DecimalSign, &mut Observation) -> Result<(), Diagnostic>,
    /// Checks the whole measurement after all rows are read.
    pub check: fn(&DataSet, &Table, &mut Vec<Diagnostic>),
    /// The unknowns of a measurement in addition to those of the machine.
    pub unknowns: fn(&DataSet) -> Vec<Unknown>,
    /// Start values of the unknowns, close enough for linearized equations.
    pub start: fn(&DataSet, &Model) -> Vec<f64>,
    /// The equations of a reading for given unknowns: one for each existing value, in order. Used for prediction, calibration, diagnosis and
    /// simulation.
    pub equations: fn(&DataSet, &Observation, &Seen<'_>, &[f64], &mut Vec<Equation>),
    /// The equations without readings: known distances, in order.
    pub ties: fn(&DataSet, &[f64], &mut Vec<Equation>),
    /// The column with the temperature of its instrument or artifact.
    pub temperature: Option<&'static str>,
    /// The columns of its readings, with the unit of each.
    pub columns: &'static [&'static str],
}

/// Measured quantity of an instrument. Descriptions, plans, figures and causes depend on it, never on the name of the instrument. So a custom instrument
/// is treated like a built-in one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Measurand {
    /// The change of the distance between a ball in the spindle and one on the table. A set-up has the place of that ball and the nominal distance; a row
    /// has one value.
    BallDistance,
    /// The axis positions at which the tip is at a ball of unknown place, which is the target of the row.
    BallPlace,
    /// One error component, which the row names. The index of [`Unknown::Offset`] runs over the components of the first set-up, then
    /// over those of the next.
    Component,
    /// The displacement of the tool from the points of an artifact along F's directions.
    Displacement,
    /// That displacement while the machine moves, at samples of the encoders. A reading has the acceleration of the axes.
    MovingDisplacement,
    /// The change of a length along the line of its set-up, or from the station of it.
    LineLength,
    /// Something else.
    Other,
}

/// The instruments for descriptions: [`Register::default`](ncfix_base::register::Register::default) contains the built-in ones.
pub type Instruments = Register<&'static Instrument>;

impl Registered for &'static Instrument {
    const KIND: &'static str = "instrument";

    fn name(&self) -> &str {
        self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        BUILT_IN.iter().map(|&kind| Box::new(kind)).collect()
    }
}

/// The built-in kinds.
pub(in crate::measure) const BUILT_IN: &[&Instrument] =
    &[&displacement::KIND, &ballbar::KIND, &probe::KIND, &direct::KIND, &length::KIND, &TRACE];

/// Traces, which [`crate::measure::trace`] reads.
pub static TRACE: Instrument = trace::KIND;

/// An unknown of a measurement; lengths in mm, rotations in rad. Numbers are indices of set-ups and targets, directions 0 to 2 are X, Y, Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Unknown {
    /// Shift of the table ball from its described position.
    Centre(usize, usize),
    /// Drift of the readings over the time of a back-and-forth cycle.
    Drift(usize),
    /// Zero of a back-and-forth cycle relative to the first one.
    Level(usize),
    /// Excess of the ball-bar length over the nominal one.
    Length(usize),
    /// Excess of the extension rod length over the nominal one.
    Rod(usize),
    /// Additional length of the ball-bar of a set-up due to a temperature above the described one.
    RodTemperature(usize),
    /// Offset of readings; direction 0 for single values.
    Offset(usize, usize),
    /// Rotation of the artifact.
    Rotation(usize, usize),
    /// Angle between the instrument and the axis whose straightness it measures, rad; counted as [`Unknown::Offset`].
    Slope(usize),
    /// Position of a ball.
    Place(usize, usize),
    /// Correction of the tool vector of the rows, with the spindle at zero.
    Tool(usize, usize),
    /// A length, mm, of a custom instrument: its description, such as `span of the gauge`, and the index of its set-up.
    Own(&'static str, usize),
}

/// Tool pose, nominal and on the error model.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// The error model.
    pub model: &'a Model,
    /// Without errors, in the workpiece frame.
    pub nominal: Pose,
    /// With errors, in the workpiece frame.
    pub actual: Pose,
    /// From the workpiece frame to F's directions.
    pub to_f: Matrix,
}

impl<'a> Seen<'a> {
    /// The prediction of the model for a reading; `tool_mm` is its tool vector.
    #[must_use]
    pub fn new(machine: &'a Machine, model: &'a Model, reading: &Reading, tool_mm: &Vector) -> Seen<'a> {
        let nominal = model.nominal(&reading.position, tool_mm);
        let actual = model.actual(&reading.position, tool_mm, &reading.state);
        let to_f = model.tool_orientation(&reading.position) * nominal.rotation.transpose();
        Seen { machine, model, nominal, actual, to_f }
    }

    /// Displacement of the tip along F's directions, mm.
    #[must_use]
    pub fn displacement(&self) -> Vector {
        self.to_f * (self.actual.translation - self.nominal.translation)
    }

    /// Rotation of the tool about F's directions, rad.
    #[must_use]
    pub fn turn(&self) -> Vector {
        self.to_f * (self.nominal.rotation * self.nominal.turn_to(&self.actual))
    }

    /// A direction of F in the workpiece frame.
    #[must_use]
    pub fn direction(&self, index: usize) -> Vector {
        self.to_f.row(index).transpose()
    }
}

/// Derivatives with respect to components themselves, not by their effects on the tool.
pub type ByComponent = [Option<(ErrorName, f64)>; 3];

/// The share of a position in a reading of a mean line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathDerivative {
    /// The position.
    pub reading: Reading,
    /// Derivative with respect to the tip in the workpiece frame.
    pub by_tip: Vector,
    /// Derivatives with respect to components themselves.
    pub by_component: ByComponent,
}

/// Reading minus prediction, with derivatives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Equation {
    /// mm, or rad.
    pub residual: f64,
    /// Derivative of the prediction with respect to the tip in the workpiece frame.
    pub by_tip: Vector,
    /// Derivative with respect to a rotation of the tool in the workpiece frame.
    pub by_turn: Vector,
    /// Derivatives with respect to location errors themselves, for a reading of one.
    pub by_location: ByComponent,
    /// Derivatives at several readings, for the location of a mean line; then `by_location` is for errors that do not change along it. The others are zero.
    pub by_path: Vec<PathDerivative>,
    /// Derivatives with respect to unknowns, with their indices in [`Instrument::unknowns`].
    pub by_unknown: Vec<(usize, f64)>,
    /// `true` if an angle was read.
    pub is_angle: bool,
}

/// The word of an unknown in descriptions.
#[must_use]
pub fn word(free: Free) -> &'static str {
    match free {
        Free::Centre => "centre",
        Free::Drift => "drift",
        Free::Length => "length",
        Free::Offset => "offset",
        Free::Rod => "rod",
        Free::RodTemperature => "rod_temperature",
        Free::Rotation => "rotation",
        Free::Slope => "slope",
        Free::Tool => "tool",
        Free::Own(word) => word,
    }
}

/// Three unknowns for each of `count` things.
pub fn three(count: usize, unknown: fn(usize, usize) -> Unknown) -> impl Iterator<Item = Unknown> {
    (0..count).flat_map(move |thing| (0..3).map(move |direction| unknown(thing, direction)))
}

/// The value of an unknown by index; 0 if missing.
#[must_use]
pub fn at(values: &[f64], place: usize) -> f64 {
    values.get(place).copied().unwrap_or(0.0)
}

/// Three unknowns from an index.
#[must_use]
pub fn vector_at(values: &[f64], place: usize) -> Vector {
    Vector::new(at(values, place), at(values, place + 1), at(values, place + 2))
}

/// Zero start values, for small unknowns.
#[must_use]
pub fn zeros(data: &DataSet, _: &Model) -> Vec<f64> {
    vec![0.0; (data.kind.unknowns)(data).len()]
}

/// For kinds without known distances.
pub fn no_ties(_: &DataSet, _: &[f64], _: &mut Vec<Equation>) {}

impl Equation {
    /// Derivative with respect to a component itself; not by its effect on the tool.
    #[must_use]
    pub fn by_component(&self, name: ErrorName) -> f64 {
        by_component(&self.by_location, name)
    }
}

/// The factor of a component among location errors.
#[must_use]
pub fn by_component(by_location: &ByComponent, name: ErrorName) -> f64 {
    by_location.iter().flatten().find(|(own, _)| *own == name).map_or(0.0, |(_, factor)| *factor)
}

/// Reports temperatures without expansion, or the reverse.
fn no_expansion(data: &DataSet, table: &Table, findings: &mut Vec<Diagnostic>) {
    let Some(name) = data.kind.temperature else { return };
    let column = table.column(name);
    let setup = |row: &Observation| data.setups.get(row.setup);
    let grows = |row: &Observation| setup(row).is_some_and(|setup| setup.expansion_per_k > 0.0);
    let is_warm = |row: &Observation| row.temperature_c.or_else(|| setup(row)?.temperature_c).is_some();
    let at = table.header_place(column);
    if data.observations.iter().any(|row| row.temperature_c.is_some() && !grows(row)) {
        let help =
            "give rod_expansion_per_K in the set-up (ball-bar) or expansion_per_K in [artefact], or rename the column";
        findings.push(Diagnostic::at(
            Code::DATA_COLUMN,
            at,
            format!("{name} has no effect without an expansion"),
            help,
        ));
    } else if !data.free.contains(&Free::RodTemperature)
        && data.observations.iter().any(|row| grows(row) && !is_warm(row))
    {
        let help = format!("fill the column {name}, give the temperature in the description, or remove the expansion");
        findings.push(Diagnostic::at(Code::DATA_COLUMN, at, "an expansion is given, but no temperature", help));
    }
}

/// A required column.
///
/// # Errors
/// `E0602` if it is missing.
pub fn needed(row: &Row<'_>, name: &str) -> Result<usize, Diagnostic> {
    row.column(name).ok_or_else(|| {
        let message = format!("there is no column {name}");
        let in_mm = name.strip_suffix("_um").map(|stem| format!("{stem}_mm"));
        let help = match in_mm.filter(|in_mm| row.column(in_mm).is_some()) {
            Some(in_mm) => format!("convert the column {in_mm} to µm, and name it {name}"),
            None => format!("add the column {name}"),
        };
        Diagnostic::at(Code::DATA_COLUMN, row.header_place(), message, help)
    })
}

/// A number, or `None` for an empty cell.
///
/// # Errors
/// An error if the cell is not a number.
pub fn optional(row: &Row<'_>, column: Option<usize>, sign: DecimalSign) -> Result<Option<f64>, Diagnostic> {
    match column.filter(|&column| !row.text(column).is_empty()) {
        Some(column) => row.number(column, sign).map(Some),
        None => Ok(None),
    }
}
