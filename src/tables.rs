//! Compensation tables of controls.

use std::path::Path;

use crate::diagnostics::Diagnostics;
use crate::disk::files;
use crate::error::Error;
use crate::machine::Machine;
use crate::tool::ToolVector;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::ActiveTables;
use ncfix_model::Accumulator;
use ncfix_tables::tables::check::check;
use ncfix_tables::tables::region::Region;
use ncfix_tables::tables::scheme::{self, Task};
use ncfix_tables::tables::{self, Control, Format, Multiplication, Orientation, Wiring};

/// Start of the generator of the poses of a check: none of those of a scheme.
const SEED: u64 = 0x43_4845_434b;

/// How tables are made. `TableOptions::default()` is what `ncfix tables` does without options.
///
/// ```
/// use ncfix::prelude::*;
///
/// let mut options = TableOptions::default();
/// options.scheme = "fik".into();
/// assert_eq!((options.points, options.tolerance_mm), (37, 0.001));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TableOptions {
    /// What fills them: a scheme such as `fik`, `grid` or `own`, or `auto` for the fewest tables that reach the tolerance (`ncfix tables --list`).
    pub scheme: String,
    /// Points of a table.
    pub points: usize,
    /// How much of the error may be left, mm: its root mean square over the travel.
    pub tolerance_mm: f64,
    /// The tool for which they are made and checked; without it the longest of the machine file.
    pub tool: Option<ToolVector>,
    /// Poses at which they are checked.
    pub poses: usize,
}

impl Default for TableOptions {
    fn default() -> TableOptions {
        TableOptions { scheme: "auto".into(), points: 37, tolerance_mm: 0.001, tool: None, poses: 2000 }
    }
}

/// What a set of tables leaves over the travel of a machine, root of the mean square.
///
/// ```
/// use ncfix::prelude::*;
///
/// let machine = Machine::from_file("samples/machines/maho700s.toml")?;
/// let mut options = TableOptions::default();
/// options.scheme = "fik".into();
/// let left = Tables::make(&machine, "cec", &options)?.check(&machine, &options)?;
/// assert!(left.tables_um < left.before_um);
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TableCheck {
    /// Poses.
    pub poses: usize,
    /// Of the tip without tables, µm.
    pub before_um: f64,
    /// Of the tip with them, µm.
    pub tables_um: f64,
    /// Of the tip with the exact correction of the kinematics, µm.
    pub exact_um: f64,
}

/// Compensation tables in the format of a control.
///
/// ```
/// use ncfix::prelude::*;
///
/// let machine = Machine::from_file("samples/machines/maho700s.toml")?;
/// let mut options = TableOptions::default();
/// options.scheme = "fik".into();
/// for (name, text) in Tables::make(&machine, "cec", &options)?.files("MAHO") {
///     println!("{name}: {} lines", text.lines().count());
/// }
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Tables {
    tables: tables::Tables,
    format: &'static Format,
    wiring: Wiring,
    notes: Vec<String>,
}

impl Tables {
    /// Makes tables for the errors of a machine in its condition; `format` is a name of `ncfix tables --list`.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let error = Tables::make(&Machine::demo(), "punched tape", &TableOptions::default()).unwrap_err();
    /// assert!(error.message().contains("cec"), "{error}");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where there is no such format or scheme, an axis has no travel, or the control cannot hold tables that leave less than none.
    pub fn make(machine: &Machine, format: &str, options: &TableOptions) -> Result<Tables, Error> {
        let format = of_name(machine, format)?;
        let machine = &itself(machine);
        let own = &machine.machine;
        let region = travel(machine)?;
        let wiring = Wiring::of(own);
        let model = machine.model();
        let errors = Accumulator::sum(own, &machine.errors, &machine.condition, |_| true);
        let target = tables::Target {
            machine: own,
            model: &model,
            tool_mm: tool_mm(machine, options),
            orientation: Orientation::Smooth,
        };
        let multiplication = own.active_tables.multiplication.map(Multiplication::from).unwrap_or_default();
        let task = Task {
            target,
            orientation: None,
            errors: &errors,
            region: &region,
            points: options.points,
            tolerance_mm: options.tolerance_mm,
            multiplication,
            format,
            wiring: &wiring,
        };
        let refused = |why: String| {
            let help = "ncfix tables --list shows what each format holds; try the scheme auto or a larger tolerance";
            let mut found = Diagnostics::default();
            found.add(Diagnostic::nowhere(Code::TABLES_DO_NOT_FIT, why, help), &[]);
            Error::found(found)
        };
        let schemes = &machine.registry.schemes;
        let named = schemes.iter().find(|one| one.name.eq_ignore_ascii_case(&options.scheme));
        let (name, made) = match named {
            Some(scheme) => (scheme.name, scheme.tables(&task).map_err(refused)?),
            None if options.scheme.eq_ignore_ascii_case("auto") => {
                let (best, _) = scheme::choose_with(schemes, &task);
                let (scheme, made) = best.ok_or_else(|| refused("no scheme reaches the tolerance".into()))?;
                (scheme.name, made)
            }
            None => return Err(Error::usage(format!("there is no scheme '{}'", options.scheme))),
        };
        if let Some(fault) = format.faults_of(&made, &wiring).into_iter().next() {
            return Err(refused(fault));
        }
        let notes = vec![format!("machine {}, scheme {name}", own.name), format.sign.to_owned()];
        let made = Tables { tables: made, format, wiring, notes };
        let left = made.check(machine, options)?;
        if left.tables_um > left.before_um {
            return Err(refused("the tables would leave more than no tables".into()));
        }
        Ok(made)
    }

    /// Reads a file of tables as the control of a machine has it.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::from_file("samples/machines/maho700s.toml")?;
    /// let mut options = TableOptions::default();
    /// options.scheme = "fik".into();
    /// let made = Tables::make(&machine, "cec", &options)?;
    /// let (_, text) = made.files("MAHO").swap_remove(0);
    /// let path = std::env::temp_dir().join(format!("ncfix_tables_{}.INI", std::process::id()));
    /// std::fs::write(&path, text)?;
    /// let read = Tables::read(&path, "cec", &machine);
    /// std::fs::remove_file(&path)?;
    /// assert_eq!(read?.check(&machine, &options)?, made.check(&machine, &options)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Where the file cannot be read, or as for [`Tables::parse`].
    pub fn read(path: impl AsRef<Path>, format: &str, machine: &Machine) -> Result<Tables, Error> {
        let source = files::read(path.as_ref(), FileId(0), "compensation tables")?;
        Tables::parse(source.name(), source.bytes(), format, machine)
    }

    /// Tables of the text of a file as the control of a machine has it. No file is read.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::from_file("samples/machines/maho700s.toml")?;
    /// let mut options = TableOptions::default();
    /// options.scheme = "fik".into();
    /// let made = Tables::make(&machine, "cec", &options)?;
    /// let (name, text) = made.files("MAHO").swap_remove(0);
    /// let read = Tables::parse(&name, text, "cec", &machine)?;
    /// assert_eq!(read.check(&machine, &options)?, made.check(&machine, &options)?);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where there is no such format, or the text is not in it.
    pub fn parse(name: &str, text: impl Into<Vec<u8>>, format: &str, machine: &Machine) -> Result<Tables, Error> {
        let format = of_name(machine, format)?;
        let wiring = Wiring::of(&machine.machine);
        let source = Source::new(FileId(0), name, text.into());
        let source = source.map_err(|_| Error::usage(format!("{name} is too large")))?;
        let mut read = tables::Tables::default();
        let mut found = Diagnostics::default();
        found.extend((format.read)(&source, &wiring, &mut read), std::slice::from_ref(&source));
        if found.has_errors() {
            return Err(Error::found(found));
        }
        Ok(Tables { tables: read, format, wiring, notes: vec![format!("read from {name}")] })
    }

    /// The files as the control reads them: names, of which `name` is the beginning, and texts.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::from_file("samples/machines/maho700s.toml")?;
    /// let mut options = TableOptions::default();
    /// options.scheme = "fik".into();
    /// let files = Tables::make(&machine, "cec", &options)?.files("MAHO");
    /// assert!(files[0].0.starts_with("MAHO") && files[0].1.contains("$AN_CEC"));
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn files(&self, name: &str) -> Vec<(String, String)> {
        let written = (self.format.write)(&self.tables, &self.wiring, &self.notes);
        written.into_iter().map(|one| (format!("{name}{}", one.suffix), one.text)).collect()
    }

    /// What they leave over the travel of a machine, as the control interpolates them.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::from_file("samples/machines/maho700s.toml")?;
    /// let mut options = TableOptions::default();
    /// options.scheme = "fik".into();
    /// let left = Tables::make(&machine, "cec", &options)?.check(&machine, &options)?;
    /// assert!(left.tables_um >= left.exact_um && left.poses > 0);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where an axis has no travel.
    pub fn check(&self, machine: &Machine, options: &TableOptions) -> Result<TableCheck, Error> {
        let machine = &itself(machine);
        let own = &machine.machine;
        let model = machine.model();
        let target = tables::Target {
            machine: own,
            model: &model,
            tool_mm: tool_mm(machine, options),
            orientation: Orientation::Smooth,
        };
        let poses = travel(machine)?.reached(own).poses(options.poses, SEED);
        let found = check(&target, &Control::new(own, &self.tables), &poses);
        let um = |errors: &tables::check::Errors| ncfix_base::units::um_from_mm(errors.rms_mm());
        Ok(TableCheck {
            poses: poses.len(),
            before_um: um(&found.before),
            tables_um: um(&found.tables),
            exact_um: um(&found.exact),
        })
    }
}

/// The machine without the tables that are active in its control: new ones are for the machine itself, and those that are checked stand for themselves.
fn itself(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    let multiplication = machine.machine.active_tables.multiplication;
    machine.machine.active_tables = ActiveTables { multiplication, ..ActiveTables::default() };
    machine
}

fn of_name(machine: &Machine, name: &str) -> Result<&'static Format, Error> {
    let formats = &machine.registry.formats;
    let names = || formats.names().collect::<Vec<_>>().join(", ");
    let found = formats.iter().copied().find(|one| one.name.eq_ignore_ascii_case(name));
    found.ok_or_else(|| Error::usage(format!("there is no format '{name}'; the formats are {}", names())))
}

fn travel(machine: &Machine) -> Result<Region, Error> {
    Region::travel(&machine.machine)
        .map_err(|axis| Error::usage(format!("axis {axis} has no travel; write travel_mm of it into the machine file")))
}

/// The tool that counts: that of the options, else the longest of the machine.
fn tool_mm(machine: &Machine, options: &TableOptions) -> ncfix_base::geometry::Vector {
    let longest = || machine.machine.tools.iter().map(|tool| tool.length_mm[0].abs()).fold(0.0, f64::max);
    options.tool.unwrap_or_else(|| ToolVector::Length(longest())).vector_mm(&machine.machine)
}
