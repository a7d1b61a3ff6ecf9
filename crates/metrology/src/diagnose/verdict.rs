//! Verdict of a diagnosis: findings with their sizes, other explanations and gains, and the residual.

use super::account::{Account, swing};
use super::cause::{Candidate, Cause, CauseId, Causes, EffectKind, Term, earlier, periodic, thermal};
use super::certified;
use super::class::class;
use super::contest::{Chosen, ExplanationSummary};
use super::doubt::ExtrapolationRisk;
use super::elsewhere::ArmRisk;
use super::explain::assumptions::Family;
use super::far::drop_far;
use super::fold::{confirmed, counts};
use super::gates::{confirm, hold};
use super::held::{Compared, compare};
use super::held_out::{self, Selections};
use super::jackknife::{u95, without_parts};
use super::next::NextMeasurement;
use super::noise::{self, is_angle};
use super::parts::{FileShare, differing};
use super::readings::{doing, even_out, left_of, projected, rms, weights};
use super::rejected::{Gate, Rejected, Rejections, TriedCause, tried};
use super::reversed::{ReversedReadings, SignContradiction};
use super::sample::{self, Sample};
use super::scene::Scene;
use super::search::{Field, Taken, Weights};
use super::separate::{self, separating};
use super::share::{VarianceShare, shares};
use super::size::{self, Amounts, EXPANDED, Size, size};
use super::undecided::{CERTAIN, RivalCause, share_out};
use super::volume::Volume;
use ncfix_base::units::um_from_mm;

/// Maximum number of rounds of outlier exclusion.
const ROUNDS: usize = 3;
/// A shape is absorbed if its size is this multiple of the range of its effect on the readings.
const FAR: f64 = 3.0;
/// Relative step of a time constant for its derivative.
const LONGER: f64 = 0.02;

/// A finding.
#[derive(Clone, Debug)]
pub struct AcceptedCause {
    /// The candidate.
    pub candidate: Candidate,
    /// Amounts of its columns, mm, rad, per unit of the driver, with the uncertainty of the size.
    pub amounts: Amounts,
    /// Its size in the usual form.
    pub size: Size,
    /// True if set-ups or other terms absorb most of it: the size is that of its visible part, and a program must not use it.
    pub is_partly_visible: bool,
    /// RMS of its effect on the readings after the set-up unknowns, mm or rad.
    pub rms: f64,
    /// Its effect on each reading used, after the set-up unknowns, in the order of [`Scene::items`], mm or rad.
    pub doing: Vec<f64>,
    /// Range of its effect on the readings of a set-up: largest minus smallest, mm or rad.
    pub alone: f64,
    /// p-value, corrected for the number of candidates.
    pub chance: f64,
    /// Relative reduction of the RMS of left-out readings: the data held out, or parts left out of a repeated selection.
    pub gain_unseen: f64,
    /// Probability of the finding: the sum over all explanations that contain it; `None` if it was not compared.
    pub probability: Option<f64>,
    /// Probability that the error depends on this quantity (place, direction, speed or time), among all that predict the same readings; 1 without rivals.
    pub nature_share: f64,
    /// Causes of another nature that predict its readings, the most probable first.
    pub rivals: Vec<RivalCause>,
    /// Its shares in the explained part.
    pub share: VarianceShare,
    /// Candidates that explain nearly as much: cause and parameter, itself first, then the best.
    pub class: Vec<(&'static Cause, String)>,
    /// The same squareness by the names of other axes, with the factor of its size.
    pub same_as: Vec<(String, f64)>,
    /// Other periods, mm: aliases of a wave, or waves that look like a smooth shape at the measured places.
    pub aliases: Vec<f64>,
    /// Reason why a program must not correct it: other errors have the same effect on the readings but another effect elsewhere.
    pub doubt: Option<ExtrapolationRisk>,
    /// Rivals under which this finding remains true, with another size.
    pub resized: Vec<RivalCause>,
    /// An angle that explains the readings as well, because they have one arm.
    pub arm: Option<ArmRisk>,
    /// Its size in each file, if the files differ significantly.
    pub by_file: Vec<FileShare>,
    /// Measurement that separates it from its first other explanation.
    pub separate_by: Option<String>,
}

impl AcceptedCause {
    /// True if it may be acted on: it is certain, also against rivals of another nature, and larger than its uncertainty. A finding that was not compared is
    /// not certain.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.nature_share >= CERTAIN
            && self.probability.is_some_and(|probability| probability >= CERTAIN)
            && self.size.u95 < self.size.value.abs()
    }
}

/// A diagnosis.
#[derive(Clone, Debug)]
pub struct DiagnosedCauses {
    /// Data that were used.
    pub used: Compared,
    /// Data that were held out.
    pub held_out: Option<Compared>,
    /// Findings, the largest gain on left-out readings first.
    pub findings: Vec<AcceptedCause>,
    /// Causes that the held-out data did not confirm.
    pub not_confirmed: Vec<Candidate>,
    /// Candidates that an acceptance test rejected, including those that were not confirmed.
    pub rejected: Vec<Rejected>,
    /// Every cause, with the part of the residual that its best candidate would explain.
    pub causes: Vec<TriedCause>,
    /// Residuals of the readings before and after.
    pub account: Account,
    /// Excluded readings: numbers of measurement and row.
    pub outliers: Vec<(usize, usize)>,
    /// Residual after all findings, in relation to the noise.
    pub left: noise::Left,
    /// The most probable explanations.
    pub explanations: Vec<ExplanationSummary>,
    /// Probability that there is no cause, only noise; `None` if nothing was compared.
    pub nothing: Option<f64>,
    /// Measurements that separate the explanations, the best first.
    pub next: Vec<NextMeasurement>,
    /// Files that contradict each other in sign.
    pub contradiction: Option<SignContradiction>,
    /// Number of candidates tested.
    pub tried: usize,
    /// Correlation of consecutive residuals.
    pub memory: f64,
}

/// Finds the errors that the model lacks in the first `used` measurements of a scene, and tests them on the others. `bare` are the readings of the same
/// measurements on a machine without errors. `note` receives the current step and its progress.
#[must_use]
pub fn diagnose(scene: &Scene<'_>, bare: &Scene<'_>, used: usize, note: &mut dyn FnMut(&str, f64)) -> DiagnosedCauses {
    diagnose_with(&Causes::default(), scene, bare, used, note)
}

/// Diagnoses as [`diagnose`] does, with only these causes.
#[must_use]
pub fn diagnose_with(
    causes: &Causes,
    scene: &Scene<'_>,
    bare: &Scene<'_>,
    used: usize,
    note: &mut dyn FnMut(&str, f64),
) -> DiagnosedCauses {
    diagnose_then(causes, scene, (bare, used), note, &mut |_, _| {})
}

/// Result of a search with the data of its tests, for terms that are tested in addition.
pub(super) struct Settled<'f, 's, 'a> {
    /// Candidates, including those of the result.
    pub(super) field: &'f mut Field<'s, 'a>,
    /// Readings that were used.
    pub(super) weights: &'f Weights,
    /// Readings that were held out.
    pub(super) held_out: &'f Weights,
    /// Accepted candidates with their gains on left-out readings.
    pub(super) kept: &'f [(Taken, f64)],
    /// Number of measurements used.
    pub(super) used: usize,
    causes: &'f Causes,
    bare: &'f Scene<'f>,
    chosen: &'f [Chosen],
}

impl<'f, 's, 'a> Settled<'f, 's, 'a> {
    /// A search without findings. The first weights are those of the readings used, the second those of the readings held out; the first `used` measurements
    /// were used.
    pub(super) fn open(
        field: &'f mut Field<'s, 'a>,
        [weights, held_out]: [&'f Weights; 2],
        (causes, bare, used): (&'f Causes, &'f Scene<'f>, usize),
    ) -> Settled<'f, 's, 'a> {
        Settled { field, weights, held_out, kept: &[], used, causes, bare, chosen: &[] }
    }

    /// Returns the verdict for other candidates than those accepted.
    pub(super) fn verdict_of(&self, kept: &[(Taken, f64)]) -> DiagnosedCauses {
        let rejections = Rejections::default();
        let of = (self.used, Vec::new(), &rejections);
        let taken: Vec<usize> = kept.iter().map(|(term, _)| term.candidate).collect();
        let reversed = self.field.reversed(self.bare, self.weights, &taken);
        let terms = (kept, self.chosen, reversed.as_ref());
        verdict((self.field, self.causes), self.bare, [self.weights, self.held_out], terms, of)
    }
}

/// Receives the result of a search, and a function that reports progress.
pub(super) type AfterSearch<'t> = dyn FnMut(Settled<'_, '_, '_>, &mut dyn FnMut(&str, f64)) + 't;

/// Diagnoses as [`diagnose_with`] does; `then` receives the result with the data of its tests.
pub(super) fn diagnose_then(
    causes: &Causes,
    scene: &Scene<'_>,
    (bare, used): (&Scene<'_>, usize),
    note: &mut dyn FnMut(&str, f64),
    then: &mut AfterSearch<'_>,
) -> DiagnosedCauses {
    note("causes that may be", 0.0);
    let mut candidates = propose(causes, scene);
    if causes.iter().any(|cause| cause.cause().name == earlier::CAUSE.name) {
        earlier::propose(scene, used, &mut candidates);
    }
    let sample = Sample::new(scene);
    let mut field = Field::new(scene, candidates);
    field.part = sample.as_ref().map(|some| Box::new(sample::SearchPart::new(&field, some)));
    let (mut weights, mut held_out) = weights(scene, used);
    let mut taken = Vec::new();
    for round in 0..ROUNDS {
        note("search", round as f64 / ROUNDS as f64);
        taken = field.forward(&weights, &[]);
        let left = left_of(&field, &weights, &taken);
        if round == 0 {
            even_out(scene, &mut weights, &left);
        }
        let unknowns = field.series(&weights, &taken, 0.0).rank();
        if !drop_far(scene, &mut weights, (&left, unknowns)) {
            break;
        }
    }
    let mut rejections = Rejections::default();
    let mut selections = Selections::new();
    let sought = taken.len();
    let mut kept = confirm(&mut field, &weights, taken, (&mut selections, &mut rejections), note);
    // A term that was not confirmed has hidden another one.
    if (1..sought).contains(&kept.len()) {
        let known: Vec<usize> = kept.iter().map(|(term, _)| term.candidate).collect();
        note("search again", 0.0);
        let taken = field.forward(&weights, &known);
        if taken.len() > known.len() {
            let again = confirm(&mut field, &weights, taken, (&mut selections, &mut rejections), note);
            if again.len() > kept.len() {
                kept = again;
            }
        }
    }
    let numbers: Vec<usize> = kept.iter().map(|(term, _)| term.candidate).collect();
    note("explanations", 0.0);
    let volume = Volume::new(scene, |row| row.set < used);
    field.add_levers(&numbers);
    let mut outcome = field.contest(&weights, &numbers, volume.as_ref());
    let of_outcome: Vec<usize> = outcome.instead.iter().flatten().map(|one| one.candidate).collect();
    if field.add_levers(&of_outcome) > 0 {
        outcome = field.contest(&weights, &numbers, volume.as_ref());
    }
    let mut chosen = outcome.of_taken;
    if let Some(all) = outcome.instead {
        let again = stand(&mut field, &weights, &all, &mut rejections, note);
        let of_again: Vec<usize> = again.iter().map(|(term, _)| term.candidate).collect();
        let squares = |taken: &[usize]| field.series(&weights, taken, 0.0).squares();
        // A term of the comparison without a gain on left-out readings is not an explanation. The terms of the search are then preferred if they are probable
        // enough.
        let is_likely = chosen.iter().all(Chosen::is_likely);
        if (outcome.is_whole && again.len() == all.len()) || !is_likely || squares(&of_again) <= squares(&numbers) {
            (kept, chosen) = (again, all);
        }
    }
    let numbers: Vec<usize> = kept.iter().map(|(term, _)| term.candidate).collect();
    let far = field.left_with(&weights, &numbers);
    let far = projected(&field, &held_out, &far);
    even_out(scene, &mut held_out, &far);
    let unknowns = field.series(&held_out, &[], 0.0).rank();
    drop_far(scene, &mut held_out, (&far, unknowns));
    let not_confirmed = hold(&field, &weights, &held_out, &mut kept, &mut rejections);
    note("verdict", 1.0);
    let numbers: Vec<usize> = kept.iter().map(|(term, _)| term.candidate).collect();
    let reversed = field.reversed(bare, &weights, &numbers);
    let terms = (kept.as_slice(), chosen.as_slice(), reversed.as_ref());
    let mut found = verdict((&field, causes), bare, [&weights, &held_out], terms, (used, not_confirmed, &rejections));
    for one in &mut found.findings {
        let is_one = |chosen: &&Chosen| {
            field.candidates.get(chosen.candidate).is_some_and(|own| {
                own.cause.name == one.candidate.cause.name
                    && own.parameter == one.candidate.parameter
                    && own.columns.len() == one.candidate.columns.len()
            })
        };
        let of_contest = chosen.iter().find(is_one).map(|chosen| chosen.probability * chosen.share);
        one.probability = of_contest.map(|of_contest| of_contest.min(one.nature_share)).or(one.probability);
    }
    (found.explanations, found.nothing, found.next) = (outcome.explanations, outcome.nothing, outcome.next);
    for one in &found.findings {
        // The sign of a file belongs to all findings at once.
        let (own, rivals) = match &reversed {
            Some(reversed) => reversed.left_out_of(one),
            None => (one.nature_share, one.rivals.clone()),
        };
        // So does the choice of the set-up whose scale is wrong; its own finding is exchanged.
        let own = own + one.resized.iter().map(|rival| rival.probability).sum::<f64>();
        let rivals: Vec<RivalCause> = rivals.into_iter().filter(|rival| !one.resized.contains(rival)).collect();
        share_out(&mut found.explanations, &one.candidate.id(), own, &rivals);
    }
    field.share_others(&weights, &numbers, &mut found.explanations);
    share_rejected(&found.rejected, &found.findings, &mut found.explanations);
    if let Some(reversed) = &reversed {
        reversed.share_out(&field, &found.findings, &mut found.explanations);
    }
    let (weights, held_out, kept, chosen) = (&weights, &held_out, kept.as_slice(), chosen.as_slice());
    then(Settled { field: &mut field, weights, held_out, kept, used, causes, bare, chosen }, note);
    found
}

/// Gives noise its share of explanations with a term that was not significant: the comparison of explanations knows no random walk, and must not be surer than
/// the test that rejected the term.
fn share_rejected(rejected: &[Rejected], findings: &[AcceptedCause], explanations: &mut Vec<ExplanationSummary>) {
    let is_found = |id: &CauseId| findings.iter().any(|one| one.candidate.id() == *id);
    for one in rejected.iter().filter(|one| one.gate == Gate::Chance) {
        let id = one.candidate.id();
        if !is_found(&id) {
            let own = 1.0 / (1.0 + least_odds(one.chance));
            let rival = RivalCause { cause: CauseId::SlowChange, probability: 1.0 - own };
            share_out(explanations, &id, own, &[rival]);
        }
    }
}

/// Smallest odds of no effect against one for a p-value: −e p ln p, below 1/e (Sellke, Bayarri and Berger 2001).
fn least_odds(chance: f64) -> f64 {
    if chance <= 0.0 {
        0.0
    } else if chance < (-1.0_f64).exp() {
        -std::f64::consts::E * chance * chance.ln()
    } else {
        1.0
    }
}

/// Returns the terms of the comparison that also improve left-out readings.
fn stand(
    field: &mut Field<'_, '_>,
    weights: &Weights,
    chosen: &[Chosen],
    rejections: &mut Rejections,
    note: &mut dyn FnMut(&str, f64),
) -> Vec<(Taken, f64)> {
    let numbers: Vec<usize> = chosen.iter().map(|one| one.candidate).collect();
    let judged: Vec<Taken> = chosen.iter().map(|one| Taken { candidate: one.candidate, chance: one.chance }).collect();
    let mut out = |term: &Taken, gain| rejections.add(term, Gate::Unseen, gain);
    let mut selections = held_out::settled(&numbers);
    confirmed(field, weights, judged, &mut selections, &mut out, &mut |share| note("held-out parts", share))
}

/// Returns the candidates of all causes in a scene.
pub(super) fn propose(causes: &Causes, scene: &Scene<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    causes.iter().for_each(|cause| cause.propose(scene, &mut candidates));
    candidates
}

fn verdict(
    (field, causes): (&Field<'_, '_>, &Causes),
    bare: &Scene<'_>,
    [weights, held_out]: [&Weights; 2],
    (kept, chosen, reversed): (&[(Taken, f64)], &[Chosen], Option<&ReversedReadings>),
    (used, not_confirmed, rejections): (usize, Vec<Candidate>, &Rejections),
) -> DiagnosedCauses {
    let scene = field.scene;
    let taken: Vec<usize> = kept.iter().map(|(term, _)| term.candidate).collect();
    let memory = field.memory(weights, &taken);
    let columns: Vec<Vec<Vec<f64>>> =
        taken.iter().filter_map(|&number| field.candidates.get(number)).map(|one| field.columns(one)).collect();
    let flat: Vec<Vec<f64>> = columns.iter().flatten().cloned().collect();
    let (amounts, _) = field.series(weights, &[], memory).amounts(&flat);
    // The uncertainty of the time constants increases that of the amounts.
    let with_slopes: Vec<Vec<f64>> = flat.iter().cloned().chain(slopes(field, &taken, &columns, &amounts)).collect();
    let (_, covariance) = field.series(weights, &[], memory).amounts(&with_slopes);
    let is_change =
        |number: &usize| field.candidates.get(*number).is_some_and(|one| one.cause.effect == EffectKind::Earlier);
    let of_certificates = certified::moves(field, weights, &flat, memory);
    let without_parts = without_parts(field, weights, (&flat, taken.iter().any(is_change)), memory);
    let whole = field.series(weights, &taken, memory);
    let freedom = (whole.count() - whole.rank().min(whole.count())).max(1) as f64;
    let noise = whole.squares() / freedom;
    let of_shares = shares(field, weights, &taken);
    let ranges: Vec<std::ops::Range<usize>> = ranges(columns.iter().map(Vec::len));
    let volume = Volume::new(scene, |row| row.set < used);
    let swapped = field.swapped(weights, &taken, (memory, noise));
    let mut findings = Vec::new();
    for (((term, gain), range), share) in kept.iter().zip(ranges).zip(of_shares) {
        let Some(candidate) = field.candidates.get(term.candidate) else { continue };
        let slopes = field.mean_slopes(weights, candidate);
        let leveled = slopes.as_ref().map(|_| Candidate { term: Term::None, ..candidate.clone() });
        let candidate = leveled.as_ref().unwrap_or(candidate);
        let level = |amounts: Amounts| match &slopes {
            Some(slopes) => slopes.level(amounts),
            None => amounts,
        };
        let others: Vec<usize> = taken.iter().copied().filter(|&other| other != term.candidate).collect();
        let inflation = field.inflation(weights, &taken, &others, term.candidate);
        // The amount also depends on which other causes there are.
        let between = chosen.iter().find(|one| one.candidate == term.candidate).map_or(0.0, |one| one.between);
        let of_pair = |k: usize, l: usize| {
            covariance[(k, l)] * noise * inflation
                + if k == l && range.len() == 1 { between } else { 0.0 }
                + of_certificates.iter().map(|moves| moves[k] * moves[l]).sum::<f64>()
        };
        let amounts = level(Amounts {
            values: amounts.get(range.clone()).unwrap_or_default().to_vec(),
            covariance: range.clone().map(|k| range.clone().map(|l| of_pair(k, l)).collect()).collect(),
        });
        let own_without: Vec<Amounts> =
            without_parts.iter().map(|without| level(without.of(&range, noise * inflation))).collect();
        let mut size = size(candidate, &amounts, scene, used);
        let formal = size.u95;
        size.u95 = size.u95.max(u95(candidate, &amounts, &own_without, scene, used).unwrap_or(0.0));
        // Omitted parts increase the uncertainties of size and amounts alike.
        let widening = if formal > 0.0 { size.u95 / formal } else { 1.0 };
        let does = doing(field, weights, weights, &taken, term.candidate);
        let rms = rms(counts(scene, weights).into_iter().filter_map(|place| does.get(place).copied()));
        let alone = swing(scene, weights, &does);
        let is_partly_visible = absorbed(candidate, &size, alone);
        if is_partly_visible {
            let squares: f64 = does.iter().zip(&weights.items).map(|(own, weight)| (own * weight).powi(2)).sum();
            let scatter = candidate.columns.len() as f64 * noise * inflation;
            let u95 = um_from_mm(alone) * EXPANDED * (scatter / squares.max(f64::MIN_POSITIVE)).sqrt();
            size = Size { value: um_from_mm(alone), u95, unit: "um" };
        }
        let beside = field.series(weights, &others, memory);
        let gains = field.gains(weights, &beside);
        let class = class(field, &gains, term.candidate, noise * inflation);
        let rival = class.get(1).and_then(|&number| field.candidates.get(number));
        let (is_wave, scatter) = (candidate.cause.effect == EffectKind::Periodic, (memory, noise * inflation));
        let (aliases, of_waves) = if is_wave {
            (field.aliases(weights, term.candidate, &others, scatter), 1.0)
        } else {
            field.mimics(weights, term.candidate, &others, scatter)
        };
        let separate_by = match aliases.last() {
            Some(shortest) => Some(separate::steps(scene, candidate, *shortest)),
            None => rival.map(|rival| separating(scene, candidate, rival)),
        };
        // A term of the comparison is compared with all explanations.
        let of_chosen = chosen.iter().find(|one| one.candidate == term.candidate).map(|one| {
            let rivals = one.harmful.clone()?;
            let named = |one: &&Candidate| rivals.first().is_some_and(|id| one.id() == *id);
            let rival = field.candidates.iter().find(named).or(rival);
            let separate_by = match rival {
                Some(rival) => separating(scene, candidate, rival),
                None => candidate.cause.separate_by.to_owned(),
            };
            Some(ExtrapolationRisk { rivals: rivals.iter().map(ToString::to_string).collect(), separate_by })
        });
        let by_class = || {
            volume
                .as_ref()
                .and_then(|volume| field.doubt(weights, volume, (term.candidate, &others), (&amounts, &class), scatter))
                .or_else(|| field.wave_doubt(weights, &taken, term.candidate))
        };
        // Compared with all explanations and with its class. Effects that the comparison does not cover are compared with their class only.
        let effect = candidate.cause.effect;
        let is_compared = matches!(effect, EffectKind::Location | EffectKind::Motion | EffectKind::Backlash);
        let undecided = field.undecided((&beside, &gains), (term.candidate, &others), noise * inflation);
        // A wave with the same values at the measured places is another error between them.
        let of_wave = aliases.first().filter(|_| of_waves < CERTAIN).map(|period| RivalCause {
            cause: CauseId::Effect(periodic::CAUSE.effect, separate::every(&candidate.parameter, *period)),
            probability: (1.0 - of_waves) * undecided.own,
        });
        let relative = field.relative_scale(weights, term.candidate);
        // A common scale of all axes is as frequent as one of a single axis: temperature does both.
        let of_scale = relative.as_ref().map_or(1.0, |_| 1.0 / (1.0 + Family::Scale.assumption().odds));
        let of_others = relative
            .as_ref()
            .map(|(cause, _)| RivalCause { cause: cause.clone(), probability: (1.0 - of_scale) * undecided.own });
        let of_both_signs = undecided.own * of_waves.min(1.0) * of_scale;
        let of_sign = reversed.map_or_else(Vec::new, |one| one.rivals(term.candidate, &amounts.values, of_both_signs));
        let own_share = of_both_signs - of_sign.iter().map(|rival| rival.probability).sum::<f64>();
        let reversed = reversed.filter(|_| !of_sign.is_empty());
        // Of two set-ups, either may have the wrong scale.
        let swap = swapped.iter().find(|swap| swap.number == term.candidate);
        let of_swap: Vec<RivalCause> = swap
            .iter()
            .flat_map(|swap| &swap.rivals)
            .map(|rival| RivalCause { cause: rival.cause.clone(), probability: own_share * rival.probability })
            .collect();
        let own_share = own_share - of_swap.iter().map(|rival| rival.probability).sum::<f64>();
        let resized = if swap.is_some_and(|swap| !swap.is_itself) { of_swap.clone() } else { Vec::new() };
        let of_natures = if undecided.is_certain() { Vec::new() } else { field.rivals(&undecided) };
        let mut rivals: Vec<RivalCause> = of_natures
            .into_iter()
            .chain(of_wave)
            .chain(of_others)
            .chain(of_sign)
            .chain(of_swap.iter().cloned())
            .collect();
        rivals.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let doubt = reversed.filter(|_| own_share < CERTAIN).map(ReversedReadings::doubt);
        let of_setups = ExtrapolationRisk {
            rivals: of_swap.into_iter().map(|rival| rival.cause.to_string()).collect(),
            separate_by: "the same line measured once more with another mounting or instrument, and the temperature of the axis noted".to_owned(),
        };
        let doubt = doubt.or(Some(of_setups).filter(|risk| own_share < CERTAIN && !risk.rivals.is_empty()));
        let doubt = doubt.or_else(|| field.nature_doubt(candidate, &undecided)).or(relative.map(|(_, risk)| risk));
        let doubt = doubt.or_else(|| of_chosen.flatten().filter(|_| is_compared)).or_else(by_class);
        // Itself, its other periods, and the other explanations.
        let mut names: Vec<(&'static Cause, String)> = class
            .iter()
            .filter_map(|&number| field.candidates.get(number))
            .map(|one| (one.cause, one.parameter.clone()))
            .collect();
        let of_alias = aliases.iter().map(|period| (&periodic::CAUSE, separate::every(&candidate.parameter, *period)));
        names.splice(names.len().min(1)..names.len().min(1), of_alias);
        let by_file = differing(field, weights, (candidate, &amounts.values), &others, (memory, inflation));
        let arm =
            volume.as_ref().and_then(|volume| field.elsewhere(volume, &beside, (candidate, &amounts.values), &class));
        findings.push(AcceptedCause {
            arm,
            resized,
            by_file,
            size,
            is_partly_visible,
            rms,
            alone,
            doing: does,
            amounts: amounts.widened(widening),
            chance: term.chance,
            probability: (own_share < CERTAIN).then_some(own_share),
            nature_share: own_share,
            rivals,
            gain_unseen: *gain,
            share,
            // The reason that makes a correction unsafe comes first.
            separate_by: doubt.as_ref().map(|doubt| doubt.separate_by.clone()).or(separate_by),
            class: names,
            same_as: class.iter().filter_map(|&other| field.same_squareness(weights, term.candidate, other)).collect(),
            aliases,
            doubt,
            candidate: candidate.clone(),
        });
    }
    // Order of the gain on left-out readings: terms that nearly cancel each other are large but gain little.
    findings.sort_by(|a, b| b.gain_unseen.total_cmp(&a.gain_unseen).then(b.rms.total_cmp(&a.rms)));
    let dropped = |weights: &Weights, is_used: bool| -> Vec<(usize, usize)> {
        let items =
            scene.items.iter().zip(&weights.items).filter(|(item, weight)| **weight == 0.0 && item.sigma.is_finite());
        let rows = items.filter_map(|(item, _)| scene.rows.get(item.row));
        rows.filter(|row| (row.set < used) == is_used).map(|row| (row.set, row.number)).collect()
    };
    let mut outliers = dropped(weights, true);
    outliers.dedup();
    let values: Vec<f64> = scene.items.iter().map(|item| item.left).collect();
    let without: Vec<f64> = bare.items.iter().map(|item| item.left).collect();
    let explained = field.left_with(weights, &taken);
    let left = [left_of(field, weights, &taken), projected(field, held_out, &explained)];
    let before = [weights, held_out].map(|on| projected(field, on, &values));
    let compared = |on: &Weights, k: usize| compare(scene, on, [&projected(field, on, &without), &before[k], &left[k]]);
    let parts = [(weights, before[0].as_slice(), left[0].as_slice()), (held_out, &before[1], &left[1])];
    DiagnosedCauses {
        used: compared(weights, 0),
        held_out: (!counts(scene, held_out).is_empty()).then(|| compared(held_out, 1)),
        findings,
        not_confirmed,
        rejected: rejections.list(field, weights, (&taken, used), (memory, noise)),
        causes: tried((field, causes), weights, &taken, memory),
        account: Account::new(scene, parts, &values, &explained),
        outliers,
        left: noise::look(field, weights, &left[0]),
        explanations: Vec::new(),
        nothing: None,
        next: Vec::new(),
        contradiction: reversed.map(|reversed| reversed.contradiction.clone()),
        tried: field.tried,
        memory,
    }
}

/// True if the readings show only a part of a shape: its size over the places is not determined, or far exceeds its effect on them.
fn absorbed(candidate: &Candidate, size: &Size, alone: f64) -> bool {
    let is_shape = candidate.columns.len() > 1
        && matches!(
            candidate.cause.effect,
            EffectKind::Motion | EffectKind::Cross | EffectKind::Drift | EffectKind::Unknown
        );
    is_shape
        && !size::is_angle(candidate)
        && (size.u95 >= size.value.abs() || size.value.abs() > FAR * um_from_mm(alone))
}

/// Returns the derivative of the effect with respect to the relative change of each time constant.
fn slopes(field: &Field<'_, '_>, taken: &[usize], columns: &[Vec<Vec<f64>>], amounts: &[f64]) -> Vec<Vec<f64>> {
    let mut out = Vec::new();
    let mut place = 0;
    for (&number, own) in taken.iter().zip(columns) {
        let amounts = amounts.get(place..place + own.len()).unwrap_or_default();
        place += own.len();
        let Some(one) = field.candidates.get(number) else { continue };
        let Some((lag, _)) = one.constant.filter(|_| one.sensor.is_some()) else { continue };
        let Some(longer) = thermal::with_lag(field.scene, one, lag * (1.0 + LONGER)) else { continue };
        let mut slope = vec![0.0; field.scene.items.len()];
        for ((column, longer), amount) in own.iter().zip(field.columns(&longer)).zip(amounts) {
            for ((sum, value), more) in slope.iter_mut().zip(column).zip(longer) {
                *sum += amount * (more - value) / LONGER;
            }
        }
        out.push(slope);
    }
    out
}

/// Returns the range of the columns of each group among all columns.
fn ranges(lengths: impl Iterator<Item = usize>) -> Vec<std::ops::Range<usize>> {
    lengths
        .scan(0, |place, length| {
            *place += length;
            Some(*place - length..*place)
        })
        .collect()
}

/// True if a scene has only readings of angles: then sizes are in rad.
#[must_use]
pub fn reads_angles(scene: &Scene<'_>) -> bool {
    is_angle(scene)
}
