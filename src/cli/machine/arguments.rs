//! Arguments of the commands about one machine, and of its condition.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::cli::arguments::{MachineChoice, examples};
use crate::cli::value;
use ncfix_base::geometry::AxisVector;
use ncfix_machine::machine::{Load, State};

/// The condition of the machine.
#[derive(Clone, Debug, Default, Args)]
pub(in crate::cli) struct StateChoice {
    /// Temperatures and loads: a state file (TOML), or a log of them (CSV with t_s, T_NAME_C, load_N …); several are laid over each other, the
    /// last one wins
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) state: Vec<PathBuf>,
    /// The instant of the log, s; without it its last
    #[arg(long, value_name = "SECONDS", requires = "state", allow_hyphen_values = true)]
    pub(in crate::cli) time: Option<f64>,
    /// The instant of the log at which the zero point of the workpiece was set, s: drift counts from there
    #[arg(long, value_name = "SECONDS", requires = "state", allow_hyphen_values = true)]
    pub(in crate::cli) zero_time: Option<f64>,
    /// Where the axes stood when the zero point was set (mm, deg): only what the drift did there ends with it
    #[arg(long, value_name = "X..,Y..,Z..", value_parser = value::start, allow_hyphen_values = true, requires = "state")]
    pub(in crate::cli) zero_at: Option<AxisVector>,
    /// Weight on the table in N, and where it stands from the center of the table in mm: 1700, 1700@0,0,-280; instead of those of
    /// --state
    #[arg(long, value_name = "N[@X,Y,Z]", value_parser = value::load, allow_hyphen_values = true)]
    pub(in crate::cli) load: Option<Load>,
}

/// `ncfix machine`.
#[derive(Clone, Debug, Subcommand)]
pub(in crate::cli) enum MachineCommand {
    /// Report every fault of a machine file
    #[command(after_help = examples::MACHINE)]
    Check(MachineArguments),
    /// Show the machine that a file describes, or with --at its errors at a pose, source by source
    #[command(after_help = examples::SHOW)]
    Show(Box<ShowArguments>),
    /// List the choices of parameters for an error model, or show one of them with its values in a machine file
    #[command(after_help = examples::PRESETS)]
    Presets(PresetArguments),
}

/// `ncfix machine presets`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct PresetArguments {
    /// Preset, such as mayer-13; without it all are listed
    #[arg(value_name = "NAME")]
    pub(in crate::cli) name: Option<String>,
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
}

/// `ncfix machine show`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct ShowArguments {
    #[command(flatten)]
    /// Which file.
    pub(in crate::cli) file: MachineArguments,
    /// Axis positions (mm, deg, machine coordinates; axes left out are at 0) at which the errors are shown: X100,Y=50,C30
    #[arg(long, value_name = "X..,Y..,Z..", value_parser = value::start, allow_hyphen_values = true)]
    pub(in crate::cli) at: Option<AxisVector>,
    /// Tool: its length in mm along the spindle, or X,Y,Z from the gauge point to the tip in F's directions
    #[arg(long, value_name = "LENGTH|X,Y,Z", value_parser = value::tool, allow_hyphen_values = true, requires = "at")]
    pub(in crate::cli) tool: Option<value::ToolVector>,
    /// Sense of the last motion of axes: X+,Y-; without it backlash counts nothing
    #[arg(long, value_name = "X+,Y-", value_parser = value::sense, requires = "at", allow_hyphen_values = true)]
    pub(in crate::cli) sense: Option<State>,
    #[command(flatten)]
    /// The condition of the machine.
    pub(in crate::cli) state: StateChoice,
    /// Show where every value comes from: file and line, or default
    #[arg(long, conflicts_with = "at")]
    pub(in crate::cli) origin: bool,
    /// Print one JSON object on standard output, with --at or --origin
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// `ncfix machine check`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct MachineArguments {
    /// Machine file; without it that of NCFIX_MACHINE, then the nearest ncfix.toml from the working folder upwards
    #[arg(value_name = "M.toml")]
    pub(in crate::cli) file: Option<PathBuf>,
    /// Set-up file with zero offsets and tools: TOML, or data as the control saves them; may be given several times
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) setup: Vec<PathBuf>,
}
