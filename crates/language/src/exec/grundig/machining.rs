//! Execution of cycles: G81 to G89 define one, G79 and G77 execute it.

use super::arc;
use super::arc::Circle;
use super::channel::Channel;
use super::cycles::{self, At, Cycle, CycleFault, CycleWords};
use super::defined::{Defined, LastHole};
use super::gathered::Gathered;
use super::kept_cycle;
use super::modal::Modal;
use super::step;
use super::target;
use super::target::Target;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::step::{Feed, Step, Turn};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, AxisVector};
use ncfix_base::source::Span;
use ncfix_machine::snc::{Dwell, Kind, Word, WordValue};

use super::step::STILL;

/// Maximum number of moves of the cycles in one block.
const MOST_STEPS: usize = 100_000;

/// Unit of a cycle word.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Unit {
    /// mm or inch.
    Length,
    /// Other, used as programmed.
    Plain,
}

/// A permitted word of a cycle: letter, index (0 for none), unit.
type Allowed = (u8, u16, Unit);

const DRILL: &[Allowed] =
    &[(b'X', 0, Unit::Plain), (b'Y', 0, Unit::Length), (b'Z', 0, Unit::Length), (b'B', 0, Unit::Length)];
const POCKET: &[Allowed] = &[
    (b'X', 0, Unit::Length),
    (b'Y', 0, Unit::Length),
    (b'Z', 0, Unit::Length),
    (b'B', 0, Unit::Length),
    (b'R', 0, Unit::Length),
    (b'I', 0, Unit::Plain),
    (b'J', 0, Unit::Plain),
    (b'K', 0, Unit::Length),
    (b'Y', 3, Unit::Length),
    (b'F', 2, Unit::Length),
];

/// The permitted words of a cycle.
fn allowed(number: u16) -> Vec<Allowed> {
    if (87..=89).contains(&number) {
        return POCKET.to_vec();
    }
    let own: &[Allowed] = match number {
        83 => &[(b'I', 0, Unit::Length), (b'J', 0, Unit::Length), (b'K', 0, Unit::Length), (b'K', 1, Unit::Plain)],
        84 => &[(b'J', 0, Unit::Length), (b'I', 0, Unit::Plain), (b'I', 1, Unit::Plain)],
        85 => &[(b'F', 2, Unit::Length)],
        _ => &[],
    };
    [DRILL, own].concat()
}

/// Handles G77, G79, G81 to G89; `false` if the block has none of them.
pub(super) fn cycle_codes(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<bool, Fault> {
    let defined = gathered.codes.iter().find_map(|code| cycles::find(code.number).map(|cycle| (cycle, code.span)));
    if let Some((cycle, span)) = defined {
        gathered.take_code(cycle.number);
        define_cycle(channel, gathered, cycle, span)?;
        return Ok(true);
    }
    for number in [77, 79] {
        let Some(span) = gathered.take_code(number) else { continue };
        let Some(defined) = channel.modal.cycle.clone() else {
            let message = format!("G{number} without a defined cycle");
            return Err(fault(Code::CYCLE_ALARM, span, message, "define one first with G81 to G89"));
        };
        if channel.modal.contour.compensates() {
            let message =
                format!("the cycle of G{number} while radius compensation is on would machine at an offset position");
            let help = "program G40 with a motion in the plane before it";
            return Err(fault(Code::BAD_COMPENSATION, span, message, help));
        }
        let modal_feed = channel.modal.modes.feed;
        let done = if number == 77 {
            on_circle(channel, gathered, &defined, span)
        } else {
            at_positions(channel, gathered, &defined, span)
        };
        channel.modal.modes.feed = modal_feed;
        done?;
        return Ok(true);
    }
    Ok(false)
}

fn define_cycle(
    channel: &mut Channel<'_>,
    gathered: &mut Gathered,
    cycle: &'static Cycle,
    span: Span,
) -> Result<(), Fault> {
    let mut words = CycleWords::default();
    let scale = channel.modal.modes.scale();
    for (letter, index, unit) in allowed(cycle.number) {
        let found = gathered.once(letter, (index > 0).then_some(index))?;
        if let Some((value, _)) = found {
            words.set(letter, index, if unit == Unit::Length { value * scale } else { value });
        }
    }
    if let Some(&missing) = cycle.needs.iter().find(|&&letter| words.get(letter, 0).is_none()) {
        let message = format!("G{} ({}) needs {}", cycle.number, cycle.title, char::from(missing));
        return Err(fault(Code::CYCLE_ALARM, span, message, "add the word"));
    }
    let feed = channel.block.feed_named.then_some(channel.modal.modes.feed);
    let pitch = words.get(b'J', 0).filter(|pitch| cycle.number == 84 && *pitch > 0.0);
    channel.block.feed_named = false;
    let defined = Defined { cycle, words, feed, pitch, per_turn: channel.modal.is_per_turn() };
    let is_rigid = defined.is_rigid_tapping();
    channel.modal.cycle = Some(defined);
    if is_rigid && channel.settings.strict && !channel.settings.keeps_cycles {
        return Err(not_coupled(span));
    }
    if cycle.number == 84 && !channel.settings.keeps_cycles {
        channel.outlet.warnings.push(by_feed(span));
    }
    Ok(())
}

/// The warning for a tap that becomes moves.
fn by_feed(span: Span) -> Fault {
    let message = "tapping becomes feed moves with a spindle reversal between them";
    let help = "use a compensating tapping chuck; keep the override at 100 %";
    fault(Code::TAPPING_BY_FEED, span, message, help)
}

/// The error for a tap without a compensating chuck that would become moves.
fn not_coupled(span: Span) -> Fault {
    let message = "tapping without a compensating chuck (I1=1) needs a synchronized spindle";
    let help = "it stays G84 in a metric program without --expand-cycles; or program I1=0 and use such a chuck";
    fault(Code::NOT_SUPPORTED, span, message, help)
}

/// `G79`: once at each point.
fn at_positions(
    channel: &mut Channel<'_>,
    gathered: &mut Gathered,
    defined: &Defined,
    span: Span,
) -> Result<(), Fault> {
    let rotation = pocket_angle(gathered, defined);
    let points = target::points(&channel.modal, gathered)?;
    let target = position(channel, gathered)?;
    if points.is_empty() {
        if target.named.is_empty() {
            return Err(bad_value(span, "G79 needs a position", "program axes or points"));
        }
        return run_cycle(channel, defined, &target, rotation);
    }
    for point in points {
        let mut place = target;
        for axis in point.named.difference(target.named).iter() {
            place.to[axis] = point.values[axis];
        }
        place.named = place.named.union(point.named);
        run_cycle(channel, defined, &place, rotation)?;
    }
    Ok(())
}

/// `G77`: holes on a circle.
fn on_circle(channel: &mut Channel<'_>, gathered: &mut Gathered, defined: &Defined, span: Span) -> Result<(), Fault> {
    let rotation = pocket_angle(gathered, defined);
    let scale = channel.modal.modes.scale();
    let Some((radius, _)) = gathered.once(b'R', None)? else {
        return Err(bad_value(span, "G77 needs the radius R", "write for example G77 X0 Y0 Z0 R20 I0 J6"));
    };
    let first = gathered.once(b'I', None)?.map_or(0.0, |found| found.0);
    let last = gathered.once(b'K', None)?.map(|found| found.0);
    let Some((count, _)) = gathered.once(b'J', None)? else {
        return Err(bad_value(span, "G77 needs the number of holes J", "write for example J6"));
    };
    let center = position(channel, gathered)?;
    let places = cycles::bolt_circle(target::flat(&channel.modal, &center.to), radius * scale, first, last, count)
        .map_err(|found| cycle_fault(found, span))?;
    let [abscissa, ordinate, _] = channel.modal.modes.plane.axes();
    for flat in places {
        let mut place = center;
        target::set_flat(&channel.modal, &mut place.to, flat);
        place.named.insert(abscissa);
        place.named.insert(ordinate);
        run_cycle(channel, defined, &place, rotation)?;
    }
    Ok(())
}

/// B1= rotates pockets and slots, rad.
fn pocket_angle(gathered: &mut Gathered, defined: &Defined) -> f64 {
    let is_turn = (87..=89).contains(&defined.cycle.number) && gathered.peek(b'L', Some(1)).is_none();
    let found = if is_turn { gathered.take(b'B', Some(1)) } else { None };
    found.map_or(0.0, |(degrees, _)| degrees.to_radians())
}

/// The position of G77 and G79; the word of the tool axis is the surface, also under G91.
fn position(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<Target, Fault> {
    let [.., applicate] = channel.modal.modes.plane.axes();
    let surface = gathered.once(applicate.letter(), None)?;
    let incremental = channel.modal.modes.incremental;
    let mut target = target::target(channel, gathered, incremental)?;
    if let Some((value, _)) = surface {
        target.to[applicate] = value * channel.modal.modes.scale();
        target.named.insert(applicate);
    }
    Ok(target)
}

/// Executes a cycle at a position.
fn run_cycle(channel: &mut Channel<'_>, defined: &Defined, place: &Target, rotation_rad: f64) -> Result<(), Fault> {
    let span = channel.outlet.origin.span;
    let [.., applicate] = channel.modal.modes.plane.axes();
    target::check_known(channel.settings.strict, &channel.modal, applicate, span)?;
    if !place.named.contains(applicate) {
        check_surface(channel, place.to[applicate], span)?;
    }
    let extra: AxisSet = place.named.difference(AxisSet::XYZ);
    if !extra.is_empty() {
        let mut to = target::here(&channel.modal, &channel.standing);
        extra.iter().for_each(|axis| to[axis] = place.to[axis]);
        step::rapid_line(channel, &to, extra)?;
    }
    let settings = &channel.settings.machine.control.grundig;
    let at = At {
        point: target::flat(&channel.modal, &place.to),
        surface: place.to[applicate],
        height: target::here(&channel.modal, &channel.standing)[applicate],
        rotation_rad,
        tool_radius_mm: channel.modal.whole_radius_mm(),
        peck_clearance_mm: settings.peck_clearance_mm,
        engagement_percent: settings.engagement_percent,
        slot_from_arc_center: settings.slot_from_arc_center,
    };
    let steps = (defined.cycle.steps)(&defined.words, &at).map_err(|found| cycle_fault(found, span))?;
    channel.block.cycle_steps += steps.len();
    if channel.block.cycle_steps > MOST_STEPS {
        let message = "the cycles of this block make more than 100 000 moves";
        return Err(fault(Code::CYCLE_ALARM, span, message, "check infeeds, pecks and the number of positions"));
    }
    let cutting = cutting_feed(&channel.modal, defined, span)?;
    let plunging = defined.words.get(b'F', 2).unwrap_or(cutting);
    let words: Vec<_> = allowed(defined.cycle.number).into_iter().map(|(letter, index, _)| (letter, index)).collect();
    if let Some(name) = defined.cycle.own_strokes {
        channel.outlet.mill(name, |text| format!("({})", text.to_ascii_uppercase()));
    }
    let is_marked = kept_cycle::begin(channel, defined, &words, cutting, at.surface);
    if defined.is_rigid_tapping() && channel.settings.strict && !is_marked {
        return Err(not_coupled(span));
    }
    // In a scaled frame; without kept cycles, the definition has the warning.
    if defined.cycle.number == 84 && channel.settings.keeps_cycles && !is_marked {
        channel.outlet.warnings.push(by_feed(span));
    }
    for step in steps {
        channel.modal.modes.feed = cutting;
        carry_out(channel, step, plunging)?;
    }
    if is_marked {
        channel.outlet.push(Kind::Cycle(None));
    }
    let end = target::here(&channel.modal, &channel.standing)[applicate];
    channel.modal.last_hole = Some(LastHole { surface: at.surface, end });
    Ok(())
}

/// Rejects a hole whose block does not state the surface after a hole that ended at another height: the surface may be the one of the last hole, or the
/// height of the tool before the block.
fn check_surface(channel: &Channel<'_>, surface: f64, span: Span) -> Result<(), Fault> {
    let applicate = channel.modal.modes.plane.axes()[2];
    let height = target::here(&channel.modal, &channel.standing)[applicate];
    let Some(last) = channel.modal.last_hole.filter(|_| channel.settings.strict) else { return Ok(()) };
    if (height - last.end).abs() > STILL || (surface - last.surface).abs() <= STILL {
        return Ok(());
    }
    let round = |value: f64| (value * 1e4).round() / 1e4;
    let (before, height) = (round(last.surface), round(surface));
    let message = format!(
        "{applicate} is missing after a hole: the surface may be {applicate}{before}, as before, or {applicate}{height}, where the tool was"
    );
    let help = format!("write the surface in every block of holes, for example {applicate}{before}");
    Err(fault(Code::TWO_MEANINGS, span, message, help))
}

/// The cutting feed of a cycle at its execution; a feed by pitch depends on the speed and feed mode then.
fn cutting_feed(modal: &Modal, defined: &Defined, span: Span) -> Result<f64, Fault> {
    let per_turn = modal.is_per_turn();
    if let Some(pitch) = defined.pitch {
        if per_turn {
            return Ok(pitch);
        }
        return match modal.modes.speed {
            Some(speed) if speed > 0.0 && !modal.has_cutting_speed() => Ok(pitch * speed),
            _ => {
                let message = "G84 with the pitch J needs the speed S in turns per minute";
                Err(fault(Code::CYCLE_ALARM, span, message, "program S before, and G97 where G96 is in force"))
            }
        };
    }
    let has_own = defined.feed.is_some() || defined.words.get(b'F', 2).is_some();
    if has_own && defined.per_turn != per_turn {
        let (then, now) = if per_turn { ("G94", "G95") } else { ("G95", "G94") };
        let message = format!("the cycle was defined with its feed under {then}, but is executed under {now}");
        return Err(fault(Code::CYCLE_ALARM, span, message, "define it again after the change of feed mode"));
    }
    Ok(defined.feed.unwrap_or(modal.modes.feed))
}

fn carry_out(channel: &mut Channel<'_>, step: Step, plunging: f64) -> Result<(), Fault> {
    let axes = channel.modal.modes.plane.axes();
    match step {
        Step::Rapid { plane, height } | Step::Line { plane, height, .. } => {
            let here = target::here(&channel.modal, &channel.standing);
            let (mut to, mut named) = (here, AxisSet::EMPTY);
            if let Some(flat) = plane {
                target::set_flat(&channel.modal, &mut to, flat);
                axes.into_iter().take(2).for_each(|axis| named.insert(axis));
            }
            if let Some(height) = height {
                to[axes[2]] = height;
                named.insert(axes[2]);
            }
            if step::has_place(channel.settings.strict, channel.settings.rapid_order, &channel.modal, named)
                && named.iter().all(|axis| (to[axis] - here[axis]).abs() < STILL)
            {
                return Ok(());
            }
            match step {
                Step::Line { feed, .. } => {
                    let feed = if feed == Feed::Plunge { plunging } else { channel.modal.modes.feed };
                    step::feed_line(channel, &to, named, feed)
                }
                _ => step::rapid_line(channel, &to, named),
            }
        }
        Step::Arc { end, center, clockwise } => {
            let mut to = target::here(&channel.modal, &channel.standing);
            let start = target::flat(&channel.modal, &to);
            target::set_flat(&channel.modal, &mut to, end);
            let sweep_rad = super::arc::sweep_between(start, end, center, clockwise);
            let mut middle = AxisVector::ZERO;
            target::set_flat(&channel.modal, &mut middle, center);
            let circle = Circle { clockwise, center: [middle[axes[0]], middle[axes[1]]], sweep_rad };
            arc::circular(channel, circle, to, axes.into_iter().take(2).collect())
        }
        Step::Dwell(seconds) => {
            channel.outlet.begin_line();
            channel.outlet.push(Kind::Dwell(Dwell::Seconds(seconds)));
            Ok(())
        }
        Step::Spindle(turn) => {
            // Needed only if the step depends on the previous rotation.
            let is_relative = matches!(turn, Turn::Reversed | Turn::Again);
            let before = if is_relative { turning(channel.spindle, &channel.outlet)? } else { 0 };
            spindle_word(&mut channel.outlet, turn.m_code(before));
            Ok(())
        }
        // No cycle of these controls has these steps.
        Step::Stop | Step::Brought(_) => Ok(()),
    }
}

/// The active M3 or M4.
fn turning(spindle: Option<u16>, outlet: &MotionSink<'_>) -> Result<u16, Fault> {
    spindle.ok_or_else(|| {
        step::block_fault(
            outlet,
            Code::CYCLE_ALARM,
            "the cycle stops or reverses the spindle, but neither M3 nor M4 was programmed",
            "start the spindle first",
        )
    })
}

fn spindle_word(outlet: &mut MotionSink<'_>, number: u16) {
    let value = WordValue::Number(f64::from(number));
    outlet.begin_line();
    outlet.push(Kind::Before(vec![Word { letter: b'M', extension: None, value }]));
}

fn cycle_fault(found: CycleFault, span: Span) -> Fault {
    fault(Code::CYCLE_ALARM, span, found.message, found.help)
}
