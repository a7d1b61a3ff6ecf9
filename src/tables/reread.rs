//! Reads tables of a control: checks them, compares them with others, converts them to another format.

use std::path::{Path, PathBuf};

use super::{TableOptions, Tables, request, wiring};
use crate::diagnostics::Diagnostics;
use crate::disk::table_files::{self, TableReading};
use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::geometry::Vector;
use ncfix_tables::results::compared::{difference, range_of};
use ncfix_tables::results::made::{misfits, worse};
use ncfix_tables::results::result::TablesResult;
use ncfix_tables::tables::{Format, Tables as ControlTables, Wiring};

/// Tools whose tips are closer than this are the same, mm.
const SAME_TOOL_MM: f64 = 1e-6;

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
    /// True if they are checked, which needs the machine.
    pub(crate) is_checked: bool,
}

/// Tables as they were read.
pub(crate) struct RereadTables {
    /// Those of the files.
    pub(crate) tables: ControlTables,
    /// Those with which they are compared.
    pub(crate) other: Option<ControlTables>,
    /// Those that are written.
    pub(crate) converted: Option<Tables>,
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
        Ok((!found.has_errors()).then_some(RereadTables { tables: read.tables, other, converted }))
    }
}

/// The names of files without their folders.
fn names(paths: &[PathBuf]) -> String {
    let names = paths.iter().map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned());
    names.collect::<Vec<_>>().join(", ")
}
