//! Explanations of the residual of a model: one likelihood, sets of terms with probabilities.
//!
//! ```text
//! Scene::new(machine, errors, sets)   the residual of every reading, and its sensitivity to a deviation anywhere
//! term::terms                         the additional effect of each error on the readings, in one form
//! NoiseSeries::new                    readings in series; autocorrelated noise, filtered
//! Likelihood::new                     set-ups eliminated; everything about a set of terms from products of columns
//! search::explanations                sets of terms with probabilities
//! contest::contest                    the search over a growing pool of terms, with the autocorrelation of the noise
//! ```
//!
//! A diagnosis compares the result of its search with all sets of these terms and of the candidates of the registry.

pub mod assumptions;
pub mod contest;
pub mod likelihood;
pub mod noise;
pub mod search;
mod setups;
pub mod term;
mod tridiagonal;
