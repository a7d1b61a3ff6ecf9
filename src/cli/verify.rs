//! `ncfix verify`: executes an original and a corrected program and compares the errors of both on the error model.

use super::arguments::VerifyArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::pair::Pair;
use super::stop::Stop;
use super::{fix, print};
use crate::report::correction::error_rows;
use crate::report::json;

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
