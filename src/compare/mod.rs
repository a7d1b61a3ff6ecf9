//! Comparison of two programs, executed in parallel on the machine, or as texts.

mod along;
mod at_feed;
mod differences;
mod header;
mod listing;
mod review;
mod stamp;
mod text;
mod walk;

use crate::correction::spread;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::program::Program;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::units::um_from_mm;
use ncfix_path::path::{Follow, Promise};
use ncfix_path::review::ReviewTrace;
use ncfix_report::json::VerificationReport;
use ncfix_report::review::{Limit, Review};
use ncfix_report::verdict::Verdict;

pub(crate) use along::ErrorsAlong;
pub(crate) use at_feed::{block_of, place_of};
pub(crate) use listing::Listing;
pub(crate) use review::ComparedPrograms;
pub(crate) use text::TextComparison;
pub(crate) use walk::{Outcome, Pair};

/// Estimated minimum length of a line of a corrected program, bytes.
const LEAST_LINE: usize = 16;

/// Lever arm that converts angles into lengths for the comparison, mm.
const ARM_MM: f64 = 1000.0;

/// The default number of rows of a comparison.
pub(crate) const ROWS: usize = 20;

/// Options of a comparison.
#[derive(Clone, Debug, Default)]
pub(crate) struct CompareOptions {
    /// Compared axes; all if empty.
    pub(crate) axes: Vec<Axis>,
    /// Changes up to this are ignored, mm; for a rotary axis, the arc at a radius of 1 m counts.
    pub(crate) tolerance_mm: f64,
    /// Only moves with at least this change, mm.
    pub(crate) least_mm: Option<f64>,
    /// Largest permitted change, mm.
    pub(crate) limit_mm: Option<f64>,
    /// Maximum number of rows, in descending order of the change.
    pub(crate) rows: Option<usize>,
}

impl CompareOptions {
    /// The compared axes.
    fn all_axes(&self) -> Vec<Axis> {
        AXES.into_iter().filter(|axis| self.axes.is_empty() || self.axes.contains(axis)).collect()
    }

    /// The tolerances, mm and rad.
    fn tolerance(&self) -> [f64; 2] {
        [self.tolerance_mm, self.tolerance_mm / ARM_MM]
    }
}

impl Program {
    /// Executes this program and its corrected version side by side, and compares both on the error model: the distance of the tool from the path of this
    /// program, and every difference that is not a correction.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let text = program.correct(&machine, &Options::default()).text()?;
    /// let corrected = Program::parse("corrected.mpf", text, DialectChoice::Sinumerik)?;
    /// let found = program.verify(&corrected, &machine)?;
    /// assert!(found.after.unwrap().max_um < 1.0 && found.before.unwrap().max_um > 10.0);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If one of the programs is not understood, or the two cannot be compared.
    pub fn verify(&self, corrected: &Program, machine: &Machine) -> Result<VerificationReport, Error> {
        let mut found = Diagnostics::default();
        let pair = Pair::of([self, corrected], machine);
        match pair.verify(&mut found, &mut |_| ())? {
            Some(outcome) => Ok(verification(Some(&outcome), &found)),
            None => Err(Error::found(found)),
        }
    }

    /// The changes between this program and its corrected one, move by move: the twenty largest changes, figures of each axis, and whether the
    /// corrected program should run.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let text = program.correct(&machine, &Options::default()).text()?;
    /// let corrected = Program::parse("corrected.mpf", text, DialectChoice::Sinumerik)?;
    /// let review = program.compare(&corrected, &machine)?;
    /// assert!(!review.same);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If one of the programs is not understood, or the two cannot be compared.
    pub fn compare(&self, corrected: &Program, machine: &Machine) -> Result<Review, Error> {
        let mut found = Diagnostics::default();
        let pair = Pair::of([self, corrected], machine);
        let Some((trace, outcome)) = pair.trace(false, &mut found)? else { return Err(Error::found(found)) };
        let Some(text) = outcome.sources[1].first() else { return Err(Error::found(found)) };
        let (wanted, names) = (CompareOptions::default(), [self.name().to_owned(), corrected.name().to_owned()]);
        found.extend(outcome.differences.iter().cloned(), &outcome.sources[1]);
        let mut review = ComparedPrograms { wanted: &wanted, names, trace: &trace, outcome: &outcome, corrected: text }
            .review(&found);
        let listing = Listing::new(&wanted, (&trace.rows, &outcome), text);
        (review.rows, review.more_rows) = listing.some(ROWS);
        Ok(review)
    }
}

impl Pair<'_> {
    /// Compares both, and reports differences that are not a correction; `None` if there are errors that prevent the comparison.
    ///
    /// # Errors
    /// If their dialect does not exist.
    pub(crate) fn verify(
        &self,
        found: &mut Diagnostics,
        see: &mut dyn FnMut(Follow<'_>),
    ) -> Result<Option<Outcome>, Error> {
        let is_itself = self.programs[0].bytes() == self.programs[1].bytes();
        let Some(outcome) = self.compare(found, see)? else { return Ok(None) };
        if is_itself {
            let most_um = um_from_mm(outcome.comparison.after.max_mm);
            let promised_um = um_from_mm(self.promised.unwrap_or(Promise::default().tolerance_mm));
            if most_um > promised_um {
                let message = format!(
                    "nothing was corrected: the tool tip is up to {most_um:.2} µm off its position; a correction would leave at most {promised_um:.2} µm"
                );
                found.add(Diagnostic::nowhere(Code::OFF_PROMISE, message, "correct the program with ncfix fix"), &[]);
            }
        }
        found.extend(outcome.refused.iter().cloned(), &[]);
        found.extend(outcome.differences.iter().cloned(), &outcome.sources[1]);
        Ok(Some(outcome))
    }

    /// Compares both move by move; `None` if there are errors.
    ///
    /// # Errors
    /// If their dialect does not exist.
    pub(crate) fn trace(
        &self,
        has_places: bool,
        found: &mut Diagnostics,
    ) -> Result<Option<(ReviewTrace, Outcome)>, Error> {
        let mut trace = ReviewTrace::new(self.programs[1].bytes().len() / LEAST_LINE, has_places);
        let outcome = self.compare(found, &mut |follow| trace.see(&follow, has_places))?;
        Ok(outcome.filter(|_| !found.has_errors()).map(|outcome| (trace, outcome)))
    }
}

/// The changes between a program and the corrected program that was just made.
pub(crate) struct Reviewed {
    pub(crate) review: Review,
    pub(crate) trace: ReviewTrace,
    pub(crate) outcome: Outcome,
}

impl Pair<'_> {
    /// The changes of a correction against the permitted size, with the largest rows; `None` if there are errors. `names` are the names of both
    /// files.
    ///
    /// # Errors
    /// If their dialect does not exist.
    pub(crate) fn review(
        &self,
        names: [String; 2],
        allowed_um: f64,
        found: &mut Diagnostics,
    ) -> Result<Option<Reviewed>, Error> {
        let Some((trace, outcome)) = self.trace(true, found)? else { return Ok(None) };
        let Some(corrected) = outcome.sources[1].first() else { return Ok(None) };
        found.extend(outcome.differences.iter().cloned(), &outcome.sources[1]);
        let wanted = CompareOptions::default();
        let mut review =
            ComparedPrograms { wanted: &wanted, names, trace: &trace, outcome: &outcome, corrected }.review(found);
        let axes: Vec<Axis> = AXES.into_iter().filter(|axis| !axis.is_rotary()).collect();
        let value_um = trace.rows.iter().map(|row| row.largest(&axes)).fold(0.0, f64::max);
        let name = "the largest correction of a linear axis".to_owned();
        review.limits.push(Limit { name, value_um, limit_um: allowed_um, is_kept: value_um <= allowed_um });
        review.verdict = Verdict::of(&review);
        let listing = Listing::new(&wanted, (&trace.rows, &outcome), corrected);
        (review.rows, review.more_rows) = listing.some(ROWS);
        Ok(Some(Reviewed { review, trace, outcome }))
    }
}

/// The result of a comparison.
pub(crate) fn verification(outcome: Option<&Outcome>, found: &Diagnostics) -> VerificationReport {
    let before = outcome.map(|outcome| spread(&outcome.comparison.before));
    let after = outcome.map(|outcome| spread(&outcome.comparison.after));
    let coverage = outcome.map(|outcome| outcome.coverage.clone());
    let before_form = outcome.map(|outcome| spread(&outcome.comparison.form));
    let zeros = outcome.map_or_else(Vec::new, |outcome| outcome.zeros.clone());
    let diagnostics = found.json();
    let prediction = outcome.and_then(|outcome| outcome.prediction.clone());
    let review = Review {
        before,
        before_form,
        zeros,
        after,
        diagnostics,
        coverage: coverage.clone(),
        prediction: prediction.clone(),
        rounding_um: outcome.map_or(0.0, |outcome| um_from_mm(outcome.rounding_mm)),
        ..Review::default()
    };
    let verdict = outcome.map(|_| Verdict::of(&review));
    let [original_at_feed, corrected_at_feed] =
        outcome.and_then(|outcome| outcome.at_feed.clone()).map_or([None, None], |pair| pair.map(Some));
    VerificationReport {
        verdict,
        coverage,
        prediction,
        before,
        before_form,
        zeros: review.zeros,
        after,
        samples: outcome.map_or(0, |outcome| outcome.comparison.samples),
        original_at_feed,
        corrected_at_feed,
        diagnostics: found.json(),
    }
}
