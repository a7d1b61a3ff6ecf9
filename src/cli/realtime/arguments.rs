//! The arguments of `ncfix realtime`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::cli::arguments::{MachineChoice, PoseRotaryChoice, StateChoice};
use crate::cli::value;
use crate::tool::ToolVector;
use ncfix_base::geometry::Vector;
use ncfix_base::units::{mm_from_um, rad_from_urad};
use ncfix_machine::machine::Machine;
use ncfix_tables::realtime::{Dosing, KernelRecipe};

/// End of `ncfix realtime --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
Each line of standard input is an uncompensated set-point of all axes, in machine coordinates, mm and degrees: words (X100 Y50.5 Z-20; after the first \
line, unchanged axes may be omitted), or a table whose first line has the axis letters (X,Y,Z). Standard output has a header line (dX_um, dA_urad …) \
and a line for each set-point: the correction to add, and its state: beyond (outside the travel; the correction at the end of the travel applies), \
dosed (the rate limit delays part of the correction), unsolved (there is no correction; the previous one remains), renewed (a new kernel is in force). \
A line that cannot be read ends the run with status 4; all lines before it were answered.

ncfix reads the files of --state again at the interval of --update-s. In a log, the last entry applies.

With --ring, set-points and corrections go through shared memory instead (layout: docs/reference/realtime.md); Ctrl-C or the control ends the run.

Examples:
  ncfix realtime --machine mill.toml --tool 120 < set_points.csv > corrections.csv
  ncfix realtime --machine mill.toml --state live.csv --update-s 60 --dose-um 1 --latency
  ncfix realtime --machine mill.toml --ring mill
  ncfix realtime --stability stability.html";

/// `ncfix realtime`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct RealtimeArguments {
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// Condition of the machine.
    pub(in crate::cli) state: StateChoice,
    /// Tool length, mm, or vector from the spindle to the tip, mm (default: the gauge point of the spindle)
    #[arg(long, value_name = "LENGTH|X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) tool: Option<ToolVector>,
    /// Correction of the rotary axes
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) rotary: PoseRotaryChoice,
    /// Largest change of a linear axis correction per set-point, µm; off for no limit
    #[arg(long, value_name = "UM|off", default_value = "1", value_parser = value::dose)]
    pub(in crate::cli) dose_um: f64,
    /// Largest change of a rotary axis correction per set-point, µrad; off for no limit
    #[arg(long, value_name = "URAD|off", default_value = "5", value_parser = value::dose)]
    pub(in crate::cli) dose_urad: f64,
    /// Largest correction allowed anywhere in the travel, with unit; models beyond it are refused
    #[arg(long, value_name = "LENGTH", default_value = "0.5mm", value_parser = value::positive_length_mm)]
    pub(in crate::cli) max_correction: f64,
    /// Interval for reading --state again, s
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = value::seconds)]
    pub(in crate::cli) update_s: Duration,
    /// Serve rings in shared memory: a name in /dev/shm, or a path with a separator; the file must not exist and is removed at the end
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) ring: Option<String>,
    /// Records of each ring, a power of two
    #[arg(long, value_name = "N", default_value_t = 1024, requires = "ring")]
    pub(in crate::cli) records: u64,
    /// Print the computing times of the set-points at the end
    #[arg(long)]
    pub(in crate::cli) latency: bool,
    /// Only write a page with a simulation of scale compensation against set-point compensation
    #[arg(long, value_name = "FILE.html")]
    pub(in crate::cli) stability: Option<PathBuf>,
}

impl RealtimeArguments {
    /// Settings of the kernels.
    pub(super) fn recipe(&self, machine: &Machine) -> KernelRecipe {
        KernelRecipe {
            tool_mm: self.tool.map_or_else(Vector::zeros, |tool| tool.vector_mm(machine)),
            mode: self.rotary.solve(),
            max_correction_mm: self.max_correction,
        }
    }

    /// Rate limits of corrections.
    pub(super) fn dosing(&self) -> Dosing {
        Dosing::new(mm_from_um(self.dose_um), rad_from_urad(self.dose_urad))
    }
}
