//! Motions synchronized with the spindle: G33, and of RS274/NGC G33.1 and G76.

use super::channel::Channel;
use super::codes::name_of;
use super::cycles::threading::{Thread as Cut, moves};
use super::gathered::Gathered;
use super::measure;
use super::modal::Modal;
use super::special;
use super::step;
use super::step::Step;
use super::target;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, Plane};
use ncfix_dialect::Language;
use ncfix_machine::snc::{MotionMode, Thread, ThreadCode};

/// `G33`, `G33.1`
pub(super) fn thread(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    check_thread(channel.language, &channel.modal, gathered, code)?;
    let letter = if channel.is_rs274() { b'K' } else { b'F' };
    let lead = measure::length(channel, gathered, letter)?;
    let Some(lead) = lead.or((!channel.is_rs274()).then_some(channel.modal.modes.feed)).filter(|lead| *lead > 0.0)
    else {
        let message = format!("{} needs {} with the lead", name_of(code), char::from(letter));
        return Err(bad_value(gathered.span, message, "write the travel per spindle revolution"));
    };
    if gathered.has(b'Q') && !channel.is_rs274() {
        let message = "the start angle of a thread (Q) is not supported";
        return Err(fault(Code::NOT_SUPPORTED, gathered.span_of(b'Q'), message, "remove Q"));
    }
    gathered.use_up(b"$");
    if gathered.raw(b'I').is_some_and(|factor| factor > 1.0) {
        let message = "a faster retract from the hole (I) is not supported";
        return Err(fault(Code::NOT_SUPPORTED, gathered.span_of(b'I'), message, "remove I"));
    }
    let start = target::here(&channel.modal, &channel.standing);
    let (end, named) = step::end(channel, gathered)?;
    let step = |code: ThreadCode, end| {
        let motion_mode = MotionMode::Thread(Thread { code, lead: Some((letter, lead)), change: None });
        Step { rapid: false, end, named, feed_named: false, motion_mode, span: gathered.span }
    };
    if code == 330 {
        return step::step(channel, step(ThreadCode::G33, end));
    }
    // The spindle reverses, and the tool returns to its start.
    named
        .iter()
        .try_for_each(|axis| target::check_stated(channel.settings.strict, &channel.modal, axis, gathered.span))?;
    step::step(channel, step(ThreadCode::G331, end))?;
    channel.outlet.begin_line();
    step::step(channel, step(ThreadCode::G332, start))
}

/// `G76`: a thread in passes.
pub(super) fn threading(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    check_thread(channel.language, &channel.modal, gathered, 760)?;
    let span = gathered.span;
    if channel.modal.modes.plane != Plane::ZX {
        let message = "G76 outside the XZ plane";
        return Err(bad_value(span, message, "select G18"));
    }
    special::check_plane_stated(
        channel.settings.strict,
        &channel.modal,
        [Axis::X, Axis::Z].into_iter().collect(),
        span,
    )?;
    let mut needed = [0.0; 4];
    for (value, letter) in needed.iter_mut().zip(*b"PIJK") {
        let Some(found) = measure::length(channel, gathered, letter)? else {
            let message = format!("G76 needs {}", char::from(letter));
            return Err(bad_value(span, message, "write P, I, J and K"));
        };
        *value = found;
    }
    let [pitch, peak, first, depth] = needed;
    let here = target::here(&channel.modal, &channel.standing);
    let (end, _) = step::end(channel, gathered)?;
    let tapers = gathered.raw(b'L').unwrap_or(0.0);
    if !(0.0..=3.0).contains(&tapers) || tapers.fract() != 0.0 {
        return Err(bad_value(gathered.span_of(b'L'), format!("L{tapers} is not 0 to 3"), "check L"));
    }
    gathered.use_up(b"$");
    let springs = gathered.raw(b'H').unwrap_or(0.0);
    let cut = Cut {
        start: [here[Axis::X], here[Axis::Z]],
        end: [end[Axis::X], end[Axis::Z]],
        pitch,
        peak,
        first,
        depth,
        degression: gathered.raw(b'R').unwrap_or(1.0),
        slide_rad: measure::angle(channel.settings.machine, channel.language, &mut channel.warned, gathered, b'Q')?
            .unwrap_or(0.0),
        // The value is within its type.
        springs: springs.max(0.0) as u32,
        taper: measure::length(channel, gathered, b'E')?.unwrap_or(0.0),
        // 0 to 3.
        tapers: [tapers as u8 & 1 != 0, tapers as u8 & 2 != 0],
    };
    let passes = moves(&cut).map_err(|message| bad_value(span, message, "check the words of G76"))?;
    let mut place = here;
    for (index, pass) in passes.into_iter().enumerate() {
        if index > 0 {
            channel.outlet.begin_line();
        }
        let mut named = AxisSet::EMPTY;
        for (axis, value) in [Axis::X, Axis::Z].into_iter().zip(pass.to) {
            if place[axis] != value || index == 0 {
                named.insert(axis);
            }
            place[axis] = value;
        }
        let motion_mode = pass.pitch.map_or(MotionMode::Path, |pitch| {
            MotionMode::Thread(Thread { code: ThreadCode::G33, lead: Some((b'K', pitch)), change: None })
        });
        let rapid = pass.pitch.is_none();
        step::step(channel, Step { rapid, end: place, named, feed_named: false, motion_mode, span })?;
    }
    Ok(())
}

fn check_thread(language: Language, modal: &Modal, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    let (name, span) = (name_of(code), gathered.span);
    if modal.contour.compensates() || modal.turning.is_some() {
        let message = format!("{name} under radius compensation or tool center point control");
        return Err(fault(Code::NOT_SUPPORTED, span, message, "end it before the thread"));
    }
    if language == Language::Rs274 && !matches!(modal.spindle, 3 | 4) {
        let message = format!("{name} while the spindle does not turn");
        return Err(bad_value(span, message, "start the spindle first"));
    }
    Ok(())
}
