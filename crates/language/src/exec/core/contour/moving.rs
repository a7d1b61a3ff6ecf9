//! A motion in the stage: its curve in plane coordinates, and its form after the curve changes.

use super::contour_request::ContourRequest;
use super::curve::{Curve, Flat, SAME_MM, distance};
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::path::{Path, Shape};
use crate::exec::core::sagitta::chord_count;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, LINEAR_AXES, PlaneBasis};
use ncfix_machine::snc::{Element, Kind, MotionMode};

/// A motion, its element, and its contour request. The kind of the element is a placeholder.
#[derive(Clone, Debug)]
pub(in crate::exec) struct Moving {
    pub(in crate::exec) path: Path,
    pub(in crate::exec) element: Element,
    pub(in crate::exec) wish: ContourRequest,
    /// Its compensation word for the control.
    pub(in crate::exec) switch: Switch,
}

/// An input or output item of the stage.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly all are the large one; a box would be an allocation for each")]
pub(in crate::exec) enum Item {
    /// Anything without motion.
    Element(Element),
    /// A motion.
    Path(Box<Moving>),
}

/// Largest distance of straight pieces from an arc at rapid, mm.
const RAPID_CHORD_MM: f64 = 1e-3;
/// Tolerance of equal plane directions.
const SAME_PLANE: f64 = 1e-9;

impl Moving {
    /// A motion as programmed in its block.
    pub(in crate::exec) fn new(path: Path, element: Element, wish: ContourRequest) -> Moving {
        Moving { path, element, wish, switch: Switch::None }
    }

    /// `true` if it moves in the working plane.
    pub(super) fn is_plane_motion(&self) -> bool {
        match self.path.shape {
            Shape::Line => {
                let (start, end) =
                    (self.path.basis.flat(&self.path.start), self.path.basis.flat(&self.path.motion.target));
                distance(start, end) > SAME_MM
            }
            Shape::Arc { .. } | Shape::Chords(_) => true,
        }
    }

    /// `true` if it goes to a machine position in the plane, even one near the programmed position: the tool is beside the contour.
    pub(super) fn goes_off_contour(&self) -> bool {
        let motion = &self.path.motion;
        (motion.in_machine_frame || motion.motion_mode == MotionMode::Positioning) && self.names_plane()
    }

    /// `true` if its block names an axis of the plane.
    pub(super) fn names_plane(&self) -> bool {
        !self.path.motion.named.intersection(plane_axes(&self.path.basis)).is_empty()
    }

    /// Its curve in the coordinates of a basis; `None` if it has none.
    pub(super) fn curve(&self, basis: &PlaneBasis) -> Option<Curve> {
        let (start, end) = (basis.flat(&self.path.start), basis.flat(&self.path.motion.target));
        let curve = match &self.path.shape {
            Shape::Line => Curve::Line { start, end },
            Shape::Arc { clockwise, center, extra_turns } => {
                let own = &self.path.basis;
                let center = if own == basis { *center } else { at_height(basis, own, *center) };
                Curve::arc(start, end, center, *clockwise, *extra_turns)
            }
            Shape::Chords(_) => return None,
        };
        (curve.is_finite() && curve.length() > 0.0).then_some(curve)
    }

    /// The motion along another curve, from a position; the ends of heights and other axes stay.
    pub(super) fn along(&self, curve: &Curve, basis: PlaneBasis, from: AxisVector) -> Moving {
        self.ending(curve, basis, from, self.path.motion.target)
    }

    /// The motion along another curve, with other ends of the heights and other axes.
    pub(super) fn ending(&self, curve: &Curve, basis: PlaneBasis, from: AxisVector, other_axes: AxisVector) -> Moving {
        let mut out = self.clone();
        out.path.start = from;
        out.path.basis = basis;
        out.path.motion.target = basis.moved(&other_axes, curve.end());
        out.path.motion.named = out.path.motion.named.union(plane_axes(&basis));
        out.path.shape = match *curve {
            // An arc shortened to zero length must not become a full circle.
            _ if curve.length() < SAME_MM => Shape::Line,
            Curve::Line { .. } => Shape::Line,
            // Rapid motion is straight.
            Curve::Arc { .. } if out.path.motion.rapid => {
                Shape::Chords(chords(curve, &basis, &from, &out.path.motion.target))
            }
            Curve::Arc { center, sweep, .. } => {
                Shape::Arc { clockwise: sweep < 0.0, center, extra_turns: curve.extra_turns() }
            }
        };
        out
    }

    /// A further motion of the same block, after this one.
    pub(super) fn further(&self) -> Moving {
        let mut out = self.clone();
        out.element.starts_block = false;
        out.element.number = None;
        out.path.motion.feed_named = false;
        out.switch = Switch::None;
        out
    }

    /// The motion with the plane coordinates of a position.
    pub(super) fn carried(mut self: Box<Self>, basis: &PlaneBasis, from: AxisVector) -> Box<Self> {
        let flat = basis.flat(&from);
        self.path.start = from;
        self.path.motion.target = basis.moved(&self.path.motion.target, flat);
        self.path.shape = Shape::Line;
        self
    }

    /// A fault at the block.
    pub(super) fn fault(&self, code: Code, message: impl Into<String>, help: &str) -> Fault {
        fault(code, self.wish.span, message, help).of_file(self.wish.file)
    }
}

impl Item {
    pub(super) fn element(&self) -> &Element {
        match self {
            Item::Element(element) => element,
            Item::Path(moving) => &moving.element,
        }
    }

    /// `true` if a control counts its block as one without motion in the plane.
    pub(super) fn counts(&self) -> bool {
        match self {
            Item::Element(element) => {
                let kind = &element.kind;
                !matches!(kind, Kind::Comment(_) | Kind::Label(_) | Kind::Empty | Kind::Header(_) | Kind::Setup(_))
            }
            Item::Path(_) => true,
        }
    }
}

/// Removes the items at the end of `items` that belong to the block of the next motion.
pub(super) fn own_of(items: &mut Vec<Item>, next: &Element) -> Vec<Item> {
    if next.starts_block {
        return Vec::new();
    }
    let mut at = items.len();
    for item in items.iter().rev() {
        let element = item.element();
        if element.origin != next.origin || matches!(item, Item::Path(_)) {
            break;
        }
        at -= 1;
        if element.starts_block {
            break;
        }
    }
    items.split_off(at)
}

/// Number of blocks without motion in the plane between the motion of an element and the end of `items`.
pub(super) fn blocks_between(first: &Element, items: &[Item]) -> usize {
    let mut last = first.origin;
    let mut count = 0;
    for item in items.iter().filter(|item| item.counts()) {
        let element = item.element();
        if element.origin != last || element.starts_block {
            count += 1;
            last = element.origin;
        }
    }
    count
}

/// Ends of straight pieces that approximate an arc.
fn chords(curve: &Curve, basis: &PlaneBasis, from: &AxisVector, to: &AxisVector) -> Vec<AxisVector> {
    let Curve::Arc { radius, sweep, .. } = *curve else { return vec![*to] };
    let count = chord_count(radius, sweep, RAPID_CHORD_MM);
    let mut ends: Vec<AxisVector> = (1..count)
        .map(|k| {
            let share = f64::from(k) / f64::from(count);
            basis.moved(&from.lerp(to, share), curve.at(curve.length() * share))
        })
        .collect();
    ends.push(*to);
    ends
}

/// The axes that move with plane coordinates.
pub(super) fn plane_axes(basis: &PlaneBasis) -> AxisSet {
    match basis {
        PlaneBasis::Principal(plane) => {
            let [abscissa, ordinate, _] = plane.axes();
            [abscissa, ordinate].into_iter().collect()
        }
        PlaneBasis::Tilted(_) => LINEAR_AXES.into_iter().take(3).collect(),
    }
}

/// `true` if two bases have one plane and are not mirrored.
pub(super) fn same_plane(a: &PlaneBasis, b: &PlaneBasis) -> bool {
    let normal = |basis: &PlaneBasis| basis.lift([0.0, 0.0], 1.0);
    a == b || (normal(a) - normal(b)).norm() < SAME_PLANE
}

/// Plane coordinates in one basis for a point in another basis of the same plane.
fn at_height(basis: &PlaneBasis, own: &PlaneBasis, point: Flat) -> Flat {
    let xyz = own.lift(point, 0.0);
    let mut position = AxisVector::ZERO;
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        position[axis] = xyz[axis.slot()];
    }
    basis.flat(&position)
}

/// Effect of a motion on the compensation of the control.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum Switch {
    #[default]
    None,
    /// It leads to the contour.
    On,
    /// It leads off the contour.
    Off,
}
