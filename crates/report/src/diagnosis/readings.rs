//! The readings of a diagnosis one by one, for pictures: what is left before and after, what each finding does, and all that they may depend on.

use crate::compared::{Circle, Input};

/// What a page shows beside the object for programs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// Measurements, lengths and angles apart.
    pub sets: Vec<Set>,
    /// What was tried, by cause.
    pub causes: Vec<Tried>,
    /// Files that it comes from.
    pub inputs: Vec<Input>,
    /// Version of the program.
    pub version: &'static str,
}

/// Readings of a measurement in one unit; all lists of readings are of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Set {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// Whether nothing was looked for in it.
    pub is_held_out: bool,
    /// `µm` or `µrad`.
    pub unit: &'static str,
    /// Directions or components.
    pub parts: Vec<String>,
    /// Labels of the set-ups.
    pub setups: Vec<String>,
    /// The readings in the order of the table.
    pub readings: Vec<Reading>,
    /// What each finding does to every reading, in the order of the findings; empty where it was held out.
    pub doing: Vec<Vec<f64>>,
    /// What they may depend on.
    pub drivers: Vec<Driver>,
    /// Circles of a ball-bar.
    pub circles: Vec<Circle>,
}

/// One reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Row of the table, from 1.
    pub row: usize,
    /// Number among [`Set::parts`].
    pub part: usize,
    /// What the model leaves.
    pub before: f64,
    /// What is left with all findings.
    pub after: f64,
    /// Whether it counted.
    pub counts: bool,
}

/// A column that readings may depend on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Driver {
    /// Its name, as findings have it.
    pub name: String,
    /// The same with its unit: `X in mm`.
    pub title: String,
    /// Its value at each reading.
    pub values: Vec<f64>,
}

/// A cause of the catalogue.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tried {
    /// Its name.
    pub cause: String,
    /// Kind of effect.
    pub effect: String,
    /// What shows it.
    pub shown_by: String,
    /// Candidates of it.
    pub candidates: usize,
    /// Parameter of the best that does not stand, and the share of the squares of what is left that it would take.
    pub best: Option<(String, f64)>,
}
