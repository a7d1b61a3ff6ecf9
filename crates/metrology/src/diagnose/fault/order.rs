//! Rows that are not in the order in which they were taken, if directions of motion are derived from the order.

use super::{DataDefect, DefectCheck, DefectKind, Then, View};
use crate::measure::data::DataSet;
use ncfix_base::geometry::AXES;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "rows out of order",
    made_by: "a table that was sorted or shuffled, or combined from several tables",
    shown_by: "no columns of directions, and axis positions jump at random from row to row, or the time decreases",
    source: "the direction of motion follows from the order of rows",
    look,
};

/// Minimum number of rows of a run.
const ROWS: usize = 20;
/// Minimum number of positions of an axis: with few positions any order is equally good.
const PLACES: usize = 8;
/// Largest distance between consecutive rows that shows an order, as a share of the mean distance of any two rows.
const NEAR: f64 = 0.7;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets().filter(|(_, data)| data.is_in_order && !data.has_senses) {
        let Some(evidence) = out_of_order(data) else { continue };
        out.push(DataDefect {
            kind: DefectKind::Order,
            set,
            name: data.name.clone(),
            what: "rows in no order".into(),
            rows: [0, data.observations.len().saturating_sub(1)],
            evidence: format!("{evidence}: directions of motion cannot be derived from the order of rows"),
            then: Then::Nothing,
        });
    }
}

fn out_of_order(data: &DataSet) -> Option<String> {
    let mut runs: std::collections::BTreeMap<(usize, usize), Vec<usize>> = std::collections::BTreeMap::new();
    for (row, one) in data.observations.iter().enumerate() {
        runs.entry((one.setup, one.run)).or_default().push(row);
    }
    let time = |row: usize| data.observations.get(row).and_then(|one| one.t_s);
    let (mut steps, mut ways, mut back, mut timed) = (0.0, 0.0, 0, 0);
    for rows in runs.values().filter(|rows| rows.len() >= ROWS) {
        let pairs = || rows.windows(2).filter_map(|pair| Some((time(pair[0])?, time(pair[1])?)));
        timed += pairs().count();
        back += pairs().filter(|(before, behind)| behind < before).count();
        for axis in AXES {
            let at: Vec<f64> = rows.iter().map(|&row| data.observations[row].reading.position[axis]).collect();
            let mut places: Vec<u64> = at.iter().map(|at| at.to_bits()).collect();
            places.sort_unstable();
            places.dedup();
            if places.len() < PLACES {
                continue;
            }
            // The mean distance of any two values follows from the sorted values.
            let mut sorted = at.clone();
            sorted.sort_by(f64::total_cmp);
            let count = at.len() as f64;
            let between = |(k, at): (usize, &f64)| (2.0 * k as f64 - count + 1.0) * at;
            ways += 2.0 * sorted.iter().enumerate().map(between).sum::<f64>() / (count * count);
            steps += at.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f64>() / (count - 1.0);
        }
    }
    if ways <= 0.0 {
        return None;
    }
    if timed > 0 {
        let backwards = || format!("time goes back {back} times within runs");
        return (back > 1).then(backwards);
    }
    let share = steps / ways;
    (share > NEAR).then(|| {
        let percent = 100.0 * share;
        format!("from row to row axes move {percent:.0} % of the way between any two rows of a run")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn an_axis_that_goes_to_and_fro_on_its_way_is_in_order() {
        let machine = bench::machine();
        let found = |order: &[usize]| {
            let cells: Vec<(f64, &str)> = order.iter().map(|&k| (100.0 * k as f64 - 950.0, "")).collect();
            out_of_order(&bench::along_x(&machine, "", &cells))
        };
        // 20 positions 100 mm apart have a mean distance of 100 · (20² − 1)/(3 · 20) = 665 mm; these steps are 5700/19 = 300 mm.
        let series = [0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15, 16, 18, 17, 19];
        assert_eq!(found(&series), None);
        // From one half to the other and back: ten steps of 1000 mm and nine of 900 mm.
        let halves: Vec<usize> = (0..10).flat_map(|k| [k, k + 10]).collect();
        assert!(found(&halves).is_some());
    }
}
