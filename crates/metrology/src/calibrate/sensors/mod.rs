//! Selection of temperature sensors that predict a thermal drift (Spaan 1995, ch. 5).
//!
//! Drift of the tool relative to the workpiece is a weighted sum of temperature rises, in every direction and at every position of the axis along
//! which it changes. [`data`] reads records. [`select()`] finds the best sensors of each number ([`subset`]: exact), determines their efficiency on
//! the data and on an independent run, and selects the number that predicts the independent run. [`text`] writes the result as `[[drift]]` of a
//! machine file.
//!
//! | figure | formula | note |
//! | --- | --- | --- |
//! | Cp | `SSE_p / MSE + 2p − n` (eq. 5.1) | p includes the coefficients, the searched lags and one offset per run; MSE is that of all sensors, with Cp = p |
//! | efficiency | `1 − Σ∣measured − simulated∣ / Σ∣measured∣` (eq. 5.2) | both relative to the first reading of a run, as a drift is to its zero; on the data with the fitted offset, which removes the noise of that reading |
//!
//! Cp assumes independent residuals. Those of a slow drift are not, so that Cp selects too many sensors. The number of sensors is therefore never
//! selected by Cp. It is the smallest one whose residual on the independent run is within one standard error (of ten time blocks, compared block by
//! block) of the minimum. Without an independent run the last third of every run is held out instead. If no number of sensors predicts the
//! independent run better than no correction, there is no drift model.
//!
//! Shrinkage is a ridge: a reading error f, independent for every sensor, adds f² Σ c² to the mean square residual; the coefficients that minimize
//! the sum for f in K are those of a ridge with weight n f². The other kind is a regression on the first principal components of the rises in kelvin: every
//! component is a distribution of temperatures over all sensors, and an error of one sensor changes it by its share only.

pub mod data;
mod products;
mod select;
mod shrinkage;
pub mod subset;
#[cfg(test)]
mod subset_tests;
pub mod text;

pub use select::{SelectionOptions, SensorSelection, SensorTerm, SubsetSize, select};
pub use shrinkage::Shrinkage;
