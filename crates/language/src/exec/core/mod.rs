//! The interpreter core: the language-independent parts of program execution.
//!
//! | concept | file |
//! | --- | --- |
//! | sequence of blocks, skip levels, modal calls, diagnostics | [`interpreter`] |
//! | levels, repeated sections, effect of a block on the order | [`level`] |
//! | files and sources of programs | [`program`], [`library`] |
//! | types of a family | [`family`] |
//! | modal groups: active codes, saved states | [`modal`] |
//! | changes of the head | [`head`] |
//! | tools: selected, in the spindle, active; data written by a run | [`tool`] |
//! | axis positions, and axes with stated positions | [`position`] |
//! | paths to reference points and back | [`mod@reference`] |
//! | active frame, tool length and plane | [`standing`] |
//! | radius compensation, roundings, chamfers | [`contour`] |
//! | steps of cycles | [`step`] |
//! | paths, and their conversion by the motion sink | [`path`], [`motion_sink`], [`resolve`], [`curve_arcs`], [`five_axis`] |
//! | faults, state of a run, limits of a run, values that it assumes or fixes | [`fault`], [`run_state`], [`options`], [`settings`], [`assumed_values`], [`fixed_values`] |
//!
//! # Parts of a family
//!
//! A family is a group of dialects with one executor, such as Fanuc and RS274/NGC.
//!
//! 1. **A tree.** Its grammar lives in `syntax`; [`program::ProgramText`] and [`program::Statement`] give the core the blocks with their lines,
//!    numbers and skip levels.
//! 2. **Types**, [`family::Family`]: the derived data of a file, calls, and the data of a level.
//! 3. **A channel**: plain state and a [`motion_sink::MotionSink`]. The state consists of [`modal::Modes`] with the family's motion modes,
//!    [`modal::CodesInForce`] with its other groups and their codes at the start, a [`tool::ToolState`] with its length, a [`tool::ToolTable`] with
//!    the edge data of its control, and a [`position::Position`]. The family itself gathers words, evaluates values, and executes a block in the
//!    order of the control; motions become a [`path::Path`] with a [`contour::ContourRequest`] and go to the motion sink.
//! 4. **Functions**, [`interpreter::Execute`]: the effect of a block, the search and start of calls, and the meaning of an end.
//!
//! In return the core counts blocks and ends endless programs, skips blocks by level, sets the origin of each element, and repeats sections. It
//! postpones flow actions until after a modal call, loads each file once, and reports each diagnostic once.
//!
//! Some parts are not shared, as sharing would need a list of options: the words that select a code (RS274/NGC and Fanuc use tenths, Sinumerik has
//! names, Grundig takes codes from a list in its order); the numbers of offsets (D of an edge, H and D of a table, hundredths of T); the content of
//! a restored state and its words in the output (SAVE, M72); the positions of reference points.
//!
//! # Sketch of a fourth family: Klartext (not implemented)
//!
//! | in the program | for the core |
//! | --- | --- |
//! | `CALL LBL 5` | `AfterBlock::Call`; `call` begins a level in the same file at the block of the label |
//! | `LBL 0` | `AfterBlock::Return` if a call is open, otherwise `AfterBlock::Next` |
//! | `CALL LBL 5 REP 3` | `AfterBlock::Repeat` of the section from the label to the block before, three passes |
//! | `FN 9: IF Q1 EQU Q2 GOTO LBL 7` | `AfterBlock::Goto`; labels are looked up once and kept in `Family::Prepared` |
//! | `CALL PGM SUB` | `AfterBlock::Call`; `find_once` by name; the level keeps the QL of its caller, restores them at its end |
//! | `M2`, `M30`, `END PGM` | `AfterBlock::End`, the latter by `end_of_blocks` |
//! | `Q1 = Q2 + SIN 30` | not part of the core: the channel keeps Q, QL, QR, QS |
//! | `L X+10 IY+5 R0 FMAX M3` | words gathered, axis by axis absolute or incremental; `Shape::Line`, `ContourModal::side` of R0, RL, RR |
//! | `CC`, `C`, `CR`, `CT` | the pole is state; `Shape::Arc`; `CT` uses the final direction of the previous path |
//! | `RND`, `CHF`, `APPR`, `DEP` | `ContourRequest::corner`, `ContourRequest::soft`, as contour words of Grundig |
//! | cycle 7, 8, 10, 11, 26, `PLANE` | frames of the channel; [`standing::InForce`] holds their product |
//! | `CYCL DEF 200 …` | state: the parameters are Q; DEF-active cycles act immediately |
//! | `CYCL CALL`, `M99` | [`step`]s of the cycle, executed at the position |
//! | `M89` | `modal_call`: begun after each block with motion |
//! | `TOOL CALL 5 Z S2500` | [`tool::ToolState`] with its single length, found by [`tool::ToolTable`]; the axis selects the plane |
//! | `TOOL DEF 5`, `DL`, `DR` | `ToolState::selected`; allowances belong to the family, as G39 of Grundig |
//! | `F MAX`, `FU`, `M136` | [`modal::Modes`]; M functions with a group in [`modal::CodesInForce`] |
//! | `M91`, `M92` | positions of the machine for one block; axis positions are a [`position::Position`] as usual |
//!
//! A program that only the control knows (such as a cycle of the machine builder) is passed through, as `[[opaque]]` defines.
//!
//! # Sketch of turning, in every family (not implemented)
//!
//! The gatherer of a family converts diameters: internally there are radii. The working plane is ZX. Nose radius compensation is radius compensation
//! about a center that [`contour`] shifts by the vector of the tip. G71 to G73 and related cycles read a contour between two blocks: those blocks are
//! executed into a list of paths instead of the motion sink, and the cycle derives its steps from them. Execution continues with `AfterBlock::Goto` after
//! the last block. Threads are moves with `MotionMode::Thread`. Feed per turn and constant cutting speed are state that moves already carry.

pub(in crate::exec) mod arc;
pub(in crate::exec) mod assumed_values;
pub(in crate::exec) mod contour;
pub(in crate::exec) mod curve_arcs;
pub(in crate::exec) mod executor;
pub(in crate::exec) mod family;
pub(in crate::exec) mod fault;
pub(in crate::exec) mod five_axis;
pub(in crate::exec) mod fixed_values;
pub(in crate::exec) mod flags;
pub(in crate::exec) mod grid;
pub(in crate::exec) mod growing_offsets;
pub(in crate::exec) mod head;
pub(in crate::exec) mod interpreter;
pub(in crate::exec) mod level;
pub(in crate::exec) mod library;
pub(in crate::exec) mod modal;
pub(in crate::exec) mod motion_sink;
pub(in crate::exec) mod options;
pub(in crate::exec) mod path;
pub(in crate::exec) mod position;
pub(in crate::exec) mod program;
pub(in crate::exec) mod radius;
pub(in crate::exec) mod reference;
pub(in crate::exec) mod resolve;
pub(in crate::exec) mod rollover;
pub(in crate::exec) mod run_state;
pub(in crate::exec) mod sagitta;
pub(in crate::exec) mod settings;
pub(in crate::exec) mod standing;
pub(in crate::exec) mod step;
pub(in crate::exec) mod tilted_plane;
pub(in crate::exec) mod tool;
#[cfg(test)]
mod toy;
