//! Sensors that are read while the machine works: sources in separate threads, and a check of every value.
//!
//! ```text
//! source (thread) ─▶ ReadingOutlet ─▶ Panel::take ─▶ Monitor ─▶ ChannelReading
//!                   bounded     never waits    pure       last good value, its age, its state
//! ```
//!
//! A [`Config`] defines the channels, the sources of their values and the plausibility limits. A [`Panel`] owns the threads. A source that hangs or dies
//! delays no one; the values of its channels grow old. A [`Monitor`] is a state machine: a value and its time go in, a [`ChannelReading`] comes out. It always
//! passes on the last good value; a fault never becomes a temperature.

mod config;
mod lines;
mod monitor;
mod outage;
mod outlet;
mod panel;
pub mod source;
mod stamp;

pub use config::{Action, ChannelUnit, Config, SensorChannel, ValueOrigin};
pub use lines::LineReader;
pub use monitor::{ChannelFault, ChannelReading, ChannelState, FirstAnswer, Monitor, SourceReport};
pub use outage::SensorOutages;
pub use outlet::ReadingOutlet;
pub use panel::{Panel, PanelVerdict};
pub use source::{SensorSource, SensorSources};
pub use stamp::{clock, stamp};
