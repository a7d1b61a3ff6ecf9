//! Flow of execution: G14, G22, G23, G29, M30.

use super::gathered::Gathered;
use super::level::{Action, Interpreter, Level, LevelKind, MacroCall};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::level::RepeatedSection;
use crate::syntax::words::{Block, PartKind};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_machine::snc::{Kind, Word, WordValue};

/// Maximum nesting of repetitions.
const MOST_REPEATS: usize = 16;
/// Maximum nesting of macros.
const MOST_MACROS: usize = 8;
/// Maximum passes of one repetition.
const MOST_PASSES: f64 = 1e9;

/// G codes that control the execution.
pub(super) const FLOW_CODES: [u16; 4] = [14, 22, 23, 29];

impl Interpreter<'_> {
    /// Executes the flow code of a block.
    pub(super) fn flow(&mut self, code: u16, span: Span, block: &Block, index: usize) -> Result<(), Fault> {
        let mut gathered = std::mem::take(&mut self.own);
        gathered.take_code(code);
        let other = gathered.codes.first().or(gathered.functions.first());
        if let Some(other) = other {
            let message = format!("G{code} shares its block with other G or M codes");
            let found = fault(Code::MUST_STAND_ALONE, other.span, message, "give it its own block");
            self.own = gathered;
            return Err(found);
        }
        let action = match code {
            14 => self.section(&mut gathered, span, index),
            22 => self.call_macro(&mut gathered, span),
            23 => self.call_program(&mut gathered, span),
            _ => self.jump(&mut gathered, span),
        };
        let done = action.and_then(|action| self.act(action, block));
        let rest = done.and_then(|()| gathered.check_all_used());
        self.own = gathered;
        rest
    }

    /// `G14 N1=a N2=b J n`: repeats the blocks from a to b n more times.
    fn section(&self, gathered: &mut Gathered, span: Span, index: usize) -> Result<Action, Fault> {
        let Some((first, at)) = gathered.once(b'N', Some(1))? else {
            return Err(bad_value(span, "G14 needs N1=", "name the first block of the section"));
        };
        let first = self.block_numbered(first, at)?;
        let last = match gathered.once(b'N', Some(2))? {
            None => first,
            Some((last, at)) => self.block_numbered(last, at)?,
        };
        let (first, last) = (first.min(last), first.max(last));
        if (first..=last).contains(&index) {
            let help = "let the section end before this block";
            return Err(bad_value(span, "G14 is inside the section that it repeats", help));
        }
        let step = gathered.once(b'K', None)?.map_or(1.0, |found| found.0);
        let times = gathered.once(b'J', None)?;
        let counter = gathered.parameters.pop();
        let (left, counter) = match (counter, times) {
            (Some(_), Some((_, at))) => {
                return Err(bad_value(at, "G14 with J and with a parameter", "keep one of them"));
            }
            (Some(code), None) => {
                let number = usize::from(code.number);
                let value = self.channel.parameters.get(number, code.span)?;
                if step <= 0.0 {
                    return Err(bad_value(code.span, "the parameter of G14 must decrease: K above 0", "correct K"));
                }
                ((value / step).ceil().clamp(0.0, MOST_PASSES), Some((number, step)))
            }
            (None, times) => (times.map_or(1.0, |found| found.0), None),
        };
        let left_at = times.map_or(span, |found| found.1);
        if !(0.0..=MOST_PASSES).contains(&left) || left.fract() != 0.0 {
            return Err(bad_value(
                left_at,
                format!("J={left} is not a valid number of repetitions"),
                "write a whole number, 0 or larger",
            ));
        }
        if left == 0.0 {
            return Ok(Action::Next);
        }
        if self.levels.last().is_some_and(|level| level.repetitions() >= MOST_REPEATS) {
            let message = "repetitions (G14) are nested too deeply";
            return Err(fault(Code::TOO_MANY_CALLS, span, message, "write some of the repetitions out"));
        }
        Ok(Action::Repeat(RepeatedSection { first, last, passes: left as u64, pass: counter }))
    }

    /// Decrements the parameter at the start of a further pass.
    pub(super) fn count_down(&mut self, counter: Option<(usize, f64)>) -> Result<(), Fault> {
        let Some((number, step)) = counter else { return Ok(()) };
        let value = self.channel.parameters.get(number, Span::default())?;
        self.channel.parameters.set(number, value - step, Span::default())
    }

    /// `G22 N=9101`; with a parameter, only if it is above 0.
    fn call_macro(&self, gathered: &mut Gathered, span: Span) -> Result<Action, Fault> {
        let number = self.called(gathered, span)?;
        if !self.holds(gathered)? {
            return Ok(Action::Next);
        }
        let depth = self.levels.iter().filter(|level| level.own == LevelKind::Macro).count();
        if depth >= MOST_MACROS {
            let message = format!("macros are nested more than {MOST_MACROS} deep");
            return Err(fault(Code::TOO_MANY_CALLS, span, message, "does a macro call itself?"));
        }
        Ok(Action::Call(MacroCall { kind: LevelKind::Macro, number, span }))
    }

    /// `G23 N=9002`: calls a whole program, which returns with M30.
    fn call_program(&self, gathered: &mut Gathered, span: Span) -> Result<Action, Fault> {
        let number = self.called(gathered, span)?;
        if !self.holds(gathered)? {
            return Ok(Action::Next);
        }
        if self.levels.iter().any(|level| level.own == LevelKind::Macro) {
            let message = "G23 calls a program from a macro";
            return Err(fault(Code::NOT_SUPPORTED, span, message, "call it from the main program"));
        }
        if self.levels.len() > MOST_MACROS {
            let message = "programs are nested too deeply";
            return Err(fault(Code::TOO_MANY_CALLS, span, message, "does a program call itself?"));
        }
        Ok(Action::Call(MacroCall { kind: LevelKind::Program, number, span }))
    }

    fn called(&self, gathered: &mut Gathered, span: Span) -> Result<u32, Fault> {
        match gathered.once(b'N', None)? {
            Some((number, _)) if number.fract() == 0.0 && (0.0..1e9).contains(&number) => Ok(number as u32),
            _ => {
                Err(bad_value(span, "the call needs the number of the called program", "write for example G22 N=9101"))
            }
        }
    }

    /// `true` if the parameter of a conditional call or jump is above 0, or without parameter.
    fn holds(&self, gathered: &mut Gathered) -> Result<bool, Fault> {
        match gathered.parameters.pop() {
            None => Ok(true),
            Some(code) => Ok(self.channel.parameters.get(usize::from(code.number), code.span)? > 0.0),
        }
    }

    /// Begins a call.
    pub(super) fn enter(&mut self, call: MacroCall, block: &Block) -> Result<(), Fault> {
        let MacroCall { kind, number, span } = call;
        let part_kind = if kind == LevelKind::Macro { PartKind::Macro } else { PartKind::Program };
        let Some((program, part)) = self.find(part_kind, number) else {
            let (what, ending) = if kind == LevelKind::Macro { ("macro", "MM") } else { ("program", "PM") };
            let message = self.library.refusal().unwrap_or_else(|| {
                format!("{what} {number} is not in this file, and there is no file {number}.{ending} in its folder")
            });
            return Err(fault(Code::NO_SUBPROGRAM, span, message, "put it into this file or its folder"));
        };
        let start = self.programs.get(program).and_then(|loaded| loaded.program.parts.get(part));
        let start = start.map_or(0, |part| part.blocks.start);
        let calls = self.chain(block.line);
        self.levels.push(Level::new(program, part, start, calls, kind));
        Ok(())
    }

    /// `G29 E1 N=30 K1`: jumps if the parameter is above 0, and then decrements it by K.
    fn jump(&mut self, gathered: &mut Gathered, span: Span) -> Result<Action, Fault> {
        let number = self.called(gathered, span)?;
        let step = gathered.once(b'K', None)?;
        // The search direction has no effect: block numbers are unique.
        gathered.once(b'I', None)?;
        let parameter = gathered.parameters.last().copied();
        if !self.holds(gathered)? {
            return Ok(Action::Next);
        }
        if let (Some(parameter), Some((step, _))) = (parameter, step) {
            let place = usize::from(parameter.number);
            let value = self.channel.parameters.get(place, parameter.span)?;
            self.channel.parameters.set(place, value - step, parameter.span)?;
        }
        let target = self.block_numbered(f64::from(number), span)?;
        Ok(Action::Goto(target))
    }

    /// The block with a number in the running program.
    fn block_numbered(&self, number: f64, span: Span) -> Result<usize, Fault> {
        let found = self.levels.last().and_then(|level| {
            let program = &self.programs.get(level.program)?.program;
            if number.fract() != 0.0 || !(0.0..1e9).contains(&number) {
                return None;
            }
            let first = program.find_block(level.part, number as u32, usize::MAX)?;
            let second = program.find_block(level.part, number as u32, first)?;
            let line = |index: usize| program.blocks.get(index).map_or(0, |block| block.line);
            Some((first, (second != first).then(|| [line(first), line(second)])))
        });
        if let Some((_, Some([first, second]))) = found {
            let message = format!("N{number} is the number of line {first} and of line {second}");
            let help = "numbers may repeat, but not that of a block to which G14 or G29 refers";
            return Err(fault(Code::DOUBLE_NUMBER, span, message, help));
        }
        found.map(|(first, _)| first).ok_or_else(|| {
            let message = format!("there is no block N{number} in this program");
            fault(Code::NO_TARGET, span, message, "targets must be in the same program or macro")
        })
    }

    /// Ends a level at M30, M2, or the last block.
    pub(super) fn end(&mut self, word: Option<u16>) {
        let is_main = self.levels.last().is_none_or(|level| level.own == LevelKind::Main);
        if is_main {
            if let Some(number) = word {
                let value = WordValue::Number(f64::from(number));
                self.channel.outlet.push(Kind::After(vec![Word { letter: b'M', extension: None, value }]));
            }
            self.pass_notes_behind_end();
            self.ledger.end();
        }
        self.levels.pop();
    }
}
