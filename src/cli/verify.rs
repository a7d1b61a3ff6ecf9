//! `ncfix verify`: executes an original and a corrected program and compares the errors of both on the error model.

use std::cell::RefCell;
use std::path::Path;

use super::arguments::{MachineChoice, ProgramChoice, StateChoice, VerifyArguments};
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::program::{self, Running};
use super::state;
use super::stop::Stop;
use super::{fix, print};
use crate::diagnostic::{Code, Diagnostic};
use crate::emit;
use crate::exec::RapidOrder;
use crate::path::{self, Follow, Grouping};
use crate::report::correction::error_rows;
use crate::report::json;
use crate::snc::Element;
use crate::source::{FileId, Source};

/// Compares two programs.
pub(super) fn run(arguments: &VerifyArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let outcome = Pair::from(arguments).compare(&mut findings, &mut |_| {})?;
    let before = outcome.as_ref().map(|outcome| fix::spread(&outcome.comparison.before));
    let after = outcome.as_ref().map(|outcome| fix::spread(&outcome.comparison.after));
    if arguments.json {
        let samples = outcome.map_or(0, |outcome| outcome.comparison.samples);
        let verification = json::Verification { before, after, samples, diagnostics: findings.json() };
        print(&json::line(&verification).map_err(Stop::Usage)?)?;
    } else {
        findings.draw();
        if let (Some(before), Some(after)) = (before, after) {
            let max_at = outcome.as_ref().and_then(|outcome| outcome.max_at.as_ref());
            print(&error_rows(before, after, max_at.map(|(line, file)| (*line, file.as_str()))))?;
        }
    }
    Ok(findings.exit_code())
}

/// Two programs and how they are executed.
pub(super) struct Pair<'a> {
    pub(super) original: &'a Path,
    pub(super) corrected: &'a Path,
    pub(super) machine: &'a MachineChoice,
    pub(super) state: &'a StateChoice,
    pub(super) program: &'a ProgramChoice,
}

impl<'a> From<&'a VerifyArguments> for Pair<'a> {
    fn from(arguments: &'a VerifyArguments) -> Pair<'a> {
        Pair {
            original: &arguments.original,
            corrected: &arguments.corrected,
            machine: &arguments.machine,
            state: &arguments.state,
            program: &arguments.program,
        }
    }
}

impl Pair<'_> {
    /// Opens both programs and walks them side by side; `None` where findings forbid it.
    pub(super) fn compare(
        &self,
        findings: &mut Findings,
        see: &mut dyn FnMut(Follow),
    ) -> Result<Option<Outcome>, Stop> {
        // Both are read before anything else: a file that is missing is the first thing to know.
        let sources = [program::read(self.original)?, program::read(self.corrected)?];
        let Some(mut chosen) = machine_choice::choose(self.machine, self.original, findings)? else {
            return Ok(None);
        };
        if !state::apply(self.state, &mut chosen, findings)? {
            return Ok(None);
        }
        let mut opened = Vec::new();
        for source in &sources {
            opened.extend(program::open(source, self.program, Some(&chosen), findings)?);
        }
        let Ok(opened) = <[program::Opened; 2]>::try_from(opened) else { return Ok(None) };
        Ok(self.walked(opened, &sources, &chosen, findings, see))
    }

    fn walked(
        &self,
        [original, corrected]: [program::Opened; 2],
        sources: &[Source; 2],
        chosen: &Chosen,
        findings: &mut Findings,
        see: &mut dyn FnMut(Follow),
    ) -> Option<Outcome> {
        let start = |opened: program::Opened, path: &Path| {
            let is_stamped = emit::is_stamped(opened.source.bytes());
            let rapid_order = if is_stamped { RapidOrder::None } else { RapidOrder::Stated };
            Running::start(opened, path, self.program, &chosen.machine, false, rapid_order)
        };
        let original = start(original, self.original);
        let corrected = start(corrected, self.corrected);
        if let Some(model) = emit::stamped_model(sources[1].bytes())
            && model != chosen.hash
        {
            let message = format!(
                "{} was corrected for the model {model}, and is compared on {}",
                sources[1].name(),
                chosen.hash
            );
            let help = "give --machine the machine file that it was corrected with";
            findings.add(Diagnostic::nowhere(Code::OTHER_STAMP, message, help), sources);
        }
        let stamped_state = emit::stamped_state(sources[1].bytes());
        if emit::is_stamped(sources[1].bytes()) && stamped_state != chosen.state {
            let said = |state: &Option<String>| state.clone().unwrap_or_else(|| "none".into());
            let message = format!(
                "{} was corrected for the state {}, and is compared in {}",
                sources[1].name(),
                said(&stamped_state),
                said(&chosen.state)
            );
            let help = "give the same --state, --time, --zero-time, --zero-at and --load as for the correction";
            findings.add(Diagnostic::nowhere(Code::OTHER_STAMP, message, help), sources);
        }
        let is_marked = emit::is_stamped(sources[1].bytes()) && !emit::is_stamped(sources[0].bytes());
        let grouping = if is_marked { Grouping::ByMarks } else { Grouping::ByPlace };
        walk(original, corrected, grouping, chosen, findings, see)
    }
}

/// Compares two running programs.
fn walk(
    original: Running,
    corrected: Running,
    grouping: Grouping,
    chosen: &Chosen,
    findings: &mut Findings,
    see: &mut dyn FnMut(Follow),
) -> Option<Outcome> {
    let model = chosen.model();
    let increments = [chosen.machine.control.increment_mm, chosen.machine.control.increment_rad];
    let shared = RefCell::new(std::mem::take(findings));
    let mut original = Clean { running: original, findings: &shared, mark: 0 };
    let mut corrected = Clean { running: corrected, findings: &shared, mark: OF_CORRECTED };
    let result = path::compare_seeing(&mut original, &mut corrected, grouping, &chosen.machine, &model, see);
    let max_at = result.as_ref().ok().and_then(|comparison| comparison.max_at);
    let max_at = max_at.and_then(|origin| Some((origin.line, original.source(origin.file)?.name().to_owned())));
    let unaligned = result.as_ref().err().and_then(|diagnostic| diagnostic.place).map(|place| place.file);
    let source = unaligned.and_then(|file| original.source(file).or_else(|| corrected.source(file)));
    let sources = original.running.sources().to_vec();
    drop((original, corrected));
    *findings = shared.into_inner();
    match result {
        Ok(comparison) => Some(Outcome { comparison, max_at, sources, increments }).filter(|_| !findings.has_errors()),
        // Where a program could not be executed to its end, that it does not match the other one is no news.
        Err(_) if findings.has_errors() => None,
        Err(mut diagnostic) => {
            if let (Some(place), Some(source)) = (&mut diagnostic.place, &source) {
                place.file = source.id();
            }
            findings.add(diagnostic, source.as_slice());
            None
        }
    }
}

/// What a comparison found.
pub(super) struct Outcome {
    pub(super) comparison: path::Comparison,
    /// Line and file of the largest error that is left.
    max_at: Option<(u32, String)>,
    /// The files of the original.
    pub(super) sources: Vec<Source>,
    /// Of the control, mm and rad.
    pub(super) increments: [f64; 2],
}

/// Added to the file numbers of the corrected program: both programs count their files from 0, and a finding must be drawn in the
/// right one.
const OF_CORRECTED: u16 = 1 << 15;

/// The elements of a program without its findings, which are put aside.
struct Clean<'r, 'f> {
    running: Running<'r>,
    findings: &'f RefCell<Findings>,
    mark: u16,
}

impl Clean<'_, '_> {
    /// The file of a marked number, if it is one of this program.
    fn source(&self, marked: FileId) -> Option<Source> {
        let is_mine = |source: &&Source| source.id().0 ^ self.mark == marked.0;
        self.running.sources().iter().find(is_mine).cloned()
    }
}

impl Iterator for Clean<'_, '_> {
    type Item = Element;

    fn next(&mut self) -> Option<Element> {
        loop {
            match self.running.next()? {
                Ok(mut element) => {
                    element.origin.file.0 ^= self.mark;
                    return Some(element);
                }
                Err(diagnostic) => self.findings.borrow_mut().add(diagnostic, self.running.sources()),
            }
        }
    }
}
