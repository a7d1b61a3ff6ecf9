//! The machine: chain of bodies, axes, travel, tools, zero offsets, control settings, and the state it is in.
//!
//! Says nothing of errors: `ncfix_model` adds them.

mod active;
mod axis_name;
mod chain;
mod clamp;
pub mod condition;
mod contour_control;
mod document;
pub mod edit;
pub mod file;
mod frame_control;
mod grundig_control;
mod iso_control;
mod kinematics;
mod macro_control;
mod opaque;
mod orientation;
pub mod origin;
mod output_control;
pub mod range;
mod section;
mod servo;
mod setting;
mod state;
mod strain;
mod tool;
mod travel;
mod zero_offset;

pub use active::{ActiveCompensation, ActiveTables, TableProducts};
pub use chain::{Branch, Topology, TopologyFault};
pub use clamp::Clamp;
pub use condition::{Condition, Load, ZeroPose};
pub use contour_control::{CompensationCorner, CompensationStart};
pub use frame_control::Rollover;
pub use grundig_control::{GrundigControl, ScaledAxes};
pub use iso_control::{DecimalPoint, IncrementSystem, IsoControl, LengthAxis, OneAxis};
pub use kinematics::Kinematics;
pub use macro_control::MacroControl;
pub use opaque::{AllowedSynchronised, Opaque};
pub use servo::{AxisServo, Servo};
pub use setting::Setting;
pub use state::State;
pub use strain::StrainGauge;
pub use tool::Tool;

use std::collections::BTreeMap;

use ncfix_base::geometry::{Axis, AxisSet, AxisVector, FrameParts, Plane, RotationOrder, Vector};

/// A machine as its file describes it. Lengths mm, angles rad, directions unit vectors in F at the zero pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// `machine.name`.
    pub name: String,
    /// Order of the bodies from workpiece to tool.
    pub topology: Topology,
    /// Dialect of its programs, as written (`sinumerik`); the register of dialects resolves it.
    pub controller: String,
    /// Temperature at which the model holds, °C.
    pub reference_temperature_c: f64,
    /// Temperatures of sensors at which the model holds, °C, where they are others than [`Self::reference_temperature_c`].
    pub sensor_references_c: BTreeMap<String, f64>,
    /// Axes by slot; `None` where the machine lacks the axis.
    pub axes: [Option<AxisData>; ncfix_base::geometry::AXIS_COUNT],
    /// Spindle.
    pub spindle: Spindle,
    /// Settings of the control.
    pub control: Control,
    /// Settable zero offsets by name, `G54` …
    pub zero_offsets: BTreeMap<String, FrameParts>,
    /// Tools by number and edge.
    pub tools: Vec<Tool>,
    /// Wear in the radii of tools, by number and edge, where the control tells it apart, mm.
    pub radius_wear_mm: BTreeMap<(u32, u32), f64>,
    /// Base frames that are active when a program starts: those of the control from number 0 on, those of the channel from 16 on.
    pub base_frames: BTreeMap<i64, FrameParts>,
    /// R parameters that are not 0 when a program starts.
    pub parameters: BTreeMap<i64, f64>,
    /// System variables that only the machine knows, by name and indices: `$MN_INT_INCR_PER_MM`, `$TC_DP6[1,1]`.
    pub system: BTreeMap<String, Setting>,
    /// Global variables that only the machine knows, by name.
    pub gud: BTreeMap<String, Setting>,
    /// Compensation tables that are switched on in the control.
    pub active_tables: ActiveTables,
    /// The axes in the order in which the control numbers them in its tables (AX1, AX2 …); empty for X Y Z U V W A B C as far as there are.
    pub axis_order: Vec<Axis>,
    /// The strain gauge that weighs workpieces.
    pub strain: Option<StrainGauge>,
    /// How the axes follow a program at feed.
    pub servo: Option<Servo>,
}

/// One axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisData {
    /// Which.
    pub axis: Axis,
    /// How programs name it beside its letter, upper case (Sinumerik MD20080): `X1`.
    pub name: Option<String>,
    /// Motion of the moving body (the side away from F) in F for a positive command: unit vector, turning axis for rotary axes.
    pub direction: Vector,
    /// A point of the axis line in F at the zero pose, mm.
    pub point_mm: Vector,
    /// Lowest and highest command, mm or rad; `None` without limits.
    pub travel: Option<[f64; 2]>,
    /// Whether it turns without end and its positions are those within a turn; then it has no travel.
    pub modulo: bool,
    /// Highest feed, mm/min or deg/min as in the file; `None` where not given.
    pub max_feed: Option<f64>,
    /// What clamps it; while one is closed, the axis must not move.
    pub clamps: Vec<Clamp>,
    /// How location and motion errors act.
    pub lever: Lever,
}

/// Where the motion errors of an axis act in its transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lever {
    /// `L · D(e0) · M(q) · D(e) · L⁻¹`: errors move with the carriage (Esmaeili).
    #[default]
    Carried,
    /// `L · D(e0) · D(e) · M(q) · L⁻¹`: the arm includes the axis's own motion (Spaan eq. 2.7–2.9).
    Fixed,
}

/// The spindle.
#[derive(Clone, Debug, PartialEq)]
pub struct Spindle {
    /// Gauge point in F at the zero pose, mm.
    pub origin_mm: Vector,
    /// Unit vector from the tip to the spindle.
    pub axis: Vector,
}

/// What differs from control to control and changes positions or text.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Smallest increment of linear axes in a program, mm.
    pub increment_mm: f64,
    /// Smallest increment of rotary axes in a program, rad.
    pub increment_rad: f64,
    /// The increment of the words that the control reads, mm and rad: that of the output unless an option has changed the latter.
    pub grid: [f64; 2],
    /// Whether the output is in inches; `None` for the metric one of programs that do not state their unit.
    pub output_inch: Option<bool>,
    /// Whether an inch has ten times as many increments as a millimeter, the grid of a Fanuc; LinuxCNC reads any decimals, and a hundred times
    /// as many keep what `increment_mm` asks for.
    pub has_inch_grid: bool,
    /// Increments into which a Sinumerik divides a millimeter (MD10200); `None` where the file does not say it.
    pub increments_per_mm: Option<f64>,
    /// The largest number of a block of the output, where blocks must have numbers; `None` without a limit.
    pub last_block_number: Option<u32>,
    /// Sinumerik MD21000: allowed radius difference of an arc, mm.
    pub arc_tolerance_mm: f64,
    /// Sinumerik MD21010: the same as a share of the radius.
    pub arc_tolerance_ratio: f64,
    /// Whether T takes effect at once, or with M6 (Sinumerik MD22550).
    pub tool_change: ToolChange,
    /// Plane along whose axes the tool lengths lie whatever plane is active (Sinumerik SD42940); `None`: along those of the active one.
    pub tool_length_plane: Option<Plane>,
    /// Edge that is active behind a tool change (Sinumerik MD20270).
    pub edge_after_tool_change: u32,
    /// Sinumerik SD42440: an incremental word behind a frame change also traverses the change.
    pub incremental_traverses_frame_change: bool,
    /// In which order the angles of `ROT` turn (Sinumerik MD10600).
    pub rotation_order: RotationOrder,
    /// Whether naming an axis with `MIRROR` mirrors it whatever value follows; else 0 means no (Sinumerik MD10612).
    pub mirror_toggles: bool,
    /// Whether a plain absolute word of a modulo axis goes the shortest way; else it stays within the turn (Sinumerik MD30455 bit 2).
    pub modulo_shortest: bool,
    /// How a rotary axis that turns without end gets to an absolute position on a Fanuc, RS274/NGC or Grundig control; `None` where the file
    /// does not say it.
    pub rollover: Option<Rollover>,
    /// Whether `>` and `<` take reals that differ by 1e-12 of their size as equal, as the other four comparisons do (Sinumerik MD10280
    /// bit 0 is 0).
    pub relative_comparison: bool,
    /// Where Z retracts to before CYCLE800 swivels, machine position of the axis, mm; `None` where it is not known.
    pub swivel_retract_z_mm: Option<f64>,
    /// The rotary axis to which the preferred direction of CYCLE800 relates; `None` for the one that tilts the tool.
    pub swivel_direction_axis: Option<Axis>,
    /// Whether shifts have a fine part, which `G59` programs (Sinumerik MD24000).
    pub fine_shift: bool,
    /// How far the straight pieces that stand for a curve – a spline, an arc in a tilted plane or under unequal scale, a straight line
    /// of a five-axis transformation – may be off it, mm.
    pub chord_tolerance_mm: f64,
    /// Programs and cycles that the control runs by itself: their calls are passed on.
    pub opaque: Vec<Opaque>,
    /// Synchronised actions that may move axes, by their ID.
    pub allow_synchronised: Vec<AllowedSynchronised>,
    /// The axis whose positions are diameters behind DIAMON (Sinumerik MD20100).
    pub transverse_axis: Axis,
    /// How A2, B2, C2 turn the tool (Sinumerik MD21100).
    pub orientation_angles: OrientationAngles,
    /// About what TILT turns the tool (Sinumerik MD21094, tens digit).
    pub tilt_about: TiltAbout,
    /// How far ORIPATH binds the tool to the path (Sinumerik MD21094, last digit).
    pub ori_path: OriPath,
    /// Nearer to its pole than this, a five-axis transformation moves the rotary axes linearly instead of along a great circle
    /// (Sinumerik MD24530, MD24540), rad.
    pub pole_limit_rad: f64,
    /// Folders in which subprograms are looked for beside that of the program, in order.
    pub search_path: Vec<String>,
    /// Modal codes that are active at the start and differ from those of the control as delivered (Sinumerik MD20150).
    pub initial_codes: Vec<String>,
    /// The working plane that is active at the start (Sinumerik MD20150).
    pub initial_plane: Plane,
    /// Program levels, main program included.
    pub max_program_levels: u32,
    /// Sinumerik MD20210: change of direction beyond which G451 goes around a corner on an arc too, rad.
    pub compensation_corner_rad: f64,
    /// Sinumerik MD20230: change of direction below which G450 goes to the intersection too, rad.
    pub compensation_flat_rad: f64,
    /// Sinumerik MD20250: blocks without motion in the plane that may stand between two elements of a compensated contour.
    pub compensation_blocks_between: u32,
    /// Sinumerik MD20240: elements of a compensated contour that may be left out where the tool is too wide for them.
    pub compensation_look_ahead: u32,
    /// How radius compensation begins and ends (Fanuc parameter 5003).
    pub compensation_start: CompensationStart,
    /// What lies around outer corners of a compensated contour (Fanuc parameter 19607); `None` for what the dialect says.
    pub compensation_corner: Option<CompensationCorner>,
    /// What concerns Fanuc and RS274/NGC.
    pub iso: IsoControl,
    /// What concerns custom macros.
    pub macros: MacroControl,
    /// `G500`, `G54`: the zero offset that is active at the start; `None` for that of the control as delivered.
    pub initial_zero_offset: Option<String>,
    /// What only Grundig, Philips and `MillPlus` have.
    pub grundig: GrundigControl,
}

/// The turns that three orientation angles stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OrientationAngles {
    /// C about Z, B about the new Y, A about the new X.
    #[default]
    Rpy,
    /// A about Z, B about the new X, C about the new Z.
    Euler,
}

/// The axis of TILT.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TiltAbout {
    /// The normal of the surface, behind LEAD.
    #[default]
    Normal,
    /// The tangent of the path, behind LEAD.
    Tangent,
    /// The tangent of the path as LEAD has turned it.
    TurnedTangent,
}

/// Where ORIPATH keeps the tool relative to path and surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OriPath {
    /// At the ends of blocks.
    #[default]
    End,
    /// All along the path.
    Path,
}

/// When a tool takes effect.
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
            has_inch_grid: true,
            increments_per_mm: None,
            last_block_number: None,
            arc_tolerance_mm: 0.01,
            arc_tolerance_ratio: 0.001,
            tool_change: ToolChange::M6,
            tool_length_plane: None,
            edge_after_tool_change: 1,
            incremental_traverses_frame_change: true,
            rotation_order: RotationOrder::Rpy,
            mirror_toggles: true,
            modulo_shortest: false,
            rollover: None,
            relative_comparison: true,
            swivel_retract_z_mm: None,
            swivel_direction_axis: None,
            fine_shift: false,
            chord_tolerance_mm: 2.5e-4,
            orientation_angles: OrientationAngles::Rpy,
            tilt_about: TiltAbout::Normal,
            ori_path: OriPath::End,
            pole_limit_rad: 2_f64.to_radians(),
            opaque: Vec::new(),
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
    /// The axes that the machine has.
    #[must_use]
    pub fn axis_set(&self) -> AxisSet {
        self.axes.iter().flatten().map(|axis| axis.axis).collect()
    }

    /// How much warmer a sensor is than where the model holds, K, for a body that follows it with `lag_s`; `None` without a reading.
    #[must_use]
    pub fn rise_k(&self, condition: &Condition, sensor: &str, lag_s: f64) -> Option<f64> {
        Some(condition.temperature_c(sensor, lag_s)? - self.reference_of(sensor))
    }

    /// [`Machine::rise_k`] in each of some conditions, which is fastest in the order of time.
    #[must_use]
    pub fn rises_k(&self, conditions: &[&Condition], sensor: &str, lag_s: f64) -> Vec<Option<f64>> {
        let reference_c = self.reference_of(sensor);
        let all = condition::temperatures_c(conditions.iter().copied(), sensor, lag_s);
        all.into_iter().map(|temperature_c| Some(temperature_c? - reference_c)).collect()
    }

    /// The temperature of a sensor at which the model holds, °C.
    fn reference_of(&self, sensor: &str) -> f64 {
        self.sensor_references_c.get(sensor).copied().unwrap_or(self.reference_temperature_c)
    }

    /// Data of an axis that the machine has.
    #[must_use]
    pub fn axis(&self, axis: Axis) -> Option<&AxisData> {
        self.axes[axis.slot()].as_ref()
    }

    /// The tool vector as the rotary axes of the tool side turn it at an axis command, along F's directions, mm.
    #[must_use]
    pub fn turned_tool_mm(&self, command: &AxisVector, tool_mm: &Vector) -> Vector {
        // The axis nearest to the tool turns it first.
        let rotary = self.topology.tool.iter().rev().filter(|axis| axis.is_rotary());
        rotary.filter_map(|&axis| self.axis(axis)).fold(*tool_mm, |vector, data| {
            // Rodrigues' formula.
            let (sin, cos) = command[data.axis].sin_cos();
            let along = data.direction * data.direction.dot(&vector);
            along + (vector - along) * cos + data.direction.cross(&vector) * sin
        })
    }
}
