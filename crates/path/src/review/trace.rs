//! What is kept of the pieces of a comparison while it walks.

use super::Row;
use crate::path::Follow;
use ncfix_machine::snc::WordValue;

/// An arc is drawn as chords over no more than this, rad.
const CHORD_RAD: f64 = 0.26;
/// Points within arcs at most: a picture of more than a million of them is drawn with what it has.
const MOST_VIA: usize = 1_000_000;
/// Points within one arc at most, which may have any number of turns.
const MOST_OF_ARC: usize = 1000;
/// A change of a feed below this share is arithmetic.
const SAME_FEED: f64 = 1e-6;

/// Rows, and what a picture needs beside them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The rows.
    pub rows: Vec<Row>,
    /// Nominal X, Y, Z at the end of each row, mm, in the coordinates of the program; empty where they are not asked for.
    pub at_mm: Vec<[f32; 3]>,
    /// Further places on the way to the end of a row, where that is an arc: the row, and X, Y, Z as above.
    pub via: Vec<(u32, [f32; 3])>,
    /// From which row on which tool is in use.
    pub tools: Vec<(usize, String)>,
    /// The smallest and the largest feed of a piece, as a share of that of its move; `None` where feeds are the same.
    pub feeds: Option<[f64; 2]>,
    /// The tool word that was seen last.
    tool: Option<WordValue>,
}

impl Trace {
    /// With room for so many rows; `has_places` for pictures.
    #[must_use]
    pub fn new(rows: usize, has_places: bool) -> Trace {
        // Memory that is not written is not taken.
        let at_mm = Vec::with_capacity(if has_places { rows } else { 0 });
        Trace { rows: Vec::with_capacity(rows), at_mm, ..Trace::default() }
    }

    /// Keeps a piece.
    pub fn see(&mut self, follow: &Follow<'_>, has_places: bool) {
        if follow.tool != self.tool.as_ref() {
            self.tool = follow.tool.cloned();
            self.tools.push((self.rows.len(), follow.tool.map_or_else(String::new, tool_name)));
        }
        if has_places {
            let chords = (follow.course.sweep_rad() / CHORD_RAD).ceil().clamp(1.0, MOST_OF_ARC as f64) as usize;
            if self.via.len() + chords <= MOST_VIA {
                let (row, course) = (self.at_mm.len() as u32, follow.course);
                let place = |k| course.at(k as f64 / chords as f64).xyz().map(|value| value as f32).into();
                self.via.extend((1..chords).map(|k| (row, place(k))));
            }
            self.at_mm.push(follow.nominal.xyz().map(|value| value as f32).into());
        }
        if let Some(share) = follow.feed_share.filter(|share| (share - 1.0).abs() > SAME_FEED) {
            let [least, most] = self.feeds.unwrap_or([share; 2]);
            self.feeds = Some([least.min(share), most.max(share)]);
        }
        self.rows.push(Row::new(follow));
    }
}

/// A tool as it is called: `5`, `MILL_10`.
fn tool_name(word: &WordValue) -> String {
    match word {
        WordValue::Number(number) => number.to_string(),
        WordValue::Name(name) => name.iter().map(|&byte| char::from(byte)).collect(),
    }
}
