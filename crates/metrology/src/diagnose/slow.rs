//! Significance of the findings against slowly varying noise, by the likelihood. The noise is estimated again for every set of terms.
//!
//! Many terms together can follow slow noise; their residual then looks white, and each looks significant given the others. Here terms are added one by one,
//! the most significant first. The residual may be the sum of white noise and a slow process (first-order autoregressive; near 1 it is a random walk). A term
//! that explains all slow variation removes this process and gains much. A term that follows it only in part gains as much as a chance match.

use ncfix_base::numeric::{fisher, in_parts};

use super::cause::{Candidate, EffectKind};
use super::fold::counts;
use super::search::{Field, Taken, Weights};

/// Tested autocorrelations from row to row, and tested variances of the innovation relative to white noise.
const MEMORIES: [f64; 4] = [0.8, 0.95, 0.99, 0.999];
const FRESH: [f64; 8] = [1e-3, 4e-3, 0.016, 0.06, 0.25, 1.0, 4.0, 32.0];
/// Tested values if there are many readings.
const MEMORIES_OF_MANY: [f64; 3] = [0.9, 0.98, 0.999];
const FRESH_OF_MANY: [f64; 5] = [2e-3, 0.016, 0.12, 1.0, 16.0];
/// Number of readings from which these values are used.
const MANY: usize = 8000;
/// Maximum number of named causes that are compared with an unnamed one.
const MOST: usize = 60;
/// A column with less than this share of its square remaining is dependent.
const DEPENDENT: f64 = 1e-9;
/// A column of unit length has faded out below this value: its square is lost in the rounding of the products.
const FADED: f64 = 1e-12;

/// The included readings, one series after the other.
struct Rows {
    places: Vec<usize>,
    /// Position in its series.
    within: Vec<usize>,
    longest: usize,
}

impl Rows {
    fn new(field: &Field<'_, '_>, weights: &Weights) -> Rows {
        let mut places = counts(field.scene, weights);
        places.sort_by_key(|&place| weights.series.get(place).copied());
        let mut within = Vec::with_capacity(places.len());
        let (mut last, mut count) = (None, 0);
        for place in &places {
            let own = weights.series.get(*place).copied();
            count = if own == last { count + 1 } else { 0 };
            last = own;
            within.push(count);
        }
        let longest = within.iter().max().map_or(0, |most| most + 1);
        Rows { places, within, longest }
    }

    /// A column in units of the noise, of unit length.
    fn column(&self, weights: &Weights, values: &[f64]) -> Vec<f64> {
        let of = |place: &usize| Some(values.get(*place)? * weights.items.get(*place)?);
        let mut out: Vec<f64> = self.places.iter().map(|place| of(place).unwrap_or(0.0)).collect();
        let length = out.iter().map(|value| value * value).sum::<f64>().sqrt();
        if length > 0.0 {
            out.iter_mut().for_each(|value| *value /= length);
        }
        out
    }
}

/// A column from its first to its last value that is not 0: that of a set-up is short.
struct SparseColumn {
    first: usize,
    values: Vec<f64>,
}

impl SparseColumn {
    fn new(column: &[f64]) -> SparseColumn {
        let first = column.iter().position(|value| *value != 0.0).unwrap_or(0);
        let end = column.iter().rposition(|value| *value != 0.0).map_or(first, |last| last + 1);
        SparseColumn { first, values: column.get(first..end).unwrap_or_default().to_vec() }
    }

    fn dot(&self, other: &SparseColumn) -> f64 {
        let [start, end] = [self.first.max(other.first), self.end().min(other.end())];
        let of = |column: &SparseColumn| start.saturating_sub(column.first)..end.saturating_sub(column.first);
        if start >= end {
            return 0.0;
        }
        let pair = self.values.get(of(self)).zip(other.values.get(of(other)));
        pair.map_or(0.0, |(one, other)| one.iter().zip(other).map(|(a, b)| a * b).sum())
    }

    fn end(&self) -> usize {
        self.first + self.values.len()
    }
}

/// A noise model: white noise plus a slow process with this autocorrelation and this variance of its innovation.
#[derive(Clone, Copy)]
struct Kind {
    memory: f64,
    fresh: f64,
}

/// Products of columns after the set-up unknowns, under one noise model. The last column is that of the readings.
struct Products {
    matrix: Vec<f64>,
    side: usize,
    /// Σ ln of the variances of the innovations.
    variances: f64,
}

impl Products {
    /// Innovations of a Kalman filter: each reading minus its prediction from the preceding ones.
    fn new(kind: Kind, rows: &Rows, (unknowns, columns): (&[SparseColumn], &[SparseColumn])) -> Products {
        let mut variance = kind.fresh / (1.0 - kind.memory * kind.memory);
        let mut steps = Vec::with_capacity(rows.longest);
        for _ in 0..rows.longest {
            let whole = variance + 1.0;
            steps.push((variance / whole, whole.sqrt()));
            variance = kind.memory * kind.memory * variance / whole + kind.fresh;
        }
        let whitened = |column: &SparseColumn| {
            let mut slow = 0.0;
            let mut out = SparseColumn { first: column.first, values: Vec::with_capacity(column.values.len()) };
            for (place, within) in rows.within.iter().enumerate().skip(column.first) {
                if *within == 0 {
                    slow = 0.0;
                }
                let value = column.values.get(place - column.first);
                // After its last value, a column only fades.
                if value.is_none() && f64::abs(slow) < FADED {
                    break;
                }
                let (gain, sigma) = steps.get(*within).copied().unwrap_or((0.0, 1.0));
                let new = value.copied().unwrap_or(0.0) - slow;
                slow = kind.memory * (slow + gain * new);
                out.values.push(new / sigma);
            }
            out
        };
        let all: Vec<SparseColumn> = unknowns.iter().chain(columns).map(whitened).collect();
        let side = all.len();
        let mut matrix = vec![0.0; side * side];
        for (k, one) in all.iter().enumerate() {
            for (l, other) in all.iter().enumerate().take(k + 1) {
                let product = one.dot(other);
                matrix[k * side + l] = product;
                matrix[l * side + k] = product;
            }
        }
        let whole: Vec<f64> = (0..side).map(|k| matrix[k * side + k]).collect();
        (0..unknowns.len()).for_each(|k| {
            take_out(&mut matrix, side, k, whole[k]);
        });
        let count = columns.len();
        let rest =
            (0..count * count).map(|at| matrix[(unknowns.len() + at / count) * side + unknowns.len() + at % count]);
        Products {
            matrix: rest.collect(),
            side: count,
            variances: rows.within.iter().map(|within| steps.get(*within).map_or(0.0, |step| 2.0 * step.1.ln())).sum(),
        }
    }

    /// Returns −2 ln of the likelihood with some columns, up to a constant, and the number of independent columns.
    fn left(&self, columns: &[usize], count: f64) -> (f64, usize) {
        let mut matrix = self.matrix.clone();
        let rank =
            columns.iter().filter(|&&k| take_out(&mut matrix, self.side, k, self.matrix[k * self.side + k])).count();
        let squares = matrix.last().copied().unwrap_or(0.0);
        let whole = self.matrix.last().copied().unwrap_or(0.0);
        (count * squares.max(1e-12 * whole).ln() + self.variances, rank)
    }
}

/// Eliminates a column from all products. Returns true if it is independent.
fn take_out(matrix: &mut [f64], side: usize, k: usize, whole: f64) -> bool {
    let pivot = matrix[k * side + k];
    if !(pivot > DEPENDENT * whole && whole > 0.0) {
        return false;
    }
    let row: Vec<f64> = matrix[k * side..(k + 1) * side].to_vec();
    for l in (0..side).filter(|&l| row[l] != 0.0) {
        let factor = row[l] / pivot;
        matrix[l * side..(l + 1) * side].iter_mut().zip(&row).for_each(|(value, own)| *value -= factor * own);
    }
    true
}

/// Candidates under all noise models.
struct Slow {
    /// The readings.
    count: f64,
    /// Columns of each candidate.
    own: Vec<Vec<usize>>,
    all: Vec<Products>,
}

impl Slow {
    fn new(field: &Field<'_, '_>, weights: &Weights, numbers: &[usize]) -> Slow {
        let rows = Rows::new(field, weights);
        let mut unknowns: Vec<SparseColumn> = Vec::new();
        field.each_unknown(|values| unknowns.push(SparseColumn::new(&rows.column(weights, values))));
        let mut columns: Vec<SparseColumn> = Vec::new();
        let mut own: Vec<Vec<usize>> = Vec::new();
        for number in numbers {
            let all = field.candidates.get(*number).map(|one| field.columns(one)).unwrap_or_default();
            own.push((columns.len()..columns.len() + all.len()).collect());
            columns.extend(all.iter().map(|values| SparseColumn::new(&rows.column(weights, values))));
        }
        let values: Vec<f64> = field.scene.items.iter().map(|item| item.left).collect();
        columns.push(SparseColumn::new(&rows.column(weights, &values)));
        let (memories, fresh) = if rows.places.len() > MANY {
            (&MEMORIES_OF_MANY[..], &FRESH_OF_MANY[..])
        } else {
            (&MEMORIES[..], &FRESH[..])
        };
        let mut kinds = vec![Kind { memory: 0.0, fresh: 0.0 }];
        kinds.extend(memories.iter().flat_map(|&memory| fresh.iter().map(move |&fresh| Kind { memory, fresh })));
        let all = in_parts(&kinds, &|kind: &Kind| Products::new(*kind, &rows, (&unknowns, &columns)));
        Slow { count: rows.places.len() as f64, own, all }
    }

    /// Returns −2 ln of the likelihood of some candidates, up to a constant, with the best noise model, and the number of independent columns.
    fn best(&self, taken: &[usize]) -> (f64, usize) {
        let columns: Vec<usize> = taken.iter().filter_map(|&k| self.own.get(k)).flatten().copied().collect();
        let each = self.all.iter().map(|products| products.left(&columns, self.count));
        each.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0))
    }
}

/// Replaces unnamed terms by named ones with at least as much evidence under slowly varying noise. A shape over two drivers can follow noise that depends on
/// neither of them, and then hides a cause that depends on one.
pub(super) fn named(field: &Field<'_, '_>, weights: &Weights, mut judged: Vec<Taken>) -> Vec<Taken> {
    for k in 0..judged.len() {
        let rivals =
            judged.get(k).and_then(|term| field.candidates.get(term.candidate)).map(|one| named_of(field, one));
        let Some(rivals) = rivals.filter(|rivals| !rivals.is_empty()) else { continue };
        let others = judged.len();
        let numbers: Vec<usize> = judged.iter().map(|term| term.candidate).chain(rivals.iter().copied()).collect();
        let slow = Slow::new(field, weights, &numbers);
        // Schwarz 1978.
        let worth = |taken: &[usize]| {
            let (left, rank) = slow.best(taken);
            left + slow.count.ln() * rank as f64
        };
        let with = |rival: usize| (0..others).filter(|&other| other != k).chain([rival]).collect::<Vec<usize>>();
        let as_is = worth(&with(k));
        let each = (others..numbers.len()).map(|rival| (worth(&with(rival)), rival));
        let best = each.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(worth, _)| *worth < as_is);
        if let (Some((_, rival)), Some(term)) = (best, judged.get_mut(k)) {
            term.candidate = numbers.get(rival).copied().unwrap_or(term.candidate);
        }
    }
    // Two shapes may have been the same cause.
    let mut known: Vec<usize> = Vec::new();
    judged.retain(|term| {
        let is_new = !known.contains(&term.candidate);
        known.push(term.candidate);
        is_new
    });
    judged
}

/// Returns the named candidates that act at the same point as an unnamed one and depend on some of its drivers.
fn named_of(field: &Field<'_, '_>, one: &Candidate) -> Vec<usize> {
    let through = |one: &Candidate| one.columns.first().and_then(|parts| parts.first()).map(|(through, _)| *through);
    let is_rival = |other: &Candidate| {
        other.cause.effect != EffectKind::Unknown
            && through(other) == through(one)
            && !other.drivers.is_empty()
            && other.drivers.iter().all(|driver| one.drivers.contains(driver))
    };
    let is_slow = |driver: &String| driver.starts_with("T_") || driver == "t_s";
    if one.cause.effect != EffectKind::Unknown || one.drivers.len() < 2 || !one.drivers.iter().all(is_slow) {
        return Vec::new();
    }
    (0..field.candidates.len())
        .filter(|&number| field.candidates.get(number).is_some_and(is_rival))
        .take(MOST)
        .collect()
}

/// Returns the terms of each sensor with more than two. A temperature moves the tip in several directions: without all of them, the noise is as slow as the
/// temperature.
fn of_one_sensor(field: &Field<'_, '_>, judged: &[Taken], open: &[usize]) -> Vec<Vec<usize>> {
    let sensor = |k: usize| {
        let term = judged.get(k)?;
        field.candidates.get(term.candidate)?.sensor.as_deref()
    };
    let mut out: Vec<Vec<usize>> = Vec::new();
    for &k in open.iter().filter(|&&k| sensor(k).is_some()) {
        match out.iter_mut().find(|group| group.first().is_some_and(|&first| sensor(first) == sensor(k))) {
            Some(group) => group.push(k),
            None => out.push(vec![k]),
        }
    }
    out.retain(|group| group.len() > 2);
    out
}

/// Returns the significant terms, each with the larger of its p-values; `note` receives the others.
pub(super) fn stand(
    field: &Field<'_, '_>,
    weights: &Weights,
    judged: Vec<Taken>,
    limit: f64,
    note: &mut dyn FnMut(&Taken),
) -> Vec<Taken> {
    if judged.is_empty() {
        return judged;
    }
    let numbers: Vec<usize> = judged.iter().map(|term| term.candidate).collect();
    let slow = Slow::new(field, weights, &numbers);
    let best = |taken: &[usize]| slow.best(taken);
    let mut taken: Vec<usize> = Vec::new();
    let mut chances = vec![1.0; judged.len()];
    loop {
        let (before, rank_before) = best(&taken);
        let chance = |more: &[usize]| {
            let with: Vec<usize> = taken.iter().chain(more).copied().collect();
            let (left, rank) = best(&with);
            let rank = rank.saturating_sub(rank_before) as f64;
            // A term may be significant only together with another one: then the number of both counts.
            let tried = (field.tried as f64).powi(i32::try_from(more.len()).unwrap_or(1));
            (fisher::exceeded((before - left) / rank.max(1.0), rank, 1e9) * tried).min(1.0)
        };
        let open: Vec<usize> = (0..judged.len()).filter(|k| !taken.contains(k)).collect();
        let singles = open.iter().map(|&k| vec![k]);
        let surest = |of: &mut dyn Iterator<Item = Vec<usize>>| {
            let all = of.map(|more| (chance(&more), more));
            all.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(chance, _)| *chance < limit)
        };
        let found = surest(&mut singles.into_iter())
            .or_else(|| {
                let pairs =
                    open.iter().enumerate().flat_map(|(at, &k)| open.iter().skip(at + 1).map(move |&l| vec![k, l]));
                surest(&mut pairs.into_iter())
            })
            .or_else(|| surest(&mut of_one_sensor(field, &judged, &open).into_iter()));
        let Some((chance, more)) = found else { break };
        for k in more {
            if let Some(own) = chances.get_mut(k) {
                *own = chance;
            }
            taken.push(k);
        }
    }
    let mut out = Vec::new();
    for (k, (mut term, chance)) in judged.into_iter().zip(chances).enumerate() {
        term.chance = term.chance.max(chance);
        if taken.contains(&k) {
            out.push(term);
        } else {
            note(&term);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::scene::Through;

    #[test]
    fn rivals_of_what_depends_on_more_than_one_slow_driver_depend_on_some_of_them() {
        let machine = bench::machine();
        let sets = [bench::reads_along_x(&machine, &[1.0; 8])];
        let scene = bench::scene(&machine, &sets);
        let of = |effect: EffectKind, drivers: &[&str]| {
            let mut one = bench::candidate(effect, Through::Tip(0), |_| 1.0);
            one.drivers = drivers.iter().map(|&name| name.to_owned()).collect();
            one
        };
        let all = vec![
            of(EffectKind::ThermalDrift, &["T_a_C"]),
            of(EffectKind::ThermalDrift, &["T_b_C"]),
            of(EffectKind::Unknown, &["T_a_C"]),
        ];
        let field = Field::new(&scene, all);
        let rivals = |drivers: &[&str]| named_of(&field, &of(EffectKind::Unknown, drivers));
        assert_eq!(rivals(&["T_a_C", "t_s"]), [0]);
        assert_eq!(rivals(&["T_a_C", "T_b_C", "t_s"]), [0, 1]);
        // For a single driver, the named cause was tested already; positions do not vary slowly.
        assert_eq!(rivals(&["T_a_C"]), [0; 0]);
        assert_eq!(rivals(&["T_a_C", "X"]), [0; 0]);
    }

    #[test]
    fn what_a_name_says_as_well_has_the_name() {
        let machine = bench::machine();
        let temperature = |row: usize| (0.7 * row as f64).sin();
        let found = |um: &dyn Fn(usize) -> f64| {
            let sets = [bench::reads_along_x(&machine, &(0..60).map(um).collect::<Vec<_>>())];
            let scene = bench::scene(&machine, &sets);
            let tip = Through::Tip(0);
            let mut named = bench::candidate(EffectKind::ThermalDrift, tip, move |row| temperature(row.number));
            named.drivers = vec!["T_a_C".into()];
            // An increasing part depends on the temperature and on a second driver.
            let mut shape = bench::candidate(EffectKind::Unknown, tip, move |row| temperature(row.number));
            shape.drivers = vec!["T_a_C".into(), "t_s".into()];
            let mut more =
                bench::candidate(EffectKind::Unknown, tip, move |row| row.number as f64 * temperature(row.number));
            shape.columns.append(&mut more.columns);
            let field = Field::new(&scene, vec![shape, named]);
            let judged = super::named(&field, &bench::even(&scene), vec![Taken { candidate: 0, chance: 0.0 }]);
            judged.iter().map(|term| term.candidate).collect::<Vec<_>>()
        };
        assert_eq!(found(&|row| 5.0 * temperature(row)), [1]);
        assert_eq!(found(&|row| 0.1 * row as f64 * temperature(row)), [0]);
    }
}
