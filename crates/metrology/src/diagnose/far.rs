//! Outliers: readings that are too far from all others for their number.
//!
//! The largest of many normal readings is far out too: of 15 readings one is beyond 3.3 σ with a probability of 1.4 %, of 20,000 with 100 %. And the median of a
//! few residuals is an uncertain spread, which a fit with many unknowns makes too small. So a reading is an outlier only if it is far by the spread, and if
//! Student's t of its deletion residual is significant for the number of readings (Grubbs 1969; Bonferroni).
//!
//! If a display shows most readings as one number, their median spread is zero, and every other reading would be far. So the spread of a file is not less
//! than that of its display steps.

use super::fold::counts;
use super::noise::MEDIAN;
use super::readings::FEW;
use super::scene::Scene;
use super::search::Weights;
use crate::measure::display;
use ncfix_base::numeric::fisher;

/// An outlier is beyond this multiple of the spread.
pub const FAR: f64 = 6.0;
/// Probability of excluding any reading of a file if all are normal.
const CHANCE: f64 = 0.01;

/// Excludes outliers within each file, by the residuals after a fit of this number of unknowns. Returns true if there were any.
pub(super) fn drop_far(scene: &Scene<'_>, weights: &mut Weights, (left, unknowns): (&[f64], usize)) -> bool {
    let places = counts(scene, weights);
    let size = |place: &usize| match (left.get(*place), weights.items.get(*place)) {
        (Some(left), Some(weight)) => (left * weight).abs(),
        _ => 0.0,
    };
    let middle = |mut sizes: Vec<f64>| {
        let middle = sizes.len() / 2;
        if sizes.is_empty() { 0.0 } else { *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN }
    };
    let whole = middle(places.iter().map(size).collect());
    let set = |place: usize| Some(scene.rows.get(scene.items.get(place)?.row)?.set);
    // RMS noise of the display steps of each file, lengths and angles, relative to the uncertainty of its readings.
    let steps: Vec<[f64; 2]> =
        scene.sets.iter().map(|set| [false, true].map(|is_angle| display::noise_of(set, is_angle))).collect();
    let least = |place: &usize| {
        let of_set = set(*place).and_then(|number| steps.get(number));
        let step = of_set.zip(scene.items.get(*place)).map_or(0.0, |(steps, item)| steps[usize::from(item.is_angle)]);
        step * weights.items.get(*place).copied().unwrap_or(0.0)
    };
    // Share of the readings that the unknowns do not take up.
    let free = 1.0 - unknowns as f64 / places.len().max(1) as f64;
    let mut far = Vec::new();
    for number in 0..scene.sets.len() {
        let own_places: Vec<usize> = places.iter().copied().filter(|&place| set(place) == Some(number)).collect();
        // The noise of a few readings is not determined; noise levels that differ by less are equal.
        let (spread, others) = if own_places.len() < FEW {
            (whole, places.iter().map(size).collect::<Vec<f64>>())
        } else {
            let own: Vec<f64> = own_places.iter().map(size).collect();
            (middle(own.clone()), own)
        };
        let spread = own_places.iter().map(&least).fold(spread, f64::max);
        let rest: Vec<f64> = others.iter().copied().filter(|size| *size <= FAR * spread).collect();
        let freedom = free * rest.len() as f64;
        let variance = rest.iter().map(|size| size * size).sum::<f64>() / freedom;
        let is_significant = |size: f64| {
            // Without a spread of the others, every difference is significant.
            freedom > 0.0
                && (variance <= 0.0
                    || fisher::exceeded(size * size / variance, 1.0, freedom) * others.len() as f64 <= CHANCE)
        };
        far.extend(own_places.into_iter().filter(|place| size(place) > FAR * spread && is_significant(size(place))));
    }
    far.iter().for_each(|&place| {
        if let Some(weight) = weights.items.get_mut(place) {
            *weight = 0.0;
        }
    });
    !far.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    /// Places that are excluded of these residuals, µm, after a fit of two unknowns.
    fn excluded(um: &[f64]) -> Vec<usize> {
        let machine = bench::machine();
        let sets = [bench::reads_along_x(&machine, um)];
        let scene = bench::scene(&machine, &sets);
        let mut weights = bench::even(&scene);
        drop_far(&scene, &mut weights, (um, 2));
        (0..um.len()).filter(|&place| weights.items[place] == 0.0).collect()
    }

    #[test]
    fn the_largest_of_a_few_readings_is_no_outlier_and_a_gross_error_is() {
        // 15 readings whose median magnitude is 0.3: 6 times the spread is 2.7.
        let quiet = [0.3, -0.2, 0.1, -0.3, 0.25, 1.6, -1.7, 0.2, -0.3, 0.3, -1.4, 1.2, -0.1, 0.9];
        let with = |size: f64| quiet.iter().copied().chain([size]).collect::<Vec<f64>>();
        // Sum of squares of the others 10.1825 with 14 · 13/15 degrees of freedom: s = 0.916. Student's t of 3.3 is 3.60, of 6.2 is 6.77: two-sided, times
        // 15 readings, 5.4 % and 0.03 %.
        assert_eq!(excluded(&with(3.3)), [0; 0]);
        assert_eq!(excluded(&with(6.2)), [14]);
    }

    #[test]
    fn readings_that_agree_exactly_leave_one_out() {
        let mut um = [0.0; 12];
        um[4] = 1.0;
        assert_eq!(excluded(&um), [4]);
    }
}
