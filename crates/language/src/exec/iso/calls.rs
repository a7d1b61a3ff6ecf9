//! Calls: begins the level of a program, and returns from it.

use super::state;
use std::rc::Rc;

use super::call::{Call, CallKind};
use super::flow::check_loops;
use super::level::{Called, Interpreter, Level};
use super::library::Entry;
use crate::exec::core::fault::{Fault, at};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::snc::Kind;

/// Maximum number of program levels of RS274/NGC.
const RS274_LEVELS: u32 = 10;
/// Variable in which a program called by T finds the tool number.
const TOOL_VARIABLE: u32 = 149;

impl Interpreter<'_> {
    /// Begins a call; `modal` is its index among the modal calls, if it is one.
    pub(super) fn call(&mut self, mut call: Box<Call>, line: u32, modal: Option<usize>) -> Result<(), Fault> {
        if self.pass_on(&call)? {
            return Ok(());
        }
        let limit = match self.channel.language {
            Language::Rs274 => RS274_LEVELS,
            _ => self.machine.control.max_program_levels,
        };
        if self.levels.len() as u64 >= u64::from(limit) {
            let message = format!("this would be program level {}", self.levels.len() + 1);
            let help = match self.channel.language {
                Language::Rs274 => "a subroutine that calls itself must end; RS274/NGC has ten levels",
                _ => "a program that calls itself must end; the limit is control.max_program_levels",
            };
            return Err(at(call.span, Code::TOO_MANY_CALLS, message, help));
        }
        let mut found = self.find(&mut call)?;
        if let Some(number) = call.at_block {
            found.2 = self.block_of_call(found, number, call.span)?;
        }
        if call.repeats == 0 {
            return Ok(());
        }
        let calls = self.chain(line);
        let Some(caller) = self.levels.last() else { return Ok(()) };
        if found.0 == 0 {
            self.own.entered.iter_mut().skip(found.1).take(1).for_each(|place| *place = true);
        }
        let (modal, is_of_code) = (modal.or(caller.own.modal), call.is_of_code || caller.own.is_of_code);
        self.enter(&call);
        let repeats = call.repeats;
        let called = Called { start: found.2, call: Some(Rc::from(call)), modal, is_of_code };
        let mut level = Level::new(found.0, found.1, found.2, calls, called);
        level.repeats = repeats;
        self.levels.push(level);
        Ok(())
    }

    /// The block at which `M98 Q` begins a program: the first one with its number.
    fn block_of_call(&self, (program, part, start): Entry, number: u32, span: Span) -> Result<usize, Fault> {
        let loaded = &self.programs[program];
        let Some(found) = loaded.program.find_block(part, number, start.saturating_sub(1)) else {
            let message = format!("block N{number} is not in the called program");
            return Err(at(span, Code::NO_TARGET, message, "check the number of the block"));
        };
        let before = self.levels.last().filter(|caller| (caller.program, caller.part) == (program, part));
        let from = before.map_or(start, |caller| caller.next.saturating_sub(1));
        check_loops(loaded, from, found, span)?;
        Ok(found)
    }

    /// Begins the variables of a level.
    fn enter(&mut self, call: &Call) {
        if self.channel.language == Language::Rs274 {
            state::enter_level(&mut self.channel.saved);
        }
        let variables = &mut self.channel.variables;
        match call.kind {
            CallKind::Subprogram if self.channel.language == Language::Rs274 => variables.enter_shared(),
            CallKind::Subprogram => {}
            CallKind::Tool(number) => variables.set(TOOL_VARIABLE, Some(number)),
            CallKind::Macro | CallKind::Sub => variables.enter(&call.arguments),
        }
    }

    /// Ends the variables of a level.
    fn leave(&mut self, kind: CallKind) {
        let is_rs274 = self.channel.language == Language::Rs274;
        if is_rs274 {
            state::leave_level(&mut self.channel);
            self.channel.flush_before();
        }
        match kind {
            CallKind::Subprogram if is_rs274 => self.channel.variables.leave(),
            CallKind::Subprogram | CallKind::Tool(_) => {}
            CallKind::Macro | CallKind::Sub => self.channel.variables.leave(),
        }
    }

    /// Executes M99, `endsub`, `return` and the end of a subprogram.
    pub(super) fn return_to(&mut self, target: Option<u32>, span: Span) -> Result<(), Fault> {
        let Some(level) = self.levels.last_mut() else { return Ok(()) };
        let Some(call) = level.own.call.clone() else {
            // The main program would restart endlessly; one pass suffices to see all of it.
            match target {
                None => {
                    self.channel.push(Kind::After(vec![super::auxiliary::word(99)]));
                    self.ledger.end();
                }
                Some(_) => self.go_to(target, span)?,
            }
            return Ok(());
        };
        let (own, part) = (level.program, level.part);
        if target.is_some() && self.machine.control.iso.is_haas() {
            // A Haas jumps within the subprogram.
            return self.go_to(target, span);
        }
        level.repeats = level.repeats.saturating_sub(1);
        let again = level.repeats > 0 && target.is_none();
        if again {
            level.next = level.own.start;
        }
        self.leave(call.kind);
        if again {
            self.enter(&call);
            return Ok(());
        }
        self.levels.pop();
        if let Some(number) = target {
            self.check_return(number, (own, part), span)?;
        }
        self.go_to(target, span)
    }

    /// Checks M99 P for a number that both caller and subprogram have: a Haas continues in the subprogram.
    fn check_return(&self, number: u32, (program, part): (usize, usize), span: Span) -> Result<(), Fault> {
        let Some(caller) = self.levels.last() else { return Ok(()) };
        let has = |program: usize, part: usize| self.programs[program].program.find_block(part, number, 0).is_some();
        let is_double = has(program, part) && has(caller.program, caller.part);
        if !is_double || self.machine.control.iso.reads_as_fanuc() {
            return Ok(());
        }
        let message = format!(
            "M99 P{number}: a Fanuc continues at N{number} of the caller, a Haas at N{number} of this program, and both exist"
        );
        let help =
            "give the two blocks different numbers; or set control.word_meaning = \"fanuc\" or controller = \"haas\"";
        Err(at(span, Code::TWO_MEANINGS, message, help))
    }

    /// Handles the end of a program's blocks.
    pub(super) fn end_of_part(&mut self) {
        let is_main = self.levels.last().is_none_or(|level| level.own.call.is_none());
        if let Some(level) =
            self.levels.last_mut().filter(|level| is_main && level.program == 0 && level.part < self.own.main)
        {
            // The first numbered program follows the blocks before its number.
            level.part = self.own.main;
            level.next = self.programs[0].program.parts.get(self.own.main).map_or(0, |part| part.blocks.start);
        } else if is_main {
            self.ledger.end();
        } else {
            // Without M99 or endsub the program ends nevertheless.
            let _ = self.return_to(None, Span::default());
        }
    }

    /// Begins the modal call after a block with motion. Returns `false` if there is none.
    pub(super) fn trigger(&mut self, line: u32) -> Result<bool, Fault> {
        let bound = self.levels.last().and_then(|level| level.own.modal).unwrap_or(self.channel.modal_calls.len());
        let Some(place) = bound.checked_sub(1) else { return Ok(false) };
        let Some(call) = self.channel.modal_calls.get(place).cloned() else { return Ok(false) };
        self.call(Box::new(call), line, Some(place))?;
        Ok(true)
    }

    /// Jumps to the block of M99 P in the program that continues.
    fn go_to(&mut self, target: Option<u32>, span: Span) -> Result<(), Fault> {
        let (Some(number), Some(level)) = (target, self.levels.last_mut()) else { return Ok(()) };
        let loaded = &self.programs[level.program];
        let from = level.next.saturating_sub(1);
        let Some(found) = loaded.program.find_block(level.part, number, from) else {
            let message = format!("block N{number} is not in the program that continues");
            return Err(at(span, Code::NO_TARGET, message, "check the number of the block"));
        };
        check_loops(loaded, from, found, span)?;
        level.next = found;
        Ok(())
    }
}
