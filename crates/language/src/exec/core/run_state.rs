//! State of every run in any language: files, diagnostics, progress, and call chains.

use std::collections::{HashMap, HashSet, VecDeque};

use super::options::Options;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Source, Span};
use ncfix_machine::snc::Origin;

/// Default of [`Options::max_blocks`]: at 50 ms a block this is more than a day at the machine. An endless loop reaches it in half a minute to
/// several minutes.
const MAX_BLOCKS: u64 = 2_000_000;
/// Number of blocks executed after the first error, to find further errors.
const BLOCKS_AFTER_ERROR: u64 = 1_000_000;
/// Number of different errors after which the run ends.
const MAX_ERRORS: usize = 100;

/// Progress of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::exec) enum Stage {
    /// Blocks are being executed.
    Runs,
    /// No more blocks are executed.
    Over,
    /// Held elements have been emitted.
    Finished,
}

/// State of a run: files, diagnostics, call chains and progress.
pub(in crate::exec) struct RunState {
    /// All files of the run so far, by [`FileId`].
    pub(in crate::exec) sources: Vec<Source>,
    /// Diagnostics that are not handed out yet.
    pub(in crate::exec) findings: VecDeque<Diagnostic>,
    /// Progress of the run.
    pub(in crate::exec) stage: Stage,
    skip_levels: [bool; 10],
    reported: HashSet<(Code, Option<Place>)>,
    /// Variables, by file, without a value that were reported, or that have no value as a consequence.
    without_value: HashSet<(FileId, String)>,
    errors: usize,
    /// A block with an F word was not executed because of an error.
    has_lost_feed: bool,
    /// A block with a position was not executed because of an error.
    has_lost_place: bool,
    executed: u64,
    limit: u64,
    /// Call chains: the chain of the caller and its line.
    chains: Vec<(u32, u32)>,
    chain_ids: HashMap<(u32, u32), u32>,
}

impl RunState {
    /// `true` if an error was reported.
    pub(in crate::exec) fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// The run state of a main program with `blocks` blocks.
    pub(in crate::exec) fn new(main: Source, blocks: usize, options: &Options) -> RunState {
        RunState {
            sources: vec![main],
            findings: VecDeque::new(),
            stage: Stage::Runs,
            skip_levels: options.skip_levels,
            reported: HashSet::new(),
            without_value: HashSet::new(),
            errors: 0,
            has_lost_feed: false,
            has_lost_place: false,
            executed: 0,
            limit: options.max_blocks.unwrap_or_else(|| MAX_BLOCKS.max(blocks as u64 * 20)),
            chains: Vec::new(),
            chain_ids: HashMap::new(),
        }
    }

    /// Ends the execution of blocks.
    pub(in crate::exec) fn end(&mut self) {
        // Elements emitted after the end may cause further diagnostics, but do not restart the run.
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
    /// `None` or a diagnostic if the limit is exceeded; the run is then over. After errors there is no diagnostic.
    pub(in crate::exec) fn count(&mut self, file: FileId, span: Span) -> Result<(), Option<Diagnostic>> {
        if self.executed < self.limit {
            self.executed += 1;
            return Ok(());
        }
        self.end();
        if self.errors > 0 {
            return Err(None);
        }
        let message = format!("{} blocks were executed, and the program continues here", self.executed);
        let help = "raise --max-blocks if the program does end";
        Err(Some(Diagnostic::at(Code::TOO_MANY_BLOCKS, Place { file, span }, message, help)))
    }

    /// `true` if blocks with this skip level are skipped.
    pub(in crate::exec) fn leaves_out(&self, level: u8) -> bool {
        self.skip_levels.get(usize::from(level)).copied().unwrap_or(false)
    }

    /// `true` if a block with this skip level is skipped; reports that this is decided here.
    pub(in crate::exec) fn skips(&mut self, level: u8, file: FileId, span: Span) -> bool {
        let is_skipped = self.leaves_out(level);
        // One diagnostic per run suffices for all skipped blocks.
        if !self.reported.iter().any(|(code, _)| *code == Code::SKIP_EXECUTED) {
            let done = if is_skipped { "always skipped" } else { "always executed" };
            let message =
                format!("the output has no / blocks: this block is {done}, and the skip switch has no effect");
            let help = "choose with --skip which levels are skipped";
            self.report(Diagnostic::at(Code::SKIP_EXECUTED, Place { file, span }, message, help));
        }
        is_skipped
    }

    /// Reports a diagnostic, unless it is known. After the first error the run ends soon, after many errors immediately.
    pub(in crate::exec) fn report(&mut self, mut finding: Diagnostic) {
        // A place in the text of a macro is shown at the use of the macro.
        if let Some(place) = &mut finding.place
            && let Some(source) = self.sources.get(usize::from(place.file.0))
        {
            place.span = source.in_file(place.span);
        }
        // The F and the motion of a block with an error were not executed: an arc after it would begin elsewhere.
        let is_of_arc = [Code::ARC_OFF_CIRCLE, Code::RADIUS_TOO_SMALL].contains(&finding.code);
        let is_consequence =
            finding.code == Code::MISSING_FEED && self.has_lost_feed || is_of_arc && self.has_lost_place;
        if is_consequence
            || self.is_known_variable(&mut finding)
            || !self.reported.insert((finding.code, finding.place))
        {
            return;
        }
        if finding.is_error() {
            self.has_lost_feed |= finding.place.is_some_and(|place| self.has_feed_word(place));
            self.has_lost_place |= !is_of_arc && finding.place.is_some_and(|place| self.has_position_word(place));
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

    /// `true` if the line of a place may have an F word.
    fn has_feed_word(&self, place: Place) -> bool {
        let source = self.sources.get(usize::from(place.file.0));
        source.is_some_and(|source| {
            source.line_at(place.span.start).0.iter().any(|byte| byte.eq_ignore_ascii_case(&b'F'))
        })
    }

    /// `true` if the line of a place may have a word of X, Y or Z.
    fn has_position_word(&self, place: Place) -> bool {
        let source = self.sources.get(usize::from(place.file.0));
        let is_word = |pair: &[u8]| match pair {
            [letter, value] => b"XYZxyz".contains(letter) && (value.is_ascii_digit() || b"+-.#=[".contains(value)),
            _ => false,
        };
        source.is_some_and(|source| source.line_at(place.span.start).0.windows(2).any(is_word))
    }

    /// `true` if a diagnostic is about a variable without a value that was already reported in the file. Other variables without value as a
    /// consequence are recorded.
    fn is_known_variable(&mut self, finding: &mut Diagnostic) -> bool {
        let (Some(unset), Some(place)) = (finding.unset.take(), finding.place) else { return false };
        let is_known = unset.read.is_some_and(|name| !self.without_value.insert((place.file, name)));
        self.without_value.extend(unset.left.into_iter().map(|name| (place.file, name)));
        is_known
    }

    /// The id of the next file; `None` if there are too many.
    pub(in crate::exec) fn next_file(&self) -> Option<FileId> {
        u16::try_from(self.sources.len()).ok().map(FileId)
    }

    /// The call chain of a program called in a line of another; 0 is the chain of the main program.
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
