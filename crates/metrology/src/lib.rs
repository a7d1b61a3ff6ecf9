//! From measured data to parameters, causes and what extends the machine file. It knows no text of programs.

pub mod calibrate;
pub mod decompose;
pub mod diagnose;
pub mod measure;
pub mod results;
