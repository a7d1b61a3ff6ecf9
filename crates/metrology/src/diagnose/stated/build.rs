//! Candidates of stated hypotheses: the effect of each term on the readings of a scene.

use std::sync::Arc;

use super::super::cause::{BUILT_IN, Candidate, Cause, EffectKind, UNNAMED, Values, Weight, own, thermal};
use super::super::explain::assumptions::Family;
use super::super::explain::term::{Term as Shape, terms};
use super::super::extend::change::Change;
use super::super::row::SceneRow;
use super::super::scene::{Scene, Through};
use super::super::shape::unit_of;
use super::form::{Factor, Operand, Quantity, StatedTerm};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_model::ParameterName;
use ncfix_model::name::{ErrorKind, ErrorName};

/// mm in a meter, and factor of the units 1000/min, m/min and m/s.
const THOUSAND: f64 = 1e3;
/// Effects of a component and of the tip are equal within this share.
const EQUAL: f64 = 1e-6;
/// Largest deviation of the direction of an axis from a coordinate.
const ALONG: f64 = 1e-6;

/// Unit of the amount of a term, and its columns of the candidate.
#[derive(Clone, Debug)]
pub(super) struct AmountUnit {
    pub(super) term: String,
    /// First column; a wave has two, and its amplitude is the amount.
    pub(super) column: usize,
    pub(super) is_wave: bool,
    /// Factor from the internal unit, mm or rad per unit, to this one.
    pub(super) factor: f64,
    pub(super) unit: String,
}

/// A candidate with the units of the amounts of its terms.
#[derive(Clone, Debug)]
pub(super) struct Built {
    pub(super) candidate: Candidate,
    pub(super) amounts: Vec<AmountUnit>,
}

type OfRow = Arc<dyn Fn(&SceneRow) -> f64 + Send + Sync>;

/// The usual cause of an effect.
fn usual(effect: EffectKind) -> &'static Cause {
    // Lobes of an instrument have the same effect, but descriptions of their own.
    if effect == EffectKind::Unknown {
        return &UNNAMED;
    }
    BUILT_IN.iter().copied().find(|cause| cause.effect == effect).unwrap_or(&UNNAMED)
}

fn at(values: &Values, row: &SceneRow) -> f64 {
    values.get(row.set).and_then(|own| own.get(row.number)).copied().unwrap_or(f64::NAN)
}

/// A driver by row. A temperature is relative to its reference, or to the zero setting of the instrument.
fn by_row(scene: &Scene<'_>, of: &Quantity, (lag_s, is_since_zero): (f64, bool)) -> Result<OfRow, String> {
    Ok(match of {
        &Quantity::Position(axis) => Arc::new(move |row: &SceneRow| row.position[axis]),
        &Quantity::Sense(axis) => Arc::new(move |row: &SceneRow| row.sense_of(axis)),
        &Quantity::Speed(axis) => {
            Arc::new(move |row: &SceneRow| row.velocity.map_or(f64::NAN, |velocity| velocity[axis]))
        }
        Quantity::Time => Arc::new(|row: &SceneRow| row.time_s.unwrap_or(f64::NAN)),
        Quantity::Temperature(column) => {
            let [rise, since_zero] = thermal::rises(scene, column, lag_s).ok_or_else(|| {
                format!("{column} cannot be followed with a lag: the readings have no times (column t_s)")
            })?;
            let values = if is_since_zero { since_zero } else { rise };
            Arc::new(move |row: &SceneRow| at(&values, row))
        }
        Quantity::Column(column) => {
            let values = super::super::cause::column(scene.sets, column)
                .ok_or_else(|| format!("no measurement has the column {column}"))?;
            Arc::new(move |row: &SceneRow| at(&values, row))
        }
    })
}

/// A factor by row: one function, or the sine and the cosine of a wave.
fn of_factor(scene: &Scene<'_>, factor: &Factor, how: (f64, bool)) -> Result<Vec<OfRow>, String> {
    Ok(match factor {
        Factor::Power { of, minus, power } => {
            let (of, power) = (by_row(scene, of, how)?, i32::from(*power));
            match minus {
                None => vec![Arc::new(move |row: &SceneRow| of(row).powi(power))],
                Some(Operand::Number(number)) => {
                    let number = *number;
                    vec![Arc::new(move |row: &SceneRow| (of(row) - number).powi(power))]
                }
                Some(Operand::Quantity(other)) => {
                    let other = by_row(scene, other, how)?;
                    vec![Arc::new(move |row: &SceneRow| (of(row) - other(row)).powi(power))]
                }
            }
        }
        &Factor::Wave { axis, period } => {
            let turn = move |row: &SceneRow| std::f64::consts::TAU * row.position[axis] / period;
            vec![Arc::new(move |row: &SceneRow| turn(row).sin()), Arc::new(move |row: &SceneRow| turn(row).cos())]
        }
        Factor::Step { of, is_above, limit } => {
            let (is_above, limit) = (*is_above, *limit);
            // The limit of a temperature refers to the values in the table.
            let of = match of {
                Quantity::Temperature(column) => by_row(scene, &Quantity::Column(Arc::clone(column)), how)?,
                other => by_row(scene, other, how)?,
            };
            let step = move |row: &SceneRow| {
                let value = of(row);
                if value.is_nan() { value } else { f64::from(u8::from((value > limit) == is_above && value != limit)) }
            };
            vec![Arc::new(step)]
        }
    })
}

/// The columns of a term, by row.
fn of_term(scene: &Scene<'_>, term: &StatedTerm, is_since_zero: bool) -> Result<Vec<Weight>, String> {
    let mut all: Vec<OfRow> = vec![Arc::new(|_: &SceneRow| 1.0)];
    for factor in &term.factors {
        let own = of_factor(scene, factor, (term.lag_s, is_since_zero))?;
        all = own
            .iter()
            .flat_map(|one| {
                all.iter().map(move |known| {
                    let (one, known) = (Arc::clone(one), Arc::clone(known));
                    let product: OfRow = Arc::new(move |row: &SceneRow| one(row) * known(row));
                    product
                })
            })
            .collect();
    }
    Ok(all.into_iter().map(|of| Weight::new(move |row| of(row))).collect())
}

/// The temperature of a factor, or the two temperatures of a difference.
fn temperatures(factor: &Factor) -> Option<(&Arc<str>, Option<&Arc<str>>)> {
    match factor {
        Factor::Power { of: Quantity::Temperature(one), minus: None, power: 1 } => Some((one, None)),
        Factor::Power {
            of: Quantity::Temperature(one),
            minus: Some(Operand::Quantity(Quantity::Temperature(other))),
            power: 1,
        } => Some((one, Some(other))),
        _ => None,
    }
}

/// The axis of a position, a number subtracted from it, and its power.
fn position(factor: &Factor) -> Option<(Axis, Option<f64>, u8)> {
    match factor {
        Factor::Power { of: Quantity::Position(axis), minus: None, power } => Some((*axis, None, *power)),
        Factor::Power { of: Quantity::Position(axis), minus: Some(Operand::Number(from)), power } => {
            Some((*axis, Some(*from), *power))
        }
        _ => None,
    }
}

fn component_of(through: Through) -> Option<ErrorName> {
    match through {
        Through::Component(name) => Some(name),
        _ => None,
    }
}

fn is_rotation(through: Through) -> bool {
    component_of(through).is_some_and(|name| name.direction.is_rotation())
}

/// The effect of a cause of this form.
fn effect(through: Through, terms: &[StatedTerm]) -> EffectKind {
    let component = component_of(through);
    let axis = component.and_then(|name| name.axis());
    let is_own = |other: Axis| axis == Some(other) && component == Some(own(other));
    let is_location = component.is_some_and(|name| name.kind == ErrorKind::Location);
    if let [StatedTerm { factors, .. }] = terms {
        match factors.as_slice() {
            [] if is_location => return EffectKind::Location,
            [Factor::Power { of: Quantity::Sense(sense), minus: None, power: 1 }] if axis == Some(*sense) => {
                return if is_own(*sense) { EffectKind::Backlash } else { EffectKind::LateralPlay };
            }
            [Factor::Power { of: Quantity::Speed(of), minus: None, power: 1 }] if is_own(*of) => {
                return EffectKind::Following;
            }
            [Factor::Power { of: Quantity::Time, .. }] => return EffectKind::Drift,
            [Factor::Wave { axis: of, .. }] if axis == Some(*of) && !is_location => return EffectKind::Periodic,
            [factor] if temperatures(factor).is_some() => {
                return match (is_location, is_rotation(through)) {
                    (true, true) => EffectKind::ThermalSquareness,
                    (false, false) => EffectKind::ThermalDrift,
                    _ => EffectKind::Unknown,
                };
            }
            [one, other] => {
                let is_expansion = |one: &Factor, other: &Factor| {
                    matches!(temperatures(one), Some((_, None)))
                        && position(other).is_some_and(|(axis, _, power)| power == 1 && is_own(axis))
                };
                if is_expansion(one, other) || is_expansion(other, one) {
                    return EffectKind::ThermalExpansion;
                }
            }
            _ => {}
        }
    }
    let all: Option<Vec<Axis>> =
        terms.iter().flat_map(|term| &term.factors).map(|factor| position(factor).map(|(axis, ..)| axis)).collect();
    // A displacement of the tool over one linear axis is a displacement of this axis, and no rarer than it.
    if let (Through::Tip(_), Some([first, others @ ..])) = (through, all.as_deref())
        && !first.is_rotary()
        && others.iter().all(|other| other == first)
    {
        return EffectKind::Motion;
    }
    let Some((all, own)) = all.zip(axis.filter(|_| !is_location)) else { return EffectKind::Unknown };
    let mut others: Vec<Axis> = all.iter().copied().filter(|other| *other != own).collect();
    others.sort_unstable();
    others.dedup();
    match (others.len(), all.contains(&own)) {
        (0, _) => EffectKind::Motion,
        (1, true) => EffectKind::Cross,
        _ => EffectKind::Unknown,
    }
}

/// The parameters of the machine file that the terms correspond to, one for each.
fn parameters(component: ErrorName, effect: EffectKind, terms: &[StatedTerm]) -> Option<Vec<ParameterName>> {
    let one = |term: &StatedTerm| match (effect, term.factors.as_slice()) {
        (EffectKind::Location, []) => Some(ParameterName::location(component)),
        (EffectKind::Motion, []) => Some(ParameterName::coefficient(component, 0)),
        (EffectKind::Motion, [factor]) => match position(factor)? {
            (_, None, power) => Some(ParameterName::coefficient(component, power)),
            _ => None,
        },
        (EffectKind::Backlash | EffectKind::LateralPlay, _) => Some(ParameterName::backlash(component)),
        _ => None,
    };
    terms.iter().map(one).collect()
}

/// The candidate of a sum of terms.
///
/// # Errors
/// The reason why these data have none.
pub(super) fn of_sum(scene: &Scene<'_>, through: Through, terms: &[StatedTerm]) -> Result<Built, String> {
    let effect = effect(through, terms);
    let parameter = match through {
        Through::Tip(direction) => ["X", "Y", "Z"].get(direction).copied().unwrap_or("Z").to_owned(),
        _ => component_of(through).map_or_else(String::new, |name| name.to_string()),
    };
    // A lag belongs to its axis.
    let parameter = match component_of(through).and_then(|name| name.axis()) {
        Some(axis) if effect == EffectKind::Following => axis.to_string(),
        _ => parameter,
    };
    let mut candidate = Candidate::one(usual(effect), parameter, through, Weight::new(|_| 0.0));
    candidate.columns.clear();
    let mut amounts = Vec::new();
    for term in terms {
        let weights = of_term(scene, term, effect == EffectKind::ThermalDrift)?;
        let (factor, unit) = unit(through, term);
        let column = candidate.columns.len();
        let waves = term.factors.iter().filter(|factor| factor.wave_axis().is_some()).count();
        if waves > 1 {
            return Err("a product of two waves has no single amplitude".into());
        }
        amounts.push(AmountUnit { term: term.text.clone(), column, is_wave: waves == 1, factor, unit });
        candidate.columns.extend(weights.into_iter().map(|weight| vec![(through, weight)]));
        for driver in term.drivers() {
            if !candidate.drivers.contains(&driver) {
                candidate.drivers.push(driver);
            }
        }
    }
    if let Some(names) = component_of(through).and_then(|component| parameters(component, effect, terms)) {
        candidate = candidate.extends(&names);
    }
    if let [term] = terms {
        candidate = match effect {
            EffectKind::Periodic => with_period(candidate, term),
            EffectKind::ThermalDrift => with_drift(scene, candidate, (through, term)),
            EffectKind::ThermalExpansion => with_expansion(scene, candidate, term),
            _ => candidate,
        };
    }
    Ok(Built { candidate, amounts })
}

fn with_period(mut candidate: Candidate, term: &StatedTerm) -> Candidate {
    if let [Factor::Wave { axis, period }] = term.factors.as_slice() {
        candidate.constant = Some(if axis.is_rotary() { (period.to_degrees(), "deg") } else { (*period, "mm") });
    }
    candidate
}

/// Name of a sensor by its column.
fn sensor_of(column: &str) -> String {
    column.strip_suffix("_C").unwrap_or(column).to_owned()
}

/// Drift with one sensor or with the difference of two: entries of `[[drift]]`, which describes the tool relative to the workpiece.
fn with_drift(scene: &Scene<'_>, mut candidate: Candidate, (through, term): (Through, &StatedTerm)) -> Candidate {
    let Some((one, other)) = term.factors.first().and_then(temperatures) else { return candidate };
    if other.is_none() {
        candidate.sensor = Some(one.to_string());
        candidate.constant = (term.lag_s > 0.0).then_some((term.lag_s, "s"));
    }
    let index = match through {
        Through::Tip(direction) => direction,
        _ => component_of(through).map_or(0, |name| name.direction.index()),
    };
    let [own, tip] = [through, Through::Tip(index)].map(|through| scene.factors(through));
    let most = tip.iter().fold(0.0, |most, value| f64::max(most, value.abs()));
    let is = |sign: f64| most > 0.0 && own.iter().zip(&tip).all(|(own, tip)| (own - sign * tip).abs() <= EQUAL * most);
    let sign = [1.0, -1.0].into_iter().find(|sign| is(*sign));
    let direction = ["X", "Y", "Z"].get(index).copied().unwrap_or("Z");
    let sensors: Vec<(String, f64)> =
        std::iter::once((sensor_of(one), 1.0)).chain(other.map(|other| (sensor_of(other), -1.0))).collect();
    let lag_s = term.lag_s;
    candidate.written(move |amounts| {
        let sign = sign.ok_or("its effect on the tool turns with an axis, but [[drift]] does not")?;
        let amount = amounts.first().copied().unwrap_or(0.0);
        let change = |(sensor, share): &(String, f64)| Change::Drift {
            direction,
            sensor: sensor.clone(),
            lag_s,
            um_per_k: um_from_mm(sign * share * amount),
        };
        Ok(sensors.iter().map(change).collect())
    })
}

/// Thermal expansion of an axis about its fixed position: `scale` of `[[expansion]]`.
fn with_expansion(scene: &Scene<'_>, candidate: Candidate, term: &StatedTerm) -> Candidate {
    let sensor = term.factors.iter().find_map(temperatures).map(|(sensor, _)| sensor_of(sensor));
    let held = term.factors.iter().find_map(position);
    let (Some(sensor), Some((axis, from, _))) = (sensor, held) else { return candidate };
    let share = scene.machine.axis(axis).map_or(0.0, |data| data.direction[axis.dimension()]);
    let (from_mm, lag_s) = (from.unwrap_or(0.0), term.lag_s);
    candidate.written(move |amounts| {
        if axis.is_rotary() || (share.abs() - 1.0).abs() > ALONG {
            return Err(format!("{axis} is not along a coordinate of the machine"));
        }
        let slope = amounts.first().copied().unwrap_or(0.0) / share;
        // mm/(mm K) in µm/(m K); e = slope (x − from).
        let um_per_m_k = THOUSAND * um_from_mm(slope);
        Ok(vec![Change::Growth {
            axis,
            sensor: sensor.clone(),
            lag_s,
            um_per_m_k,
            um_per_k: um_from_mm(slope * from_mm),
        }])
    })
}

/// Unit of the amount of a term, and the factor from the internal unit, mm or rad per unit, to it.
fn unit(through: Through, term: &StatedTerm) -> (f64, String) {
    let (mut factor, numerator) =
        if is_rotation(through) { (urad_from_rad(1.0), "urad") } else { (um_from_mm(1.0), "um") };
    let mut below: Vec<(&str, u8)> = Vec::new();
    for one in &term.factors {
        let Factor::Power { of, power, .. } = one else { continue };
        let (scale, name) = match of {
            Quantity::Position(axis) if axis.is_rotary() => (1.0, "rad"),
            Quantity::Position(_) => (THOUSAND, "m"),
            // A reversal value is twice the deviation on either side.
            Quantity::Sense(_) => {
                factor *= if power % 2 == 1 { 2.0 } else { 1.0 };
                continue;
            }
            Quantity::Speed(axis) if axis.is_rotary() => (1.0, "(rad/s)"),
            Quantity::Speed(_) => (THOUSAND, "(m/s)"),
            Quantity::Time => (1.0, "s"),
            Quantity::Temperature(_) => (1.0, "K"),
            Quantity::Column(name) => match unit_of(name) {
                "1/min" => (THOUSAND, "(1000/min)"),
                "mm/min" => (THOUSAND, "(m/min)"),
                "" => (1.0, "unit"),
                other => (1.0, other),
            },
        };
        factor *= f64::powi(scale, i32::from(*power));
        match below.iter_mut().find(|(known, _)| *known == name) {
            Some((_, known)) => *known = known.saturating_add(*power),
            None => below.push((name, *power)),
        }
    }
    let names: Vec<String> = below
        .iter()
        .map(|(name, power)| if *power > 1 { format!("{name}^{power}") } else { (*name).to_owned() })
        .collect();
    let unit = match names.as_slice() {
        [] => numerator.to_owned(),
        [one] => format!("{numerator}/{one}"),
        all => format!("{numerator}/({})", all.join(" ")),
    };
    (factor, unit)
}

/// Candidate of a term, by its name in explanations; `None` if the axes of the scene have no such term.
pub(super) fn of_shape(scene: &Scene<'_>, name: &str) -> Option<Candidate> {
    let term = terms(scene).into_iter().find(|term| term.name() == name)?;
    let effect = effect_of(&term);
    let parameter = match term.component.axis() {
        Some(axis) if effect == EffectKind::Following => axis.to_string(),
        _ => term.component.to_string(),
    };
    let mut candidate = Candidate::one(usual(effect), parameter, term.through(), term.weight.clone());
    let is_driver = |word: &&str| AXES.iter().any(|axis| word.strip_suffix("_dir").unwrap_or(word) == axis.to_string());
    candidate.drivers = term.shape.split_whitespace().filter(is_driver).map(str::to_owned).collect();
    if candidate.drivers.is_empty() && term.component.kind == ErrorKind::Motion {
        candidate.drivers.extend(term.component.axis().map(|axis| axis.to_string()));
    }
    let location = ParameterName::location(term.component);
    Some(if effect == EffectKind::Location { candidate.extends(&[location]) } else { candidate })
}

/// The effect by which causes name a term of an explanation.
fn effect_of(term: &Shape) -> EffectKind {
    match term.family {
        Family::Squareness | Family::Tilt | Family::Offset => EffectKind::Location,
        Family::Backlash => EffectKind::Backlash,
        Family::LateralPlay | Family::AngularPlay => EffectKind::LateralPlay,
        Family::Lag => EffectKind::Following,
        Family::Cross | Family::CrossAngle => EffectKind::Cross,
        _ => EffectKind::Motion,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_without_a_name_has_no_words_of_an_instrument() {
        assert_eq!(usual(EffectKind::Unknown).name, UNNAMED.name);
        assert_eq!(usual(EffectKind::Backlash).effect, EffectKind::Backlash);
    }
}
