//! The arguments of `ncfix feed`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::cli::arguments::{CorrectionChoice, MachineChoice, ProgramChoice, StateChoice};
use crate::cli::value;
use crate::feed::FeedOptions;
use ncfix_base::units::parse_length_mm;

/// What `ncfix feed --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
The whole program is executed and corrected once before the first byte goes out: whatever is wrong in it is found then, and whether the link keeps up with \
the motion. Then each line is corrected for the temperatures of the moment, frozen, written into the journal, and sent.

No line goes out unless the control says that it is idle; where a link has no such question, --i-checked-the-machine-stands-still takes its place.

Ctrl-C once sends no further line and lets the control run out; twice holds the axes where the link has a word for it. `ncfix resume` shows how a job that \
broke off can be taken up again.

Links: grbl, marlin, heidenhain-fe1, … (docs/reference/feed.md), or a profile of your own.

Examples:
  ncfix feed part.ngc --machine mill.toml --link grbl --dry-run
  ncfix feed part.ngc --machine mill.toml --link grbl --port /dev/ttyUSB0 --sensors sensors.toml
  ncfix feed part.h --machine mill.toml --link heidenhain-fe1 --port /dev/ttyS0 --rapids-only
  ncfix feed part.ngc --machine mill.toml --link linuxcnc --port tcp:192.168.1.20:5007 --json";

/// `ncfix feed`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct FeedArguments {
    /// Part program
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// Where the control is: /dev/ttyUSB0, COM3, tcp:host:port
    #[arg(long, value_name = "PORT", required_unless_present = "dry_run")]
    pub(in crate::cli) port: Option<String>,
    /// How it is spoken to: the name of a profile, or a profile file
    #[arg(long, value_name = "LINK|FILE.toml")]
    pub(in crate::cli) link: String,
    /// Sensors of temperature that are read meanwhile; without it nothing is added to the first step
    #[arg(long, value_name = "S.toml")]
    pub(in crate::cli) sensors: Option<PathBuf>,
    /// Check the program and the link, and send nothing
    #[arg(long)]
    pub(in crate::cli) dry_run: bool,
    /// Send over a link that cannot ask whether the machine stands still (tape readers, FE1): you have looked, and if it moves, lines
    /// run into what it does
    #[arg(long)]
    pub(in crate::cli) i_checked_the_machine_stands_still: bool,
    /// Send even where the control will have to wait for lines
    #[arg(long)]
    pub(in crate::cli) allow_starvation: bool,
    #[command(flatten)]
    /// How fast what temperatures ask for is applied.
    pub(in crate::cli) dosing: DosingChoice,
    /// The journal; without it IN.journal
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) journal: Option<PathBuf>,
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// The condition of the machine.
    pub(in crate::cli) state: StateChoice,
    #[command(flatten)]
    /// How the program is executed.
    pub(in crate::cli) program: ProgramChoice,
    #[command(flatten)]
    /// How it is corrected.
    pub(in crate::cli) correction: CorrectionChoice,
    /// Print events as JSON lines on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// How fast what temperatures ask for is applied.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct DosingChoice {
    /// Seconds between two looks at the temperatures
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = value::seconds)]
    pub(in crate::cli) every: Duration,
    /// The zero point of the workpiece is set in the condition in which the job begins: drift counts from there
    #[arg(long, conflicts_with = "zero_time", requires = "sensors")]
    pub(in crate::cli) zero_now: bool,
    /// What temperatures ask for changes on rapid moves only
    #[arg(long)]
    pub(in crate::cli) rapids_only: bool,
    /// The most that it changes from one block with feed to the next, with its unit; rapid moves take all of it at once
    #[arg(long, value_name = "LENGTH", default_value = "1um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) dose_per_block: f64,
    /// The most that it changes on a mm of way, with its unit
    #[arg(long, value_name = "LENGTH", default_value = "0.1um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) dose_per_mm: f64,
    /// The most that it changes in a second, with its unit
    #[arg(long, value_name = "LENGTH", default_value = "0.5um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) dose_per_s: f64,
    /// Warn where temperatures ask for more than this, with its unit
    #[arg(long, value_name = "LENGTH", default_value = "50um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) warn_shift: f64,
    /// Stop where they ask for more than this, with its unit
    #[arg(long, value_name = "LENGTH", default_value = "0.2mm", value_parser = value::positive_length_mm)]
    pub(in crate::cli) max_shift: f64,
}

impl From<&FeedArguments> for FeedOptions {
    fn from(arguments: &FeedArguments) -> FeedOptions {
        let dosing = &arguments.dosing;
        FeedOptions {
            allow_starvation: arguments.allow_starvation,
            machine_stands_still: arguments.i_checked_the_machine_stands_still,
            every: dosing.every,
            zero_now: dosing.zero_now,
            rapids_only: dosing.rapids_only,
            dose_per_block_mm: dosing.dose_per_block,
            dose_per_mm: dosing.dose_per_mm,
            dose_per_s_mm: dosing.dose_per_s,
            warn_shift_mm: dosing.warn_shift,
            max_shift_mm: dosing.max_shift,
        }
    }
}

/// What `ncfix resume --help` says last.
pub(in crate::cli) const RESUME_HELP: &str = "\
Nothing is ever taken up again by itself. An answer of the control is no proof that a line was carried out: what its planner may hold, as it stated itself, was \
not; where it stated nothing, only what it had carried out when it stood still is sure. The plan goes up to the height of --clearance, across, and down with a slow \
feed to where a retract of the program had ended, or begins at the beginning. It is refused without that height, where nothing lifts the tool to it, and where the program, \
the machine file, the state or ncfix have changed. No line goes out unless the control says that it is idle.

Examples:
  ncfix resume part.ngc.journal --clearance 25mm
  ncfix resume part.ngc.journal --clearance 25mm --confirm 5a1e00c3f2b7
  ncfix resume part.ngc.journal --clearance 25mm --port /dev/ttyUSB1 --confirm 5a1e00c3f2b7";

/// `ncfix resume`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct ResumeArguments {
    /// Journal of the job
    #[arg(value_name = "JOURNAL")]
    pub(in crate::cli) journal: PathBuf,
    /// Number of the plan that was read and is carried out
    #[arg(long, value_name = "PLAN")]
    pub(in crate::cli) confirm: Option<String>,
    /// Go up to this Z first, with its unit, in the coordinates of the program: a height that is clear of workpiece and clamps, 1 mm or
    /// more above all that is machined. Nothing is taken up again without it
    #[arg(long, value_name = "Z", value_parser = parse_length_mm, allow_hyphen_values = true)]
    pub(in crate::cli) clearance: Option<f64>,
    /// Send over a link that cannot ask whether the machine stands still (tape readers, FE1): you have looked, and if it moves, lines
    /// run into what it does
    #[arg(long)]
    pub(in crate::cli) i_checked_the_machine_stands_still: bool,
    /// Where the control is now, if elsewhere
    #[arg(long, value_name = "PORT")]
    pub(in crate::cli) port: Option<String>,
    /// Print the plan as one JSON object
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
