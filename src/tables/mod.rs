//! Compensation tables of controls.

pub(crate) mod live;
pub(crate) mod output;
pub(crate) mod reread;

use std::path::{Path, PathBuf};

use crate::coverage::of_ranges;
use crate::diagnostics::Diagnostics;
use crate::disk::files::{self, is_standard_stream};
use crate::disk::table_files::{numbers_assumed, products_assumed, tool_remark};
use crate::error::Error;
use crate::machine::Machine;
use crate::tool::ToolVector;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::ActiveTables;
use ncfix_model::coverage::UsedRanges;
use ncfix_tables::results::made::{Filling, MadeTables, make, misfits, shifted};
use ncfix_tables::results::request::{TablesRequest, region};
use ncfix_tables::results::result::TablesResult;
use ncfix_tables::results::single::single_errors;
use ncfix_tables::tables::{self, Format, Multiplication, Orientation, Scheme, Schemes, Wiring};

/// Options for making tables. `TableOptions::default()` gives the options of `ncfix tables` without arguments.
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
    /// The scheme that fills the tables: `fik`, `grid`, `own` or another, or `auto` for the fewest tables that reach the tolerance (`ncfix tables
    /// --list`).
    pub scheme: String,
    /// Number of points of a table.
    pub points: usize,
    /// Largest permitted residual, mm: RMS over the travel.
    pub tolerance_mm: f64,
    /// The tool for which they are made and checked; by default the longest one of the machine file.
    pub tool: Option<ToolVector>,
    /// Number of poses at which they are checked.
    pub poses: usize,
    /// Treatment of the tool orientation by the rotary axes; `None` for the default of each scheme.
    pub orientation: Option<Orientation>,
    /// Ranges of axes that the tables cover instead of their travel, mm or deg.
    pub ranges_mm_deg: Vec<(Axis, [f64; 2])>,
    /// The axis names of the control, if the machine file does not state them.
    pub axis_names: Vec<(Axis, String)>,
    /// The value of a table that is multiplied by another one; `None` for the setting of the machine file.
    pub multiplication: Option<Multiplication>,
    /// `true` to compute the residuals with fewer tables too, which takes longer.
    pub tries_fewer: bool,
    /// Largest number of tables: the best set of them is made, with the residuals of the best sets of each number; `None` for no limit.
    pub most: Option<usize>,
    /// `true` to also count the tables that each single error of the machine needs, which takes longer.
    pub each_error: bool,
}

impl Default for TableOptions {
    fn default() -> TableOptions {
        TableOptions {
            scheme: "auto".into(),
            points: 37,
            tolerance_mm: 0.001,
            tool: None,
            poses: 2000,
            orientation: None,
            ranges_mm_deg: Vec::new(),
            axis_names: Vec::new(),
            multiplication: None,
            tries_fewer: false,
            most: None,
            each_error: false,
        }
    }
}

impl TableOptions {
    /// Refuses two ranges or two names of one axis, and one name of two axes.
    ///
    /// # Errors
    /// The option that is given twice.
    pub(crate) fn check_unique(&self) -> Result<(), Error> {
        once("--axis-name", self.axis_names.iter().map(|(_, name)| name.clone()))?;
        once("--axis-name", self.axis_names.iter().map(|(axis, _)| format!("axis {axis}")))?;
        once("--range", self.ranges_mm_deg.iter().map(|(axis, _)| axis.to_string()))
    }
}

/// Refuses an option that is given twice for the same thing.
fn once(option: &str, all: impl Iterator<Item = String>) -> Result<(), Error> {
    let mut known: Vec<String> = Vec::new();
    for one in all.map(|one| one.to_ascii_uppercase()) {
        if known.contains(&one) {
            return Err(Error::usage(format!("{option} is given twice for {one}; give it once")));
        }
        known.push(one);
    }
    Ok(())
}

/// The residual of a set of tables over the travel of a machine, RMS.
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
    /// Number of poses.
    pub poses: usize,
    /// RMS error of the tool tip without tables, µm.
    pub before_um: f64,
    /// RMS error of the tool tip with them, µm.
    pub tables_um: f64,
    /// RMS error of the tool tip with the exact correction of the kinematics, µm.
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
    /// If there is no such format or scheme, an axis has no travel, or the control cannot hold tables that reduce the error.
    pub fn make(machine: &Machine, format: &str, options: &TableOptions) -> Result<Tables, Error> {
        let format = of_name(machine, format)?;
        let mut found = Diagnostics::default();
        let made = Tables::make_noting(machine, format, options, &mut TablesResult::default(), &mut found)?;
        made.ok_or_else(|| Error::found(found))
    }

    /// Makes tables and notes in the result which ones were made, tried and checked; `None` if there are errors.
    ///
    /// # Errors
    /// If there is no such scheme, or the machine has no such part of its volume.
    pub(crate) fn make_noting(
        machine: &Machine,
        format: &'static Format,
        options: &TableOptions,
        result: &mut TablesResult,
        found: &mut Diagnostics,
    ) -> Result<Option<Tables>, Error> {
        machine.check_one_head()?;
        let machine = &itself(machine);
        let schemes = &machine.registry.schemes;
        let scheme = scheme_of(schemes, &options.scheme)?;
        let request = request(machine, options)?;
        let &TableOptions { points, tolerance_mm, most, .. } = options;
        let tries_fewer = options.tries_fewer || most.is_some();
        let filling = Filling { format, scheme, schemes, points, tolerance_mm, tries_fewer, most, is_fewest: false };
        if options.each_error {
            result.single_errors = single_errors(&request, &filling);
        }
        let made = match make(&request, &filling, result) {
            Ok(made) => made,
            Err(why) => {
                found.add(*why, &[]);
                return Ok(None);
            }
        };
        let used =
            UsedRanges { axes: request.region.ranges.iter().copied().collect(), tools_mm: Some([request.tool_mm; 2]) };
        let mut gaps = of_ranges(machine, &used).diagnostics(false);
        // Tables have a range instead of a workpiece that can be moved.
        for gap in gaps.iter_mut().filter(|gap| gap.code == Code::BEYOND_MEASURED) {
            let measure = gap.help.trim_start_matches("move the workpiece, or ");
            gap.help = format!("limit the tables with --range, or {measure}");
        }
        found.extend(gaps, &[]);
        let notes = notes(machine, &request, format, &made);
        result.check = Some(made.checked);
        found.extend(misfits(format, &made.tables, &request.wiring), &[]);
        if format.has_axis_numbers && request.wiring.assumes(&made.tables.axes()) {
            found.add(numbers_assumed(&request.wiring.listed(&made.tables.axes())), &[]);
        }
        if request.multiplication.is_none() && made.tables.lookups.iter().any(|one| one.factor.is_some()) {
            found.add(products_assumed("these tables"), &[]);
        }
        Ok((!found.has_errors()).then_some(Tables { tables: made.tables, format, wiring: request.wiring, notes }))
    }

    /// Reads a file of tables as the control of a machine interprets it.
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
    /// If the file cannot be read, or as for [`Tables::parse`].
    pub fn read(path: impl AsRef<Path>, format: &str, machine: &Machine) -> Result<Tables, Error> {
        let source = files::read(path.as_ref(), FileId(0), "compensation tables")?;
        Tables::parse(source.name(), source.bytes(), format, machine)
    }

    /// Tables from the text of a file, as the control of a machine interprets it. No file is read.
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
    /// If there is no such format, or the text cannot be parsed in it.
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

    /// The files in the format of the control, as pairs of a name and a text. Every name begins with `name`. Nothing is written.
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

    /// The files for `output`: its name, which formats with several files extend.
    ///
    /// # Errors
    /// If several files would go to standard output.
    pub(crate) fn files_at(&self, output: &Path) -> Result<Vec<(PathBuf, String)>, Error> {
        let written = (self.format.write)(&self.tables, &self.wiring, &self.notes);
        if is_standard_stream(output) && written.len() > 1 {
            let what = format!("{} are {} files, but standard output is only one", self.format.title, written.len());
            return Err(Error::usage(format!(
                "{what}; give with -o the beginning of their names, for example -o mill"
            )));
        }
        let stem = output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = |suffix: &str| {
            if suffix.is_empty() || is_standard_stream(output) {
                output.to_owned()
            } else {
                output.with_file_name(format!("{stem}{suffix}"))
            }
        };
        Ok(written.into_iter().map(|one| (name(&one.suffix), one.text)).collect())
    }

    /// The tables themselves.
    pub(crate) fn inner(&self) -> &tables::Tables {
        &self.tables
    }

    /// The residual over the travel of a machine, as the control interpolates the tables.
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
    /// If an axis has no travel.
    pub fn check(&self, machine: &Machine, options: &TableOptions) -> Result<TableCheck, Error> {
        let machine = &itself(machine);
        let found = request(machine, options)?.check(&self.tables);
        Ok(TableCheck {
            poses: found.poses,
            before_um: found.before.rms_um,
            tables_um: found.tables.rms_um,
            exact_um: found.exact.rms_um,
        })
    }
}

/// The machine without the tables that are active in its control: new tables apply to the machine itself, and checked tables are evaluated alone.
pub(crate) fn itself(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    if machine.machine.active_tables.is_offline {
        return machine;
    }
    let multiplication = machine.machine.active_tables.multiplication;
    machine.machine.active_tables = ActiveTables { multiplication, ..ActiveTables::default() };
    machine
}

fn of_name(machine: &Machine, name: &str) -> Result<&'static Format, Error> {
    let formats = &machine.registry.formats;
    let names = || formats.names().collect::<Vec<_>>().join(", ");
    let found = formats.iter().copied().find(|one| one.name.eq_ignore_ascii_case(name));
    found.ok_or_else(|| Error::usage(format!("unknown format '{name}'; the formats are {}", names())))
}

/// The scheme of a name; `None` for `auto`.
///
/// # Errors
/// If there is no such scheme.
pub(crate) fn scheme_of(schemes: &Schemes, name: &str) -> Result<Option<&'static Scheme>, Error> {
    let scheme = schemes.iter().copied().find(|scheme| scheme.name.eq_ignore_ascii_case(name));
    if scheme.is_none() && !name.eq_ignore_ascii_case("auto") {
        let names: Vec<&str> = schemes.iter().map(|scheme| scheme.name).chain(["auto"]).collect();
        return Err(Error::usage(format!("unknown scheme '{name}'; the schemes are {}", names.join(", "))));
    }
    Ok(scheme)
}

/// The request for making and checking tables on a machine [itself].
///
/// # Errors
/// If the machine has no such part of its volume.
fn request<'a>(machine: &'a Machine, options: &TableOptions) -> Result<TablesRequest<'a>, Error> {
    let own = &machine.machine;
    let products = own.active_tables.multiplication.map(Multiplication::from);
    Ok(TablesRequest {
        machine: own,
        errors: &machine.errors,
        condition: &machine.condition,
        region: region(own, &options.ranges_mm_deg).map_err(|reason| Error::usage(reason.to_string()))?,
        ranges: options.ranges_mm_deg.clone(),
        wiring: wiring(Wiring::of(own), options),
        tool_mm: tool_mm(machine, options),
        orientation: options.orientation,
        multiplication: options.multiplication.or(products),
        poses: options.poses,
    })
}

/// The names of the axes, with those of the options.
fn wiring(mut wiring: Wiring, options: &TableOptions) -> Wiring {
    options.axis_names.iter().for_each(|(axis, name)| wiring.rename(*axis, name));
    wiring
}

/// The remarks at the beginning of new tables.
fn notes(machine: &Machine, request: &TablesRequest<'_>, format: &Format, made: &MadeTables) -> Vec<String> {
    let state = machine.state.as_deref().map_or(String::new(), |state| format!(", state {state}"));
    let version = env!("CARGO_PKG_VERSION");
    let (name, hash) = (&machine.machine.name, &machine.hash);
    let [without, with] = [made.checked.before.rms_um, made.checked.tables.rms_um];
    let mut notes = vec![
        format!("ncfix {version}: machine {name} ({hash}{state}), scheme {}", made.scheme),
        tool_remark(&request.tool_mm),
        format!("tip error over the volume, rms: {without:.3} um without, {with:.3} um with these tables"),
        format!("{}; measure before and after: a wrong sign doubles the errors", format.sign),
    ];
    notes.extend(shifted(&made.checked));
    if format.has_axis_numbers {
        let axes = made.tables.axes();
        let about = if request.wiring.assumes(&axes) { " (assumed)" } else { "" };
        notes.push(format!("axes{about}: {}", request.wiring.listed(&axes)));
    }
    let sums = request.largest_sums(&made.tables);
    if !made.tables.lookups.is_empty() && !sums.is_empty() {
        let unit = |axis: &str| if axis.starts_with(['A', 'B', 'C']) { "deg" } else { "mm" };
        let shown = sums.iter().map(|one| format!("{} {:.4} {}", one.axis, one.largest, unit(&one.axis)));
        notes.push(format!("largest sum of the corrections of an axis: {}", shown.collect::<Vec<_>>().join(", ")));
        for one in sums.iter().filter(|_| format.sum_limit.is_some()) {
            let axis = AXES.into_iter().find(|axis| axis.to_string() == one.axis);
            let remark = axis
                .zip(format.sum_limit)
                .map(|(axis, limit)| limit(&request.wiring.name(axis), one.largest, unit(&one.axis)));
            notes.extend(remark);
        }
    }
    let ranges = request.asked_ranges();
    if !ranges.is_empty() {
        notes.push(format!("made for a part of the travel: {}", ranges.join(", ")));
    }
    notes
}

/// The tool for the tables: that of the options, else the longest of the machine.
fn tool_mm(machine: &Machine, options: &TableOptions) -> ncfix_base::geometry::Vector {
    let longest = || machine.machine.tools.iter().map(|tool| tool.length_mm[0].abs()).fold(0.0, f64::max);
    options.tool.unwrap_or_else(|| ToolVector::Length(longest())).vector_mm(&machine.machine)
}
