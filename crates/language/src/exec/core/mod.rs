//! The interpreter core: what every family of languages executes with.

pub(in crate::exec) mod arc;
pub(in crate::exec) mod contour;
pub(in crate::exec) mod executor;
pub(in crate::exec) mod family;
pub(in crate::exec) mod fault;
pub(in crate::exec) mod five_axis;
pub(in crate::exec) mod flags;
pub(in crate::exec) mod grid;
pub(in crate::exec) mod interpreter;
pub(in crate::exec) mod ledger;
pub(in crate::exec) mod level;
pub(in crate::exec) mod library;
pub(in crate::exec) mod options;
pub(in crate::exec) mod outlet;
pub(in crate::exec) mod path;
pub(in crate::exec) mod program;
pub(in crate::exec) mod radius;
pub(in crate::exec) mod resolve;
pub(in crate::exec) mod rollover;
pub(in crate::exec) mod sagitta;
pub(in crate::exec) mod tilted_plane;
