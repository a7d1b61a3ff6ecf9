//! A null space in interpretable directions: each has its own column, the least simple one possible, and few others.
//!
//! Any mixture of the directions of a null space is equivalent. Columns are visited from the least simple one. Each is taken that is still involved
//! in the part not yet described; without the taken columns all others are identifiable. A model is reduced by the same rule.

use nalgebra::{DMatrix, DVector};

/// Minimum involvement of a column, relative to itself. Lower limits come later: removing a column with little involvement would leave the others
/// almost unidentifiable.
const TAKES_PART: [f64; 3] = [0.02, 1e-3, 1e-6];
/// Rounding noise.
pub(super) const NOISE: f64 = 1e-9;
/// Parts of a direction below this share of its largest one are not named.
pub(super) const COUNTS: f64 = 0.01;
/// Maximum number of operations for shortening directions.
const MOST_STEPS: usize = 30_000_000;

/// A direction: its own column, and its parts by columns of unit length; the part of its own column is 1.
pub(super) type NullDirection = (usize, DVector<f64>);

/// Determines the directions. `order` has the columns in groups, simple groups first: a column of a simple group is taken only if no other group is
/// involved.
pub(super) fn directions(null_space: &[DVector<f64>], order: &[Vec<usize>]) -> Vec<NullDirection> {
    let Some(height) = null_space.first().map(DVector::len) else { return Vec::new() };
    let count = null_space.len();
    let whole = DMatrix::from_fn(height, count, |row, column| null_space[column][row]);
    let mut taken: Vec<usize> = Vec::new();
    // The part of each column that is not yet described.
    let mut open: Vec<DVector<f64>> = whole.row_iter().map(|row| row.transpose()).collect();
    // Most unknowns of many set-ups are in no direction.
    let is_in: Vec<bool> = open.iter().map(|row| row.iter().any(|part| *part != 0.0)).collect();
    for group in order.iter().rev() {
        for limit in TAKES_PART {
            for &column in group.iter().rev() {
                let size = open.get(column).map_or(0.0, DVector::norm);
                if taken.len() == count || size <= limit || taken.contains(&column) {
                    continue;
                }
                let unit = &open[column] / size;
                for (row, _) in open.iter_mut().zip(&is_in).filter(|(_, is_in)| **is_in) {
                    let part = row.dot(&unit);
                    row.axpy(-part, &unit, 1.0);
                }
                taken.push(column);
            }
        }
    }
    if taken.len() < count {
        return Vec::new();
    }
    let own = DMatrix::from_fn(count, count, |row, column| whole[(taken[row], column)]);
    let Some(back) = own.try_inverse() else { return Vec::new() };
    let mut all = whole * back;
    let mut out = Vec::new();
    for (number, &column) in taken.iter().enumerate() {
        let mut direction = all.column_mut(number);
        // Exactly, so that no noise remains.
        taken.iter().for_each(|&other| direction[other] = f64::from(u8::from(other == column)));
        let least = NOISE * direction.amax();
        direction.iter_mut().filter(|part| part.abs() < least).for_each(|part| *part = 0.0);
        out.push((column, direction.into_owned()));
    }
    out.sort_by_key(|(column, _)| *column);
    out
}

/// True if a column is in the null space, and would not be if the `fixed` columns were known: every direction without these is without the column.
pub(super) fn is_settled(null_space: &[DVector<f64>], own: usize, fixed: &[usize]) -> bool {
    let count = null_space.len();
    let part = |row: usize, column: usize| null_space[column].get(row).copied().unwrap_or(0.0);
    let size = (0..count).map(|column| part(own, column).abs()).fold(0.0, f64::max);
    if count == 0 || fixed.is_empty() || size <= 0.0 {
        return false;
    }
    // Mixtures of the directions in which the fixed columns vanish; rows of zeros make the decomposition complete.
    let held = DMatrix::from_fn(fixed.len().max(count), count, |row, column| {
        fixed.get(row).map_or(0.0, |&fixed| part(fixed, column))
    });
    let parts = held.svd(false, true);
    let Some(mixtures) = parts.v_t else { return false };
    let largest = parts.singular_values.max();
    (0..count).filter(|&k| parts.singular_values[k] <= TAKES_PART[2] * largest).all(|k| {
        let own: f64 = (0..count).map(|column| mixtures[(k, column)] * part(own, column)).sum();
        own.abs() <= TAKES_PART[1] * size
    })
}

/// Shortens directions if the difference of two has fewer parts than one of them.
pub(super) fn shorten(directions: &mut [NullDirection]) {
    let support = |direction: &DVector<f64>| -> Vec<usize> {
        let least = COUNTS * direction.amax();
        (0..direction.len()).filter(|&k| direction[k].abs() >= least).collect()
    };
    let mut steps = 0;
    let mut supports: Vec<Vec<usize>> = directions.iter().map(|(_, direction)| support(direction)).collect();
    for one in 0..directions.len() {
        for other in 0..directions.len() {
            if one == other || supports[one].len() < 3 || directions[other].1[directions[one].0] != 0.0 {
                continue;
            }
            for &column in &supports[other].clone() {
                steps += directions[one].1.len();
                let part = directions[one].1[column];
                if part == 0.0 || steps > MOST_STEPS {
                    continue;
                }
                let factor = part / directions[other].1[column];
                let mut next = &directions[one].1 - &directions[other].1 * factor;
                next[column] = 0.0;
                let found = support(&next);
                // The own column must remain one of the large ones.
                if found.len() < supports[one].len() && found.contains(&directions[one].0) {
                    directions[one].1 = next;
                    supports[one] = found;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_has_a_column_of_its_own_from_the_last_group() {
        // Two mixtures of e0 + e2 and of e1 − 2 e3 + e0.
        let [one, other] = [[1.0, 0.0, 1.0, 0.0], [1.0, 1.0, 0.0, -2.0]].map(|parts| DVector::from_row_slice(&parts));
        let mixed = [(&one + &other).normalize(), (&one - &other * 0.5).normalize()];
        let found = directions(&mixed, &[vec![0, 1], vec![2, 3]]);
        assert_eq!(found.iter().map(|(own, _)| *own).collect::<Vec<_>>(), [2, 3]);
        assert!((&found[0].1 - &one).amax() < 1e-12, "{}", found[0].1);
        assert!((&found[1].1 + &other * 0.5).amax() < 1e-12, "{}", found[1].1);
        // If the last group is not involved, the first one is taken.
        let found = directions(&mixed, &[vec![0, 1, 3], vec![2]]);
        assert_eq!(found.iter().map(|(own, _)| *own).collect::<Vec<_>>(), [2, 3]);
    }

    #[test]
    fn a_known_column_settles_what_depends_on_it_alone() {
        // e0 + e1, and e2 + e3: with e1 known, e0 is known, and e2 is not.
        let [one, other] = [[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]].map(|parts| DVector::from_row_slice(&parts));
        let mixed = [(&one + &other).normalize(), (&one - &other * 0.5).normalize()];
        assert!(is_settled(&mixed, 0, &[1]) && !is_settled(&mixed, 2, &[1]) && !is_settled(&mixed, 0, &[3]));
        assert!(!is_settled(&mixed, 0, &[]) && !is_settled(&[], 0, &[1]));
    }

    #[test]
    fn shorter_directions_span_the_same() {
        let rows = [[1.0, 0.0, 1.0, 1.0, 1.0], [0.0, 1.0, 1.0, 1.0, 0.0]].map(|parts| DVector::from_row_slice(&parts));
        let mut found: Vec<NullDirection> = rows.iter().cloned().enumerate().collect();
        shorten(&mut found);
        assert_eq!(found[0].1, DVector::from_row_slice(&[1.0, -1.0, 0.0, 0.0, 1.0]));
        assert_eq!(found[1].1, rows[1]);
    }
}
