//! A plan under construction: rows, and the path of the axes through them.

use crate::measure::data::{DataColumn, DataSet, Observation, number_of};
use crate::measure::reading::Reading;
use ncfix_base::diagnostic::Place;
use ncfix_base::geometry::{AXES, Arc, Axis, AxisSet, AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Machine, State};
use ncfix_machine::snc::{Dwell, FeedUnit, Kind, MotionMode, Move, RotaryDirection, Word, WordValue};
use ncfix_model::ErrorName;

use super::{MOST, PlanRefused, Wishes};

/// Margin of the travel limits, mm or rad.
pub(super) const ROOM: f64 = 1e-9;
/// Number of intervals for checking the travel of an arc.
const ARC_PARTS: u32 = 90;

/// Data of a row in addition to its observation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extra {
    /// Label of the repetition.
    pub run: String,
    /// Time, s.
    pub time_s: Option<f64>,
    /// Speed of the spindle, 1/min.
    pub speed: Option<f64>,
    /// Feed, mm/min.
    pub feed: Option<f64>,
    /// Weight on the table, N, and its position, mm.
    pub load: Option<(f64, Vector)>,
    /// A known move of the tool along the measured component in a test of signs, µm.
    pub moved_um: Option<f64>,
    /// A known turn about the measured component in a test of signs, µrad.
    pub moved_urad: Option<f64>,
    /// The feature of a workpiece that the row is about.
    pub feature: Option<PlannedFeature>,
}

/// A feature of a workpiece: a center or a face.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedFeature {
    /// Its name.
    pub name: String,
    /// Its level, from 1 at the top.
    pub level: u32,
    /// Its nominal position relative to the zero of the workpiece, mm.
    pub nominal_mm: Vector,
    /// The readings that it gives, of three: a center none along its axis, a face none along itself.
    pub reads: [bool; 3],
}

/// Zero and tool of a program in the coordinates of a workpiece.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedPart {
    /// The zero offset of the program: `G54`.
    pub zero_offset: String,
    /// Its position as that of the tool tip: axis positions plus tool vector, mm.
    pub origin_mm: Vector,
    /// The tool, by its number at the control.
    pub tool: u32,
    /// From the spindle gauge point to the tip, along the axes of F, mm.
    pub tool_mm: Vector,
}

/// Motion to further poses.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum PlanReach {
    /// None: the plan has no further poses.
    #[default]
    Never,
    /// On a sphere in pieces of this angle, at this feed.
    Sphere {
        /// Angle of a piece, rad.
        chord: f64,
        /// Feed.
        feed: f64,
    },
    /// From above the pose, down to `above_mm` over it.
    Above {
        /// Start of the approach, over the pose along the tool, mm.
        clearance_mm: f64,
        /// End of the approach, mm.
        above_mm: f64,
        /// `true` if the axis along the tool retracts to the end of its travel before others move.
        retract: bool,
        /// Feed.
        feed: f64,
    },
}

/// A plan.
#[derive(Clone, Debug)]
pub struct Builder {
    /// The measurement, without values.
    pub data: DataSet,
    /// One for every row.
    pub extras: Vec<Extra>,
    /// Content of the program.
    pub path: Vec<Kind>,
    /// Optional further rows.
    pub candidates: Vec<Observation>,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// `true` if its readings depend on the geometry, so that parameters may be evaluated.
    pub is_geometric: bool,
    /// Motion to further poses.
    pub reach: PlanReach,
    /// Action at a pose: a line, a dwell, or nothing.
    pub at_pose: Vec<Kind>,
    /// The readings of a displacement that are taken, of three.
    pub reads: [bool; 3],
    /// Zero and tool of its program; `None` for a program in machine coordinates.
    pub part: Option<PlannedPart>,
    /// The side from which poses are reached, in the workpiece; `None` for along the tool.
    pub(super) side: Option<Vector>,
    /// Current weight on the table, N, and its position, mm.
    pub(super) load: Option<(f64, Vector)>,
    pub(super) machine: Machine,
    pub(super) kinematics: Kinematics,
    margin_mm: f64,
    pub(super) last: Option<AxisVector>,
    /// `true` after the tool was retracted from the workpiece, until the next motion.
    pub(super) is_away: bool,
    state: State,
}

impl Builder {
    /// An empty plan.
    #[must_use]
    pub fn new(machine: &Machine, wishes: &Wishes, data: DataSet) -> Builder {
        Builder {
            data,
            extras: Vec::new(),
            path: Vec::new(),
            candidates: Vec::new(),
            notes: Vec::new(),
            is_geometric: true,
            reach: PlanReach::Never,
            at_pose: Vec::new(),
            reads: [true; 3],
            part: None,
            side: None,
            load: None,
            margin_mm: wishes.margin_mm(),
            machine: machine.clone(),
            kinematics: Kinematics::new(machine),
            last: None,
            is_away: false,
            state: State::default(),
        }
    }

    /// The command for a tip: a position of the tool tip, rotary axes at zero.
    pub(super) fn at_tip(&self, tip_mm: &Vector, tool_mm: &Vector) -> AxisVector {
        let mut command = AxisVector::ZERO;
        command.set_xyz(tip_mm - self.machine.turned_tool_mm(&command, tool_mm));
        command
    }

    /// Rounds to increments of the control; modulo axes to within a turn.
    pub(super) fn on_increments(&self, position: &AxisVector) -> AxisVector {
        let control = &self.machine.control;
        let mut out = *position;
        for data in self.machine.axes.iter().flatten() {
            let axis = data.axis;
            let increment = if axis.is_rotary() { control.increment_rad } else { control.increment_mm };
            if data.modulo {
                out[axis] = out[axis].rem_euclid(std::f64::consts::TAU);
            }
            if increment > 0.0 {
                out[axis] = (out[axis] / increment).round() * increment;
            }
        }
        out
    }

    /// The travel of an axis minus the margin: machine errors move an axis slightly when the tip is placed.
    pub(super) fn travel(&self, axis: Axis) -> Option<[f64; 2]> {
        let margin = if axis.is_rotary() { 0.0 } else { self.margin_mm };
        self.machine.axis(axis)?.travel.map(|[low, high]| [low + margin, high - margin])
    }

    /// The axis for which a position is outside the travel.
    pub(super) fn outside(&self, position: &AxisVector) -> Option<Axis> {
        AXES.into_iter().find(|&axis| match self.machine.axis(axis) {
            Some(_) => {
                let value = position[axis];
                let is_within = |[low, high]: [f64; 2]| (low - ROOM..=high + ROOM).contains(&value);
                !value.is_finite() || !self.travel(axis).is_none_or(is_within)
            }
            None => position[axis].abs() > ROOM,
        })
    }

    fn check(&self, position: &AxisVector) -> Result<(), PlanRefused> {
        if self.path.len() > MOST || self.extras.len() > MOST {
            return Err(PlanRefused(format!("the plan has more than {MOST} steps; use a larger step")));
        }
        let Some(axis) = self.outside(position) else { return Ok(()) };
        let Some(data) = self.machine.axis(axis) else {
            return Err(PlanRefused(format!(
                "the plan moves {axis}, which the machine {} does not have",
                self.machine.name
            )));
        };
        let show = |value: f64| ncfix_base::units::shown_position(axis.is_rotary(), value);
        let unit = if axis.is_rotary() { "deg" } else { "mm" };
        let [low, high] = data.travel.unwrap_or_default();
        let place = format!("{axis} would go to {:.4} {unit}", show(position[axis]));
        let travel = format!("its travel of {} to {} {unit}", show(low), show(high));
        let help = "move the center, or make the plan smaller";
        Err(PlanRefused(if (low..=high).contains(&position[axis]) {
            let margin = self.margin_mm;
            format!(
                "{place}, less than the margin of {margin} mm from an end of {travel}; {help}, or give a smaller --margin"
            )
        } else {
            format!("{place}, which is outside {travel}; {help}")
        }))
    }

    /// End of the path so far.
    #[must_use]
    pub fn last(&self) -> Option<AxisVector> {
        self.last
    }

    /// The readings of a row, of three.
    #[must_use]
    pub fn reads_of(&self, extra: &Extra) -> [bool; 3] {
        extra.feature.as_ref().map_or(self.reads, |feature| feature.reads)
    }

    /// The measurement as if it had been carried out, with readings of 0, its runs and its feeds.
    #[must_use]
    pub fn as_measured(&self) -> DataSet {
        let mut data = self.data.clone();
        data.is_plan = false;
        data.runs = Vec::new();
        for (row, extra) in data.observations.iter_mut().zip(&self.extras) {
            row.values = self.reads_of(extra).map(|is_read| is_read.then_some(0.0));
            row.run = number_of(&mut data.runs, &extra.run);
        }
        if self.extras.iter().any(|extra| extra.feed.is_some()) {
            let values = self.extras.iter().map(|extra| extra.feed.unwrap_or(f64::NAN)).collect();
            data.drivers.push(DataColumn { name: "feed_mm_min".to_owned(), values });
        }
        data
    }

    /// A straight move; at rapid without a feed.
    pub(super) fn go(&mut self, to: &AxisVector, feed: Option<f64>) -> Result<(), PlanRefused> {
        let to = self.on_increments(to);
        self.push(to, None, feed)
    }

    /// An arc about a center, given in abscissa and ordinate of its plane.
    pub(super) fn arc(&mut self, to: &AxisVector, arc: Arc, feed: f64) -> Result<(), PlanRefused> {
        let to = self.on_increments(to);
        if let Some(start) = self.last {
            for part in 1..ARC_PARTS {
                self.check(&arc.at(&start, &to, f64::from(part) / f64::from(ARC_PARTS)))?;
            }
        }
        self.push(to, Some(arc), Some(feed))
    }

    fn push(&mut self, to: AxisVector, arc: Option<Arc>, feed: Option<f64>) -> Result<(), PlanRefused> {
        self.push_named(to, arc, feed, self.machine.axis_set())
    }

    pub(super) fn push_named(
        &mut self,
        to: AxisVector,
        arc: Option<Arc>,
        feed: Option<f64>,
        named: AxisSet,
    ) -> Result<(), PlanRefused> {
        self.check(&to)?;
        if let Some(last) = &self.last {
            self.state.note_motion(last, &to);
        }
        self.last = Some(to);
        self.is_away = false;
        self.path.push(Kind::Move(Move {
            rapid: feed.is_none(),
            arc,
            target: to,
            named,
            known: self.machine.axis_set(),
            feed: feed.unwrap_or(0.0),
            feed_named: feed.is_some(),
            unit: FeedUnit::PerMinute,
            ways: [RotaryDirection::Plain; 3],
            in_machine_frame: true,
            motion_mode: MotionMode::Path,
            off_curve_mm: 0.0,
            tip: None,
            arc_basis: None,
        }));
        Ok(())
    }

    /// Updates directions of motion for a path between two positions.
    pub(super) fn note_motion(&mut self, from: &AxisVector, to: &AxisVector) {
        self.state.note_motion(from, to);
    }

    /// A row at a position, with the current directions of motion.
    pub(super) fn row(
        &mut self,
        position: &AxisVector,
        tool_mm: Vector,
        setup: usize,
        extra: Extra,
    ) -> Result<(), PlanRefused> {
        self.check(position)?;
        let extra = Extra { load: self.load, ..extra };
        let reading = Reading { position: *position, tool_mm, state: self.state };
        self.data.observations.push(observation(reading, setup));
        self.extras.push(extra);
        Ok(())
    }

    /// Sets the measured quantity of the last row.
    pub(super) fn of_last(&mut self, target: Option<usize>, component: Option<ErrorName>) {
        if let Some(row) = self.data.observations.last_mut() {
            row.target = target;
            row.component = component;
        }
    }

    /// Adds a comment and a program stop.
    pub(super) fn stop(&mut self, text: &str) {
        self.comment(text);
        self.words(&[(b'M', 0.0)]);
    }

    /// Adds a comment.
    pub(super) fn comment(&mut self, text: &str) {
        self.path.push(Kind::Comment(text.as_bytes().to_vec()));
    }

    /// Adds auxiliary words.
    pub(super) fn words(&mut self, words: &[(u8, f64)]) {
        let word = |&(letter, value): &(u8, f64)| Word { letter, extension: None, value: WordValue::Number(value) };
        self.path.push(Kind::Before(words.iter().map(word).collect()));
    }

    /// Adds a dwell.
    pub(super) fn dwell(&mut self, seconds: f64) {
        self.path.push(Kind::Dwell(Dwell::Seconds(seconds)));
    }

    /// Adds the action at a pose.
    pub(super) fn at_pose(&mut self) {
        self.path.extend_from_slice(&self.at_pose.clone());
    }
}

/// A row without values.
#[must_use]
pub(super) fn observation(reading: Reading, setup: usize) -> Observation {
    Observation {
        reading,
        setup,
        run: 0,
        t_s: None,
        condition: 0,
        temperature_c: None,
        feed: None,
        cycle: None,
        values: [None; 3],
        target: None,
        component: None,
        spindle_rad: 0.0,
        place: Place::default(),
    }
}
