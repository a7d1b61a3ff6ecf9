//! Harm of a correction: if another explanation is true, correcting by a term of the first one may increase the error.

use std::collections::HashMap;

use super::cause::EffectKind;
use super::entrant::{EntrantSource, family};
use super::search::Field;
use super::volume::Volume;
use crate::diagnose::explain::assumptions::Family;
use crate::diagnose::explain::contest::Contest;
use crate::diagnose::explain::search::Explanation;
use ncfix_base::numeric::sums::dot;
use ncfix_model::name::ErrorName;

/// A correction is refused if it would increase the error with more than this probability.
const HARMFUL: f64 = 0.1;
/// The limit for explanations that no reading separates from the first one: only typical sizes argue against them.
const HARMFUL_ALIKE: f64 = 0.01;
/// A correction helps if its residual is less than this share of the error.
const LEAVES: f64 = 0.8;
/// Two explanations fit the readings equally if their sums of squared residuals differ by less than this, in variances.
const ALIKE: f64 = 0.02;

/// Displacements by each explanation over the used volume.
pub(super) struct Harm<'f> {
    found: &'f Contest,
    /// By explanation: the field, mm.
    fields: Vec<Vec<f64>>,
    /// By entrant of the first explanation: its displacements, mm.
    own: HashMap<usize, Vec<f64>>,
    /// Number of values for one tool.
    part: usize,
    /// By entrant: true for offsets and tilts of rotary axes and of the spindle, and true for shapes, which are written as tables.
    is_offset: Vec<bool>,
    is_shape: Vec<bool>,
    /// By entrant: true for shapes that are angles.
    is_angle: Vec<bool>,
    /// Effect and parameter of each entrant.
    keys: Vec<(EffectKind, String)>,
}

impl<'f> Harm<'f> {
    pub(super) fn new(
        field: &'f Field<'_, '_>,
        found: &'f Contest,
        sources: &[EntrantSource],
        volume: Option<&Volume>,
    ) -> Harm<'f> {
        let mut units: HashMap<usize, Vec<Vec<f64>>> = HashMap::new();
        let mut of = |entrant: usize| -> Vec<Vec<f64>> {
            let make = || match (volume, sources.get(entrant)) {
                (Some(volume), Some(EntrantSource::Known(number))) => {
                    let one = &field.candidates[*number];
                    let moves = matches!(
                        one.cause.effect,
                        EffectKind::Location | EffectKind::Motion | EffectKind::Cross | EffectKind::Periodic
                    );
                    if moves { volume.fields(one, false) } else { Vec::new() }
                }
                // The file stores it as a table, which is constant beyond the measured range; an angle also acts beyond it, by its arm.
                (Some(volume), Some(EntrantSource::Shape(one))) => {
                    let is_angle = one.parameter.parse::<ErrorName>().is_ok_and(|name| name.direction.is_rotation());
                    volume.fields(one, !is_angle)
                }
                _ => Vec::new(),
            };
            units.entry(entrant).or_insert_with(make).clone()
        };
        let mut own = HashMap::new();
        let mut fields = Vec::new();
        for (rank, one) in found.explanations.iter().enumerate() {
            let mut all: Vec<f64> = Vec::new();
            let mut amounts = one.posterior.mean.iter();
            for &entrant in &one.set {
                let columns = of(entrant);
                let width = found.widths.get(entrant).copied().unwrap_or(1);
                let mut mine: Vec<f64> = Vec::new();
                for (k, amount) in amounts.by_ref().take(width).enumerate() {
                    if let Some(column) = columns.get(k) {
                        mine.resize(column.len(), 0.0);
                        mine.iter_mut().zip(column).for_each(|(sum, value)| *sum += amount * value);
                    }
                }
                if !mine.is_empty() {
                    all.resize(mine.len(), 0.0);
                    all.iter_mut().zip(&mine).for_each(|(sum, value)| *sum += value);
                }
                if rank == 0 {
                    own.insert(entrant, mine);
                }
            }
            fields.push(all);
        }
        let part = volume.map_or(1, Volume::numbers_of_a_tool).max(1);
        let keys = sources.iter().map(|source| source.key(field)).collect();
        let is_offset = |source: &EntrantSource| match source {
            EntrantSource::Known(number) => matches!(family(&field.candidates[*number]), Family::Offset | Family::Tilt),
            EntrantSource::Shape(_) => false,
        };
        let is_shape = |source: &EntrantSource| matches!(source, EntrantSource::Shape(_));
        let [is_offset, is_shape] =
            [sources.iter().map(is_offset).collect(), sources.iter().map(is_shape).collect::<Vec<bool>>()];
        let is_angle = |source: &EntrantSource| {
            let EntrantSource::Shape(one) = source else { return false };
            one.parameter.parse::<ErrorName>().is_ok_and(|name| name.direction.is_rotation())
        };
        let is_angle = sources.iter().map(is_angle).collect();
        Harm { found, fields, own, part, is_offset, is_shape, is_angle, keys }
    }

    /// True if a correction by a term of the first explanation also helps, with each tool, if another explanation is true.
    fn helps(&self, first: &[f64], own: &[f64], field: &[f64]) -> bool {
        let at = |values: &[f64], k: usize| values.get(k).copied().unwrap_or(0.0);
        // The alternative to the term: the difference of both explanations plus the term itself.
        let instead: Vec<f64> = (0..own.len()).map(|k| at(field, k) - at(first, k) + own[k]).collect();
        instead.chunks(self.part).zip(own.chunks(self.part)).all(|(instead, own)| {
            let left: f64 = instead.iter().zip(own).map(|(other, own)| (other - own).powi(2)).sum();
            left <= LEAVES * LEAVES * dot(instead, instead)
        })
    }

    /// Alternatives to a term of the first explanation, if correcting by that term would probably increase the error with them. A term found by the
    /// search has passed its own acceptance tests: unless it `is_new`, only explanations count that no reading separates.
    pub(super) fn of(&self, entrant: usize, is_new: bool) -> Option<Vec<usize>> {
        let none = Vec::new();
        let (first, own) = (self.fields.first()?, self.own.get(&entrant).unwrap_or(&none));
        let square = dot(own, own);
        let best = self.found.explanations.first()?;
        let (mut harmful, mut harmful_alike) = (0.0, 0.0);
        let mut others: Vec<usize> = Vec::new();
        let all = self.found.explanations.iter().zip(&self.fields);
        for (one, field) in all.filter(|(one, _)| !one.set.contains(&entrant)) {
            let is_variant = |other: &usize| {
                !best.set.contains(other)
                    && self.keys.get(*other).zip(self.keys.get(entrant)).is_some_and(|(a, b)| a == b)
            };
            // Backlash has no displacements over the volume, and a shape is written only over the measured range: a variant is equivalent.
            let by_variant = square <= 0.0 || self.is_shape.get(entrant).copied().unwrap_or(false);
            let helps =
                (by_variant && one.set.iter().any(is_variant)) || (square > 0.0 && self.helps(first, own, field));
            if helps {
                continue;
            }
            harmful += one.probability;
            // Only tools of several lengths separate the offsets and tilts of rotary axes and of the spindle.
            let scale = best.posterior.scale;
            let is_same = |with: &&Explanation| {
                let apart = (one.posterior.misfit - with.posterior.misfit).abs() / (scale * scale);
                let others = with.set.iter().filter(|other| **other != entrant);
                apart < ALIKE
                    && one.set.len() == with.set.len()
                    && others.into_iter().all(|other| one.set.contains(other))
            };
            let mut with = self.found.explanations.iter().filter(|with| with.set.contains(&entrant));
            if self.is_offset.get(entrant).copied().unwrap_or(false) && with.any(|with| is_same(&with)) {
                harmful_alike += one.probability;
            }
            if others.is_empty() {
                others = one.set.iter().copied().filter(|other| !best.set.contains(other)).collect();
            }
        }
        // An angle acts by its arm far from where it was measured.
        let most = if self.is_angle.get(entrant).copied().unwrap_or(false) { HARMFUL_ALIKE } else { HARMFUL };
        ((is_new && harmful > most) || harmful_alike > HARMFUL_ALIKE).then_some(others)
    }
}
