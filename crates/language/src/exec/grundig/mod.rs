//! Executes programs of the Grundig, Philips and `MillPlus` controls.
//!
//! Each block passes three steps. Its assignments are executed from left to right. Its words are gathered with their values. Then each word is
//! consumed in a fixed order (modal codes, zero offsets and frame, tool, compensation, feed and speed, auxiliary functions, motion or cycle). An
//! unconsumed word is an error.

mod arc;
mod auxiliary;
mod channel;
mod contour_words;
mod cycles;
mod defined;
mod execute;
mod expression;
mod flow;
mod frames;
mod gathered;
mod geometry;
mod kept_cycle;
mod level;
mod library;
mod machining;
mod modal;
mod modes;
mod motion;
mod order;
mod setup;
mod shifts;
mod step;
mod tables;
mod target;
mod tilt;
mod tilted;
mod tip;
mod tool;

pub(super) use execute::start;
pub(super) use tables::apply as apply_tables;
