//! Drives the machine by the elements of a program, or by the pieces of a corrected one.
//!
//! Blocks are passed without stop, except at an exact stop of the language, a dwell, a tool or M word, and between rapid and feed moves. The axes
//! also stop for motions of the control itself: to a reference point, or until a probe touches.

use std::sync::Arc;

use super::chord::{MoveSpeed, ServoMove, SpaceCircle};
use super::drive::Drive;
use super::follow::CycleState;
use crate::path::{CorrectionOptions, Increments, Output, OutputFrame, Piece, PieceArc};
use ncfix_base::geometry::{Arc as PlaneArc, AxisSet, AxisVector, Matrix, Plane, ROTARY_AXES, Vector};
use ncfix_dialect::{BlockEnd, BlockEnds};
use ncfix_machine::machine::{Kinematics, Machine, Servo, TipPath};
use ncfix_machine::snc::{Dwell, Element, FeedUnit, Kind, MotionMode, Setup, Turning, Word, WordValue};
use ncfix_model::Model;

/// A program on a machine.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    drive: Drive<'a>,
    kinematics: Kinematics,
    /// Largest distance of the tip from its path in the workpiece for a straight motion of the axes, mm.
    chord_tolerance_mm: f64,
    increments: Increments,
    is_work_frame: bool,
    keeps_transform: bool,
    setup: Arc<Setup>,
    /// Feed unit of the last move.
    unit: FeedUnit,
    /// Programmed spindle speed, 1/min.
    spindle_rpm: f64,
    block_ends: BlockEnds,
    stops: bool,
    stops_once: bool,
    /// `true` if the last move was rapid.
    is_rapid: bool,
    known: AxisSet,
    /// Feed that replaces the programmed one in all feed moves, mm/min.
    feed_mm_min: Option<f64>,
}

/// A move to execute, from an element or a piece.
struct Order {
    target: AxisVector,
    circle: Option<SpaceCircle>,
    /// Some if the tip follows the line, or the arc `tip_arc`, in the workpiece.
    tip: Option<Turning>,
    tip_arc: Option<(PlaneArc, Option<Matrix>)>,
    rapid: bool,
    feed: f64,
    motion_mode: MotionMode,
    unit: FeedUnit,
    named: AxisSet,
    known: AxisSet,
}

impl<'a> Run<'a> {
    /// A machine before the first block. `options` are those of the correction if pieces are to be executed.
    #[must_use]
    pub fn new(machine: &Machine, servo: &Servo, model: &'a Model, options: &CorrectionOptions) -> Run<'a> {
        let mut drive = Drive::new(machine, servo, model);
        let mut known = AxisSet::EMPTY;
        if let Some(start) = options.start {
            drive.jump(&start, &mut |_| {});
            known = machine.axis_set();
        }
        Run {
            drive,
            kinematics: Kinematics::new(machine),
            chord_tolerance_mm: machine.control.chord_tolerance_mm,
            increments: Increments::new(&machine.control),
            is_work_frame: options.frame == OutputFrame::Work,
            keeps_transform: options.keeps_transform(),
            setup: Arc::default(),
            unit: FeedUnit::default(),
            spindle_rpm: 0.0,
            block_ends: ncfix_dialect::find(&machine.controller).map_or(BlockEnds::NONE, |dialect| dialect.block_ends),
            stops: false,
            stops_once: false,
            is_rapid: false,
            known,
            feed_mm_min: None,
        }
    }

    /// Uses one feed, mm/min, for all feed moves along the path.
    #[must_use]
    pub fn with_feed(self, feed_mm_min: f64) -> Run<'a> {
        Run { feed_mm_min: Some(feed_mm_min), ..self }
    }

    /// Executes an element of a program; `block` identifies it in the results.
    pub fn element(&mut self, element: &Element, block: u64, see: &mut dyn FnMut(&CycleState)) {
        let Kind::Move(motion) = &element.kind else {
            self.other(&element.kind, see);
            return;
        };
        let start = self.drive.standing().copied().unwrap_or(motion.target);
        let order = Order {
            target: motion.target,
            circle: motion
                .arc
                .filter(|_| motion.tip.is_none())
                .map(|arc| SpaceCircle::of_arc(&arc, motion.arc_basis.as_ref(), &start)),
            tip: motion.tip,
            tip_arc: motion.arc.filter(|_| motion.tip.is_some()).map(|arc| (arc, motion.arc_basis)),
            rapid: motion.rapid,
            feed: motion.feed,
            motion_mode: motion.motion_mode,
            unit: motion.unit,
            named: motion.named,
            known: motion.known,
        };
        self.order(&order, block, see);
    }

    /// Executes a piece of a corrected program, or an element between pieces.
    pub fn output(&mut self, output: &Output, block: u64, see: &mut dyn FnMut(&CycleState)) {
        match output {
            Output::Element(element) => self.element(element, block, see),
            // A simulation has the moves of a cycle.
            Output::Cycle(_) => {}
            Output::Piece(piece) => {
                let order = self.order_of(piece);
                self.order(&order, block, see);
            }
        }
    }

    /// Ends the program.
    pub fn finish(&mut self, see: &mut dyn FnMut(&CycleState)) {
        self.drive.finish(see);
    }

    /// Time so far, without moves in the look-ahead, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.drive.time_s()
    }

    /// `true` if a chord took more than an hour and was therefore not simulated.
    #[must_use]
    pub fn has_left_out(&self) -> bool {
        self.drive.has_left_out()
    }

    /// Converts a speed in mm/min to the feed unit of the program; `None` if that unit has no equivalent.
    #[must_use]
    pub fn feed_at(&self, feed_mm_min: f64) -> Option<f64> {
        match self.unit {
            FeedUnit::PerMinute => Some(feed_mm_min),
            FeedUnit::PerTurn => (self.spindle_rpm > 0.0).then(|| feed_mm_min / self.spindle_rpm),
            FeedUnit::InverseTime => None,
        }
    }

    fn order_of(&self, piece: &Piece) -> Order {
        let start = self.drive.standing().copied().unwrap_or(piece.command);
        let turns = ROTARY_AXES.iter().any(|&axis| start[axis] != piece.command[axis]);
        let transform = self.setup.transform.filter(|_| self.keeps_transform);
        let tip = transform.filter(|_| turns || piece.arc.is_some());
        Order {
            target: piece.command,
            circle: piece.arc.filter(|_| tip.is_none()).map(|arc| self.circle_of(piece, &arc, &start)),
            tip,
            tip_arc: piece.arc.filter(|_| tip.is_some()).map(|arc| self.tip_arc_of(piece, &arc, &start)),
            rapid: piece.rapid,
            feed: piece.feed,
            motion_mode: piece.motion_mode,
            unit: piece.unit,
            named: piece.words,
            known: piece.known,
        }
    }

    /// The circle of a piece, whose center refers to the emitted frame.
    fn circle_of(&self, piece: &Piece, arc: &PieceArc, start: &AxisVector) -> SpaceCircle {
        let spatial = arc.spatial(&piece.counts, &self.increments);
        let [_, _, across] = arc.plane.axes();
        let mut normal = Vector::zeros();
        normal[across.slot()] = if arc.clockwise { -1.0 } else { 1.0 };
        let mut center = Vector::zeros();
        for (slot, axis) in ncfix_base::geometry::LINEAR_AXES.into_iter().take(3).enumerate() {
            center[slot] = self.increments.position(axis, arc.center_counts[slot]);
        }
        if let Some(circle) = spatial {
            (center, normal) = (circle.to_center, circle.normal);
        }
        if self.is_work_frame {
            let linear = self.setup.frame.linear();
            center = linear * center;
            // A mirrored arc turns the other way.
            normal = linear * normal * linear.determinant().signum();
        }
        let normal = normal.try_normalize(0.0).unwrap_or(normal);
        SpaceCircle { center: start.xyz() + center, normal, extra_turns: arc.extra_turns }
    }

    /// The circle of a piece under a transformation, in positions fixed to the workpiece, with its basis.
    fn tip_arc_of(&self, piece: &Piece, arc: &PieceArc, start: &AxisVector) -> (PlaneArc, Option<Matrix>) {
        let position = self.kinematics.on_workpiece(start, &self.setup.tool_mm);
        let SpaceCircle { center, normal, extra_turns } = self.circle_of(piece, arc, &position);
        // Any direction of the plane, such as that of the start.
        let out = position.xyz() - center;
        let first = (out - normal * out.dot(&normal)).try_normalize(0.0).unwrap_or_else(Vector::x);
        let basis = Matrix::from_columns(&[first, normal.cross(&first), normal]);
        let center = basis.tr_mul(&center);
        let arc = PlaneArc { plane: Plane::XY, clockwise: false, center_mm: [center.x, center.y], extra_turns };
        (arc, Some(basis))
    }

    /// Executes a move whose tip follows a path in the workpiece as chords that are straight in the axes.
    fn follow_tip(&mut self, order: &Order, turning: Turning, block: u64, see: &mut dyn FnMut(&CycleState)) {
        let Some(start) = self.drive.standing().copied() else {
            self.drive.jump(&order.target, see);
            return;
        };
        let tool_mm = self.setup.tool_mm;
        let follows_circle = turning == Turning::Vector;
        let whole = self.pace(order);
        let Run { drive, kinematics, .. } = self;
        let path = TipPath::new(kinematics, follows_circle, [&start, &order.target], &tool_mm);
        path.divide(
            order.tip_arc.as_ref().map(|(arc, basis)| (arc, basis.as_ref())),
            self.chord_tolerance_mm,
            |target, share, _| {
                let pace = match whole {
                    MoveSpeed::Time(time_s) => MoveSpeed::Time(time_s * share),
                    other => other,
                };
                drive.go(&ServoMove { target, circle: None, pace, is_tip_feed: true, block }, see);
            },
        );
    }

    fn order(&mut self, order: &Order, block: u64, see: &mut dyn FnMut(&CycleState)) {
        let starts_at_known = order.named.difference(self.known).is_empty();
        self.known = self.known.union(order.known);
        self.unit = order.unit;
        if !starts_at_known {
            self.drive.jump(&order.target, see);
            return;
        }
        let is_alone =
            matches!(order.motion_mode, MotionMode::Positioning | MotionMode::Reference | MotionMode::Probe(_));
        if is_alone || order.rapid != self.is_rapid {
            self.drive.stop(see);
        }
        self.is_rapid = order.rapid;
        if let Some(turning) = order.tip {
            self.follow_tip(order, turning, block, see);
        } else {
            self.go(order, block, see);
        }
        if is_alone || self.stops || self.stops_once {
            self.drive.stop(see);
        }
        self.stops_once = false;
    }

    fn go(&mut self, order: &Order, block: u64, see: &mut dyn FnMut(&CycleState)) {
        let motion = ServoMove {
            target: order.target,
            circle: order.circle,
            pace: self.pace(order),
            is_tip_feed: self.keeps_transform && self.setup.transform.is_some(),
            block,
        };
        self.drive.go(&motion, see);
    }

    fn pace(&self, order: &Order) -> MoveSpeed {
        if order.rapid || matches!(order.motion_mode, MotionMode::Positioning | MotionMode::Reference) {
            return MoveSpeed::Rapid;
        }
        if let MotionMode::Thread(thread) = order.motion_mode
            && let Some((_, lead_mm)) = thread.lead
        {
            return MoveSpeed::Feed(lead_mm.abs() * self.spindle_rpm / 60.0);
        }
        if let Some(feed_mm_min) = self.feed_mm_min {
            return MoveSpeed::Feed(feed_mm_min / 60.0);
        }
        if order.unit == FeedUnit::InverseTime {
            return MoveSpeed::Time(if order.feed > 0.0 { 60.0 / order.feed } else { 0.0 });
        }
        match order.unit {
            FeedUnit::PerTurn => MoveSpeed::Feed(order.feed * self.spindle_rpm / 60.0),
            _ => MoveSpeed::Feed(order.feed / 60.0),
        }
    }

    fn other(&mut self, kind: &Kind, see: &mut dyn FnMut(&CycleState)) {
        match kind {
            Kind::Setup(setup) => {
                self.drive.change_tool(&setup.tool_mm, see);
                self.setup = Arc::clone(setup);
            }
            Kind::Dwell(Dwell::Seconds(time_s)) => self.drive.wait(time_s.max(0.0), see),
            Kind::Dwell(Dwell::Turns(turns)) => {
                let time_s = if self.spindle_rpm > 0.0 { turns.abs() * 60.0 / self.spindle_rpm } else { 0.0 };
                self.drive.wait(time_s, see);
            }
            Kind::Tool(_) => self.drive.stop(see),
            Kind::Lost(axes) => {
                self.drive.stop(see);
                self.known = self.known.difference(*axes);
            }
            Kind::Before(words) | Kind::After(words) => {
                words.iter().for_each(|word| self.note_spindle(word));
                if words.iter().any(|word| word.letter == b'M') {
                    self.drive.stop(see);
                }
            }
            Kind::Keep(word) => self.mode(word),
            Kind::Verbatim(words) => {
                let first = words.split(|&byte| byte == b' ').next().and_then(|word| std::str::from_utf8(word).ok());
                if let Some(word) = first {
                    self.mode(word);
                }
            }
            _ => {}
        }
    }

    fn note_spindle(&mut self, word: &Word) {
        if let (b'S', None | Some(1), WordValue::Number(value)) = (word.letter, word.extension, &word.value) {
            self.spindle_rpm = value.abs();
        }
    }

    fn mode(&mut self, word: &str) {
        match self.block_ends.of(word) {
            Some(BlockEnd::Exact) => self.stops = true,
            Some(BlockEnd::Running) => self.stops = false,
            Some(BlockEnd::Once) => self.stops_once = true,
            None => {}
        }
    }
}

/// Statistics of the contouring error over a program: distances from the path in each cycle of feed moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    cycles: u64,
    squares: f64,
    /// The largest distance, mm.
    pub max_mm: f64,
    /// The block of the largest distance.
    pub max_at: u64,
}

impl Tally {
    /// Adds a moment.
    pub fn note(&mut self, moment: &CycleState) {
        let Some(on_path) = moment.on_path.filter(|on_path| !on_path.is_rapid) else { return };
        let off_mm = on_path.off_mm.norm();
        self.cycles += 1;
        self.squares += off_mm * off_mm;
        if off_mm > self.max_mm {
            (self.max_mm, self.max_at) = (off_mm, on_path.block);
        }
    }

    /// Root mean square over the cycles, mm.
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        if self.cycles == 0 { 0.0 } else { (self.squares / self.cycles as f64).sqrt() }
    }

    /// Number of cycles in the statistics.
    #[must_use]
    pub fn cycles(&self) -> u64 {
        self.cycles
    }
}
