//! What the data cannot tell, in words.

use nalgebra::DVector;

use crate::measure::data::DataSet;

use super::column::Column;

/// Parts of a direction that are smaller than this share of its largest one are left out.
const COUNTS: f64 = 0.05;
/// Names in a sentence at most.
const MOST_NAMES: usize = 6;

/// A sentence for every direction of a null space.
#[must_use]
pub fn lost(null_space: &[DVector<f64>], columns: &[Column], data: &[DataSet]) -> Vec<String> {
    simplified(null_space).iter().map(|direction| sentence(direction, columns, data)).collect()
}

/// The same space by directions with as many zeros as elimination gives: each then names as few columns as it can.
fn simplified(null_space: &[DVector<f64>]) -> Vec<DVector<f64>> {
    let mut rows: Vec<DVector<f64>> = null_space.to_vec();
    let mut done = 0;
    while done < rows.len() {
        // The largest part of what is left, in rows of unit length.
        for row in rows.iter_mut().skip(done) {
            let size = row.amax();
            if size > 0.0 {
                *row /= size;
            }
        }
        let Some(pivot) = rows.get(done).map(|row| row.iamax()) else { break };
        let first = rows[done].clone();
        let own = first[pivot];
        if own == 0.0 {
            break;
        }
        for (k, row) in rows.iter_mut().enumerate().filter(|(k, _)| *k != done) {
            let _ = k;
            let factor = row[pivot] / own;
            *row -= &first * factor;
        }
        done += 1;
    }
    rows.into_iter().filter(|row| row.amax() > 0.0).collect()
}

fn sentence(direction: &DVector<f64>, columns: &[Column], data: &[DataSet]) -> String {
    let largest = direction.amax();
    let mut parts: Vec<(usize, f64)> =
        direction.iter().copied().enumerate().filter(|(_, part)| part.abs() >= COUNTS * largest).collect();
    // Parameters of the machine first: they are what is asked for.
    parts.sort_by_key(|&(k, _)| (!matches!(columns.get(k), Some(Column::Parameter(_))), k));
    let names: Vec<String> =
        parts.iter().filter_map(|(k, _)| columns.get(*k)).map(|column| column.name(data).to_string()).collect();
    match names.as_slice() {
        [] => "nothing".into(),
        [only] => format!("{only} moves nothing that was measured"),
        [first, others @ ..] => {
            let shown = others.iter().take(MOST_NAMES).cloned().collect::<Vec<_>>().join(", ");
            let more = others.len().saturating_sub(MOST_NAMES);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            format!("{first} cannot be told from {shown}{more}")
        }
    }
}
