//! Files of instruments as measurements: reads one, and gives the two files that `calibrate` and `diagnose` take.

use std::path::{Path, PathBuf};

use crate::diagnostics::Diagnostics;
use crate::disk::atomic_writes::AtomicWrites;
use crate::disk::files;
use crate::disk::output::{Target, protect};
use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::FileId;
use ncfix_instruments::answers::{FileAnswers, ImportAnswers};
use ncfix_instruments::preview::preview;
use ncfix_instruments::readings::{ImportedKind, ImportedReadings};
use ncfix_instruments::text::DecodedText;
use ncfix_instruments::{ImportOutcome, import};

/// Decoded file of an instrument.
struct InstrumentFile {
    text: DecodedText,
    name: String,
    /// True if it is one of several: its questions then need its name.
    several: bool,
    /// True if it was found in a folder: nobody said that it has readings.
    of_folder: bool,
}

/// A file of a folder that was not read.
struct UnreadFile {
    path: PathBuf,
    reason: String,
}

/// Endings of files in a folder that have no readings: documents, pictures, programs and files of ncfix.
const WITHOUT_READINGS: [&str; 31] = [
    "pdf", "png", "jpg", "jpeg", "gif", "bmp", "svg", "doc", "docx", "odt", "ppt", "pptx", "md", "html", "htm", "zip",
    "toml", "json", "ini", "arc", "mpf", "spf", "nc", "ngc", "var", "tbl", "pm", "mm", "tap", "eia", "cnc",
];

impl UnreadFile {
    /// True if its ending does not exclude readings.
    fn may_have_readings(&self) -> bool {
        may_have_readings(&self.path)
    }
}

/// True if the ending of a file does not exclude readings.
fn may_have_readings(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    !ending.is_some_and(|ending| WITHOUT_READINGS.contains(&ending.as_str()))
}

impl InstrumentFile {
    /// Reads and decodes a file; otherwise the reason why it is not text.
    ///
    /// # Errors
    /// If it cannot be read.
    fn read(path: &Path) -> Result<Result<InstrumentFile, Box<Diagnostic>>, Error> {
        let source = files::read(path, FileId(0), "file of an instrument")?;
        let name =
            path.file_name().map_or_else(|| source.name().to_owned(), |name| name.to_string_lossy().into_owned());
        let text = DecodedText::decode(source.name(), source.bytes().to_vec());
        Ok(text.map(|text| InstrumentFile { text, name, several: false, of_folder: false }))
    }

    /// Reads the readings; `None` if the file is refused.
    fn readings(
        &self,
        format: Option<&str>,
        answers: &ImportAnswers,
        machine: &Machine,
        findings: &mut Diagnostics,
    ) -> Option<ImportOutcome> {
        match import(&self.text, format, answers, &machine.machine, &machine.registry().instrument_formats) {
            Ok(mut outcome) => {
                let before = if self.several { format!("{}: ", self.name) } else { String::new() };
                match &mut outcome {
                    ImportOutcome::Readings(readings) => {
                        for warning in [readings.warning(), readings.length_warning()].into_iter().flatten() {
                            findings.add(Diagnostic { message: before.clone() + &warning.message, ..warning }, &[]);
                        }
                    }
                    ImportOutcome::Questions(questions) => {
                        questions.iter_mut().for_each(|question| question.sentence.insert_str(0, &before));
                    }
                }
                Some(outcome)
            }
            Err(diagnostic) => {
                findings.add(*diagnostic, std::slice::from_ref(self.text.source()));
                None
            }
        }
    }

    /// Asks for a machine file, which no file of an instrument contains, and for all else that is open: the questions come in one round. `demo` stands in
    /// for the machine.
    fn ask_without_machine(
        &self,
        format: Option<&str>,
        answers: &ImportAnswers,
        demo: &Machine,
        findings: &mut Diagnostics,
    ) {
        let message = "no machine file was found, and the readings depend on the axes and their order";
        findings.add(Diagnostic::nowhere(Code::IMPORT_QUESTION, message, "give --machine M.toml"), &[]);
        let outcome = import(&self.text, format, answers, &demo.machine, &demo.registry().instrument_formats);
        let Ok(ImportOutcome::Questions(questions)) = outcome else { return };
        for mut question in questions {
            if question.option == "at" {
                // Which axes these are, only the machine file says.
                question.sentence = "the file does not state the positions of the other axes, or of its zero".into();
                question.advice = "machine coordinates, such as Y200,Z100".into();
            }
            findings.add(question.refusal(), &[]);
        }
    }
}

/// A question to a person, who may have no answer.
pub(crate) type QuestionToPerson<'a, E> = &'a mut dyn FnMut(&str) -> Result<Option<String>, E>;

/// Files of one command: all that have readings are written, or none.
pub(crate) struct InstrumentFiles {
    files: Vec<InstrumentFile>,
    /// Files of folders that are no tables of an instrument.
    unread: Vec<UnreadFile>,
    /// Paths of all files.
    paths: Vec<PathBuf>,
    /// Sentences about options that have no effect on a file.
    idle: String,
}

impl InstrumentFiles {
    /// Reads and decodes the files, and all files of folders; `None` if a named one is not text.
    ///
    /// # Errors
    /// If one cannot be read, or standard input is one of several.
    pub(crate) fn read(paths: &[PathBuf], findings: &mut Diagnostics) -> Result<Option<InstrumentFiles>, Error> {
        if paths.len() > 1 && paths.iter().any(|path| files::is_standard_stream(path)) {
            return Err(Error::usage("- for standard input is the only file of a command".into()));
        }
        let several = paths.len() > 1 || paths.iter().any(|path| path.is_dir());
        let mut all = InstrumentFiles { files: Vec::new(), unread: Vec::new(), paths: Vec::new(), idle: String::new() };
        let mut is_sound = true;
        for path in paths {
            let of_folder = path.is_dir();
            for path in if of_folder { in_folder(path)? } else { vec![path.clone()] } {
                match InstrumentFile::read(&path)? {
                    _ if of_folder && is_measurement(&path) => {
                        let reason = "it is a measurement already".to_owned();
                        // Once for the two files; the name of the description does not count as one with readings.
                        if path.extension().is_some_and(|ending| ending == "toml") {
                            all.unread.push(UnreadFile { path: path.clone(), reason });
                        }
                    }
                    Ok(file) => all.files.push(InstrumentFile { several, of_folder, ..file }),
                    Err(found) if of_folder => {
                        all.unread.push(UnreadFile { path: path.clone(), reason: found.message });
                    }
                    Err(found) => {
                        findings.add(*found, &[]);
                        is_sound = false;
                    }
                }
                all.paths.push(path);
            }
        }
        Ok(is_sound.then_some(all))
    }

    /// Sets files of folders aside whose text has no layout of an instrument.
    ///
    /// # Errors
    /// If no file is left, or an answer is for none of them.
    fn sort_out(&mut self, format: Option<&str>, stated: &FileAnswers, machine: &Machine) -> Result<(), Error> {
        let formats = &machine.registry().instrument_formats;
        let reason = |file: &InstrumentFile| {
            let found = import(&file.text, format, &stated.of(&file.name), &machine.machine, formats);
            // A program or a document can look like the beginning of a table.
            let is_other = !may_have_readings(Path::new(&file.name));
            let is_none = |found: &Diagnostic| file.of_folder && (is_other || found.code == Code::IMPORT_FORMAT);
            found.err().filter(|found| is_none(found)).map(|found| found.message)
        };
        for file in std::mem::take(&mut self.files) {
            match reason(&file) {
                Some(reason) => self.unread.push(UnreadFile { path: PathBuf::from(file.text.source().name()), reason }),
                None => self.files.push(file),
            }
        }
        if self.files.is_empty() {
            return Err(Error::usage(format!("there is no file of an instrument; {}", self.unread_files().trim_end())));
        }
        let names = self.files.iter().map(|file| file.name.as_str());
        match stated.stranger(names) {
            Some(file) => Err(Error::usage(format!("an answer is for {file}, and no file that is read has this name"))),
            None => Ok(()),
        }
    }

    /// The sentences about options without an effect, and about files of folders that were not read; empty without any.
    pub(crate) fn unread_files(&self) -> String {
        let line = |one: &UnreadFile| format!("not read: {}: {}\n", one.path.display(), one.reason);
        self.idle.clone() + &self.unread.iter().map(line).collect::<String>()
    }

    /// True if a file that was not read may have readings.
    pub(crate) fn is_partial(&self) -> bool {
        self.unread.iter().any(UnreadFile::may_have_readings)
    }

    /// Paths of all files.
    pub(crate) fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// The readings of all files, after the questions that they leave open; `None` if a file is refused. Without `ask`, nobody can answer.
    ///
    /// # Errors
    /// Errors of `ask`, and if no file is one of an instrument.
    pub(crate) fn understood<E: From<Error>>(
        &mut self,
        (format, stated): (Option<&str>, &FileAnswers),
        machine: &Machine,
        mut ask: Option<QuestionToPerson<'_, E>>,
        findings: &mut Diagnostics,
    ) -> Result<Option<Vec<ImportedReadings>>, E> {
        self.sort_out(format, stated, machine)?;
        let mut all = Vec::new();
        for file in self.iter() {
            let mut answers = stated.of(&file.name);
            let mut wrong = String::new();
            loop {
                let questions = match file.readings(format, &answers, machine, findings) {
                    None => break,
                    Some(ImportOutcome::Readings(readings)) => {
                        all.push(*readings);
                        break;
                    }
                    Some(ImportOutcome::Questions(questions)) => questions,
                };
                let Some(ask) = &mut ask else {
                    questions.iter().for_each(|question| findings.add(question.refusal(), &[]));
                    break;
                };
                for question in questions {
                    let text = format!("{wrong}{} ({})", question.sentence, question.advice);
                    wrong.clear();
                    let Some(text) = ask(&text)? else {
                        findings.add(question.refusal(), &[]);
                        return Ok(None);
                    };
                    if question.option == "flat-reference" {
                        answers.is_flat_reference = is_yes(&text);
                    } else if let Err(sentence) = answers.set(question.option, &text) {
                        wrong = format!("{sentence}\n");
                    }
                }
            }
        }
        if all.len() != self.files.len() {
            return Ok(None);
        }
        Ok(self.take_idle(&all, stated, findings).then_some(all))
    }

    /// Takes the options that have no effect on a file: a sentence for each file; false after a refusal, if an option has no effect on any file, or was given
    /// for this file alone.
    fn take_idle(&mut self, all: &[ImportedReadings], stated: &FileAnswers, findings: &mut Diagnostics) -> bool {
        let mut refused: Vec<&str> = Vec::new();
        let mut is_shifted = false;
        for (file, readings) in self.files.iter().zip(all) {
            if let Some(finding) = self.shifted(file, readings, stated) {
                findings.add(finding, &[]);
                is_shifted = true;
            }
            for option in &readings.unused {
                let name = option.trim_start_matches('-').split(' ').next().unwrap_or_default();
                let is_idle = |other: &ImportedReadings| other.unused.contains(option);
                if !all.iter().all(is_idle) && !stated.is_own(&file.name, name) {
                    self.idle += &format!("{}: {option} has no effect on these readings\n", file.name);
                } else if !refused.contains(&option.as_str()) {
                    refused.push(option);
                    let what = if self.files.len() > 1 && !stated.is_own(&file.name, name) {
                        "these files"
                    } else {
                        file.name.as_str()
                    };
                    let message = format!("{option} has no effect on the readings of {what}");
                    findings.add(Diagnostic::nowhere(Code::IMPORT_CONTRADICTION, message, idle_help(name)), &[]);
                }
            }
        }
        refused.is_empty() && !is_shifted
    }

    /// The refusal of a position in the common `--at` of several files that would shift the targets of one of them: the axis moved in this file.
    fn shifted(&self, file: &InstrumentFile, readings: &ImportedReadings, stated: &FileAnswers) -> Option<Diagnostic> {
        if self.files.len() < 2 || readings.kind != ImportedKind::Direct || stated.is_own(&file.name, "at") {
            return None;
        }
        let moved = readings.axes.first()?;
        let answers = stated.of(&file.name);
        let (_, value) = answers.at.iter().find(|(axis, value)| axis == moved && *value != 0.0)?;
        let message =
            format!("{moved} moved in {}, so {moved}{value} of --at would shift its targets by {value}", file.name);
        let stem = file.name.rsplit_once('.').map_or(file.name.as_str(), |(stem, _)| stem);
        let help = format!(
            "give the positions of the axes that stood still for this file alone: --at {stem}=…; with {moved} in it, target 0 of the file is this position"
        );
        Some(Diagnostic::nowhere(Code::IMPORT_CONTRADICTION, message, help))
    }

    /// The files in the order of the command.
    fn iter(&self) -> impl Iterator<Item = &InstrumentFile> {
        self.files.iter()
    }

    /// Asks for a machine file, and for all else that the first file leaves open.
    pub(crate) fn ask_without_machine(
        &self,
        format: Option<&str>,
        answers: &FileAnswers,
        demo: &Machine,
        findings: &mut Diagnostics,
    ) {
        let ask = |file: &InstrumentFile| file.ask_without_machine(format, &answers.of(&file.name), demo, findings);
        self.iter().take(1).for_each(ask);
    }

    /// The preview of all files, each below its name if there are several.
    pub(crate) fn preview(&self, all: &[ImportedReadings]) -> String {
        let name = |file: &InstrumentFile| if file.several { format!("{}\n", file.name) } else { String::new() };
        self.iter().zip(all).map(|(file, readings)| name(file) + &preview(readings)).collect()
    }

    /// Writes table and description of every file, or none; `output` is the common name of the two, and for several files their folder. A folder that does
    /// not exist is made. Returns the sentences about the files.
    ///
    /// # Errors
    /// If they cannot be written, exist and must not be replaced, or would have one name.
    pub(crate) fn write(
        &self,
        all: &[ImportedReadings],
        output: &Path,
        inputs: &[PathBuf],
        is_forced: bool,
        findings: &mut Diagnostics,
    ) -> Result<Option<String>, Error> {
        let mut pairs: Vec<[PathBuf; 2]> = Vec::new();
        for file in self.iter() {
            let stem = Path::new(&file.name).file_stem().unwrap_or_default();
            let paths = pair(&if file.several { output.join(stem) } else { output.to_owned() })?;
            if pairs.contains(&paths) {
                let name = Path::new(stem).display();
                return Err(Error::usage(format!("two files have the name {name}; import one of them alone")));
            }
            pairs.push(paths);
        }
        if let Some(path) = pairs.iter().flatten().find(|path| path.exists() && !is_forced) {
            return Err(Error::usage(format!(
                "{} exists; choose another name, or give --force to replace it",
                path.display()
            )));
        }
        let mut together = AtomicWrites::default();
        for ((file, readings), paths) in self.iter().zip(all).zip(&pairs) {
            for (path, text) in paths.iter().zip([readings.table(), readings.description(&file.name)]) {
                if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
                    std::fs::create_dir_all(folder).map_err(|error| Error::file("make", folder, &error))?;
                }
                let target = Target::new(path)?;
                protect(&target, inputs, findings);
                together.add(target, text.as_bytes())?;
            }
        }
        if findings.has_errors() {
            return Ok(None);
        }
        together.publish()?;
        let wrote =
            |[table, description]: &[PathBuf; 2]| format!("wrote {} and {}\n", table.display(), description.display());
        Ok(Some(pairs.iter().map(wrote).collect::<String>() + &self.unread_files()))
    }
}

/// The files of a folder, by name, without hidden ones.
fn in_folder(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = std::fs::read_dir(folder).map_err(|error| Error::file("read", folder, &error))?;
    let is_hidden = |path: &Path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    let mut found: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    found.retain(|path| path.is_file() && !is_hidden(path));
    found.sort();
    Ok(found)
}

/// True for a table with its description, or for this description.
fn is_measurement(path: &Path) -> bool {
    let description = path.with_extension("toml");
    let has_section = |text: String| text.lines().any(|line| line.trim() == "[measurement]");
    path.with_extension("csv").is_file() && std::fs::read_to_string(description).is_ok_and(has_section)
}

/// The remedy for an option without an effect.
fn idle_help(option: &str) -> &'static str {
    match option {
        "material" => {
            "remove --material; for an artifact at its own temperature, write expansion_per_K and temperature_C in [artefact] of the description"
        }
        "turned" => "remove --turned: these readings have the axes of the machine",
        _ => "remove it; `ncfix import --list` lists what each format needs, and --as names the format",
    }
}

/// True for an affirmative answer.
pub(crate) fn is_yes(text: &str) -> bool {
    text.to_lowercase().starts_with('y')
}

/// Table and description of a measurement: `NAME` and `NAME.csv` mean both files.
fn pair(output: &Path) -> Result<[PathBuf; 2], Error> {
    let name = output.to_string_lossy();
    let stem = name.strip_suffix(".csv").or_else(|| name.strip_suffix(".toml")).unwrap_or(&name);
    if files::is_standard_stream(output) || stem.is_empty() || stem.ends_with(['/', '\\']) {
        return Err(Error::usage("a measurement is two files; give -o their common name, such as laser".into()));
    }
    Ok([PathBuf::from(format!("{stem}.csv")), PathBuf::from(format!("{stem}.toml"))])
}
