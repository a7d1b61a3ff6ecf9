//! Changes of the head by an M word of the machine file.

use super::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Setup;

/// State of a block in which a word may change the head.
#[derive(Clone, Copy, Debug)]
pub(in crate::exec) struct HeadBlock<'a> {
    /// The active setup.
    pub(in crate::exec) setup: &'a Setup,
    /// The head in which the tool is.
    pub(in crate::exec) head: u16,
    /// `true` under radius compensation.
    pub(in crate::exec) compensates: bool,
    /// `true` if the block also has words of a motion.
    pub(in crate::exec) moves: bool,
}

/// The head that the M words of a block select, if it is another one.
///
/// # Errors
/// If the tool or the position would not be sure after the change.
pub(in crate::exec) fn selected(
    machine: &Machine,
    words: impl Iterator<Item = (u32, Span)>,
    block: HeadBlock<'_>,
) -> Result<Option<u16>, Fault> {
    let mut found: Option<(u16, u32)> = None;
    for (number, span) in words {
        let Some(head) = machine.head_of_word(number) else { continue };
        if let Some((_, first)) = found.filter(|(other, _)| *other != head) {
            let message = format!("M{first} and M{number} select different heads in one block");
            return Err(fault(Code::HEAD_CHANGE, span, message, "write each in a block of its own"));
        }
        found = Some((head, number));
        if head != block.head {
            check_fixed(machine, [block.head, head], number, span)?;
            check(number, span, block)?;
        }
    }
    Ok(found.map(|(head, _)| head).filter(|head| *head != block.head))
}

/// Refuses another head if the caller has chosen one for the whole run.
fn check_fixed(machine: &Machine, heads: [u16; 2], number: u32, span: Span) -> Result<(), Fault> {
    if !machine.has_fixed_head {
        return Ok(());
    }
    let [own, other] = heads.map(|head| machine.heads.get(usize::from(head)).map_or("", |head| head.name.as_str()));
    let message = format!("M{number} selects the head {other}, and this run is for the head {own} alone");
    Err(fault(
        Code::HEAD_CHANGE,
        span,
        message,
        "run this command for a program, or a part of it, that stays with one head",
    ))
}

fn check(number: u32, span: Span, block: HeadBlock<'_>) -> Result<(), Fault> {
    let setup = block.setup;
    let length_mm = setup.tool_mm.norm();
    let (state, help) = if block.compensates {
        ("radius compensation is on".to_owned(), "program G40 with a motion in the plane before it")
    } else if setup.transform.is_some() {
        ("a five-axis transformation is active".to_owned(), "end the transformation before it")
    } else if !setup.frame.is_translation() {
        let help = "end it before the word, and program it again after: the tool axis is another one";
        ("a rotated, mirrored or scaled frame is active".to_owned(), help)
    } else if length_mm > 0.0 {
        let help = "cancel it before (Sinumerik D0, Fanuc and RS274/NGC G49, Grundig T0 M6), and select the tool after the word";
        (format!("a tool length of {length_mm:.3} mm is active, which belongs to the other head"), help)
    } else if block.moves {
        let help = "write the word in a block of its own: it may act before, with or after the rest of the block";
        ("the block also has a motion, a dwell or axis words".to_owned(), help)
    } else {
        return Ok(());
    };
    Err(fault(Code::HEAD_CHANGE, span, format!("M{number} changes the head while {state}"), help))
}
