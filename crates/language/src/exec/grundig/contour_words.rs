//! Contour words: elements whose end the next one determines (G64), roundings and chamfers (R1=, I1=), G11, G61 and G62.

use super::arc;
use super::arc::{Circle, sweep_between};
use super::channel::Channel;
use super::channel::GrundigAtHand;
use super::channel::Open;
use super::gathered::{Found, Gathered};
use super::geometry::{Choice, Element, meet};
use super::modal::Modal;
use super::modal::{MotionKind, plus};
use super::setup;
use super::step;
use super::target;
use super::target::Target;
use crate::exec::core::contour::{Clearance, Corner, Soft, SoftForm, SoftSide, Transition};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::standing::InForce;
use crate::exec::core::step::Flat;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_base::source::Span;
use ncfix_machine::machine::Machine;

/// Takes R1= and I1= of a motion: the transition to the next one.
pub(super) fn corner_words(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    channel.block.corner = None;
    if !channel.modal.calculates_geometry() {
        return Ok(());
    }
    let (round, chamfer) = (gathered.once(b'R', Some(1))?, gathered.once(b'I', Some(1))?);
    channel.block.corner = transition(channel.settings.machine, &channel.modal, &channel.standing, round, chamfer)?;
    Ok(())
}

/// A rounding by its radius, or a chamfer by its distance from the corner.
fn transition(
    machine: &Machine,
    modal: &Modal,
    standing: &InForce,
    round: Option<Found>,
    chamfer: Option<Found>,
) -> Result<Option<Corner>, Fault> {
    let scale = modal.modes.scale() * plane_factor(modal, standing);
    let size = |(value, span): Found| {
        if value > 0.0 {
            return Ok(value * scale);
        }
        Err(bad_value(span, format!("a rounding or chamfer of {value}"), "write a size above 0"))
    };
    let transition = match (round, chamfer) {
        (None, None) => return Ok(None),
        (Some(_), Some((_, span))) => {
            return Err(bad_value(span, "a rounding and a chamfer at one corner", "keep one of them"));
        }
        (Some(round), None) => Transition::Round(size(round)?),
        (None, Some(chamfer)) if machine.control.grundig.chamfer_is_length => Transition::ChamferLength(size(chamfer)?),
        (None, Some(chamfer)) => Transition::ChamferSetback(size(chamfer)?),
    };
    Ok(Some(Corner { transition, feed: 0.0, is_modal: false }))
}

/// Handles a motion block under G64 as an element of the intersection calculation; `false` for an ordinary motion.
pub(super) fn open_element(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<bool, Fault> {
    if gathered.is_used_up() {
        return Ok(false);
    }
    let Some((element, has_end)) = element_of(&channel.modal, &channel.open, &channel.standing, gathered)? else {
        return match channel.open.take() {
            None => Ok(false),
            Some(open) => Err(without_end(&mut channel.outlet, &open)),
        };
    };
    let choice = match gathered.once(b'J', Some(1))? {
        None | Some((1.0, _)) => Choice::First,
        Some((2.0, _)) => Choice::Second,
        Some((value, span)) => {
            return Err(bad_value(span, format!("J1={value} does not select an intersection"), "write J1=1 or J1=2"));
        }
    };
    if !has_end {
        if let Some(open) = channel.open.take() {
            return Err(without_end(&mut channel.outlet, &open));
        }
        begin_open(channel, element, choice, gathered.span)?;
        return Ok(true);
    }
    let Some(open) = channel.open.take() else {
        // With an end, the element is fully defined; an additional tangent or angle is an error.
        let message = "both angle or tangent and end point of an element with a known start";
        return match element {
            Element::Arc { .. } => Ok(false),
            _ => Err(bad_value(
                gathered.span,
                message,
                "keep the end point, or omit the end point of the previous element",
            )),
        };
    };
    let incremental = channel.modal.modes.incremental;
    let target = target_of_plane(channel, gathered, incremental)?;
    let end = target::flat(&channel.modal, &target.to);
    let choice = if choice == Choice::Second { choice } else { open.choice };
    let found = meet(open.start, open.element, element, end, choice);
    let corner = match found {
        Ok(corner) => corner,
        Err(found) => {
            channel.outlet.close(None, AxisSet::EMPTY);
            let help = "correct one of them";
            return Err(fault(Code::BAD_WORD_VALUE, gathered.span, found.message(), help));
        }
    };
    let plane: AxisSet = channel.modal.modes.plane.axes().into_iter().take(2).collect();
    let mut place = target::here(&channel.modal, &channel.standing);
    target::set_flat(&channel.modal, &mut place, corner);
    channel.modal.position.command = step::reach(&channel.modal, &channel.standing, &place, plane);
    channel.modal.position.known = channel.modal.position.known.union(plane);
    let shown = setup::shown_axes(&channel.standing, plane, true);
    channel.outlet.close(Some(channel.modal.position.command), shown);
    match element {
        Element::Arc { center, clockwise } => {
            let sweep_rad = sweep_between(corner, end, center, clockwise);
            let circle = Circle { clockwise, center: plane_coordinates(&channel.modal, center), sweep_rad };
            arc::circular(channel, circle, target.to, target.named.union(plane))?;
        }
        _ => step::straight(channel, target)?,
    }
    Ok(true)
}

/// The target of a block whose angles are evaluated.
fn target_of_plane(channel: &mut Channel<'_>, gathered: &mut Gathered, incremental: bool) -> Result<Target, Fault> {
    let plane = channel.modal.modes.plane.axes();
    if incremental && plane.into_iter().take(2).any(|axis| gathered.peek(axis.letter(), None).is_some()) {
        let message =
            "the end of this element is incremental, and its start is the intersection with the previous element";
        return Err(bad_value(gathered.span, message, "program the end in absolute coordinates"));
    }
    target::target(channel, gathered, incremental)
}

/// The element of a block, and `true` if it has an end; `None` if the block needs no calculation.
fn element_of(
    modal: &Modal,
    open: &Option<Open>,
    standing: &InForce,
    gathered: &mut Gathered,
) -> Result<Option<(Element, bool)>, Fault> {
    let axes = modal.modes.plane.axes();
    let words = |gathered: &Gathered| {
        let named = |axis: ncfix_base::geometry::Axis| {
            [None, Some(90), Some(91)].into_iter().any(|index| gathered.peek(axis.letter(), index).is_some())
        };
        axes.into_iter().take(2).filter(|&axis| named(axis)).count()
    };
    let ends = words(gathered);
    let is_polar =
        [(b'B', 2), (b'L', 1)].into_iter().any(|(letter, index)| gathered.peek(letter, Some(index)).is_some());
    let has_end = ends == 2;
    match modal.modes.motion {
        MotionKind::Rapid | MotionKind::Line => {
            if is_polar || ends == 1 {
                return Ok(None);
            }
            if let Some((degrees, _)) = gathered.peek(b'B', Some(1)) {
                gathered.take(b'B', Some(1));
                return Ok(Some((Element::Line { angle_rad: degrees.to_radians() }, has_end)));
            }
            match gathered.once(b'K', Some(1))? {
                Some(_) => Ok(Some((Element::Touching, has_end))),
                None => Ok(None),
            }
        }
        MotionKind::Clockwise | MotionKind::CounterClockwise => {
            let letters = [axes[0], axes[1]].map(|axis| b"IJK".get(axis.slot()).copied().unwrap_or_default());
            let given = letters.map(|letter| gathered.peek(letter, None));
            let ([Some((first, _)), Some((second, _))], None) = (given, gathered.peek(b'B', Some(5))) else {
                return Ok(None);
            };
            // With an end and no open element before it, it is an ordinary arc.
            if ends == 1 || is_polar || (has_end && open.is_none()) {
                return Ok(None);
            }
            for letter in letters {
                gathered.take(letter, None);
            }
            let here = target::here(modal, standing);
            let scale = modal.modes.scale();
            let base = if modal.modes.incremental { [here[axes[0]], here[axes[1]]] } else { [0.0; 2] };
            let mut center = here;
            center[axes[0]] = base[0] + first * scale;
            center[axes[1]] = base[1] + second * scale;
            let clockwise = modal.modes.motion == MotionKind::Clockwise;
            Ok(Some((Element::Arc { center: target::flat(modal, &center), clockwise }, has_end)))
        }
    }
}

/// Begins a motion whose end is not known.
fn begin_open(channel: &mut Channel<'_>, element: Element, choice: Choice, span: Span) -> Result<(), Fault> {
    target::check_plane_known(channel.settings.strict, &channel.modal, span)?;
    if !channel.standing.setup.frame.keeps_circles(channel.modal.modes.plane) {
        let message = "intersections of G64 under unequal scale";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "program the ends of the elements"));
    }
    let start = target::flat(&channel.modal, &target::here(&channel.modal, &channel.standing));
    let to = target::here(&channel.modal, &channel.standing);
    channel.block.is_open = true;
    let feed = channel.modal.modes.feed;
    let rapid = channel.modal.modes.motion == MotionKind::Rapid;
    let done = match element {
        Element::Arc { center, clockwise } => {
            step::check_feed(channel, feed, span)?;
            let circle = Circle { clockwise, center: plane_coordinates(&channel.modal, center), sweep_rad: 0.0 };
            arc::one_arc(channel, circle, &to, AxisSet::EMPTY)
        }
        _ if rapid => step::rapid_line(channel, &to, AxisSet::EMPTY),
        _ => step::feed_line(channel, &to, AxisSet::EMPTY, feed),
    };
    channel.block.is_open = false;
    done?;
    channel.open = Some(Open { start, element, choice, span });
    Ok(())
}

/// Scale factor of the frame in the plane.
fn plane_factor(modal: &Modal, standing: &InForce) -> f64 {
    let frame = &standing.setup.frame;
    if frame.is_translation() {
        return 1.0;
    }
    frame.linear().column(modal.modes.plane.axes()[0].slot()).norm()
}

fn without_end(outlet: &mut MotionSink<'_>, open: &Open) -> Fault {
    outlet.close(None, AxisSet::EMPTY);
    bad_value(
        open.span,
        "this element has no end, and the next one does not define their intersection",
        "program an element with an end point next: a line with B1= or K1=, or an arc with its center",
    )
}

/// Reports an element that is still incomplete.
pub(super) fn end_open(open: &mut Option<Open>, outlet: &mut MotionSink<'_>) {
    if let Some(open) = open.take() {
        let found = without_end(outlet, &open);
        outlet.warnings.push(found);
    }
}

/// Converts a point of the plane to abscissa and ordinate.
fn plane_coordinates(modal: &Modal, flat: Flat) -> [f64; 2] {
    let mut place = ncfix_base::geometry::AxisVector::ZERO;
    target::set_flat(modal, &mut place, flat);
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    [place[abscissa], place[ordinate]]
}

/// `G11`: two lines in one block, each by its end, by angle and length, or the first by its angle alone.
pub(super) fn two_lines(channel: &mut Channel<'_>, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
    let help = "write for example G11 X40 Y10 R5 X1=60 Y1=30, or G11 B30 X1=60 Y1=30 B1=90";
    if channel.modal.modes.incremental {
        return Err(fault(Code::NOT_SUPPORTED, span, "G11 under G91", "program it under G90"));
    }
    target::check_plane_known(channel.settings.strict, &channel.modal, span)?;
    channel.modal.modes.motion = MotionKind::Line;
    let start = target::here(&channel.modal, &channel.standing);
    let first = leg(&channel.modal, gathered, None)?;
    let second = leg(&channel.modal, gathered, Some(1))?;
    let corners = [(None, None), (Some(1), Some(1))].map(|(r, k)| (gathered.take(b'R', r), gathered.take(b'K', k)));
    let scale = channel.modal.modes.scale();
    let from = target::flat(&channel.modal, &start);
    let middle = match (first.end(from, scale, channel), second) {
        (Some(middle), _) => middle,
        (None, Leg { angle: Some(b), place: [Some(_), Some(_)], .. }) => {
            let Some(a) = first.angle else { return Err(bad_value(span, "the first line has no end", help)) };
            let end = second.given(from, scale, &channel.modal);
            let line = |degrees: f64| Element::Line { angle_rad: degrees.to_radians() };
            meet(from, line(a), line(b), end, Choice::First)
                .map_err(|found| fault(Code::BAD_WORD_VALUE, span, found.message(), help))?
        }
        _ => return Err(bad_value(span, "the first line has no end", help)),
    };
    let second = Leg { angle: second.angle.filter(|_| !second.is_whole()), ..second };
    let Some(end) = second.end(middle, scale, channel) else {
        return Err(bad_value(span, "the second line has no end", help));
    };
    let plane: AxisSet = channel.modal.modes.plane.axes().into_iter().take(2).collect();
    for (place, (round, chamfer)) in [middle, end].into_iter().zip(corners) {
        channel.block.corner = transition(channel.settings.machine, &channel.modal, &channel.standing, round, chamfer)?;
        let mut to = start;
        target::set_flat(&channel.modal, &mut to, place);
        step::feed_line(channel, &to, plane, channel.modal.modes.feed)?;
    }
    Ok(())
}

fn leg(modal: &Modal, gathered: &mut Gathered, index: Option<u16>) -> Result<Leg, Fault> {
    let [abscissa, ordinate] = flat_letters(modal);
    Ok(Leg {
        place: [gathered.once(abscissa, index)?, gathered.once(ordinate, index)?].map(|word| word.map(|w| w.0)),
        angle: gathered.once(b'B', index)?.map(|word| word.0),
        length: gathered.once(b'L', index)?.map(|word| word.0),
    })
}

/// The letters of the axes of the plane in the order of angles.
fn flat_letters(modal: &Modal) -> [u8; 2] {
    match modal.modes.plane.number() {
        17 => *b"XY",
        18 => *b"XZ",
        _ => *b"YZ",
    }
}

/// `G61`, `G62`: tangential approach to the contour and retraction from it.
pub(super) fn soft_words(
    modal: &Modal,
    block: &mut GrundigAtHand,
    outlet: &mut MotionSink<'_>,
    gathered: &mut Gathered,
    retracts: bool,
    span: Span,
) -> Result<(), Fault> {
    let form = match gathered.once(b'I', Some(2))?.map_or(0.0, |found| found.0) {
        0.0 => SoftForm::Line,
        1.0 => SoftForm::Quadrant,
        2.0 => SoftForm::Semicircle,
        other => return Err(bad_value(span, format!("I2={other} is not a valid form"), "write I2=0, 1 or 2")),
    };
    let size = match gathered.once(b'R', None)? {
        Some((value, _)) if value > 0.0 => value * modal.modes.scale(),
        _ => return Err(bad_value(span, "the approach needs R", "write its radius or length")),
    };
    if !modal.contour.compensates() && !retracts {
        let message = "a tangential approach without radius compensation";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "program G41 or G42 in the block or before it"));
    }
    // A pending one without motion is reported.
    end_soft(block, outlet);
    let soft = Soft {
        form,
        retracts,
        side: SoftSide::Compensation,
        in_plane: true,
        size_mm: size,
        clearance: Clearance::Above(0.0),
        infeed: 0.0,
        feed_before: modal.modes.feed,
        rapid_before: modal.modes.motion == MotionKind::Rapid,
    };
    block.soft = Some((soft, span));
    Ok(())
}

/// Reports G61 or G62 without a motion onto the contour or off it.
pub(super) fn end_soft(block: &mut GrundigAtHand, outlet: &mut MotionSink<'_>) {
    if let Some((soft, span)) = block.soft.take() {
        let message = if soft.retracts { "no motion follows this G62" } else { "no motion follows this G61" };
        let help = "write its end point, for example G61 X0 Y0 R8";
        outlet.warnings.push(bad_value(span, message, help));
    }
}

/// One of the two lines of G11, as programmed.
#[derive(Clone, Copy, Debug)]
struct Leg {
    place: [Option<f64>; 2],
    angle: Option<f64>,
    length: Option<f64>,
}

impl Leg {
    fn is_whole(&self) -> bool {
        self.place.iter().all(Option::is_some)
    }

    /// The given coordinates; missing ones are those of the start.
    fn given(&self, from: Flat, scale: f64, modal: &Modal) -> Flat {
        // In G18 the second coordinate is −Z.
        let signs = [1.0, if modal.modes.plane.number() == 18 { -1.0 } else { 1.0 }];
        let mut out = from;
        for ((place, word), sign) in out.iter_mut().zip(self.place).zip(signs) {
            if let Some(value) = word {
                *place = sign * value * scale;
            }
        }
        out
    }

    /// Its end; `None` if not determined.
    fn end(&self, from: Flat, scale: f64, channel: &Channel<'_>) -> Option<Flat> {
        let given = self.given(from, scale, &channel.modal);
        let direction = |degrees: f64| {
            target::flat(
                &channel.modal,
                &plus(&ncfix_base::geometry::AxisVector::ZERO, &channel.modal.direction(degrees), 1.0),
            )
        };
        match (self.place, self.angle, self.length) {
            ([Some(_), Some(_)], None, None) => Some(given),
            ([None, None], Some(angle), Some(length)) => {
                let way = direction(angle);
                Some([from[0] + way[0] * length * scale, from[1] + way[1] * length * scale])
            }
            ([Some(_), None], Some(angle), None) => {
                let way = direction(angle);
                let far = (given[0] - from[0]) / way[0];
                (way[0].abs() > 1e-9 && far >= 0.0).then_some([given[0], from[1] + way[1] * far])
            }
            ([None, Some(_)], Some(angle), None) => {
                let way = direction(angle);
                let far = (given[1] - from[1]) / way[1];
                (way[1].abs() > 1e-9 && far >= 0.0).then_some([from[0] + way[0] * far, given[1]])
            }
            _ => None,
        }
    }
}
