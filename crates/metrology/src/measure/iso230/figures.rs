//! The figures of a measurement that its readings allow.
//!
//! Readings of single components give the figures of [`super::positioning`] for every component and set-up. Ball-bar rows in a plane through the
//! table ball are circles ([`super::circle`]), each with its direction. Rows of a set-up that do not lie in a plane are a sphere ([`super::sphere`]).

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use nalgebra::Matrix3;

use super::circle::{self, CirclePoint};
use super::positioning::{self, ApproachReading};
use super::{drift, sphere, straightness};
use crate::measure::data::{DataSet, Free, Observation};
use crate::measure::kind::Measurand;
use crate::measure::kind::direct::is_straightness;
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Machine};

/// Largest distance from a common plane, as a share of the radius.
const FLAT: f64 = 1e-3;
/// Tolerance of equal normals, as the sine of an angle.
const SAME_PLANE: f64 = 1e-2;
/// Step of a circle below which it has no direction, rad.
const LEAST_STEP: f64 = 1e-9;
/// Minimum arc for a meaningful center, rad.
const LEAST_ARC: f64 = PI;
/// Largest gap of a closed circle, rad.
const CLOSED: f64 = 0.1;
/// Number of runs required by ISO 230-2.
pub const RUNS: usize = 5;

/// Figures of one component, of circles in one plane, or of a sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredFigures {
    /// Label of the set-up.
    pub setup: String,
    /// Its subject: `EXX`, `EXX at Y50` if the set-up has several lines, `XY`, `sphere`.
    pub of: String,
    /// The figures, or the reason why they do not exist, as a sentence.
    pub figures: Result<Figures, String>,
}

/// Figures.
#[derive(Clone, Debug, PartialEq)]
pub enum Figures {
    /// Of a component.
    Positioning {
        /// ISO 230-2; mm, or rad.
        figures: positioning::PositioningFigures,
        /// `true` for an angle.
        is_angle: bool,
        /// `true` if a drift was removed before.
        without_drift: bool,
        /// Number of readings left out because the direction of their approach is unknown.
        left_out: usize,
    },
    /// Of a straightness.
    Straightness {
        /// Repeatability and reversal, mm.
        figures: positioning::PositioningFigures,
        /// Deviation from the least-squares line and from the line through the end points (ISO 230-1), mm.
        deviation: [f64; 2],
        /// `true` if a drift was removed before.
        without_drift: bool,
        /// Number of readings left out because the direction of their approach is unknown.
        left_out: usize,
    },
    /// Of circles.
    Circle {
        /// ISO 230-4, mm.
        figures: circle::CircleFigures,
        /// Nominal radius, mm.
        radius_mm: f64,
        /// Counterclockwise and clockwise paths, as seen against the normal.
        paths: [CirclePath; 2],
    },
    /// Of a sphere.
    Sphere {
        /// The fitted sphere; its center is the error of the set-up.
        sphere: sphere::Sphere,
        /// Nominal radius, mm.
        radius_mm: f64,
        /// Number of readings.
        points: usize,
    },
}

/// A path on a circle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CirclePath {
    /// Number of readings.
    pub points: usize,
    /// Its start, rad from the first axis of the plane.
    pub start: f64,
    /// Arc covered, rad: a full turn if closed.
    pub arc: f64,
    /// Feed, mm/min, from the table, otherwise from the times of its readings.
    pub feed: Option<f64>,
}

/// All figures of a measurement.
#[must_use]
pub fn figures(data: &DataSet, machine: &Machine) -> Vec<MeasuredFigures> {
    match data.kind.measurand {
        Measurand::Component => components(data),
        Measurand::BallDistance => circles_and_spheres(data, machine),
        _ => Vec::new(),
    }
}

/// The readings of a component in one set-up along one line.
struct LineGroup {
    setup: usize,
    target: usize,
    /// The place of the line, where the set-up has several; `None` for all readings.
    line: Option<MeasuredLine>,
}

/// Positions of the axes that stand still, and the measuring point, to a micrometer or a microradian.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct MeasuredLine {
    position: Vec<(Axis, i64)>,
    tool: [i64; 3],
}

impl MeasuredLine {
    /// Number of steps in a millimeter or a radian.
    const FINE: f64 = 1e3;

    fn of(row: &Observation) -> Option<MeasuredLine> {
        let moved = row.motion_axis()?;
        let fine = |value: f64| (value * MeasuredLine::FINE).round() as i64;
        let position = AXES.into_iter().filter(|axis| *axis != moved);
        let position = position.map(|axis| (axis, fine(row.reading.position[axis]))).collect();
        Some(MeasuredLine { position, tool: [0, 1, 2].map(|k| fine(row.reading.tool_mm[k])) })
    }

    /// The positions in which it differs from other lines: ` at Y50 Z200`.
    fn words(&self, others: &[&MeasuredLine]) -> String {
        let mut out = String::new();
        for (k, (axis, at)) in self.position.iter().enumerate() {
            if others.iter().any(|other| other.position.get(k) != Some(&(*axis, *at))) {
                let value = *at as f64 / MeasuredLine::FINE;
                let shown = if axis.is_rotary() { (1000.0 * value.to_degrees()).round() / 1000.0 } else { value };
                out.push_str(&format!(" {axis}{shown}"));
            }
        }
        if others.iter().any(|other| other.tool != self.tool) {
            let [x, y, z] = self.tool.map(|own| own as f64 / MeasuredLine::FINE);
            out.push_str(&format!(" tool {x},{y},{z}"));
        }
        if out.is_empty() { out } else { format!(" at{out}") }
    }
}

/// Components by set-up and line. Lines with a single target do not count as lines: the other axes moved too, and all readings count as one line.
fn line_groups(data: &DataSet) -> Vec<LineGroup> {
    let mut groups: BTreeMap<(usize, usize), BTreeMap<MeasuredLine, Vec<f64>>> = BTreeMap::new();
    for row in &data.observations {
        let (Some(axis), Some(target), Some(line)) = (row.motion_axis(), row.target, MeasuredLine::of(row)) else {
            continue;
        };
        groups.entry((row.setup, target)).or_default().entry(line).or_default().push(row.reading.position[axis]);
    }
    let mut out = Vec::new();
    for ((setup, target), lines) in groups {
        let is_line = |targets: &Vec<f64>| targets.iter().any(|at| (at - targets[0]).abs() * MeasuredLine::FINE > 1.0);
        if lines.len() > 1 && lines.values().all(is_line) {
            out.extend(lines.into_keys().map(|line| LineGroup { setup, target, line: Some(line) }));
        } else {
            out.push(LineGroup { setup, target, line: None });
        }
    }
    out
}

fn components(data: &DataSet) -> Vec<MeasuredFigures> {
    let groups = line_groups(data);
    let one = |group: &LineGroup| {
        let name = data.targets.get(group.target)?;
        let component = name.parse().ok()?;
        let is_in = |row: &Observation| {
            row.setup == group.setup
                && group.line.as_ref().is_none_or(|line| MeasuredLine::of(row).as_ref() == Some(line))
        };
        let figures = positioning::approaches_of(data, component, &is_in).and_then(|(readings, left_out)| {
            let readings: Vec<ApproachReading> =
                if data.free.contains(&Free::Drift) { drift::without_drift(&readings)? } else { readings };
            let figures = positioning::figures(&readings)?;
            let without_drift = data.free.contains(&Free::Drift);
            Ok(match straightness::of(&figures.targets).filter(|_| is_straightness(component)) {
                Some(deviation) => Figures::Straightness { figures, deviation, without_drift, left_out },
                None => Figures::Positioning {
                    figures,
                    is_angle: component.direction.is_rotation(),
                    without_drift,
                    left_out,
                },
            })
        });
        let figures =
            figures.map_err(|fault| component.axis().map_or_else(|| fault.to_string(), |axis| fault.words(axis)));
        let is_beside = |other: &&LineGroup| (other.setup, other.target) == (group.setup, group.target);
        let others: Vec<&MeasuredLine> =
            groups.iter().filter(is_beside).filter_map(|other| other.line.as_ref()).collect();
        let line = group.line.as_ref().map_or_else(String::new, |line| line.words(&others));
        Some(MeasuredFigures { setup: label(data, group.setup), of: format!("{name}{line}"), figures })
    };
    groups.iter().filter_map(one).collect()
}

fn label(data: &DataSet, setup: usize) -> String {
    data.setups.get(setup).map_or_else(String::new, |setup| setup.label.clone())
}

/// A row relative to the table ball.
struct Place {
    /// Its nominal position, mm.
    nominal: Vector,
    /// Measured distance, mm.
    distance: f64,
    run: usize,
    t_s: Option<f64>,
    feed: Option<f64>,
}

fn circles_and_spheres(data: &DataSet, machine: &Machine) -> Vec<MeasuredFigures> {
    let kinematics = Kinematics::new(machine);
    let mut setups: Vec<Vec<Place>> = Vec::new();
    setups.resize_with(data.setups.len(), Vec::new);
    for row in &data.observations {
        if let (Some(own), Some(place)) = (setups.get_mut(row.setup), place(data, &kinematics, row)) {
            own.push(place);
        }
    }
    let mut out = Vec::new();
    for (number, places) in setups.iter().enumerate().filter(|(_, places)| !places.is_empty()) {
        let mut runs: BTreeMap<usize, Vec<&Place>> = BTreeMap::new();
        places.iter().for_each(|place| runs.entry(place.run).or_default().push(place));
        let mut planes: Vec<(Vector, Vec<&Place>)> = Vec::new();
        for run in runs.into_values() {
            let Some(normal) = plane(&run) else { continue };
            match planes.iter_mut().find(|(known, _)| known.cross(&normal).norm() < SAME_PLANE) {
                Some((_, own)) => own.extend(run),
                None => planes.push((normal, run)),
            }
        }
        let is_flat = planes.iter().any(|(_, own)| own.len() == places.len());
        let setup = label(data, number);
        out.extend(planes.iter().map(|(normal, own)| {
            let (name, axes) = directions(normal);
            MeasuredFigures { setup: setup.clone(), of: name, figures: circle_of(own, axes) }
        }));
        if !is_flat {
            out.push(MeasuredFigures { setup, of: "sphere".into(), figures: sphere_of(places) });
        }
    }
    out
}

fn place(data: &DataSet, kinematics: &Kinematics, row: &Observation) -> Option<Place> {
    let setup = data.setups.get(row.setup)?;
    let mut centre = AxisVector::ZERO;
    centre.set_xyz(setup.centre_mm);
    // The ball is at the tip position of a zero-length tool, in the workpiece.
    let ball = kinematics.tip_mm(&centre, &Vector::zeros());
    let reading = &row.reading;
    let nominal = kinematics.tip_mm(&reading.position, &reading.tool_mm) - ball;
    let distance = setup.length_mm * data.stretch(row) + row.values[0]?;
    (nominal.norm() > 0.0).then_some(Place { nominal, distance, run: row.run, t_s: row.t_s, feed: row.feed })
}

/// The normal of the plane through the ball that contains all places, if there is one.
fn plane(places: &[&Place]) -> Option<Vector> {
    let mut scatter = Matrix3::zeros();
    for place in places {
        let along = place.nominal.normalize();
        scatter += along * along.transpose() / places.len() as f64;
    }
    let system = scatter.symmetric_eigen();
    let least = system.eigenvalues.imin();
    let mut sizes: Vec<f64> = system.eigenvalues.iter().copied().collect();
    sizes.sort_by(f64::total_cmp);
    // A line does not determine a plane.
    let is_plane = sizes.first()?.max(0.0).sqrt() < FLAT && sizes.get(1)?.max(0.0).sqrt() > 10.0 * FLAT;
    let normal: Vector = system.eigenvectors.column(least).into_owned();
    is_plane.then(|| if normal[normal.iamax()] < 0.0 { -normal } else { normal })
}

/// The name of a plane, and its directions: as seen against its normal the second is a quarter turn counterclockwise from the first.
fn directions(normal: &Vector) -> (String, [Vector; 2]) {
    let which = normal.iamax();
    let first = Vector::ith((which + 1) % 3, 1.0);
    let first = (first - normal * normal.dot(&first)).normalize();
    let name = ["YZ", "ZX", "XY"].get(which).copied().unwrap_or("XY");
    let is_main = normal[which] > 1.0 - SAME_PLANE * SAME_PLANE;
    let [x, y, z] = [normal.x, normal.y, normal.z];
    let name = if is_main { name.to_owned() } else { format!("plane across ({x:.3}, {y:.3}, {z:.3})") };
    (name, [first, normal.cross(&first)])
}

fn circle_of(places: &[&Place], axes: [Vector; 2]) -> Result<Figures, String> {
    let radius_mm = places.iter().map(|place| place.nominal.norm()).sum::<f64>() / places.len().max(1) as f64;
    let angle = |place: &Place| place.nominal.dot(&axes[1]).atan2(place.nominal.dot(&axes[0]));
    let mut sides: [Vec<(CirclePoint, &Place)>; 2] = [Vec::new(), Vec::new()];
    for run in places.chunk_by(|one, other| one.run == other.run) {
        let step = |k: usize| -> Option<f64> {
            let (from, to) = (run.get(k.checked_sub(1)?)?, run.get(k)?);
            let step = (angle(to) - angle(from) + PI).rem_euclid(TAU) - PI;
            (step.abs() > LEAST_STEP).then_some(step)
        };
        let mut last = (0..run.len()).find_map(step).unwrap_or(0.0);
        for (k, &place) in run.iter().enumerate() {
            last = step(k).unwrap_or(last);
            let point = CirclePoint { angle: angle(place), deviation_mm: place.distance - radius_mm };
            let [counter, clock] = &mut sides;
            if last >= 0.0 { counter } else { clock }.push((point, place));
        }
    }
    let paths = sides.each_ref().map(|side| path(side));
    for path in paths.iter().filter(|path| path.points > 0) {
        if path.arc < LEAST_ARC {
            let degrees = path.arc.to_degrees();
            return Err(format!("a path covers {degrees:.0}° of the circle; figures need at least half a circle"));
        }
    }
    let [counter, clock] = sides.map(|side| side.into_iter().map(|(point, _)| point).collect::<Vec<_>>());
    let figures = circle::figures(radius_mm, &counter, &clock).ok_or("the readings do not form a circle")?;
    Ok(Figures::Circle { figures, radius_mm, paths })
}

fn path(points: &[(CirclePoint, &Place)]) -> CirclePath {
    let Some((first, _)) = points.first() else { return CirclePath::default() };
    let mut angles: Vec<f64> = points.iter().map(|(point, _)| point.angle.rem_euclid(TAU)).collect();
    angles.sort_by(f64::total_cmp);
    let around = angles.first().zip(angles.last()).map_or(TAU, |(first, last)| first + TAU - last);
    let gap = angles.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max);
    let arc = if gap <= CLOSED.max(1.5 * TAU / points.len() as f64) { TAU } else { TAU - gap };
    let given = points.iter().find_map(|(_, place)| place.feed);
    CirclePath {
        points: points.len(),
        start: first.angle.rem_euclid(TAU),
        arc,
        feed: given.or_else(|| timed_feed(points)),
    }
}

/// The feed from the times of readings, mm/min: distance divided by time.
fn timed_feed(points: &[(CirclePoint, &Place)]) -> Option<f64> {
    let steps = points.windows(2).filter(|pair| pair[0].1.run == pair[1].1.run).filter_map(|pair| {
        let time = pair[1].1.t_s? - pair[0].1.t_s?;
        (time > 0.0).then(|| ((pair[1].1.nominal - pair[0].1.nominal).norm(), time))
    });
    let (way, time) = steps.fold((0.0, 0.0), |(way, time), (step, took)| (way + step, time + took));
    (time > 0.0 && way > 0.0).then(|| way / time * 60.0)
}

fn sphere_of(places: &[Place]) -> Result<Figures, String> {
    let radius_mm = places.iter().map(|place| place.nominal.norm()).sum::<f64>() / places.len().max(1) as f64;
    let points: Vec<Vector> = places.iter().map(|place| place.nominal.normalize() * place.distance).collect();
    let sphere = sphere::fit(&points).ok_or("the readings do not form a sphere")?;
    Ok(Figures::Sphere { sphere, radius_mm, points: points.len() })
}
