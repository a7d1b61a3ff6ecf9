//! Data of the pieces that a comparison keeps.

use super::ReviewRow;
use crate::path::Follow;
use ncfix_machine::snc::WordValue;

/// Largest angle of a chord that draws an arc, rad.
const CHORD_RAD: f64 = 0.26;
/// Maximum number of points within arcs in one picture.
const MOST_VIA: usize = 1_000_000;
/// Maximum number of points within one arc, which may have any number of turns.
const MOST_OF_ARC: usize = 1000;
/// Relative change of a feed that counts as rounding noise.
const SAME_FEED: f64 = 1e-6;

/// Rows, and additional data for a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReviewTrace {
    /// The rows.
    pub rows: Vec<ReviewRow>,
    /// Nominal X, Y, Z at the end of each row, mm, in program coordinates; empty if not requested.
    pub at_mm: Vec<[f32; 3]>,
    /// Intermediate places of a row that is an arc: the row, and X, Y, Z as above.
    pub via: Vec<(u32, [f32; 3])>,
    /// Tool changes: the first row with the tool, and the tool.
    pub tools: Vec<(usize, String)>,
    /// The smallest and the largest feed of a piece relative to that of its move; `None` if feeds are unchanged.
    pub feeds: Option<[f64; 2]>,
    /// The last tool word.
    tool: Option<WordValue>,
}

impl ReviewTrace {
    /// An empty trace with capacity for `rows` rows; `has_places` for pictures.
    #[must_use]
    pub fn new(rows: usize, has_places: bool) -> ReviewTrace {
        // Memory is not used until it is written.
        let at_mm = Vec::with_capacity(if has_places { rows } else { 0 });
        ReviewTrace { rows: Vec::with_capacity(rows), at_mm, ..ReviewTrace::default() }
    }

    /// Adds a piece.
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
        self.rows.push(ReviewRow::new(follow));
    }
}

/// The name of a tool: `5`, `MILL_10`.
fn tool_name(word: &WordValue) -> String {
    match word {
        WordValue::Number(number) => number.to_string(),
        WordValue::Name(name) => name.iter().map(|&byte| char::from(byte)).collect(),
    }
}
