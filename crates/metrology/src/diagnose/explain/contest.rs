//! The comparison of all terms: a pool of terms that are always tested, and a large number of others that join it if they improve the score.
//!
//! The search runs over the pool. With its best set, every term outside is tested once; terms whose gain exceeds the cost of their odds join the
//! pool, and the search runs again. The autocorrelation of the noise is selected again for each best set.

use super::likelihood::{ColumnGroup, Likelihood};
use super::noise::{Memory, NoiseSeries};
use super::search::{self, Explanation, Odds};
use crate::diagnose::scene::Scene;
use ncfix_base::numeric::in_parts;

/// Maximum number of combinations of autocorrelation and factor that are tested.
const MOST_MEMORIES: usize = 6;
/// Factors of all sizes of priors, from a new high-precision machine to a worn one, and to a router or printer that someone built at home.
const FACTORS: [f64; 7] = [0.1, 0.2, 0.4, 1.0, 2.5, 6.0, 15.0];
/// Standard deviation of the natural logarithm of that factor: two of three machines are within a factor of 2.7.
const FACTOR_SPREAD: f64 = 1.0;
/// Number of iterations in which terms from outside join.
const ROUNDS: usize = 4;
/// A term is an alternative if, instead of another one, it explains less by no more than this: a factor of 150, as a natural logarithm.
const NEARLY: f64 = 5.0;
/// Number of terms from outside that join in an iteration, those with the largest gain.
const JOIN: usize = 40;

/// A term in the comparison.
#[derive(Clone, Debug, Default)]
pub struct Entrant {
    /// Its columns.
    pub group: ColumnGroup,
    /// Logarithm of its odds.
    pub log_odds: f64,
    /// Index of the entrant that usually accompanies it.
    pub parent: Option<usize>,
    /// True if most machines have it; all of these together are a start of the search.
    pub is_simple: bool,
}

/// A large number of terms outside the pool, by index.
pub struct Outside<'o> {
    /// Their number.
    pub count: usize,
    /// Logarithm of the odds of one.
    pub log_odds: &'o (dyn Fn(usize) -> f64 + Sync),
    /// Its columns.
    pub group: &'o (dyn Fn(usize) -> ColumnGroup + Sync),
}

/// The outcome.
#[derive(Clone, Debug, Default)]
pub struct Contest {
    /// Number of entrants at the end: the given ones, then the joined ones.
    pub entrants: usize,
    /// Columns of each entrant.
    pub widths: Vec<usize>,
    /// Indices of the outside terms that joined; as entrants they follow the given ones in this order.
    pub joined: Vec<usize>,
    /// Explanations, the most probable first. Their sets contain indices of entrants.
    pub explanations: Vec<Explanation>,
    /// Decrease of the score of the first explanation without each of its terms, in the order of its set.
    pub losses: Vec<f64>,
    /// Entrants with the same effect on all measured positions as another one, with the index of that one.
    pub alike: Vec<(usize, usize)>,
    /// Amount of each of these, as a multiple of that of the other one.
    pub ratios: Vec<f64>,
    /// Logarithm of the odds of each entrant.
    pub log_odds: Vec<f64>,
    /// Score of each given start relative to that of the best set; minus infinity if one of its terms has no visible effect.
    pub behind: Vec<f64>,
    /// Autocorrelation of the noise; its length is in seconds if the readings have times, else in rows.
    pub memory: Memory,
}

/// Runs the comparison. `weights` are 1/σ of each reading, 0 for rejected ones. `starts` are sets of entrants from which the search starts, in
/// addition to the empty set and to all simple terms.
#[must_use]
pub fn contest(
    scene: &Scene<'_>,
    weights: &[f64],
    mut entrants: Vec<Entrant>,
    outside: &Outside<'_>,
    starts: &[Vec<usize>],
) -> Contest {
    let noise = NoiseSeries::new(scene, weights);
    let readings = (weights.iter().filter(|weight| **weight > 0.0).count() as f64).max(2.0);
    // Two parameters more than white noise, by the information criterion of Schwarz (1978).
    let price = |memory: Memory| if memory.ratio > 0.0 { readings.ln() } else { 0.0 };
    let choose = |entrants: &[Entrant], set: &[usize]| {
        let some: Vec<ColumnGroup> = set.iter().map(|&number| entrants[number].group.clone()).collect();
        let worth = |&memory: &Memory| {
            let likelihood = Likelihood::new(scene, weights, &some, (&noise, memory));
            let own: Vec<usize> = (0..likelihood.count()).collect();
            likelihood.evidence(&own).1 - price(memory)
        };
        let memories = noise.memories();
        let worths = in_parts(&memories, &worth);
        let best = memories.into_iter().zip(worths).max_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or_else(Memory::default, |(memory, _)| memory)
    };
    let mut joined: Vec<usize> = Vec::new();
    let mut best: Option<(f64, Contest)> = None;
    let mut tried: Vec<(Memory, f64)> = Vec::new();
    let rarity = |factor: f64| 0.5 * (factor.ln() / FACTOR_SPREAD).powi(2);
    // Terms and noise compete for the same readings. So the search starts from white noise, and from autocorrelated noise that explains all readings.
    for start in [Memory::default(), choose(&entrants, &[])] {
        let (mut memory, mut factor) = (start, 1.0);
        while !tried.contains(&(memory, factor)) && tried.len() < MOST_MEMORIES {
            tried.push((memory, factor));
            let mut next = factor;
            let mut known: Vec<Vec<usize>> = starts.to_vec();
            let groups: Vec<ColumnGroup> = entrants.iter().map(|one| one.group.clone()).collect();
            let mut likelihood = Likelihood::new(scene, weights, &groups, (&noise, memory));
            for round in 0..ROUNDS {
                likelihood.factor = factor;
                let place = |number: usize| likelihood.kept.iter().position(|&kept| kept == number);
                let same =
                    |number: usize| likelihood.alike.iter().find(|(one, _)| *one == number).map(|(_, other)| *other);
                let inner = |set: &[usize]| -> Option<Vec<usize>> {
                    let mut out: Vec<usize> =
                        set.iter().map(|&number| place(same(number).unwrap_or(number))).collect::<Option<_>>()?;
                    out.sort_unstable();
                    out.dedup();
                    Some(out)
                };
                let odds = Odds {
                    log: likelihood.kept.iter().map(|&number| entrants[number].log_odds).collect(),
                    parents: likelihood.kept.iter().map(|&number| place(entrants[number].parent?)).collect(),
                };
                let simple = (0..likelihood.count()).filter(|&k| entrants[likelihood.kept[k]].is_simple).collect();
                let mut from = vec![Vec::new(), simple];
                from.extend(known.iter().filter_map(|set| inner(set)));
                let found = search::explanations(&likelihood, &odds, &from);
                let Some(first) = found.first() else { break };
                let score = |set: &[usize]| likelihood.evidence(set).1 + odds.of(set);
                let worth = score(&first.set);
                let behind =
                    starts.iter().map(|set| inner(set).map_or(f64::NEG_INFINITY, |set| score(&set) - worth)).collect();
                let (set, scale) = (first.set.clone(), first.posterior.scale);
                let without = |place: usize| {
                    let rest: Vec<usize> =
                        set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, &k)| k).collect();
                    worth - score(&rest)
                };
                let losses: Vec<f64> = (0..set.len()).map(without).collect();
                let outer: Vec<usize> = set.iter().map(|&k| likelihood.kept[k]).collect();
                known.push(outer);
                // Terms whose gain exceeds the cost of their odds, or nearly does so instead of another term.
                let open: Vec<usize> = (0..outside.count).filter(|number| !joined.contains(number)).collect();
                let mut sets = vec![(set.clone(), 0.0)];
                for (place, loss) in losses.iter().enumerate() {
                    let rest = set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, &k)| k).collect();
                    sets.push((rest, NEARLY - loss));
                }
                let gains = likelihood.best_with_others(&sets, scale, &open, outside.group);
                let mut gaining: Vec<(f64, usize)> = open
                    .iter()
                    .zip(gains)
                    .map(|(&number, gain)| (gain + (outside.log_odds)(number), number))
                    .filter(|(gain, _)| *gain > 0.0)
                    .collect();
                gaining.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
                gaining.truncate(JOIN);
                let explanations = found
                    .into_iter()
                    .map(|one| Explanation { set: one.set.iter().map(|&k| likelihood.kept[k]).collect(), ..one })
                    .collect();
                let outcome = Contest {
                    entrants: entrants.len(),
                    widths: entrants.iter().map(|one| one.group.columns.len()).collect(),
                    joined: Vec::new(),
                    explanations,
                    losses,
                    alike: likelihood.alike.clone(),
                    ratios: likelihood.ratios.clone(),
                    log_odds: Vec::new(),
                    behind,
                    memory,
                };
                let worth = worth - price(memory) - rarity(factor);
                // The factor that is best for this set or for a given one.
                let mut most = f64::NEG_INFINITY;
                let also = starts.iter().filter_map(|set| inner(set)).chain([set.clone()]);
                for set in also {
                    for other in FACTORS {
                        likelihood.factor = other;
                        let own = likelihood.evidence(&set).1 + odds.of(&set) - rarity(other);
                        if own > most {
                            (most, next) = (own, other);
                        }
                    }
                }
                // A larger pool with the same autocorrelation replaces the smaller one.
                if best
                    .as_ref()
                    .is_none_or(|(known, before)| worth > *known || (worth >= *known - 1e-9 && before.memory == memory))
                {
                    best = Some((worth, outcome));
                }
                if gaining.is_empty() || round + 1 == ROUNDS {
                    break;
                }
                let groups: Vec<ColumnGroup> = gaining.iter().map(|&(_, number)| (outside.group)(number)).collect();
                likelihood.add(&groups);
                for ((_, number), group) in gaining.into_iter().zip(groups) {
                    entrants.push(Entrant {
                        group,
                        log_odds: (outside.log_odds)(number),
                        parent: None,
                        is_simple: false,
                    });
                    joined.push(number);
                }
            }
            let Some(set) = known.last() else { break };
            memory = choose(&entrants, set);
            factor = next;
        }
    }
    let mut out = best.map_or_else(Contest::default, |(_, outcome)| outcome);
    out.joined = joined;
    out.log_odds = entrants.iter().map(|one| one.log_odds).collect();
    out
}

/// Returns the logarithm of the likelihood of sets of groups, each with its best autocorrelation of the noise and its best factor of the prior sizes,
/// less the penalties of both. Groups without a visible effect count as absent. `weights` are 1/σ of each reading, 0 for rejected ones.
#[must_use]
pub fn evidences(scene: &Scene<'_>, weights: &[f64], groups: &[ColumnGroup], sets: &[Vec<usize>]) -> Vec<f64> {
    let noise = NoiseSeries::new(scene, weights);
    let readings = (weights.iter().filter(|weight| **weight > 0.0).count() as f64).max(2.0);
    let mut best = vec![f64::NEG_INFINITY; sets.len()];
    for memory in noise.memories() {
        let mut own = vec![f64::NEG_INFINITY; sets.len()];
        // Two parameters more than white noise, by the information criterion of Schwarz (1978).
        let price = if memory.ratio > 0.0 { readings.ln() } else { 0.0 };
        let mut likelihood = Likelihood::new(scene, weights, groups, (&noise, memory));
        let place = |number: usize| {
            let same = likelihood.alike.iter().find(|(one, _)| *one == number).map_or(number, |(_, other)| *other);
            likelihood.kept.iter().position(|&kept| kept == same)
        };
        let inner: Vec<Vec<usize>> = sets
            .iter()
            .map(|set| {
                let mut own: Vec<usize> = set.iter().filter_map(|&number| place(number)).collect();
                own.sort_unstable();
                own.dedup();
                own
            })
            .collect();
        for factor in FACTORS {
            likelihood.factor = factor;
            let rarity = 0.5 * (factor.ln() / FACTOR_SPREAD).powi(2);
            let values = in_parts(&inner, &|set: &Vec<usize>| likelihood.evidence(set).1 - price - rarity);
            own.iter_mut().zip(values).for_each(|(best, value)| *best = best.max(value));
        }
        let most = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if most(&own) > most(&best) {
            best = own;
        }
    }
    best
}

impl Contest {
    /// Returns the probability of an entrant: the sum over the explanations that contain it.
    #[must_use]
    pub fn probability(&self, entrant: usize) -> f64 {
        self.explanations.iter().filter(|one| one.set.contains(&entrant)).map(|one| one.probability).sum()
    }
}
