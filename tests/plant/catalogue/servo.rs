//! What only a moving axis does: lags, stuck axes, deflections, vibrations, delays, chords.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use crate::plant::bench::Bench;
use crate::plant::effect::{Effect, Law, Place, Stage};
use crate::plant::machine::LETTERS;
use crate::plant::random::Random;
use crate::plant::row::Row;

const PLANES: [&str; 3] = ["XY", "YZ", "ZX"];

/// Cosine or sine of the circle's angle as an axis has it; 0 for an axis that stands.
fn part(row: &Row, axis: usize) -> f64 {
    row.circle.map_or(0.0, |circle| match circle.plane {
        [a, _] if a == axis => circle.angle.cos(),
        [_, b] if b == axis => circle.angle.sin(),
        _ => 0.0,
    })
}

/// How far the circle has gone since an axis reversed, rad, and on which side it is: 1 where the axis has come from its + end.
pub(crate) fn behind_reversal(row: &Row, axis: usize) -> Option<(f64, f64)> {
    let circle = row.circle.filter(|circle| circle.plane.contains(&axis))?;
    // At 0 and 180° for the abscissa, at 90 and 270° for the ordinate.
    let at = if circle.plane[0] == axis { circle.angle } else { circle.angle - PI / 2.0 };
    let way = (circle.sense * at).rem_euclid(PI);
    let reversal = at - circle.sense * way;
    Some((way, reversal.cos().signum()))
}

/// The effect of a row of the catalogue.
pub(super) fn effect(row: u8, stage: &Stage<'_>, random: &mut Random) -> Option<Effect> {
    let axis = random.below(3);
    let letter = LETTERS[axis];
    let all = |effect: Effect, place: fn(usize) -> Place, shape: fn(&Row, usize) -> f64| {
        (0..3).fold(effect, |effect, axis| effect.acts(place(axis), move |row| shape(row, axis)))
    };
    Some(
        match row {
            22 => {
                // The width is a way of the circle, a degree to a few on the smallest one.
                let width_mm = random.between(2.5, 7.0);
                Effect::new(row, "reversal-spike", letter, &[letter, &format!("{letter}_dir")], Law::Linear(1e3), "um")
                    .acts(Place::Command(axis), move |row| {
                        behind_reversal(row, axis).map_or(0.0, |(way, side)| {
                            side * (-way * row.circle.map_or(1.0, |circle| circle.radius) / width_mm).exp()
                        })
                    })
            }
            23 => {
                let (tooth, phase) = (random.between(0.15, 0.4), random.unit());
                Effect::new(row, "dynamic", letter, &[letter, "feed_mm_min"], Law::Linear(1e3), "um")
                    .acts(Place::Command(axis), move |row| {
                        let saw = 1.0 - 2.0 * (row.q[axis] / tooth + phase).rem_euclid(1.0);
                        // Below 150 mm/min of the axis.
                        if row.circle.is_some_and(|circle| circle.plane.contains(&axis)) {
                            row.dir[axis] * saw * (-(row.v[axis] / 2.5).powi(2)).exp()
                        } else {
                            0.0
                        }
                    })
                    .alias("reversal-spike", letter)
            }
            26 => {
                // One axis is later than the two others: two planes show it.
                let (first, second) = (PLANES[axis], PLANES[(axis + 2) % 3]);
                Effect::new(row, "servo-mismatch", first, &["feed_mm_min", letter], Law::Linear(1e3), "ms")
                    .acts(Place::Command(axis), move |row| -row.v[axis])
                    .alias("servo-mismatch", second)
                    .alias("servo-mismatch", letter)
            }
            27 => Effect::new(row, "following", letter, &["feed_mm_min", letter], Law::Linear(1e3), "ms")
                .acts(Place::Command(axis), move |row| -row.v[axis])
                .alias("delay", letter),
            33 => all(
                Effect::new(row, "delay", "", &["feed_mm_min"], Law::Linear(1e3), "ms"),
                Place::Command,
                |row, axis| -row.v[axis],
            ),
            34 => all(
                Effect::new(row, "delay", "t_s", &["feed_mm_min", "t_s"], Law::Linear(1e6), "ppm"),
                Place::Command,
                |row, axis| -row.v[axis] * row.t,
            )
            .only_here(),
            28 => {
                // Half of tau² a towards the centre: what is left of a lag of first order when its delay is taken out.
                let effect = Effect::new(row, "following", "XYZ", &["feed_mm_min"], Law::Root(1e3), "ms");
                let effect = all(effect, Place::Command, |row, axis| row.a[axis] / 2.0);
                PLANES.iter().fold(effect, |effect, plane| effect.alias("following", plane)).alias("dynamic", "XYZ")
            }
            30 => Effect::new(row, "dynamic", letter, &["feed_mm_min", letter], Law::Linear(1e6), "um/(m/s2)")
                .acts(Place::Tip(axis), move |row| row.a[axis]),
            32 => {
                let frequency = random.between(0.8, 3.2);
                let phases: Vec<f64> = stage.sheets.iter().map(|_| random.between(0.0, TAU)).collect();
                Effect::new(row, "dynamic", letter, &["t_s"], Law::Linear(1e3), "um")
                    .acts(Place::Tip(axis), move |row| (TAU * frequency * row.t + phases[row.day]).sin())
                    .alias("periodic", letter)
                    .repeats(1.0 / frequency)
                    .only_here()
            }
            36 => chords(row, stage),
            37 => {
                let effect = Effect::new(row, "dynamic", "", &["X", "Y", "Z"], Law::Linear(1e3), "um");
                let effect = all(effect, Place::Command, |row, axis| {
                    let first = row.circle.is_some_and(|circle| circle.angle.cos().abs() > FRAC_PI_4.cos());
                    part(row, axis) * if first { 0.5 } else { -0.5 }
                });
                PLANES.iter().fold(effect, |effect, plane| effect.alias("dynamic", plane))
            }
            _ => return None,
        }
        .alias_on(stage),
    )
}

/// A circle of straight blocks: the number of corners follows from how far a chord may be off.
fn chords(row: u8, stage: &Stage<'_>) -> Effect {
    let radius = 100.0;
    // The root mean square of a parabola about its mean is 0.298 of its height.
    let sagitta = stage.about / 0.298;
    let count = (PI / (1.0 - sagitta / radius).acos()).round().max(3.0);
    let effect = Effect::new(row, "program", "", &["X", "Y", "Z"], Law::Fixed(count), "chords");
    (0..3).fold(effect, |effect, axis| {
        effect.acts(Place::Command(axis), move |row| {
            let Some(circle) = row.circle else { return 0.0 };
            let half = PI / count;
            let within = circle.angle.rem_euclid(2.0 * half) - half;
            part(row, axis) * circle.radius * (half.cos() / within.cos() - 1.0)
        })
    })
}

impl Effect {
    /// On the fly the axes move alone: a delay of one of them is its following error, and that of all is three.
    fn alias_on(self, stage: &Stage<'_>) -> Effect {
        let is_common = self.hidden.row == 33 && stage.bench == Bench::OnTheFly;
        if is_common {
            LETTERS[..3].iter().fold(self, |effect, letter| effect.alias("following", letter))
        } else {
            self
        }
    }
}
