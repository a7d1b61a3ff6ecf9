//! What every run keeps whatever its language: the files, the findings, how far it is, who called whom.

use std::collections::{HashMap, HashSet, VecDeque};

use super::options::Options;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Source, Span};
use ncfix_machine::snc::Origin;

/// Default of [`Options::max_blocks`].
const MAX_BLOCKS: u64 = 10_000_000;
/// After the first error so many blocks more are executed in search of others.
const BLOCKS_AFTER_ERROR: u64 = 1_000_000;
/// After so many different errors the run ends.
const MAX_ERRORS: usize = 100;

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::exec) enum Stage {
    /// Blocks are executed.
    Runs,
    /// No more blocks are executed.
    Over,
    /// What was held back has come out.
    Finished,
}

/// The books of a run.
pub(in crate::exec) struct Ledger {
    /// All files of the run so far, by [`FileId`].
    pub(in crate::exec) sources: Vec<Source>,
    /// What is still to be handed out.
    pub(in crate::exec) findings: VecDeque<Diagnostic>,
    /// How far it is.
    pub(in crate::exec) stage: Stage,
    skip_levels: [bool; 10],
    reported: HashSet<(Code, Option<Place>)>,
    /// Variables without a value that a finding was about, or that have none because of it, by the file.
    without_value: HashSet<(FileId, String)>,
    errors: usize,
    executed: u64,
    limit: u64,
    /// Call chains: the chain of the caller and its line.
    chains: Vec<(u32, u32)>,
    chain_ids: HashMap<(u32, u32), u32>,
}

impl Ledger {
    /// Whether an error was found.
    pub(in crate::exec) fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// Of a main program of so many blocks.
    pub(in crate::exec) fn new(main: Source, blocks: usize, options: &Options) -> Ledger {
        Ledger {
            sources: vec![main],
            findings: VecDeque::new(),
            stage: Stage::Runs,
            skip_levels: options.skip_levels,
            reported: HashSet::new(),
            without_value: HashSet::new(),
            errors: 0,
            executed: 0,
            limit: options.max_blocks.unwrap_or_else(|| MAX_BLOCKS.max(blocks as u64 * 20)),
            chains: Vec::new(),
            chain_ids: HashMap::new(),
        }
    }

    /// No more blocks are executed.
    pub(in crate::exec) fn end(&mut self) {
        // What comes out behind the end may find more, and does not end the run anew.
        if self.stage == Stage::Runs {
            self.stage = Stage::Over;
        }
    }

    /// Blocks executed so far.
    pub(in crate::exec) fn executed(&self) -> u64 {
        self.executed
    }

    /// Counts a block that is about to be executed.
    ///
    /// # Errors
    /// Where there were too many; the run is over then. Behind errors that is no finding.
    pub(in crate::exec) fn count(&mut self, file: FileId, span: Span) -> Result<(), Option<Diagnostic>> {
        if self.executed < self.limit {
            self.executed += 1;
            return Ok(());
        }
        self.end();
        if self.errors > 0 {
            return Err(None);
        }
        let message = format!("{} blocks were executed and the program goes on here", self.executed);
        let help = "raise --max-blocks if the program does end";
        Err(Some(Diagnostic::at(Code::TOO_MANY_BLOCKS, Place { file, span }, message, help)))
    }

    /// Whether blocks with this skip level are left out.
    pub(in crate::exec) fn leaves_out(&self, level: u8) -> bool {
        self.skip_levels.get(usize::from(level)).copied().unwrap_or(false)
    }

    /// Whether a block with this skip level is left out; that this is decided now is a finding.
    pub(in crate::exec) fn skips(&mut self, level: u8, file: FileId, span: Span) -> bool {
        let is_skipped = self.leaves_out(level);
        // One finding a run: every further block would say the same.
        if !self.reported.iter().any(|(code, _)| *code == Code::SKIP_EXECUTED) {
            let done = if is_skipped { "skipped" } else { "executed" };
            let message = format!("blocks with / are decided now; this one is {done}");
            let help = "choose with --skip which levels are left out";
            self.report(Diagnostic::at(Code::SKIP_EXECUTED, Place { file, span }, message, help));
        }
        is_skipped
    }

    /// Takes a finding, unless it is known. After the first error the run ends soon, after many at once.
    pub(in crate::exec) fn report(&mut self, mut finding: Diagnostic) {
        // A place in the text of a macro is shown where the macro is used.
        if let Some(place) = &mut finding.place
            && let Some(source) = self.sources.get(usize::from(place.file.0))
        {
            place.span = source.in_file(place.span);
        }
        if self.is_known_variable(&mut finding) || !self.reported.insert((finding.code, finding.place)) {
            return;
        }
        if finding.is_error() {
            self.errors += 1;
            if self.errors == 1 {
                self.limit = self.limit.min(self.executed + BLOCKS_AFTER_ERROR);
            }
            if self.errors >= MAX_ERRORS {
                self.end();
            }
        }
        self.findings.push_back(finding);
    }

    /// Whether a finding is about a variable without a value, and an earlier one in the file was too: that one says it all. Other
    /// variables that have no value because of it are known from here on.
    fn is_known_variable(&mut self, finding: &mut Diagnostic) -> bool {
        let (Some(unset), Some(place)) = (finding.unset.take(), finding.place) else { return false };
        let is_known = unset.read.is_some_and(|name| !self.without_value.insert((place.file, name)));
        self.without_value.extend(unset.left.into_iter().map(|name| (place.file, name)));
        is_known
    }

    /// The number of the next file; `None` where there are too many.
    pub(in crate::exec) fn next_file(&self) -> Option<FileId> {
        u16::try_from(self.sources.len()).ok().map(FileId)
    }

    /// The call chain of a program that is called in a line of another; 0 is the chain of the main program.
    pub(in crate::exec) fn chain(&mut self, caller: u32, line: u32) -> u32 {
        let next_id = u32::try_from(self.chains.len() + 1).unwrap_or(u32::MAX);
        let id = *self.chain_ids.entry((caller, line)).or_insert(next_id);
        if id == next_id {
            self.chains.push((caller, line));
        }
        id
    }

    /// Lines of the calls that led to an element, innermost first; empty in the main program.
    pub(in crate::exec) fn call_lines(&self, origin: &Origin) -> Vec<u32> {
        let mut lines = Vec::new();
        let mut chain = origin.calls;
        while let Some(&(caller, line)) = (chain as usize).checked_sub(1).and_then(|index| self.chains.get(index)) {
            lines.push(line);
            chain = caller;
        }
        lines
    }
}
