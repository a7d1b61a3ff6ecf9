//! Arguments of the commands about one machine, and of its condition.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use crate::cli::arguments::{MachineChoice, examples};
use crate::stated_zero::StatedZero;
use crate::tool::ToolVector;
use ncfix_base::geometry::AxisVector;
use ncfix_machine::describe::{DescriptionRequest, StatedPivot, StatedSense, StatedTravel};
use ncfix_machine::machine::{Load, State};

/// Condition of the machine.
#[derive(Clone, Debug, Default, Args)]
pub(in crate::cli) struct StateChoice {
    /// Temperatures and loads: a state file (TOML) or a log (CSV with t_s, T_NAME_C, load_N …); repeatable, later files override earlier ones
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) state: Vec<PathBuf>,
    /// Time in the log, s (default: last entry)
    #[arg(long, value_name = "SECONDS", requires = "state", allow_hyphen_values = true)]
    pub(in crate::cli) time: Option<f64>,
    /// Time in the log at which the workpiece zero was set, s: drift is relative to it
    #[arg(long, value_name = "SECONDS", requires = "state", allow_hyphen_values = true)]
    pub(in crate::cli) zero_time: Option<f64>,
    /// Axis positions at which the workpiece zero was set (mm, deg): the drift at this pose counts as zero; elsewhere only the difference is corrected
    #[arg(long, value_name = "X..,Y..,Z..", allow_hyphen_values = true, requires = "state")]
    pub(in crate::cli) zero_at: Option<AxisVector>,
    /// Method by which a zero offset was set: G54=touched, probed or absolute, with the axis positions of the touch (mm, deg) and the length L of the tool or probe that touched (mm); R5: radius of the edge finder, with X+: direction of travel at the touch; @X: begins the place of one touch; repeatable
    #[arg(long, value_name = "G54=touched[@X..,Y..,Z..,L..]")]
    pub(in crate::cli) zero: Vec<StatedZero>,
    /// Weight on the table, in newtons, and its position from the center of the table, mm: 1700 or 1700@0,0,-280; overrides --state
    #[arg(long, value_name = "N[@X,Y,Z]", allow_hyphen_values = true)]
    pub(in crate::cli) load: Option<Load>,
}

/// `ncfix machine`.
#[derive(Clone, Debug, Subcommand)]
pub(in crate::cli) enum MachineCommand {
    /// Report every error in a machine file
    #[command(after_help = examples::MACHINE)]
    Check(MachineArguments),
    /// Show the machine described by a file, or with --at its errors at a pose, by source
    #[command(after_help = examples::SHOW)]
    Show(Box<ShowArguments>),
    /// List parameter sets for an error model, or show one with its values in a machine file
    #[command(after_help = examples::PRESETS)]
    Presets(PresetArguments),
    /// Write a new machine file from a template, statements and data of the control
    #[command(after_help = examples::NEW)]
    New(Box<NewMachineArguments>),
}

/// `ncfix machine new`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct NewMachineArguments {
    /// Machine file to write; the machine gets its name. - for standard output
    #[arg(value_name = "NAME.toml", required_unless_present = "list")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Template of the chain
    #[arg(long, value_name = "TEMPLATE", required_unless_present = "list")]
    pub(in crate::cli) like: Option<String>,
    /// List the templates with their chains
    #[arg(long, conflicts_with_all = ["output", "like"])]
    pub(in crate::cli) list: bool,
    /// Control: sinumerik, 840d, fanuc, haas, linuxcnc, grbl, millplus … (default: that of --from, else sinumerik)
    #[arg(long, value_name = "CONTROL")]
    pub(in crate::cli) control: Option<String>,
    /// Travel of an axis, machine coordinates, mm or degrees: X=0..600, C=modulo; repeatable
    #[arg(long, value_name = "AXIS=LOW..HIGH", allow_hyphen_values = true)]
    pub(in crate::cli) travel: Vec<StatedTravel>,
    /// Sense of an axis: C=- if the part that it carries turns against the right-hand rule, or moves against its letter, for a positive command; repeatable
    #[arg(long, value_name = "AXIS=+|-", allow_hyphen_values = true)]
    pub(in crate::cli) sense: Vec<StatedSense>,
    /// Point on a rotary axis, machine coordinates with all axes at zero, mm: C=300,-198,-440; repeatable
    #[arg(long, value_name = "AXIS=X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) pivot: Vec<StatedPivot>,
    /// Unit of --setup files that do not state it: G10 of a Fanuc, .var and tool.tbl of LinuxCNC, $# of Grbl
    #[arg(long, value_name = "UNIT", value_parser = ["mm", "inch"])]
    pub(in crate::cli) saved_unit: Option<String>,
    /// Data of the control: Sinumerik machine data, LinuxCNC INI, Grbl settings ($$); repeatable
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) from: Vec<PathBuf>,
    /// Zero offsets and tools to write into the file: data saved by the control (archive, TOA, UFR, .var, tool.tbl, G10, $#) or TOML; repeatable
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) setup: Vec<PathBuf>,
    /// Write a picture of the chain with the directions of its axes
    #[arg(long, value_name = "PICTURE.svg")]
    pub(in crate::cli) picture: Option<PathBuf>,
}

impl NewMachineArguments {
    /// The statements of the command line.
    pub(in crate::cli) fn request(&self) -> DescriptionRequest {
        let stem = self.output.as_deref().and_then(Path::file_stem).map(|stem| stem.to_string_lossy().into_owned());
        DescriptionRequest {
            name: stem.filter(|stem| stem != "-").unwrap_or_else(|| "machine".to_owned()),
            control: self.control.clone(),
            travels: self.travel.clone(),
            senses: self.sense.clone(),
            pivots: self.pivot.clone(),
            saved_unit: self.saved_unit.clone(),
            ..DescriptionRequest::default()
        }
    }
}

/// `ncfix machine presets`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct PresetArguments {
    /// Preset, such as mayer-13 (default: list all)
    #[arg(value_name = "NAME")]
    pub(in crate::cli) name: Option<String>,
    /// Machine file of a later calibration, such as with compensation: the ratio of each parameter
    #[arg(long, value_name = "M.toml", requires = "name")]
    pub(in crate::cli) after: Option<PathBuf>,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
}

/// `ncfix machine show`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct ShowArguments {
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) file: MachineArguments,
    /// Head whose spindle and errors to show (default: the head with start = true; with --at, a machine with several heads needs one)
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) head: Option<String>,
    /// Axis positions (machine coordinates, mm, deg; other axes: 0) at which to show the errors: X100,Y50,C30
    #[arg(long, value_name = "X..,Y..,Z..", allow_hyphen_values = true)]
    pub(in crate::cli) at: Option<AxisVector>,
    /// Tool length along the spindle, mm, or X,Y,Z from gauge point to tip along the axes of F, mm
    #[arg(long, value_name = "LENGTH|X,Y,Z", allow_hyphen_values = true, requires = "at")]
    pub(in crate::cli) tool: Option<ToolVector>,
    /// Direction of the last motion of axes: X+,Y- (default: no backlash)
    #[arg(long, value_name = "X+,Y-", requires = "at", allow_hyphen_values = true)]
    pub(in crate::cli) sense: Option<State>,
    #[command(flatten)]
    /// Condition of the machine.
    pub(in crate::cli) state: StateChoice,
    /// Show the source of every value: file and line, or default
    #[arg(long, conflicts_with = "at")]
    pub(in crate::cli) origin: bool,
    /// Print one JSON object on standard output, with --at or --origin
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// `ncfix machine check`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct MachineArguments {
    /// Machine file (default: NCFIX_MACHINE, else the nearest ncfix.toml in or above the working folder)
    #[arg(value_name = "M.toml")]
    pub(in crate::cli) file: Option<PathBuf>,
    /// Set-up file with zero offsets and tools: TOML, or data saved by the control; repeatable
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) setup: Vec<PathBuf>,
}
