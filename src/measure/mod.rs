//! What was measured on the machine: tables of data and the positions in them.
//!
//! [`csv`] reads a table and knows where every cell stands, [`reading`] finds axis positions, tool vectors and senses of motion in its
//! columns, [`mode`] takes the corrections out of positions that were read (measurement mode). [`strain`] finds readings of a strain gauge,
//! [`weighing`] what load made them.

pub mod csv;
pub mod mode;
pub mod reading;
pub mod strain;
pub mod weighing;
