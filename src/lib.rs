//! ncfix reads a part program, executes it into a flat stream of simple moves, adds the corrections that the measured error
//! model of one machine asks for, and writes a program for exactly this machine.
//!
//! Everything streams: no stage holds the path, so an endless program can be fed and memory is bounded by the program text. Inside are mm, rad and s; at the
//! edges every name carries its unit. `ARCHITECTURE.md` of the project is the map of its crates, `docs/theory.md` has the formulas with their sources.

pub mod cli;
