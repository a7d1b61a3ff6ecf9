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
use ncfix_instruments::answers::ImportAnswers;
use ncfix_instruments::preview::preview;
use ncfix_instruments::readings::ImportedReadings;
use ncfix_instruments::text::DecodedText;
use ncfix_instruments::{ImportOutcome, import};

/// Decoded file of an instrument.
struct InstrumentFile {
    text: DecodedText,
    name: String,
    /// True if it is one of several: its questions then need its name.
    several: bool,
}

impl InstrumentFile {
    /// Reads and decodes a file; `None` if it is not text.
    ///
    /// # Errors
    /// If it cannot be read.
    fn read(path: &Path, findings: &mut Diagnostics) -> Result<Option<InstrumentFile>, Error> {
        let source = files::read(path, FileId(0), "file of an instrument")?;
        let name =
            path.file_name().map_or_else(|| source.name().to_owned(), |name| name.to_string_lossy().into_owned());
        match DecodedText::decode(source.name(), source.bytes().to_vec()) {
            Ok(text) => Ok(Some(InstrumentFile { text, name, several: false })),
            Err(diagnostic) => {
                findings.add(*diagnostic, &[]);
                Ok(None)
            }
        }
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
                        if let Some(warning) = readings.warning() {
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

/// Files of one command, with the same answers: all are written, or none.
pub(crate) struct InstrumentFiles(Vec<InstrumentFile>);

impl InstrumentFiles {
    /// Reads and decodes the files; `None` if one is not text.
    ///
    /// # Errors
    /// If one cannot be read, or standard input is one of several.
    pub(crate) fn read(paths: &[PathBuf], findings: &mut Diagnostics) -> Result<Option<InstrumentFiles>, Error> {
        if paths.len() > 1 && paths.iter().any(|path| files::is_standard_stream(path)) {
            return Err(Error::usage("- for standard input is the only file of a command".into()));
        }
        let mut files = Vec::new();
        for path in paths {
            let several = paths.len() > 1;
            files.extend(InstrumentFile::read(path, findings)?.map(|file| InstrumentFile { several, ..file }));
        }
        Ok((files.len() == paths.len()).then_some(InstrumentFiles(files)))
    }

    /// The readings of all files, after the questions that they leave open; `None` if a file is refused. Without `ask`, nobody can answer.
    ///
    /// # Errors
    /// Errors of `ask`.
    pub(crate) fn understood<E>(
        &self,
        (format, stated): (Option<&str>, &ImportAnswers),
        machine: &Machine,
        mut ask: Option<QuestionToPerson<'_, E>>,
        findings: &mut Diagnostics,
    ) -> Result<Option<Vec<ImportedReadings>>, E> {
        let mut all = Vec::new();
        for file in self.iter() {
            let mut answers = stated.clone();
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
        Ok((all.len() == self.0.len()).then_some(all))
    }

    /// The files in the order of the command.
    fn iter(&self) -> impl Iterator<Item = &InstrumentFile> {
        self.0.iter()
    }

    /// Asks for a machine file, and for all else that the first file leaves open.
    pub(crate) fn ask_without_machine(
        &self,
        format: Option<&str>,
        answers: &ImportAnswers,
        demo: &Machine,
        findings: &mut Diagnostics,
    ) {
        self.iter().take(1).for_each(|file| file.ask_without_machine(format, answers, demo, findings));
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
        Ok(Some(pairs.iter().map(wrote).collect()))
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
