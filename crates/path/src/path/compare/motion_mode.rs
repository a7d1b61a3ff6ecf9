//! Comparison of threads and probing motions with those of the original.

use ncfix_machine::snc::{MotionMode, Thread};

/// Difference below which leads and their changes are equal, mm: in inches they are written with six decimals.
const SAME_LEAD_MM: f64 = 3e-5;

/// Descriptions of both if they differ; other moves are compared by their path.
pub(super) fn difference(original: &MotionMode, corrected: &MotionMode) -> Option<[String; 2]> {
    let is_kept = match (original, corrected) {
        (MotionMode::Thread(one), MotionMode::Thread(other)) => is_same_thread(one, other),
        (MotionMode::Thread(_) | MotionMode::Probe(_), _) | (_, MotionMode::Thread(_) | MotionMode::Probe(_)) => {
            original == corrected
        }
        _ => true,
    };
    (!is_kept).then(|| [shown(original), shown(corrected)])
}

fn is_same_thread(one: &Thread, other: &Thread) -> bool {
    let is_same = |one: Option<f64>, other: Option<f64>| match (one, other) {
        (Some(one), Some(other)) => (one - other).abs() <= SAME_LEAD_MM,
        (None, None) => true,
        _ => false,
    };
    let lead = |thread: &Thread| thread.lead.map(|(_, lead)| lead);
    one.code == other.code && is_same(lead(one), lead(other)) && is_same(one.change, other.change)
}

fn shown(motion_mode: &MotionMode) -> String {
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    match motion_mode {
        MotionMode::Thread(thread) => {
            let lead = thread.lead.map_or_else(String::new, |(_, lead)| format!(" with {} mm a turn", rounded(lead)));
            let change = thread.change.map_or_else(String::new, |change| format!(", changing by {}", rounded(change)));
            format!("{}{lead}{change}", thread.code.word())
        }
        MotionMode::Probe(word) => (*word).to_owned(),
        _ => "a move without a thread".to_owned(),
    }
}
