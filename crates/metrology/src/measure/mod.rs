//! What was measured on the machine: the positions and readings in tables of data.
//!
//! [`reading`] finds axis positions, tool vectors and senses of motion in the columns of a table ([`ncfix_base::csv`]), [`data`] reads a
//! measurement with its description, [`kind`] has one file per kind of measurement: what it reads and what a reading should be.
//! [`simulate`] goes the other way, with [`noise`]; [`plan`] makes measurements without readings and the way of the axes to them. [`mode`] takes the
//! corrections out of positions that were read (measurement mode), [`iso230`] has the figures of the acceptance tests. [`strain`] finds readings
//! of a strain gauge, [`weighing`] what load made them, [`copies`] tables with the same readings.
//! [`trace`] has what a control and an instrument recorded while the machine moved.

pub mod circles;
pub mod copies;
pub mod data;
pub mod iso230;
pub mod kind;
pub mod mode;
pub mod noise;
pub mod plan;
pub mod reading;
pub mod simulate;
pub mod strain;
pub mod trace;
pub mod weighing;
