//! The schemes that fill tables from the error model: one file each, and their registry ([`Schemes`]), which a caller may extend.

mod assembly;
pub mod auto;
mod best_sets;
mod exact;
pub mod fewer;
mod fit;
pub mod functions;
mod matrix;
pub mod mesh;
mod own;
mod reversal;
mod rival;
mod sums;
mod trigonometric;

use super::format::Holds;
use super::region::Region;
use super::target::Target;
use super::{Format, Multiplication, Orientation, Tables, Wiring};
use ncfix_base::geometry::{Axis, AxisVector, LINEAR_AXES};
use ncfix_base::register::{Register, Registered};
use ncfix_machine::machine::State;
use ncfix_model::Accumulator;

pub use reversal::{Reversal, reversals};

/// Share of the tolerance used as the target of the search: other poses have slightly larger errors.
pub const AIM: f64 = 0.95;

/// A request for tables.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The target correction.
    pub target: Target<'a>,
    /// Orientation option that replaces that of the target; `None` for the default of each scheme.
    pub orientation: Option<Orientation>,
    /// The errors one by one.
    pub errors: &'a Accumulator<'a>,
    /// The region.
    pub region: &'a Region,
    /// Number of points of a table.
    pub points: usize,
    /// Permitted residual error, mm: root mean square over the region.
    pub tolerance_mm: f64,
    /// The control's interpretation of products.
    pub multiplication: Multiplication,
    /// The format of the tables.
    pub format: &'a Format,
    /// The control's axis names.
    pub wiring: &'a Wiring,
}

/// A method of filling tables.
#[derive(Clone, Copy, Debug)]
pub struct Scheme {
    /// Its name for `--scheme`.
    pub name: &'static str,
    /// Its description in a few words.
    pub title: &'static str,
    /// Table kinds that it needs in a format.
    pub needs: &'static [Holds],
    /// Its default orientation option.
    pub home: Orientation,
    /// `true` if it finds its own nodes: if the result does not fit, adding points cannot make it fit.
    pub finds_nodes: bool,
    /// Fills the tables; a message if that is impossible.
    pub fill: fn(&Task<'_>) -> Result<Tables, String>,
}

/// The schemes that fill tables: [`Register::default`](ncfix_base::register::Register::default) contains the built-in ones.
pub type Schemes = Register<&'static Scheme>;

impl Registered for &'static Scheme {
    const KIND: &'static str = "table scheme";

    fn name(&self) -> &str {
        self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        SCHEMES.iter().map(Box::new).collect()
    }

    fn conflict(&self, other: &Self) -> Option<String> {
        self.name.eq_ignore_ascii_case(other.name).then(|| "names that differ only in case are the same".into())
    }
}

/// The built-in schemes; [`auto::choose`] selects among them.
pub const SCHEMES: &[Scheme] = &[
    functions::SCHEME,
    mesh::SCHEME,
    matrix::SCHEME,
    own::SCHEME,
    sums::POLYNOMIALS,
    sums::FREE,
    trigonometric::SCHEME,
    exact::SCHEME,
];

/// The scheme of a name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Scheme> {
    SCHEMES.iter().find(|scheme| scheme.name.eq_ignore_ascii_case(name))
}

impl Scheme {
    /// The rounded tables of this scheme for the format of a task.
    ///
    /// # Errors
    /// A message if the format does not support the scheme, or the scheme cannot represent the errors.
    pub fn tables(&self, task: &Task<'_>) -> Result<Tables, String> {
        if !self.needs.iter().all(|&need| task.format.can_hold(need)) {
            return Err(format!("{} cannot hold the scheme {}", task.format.title, self.name));
        }
        let orientation = task.orientation.unwrap_or(self.home);
        let task = &Task { target: Target { orientation, ..task.target }, ..*task };
        let mut tables = (self.fill)(task)?;
        if task.format.can_hold(Holds::Senses) {
            append(&mut tables, reversal::tables(task));
        }
        (task.format.round)(&mut tables);
        Ok(tables)
    }
}

impl<'a> Task<'a> {
    /// The task without corrections by rotary axes, for tables that have none.
    fn without_rotary_corrections(&self) -> Task<'a> {
        Task { target: Target { orientation: Orientation::Off, ..self.target }, ..*self }
    }

    /// The linear axes that correct the position.
    fn linear(&self) -> Vec<Axis> {
        let there = LINEAR_AXES.into_iter().filter(|&axis| self.target.machine.axis(axis).is_some());
        let mut axes: Vec<Axis> = Vec::new();
        for axis in there {
            if axes.iter().all(|one| one.dimension() != axis.dimension()) {
                axes.push(axis);
            }
        }
        axes
    }

    /// A position in the range of error functions: within a turn from 0 for a modulo axis.
    fn in_turn(&self, axis: Axis, at: f64) -> f64 {
        let is_endless = self.target.machine.axis(axis).is_some_and(|data| data.modulo);
        if is_endless { at.rem_euclid(std::f64::consts::TAU) } else { at }
    }

    /// The exact corrections at poses.
    fn exact(&self, poses: &[AxisVector]) -> Result<Vec<AxisVector>, String> {
        let state = State::default();
        let corrections = poses.iter().map(|pose| self.target.correction(pose, &state));
        let all: Option<Vec<AxisVector>> = corrections.collect();
        all.ok_or_else(|| "the tip cannot be brought to its position everywhere in the region".to_owned())
    }
}

/// Appends other functions of one axis after the existing ones.
fn append(tables: &mut Tables, others: Tables) {
    let first = tables.lookups.len();
    for mut lookup in others.lookups {
        lookup.factor = lookup.factor.map(|factor| factor + first);
        tables.lookups.push(lookup);
    }
}
