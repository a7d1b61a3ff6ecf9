//! Twins: terms with the same effect on all readings, but another one elsewhere. No reading separates them, so they share their probability by their odds. The
//! comparison itself uses one of them.

use std::collections::HashMap;

use super::cause::EffectKind;
use super::entrant::EntrantSource;
use super::explain::contest::Contest;
use super::search::Field;
use super::volume::Volume;
use ncfix_base::numeric::sums::dot;

/// Two displacements over the volume are the same if 1 − |cos| of them is below this.
const SAME: f64 = 1e-6;
/// Largest number of ways to write a set with other twins.
const MOST_WAYS: usize = 64;

/// One of several twins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Twin {
    /// Its entrant.
    pub(super) entrant: usize,
    /// Its share in their probability.
    pub(super) share: f64,
    /// Its amount, as a multiple of that of the compared one.
    pub(super) ratio: f64,
}

/// The twins of each compared entrant that has any, itself first.
#[derive(Clone, Debug, Default)]
pub(super) struct Twins(HashMap<usize, Vec<Twin>>);

impl Twins {
    /// Finds the twins of a comparison among the errors of axes. One error under two names has no twin: its correction is the same.
    pub(super) fn new(
        field: &Field<'_, '_>,
        found: &Contest,
        sources: &[EntrantSource],
        volume: Option<&Volume>,
    ) -> Twins {
        let displacements = |entrant: usize| -> Vec<f64> {
            let candidate = match sources.get(entrant) {
                Some(EntrantSource::Known(number)) => field.candidates.get(*number),
                Some(EntrantSource::Shape(one)) => Some(&**one),
                None => None,
            };
            let (Some(candidate), Some(volume)) = (candidate, volume) else { return Vec::new() };
            let moves = matches!(candidate.cause.effect, EffectKind::Location | EffectKind::Motion | EffectKind::Cross);
            if moves { volume.fields(candidate, false).into_iter().next().unwrap_or_default() } else { Vec::new() }
        };
        let is_same = |one: &[f64], other: &[f64]| {
            let norms = dot(one, one) * dot(other, other);
            one.len() == other.len() && norms > 0.0 && 1.0 - (dot(one, other).powi(2) / norms).sqrt() < SAME
        };
        let odds = |entrant: usize| found.log_odds.get(entrant).copied().unwrap_or(f64::NEG_INFINITY).exp();
        let mut all: HashMap<usize, Vec<Twin>> = HashMap::new();
        for (&(entrant, kept), &ratio) in found.alike.iter().zip(&found.ratios) {
            // Variants of a cause are one cause. Of causes without displacements over the volume, nothing shows that they differ elsewhere.
            let [own, others] = [entrant, kept].map(displacements);
            let is_variant =
                sources.get(entrant).zip(sources.get(kept)).is_none_or(|(a, b)| a.key(field) == b.key(field));
            if is_variant || own.is_empty() || others.is_empty() || is_same(&own, &others) {
                continue;
            }
            let first = Twin { entrant: kept, share: odds(kept), ratio: 1.0 };
            all.entry(kept).or_insert_with(|| vec![first]).push(Twin { entrant, share: odds(entrant), ratio });
        }
        for twins in all.values_mut() {
            let whole: f64 = twins.iter().map(|one| one.share).sum();
            twins.iter_mut().for_each(|one| one.share /= whole.max(f64::MIN_POSITIVE));
        }
        Twins(all)
    }

    /// Share of an entrant in the probability of its twins; 1 without any.
    pub(super) fn share(&self, entrant: usize) -> f64 {
        self.0.values().flatten().find(|one| one.entrant == entrant).map_or(1.0, |one| one.share)
    }

    /// Every way to write a set with twins, with its share in the probability of the set. Too many ways leave it as it is.
    pub(super) fn ways(&self, set: &[usize]) -> Vec<(Vec<Twin>, f64)> {
        let itself = |entrant: &usize| Twin { entrant: *entrant, share: 1.0, ratio: 1.0 };
        let mut ways: Vec<(Vec<Twin>, f64)> = vec![(Vec::new(), 1.0)];
        for entrant in set {
            let own = [itself(entrant)];
            let twins = self.0.get(entrant).map_or(&own[..], Vec::as_slice);
            if ways.len() * twins.len() > MOST_WAYS {
                return vec![(set.iter().map(itself).collect(), 1.0)];
            }
            let with = |(way, share): &(Vec<Twin>, f64), twin: &Twin| {
                (way.iter().copied().chain([*twin]).collect(), share * twin.share)
            };
            ways = ways.iter().flat_map(|way| twins.iter().map(move |twin| with(way, twin))).collect();
        }
        ways
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twins_share_the_probability_of_each_set() {
        let of = |entrant: usize, share: f64, ratio: f64| Twin { entrant, share, ratio };
        let twins = Twins(HashMap::from([(2, vec![of(2, 0.75, 1.0), of(5, 0.25, -1.0)])]));
        assert_eq!([2, 5, 1].map(|entrant| twins.share(entrant)), [0.75, 0.25, 1.0]);
        let ways = twins.ways(&[1, 2]);
        let expected =
            [(vec![of(1, 1.0, 1.0), of(2, 0.75, 1.0)], 0.75), (vec![of(1, 1.0, 1.0), of(5, 0.25, -1.0)], 0.25)];
        assert_eq!(ways, expected);
    }
}
