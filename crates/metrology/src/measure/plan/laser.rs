//! One axis from end to end and back, repeatedly (ISO 230-2): laser interferometer, level, autocollimator.
//!
//! Targets are pᵢ = (i − 1) p + r with random r within ±30 % of p, so that equal steps do not hide an error with the pitch of a screw; r is identical
//! in all runs. The axis overruns the ends before it reverses, so that every target is reached in one direction.

use super::builder::{Builder, Extra};
use super::random::Random;
use super::{PlanKind, PlanRefused, RowSpacing, Wishes, empty, kind};
use crate::measure::data::{Free, Setup, number_of};
use crate::measure::kind::direct::is_straightness;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{Branch, Machine};
use ncfix_model::ErrorName;
use ncfix_model::name::{Carrier, ErrorKind};

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "laser",
    title: "one axis in steps, forward and backward (ISO 230-2); variant equal: equal steps, signs: with a sign test",
    wishes: &["axis", "component", "range", "points", "runs", "center", "feed", "dwell", "variant", "seed"],
    spacing: RowSpacing::Angle,
    has_setups: false,
    build,
};

/// Range of r, as a share of a step.
const SCATTER: f64 = 0.3;
/// Known move in a test of signs, mm: far above the errors of a machine, within the range of instruments.
const MOVE_MM: f64 = 0.1;
/// Known turn in a test of signs, rad: 20 increments of 0.001°, within the range of autocollimators and levels.
const TURN_RAD: f64 = 0.02 * std::f64::consts::PI / 180.0;
/// Largest share of a turn about another direction.
const OBLIQUE: f64 = 0.01;

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, PlanRefused> {
    let axis = wishes.axis.unwrap_or(Axis::X);
    let data = machine.axis(axis).ok_or_else(|| PlanRefused(format!("{} has no axis {axis}", machine.name)))?;
    let (is_equal, has_signs) = match wishes.variant.as_deref() {
        None | Some("iso") => (false, false),
        Some("equal") => (true, false),
        Some("signs") => (false, true),
        Some(other) => {
            return Err(PlanRefused(format!("unknown steps '{other}'; the variants are iso, equal, signs")));
        }
    };
    let components = if wishes.components.is_empty() {
        let own = format!("E{axis}{axis}").parse::<ErrorName>();
        vec![own.map_err(|_| PlanRefused(format!("there is no positioning error of {axis}")))?]
    } else {
        wishes.components.clone()
    };
    for component in &components {
        if component.kind != ErrorKind::Motion || component.carrier != Carrier::Axis(axis) {
            let message =
                format!("{component} is not a motion error of {axis}; give for example E{axis}{axis} or EY{axis}");
            return Err(PlanRefused(message));
        }
    }
    let [low, high] = wishes
        .range
        .or_else(|| {
            let margin = if axis.is_rotary() { 0.0 } else { wishes.margin_mm() };
            data.travel.map(|[low, high]| [low + margin, high - margin])
        })
        .ok_or_else(|| PlanRefused(format!("{axis} has no limits of travel; give --range FROM,TO")))?;
    let count = wishes.points.unwrap_or(11).clamp(2, 10_000);
    let runs = wishes.runs.unwrap_or(5).clamp(1, 1000);
    let length = high - low;
    // Overrun at both ends.
    let turn = (length * 0.005).min(if axis.is_rotary() { 1_f64.to_radians() } else { 2.0 });
    let step = (length - 2.0 * turn) / (count - 1) as f64;
    if !(length > 0.0 && step > 0.0) {
        return Err(PlanRefused("the range is empty; give --range FROM,TO with TO beyond FROM".into()));
    }
    let mut random = Random(wishes.seed);
    let targets: Vec<f64> = (0..count)
        .map(|number| {
            let off = if is_equal { 0.0 } else { random.between(-SCATTER, SCATTER) * step };
            // The ends stay within the range.
            (low + turn + step * number as f64 + off).clamp(low + turn, high - turn)
        })
        .collect();
    let tool_mm = wishes.tool_mm();
    let feed = wishes.feed.unwrap_or(1000.0);
    let dwell_s = wishes.dwell_s.unwrap_or(4.0);
    // The reference of a straightness is never exactly along the axis.
    let is_aligned = !components.iter().copied().any(is_straightness);
    let free: &[Free] = if is_aligned { &[Free::Offset] } else { &[Free::Offset, Free::Slope] };
    let mut set = empty(kind("direct")?, free);
    set.setups.push(Setup { label: "A".into(), ..Setup::default() });
    let numbers: Vec<usize> =
        components.iter().map(|component| number_of(&mut set.targets, &component.to_string())).collect();
    let mut plan = Builder::new(machine, wishes, set);
    let centre_mm = wishes.centre_or_middle(machine, &tool_mm);
    let mut pose = plan.at_tip(&centre_mm, &tool_mm);
    plan.stop("clear the path: the axes move to their first position");
    pose[axis] = low;
    plan.approach(&pose, feed)?;
    plan.stop("set the instrument to zero");
    if has_signs {
        pose[axis] = targets.first().copied().unwrap_or(low);
        test_signs(&mut plan, &pose, &components, &numbers, (tool_mm, feed, dwell_s))?;
        pose[axis] = low;
        plan.go(&pose, Some(feed))?;
    }
    for run in 1..=runs {
        for is_back in [false, true] {
            let label = format!("{run}{}", if is_back { "-" } else { "+" });
            for number in 0..count {
                let number = if is_back { count - 1 - number } else { number };
                pose[axis] = targets.get(number).copied().unwrap_or(low);
                plan.go(&pose, Some(feed))?;
                let Some(here) = plan.last() else { continue };
                for (component, target) in components.iter().zip(&numbers) {
                    let extra = Extra { run: label.clone(), feed: Some(feed), ..Extra::default() };
                    plan.row(&here, tool_mm, 0, extra)?;
                    plan.of_last(Some(*target), Some(*component));
                }
                plan.dwell(dwell_s);
            }
            pose[axis] = if is_back { low } else { high };
            plan.go(&pose, Some(feed))?;
        }
    }
    plan.state_lowest(&tool_mm);
    Ok(plan)
}

/// Readings at a pose and beside it, by a known move along each component, or a known turn about it.
fn test_signs(
    plan: &mut Builder,
    pose: &AxisVector,
    components: &[ErrorName],
    targets: &[usize],
    (tool_mm, feed, dwell_s): (Vector, f64, f64),
) -> Result<(), PlanRefused> {
    let pose = &plan.on_increments(pose);
    for (component, target) in components.iter().zip(targets) {
        let is_angle = component.direction.is_rotation();
        let found =
            if is_angle { beside_by_turn(plan, pose, *component) } else { beside(plan, pose, *component, &tool_mm) };
        let Some((beside, by)) = found else {
            plan.notes.push(if is_angle {
                format!(
                    "no axis turns about {component} alone: turn the instrument by hand, and add rows with moved_urad 0 and the turn"
                )
            } else {
                format!("no axis moves along {component} alone: its sign is not tested")
            });
            continue;
        };
        // Readings are deviations of the body that the axis moves: on the workpiece side relative to the tool.
        let on_table = component.axis().and_then(|axis| plan.machine.topology.branch(axis)) == Some(Branch::Workpiece);
        let by = by * if on_table { -1.0 } else { 1.0 };
        for (at, by) in [(pose, 0.0), (&beside, by)] {
            plan.go(at, Some(feed))?;
            let mut extra = Extra { run: "signs".to_owned(), feed: Some(feed), ..Extra::default() };
            let (own, micro) = if is_angle {
                (&mut extra.moved_urad, urad_from_rad(by))
            } else {
                (&mut extra.moved_um, um_from_mm(by))
            };
            *own = Some(micro);
            plan.row(pose, tool_mm, 0, extra)?;
            plan.of_last(Some(*target), Some(*component));
            plan.dwell(dwell_s);
        }
        plan.go(pose, Some(feed))?;
    }
    Ok(())
}

/// A position beside a pose along a component, and the move of the tool along it, mm.
fn beside(plan: &Builder, pose: &AxisVector, component: ErrorName, tool_mm: &Vector) -> Option<(AxisVector, f64)> {
    let moved = [Axis::X, Axis::Y, Axis::Z].get(component.direction.index()).copied();
    let moved = moved.filter(|axis| plan.machine.axis(*axis).is_some())?;
    let mut beside = *pose;
    beside[moved] += MOVE_MM;
    let [from, to] = [pose, &beside].map(|at| plan.kinematics.tip_mm(at, tool_mm)[component.direction.index()]);
    Some((beside, to - from))
}

/// A position beside a pose by a turn about a component alone, and the turn of the tool relative to the workpiece, rad. Other rotary axes are at zero.
fn beside_by_turn(plan: &Builder, pose: &AxisVector, component: ErrorName) -> Option<(AxisVector, f64)> {
    let rotary: Vec<Axis> = plan.kinematics.rotary_axes().collect();
    rotary.iter().find_map(|&axis| {
        if rotary.iter().any(|&other| other != axis && pose[other] != 0.0) {
            return None;
        }
        // Towards the middle of the travel, so that no limit is in the way.
        let middle = plan.machine.axis(axis)?.travel.map_or(0.0, |[low, high]| f64::midpoint(low, high));
        let mut beside = *pose;
        beside[axis] += if pose[axis] > middle { -TURN_RAD } else { TURN_RAD };
        let beside = plan.on_increments(&beside);
        let [from, to] = [pose, &beside].map(|at| plan.kinematics.rotation(at));
        let turn = to * from.transpose();
        // The vector of a small rotation.
        let vector =
            Vector::new(turn[(2, 1)] - turn[(1, 2)], turn[(0, 2)] - turn[(2, 0)], turn[(1, 0)] - turn[(0, 1)]) / 2.0;
        let along = vector[component.direction.index() % 3];
        let across = (vector.norm_squared() - along * along).max(0.0).sqrt();
        (along != 0.0 && across < OBLIQUE * along.abs()).then_some((beside, along))
    })
}
