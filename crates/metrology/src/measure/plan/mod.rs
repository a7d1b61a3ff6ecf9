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
    /// What stands between its rows, as the wish `every` has it.
    pub spacing: RowSpacing,
    /// Whether several tools and centres make several set-ups of it.
    pub has_setups: bool,
    /// Makes the plan.
    pub build: fn(&Machine, &Wishes) -> Result<Builder, Refused>,
}

/// What the wish `every` is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowSpacing {
    /// An angle, rad.
    Angle,
    /// A length, mm.
    Length,
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

impl PlanKind {
    /// Refuses wishes that a plan of this kind on this machine has no place for. `is_seeded` says whether a seed was given.
    ///
    /// # Errors
    /// What it has in their place.
    pub fn check(&self, wishes: &Wishes, is_seeded: bool, machine: &Machine) -> Result<(), Refused> {
        let given = wishes.given().into_iter().chain([("seed", is_seeded)]);
        if let Some((name, _)) = given.into_iter().find(|(name, is_given)| *is_given && !self.wishes.contains(name)) {
            let known: Vec<String> = self.wishes.iter().map(|wish| format!("--{wish}")).collect();
            let known = known.join(", ");
            return Err(Refused(format!("a plan {} has no --{name}; it has --tool, {known}", self.name)));
        }
        for (name, count) in [("tool", wishes.tools_mm.len()), ("centre", wishes.centres_mm.len())] {
            if count > 1 && !self.has_setups {
                return Err(Refused(format!("a plan {} has one --{name}", self.name)));
            }
        }
        let is_turned = wishes.axis.is_some_and(Axis::is_rotary);
        let linear = machine.axes.iter().flatten().filter(|data| !data.axis.is_rotary());
        let slowest = linear.filter_map(|data| data.max_feed).min_by(f64::total_cmp);
        if let (Some(feed), Some(most), false) = (wishes.feed, slowest, is_turned)
            && feed > most
        {
            // The control would be slower than the program says, or the machine faster than it may.
            return Err(Refused(format!(
                "--feed {feed} mm/min is beyond the {most} mm/min that every linear axis of the machine {} has; give {most} or less",
                machine.name
            )));
        }
        Ok(())
    }
}

impl Wishes {
    /// The wishes that not every kind has, by the names of the command line but for the seed, and whether they were given.
    fn given(&self) -> [(&'static str, bool); 23] {
        [
            ("centre", !self.centres_mm.is_empty()),
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
            ("line", self.line.is_some()),
        ]
    }

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
