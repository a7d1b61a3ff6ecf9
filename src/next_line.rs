//! The line to type after a command: the next step from the file of an instrument to a corrected part.

use std::path::{Path, PathBuf};

use crate::machine::Machine;
use crate::square::FoundSquareness;
use crate::stated_zero::StatedZero;
use ncfix_machine::describe::template;

/// After a correction without a review: the comparison would take several times as long as the correction.
const NOT_COMPARED: &str = "verdict      none yet: the output was not compared with the program; do it now:\n";
/// The same where no command can be given.
const NOT_COMPARED_BY_NAME: &str =
    "verdict      none yet: the output was not compared with the program; ncfix verify ORIGINAL CORRECTED does it\n";

/// After a correction: the row with its test, and without a verdict the row that says that nothing has compared the output.
pub(crate) fn after_correction(has_verdict: bool, test: String) -> String {
    match (has_verdict, test.is_empty()) {
        (true, _) => test,
        (false, false) => NOT_COMPARED.to_owned() + &test,
        (false, true) => NOT_COMPARED_BY_NAME.to_owned(),
    }
}

/// A row with a command.
fn row(words: &[String]) -> String {
    let quoted = |word: &String| if word.contains(' ') { format!("\"{word}\"") } else { word.clone() };
    format!("{:<13}ncfix {}\n", "next", words.iter().map(quoted).collect::<Vec<_>>().join(" "))
}

/// The words of a line; `{}` stands for the next path.
fn words(line: &str, paths: &[&Path]) -> Vec<String> {
    let mut paths = paths.iter();
    line.split(' ')
        .map(|word| match word {
            "{}" => paths.next().map_or_else(String::new, |path| path.display().to_string()),
            word => word.to_owned(),
        })
        .collect()
}

/// The file beside another one, with an addition to its name.
fn beside(path: &Path, addition: &str) -> PathBuf {
    let stem = path.file_stem().map_or_else(|| "machine".to_owned(), |stem| stem.to_string_lossy().into_owned());
    path.with_file_name(format!("{stem}_{addition}.toml"))
}

/// After `ncfix machine new`: the files of instruments; for a router, whose owner has a ruler, two diagonals.
pub(crate) fn after_new_machine(machine: &Path, like: &str) -> String {
    if template(like).is_ok_and(|template| template.is_router) {
        // Both sides and the programmed ones give the scales too; a ruler is read to half a millimeter.
        let line = "square --machine {} --d1 D1 --d2 D2 --sides A,B --nominal A,B --read-to 0.5 -o {}";
        return row(&words(line, &[machine, &beside(machine, "square")]));
    }
    row(&words("import FOLDER --machine {} -o readings", &[machine]))
}

/// After `ncfix import`: the calibration of the measurement or folder `output`.
pub(crate) fn after_import(output: &Path, machine: &Machine) -> String {
    let Some(file) = machine.files.last() else { return String::new() };
    let is_table = output.extension().is_some_and(|ending| ending == "csv") || output.is_dir();
    let data = if is_table { output.to_owned() } else { PathBuf::from(format!("{}.csv", output.display())) };
    row(&words("calibrate {} --machine {} -o {}", &[&data, file, &beside(file, "measured")]))
}

/// After a change of the machine file: the correction of a program. Without zero offsets in the file, the control has them.
pub(crate) fn after_calibration(machine: &Path, has_offsets: bool) -> String {
    if machine == Path::new("-") {
        return String::new();
    }
    let setup = if has_offsets { "" } else { " --setup OFFSETS" };
    row(&words(&format!("fix PROGRAM --machine {{}}{setup} -o CORRECTED --review review.html"), &[machine]))
}

/// After `ncfix square`: as after a calibration, with the largest correction if the default does not allow it.
pub(crate) fn after_square(output: &Path, machine: &Machine, found: &FoundSquareness) -> String {
    let line = after_calibration(output, !machine.machine.zero_offsets.is_empty());
    found
        .max_correction(machine)
        .filter(|_| !line.is_empty())
        .map_or(line.clone(), |largest| format!("{} --max-correction {largest}\n", line.trim_end()))
}

/// After a calibration whose residual is too large: the search for the errors that the calibrated file lacks.
pub(crate) fn after_poor_fit(data: &[PathBuf], calibrated: &Path) -> String {
    if calibrated == Path::new("-") {
        return String::new();
    }
    let mut all = vec!["diagnose".to_owned()];
    all.extend(data.iter().map(|path| path.display().to_string()));
    all.extend(words("--machine {} -o {}", &[calibrated, &beside(calibrated, "extended")]));
    row(&all)
}

/// Options of a correction that its test needs too.
#[derive(Clone, Copy)]
pub(crate) struct SameMachine<'a> {
    /// `--machine`.
    pub(crate) machine: Option<&'a Path>,
    /// `--head`.
    pub(crate) head: Option<&'a str>,
    /// `--dialect`.
    pub(crate) dialect: Option<&'a str>,
    /// `--setup`.
    pub(crate) setups: &'a [PathBuf],
    /// `--state`.
    pub(crate) states: &'a [PathBuf],
    /// `--zero`, as written.
    pub(crate) zeros: &'a [StatedZero],
}

/// After `ncfix fix`: the test of the corrected program on the same machine.
pub(crate) fn after_fix(original: &Path, corrected: &Path, same: SameMachine<'_>) -> String {
    if original == corrected || [original, corrected].contains(&Path::new("-")) {
        return String::new();
    }
    let mut all = words("verify {} {}", &[original, corrected]);
    let mut option = |name: &str, value: String| all.extend([name.to_owned(), value]);
    same.machine.iter().for_each(|path| option("--machine", path.display().to_string()));
    same.head.iter().for_each(|head| option("--head", (*head).to_owned()));
    same.dialect.iter().for_each(|dialect| option("--dialect", (*dialect).to_owned()));
    same.setups.iter().for_each(|path| option("--setup", path.display().to_string()));
    same.states.iter().for_each(|path| option("--state", path.display().to_string()));
    same.zeros.iter().for_each(|zero| option("--zero", zero.text().to_owned()));
    row(&all)
}
