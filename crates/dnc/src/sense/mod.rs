//! Sensors that are read while the machine works: sources in threads of their own, and a judge for every value that they bring.
//!
//! ```text
//! source (thread) ─▶ Outlet ─▶ Panel::take ─▶ Monitor ─▶ Reading
//!                   bounded     never waits    pure       last good value, its age, its state
//! ```
//!
//! A [`Config`] says which channels there are, where their values come from and what is believed. A [`Panel`] owns the threads; a source that hangs or
//! dies keeps nobody waiting, its channels grow old. A [`Monitor`] is a pure machine: a value and its time go in, a [`Reading`] comes out. What it
//! hands on is always the last value that was good; a fault never becomes a temperature.

mod config;
mod lines;
mod monitor;
mod outlet;
mod panel;
pub mod source;
mod stamp;

pub use config::{Action, ChannelUnit, Config, SensorChannel, ValueOrigin};
pub use lines::LineReader;
pub use monitor::{ChannelState, Fault, Monitor, Reading, Told};
pub use outlet::Outlet;
pub use panel::{Panel, Verdict};
pub use source::{SensorSource, SensorSources};
pub use stamp::stamp;
