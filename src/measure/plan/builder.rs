//! A plan that grows: rows, and the path of the axes through them.

use crate::diagnostic::Place;
use crate::geometry::{AXES, Arc, Axis, AxisVector, Vector};
use crate::machine::{Kinematics, Machine, State};
use crate::measure::data::{DataSet, Observation};
use crate::measure::reading::Reading;
use crate::model::ErrorName;
use crate::snc::{Dwell, Kind, Manner, Move, Way, Word, WordValue};

use super::{MOST, Refused};

/// Travel limits are met with this in hand, mm or rad.
const ROOM: f64 = 1e-9;
/// Where the travel of an arc is looked at, parts of it.
const ARC_PARTS: u32 = 90;

/// What a row says beside its observation.
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
}

/// How further poses are reached.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Reach {
    /// They are not: the plan has no others.
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
        /// Where the way to a pose begins, over it along the tool, mm.
        clearance_mm: f64,
        /// Where it ends, mm.
        above_mm: f64,
        /// Whether the axis along the tool goes to the end of its travel before others move.
        retract: bool,
        /// Feed.
        feed: f64,
    },
}

/// A plan.
#[derive(Clone, Debug)]
pub struct Builder {
    /// The measurement; no row has a value.
    pub data: DataSet,
    /// One for every row.
    pub extras: Vec<Extra>,
    /// What a program does.
    pub path: Vec<Kind>,
    /// Rows that could be added.
    pub candidates: Vec<Observation>,
    /// What a user should know.
    pub notes: Vec<String>,
    /// Whether its readings are of the geometry, so that parameters can be asked about.
    pub is_geometric: bool,
    /// How further poses are reached.
    pub reach: Reach,
    /// What is done at a pose: a line, a time to wait, or nothing.
    pub at_pose: Vec<Kind>,
    /// Which of three readings of a displacement are taken.
    pub reads: [bool; 3],
    pub(super) machine: Machine,
    pub(super) kinematics: Kinematics,
    last: Option<AxisVector>,
    state: State,
}

impl Builder {
    /// An empty plan.
    #[must_use]
    pub fn new(machine: &Machine, data: DataSet) -> Builder {
        Builder {
            data,
            extras: Vec::new(),
            path: Vec::new(),
            candidates: Vec::new(),
            notes: Vec::new(),
            is_geometric: true,
            reach: Reach::Never,
            at_pose: Vec::new(),
            reads: [true; 3],
            machine: machine.clone(),
            kinematics: Kinematics::new(machine),
            last: None,
            state: State::default(),
        }
    }

    /// The command for a tip: a position at the tool point, rotary axes at zero.
    pub(super) fn at_tip(&self, tip_mm: &Vector, tool_mm: &Vector) -> AxisVector {
        let mut command = AxisVector::ZERO;
        command.set_xyz(tip_mm - self.machine.turned_tool_mm(&command, tool_mm));
        command
    }

    /// Whole increments of the control, within the turn on axes that turn without end.
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

    /// The axis that has no such position.
    pub(super) fn outside(&self, position: &AxisVector) -> Option<Axis> {
        AXES.into_iter().find(|&axis| match self.machine.axis(axis) {
            Some(data) => {
                let value = position[axis];
                !value.is_finite()
                    || data.travel.is_some_and(|[low, high]| !(low - ROOM..=high + ROOM).contains(&value))
            }
            None => position[axis].abs() > ROOM,
        })
    }

    fn check(&self, position: &AxisVector) -> Result<(), Refused> {
        if self.path.len() > MOST || self.extras.len() > MOST {
            return Err(Refused(format!("the plan has more than {MOST} steps; take a wider step")));
        }
        let Some(axis) = self.outside(position) else { return Ok(()) };
        let Some(data) = self.machine.axis(axis) else {
            return Err(Refused(format!("the plan moves {axis}, which the machine {} lacks", self.machine.name)));
        };
        let show = |value: f64| if axis.is_rotary() { value.to_degrees() } else { value };
        let unit = if axis.is_rotary() { "deg" } else { "mm" };
        let [low, high] = data.travel.unwrap_or_default();
        Err(Refused(format!(
            "{axis} would go to {:.4} {unit}, which is outside its travel of {} to {} {unit}; move the centre, or make the plan smaller",
            show(position[axis]),
            show(low),
            show(high)
        )))
    }

    /// Where the path stands.
    #[must_use]
    pub fn last(&self) -> Option<AxisVector> {
        self.last
    }

    /// A straight move; without a feed at rapid.
    pub(super) fn go(&mut self, to: &AxisVector, feed: Option<f64>) -> Result<(), Refused> {
        let to = self.on_increments(to);
        self.push(to, None, feed)
    }

    /// An arc about a center, abscissa and ordinate of its plane.
    pub(super) fn arc(&mut self, to: &AxisVector, arc: Arc, feed: f64) -> Result<(), Refused> {
        let to = self.on_increments(to);
        if let Some(start) = self.last {
            for part in 1..ARC_PARTS {
                self.check(&arc.at(&start, &to, f64::from(part) / f64::from(ARC_PARTS)))?;
            }
        }
        self.push(to, Some(arc), Some(feed))
    }

    fn push(&mut self, to: AxisVector, arc: Option<Arc>, feed: Option<f64>) -> Result<(), Refused> {
        self.check(&to)?;
        if let Some(last) = &self.last {
            self.state.note_motion(last, &to);
        }
        self.last = Some(to);
        self.path.push(Kind::Move(Move {
            rapid: feed.is_none(),
            arc,
            target: to,
            named: self.machine.axis_set(),
            known: self.machine.axis_set(),
            feed: feed.unwrap_or(0.0),
            feed_named: feed.is_some(),
            inverse_time: false,
            ways: [Way::Plain; 3],
            in_machine_frame: true,
            manner: Manner::Path,
        }));
        Ok(())
    }

    /// Notes senses of motion between places on the way.
    pub(super) fn note_motion(&mut self, from: &AxisVector, to: &AxisVector) {
        self.state.note_motion(from, to);
    }

    /// A row at a position, with the senses of motion so far.
    pub(super) fn row(
        &mut self,
        position: &AxisVector,
        tool_mm: Vector,
        setup: usize,
        extra: Extra,
    ) -> Result<(), Refused> {
        self.check(position)?;
        let reading = Reading { position: *position, tool_mm, state: self.state };
        self.data.observations.push(observation(reading, setup));
        self.extras.push(extra);
        Ok(())
    }

    /// What the last row measures.
    pub(super) fn of_last(&mut self, target: Option<usize>, component: Option<ErrorName>) {
        if let Some(row) = self.data.observations.last_mut() {
            row.target = target;
            row.component = component;
        }
    }

    /// A comment and a stop of the program.
    pub(super) fn stop(&mut self, text: &str) {
        self.comment(text);
        self.words(&[(b'M', 0.0)]);
    }

    /// A comment.
    pub(super) fn comment(&mut self, text: &str) {
        self.path.push(Kind::Comment(text.as_bytes().to_vec()));
    }

    /// Auxiliary words.
    pub(super) fn words(&mut self, words: &[(u8, f64)]) {
        let word = |&(letter, value): &(u8, f64)| Word { letter, extension: None, value: WordValue::Number(value) };
        self.path.push(Kind::Before(words.iter().map(word).collect()));
    }

    /// A time to wait.
    pub(super) fn dwell(&mut self, seconds: f64) {
        self.path.push(Kind::Dwell(Dwell::Seconds(seconds)));
    }

    /// What is done at a pose.
    pub(super) fn at_pose(&mut self) {
        self.path.extend_from_slice(&self.at_pose.clone());
    }

    /// Adds a candidate as a row and the way to it.
    ///
    /// # Errors
    /// Where the way leaves the travel.
    pub fn visit(&mut self, candidate: &Observation, run: &str) -> Result<(), Refused> {
        let position = self.on_increments(&candidate.reading.position);
        let tool_mm = candidate.reading.tool_mm;
        let mut extra = Extra { run: run.to_owned(), ..Extra::default() };
        if self.data.observations.last().is_some_and(|last| last.setup != candidate.setup) {
            let label = self.data.setups.get(candidate.setup).map_or_else(String::new, |setup| setup.label.clone());
            self.stop(&format!("set-up {label}"));
        }
        match self.reach.clone() {
            Reach::Never => return Err(Refused("the plan has no further poses".into())),
            Reach::Sphere { chord, feed } => {
                let setup = self.data.setups.get(candidate.setup);
                let centre = setup.map_or_else(Vector::zeros, |setup| setup.centre_mm);
                self.on_sphere(&centre, &tool_mm, &position, chord, feed)?;
                extra.feed = Some(feed);
            }
            Reach::Above { clearance_mm, above_mm, retract, feed } => {
                self.above(&position, &tool_mm, [clearance_mm, above_mm], retract, feed)?;
            }
        }
        // Where a ball is probed nobody commands: the row is exact.
        let exact = self.data.kind.name == "probe";
        let row = if exact { candidate.reading.position } else { position };
        self.row(&row, tool_mm, candidate.setup, extra)?;
        self.of_last(candidate.target, candidate.component);
        self.at_pose();
        if let Reach::Above { clearance_mm, feed, .. } = self.reach {
            let up = self.raised(&position, &tool_mm, clearance_mm)?;
            self.go(&up, Some(feed))?;
        }
        Ok(())
    }

    /// The position whose tip is so far off along the tool, towards the spindle.
    pub(super) fn raised(&self, position: &AxisVector, tool_mm: &Vector, by_mm: f64) -> Result<AxisVector, Refused> {
        let tip = self.kinematics.tip_mm(position, tool_mm) + self.kinematics.direction(position) * by_mm;
        let missing = || Refused(format!("the linear axes of {} cannot place the tool", self.machine.name));
        self.kinematics.placed(&tip, position, tool_mm).ok_or_else(missing)
    }

    /// Goes down to a pose from above it.
    fn above(
        &mut self,
        position: &AxisVector,
        tool_mm: &Vector,
        [clearance_mm, above_mm]: [f64; 2],
        retract: bool,
        feed: f64,
    ) -> Result<(), Refused> {
        let high = self.raised(position, tool_mm, clearance_mm)?;
        let low = self.raised(position, tool_mm, above_mm)?;
        if retract {
            let (which, sign) = super::along_spindle(&self.machine);
            let axis = [Axis::X, Axis::Y, Axis::Z][which.min(2)];
            let travel = self.machine.axis(axis).and_then(|data| data.travel);
            let top = travel.map(|[low, high]| if sign > 0.0 { high } else { low });
            if let (Some(top), Some(mut here)) = (top, self.last) {
                here[axis] = top;
                self.go(&here, None)?;
            }
            let mut over = high;
            over[axis] = top.unwrap_or(high[axis]);
            self.go(&over, None)?;
        }
        self.go(&high, Some(feed))?;
        self.go(&low, Some(feed))
    }

    /// Goes to a position on the sphere about a centre along a great circle, in chords; across the pole on the spindle's side where the
    /// way is not given.
    pub(super) fn on_sphere(
        &mut self,
        centre_mm: &Vector,
        tool_mm: &Vector,
        to: &AxisVector,
        chord: f64,
        feed: f64,
    ) -> Result<(), Refused> {
        let centre = self.at_tip(centre_mm, tool_mm).xyz();
        let Some(from) = self.last.map(|last| last.xyz() - centre) else { return self.go(to, Some(feed)) };
        let target = to.xyz() - centre;
        let (start, end) = (from.norm(), target.norm());
        if start < ROOM || end < ROOM {
            return self.go(to, Some(feed));
        }
        let (one, other) = (from / start, target / end);
        let (which, sign) = super::along_spindle(&self.machine);
        let mut way = vec![one, other];
        if one.dot(&other) < -0.999 {
            let mut pole = Vector::zeros();
            pole[which] = sign;
            way.insert(1, if one.dot(&pole).abs() > 0.9 { Vector::ith((which + 1) % 3, 1.0) } else { pole });
        }
        let legs = way.len() - 1;
        for (leg, pair) in way.windows(2).enumerate() {
            let is_last = leg + 1 == legs;
            let &[one, other] = pair else { continue };
            let angle = one.dot(&other).clamp(-1.0, 1.0).acos();
            let pieces = (angle / chord.max(1e-4)).ceil().max(1.0) as usize;
            for piece in 1..=pieces {
                let share = piece as f64 / pieces as f64;
                let turned = if angle > 1e-9 {
                    (one * ((1.0 - share) * angle).sin() + other * (share * angle).sin()) / angle.sin()
                } else {
                    other
                };
                let mut next = *to;
                let radius = if is_last { start + (end - start) * share } else { start };
                next.set_xyz(centre + turned * radius);
                self.go(&next, Some(feed))?;
            }
        }
        Ok(())
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
        values: [None; 3],
        target: None,
        component: None,
        spindle_rad: 0.0,
        place: Place::default(),
    }
}
