//! Hemispheres with a ball-bar: five meridians joined by arcs along the equator (Esmaeili 2021, ch. 4.6.2), and the eight spheres of
//! Spaan 1995, Table 3.1.
//!
//! The pole is on the side of the spindle. The path is made of chords: 0.1° at 150 mm leaves 0.06 µm to the sphere.

use std::f64::consts::PI;

use super::builder::{Builder, Extra, Reach, observation};
use super::{PlanKind, Refused, Wishes, along_spindle, empty, kind};
use crate::geometry::Vector;
use crate::machine::{Machine, State};
use crate::measure::data::{Free, Observation, Setup};
use crate::measure::reading::Reading;

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "sphere",
    title: "hemisphere of five meridians about a ball on the table; variant spaan: the eight spheres of Spaan's Table 3.1",
    wishes: &["centre", "radius", "feed", "every", "chord", "variant"],
    build,
};

/// Meridians.
const MERIDIANS: u32 = 5;

/// Number of the experiment, radius, centre, tool length, mm (Spaan 1995, Table 3.1).
const SPAAN: [(u32, f64, [f64; 3], f64); 8] = [
    (4, 300.0, [300.0, 80.0, 300.0], 110.0),
    (14, 150.0, [300.0, 80.0, 300.0], 110.0),
    (27, 300.0, [400.0, 190.0, 300.0], 110.0),
    (29, 250.0, [400.0, 190.0, 300.0], 110.0),
    (89, 300.0, [50.0, 80.0, 300.0], 110.0),
    (99, 150.0, [350.0, 210.0, 300.0], 245.0),
    (105, 300.0, [350.0, 210.0, 300.0], 245.0),
    (137, 300.0, [350.0, 210.0, 0.0], 245.0),
];

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, Refused> {
    let spheres = match wishes.variant.as_deref() {
        None | Some("meridians") => {
            let tool_mm = wishes.tool_mm();
            vec![(
                "A".to_owned(),
                wishes.radius_mm.unwrap_or(150.0),
                wishes.centre_or_middle(machine, &tool_mm),
                tool_mm,
            )]
        }
        Some("spaan") => SPAAN
            .iter()
            .map(|&(number, radius_mm, [x, y, z], length_mm)| {
                (number.to_string(), radius_mm, Vector::new(x, y, z), machine.spindle.axis * -length_mm)
            })
            .collect(),
        Some(other) => return Err(Refused(format!("there is no sphere '{other}'; the variants are meridians, spaan"))),
    };
    let feed = wishes.feed.unwrap_or(200.0);
    let chord = wishes.chord.unwrap_or(0.1_f64.to_radians()).clamp(1e-4, 0.2);
    let every = wishes.every.unwrap_or(5_f64.to_radians()).max(chord);
    let mut data = empty(kind("ballbar")?, &[Free::Centre, Free::Length]);
    for (label, length_mm, centre_mm, _) in &spheres {
        data.setups.push(Setup { label: label.clone(), centre_mm: *centre_mm, length_mm: *length_mm });
    }
    let mut plan = Builder::new(machine, data);
    plan.reach = Reach::Sphere { chord, feed };
    for (number, (label, radius_mm, centre_mm, tool_mm)) in spheres.iter().enumerate() {
        plan.stop(&format!("set-up {label}: take the ball-bar off: the axes go to their first position"));
        hemisphere(&mut plan, number, (*radius_mm, centre_mm, tool_mm), [chord, every], feed)?;
    }
    if let [(_, radius_mm, _, tool_mm)] = spheres.as_slice() {
        plan.candidates = candidates(&plan, 0, *radius_mm, tool_mm);
    }
    Ok(plan)
}

/// A point of the unit sphere: along a meridian from the equator over the pole to the equator.
fn on_meridian(machine: &Machine, azimuth: f64, along: f64) -> Vector {
    let (which, sign) = along_spindle(machine);
    let mut point = Vector::zeros();
    point[(which + 1) % 3] = along.cos() * azimuth.cos();
    point[(which + 2) % 3] = along.cos() * azimuth.sin();
    point[which] = along.sin() * sign;
    point
}

/// The hemisphere of one set-up.
fn hemisphere(
    plan: &mut Builder,
    setup: usize,
    (radius_mm, centre_mm, tool_mm): (f64, &Vector, &Vector),
    [chord, every]: [f64; 2],
    feed: f64,
) -> Result<(), Refused> {
    let machine = plan.machine.clone();
    let centre = plan.at_tip(centre_mm, tool_mm);
    let at = |azimuth: f64, along: f64| {
        let mut out = centre;
        out.set_xyz(centre.xyz() + on_meridian(&machine, azimuth, along) * radius_mm);
        out
    };
    let stride = PI / f64::from(MERIDIANS);
    plan.go(&at(0.0, 0.0), Some(feed))?;
    plan.stop("put the ball-bar on");
    for meridian in 0..MERIDIANS {
        let azimuth = stride * f64::from(meridian);
        // Every other one backwards, from where the arc on the equator has led.
        let is_back = meridian % 2 == 1;
        let along = move |share: f64| if is_back { PI * (1.0 - share) } else { PI * share };
        travel(plan, setup, tool_mm, PI, [chord, every], feed, &format!("m{}", meridian + 1), |share| {
            at(azimuth, along(share))
        })?;
        if meridian + 1 < MERIDIANS {
            let end = azimuth + if is_back { 0.0 } else { PI };
            travel(plan, setup, tool_mm, stride, [chord, every], feed, &format!("e{}", meridian + 1), |share| {
                at(end + stride * share, 0.0)
            })?;
        }
    }
    Ok(())
}

/// Chords from a share of 0 to 1 of an angle, with rows where they are due.
#[expect(clippy::too_many_arguments, reason = "all of them say what one arc is")]
fn travel(
    plan: &mut Builder,
    setup: usize,
    tool_mm: &Vector,
    angle: f64,
    [chord, every]: [f64; 2],
    feed: f64,
    run: &str,
    at: impl Fn(f64) -> crate::geometry::AxisVector,
) -> Result<(), Refused> {
    let rows = (angle / every).round().max(1.0) as usize;
    // Whole chords between rows, none longer than asked for.
    let between = (angle / rows as f64 / chord - 1e-9).ceil().max(1.0) as usize;
    let chords = rows * between;
    plan.comment(run);
    for number in 0..=chords {
        let position = plan.on_increments(&at(number as f64 / chords as f64));
        if number > 0 {
            plan.go(&position, Some(feed))?;
        }
        if number.is_multiple_of(between) {
            let extra = Extra { run: run.to_owned(), feed: Some(feed), ..Extra::default() };
            plan.row(&position, *tool_mm, setup, extra)?;
        }
    }
    Ok(())
}

/// Further poses on the hemisphere, 15° apart, off the meridians.
pub(super) fn candidates(plan: &Builder, setup: usize, radius_mm: f64, tool_mm: &Vector) -> Vec<Observation> {
    let centre_mm = plan.data.setups.get(setup).map_or_else(Vector::zeros, |setup| setup.centre_mm);
    let centre = plan.at_tip(&centre_mm, tool_mm);
    let mut out = Vec::new();
    for azimuth in 0..24 {
        for height in 0..6 {
            let [azimuth, height] = [azimuth, height].map(|step: u8| (f64::from(step) * 15.0).to_radians());
            let mut position = centre;
            position.set_xyz(centre.xyz() + on_meridian(&plan.machine, azimuth, height) * radius_mm);
            let position = plan.on_increments(&position);
            if plan.outside(&position).is_none() {
                out.push(observation(Reading { position, tool_mm: *tool_mm, state: State::default() }, setup));
            }
        }
    }
    out
}
