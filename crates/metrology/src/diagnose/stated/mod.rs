//! Hypotheses that a person states: a small language of terms, their candidates, and the test of each against the readings.
//!
//! ```text
//! token      words, numbers and signs with their places
//! grammar    hypotheses from text, with a diagnostic at its column for every fault
//! form       hypotheses as values
//! build      candidates: the effect of each term on the readings of a scene
//! subject    the candidate that a hypothesis is, and the amounts of its terms
//! model      stated terms as parts of a model that is fitted
//! trial      amount, evidence, gain on unseen readings, rivals, possible correction
//! ```
//!
//! `docs/reference/terms.md` has the grammar.

mod build;
mod form;
mod grammar;
mod model;
mod subject;
#[cfg(test)]
mod tests;
mod token;
mod trial;

pub use form::{StatedHypothesis, TermAmount};
pub use grammar::read;
pub use model::{ModelTerm, stated_model};
pub use trial::{EqualExplanation, HypothesisTrial, StatedSet, StatedTrials, diagnose_stated};
