//! Corrections in the cycle of a control: set-points of all axes in, corrections of all axes out (Spaan 1995, ch. 6).
//!
//! ```text
//! Kernel::new(&Machine, &Model, tool, …)   outside of the cycle: the model on 200 intervals per axis
//! handover(Kernel)                          -> (Publisher, Subscriber): a new kernel every 60 s, without a lock
//! Cycle::new(Subscriber, Dosing, …)         the cycle: Cycle::step(&set-point) -> Answer, nothing is allocated, nothing waits
//! ```
//!
//! The correction is looked up at the uncompensated set-point and not at the measured position: [`stability`] shows why. A [`ring`] in shared
//! memory connects the cycle to a control in another process, [`Histogram`] counts how long cycles took.

mod cycle;
mod dosing;
mod histogram;
mod kernel;
pub mod ring;
mod sense;
pub mod stability;
mod update;

pub use cycle::{Answer, Cycle, Signals};
pub use dosing::Dosing;
pub use histogram::Histogram;
pub use kernel::{Agreement, INTERVALS, Kernel};
pub use update::{Publisher, Subscriber, Updater, handover};
