//! Steps down one criterion: enter, leave, exchange, the largest fall first.

use super::Change;
use super::sweep::Swept;

/// What must fall strictly: ν ln(squares that are left) + Σ prices of the columns that are in.
#[derive(Clone, Debug)]
pub(super) struct Criterion {
    /// The first candidate's column.
    pub(super) first: usize,
    /// ν.
    pub(super) freedom: f64,
    /// What each candidate costs.
    pub(super) prices: Vec<f64>,
    /// How many may be in.
    pub(super) most: usize,
}

/// A fall by less is the arithmetic's.
const LEAST_FALL: f64 = 1e-6;
/// Squares below this share of the first ones are nothing.
const NOTHING: f64 = 1e-20;
/// No descent that falls strictly takes so many steps.
const MOST_STEPS: usize = 5000;

/// Goes down as long as there is a way, and tells each step. `chosen` are the columns that are in.
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
        // By how much the criterion changes where the squares fall by this.
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
        let Some((_, column, how)) = best else { return };
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
            // The arithmetic contradicts itself: what was told is no more.
            chosen.retain(|&own| swept.is_inside(own));
            return;
        }
    }
}
