//! The arguments of `ncfix realtime`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::cli::arguments::{MachineChoice, RotaryChoice, StateChoice};
use crate::cli::value;
use ncfix_base::geometry::Vector;
use ncfix_base::units::{mm_from_um, rad_from_urad};
use ncfix_machine::machine::Machine;
use ncfix_tables::realtime::{Dosing, KernelRecipe};

/// What `ncfix realtime --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
Standard input has one set-point of all axes per line, uncompensated, machine coordinates in mm and degrees: words (X100 Y50.5 Z-20; behind the first line axes \
may be left out where they stay), or a table whose first line has the letters of the axes (X,Y,Z). Standard output has a line of titles (dX_um, dA_urad …) and a \
line for each set-point: what is added to it, and in the last column what there is to be known: beyond (the travel; the correction is that of its end), dosed (the \
correction is still on its way), unsolved (no correction exists; the last one is held), renewed (a new kernel is in force). A line that cannot be read ends the \
run with status 4; every line before it was answered.

The files of --state are read again every --update-s; a log counts with its last instant.

With --ring set-points and corrections go through shared memory instead (docs/realtime.md has the layout); Ctrl-C or the control ends it.

Examples:
  ncfix realtime --machine mill.toml --tool 120 < set_points.csv > corrections.csv
  ncfix realtime --machine mill.toml --state live.csv --update-s 60 --dose-um 1 --latency
  ncfix realtime --machine mill.toml --ring mill
  ncfix realtime --stability stability.html";

/// `ncfix realtime`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct RealtimeArguments {
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// In which condition.
    pub(in crate::cli) state: StateChoice,
    /// Length of the tool in mm, or vector from the spindle to its tip; without it the gauge point of the spindle is corrected
    #[arg(long, value_name = "LENGTH|X,Y,Z", value_parser = value::tool, allow_hyphen_values = true)]
    pub(in crate::cli) tool: Option<value::ToolVector>,
    /// Rotary axes
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) rotary: RotaryChoice,
    /// The correction of a linear axis changes by no more than this per set-point, µm; off for no limit
    #[arg(long, value_name = "UM|off", default_value = "1", value_parser = value::dose)]
    pub(in crate::cli) dose_um: f64,
    /// The same for rotary axes, µrad
    #[arg(long, value_name = "URAD|off", default_value = "5", value_parser = value::dose)]
    pub(in crate::cli) dose_urad: f64,
    /// Refuse a model whose corrections go beyond this anywhere in the travel, with its unit
    #[arg(long, value_name = "LENGTH", default_value = "0.5mm", value_parser = value::positive_length_mm)]
    pub(in crate::cli) max_correction: f64,
    /// How often --state is read again, s
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = value::seconds)]
    pub(in crate::cli) update_s: Duration,
    /// Serve rings in shared memory: a name in /dev/shm, or a path with a separator; the file must not exist and is removed at the end
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) ring: Option<String>,
    /// Records of each ring, a power of two
    #[arg(long, value_name = "N", default_value_t = 1024, requires = "ring")]
    pub(in crate::cli) records: u64,
    /// Print at the end how long the set-points took
    #[arg(long)]
    pub(in crate::cli) latency: bool,
    /// Write a page with a simulation of scale compensation against set-point compensation, and do nothing else
    #[arg(long, value_name = "FILE.html")]
    pub(in crate::cli) stability: Option<PathBuf>,
}

impl RealtimeArguments {
    /// How kernels are made.
    pub(super) fn recipe(&self, machine: &Machine) -> KernelRecipe {
        KernelRecipe {
            tool_mm: self.tool.map_or_else(Vector::zeros, |tool| tool.vector_mm(machine)),
            mode: self.rotary.solve(),
            max_correction_mm: self.max_correction,
        }
    }

    /// How corrections are dosed.
    pub(super) fn dosing(&self) -> Dosing {
        Dosing::new(mm_from_um(self.dose_um), rad_from_urad(self.dose_urad))
    }
}
