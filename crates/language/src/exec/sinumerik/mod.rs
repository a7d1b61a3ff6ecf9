//! Executes programs of the Sinumerik.
//!
//! Each block passes three steps: its words are gathered, checked, and executed in a fixed order (assignments, modal codes, zero offset and frame,
//! tool, feed and speed, auxiliary functions before the motion, motion, others).

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
mod context;
mod contour_call;
mod contour_words;
mod control;
mod curve;
mod cycle_calls;
mod cycles;
mod dwell;
mod execute;
mod expression;
mod feed;
mod five_axis;
mod flow;
mod forbidden;
mod frame_store;
mod frame_value;
mod frames;
mod functions;
mod gather;
mod gathered;
mod gatherer;
mod groups;
mod indexed_word;
mod jump;
mod level;
mod library;
mod loaded;
mod modal;
mod modes;
mod motion;
mod names;
mod operand;
mod order;
mod orientation;
mod parameters;
mod part;
mod pass;
mod place;
mod polar;
mod pole;
mod polynomial;
mod positioning;
mod reference;
mod rotary;
mod save;
mod scope;
mod setup;
mod spatial;
mod spline;
mod splines;
mod startup;
mod stated;
mod stream;
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

/// Advice for a word that is not executed. It may move the machine, so nobody is asked just to remove it.
const WITHOUT_IT: &str =
    "program its effect with plain positions of X, Y and Z; if you only remove it, the moves after it may go elsewhere";

pub(super) use archive::apply_archive;
pub(super) use execute::start;
