//! Errors of the servo loops: lag between axes, lag of an axis after its command, deflection by acceleration.
//!
//! An axis with lag τ is at −τ v from its command. Two axes with equal lags cause no path error except along the path.

use super::{Candidate, Cause, Correctable, EffectKind, Weight};
use crate::diagnose::row::SceneRow;
use crate::diagnose::scene::{Scene, Through};
use crate::measure::kind::Measurand;
use ncfix_base::geometry::{Axis, AxisVector};

pub(super) const MISMATCH: Cause = Cause {
    name: "servo mismatch",
    effect: EffectKind::ServoMismatch,
    made_by: "different velocity gains",
    shown_by: "ball-bar: an oval at 45° that changes its sign with the direction and increases with the feed",
    separate_by: "the circle in the other direction",
    correctable: Correctable::No,
    propose: mismatch,
};

pub(super) const MISMATCH_AT_USUAL_FEED: Cause = Cause {
    name: "servo mismatch at an unknown feed",
    effect: EffectKind::ServoMismatch,
    made_by: "different velocity gains; the lag is stated for a feed of 1000 mm/min, as the readings have none",
    shown_by: "ball-bar: an oval at 45° that changes its sign with the direction",
    separate_by: "the circle in the other direction, with the column feed_mm_min",
    correctable: Correctable::No,
    propose: mismatch_at_usual_feed,
};

pub(super) const FOLLOWING: Cause = Cause {
    name: "following error",
    effect: EffectKind::Following,
    made_by: "velocity gain without feed-forward",
    shown_by: "traces: the difference between set-point and encoder increases with the velocity; ball-bar: circles shrink with the square of the feed",
    separate_by: "two feeds separate it from the length of the bar",
    correctable: Correctable::No,
    propose: following,
};

pub(in crate::diagnose) const DYNAMIC: Cause = Cause {
    name: "deflection by acceleration",
    effect: EffectKind::Dynamic,
    made_by: "inertia and compliance of the frame",
    shown_by: "errors at corners and small circles that increase with the acceleration",
    separate_by: "encoders show a lag, but not a deflection",
    correctable: Correctable::No,
    propose: dynamic,
};

pub(super) const DELAY: Cause = Cause {
    name: "delay between readings and positions",
    effect: EffectKind::Delay,
    made_by: "two recorders, clocks with different rates",
    shown_by: "readings of moving axes: the two directions differ in proportion to the feed, equally on all axes",
    separate_by: "an external clock, two feeds: a lag of one axis differs from that of the others",
    correctable: Correctable::No,
    propose: delay,
};

pub(super) const STICK_SLIP: Cause = Cause {
    name: "stick-slip",
    effect: EffectKind::Dynamic,
    made_by: "friction that decreases with the speed, at low feeds",
    shown_by: "a sawtooth where an axis is slow; rougher traces at low feed",
    separate_by: "a higher feed: it disappears",
    correctable: Correctable::No,
    propose: stick_slip,
};

/// Linear axes with a velocity or an acceleration in at least one row.
fn moving(scene: &Scene<'_>, of: fn(&SceneRow) -> Option<AxisVector>) -> Vec<Axis> {
    let axes = scene.machine.axes.iter().flatten().map(|data| data.axis).filter(|axis| !axis.is_rotary());
    axes.filter(|&axis| scene.rows.iter().any(|row| of(row).is_some_and(|value| value[axis] != 0.0))).collect()
}

/// Effect of an axis ahead of its command, with its sign. Errors are those of the moving body; for an axis that moves the table the sign is reversed.
fn ahead(scene: &Scene<'_>, axis: Axis) -> (Through, f64) {
    (Through::Component(super::own(axis)), super::body_sense(scene, axis))
}

/// Effect of a lag of an axis by `factor` seconds.
fn lag(scene: &Scene<'_>, axis: Axis, factor: f64) -> (Through, Weight) {
    let (through, sense) = ahead(scene, axis);
    let by = -factor * sense;
    (through, Weight::new(move |row| by * row.velocity.map_or(0.0, |velocity| velocity[axis])))
}

/// Name of the pair of axes that begins with this axis in cyclic order: XY, YZ, ZX.
fn pair(axes: &[Axis], axis: Axis) -> String {
    let next = axes.iter().copied().find(|other| other.dimension() == (axis.dimension() + 1) % 3);
    next.map_or_else(|| axis.to_string(), |next| format!("{axis}{next}"))
}

/// Proposes the pairs of axes that move together on circles whose feed was not noted.
fn mismatch_at_usual_feed(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let axes = moving(scene, |row| row.assumed_velocity);
    let lag = |axis: Axis, factor: f64| {
        let (through, sense) = ahead(scene, axis);
        let by = -factor * sense;
        (through, Weight::new(move |row| by * row.assumed_velocity.map_or(0.0, |velocity| velocity[axis])))
    };
    let moves = |row: &SceneRow, axis: Axis| row.assumed_velocity.is_some_and(|velocity| velocity[axis].abs() > 1e-3);
    let pairs = axes.iter().flat_map(|&one| axes.iter().map(move |&other| (one, other)));
    for (one, other) in pairs.filter(|(one, other)| other.dimension() == (one.dimension() + 1) % 3) {
        if scene.rows.iter().any(|row| moves(row, one) && moves(row, other)) {
            let parts = vec![lag(one, 0.5), lag(other, -0.5)];
            let name = format!("{one}{other}");
            let mut candidate = Candidate::one(&MISMATCH_AT_USUAL_FEED, name, parts[0].0, parts[0].1.clone());
            candidate.columns = vec![parts];
            out.push(candidate.driven_by(&[&one, &other]));
        }
    }
}

/// Proposes pairs of axes that move at the same time; only these can have a mismatch.
fn mismatch(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let axes = moving(scene, |row| row.velocity);
    let moves = |row: &SceneRow, axis: Axis| row.velocity.is_some_and(|v| v[axis].abs() > 1e-3);
    let together = |one: Axis, other: Axis| scene.rows.iter().any(|row| moves(row, one) && moves(row, other));
    for &one in &axes {
        let mut others = 0;
        for &other in axes.iter().filter(|&&other| other != one && together(one, other)) {
            others += 1;
            if other.dimension() == (one.dimension() + 1) % 3 {
                let parts = vec![lag(scene, one, 0.5), lag(scene, other, -0.5)];
                let mut candidate = Candidate::one(&MISMATCH, format!("{one}{other}"), parts[0].0, parts[0].1.clone());
                candidate.drivers = vec!["feed_mm_min".into(), one.to_string(), other.to_string()];
                // Both parts have one amount: the difference of the lags.
                candidate.columns = vec![parts];
                out.push(candidate);
            }
        }
        // One axis that lags two others.
        if others > 1 {
            let (through, weight) = lag(scene, one, 1.0);
            let candidate = Candidate::one(&MISMATCH, pair(&axes, one), through, weight);
            out.push(candidate.driven_by(&[&"feed_mm_min", &one]));
        }
    }
}

fn following(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    // To a ball-bar, a lag of one axis is a lag against the other one, a mismatch.
    let is_bar = |set: &crate::measure::data::DataSet| set.kind.measurand == Measurand::BallDistance;
    let axes = if scene.sets.iter().all(is_bar) { Vec::new() } else { moving(scene, |row| row.velocity) };
    for &axis in &axes {
        let (through, weight) = lag(scene, axis, 1.0);
        let one = Candidate::one(&FOLLOWING, axis, through, weight);
        out.push(one.driven_by(&[&"feed_mm_min", &axis]));
    }
    // A first-order lag without its delay leaves half of τ² times the acceleration, towards the center.
    let axes = moving(scene, |row| row.acceleration);
    let half = |axis: &Axis| {
        let axis = *axis;
        let (through, sense) = ahead(scene, axis);
        let half = sense / 2.0;
        (through, Weight::new(move |row| half * row.acceleration.map_or(0.0, |acceleration| acceleration[axis])))
    };
    let parts: Vec<(Through, Weight)> = axes.iter().map(half).collect();
    if let Some((through, weight)) = parts.first().cloned()
        && parts.len() > 1
    {
        let name: String = axes.iter().map(ToString::to_string).collect();
        let mut one = Candidate::one(&FOLLOWING, name, through, weight).driven_by(&[&"feed_mm_min"]);
        one.columns = vec![parts];
        out.push(one);
    }
}

/// Proposes a delay between readings and positions: all axes are at their earlier positions, with a fast clock by an increasing amount.
fn delay(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let axes = moving(scene, |row| row.velocity);
    let Some(&first) = axes.first() else { return };
    let start = super::times(scene).map(|[start, _]| start);
    let all = |clock: Option<f64>| -> Vec<(Through, Weight)> {
        let part = |&axis: &Axis| {
            let (through, sense) = ahead(scene, axis);
            let weight = Weight::new(move |row| {
                let since = clock.map_or(1.0, |start| row.time_s.map_or(0.0, |time| time - start));
                -sense * since * row.velocity.map_or(0.0, |velocity| velocity[axis])
            });
            (through, weight)
        };
        axes.iter().map(part).collect()
    };
    let mut one = Candidate::one(&DELAY, "", Through::Component(super::own(first)), Weight::new(|_| 0.0));
    one.columns = vec![all(None)];
    out.push(one.driven_by(&[&"feed_mm_min"]));
    if start.is_some() {
        let mut one = Candidate::one(&DELAY, "t_s", Through::Component(super::own(first)), Weight::new(|_| 0.0));
        one.columns = vec![all(start)];
        out.push(one.driven_by(&[&"feed_mm_min", &"t_s"]));
    }
}

fn dynamic(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in moving(scene, |row| row.acceleration) {
        let weight = Weight::new(move |row| row.acceleration.map_or(0.0, |acceleration| acceleration[axis]));
        for direction in 0..3 {
            let letter = super::tip(direction);
            let name = if axis.dimension() == direction { letter.to_owned() } else { format!("{axis}{letter}") };
            let one = Candidate::one(&DYNAMIC, name, Through::Tip(direction), weight.clone());
            out.push(one.driven_by(&[&"feed_mm_min", &axis]));
        }
    }
}

/// Lengths over which an axis sticks and slips, mm.
const TEETH: [f64; 12] = [0.12, 0.135, 0.15, 0.17, 0.19, 0.215, 0.24, 0.27, 0.3, 0.335, 0.375, 0.42];
/// Speeds of an axis below which it sticks and slips, mm/s.
const SLOW: [f64; 2] = [2.5, 6.0];

fn stick_slip(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let is_slow = |row: &SceneRow, axis: Axis| {
        row.velocity.is_some_and(|velocity| velocity[axis].abs() < SLOW[1] && row.since_turn[axis].is_finite())
    };
    for axis in moving(scene, |row| row.velocity) {
        if !scene.rows.iter().any(|row| is_slow(row, axis)) {
            continue;
        }
        for tooth in TEETH {
            for slow in SLOW {
                let wave = |harmonic: f64, of: fn(f64) -> f64| {
                    Weight::new(move |row| {
                        let Some(speed) = row.velocity.map(|velocity| velocity[axis]) else { return 0.0 };
                        let fade = (-(speed / slow).powi(2)).exp();
                        row.sense_of(axis) * of(std::f64::consts::TAU * harmonic * row.position[axis] / tooth) * fade
                    })
                };
                let mut one =
                    Candidate::one(&STICK_SLIP, axis, Through::Component(super::own(axis)), wave(1.0, f64::sin));
                for column in [wave(1.0, f64::cos), wave(2.0, f64::sin), wave(2.0, f64::cos)] {
                    one.columns.push(vec![(Through::Component(super::own(axis)), column)]);
                }
                one.constant = Some((tooth, "mm"));
                out.push(one.driven_by(&[&axis, &"feed_mm_min"]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn a_lag_of_first_order_leaves_half_of_the_acceleration() {
        let machine = bench::machine();
        // x = t² and y = −2 t² with one reading per second.
        let rows: String = (0..5).map(|t| format!("{},{},0,0,0,0,{t}\n", t * t, -2 * t * t)).collect();
        let rows = format!("X,Y,Z,dx_um,dy_um,dz_um,t_s\n{rows}");
        let sets = [bench::table(&machine, &rows, "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n")];
        let scene = bench::scene(&machine, &sets);
        let mut found = Vec::new();
        following(&scene, &mut found);
        let both = found.iter().find(|one| one.parameter == "XY").unwrap();
        // In the middle the accelerations are 2 and −4 mm/s².
        let parts: Vec<f64> = both.columns[0].iter().map(|(_, weight)| weight.of(&scene.rows[2])).collect();
        assert_eq!(parts, [1.0, -2.0]);
        // The velocities are 4 and −8 mm/s, and the axes lag.
        let lags = ["X", "Y"].map(|axis| found.iter().find(|one| one.parameter == axis).unwrap());
        assert_eq!(lags.map(|one| one.columns[0][0].1.of(&scene.rows[2])), [-4.0, 8.0]);
    }
}
