//! From measured data to parameters, causes and additions to the machine file, without any knowledge of program text.

pub mod calibrate;
pub mod decompose;
pub mod diagnose;
pub mod measure;
pub mod results;
