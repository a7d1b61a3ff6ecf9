//! The arguments of `ncfix feed`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::cli::arguments::{CorrectionChoice, MachineChoice, ProgramChoice, StateChoice};
use crate::cli::value;
use crate::feed::FeedOptions;
use ncfix_base::units::parse_length_mm;

/// End of `ncfix feed --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
Before the first byte, ncfix executes and corrects the whole program once. It finds errors in the program, and a link that is too slow for the motion. \
Then it corrects each line for the current temperatures, writes it to the journal, and sends it. A sent line no longer changes.

ncfix sends nothing unless the control reports that it is idle. Links without such a report need --i-checked-the-machine-stands-still.

Ctrl-C once stops sending and lets the control finish its lines; twice also holds the axes if the link has a command for it. `ncfix resume` shows how to \
resume an interrupted job. The link lsv2 sends one file, which a person starts at the control.

Links: grbl, marlin, heidenhain-fe1, lsv2 … (docs/reference/feed.md), or your own profile.

Examples:
  ncfix feed part.ngc --machine mill.toml --link grbl --dry-run
  ncfix feed part.ngc --machine mill.toml --link grbl --port /dev/ttyUSB0 --sensors sensors.toml
  ncfix feed part.pm --machine mill.toml --link heidenhain-fe1 --port /dev/ttyS0 --rapids-only
  ncfix feed part.ngc --machine mill.toml --link linuxcnc --port tcp:192.168.1.20:5007 --json
  ncfix feed part.pm --machine mill.toml --link lsv2 --port tcp:192.168.1.30:19000 --to 'TNC:\\PART.PM'";

/// `ncfix feed`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct FeedArguments {
    /// Part program
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// Port of the control: /dev/ttyUSB0, COM3, tcp:host:port
    #[arg(long, value_name = "PORT", required_unless_present = "dry_run")]
    pub(in crate::cli) port: Option<String>,
    /// Protocol of the control: name of a profile, or profile file
    #[arg(long, value_name = "LINK|FILE.toml")]
    pub(in crate::cli) link: String,
    /// Path of the file on the control, for links that send a file (lsv2), such as TNC:\PART.PM
    #[arg(long, value_name = "PATH")]
    pub(in crate::cli) to: Option<String>,
    /// Live temperature sensors to read during the transfer (default: no thermal correction)
    #[arg(long, value_name = "S.toml")]
    pub(in crate::cli) sensors: Option<PathBuf>,
    /// Check the program and the link, and ask each sensor once; send nothing
    #[arg(long)]
    pub(in crate::cli) dry_run: bool,
    /// Confirm that the machine stands still, for links on which ncfix cannot ask the control (RS-232 without answers, FE1); lines that are sent to a moving machine interfere with its motion
    #[arg(long)]
    pub(in crate::cli) i_checked_the_machine_stands_still: bool,
    /// Send even if the control will have to wait for lines
    #[arg(long)]
    pub(in crate::cli) allow_starvation: bool,
    #[command(flatten)]
    /// Rate limits of the thermal correction.
    pub(in crate::cli) dosing: DosingChoice,
    /// Journal file (default: IN.journal)
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) journal: Option<PathBuf>,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// Condition of the machine.
    pub(in crate::cli) state: StateChoice,
    #[command(flatten)]
    /// Reading and execution of the program.
    pub(in crate::cli) program: ProgramChoice,
    #[command(flatten)]
    /// Method of correction.
    pub(in crate::cli) correction: CorrectionChoice,
    /// Print events as JSON lines on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// Rate limits of the thermal correction.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct DosingChoice {
    /// Interval between readings of the temperatures, s
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = value::seconds)]
    pub(in crate::cli) every: Duration,
    /// Take the start of the job as the time when the workpiece zero was set: drift is relative to it; needs --sensors
    #[arg(long, conflicts_with = "zero_time", requires = "sensors")]
    pub(in crate::cli) zero_now: bool,
    /// Change the thermal correction only on rapid moves
    #[arg(long)]
    pub(in crate::cli) rapids_only: bool,
    /// Largest change of the thermal correction per feed block, with unit; a rapid move applies the whole remaining change
    #[arg(long, value_name = "LENGTH", default_value = "1um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) dose_per_block: f64,
    /// Largest change of the thermal correction per mm of path, with unit
    #[arg(long, value_name = "LENGTH", default_value = "0.1um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) dose_per_mm: f64,
    /// Largest change of the thermal correction per second, with unit
    #[arg(long, value_name = "LENGTH", default_value = "0.5um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) dose_per_s: f64,
    /// Warn if the thermal correction required exceeds this, with unit
    #[arg(long, value_name = "LENGTH", default_value = "50um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) warn_shift: f64,
    /// Stop if the thermal correction required exceeds this, with unit
    #[arg(long, value_name = "LENGTH", default_value = "0.2mm", value_parser = value::positive_length_mm)]
    pub(in crate::cli) max_shift: f64,
}

impl From<&FeedArguments> for FeedOptions {
    fn from(arguments: &FeedArguments) -> FeedOptions {
        let dosing = &arguments.dosing;
        FeedOptions {
            allow_starvation: arguments.allow_starvation,
            control_file: arguments.to.clone(),
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

/// End of `ncfix resume --help`.
pub(in crate::cli) const RESUME_HELP: &str = "\
ncfix never resumes a job automatically. An answer of the control does not prove that it executed the line: lines that may still be in the planner, by \
the size that the control reported, count as not executed. Without such a report, only lines executed when the machine last stood still are certain. \
The plan moves up to the height of --clearance, across, and down at a slow feed to the end of a retract of the program, or starts at the beginning. \
ncfix refuses it without that height, if no move lifts the tool to it, and if the program, the machine file, the state or ncfix has changed. It sends \
nothing unless the control reports that it is idle; a link without such a report also needs --i-checked-the-machine-stands-still.

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
    /// Number of the plan to run, as shown before
    #[arg(long, value_name = "PLAN")]
    pub(in crate::cli) confirm: Option<String>,
    /// Z of the program to which the tool moves first, with unit: clear of workpiece and clamps, at least 1 mm above everything machined; required to
    /// resume
    #[arg(long, value_name = "Z", value_parser = parse_length_mm, allow_hyphen_values = true)]
    pub(in crate::cli) clearance: Option<f64>,
    /// Confirm that the machine stands still, for links on which ncfix cannot ask the control (RS-232 without answers, FE1); lines that are sent to a moving machine interfere with its motion
    #[arg(long)]
    pub(in crate::cli) i_checked_the_machine_stands_still: bool,
    /// Port of the control, if it has changed
    #[arg(long, value_name = "PORT")]
    pub(in crate::cli) port: Option<String>,
    /// Print the plan as one JSON object
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
