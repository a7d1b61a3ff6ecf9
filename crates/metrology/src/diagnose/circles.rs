//! Chords and lobes of circles: the numbers that explain most of the residual. Numbers that evenly spaced angles cannot distinguish from smaller ones are
//! excluded.

use std::collections::HashMap;

use super::cause::{Values, circle};
use super::row::SceneRow;
use super::scene::Scene;
use super::seek::SOME;

/// Number of consecutive rows that are kept together in a sample.
const STRETCH: usize = 50;
/// Range of tested numbers of chords.
const CHORDS: std::ops::Range<u32> = 24..720;
/// Range of tested numbers of lobes. Fewer lobes are errors of the axes. Three are tested only as one wave for all planes.
const LOBES: std::ops::Range<u32> = 4..60;
const ALIKE_FROM: u32 = 3;
/// A number of cycles is indistinguishable from zero if the mean of exp(i n φ) exceeds this.
const ALIKE: f64 = 0.95;

/// A sample of the rows on circles.
#[derive(Clone, Debug)]
pub(super) struct Circles {
    /// Places on circles, of all rows.
    pub(super) places: circle::Places,
    rows: Vec<usize>,
    /// Numbers of chords that the angles distinguish from smaller ones.
    counts: std::ops::Range<u32>,
    /// For each number of chords: distance of the chord from the circle at each row, relative to the mean of the set-up, mm.
    chords: Vec<Vec<f64>>,
    /// For each row: the plane, given by the direction that stands still, and the angle, rad.
    angles: Vec<(usize, f64)>,
    /// Planes that occur.
    planes: Vec<usize>,
    /// Upper limit of the number of lobes.
    most: u32,
}

/// A candidate for lobes of circles.
#[derive(Clone, Debug)]
pub(super) struct Lobes {
    /// Planes that have these lobes, given by the direction that stands still.
    pub(super) planes: Vec<usize>,
    pub(super) count: u32,
    /// True if all planes have the same lobes.
    pub(super) are_alike: bool,
}

impl Circles {
    pub(super) fn new(scene: &Scene<'_>) -> Option<Circles> {
        let all = circle::places(scene)?;
        let circle::Places { angles, radii, planes } = &all;
        let at = |values: &Values, row: &SceneRow| {
            values.get(row.set).and_then(|own| own.get(row.number)).copied().unwrap_or(f64::NAN)
        };
        let places: Vec<(usize, f64, f64)> = scene
            .rows
            .iter()
            .enumerate()
            .map(|(place, row)| (place, at(angles, row), at(radii, row)))
            .filter(|(_, angle, radius)| angle.is_finite() && radius.is_finite())
            .enumerate()
            // Consecutive rows are kept together: every n-th row alone would alias numbers of chords.
            .filter(|(count, _)| (count / STRETCH).is_multiple_of((scene.rows.len() / SOME).max(1)))
            .map(|(_, place)| place)
            .collect();
        // Lengths may be unknowns of set-ups, so the mean over a circle carries no information.
        let mut numbers: HashMap<(usize, usize), usize> = HashMap::new();
        let mut setup = |place: usize| {
            let next = numbers.len();
            *numbers.entry(scene.rows.get(place).map_or((0, 0), |row| (row.set, row.setup))).or_insert(next)
        };
        let setups: Vec<usize> = places.iter().map(|one| setup(one.0)).collect();
        let most = told(places.iter().map(|(_, angle, _)| *angle));
        let counts = CHORDS.start..CHORDS.end.min(most);
        let chords = counts
            .clone()
            .map(|count| {
                let within = |(_, angle, radius): &(usize, f64, f64)| radius * circle::chord(*angle, count);
                let mut means = vec![(0.0, 0.0); numbers.len()];
                for (one, &setup) in places.iter().zip(&setups) {
                    let mean: &mut (f64, f64) = &mut means[setup];
                    *mean = (mean.0 + within(one), mean.1 + 1.0);
                }
                let mean = |(sum, count): (f64, f64)| sum / count;
                places.iter().zip(&setups).map(|(one, &setup)| within(one) - mean(means[setup])).collect()
            })
            .collect();
        let angles: Vec<(usize, f64)> = places
            .iter()
            .map(|&(place, angle, _)| (scene.rows.get(place).map_or(0, |row| at(planes, row) as usize), angle))
            .collect();
        let mut planes: Vec<usize> = angles.iter().map(|(plane, _)| *plane).collect();
        planes.sort_unstable();
        planes.dedup();
        let rows = places.into_iter().map(|(place, ..)| place).collect();
        Some(Circles { places: all, rows, counts, chords, angles, planes, most: LOBES.end.min(most) })
    }

    /// Number of these candidates.
    pub(super) fn count(&self) -> usize {
        let lobes = |from: u32| self.most.saturating_sub(from) as usize;
        let of_all = if self.planes.len() > 1 { lobes(LOBES.start) + lobes(ALIKE_FROM) } else { 0 };
        self.counts.len() + self.planes.len() * lobes(LOBES.start) + of_all
    }

    /// Returns the number of lobes that explains most, for each plane and for all planes together.
    pub(super) fn best_lobes(&self, sums: &[f64], information: &[f64]) -> Vec<Lobes> {
        let of_plane = |plane: usize, count: u32| {
            let mut wave = Wave::default();
            for (&row, (_, angle)) in self.rows.iter().zip(&self.angles).filter(|(_, (own, _))| *own == plane) {
                let [sum, known] = [sums, information].map(|all| all.get(row).copied().unwrap_or(0.0));
                wave.add(f64::from(count) * angle, sum, known);
            }
            wave
        };
        let all: Vec<Vec<Wave>> = (ALIKE_FROM..self.most.max(ALIKE_FROM))
            .map(|count| self.planes.iter().map(|&plane| of_plane(plane, count)).collect())
            .collect();
        let best = |from: u32, gain: &dyn Fn(&[Wave]) -> f64| {
            let counts = (ALIKE_FROM..).zip(&all).filter(|(count, _)| *count >= from);
            let gains = counts.map(|(count, waves)| (gain(waves), count)).max_by(|a, b| a.0.total_cmp(&b.0));
            gains.filter(|(gain, _)| *gain > 0.0).map(|(_, count)| count)
        };
        let mut out = Vec::new();
        for (k, &plane) in self.planes.iter().enumerate() {
            let count = best(LOBES.start, &|waves| waves.get(k).map_or(0.0, Wave::gain));
            out.extend(count.map(|count| Lobes { planes: vec![plane], count, are_alike: true }));
        }
        if self.planes.len() > 1 {
            let of = |count, are_alike| Lobes { planes: self.planes.clone(), count, are_alike };
            out.extend(best(ALIKE_FROM, &|waves| Wave::sum(waves).gain()).map(|count| of(count, true)));
            out.extend(best(LOBES.start, &|waves| waves.iter().map(Wave::gain).sum()).map(|count| of(count, false)));
        }
        out
    }

    /// Returns the number of chords that explains most. The shape has no free amount: the number of chords defines it.
    pub(super) fn best(&self, sums: &[f64], information: &[f64]) -> Option<u32> {
        let of = |values: &[f64]| -> Vec<f64> {
            self.rows.iter().map(|&row| values.get(row).copied().unwrap_or(0.0)).collect()
        };
        let (sums, information) = (of(sums), of(information));
        let gain = |shape: &[f64]| -> f64 {
            let each = shape.iter().zip(sums.iter().zip(&information));
            each.map(|(shape, (sum, information))| shape * (2.0 * sum - information * shape)).sum()
        };
        let gains = self.counts.clone().zip(&self.chords).map(|(count, shape)| (gain(shape), count));
        gains.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(gain, _)| *gain > 0.0).map(|(_, count)| count)
    }
}

/// Normal equations of a cosine and a sine: products with the residual, and with each other.
#[derive(Clone, Copy, Debug, Default)]
struct Wave {
    right: [f64; 2],
    matrix: [f64; 3],
}

impl Wave {
    fn add(&mut self, angle: f64, sum: f64, information: f64) {
        let (sine, cosine) = angle.sin_cos();
        let parts = [cosine * cosine, sine * sine, sine * cosine];
        self.right = [self.right[0] + sum * cosine, self.right[1] + sum * sine];
        self.matrix = [0, 1, 2].map(|k| self.matrix[k] + information * parts[k]);
    }

    fn sum(all: &[Wave]) -> Wave {
        all.iter().fold(Wave::default(), |sum, one| Wave {
            right: [0, 1].map(|k| sum.right[k] + one.right[k]),
            matrix: [0, 1, 2].map(|k| sum.matrix[k] + one.matrix[k]),
        })
    }

    fn gain(&self) -> f64 {
        let Wave { right: [one, other], matrix: [own, of_other, mixed] } = *self;
        let told = own * of_other - mixed * mixed;
        if told <= 0.0 {
            return 0.0;
        }
        (one * one * of_other - 2.0 * one * other * mixed + other * other * own) / told
    }
}

/// Smallest number of cycles on a circle that the angles (rad) cannot distinguish from fewer: half of the first number that is indistinguishable from zero.
fn told(angles: impl Iterator<Item = f64> + Clone) -> u32 {
    let count = angles.clone().count() as f64;
    let is_like_none = |cycles: &u32| {
        let each = angles.clone().map(|angle| (f64::from(*cycles) * angle).sin_cos());
        let (real, imaginary) = each.fold((0.0, 0.0), |sum, (sine, cosine)| (sum.0 + cosine, sum.1 + sine));
        real.hypot(imaginary) > ALIKE * count
    };
    (1..2 * CHORDS.end).find(is_like_none).map_or(CHORDS.end, |cycles| cycles / 2)
}
