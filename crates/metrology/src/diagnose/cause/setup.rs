//! Unknowns of a set-up that its description states as known: position, length, rotation, tool, scale.

use std::collections::BTreeMap;

use super::{Candidate, Cause, Correctable, EffectKind, Values, Weight, column, tip};
use crate::diagnose::row::SceneRow;
use crate::diagnose::scene::{Scene, Through};
use crate::measure::data::Free;
use crate::measure::kind::Measurand;

pub(super) const PLACE: Cause = Cause {
    name: "position of the artifact",
    effect: EffectKind::Setup,
    made_by: "a ball or an artifact that is not at its described position",
    shown_by: "ball-bar: a circle off its center, equal in both directions, different in the next set-up",
    separate_by: "mount it again",
    correctable: Correctable::No,
    propose: place,
};

pub(in crate::diagnose) const TOOL: Cause = Cause {
    name: "length and offset of the tool",
    effect: EffectKind::Setup,
    made_by: "a tool or stylus with a wrong measured length",
    shown_by: "readings that turn with the spindle, or differ from tool to tool",
    separate_by: "index the spindle; another tool length",
    correctable: Correctable::No,
    propose: tool,
};

pub(in crate::diagnose) const SCALE: Cause = Cause {
    name: "scale of the instrument",
    effect: EffectKind::Setup,
    made_by: "a beam that is not along the axis, air or artifact at another temperature than assumed",
    shown_by: "length errors in one set-up only, or with the temperature of air or artifact",
    separate_by: "mount it again; an artifact of another material",
    correctable: Correctable::No,
    propose: scale,
};

pub(super) const PROBE: Cause = Cause {
    name: "delay and lobes of the probe",
    effect: EffectKind::Probe,
    made_by: "a late trigger, a probe with a three-point seat",
    shown_by: "probing at two feeds; a sphere touched from nine directions",
    separate_by: "a second feed, the probe turned by 60°",
    correctable: Correctable::No,
    propose: probe,
};

/// Spread of points along an axis that shows a scale, mm.
const SPREAD_MM: f64 = 10.0;
/// Maximum number of set-ups. With more, no set-up gets unknowns of its own.
const MOST: usize = 40;
/// Columns with the temperatures of instrument and artifact.
const OWN: [&str; 6] = ["T_plate_C", "T_air_C", "T_artefact_C", "T_artifact_C", "T_bar_C", "T_workpiece_C"];

/// Name of the rotations of artifacts.
const ROTATION: &str = "rotation";

/// True for an artifact that is not aligned with the axes as its description states.
pub(in crate::diagnose) fn is_alignment(one: &Candidate) -> bool {
    one.cause.name == PLACE.name && one.parameter.split(' ').next() == Some(ROTATION)
}

/// A part of a column: the path of its effect, and its weight as a function of the row.
fn part(through: Through, of: impl Fn(&SceneRow) -> f64 + Send + Sync + 'static) -> (Through, Weight) {
    (through, Weight::new(of))
}

/// Coordinate `k` of the tool tip as described, mm.
fn along(row: &SceneRow, scene: &Scene<'_>, k: usize) -> f64 {
    let axis = super::linear(scene).find(|axis| axis.dimension() == k);
    axis.map_or(0.0, |axis| row.position[axis]) + row.tool_mm[k]
}

/// Tool tip as described, mm.
fn point(row: &SceneRow, scene: &Scene<'_>) -> [f64; 3] {
    [0, 1, 2].map(|k| along(row, scene, k))
}

/// Set-ups of these measurands in whose measurements `free` is not among the free unknowns.
fn setups(scene: &Scene<'_>, measurands: &[Measurand], free: Free) -> Vec<(usize, usize)> {
    let sets = scene
        .sets
        .iter()
        .enumerate()
        .filter(|(_, set)| measurands.contains(&set.kind.measurand) && !set.free.contains(&free));
    let all: Vec<_> = sets.flat_map(|(set, data)| (0..data.setups.len()).map(move |setup| (set, setup))).collect();
    if all.len() > MOST { Vec::new() } else { all }
}

/// Label of a set-up of a measurement, with the name of its file if the set-up of another file has the same label.
fn full_label(scene: &Scene<'_>, own: (usize, usize), all: &[(usize, usize)]) -> String {
    let own_label = label(scene, own);
    let is_alike = |other: &&(usize, usize)| other.0 != own.0 && label(scene, **other) == own_label;
    let file = scene.sets.get(own.0).filter(|_| all.iter().any(|other| is_alike(&other))).map_or("", |set| &set.name);
    format!("{file} {own_label}").trim().to_owned()
}

/// Label of a set-up of a measurement.
fn label<'s>(scene: &'s Scene<'_>, (set, setup): (usize, usize)) -> &'s str {
    scene.sets.get(set).and_then(|set| set.setups.get(setup)).map_or("", |setup| &setup.label)
}

fn push(
    out: &mut Vec<Candidate>,
    cause: &'static Cause,
    name: &str,
    columns: Vec<Vec<(Through, Weight)>>,
    drivers: &[&str],
) {
    let Some((through, weight)) = columns.first().and_then(|parts| parts.first()).cloned() else { return };
    let mut one = Candidate::one(cause, name, through, weight);
    one.columns = columns;
    one.drivers = drivers.iter().map(|&name| name.to_owned()).collect();
    out.push(one);
}

fn place(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let of = |own: (usize, usize)| move |row: &SceneRow| f64::from(u8::from((row.set, row.setup) == own));
    let centres = setups(scene, &[Measurand::BallDistance], Free::Centre);
    let columns = centres.iter().flat_map(|&own| (0..3).map(move |k| vec![part(Through::Tip(k), of(own))])).collect();
    push(out, &PLACE, "centre", columns, &["setup"]);
    let mut lengths: BTreeMap<u64, Vec<(usize, usize)>> = BTreeMap::new();
    for own in setups(scene, &[Measurand::BallDistance], Free::Length) {
        let length = scene.sets.get(own.0).and_then(|set| set.setups.get(own.1)).map_or(0.0, |setup| setup.length_mm);
        lengths.entry((length * 1e3).round() as u64).or_default().push(own);
    }
    let of_all = |all: Vec<(usize, usize)>| {
        let weight = move |row: &SceneRow| f64::from(u8::from(all.contains(&(row.set, row.setup))));
        vec![part(Through::Reading(false), weight)]
    };
    // Set-ups with the same length use the same bar, but its length may have been set again in one of them.
    let again: Vec<(usize, usize)> = lengths.values().filter(|all| all.len() > 1).flatten().copied().collect();
    push(out, &PLACE, "length", lengths.into_values().map(of_all).collect(), &["setup"]);
    for own in again {
        let name = format!("length {}", label(scene, own));
        push(out, &PLACE, name.trim_end(), vec![of_all(vec![own])], &["setup"]);
    }
    let mut columns = Vec::new();
    let mut of_each = Vec::new();
    // The direction of a square is exact.
    let is_square = |set: usize| scene.sets.get(set).is_some_and(|data| data.is_square_stated);
    for own in setups(scene, &[Measurand::Displacement], Free::Rotation).into_iter().filter(|own| !is_square(own.0)) {
        let rows = scene.rows.iter().filter(|row| (row.set, row.setup) == own);
        let points: Vec<[f64; 3]> = rows.map(|row| point(row, scene)).collect();
        let middle = [0, 1, 2].map(|k| points.iter().map(|at| at[k]).sum::<f64>() / points.len().max(1) as f64);
        let dimensions = [0, 1, 2].map(|k| super::linear(scene).find(|axis| axis.dimension() == k));
        let first = columns.len();
        for about in 0..3 {
            // The two components of e × p.
            let [one, other] = [(about + 1) % 3, (about + 2) % 3];
            let at = move |k: usize| {
                move |row: &SceneRow| {
                    if (row.set, row.setup) == own {
                        dimensions[k].map_or(0.0, |axis| row.position[axis]) + row.tool_mm[k] - middle[k]
                    } else {
                        0.0
                    }
                }
            };
            let (plus, minus) = (at(one), at(other));
            columns.push(vec![part(Through::Value(other), plus), part(Through::Value(one), move |row| -minus(row))]);
        }
        of_each.push((own, columns.get(first..).unwrap_or_default().to_vec()));
    }
    let several = of_each.len() > 1;
    push(out, &PLACE, ROTATION, columns, &["setup"]);
    // One of several may be misaligned.
    for (own, columns) in of_each.into_iter().filter(|_| several) {
        let name = format!("{ROTATION} {}", label(scene, own));
        push(out, &PLACE, name.trim_end(), columns, &["setup"]);
    }
}

fn tool(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let all = setups(scene, &[Measurand::BallPlace, Measurand::Displacement, Measurand::BallDistance], Free::Tool);
    if all.is_empty() {
        return;
    }
    let of = |own: (usize, usize)| move |row: &SceneRow| f64::from(u8::from((row.set, row.setup) == own));
    if all.len() > 1 {
        let columns = all.iter().map(|&own| vec![part(Through::Tip(2), of(own))]).collect();
        push(out, &TOOL, "tool_z", columns, &["setup"]);
    }
    // One probe with one stylus has the same error in all set-ups: its pre-travel, or its length.
    let mut lengths: Vec<i64> = scene.rows.iter().map(|row| (row.tool_mm[2] * 1e3).round() as i64).collect();
    lengths.sort_unstable();
    lengths.dedup();
    if lengths.len() == 1 {
        let common = all.clone();
        let always = move |row: &SceneRow| f64::from(u8::from(common.contains(&(row.set, row.setup))));
        push(out, &TOOL, "tool_z", vec![vec![part(Through::Tip(2), always)]], &[]);
    }
    if scene.rows.iter().any(|row| row.spindle_rad != 0.0) {
        let turned = |sine: f64, cosine: f64| {
            let all = all.clone();
            move |row: &SceneRow| {
                let own = f64::from(u8::from(all.contains(&(row.set, row.setup))));
                own * (sine * row.spindle_rad.sin() + cosine * row.spindle_rad.cos())
            }
        };
        let columns = vec![
            vec![part(Through::Tip(0), turned(0.0, 1.0)), part(Through::Tip(1), turned(1.0, 0.0))],
            vec![part(Through::Tip(0), turned(-1.0, 0.0)), part(Through::Tip(1), turned(0.0, 1.0))],
        ];
        push(out, &TOOL, "tool_x", columns, &["spindle_deg", "setup"]);
    }
}

fn scale(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let reference = scene.machine.reference_temperature_c;
    let own_length = |row: &SceneRow| {
        let name = row.component?;
        let axis = name.axis()?;
        (name == super::own(axis) && !axis.is_rotary()).then(|| row.position[axis])
    };
    let is_direct = |set: usize| scene.sets.get(set).is_some_and(|set| set.kind.measurand == Measurand::Component);
    // A wrong scale in one set-up of a laser.
    let mut all: Vec<(usize, usize)> = scene
        .rows
        .iter()
        .filter(|row| is_direct(row.set) && own_length(row).is_some())
        .map(|row| (row.set, row.setup))
        .collect();
    all.sort_unstable();
    all.dedup();
    // Only another set-up shows that a scale is wrong: one of this instrument or of another.
    let plates = plates(scene);
    let has_others = (2..=MOST).contains(&(all.len() + plates.len()));
    if has_others {
        for &own in &all {
            let of =
                move |row: &SceneRow| if (row.set, row.setup) == own { own_length(row).unwrap_or(0.0) } else { 0.0 };
            let name = format!("scale {}", full_label(scene, own, &all));
            push(out, &SCALE, name.trim_end(), vec![vec![part(Through::Reading(false), of)]], &["setup"]);
        }
    }
    // A plate alone shows it by equal scales of two axes: two machine errors are rarely equal.
    if has_others || (plates.len() == 1 && spans_a_plane(scene)) {
        artefacts(scene, plates, out);
    }
    for name in OWN {
        let Some(values) = column(scene.sets, name) else { continue };
        let warm = move |values: &Values, row: &SceneRow| {
            let value = values.get(row.set).and_then(|own| own.get(row.number)).copied().unwrap_or(f64::NAN);
            value - reference
        };
        let directs: Vec<bool> = (0..scene.sets.len()).map(is_direct).collect();
        let own = values.clone();
        let of_direct = move |row: &SceneRow| {
            let length = own_length(row).filter(|_| directs.get(row.set) == Some(&true));
            length.map_or(0.0, |length| length * warm(&own, row))
        };
        push(out, &SCALE, "scale", vec![vec![part(Through::Reading(false), of_direct)]], &[name]);
        let plates: Vec<bool> = scene.sets.iter().map(|set| set.kind.measurand == Measurand::Displacement).collect();
        let mut parts = Vec::new();
        for axis in super::linear(scene) {
            let k = axis.dimension();
            let Some([low, high]) = super::range(scene, axis) else { continue };
            let (values, plates) = (values.clone(), plates.clone());
            let of = move |row: &SceneRow| {
                if plates.get(row.set) == Some(&true) {
                    (row.position[axis] + row.tool_mm[k] - f64::midpoint(low, high)) * warm(&values, row)
                } else {
                    0.0
                }
            };
            parts.push(part(Through::Value(k), of));
        }
        push(out, &SCALE, "scale", vec![parts], &[name]);
    }
    for one in out.iter_mut().filter(|one| one.cause.name == SCALE.name) {
        one.sensor = one.drivers.iter().find(|name| name.starts_with("T_")).cloned();
    }
}

/// True if the points of artifacts spread along two linear axes or more.
fn spans_a_plane(scene: &Scene<'_>) -> bool {
    let is_plate =
        |row: &&SceneRow| scene.sets.get(row.set).is_some_and(|set| set.kind.measurand == Measurand::Displacement);
    let spreads = super::linear(scene).filter(|axis| {
        let mut places = scene.rows.iter().filter(is_plate).map(|row| row.position[*axis]);
        places.next().is_some_and(|first| places.any(|place| (place - first).abs() > SPREAD_MM))
    });
    spreads.count() > 1
}

/// Set-ups of artifacts.
fn plates(scene: &Scene<'_>) -> Vec<(usize, usize)> {
    let is_plate = |set: usize| scene.sets.get(set).is_some_and(|set| set.kind.measurand == Measurand::Displacement);
    let mut all: Vec<(usize, usize)> =
        scene.rows.iter().filter(|row| is_plate(row.set)).map(|row| (row.set, row.setup)).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Scale of one artifact or of one mounting: its length differs from the certificate, about its middle and in all directions.
fn artefacts(scene: &Scene<'_>, all: Vec<(usize, usize)>, out: &mut Vec<Candidate>) {
    let known = all.clone();
    for own in all {
        let points: Vec<[f64; 3]> =
            scene.rows.iter().filter(|row| (row.set, row.setup) == own).map(|row| point(row, scene)).collect();
        let parts = [0, 1, 2].into_iter().filter_map(|k| {
            let axis = super::linear(scene).find(|axis| axis.dimension() == k)?;
            let middle = points.iter().map(|at| at[k]).sum::<f64>() / points.len().max(1) as f64;
            Some(part(Through::Value(k), move |row| {
                if (row.set, row.setup) == own { row.position[axis] + row.tool_mm[k] - middle } else { 0.0 }
            }))
        });
        let name = format!("scale {}", full_label(scene, own, &known));
        push(out, &SCALE, name.trim_end(), vec![parts.collect()], &["setup"]);
    }
}

fn probe(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    if let Some(feed) = column(scene.sets, "feed_mm_min") {
        let is_probe: Vec<bool> = scene.sets.iter().map(|set| set.kind.measurand == Measurand::BallPlace).collect();
        if is_probe.contains(&true) {
            let weight = Weight::new(move |row| {
                let feed = feed.get(row.set).and_then(|own| own.get(row.number)).copied().unwrap_or(0.0);
                if is_probe.get(row.set) == Some(&true) { -feed / 60.0 } else { 0.0 }
            });
            for direction in 0..3 {
                let one = Candidate::one(&PROBE, tip(direction), Through::Tip(direction), weight.clone());
                out.push(one.driven_by(&[&"feed_mm_min"]));
            }
        }
    }
    // Three lobes over the direction of contact in the plane.
    let [Some(first), Some(second)] = [0, 1].map(|k| super::linear(scene).find(|axis| axis.dimension() == k)) else {
        return;
    };
    let touches = |row: &SceneRow| {
        scene.sets.get(row.set).is_some_and(|set| set.kind.measurand == Measurand::BallPlace)
            && row.sense_of(first) != 0.0
            && row.sense_of(second) != 0.0
    };
    if scene.rows.iter().any(touches) {
        let lobe = |of: fn(f64) -> f64| {
            Weight::new(move |row| {
                let [x, y] = [row.sense_of(first), row.sense_of(second)];
                if x == 0.0 && y == 0.0 { 0.0 } else { (3.0 * y.atan2(x)).cos() * of(y.atan2(x)) }
            })
        };
        let parts = vec![(Through::Tip(0), lobe(f64::cos)), (Through::Tip(1), lobe(f64::sin))];
        push(out, &PROBE, "lobes", vec![parts], &["X_dir", "Y_dir"]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn an_artefact_that_is_turned_moves_across_its_arm() {
        let machine = bench::machine();
        // Relative to the middle (10, 20, 30), the first point is at (−10, −20, 30).
        let rows = "X,Y,Z,dx_um,dy_um,dz_um\n0,0,60,0,0,0\n20,40,0,0,0,0\n";
        let sets = [bench::table(&machine, rows, "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n")];
        let scene = bench::scene(&machine, &sets);
        let mut found = Vec::new();
        place(&scene, &mut found);
        let one = found.iter().find(|one| one.parameter == "rotation").unwrap();
        let moves = |column: &Vec<(Through, Weight)>| {
            let mut out = [0.0; 3];
            for (through, weight) in column {
                let Through::Value(value) = through else { panic!("{through:?}") };
                out[*value] += weight.of(&scene.rows[0]);
            }
            out
        };
        // e × p about X, Y and Z.
        let expected = [[0.0, -30.0, -20.0], [30.0, 0.0, 10.0], [20.0, -10.0, 0.0]];
        assert_eq!(one.columns.iter().map(moves).collect::<Vec<_>>(), expected);
    }
}
