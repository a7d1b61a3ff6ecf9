//! Hypotheses stated by a user: a small language of terms, their candidates, and the test of each hypothesis against the readings.
//!
//! ```text
//! token      words, numbers and signs with their positions
//! grammar    parser of hypotheses, with a diagnostic at its column for every syntax error
//! form       hypotheses as values
//! build      candidates: the effect of each term on the readings of a scene
//! subject    the candidate of a hypothesis, and the amounts of its terms
//! overlap    accepted causes that share its effect on the readings
//! variant    names of the variants of a cause
//! contested  accepted causes that a hypothesis contests
//! model      stated terms as parts of a fitted model
//! trial      amount, evidence, gain on left-out readings, other explanations, possible correction
//! ```
//!
//! `docs/reference/terms.md` describes the grammar.

mod build;
mod contested;
mod form;
mod grammar;
mod model;
mod overlap;
mod subject;
#[cfg(test)]
mod tests;
mod token;
mod trial;
mod variant;

pub use form::{StatedHypothesis, TermAmount};
pub use grammar::{read, read_options};
pub use model::{ModelTerm, StatedModel, TermRefusal, stated_model};
pub use trial::{EqualExplanation, HypothesisTrial, STRONG, StatedSet, StatedTrials, diagnose_stated};
