//! Calls: finds the program, begins its level, and returns from it.

use super::channel::Channel;
use super::contour_call;
use super::flow;
use super::gathered::Call;
use super::jump::{place_of, search, variable};
use super::level::{CalledWith, Entry, Interpreter, Level, Loaded, ReturnTarget};
use super::names::opaque_moves;
use super::parameters;
use super::part::{COUNT_HELP, count_of};
use super::pass::opaque_statement;
use super::place::Place;
use super::save;
use super::scope::scope_of;
use super::value::Value;
use super::variables::Locals;
use super::{cycles, library, names};
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::level::RepeatedSection;
use crate::syntax::look_alike;
use crate::syntax::sinumerik::{ArgumentRange, Block, CallKind, CallStatement, Callee, JumpTarget, Search};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_machine::snc::Kind;

impl Interpreter<'_> {
    /// Executes a call by word: `NAME`, `NAME(…)`, `L10 P2`.
    pub(super) fn call(&mut self, call: &Call, block: &Block) -> Result<(), Fault> {
        let caller = self.levels.last().map_or(0, |level| level.program);
        if call.name == "CYCLE800" && self.find("CYCLE800", caller).is_none() {
            return self.swivel(call);
        }
        if call.name == contour_call::CONTOUR && self.find(contour_call::CONTOUR, caller).is_none() {
            return self.name_contour(call);
        }
        if call.name == "EXECSTRING" {
            return self.execute_text(call, block);
        }
        self.check_depth(&call.name, call.span)?;
        if call.repeats == 0 {
            return Ok(());
        }
        let entry = match self.contour_of(call)? {
            Some(name) => {
                let entry = self.entry(&name, None, 1, call.span)?;
                self.to_first_point(entry)?
            }
            None => self.entry(&call.name, call.arguments, call.repeats, call.span)?,
        };
        self.begin(entry, block.line);
        Ok(())
    }

    /// `MCALL`, `CALL`, `PCALL`, `EXTCALL`, `CALLPATH`.
    pub(super) fn call_statement(&mut self, statement: &CallStatement, block: &Block) -> Result<(), Fault> {
        let Some(caller) = self.levels.last().map(|level| level.program) else { return Ok(()) };
        let CallStatement { span, kind, callee, arguments, repeats, part } = *statement;
        let name = callee.map(|callee| name_of(&self.programs[caller], &self.channel, callee)).transpose()?;
        if kind == CallKind::Path {
            self.library.add_folder(name.as_deref().unwrap_or_default());
            // A missing program may exist now.
            self.forget_missing();
            return Ok(());
        }
        let repeats = match repeats {
            Some(id) => {
                let value = scope_of(&self.programs[caller], &self.channel).number(id)?;
                let help = COUNT_HELP;
                count_of(value)
                    .ok_or_else(|| fault(Code::BAD_WORD_VALUE, span, format!("P{value} is not possible"), help))?
            }
            None => 1,
        };
        if kind == CallKind::Modal {
            self.own.modal_call = None;
            self.channel.system.modal_call = false;
            if self.channel.settings.writes_cycles() && name.is_none() {
                self.channel.push(Kind::Keep("MCALL"));
            }
            if let Some(name) = name {
                let entry = self.entry(&name, arguments, repeats, span)?;
                self.channel.system.modal_call = true;
                // The output has the call again, with the number of this block.
                if self.channel.settings.writes_cycles() && self.makes_holes(&entry) {
                    self.channel.push(Kind::Empty);
                }
                self.own.modal_call = Some(Entry { is_modal: true, ..entry });
            }
            return Ok(());
        }
        let short = name.as_deref().and_then(|name| name.rsplit('/').next()).unwrap_or_default();
        if let Some(moves) = opaque_moves(&self.machine.control, &short.to_ascii_uppercase()).filter(|_| part.is_none())
        {
            let written = (span, name.as_deref().unwrap_or_default());
            return opaque_statement(&self.programs[caller], &mut self.channel, written, arguments, moves);
        }
        let shown = name.as_deref().unwrap_or("BLOCK");
        self.check_depth(shown, span)?;
        if repeats == 0 {
            return Ok(());
        }
        let Some((first, last)) = part else {
            let entry = self.entry(shown, arguments, repeats, span)?;
            self.begin(entry, block.line);
            return Ok(());
        };
        let mut entry = match &name {
            Some(name) => self.entry(name, arguments, repeats, span)?,
            None => {
                let section = self.levels.last().map_or(0, |level| level.part);
                let file = self.programs[caller].program.source.id();
                Entry {
                    program: caller,
                    section,
                    arguments: Vec::new(),
                    repeats,
                    is_modal: false,
                    part: None,
                    span,
                    file,
                }
            }
        };
        // Variables for the labels are those of the caller; the blocks are those of the callee.
        let text = |target| self.label_text(caller, target, span);
        let (first, last) = (text(first)?, text(last)?);
        self.programs[entry.program].program.keep_whole();
        let loaded = &self.programs[entry.program];
        let blocks = loaded.program.sections.get(entry.section).map_or(0..0, |section| section.blocks.clone());
        let find = |text: &[u8], from: usize| {
            let place = Place::of_text(&loaded.program, text)?;
            (from..blocks.end).find(|&at| place.is_at(&loaded.program.blocks[at]))
        };
        let found = find(&first, blocks.start).and_then(|first| Some((first, find(&last, first)?)));
        let Some((first, last)) = found else {
            let message = format!("{shown} has no blocks from {} to {}", lossy(&first), lossy(&last));
            return Err(fault(Code::NO_TARGET, span, message, "check the labels and their order"));
        };
        if name.is_none() {
            // A part of the running program sees its variables.
            if let Some(level) = self.levels.last_mut() {
                level.repeat(RepeatedSection { first, last, passes: u64::from(repeats), pass: () }, level.next);
            }
            return Ok(());
        }
        entry.part = Some((first, last));
        self.begin(entry, block.line);
        Ok(())
    }

    fn label_text(&self, program: usize, target: JumpTarget, span: Span) -> Result<Vec<u8>, Fault> {
        let loaded = &self.programs[program];
        match place_of(loaded, &self.channel, target)? {
            Some(Place::Label(name)) => Ok(loaded.program.names.text(name).as_bytes().to_vec()),
            Some(Place::Number(number)) => {
                Ok(format!("{}{}", if number.main { ':' } else { 'N' }, number.number).into_bytes())
            }
            None => match target {
                JumpTarget::Computed(id) => Ok(scope_of(loaded, &self.channel).value(id)?.text()),
                JumpTarget::Label(name) => {
                    Ok(variable(loaded, &self.channel, name).map(Value::text).unwrap_or_default())
                }
                _ => Err(fault(Code::NO_TARGET, span, "this is not a label", "write a label or block number")),
            },
        }
    }

    /// Number of program levels in use; a repetition counts as one.
    fn depth(&self) -> usize {
        let counted = |level: &&Level| counts(level, &self.programs);
        self.levels.iter().filter(counted).map(|level| 1 + level.repetitions()).sum()
    }

    /// Reports too many program levels.
    pub(super) fn check_depth(&self, name: &str, span: Span) -> Result<(), Fault> {
        let depth = self.depth();
        if depth as u64 >= u64::from(self.machine.control.max_program_levels) {
            let message = format!("{name} would be program level {}", depth + 1);
            let help = "a program that calls itself never ends; the limit is control.max_program_levels";
            return Err(fault(Code::TOO_MANY_CALLS, span, message, help));
        }
        Ok(())
    }

    /// The program of a name with its arguments, evaluated in the running program.
    fn entry(
        &mut self,
        name: &str,
        arguments: Option<ArgumentRange>,
        repeats: u32,
        span: Span,
    ) -> Result<Entry, Fault> {
        let caller = self.levels.last().map_or(0, |level| level.program);
        let stored = self.named_contour(name, span)?;
        let name = stored.as_deref().unwrap_or(name);
        if let Some(entry) = self.part_of_contour(name, repeats, span)? {
            return Ok(entry);
        }
        let Some((program, section)) = self.find(name, caller) else {
            if let Some((reason, help)) = cycles::refusal(name) {
                let help = format!(
                    "{help}; to let the control run the cycle without a correction, name it in control.opaque of the machine file"
                );
                return Err(fault(Code::NOT_SUPPORTED, span, format!("{name} is not executed: {reason}"), help));
            }
            let cycle = names::is_cycle(name);
            let (code, message) = if cycle {
                (Code::NOT_SUPPORTED, format!("the cycle {name} is not supported yet"))
            } else {
                let refusal = self.library.refusal();
                (Code::NO_SUBPROGRAM, refusal.unwrap_or_else(|| format!("there is no program {name}")))
            };
            let written = self.programs[caller].program.source.slice(span);
            let help = if cycle {
                "write its moves out, or add it to control.opaque of the machine file if the control is to run it itself"
                    .to_owned()
            } else {
                format!(
                    "put it next to the main program as {name}.SPF; or if the control is to run it itself, write opaque = [\"{name}\"] in [control]"
                )
            };
            let help = match look_alike::whole(written) {
                Some(typed) => format!("{typed}; if it is a program, {help}"),
                None => help,
            };
            return Err(fault(code, span, message, help));
        };
        let called = &self.programs[program];
        let wanted = (called, called.parameters(section));
        let arguments = parameters::evaluate(&self.programs[caller], &self.channel, wanted, arguments, span)?;
        let file = self.programs[caller].program.source.id();
        Ok(Entry { program, section, arguments, repeats, is_modal: false, part: None, span, file })
    }

    /// Begins the level of a call.
    pub(super) fn begin(&mut self, entry: Entry, line: u32) {
        let Some(level) = self.levels.last() else { return };
        let caller = level.own.cycle.map_or((level.calls, line), |cycle| (cycle.origin.calls, cycle.origin.line));
        let calls = self.ledger.chain(caller.0, caller.1);
        self.enter(entry, calls);
    }

    fn enter(&mut self, entry: Entry, calls: u32) {
        let not_kept = self.mark_hole(&entry);
        let Entry { program, section, arguments, repeats, is_modal, part, span, file } = entry;
        let cycle = self.cycle_of(program, is_modal, (file, span));
        let refused = self.under_compensation(cycle, span);
        let is_inside = self.levels.last().is_some_and(|level| level.own.cycle.is_some());
        if let Some(name) = cycle.map(|cycle| cycle.name).filter(|name| !is_inside && cycles::mills(name)) {
            self.channel.outlet.mill(name, |text| format!(";{text}"));
        }
        let loaded = &self.programs[program];
        let blocks = loaded.program.sections.get(section).map_or(0..0, |section| section.blocks.clone());
        let own = CalledWith {
            span,
            cycle,
            is_modal,
            within: part,
            saved: loaded.own.has_save(section).then(|| Box::new(self.channel.modal.clone())),
            callers_variables: self.channel.variables.exchange(Locals::default()),
            ..CalledWith::default()
        };
        let mut level = Level::new(program, section, blocks.start, calls, own);
        if let Some((first, last)) = part {
            level.repeat(RepeatedSection { first, last, passes: 1, pass: () }, blocks.end);
        }
        level.repeats = repeats;
        let bound = parameters::bind(loaded, &mut self.channel, loaded.parameters(section), &arguments);
        level.own.arguments = arguments;
        let called = loaded.program.source.id();
        if let Some(found) = refused.or(not_kept) {
            self.report(found.in_file(file));
        }
        let file = called;
        self.levels.push(level);
        if let Err(found) = bound {
            self.report(found.in_file(file));
        }
    }

    /// Removes the last level and restores the caller's state.
    pub(super) fn leave(&mut self) -> Option<Level> {
        let mut level = self.levels.pop()?;
        let called = &self.programs[level.program];
        parameters::results(called, &self.channel.variables, called.parameters(level.part), &mut level.own.arguments);
        let own = self.channel.variables.exchange(std::mem::take(&mut level.own.callers_variables));
        if let Some(lent) = level.own.lent.take() {
            self.channel.variables.take_back(own, &lent);
        }
        if let Some(saved) = level.own.saved.take() {
            save::restore(&mut self.channel, *saved);
        }
        self.mark_hole_end(level.program);
        let caller = self.levels.last().map_or(0, |level| level.program);
        let given =
            parameters::give_back(&self.programs[caller], &mut self.channel, &level.own.arguments, level.own.span);
        if let Err(found) = given {
            self.report_here(found);
        }
        Some(level)
    }

    /// Ends a program: returns to the caller, or ends the run. `word` is M2, M17 or M30, if any.
    pub(super) fn end_of_program(&mut self, word: Option<u32>) {
        if word.is_some() {
            self.leave_texts();
        }
        if self.levels.len() <= 1 {
            if let Some(number) = word {
                flow::push_end(&mut self.channel, number);
            }
            self.ledger.end();
            return;
        }
        let Some(level) = self.leave() else { return };
        if level.repeats > 1 {
            let Level { program, part: section, calls, repeats, own, .. } = level;
            let CalledWith { arguments, is_modal, within: part, span, .. } = own;
            let file = self.channel.outlet.file();
            self.enter(Entry { program, section, arguments, repeats: repeats - 1, is_modal, part, span, file }, calls);
        }
    }

    /// RET, including a return to a place in a caller.
    pub(super) fn return_to(&mut self, target: &ReturnTarget, span: Span) -> Result<(), Fault> {
        self.leave_texts();
        if self.levels.len() == 1 {
            self.channel.push(Kind::Keep("RET"));
        }
        if target.place.is_empty() && target.levels == 1 {
            self.end_of_program(None);
            return Ok(());
        }
        for _ in 0..target.levels {
            if self.levels.len() <= 1 {
                self.ledger.end();
                return Ok(());
            }
            self.leave();
        }
        let Some(level) = self.levels.last_mut().filter(|_| !target.place.is_empty()) else { return Ok(()) };
        let loaded = &mut self.programs[level.program];
        loaded.program.keep_whole();
        let section = loaded.program.sections.get(level.part).map_or(0..0, |section| section.blocks.clone());
        let place = Place::of_text(&loaded.program, &target.place);
        let index = level.next.saturating_sub(1);
        let found = place.and_then(|place| search(&loaded.program.blocks, place, Search::Around, index, section));
        let Some(found) = found else {
            let message = format!("RET: the calling program has no block {}", lossy(&target.place));
            return Err(fault(Code::NO_TARGET, span, message, "check the label and the caller of the program"));
        };
        level.go_to(found + usize::from(target.behind), true);
        Ok(())
    }

    /// Reports an error in the running program.
    #[expect(clippy::boxed_local, reason = "findings come like this")]
    pub(super) fn report_here(&mut self, found: Fault) {
        let program = self.levels.last().map_or(0, |level| level.program);
        let file = self.programs[program].program.source.id();
        self.report(found.in_file(file));
    }

    /// The program and section of a name. The search order is the caller's file, the main program's file, programs found before, the library, the
    /// built-in cycles. A path is searched in the library first.
    fn find(&mut self, name: &str, caller: usize) -> Option<(usize, usize)> {
        let short = library::program_name(name);
        // A file without header has a section without name.
        if short.is_empty() {
            return None;
        }
        let is_path = name.len() != short.len() && name.contains(['/', '\\', ':']);
        if !is_path {
            let in_caller =
                library::section_of(&self.programs[caller].program, &short).map(|section| (caller, section));
            let in_main = || library::section_of(&self.programs[0].program, &short).map(|section| (0, section));
            if let Some(found) = in_caller.or_else(in_main) {
                return Some(found);
            }
        }
        let key = if is_path { name } else { &short };
        self.find_once(key, |run| {
            let found = run.load(key, &short, is_path);
            if found.is_none() && is_path { run.find(&short, caller) } else { found }
        })
    }
}

/// `true` if a level counts as a program level; a cycle of the control counts as one, however it is implemented here.
fn counts(level: &Level, programs: &[Loaded]) -> bool {
    let name = programs.get(level.program).and_then(|loaded| loaded.own.built_in);
    !name.is_some_and(|name| name.starts_with('_'))
}

/// The name or path of the program that a statement calls.
fn name_of(loaded: &Loaded, channel: &Channel<'_>, callee: Callee) -> Result<String, Fault> {
    Ok(match callee {
        Callee::Name(name) => loaded.program.names.text(name).to_owned(),
        Callee::Path(span) => lossy(loaded.program.source.slice(span)),
        Callee::Computed(id) => match scope_of(loaded, channel).value(id)? {
            Value::Text(text) => lossy(&text),
            _ => {
                let span = loaded.program.expr(id).span;
                let help = "write for example CALL \"NAME\"";
                return Err(fault(Code::TYPE_MISMATCH, span, "the name of a program is a string", help));
            }
        },
    })
}

fn lossy(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim().to_owned()
}
