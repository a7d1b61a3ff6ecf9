//! Machine: chain of bodies, axes, travel, tools, zero offsets, control settings, and its state.
//!
//! This module contains no errors: `ncfix_model` adds them.

mod active;
mod axis_name;
mod chain;
mod clamp;
pub mod condition;
mod contour_control;
pub mod controller;
mod datum;
mod document;
pub mod edit;
pub mod file;
mod firmware;
mod foreign_key;
mod frame_control;
mod grundig_control;
mod head;
mod iso_control;
mod kinematics;
mod lacking;
mod load_sensor;
mod macro_control;
mod measured;
mod opaque;
mod orientation;
pub mod origin;
mod output_control;
pub mod range;
mod section;
mod servo;
mod setting;
pub mod squareness;
mod state;
mod strain;
mod tip_path;
mod tool;
mod travel;
pub mod uncertainty;
pub mod zero_offset;

pub(crate) use active::OTHER_AXIS;
pub use active::{ActiveCompensation, ActiveTables, TableProducts};
pub use chain::{Branch, Topology, TopologyFault};
pub use clamp::Clamp;
pub use condition::{Condition, Load, ZeroPose};
pub use contour_control::{ArcCenter, CompensationCorner, CompensationStart};
pub use datum::{Datum, TouchedAt, ZeroSetting};
pub use firmware::Firmware;
pub use frame_control::Rollover;
pub use grundig_control::{GrundigControl, PlaneOrder, ScaledAxes};
pub use head::{Head, MOST_HEADS, Spindle};
pub use iso_control::{DecimalPoint, IncrementSystem, IsoControl, LengthAxis, OneAxis, WordMeaning};
pub use kinematics::Kinematics;
pub use lacking::LackingWord;
pub use load_sensor::LoadSensor;
pub use macro_control::MacroControl;
pub use measured::MeasuredRanges;
pub use opaque::{AllowedSynchronised, Opaque};
pub use servo::{AxisServo, Servo};
pub use setting::Setting;
pub use state::State;
pub use strain::StrainGauge;
pub use tip_path::{GreatCircle, TipArc, TipPath};
pub use tool::Tool;
pub use uncertainty::{Uncertainty, UncertaintyRow};

use std::collections::BTreeMap;

use ncfix_base::geometry::{Axis, AxisSet, AxisVector, FrameParts, Plane, RotationOrder, Vector};

/// Machine as described by its file. Lengths in mm, angles in rad, directions as unit vectors in F at the zero pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Name from `machine.name`.
    pub name: String,
    /// Order of the bodies from workpiece to tool.
    pub topology: Topology,
    /// Dialect of its programs, as written (`sinumerik`); the registry of dialects resolves it.
    pub controller: String,
    /// Reference temperature of the model, °C.
    pub reference_temperature_c: f64,
    /// Reference temperatures of sensors, °C, if different from [`Self::reference_temperature_c`].
    pub sensor_references_c: BTreeMap<String, f64>,
    /// Axes by slot; `None` if the machine lacks the axis.
    pub axes: [Option<AxisData>; ncfix_base::geometry::AXIS_COUNT],
    /// Spindle; of a machine with heads, that of the head that is active at the start.
    pub spindle: Spindle,
    /// Heads that M words select, the one that is active at the start first; empty if the machine has one spindle.
    pub heads: Vec<Head>,
    /// True if only the first head is in use, and a word that selects another one is refused.
    pub has_fixed_head: bool,
    /// Settings of the control.
    pub control: Control,
    /// Settable zero offsets by name: `G54` …
    pub zero_offsets: BTreeMap<String, FrameParts>,
    /// Values of zero offsets whose shift of X, Y and Z no file states: the offsets are not known, but further data complete them.
    pub partial_offsets: BTreeMap<String, FrameParts>,
    /// Statements about the setting of zero offsets, by their names.
    pub datums: BTreeMap<String, Datum>,
    /// Tools by number and edge.
    pub tools: Vec<Tool>,
    /// Wear of the tool radii, by number and edge, if the control stores it separately, mm.
    pub radius_wear_mm: BTreeMap<(u32, u32), f64>,
    /// Base frames that are active at the start of a program: those of the control from number 0, those of the channel from 16.
    pub base_frames: BTreeMap<i64, FrameParts>,
    /// R parameters that are not 0 at the start of a program.
    pub parameters: BTreeMap<i64, f64>,
    /// System variables that only the machine knows, by name and indices: `$MN_INT_INCR_PER_MM`, `$TC_DP6[1,1]`.
    pub system: BTreeMap<String, Setting>,
    /// Global variables that only the machine knows, by name.
    pub gud: BTreeMap<String, Setting>,
    /// Active compensation tables of the control.
    pub active_tables: ActiveTables,
    /// Axes in the order of their numbers in the tables of the control (AX1, AX2 …); `None` is an axis that ncfix does not know, such as a spindle. Empty means
    /// X Y Z U V W A B C, as far as they exist.
    pub axis_order: Vec<Option<Axis>>,
    /// Strain gauge that weighs workpieces.
    pub strain: Option<StrainGauge>,
    /// Sensors that show the weight of a workpiece at once.
    pub load_sensors: Vec<LoadSensor>,
    /// Servo behavior of the axes at feed.
    pub servo: Option<Servo>,
    /// Ranges in which the errors were measured; `None` if the file does not state them.
    pub measured: Option<MeasuredRanges>,
    /// Standard uncertainties of the errors; `None` if the file does not state them.
    pub uncertainty: Option<Uncertainty>,
}

/// Data of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisData {
    /// Axis.
    pub axis: Axis,
    /// Name in programs in addition to its letter, upper case (Sinumerik MD20080): `X1`.
    pub name: Option<String>,
    /// Motion of the moving body (the side away from F) in F for a positive command: unit vector; for rotary axes the axis of rotation.
    pub direction: Vector,
    /// Point on the axis line in F at the zero pose, mm.
    pub point_mm: Vector,
    /// Lowest and highest command, mm or rad; `None` without limits.
    pub travel: Option<[f64; 2]>,
    /// True for a modulo axis, whose positions are within one turn; it has no travel.
    pub modulo: bool,
    /// Position of a rotary axis at the beginning of every program, rad; `None` if the file does not state it.
    pub start_rad: Option<f64>,
    /// Maximum feed, mm/min or deg/min as in the file; `None` if not given.
    pub max_feed: Option<f64>,
    /// Clamps; while one of them is closed, the axis must not move.
    pub clamps: Vec<Clamp>,
    /// Place where location and motion errors act.
    pub lever: Lever,
}

/// Place of the motion errors of an axis in its transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lever {
    /// `L · D(e0) · M(q) · D(e) · L⁻¹`: errors move with the carriage (Esmaeili).
    #[default]
    Carried,
    /// `L · D(e0) · D(e) · M(q) · L⁻¹`: the lever arm includes the motion of the axis itself (Spaan eq. 2.7–2.9).
    Fixed,
}

/// Settings that differ between controls and affect positions or text.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Smallest increment of linear axes in a program, mm.
    pub increment_mm: f64,
    /// Smallest increment of rotary axes in a program, rad.
    pub increment_rad: f64,
    /// Increment of the words that the control reads, mm and rad. `--increment` changes only the increment of the output.
    pub grid: [f64; 2],
    /// True if the output is in inches; `None`: metric for programs that do not state their unit.
    pub output_inch: Option<bool>,
    /// True if the files in which the control saves offsets and tools are in inches; `None` if the machine file does not state their unit.
    pub saved_inch: Option<bool>,
    /// True if an inch has ten times as many increments as a millimeter, the grid of a Fanuc. LinuxCNC reads any decimals; there, a hundred times as many
    /// preserve the resolution of `increment_mm`.
    pub has_inch_grid: bool,
    /// The firmware, if the control is one of the Grbl family. They have no O words, at least not in programs that are sent to them.
    pub firmware: Option<Firmware>,
    /// Increments per millimeter of a Sinumerik (MD10200); `None` if the file does not state it.
    pub increments_per_mm: Option<f64>,
    /// Largest block number of the output, if blocks must have numbers; `None` without a limit.
    pub last_block_number: Option<u32>,
    /// Time that the control needs to prepare a block, s: it moves through a sequence of shorter blocks more slowly than programmed. `None` if the file
    /// does not state it.
    pub block_cycle_s: Option<f64>,
    /// Allowed radius difference of an arc, mm (Sinumerik MD21000, Fanuc parameter 3410).
    pub arc_tolerance_mm: f64,
    /// Sinumerik MD21010: allowed radius difference of an arc as a share of the radius.
    pub arc_tolerance_ratio: f64,
    /// Center of an arc with such a difference; `None`: as in the dialect.
    pub arc_center: Option<ArcCenter>,
    /// `true` if I, J, K point from the center of an arc to its start; usually they point from the start to the center (Fanuc), or are the position of
    /// the center (Grundig in G90).
    pub has_arc_words_from_center: bool,
    /// `true` if the words of the center choose the plane of an arc: J and K are those of YZ, whatever plane is selected (Grundig).
    pub takes_arc_plane_from_words: bool,
    /// Effect of T: immediately, or with M6 (Sinumerik MD22550).
    pub tool_change: ToolChange,
    /// Plane along whose axes the tool lengths lie, whichever plane is active (Sinumerik SD42940); `None`: those of the active plane.
    pub tool_length_plane: Option<Plane>,
    /// Edge that is active after a tool change (Sinumerik MD20270).
    pub edge_after_tool_change: u32,
    /// Sinumerik SD42440: true if an incremental word after a frame change also traverses the change.
    pub incremental_traverses_frame_change: bool,
    /// Order of rotation of the angles of `ROT` (Sinumerik MD10600).
    pub rotation_order: RotationOrder,
    /// True if naming an axis with `MIRROR` mirrors it whatever value follows; else the value 0 means no mirroring (Sinumerik MD10612).
    pub mirror_toggles: bool,
    /// True if a plain absolute word of a modulo axis takes the shortest path; else it stays within the turn (Sinumerik MD30455 bit 2).
    pub modulo_shortest: bool,
    /// Path of a modulo axis to an absolute position on a Fanuc, RS274/NGC or Grundig control; `None` if the file does not state it.
    pub rollover: Option<Rollover>,
    /// True if `>` and `<` treat reals that differ by 1e-12 of their size as equal, like the other four comparisons (Sinumerik MD10280 bit 0 is 0).
    pub relative_comparison: bool,
    /// Retract position of X, as [`Self::swivel_retract_z_mm`].
    pub swivel_retract_x_mm: Option<f64>,
    /// Retract position of Y, as [`Self::swivel_retract_z_mm`].
    pub swivel_retract_y_mm: Option<f64>,
    /// Retract position of Z before CYCLE800 swivels, machine position of the axis, mm; `None` if it is not known.
    pub swivel_retract_z_mm: Option<f64>,
    /// Rotary axis for the preferred direction of CYCLE800; `None`: the one that tilts the tool.
    pub swivel_direction_axis: Option<Axis>,
    /// True if shifts have a fine part, which `G59` programs (Sinumerik MD24000).
    pub fine_shift: bool,
    /// Maximum deviation of the line segments that replace a curve, mm. Such curves are a spline, an arc in a tilted plane or under unequal scale, and a
    /// straight line of a five-axis transformation.
    pub chord_tolerance_mm: f64,
    /// Programs and cycles that the control executes by itself: their calls are passed on.
    pub opaque: Vec<Opaque>,
    /// Names (upper case) of axes that the topology does not have: the control moves them, and their words are passed on.
    pub passed_on_axes: Vec<String>,
    /// Synchronized actions that may move axes, by ID.
    pub allow_synchronised: Vec<AllowedSynchronised>,
    /// Axis whose positions are diameters after DIAMON (Sinumerik MD20100).
    pub transverse_axis: Axis,
    /// Rotations of the tool by A2, B2, C2 (Sinumerik MD21100).
    pub orientation_angles: OrientationAngles,
    /// Axis about which TILT rotates the tool (Sinumerik MD21094, tens digit).
    pub tilt_about: TiltAbout,
    /// Extent to which ORIPATH keeps the tool relative to the path (Sinumerik MD21094, last digit).
    pub ori_path: OriPath,
    /// Distance from the pole below which a five-axis transformation moves the rotary axes linearly instead of along a great circle (Sinumerik MD24530,
    /// MD24540), rad.
    pub pole_limit_rad: f64,
    /// Folders that are searched for subprograms after that of the program, in order.
    pub search_path: Vec<String>,
    /// Modal codes that are active at the start and differ from those of the control as delivered (Sinumerik MD20150).
    pub initial_codes: Vec<String>,
    /// Working plane that is active at the start (Sinumerik MD20150).
    pub initial_plane: Plane,
    /// Maximum number of program levels, including the main program.
    pub max_program_levels: u32,
    /// Sinumerik MD20210: change of direction above which G451, too, goes around a corner on an arc, rad.
    pub compensation_corner_rad: f64,
    /// Sinumerik MD20230: change of direction below which G450, too, goes to the intersection, rad.
    pub compensation_flat_rad: f64,
    /// Sinumerik MD20250: maximum number of blocks without motion in the plane between two elements of a compensated contour.
    pub compensation_blocks_between: u32,
    /// Sinumerik MD20240: maximum number of elements of a compensated contour that may be omitted if the tool is too wide for them.
    pub compensation_look_ahead: u32,
    /// Approach and retraction of radius compensation (Fanuc parameter 5003).
    pub compensation_start: CompensationStart,
    /// Path around outer corners of a compensated contour (Fanuc parameter 19607); `None`: as in the dialect.
    pub compensation_corner: Option<CompensationCorner>,
    /// Settings of Fanuc and RS274/NGC.
    pub iso: IsoControl,
    /// Settings of custom macros.
    pub macros: MacroControl,
    /// Zero offset that is active at the start, such as `G500`, `G54`; `None`: that of the control as delivered.
    pub initial_zero_offset: Option<String>,
    /// Settings of Grundig, Philips and `MillPlus` only.
    pub grundig: GrundigControl,
}

/// Sequence of rotations by three orientation angles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OrientationAngles {
    /// C about Z, B about the new Y, A about the new X.
    #[default]
    Rpy,
    /// A about Z, B about the new X, C about the new Z.
    Euler,
}

/// Rotation axis of TILT.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TiltAbout {
    /// Surface normal, after LEAD.
    #[default]
    Normal,
    /// Path tangent, after LEAD.
    Tangent,
    /// Path tangent as rotated by LEAD.
    TurnedTangent,
}

/// Places where ORIPATH keeps the tool relative to path and surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OriPath {
    /// At block ends.
    #[default]
    End,
    /// Along the whole path.
    Path,
}

/// Word that makes a tool take effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToolChange {
    /// T selects, M6 changes.
    #[default]
    M6,
    /// T changes.
    T,
}

impl Default for Control {
    fn default() -> Self {
        Control {
            increment_mm: 1e-4,
            increment_rad: 1e-4_f64.to_radians(),
            grid: [1e-4, 1e-4_f64.to_radians()],
            output_inch: None,
            saved_inch: None,
            has_inch_grid: true,
            firmware: None,
            increments_per_mm: None,
            last_block_number: None,
            block_cycle_s: None,
            arc_tolerance_mm: 0.01,
            arc_tolerance_ratio: 0.001,
            arc_center: None,
            has_arc_words_from_center: false,
            takes_arc_plane_from_words: false,
            tool_change: ToolChange::M6,
            tool_length_plane: None,
            edge_after_tool_change: 1,
            incremental_traverses_frame_change: true,
            rotation_order: RotationOrder::Rpy,
            mirror_toggles: true,
            modulo_shortest: false,
            rollover: None,
            relative_comparison: true,
            swivel_retract_x_mm: None,
            swivel_retract_y_mm: None,
            swivel_retract_z_mm: None,
            swivel_direction_axis: None,
            fine_shift: false,
            chord_tolerance_mm: 2.5e-4,
            orientation_angles: OrientationAngles::Rpy,
            tilt_about: TiltAbout::Normal,
            ori_path: OriPath::End,
            pole_limit_rad: 2_f64.to_radians(),
            opaque: Vec::new(),
            passed_on_axes: Vec::new(),
            allow_synchronised: Vec::new(),
            transverse_axis: Axis::X,
            search_path: Vec::new(),
            initial_codes: Vec::new(),
            initial_plane: Plane::XY,
            max_program_levels: 16,
            compensation_corner_rad: 100_f64.to_radians(),
            compensation_flat_rad: 10_f64.to_radians(),
            compensation_blocks_between: 3,
            compensation_look_ahead: 4,
            compensation_start: CompensationStart::A,
            compensation_corner: None,
            iso: IsoControl::default(),
            macros: MacroControl::default(),
            initial_zero_offset: None,
            grundig: GrundigControl::default(),
        }
    }
}

impl Machine {
    /// Returns the index of a zero offset in [`Self::zero_offsets`]; `None` if it has no value there.
    #[must_use]
    pub fn zero_index(&self, name: &str) -> Option<u16> {
        self.zero_offsets.keys().position(|known| known == name).and_then(|index| u16::try_from(index).ok())
    }

    /// Returns the axes that the machine has.
    #[must_use]
    pub fn axis_set(&self) -> AxisSet {
        self.axes.iter().flatten().map(|axis| axis.axis).collect()
    }

    /// Returns the temperature rise of a sensor above its reference temperature, K, for a body that follows it with the time constant `lag_s`. `None` without
    /// a reading.
    #[must_use]
    pub fn rise_k(&self, condition: &Condition, sensor: &str, lag_s: f64) -> Option<f64> {
        Some(condition.temperature_c(sensor, lag_s)? - self.reference_of(sensor))
    }

    /// Returns [`Machine::rise_k`] for each condition. The computation is fastest if the conditions are in order of time.
    #[must_use]
    pub fn rises_k(&self, conditions: &[&Condition], sensor: &str, lag_s: f64) -> Vec<Option<f64>> {
        let reference_c = self.reference_of(sensor);
        let all = condition::temperatures_c(conditions.iter().copied(), sensor, lag_s);
        all.into_iter().map(|temperature_c| Some(temperature_c? - reference_c)).collect()
    }

    /// Returns the reference temperature of a sensor, °C.
    fn reference_of(&self, sensor: &str) -> f64 {
        self.sensor_references_c.get(sensor).copied().unwrap_or(self.reference_temperature_c)
    }

    /// Returns the spindle of a head by its index; that of the machine if it has no heads.
    #[must_use]
    pub fn spindle_of(&self, head: u16) -> &Spindle {
        self.heads.get(usize::from(head)).map_or(&self.spindle, |head| &head.spindle)
    }

    /// Returns the index of the head that an M word selects; `None` for another word.
    #[must_use]
    pub fn head_of_word(&self, number: u32) -> Option<u16> {
        let place = self.heads.iter().position(|head| head.select.contains(&number))?;
        u16::try_from(place).ok()
    }

    /// Returns the index of a head by its name.
    #[must_use]
    pub fn head_named(&self, name: &str) -> Option<usize> {
        self.heads.iter().position(|head| head.name == name)
    }

    /// True if a program may change the head.
    #[must_use]
    pub fn changes_heads(&self) -> bool {
        self.heads.len() > 1 && !self.has_fixed_head
    }

    /// Makes a head the one that is active at the start. An index without a head changes nothing.
    pub fn start_with_head(&mut self, index: usize) {
        if let Some(head) = self.heads.get(index) {
            self.spindle = head.spindle.clone();
            self.heads[..=index].rotate_right(1);
        }
    }

    /// Returns the data of an axis; `None` if the machine lacks it.
    #[must_use]
    pub fn axis(&self, axis: Axis) -> Option<&AxisData> {
        self.axes[axis.slot()].as_ref()
    }

    /// Returns the tool vector as rotated by the rotary axes of the tool side at an axis command, along the directions of F, mm.
    #[must_use]
    pub fn turned_tool_mm(&self, command: &AxisVector, tool_mm: &Vector) -> Vector {
        // The axis nearest to the tool rotates it first.
        let rotary = self.topology.tool.iter().rev().filter(|axis| axis.is_rotary());
        rotary.filter_map(|&axis| self.axis(axis)).fold(*tool_mm, |vector, data| {
            // Rodrigues' formula.
            let (sin, cos) = command[data.axis].sin_cos();
            let along = data.direction * data.direction.dot(&vector);
            along + (vector - along) * cos + data.direction.cross(&vector) * sin
        })
    }
}
