//! Reads tables of a control: checks them, compares them with others, converts them to another format.

use std::path::{Path, PathBuf};

use super::{TableOptions, Tables, request, wiring};
use crate::diagnostics::Diagnostics;
use crate::disk::table_files::{self, TableReading};
use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Vector;
use ncfix_base::number::significant;
use ncfix_base::source::{FileId, Source};
use ncfix_model::file::load;
use ncfix_tables::results::compared::{difference, range_of};
use ncfix_tables::results::inverse::machine_text;
use ncfix_tables::results::made::{misfits, worse};
use ncfix_tables::results::request::TablesRequest;
use ncfix_tables::results::result::TablesResult;
use ncfix_tables::tables::{Format, Tables as ControlTables, Wiring};

/// Tools whose tips are closer than this are the same, mm.
const SAME_TOOL_MM: f64 = 1e-6;

/// Share of the errors that may be left with the tables from which they were found: effects of the second order.
const MOST_SHARE_LEFT: f64 = 0.02;
/// Rounding of the tables and of the machine file, µm.
const ROUNDED_UM: f64 = 0.01;

/// Options for tables that are read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reread<'a> {
    /// The files: one, several that belong together, or an archive.
    pub(crate) files: &'a [PathBuf],
    /// The file of the tables with which they are compared.
    pub(crate) compare: Option<&'a Path>,
    /// The format to which they are converted, or, without a conversion, in which they are read.
    pub(crate) format: Option<&'static Format>,
    /// True if they are converted.
    pub(crate) is_converted: bool,
    /// The text of the machine file to which the errors are added that the tables remove.
    pub(crate) machine_text: Option<&'a str>,
    /// True if they are checked, which needs the machine.
    pub(crate) is_checked: bool,
}

/// Tables as they were read.
pub(crate) struct RereadTables {
    /// The errors of reading the files.
    pub(crate) tables: ControlTables,
    /// Those with which they are compared.
    pub(crate) other: Option<ControlTables>,
    /// Those that are written.
    pub(crate) converted: Option<Tables>,
    /// The machine file with the errors that they remove.
    pub(crate) machine_file: Option<String>,
}

impl Reread<'_> {
    /// Reads the tables and does what is asked on a machine [itself](super::itself), which is noted in the result; `None` if there are errors.
    ///
    /// # Errors
    /// If a file cannot be read, its format cannot be detected, or the request needs more input.
    pub(crate) fn run(
        &self,
        machine: Option<&Machine>,
        options: &TableOptions,
        result: &mut TablesResult,
        found: &mut Diagnostics,
    ) -> Result<Option<RereadTables>, Error> {
        let request = machine.map(|machine| request(machine, options)).transpose()?;
        let wiring = request.as_ref().map_or_else(|| wiring(Wiring::usual(), options), |one| one.wiring.clone());
        let reading = TableReading {
            // Without a conversion, the requested format is the one to read.
            format: if self.is_converted { None } else { self.format },
            multiplication: request.as_ref().map_or(options.multiplication, |one| one.multiplication),
            machine: request.as_ref().map(|one| one.machine),
            wiring: &wiring,
        };
        let Some(read) = table_files::read(self.files, &reading, found)? else { return Ok(None) };
        result.note(&read.tables);
        result.format = read.names();
        if let Some(request) = &request {
            result.machine.clone_from(&request.machine.name);
            if self.is_checked {
                result.check = Some(request.check(&read.tables));
                result.sums = request.largest_sums(&read.tables);
                let other = read.tool_mm.filter(|own| (own - request.tool_mm).norm() > SAME_TOOL_MM);
                result.made_for_tool_mm = other.map(|own| [own.x, own.y, own.z]);
            }
        }
        let mut other = None;
        if let Some(path) = self.compare {
            let paths = [path.to_path_buf()];
            let Some(second) = table_files::read(&paths, &TableReading { format: None, ..reading }, found)? else {
                return Ok(None);
            };
            let both = [&read.tables, &second.tables];
            let differences = match &request {
                Some(one) => difference(both, Some(one.machine), &one.region, one.tool_mm, options.poses),
                None => difference(both, None, &range_of(both), Vector::zeros(), options.poses),
            };
            result.difference = differences.map_err(|reason| Error::usage(reason.to_string()))?;
            other = Some(second.tables);
        }
        let mut machine_file = None;
        if let (Some(text), Some(request)) = (self.machine_text, &request) {
            machine_file = self.errors(text, request, &read.tables, result, found)?;
        }
        let mut converted = None;
        if self.is_converted {
            let Some(format) = self.format else {
                return Err(Error::usage("give --format to convert the tables, or remove -o".into()));
            };
            let mut tables = read.tables.clone();
            (format.round)(&mut tables);
            if let Some(request) = &request {
                let checked = request.everywhere(&tables, &request.check(&tables));
                if let Some(diagnostic) = worse(&checked, &request.volume()) {
                    found.add(diagnostic, &[]);
                    return Ok(None);
                }
            }
            found.extend(misfits(format, &tables, &wiring), &[]);
            result.format = format!("{} as {}", read.names(), format.name);
            let notes = vec![format!("read from {}", names(self.files))];
            converted = Some(Tables { tables, format, wiring: wiring.clone(), notes });
        }
        Ok((!found.has_errors()).then_some(RereadTables { tables: read.tables, other, converted, machine_file }))
    }

    /// The machine file with the errors that the tables remove: with the tables, nothing of them must be left.
    fn errors(
        &self,
        text: &str,
        request: &TablesRequest<'_>,
        tables: &ControlTables,
        result: &mut TablesResult,
        found: &mut Diagnostics,
    ) -> Result<Option<String>, Error> {
        if !request.model().is_empty() {
            let sentence = "the machine file already states errors, and the tables may correct the same ones";
            return Err(Error::usage(format!("{sentence}; give a machine file without errors")));
        }
        let mut refuse = |message: String| {
            let help = "see docs/reference/tables.md for the tables that state errors of single axes";
            found.add(Diagnostic::nowhere(Code::TABLES_DO_NOT_FIT, message, help), &[]);
        };
        let (text, count) = match machine_text(text, request.machine, tables) {
            Ok(made) => made,
            Err(why) => {
                refuse(why);
                return Ok(None);
            }
        };
        let head = format!("# Errors that these tables remove: {}.\n", names(self.files));
        let text = format!("{head}# While the control uses them, name them in active_tables.\n{text}");
        let source = Source::new(FileId(0), "machine file", text.clone().into_bytes());
        let loaded = source.ok().and_then(|source| load(&source).0);
        let Some((_, errors)) = loaded else {
            refuse("the errors of these tables cannot be stated in a machine file".to_owned());
            return Ok(None);
        };
        let checked = TablesRequest { errors: &errors, ..request.clone() }.check(tables);
        let (before, left) = (checked.before.rms_um, checked.tables.rms_um);
        if left > MOST_SHARE_LEFT * before + ROUNDED_UM {
            refuse(format!(
                "the tables are no errors of single axes: of the {} µm RMS that they would correct, {} µm are left",
                significant(before),
                significant(left)
            ));
            return Ok(None);
        }
        result.check = Some(checked);
        result.errors_found = Some(count);
        Ok(Some(text))
    }
}

/// The names of files without their folders.
fn names(paths: &[PathBuf]) -> String {
    let names = paths.iter().map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned());
    names.collect::<Vec<_>>().join(", ")
}
