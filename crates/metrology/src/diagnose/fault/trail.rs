//! Readings relative to their own repetitions, in the order in which they were taken.
//!
//! Effects of the machine by position, direction or feed repeat when it returns. So the residual relative to the median of all visits depends on time
//! but not on the position. Short faults are searched there, so that no effect of the machine is mistaken for one.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use super::{median, spread};
use crate::diagnose::scene::{NO_ROW, Scene, SceneReading};
use crate::measure::data::DataSet;
use crate::measure::display;
use ncfix_base::geometry::AXES;
use ncfix_base::numeric::Upright;

/// Minimum number of visits for a median.
const VISITS: usize = 3;
/// Columns that describe the conditions of a visit.
const MANNER: [&str; 5] = ["feed_mm_min", "load_N", "load_x_mm", "load_y_mm", "spindle_deg"];

/// Readings of one kind in sequence: one value, or one component.
#[derive(Clone, Debug, Default)]
pub(super) struct ReadingTrail {
    /// Row and value of each reading.
    pub(super) at: Vec<(usize, usize)>,
    /// Residuals of the model, mm or rad; NaN for rejected readings.
    pub(super) value: Vec<f64>,
    /// Index of the position with direction of each reading; the number of all of them if it has no repetitions.
    pub(super) group: Vec<usize>,
    /// Number of positions with repetitions.
    pub(super) groups: usize,
    /// Terms that may depend on the directions of axes, if every visit comes from another side.
    senses: Vec<Vec<f64>>,
    /// Their span in the used readings, computed on demand.
    spanned: OnceLock<Arc<Upright>>,
    /// Residuals relative to the repetitions, mm or rad; NaN for rejected readings.
    pub(super) left: Vec<f64>,
    /// Noise from one reading to the next, mm or rad.
    pub(super) noise: f64,
    /// Stated uncertainty.
    pub(super) sigma: f64,
    /// Usual number of rows from one reading to the next.
    pub(super) step: usize,
    /// Cumulative sums and numbers of the used readings.
    sums: Vec<(f64, usize)>,
}

/// A measurement.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    pub(super) channels: Vec<ReadingTrail>,
    /// Rows of the table.
    pub(super) rows: usize,
    /// Ranges of rows within which poses repeat: first and last.
    pub(super) blocks: Vec<[usize; 2]>,
    /// True if most readings have repetitions.
    pub(super) is_repeated: bool,
    /// True if the repetitions come from the same side.
    pub(super) has_sense: bool,
    /// By row: true if a run or a direction begins with it.
    begins: Vec<bool>,
    /// By row: an index that is equal for rows at the same point from the same side, with any tool.
    alike: Vec<usize>,
    noise_ratio: Option<f64>,
}

/// Index of the component of every row.
pub(super) fn channels(data: &DataSet) -> Vec<usize> {
    data.observations.iter().map(|one| one.component.and(one.target).unwrap_or(0)).collect()
}

impl Trail {
    pub(super) fn new(scene: &Scene<'_>, set: usize) -> Trail {
        let Some(data) = scene.sets.get(set) else { return Trail::default() };
        let items: Vec<(&SceneReading, usize)> = scene
            .items
            .iter()
            .filter(|item| item.row != NO_ROW)
            .filter_map(|item| scene.rows.get(item.row).filter(|row| row.set == set).map(|row| (item, row.number)))
            .collect();
        let component = channels(data);
        let channel: Vec<usize> =
            items.iter().map(|(item, row)| 3 * component.get(*row).copied().unwrap_or(0) + item.value.min(2)).collect();
        let motion_mode: Vec<&[f64]> = data
            .drivers
            .iter()
            .filter(|driver| MANNER.contains(&driver.name.as_str()))
            .map(|driver| driver.values.as_slice())
            .collect();
        let key = |(item, row): &(&SceneReading, usize), channel: usize, with_sense: bool| -> Vec<i64> {
            let Some(one) = data.observations.get(*row) else { return Vec::new() };
            let fine = |value: f64| (value * 1e3).round() as i64;
            let mut key = vec![one.setup as i64, channel as i64, one.target.map_or(-1, |target| target as i64)];
            key.extend(AXES.iter().map(|&axis| fine(one.reading.position[axis])));
            key.extend(one.reading.tool_mm.iter().map(|value| fine(*value)));
            key.extend(motion_mode.iter().map(|values| values.get(*row).map_or(0, |value| fine(*value))));
            if with_sense {
                key.extend(one.reading.state.direction.iter().map(|sense| i64::from(*sense)));
            }
            debug_assert!(item.sigma > 0.0);
            key
        };
        let group = |with_sense: bool| {
            let mut groups: BTreeMap<Vec<i64>, Vec<usize>> = BTreeMap::new();
            for (place, item) in items.iter().enumerate() {
                groups.entry(key(item, channel[place], with_sense)).or_default().push(place);
            }
            let repeated: usize = groups.values().map(Vec::len).filter(|visits| *visits >= VISITS).sum();
            (groups, 2 * repeated > items.len())
        };
        let (mut groups, mut is_repeated) = group(true);
        let has_sense = is_repeated;
        if !is_repeated {
            (groups, is_repeated) = group(false);
        }
        let mut groups: Vec<Vec<usize>> = groups.into_values().filter(|places| places.len() >= VISITS).collect();
        groups.sort_unstable();
        let spans = groups
            .iter()
            .map(|places| {
                let rows = || places.iter().map(|&place| items[place].1);
                [rows().min().unwrap_or(0), rows().max().unwrap_or(0)]
            })
            .collect();
        let count = channel.iter().max().map_or(0, |most| most + 1);
        let mut trail = Trail {
            channels: vec![ReadingTrail::default(); count],
            rows: data.observations.len(),
            blocks: blocks(spans),
            is_repeated,
            has_sense,
            begins: begins(data),
            alike: alike(data),
            noise_ratio: None,
        };
        let mut of_item = vec![usize::MAX; items.len()];
        for places in &groups {
            let Some(own) = places.first().and_then(|&place| trail.channels.get_mut(channel[place])) else { continue };
            places.iter().for_each(|&place| of_item[place] = own.groups);
            own.groups += 1;
        }
        let mut raw: Vec<Vec<f64>> = vec![Vec::new(); count];
        let mut places: Vec<Vec<usize>> = vec![Vec::new(); count];
        for ((place, (item, row)), number) in items.iter().enumerate().zip(&channel) {
            let own = &mut trail.channels[*number];
            own.at.push((*row, item.value));
            own.value.push(item.left);
            own.group.push(of_item[place]);
            own.sigma = item.sigma;
            let read = data.observations.get(*row).and_then(|one| one.values.get(item.value).copied().flatten());
            raw[*number].push(read.unwrap_or(item.left));
            places[*number].push(place);
        }
        let mut ratios = Vec::new();
        let all = trail.channels.iter_mut().zip(raw).zip(places).filter(|((own, _), _)| !own.at.is_empty());
        for ((own, raw), places) in all {
            if is_repeated && !has_sense {
                own.go_with(senses(scene, &items, &places));
            }
            let mut steps: Vec<usize> = own.at.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
            steps.sort_unstable();
            own.step = steps.get(steps.len() / 2).copied().unwrap_or(1);
            own.left = own.beside_visits(None);
            let noise = if is_repeated { noise(&own.left, 1) } else { noise(&raw, 2) };
            if let Some(noise) = noise {
                ratios.push(noise / own.sigma);
            }
            // Neighbors may be equal by chance: where runs differ by whole display steps, or where few readings repeat. The noise is not less than that of the
            // display, nor than the scatter of the repetitions as far as the uncertainty of a reading explains it.
            let is_angle = places.first().is_some_and(|&place| items[place].0.is_angle);
            let repeats = spread(own.left.iter().copied()).min(own.sigma);
            let least = display::noise(&raw, is_angle).max(repeats).max(1e-3 * own.sigma);
            own.noise = noise.unwrap_or(own.sigma).max(least);
            own.sum_up();
        }
        trail.noise_ratio = (!ratios.is_empty()).then(|| median(ratios));
        trail
    }

    /// Noise in units of the stated uncertainty.
    pub(super) fn noise_ratio(&self) -> Option<f64> {
        self.noise_ratio
    }

    /// True if a run or a direction begins within some rows of this one.
    pub(super) fn is_border(&self, row: usize, within: usize) -> bool {
        let end = self.begins.len().min(row + within + 1);
        self.begins.get(row.saturating_sub(within)..end).is_some_and(|near| near.contains(&true))
    }

    /// The block that contains a row.
    pub(super) fn block_of(&self, row: usize) -> Option<[usize; 2]> {
        self.blocks.get(self.blocks.partition_point(|block| block[1] < row)).copied().filter(|block| block[0] <= row)
    }

    /// Other rows at the same points from the same sides as a range of rows.
    pub(super) fn other_visits(&self, [first, last]: [usize; 2]) -> Vec<usize> {
        let own: std::collections::HashSet<usize> = self.alike.iter().take(last + 1).skip(first).copied().collect();
        (0..self.rows)
            .filter(|row| !(first..=last).contains(row) && self.alike.get(*row).is_some_and(|k| own.contains(k)))
            .collect()
    }

    /// Rejects rows.
    pub(super) fn forget(&mut self, [first, last]: [usize; 2]) {
        for channel in &mut self.channels {
            let range = channel.range(first, last);
            channel.left.get_mut(range.clone()).into_iter().flatten().for_each(|left| *left = f64::NAN);
            channel.value.get_mut(range).into_iter().flatten().for_each(|value| *value = f64::NAN);
            channel.sum_up();
        }
    }

    /// Rejects single readings, given in order.
    pub(super) fn forget_readings(&mut self, readings: &[(usize, usize)]) {
        for channel in &mut self.channels {
            for (at, (left, value)) in channel.at.iter().zip(channel.left.iter_mut().zip(&mut channel.value)) {
                if readings.binary_search(at).is_ok() {
                    (*left, *value) = (f64::NAN, f64::NAN);
                }
            }
            channel.sum_up();
        }
    }
}

impl ReadingTrail {
    pub(super) fn senses(&self) -> &[Vec<f64>] {
        &self.senses
    }

    /// Adds columns that are fitted to the readings as well.
    pub(super) fn go_with(&mut self, columns: Vec<Vec<f64>>) {
        self.senses.extend(columns);
        self.spanned = OnceLock::new();
    }

    /// Span of the direction terms in the used readings, which do not change.
    pub(super) fn spanned(&self, known: &[usize]) -> Arc<Upright> {
        let of_known = |column: &Vec<f64>| known.iter().map(|&k| column[k]).collect();
        let make = || Arc::new(Upright::new(&self.senses.iter().map(of_known).collect::<Vec<Vec<f64>>>()));
        self.spanned.get_or_init(make).clone()
    }

    pub(super) fn sum_up(&mut self) {
        let mut sum = (0.0, 0);
        self.sums = std::iter::once(sum)
            .chain(self.left.iter().map(|left| {
                if left.is_finite() {
                    sum = (sum.0 + left, sum.1 + 1);
                }
                sum
            }))
            .collect();
    }

    /// Indices of the readings in a range of rows.
    pub(super) fn range(&self, first: usize, last: usize) -> std::ops::Range<usize> {
        self.at.partition_point(|at| at.0 < first)..self.at.partition_point(|at| at.0 <= last)
    }

    /// End of a number of used readings from an index on.
    pub(super) fn beyond(&self, from: usize, count: usize, last: usize) -> usize {
        let counting = (from..last).filter(|&k| self.left.get(k).is_some_and(|left| left.is_finite()));
        counting.take(count).last().map_or(from, |k| k + 1)
    }

    /// Beginning of a number of used readings up to an index.
    pub(super) fn before(&self, until: usize, count: usize, first: usize) -> usize {
        let counting = (first..until).rev().filter(|&k| self.left.get(k).is_some_and(|left| left.is_finite()));
        counting.take(count).last().unwrap_or(until)
    }

    /// Mean of a range of readings and number of the used ones; `None` without used readings.
    pub(super) fn mean(&self, from: usize, to: usize) -> Option<(f64, usize)> {
        let (from, to) = (self.sums.get(from)?, self.sums.get(to)?);
        let count = to.1.checked_sub(from.1).filter(|count| *count > 0)?;
        Some(((to.0 - from.0) / count as f64, count))
    }
}

/// By row: true if a run or a direction begins with it.
fn begins(data: &DataSet) -> Vec<bool> {
    let what = |row: usize| data.observations.get(row).map(|one| (one.setup, one.run, one.reading.state.direction));
    (0..data.observations.len()).map(|row| row == 0 || what(row) != what(row - 1)).collect()
}

/// Indices that are equal for rows at the same point from the same side.
fn alike(data: &DataSet) -> Vec<usize> {
    let mut known: BTreeMap<Vec<i64>, usize> = BTreeMap::new();
    let fine = |value: f64| (value * 1e3).round() as i64;
    let mut number = |one: &crate::measure::data::Observation| {
        let position = &one.reading.position;
        let mut key: Vec<i64> = AXES
            .iter()
            .map(|&axis| {
                fine(position[axis] + if axis.is_rotary() { 0.0 } else { one.reading.tool_mm[axis.dimension()] })
            })
            .collect();
        key.extend(one.reading.state.direction.iter().map(|sense| i64::from(*sense)));
        key.push(one.target.map_or(-1, |target| target as i64));
        let count = known.len();
        *known.entry(key).or_insert(count)
    };
    data.observations.iter().map(&mut number).collect()
}

/// Noise from differences of neighbors, of the first or second order.
fn noise(values: &[f64], order: usize) -> Option<f64> {
    /// 75th percentile of the absolute values of normal noise, in standard deviations.
    const QUARTER: f64 = 1.150_349;
    const LEAST: usize = 10;
    let counting: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    let differences: Vec<f64> = if order == 1 {
        counting.windows(2).map(|pair| (pair[1] - pair[0]) / 2.0_f64.sqrt()).collect()
    } else {
        counting.windows(3).map(|three| (three[2] - 2.0 * three[1] + three[0]) / 6.0_f64.sqrt()).collect()
    };
    if differences.len() < LEAST {
        return None;
    }
    let mut sizes: Vec<f64> = differences.iter().map(|difference| difference.abs()).collect();
    let quarter = 3 * sizes.len() / 4;
    let upper = *sizes.select_nth_unstable_by(quarter, f64::total_cmp).1 / QUARTER;
    let noise = spread(differences.into_iter()).max(upper);
    (noise > 0.0).then_some(noise)
}

/// Ranges of rows covered by overlapping groups.
fn blocks(mut spans: Vec<[usize; 2]>) -> Vec<[usize; 2]> {
    spans.sort_unstable();
    let mut blocks: Vec<[usize; 2]> = Vec::new();
    for span in spans {
        match blocks.last_mut() {
            Some(block) if span[0] <= block[1] => block[1] = block[1].max(span[1]),
            _ => blocks.push(span),
        }
    }
    blocks
}

/// Terms that depend on the directions of the axes, alone and times the position along each axis, by reading: for visits that all come from another
/// side.
fn senses(scene: &Scene<'_>, items: &[(&SceneReading, usize)], places: &[usize]) -> Vec<Vec<f64>> {
    let axes = || scene.machine.axes.iter().flatten().map(|data| data.axis);
    let row = |place: usize| scene.rows.get(items[place].0.row);
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for axis in axes() {
        let sense: Vec<f64> = places.iter().map(|&place| row(place).map_or(0.0, |row| row.sense_of(axis))).collect();
        let first = sense.first().copied().unwrap_or(0.0);
        if sense.iter().all(|sense| *sense == first) {
            continue;
        }
        columns.push(sense.clone());
        for along in axes() {
            let at: Vec<f64> = places.iter().map(|&place| row(place).map_or(0.0, |row| row.position[along])).collect();
            let middle = at.iter().sum::<f64>() / at.len().max(1) as f64;
            for power in [1, 2] {
                columns.push(at.iter().zip(&sense).map(|(at, sense)| (at - middle).powi(power) * sense).collect());
            }
        }
    }
    columns
}
