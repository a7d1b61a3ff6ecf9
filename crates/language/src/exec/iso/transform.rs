//! Rotation, scale, mirror, polar coordinates and tilted planes of Fanuc: the codes that change the transformations nearest to the programmed values.

use super::channel::Channel;
use super::codes::{Group, name_of};
use super::frames::Within;
use super::gathered::Gathered;
use super::measure;
use super::modal::Modal;
use super::one_axis;
use super::polar::Polar;
use super::setup;
use super::setup::turned_length;
use super::special;
use super::target;
use super::text;
use super::tilt;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AXES, Axis, AxisSet};
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::snc::Kind;

/// Unit of a factor without decimal point (Fanuc parameter 5400, bit 7).
const FACTOR: f64 = 1e-3;
const LETTERS: [u8; 3] = *b"XYZ";

/// Executes these codes of a block. Returns `true` if they consumed the axis words, so that the block has no motion.
pub(super) fn transform_codes(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<bool, Fault> {
    let groups = [Group::Interpolation, Group::Rotation, Group::Scale, Group::Mirror, Group::Polar];
    if groups.iter().all(|&group| gathered.code(group).is_none()) {
        return Ok(false);
    }
    if gathered.code(Group::Interpolation).is_some_and(|code| code != 131) {
        let message = "polar coordinate interpolation (G12.1) is not supported";
        let span = gathered.code_span(Group::Interpolation);
        return Err(fault(Code::NOT_SUPPORTED, span, message, "put the block into a program that is not corrected"));
    }
    if channel.modal.turning.is_some() {
        let span = groups.iter().find(|&&group| gathered.code(group).is_some()).map(|&g| gathered.code_span(g));
        let message = "a change of mirror, scaling, rotation or tilted plane under tool center point control";
        let help = "end it with G49 first";
        return Err(fault(Code::NOT_SUPPORTED, span.unwrap_or(gathered.span), message, help));
    }
    // Codes that end them are emitted, as an earlier program may have left one active in the control.
    for (group, off, word) in [(Group::Rotation, 690, "G69"), (Group::Scale, 500, "G50"), (Group::Polar, 150, "G15")] {
        if gathered.code(group) == Some(off) {
            channel.push(Kind::Keep(word));
        }
    }
    let before = channel.modal.transforms.clone();
    let mut took = false;
    // An inner transformation ends before the outer one, and begins after it.
    if gathered.code(Group::Rotation) == Some(690) {
        channel.modal.transforms.end_rotation();
        channel.special.tilt_parts = Default::default();
    }
    if gathered.code(Group::Scale) == Some(500) {
        let done = channel.modal.transforms.end_scale();
        allowed(done, 500, gathered.code_span(Group::Scale))?;
    }
    match gathered.code(Group::Mirror) {
        Some(501) => took |= end_mirror(channel.language, &mut channel.modal, &mut channel.outlet, gathered)?,
        Some(_) => {
            mirror(channel, gathered)?;
            took = true;
        }
        None => {}
    }
    if gathered.code(Group::Scale) == Some(510) {
        once(took, gathered.code_span(Group::Scale))?;
        scale(channel, gathered)?;
        took = true;
    }
    if let Some(code) = gathered.code(Group::Rotation).filter(|&code| code != 690) {
        let span = gathered.code_span(Group::Rotation);
        once(took, span)?;
        match code {
            680 => rotation(channel, gathered, span)?,
            _ => {
                tilt::end_kept(channel);
                tilt::tilt(channel, gathered, code, span)?;
            }
        }
        took = true;
    }
    match gathered.code(Group::Polar) {
        Some(150) => channel.special.polar = None,
        Some(_) => channel.special.polar = Some(Polar::default()),
        None => {}
    }
    if channel.modal.transforms != before {
        if channel.modal.contour.compensates() {
            let message = "a change of mirror, scaling, rotation or tilted plane within radius compensation";
            return Err(fault(Code::NOT_SUPPORTED, gathered.span, message, "end it with G40 first"));
        }
        let (here, known) = (target::here(&channel.modal, &channel.standing), channel.modal.position.known);
        setup::refresh_setup(channel);
        one_axis::note_turn(&channel.modal, &mut channel.special, &channel.standing, &before, &here, known);
    }
    Ok(took)
}

fn once(took: bool, span: Span) -> Result<(), Fault> {
    if !took {
        return Ok(());
    }
    let message = "two codes of the block need its axis words";
    Err(bad_value(span, message, "write each in its own block"))
}

fn allowed(done: Result<(), Within>, code: u16, span: Span) -> Result<(), Fault> {
    done.map_err(|within| {
        let message = format!("{} within {within}", name_of(code));
        let help = "begin with the mirror, then the scaling, then the rotation, and end in the reverse order";
        fault(Code::NOT_SUPPORTED, span, message, help)
    })
}

/// Values of X, Y, Z, mm.
fn place_words(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<[Option<f64>; 3], Fault> {
    let mut out = [None; 3];
    for (value, letter) in out.iter_mut().zip(LETTERS) {
        *value = measure::length(channel, gathered, letter)?;
    }
    Ok(out)
}

/// `G51.1 X Y Z`
fn mirror(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let span = gathered.code_span(Group::Mirror);
    let mut words = place_words(channel, gathered)?;
    if gathered.mirrors_zero {
        words = words.map(|word| word.map(|_| 0.0));
    }
    if words == [None; 3] {
        return Err(bad_value(
            span,
            "G51.1 without axis words",
            "program the axes that it mirrors, with the mirror positions",
        ));
    }
    let done = channel.modal.transforms.set_mirror(words);
    allowed(done, 511, span)
}

/// `G50.1 X Y Z`. Returns `true` if it consumed the axis words.
fn end_mirror(
    language: Language,
    modal: &mut Modal,
    outlet: &mut MotionSink<'_>,
    gathered: &Gathered,
) -> Result<bool, Fault> {
    let has_motion = gathered.code(Group::Motion).is_some();
    let named = LETTERS.map(|letter| !has_motion && gathered.has(letter));
    if !has_motion {
        gathered.use_up(&LETTERS);
    }
    let mut text = if gathered.mirrors_zero { "G100" } else { "G50.1" }.to_owned();
    for (letter, _) in LETTERS.into_iter().zip(named).filter(|&(_, is_named)| is_named) {
        text::append(language, &mut text, letter, 0.0);
    }
    outlet.push(Kind::Verbatim(text.into_bytes()));
    let done = modal.transforms.end_mirror(named);
    allowed(done, 501, gathered.code_span(Group::Mirror))?;
    Ok(!has_motion && named != [false; 3])
}

/// `G51 X Y Z P`, `G51 X Y Z I J K`
fn scale(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let span = gathered.code_span(Group::Scale);
    let center = place_words(channel, gathered)?;
    let factor = |letter: u8| {
        gathered.raw(letter).map(|value| if gathered.is_unpointed(letter) { value * FACTOR } else { value })
    };
    let each = [factor(b'I'), factor(b'J'), factor(b'K')];
    let factors = match (factor(b'P'), each) {
        (Some(all), [None, None, None]) => [all; 3],
        (None, [None, None, None]) | (Some(_), _) => {
            let message = "G51 needs P with the factor, or I, J, K with a factor for each axis";
            return Err(bad_value(span, message, "for example P2000 for twice the size"));
        }
        (None, each) => each.map(|factor| factor.unwrap_or(1.0)),
    };
    for (axis, _) in AXES.into_iter().zip(center).filter(|(axis, word)| channel.axes.contains(*axis) && word.is_none())
    {
        target::check_stated(channel.settings.strict, &channel.modal, axis, span)?;
    }
    let here = target::here(&channel.modal, &channel.standing);
    match channel.modal.transforms.set_scale(center, factors, &here) {
        Ok(true) => Ok(()),
        Ok(false) => Err(bad_value(span, "a factor of G51 is 0", "correct the factor")),
        Err(within) => allowed(Err(within), 510, span),
    }
}

/// `G68 X Y R`, `G68 X Y Z I J K R`
fn rotation(channel: &mut Channel<'_>, gathered: &Gathered, span: Span) -> Result<(), Fault> {
    let Some(angle) = measure::angle(channel.settings.machine, channel.language, &mut channel.warned, gathered, b'R')?
    else {
        return Err(bad_value(span, "G68 needs R with the angle", "write R in degrees"));
    };
    let here = target::here(&channel.modal, &channel.standing);
    let center = place_words(channel, gathered)?;
    if gathered.has_any(b"IJK") {
        special::check_plane_stated(channel.settings.strict, &channel.modal, missing(center), span)?;
        let direction = [b'I', b'J', b'K'].map(|letter| gathered.raw(letter).unwrap_or(0.0));
        let done = match channel.modal.transforms.set_rotation_about(center, direction, angle, &here) {
            Ok(true) => Ok(()),
            Ok(false) => return Err(bad_value(span, "I, J and K of G68 are 0", "write the direction of the line")),
            Err(within) => Err(within),
        };
        allowed(done, 680, span)?;
        if channel.modal.transforms.turns(&channel.modal.tool.length_mm) {
            return Err(turned_length(span));
        }
        return Ok(());
    }
    let [abscissa, ordinate, applicate] = channel.modal.modes.plane.axes();
    if gathered.has(applicate.letter()) {
        let message = format!("{applicate} with G68 in this plane");
        let help = "program the center in the working plane, or the line with I, J and K too";
        return Err(bad_value(gathered.span_of(applicate.letter()), message, help));
    }
    let plane: AxisSet = [abscissa, ordinate].into_iter().collect();
    special::check_plane_stated(channel.settings.strict, &channel.modal, missing(center).intersection(plane), span)?;
    let center = [abscissa, ordinate].map(|axis| center.get(axis.slot()).copied().flatten());
    let done = channel.modal.transforms.set_rotation(channel.modal.modes.plane, center, angle, &here);
    allowed(done, 680, span)
}

/// The axes of X, Y, Z without a word.
fn missing(words: [Option<f64>; 3]) -> AxisSet {
    [Axis::X, Axis::Y, Axis::Z]
        .into_iter()
        .zip(words)
        .filter(|(_, word)| word.is_none())
        .map(|(axis, _)| axis)
        .collect()
}
