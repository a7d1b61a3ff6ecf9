//! The exact distance of the balls on the plant against the closed forms of ball-bar practice, to 0.002 µm; what is odd and what is even in
//! the sense of the circle, what grows with the feed, and what the planes exchange.

use std::f64::consts::{PI, TAU};

use super::bench::{self, Bench};
use super::catalogue;
use super::effect::{Effect, Place, Stage};
use super::machine::{Errors, Machine};
use super::random::Random;
use super::reading;
use super::row::{Circle, Kind, Row, Setup, Sheet};

const RADIUS: f64 = 100.0;
const CENTRE: [f64; 3] = [350.0, 250.0, 180.0];
/// 0.002 µm in mm.
const CLOSE: f64 = 2e-6;

/// A machine whose axes all carry the tool, so that its errors are those of the tool.
fn machine() -> Machine {
    Machine { known: Vec::new(), ..Machine::mill(1) }
}

/// One full circle in a plane.
fn circle(plane: [usize; 2], sense: f64, feed: f64) -> Sheet {
    let mut sheet = Sheet::new("circle", Kind::Ballbar, 0.3e-3, &[], &[]);
    sheet.setups.push(Setup { label: "A".into(), centre: CENTRE, length: RADIUS, ..Setup::default() });
    let speed = feed / 60.0;
    for k in 0..720 {
        // Off the reversals, where a sign jumps.
        let angle = sense * (f64::from(k) * 0.5 + 0.25).to_radians();
        let (s, c) = angle.sin_cos();
        let mut row = Row { feed, tool: [0.0, 0.0, -120.0], ..Row::default() };
        let mut point = CENTRE;
        point[plane[0]] += RADIUS * c;
        point[plane[1]] += RADIUS * s;
        (0..3).for_each(|k| row.q[k] = point[k] - row.tool[k]);
        (row.v[plane[0]], row.v[plane[1]]) = (-sense * speed * s, sense * speed * c);
        (row.a[plane[0]], row.a[plane[1]]) = (-speed * speed / RADIUS * c, -speed * speed / RADIUS * s);
        plane.iter().for_each(|&axis| row.dir[axis] = row.v[axis].signum());
        row.circle = Some(Circle { plane, angle, sense, radius: RADIUS });
        sheet.rows.push(row);
    }
    sheet
}

/// Change of the distance by one error with a shape, mm, at all rows.
fn changes(sheet: &Sheet, add: &dyn Fn(&Row, &mut Errors)) -> Vec<f64> {
    let at = |row: &Row| {
        let mut errors = Errors::default();
        add(row, &mut errors);
        errors
    };
    sheet.rows.iter().map(|row| reading::read(&machine(), sheet, row, &at)[0]).collect()
}

/// Both senses against a closed form of the angle and the sense.
fn agrees(name: &str, add: &dyn Fn(&Row, &mut Errors), form: &dyn Fn(f64, f64) -> f64) {
    for sense in [1.0, -1.0] {
        let sheet = circle([0, 1], sense, 1000.0);
        for (row, change) in sheet.rows.iter().zip(changes(&sheet, add)) {
            let angle = row.circle.unwrap().angle;
            let expected = form(angle, sense);
            assert!((change - expected).abs() < CLOSE, "{name} at {angle}, {sense}: {change} not {expected}");
        }
    }
}

#[test]
fn distances_follow_the_closed_forms() {
    let e = 5e-3;
    let speed = 1000.0 / 60.0;
    agrees("nothing", &|_, _| {}, &|_, _| 0.0);
    agrees("scale X", &|row, out| out.motion[0][0] = 4e-5 * (row.q[0] - CENTRE[0]), &|t, _| {
        RADIUS * 4e-5 / 2.0 * (1.0 + (2.0 * t).cos())
    });
    let b = 40e-6;
    agrees("squareness", &|_, out| out.location[1][5] = b, &|t, _| {
        -b * RADIUS / 2.0 * (2.0 * t).sin() - b * CENTRE[1] * t.cos()
    });
    agrees("servo mismatch", &|row, out| out.command[0] = -3e-4 * row.v[0], &|t, s| {
        s * speed * 3e-4 / 2.0 * (2.0 * t).sin()
    });
    let along = |row: &Row, axis: usize| (row.q[axis] - CENTRE[axis]) / RADIUS;
    agrees("bow of X", &|row, out| out.motion[0][1] = e * (1.0 - along(row, 0).powi(2)), &|t, _| e * t.sin().powi(3));
    agrees("bow of Y", &|row, out| out.motion[1][0] = e * (1.0 - along(row, 1).powi(2)), &|t, _| e * t.cos().powi(3));
    agrees("backlash X", &|row, out| out.motion[0][0] = -e / 2.0 * row.dir[0], &|t, s| {
        e / 2.0 * s * t.sin().signum() * t.cos()
    });
    agrees("backlash Y", &|row, out| out.motion[1][1] = -e / 2.0 * row.dir[1], &|t, s| {
        -e / 2.0 * s * t.cos().signum() * t.sin()
    });
    agrees("lateral play of X", &|row, out| out.motion[0][1] = e / 2.0 * row.dir[0], &|t, s| {
        -e / 2.0 * s * t.sin().abs()
    });
    agrees(
        "pitch of a screw",
        &|row, out| out.motion[0][0] = e / 3.0 * (TAU * (row.q[0] - CENTRE[0]) / 10.0 + 0.4).sin(),
        &|t, _| e / 3.0 * t.cos() * (TAU * RADIUS * t.cos() / 10.0 + 0.4).sin(),
    );
}

#[test]
fn set_ups_follow_the_closed_forms() {
    let mut sheet = circle([0, 1], 1.0, 1000.0);
    sheet.setups[0].off_centre = [6e-3, -4e-3, 0.0];
    sheet.setups[0].off_length = 3e-3;
    for (row, change) in sheet.rows.iter().zip(changes(&sheet, &|_, _| {})) {
        let t = row.circle.unwrap().angle;
        assert!((change - (-6e-3 * t.cos() + 4e-3 * t.sin() - 3e-3)).abs() < CLOSE);
    }
}

/// An effect of the catalogue that acts on an axis, or on any.
fn of_row(row: u8, axis: Option<usize>) -> Effect {
    let plan = bench::plan(Bench::Ballbar, 0.2, 2);
    let stage =
        Stage { bench: Bench::Ballbar, machine: &plan.machine, sheets: &plan.sheets, used: plan.used, about: 1.5e-3 };
    let is_it = |effect: &Effect| axis.is_none_or(|axis| effect.acting[0].0 == Place::Command(axis));
    let made = (0..99).filter_map(|seed| catalogue::effect(row, &stage, &mut Random::new(seed, "signature")));
    made.into_iter().find(is_it).unwrap()
}

#[test]
fn lags_grow_with_the_feed() {
    let [slow, fast] = [1000.0, 2000.0].map(|feed| circle([0, 1], 1.0, feed));
    let ratio = |effect: &Effect| {
        let [one, two] = [&slow, &fast].map(|sheet| changes(sheet, &|row, out| effect.add(row, out)));
        one.iter().zip(&two).map(|(a, b)| (a * b).signum() * (b * b).sqrt() / a.abs().max(1e-9)).nth(77).unwrap()
    };
    let mut mismatch = of_row(26, Some(0));
    mismatch.amplitude = 2e-4;
    assert!((ratio(&mismatch) - 2.0).abs() < 2e-3, "{}", ratio(&mismatch));
    let mut shrink = of_row(28, None);
    shrink.amplitude = 0.02 * 0.02;
    assert!((ratio(&shrink) - 4.0).abs() < 2e-3, "{}", ratio(&shrink));
    let speed = 1000.0 / 60.0;
    for change in changes(&slow, &|row, out| shrink.add(row, out)) {
        assert!((change + (speed * 0.02_f64).powi(2) / (2.0 * RADIUS)).abs() < CLOSE);
    }
    // A delay of all axes turns the circle in itself.
    let delay = changes(&slow, &|row, out| (0..3).for_each(|k| out.command[k] = -3e-4 * row.v[k]));
    assert!(delay.iter().all(|change| change.abs() < CLOSE));
}

#[test]
fn a_spike_stands_outwards_behind_the_reversal() {
    let mut spike = of_row(22, Some(0));
    spike.amplitude = 5e-3;
    for sense in [1.0, -1.0] {
        let sheet = circle([0, 1], sense, 1000.0);
        for (row, change) in sheet.rows.iter().zip(changes(&sheet, &|row, out| spike.add(row, out))) {
            // X reverses at 0 and at 180 degrees.
            let t = row.circle.unwrap().angle;
            let way = (sense * t).rem_euclid(PI).to_degrees();
            if way < 1.0 {
                assert!(change > 2.5e-3, "outwards behind the reversal: {change} at {way}");
            } else if way > 60.0 {
                assert!(change.abs() < 1e-5, "nothing before the next one: {change} at {way}");
            }
        }
    }
}

#[test]
fn senses_and_planes_exchange_what_they_should() {
    // A circle in the other sense passes the same angles the other way.
    let paired = |add: &dyn Fn(&Row, &mut Errors)| {
        let [ccw, cw] = [1.0, -1.0].map(|sense| changes(&circle([0, 1], sense, 1000.0), add));
        let cw: Vec<f64> = cw.into_iter().rev().collect();
        let even = ccw.iter().zip(&cw).map(|(a, b)| (a + b).abs()).fold(0.0, f64::max);
        let odd = ccw.iter().zip(&cw).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (even, odd)
    };
    let servo = paired(&|row, out| out.command[0] = -3e-4 * row.v[0]);
    let backlash = paired(&|row, out| out.motion[0][0] = 3e-3 * row.dir[0]);
    let play = paired(&|row, out| out.motion[0][1] = 3e-3 * row.dir[0]);
    for (even, odd) in [servo, backlash, play] {
        assert!(even < 2.0 * CLOSE && odd > 4e-3, "odd: {even} {odd}");
    }
    let scale = paired(&|row, out| out.motion[0][0] = 3e-5 * (row.q[0] - CENTRE[0]));
    let square = paired(&|_, out| out.location[1][5] = 40e-6);
    for (even, odd) in [scale, square] {
        assert!(odd < 2.0 * CLOSE && even > 4e-3, "even: {even} {odd}");
    }
    // X in the plane YX is Y in the plane XY.
    let one = changes(&circle([0, 1], 1.0, 1000.0), &|row, out| out.motion[0][0] = 3e-3 * row.dir[0]);
    let two = changes(&circle([1, 0], 1.0, 1000.0), &|row, out| out.motion[1][1] = 3e-3 * row.dir[1]);
    assert!(one.iter().zip(two).all(|(a, b)| (a - b).abs() < CLOSE));
}

#[test]
fn corners_of_chords_lie_on_the_circle_and_their_middles_within() {
    let chords = of_row(36, None);
    let sheet = circle([0, 1], 1.0, 1000.0);
    let super::effect::Law::Fixed(count) = chords.law else { panic!("chords are counted") };
    let sagitta = RADIUS * (1.0 - (PI / count).cos());
    let all = changes(&sheet, &|row, out| chords.add(row, out));
    assert!(all.iter().all(|change| (-sagitta - CLOSE..CLOSE).contains(change)));
    assert!(all.iter().any(|change| *change < -0.9 * sagitta) && all.iter().any(|change| *change > -0.2 * sagitta));
}
