//! `ncfix verify`: executes an original and a corrected program and compares the errors of both on the error model.

use std::cell::RefCell;
use std::path::Path;

use super::arguments::VerifyArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::program::{self, Running};
use super::stop::Stop;
use super::{fix, print};
use crate::model::Model;
use crate::path;
use crate::report::correction::error_rows;
use crate::report::json;
use crate::snc::Element;

/// Compares two programs.
pub(super) fn run(arguments: &VerifyArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let comparison = compare(arguments, &mut findings)?;
    let (before, after) = match &comparison {
        Some(comparison) => (Some(fix::spread(&comparison.before)), Some(fix::spread(&comparison.after))),
        None => (None, None),
    };
    if arguments.json {
        let samples = comparison.map_or(0, |comparison| comparison.samples);
        let verification = json::Verification { before, after, samples, diagnostics: findings.json() };
        print(&json::line(&verification).map_err(Stop::Usage)?)?;
    } else {
        findings.draw();
        if let (Some(before), Some(after)) = (before, after) {
            print(&error_rows(before, after, None))?;
        }
    }
    Ok(findings.exit_code())
}

/// Opens both programs and walks them side by side; `None` where findings forbid it.
fn compare(arguments: &VerifyArguments, findings: &mut Findings) -> Result<Option<path::Comparison>, Stop> {
    // Both are read before anything else: a file that is missing is the first thing to know.
    let sources = [program::read(&arguments.original)?, program::read(&arguments.corrected)?];
    let Some(chosen) = machine_choice::choose(&arguments.machine, &arguments.original, findings)? else {
        return Ok(None);
    };
    let mut opened = Vec::new();
    for source in &sources {
        opened.extend(program::open(source, &arguments.program, Some(&chosen), findings)?);
    }
    let Ok([original, corrected]) = <[program::Opened; 2]>::try_from(opened) else { return Ok(None) };
    let start = |opened, path: &Path| Running::start(opened, path, &arguments.program, &chosen.machine, false);
    let original = start(original, &arguments.original);
    let corrected = start(corrected, &arguments.corrected);
    Ok(walk(original, corrected, &chosen, findings))
}

/// Compares two running programs.
fn walk(original: Running, corrected: Running, chosen: &Chosen, findings: &mut Findings) -> Option<path::Comparison> {
    let model = Model::new(&chosen.machine, &chosen.errors);
    let shared = RefCell::new(std::mem::take(findings));
    let mut original = Clean { running: original, findings: &shared };
    let mut corrected = Clean { running: corrected, findings: &shared };
    let result = path::compare(&mut original, &mut corrected, &chosen.machine, &model);
    let sources = original.running.sources().to_vec();
    drop((original, corrected));
    *findings = shared.into_inner();
    match result {
        Ok(comparison) => Some(comparison).filter(|_| !findings.has_errors()),
        // Where a program could not be executed to its end, that it does not match the other one is no news.
        Err(_) if findings.has_errors() => None,
        Err(diagnostic) => {
            findings.add(diagnostic, &sources);
            None
        }
    }
}

/// The elements of a program without its findings, which are put aside.
struct Clean<'r, 'f> {
    running: Running<'r>,
    findings: &'f RefCell<Findings>,
}

impl Iterator for Clean<'_, '_> {
    type Item = Element;

    fn next(&mut self) -> Option<Element> {
        loop {
            match self.running.next()? {
                Ok(element) => return Some(element),
                Err(diagnostic) => self.findings.borrow_mut().add(diagnostic, self.running.sources()),
            }
        }
    }
}
