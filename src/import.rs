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
use ncfix_instruments::readings::ImportedReadings;
use ncfix_instruments::text::DecodedText;
use ncfix_instruments::{ImportOutcome, import};

/// Decoded file of an instrument.
pub(crate) struct InstrumentFile {
    text: DecodedText,
    name: String,
}

impl InstrumentFile {
    /// Reads and decodes a file; `None` if it is not text.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn read(path: &Path, findings: &mut Diagnostics) -> Result<Option<InstrumentFile>, Error> {
        let source = files::read(path, FileId(0), "file of an instrument")?;
        let name =
            path.file_name().map_or_else(|| source.name().to_owned(), |name| name.to_string_lossy().into_owned());
        match DecodedText::decode(source.name(), source.bytes().to_vec()) {
            Ok(text) => Ok(Some(InstrumentFile { text, name })),
            Err(diagnostic) => {
                findings.add(*diagnostic, &[]);
                Ok(None)
            }
        }
    }

    /// Reads the readings; `None` if the file is refused.
    pub(crate) fn readings(
        &self,
        format: Option<&str>,
        answers: &ImportAnswers,
        machine: &Machine,
        findings: &mut Diagnostics,
    ) -> Option<ImportOutcome> {
        match import(&self.text, format, answers, &machine.machine, &machine.registry().instrument_formats) {
            Ok(outcome) => {
                if let ImportOutcome::Readings(readings) = &outcome {
                    readings.warning().into_iter().for_each(|warning| findings.add(warning, &[]));
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
    pub(crate) fn ask_without_machine(
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

    /// Writes both files, or none. A folder that does not exist is made.
    ///
    /// # Errors
    /// If they cannot be written, or exist and must not be replaced.
    pub(crate) fn write(
        &self,
        readings: &ImportedReadings,
        output: &Path,
        inputs: &[PathBuf],
        is_forced: bool,
        findings: &mut Diagnostics,
    ) -> Result<Option<[PathBuf; 2]>, Error> {
        let paths = pair(output)?;
        if let Some(folder) = output.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).map_err(|error| Error::file("make", folder, &error))?;
        }
        let mut together = AtomicWrites::default();
        let texts = [readings.table(), readings.description(&self.name)];
        for (path, text) in paths.iter().zip(texts) {
            let target = Target::new(path)?;
            protect(&target, inputs, findings);
            if path.exists() && !is_forced {
                return Err(Error::usage(format!(
                    "{} exists; choose another name, or give --force to replace it",
                    path.display()
                )));
            }
            together.add(target, text.as_bytes())?;
        }
        if findings.has_errors() {
            return Ok(None);
        }
        together.publish()?;
        Ok(Some(paths))
    }
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
