//! Corrections in the cycle of a control: set-points of all axes in, corrections of all axes out (Spaan 1995, ch. 6).
//!
//! ```text
//! Kernel::new(&Machine, &Model, tool, …)   outside of the cycle: the model on 200 intervals per axis
//! handover(Kernel)                          -> (Publisher, Subscriber): a new kernel every 60 s, without a lock
//! Cycle::new(Subscriber, Dosing, …)         the cycle: Cycle::step(&set-point) -> Answer, nothing is allocated, nothing waits
//! ```
//!
//! The correction is looked up at the uncompensated set-point and not at the measured position: [`stability`] shows why. A [`ring`] in shared
//! memory connects the cycle to a control in another process, [`LatencyHistogram`] counts the durations of cycles.
//!
//! ```
//! use std::time::Duration;
//!
//! use ncfix_base::geometry::{Axis, AxisVector, Vector};
//! use ncfix_machine::machine::{Condition, file::DEMO};
//! use ncfix_model::{Model, Solve, file::load};
//! use ncfix_tables::realtime::{Cycle, Dosing, Kernel, Updater, handover};
//! use ncfix_base::source::{FileId, Source};
//!
//! let source = Source::new(FileId(0), "demo.toml", DEMO.as_bytes().to_vec()).unwrap();
//! let (machine, errors) = load(&source).0.unwrap();
//! let tool_mm = Vector::new(0.0, 0.0, -120.0);
//! let kernel = move |condition: &Condition| {
//!     Kernel::new(&machine, &Model::at(&machine, &errors, condition), &tool_mm, Solve::Full)
//! };
//! let (publisher, subscriber) = handover(kernel(&Condition::default()));
//! // A real updater puts the readings of the sensors into the condition.
//! let updater = Updater::start(publisher, Duration::from_secs(60), move || Some(kernel(&Condition::default())));
//! // At most 1 µm and 5 µrad per cycle; a return of more than 0.1 µm or 1 µrad is a reversal.
//! let mut cycle = Cycle::new(subscriber, Dosing::new(1e-3, 5e-6), 1e-4, 1e-6);
//!
//! // In the cycle of the control:
//! let mut set_point = AxisVector::ZERO;
//! set_point[Axis::X] = 350.0;
//! let answer = cycle.step(&set_point);
//! let command = set_point + answer.correction;
//! # assert!((command[Axis::X] - 350.0).abs() <= 1e-3);
//! # drop(updater);
//! ```

mod counted;
mod cycle;
mod dosing;
mod histogram;
mod kernel;
mod recipe;
pub mod ring;
mod sense;
mod served;
pub mod set_points;
pub mod stability;
mod update;

pub use counted::CycleCounts;
pub use cycle::{Answer, Cycle, Signals};
pub use dosing::Dosing;
pub use histogram::LatencyHistogram;
pub use kernel::{Agreement, INTERVALS, Kernel};
pub use recipe::KernelRecipe;
pub use served::{ServingEnd, serve};
pub use update::{Publisher, Subscriber, Updater, handover};
