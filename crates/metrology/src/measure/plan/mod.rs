//! Test plans: measuring positions, and the program path to them.
//!
//! A plan is a measurement without readings ([`DataSet`]) and a path in axis commands. One file per kind of plan, registered in [`PLANS`]; pure
//! functions of a machine and [`Wishes`]. [`builder`] keeps path and rows within the travel and on increments of the control, [`table`] writes the
//! pair of files.

mod ballbar;
pub mod builder;
mod diagonal;
mod drift;
pub mod duration;
mod follow;
mod laser;
mod load;
mod plate;
mod probe;
mod random;
mod rtest;
mod sphere;
pub mod table;
mod together;
mod turned_bar;
mod way;
mod workpiece;

use std::fmt;

use ncfix_base::geometry::{Axis, Plane, Vector};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorName;

use super::data::DataSet;
use builder::Builder;

/// A kind of plan.
#[derive(Debug)]
pub struct PlanKind {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its title.
    pub title: &'static str,
    /// The options that it supports in addition to the tool, by their names on the command line.
    pub wishes: &'static [&'static str],
    /// Meaning of the option `every` between its rows.
    pub spacing: RowSpacing,
    /// `true` if several tools and centers make several set-ups.
    pub has_setups: bool,
    /// Makes the plan.
    pub build: fn(&Machine, &Wishes) -> Result<Builder, PlanRefused>,
}

/// Meaning of the option `every`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowSpacing {
    /// An angle, rad.
    Angle,
    /// A length, mm.
    Length,
}

/// All kinds of plans.
pub const PLANS: &[PlanKind] = &[
    ballbar::PLAN,
    sphere::PLAN,
    probe::PLAN,
    rtest::PLAN,
    laser::PLAN,
    diagonal::PLAN,
    drift::PLAN,
    plate::PLAN,
    load::PLAN,
    workpiece::PLAN,
];

/// The plan with a name.
#[must_use]
pub fn find(name: &str) -> Option<&'static PlanKind> {
    PLANS.iter().find(|plan| plan.name == name)
}

/// The kinds with their options, for the help: a kind and its title, and a line of options.
#[must_use]
pub fn kinds_help() -> String {
    let kind = |plan: &PlanKind| {
        let wishes: Vec<String> = plan.wishes.iter().map(|wish| format!("--{wish}")).collect();
        format!("  {:<9} {}\n            {}\n", plan.name, plan.title, wishes.join(" "))
    };
    PLANS.iter().map(kind).collect()
}

/// Options of a user; missing ones have defaults of the plan. mm, rad, mm/min, s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wishes {
    /// Tool vectors, from the spindle gauge point to the tip, along F's directions at the zero pose.
    pub tools_mm: Vec<Vector>,
    /// Centers, as positions of the tool tip; all kinds except plates have one.
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
    /// Angle before and after the arc.
    pub overlap: Option<f64>,
    /// Angle of a straight piece on a sphere.
    pub chord: Option<f64>,
    /// Variant of the plan.
    pub variant: Option<String>,
    /// Positions of balls in the workpiece frame.
    pub balls_mm: Vec<Vector>,
    /// Distance from a pose at which the approach begins.
    pub clearance_mm: Option<f64>,
    /// Largest angle of tilting axes.
    pub tilt: Option<f64>,
    /// The measured axis.
    pub axis: Option<Axis>,
    /// Measured components.
    pub components: Vec<ErrorName>,
    /// Its first and last position.
    pub range: Option<[f64; 2]>,
    /// Number of points, poses, or holes along a side.
    pub points: Option<usize>,
    /// Number of runs.
    pub runs: Option<usize>,
    /// Dwell time at a pose.
    pub dwell_s: Option<f64>,
    /// Margin at both ends of the travel of linear axes.
    pub margin_mm: Option<f64>,
    /// Weights on the table, N.
    pub forces_n: Vec<f64>,
    /// Their positions, mm.
    pub places_mm: Vec<Vector>,
    /// Total duration, hours.
    pub hours: Option<f64>,
    /// Highest spindle speed, 1/min.
    pub speed: Option<f64>,
    /// Sides of the blank of a workpiece along X, Y and Z, mm.
    pub blank_mm: Option<Vector>,
    /// Number of levels of a workpiece.
    pub levels: Option<usize>,
    /// Seed of random choices.
    pub seed: u64,
    /// A line of the control at every pose, such as a probing cycle call, instead of a stop.
    pub line: Option<String>,
}

/// Reason why there is no such plan: a sentence without a full stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanRefused(pub String);

impl fmt::Display for PlanRefused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for PlanRefused {}

/// Maximum number of rows and moves of a plan: a mistyped step must not fill the disk.
const MOST: usize = 500_000;

/// Default margin at both ends of the travel, mm: a larger displacement of spindle or table needs more than a calibration.
const MARGIN_MM: f64 = 2.0;

impl PlanKind {
    /// Rejects options that a plan of this kind on this machine does not support. `is_seeded` is `true` if a seed was given.
    ///
    /// # Errors
    /// The supported alternatives.
    pub fn check(&self, wishes: &Wishes, is_seeded: bool, machine: &Machine) -> Result<(), PlanRefused> {
        let mut given = wishes.given().into_iter().chain([("seed", is_seeded)]);
        if let Some((name, _)) = given.find(|(name, is_given)| *is_given && !self.wishes.contains(name)) {
            let known: Vec<String> = self.wishes.iter().map(|wish| format!("--{wish}")).collect();
            let known = known.join(", ");
            return Err(PlanRefused(format!("ncfix plan {} has no --{name}; it has --tool, {known}", self.name)));
        }
        for (name, count) in [("tool", wishes.tools_mm.len()), ("center", wishes.centres_mm.len())] {
            if count > 1 && !self.has_setups {
                return Err(PlanRefused(format!(
                    "ncfix plan {} takes only one --{name}; make a plan for each, and fit the files together",
                    self.name
                )));
            }
        }
        let is_turned = wishes.axis.is_some_and(Axis::is_rotary);
        let linear = machine.axes.iter().flatten().filter(|data| !data.axis.is_rotary());
        let slowest = linear.filter_map(|data| data.max_feed).min_by(f64::total_cmp);
        if let (Some(feed), Some(most), false) = (wishes.feed, slowest, is_turned)
            && feed > most
        {
            // The control would be slower than programmed, or the machine faster than permitted.
            return Err(PlanRefused(format!(
                "--feed {feed} mm/min is beyond the {most} mm/min that every linear axis of the machine {} has; give {most} or less",
                machine.name
            )));
        }
        Ok(())
    }
}

impl Wishes {
    /// The options that not every kind supports, by their command line names except the seed, and `true` if given.
    fn given(&self) -> [(&'static str, bool); 25] {
        [
            ("center", !self.centres_mm.is_empty()),
            ("radius", self.radius_mm.is_some()),
            ("feed", self.feed.is_some()),
            ("plane", !self.planes.is_empty()),
            ("every", self.every.is_some()),
            ("sweep", self.sweep.is_some()),
            ("overlap", self.overlap.is_some()),
            ("chord", self.chord.is_some()),
            ("variant", self.variant.is_some()),
            ("ball", !self.balls_mm.is_empty()),
            ("clearance", self.clearance_mm.is_some()),
            ("tilt", self.tilt.is_some()),
            ("axis", self.axis.is_some()),
            ("component", !self.components.is_empty()),
            ("range", self.range.is_some()),
            ("points", self.points.is_some()),
            ("runs", self.runs.is_some()),
            ("dwell", self.dwell_s.is_some()),
            ("force", !self.forces_n.is_empty()),
            ("place", !self.places_mm.is_empty()),
            ("hours", self.hours.is_some()),
            ("speed", self.speed.is_some()),
            ("blank", self.blank_mm.is_some()),
            ("levels", self.levels.is_some()),
            ("line", self.line.is_some()),
        ]
    }

    /// Margin at both ends of the travel of linear axes.
    fn margin_mm(&self) -> f64 {
        self.margin_mm.unwrap_or(MARGIN_MM).max(0.0)
    }

    /// The single tool; default length 0.
    fn tool_mm(&self) -> Vector {
        self.tools_mm.first().copied().unwrap_or_else(Vector::zeros)
    }

    /// The center, or the middle of the travel, as a position of the tool tip.
    fn centre_or_middle(&self, machine: &Machine, tool_mm: &Vector) -> Vector {
        self.centres_mm.first().copied().unwrap_or_else(|| middle(machine) + tool_mm)
    }
}

/// The middle of the travel of X, Y and Z.
fn middle(machine: &Machine) -> Vector {
    let of = |axis| machine.axis(axis).and_then(|data| data.travel).map_or(0.0, |[low, high]| low.midpoint(high));
    Vector::new(of(Axis::X), of(Axis::Y), of(Axis::Z))
}

/// The direction 0, 1, 2 nearest to the spindle, and its sign.
fn along_spindle(machine: &Machine) -> (usize, f64) {
    let axis = machine.spindle.axis;
    let which = axis.iamax();
    (which, if axis[which] < 0.0 { -1.0 } else { 1.0 })
}

/// A measurement of a kind without rows.
fn empty(kind: &'static super::kind::Instrument, free: &[super::data::Free]) -> DataSet {
    DataSet {
        sigma_rad: None,
        scale_sigma: 0.0,
        balls: Vec::new(),
        is_plan: true,
        fixed: Vec::new(),
        ranges: Vec::new(),
        conditions: Vec::new(),
        is_in_order: true,
        is_order_stated: true,
        is_unit_stated: false,
        is_square_stated: false,
        sensors: None,
        has_senses: true,
        name: kind.name.to_owned(),
        kind,
        date: None,
        head: None,
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

/// The kind with a name; all names in plans are registered.
fn kind(name: &str) -> Result<&'static super::kind::Instrument, PlanRefused> {
    super::kind::BUILT_IN
        .iter()
        .copied()
        .find(|kind| kind.name == name)
        .ok_or_else(|| PlanRefused(format!("unknown kind of test plan '{name}'")))
}
