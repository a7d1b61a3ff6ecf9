//! Extension of the machine file by accepted causes: parameters of the geometry, and entries for everything else, each with its size and evidence in
//! a note.
//!
//! [`extension`] returns for every cause the [`Change`]s of the file that hold it, or the reason why none does. [`change`] applies them to the text,
//! and [`note`] writes the notes.

pub mod change;
mod entry;
mod law;
pub mod note;
mod warm;

use crate::calibrate::Parameter;
use crate::calibrate::effect::effect_parameters;
use crate::measure::data::DataSet;
use ncfix_base::number::percent;
use ncfix_base::numeric::sums::dot;
use ncfix_base::units::um_from_mm;
use ncfix_model::name::ErrorName;
use ncfix_model::parameter::ComponentTerm;
use ncfix_model::{ErrorModel, ParameterName};

use super::cause::{Candidate, Correctable, EffectKind, Term};
use super::doubt::ExtrapolationRisk;
use super::row::{NOWHERE, SceneRow};
use super::scene::{NO_ROW, Scene, Through};
use super::size::weights_at;
use super::verdict::{AcceptedCause, DiagnosedCauses};
pub use change::{Anchor, Change};

/// µrad in a rad.
const MICRO: f64 = 1e6;
/// A constant belongs to the set-ups if its uncertainty exceeds that of the size by this factor.
const VAGUE: f64 = 30.0;

/// Largest plausible deviation of a machine from its model, mm.
const MOST_MM: f64 = 1.0;
/// A polynomial is not used beyond the measured range if its range of values increases there by more than this share, sampled at this number of
/// points of the travel.
const REACHES: f64 = 0.5;
const LOOKS: u32 = 64;
/// A cause is cancelled by others if its effect exceeds the residual of the model by this factor.
const CANCELS: f64 = 1.5;

/// A cause with at least this probability is certainly present.
const SURELY: f64 = 0.95;
/// Effects with a correlation below the negative of this are parts of one effect.
const AGAINST: f64 = 0.3;

/// The changes for every cause of a diagnosis, or the reason why the machine file cannot hold it. `used` is the number of measurements used, the
/// first ones of the scene.
#[must_use]
pub fn extension(found: &DiagnosedCauses, scene: &Scene<'_>, used: usize) -> Vec<Result<Vec<Change>, String>> {
    let left = present(found).unwrap_or(found.used.before.rms);
    let sound = |one: &AcceptedCause| is_sound(one, left).and_then(|()| changes(one, scene, used));
    let mut out: Vec<Result<Vec<Change>, String>> = found.findings.iter().map(sound).collect();
    while let Some(number) = leaning(found, scene, &out) {
        if let Some(one) = out.get_mut(number) {
            *one = Err("this correction is right only together with causes that are not corrected; alone, it could increase the error; measure what separates those from their other explanations".into());
        }
    }
    out
}

/// Residual of the model, mm or rad, if the machine had always been as it is in the last file; `None` if it did not change between files.
fn present(found: &DiagnosedCauses) -> Option<f64> {
    let earlier: Vec<&AcceptedCause> =
        found.findings.iter().filter(|one| one.candidate.cause.effect == EffectKind::Earlier).collect();
    if earlier.is_empty() {
        return None;
    }
    let places = found.account.before.iter().zip(&found.account.counts).enumerate().filter(|(_, (_, counts))| **counts);
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for (place, (before, _)) in places {
        let less: f64 = earlier.iter().filter_map(|one| one.doing.get(place)).sum();
        sum += (before - less).powi(2);
        count += 1.0;
    }
    Some((sum / count.max(1.0)).sqrt())
}

/// The changes for an additional cause, or the reason why the machine file cannot hold it; `left` is the residual of the model, mm or rad.
///
/// # Errors
/// The reason why it cannot.
pub(super) fn of_one(
    one: &AcceptedCause,
    left: f64,
    (scene, used): (&Scene<'_>, usize),
) -> Result<Vec<Change>, String> {
    is_sound(one, left).and_then(|()| changes(one, scene, used))
}

/// The changes for a term stated by the user, or the reason why the machine file cannot hold it.
///
/// # Errors
/// The reason why it cannot.
pub(super) fn of_stated(one: &AcceptedCause, scene: &Scene<'_>, used: usize) -> Result<Vec<Change>, String> {
    changes(one, scene, used)
}

/// The cause whose removal most improves the fit of the written causes to the readings; `None` if no removal improves it, or if all causes are
/// written.
fn leaning(found: &DiagnosedCauses, scene: &Scene<'_>, written: &[Result<Vec<Change>, String>]) -> Option<usize> {
    let is_written = |number: &usize| written.get(*number).is_some_and(Result::is_ok);
    let numbers: Vec<usize> = (0..found.findings.len()).filter(is_written).collect();
    if numbers.len() == found.findings.len() {
        return None;
    }
    let squares = |numbers: &[usize]| -> f64 {
        let left = |place: usize| {
            let does = |number: &usize| found.findings.get(*number)?.doing.get(place).copied();
            found.account.before.get(place).copied().unwrap_or(0.0) - numbers.iter().filter_map(does).sum::<f64>()
        };
        let items = scene.items.iter().zip(&found.account.counts).enumerate();
        let counted = items.filter(|(_, (item, counts))| **counts && item.sigma.is_finite() && item.sigma > 0.0);
        counted.map(|(place, (item, _))| (left(place) / item.sigma).powi(2)).sum()
    };
    // A cause that nearly cancels a part of an unwritten one belongs to that one.
    let doing = |number: usize| found.findings.get(number).map_or(&[][..], |one| one.doing.as_slice());
    let cancels = |one: usize, other: usize| {
        let [own, with, others] = [(one, one), (one, other), (other, other)].map(|(a, b)| dot(doing(a), doing(b)));
        with < -AGAINST * (own * others).sqrt()
    };
    // Two causes that are both certainly present are not parts of one.
    let is_sure = |number: usize| {
        let Some(one) = found.findings.get(number) else { return false };
        let name = |one: &AcceptedCause| (one.candidate.cause.effect, one.candidate.parameter.clone());
        // Two variants of one cause share its probability.
        let is_single = found.findings.iter().filter(|other| name(other) == name(one)).count() == 1;
        is_single && one.probability.is_some_and(|probability| probability >= SURELY)
    };
    let is_against = |one: &usize| {
        (0..found.findings.len())
            .any(|other| !is_written(&other) && cancels(*one, other) && !(is_sure(*one) && is_sure(other)))
    };
    if let Some(&one) = numbers.iter().find(|one| is_against(one)) {
        return Some(one);
    }
    let whole = squares(&numbers);
    // They are then all written, unless the readings of the present machine would be worse than without any.
    let is_earlier = |&number: &usize| found.findings[number].candidate.cause.effect == EffectKind::Earlier;
    let earlier: Vec<usize> = (0..found.findings.len()).filter(is_earlier).collect();
    let present: Vec<usize> = earlier.iter().copied().chain(numbers.iter().copied()).collect();
    if (0..found.findings.len()).all(is_sure) && squares(&present) <= squares(&earlier) {
        return None;
    }
    let without = |number: usize| {
        let rest: Vec<usize> = numbers.iter().copied().filter(|&other| other != number).collect();
        (squares(&rest), number)
    };
    let worst = numbers.iter().map(|&number| without(number)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    (worst.0 <= whole).then_some(worst.1)
}

/// Refuses causes that must not move a program: a wave whose period is not identifiable; terms that nearly cancel each other and so far exceed the
/// residual; a cause whose uncertainty exceeds its size, so that even its sign is open.
///
/// # Errors
/// The reason for the refusal.
fn is_sound(one: &AcceptedCause, left: f64) -> Result<(), String> {
    if largest(one.size.unit).is_some_and(|most| one.size.value.abs() > most) || one.rms > MOST_MM {
        return Err(
            "the size is not plausible for a machine: the columns, their units or the description do not match the measurement"
                .into(),
        );
    }
    if !one.aliases.is_empty() {
        let what = if one.candidate.cause.effect == EffectKind::Periodic {
            "other periods explain it equally well"
        } else {
            "short waves of other periods have the same effect at the measured positions"
        };
        return Err(format!(
            "{what}: between these positions its effect is not known; measure at unevenly spaced points or in small steps"
        ));
    }
    if one.is_partly_visible {
        return Err("the unknowns of the set-ups or other findings absorb a part of it, so only the remaining part is determined; describe what is known of the set-ups, or measure more of them".into());
    }
    if one.rms > CANCELS * left {
        let times = one.rms / left;
        return Err(format!(
            "alone its effect is {times:.1} times the residual of the model: other findings cancel it only at the measured positions; measure at more positions"
        ));
    }
    if let Some(doubt) = &one.doubt {
        return Err(doubtful(doubt));
    }
    if !one.by_file.is_empty() {
        return Err(
            "it differs between files: the machine or the measurement changed between them; diagnose the latest file alone"
                .into(),
        );
    }
    if one.size.u95 >= one.size.value.abs() {
        return Err("its uncertainty exceeds its size; measure more often or at more positions".into());
    }
    if !one.is_certain() {
        let how = one.separate_by.as_deref().unwrap_or(one.candidate.cause.separate_by);
        return Err(match one.probability {
            Some(probability) => format!("its probability is only {}; measure {how}", percent(probability)),
            None => format!("it was not compared with other explanations; measure {how}"),
        });
    }
    Ok(())
}

/// The reason why a cause with an extrapolation risk is not corrected.
fn doubtful(doubt: &ExtrapolationRisk) -> String {
    if doubt.rivals.is_empty() {
        return format!("over the whole travel its uncertainty exceeds its size; measure {}", doubt.separate_by);
    }
    let (verb, does) = if doubt.rivals.len() > 1 { ("have", "together ") } else { ("has", "") };
    format!(
        "{} {does}{verb} the same effect on these readings, but a different effect at other positions or times, so a correction could increase the error; to separate them: {}",
        doubt.rivals.join(" and "),
        doubt.separate_by
    )
}

/// Largest plausible size in a unit.
fn largest(unit: &str) -> Option<f64> {
    match unit {
        "um" => Some(um_from_mm(MOST_MM)),
        "urad" | "um/m" | "urad/rad" => Some(10.0 * um_from_mm(MOST_MM)),
        _ => None,
    }
}

fn changes(one: &AcceptedCause, scene: &Scene<'_>, used: usize) -> Result<Vec<Change>, String> {
    let candidate = &one.candidate;
    if let Term::Parameters(names) = &candidate.term {
        let all = names.iter().zip(&one.amounts.values).enumerate();
        // An amount that depends on the others is 0 and stays 0. A constant that set-ups can absorb is arbitrary.
        let sizes = one.size.u95 / MICRO;
        let is_told = |&(k, (name, amount)): &(usize, (&ParameterName, &f64))| {
            let is_constant = names.len() > 1 && name.term == ComponentTerm::Coefficient(0);
            *amount != 0.0 && !(is_constant && one.amounts.u95(k) > VAGUE * sizes)
        };
        if reaches_out(candidate, &one.amounts.values, scene, used) {
            // Without amounts that set-ups can absorb: the fitted shape over the measured range, and constant beyond it.
            let mut told = one.clone();
            for ((k, (_, amount)), own) in all.clone().zip(&mut told.amounts.values) {
                if !is_told(&(k, (&names[k], amount))) {
                    *own = 0.0;
                }
            }
            return law::law(&told, scene, used).map(|change| vec![change]);
        }
        let all = all.filter(is_told);
        return Ok(all.map(|(_, (name, amount))| Change::Parameter { name: *name, amount: *amount }).collect());
    }
    if let Term::File(term) = &candidate.term {
        return term.changes(&one.amounts.values);
    }
    match candidate.cause.effect {
        EffectKind::Periodic => entry::periodic(one, scene),
        EffectKind::ThermalExpansion => entry::expansion(one, scene),
        EffectKind::ThermalDrift => entry::drift(one),
        EffectKind::Load => entry::load(one, scene),
        EffectKind::Backlash | EffectKind::LateralPlay | EffectKind::Cross | EffectKind::Unknown | EffectKind::Motion => {
            law::law(one, scene, used).map(|change| vec![change])
        }
        EffectKind::ThermalSquareness => Err("the machine file has no angle between axes that depends on a temperature: setting the zero point removes a drift, but not an angle; beams ([[segment]]) tilt axes if the structure and its sensors are known"
            .into()),
        EffectKind::Drift => {
            Err("it depends on time, and the time at which a program will run is not known; log temperatures: the machine file can hold a drift only if it follows a temperature ([[drift]])"
                .into())
        }
        EffectKind::Setup | EffectKind::Probe => Err("it belongs to the instrument and its set-up, not to the machine".into()),
        EffectKind::SpindleSpeed => {
            Err("it depends on the spindle speed, and errors of the machine file do not; with a temperature sensor at the spindle it is a drift that follows a temperature, which the machine file can hold ([[drift]])"
                .into())
        }
        EffectKind::Earlier => Err("this was the state in earlier files; the machine file has the current state".into()),
        EffectKind::Sensor | EffectKind::Outlier | EffectKind::Program => Err("it belongs to the data, not to the machine".into()),
        EffectKind::Dynamic => Err("it depends on the acceleration, not on the position: ncfix decompose fits it to traces and writes [[dynamic]]; a lower feed makes it smaller"
            .into()),
        EffectKind::ServoMismatch | EffectKind::Following | EffectKind::Delay | EffectKind::ReversalSpike => Err(
            "it depends on the speed or on earlier motion, but errors of the machine file depend on positions: tune the drive, or compensate it in the control"
                .into(),
        ),
        EffectKind::Location | EffectKind::Own(_) => Err("it has no parameter of the error model".into()),
    }
}

/// True if a shape of one axis that is not a straight line has a larger effect outside the measured range than inside.
fn reaches_out(candidate: &Candidate, amounts: &[f64], scene: &Scene<'_>, used: usize) -> bool {
    let Some(axis) = component(candidate).and_then(|name| name.axis()).filter(|axis| !axis.is_rotary()) else {
        return false;
    };
    let is_straight = |name: &ParameterName| {
        matches!(name.term, ComponentTerm::Coefficient(0 | 1) | ComponentTerm::Whole | ComponentTerm::Backlash)
    };
    if !matches!(&candidate.term, Term::Parameters(names) if !names.iter().all(is_straight)) {
        return false;
    }
    let rows = || scene.rows.iter().filter(|row| row.set < used);
    let travel = scene.machine.axis(axis).and_then(|data| data.travel);
    let (Some(first), Some([low, high])) = (rows().next(), travel) else { return false };
    let value = |place: f64| {
        let mut row = SceneRow { number: NOWHERE, ..first.clone() };
        row.position[axis] = place;
        weights_at(candidate, &row).iter().zip(amounts).map(|(weight, amount)| weight * amount).sum::<f64>()
    };
    let ends = |all: &mut dyn Iterator<Item = f64>| {
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
    };
    let inside = ends(&mut rows().map(|row| value(row.position[axis])));
    let looks = (0..=LOOKS).map(|k| low + (high - low) * f64::from(k) / f64::from(LOOKS));
    let outside = ends(&mut looks.map(value));
    (inside[0] - outside[0]).max(outside[1] - inside[1]) > REACHES * (inside[1] - inside[0])
}

/// The component through which all columns act; `None` if there are several.
fn component(candidate: &Candidate) -> Option<ErrorName> {
    let mut all = candidate.columns.iter().flatten().map(|(through, _)| *through);
    let Through::Component(name) = all.next()? else { return None };
    (candidate.columns.iter().all(|parts| parts.len() == 1) && all.all(|own| own == Through::Component(name)))
        .then_some(name)
}

/// The effect of a cause on every reading of a scene, mm or rad.
fn doing(one: &AcceptedCause, scene: &Scene<'_>) -> Vec<f64> {
    let mut out = vec![0.0; scene.items.len()];
    for (parts, amount) in one.candidate.columns.iter().zip(&one.amounts.values) {
        let mut column = vec![0.0; scene.items.len()];
        for (through, weight) in parts {
            for ((value, factor), item) in column.iter_mut().zip(scene.factors(*through)).zip(&scene.items) {
                if let Some(row) = scene.rows.get(item.row) {
                    *value += factor * weight.of(row);
                }
            }
        }
        scene.add_along(&mut column, parts);
        out.iter_mut().zip(&column).for_each(|(out, value)| *out += amount * value);
    }
    out
}

/// The effect on every reading of a scene of the causes that the file does not hold, mm or rad.
#[must_use]
pub fn effect_of_others(found: &DiagnosedCauses, scene: &Scene<'_>, holds: &[bool]) -> Vec<f64> {
    let mut away = vec![0.0; scene.items.len()];
    for (one, _) in found.findings.iter().zip(holds).filter(|(_, holds)| !**holds) {
        away.iter_mut().zip(doing(one, scene)).for_each(|(away, own)| *away += own);
    }
    away
}

/// The used measurements, without rejected readings and without the effects of causes that the file does not hold. The terms in the file are fitted
/// to them again. `None` if these effects cannot be subtracted from the readings.
#[must_use]
pub fn cleaned(found: &DiagnosedCauses, scene: &Scene<'_>, used: usize, holds: &[bool]) -> Option<Vec<DataSet>> {
    let mut sets: Vec<DataSet> = scene.sets.iter().take(used).cloned().collect();
    let is_less = found.findings.iter().zip(holds).any(|(_, holds)| !*holds);
    let away = effect_of_others(found, scene, holds);
    let mut out: Vec<(usize, usize)> = Vec::new();
    for (item, away) in scene.items.iter().zip(away).filter(|(item, _)| item.row != NO_ROW) {
        let Some(row) = scene.rows.get(item.row).filter(|row| row.set < used) else { continue };
        let observation = sets.get_mut(row.set).and_then(|set| set.observations.get_mut(row.number));
        let Some(value) = observation.and_then(|own| own.values.get_mut(item.value)) else { continue };
        let counts = item.sigma.is_finite() && !found.outliers.contains(&(row.set, row.number));
        match value {
            Some(_) if !counts => *value = None,
            Some(value) => *value -= away,
            // A probing has no values: its reading is the positions of the axes.
            None if !counts => out.push((row.set, row.number)),
            None if is_less => return None,
            None => {}
        }
    }
    out.sort_unstable();
    out.dedup();
    for (set, number) in out.into_iter().rev() {
        if let Some(set) = sets.get_mut(set) {
            set.observations.remove(number);
        }
    }
    Some(sets)
}

/// Parameters of an extended model that a joint fit determines again: those to which errors are proportional, and time constants of drifts.
#[must_use]
pub fn again(original: &ErrorModel, read: &ErrorModel, changes: &[Change]) -> Vec<Parameter> {
    let of = |errors: &ErrorModel| -> Vec<Parameter> {
        effect_parameters(errors).into_iter().map(Parameter::from).collect()
    };
    let known: Vec<(String, u64)> =
        of(original).iter().map(|one| (one.to_string(), one.get(original).to_bits())).collect();
    // New parameters, and those with a changed value.
    let new = of(read).into_iter().filter(|one| !known.contains(&(one.to_string(), one.get(read).to_bits())));
    let is_lag = |name: &str| name.starts_with("drift.") && name.ends_with(".lag_s");
    let mut out: Vec<Parameter> = new.filter(|one| one.is_linear() || is_lag(&one.to_string())).collect();
    for change in changes {
        if let Change::Parameter { name, .. } = change {
            let own = Parameter::from(*name);
            if !out.contains(&own) {
                out.push(own);
            }
        }
    }
    out
}

/// The remedy for a cause, as text.
fn remedy(candidate: &Candidate) -> &'static str {
    match candidate.cause.correctable {
        Correctable::Program => "a corrected program removes it",
        Correctable::Live => "only live readings can remove it",
        // A table in the file corrects an effect without a known cause.
        Correctable::No => "a corrected program removes it, whatever its cause",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::share::VarianceShare;
    use crate::diagnose::size::{Amounts, Size};

    pub(super) fn finding(um: f64, rms: f64) -> AcceptedCause {
        AcceptedCause {
            candidate: bench::candidate(EffectKind::Motion, Through::Component("EXX".parse().unwrap()), |_| 1.0),
            amounts: Amounts::default(),
            size: Size { value: um, u95: 0.1, unit: "um" },
            is_partly_visible: false,
            rms,
            doing: Vec::new(),
            alone: 0.0,
            chance: 0.0,
            probability: Some(1.0),
            nature_share: 1.0,
            rivals: Vec::new(),
            resized: Vec::new(),
            arm: None,
            gain_unseen: 0.0,
            share: VarianceShare::default(),
            class: Vec::new(),
            same_as: Vec::new(),
            aliases: Vec::new(),
            doubt: None,
            by_file: Vec::new(),
            separate_by: None,
        }
    }

    #[test]
    fn no_machine_errs_by_more_than_a_millimetre() {
        let why = |um: f64, rms: f64| is_sound(&finding(um, rms), 10.0).err().unwrap_or_default();
        assert_eq!(why(900.0, 0.9), "");
        assert!(why(1100.0, 0.5).contains("not plausible for a machine"));
        // A small size may have a large effect on the readings.
        assert!(why(500.0, 1.1).contains("not plausible for a machine"));
    }

    #[test]
    fn what_does_more_than_there_is_left_is_cancelled_by_others() {
        let why = |rms: f64| is_sound(&finding(100.0, rms), 0.1).err().unwrap_or_default();
        assert_eq!(why(0.14), "");
        assert!(why(0.2).contains("2.0 times the residual of the model"));
    }

    #[test]
    fn cleaned_data_are_those_that_were_used_without_readings_that_did_not_count() {
        let machine = bench::machine();
        let sets = [bench::reads_along_x(&machine, &[1.0; 12]), bench::reads_along_x(&machine, &[2.0; 12])];
        let scene = bench::scene(&machine, &sets);
        let mut found = crate::diagnose::diagnose(&scene, &scene, 1, &mut |_, _| {});
        (found.findings, found.outliers) = (vec![finding(5.0, 5e-3)], vec![(0, 3)]);
        found.findings[0].candidate = bench::candidate(EffectKind::Unknown, Through::Tip(0), |_| 1.0);
        found.findings[0].amounts = Amounts { values: vec![0.25e-3], covariance: vec![vec![0.0]] };
        let reads = |holds: bool| -> Vec<Vec<Option<f64>>> {
            let sets = cleaned(&found, &scene, 1, &[holds]).unwrap();
            let round = |value: f64| (value * 1e9).round() / 1e6;
            sets.iter().map(|set| set.observations.iter().map(|one| one.values[0].map(round)).collect()).collect()
        };
        let all = |um: f64| (0..12).map(|row| (row != 3).then_some(um)).collect::<Vec<_>>();
        // The effects of causes in the file stay in the readings, those of the others are subtracted.
        assert_eq!(reads(true), [all(1.0)]);
        assert_eq!(reads(false), [all(0.75)]);
    }
}
