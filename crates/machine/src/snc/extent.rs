//! Extent of a stream: range of the positions of each axis, and shortest and longest tool, where the program cuts.
//!
//! Feed moves count, from their start to their end. Rapid moves count only in a program without feed moves, because a retract to the end of the travel makes
//! no surface.

mod bare_tool;

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, TAU};

pub use bare_tool::BareTool;

use super::motion_mode::MotionMode;
use super::{Element, Kind, Move, Origin, Word, WordValue};
use bare_tool::BareTools;
use ncfix_base::geometry::{AXES, Arc, Axis, AxisSet, AxisVector, Matrix, Vector};

/// Angle between points of an arc in a tilted plane, rad: the path exceeds them by a thousandth of the radius.
const POINT_RAD: f64 = TAU / 72.0;

/// Ranges of the positions and tools of a stream, collected element by element.
#[derive(Clone, Debug, PartialEq)]
pub struct PathExtent {
    feed: Reach,
    rapid: Reach,
    /// Last position, and the axes whose position is known there.
    last: AxisVector,
    known: AxisSet,
    tool_mm: Vector,
    /// Index of the zero offset in force, and those in which axes moved.
    zero: Option<u16>,
    zeros: BTreeSet<u16>,
    /// Index of the active head, and those with which axes moved, with the zero offset there.
    head: u16,
    heads: BTreeSet<(u16, Option<u16>)>,
    /// First feed move that ends at an unknown position, and its axes.
    unknown: Option<(Origin, AxisSet)>,
    /// True from a tool change until Z is stated.
    is_changed: bool,
    /// First feed move of that time, its axes and the tool there: an approach, if Z is stated by a rapid move or with another tool length.
    approach: Option<(Origin, AxisSet, Vector)>,
    /// True from M6 to the first loss of positions or motion: that loss is the one of the tool change.
    is_loss_of_change: bool,
    /// Axes other than X, Y and Z with a place that only M6 has made uncertain. A tool changer moves the linear axes.
    kept: AxisSet,
    /// Axes other than X, Y and Z with a place before the last loss of all positions, until a motion.
    before_change: AxisSet,
    /// Axes that the stream has moved, or whose position something else has changed.
    moved: AxisSet,
    /// First feed moves at which the position of axes other than X, Y and Z is not known, whether a machine has them or not.
    assumed: Vec<AssumedAxis>,
    /// Tools that cut without a length.
    bare: BareTools,
}

/// A feed move at which the position of an axis is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssumedAxis {
    /// Place of the move.
    pub origin: Origin,
    /// The axis.
    pub axis: Axis,
    /// Position that counts as that of the axis, mm or rad: the last one of the stream, or 0.
    pub position: f64,
    /// True if the axis has moved since the beginning.
    pub has_moved: bool,
}

/// True for the word that changes the tool.
fn is_change(word: &Word) -> bool {
    word.letter == b'M' && word.extension.is_none() && word.value == WordValue::Number(6.0)
}

/// Positions and tools of one kind of moves.
#[derive(Clone, Debug, PartialEq)]
struct Reach {
    low: AxisVector,
    high: AxisVector,
    axes: AxisSet,
    /// Shortest and longest tool, from the gauge point of the spindle to the tip, mm.
    tools_mm: Option<[Vector; 2]>,
}

impl Default for Reach {
    fn default() -> Reach {
        Reach {
            low: AxisVector([f64::INFINITY; AXES.len()]),
            high: AxisVector([f64::NEG_INFINITY; AXES.len()]),
            axes: AxisSet::EMPTY,
            tools_mm: None,
        }
    }
}

impl Reach {
    fn position(&mut self, position: &AxisVector, axes: AxisSet) {
        for axis in axes.iter() {
            self.low[axis] = self.low[axis].min(position[axis]);
            self.high[axis] = self.high[axis].max(position[axis]);
        }
        self.axes = self.axes.union(axes);
    }

    fn coordinate(&mut self, axis: Axis, position: f64) {
        self.low[axis] = self.low[axis].min(position);
        self.high[axis] = self.high[axis].max(position);
    }

    fn tool(&mut self, tool_mm: Vector) {
        let [shortest, longest] = self.tools_mm.get_or_insert([tool_mm; 2]);
        let length_mm = tool_mm.norm();
        if length_mm < shortest.norm() {
            *shortest = tool_mm;
        }
        if length_mm > longest.norm() {
            *longest = tool_mm;
        }
    }

    /// Adds points of an arc in a tilted plane.
    fn tilted_arc(&mut self, arc: &Arc, basis: &Matrix, ends: [&AxisVector; 2]) {
        let [start, end] = ends.map(|end| {
            let mut flat = *end;
            flat.set_xyz(basis.tr_mul(&end.xyz()));
            flat
        });
        // A turn passes all directions: 1 to 72 points.
        let count = (arc.sweep_rad(&start, &end).abs().min(TAU) / POINT_RAD).ceil().max(1.0) as u32;
        for k in 0..=count {
            let mut point = arc.at(&start, &end, f64::from(k) / f64::from(count));
            point.set_xyz(basis * point.xyz());
            for axis in AxisSet::XYZ.iter() {
                self.coordinate(axis, point[axis]);
            }
        }
    }

    /// Adds the points of an arc at which one of its two axes turns back.
    fn arc(&mut self, arc: &Arc, start: &AxisVector, end: &AxisVector) {
        let [abscissa, ordinate, _] = arc.plane.axes();
        let radius_mm = arc.radius_mm(start).max(arc.radius_mm(end));
        let sweep_rad = arc.sweep_rad(start, end).abs();
        let start_rad = (start[ordinate] - arc.center_mm[1]).atan2(start[abscissa] - arc.center_mm[0]);
        let quarters = [(abscissa, 0, 1.0), (ordinate, 1, 1.0), (abscissa, 0, -1.0), (ordinate, 1, -1.0)];
        let mut angle_rad = 0.0;
        for (axis, row, sense) in quarters {
            let turned_rad = if arc.clockwise { start_rad - angle_rad } else { angle_rad - start_rad };
            if turned_rad.rem_euclid(TAU) <= sweep_rad {
                self.coordinate(axis, arc.center_mm[row] + sense * radius_mm);
            }
            angle_rad += FRAC_PI_2;
        }
    }
}

impl Default for PathExtent {
    fn default() -> PathExtent {
        PathExtent {
            feed: Reach::default(),
            rapid: Reach::default(),
            last: AxisVector::ZERO,
            known: AxisSet::EMPTY,
            tool_mm: Vector::zeros(),
            zero: None,
            zeros: BTreeSet::new(),
            head: 0,
            heads: BTreeSet::new(),
            unknown: None,
            is_changed: false,
            approach: None,
            is_loss_of_change: false,
            kept: AxisSet::EMPTY,
            before_change: AxisSet::EMPTY,
            moved: AxisSet::EMPTY,
            assumed: Vec::new(),
            bare: BareTools::default(),
        }
    }
}

impl PathExtent {
    /// An extent before the first element; `changes_at_t` if T changes the tool, and not M6.
    #[must_use]
    pub fn new(changes_at_t: bool) -> PathExtent {
        PathExtent { bare: BareTools::new(changes_at_t), ..PathExtent::default() }
    }

    /// Adds an element.
    pub fn see(&mut self, element: &Element) {
        match &element.kind {
            Kind::Move(motion) => self.motion(motion, element.origin),
            Kind::Setup(setup) => {
                (self.tool_mm, self.zero, self.head) = (setup.tool_mm, setup.zero, setup.head);
            }
            Kind::Lost(axes) => {
                let before = self.known.union(self.kept).difference(AxisSet::XYZ);
                let is_of_change = std::mem::take(&mut self.is_loss_of_change);
                self.kept = if is_of_change { before } else { self.kept.difference(*axes) };
                // The word may follow.
                let is_of_all = AxisSet::XYZ.difference(*axes) == AxisSet::EMPTY;
                self.before_change = if is_of_all { before } else { AxisSet::EMPTY };
                self.known = self.known.difference(*axes);
                // A tool change moves the linear axes; a reference point approach names its axes.
                if !is_of_change && *axes != AxisSet::ALL {
                    self.moved = self.moved.union(*axes);
                }
                if self.approach.is_some() {
                    self.end_approach(false);
                }
            }
            Kind::Before(words) | Kind::After(words) if words.iter().any(is_change) => self.change_tool(),
            Kind::Tool(word) => self.bare.select(word),
            _ => {}
        }
    }

    /// Ends the approach after a tool change; if it was none, it counts as a cut.
    fn end_approach(&mut self, is_approach: bool) {
        let taken = self.approach.take().filter(|_| !is_approach);
        self.unknown = self.unknown.or(taken.map(|(origin, axes, _)| (origin, axes)));
        self.is_changed = false;
    }

    fn change_tool(&mut self) {
        self.bare.change();
        self.end_approach(false);
        self.is_changed = true;
        self.is_loss_of_change = true;
        let before = self.known.union(std::mem::take(&mut self.before_change));
        self.kept = self.kept.union(before.difference(AxisSet::XYZ));
    }

    /// Returns the last position, mm and rad; that of unknown axes has no meaning.
    #[must_use]
    pub fn last(&self) -> &AxisVector {
        &self.last
    }

    /// Returns the tool in use, from the gauge point of the spindle to the tip, in F at the zero pose, mm.
    #[must_use]
    pub fn tool_mm(&self) -> &Vector {
        &self.tool_mm
    }

    /// Adds a position on the way of a move whose axes move along curves, mm and rad.
    pub fn pass(&mut self, motion: &Move, position: &AxisVector) {
        let known = self.known.intersection(motion.known);
        self.reach_of(motion).position(position, known);
    }

    fn reach_of(&mut self, motion: &Move) -> &mut Reach {
        let is_feed = !motion.rapid && motion.motion_mode != MotionMode::Reference;
        if is_feed { &mut self.feed } else { &mut self.rapid }
    }

    fn motion(&mut self, motion: &Move, origin: Origin) {
        let is_feed = !motion.rapid && motion.motion_mode != MotionMode::Reference;
        let reach = if is_feed { &mut self.feed } else { &mut self.rapid };
        reach.position(&self.last, self.known.intersection(motion.known));
        reach.position(&motion.target, motion.known);
        if let (Some(arc), Some(basis), None) = (&motion.arc, &motion.arc_basis, motion.tip) {
            reach.tilted_arc(arc, basis, [&self.last, &motion.target]);
        } else if let Some(arc) = motion.arc.as_ref().filter(|_| motion.tip.is_none()) {
            reach.arc(arc, &self.last, &motion.target);
        }
        reach.tool(self.tool_mm);
        let unknown = AxisSet::XYZ.difference(motion.known);
        if !unknown.contains(Axis::Z) {
            let has_other_length = self.approach.is_some_and(|(_, _, tool_mm)| tool_mm != self.tool_mm);
            self.end_approach(!is_feed || has_other_length);
        }
        if is_feed && unknown != AxisSet::EMPTY {
            let is_height_alone = unknown == [Axis::Z].into_iter().collect();
            if self.is_changed && is_height_alone && motion.arc.is_none() {
                self.approach = self.approach.or(Some((origin, unknown, self.tool_mm)));
            } else {
                self.end_approach(false);
                self.unknown = self.unknown.or(Some((origin, unknown)));
            }
        }
        let changes = |axis: &Axis| motion.target[*axis] != self.last[*axis];
        self.moved = self.moved.union(motion.named).union(self.known.iter().filter(changes).collect());
        self.is_loss_of_change = false;
        self.before_change = AxisSet::EMPTY;
        self.kept = self.kept.difference(motion.known);
        if is_feed {
            self.assume(motion, origin);
            if self.tool_mm == Vector::zeros() {
                self.bare.cut(origin);
            }
        }
        self.zeros.extend(self.zero);
        self.heads.insert((self.head, self.zero));
        self.last = motion.target;
        self.known = motion.known;
    }

    /// Notes the axes with an unknown position at a feed move.
    fn assume(&mut self, motion: &Move, origin: Origin) {
        let unknown = AxisSet::ALL.difference(AxisSet::XYZ).difference(motion.known);
        for axis in unknown.difference(self.kept).iter() {
            let has_moved = self.moved.contains(axis);
            if !self.assumed.iter().any(|one| one.axis == axis && one.has_moved == has_moved) {
                self.assumed.push(AssumedAxis { origin, axis, position: motion.target[axis], has_moved });
            }
        }
    }

    /// Returns the first feed move after which the position of a linear axis is not known, and these axes: neither the program nor a start position states it,
    /// or something outside the stream has moved them. A straight feed move in the plane between a tool change and the approach in Z is no cut.
    #[must_use]
    pub fn unknown(&self) -> Option<(Origin, AxisSet)> {
        self.unknown.or(self.approach.map(|(origin, axes, _)| (origin, axes)))
    }

    /// Returns the first feed moves at which the position of some of these axes is not known, and what counts as their position. At most two for each axis: one
    /// before it has moved, unless it is in `begun`, the axes with a known place at the beginning, and one after that.
    pub fn assumed(&self, among: AxisSet, begun: AxisSet) -> impl Iterator<Item = &AssumedAxis> {
        self.assumed.iter().filter(move |one| among.contains(one.axis) && (one.has_moved || !begun.contains(one.axis)))
    }

    /// Returns the tools that cut while the control adds no length, each with its first feed move of this kind.
    #[must_use]
    pub fn bare_tools(&self) -> &[BareTool] {
        self.bare.cuts()
    }

    /// Returns the indices of the heads with which axes moved.
    #[must_use]
    pub fn heads(&self) -> BTreeSet<u16> {
        self.heads.iter().map(|(head, _)| *head).collect()
    }

    /// Returns the indices of the zero offsets in which axes moved with a head.
    #[must_use]
    pub fn zeros_with(&self, head: u16) -> BTreeSet<u16> {
        self.heads.iter().filter(|(own, _)| *own == head).filter_map(|(_, zero)| *zero).collect()
    }

    /// Returns the indices of the zero offsets in which axes moved.
    #[must_use]
    pub fn zeros(&self) -> &BTreeSet<u16> {
        &self.zeros
    }

    fn reach(&self) -> &Reach {
        if self.feed.axes.is_empty() { &self.rapid } else { &self.feed }
    }

    /// Returns the axes whose position is known, with their lowest and highest position, mm or rad.
    pub fn axes(&self) -> impl Iterator<Item = (Axis, [f64; 2])> + '_ {
        let reach = self.reach();
        reach.axes.iter().map(|axis| (axis, [reach.low[axis], reach.high[axis]]))
    }

    /// Returns the shortest and the longest tool, from the gauge point of the spindle to the tip, in F at the zero pose, mm; `None` without moves.
    #[must_use]
    pub fn tools_mm(&self) -> Option<[Vector; 2]> {
        self.reach().tools_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::Plane;

    fn at(x: f64, y: f64) -> AxisVector {
        AxisVector([x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    #[test]
    fn an_arc_reaches_beyond_its_ends() {
        // From 0 to 90 degrees clockwise: three quarters of a circle of radius 10 about 100, 50.
        let arc = Arc { plane: Plane::XY, clockwise: true, center_mm: [100.0, 50.0], extra_turns: 0 };
        let mut reach = Reach::default();
        reach.arc(&arc, &at(110.0, 50.0), &at(100.0, 60.0));
        assert_eq!([reach.low[Axis::X], reach.high[Axis::X]], [90.0, 110.0]);
        assert_eq!([reach.low[Axis::Y], reach.high[Axis::Y]], [40.0, 60.0]);
        let mut short = Reach::default();
        let arc = Arc { clockwise: false, ..arc };
        short.arc(&arc, &at(110.0, 50.0), &at(100.0, 60.0));
        // A quarter turns back nowhere but at its ends.
        assert!(short.low[Axis::X] > 109.0 && short.low[Axis::Y] > 59.0, "{short:?}");
    }
}
