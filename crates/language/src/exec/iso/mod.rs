//! Executes programs of Fanuc controls and of RS274/NGC (LinuxCNC).
//!
//! Each block is processed in three steps: its words are gathered, their values are evaluated, and the words are executed in the order of the
//! dialect. Differences between the dialects depend on [`ncfix_dialect::Language`].

mod arc;
mod arguments;
mod assign;
mod auxiliary;
mod call;
mod calls;
mod channel;
mod codes;
mod compensation;
mod cycle;
mod cycles;
mod data;
mod data_origin;
mod direction;
mod drill;
mod execute;
mod expression;
mod feed;
mod flow;
mod forbidden;
mod frames;
mod functions;
mod gather;
mod gathered;
mod haas;
mod haas_codes;
mod home;
mod kept_cycle;
mod length;
mod level;
mod library;
mod loaded;
mod measure;
mod message;
mod modal;
mod modes;
mod motion;
mod nurbs;
mod offsets;
mod one_axis;
mod opaque;
mod order;
mod origin;

mod passed_axis;
mod passes;
mod pattern;
mod polar;
mod predefined;
mod probe;
mod reference;
mod request;
mod setup;
mod special;
mod spline;
mod startup;
mod state;
mod step;
mod system;
mod tapping;
mod target;
mod text;
mod thread;
mod tilt;
mod tilted;
mod tip;
mod transform;
mod trip;
mod variables;
mod zero_offset;

pub(super) use execute::start;
