//! Executes the words of one block in a fixed order.

use super::angle;
use super::channel::Channel;
use super::contour_words;
use super::dwell;
use super::feed;
use super::forbidden;
use super::frames;
use super::gathered::Gathered;
use super::modes;
use super::pass;
use super::passed_axis;
use super::polar;
use super::save;
use super::setup;
use super::stream;
use super::surface;
use super::tool;
use super::tool_frame;
use super::transform;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::head::{self, HeadBlock};
use crate::exec::core::motion_sink::MotionSink;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_base::source::Span;
use ncfix_machine::snc::{Kind, Word, WordValue};

/// Executes a block's words.
pub(super) fn execute(
    channel: &mut Channel<'_>,
    gathered: &mut Gathered,
    comment: Option<Vec<u8>>,
    span: Span,
) -> Result<(), Fault> {
    contour_words::contour_words(&mut channel.modal, &mut channel.block, &mut channel.outlet, gathered)?;
    forbidden::check_state(&channel.modal, gathered, span)?;
    modes::modal_codes(channel, gathered)?;
    for &word in &gathered.keep {
        save::keep(channel, word);
    }
    if gathered.is_complete {
        feed::feed_for_call(&channel.modal, &channel.splines, &mut channel.outlet);
    }
    for text in std::mem::take(&mut gathered.verbatim) {
        channel.push(Kind::Verbatim(text));
    }
    channel.outlet.warnings.extend(gathered.warning.take());
    pass::check_diameter(channel.settings.machine, &mut channel.modal, gathered)?;
    transform::transform(channel, gathered)?;
    tool_frame::tool_frame(channel, gathered)?;
    surface::surface(&mut channel.modal, gathered)?;
    frames::offset(channel, gathered)?;
    if let Some(statement) = gathered.frame {
        frames::frame_statement(channel, gathered, statement)?;
        channel.comment(comment);
        return Ok(());
    }
    frames::without_statement(gathered)?;
    if let Some(pole) = gathered.pole {
        polar::set_pole(&channel.settings, &mut channel.modal, gathered, pole)?;
        channel.comment(comment);
        return Ok(());
    }
    tool::tool(channel, gathered)?;
    contour_words::check_edge(channel.settings.strict, &channel.modal, &mut channel.outlet, gathered, span);
    if let Some(at) = gathered.dwell {
        functions(channel, gathered, (false, span))?;
        dwell::dwell(channel, gathered, at)?;
        channel.comment(comment);
        lose(channel, gathered);
        return Ok(());
    }
    feed::feed_and_speed(&mut channel.modal, gathered);
    if let Some(text) = gathered.message.take() {
        channel.push(Kind::Message(text));
    }
    let moves = !gathered.named.is_empty()
        || gathered.center.iter().any(Option::is_some)
        || gathered.addresses.iter().any(|value| value.address.moves());
    functions(channel, gathered, (moves || gathered.is_reference, span))?;
    let before = std::mem::take(&mut gathered.before);
    if !before.is_empty() {
        channel.push(Kind::Before(before));
    }
    passed_axis::pass_on(channel, gathered, moves)?;
    if moves {
        channel.comment(comment);
        angle::angle(channel, gathered, span)?;
        stream::send(channel, gathered, span)?;
    } else {
        if gathered.feed.is_some() {
            channel.push(Kind::Feed(channel.modal.modes.feed));
        }
        channel.comment(comment);
    }
    let after = std::mem::take(&mut gathered.after);
    if !after.is_empty() {
        channel.push(Kind::After(after));
    }
    lose(channel, gathered);
    Ok(())
}

/// Acts on the M functions of a block that change the head or move axes.
fn functions(channel: &mut Channel<'_>, gathered: &mut Gathered, (moves, span): (bool, Span)) -> Result<(), Fault> {
    if !channel.settings.machine.heads.is_empty() {
        let words: Vec<Word> = gathered.before.iter().chain(&gathered.after).cloned().collect();
        select_head(channel, gathered, &words, (moves, span))?;
    }
    if gathered.before.iter().chain(&gathered.after).any(|word| is_moved_by(&channel.outlet, word)) {
        gathered.lost = AxisSet::ALL;
    }
    Ok(())
}

/// Forgets the positions that the functions of a block have changed.
fn lose(channel: &mut Channel<'_>, gathered: &Gathered) {
    if !gathered.lost.is_empty() {
        let lost = channel.modal.forget(gathered.lost);
        channel.push(Kind::Lost(lost));
    }
}

/// Changes the head, if an M word of the block selects another one. The head has moved, so the position is unknown afterwards.
fn select_head(
    channel: &mut Channel<'_>,
    gathered: &mut Gathered,
    words: &[Word],
    (moves, span): (bool, Span),
) -> Result<(), Fault> {
    let machine = channel.settings.machine;
    let extended = words.iter().filter(|word| word.letter == b'M' && word.extension.is_some());
    let of_head = |word: &Word| match word.value {
        WordValue::Number(number) => Some(number as u32).filter(|number| machine.head_of_word(*number).is_some()),
        WordValue::Name(_) => None,
    };
    if let Some(number) = extended.filter_map(of_head).next() {
        let message = format!("M{number} changes the head, and an address extension may give it another meaning");
        return Err(fault(Code::HEAD_CHANGE, span, message, format!("write M{number}")));
    }
    let numbers = words.iter().filter(|word| word.letter == b'M');
    let numbers = numbers.filter_map(|word| match word.value {
        // A whole number, as the gatherer has checked.
        WordValue::Number(number) => Some((number as u32, span)),
        WordValue::Name(_) => None,
    });
    let block = HeadBlock {
        setup: &channel.standing.setup,
        head: channel.modal.tool.head,
        compensates: channel.modal.contour.compensates(),
        moves,
    };
    let Some(head) = head::selected(channel.settings.machine, numbers, block)? else { return Ok(()) };
    channel.modal.tool.head = head;
    channel.outlet.kinematics = None;
    channel.modal.forget_position();
    gathered.lost = AxisSet::ALL;
    setup::refresh_setup(&mut channel.modal, &mut channel.standing, &mut channel.outlet);
    Ok(())
}

/// `true` if a word is an M function that moves axes according to the machine file.
pub(super) fn is_moved_by(outlet: &MotionSink<'_>, word: &Word) -> bool {
    let is_function = word.letter == b'M' && word.extension.is_none();
    matches!(word.value, WordValue::Number(number) if is_function && outlet.function_moves(number))
}
