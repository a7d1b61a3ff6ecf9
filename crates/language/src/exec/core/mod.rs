//! The interpreter core: all that executing a program has in common, whatever the language.
//!
//! | concept | file |
//! | --- | --- |
//! | the way from block to block, skip levels, modal calls, findings | [`interpreter`] |
//! | levels, sections in repetition, what a block does to the order | [`level`] |
//! | files of the run; where programs come from | [`program`], [`library`] |
//! | what a family is made of | [`family`] |
//! | modal groups: what is in force of each, saved states | [`modal`] |
//! | tools: selected and in the spindle, what is in force, data that a run writes | [`tool`] |
//! | where the axes are, and of which the program has said so | [`position`] |
//! | the way to reference points and back | [`reference`] |
//! | frame, tool length and plane in force | [`standing`] |
//! | radius compensation, roundings, chamfers | [`contour`] |
//! | steps of cycles | [`step`] |
//! | paths, and what the outlet makes of them | [`path`], [`outlet`], [`resolve`], [`five_axis`] |
//! | findings, books, limits of a run | [`fault`], [`ledger`], [`options`], [`settings`] |
//!
//! # What a family brings
//!
//! 1. **A tree.** Its grammar lives in `syntax`; [`program::ProgramText`] and [`program::Statement`] tell the core where blocks are, their lines,
//!    numbers and skip levels.
//! 2. **Types**, [`family::Family`]: what is worked out of a file once, what a call is, what a level keeps.
//! 3. **A channel**: plain state and an [`outlet::Outlet`]. The state is made of [`modal::Modes`] with the family's kinds of motion,
//!    [`modal::CodesInForce`] with its other groups and their codes at the start, a [`tool::ToolState`] with its length, a
//!    [`tool::ToolTable`] with what its control keeps of an edge, and a [`position::Position`]. Gathering words, working out values, and executing a block in the order of
//!    the control are its own; motions become a [`path::Path`] with a [`contour::Wish`] and go to the outlet.
//! 4. **Answers**, [`interpreter::Execute`]: what a block does, how a call is found and begun, what an end means.
//!
//! In return the core counts blocks and ends endless programs, leaves skipped blocks out, gives each element its origin, repeats
//! sections, holds what a block does to the order back behind a modal call, loads each file once, and hands findings out once.
//!
//! Not shared, because sharing would be a list of options: which words select a code (RS274/NGC and Fanuc count tenths, Sinumerik has names,
//! Grundig takes codes out of a list in its order); which number names an offset (D of an edge, H and D of a table, hundredths of T); what
//! a saved state brings back and in which words the output says so (SAVE, M72); where reference points are.
//!
//! # A fourth family: Klartext
//!
//! | in the program | for the core |
//! | --- | --- |
//! | `CALL LBL 5` | `AfterBlock::Call`; `call` begins a level in the same file at the block of the label |
//! | `LBL 0` | `AfterBlock::Return` where a call is open, else `AfterBlock::Next` |
//! | `CALL LBL 5 REP 3` | `AfterBlock::Repeat` of the section from the label to the block before, three passes |
//! | `FN 9: IF Q1 EQU Q2 GOTO LBL 7` | `AfterBlock::Goto`; labels are looked up once and kept in `Family::Prepared` |
//! | `CALL PGM SUB` | `AfterBlock::Call`; `find_once` by name; the level keeps the QL of its caller, gives them back when it ends |
//! | `M2`, `M30`, `END PGM` | `AfterBlock::End`, the latter by `end_of_blocks` |
//! | `Q1 = Q2 + SIN 30` | no business of the core: the channel keeps Q, QL, QR, QS |
//! | `L X+10 IY+5 R0 FMAX M3` | words gathered, axis by axis absolute or incremental; `Shape::Line`, `ContourModal::side` of R0, RL, RR |
//! | `CC`, `C`, `CR`, `CT` | the pole is state; `Shape::Arc`; `CT` takes the direction of the path before |
//! | `RND`, `CHF`, `APPR`, `DEP` | `Wish::corner`, `Wish::soft`, as contour words of Grundig are |
//! | cycle 7, 8, 10, 11, 26, `PLANE` | frames of the channel; [`standing::InForce`] puts what they add up to in force |
//! | `CYCL DEF 200 …` | state: the parameters are Q; DEF-active cycles act at once |
//! | `CYCL CALL`, `M99` | [`step`]s of the cycle, carried out at the position |
//! | `M89` | `modal_call`: there is one behind each block that has moved |
//! | `TOOL CALL 5 Z S2500` | [`tool::ToolState`] with its one length, found by [`tool::ToolTable`]; the axis chooses the plane |
//! | `TOOL DEF 5`, `DL`, `DR` | `ToolState::selected`; allowances are the family's, as G39 of Grundig is |
//! | `F MAX`, `FU`, `M136` | [`modal::Modes`]; M functions with a group in [`modal::CodesInForce`] |
//! | `M91`, `M92` | positions of the machine for one block; where the axes are is a [`position::Position`] as ever |
//!
//! A program of the control that only it knows (a cycle of its builder) passes through, as `[[opaque]]` says.
//!
//! # Turning, in every family
//!
//! Diameters are read by the gatherer of a family: inside there are radii. The working plane is ZX; nose radius compensation is radius
//! compensation about a center that [`contour`] shifts by the vector of the tip. G71 to G73 and their kin read a contour between two
//! blocks: those blocks are executed into a list of paths in place of the outlet, and the cycle makes its steps of them; execution goes
//! on with `AfterBlock::Goto` behind the last. Threads are moves with `Manner::Thread`. Feed per turn and constant cutting speed are state
//! that moves carry already.

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
pub(in crate::exec) mod modal;
pub(in crate::exec) mod options;
pub(in crate::exec) mod outlet;
pub(in crate::exec) mod path;
pub(in crate::exec) mod position;
pub(in crate::exec) mod program;
pub(in crate::exec) mod radius;
pub(in crate::exec) mod reference;
pub(in crate::exec) mod resolve;
pub(in crate::exec) mod rollover;
pub(in crate::exec) mod sagitta;
pub(in crate::exec) mod settings;
pub(in crate::exec) mod standing;
pub(in crate::exec) mod step;
pub(in crate::exec) mod tilted_plane;
pub(in crate::exec) mod tool;
#[cfg(test)]
mod toy;
