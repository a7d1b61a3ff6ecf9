//! The arguments of `ncfix import`: those of the command, and one option for each question of an import.

use std::path::PathBuf;

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

use crate::cli::arguments::MachineChoice;
use ncfix_instruments::answers::{FileAnswers, OPTIONS};

/// End of `ncfix import --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
On a terminal, ncfix asks for what the file does not state, shows what it understood, and writes after a confirmation. In a script it asks nothing, and writes \
only if no question remains. Without -o it only shows what it understood.

An answer is for all files, or as FILE=VALUE for one of them: --at laser_X=Y200,Z100 --at laser_Y=X300,Z100. Files of a folder that are not \
instrument tables are listed, and the others are written; the exit status is then 1 if one of them may contain readings.

Examples:
  ncfix import --list
  ncfix import laser.txt --machine mill.toml
  ncfix import laser.txt --machine mill.toml --axis X --at Y200,Z100 --sign + --unit um --tool 120 --material 20C -o laser
  ncfix import readings --machine mill.toml --tool 0 --material 20C --at laser_X=Y200,Z100 --at laser_Y=X300,Z100 -o measured
  ncfix import plate.csv --machine mill.toml --at X100,Y50,Z-20 --sign + --unit mm --tool 80 --material 23.8@26 -o plate";

/// `ncfix import`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct ImportArguments {
    /// File of an instrument, - for standard input; or several files and folders: ncfix reads all instrument tables in them
    #[arg(value_name = "FILE|FOLDER", required_unless_present = "list")]
    pub(in crate::cli) files: Vec<PathBuf>,
    /// Common name of the two files to write: NAME.csv and NAME.toml; for several files or a folder the folder to write (default: only show what was understood)
    #[arg(short, long, value_name = "NAME")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Format (default: by the content)
    #[arg(long = "as", value_name = "FORMAT")]
    pub(in crate::cli) format: Option<String>,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// Answers to the questions of an import.
    pub(in crate::cli) answers: AnswerChoice,
    /// Write without asking for a confirmation
    #[arg(long)]
    pub(in crate::cli) yes: bool,
    /// Replace existing files
    #[arg(long)]
    pub(in crate::cli) force: bool,
    /// List the formats and what you must state for each
    #[arg(long)]
    pub(in crate::cli) list: bool,
}

/// Answers that were given as options.
#[derive(Clone, Debug)]
pub(in crate::cli) struct AnswerChoice(pub(in crate::cli) FileAnswers);

impl FromArgMatches for AnswerChoice {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut answers = FileAnswers::default();
        answers.all.is_flat_reference = matches.get_flag("flat-reference");
        for option in OPTIONS {
            let wrong = |sentence| {
                clap::Error::raw(clap::error::ErrorKind::ValueValidation, format!("--{}: {sentence}\n", option.name))
            };
            for text in matches.get_many::<String>(option.name).into_iter().flatten() {
                answers.set(option.name, text).map_err(wrong)?;
            }
        }
        Ok(AnswerChoice(answers))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = AnswerChoice::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for AnswerChoice {
    fn augment_args(command: Command) -> Command {
        let of = |option: &ncfix_instruments::answers::ImportOption| {
            Arg::new(option.name)
                .long(option.name)
                .value_name(option.example)
                .allow_hyphen_values(true)
                .action(clap::ArgAction::Append)
                .help(option.meaning)
        };
        let flat = Arg::new("flat-reference").long("flat-reference").action(clap::ArgAction::SetTrue);
        command.args(OPTIONS.iter().map(of)).arg(flat.help("A height map was probed on a calibrated flat"))
    }

    fn augment_args_for_update(command: Command) -> Command {
        AnswerChoice::augment_args(command)
    }
}
