//! Evaluation of measured data: parameters, causes of errors, and additions to the machine file. This crate does not read part programs.

pub mod calibrate;
pub mod decompose;
pub mod diagnose;
pub mod measure;
pub mod results;
