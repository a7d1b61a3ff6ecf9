//! The schemes that fill tables from the error model: one file each, and the register of them ([`Schemes`]), which a caller extends.

mod assembly;
mod auto;
mod exact;
mod fit;
mod functions;
mod matrix;
mod mesh;
mod reversal;
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

pub use auto::{AIM, Tried, choose, choose_with};

/// What tables are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The corrections that they shall give.
    pub target: Target<'a>,
    /// What the rotary axes do, in place of that of the target; `None` for what each scheme is at home in.
    pub orientation: Option<Orientation>,
    /// The errors one by one.
    pub errors: &'a Accumulator<'a>,
    /// Where.
    pub region: &'a Region,
    /// Points of a table.
    pub points: usize,
    /// How much of the error may be left, mm: its root mean square over the region.
    pub tolerance_mm: f64,
    /// What the control does with products.
    pub multiplication: Multiplication,
    /// The format that shall hold them.
    pub format: &'a Format,
    /// How the control names the axes.
    pub wiring: &'a Wiring,
}

/// A way to fill tables.
#[derive(Clone, Copy, Debug)]
pub struct Scheme {
    /// Its name for `--scheme`.
    pub name: &'static str,
    /// What it does, in a few words.
    pub title: &'static str,
    /// What a format must hold for it.
    pub needs: &'static [Holds],
    /// What of the direction of the tool it can hold best.
    pub home: Orientation,
    /// Whether it finds its own nodes: what does not fit does not fit with more points.
    pub finds_nodes: bool,
    /// Fills the tables; a sentence where it cannot.
    pub fill: fn(&Task<'_>) -> Result<Tables, String>,
}

/// The schemes that fill tables: [`Register::default`](ncfix_base::register::Register::default) are those that are built in.
pub type Schemes = Register<&'static Scheme>;

impl Registered for &'static Scheme {
    const KIND: &'static str = "scheme of tables";

    fn name(&self) -> &str {
        self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        SCHEMES.iter().map(Box::new).collect()
    }

    fn conflict(&self, other: &Self) -> Option<String> {
        self.name.eq_ignore_ascii_case(other.name).then(|| "letters of either case are the same in its name".into())
    }
}

/// Those that are built in; [`choose`] picks among them.
pub const SCHEMES: &[Scheme] = &[
    functions::SCHEME,
    mesh::SCHEME,
    matrix::SCHEME,
    sums::OWN,
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
    /// A sentence where the format has no place for the scheme, or the scheme cannot describe the errors.
    pub fn tables(&self, task: &Task<'_>) -> Result<Tables, String> {
        if !self.needs.iter().all(|&need| task.format.can_hold(need)) {
            return Err(format!("{} has no place for the scheme {}", task.format.title, self.name));
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
    /// The same without corrections by rotary axes, for tables that have none.
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

    /// A position as error functions have it: within a turn from 0 for an axis without end.
    fn in_turn(&self, axis: Axis, at: f64) -> f64 {
        let is_endless = self.target.machine.axis(axis).is_some_and(|data| data.modulo);
        if is_endless { at.rem_euclid(std::f64::consts::TAU) } else { at }
    }

    /// The exact corrections at poses.
    fn exact(&self, poses: &[AxisVector]) -> Result<Vec<AxisVector>, String> {
        let state = State::default();
        let corrections = poses.iter().map(|pose| self.target.correction(pose, &state));
        let all: Option<Vec<AxisVector>> = corrections.collect();
        all.ok_or_else(|| "the tip cannot be brought to its place everywhere in the region".to_owned())
    }
}

/// Adds the functions of one axis of others behind those that are there.
fn append(tables: &mut Tables, others: Tables) {
    let first = tables.lookups.len();
    for mut lookup in others.lookups {
        lookup.factor = lookup.factor.map(|factor| factor + first);
        tables.lookups.push(lookup);
    }
}
