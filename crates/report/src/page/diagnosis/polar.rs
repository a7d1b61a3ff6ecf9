//! Ball-bar circles before and after, and the effect of a single cause, magnified.

use std::collections::BTreeMap;

use super::{figure, side_by_side};
use crate::compared::Circle;
use crate::diagnosis::{CauseText as _, PageReadings};
use crate::markup::Markup;
use crate::number::significant;
use crate::plot::{Polar, PolarTrace};
use ncfix_metrology::results::diagnosis::CauseReport;
use ncfix_metrology::results::readings::Set;

/// Maximum number of circles of a measurement before and after, and for one cause.
const MOST_CIRCLES: usize = 6;
const MOST_ALONE: usize = 3;
/// Share of its largest effect below which the effect of a cause is not visible.
const SEEN: f64 = 0.05;

/// Circles of a set-up in a plane: the first one in each direction.
type Plane<'a> = ((usize, &'a str), Vec<&'a Circle>);

/// Draws the circles of all ball-bar measurements that were used.
pub(super) fn section(out: &mut Markup, shown: &PageReadings) {
    for set in shown.readings.sets.iter().filter(|set| !set.is_held_out && !set.circles.is_empty()) {
        out.leaf("h2", &[], format_args!("{}: circles before and after", set.name));
        let planes = planes(set);
        let before: Vec<f64> = set.readings.iter().map(|one| one.before).collect();
        let after: Vec<f64> = set.readings.iter().map(|one| one.after).collect();
        side_by_side(out, |out| {
            for plane in most(set, &planes, &before, MOST_CIRCLES) {
                let picture = picture(set, plane, "Ball-bar", &[("before", &before), ("after", &after)]);
                figure(out, &picture, "Unknown center and length are removed.");
            }
        });
        let more = planes.len().saturating_sub(MOST_CIRCLES);
        if more > 0 {
            let text = format_args!("{more} more circles are not drawn: those with the largest residual come first.");
            out.leaf("p", &[("class", &"soft")], text);
        }
    }
}

/// Draws the effect of a single cause on circles, magnified: one circle of every plane, where the effect is largest.
pub(super) fn alone(out: &mut Markup, set: &Set, number: usize, one: &CauseReport) {
    let Some(does) = set.doing.get(number) else { return };
    let planes = planes(set);
    let mut known: Vec<&str> = Vec::new();
    let mut largest = 0.0;
    for plane in most(set, &planes, does, planes.len()) {
        let name = plane.0.1;
        let swing = swing(set, plane, does);
        if known.len() >= MOST_ALONE || known.contains(&name) || swing <= SEEN * largest {
            continue;
        }
        largest = f64::max(largest, swing);
        known.push(name);
        let picture = picture(set, plane, &format!("{} alone", one.name()), &[("alone", does)]);
        figure(out, &picture, format_args!("Circularity of this cause alone: {} {}.", significant(swing), set.unit));
    }
}

fn planes(set: &Set) -> Vec<Plane<'_>> {
    let mut all: BTreeMap<(usize, &str), Vec<&Circle>> = BTreeMap::new();
    for circle in &set.circles {
        let own = all.entry((circle.setup, &circle.plane)).or_default();
        if own.iter().all(|other| other.is_counterclockwise != circle.is_counterclockwise) {
            own.push(circle);
        }
    }
    all.into_iter().collect()
}

/// Returns the planes in which values vary most.
fn most<'p, 'a>(set: &Set, planes: &'p [Plane<'a>], values: &[f64], most: usize) -> Vec<&'p Plane<'a>> {
    let mut order: Vec<(f64, &Plane<'a>)> = planes.iter().map(|plane| (swing(set, plane, values), plane)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    order.into_iter().take(most).map(|(_, plane)| plane).collect()
}

/// Returns the largest value minus the smallest on the circles of a plane.
fn swing(set: &Set, plane: &Plane<'_>, values: &[f64]) -> f64 {
    let counts = |number: usize| set.readings.get(number).is_some_and(|reading| reading.counts);
    let own = plane.1.iter().flat_map(|circle| &circle.angles).filter(|(number, _)| counts(*number));
    let ends = own
        .filter_map(|(number, _)| values.get(*number))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |ends, value| [ends[0].min(*value), ends[1].max(*value)]);
    if ends[1] > ends[0] { ends[1] - ends[0] } else { 0.0 }
}

fn picture(set: &Set, plane: &Plane<'_>, what: &str, all: &[(&str, &[f64])]) -> Polar {
    let ((setup, name), circles) = plane;
    let label = set.setups.get(*setup).map_or("", String::as_str);
    let of = |circle: &Circle, values: &[f64]| -> Vec<(f64, f64)> {
        let own = circle.angles.iter().filter(|(number, _)| set.readings.get(*number).is_some_and(|one| one.counts));
        own.filter_map(|&(number, angle)| Some((angle, *values.get(number)?))).collect()
    };
    let sense = |circle: &Circle| if circle.is_counterclockwise { "ccw" } else { "cw" };
    let traces = circles.iter().flat_map(|circle| {
        all.iter()
            .map(|(name, values)| PolarTrace { label: format!("{name} {}", sense(circle)), points: of(circle, values) })
    });
    Polar {
        title: format!("{what}, {name}{}{label}", if label.is_empty() { "" } else { ", set-up " }),
        axes: circles.first().map_or_else(Default::default, |circle| circle.axes.clone()),
        unit: set.unit.to_string(),
        radius_mm: circles.first().map_or(0.0, |circle| circle.radius_mm),
        traces: traces.collect(),
    }
}
