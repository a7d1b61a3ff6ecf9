//! The interpreter for any language: levels, the files of the run, and the sequence of blocks.

use std::borrow::Borrow;
use std::collections::{HashMap, VecDeque};
use std::hash::Hash;

use super::executor::Executor;
use super::family::{BlockOf, Family, FileOf};
use super::fault::Fault;
use super::level::{AfterBlock, ProgramLevel};
use super::library::Library;
use super::motion_sink::HasOutlet;
use super::program::{ProgramText, Statement};
use super::run_state::RunState;
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::{FileId, Source, Span};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, Origin};

/// The functions that a family of languages provides to the core.
pub(in crate::exec) trait Execute: Family {
    /// The state of the control, and the motion sink.
    type Channel<'a>: HasOutlet<'a>;
    /// State of a run in addition to the channel.
    type Run;

    /// Parses a file named by a call.
    fn parse(run: &Runner<'_, Self>, source: &Source) -> (Self::Program, Vec<Diagnostic>);

    /// The index after the last block of a level.
    fn end_of(channel: &Self::Channel<'_>, file: &FileOf<Self>, level: &ProgramLevel<Self>) -> usize;

    /// Prepares the execution of a block: sets the origin of its elements and emits what comes before them.
    fn begin(run: &mut Runner<'_, Self>, block: &BlockOf<Self>, own: Origin);

    /// Executes a block; `index` is its index in the program.
    fn block(run: &mut Runner<'_, Self>, block: &BlockOf<Self>, index: usize) -> Result<AfterBlock<Self>, Fault>;

    /// Begins the level of the modal call after a block with motion. Returns `false` if there is none.
    fn modal_call(_run: &mut Runner<'_, Self>, _block: &BlockOf<Self>) -> Result<bool, Fault> {
        Ok(false)
    }

    /// Reports too many nested repetitions.
    fn check_repetition(_run: &Runner<'_, Self>, _span: Span) -> Result<(), Fault> {
        Ok(())
    }

    /// Begins a pass of a repetition.
    fn begin_pass(_run: &mut Runner<'_, Self>, _pass: Self::Pass) -> Result<(), Fault> {
        Ok(())
    }

    /// Begins a call.
    fn call(run: &mut Runner<'_, Self>, call: Self::Call, block: &BlockOf<Self>) -> Result<(), Fault>;

    /// Returns to a caller.
    fn return_to(run: &mut Runner<'_, Self>, target: Self::Return, span: Span) -> Result<(), Fault>;

    /// Handles a block that ends its program.
    fn end_of_program(run: &mut Runner<'_, Self>, end: Self::End);

    /// Handles the end of a level's blocks.
    fn end_of_blocks(run: &mut Runner<'_, Self>);

    /// Handles an error in a block.
    fn behind_fault(_run: &mut Runner<'_, Self>) {}

    /// Moves a diagnostic to the place that is meaningful to the user.
    fn as_seen_by_user(_run: &Runner<'_, Self>, finding: Diagnostic) -> Diagnostic {
        finding
    }

    /// Emits what is held back after the last block; called once.
    fn finish(run: &mut Runner<'_, Self>);
}

/// A running program.
pub(in crate::exec) struct Runner<'a, F: Execute> {
    pub(in crate::exec) machine: &'a Machine,
    pub(in crate::exec) library: Box<dyn Library + 'a>,
    pub(in crate::exec) ledger: RunState,
    /// The files of the run; the first one contains the main program.
    pub(in crate::exec) programs: Vec<FileOf<F>>,
    /// The running programs; the innermost is last.
    pub(in crate::exec) levels: Vec<ProgramLevel<F>>,
    pub(in crate::exec) channel: F::Channel<'a>,
    /// State of the family.
    pub(in crate::exec) own: F::Run,
    /// Programs that were searched.
    found: HashMap<F::Name, Option<F::Entry>>,
}

impl<'a, F: Execute> Runner<'a, F> {
    /// Starts the main program at its given level.
    pub(in crate::exec) fn start(
        machine: &'a Machine,
        library: Box<dyn Library + 'a>,
        ledger: RunState,
        (channel, own): (F::Channel<'a>, F::Run),
        (main, level): (FileOf<F>, ProgramLevel<F>),
    ) -> Self {
        let (programs, levels) = (vec![main], vec![level]);
        Runner { machine, library, ledger, programs, levels, channel, own, found: HashMap::new() }
    }

    /// Executes one block.
    fn execute_block(&mut self) {
        let Some(level) = self.levels.last_mut() else {
            self.ledger.end();
            return;
        };
        let Some(loaded) = self.programs.get_mut(level.program) else {
            self.ledger.end();
            return;
        };
        if let Some(pending) = level.pending.take() {
            loaded.program.ensure(level.next.saturating_sub(1));
            let file = loaded.program.source().id();
            if let Err(found) = self.act(pending.0, &pending.1) {
                self.report(found.in_file(file));
            }
            return;
        }
        if level.repetitions() > 0
            && let Some(pass) = level.end_sections()
        {
            self.begin_pass(pass);
        }
        let Runner { programs, levels, channel, .. } = self;
        let Some(level) = levels.last_mut() else { return };
        let Some(loaded) = programs.get_mut(level.program) else { return };
        let index = level.next;
        loaded.program.ensure(index);
        let end = F::end_of(channel, loaded, level);
        let Some(&block) = loaded.program.block(index).filter(|_| index < end) else {
            F::end_of_blocks(self);
            return;
        };
        level.next += 1;
        let calls = level.calls;
        let file = loaded.program.source().id();
        if let Err(found) = self.ledger.count(file, block.span()) {
            found.into_iter().for_each(|found| self.report(found));
            return;
        }
        if block.skip().is_some_and(|level| self.ledger.skips(level, file, block.span())) {
            return;
        }
        F::begin(self, &block, Origin { file, line: block.line(), span: block.span(), calls });
        let action = F::block(self, &block, index);
        self.report_warnings(file);
        let done = action.and_then(|action| self.behind_block(action, &block));
        if let Err(found) = done {
            self.report(found.in_file(file));
            F::behind_fault(self);
        }
    }

    fn begin_pass(&mut self, pass: F::Pass) {
        if let Err(found) = F::begin_pass(self, pass) {
            let file = self.channel.outlet().file();
            self.report(found.in_file(file));
        }
    }

    /// Postpones the flow action of a block until after the modal call that it triggers.
    fn behind_block(&mut self, action: AfterBlock<F>, block: &BlockOf<F>) -> Result<(), Fault> {
        if !F::modal_call(self, block)? {
            return self.act(action, block);
        }
        let caller = self.levels.len().checked_sub(2).and_then(|index| self.levels.get_mut(index));
        if let (Some(level), false) = (caller, action.is_next()) {
            level.pending = Some(Box::new((action, *block)));
        }
        Ok(())
    }

    /// Executes the flow action of a block.
    pub(in crate::exec) fn act(&mut self, action: AfterBlock<F>, block: &BlockOf<F>) -> Result<(), Fault> {
        match action {
            AfterBlock::Next => {}
            AfterBlock::Jump(target) | AfterBlock::Goto(target) => {
                self.pass_notes(target);
                if let Some(level) = self.levels.last_mut() {
                    level.go_to(target, matches!(action, AfterBlock::Goto(_)));
                }
            }
            AfterBlock::Repeat(section) => {
                F::check_repetition(self, block.span())?;
                let begins = self.levels.last_mut().is_some_and(|level| level.repeat(section, level.next));
                if begins {
                    F::begin_pass(self, section.pass)?;
                }
            }
            AfterBlock::Call(call) => F::call(self, call, block)?,
            AfterBlock::Return(target) => F::return_to(self, target, block.span())?,
            AfterBlock::End(end) => {
                let is_main = self.levels.len() == 1;
                F::end_of_program(self, end);
                if is_main {
                    self.pass_notes_behind_end();
                }
            }
        }
        Ok(())
    }

    /// Passes on the comments after the end of the main program.
    pub(in crate::exec) fn pass_notes_behind_end(&mut self) {
        let Some(level) = self.levels.last() else { return };
        let end = self.programs.get(level.program).map_or(0, |loaded| F::end_of(&self.channel, loaded, level));
        self.pass_notes(end);
    }

    /// Passes on the comments of blocks that the running program leaves out up to a block: they have a line of their own in the text, and people look for
    /// them there.
    fn pass_notes(&mut self, end: usize) {
        let Some(level) = self.levels.last() else { return };
        let (own, calls) = (level.program, level.calls);
        let mut blocks = level.next..end;
        loop {
            let Some(loaded) = self.programs.get_mut(own) else { return };
            let Some((index, block)) = loaded.next_left_out(&mut blocks) else { return };
            let file = loaded.program.source().id();
            F::begin(self, &block, Origin { file, line: block.line(), span: block.span(), calls });
            // A block without words has no action.
            let _ = F::block(self, &block, index);
            if let Some(loaded) = self.programs.get_mut(own) {
                loaded.reopen(index);
            }
        }
    }

    /// The call chain of a program called in a line of the running one.
    pub(in crate::exec) fn chain(&mut self, line: u32) -> u32 {
        let caller = self.levels.last().map_or(0, |level| level.calls);
        self.ledger.chain(caller, line)
    }

    /// Searches a program once, and stores the result.
    pub(in crate::exec) fn find_once<N>(
        &mut self,
        name: &N,
        find: impl FnOnce(&mut Self) -> Option<F::Entry>,
    ) -> Option<F::Entry>
    where
        N: Eq + Hash + ToOwned<Owned = F::Name> + ?Sized,
        F::Name: Borrow<N>,
    {
        if let Some(found) = self.found.get(name) {
            return *found;
        }
        let found = find(self);
        self.found.insert(name.to_owned(), found);
        found
    }

    /// Forgets failed searches, as missing programs may exist now.
    pub(in crate::exec) fn forget_missing(&mut self) {
        self.found.retain(|_, found| found.is_some());
    }

    /// Reads a file into the run and reports its diagnostics. `None` if there are too many files or it is unreadable.
    pub(in crate::exec) fn read(&mut self, shown: &str, bytes: Vec<u8>) -> Option<F::Program> {
        let id = self.ledger.next_file()?;
        let source = Source::new(id, shown, bytes).ok()?;
        let (program, findings) = F::parse(self, &source);
        // Including its macro expansions.
        self.ledger.sources.push(program.source().clone());
        for finding in findings {
            self.report(finding);
        }
        Some(program)
    }

    /// Stores a file. Returns its index.
    pub(in crate::exec) fn keep(&mut self, file: FileOf<F>) -> usize {
        self.programs.push(file);
        self.programs.len() - 1
    }

    /// Reports a diagnostic.
    pub(in crate::exec) fn report(&mut self, finding: Diagnostic) {
        let finding = F::as_seen_by_user(self, finding);
        self.ledger.report(finding);
    }

    /// Reports the warnings of the stages after a block.
    pub(in crate::exec) fn report_warnings(&mut self, file: FileId) {
        for found in std::mem::take(&mut self.channel.outlet().warnings) {
            self.report(found.in_file(file));
        }
    }
}

impl<F: Execute> Executor for Runner<'_, F> {
    fn ledger(&self) -> &RunState {
        &self.ledger
    }

    fn books(&mut self) -> (&mut RunState, &mut VecDeque<Element>) {
        (&mut self.ledger, &mut self.channel.outlet().queue)
    }

    fn step(&mut self) {
        self.execute_block();
    }

    fn finish(&mut self) {
        F::finish(self);
    }
}
