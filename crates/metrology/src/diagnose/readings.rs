//! Readings that are included, and their residuals after the set-up unknowns.

use std::collections::BTreeMap;

use super::far::drop_far;
use super::fold::counts;
use super::noise::is_angle;
use super::scene::{NO_ROW, Scene};
use super::search::{Field, Weights};

/// Minimum number of readings that determine the noise of a file.
pub(super) const FEW: usize = 20;
/// Files whose noise differs by more than this factor are weighted separately.
const UNLIKE: f64 = 2.5;

/// Weights of the measurements that are used, and of those held out.
pub(super) fn weights(scene: &Scene<'_>, used: usize) -> (Weights, Weights) {
    let rows = scene.rows.len();
    let series = |item: &super::scene::SceneReading| {
        // Each value of a row forms its own series, and so does every known distance.
        scene.rows.get(item.row).map_or(usize::MAX, |row| row.series * 3 + item.value)
    };
    let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
    let mut ties = 0;
    let series: Vec<usize> = scene
        .items
        .iter()
        .map(|item| {
            let own = if item.row == NO_ROW {
                ties += 1;
                3 * rows + ties
            } else {
                series(item)
            };
            let count = numbers.len();
            *numbers.entry(own).or_insert(count)
        })
        .collect();
    // Known distances are included in both groups.
    let of = |is_used: bool| Weights {
        items: scene
            .items
            .iter()
            .map(|item| {
                let counts = scene.rows.get(item.row).is_none_or(|row| (row.set < used) == is_used);
                if counts { 1.0 / item.sigma } else { 0.0 }
            })
            .collect(),
        series: series.clone(),
    };
    (of(true), of(false))
}

/// Residuals after the set-up unknowns, mm or rad; 0 for excluded readings.
pub(super) fn projected(field: &Field<'_, '_>, weights: &Weights, values: &[f64]) -> Vec<f64> {
    let mut series = field.series(weights, &[], 0.0);
    series.set_values(values);
    series
        .left()
        .iter()
        .zip(&weights.items)
        .map(|(left, weight)| if *weight > 0.0 { left / weight } else { 0.0 })
        .collect()
}

/// Residuals after some candidates, mm or rad.
pub(super) fn left_of(field: &Field<'_, '_>, weights: &Weights, taken: &[usize]) -> Vec<f64> {
    let series = field.series(weights, taken, 0.0);
    series
        .left()
        .iter()
        .zip(&weights.items)
        .map(|(left, weight)| if *weight > 0.0 { left / weight } else { 0.0 })
        .collect()
}

/// Weights the readings by the noise of their files, from consecutive readings, if the noise of files differs more than stated.
pub(super) fn even_out(scene: &Scene<'_>, weights: &mut Weights, left: &[f64]) {
    let mut series: BTreeMap<(usize, usize), Vec<f64>> = BTreeMap::new();
    for place in counts(scene, weights) {
        let own = scene.items.get(place).and_then(|item| scene.rows.get(item.row)).map(|row| row.set);
        if let (Some(set), Some(left), Some(weight)) = (own, left.get(place), weights.items.get(place)) {
            series.entry((set, weights.series.get(place).copied().unwrap_or(0))).or_default().push(left * weight);
        }
    }
    let mut noise: Vec<Option<f64>> = Vec::new();
    for set in 0..scene.sets.len() {
        let own = series.iter().filter(|((of, _), _)| *of == set);
        let mut steps: Vec<f64> = own
            .flat_map(|(_, left)| left.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect::<Vec<_>>())
            .collect();
        let middle = steps.len() / 2;
        noise.push((steps.len() >= FEW).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1));
    }
    let mut known: Vec<f64> = noise.iter().copied().flatten().filter(|noise| *noise > 0.0).collect();
    known.sort_by(f64::total_cmp);
    let (Some(least), Some(most)) = (known.first(), known.last()) else { return };
    if *most < UNLIKE * least {
        return;
    }
    let usual = known[known.len() / 2];
    for (item, weight) in scene.items.iter().zip(&mut weights.items) {
        let own = scene.rows.get(item.row).and_then(|row| noise.get(row.set).copied().flatten());
        if let Some(own) = own.filter(|own| *own > 0.0) {
            *weight *= usual / own;
        }
    }
}

/// Effect of a candidate on the included readings after the set-up unknowns, with the amounts fitted together with the other terms.
pub(super) fn doing(
    field: &Field<'_, '_>,
    train: &Weights,
    weights: &Weights,
    taken: &[usize],
    number: usize,
) -> Vec<f64> {
    let mut values = field.left_with(train, taken);
    let mut columns = Vec::new();
    let mut place = 0..0;
    for &own in taken {
        let of = field.columns_of(own);
        if own == number {
            place = columns.len()..columns.len() + of.len();
        }
        columns.extend(of);
    }
    let (amounts, _) = field.series(train, &[], 0.0).amounts(&columns);
    values.iter_mut().for_each(|value| *value = 0.0);
    for (column, amount) in columns.iter().zip(&amounts).skip(place.start).take(place.len()) {
        values.iter_mut().zip(column).for_each(|(value, part)| *value += part * amount);
    }
    projected(field, weights, &values)
}

/// RMS; 0 for no values.
pub(super) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0_f64), |(sum, count), value| (sum + value * value, count + 1.0));
    (sum / count.max(1.0)).sqrt()
}

/// Returns the number of included readings of the measurements used, and the number of identifiable set-up unknowns.
#[must_use]
pub fn freedom_of(scene: &Scene<'_>, used: usize) -> [usize; 2] {
    let (weights, _) = weights(scene, used);
    let field = Field::bare(scene);
    let of_rows = counts(scene, &weights).len();
    [of_rows, field.series(&weights, &[], 0.0).rank()]
}

/// Residuals of two models, RMS, for the measurements used and for those held out; `None` without readings. They are those of the lengths, mm; without
/// lengths those of the angles, rad. Both models are compared on the same readings: outliers of the `explained` residuals (mm or rad) are excluded.
#[must_use]
pub fn residuals(models: [&Scene<'_>; 2], used: usize, explained: &[f64]) -> [Option<[f64; 2]>; 2] {
    let [scene, _] = models;
    let field = Field::bare(scene);
    let (used, held_out) = weights(scene, used);
    [used, held_out].map(|mut weights| {
        let left = projected(&field, &weights, explained);
        let unknowns = field.series(&weights, &[], 0.0).rank();
        drop_far(scene, &mut weights, (&left, unknowns));
        // Angles among lengths have another unit.
        let of_angles = is_angle(scene);
        let is_shown = |place: &usize| scene.items.get(*place).is_some_and(|item| item.is_angle == of_angles);
        let places: Vec<usize> = counts(scene, &weights).into_iter().filter(is_shown).collect();
        let of = |model: &Scene<'_>| {
            let values: Vec<f64> = model.items.iter().map(|item| item.left).collect();
            let left = projected(&field, &weights, &values);
            rms(places.iter().filter_map(|&place| left.get(place).copied()))
        };
        (!places.is_empty()).then(|| models.map(of))
    })
}

/// Residuals of two models of one scene after the set-ups, for the measurements used and for those held out: RMS in units of the uncertainty of each
/// reading, so that lengths and angles have equal weights. Both models are compared on the same readings. A reading is excluded only if it is an
/// outlier with both models, because an error of a single axis makes its readings outliers until the model contains it.
#[must_use]
pub fn levels(scenes: [&Scene<'_>; 2], used: usize) -> [[f64; 2]; 2] {
    let fields = scenes.map(Field::bare);
    let all = |k: usize| -> Vec<f64> { scenes[k].items.iter().map(|item| item.left).collect() };
    let (own, held_out) = weights(scenes[0], used);
    let by_part = [own, held_out].map(|mut weights| {
        let without_far = [0, 1].map(|k| {
            let mut own = weights.clone();
            let left = projected(&fields[k], &own, &all(k));
            let unknowns = fields[k].series(&own, &[], 0.0).rank();
            drop_far(scenes[k], &mut own, (&left, unknowns));
            own
        });
        for (place, weight) in weights.items.iter_mut().enumerate() {
            if without_far.iter().all(|own| own.items.get(place) == Some(&0.0)) {
                *weight = 0.0;
            }
        }
        [0, 1].map(|k| {
            let left = projected(&fields[k], &weights, &all(k));
            let of = |place: usize| Some(left.get(place)? * weights.items.get(place)?);
            rms(counts(scenes[k], &weights).into_iter().filter_map(of))
        })
    });
    let [own, held_out] = by_part;
    [0, 1].map(|k| [own[k], held_out[k]])
}
