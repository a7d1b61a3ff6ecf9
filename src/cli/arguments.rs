//! The command line: commands, options and their help.

pub(super) mod examples;
mod groups;
mod help;
mod page;
mod switches;
mod work;

pub(super) use super::calibrate::arguments::CalibrateArguments;
pub(super) use super::decompose::arguments::DecomposeArguments;
pub(super) use super::diagnose::arguments::DiagnoseArguments;
pub(super) use super::diff::arguments::DiffArguments;
pub(super) use super::feed::arguments::{FeedArguments, ResumeArguments};
pub(super) use super::figures::arguments::FiguresArguments;
pub(super) use super::fix::arguments::{CompensationChoice, CorrectionChoice, PoseRotaryChoice, RotaryChoice};
pub(super) use super::import::arguments::ImportArguments;
pub(super) use super::load::arguments::LoadArguments;
pub(super) use super::machine::arguments::{
    MachineArguments, MachineCommand, NewMachineArguments, PresetArguments, ShowArguments, StateChoice,
};
pub(super) use super::measured::arguments::MeasuredArguments;
pub(super) use super::plan::arguments::PlanArguments;
pub(super) use super::realtime::arguments::RealtimeArguments;
pub(super) use super::sensors::arguments::SensorsArguments;
pub(super) use super::simulate::arguments::SimulateArguments;
pub(super) use super::square::arguments::SquareArguments;
pub(super) use super::steps::arguments::StepsArguments;
pub(super) use super::tables::arguments::TablesArguments;
pub(super) use super::verify::arguments::VerifyArguments;
pub(super) use groups::{overview, renamed};
pub(super) use help::{CompletionsArguments, EXAMPLES, ManArguments, STATUSES};
pub(super) use page::PageChoice;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::builder::NonEmptyStringValueParser;
use clap::error::{ContextKind, ErrorKind};
use clap::{ArgGroup, Args, FromArgMatches as _, Subcommand};

use super::verbosity::Verbosity;
use super::{
    calibrate, decompose, diagnose, diff, feed, figures, import, load, measured, plan, realtime, sensors, simulate,
    square, steps, tables, value,
};
use crate::options::{Compensation, Options};
use ncfix_base::geometry::AxisVector;
use ncfix_machine::machine::file::nearest;

const AFTER_HELP: &str = "\
Machine file: --machine, else the environment variable NCFIX_MACHINE, else the nearest ncfix.toml in or above the folder of the program, else in or \
above the working folder, else an embedded demo machine (with a warning, also in the output). `ncfix machine show --origin` shows which one is used.

Examples:
  ncfix part.mpf -o part_corrected.mpf --machine mill.toml
  ncfix part.mpf -o - --machine mill.toml | less
  ncfix part.mpf -o part_corrected.mpf --review review.html
  ncfix part.mpf -o part_corrected.mpf --machine mill.toml --feed-limit 15um
  ncfix check part.mpf
  ncfix snc part.mpf | head
  ncfix verify part.mpf part_corrected.mpf --machine mill.toml
  ncfix verify part.mpf part_corrected.mpf --machine mill.toml --at-feed
  ncfix part.mpf -o out.mpf --machine mill.toml --state warm.toml --load 1700
  ncfix machine show mill.toml --at X100,Y50,Z-20 --tool 120
  ncfix explain E0203";

/// Long description at the top of `ncfix --help`.
const ABOUT: &str = "\
Corrects part programs for the measured geometric errors of one machine tool.

Reads a part program, shifts the programmed positions of cuts so that the tool of this machine, despite its errors, reaches the \
programmed point, and writes the program in the same language. To execute a program means to work through it on the computer: nothing moves.";

/// Definition of the command line: the commands, and the arguments of `fix`, whose name may be omitted.
pub(super) fn definition() -> clap::Command {
    let command = clap::Command::new("ncfix").bin_name("ncfix").version(env!("CARGO_PKG_VERSION"));
    let command = FixArguments::augment_args(Command::augment_subcommands(command))
        .about("Corrects part programs for the measured geometric errors of one machine tool")
        .long_about(ABOUT)
        .after_help(AFTER_HELP)
        .args_conflicts_with_subcommands(true)
        .subcommand_negates_reqs(true)
        .arg_required_else_help(true);
    groups::in_groups(help::with_statuses(switches::add(command)))
}

/// Reads a command line whose first argument is the name of the program.
pub(super) fn parse<I>(arguments: I) -> Result<(Verbosity, Command), clap::Error>
where
    I: IntoIterator,
    I::Item: Into<OsString> + Clone,
{
    let definition = definition();
    let words = switches::moved_behind(arguments.into_iter().map(Into::into).collect(), &definition);
    let first = words.get(1).map(|word| word.to_string_lossy().into_owned()).unwrap_or_default();
    let matches = definition.try_get_matches_from(words).map_err(|error| explained(error, &first))?;
    let command = if matches.subcommand_name().is_some() {
        Command::from_arg_matches(&matches)
    } else {
        FixArguments::from_arg_matches(&matches).map(Command::Fix)
    };
    Ok((switches::verbosity(&matches), command?))
}

/// Replaces the message of clap for a word in the place of a command, which clap takes for the program of the default
/// command: it reports a conflict with the next words, or a missing output.
fn explained(error: clap::Error, first: &str) -> clap::Error {
    let is_word = first.starts_with(char::is_alphanumeric) && !first.contains(['.', '/', '\\']);
    let is_unknown = is_word && definition().find_subcommand(first).is_none() && !PathBuf::from(first).exists();
    let is_alone = error.kind() == ErrorKind::MissingRequiredArgument && is_unknown;
    let has_command = error.get(ContextKind::InvalidSubcommand).is_some();
    if !(is_alone || has_command && error.kind() == ErrorKind::ArgumentConflict) {
        return error;
    }
    let commands: Vec<String> = definition().get_subcommands().map(|command| command.get_name().to_owned()).collect();
    let meant = nearest(first, commands.iter().map(String::as_str));
    let message = format!(
        "`{first}` is not a command; a command comes first, and without one only one file can be given; {}commands: {}",
        meant.map_or_else(String::new, |meant| format!("did you mean `ncfix {meant}`? ")),
        commands.join(", ")
    );
    definition().error(ErrorKind::InvalidSubcommand, message)
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Correct a program for the errors of the machine (the default command)
    #[command(after_help = AFTER_HELP)]
    Fix(FixArguments),
    /// Execute and correct a program on the computer, without writing it; report what is wrong
    #[command(after_help = examples::CHECK)]
    Check(CheckArguments),
    /// Print the moves of a program (SNC)
    #[command(after_help = examples::SNC)]
    Snc(SncArguments),
    /// Compare the errors of two programs on the error model
    #[command(after_help = examples::VERIFY)]
    Verify(VerifyArguments),
    /// Show what a correction changed
    #[command(after_help = diff::arguments::AFTER_HELP)]
    Diff(Box<DiffArguments>),
    /// Subtract corrections from positions read on the machine
    #[command(name = "correct-readings", alias = "measured", after_help = measured::arguments::AFTER_HELP)]
    Measured(MeasuredArguments),
    /// Find the largest fixed step that keeps a tolerance
    #[command(name = "max-step", alias = "steps", after_help = steps::arguments::AFTER_HELP)]
    Steps(StepsArguments),
    /// Weigh the workpiece and find its position, from strain readings
    #[command(name = "weigh", alias = "load", after_help = load::arguments::AFTER_HELP)]
    Load(LoadArguments),
    /// Find what the error model gets wrong, and why
    #[command(after_help = diagnose::arguments::AFTER_HELP)]
    Diagnose(DiagnoseArguments),
    /// Split the errors at speed into their causes
    #[command(after_help = decompose::arguments::AFTER_HELP)]
    Decompose(DecomposeArguments),
    /// Select the temperature sensors that predict the drift
    #[command(after_help = sensors::arguments::AFTER_HELP)]
    Sensors(SensorsArguments),
    /// Find the squareness of two axes from two diagonals or a dial gauge
    #[command(after_help = square::arguments::AFTER_HELP)]
    Square(Box<SquareArguments>),
    /// Send a program line by line, corrected for temperature
    #[command(after_help = feed::arguments::AFTER_HELP)]
    Feed(Box<FeedArguments>),
    /// Compute corrections for set-points in real time
    #[command(after_help = realtime::arguments::AFTER_HELP)]
    Realtime(Box<RealtimeArguments>),
    /// Resume a transfer that was interrupted
    #[command(after_help = feed::arguments::RESUME_HELP)]
    Resume(ResumeArguments),
    /// Plan a measurement and write its program
    #[command(after_help = plan::arguments::after_help())]
    Plan(Box<PlanArguments>),
    /// Turn the file of an instrument into a measurement
    #[command(after_help = import::arguments::AFTER_HELP)]
    Import(Box<ImportArguments>),
    /// Fit the error model to measured data
    #[command(after_help = calibrate::arguments::AFTER_HELP)]
    Calibrate(CalibrateArguments),
    /// Simulate the readings of instruments
    #[command(after_help = simulate::arguments::AFTER_HELP)]
    Simulate(SimulateArguments),
    /// Compute the parameters of ISO 230-2 and 230-4 from measured data
    #[command(name = "iso230", alias = "figures", after_help = figures::arguments::AFTER_HELP)]
    Figures(FiguresArguments),
    /// Make, check and read compensation tables
    #[command(after_help = tables::arguments::AFTER_HELP)]
    Tables(Box<TablesArguments>),
    /// Check, show or write a machine file
    #[command(subcommand, after_help = examples::MACHINE)]
    Machine(MachineCommand),
    /// Explain a diagnostic code such as E0203, or find answers by words
    #[command(after_help = examples::EXPLAIN)]
    Explain(ExplainArguments),
    /// Print the completion script of a shell
    #[command(after_help = examples::COMPLETIONS)]
    Completions(CompletionsArguments),
    /// Print a manual page, or write all of them
    #[command(after_help = examples::MAN)]
    Man(ManArguments),
}

/// Machine file and set-up files.
#[derive(Clone, Debug, Default, Args)]
pub(super) struct MachineChoice {
    /// Machine file (default: NCFIX_MACHINE, else the nearest ncfix.toml in or above the folder of the input file, else in or above the working
    /// folder)
    #[arg(short, long, value_name = "M.toml")]
    pub(super) machine: Option<PathBuf>,
    /// Zero offsets and tools that override the machine file: TOML, or data of the control (archive, TOA, UFR, RPA, GUD, INI, .var, tool.tbl, G10, $#, TOOL.T); repeatable, the last one wins
    #[arg(long, value_name = "FILE")]
    pub(super) setup: Vec<PathBuf>,
    /// Head that is active at the start of the program (default: the head with start = true)
    #[arg(long, value_name = "NAME")]
    pub(super) head: Option<String>,
}

/// Reading and execution of a program.
#[derive(Clone, Debug, Args)]
pub(super) struct ProgramChoice {
    /// Dialect: sinumerik, grundig, fanuc or rs274 (default: by the machine file, else file name and content)
    #[arg(long, value_name = "DIALECT", value_parser = NonEmptyStringValueParser::new())]
    pub(super) dialect: Option<String>,
    /// Largest number of executed blocks (default: 2 million, or 20 times the number in the program, if that is more)
    #[arg(long, value_name = "N")]
    pub(super) max_blocks: Option<u64>,
    /// Blocks to skip, as set at the control: 0 skips blocks with /, 0,3 also those with /3, all skips every level (default: none is skipped)
    #[arg(long, value_name = "LEVELS", value_parser = value::skip_levels)]
    pub(super) skip: Option<value::SkipLevels>,
    /// Axis positions before the first block, for programs that begin with an incremental move or an arc (machine coordinates, mm, deg; other axes:
    /// 0)
    #[arg(long, value_name = "X0,Y0,Z0", allow_hyphen_values = true)]
    pub(super) start: Option<AxisVector>,
}

/// `ncfix fix`.
#[derive(Clone, Debug, Args)]
#[command(group(ArgGroup::new("target").args(["output", "in_place", "zero_shift"]).required(true)))]
pub(super) struct FixArguments {
    /// Part program; - for standard input
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// Corrected program; - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub(super) output: Option<PathBuf>,
    /// Instead of a program, write zero offsets that cancel the drift of --state; only possible if the drift is the same wherever the program
    /// cuts. FILE gets $P_UIFR or G10 L2 lines, or with --setup FILE.var a copy of that file with the new values
    #[arg(long, value_name = "FILE")]
    pub(super) zero_shift: Option<PathBuf>,
    /// Overwrite IN and keep the original as IN.bak (or IN.bak1 … if that exists)
    #[arg(long)]
    pub(super) in_place: bool,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(super) machine: MachineChoice,
    #[command(flatten)]
    /// Condition of the machine.
    pub(super) state: StateChoice,
    #[command(flatten)]
    /// Reading and execution of the program.
    pub(super) program: ProgramChoice,
    #[command(flatten)]
    /// Method of correction.
    pub(super) correction: CorrectionChoice,
    /// Radius compensation in the output
    #[arg(long, value_enum, default_value_t)]
    pub(super) compensation: CompensationChoice,
    /// Largest wear, positive or negative, that the control must be able to follow with --compensation wear, with unit
    #[arg(long, value_name = "LENGTH", default_value = "0.2mm", value_parser = value::positive_length_mm)]
    pub(super) largest_wear: f64,
    /// Lower feeds to keep the tool within this distance of its path, with unit (servo model: docs/reference/servo.md)
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(super) feed_limit: Option<f64>,
    /// Write an HTML page that shows all changes, for review before the program runs (the page of `ncfix diff --html`)
    #[arg(long, value_name = "PAGE.html")]
    pub(super) review: Option<PathBuf>,
    /// Refuse the program if its positions, tools, temperatures or load are beyond the measured ranges of the machine file
    #[arg(long)]
    pub(super) require_coverage: bool,
    /// Write out drilling cycles as single moves. Default: holes stay cycles, with corrected position and depth
    #[arg(long)]
    pub(super) expand_cycles: bool,
    /// Begin the output with a check by the control, which stops if a zero offset or tool length differs from those used here (not Grbl, Grundig)
    #[arg(long)]
    pub(super) guard: bool,
    /// Write runs of subprograms and further passes of loops as subprograms, the same ones once. =FIRST: number of the first one
    #[arg(long, value_name = "FIRST", num_args = 0..=1, require_equals = true, default_missing_value = "0", conflicts_with_all = ["in_place", "review", "zero_shift"])]
    pub(super) subprograms: Option<u32>,
    /// Largest output, in blocks per block of the program, such as 20x; a longer one is refused
    #[arg(long, value_name = "FACTOR", value_parser = ncfix_base::number::factor)]
    pub(super) max_growth: Option<f64>,
    /// Number of threads, 1 to 3 (default: automatic); the output does not depend on it
    #[arg(long, value_name = "N", value_parser = value::threads)]
    pub(super) threads: Option<usize>,
    /// Print the report as one JSON object on standard output
    #[arg(long)]
    pub(super) json: bool,
}

impl FixArguments {
    /// Options of the correction.
    pub(super) fn options(&self) -> Options {
        Options {
            compensation: match self.compensation {
                CompensationChoice::Center => Compensation::Center,
                CompensationChoice::Wear => Compensation::Wear(self.largest_wear),
            },
            feed_limit_mm: self.feed_limit,
            threads: self.threads,
            require_coverage: self.require_coverage,
            keeps_cycles: !self.expand_cycles,
            guard: self.guard,
            max_growth: self.max_growth,
            ..self.correction.options()
        }
    }
}

/// `ncfix check`.
#[derive(Clone, Debug, Args)]
pub(super) struct CheckArguments {
    /// Part program; - for standard input
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// Parse only; needs no machine
    #[arg(long, alias = "syntax")]
    pub(super) syntax_only: bool,
    #[command(flatten)]
    pub(super) machine: MachineChoice,
    #[command(flatten)]
    pub(super) state: StateChoice,
    #[command(flatten)]
    pub(super) program: ProgramChoice,
    #[command(flatten)]
    pub(super) correction: CorrectionChoice,
    /// Refuse the program if its positions, tools, temperatures or load are beyond the measured ranges of the machine file
    #[arg(long)]
    pub(super) require_coverage: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(super) json: bool,
}

/// `ncfix snc`.
#[derive(Clone, Debug, Args)]
pub(super) struct SncArguments {
    /// Part program; - for standard input
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// File to write (default: standard output)
    #[arg(short, long, value_name = "OUT")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) machine: MachineChoice,
    #[command(flatten)]
    pub(super) program: ProgramChoice,
}

/// `ncfix explain`.
#[derive(Clone, Debug, Args)]
pub(super) struct ExplainArguments {
    /// Diagnostic code, such as E0203, G or M code, or words to search for (default: list all diagnostic codes)
    #[arg(value_name = "CODE|WORDS")]
    pub(super) words: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_switches_of_all_commands_stand_before_and_behind_the_command() {
        for (line, expected) in [
            ("ncfix check a.mpf", Verbosity::Usual),
            ("ncfix -q check a.mpf", Verbosity::Quiet),
            ("ncfix check -q a.mpf", Verbosity::Quiet),
            ("ncfix check a.mpf --quiet", Verbosity::Quiet),
            ("ncfix --verbose machine show a.toml", Verbosity::Verbose),
            ("ncfix machine -v show a.toml", Verbosity::Verbose),
            ("ncfix machine show a.toml -v", Verbosity::Verbose),
            ("ncfix -v a.mpf -o b.mpf", Verbosity::Verbose),
            ("ncfix a.mpf -o b.mpf -q", Verbosity::Quiet),
        ] {
            assert_eq!(parse(line.split(' ')).unwrap().0, expected, "{line}");
        }
    }
}
