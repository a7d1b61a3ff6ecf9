//! Kinds of measurement: one file each, and the register of them ([`Instruments`]), which a caller extends.
//!
//! A kind reads its columns and says, for a reading, what it should be: [`Kind::equations`] is given the tool as the error model has it – the one
//! forward function – and gives what was read less what is predicted, with the derivatives by the pose of the tool and by the unknowns of the
//! set-up. To add one from another crate, write a static [`Kind`], give it to [`Instruments::with`](ncfix_base::register::Register::with) and read the measurement with
//! [`data::load_with`](super::data::load_with).

mod ballbar;
mod direct;
mod displacement;
mod probe;
mod trace;

use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Matrix, Vector};
use ncfix_base::register::{Register, Registered};
use ncfix_machine::machine::Machine;
use ncfix_model::{Model, Pose};

use super::data::{DataSet, Free, Observation};
use super::reading::Reading;

/// A kind of measurement. Functions that have nothing to do are there for them: [`zeros`], [`no_ties`].
#[derive(Debug)]
pub struct Kind {
    /// As the description names it: `kind = "ballbar"`. No other kind of a register has it.
    pub name: &'static str,
    /// What it is.
    pub title: &'static str,
    /// What its readings are of.
    pub measurand: Measurand,
    /// What may be unknown of its set-ups.
    pub free: &'static [Free],
    /// Reads what it needs of a row into the values of the observation, mm or rad, and names what is missing ([`needed`], [`optional`]). Axes, tool, set-up, run
    /// and condition are read already. Of a plan ([`DataSet::is_plan`]) every value that will be read is 0.
    pub read: fn(&mut DataSet, &Row<'_>, DecimalSign, &mut Observation) -> Result<(), Diagnostic>,
    /// Looks at the whole, once all rows are read.
    pub check: fn(&DataSet, &Table, &mut Vec<Diagnostic>),
    /// The unknowns of a measurement, beside those of the machine.
    pub unknowns: fn(&DataSet) -> Vec<Unknown>,
    /// From what the unknowns are found: near enough for the equations to be straight there.
    pub start: fn(&DataSet, &Model) -> Vec<f64>,
    /// The equations of a reading, with the values of the unknowns: one for each value that is there, in their order. It predicts, calibrates, diagnoses and
    /// simulates.
    pub equations: fn(&DataSet, &Observation, &Seen<'_>, &[f64], &mut Vec<Equation>),
    /// The equations that belong to no reading: known distances, in their order.
    pub ties: fn(&DataSet, &[f64], &mut Vec<Equation>),
    /// The column with the temperature of its instrument or artefact.
    pub temperature: Option<&'static str>,
    /// The columns of its readings, with the unit of each.
    pub columns: &'static [&'static str],
}

/// What the readings of a kind of measurement are of. Descriptions, plans, figures and causes decide by it, never by the name of the kind: one of a
/// caller that says what it measures is treated like those that are built in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Measurand {
    /// The change of the distance between a ball in the spindle and one on the table. A set-up has the place of that ball and the nominal distance; a row
    /// has one value.
    BallDistance,
    /// The axis positions at which the tip is at a ball of unknown place, which is the target of the row.
    BallPlace,
    /// One error component, which the row names. Numbers of [`Unknown::Offset`] count set-ups and, within each, the components.
    Component,
    /// The displacement of the tool from the points of an artefact along F's directions.
    Displacement,
    /// That displacement while the machine moves, at samples of the encoders. A reading has the acceleration of the axes.
    MovingDisplacement,
    /// Something else.
    Other,
}

/// The kinds of measurement that a description may name: [`Register::default`](ncfix_base::register::Register::default) are those that are built in.
pub type Instruments = Register<&'static Kind>;

impl Registered for &'static Kind {
    const KIND: &'static str = "kind of measurement";

    fn name(&self) -> &str {
        self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        BUILT_IN.iter().map(|&kind| Box::new(kind)).collect()
    }
}

/// Those that are built in.
pub(in crate::measure) const BUILT_IN: &[&Kind] =
    &[&displacement::KIND, &ballbar::KIND, &probe::KIND, &direct::KIND, &TRACE];

/// Traces, which [`crate::measure::trace`] reads.
pub static TRACE: Kind = trace::KIND;

/// An unknown of a measurement; lengths in mm, rotations in rad. Numbers are those of set-ups and targets, directions 0 to 2 are X, Y, Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Unknown {
    /// Shift of the table ball from where the description has it.
    Centre(usize, usize),
    /// Drift of the readings over the time of a back-and-forth cycle.
    Drift(usize),
    /// Zero of a back-and-forth cycle against that of the first one.
    Level(usize),
    /// Length of the ball-bar beyond the nominal one.
    Length(usize),
    /// Length of an extension rod beyond the nominal one.
    Rod(usize),
    /// What the ball-bar of a set-up is longer because it is warmer than described.
    RodTemperature(usize),
    /// Shift of readings; direction 0 where there is one value.
    Offset(usize, usize),
    /// Rotation of the artefact.
    Rotation(usize, usize),
    /// Place of a ball.
    Place(usize, usize),
    /// The tool vector beyond that of the rows, with the spindle at zero.
    Tool(usize, usize),
    /// A length, mm, of a kind of measurement that a caller brings: what it is, as `span of the gauge`, and the number of its set-up.
    Own(&'static str, usize),
}

/// Where the tool is, nominally and on the error model.
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
    /// What the model says of a reading; `tool_mm` is its tool vector.
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

    /// One direction of F in the workpiece frame.
    #[must_use]
    pub fn direction(&self, index: usize) -> Vector {
        self.to_f.row(index).transpose()
    }
}

/// What was read less what is predicted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Equation {
    /// mm, or rad.
    pub residual: f64,
    /// Derivative of the prediction by the tip in the workpiece frame.
    pub by_tip: Vector,
    /// Derivative by a rotation of the tool in the workpiece frame.
    pub by_turn: Vector,
    /// Derivatives by unknowns, with their places in [`Kind::unknowns`].
    pub by_unknown: Vec<(usize, f64)>,
    /// Whether an angle was read.
    pub is_angle: bool,
}

/// The word of what may be unknown.
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
        Free::Tool => "tool",
        Free::Own(word) => word,
    }
}

/// Three unknowns for each of `count` things.
pub fn three(count: usize, unknown: fn(usize, usize) -> Unknown) -> impl Iterator<Item = Unknown> {
    (0..count).flat_map(move |thing| (0..3).map(move |direction| unknown(thing, direction)))
}

/// The value of an unknown by its place; 0 where there is none.
#[must_use]
pub fn at(values: &[f64], place: usize) -> f64 {
    values.get(place).copied().unwrap_or(0.0)
}

/// Three unknowns from a place on.
#[must_use]
pub fn vector_at(values: &[f64], place: usize) -> Vector {
    Vector::new(at(values, place), at(values, place + 1), at(values, place + 2))
}

/// Unknowns that are small.
#[must_use]
pub fn zeros(data: &DataSet, _: &Model) -> Vec<f64> {
    vec![0.0; (data.kind.unknowns)(data).len()]
}

/// For kinds that know no distances.
pub fn no_ties(_: &DataSet, _: &[f64], _: &mut Vec<Equation>) {}

/// Says where temperatures are given that an expansion is missing for, or the other way round.
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
        findings.push(Diagnostic::at(Code::DATA_COLUMN, at, format!("{name} says nothing without an expansion"), help));
    } else if !data.free.contains(&Free::RodTemperature)
        && data.observations.iter().any(|row| grows(row) && !is_warm(row))
    {
        let help =
            format!("fill the column {name}, give the temperature in the description, or take the expansion out");
        findings.push(Diagnostic::at(Code::DATA_COLUMN, at, "an expansion is given, but no temperature", help));
    }
}

/// A column that the kind needs.
///
/// # Errors
/// `E0602` where there is none.
pub fn needed(row: &Row<'_>, name: &str) -> Result<usize, Diagnostic> {
    row.column(name).ok_or_else(|| {
        let message = format!("there is no column {name}");
        Diagnostic::at(Code::DATA_COLUMN, row.header_place(), message, format!("add the column {name}"))
    })
}

/// A number, or `None` where the cell is empty.
///
/// # Errors
/// Where the cell is no number.
pub fn optional(row: &Row<'_>, column: Option<usize>, sign: DecimalSign) -> Result<Option<f64>, Diagnostic> {
    match column.filter(|&column| !row.text(column).is_empty()) {
        Some(column) => row.number(column, sign).map(Some),
        None => Ok(None),
    }
}
