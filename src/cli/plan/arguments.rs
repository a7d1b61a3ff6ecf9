//! The arguments of `ncfix plan`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::MachineChoice;
use crate::option_values::{above_zero, axis, component, margin, not_negative, numbers, plane, vector};
use crate::tool::ToolVector;
use ncfix_base::geometry::{Axis, Plane, Vector};
use ncfix_machine::machine::Machine;
use ncfix_metrology::measure::plan::{PLANS, PlanKind, RowSpacing, Wishes, find, kinds_help};
use ncfix_model::ErrorName;

/// End of `ncfix plan --help`.
const AFTER_KINDS: &str = "
PLAN.csv gets the poses with empty readings, PLAN.toml in the same folder gets the description. The program has axis positions in machine coordinates, without \
zero offset and tool length compensation; it stops (M0) for mounting the instrument. Run it first without an instrument.

Examples:
  ncfix plan ballbar --machine mill.toml --tool 150 --center 300,200,350 -o circles.csv --program CIRCLES.MPF
  ncfix plan probe --variant rumba --machine five.toml --tool 200 --model 81 -o balls.csv --program BALLS.MPF
  ncfix plan plate --plane YZ --tool 150 --tool 0,-80,-100 --machine mill.toml --model spaan-21 --with xy.csv --with zx.csv -o yz.csv";

/// End of `ncfix plan --help`, with all kinds.
pub(in crate::cli) fn after_help() -> String {
    format!("Kinds:\n{}{AFTER_KINDS}", kinds_help())
}

/// `ncfix plan`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct PlanArguments {
    /// Kind of measurement; see Kinds below
    #[arg(value_name = "KIND", value_parser = kind)]
    pub(in crate::cli) kind: &'static PlanKind,
    /// Table of poses; its description (.toml) goes into the same folder
    #[arg(short, long, value_name = "PLAN.csv")]
    pub(in crate::cli) output: PathBuf,
    /// NC program that runs the poses, in the dialect of the machine's control
    #[arg(long, value_name = "TEST.mpf")]
    pub(in crate::cli) program: Option<PathBuf>,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    /// Preset or file of parameters that the measurement must determine; those it cannot are reported
    #[arg(long, value_name = "PRESET|FILE")]
    pub(in crate::cli) model: Option<String>,
    /// Existing measurement or plan, used together with this one to determine the model; repeatable
    #[arg(long, value_name = "OTHER.csv", requires = "model")]
    pub(in crate::cli) with: Vec<PathBuf>,
    /// Add the N poses that improve the condition of the model most
    #[arg(long, value_name = "N", requires = "model")]
    pub(in crate::cli) improve: Option<usize>,
    /// Tool length along the spindle, mm, or X,Y,Z from gauge point to tip along the axes of F, mm; repeatable for a plate
    #[arg(long, value_name = "LENGTH|X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) tool: Vec<ToolVector>,
    /// Margin to both ends of the travel of linear axes, mm (default: 2); corrected positions may exceed nominal ones
    #[arg(long, value_name = "MM", value_parser = margin)]
    pub(in crate::cli) margin: Option<f64>,
    /// Center as a position of the tool tip (axis positions plus tool vector), mm (default: middle of the travel); repeatable for a plate
    #[arg(long = "center", alias = "centre", value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(in crate::cli) centre: Vec<Vector>,
    /// Radius, mm (default: 100 for ballbar, 150 for sphere, 70 for a circle of balls, 6 for the end mill of workpiece)
    #[arg(long, value_name = "MM", value_parser = above_zero)]
    pub(in crate::cli) radius: Option<f64>,
    /// Feed, mm/min
    #[arg(long, value_name = "MM/MIN", value_parser = above_zero)]
    pub(in crate::cli) feed: Option<f64>,
    /// Plane: XY, YZ or ZX; repeatable
    #[arg(long, value_name = "PLANE", value_parser = plane)]
    pub(in crate::cli) plane: Vec<Plane>,
    /// Spacing of rows, deg (default: 2 for ballbar, 5 for sphere, 10 with a turning table), or of holes, mm (default: 50, 60 for workpiece)
    #[arg(long, value_name = "DEG|MM", value_parser = above_zero)]
    pub(in crate::cli) every: Option<f64>,
    /// Evaluated arc, deg (default: 360 in the plane perpendicular to the spindle, else 220)
    #[arg(long, value_name = "DEG", value_parser = above_zero)]
    pub(in crate::cli) sweep: Option<f64>,
    /// Angle before and after the evaluated arc, deg (default: 180 with full circles, else 20)
    #[arg(long, value_name = "DEG", value_parser = not_negative)]
    pub(in crate::cli) overlap: Option<f64>,
    /// Angle of a straight piece, deg (default: 0.1 on a sphere, 0.5 with a turning table)
    #[arg(long, value_name = "DEG", value_parser = above_zero)]
    pub(in crate::cli) chord: Option<f64>,
    /// Variant; see Kinds below
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) variant: Option<String>,
    /// Position of a ball in the workpiece frame (F at the zero pose), mm; once for every ball
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(in crate::cli) ball: Vec<Vector>,
    /// Start of the approach to a pose, above it along the tool, mm (default: 20)
    #[arg(long, value_name = "MM", value_parser = not_negative)]
    pub(in crate::cli) clearance: Option<f64>,
    /// Largest angle of tilting axes, deg (default: 60)
    #[arg(long, value_name = "DEG", value_parser = above_zero)]
    pub(in crate::cli) tilt: Option<f64>,
    /// Axis (default: X)
    #[arg(long, value_name = "AXIS", value_parser = axis)]
    pub(in crate::cli) axis: Option<Axis>,
    /// Measured error, such as EXX or EBX; repeatable
    #[arg(long, value_name = "NAME", value_parser = component)]
    pub(in crate::cli) component: Vec<ErrorName>,
    /// First and last position of the axis, mm or deg (default: the travel)
    #[arg(long, value_name = "FROM,TO", value_parser = numbers::<2>, allow_hyphen_values = true)]
    pub(in crate::cli) range: Option<[f64; 2]>,
    /// Number of targets of an axis (default: 11 for laser, 8 for load, 5 for diagonal), angles of the rotary axes (42), holes per side (5, 3 for workpiece)
    #[arg(long, value_name = "N")]
    pub(in crate::cli) points: Option<usize>,
    /// Number of forward and backward runs (default: 5 for laser and diagonal, else 1)
    #[arg(long, value_name = "N")]
    pub(in crate::cli) runs: Option<usize>,
    /// Dwell at a pose, s (default: 4 for laser and level, 3 for plate, 2 before a circle; probe stops with M0), or between the levels of workpiece (default: 0)
    #[arg(long, value_name = "S", value_parser = not_negative)]
    pub(in crate::cli) dwell: Option<f64>,
    /// Weight on the table, in newtons; repeatable
    #[arg(long, value_name = "N", value_parser = above_zero)]
    pub(in crate::cli) force: Vec<f64>,
    /// Position of the weights, mm (default: 0,0,0); repeatable
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(in crate::cli) place: Vec<Vector>,
    /// Duration of the drift measurement, h (default: one pass for din, else 24; steady stands as long again)
    #[arg(long, value_name = "H", value_parser = above_zero)]
    pub(in crate::cli) hours: Option<f64>,
    /// Highest spindle speed, 1/min (default: 6300, 4000 for workpiece)
    #[arg(long, value_name = "RPM", value_parser = above_zero)]
    pub(in crate::cli) speed: Option<f64>,
    /// Sides of the blank of a workpiece, mm (default: 200,200,50)
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::<3>)]
    pub(in crate::cli) blank: Option<[f64; 3]>,
    /// Number of levels of a workpiece (default: 12)
    #[arg(long, value_name = "N")]
    pub(in crate::cli) levels: Option<usize>,
    /// Seed of random values (default: 1)
    #[arg(long, value_name = "N")]
    pub(in crate::cli) seed: Option<u64>,
    /// NC line to insert at every pose, such as a probing cycle call
    #[arg(long, value_name = "TEXT")]
    pub(in crate::cli) line: Option<String>,
}

impl PlanArguments {
    /// Requests, in mm and rad.
    pub(super) fn wishes(&self, machine: &Machine) -> Wishes {
        let angle = |degrees: Option<f64>| degrees.map(f64::to_radians);
        let is_turned = self.axis.is_some_and(Axis::is_rotary);
        Wishes {
            tools_mm: self.tool.iter().map(|tool| tool.vector_mm(machine)).collect(),
            centres_mm: self.centre.clone(),
            margin_mm: self.margin,
            forces_n: self.force.clone(),
            places_mm: self.place.clone(),
            radius_mm: self.radius,
            feed: self.feed,
            planes: self.plane.clone(),
            every: match self.kind.spacing {
                RowSpacing::Length => self.every,
                RowSpacing::Angle => angle(self.every),
            },
            sweep: angle(self.sweep),
            overlap: angle(self.overlap),
            chord: angle(self.chord),
            variant: self.variant.clone(),
            balls_mm: self.ball.clone(),
            clearance_mm: self.clearance,
            tilt: angle(self.tilt),
            axis: self.axis,
            components: self.component.clone(),
            range: self.range.map(|range| if is_turned { range.map(f64::to_radians) } else { range }),
            points: self.points,
            runs: self.runs,
            dwell_s: self.dwell,
            hours: self.hours,
            speed: self.speed,
            blank_mm: self.blank.map(Vector::from),
            levels: self.levels,
            seed: self.seed.unwrap_or(1),
            line: self.line.clone(),
        }
    }
}

fn kind(text: &str) -> Result<&'static PlanKind, String> {
    find(text).ok_or_else(|| {
        let names: Vec<&str> = PLANS.iter().map(|plan| plan.name).collect();
        format!("the kinds are {}", names.join(", "))
    })
}
