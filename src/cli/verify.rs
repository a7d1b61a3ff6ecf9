//! `ncfix verify`: executes an original and a corrected program and compares the errors of both on the error model.

use std::collections::BTreeMap;

use super::arguments::VerifyArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::pages::{Pages, input};
use super::pair::{Outcome, Pair};
use super::stop::Stop;
use super::{print, program};
use crate::correction::spread;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::units::um_from_mm;
use ncfix_path::path::{Follow, Promise};
use ncfix_report::correction::{error_rows, feed_rows};
use ncfix_report::page::verification::verification;
use ncfix_report::review::Review;
use ncfix_report::verdict::Verdict;
use ncfix_report::verification::{Piece, Verification};
use ncfix_report::{compared, json};

/// Moves that are listed.
const LARGEST: usize = 10;

/// Compares two programs.
pub(super) fn run(arguments: &VerifyArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let pages = Pages::new(&arguments.page, None, arguments.json)?;
    if let Some(target) = pages.as_ref().and_then(Pages::target) {
        program::protect(target, [&arguments.original, &arguments.corrected], &mut findings);
    }
    let mut along = Along::default();
    let mut see = |follow: Follow<'_>| {
        if pages.is_some() {
            along.see(&follow);
        }
    };
    // Both are read before anything else: a file that is missing is the first thing to know.
    let sources = [program::read(&arguments.original)?, program::read(&arguments.corrected)?];
    let is_itself = sources[0].bytes() == sources[1].bytes();
    let pair = Pair::from(arguments);
    let outcome = if findings.has_errors() { None } else { pair.compare(sources, &mut findings, &mut see)? };
    if let Some(outcome) = outcome.as_ref().filter(|_| is_itself) {
        let most_um = um_from_mm(outcome.comparison.after.max_mm);
        let promised_um = um_from_mm(arguments.promised.unwrap_or(Promise::default().tolerance_mm));
        if most_um > promised_um {
            let message = format!(
                "nothing was corrected: the tool is up to {most_um:.2} µm off its place, and a correction leaves {promised_um:.2} µm"
            );
            findings.add(Diagnostic::nowhere(Code::OFF_PROMISE, message, "correct the program with ncfix fix"), &[]);
        }
    }
    if let Some(outcome) = &outcome {
        findings.extend(outcome.differences.iter().cloned(), &outcome.sources[1]);
    }
    if let (Some(pages), Some(outcome)) = (pages, &outcome) {
        pages.publish(&verification(&along.verification(outcome, &findings)))?;
    }
    let before = outcome.as_ref().map(|outcome| spread(&outcome.comparison.before));
    let after = outcome.as_ref().map(|outcome| spread(&outcome.comparison.after));
    let verdict = outcome
        .as_ref()
        .map(|_| Verdict::of(&Review { before, after, diagnostics: findings.json(), ..Review::default() }));
    if arguments.json {
        let samples = outcome.as_ref().map_or(0, |outcome| outcome.comparison.samples);
        let [original_at_feed, corrected_at_feed] =
            outcome.and_then(|outcome| outcome.at_feed).map_or([None, None], |pair| pair.map(Some));
        let verification = json::Verification {
            verdict,
            before,
            after,
            samples,
            original_at_feed,
            corrected_at_feed,
            diagnostics: findings.json(),
        };
        print(&json::line(&verification).map_err(Stop::Usage)?)?;
    } else {
        findings.draw();
        if let (Some(before), Some(after)) = (before, after) {
            let max_at = outcome.as_ref().and_then(|outcome| outcome.max_at.as_ref());
            let at_feed = outcome.as_ref().and_then(|outcome| outcome.at_feed.as_ref());
            let at_feed = at_feed.map_or_else(String::new, |[original, corrected]| feed_rows(original, corrected));
            let verdict = verdict.map_or_else(String::new, |verdict| verdict.rows());
            print(
                &(verdict + &error_rows(before, after, max_at.map(|(line, file)| (*line, file.as_str()))) + &at_feed),
            )?;
        }
    }
    Ok(findings.exit_code())
}

/// The errors along the path.
#[derive(Debug, Default)]
struct Along {
    path_mm: f64,
    /// Pieces that count so far: rapid ones until there is one with feed.
    pieces: Vec<Piece>,
    has_feed: bool,
}

impl Along {
    fn see(&mut self, follow: &Follow<'_>) {
        self.path_mm += follow.length_mm;
        let Some(errors_mm) = follow.errors_mm else { return };
        if !follow.rapid && !self.has_feed {
            self.has_feed = true;
            self.pieces.clear();
        }
        if follow.rapid && self.has_feed {
            return;
        }
        let errors_um = errors_mm.map(|error| um_from_mm(error) as f32);
        let path_m = (self.path_mm / 1e3) as f32;
        self.pieces.push(Piece { file: follow.original.file.0, line: follow.original.line, path_m, errors_um });
    }

    /// With what the whole comparison found.
    fn verification(self, outcome: &Outcome, findings: &Findings) -> Verification {
        let name = |k: usize| outcome.sources[k].first().map_or_else(String::new, |source| source.name().to_owned());
        let program = |k: usize, role: &'static str| outcome.sources[k].first().map(|source| input(source, role));
        let mut inputs: Vec<compared::Input> =
            [program(0, "original program"), program(1, "corrected program")].into_iter().flatten().collect();
        let machine = &outcome.machine;
        inputs.push(compared::Input { file: machine.name.clone(), role: "machine", hash: machine.model.clone() });
        Verification {
            files: [name(0), name(1)],
            machine: machine.name.clone(),
            before: Some(spread(&outcome.comparison.before)),
            after: Some(spread(&outcome.comparison.after)),
            samples: outcome.comparison.samples,
            largest: self.largest(outcome),
            pieces: self.pieces,
            at_feed: outcome.at_feed.clone(),
            inputs,
            diagnostics: findings.json(),
        }
    }

    /// The lines of which most is left.
    fn largest(&self, outcome: &Outcome) -> Vec<(String, [f64; 2])> {
        let mut lines: BTreeMap<(u16, u32), [f32; 2]> = BTreeMap::new();
        for piece in &self.pieces {
            let most = lines.entry((piece.file, piece.line)).or_default();
            *most = [0, 1].map(|k| most[k].max(piece.errors_um[k]));
        }
        let mut all: Vec<_> = lines.into_iter().collect();
        all.sort_by(|(_, a), (_, b)| b[1].total_cmp(&a[1]));
        let files = &outcome.sources[0];
        let place = |(file, line): (u16, u32)| {
            let name = files.iter().find(|source| source.id().0 == file).map_or("", |source| source.name());
            format!("{name}:{line}")
        };
        all.into_iter().take(LARGEST).map(|(at, errors)| (place(at), errors.map(f64::from))).collect()
    }
}
