//! Test plans: where to measure, and the way that a program takes there.
//!
//! A plan is a measurement without readings ([`DataSet`]) and a path in axis commands. One file per kind of plan, registered in [`PLANS`]; pure
//! functions from a machine and [`Wishes`]. [`builder`] keeps path and rows within the travel and on increments of the control, [`table`]
//! writes the pair of files.

mod ballbar;
pub mod builder;
mod drift;
mod laser;
mod load;
mod plate;
mod probe;
mod random;
mod sphere;
pub mod table;
mod way;

use std::fmt;

use ncfix_base::geometry::{Axis, Plane, Vector};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorName;

use super::data::DataSet;
use builder::Builder;

/// A kind of plan.
#[derive(Debug)]
pub struct PlanKind {
    /// As the command line names it.
    pub name: &'static str,
    /// What it is.
    pub title: &'static str,
    /// The wishes that it understands beside the tool, as the command line names them.
    pub wishes: &'static [&'static str],
    /// Makes the plan.
    pub build: fn(&Machine, &Wishes) -> Result<Builder, Refused>,
}

/// All kinds of plans.
pub const PLANS: &[PlanKind] =
    &[ballbar::PLAN, sphere::PLAN, probe::PLAN, laser::PLAN, drift::PLAN, plate::PLAN, load::PLAN];

/// The plan of a name.
#[must_use]
pub fn find(name: &str) -> Option<&'static PlanKind> {
    PLANS.iter().find(|plan| plan.name == name)
}

/// What a user may wish; what is not given has a default of the plan. mm, rad, mm/min, s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wishes {
    /// Tool vectors, from the spindle gauge point to the tip, along F's directions at the zero pose.
    pub tools_mm: Vec<Vector>,
    /// Centres, as positions at the tool point; all kinds but plates have one.
    pub centres_mm: Vec<Vector>,
    /// Radius of circles and spheres, or of the circle of balls.
    pub radius_mm: Option<f64>,
    /// Feed.
    pub feed: Option<f64>,
    /// Planes of circles or plates.
    pub planes: Vec<Plane>,
    /// Angle, or distance of holes, between rows.
    pub every: Option<f64>,
    /// Angle that an arc sweeps.
    pub sweep: Option<f64>,
    /// Angle before and behind it.
    pub overlap: Option<f64>,
    /// Angle of a straight piece on a sphere.
    pub chord: Option<f64>,
    /// Which of several plans.
    pub variant: Option<String>,
    /// Places of balls in the workpiece frame.
    pub balls_mm: Vec<Vector>,
    /// Distance from a pose at which the way to it begins.
    pub clearance_mm: Option<f64>,
    /// Largest angle of tilting axes.
    pub tilt: Option<f64>,
    /// The axis that is measured.
    pub axis: Option<Axis>,
    /// What is measured of it.
    pub components: Vec<ErrorName>,
    /// First and last position of it.
    pub range: Option<[f64; 2]>,
    /// How many points, poses, or holes along a side.
    pub points: Option<usize>,
    /// How often.
    pub runs: Option<usize>,
    /// Waiting time at a pose.
    pub dwell_s: Option<f64>,
    /// What stays free at both ends of the travel of linear axes.
    pub margin_mm: Option<f64>,
    /// Weights on the table, N.
    pub forces_n: Vec<f64>,
    /// Where they are put, mm.
    pub places_mm: Vec<Vector>,
    /// How long the whole lasts.
    pub hours: Option<f64>,
    /// Highest speed of the spindle, 1/min.
    pub speed: Option<f64>,
    /// Seed of what is at random.
    pub seed: u64,
    /// A line of the control at every pose, such as the call of a probing cycle, instead of a stop.
    pub line: Option<String>,
}

/// Why there is no such plan: a sentence without a full stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(pub String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

/// The most rows and moves of a plan: a mistyped step shall not fill the disk.
const MOST: usize = 500_000;

/// What stays free at both ends of the travel without another wish, mm: a spindle or table that is off its nominal place by more is in need
/// of other help than a calibration.
const MARGIN_MM: f64 = 2.0;

impl Wishes {
    /// What stays free at both ends of the travel of linear axes.
    fn margin_mm(&self) -> f64 {
        self.margin_mm.unwrap_or(MARGIN_MM).max(0.0)
    }

    /// The only tool; none is a tool of length 0.
    fn tool_mm(&self) -> Vector {
        self.tools_mm.first().copied().unwrap_or_else(Vector::zeros)
    }

    /// The centre, or the middle of the travel, as a position at the tool point.
    fn centre_or_middle(&self, machine: &Machine, tool_mm: &Vector) -> Vector {
        self.centres_mm.first().copied().unwrap_or_else(|| middle(machine) + tool_mm)
    }
}

/// The middle of the travel of X, Y and Z.
fn middle(machine: &Machine) -> Vector {
    let of = |axis| machine.axis(axis).and_then(|data| data.travel).map_or(0.0, |[low, high]| low.midpoint(high));
    Vector::new(of(Axis::X), of(Axis::Y), of(Axis::Z))
}

/// The direction 0, 1, 2 that the spindle is nearest to, and its sign.
fn along_spindle(machine: &Machine) -> (usize, f64) {
    let axis = machine.spindle.axis;
    let which = axis.iamax();
    (which, if axis[which] < 0.0 { -1.0 } else { 1.0 })
}

/// A measurement of a kind without rows.
fn empty(kind: &'static super::kind::Kind, free: &[super::data::Free]) -> DataSet {
    DataSet {
        sigma_rad: None,
        balls: Vec::new(),
        is_plan: true,
        fixed: Vec::new(),
        conditions: Vec::new(),
        has_senses: true,
        name: kind.name.to_owned(),
        kind,
        sigma: None,
        free: free.to_vec(),
        artefact: super::data::Setup::default(),
        rods: Vec::new(),
        cycles: Vec::new(),
        setups: Vec::new(),
        runs: vec![String::new()],
        targets: Vec::new(),
        lengths: Vec::new(),
        observations: Vec::new(),
        drivers: Vec::new(),
    }
}

/// The kind of a name; all that plans name are in the register.
fn kind(name: &str) -> Result<&'static super::kind::Kind, Refused> {
    super::kind::BUILT_IN
        .iter()
        .copied()
        .find(|kind| kind.name == name)
        .ok_or_else(|| Refused(format!("there is no kind of measurement {name}")))
}
