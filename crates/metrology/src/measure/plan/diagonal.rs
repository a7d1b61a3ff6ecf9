//! Diagonals of the working volume with a laser interferometer, forward and backward (ISO 230-6): four body diagonals, two diagonals of each face.
//!
//! A diagonal is named by the senses of its axes, P for the positive and N for the negative: PPP NPP PNP PPN of X, Y and Z, and XY-PP, XY-NP of a face.
//! Targets are equally spaced. Each diagonal is a set-up of its own, because the laser is aligned anew.

use super::builder::{Builder, Extra};
use super::{PlanKind, PlanRefused, RowSpacing, Wishes, empty, kind};
use crate::measure::data::{Free, Setup};
use ncfix_base::geometry::{Axis, AxisVector, Plane, Vector};
use ncfix_machine::machine::Machine;

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "diagonal",
    title: "diagonals of the working volume, forward and backward (ISO 230-6); variant body, face or all",
    wishes: &["variant", "plane", "points", "runs", "feed", "dwell"],
    spacing: RowSpacing::Angle,
    has_setups: false,
    build,
};

/// Axes of the volume.
const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
/// Number of targets along a diagonal, the least number of ISO 230-6 for axes up to 2 m.
const POINTS: usize = 5;
/// Number of runs, as in ISO 230-2 and ISO 230-6.
const RUNS: usize = 5;
/// Overrun beyond the ends, as a share of the diagonal: every target is reached in one direction.
const OVERRUN: f64 = 0.005;

/// A diagonal: its name, and the share of the range of each axis at its start and its end.
struct Diagonal {
    name: String,
    ends: [[f64; 3]; 2],
}

/// Diagonals with these senses of the axes that move; the others stay in the middle.
fn diagonal(name: String, moving: &[(usize, bool)]) -> Diagonal {
    let mut ends = [[0.5; 3]; 2];
    for &(axis, is_positive) in moving {
        ends[0][axis] = f64::from(u8::from(!is_positive));
        ends[1][axis] = f64::from(u8::from(is_positive));
    }
    Diagonal { name, ends }
}

fn diagonals(wishes: &Wishes) -> Result<Vec<Diagonal>, PlanRefused> {
    let (body, face) = match wishes.variant.as_deref() {
        None if !wishes.planes.is_empty() => (false, true),
        None | Some("body") => (true, false),
        Some("face") => (false, true),
        Some("all") => (true, true),
        Some(other) => {
            return Err(PlanRefused(format!("unknown diagonals '{other}'; the variants are body, face, all")));
        }
    };
    if !wishes.planes.is_empty() && !face {
        return Err(PlanRefused("--plane chooses faces; give --variant face or all".into()));
    }
    let mut out = Vec::new();
    if body {
        for (name, senses) in [
            ("PPP", [true, true, true]),
            ("NPP", [false, true, true]),
            ("PNP", [true, false, true]),
            ("PPN", [true, true, false]),
        ] {
            out.push(diagonal(name.into(), &[(0, senses[0]), (1, senses[1]), (2, senses[2])]));
        }
    }
    let all = [Plane::XY, Plane::YZ, Plane::ZX];
    let planes = if wishes.planes.is_empty() { &all[..] } else { &wishes.planes };
    for plane in planes.iter().filter(|_| face) {
        let [first, second, _] = plane.axes();
        for (name, is_positive) in [("PP", true), ("NP", false)] {
            let moving = [(first.dimension(), is_positive), (second.dimension(), true)];
            out.push(diagonal(format!("{first}{second}-{name}"), &moving));
        }
    }
    Ok(out)
}

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, PlanRefused> {
    let tool_mm = wishes.tool_mm();
    let feed = wishes.feed.unwrap_or(1000.0);
    let dwell_s = wishes.dwell_s.unwrap_or(4.0);
    let count = wishes.points.unwrap_or(POINTS).clamp(2, 10_000);
    let runs = wishes.runs.unwrap_or(RUNS).clamp(1, 1000);
    let mut plan = Builder::new(machine, wishes, empty(kind("length")?, &[Free::Offset]));
    let mut ranges = [[0.0; 2]; 3];
    for (range, axis) in ranges.iter_mut().zip(AXES) {
        machine.axis(axis).ok_or_else(|| PlanRefused(format!("{} has no axis {axis}", machine.name)))?;
        *range = plan.travel(axis).filter(|[low, high]| high > low).ok_or_else(|| {
            PlanRefused(format!("{axis} has no limits of travel; give travel_mm in the machine file"))
        })?;
    }
    let at = |share: [f64; 3]| {
        let mut pose = AxisVector::ZERO;
        for ((axis, [low, high]), share) in AXES.into_iter().zip(ranges).zip(share) {
            pose[axis] = low + (high - low) * share;
        }
        pose
    };
    for (number, Diagonal { name, ends: [start, end] }) in diagonals(wishes)?.into_iter().enumerate() {
        let from: Vector = at(start).xyz();
        let to: Vector = at(end).xyz();
        let direction = (to - from).try_normalize(f64::EPSILON);
        plan.data.setups.push(Setup { label: name.clone(), direction, ..Setup::default() });
        // The overrun stays within the travel, so the targets are inside of it.
        let along = |target: f64| {
            let share = OVERRUN + (1.0 - 2.0 * OVERRUN) * target;
            at([0, 1, 2].map(|k| start[k] + (end[k] - start[k]) * share))
        };
        plan.stop(&format!("clear the path: the axes move to the start of the diagonal {name}"));
        plan.approach(&at(start), feed)?;
        plan.stop("align the laser along the diagonal and set it to zero");
        for run in 1..=runs {
            for is_back in [false, true] {
                let label = format!("{run}{}", if is_back { "-" } else { "+" });
                for place in 0..count {
                    let place = if is_back { count - 1 - place } else { place };
                    plan.go(&along(place as f64 / (count - 1) as f64), Some(feed))?;
                    let Some(here) = plan.last() else { continue };
                    plan.row(
                        &here,
                        tool_mm,
                        number,
                        Extra { run: label.clone(), feed: Some(feed), ..Extra::default() },
                    )?;
                    plan.dwell(dwell_s);
                }
                plan.go(&at(if is_back { start } else { end }), Some(feed))?;
            }
        }
    }
    plan.notes.push("straightness and angular errors also change the diagonals: use a squareness from them only if those errors are small, or in the machine file".into());
    plan.state_lowest(&tool_mm);
    Ok(plan)
}
