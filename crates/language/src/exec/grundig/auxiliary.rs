//! F, S, M functions, dwells.

use super::channel::{Channel, GrundigAtHand};
use super::gathered::Gathered;
use super::modal::Modal;
use super::setup;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::head::{self, HeadBlock};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::settings::RunSettings;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_base::source::Span;
use ncfix_base::units::MM_PER_INCH;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Dwell, Kind, Word, WordValue};

/// M functions that act after the motion of their block.
const BEHIND: &[u16] = &[0, 1, 2, 5, 9, 30];

/// Reads F and S; the F words of a dwell, a cycle and a single block are read elsewhere.
pub(super) fn feed_and_speed(
    modal: &mut Modal,
    block: &mut GrundigAtHand,
    outlet: &mut MotionSink<'_>,
    gathered: &mut Gathered,
) -> Result<(), Fault> {
    if let Some((feed, span)) = gathered.once(b'F', None)? {
        if feed < 0.0 {
            return Err(bad_value(span, "a feed below 0", "write a feed above 0"));
        }
        modal.modes.set_feed(if modal.modes.inch { feed * MM_PER_INCH } else { feed });
        block.feed_named = true;
    } else {
        block.feed_named = false;
    }
    if let Some((speed, _)) = gathered.once(b'S', None)? {
        modal.modes.speed = Some(speed);
        block.before.push(Word { letter: b'S', extension: None, value: WordValue::Number(speed) });
    }
    if gathered.functions.is_empty() && !block.before.is_empty() {
        let before = std::mem::take(&mut block.before);
        outlet.push(Kind::Before(before));
    }
    Ok(())
}

/// M functions: emits those that act before the motion and returns the others.
pub(super) fn functions(
    settings: &RunSettings<'_>,
    block: &mut GrundigAtHand,
    spindle: &mut Option<u16>,
    outlet: &mut MotionSink<'_>,
    gathered: &mut Gathered,
) -> Result<Vec<Word>, Fault> {
    let mut behind = Vec::new();
    for code in std::mem::take(&mut gathered.functions) {
        let word = Word { letter: b'M', extension: None, value: WordValue::Number(f64::from(code.number)) };
        if code.number == 19
            && let Some((angle, _)) = gathered.take(b'D', None)
        {
            block.before.push(Word { letter: b'D', extension: None, value: WordValue::Number(angle) });
        }
        match code.number {
            3 | 4 | 13 | 14 => *spindle = Some(if matches!(code.number, 3 | 13) { 3 } else { 4 }),
            5 | 30 | 2 => *spindle = None,
            53 | 54 if settings.machine.head_of_word(code.number.into()).is_none() => {
                check_head(settings.machine, code.number, code.span)?;
            }
            _ => {}
        }
        if BEHIND.contains(&code.number) { behind.push(word) } else { block.before.push(word) }
    }
    let before = std::mem::take(&mut block.before);
    if !before.is_empty() {
        outlet.push(Kind::Before(before));
    }
    Ok(behind)
}

/// Words whose letters belong to a motion.
const OF_MOTION: &[u8] = b"XYZABCUVWIJKRLP";

/// Changes the head, if an M word of the block selects another one. The swivelling head has moved, so the position is unknown afterwards.
pub(super) fn select_head(channel: &mut Channel<'_>, words: &[(u32, Span)], gathered: &Gathered) -> Result<(), Fault> {
    if words.is_empty() {
        return Ok(());
    }
    let block = HeadBlock {
        setup: &channel.standing.setup,
        head: channel.modal.tool.head,
        compensates: channel.modal.contour.compensates(),
        moves: gathered.items.iter().any(|item| OF_MOTION.contains(&item.letter)),
    };
    let Some(head) = head::selected(channel.settings.machine, words.iter().copied(), block)? else { return Ok(()) };
    channel.modal.tool.head = head;
    channel.outlet.kinematics = None;
    channel.modal.position.keep(AxisSet::EMPTY);
    channel.outlet.push(Kind::Lost(AxisSet::ALL));
    setup::refresh_setup(channel)
}

/// M53, M54: swivels the head. The machine file describes one of its positions.
fn check_head(machine: &Machine, number: u16, span: Span) -> Result<(), Fault> {
    if machine.control.grundig.head == Some(number) {
        return Ok(());
    }
    let message = format!("M{number} turns the head to a position that the machine file does not describe");
    let help = "set control.grundig_head to the position, M53 or M54, that the axes and errors of the machine file describe; or describe each position with [[head]]";
    Err(fault(Code::NOT_SUPPORTED, span, message, help))
}

pub(super) fn dwell(outlet: &mut MotionSink<'_>, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
    let help = "write for example G4 X1.5";
    let dwell = match (gathered.once(b'X', None)?, gathered.once(b'D', None)?) {
        (Some((seconds, _)), None) if seconds >= 0.0 => Dwell::Seconds(seconds),
        (None, Some((turns, _))) if turns >= 0.0 => Dwell::Turns(turns),
        _ => return Err(bad_value(span, "G4 needs X with seconds or D with turns", help)),
    };
    outlet.push(Kind::Dwell(dwell));
    Ok(())
}
