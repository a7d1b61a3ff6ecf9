//! Functions of positions and directions, written as tables with points where they bend.

use ncfix_base::geometry::{AXES, Axis};
use ncfix_model::name::{DIRECTIONS, ErrorKind, ErrorName};

use super::super::cause::EffectKind;
use super::super::row::{NOWHERE, SceneRow};
use super::super::scene::{Scene, Through};
use super::super::size::{EXPANDED, weights_at};
use super::super::verdict::AcceptedCause;
use super::change::{Change, rounded, unit_of};

/// Number of points along an axis at which a function is sampled, in addition to its knots.
const LOOKS: usize = 33;
/// Width of a step, as a share of the travel.
const STEP: f64 = 1e-5;
/// Largest deviation of straight lines between table points, as a share of the largest value.
const OFF: f64 = 5e-3;
/// A shape without a name that bends within this share of the measured range from its end acts only where the axis reverses.
const AT_END: f64 = 0.02;
/// Directions are equal within this share.
const SAME: f64 = 1e-6;

/// Drivers of a function.
struct Drivers {
    places: Vec<Axis>,
    senses: Vec<Axis>,
}

fn drivers(one: &AcceptedCause) -> Result<Drivers, String> {
    let mut out = Drivers { places: Vec::new(), senses: Vec::new() };
    for driver in &one.candidate.drivers {
        let axis = |name: &str| AXES.into_iter().find(|axis| axis.to_string() == name);
        if let Some(axis) = axis(driver) {
            out.places.push(axis);
        } else if let Some(axis) = driver.strip_suffix("_dir").and_then(axis) {
            out.senses.push(axis);
        } else {
            return Err(format!(
                "it depends on {driver}, but tables of the machine file depend only on positions and directions of axes"
            ));
        }
    }
    Ok(out)
}

/// The component on which a function acts, and the factor of the component in its value.
fn component_of(one: &AcceptedCause, scene: &Scene<'_>, drivers: &Drivers) -> Result<(ErrorName, f64), String> {
    let mut all = one.candidate.columns.iter().flatten().map(|(through, _)| *through);
    let first = all.next().ok_or("it has no shape")?;
    if one.candidate.columns.iter().any(|parts| parts.len() != 1) || all.any(|own| own != first) {
        return Err("it has several effects at once".into());
    }
    match first {
        Through::Component(name) if name.kind == ErrorKind::Motion => Ok((name, 1.0)),
        Through::Tip(direction) => {
            let axis = *drivers.senses.first().or(drivers.places.first()).ok_or("it depends on no driver")?;
            let direction = *DIRECTIONS.get(direction).ok_or("it has no direction")?;
            let name = ErrorName::motion(direction, axis);
            let [own, tip] = [Through::Component(name), first].map(|through| scene.factors(through));
            let most = tip.iter().fold(0.0, |most, value| f64::max(most, value.abs()));
            let is = |sign: f64| own.iter().zip(&tip).all(|(own, tip)| (own - sign * tip).abs() <= SAME * most);
            [1.0, -1.0]
                .into_iter()
                .find(|&sign| most > 0.0 && is(sign))
                .map(|sign| (name, sign))
                .ok_or_else(|| format!("errors of {axis} turn with other axes, but this one does not"))
        }
        _ => Err("it is not an error of an axis".into()),
    }
}

/// A function over the measured range.
struct Law<'a> {
    one: &'a AcceptedCause,
    row: SceneRow,
    low: ncfix_base::geometry::AxisVector,
    high: ncfix_base::geometry::AxisVector,
    factor: f64,
    /// Weights at the reference position, which are subtracted; empty if the values are absolute.
    zero: Vec<f64>,
}

impl Law<'_> {
    /// Value and expanded uncertainty at places, µm or µrad.
    fn at(&self, places: &[(Axis, f64)], sense: Option<(Axis, i8)>) -> [f64; 2] {
        let mut row = self.row.clone();
        places.iter().for_each(|&(axis, place)| row.position[axis] = place);
        if let Some((axis, sense)) = sense
            && let Some(own) = row.sense.get_mut(axis.slot())
        {
            *own = sense;
        }
        let mut weights = weights_at(&self.one.candidate, &row);
        weights.iter_mut().zip(&self.zero).for_each(|(weight, zero)| *weight -= zero);
        let (value, sigma) = self.one.amounts.form(&weights);
        [self.factor * value, EXPANDED * self.factor.abs() * sigma]
    }

    /// Positions at which the function is sampled along an axis.
    fn looks(&self, axis: Axis) -> Vec<f64> {
        let (low, high) = (self.low[axis], self.high[axis]);
        let step = STEP * (high - low);
        let mut out: Vec<f64> = (0..LOOKS).map(|k| low + (high - low) * k as f64 / (LOOKS - 1) as f64).collect();
        for &at in self.one.candidate.points.iter().flatten() {
            out.extend([at - step, at, at + step].into_iter().filter(|at| low < *at && *at < high));
        }
        if let Some((_, ends)) = self.one.candidate.threshold.filter(|(beyond, _)| *beyond == axis) {
            out.extend(ends);
        }
        out.sort_by(f64::total_cmp);
        out.dedup_by(|one, other| (*one - *other).abs() < 0.5 * step);
        out
    }
}

/// Indices of the table points for which linear interpolation reproduces all rows.
fn needed(places: &[f64], rows: &[Vec<f64>]) -> Vec<usize> {
    let most = rows.iter().flatten().fold(0.0, |most, value| f64::max(most, value.abs()));
    let last = places.len().saturating_sub(1);
    let mut kept = vec![0, last];
    let mut parts = vec![[0, last]];
    while let Some([from, until]) = parts.pop() {
        let off = |k: usize| {
            let share = (places[k] - places[from]) / (places[until] - places[from]);
            let of = |row: &Vec<f64>| (row[k] - row[from] - share * (row[until] - row[from])).abs();
            rows.iter().map(of).fold(0.0, f64::max)
        };
        let worst = (from + 1..until).map(|k| (off(k), k)).max_by(|one, other| one.0.total_cmp(&other.0));
        if let Some((off, k)) = worst
            && off > OFF * most
        {
            kept.push(k);
            parts.extend([[from, k], [k, until]]);
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// Positions in the unit of the file, mm or degrees.
fn shown(axis: Axis, places: impl Iterator<Item = f64>) -> Vec<f64> {
    places.map(|place| rounded(if axis.is_rotary() { place.to_degrees() } else { place })).collect()
}

/// Values rounded to 10 pm, as in the file.
fn coarse(values: impl Iterator<Item = f64>) -> Vec<f64> {
    values.map(|value| (value * 1e5).round() / 1e5).collect()
}

/// A table over one axis, a grid over two, or a backlash that changes along the axis.
pub(super) fn law(one: &AcceptedCause, scene: &Scene<'_>, used: usize) -> Result<Change, String> {
    let drivers = drivers(one)?;
    let (name, sign) = component_of(one, scene, &drivers)?;
    let own = name.axis().ok_or("it is not an error of an axis")?;
    let mut rows = scene.rows.iter().filter(|row| row.set < used);
    let first = rows.next().ok_or("there is no reading")?;
    let (mut low, mut high) = (first.position, first.position);
    for row in rows {
        for axis in AXES {
            low[axis] = low[axis].min(row.position[axis]);
            high[axis] = high[axis].max(row.position[axis]);
        }
    }
    let (factor, _) = unit_of(name);
    let row = SceneRow { number: NOWHERE, ..first.clone() };
    let mut law = Law { one, row, low, high, factor: factor * sign, zero: Vec::new() };
    if drivers.places.iter().chain([&own]).any(|&axis| high[axis] < low[axis] || !(high[axis] - low[axis]).is_finite())
    {
        return Err("the travel is not known".into());
    }
    if let [axis] = drivers.places[..]
        && one.candidate.cause.effect == EffectKind::Unknown
        && one.candidate.points.iter().flatten().any(|&at| is_at_end(at, [low[axis], high[axis]]))
    {
        return Err(format!(
            "it begins at the end of the measured range, where {axis} reverses; measure these positions in both directions"
        ));
    }
    let others: Vec<Axis> = drivers.places.iter().copied().filter(|&axis| axis != own).collect();
    let change = |law: &Law<'_>| match (drivers.senses.as_slice(), others.as_slice()) {
        ([], []) => line(law, name, own, None),
        ([sense], []) if *sense == own => line(law, name, own, Some(own)),
        ([], [other]) => grid(law, name, own, (*other, drivers.places.contains(&own))),
        ([_, ..], _) => {
            Err("it reverses with the direction of one axis and depends on another one; no entry can hold this".into())
        }
        _ => Err("it depends on more than two axes".into()),
    };
    let mut found = change(&law)?;
    // The value common to all positions is not identifiable in a set-up with its own zero.
    if matches!(&found, Change::Shape { kind, values, .. } if *kind != "backlash" && is_offset(values)) {
        let mut row = law.row.clone();
        drivers.places.iter().for_each(|&axis| row.position[axis] = law.low[axis]);
        law.zero = weights_at(&one.candidate, &row);
        found = change(&law)?;
    }
    let change = found;
    match &change {
        // The tool reaches other positions than the axes, or another driver is unknown.
        Change::Shape { values, .. } if values.iter().flatten().all(|value| *value == 0.0) => Err(
            "it depends on the position in the workpiece, but errors of the machine file depend on positions of axes"
                .into(),
        ),
        _ => Ok(change),
    }
}

/// True if a place is inside a range, but hardly.
fn is_at_end(at: f64, [low, high]: [f64; 2]) -> bool {
    let from_end = (at - low).min(high - at) / (high - low);
    0.0 < from_end && from_end < AT_END
}

/// True if the value common to all exceeds their differences.
fn is_offset(values: &[Vec<f64>]) -> bool {
    let all = || values.iter().flatten().copied();
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    low * high > 0.0 && low.abs().min(high.abs()) > high - low && high > low
}

fn line(law: &Law<'_>, name: ErrorName, own: Axis, sense: Option<Axis>) -> Result<Change, String> {
    let looks = if law.high[own] > law.low[own] { law.looks(own) } else { vec![law.low[own]] };
    let at = |place: f64, sense: Option<(Axis, i8)>| law.at(&[(own, place)], sense);
    let is_odd = |&place: &f64| {
        let [up, down] = [1, -1].map(|sign| at(place, sense.map(|axis| (axis, sign)))[0]);
        (up + down).abs() <= 1e-9 * up.abs().max(down.abs())
    };
    // A value that reverses with the direction is a backlash; the file stores the full width.
    let (kind, times, sense) = match sense {
        Some(axis) if looks.iter().all(is_odd) => ("backlash", 2.0, Some((axis, 1))),
        Some(_) => {
            return Err("it depends on the direction but does not reverse with it; no entry can hold this".into());
        }
        None => ("table", 1.0, Some((own, 0))),
    };
    let all: Vec<[f64; 2]> = looks.iter().map(|&place| at(place, sense)).collect();
    let kept = needed(&looks, &[all.iter().map(|pair| pair[0]).collect()]);
    let of = |which: usize| coarse(kept.iter().filter_map(|&k| all.get(k)).map(move |pair| times * pair[which]));
    let places = shown(own, kept.iter().filter_map(|&k| looks.get(k).copied()));
    Ok(Change::Shape { name, kind, places, with: None, values: vec![of(0)], u95: vec![of(1)] })
}

fn grid(law: &Law<'_>, name: ErrorName, own: Axis, (other, has_own): (Axis, bool)) -> Result<Change, String> {
    let along = if has_own { law.looks(own) } else { vec![f64::midpoint(law.low[own], law.high[own])] };
    let across = law.looks(other);
    let all: Vec<Vec<[f64; 2]>> = along
        .iter()
        .map(|&place| across.iter().map(|&with| law.at(&[(own, place), (other, with)], Some((own, 0)))).collect())
        .collect();
    let rows: Vec<Vec<f64>> = all.iter().map(|row| row.iter().map(|pair| pair[0]).collect()).collect();
    let columns: Vec<Vec<f64>> =
        (0..across.len()).map(|k| rows.iter().filter_map(|row| row.get(k).copied()).collect()).collect();
    let (kept, kept_across) = (needed(&along, &columns), needed(&across, &rows));
    let of = |which: usize| -> Vec<Vec<f64>> {
        let row = |row: &Vec<[f64; 2]>| coarse(kept_across.iter().filter_map(|&k| row.get(k)).map(|pair| pair[which]));
        kept.iter().filter_map(|&k| all.get(k)).map(row).collect()
    };
    let places = shown(own, kept.iter().filter_map(|&k| along.get(k).copied()));
    let others = shown(other, kept_across.iter().filter_map(|&k| across.get(k).copied()));
    Ok(Change::Shape { name, kind: "grid", places, with: Some((other, others)), values: of(0), u95: of(1) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::cause::EffectKind;
    use crate::diagnose::size::Amounts;

    #[test]
    fn a_bend_at_a_reversal_is_at_the_end() {
        // 2 % of 200 mm are 4 mm; the ends themselves bend nothing.
        let found = [50.0, 50.34, 53.9, 54.1, 150.0, 245.9, 249.66, 250.0].map(|at| is_at_end(at, [50.0, 250.0]));
        assert_eq!(found, [false, true, true, false, false, false, true, false]);
    }

    #[test]
    fn what_all_places_have_in_common_is_an_offset() {
        assert!(is_offset(&[vec![-570.6, -560.8, -568.9]]));
        assert!(!is_offset(&[vec![0.0, 0.0, 12.0]]));
        assert!(!is_offset(&[vec![2.0, 12.0], vec![3.0, 4.0]]));
        assert!(!is_offset(&[vec![-4.0, 3.0]]));
        // A constant alone is a result of its own.
        assert!(!is_offset(&[vec![5.0, 5.0]]));
    }

    #[test]
    fn a_straight_line_needs_its_ends_and_a_bend_its_place() {
        let places = [10.0, 20.0, 40.0, 50.0];
        // 3 per mm throughout; then half of it from 20.
        assert_eq!(needed(&places, &[vec![0.0, 30.0, 90.0, 120.0]]), [0, 3]);
        assert_eq!(needed(&places, &[vec![0.0, 30.0, 60.0, 75.0]]), [0, 1, 3]);
    }

    #[test]
    fn what_turns_over_with_the_sense_is_play_and_nothing_else_is() {
        let component: ErrorName = "EXX".parse().unwrap();
        let of = |shift: f64| {
            let mut one = super::super::tests::finding(5.0, 1e-3);
            let weight = move |row: &SceneRow| row.sense_of(Axis::X) + shift;
            one.candidate = bench::candidate(EffectKind::Backlash, Through::Component(component), weight);
            one.amounts = Amounts { values: vec![2.0], covariance: vec![vec![0.01]] };
            let machine = bench::machine();
            let row = bench::scene(&machine, &[bench::reads_along_x(&machine, &[0.0; 3])]).rows[0].clone();
            let (mut low, mut high) = (row.position, row.position);
            (low[Axis::X], high[Axis::X]) = (0.0, 100.0);
            line(&Law { one: &one, row, low, high, factor: 1.0, zero: vec![0.0] }, component, Axis::X, Some(Axis::X))
        };
        // The full width is 2 − (−2).
        let Ok(Change::Shape { kind: "backlash", values, .. }) = of(0.0) else { panic!("{:?}", of(0.0)) };
        assert!(values[0].iter().all(|value| *value == 4.0), "{values:?}");
        assert!(of(0.5).unwrap_err().contains("does not reverse with it"));
    }
}
