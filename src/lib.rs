//! ncfix reads a part program, executes it into a flat stream of simple moves, adds the corrections that the measured error
//! model of one machine asks for, and writes a program for exactly this machine.
//!
//! # The program as signatures
//!
//! ```text
//! bytes ─▶ Source ─▶ Program ─▶ Element … ─▶ Output … ─▶ text
//!
//! syntax::parse(&Source, &Dialect)                 -> (Program, Vec<Diagnostic>)       never fails, reports all
//! exec::Execution::new(Program, &Machine, …)       :  Iterator<Item = Result<Element, Diagnostic>>      lazy SNC
//! path::Corrector::new(elements, &Model, …)        :  Iterator<Item = Result<Output, Diagnostic>>       corrected pieces
//! emit::…::write(&Output, …)                       -> lines of the program's own language
//!
//! model::Model::actual(command, tool, state)       -> Pose            THE forward function: correction inverts it,
//! model::Model::solve(nominal, tool, state, …)     -> command         prediction projects it; there is no second formula
//! path::compare(original, corrected, &Model)       -> Comparison      what `ncfix verify` prints
//! ```
//!
//! Everything streams: no stage holds the path, so an endless program can be fed and memory is bounded by the program text.
//!
//! # Crates and rooms
//!
//! In the order in which data passes. Each crate is a folder below `crates/` of its name without `ncfix-`; what it may name stands in its `Cargo.toml`, and
//! `tests/architecture.rs` says which rooms of one crate may name each other. `ncfix` itself has the command line and the names below.
//!
//! | crate | room | what it is | must never know |
//! | --- | --- | --- | --- |
//! | `ncfix-base` | [`source`](ncfix_base::source), [`diagnostic`](ncfix_base::diagnostic), [`units`](ncfix_base::units), [`csv`](ncfix_base::csv) | bytes and spans; findings as plain data; the edge of units; tables of text | NC, machines |
//! | | [`geometry`](ncfix_base::geometry) | axis vectors, frames, arcs: values that evaluate themselves | machines, programs |
//! | | [`numeric`](ncfix_base::numeric) | least squares, statistics: plain arithmetic | machine tools |
//! | `ncfix-dialect` | [`dialect`](ncfix_dialect) | one value per control language: code table from `grammars/`, switches. A crate of its own: executors read it, and writers, which know no executor | syntax, execution |
//! | `ncfix-machine` | [`machine`](ncfix_machine::machine) | chain of bodies, axes, travel, tools, zero offsets, control; the TOML file | errors |
//! | | [`snc`](ncfix_machine::snc) | elements of the flat stream, their text form, provenance | dialects, the model |
//! | `ncfix-language` | [`syntax`](ncfix_language::syntax) | nom parsers and trees, one family per family of languages: what was written | what a code means |
//! | | [`exec`](ncfix_language::exec) | one executor per family of languages (modal state, variables, flow, frames, cycles) over one outlet (contours, transformation) → SNC | the error model |
//! | `ncfix-model` | [`model`](ncfix_model) | error functions, forward kinematics with errors, the inverse | programs, instruments |
//! | `ncfix-path` | [`path`](ncfix_path::path) | subdivision, correction, arc fitting, the error that is left along the path | text |
//! | | [`servo`](ncfix_path::servo) | follows a path at feed: look-ahead, smoothing, loops of the axes, contouring error; lowers feeds | text |
//! | | [`emit`](ncfix_path::emit) | numbers, blocks, stamp; one writer per dialect | syntax, the model |
//! | | [`review`](ncfix_path::review) | what changed between a program and its corrected one: rows, what they add up to, words of a line | files |
//! | `ncfix-metrology` | [`measure`](ncfix_metrology::measure) | measurements of all kinds, test plans, measurement mode, what load made a strain | the text of programs |
//! | | [`calibrate`](ncfix_metrology::calibrate) | fit of parameters and set-up unknowns, what the data cannot tell, quality | causes |
//! | | [`diagnose`](ncfix_metrology::diagnose) | what the model lacks: causes, search, gates, verdict, what extends the machine file | programs, files |
//! | | [`decompose`](ncfix_metrology::decompose) | errors at speed by source: delays, servo loops, links, motion, drift, what gives way under acceleration | programs, files |
//! | `ncfix-tables` | [`tables`](ncfix_tables::tables) | compensation tables of controls: what they do, schemes that fill them, formats | programs |
//! | | [`realtime`](ncfix_tables::realtime) | kernel on tables, cycle of a control, dosing, handover, rings in shared memory, why set-points are compensated | programs, files |
//! | `ncfix-dnc` | [`feed`](ncfix_dnc::feed) | links as data, dialogues as pure machines, window, dosing | G-code, kinematics |
//! | | [`sense`](ncfix_dnc::sense) | live sensors: sources in threads, what is believed of their values | programs, models |
//! | | [`drip`](ncfix_dnc::drip) | from corrected pieces to lines of a link: second step, dosing, text | links, files |
//! | `ncfix-report` | [`report`](ncfix_report) | draws plain data: findings, the table of a correction, JSON | files |
//! | `ncfix` | [`cli`] | one file per command; the only room that opens files, but for the sources of sensors | — |
//!
//! # To add something
//!
//! | to add | write | register in |
//! | --- | --- | --- |
//! | a dialect | `dialect/x.rs`, `grammars/x-codes.tsv`, `grammars/x.ebnf`, an executor in `exec/`, a writer in `emit/`, samples | [`dialect::DIALECTS`](ncfix_dialect::DIALECTS) |
//! | a G code or word | one row; an arm in `exec/` if it moves the machine | `grammars/x-codes.tsv` |
//! | a cycle | `cycles/sinumerik/X.spf`, a row in `cycles/README.md` | `exec/sinumerik/cycles.rs` |
//! | a cycle of another dialect | `exec/iso/cycles/x.rs`, `exec/grundig/cycles/x.rs` | `mod.rs` there |
//! | a cycle of the Grundig | `exec/grundig/cycles/x.rs`, pure steps at a position | `CYCLES` there |
//! | an address with a value | an arm in `exec/` | `exec/sinumerik/address.rs` |
//! | a word that is passed on | – | `exec/sinumerik/kept.rs` |
//! | a source of error | `model/source/x.rs`: sections, effects, formula and source, example; a row in the README | [`model::SOURCES`](ncfix_model::SOURCES) |
//! | a kind of motion error | `model/motion/x.rs` with formula, source and example; `docs/motion.md` | the register of kinds there |
//! | a kind of test plan | `measure/plan/x.rs`; a row in `docs/plan.md` | [`measure::plan::PLANS`](ncfix_metrology::measure::plan::PLANS) |
//! | a kind of measurement | `measure/kind/x.rs`: columns, unknowns, equations; a row in `docs/calibrate.md` | [`measure::kind::KINDS`](ncfix_metrology::measure::kind::KINDS) |
//! | a cause | `diagnose/cause/x.rs`: what makes it, what shows it, its columns | [`diagnose::cause::CAUSES`](ncfix_metrology::diagnose::cause::CAUSES) |
//! | a link | `links/x.toml` | [`feed::PROFILES`](ncfix_dnc::feed::PROFILES) |
//! | a source of live readings | `sense/source/x.rs`; a part of `docs/sensors.md` | [`sense::SOURCES`](ncfix_dnc::sense::SOURCES) |
//! | a kind of dialogue | `feed/dialogue/x.rs`: a pure machine | [`feed::PROTOCOLS`](ncfix_dnc::feed::PROTOCOLS) |
//! | a table format | `tables/format/x.rs`: write, read, limits; a row in `docs/table-formats.md` | [`tables::FORMATS`](ncfix_tables::tables::FORMATS) |
//! | a scheme of tables | `tables/scheme/x.rs`; a row in `docs/tables.md` | [`tables::SCHEMES`](ncfix_tables::tables::SCHEMES) |
//! | a preset of parameters | `model/preset/x.rs` | [`model::preset::PRESETS`](ncfix_model::preset::PRESETS) |
//! | a finding | a row with its long text, a bad sample that provokes it | [`diagnostic::CODES`](ncfix_base::diagnostic::CODES) |
//! | a command | `cli/x.rs` | `cli/mod.rs` |
//!
//! A forgotten registration, sample or row makes a test fail and say what is missing.
//!
//! # Conventions
//!
//! mm, rad, s inside; units in every name at the edges. Axis letters are those of ISO 841, error names those of ISO 230-1:
//! `EXX` positioning of X, `EYX` its straightness, `EAX` its roll, `EC0Y` the squareness of Y about Z. An error is the deviation of
//! the moving body, also on the workpiece side; a correction is what is added to a command. `docs/theory.md` has the formulas with their
//! sources, `docs/limits.md` what is too much.

pub mod cli;
