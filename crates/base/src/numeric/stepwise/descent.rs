//! Descent of one criterion by steps: enter, remove, exchange; the largest decrease first. If no such step decreases it, two candidates enter together: each
//! of the two pieces of an S-shaped curve explains nothing without the other.

use super::Change;
use super::sweep::Swept;

/// Criterion that must decrease strictly: ν ln(residual sum of squares) + Σ penalties of the selected columns.
#[derive(Clone, Debug)]
pub(super) struct Criterion {
    /// Column of the first candidate.
    pub(super) first: usize,
    /// Degrees of freedom ν.
    pub(super) freedom: f64,
    /// Penalty of each candidate.
    pub(super) prices: Vec<f64>,
    /// Maximum number of selected candidates.
    pub(super) most: usize,
}

/// Decreases below this are numerical noise.
const LEAST_FALL: f64 = 1e-6;
/// Residual sums of squares below this share of the initial one count as zero.
const NOTHING: f64 = 1e-20;
/// Maximum number of steps; a strict descent never needs more.
const MOST_STEPS: usize = 5000;

/// Descends while a step decreases the criterion, and reports each step. `chosen` are the selected columns.
pub(super) fn descend(
    swept: &mut Swept,
    criterion: &Criterion,
    chosen: &mut Vec<usize>,
    mut tell: impl FnMut(usize, Change),
) {
    let candidates = criterion.first..criterion.first + criterion.prices.len();
    let price = |column: usize| criterion.prices.get(column - criterion.first).copied().unwrap_or(f64::INFINITY);
    let first = swept.left();
    for _ in 0..MOST_STEPS {
        let left = swept.left().max(f64::MIN_POSITIVE);
        if left <= NOTHING * first {
            return;
        }
        // Change of the criterion for a given decrease of the squares.
        let change = |fall: f64| criterion.freedom * ((left - fall).max(NOTHING * first) / left).ln();
        let mut best: Option<(f64, usize, Change)> = None;
        let mut consider = |by: f64, column: usize, how: Change| {
            if by < -LEAST_FALL && best.is_none_or(|(least, ..)| by < least) {
                best = Some((by, column, how));
            }
        };
        for column in candidates.clone().filter(|&column| !swept.is_inside(column)) {
            if chosen.len() < criterion.most && swept.is_told(column) {
                consider(change(swept.gain(column)) + price(column), column, Change::Entered);
            }
            for &leaves in chosen.iter() {
                if let Some(fall) = swept.exchange(leaves, column) {
                    consider(change(fall) + price(column) - price(leaves), column, Change::Replaced(leaves));
                }
            }
        }
        for &column in chosen.iter() {
            consider(change(-swept.loss(column)) - price(column), column, Change::Left);
        }
        let Some((_, column, how)) = best else {
            let Some(pair) = best_pair(swept, criterion, chosen.len(), change) else { return };
            for column in pair {
                if !swept.pivot(column) {
                    return;
                }
                chosen.push(column);
                tell(column, Change::Entered);
            }
            continue;
        };
        let is_done = match how {
            Change::Replaced(leaves) => {
                chosen.retain(|&own| own != leaves);
                swept.pivot(leaves) && swept.pivot(column)
            }
            _ => swept.pivot(column),
        };
        match how {
            Change::Left => chosen.retain(|&own| own != column),
            _ => chosen.push(column),
        }
        tell(column, how);
        if !is_done {
            // Numerical contradiction: the column has become linearly dependent.
            chosen.retain(|&own| swept.is_inside(own));
            return;
        }
    }
}

/// The two candidates outside that decrease the criterion most if they enter together; `change` is that of the criterion for a decrease of the squares.
fn best_pair(swept: &Swept, criterion: &Criterion, chosen: usize, change: impl Fn(f64) -> f64) -> Option<[usize; 2]> {
    if chosen + 2 > criterion.most {
        return None;
    }
    let candidates = criterion.first..criterion.first + criterion.prices.len();
    let outside = candidates.zip(&criterion.prices).filter(|&(column, _)| !swept.is_inside(column));
    let outside: Vec<(usize, f64)> =
        outside.filter(|&(column, _)| swept.is_told(column)).map(|(column, &price)| (column, price)).collect();
    let mut best: Option<(f64, [usize; 2])> = None;
    for (place, &(one, price)) in outside.iter().enumerate() {
        for &(other, more) in outside.iter().skip(place + 1) {
            let Some(fall) = swept.gain_of_two(one, other) else { continue };
            let by = change(fall) + price + more;
            if by < -LEAST_FALL && best.is_none_or(|(least, _)| by < least) {
                best = Some((by, [one, other]));
            }
        }
    }
    best.map(|(_, pair)| pair)
}
