//! Machines: axes, tools and errors of one machine, in one condition.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::diagnostics::Diagnostics;
use crate::disk::machine_file;
use crate::error::Error;
use crate::registry::Registry;
use crate::tool::ToolVector;
use ncfix_base::geometry::{AXES, Axis, AxisVector};
use ncfix_base::source::{FileId, Source};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{AxisData, Condition, State};
use ncfix_model::ErrorModel;
use ncfix_model::shares::{Deviation, ErrorShares};

/// One machine: its axes, control, tools and zero offsets, its measured errors, and its current condition.
///
/// ```
/// use ncfix::prelude::*;
///
/// let machine = Machine::demo();
/// let at = "X600,Y0,Z100".parse()?;
/// let error = machine.deviation(&at, ToolVector::Length(120.0), &State::default());
/// assert!(error.position_um[0].abs() > 1.0, "{:?} µm", error.position_um);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Machine {
    /// The machine, set-up applied.
    pub(crate) machine: ncfix_machine::machine::Machine,
    /// Its errors.
    pub(crate) errors: ErrorModel,
    /// The registry: it defines the keys of the machine file, and the causes of a diagnosis with this machine.
    pub(crate) registry: Arc<Registry>,
    /// Its condition.
    pub(crate) condition: Condition,
    /// Hash of the given condition; `None` if none was given.
    pub(crate) state: Option<String>,
    /// True if this is the embedded demo machine, used because no other was found.
    pub(crate) is_demo: bool,
    /// Hash of machine file and set-up file, 12 hexadecimal digits.
    pub(crate) hash: String,
    /// Zero offsets whose method the command line states, by name.
    pub(crate) stated_zeros: Vec<String>,
    /// Zero offsets that the program sets itself, by name and shift, in the order of their indices.
    pub(crate) written_zeros: Vec<(String, AxisVector)>,
    /// Lengths of the first tool with which the program cuts in each zero offset, by its index, mm: those count for a touch whose tool nothing states.
    pub(crate) first_tools_mm: BTreeMap<u16, f64>,
    /// The files that were read: none of them may be overwritten.
    pub(crate) files: Vec<PathBuf>,
}

impl Machine {
    /// The machine of a machine file, with the compensation tables that the file names as active in the control.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::from_file("samples/machines/maho700s.toml")?;
    /// assert_eq!(machine.name(), "maho700s");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a file cannot be read or has errors.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Machine, Error> {
        Machine::from_files(path, &[])
    }

    /// Opens a machine with set-up files of a job, whose zero offsets and tools override those of the machine file: TOML, or data saved by a control.
    /// A later file overrides an earlier one.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let folder = std::env::temp_dir().join(format!("ncfix_setup_{}", std::process::id()));
    /// std::fs::create_dir_all(&folder)?;
    /// let setup = folder.join("job.toml");
    /// std::fs::write(&setup, "[zero_offset.G54]\nX_mm = 10\n")?;
    /// let machine = Machine::from_files("samples/machines/demo.toml", &[setup]);
    /// std::fs::remove_dir_all(&folder)?;
    /// assert_eq!(machine?.name(), "demo");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a file cannot be read or has errors.
    pub fn from_files(path: impl AsRef<Path>, setups: &[PathBuf]) -> Result<Machine, Error> {
        Machine::read(path.as_ref(), setups, &Registry::default())
    }

    /// The machine of a machine file, which may also use entries of the given registry; see [`Registry`]. The machine keeps the registry for all later
    /// functions.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::from_file_with("samples/machines/demo.toml", &Registry::default())?;
    /// assert_eq!(machine.name(), "demo");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a file cannot be read or has errors.
    pub fn from_file_with(path: impl AsRef<Path>, registry: &Registry) -> Result<Machine, Error> {
        Machine::read(path.as_ref(), &[], registry)
    }

    /// Opens a machine with set-up files of a job, as [`from_files`](Machine::from_files), and with the entries of the given registry.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::from_files_with("samples/machines/demo.toml", &[], &Registry::default())?;
    /// assert_eq!(machine.name(), "demo");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a file cannot be read or has errors.
    pub fn from_files_with(path: impl AsRef<Path>, setups: &[PathBuf], registry: &Registry) -> Result<Machine, Error> {
        Machine::read(path.as_ref(), setups, registry)
    }

    fn read(path: &Path, setups: &[PathBuf], registry: &Registry) -> Result<Machine, Error> {
        let mut found = Diagnostics::default();
        let machine = machine_file::read_file(path, setups, registry, &mut found)?;
        machine.ok_or_else(|| Error::found(found))
    }

    /// The machine of the text of a machine file; diagnostics name the text `name`. No file is read.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let error = Machine::from_text("mill.toml", "[machine]\nname = 5\n").unwrap_err();
    /// assert!(error.diagnostics().errors().any(|one| one.line() == Some(2)));
    /// ```
    ///
    /// # Errors
    /// If the text has errors, or names table files as active.
    pub fn from_text(name: &str, text: &str) -> Result<Machine, Error> {
        Machine::from_text_with(name, text, &Registry::default())
    }

    /// The machine of the text of a machine file, which may also use entries of the given registry. No file is read.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let text = "[machine]\nname = \"mill\"\n[beam]\nmid_um = 12\n";
    /// let error = Machine::from_text_with("mill.toml", text, &Registry::default()).unwrap_err();
    /// assert!(error.diagnostics().errors().count() > 0);
    /// ```
    ///
    /// # Errors
    /// If the text has errors, or names table files as active.
    pub fn from_text_with(name: &str, text: &str, registry: &Registry) -> Result<Machine, Error> {
        let too_large = |_| Error::usage(format!("{name} is too large"));
        let source = Source::new(FileId(0), name, text.as_bytes().to_vec()).map_err(too_large)?;
        let mut found = Diagnostics::default();
        machine_file::of_text(&source, registry, &mut found)?.ok_or_else(|| Error::found(found))
    }

    /// The built-in machine for trials: three axes, invented errors. Programs corrected for it are for inspection, not for cutting.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// assert_eq!(Machine::demo().name(), "demo");
    /// ```
    ///
    /// # Panics
    /// Never; a test reads the built-in file.
    #[must_use]
    #[expect(clippy::expect_used, reason = "the machine is part of the program, and a test reads it")]
    pub fn demo() -> Machine {
        Machine::from_text("<demo machine>", ncfix_machine::machine::file::DEMO).expect("the demo machine is whole")
    }

    /// Its name.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert_eq!(Machine::demo().name(), "demo");
    /// ```
    #[must_use]
    pub fn name(&self) -> &str {
        &self.machine.name
    }

    /// The registry: it defines the keys of the machine file, and the causes of a diagnosis with this machine.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert!(Machine::demo().registry().causes.find("backlash").is_some());
    /// ```
    #[must_use]
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// The machine in another condition: temperatures, loads on the table.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::from_file("samples/machines/maho700s.toml")?;
    /// let mut condition = Condition::default();
    /// condition.add_load("1700@0,0,-280".parse()?);
    /// let (at, tool) = ("X700".parse()?, ToolVector::Length(200.0));
    /// let bare = machine.deviation(&at, tool, &State::default());
    /// let loaded = machine.in_condition(condition).deviation(&at, tool, &State::default());
    /// assert!((loaded.position_um[1] - bare.position_um[1] - 56.83).abs() < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn in_condition(mut self, condition: Condition) -> Machine {
        self.state = Some(crate::disk::hash::short_hash([format!("{condition:?}").as_bytes()]));
        self.condition = condition;
        self
    }

    /// The errors at a pose: position error of the tip and orientation error of the tool, relative to the workpiece,
    /// along and about the directions of the foundation. `pose` contains the axis commands, mm and rad
    /// (`"X100,C30".parse()` takes mm and degrees); `state` contains the directions of the last motions. On a machine with several heads they are those of
    /// the head at the start; [`with_head`](Self::with_head) chooses another one.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let near = machine.deviation(&"X0,Y0,Z0".parse()?, ToolVector::Length(0.0), &State::default());
    /// assert!(near.distance_um() < 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn deviation(&self, pose: &AxisVector, tool: ToolVector, state: &State) -> Deviation {
        let twist = self.model().deviation(pose, &tool.vector_mm(&self.machine), state);
        Deviation {
            position_um: std::array::from_fn(|axis| um_from_mm(twist.translation[axis])),
            rotation_urad: std::array::from_fn(|axis| urad_from_rad(twist.rotation[axis])),
        }
    }

    /// The deviation by each error source at a pose, in the frame and units of [`deviation`](Self::deviation).
    pub(crate) fn shares(&self, pose: &AxisVector, tool: ToolVector, state: &State) -> ErrorShares {
        let tool_mm = tool.vector_mm(&self.machine);
        ErrorShares::new(&self.machine, &self.errors, &self.condition, pose, &tool_mm, state)
    }

    /// Refuses axes of an option that the machine does not have.
    ///
    /// # Errors
    /// If it lacks one of them.
    pub(crate) fn check_axes(&self, option: &str, axes: &[Axis]) -> Result<(), Error> {
        match axes.iter().find(|axis| self.machine.axis(**axis).is_none()) {
            Some(axis) => Err(Error::usage(format!("{option} {axis}: the machine has no axis {axis}"))),
            None => Ok(()),
        }
    }

    /// Refuses a pose that the machine cannot take.
    ///
    /// # Errors
    /// If it lacks an axis, or the pose is outside of the travel.
    pub(crate) fn check_pose(&self, at: &AxisVector) -> Result<(), Error> {
        const ROOM: f64 = 1e-9;
        for axis in AXES {
            let shown = |value: f64| ncfix_base::units::shown_position(axis.is_rotary(), value);
            match self.machine.axis(axis) {
                None if at[axis] != 0.0 => {
                    return Err(Error::usage(format!("--at: the machine has no axis {axis}")));
                }
                Some(AxisData { travel: Some([low, high]), .. }) if !(low - ROOM..=high + ROOM).contains(&at[axis]) => {
                    let [at, low, high] = [at[axis], *low, *high].map(shown);
                    let unit = if axis.is_rotary() { "deg" } else { "mm" };
                    let sentence =
                        format!("--at: {axis} {at} {unit} is outside the travel from {low} to {high} {unit}");
                    return Err(Error::usage(sentence));
                }
                _ => {}
            }
        }
        Ok(())
    }
}
