//! Executes programs of the Sinumerik.
//!
//! Each block goes through three steps: its words are gathered, checked, and executed in a fixed order (assignments, modal
//! codes, zero offset and frame, tool, feed and speed, auxiliary functions that act before the motion, motion, the others).

mod address;
mod angle;
mod arc;
mod archive;
mod argument;
mod assign;
mod axis_name;
mod beside;
mod call;
mod cells;
mod channel;
mod contour_words;
mod cycle_calls;
mod cycles;
mod dwell;
mod execute;
mod expression;
mod flow;
mod forbidden;
mod frame_store;
mod frame_value;
mod frames;
mod functions;
mod gather;
mod gathered;
mod groups;
mod indexed_word;
mod jump;
mod level;
mod library;
mod loaded;
mod modal;
mod motion;
mod names;
mod operand;
mod orientation;
mod parameters;
mod part;
mod pass;
mod place;
mod polar;
mod polynomial;
mod positioning;
mod reference;
mod rotary;
mod save;
mod scope;
mod spatial;
mod spline;
mod surface;
mod swivel;
mod sync_action;
mod system;
mod system_write;
mod text_block;
mod thread;
mod tool;
mod tool_data;
mod transform;
mod value;
mod variables;

pub(super) use archive::apply_archive;
pub(super) use execute::start;
