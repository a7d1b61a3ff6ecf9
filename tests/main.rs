//! The integration tests, one binary.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails here, which is what it is for")]

mod architecture;
mod archives;
mod arcs;
mod bad;
mod bench_machine;
mod cli_check;
mod cli_explain;
mod cli_fix;
mod cli_machine;
mod cli_snc;
mod cli_verify;
mod comparison;
mod correction;
mod definitions;
mod emission;
mod exec;
mod five_axis;
mod flat;
mod flow;
mod frame_correction;
mod frames;
mod grammar;
mod hostile;
mod kinematics;
mod limits;
mod machine_file;
mod machines;
mod model;
mod modes;
mod programs;
mod support;
mod synchronised;
mod system;
mod tolerance;
mod variables;
