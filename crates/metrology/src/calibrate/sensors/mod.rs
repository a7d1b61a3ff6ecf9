//! Selection of the sensors that tell a thermal drift (Spaan 1995, ch. 5).
//!
//! Drift of the tool relative to the workpiece is a sum of rises of temperature with a coefficient each, in every direction and at every
//! position of the axis along which it changes. [`data`] reads records, [`select()`] looks for the best sensors of each number of them
//! ([`subset`]: exact), says how well they tell the data and an independent run, and takes the number that tells the independent run.
//! [`text`] writes what was found as `[[drift]]` of a machine file.
//!
//! | figure | formula | note |
//! | --- | --- | --- |
//! | Cp | `SSE_p / MSE + 2p − n` (eq. 5.1) | p counts the coefficients, the lags that were searched and one offset for each run; MSE is that of all sensors, whose Cp is p |
//! | efficiency | `1 − Σ∣measured − simulated∣ / Σ∣measured∣` (eq. 5.2) | measured and simulated count from the first reading of a run, as a drift counts from where the zero point was set; on the data, simulated has the offset of the fit, which takes the noise of the first reading out |
//!
//! Cp holds for residuals that are independent of each other. Those of a slow drift are not, so that Cp takes too many sensors; the number
//! of sensors is therefore never chosen by Cp, but is the smallest whose rest on the independent run is within one standard error (of ten
//! blocks of time, compared block by block) of the least. Without an independent run the last third of every run is held back for that.
//! Where no number of sensors tells the independent run better than no correction at all, there is no drift model.
//!
//! Shrinkage is a ridge: a reading that is wrong by f, independently for every sensor, adds f² Σ c² to the mean square of the rest; the
//! coefficients that make the sum least for an f in K are the ridge of weight n f².

pub mod data;
mod products;
mod select;
pub mod subset;
#[cfg(test)]
mod subset_tests;
pub mod text;

pub use select::{SelectionOptions, SensorSelection, SensorTerm, SubsetSize, select};
