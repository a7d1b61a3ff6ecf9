//! EXECSTRING: a text executed as a block in place, with the variables of the program that contains it.

use super::gathered::Call;
use super::level::{Entry, Interpreter, Loaded};
use super::loaded::load;
use super::scope::scope_of;
use super::value::Value;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{self, Block, Body, NameId};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::{FileId, Source, Span};

/// Maximum number of different texts of a run, each parsed once.
const MOST_TEXTS: usize = 10_000;

impl Interpreter<'_> {
    /// `EXECSTRING(text)`
    pub(super) fn execute_text(&mut self, call: &Call, block: &Block) -> Result<(), Fault> {
        let span = call.span;
        self.check_depth("EXECSTRING", span)?;
        let Some(caller) = self.levels.last().map(|level| level.program) else { return Ok(()) };
        let text = text_of(&self.programs[caller], call, &scope_of(&self.programs[caller], &self.channel))?;
        let program = match self.own.texts.get(&text) {
            Some(&known) => known,
            None => self.load_text(text, span)?,
        };
        // An empty text has no effect.
        if self.programs[program].program.blocks.iter().all(|block| matches!(block.body, Body::Empty)) {
            return Ok(());
        }
        let names = |at: usize| &self.programs[at].program.names;
        // Only the variables named in the text are lent: its names have their own numbers.
        let lent: Vec<(NameId, NameId)> = names(program)
            .iter()
            .filter_map(|name| Some((names(caller).find(name)?, names(program).find(name)?)))
            .collect();
        let file = self.programs[caller].program.source.id();
        self.begin(
            Entry { program, section: 0, arguments: Vec::new(), repeats: 1, is_modal: false, part: None, span, file },
            block.line,
        );
        if let Some(level) = self.levels.last_mut() {
            let locals = level.own.callers_variables.lend(&lent);
            self.channel.variables.exchange(locals);
            level.own.lent = Some(lent);
        }
        Ok(())
    }

    /// Parses a text at its first execution.
    fn load_text(&mut self, text: Vec<u8>, span: Span) -> Result<usize, Fault> {
        let too_many = || {
            let message = format!("EXECSTRING executes more than {MOST_TEXTS} different texts");
            fault(Code::NOT_SUPPORTED, span, message, "assign to an element of an array instead of composing a name")
        };
        let id = u16::try_from(self.ledger.sources.len())
            .ok()
            .filter(|_| self.own.texts.len() < MOST_TEXTS)
            .ok_or_else(too_many)?;
        let source = Source::new(FileId(id), "text of EXECSTRING", text.clone()).map_err(|_| too_many())?;
        let (program, findings) = sinumerik::parse_with(&source, self.programs[0].program.dialect, &self.own.macros);
        let does = |block: &&Block| !matches!(block.body, Body::Empty);
        let allowed = |block: &Block| {
            matches!(block.body, Body::Words | Body::Call(_) | Body::Synchronised { .. } | Body::Faulty)
        };
        let mut blocks = program.blocks.iter().filter(does);
        if program.sections.len() > 1 || !blocks.next().is_none_or(allowed) || blocks.next().is_some() {
            let message = "EXECSTRING of a jump, a definition, a control structure or several blocks is not supported";
            return Err(fault(Code::NOT_SUPPORTED, span, message, "write these blocks out"));
        }
        self.ledger.sources.push(program.source.clone());
        for finding in findings.into_iter().filter(|finding| finding.code != Code::NOT_A_PROGRAM) {
            self.report(finding);
        }
        let number = self.keep(load(program, &self.machine.control));
        self.own.texts.insert(text, number);
        Ok(number)
    }

    /// Ends the running texts: RET and M17 in them belong to the program that contains them.
    pub(super) fn leave_texts(&mut self) {
        while self.levels.len() > 1 && self.levels.last().is_some_and(|level| level.own.lent.is_some()) {
            self.leave();
        }
    }
}

/// The text to be executed.
fn text_of(loaded: &Loaded, call: &Call, scope: &super::expression::Scope<'_>) -> Result<Vec<u8>, Fault> {
    let arguments = call.arguments.map_or(&[][..], |range| loaded.program.arguments_of(range));
    let [Some(id)] = arguments else {
        let message = "EXECSTRING takes one argument, the text of a block";
        return Err(fault(Code::BAD_ARGUMENTS, call.span, message, "write for example EXECSTRING(\"X=\"<<R1)"));
    };
    match scope.value(*id)? {
        Value::Text(text) => Ok(text),
        _ => {
            let help = "append numbers to a string with <<";
            Err(fault(Code::TYPE_MISMATCH, loaded.program.expr(*id).span, "EXECSTRING takes a string", help))
        }
    }
}
