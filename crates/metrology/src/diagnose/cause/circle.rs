//! Causes that only circles show: chords of a program, steps of an old control between octants, a ball that rolls in its cup.

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_4, TAU};
use std::sync::Arc;

use super::{Candidate, Cause, Correctable, EffectKind, Values, Weight};
use crate::diagnose::scene::{Scene, Through};
use crate::measure::kind::Measurand;

pub(super) const CHORDS: Cause = Cause {
    name: "chords instead of the circle",
    effect: EffectKind::Program,
    made_by: "a program of straight blocks",
    shown_by: "ball-bar: equal inward arcs between corners on the circle, at all feeds",
    separate_by: "the same circle as one block",
    correctable: Correctable::Program,
    propose: |_, _| {},
};

pub(super) const OCTANTS: Cause = Cause {
    name: "change of the leading axis",
    effect: EffectKind::Dynamic,
    made_by: "an interpolator in which one axis leads and the other follows",
    shown_by: "ball-bar: steps at 45°, 135°, 225° and 315°",
    separate_by: "the circle in another plane; lines at 40° and 50°",
    correctable: Correctable::No,
    propose: octants,
};

pub(super) const CUP: Cause = Cause {
    name: "ball that rolls in its cup",
    effect: EffectKind::Setup,
    made_by: "a cup that is worn or dirty",
    shown_by: "ball-bar: three lobes that differ from run to run",
    separate_by: "repeat the run",
    correctable: Correctable::No,
    propose: cup,
};

pub(super) const LOBES: Cause = Cause {
    name: "lobes over the angle of a circle",
    effect: EffectKind::Unknown,
    made_by: "an out-of-round ball or cup, or an unknown cause",
    shown_by: "ball-bar: one number of lobes in both directions and at all feeds",
    separate_by: "turn the bar end for end and the ball in its cup: lobes of the instrument turn with it",
    correctable: Correctable::No,
    propose: |_, _| {},
};

/// Maximum number of runs with lobes of their own.
const MOST_RUNS: usize = 60;

/// Position relative to the center, mm, and number of the row.
type Placed = ([f64; 3], usize);

/// Positions of rows on their circles; NaN for rows on no circle.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Places {
    /// Angle, rad.
    pub(in crate::diagnose) angles: Values,
    /// Radius, mm.
    pub(in crate::diagnose) radii: Values,
    /// The direction normal to the plane of the circle: 0, 1, 2.
    pub(in crate::diagnose) planes: Values,
}

/// Position of every row on its circle; `None` if there are no circles.
pub(in crate::diagnose) fn places(scene: &Scene<'_>) -> Option<Places> {
    let mut angles: Vec<Vec<f64>> = scene.sets.iter().map(|set| vec![f64::NAN; set.observations.len()]).collect();
    let (mut radii, mut planes) = (angles.clone(), angles.clone());
    let mut any = false;
    // Circles in several planes may share a set-up.
    let mut by_run: HashMap<(usize, usize), Vec<Placed>> = HashMap::new();
    for row in &scene.rows {
        let Some(set) = scene.sets.get(row.set).filter(|set| set.kind.measurand == Measurand::BallDistance) else {
            continue;
        };
        let Some(setup) = set.setups.get(row.setup) else { continue };
        let at = [0, 1, 2].map(|k| {
            let axis = super::linear(scene).find(|axis| axis.dimension() == k);
            axis.map_or(0.0, |axis| row.position[axis]) + row.tool_mm[k] - setup.centre_mm[k]
        });
        by_run.entry((row.set, row.sequence)).or_default().push((at, row.number));
    }
    for ((set, _), rows) in by_run {
        let extent = |k: usize| rows.iter().map(|(at, _)| at[k].abs()).fold(0.0, f64::max);
        let still = (0..3).min_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(2);
        let [one, other] = [(still + 1) % 3, (still + 2) % 3];
        for (at, number) in rows {
            let own =
                [&mut angles, &mut radii, &mut planes].map(|all| all.get_mut(set).and_then(|own| own.get_mut(number)));
            if let [Some(angle), Some(radius), Some(plane)] = own {
                (*angle, *radius, *plane) = (at[other].atan2(at[one]), at[one].hypot(at[other]), still as f64);
                any = true;
            }
        }
    }
    any.then(|| Places { angles: Arc::new(angles), radii: Arc::new(radii), planes: Arc::new(planes) })
}

/// Weight of a row by a function of its angle.
fn of_angle(angles: &Values, of: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Weight {
    let angles = Arc::clone(angles);
    Weight::new(move |row| angles.get(row.set).and_then(|own| own.get(row.number)).map_or(0.0, |&angle| of(angle)))
}

fn octants(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let Some(Places { angles, .. }) = places(scene) else { return };
    let step = of_angle(&angles, |angle| if angle.cos().abs() > FRAC_PI_4.cos() { 0.5 } else { -0.5 });
    let one = Candidate::one(&OCTANTS, "", Through::Reading(false), step);
    out.push(one.driven_by(&[&"X", &"Y", &"Z"]));
}

fn cup(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let Some(Places { angles, .. }) = places(scene) else { return };
    let mut runs: Vec<(usize, usize)> = scene.rows.iter().map(|row| (row.set, row.run)).collect();
    runs.sort_unstable();
    runs.dedup();
    if runs.len() > MOST_RUNS {
        return;
    }
    let mut columns = Vec::new();
    for (set, run) in runs {
        for shift in [0.0, TAU / 12.0] {
            let angles = Arc::clone(&angles);
            columns.push(vec![(
                Through::Reading(false),
                Weight::new(move |row| {
                    if (row.set, row.run) != (set, run) {
                        return 0.0;
                    }
                    let angle = angles.get(row.set).and_then(|own| own.get(row.number));
                    angle.map_or(0.0, |angle| (3.0 * (angle + shift)).sin())
                }),
            )]);
        }
    }
    let mut one = Candidate::one(&CUP, "cup", Through::Reading(false), Weight::new(|_| 0.0));
    one.columns = columns;
    out.push(one.driven_by(&[&"run", &"X", &"Y", &"Z"]));
}

/// A circle of `count` chords with a corner at angle zero.
pub(in crate::diagnose) fn chords(places: &Places, count: u32) -> Candidate {
    let Places { angles, radii, .. } = places.clone();
    let shape = Weight::new(move |row| {
        let at = |values: &Values| values.get(row.set).and_then(|own| own.get(row.number)).copied().unwrap_or(f64::NAN);
        chord(at(&angles), count) * at(&radii)
    });
    let mut one = Candidate::one(&CHORDS, "", Through::Reading(false), shape).driven_by(&[&"X", &"Y", &"Z"]);
    one.constant = Some((f64::from(count), "chords"));
    one
}

/// Deviation of a chord from a circle of radius 1, negative inward.
pub(in crate::diagnose) fn chord(angle: f64, count: u32) -> f64 {
    let half = std::f64::consts::PI / f64::from(count);
    let within = angle.rem_euclid(2.0 * half) - half;
    half.cos() / within.cos() - 1.0
}

/// A number of lobes over the angle of circles whose planes are normal to some of the directions 0, 1, 2. Each plane has its own phase, unless
/// `are_alike`: then all planes have the same.
pub(in crate::diagnose) fn lobes(places: &Places, still: &[usize], count: u32, are_alike: bool) -> Candidate {
    let Places { angles, planes, .. } = places;
    let wave = |some: &[usize], of: fn(f64) -> f64| {
        let (angles, planes, some) = (Arc::clone(angles), Arc::clone(planes), some.to_vec());
        Weight::new(move |row| {
            let at = |values: &Values| values.get(row.set).and_then(|own| own.get(row.number)).copied();
            let is_in = at(&planes).is_some_and(|plane| some.iter().any(|&own| plane == own as f64));
            at(&angles).filter(|_| is_in).map_or(0.0, |angle| of(f64::from(count) * angle))
        })
    };
    // A circle moves both axes of its plane.
    let moves = |k: usize| still.iter().any(|&own| own != k);
    let names: Vec<&str> =
        ["X", "Y", "Z"].into_iter().enumerate().filter(|(k, _)| moves(*k)).map(|one| one.1).collect();
    let drivers: Vec<&dyn std::fmt::Display> = names.iter().map(|name| name as &dyn std::fmt::Display).collect();
    let through = Through::Reading(false);
    let parts: Vec<&[usize]> = if are_alike { vec![still] } else { still.chunks(1).collect() };
    let waves = parts.into_iter().flat_map(|some| [wave(some, f64::cos), wave(some, f64::sin)]);
    let mut found = Candidate::one(&LOBES, names.concat(), through, Weight::new(|_| 0.0)).driven_by(&drivers);
    found.columns = waves.map(|wave| vec![(through, wave)]).collect();
    found.constant = Some((f64::from(count), "lobes"));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn a_cup_has_three_lobes_of_its_own_in_each_of_sixty_runs() {
        let machine = bench::machine();
        let found = |runs: usize| {
            let mut rows = "X,Y,Z,dr_um,run,setup\n".to_owned();
            for run in 0..runs {
                rows += &format!("100,0,0,0,{run},A\n0,100,0,0,{run},A\n-100,0,0,0,{run},A\n");
            }
            let description =
                "[measurement]\nkind = \"ballbar\"\nsigma_um = 1\n[setup.A]\ncentre_mm = [0, 0, 0]\nlength_mm = 100\n";
            let sets = [bench::table(&machine, &rows, description)];
            let scene = bench::scene(&machine, &sets);
            let mut out = Vec::new();
            cup(&scene, &mut out);
            out.first().map(|one| {
                one.columns
                    .iter()
                    .map(|column| [0, 1, 2].map(|row| column[0].1.of(&scene.rows[row])))
                    .collect::<Vec<_>>()
            })
        };
        let columns = found(60).unwrap();
        assert_eq!(columns.len(), 120);
        // Sine of three times the angle at 0, 90 and 180°, and the cosine.
        let expected = [[0.0, -1.0, 0.0], [1.0, 0.0, -1.0]];
        let is = |(own, expected): (&[f64; 3], &[f64; 3])| own.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(columns.iter().zip(&expected).all(is), "{:?}", &columns[..2]);
        // These rows belong to the first run.
        assert_eq!(columns[2], [0.0; 3]);
        assert_eq!(found(61), None);
    }
}
