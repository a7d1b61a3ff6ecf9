//! The plant: machines and instruments that hide effects in measured data, by seed, so that a diagnosis can be held to finding them.
//!
//! It shares no code with the crate, and no formulas either: kinematics, random numbers, set-ups, temperatures and text are its own, written
//! from the conventions. [`case`] makes a case of rows of the catalogue of physical causes, [`Recipe`] also one of faults and of effects that
//! no catalogue has. A case is text (machine file, pairs of files used and held out) and the [`Truth`] about it.
//!
//! Signs and names are those of the conventions: an effect that is an error of the machine is given as the deviation of the body that the
//! axis moves (`EXX`, `EC0Y`), with the size that the machine file would have.

mod bench;
mod case;
mod catalogue;
mod climate;
mod effect;
mod fault;
mod laws;
mod machine;
pub(crate) mod random;
mod reading;
mod row;
mod signatures;
mod unknown;
mod vector;
mod write;

pub(crate) use bench::{BENCHES, Bench};
pub(crate) use case::{Case, File, Recipe, case};
pub(crate) use catalogue::{NOT_SHOWN, rows_shown};
pub(crate) use effect::Hidden;
pub(crate) use fault::{FAULTS, Fault, FaultKind, is_possible};
pub(crate) use random::Random;
pub(crate) use unknown::{UNKNOWNS, Unknown};
