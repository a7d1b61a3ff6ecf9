//! Hemispheres with a ball-bar: five meridians joined by arcs along the equator, 36° apart (Esmaeili 2021, ch. 4.6.2), and the eight spheres of
//! Spaan 1995, Table 3.1.
//!
//! `meridians` runs every meridian once. `esmaeili` runs each forth and back and has a fifth arc, so that it ends opposite to its start, as printed:
//! eleven half circles, 19 800 chords of 0.1° of the 19 809 positions of that program. The pole is on the side of the spindle. The path consists of
//! chords: 0.1° at 150 mm deviates by 0.06 µm from the sphere.
//!
//! In `spaan` the pole is along +Y and points outside the travel are left out: the printed heights allow only 300 mm upwards, and X 50 does not allow
//! a whole sphere.

use std::f64::consts::PI;

use super::builder::{Builder, Extra, PlanReach, observation};
use super::{PlanKind, PlanRefused, RowSpacing, Wishes, along_spindle, empty, kind};
use crate::measure::data::{Free, Observation, Setup};
use crate::measure::reading::Reading;
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "sphere",
    title: "hemisphere of five meridians about a ball on the table; variants esmaeili, and spaan: the eight spheres of Table 3.1",
    wishes: &["center", "radius", "feed", "every", "chord", "variant"],
    spacing: RowSpacing::Angle,
    has_setups: false,
    build,
};

/// Number of meridians.
const MERIDIANS: u32 = 5;
/// Chord angle of the path between parts of a sphere, rad.
const WAY_CHORD: f64 = PI / 180.0;

/// Number of the experiment, radius, center, tool length, mm (Spaan 1995, Table 3.1).
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

/// The spheres, and how they are run.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SphereVariant {
    /// Every meridian once.
    Meridians,
    /// Each forth and back.
    Esmaeili,
    /// The eight of Table 3.1.
    Spaan,
}

impl SphereVariant {
    fn from_word(word: &str) -> Option<SphereVariant> {
        Some(match word {
            "meridians" => SphereVariant::Meridians,
            "esmaeili" => SphereVariant::Esmaeili,
            "spaan" => SphereVariant::Spaan,
            _ => return None,
        })
    }
}

/// A sphere.
struct Sphere {
    label: String,
    radius_mm: f64,
    centre_mm: Vector,
    tool_mm: Vector,
}

/// Common settings of all spheres.
struct SphereSettings {
    /// Angles of a chord and between rows.
    chord: f64,
    every: f64,
    feed: f64,
    /// Direction of the pole: 0 to 2, and its sign.
    pole: (usize, f64),
    legs: Vec<Leg>,
    /// `true` if points outside the travel are left out.
    is_partial: bool,
}

/// A part of a great circle: azimuth and angle along the meridian at its ends.
struct Leg {
    run: String,
    from: [f64; 2],
    to: [f64; 2],
}

impl Leg {
    fn angle(&self) -> f64 {
        (self.to[0] - self.from[0]).abs() + (self.to[1] - self.from[1]).abs()
    }

    fn at(&self, share: f64) -> [f64; 2] {
        [0, 1].map(|k| self.from[k] + (self.to[k] - self.from[k]) * share)
    }
}

/// Every meridian once, in alternating directions, with arcs between them.
fn once() -> Vec<Leg> {
    let stride = PI / f64::from(MERIDIANS);
    let mut out = Vec::new();
    for meridian in 0..MERIDIANS {
        let azimuth = stride * f64::from(meridian);
        // Every other one backwards, from the end of the arc on the equator.
        let [from, to] = if meridian % 2 == 1 { [PI, 0.0] } else { [0.0, PI] };
        out.push(Leg { run: format!("m{}", meridian + 1), from: [azimuth, from], to: [azimuth, to] });
        if meridian + 1 < MERIDIANS {
            // The end of a meridian at π is on its opposite side.
            let end = azimuth + to;
            out.push(Leg { run: format!("e{}", meridian + 1), from: [end, 0.0], to: [end + stride, 0.0] });
        }
    }
    out
}

/// Every meridian forth and back, each followed by an arc.
fn forth_and_back() -> Vec<Leg> {
    let stride = PI / f64::from(MERIDIANS);
    let of = |meridian: u32| {
        let azimuth = stride * f64::from(meridian);
        let name = meridian + 1;
        [
            Leg { run: format!("m{name}+"), from: [azimuth, 0.0], to: [azimuth, PI] },
            Leg { run: format!("m{name}-"), from: [azimuth, PI], to: [azimuth, 0.0] },
            Leg { run: format!("e{name}"), from: [azimuth, 0.0], to: [azimuth + stride, 0.0] },
        ]
    };
    (0..MERIDIANS).flat_map(of).collect()
}

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, PlanRefused> {
    let word = wishes.variant.as_deref().unwrap_or("meridians");
    let variant = SphereVariant::from_word(word)
        .ok_or_else(|| PlanRefused(format!("unknown sphere '{word}'; the variants are meridians, esmaeili, spaan")))?;
    let spheres = match variant {
        SphereVariant::Meridians | SphereVariant::Esmaeili => {
            let tool_mm = wishes.tool_mm();
            vec![Sphere {
                label: "A".to_owned(),
                radius_mm: wishes.radius_mm.unwrap_or(150.0),
                centre_mm: wishes.centre_or_middle(machine, &tool_mm),
                tool_mm,
            }]
        }
        SphereVariant::Spaan => SPAAN
            .iter()
            .map(|&(number, radius_mm, [x, y, z], length_mm)| Sphere {
                label: number.to_string(),
                radius_mm,
                centre_mm: Vector::new(x, y, z),
                tool_mm: machine.spindle.axis * -length_mm,
            })
            .collect(),
    };
    let feed = wishes.feed.unwrap_or(200.0);
    let chord = wishes.chord.unwrap_or(0.1_f64.to_radians()).clamp(1e-4, 0.2);
    let is_partial = variant == SphereVariant::Spaan;
    let settings = SphereSettings {
        chord,
        every: wishes.every.unwrap_or(5_f64.to_radians()).max(chord),
        feed,
        pole: if is_partial { (1, 1.0) } else { along_spindle(machine) },
        legs: if variant == SphereVariant::Esmaeili { forth_and_back() } else { once() },
        is_partial,
    };
    let mut data = empty(kind("ballbar")?, &[Free::Centre, Free::Length]);
    for Sphere { label, radius_mm, centre_mm, .. } in &spheres {
        data.setups.push(Setup {
            label: label.clone(),
            centre_mm: *centre_mm,
            length_mm: *radius_mm,
            ..Setup::default()
        });
    }
    let mut plan = Builder::new(machine, wishes, data);
    plan.reach = PlanReach::Sphere { chord, feed };
    let mut left_out = 0;
    for (number, sphere) in spheres.iter().enumerate() {
        left_out += hemisphere(&mut plan, number, sphere, &settings)?;
    }
    if left_out > 0 {
        plan.notes.push(format!("{left_out} points of the spheres are outside the travel and omitted"));
    }
    if let [Sphere { radius_mm, tool_mm, .. }] = spheres.as_slice() {
        plan.candidates = candidates(&plan, 0, *radius_mm, tool_mm);
    }
    Ok(plan)
}

/// A point of the unit sphere: along a meridian from the equator over the pole to the equator.
fn on_meridian((which, sign): (usize, f64), [azimuth, along]: [f64; 2]) -> Vector {
    let mut point = Vector::zeros();
    point[(which + 1) % 3] = along.cos() * azimuth.cos();
    point[(which + 2) % 3] = along.cos() * azimuth.sin();
    point[which] = along.sin() * sign;
    point
}

/// A point of the path: its position, `true` if it is a row, and the leg.
struct Point {
    position: AxisVector,
    is_row: bool,
    leg: usize,
}

/// All points of a hemisphere, within the travel or not.
fn points(plan: &Builder, sphere: &Sphere, settings: &SphereSettings) -> Vec<Point> {
    let centre = plan.at_tip(&sphere.centre_mm, &sphere.tool_mm);
    let mut out = Vec::new();
    for (number, leg) in settings.legs.iter().enumerate() {
        let rows = (leg.angle() / settings.every).round().max(1.0) as usize;
        // Whole chords between rows, none longer than requested.
        let between = (leg.angle() / rows as f64 / settings.chord - 1e-9).ceil().max(1.0) as usize;
        let chords = rows * between;
        for chord in 0..=chords {
            let mut position = centre;
            let at = leg.at(chord as f64 / chords as f64);
            position.set_xyz(centre.xyz() + on_meridian(settings.pole, at) * sphere.radius_mm);
            let position = plan.on_increments(&position);
            out.push(Point { position, is_row: chord.is_multiple_of(between), leg: number });
        }
    }
    out
}

/// The hemisphere of one set-up. Returns the number of rows that are left out.
fn hemisphere(
    plan: &mut Builder,
    setup: usize,
    sphere: &Sphere,
    settings: &SphereSettings,
) -> Result<usize, PlanRefused> {
    let Sphere { label, centre_mm, tool_mm, .. } = sphere;
    let all = points(plan, sphere, settings);
    let is_out: Vec<bool> =
        all.iter().map(|point| settings.is_partial && plan.outside(&point.position).is_some()).collect();
    let centre = plan.at_tip(centre_mm, tool_mm).xyz();
    // Paths between parts pass over the middle of the reachable part.
    let inside = all.iter().zip(&is_out).filter(|(_, is_out)| !**is_out);
    let sum: Vector = inside.map(|(point, _)| point.position.xyz() - centre).sum();
    let mut middle = plan.at_tip(centre_mm, tool_mm);
    middle.set_xyz(centre + sum.try_normalize(0.0).unwrap_or_else(Vector::zeros) * sphere.radius_mm);
    let (mut left_out, mut leg, mut is_on, mut is_apart) = (0, usize::MAX, false, false);
    for (point, is_out) in all.iter().zip(is_out) {
        if is_out {
            left_out += usize::from(point.is_row);
            is_apart = true;
            continue;
        }
        if !is_on {
            plan.stop(&format!("set-up {label}: ball-bar removed: the axes move to their first position"));
            plan.approach(&point.position, settings.feed)?;
            plan.stop("mount the ball-bar");
            is_on = true;
        } else if is_apart {
            plan.on_sphere(centre_mm, tool_mm, &middle, WAY_CHORD, settings.feed)?;
            plan.on_sphere(centre_mm, tool_mm, &point.position, WAY_CHORD, settings.feed)?;
        } else if plan.last() != Some(point.position) {
            plan.go(&point.position, Some(settings.feed))?;
        }
        is_apart = false;
        let run = settings.legs.get(point.leg).map_or("", |leg| leg.run.as_str());
        if leg != point.leg {
            plan.comment(run);
            leg = point.leg;
        }
        if point.is_row {
            let extra = Extra { run: run.to_owned(), feed: Some(settings.feed), ..Extra::default() };
            plan.row(&point.position, *tool_mm, setup, extra)?;
        }
    }
    if !is_on {
        return Err(PlanRefused(format!(
            "no point of sphere {label} is within the travel; the machine is too small for it"
        )));
    }
    plan.stop("remove the ball-bar");
    plan.retract()?;
    Ok(left_out)
}

/// Further poses on the hemisphere, 15° apart, off the meridians.
pub(super) fn candidates(plan: &Builder, setup: usize, radius_mm: f64, tool_mm: &Vector) -> Vec<Observation> {
    let centre_mm = plan.data.setups.get(setup).map_or_else(Vector::zeros, |setup| setup.centre_mm);
    let centre = plan.at_tip(&centre_mm, tool_mm);
    let pole = along_spindle(&plan.machine);
    let mut out = Vec::new();
    for azimuth in 0..24 {
        for height in 0..6 {
            let [azimuth, height] = [azimuth, height].map(|step: u8| (f64::from(step) * 15.0).to_radians());
            let mut position = centre;
            position.set_xyz(centre.xyz() + on_meridian(pole, [azimuth, height]) * radius_mm);
            let position = plan.on_increments(&position);
            if plan.outside(&position).is_none() {
                out.push(observation(Reading { position, tool_mm: *tool_mm, state: State::default() }, setup));
            }
        }
    }
    out
}
