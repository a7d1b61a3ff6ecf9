//! Screening of shapes over two drivers: by means over bins, and for bumps and waves by a grid.

use super::{BINS, BUMPS, Driver, Empirical, Form, KNOTS, NONE, SOME};
use crate::diagnose::score::gained;

/// Number of refinements of the period of a wave, each with half the step of the one before.
const NEARER: usize = 5;
/// Smallest share of the information on each side of a step: a single outlier is not a step.
const LEAST_SIDE: f64 = 0.03;
/// Share of the largest gain from which a period counts as equally good.
const NEARLY: f64 = 0.95;
/// Number of products that are computed exactly.
const PRODUCTS: usize = 24;

impl Empirical {
    /// Adds forms of two drivers, by sums of all rows and of the binned ones.
    pub(super) fn forms(
        &self,
        (a, b): (usize, usize),
        (sums, binned): (&[[f64; 2]], &[[f64; 2]]),
        price: f64,
        out: &mut Vec<(f64, Form)>,
    ) {
        let [Some(one), Some(other)] = [self.drivers.get(a), self.drivers.get(b)] else { return };
        let mut cells = vec![[0.0; 2]; BINS * BINS];
        for ((&x, &y), sum) in one.bins.iter().zip(&other.bins).zip(binned) {
            if x != NONE
                && y != NONE
                && let Some(cell) = cells.get_mut(usize::from(x) * BINS + usize::from(y))
            {
                cell[0] += sum[0];
                cell[1] += sum[1];
            }
        }
        let add = |[s, i]: [f64; 2], [t, j]: [f64; 2]| [s + t, i + j];
        let worth = |parts: &[[f64; 2]]| -> f64 {
            parts.iter().filter(|part| part[1] > 0.0).map(|[sum, information]| sum * sum / information - price).sum()
        };
        let cell = |x: usize, y: usize| cells.get(x * BINS + y).copied().unwrap_or_default();
        if a == b {
            if one.is_sense {
                return;
            }
            let all: Vec<[f64; 2]> = (0..BINS).map(|x| cell(x, x)).collect();
            for knots in KNOTS {
                let merged = merge(&all, knots);
                out.push((worth(&merged), Form::Smooth(a, knots)));
            }
            out.extend(one.step(sums).map(|(gain, edge)| (gain - price, Form::Step(a, edge))));
            return;
        }
        for (first, second, turned) in [(a, b, false), (b, a, true)] {
            let [Some(one), Some(other)] = [self.drivers.get(first), self.drivers.get(second)] else { continue };
            let at = |x: usize, y: usize| if turned { cell(y, x) } else { cell(x, y) };
            if one.is_sense {
                let odd: Vec<[f64; 2]> = (0..BINS)
                    .map(|y| {
                        let (plus, minus) = (at(BINS - 1, y), at(0, y));
                        [plus[0] - minus[0], plus[1] + minus[1]]
                    })
                    .collect();
                if !other.is_sense {
                    for knots in KNOTS {
                        out.push((worth(&merge(&odd, knots)), Form::Sense(first, second, knots)));
                    }
                }
                continue;
            }
            if other.is_sense {
                continue;
            }
            for edge in 1..BINS {
                for (side, range) in [(1.0, edge..BINS), (-1.0, 0..edge)] {
                    let over: Vec<[f64; 2]> =
                        (0..BINS).map(|y| range.clone().map(|x| at(x, y)).fold([0.0; 2], add)).collect();
                    for knots in KNOTS {
                        out.push((
                            worth(&merge(&over, knots)),
                            Form::Beyond(first, second, knots, one.edge(edge), side),
                        ));
                    }
                }
            }
        }
        if one.is_sense || other.is_sense {
            return;
        }
        let share = |k: usize| (k as f64 + 0.5) / BINS as f64 - 0.5;
        // The origin of a product is arbitrary, so each driver alone is added.
        let (mut products, mut left) = (vec![0.0; 9], vec![0.0; 3]);
        for x in 0..BINS {
            for y in 0..BINS {
                let (at, shapes) = (cell(x, y), [share(x) * share(y), share(x), share(y)]);
                for (k, shape) in shapes.iter().enumerate() {
                    left[k] += at[0] * shape;
                    shapes.iter().enumerate().for_each(|(l, other)| products[3 * k + l] += at[1] * shape * other);
                }
            }
        }
        let gain = gained(products, left);
        out.push((gain.squares - gain.rank as f64 * price, Form::Product(a, b)));
        for knots in [3, 4, 6] {
            let rows: Vec<Vec<[f64; 2]>> =
                (0..BINS).map(|x| merge(&(0..BINS).map(|y| cell(x, y)).collect::<Vec<_>>(), knots)).collect();
            let columns = (0..knots).flat_map(|y| {
                let column: Vec<[f64; 2]> = rows.iter().map(|row| row.get(y).copied().unwrap_or_default()).collect();
                merge(&column, knots)
            });
            out.push((worth(&columns.collect::<Vec<_>>()), Form::Surface(a, b, knots)));
        }
    }

    /// Computes the best products again from the values themselves: bins cannot separate correlated temperatures.
    pub(super) fn products(&self, sums: &[[f64; 2]], price: f64, all: &mut [(f64, Form)]) {
        let is_product = |(_, form): &&mut (f64, Form)| matches!(form, Form::Product(..));
        let mut products: Vec<&mut (f64, Form)> = all.iter_mut().filter(is_product).collect();
        products.sort_by(|one, other| other.0.total_cmp(&one.0));
        let step = (sums.len() / SOME).max(1);
        for (worth, form) in products.into_iter().take(PRODUCTS) {
            let Form::Product(a, b) = *form else { continue };
            let [Some(one), Some(other)] = [self.drivers.get(a), self.drivers.get(b)] else { continue };
            let rows = one.values.iter().zip(other.values.iter()).zip(sums).zip(&self.setups).step_by(step);
            let shapes = rows.filter_map(|(((x, y), sum), setup)| {
                let [x, y] = [one.share(*x), other.share(*y)];
                (sum[1] > 0.0 && x.is_finite() && y.is_finite()).then_some((*setup, *sum, [x * y, x, y]))
            });
            let shapes: Vec<(usize, [f64; 2], [f64; 3])> = shapes.collect();
            // A set-up absorbs the mean.
            let mut means = vec![[0.0; 4]; self.setup_count];
            for (setup, sum, shapes) in &shapes {
                if let Some(mean) = means.get_mut(*setup) {
                    mean.iter_mut().zip(shapes.iter().chain(&[1.0])).for_each(|(mean, shape)| *mean += sum[1] * shape);
                }
            }
            let (mut squares, mut left) = (vec![0.0; 9], vec![0.0; 3]);
            for (setup, sum, shapes) in shapes {
                let Some(mean) = means.get(setup) else { continue };
                let own = [0, 1, 2].map(|k| shapes[k] - mean[k] / mean[3]);
                for (k, shape) in own.iter().enumerate() {
                    left[k] += sum[0] * shape;
                    own.iter().enumerate().for_each(|(l, other)| squares[3 * k + l] += sum[1] * shape * other);
                }
            }
            let gain = gained(squares, left);
            *worth = gain.squares * step as f64 - gain.rank as f64 * price;
        }
    }

    /// A bump over two lengths: the best one of a grid, then refined.
    pub(super) fn bumps(&self, sums: &[[f64; 2]], price: f64, out: &mut Vec<(f64, Form)>) {
        let lengths: Vec<usize> =
            (0..self.drivers.len()).filter(|&k| self.drivers.get(k).is_some_and(|driver| driver.is_length)).collect();
        for (place, &a) in lengths.iter().enumerate() {
            for &b in lengths.iter().skip(place + 1) {
                let [Some(one), Some(other)] = [self.drivers.get(a), self.drivers.get(b)] else { continue };
                if one.name == other.name {
                    continue;
                }
                let step = (sums.len() / SOME).max(1);
                let rows: Vec<[f64; 4]> = one
                    .values
                    .iter()
                    .zip(other.values.iter())
                    .zip(sums)
                    .filter(|(_, sum)| sum[1] > 0.0)
                    .map(|((x, y), sum)| [*x, *y, sum[0], sum[1]])
                    .collect();
                let worth = |at: [f64; 2], wide: f64, step: usize| {
                    let (mut sum, mut information) = (0.0, 1e-300);
                    for [x, y, own, known] in rows.iter().step_by(step) {
                        let far = ((x - at[0]).powi(2) + (y - at[1]).powi(2)) / (2.0 * wide * wide);
                        if far < 12.0 {
                            let shape = (-far).exp();
                            sum += own * shape;
                            information += known * shape * shape;
                        }
                    }
                    sum * sum / information * step as f64
                };
                let range = (one.high - one.low).min(other.high - other.low);
                if range < 1.0 {
                    continue;
                }
                let mut best = (0.0, [0.0; 2], 1.0);
                for wide in [range / 12.0, range / 6.0] {
                    for x in 0..BUMPS {
                        for y in 0..BUMPS {
                            let share = |k: usize| (k as f64 + 0.5) / BUMPS as f64;
                            let at = [
                                one.low + (one.high - one.low) * share(x),
                                other.low + (other.high - other.low) * share(y),
                            ];
                            let own = worth(at, wide, 4 * step);
                            if own > best.0 {
                                best = (own, at, wide);
                            }
                        }
                    }
                }
                let mut reach = range / 12.0;
                best.0 = worth(best.1, best.2, step);
                for _ in 0..5 {
                    for (dx, dy, factor) in [
                        (1.0, 0.0, 1.0),
                        (-1.0, 0.0, 1.0),
                        (0.0, 1.0, 1.0),
                        (0.0, -1.0, 1.0),
                        (0.0, 0.0, 1.25),
                        (0.0, 0.0, 0.8),
                    ] {
                        let (at, wide) = ([best.1[0] + dx * reach, best.1[1] + dy * reach], best.2 * factor);
                        let own = worth(at, wide, step);
                        if own > best.0 {
                            best = (own, at, wide);
                        }
                    }
                    reach *= 0.6;
                }
                out.push((best.0 - 4.0 * price, Form::Bump(a, b, best.1, best.2)));
            }
        }
    }

    /// Waves of a length, only above or below an edge of the feed.
    pub(super) fn waves(&self, sums: &[[f64; 2]], price: f64, out: &mut Vec<(f64, Form)>) {
        let Some(a) = self.drivers.iter().position(|driver| driver.name == "feed_mm_min") else { return };
        let Some(feed) = self.drivers.get(a) else { return };
        // Only used readings determine the feeds between which it begins.
        let in_use = feed.values.iter().zip(sums).filter(|(value, sum)| value.is_finite() && sum[1] > 0.0);
        let mut feeds: Vec<f64> = in_use.map(|(value, _)| *value).collect();
        feeds.sort_by(f64::total_cmp);
        feeds.dedup();
        if feeds.len() > 6 {
            return;
        }
        for (b, driver) in self.drivers.iter().enumerate().filter(|(_, driver)| driver.is_length) {
            let Some(sweep) = &driver.sweep else { continue };
            for pair in feeds.windows(2) {
                let edge = f64::midpoint(pair[0], pair[1]);
                for side in [1.0, -1.0] {
                    let is_in = |value: &f64| side * (value - edge) > 0.0;
                    let products: Vec<f64> = sums
                        .iter()
                        .zip(feed.values.iter())
                        .map(|(sum, value)| if is_in(value) { sum[0] } else { 0.0 })
                        .collect();
                    let known: Vec<f64> = sums
                        .iter()
                        .zip(feed.values.iter())
                        .map(|(sum, value)| if is_in(value) { sum[1] } else { 0.0 })
                        .collect();
                    let information: f64 = known.iter().sum();
                    let worth = |period: f64| {
                        let (mut sines, mut cosines) = (0.0, 0.0);
                        for (product, value) in
                            products.iter().zip(driver.values.iter()).filter(|(own, _)| **own != 0.0)
                        {
                            let (sine, cosine) = (std::f64::consts::TAU * value / period).sin_cos();
                            sines += product * sine;
                            cosines += product * cosine;
                        }
                        2.0 * (sines * sines + cosines * cosines) / information.max(1e-300)
                    };
                    // With evenly spaced readings a shorter wave is an alias of a longer one.
                    let peaks = sweep.peaks(&products, &known, NEARLY);
                    let Some(mut period) = peaks.into_iter().max_by(f64::total_cmp) else { continue };
                    let mut most = worth(period);
                    if most <= 2.0 * price {
                        continue;
                    }
                    // Refined in halves of the resolution of the transform.
                    let mut reach = period * period / sweep.travel() / 8.0;
                    for _ in 0..NEARER {
                        for near in [period - reach, period + reach] {
                            let own = worth(near);
                            if own > most {
                                (period, most) = (near, own);
                            }
                        }
                        reach *= 0.5;
                    }
                    let worth = most;
                    out.push((worth - 2.0 * price, Form::Wave(a, b, edge, side, period)));
                }
            }
        }
    }
}

impl Driver {
    /// Position of a value in the range, 0 in the middle.
    fn share(&self, value: f64) -> f64 {
        (value - f64::midpoint(self.low, self.high)) / (self.high - self.low)
    }

    /// The gain and the edge of the best step in addition to a mean; the edge is midway between two values.
    fn step(&self, sums: &[[f64; 2]]) -> Option<(f64, f64)> {
        let in_use = |row: &u32| {
            let (value, sum) = (self.values.get(*row as usize)?, sums.get(*row as usize)?);
            (sum[1] > 0.0).then_some((*value, *sum))
        };
        let add = |[s, i]: [f64; 2], [t, j]: [f64; 2]| [s + t, i + j];
        let whole = self.order.iter().filter_map(in_use).map(|(_, sum)| sum).fold([0.0; 2], add);
        let mut below = [0.0; 2];
        let mut last = f64::NAN;
        let mut best: Option<(f64, f64)> = None;
        for (value, sum) in self.order.iter().filter_map(in_use) {
            let above = whole[1] - below[1];
            if value > last && below[1].min(above) > LEAST_SIDE * whole[1] {
                let own = below[0] - whole[0] * below[1] / whole[1];
                let gain = own * own * whole[1] / (below[1] * above);
                if best.is_none_or(|(most, _)| gain > most) {
                    best = Some((gain, f64::midpoint(last, value)));
                }
            }
            below = add(below, sum);
            last = value;
        }
        best
    }
}

/// Keeps only the best form of each kind, from an index on.
pub(super) fn best_of_each(all: &mut Vec<(f64, Form)>, from: usize) {
    let mut own = all.split_off(from.min(all.len()));
    own.sort_by(|one, other| other.0.total_cmp(&one.0));
    let mut kinds = Vec::new();
    own.retain(|(worth, form)| {
        let kind = std::mem::discriminant(form);
        let is_new = *worth > 0.0 && !kinds.contains(&kind);
        kinds.push(kind);
        is_new
    });
    all.extend(own);
}

fn merge(all: &[[f64; 2]], count: usize) -> Vec<[f64; 2]> {
    let mut out = vec![[0.0; 2]; count];
    for (k, part) in all.iter().enumerate() {
        if let Some(sum) = out.get_mut(k * count / all.len().max(1)) {
            sum[0] += part[0];
            sum[1] += part[1];
        }
    }
    out
}

#[cfg(test)]
mod tests;
