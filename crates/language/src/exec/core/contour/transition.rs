//! RND, CHF and CHR: roundings and chamfers between two contour elements.

use std::f64::consts::PI;

use super::contour_request::Transition;
use super::curve::{Curve, Flat, SAME_MM, add, angle_between, cross, distance, left, scaled, unit};
use super::moving::{Item, Moving, blocks_between, own_of, same_plane};
use super::unknown;
use crate::exec::core::fault::Fault;
use ncfix_base::diagnostic::Code;
use ncfix_machine::snc::{Kind, Origin};

/// Maximum number of blocks without motion between two elements with a transition (Sinumerik MD20200).
const BLOCKS_BETWEEN: usize = 3;
/// Maximum number of waiting items of any kind.
const MOST_WAITING: usize = 1000;
/// Angle below which elements continue without a corner, rad.
const NO_CORNER: f64 = 1e-6;
/// Number of steps of the search for the setback of a chamfer between arcs.
const STEPS: usize = 200;

/// The element that waits for the one after a transition.
#[derive(Debug, Default)]
pub(super) struct Transitions {
    held: Option<Box<Moving>>,
    behind: Vec<Item>,
    /// The stop of the control after the held element: its origin, and the variable it reads.
    stop: Option<(Origin, &'static str)>,
}

/// Two elements with a transition between them; lengths along the elements.
struct Fit {
    /// End of the first element.
    first_end: f64,
    between: Curve,
    /// Start of the second element.
    second_start: f64,
}

impl Transitions {
    pub(super) fn is_holding(&self) -> bool {
        self.held.is_some()
    }

    /// Records a read access to the main run.
    pub(super) fn stop(&mut self, origin: Origin, name: &'static str) {
        if self.held.is_some() && self.stop.is_none() {
            self.stop = Some((origin, name));
        }
    }

    /// Takes an item and emits final ones.
    pub(super) fn take(&mut self, item: Item, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
        match item {
            Item::Element(_) if self.held.is_none() => out.push(item),
            Item::Element(_) => {
                self.behind.push(item);
                if self.behind.len() > MOST_WAITING {
                    self.finish(out, findings);
                }
            }
            Item::Path(moving) => {
                let moving = match self.held.take() {
                    Some(first) => self.meet(first, moving, out, findings),
                    None => moving,
                };
                if moving.wish.corner.is_some() && moving.is_plane_motion() {
                    self.held = Some(moving);
                } else {
                    out.push(Item::Path(moving));
                }
            }
        }
    }

    /// Emits what is held, without a transition.
    pub(super) fn finish(&mut self, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
        if let Some(first) = self.held.take() {
            let stop = self.stop.take();
            match unknown::across(&first, &self.behind).or_else(|| unknown::across_stop(&first, stop)) {
                Some(found) => findings.push(found),
                None => self.without(&first, findings),
            }
            out.push(Item::Path(first));
        }
        out.append(&mut self.behind);
    }

    fn without(&self, first: &Moving, findings: &mut Vec<Fault>) {
        if first.wish.corner.is_some_and(|corner| !corner.is_modal) {
            findings.push(first.fault(
                Code::CORNER_LEFT_OUT,
                "no rounding or chamfer here: no motion in the plane follows soon enough",
                "remove RND, CHF or CHR, or program the next contour element directly after it",
            ));
        }
    }

    /// Joins both known elements: emits the first and the transition, returns the second.
    fn meet(
        &mut self,
        first: Box<Moving>,
        mut second: Box<Moving>,
        out: &mut Vec<Item>,
        findings: &mut Vec<Fault>,
    ) -> Box<Moving> {
        let own = own_of(&mut self.behind, &second.element);
        let stop = self.stop.take();
        let across = unknown::across(&first, &self.behind)
            .or_else(|| unknown::across_stop(&first, stop))
            .or_else(|| unknown::between(&first, &second));
        let is_clear = across.is_none();
        findings.extend(across);
        let is_near = blocks_between(&first.element, &self.behind) <= BLOCKS_BETWEEN;
        let basis = first.path.basis;
        let curves = first.curve(&basis).zip(second.curve(&basis));
        let corner = first
            .wish
            .corner
            .filter(|_| is_clear && is_near && second.is_plane_motion() && same_plane(&basis, &second.path.basis));
        let fitted = match (corner, curves) {
            (Some(corner), Some((a, b))) => match fit(corner.transition, &a, &b) {
                Ok(fitted) => fitted.map(|fitted| (fitted, corner, a, b)),
                Err(message) => {
                    findings.push(first.fault(
                        Code::CORNER_DOES_NOT_FIT,
                        message,
                        "make it smaller, or the adjacent contour elements longer",
                    ));
                    None
                }
            },
            _ => {
                if is_clear {
                    self.without(&first, findings);
                }
                None
            }
        };
        let Some((fitted, corner, a, b)) = fitted else {
            out.push(Item::Path(first));
            out.append(&mut self.behind);
            out.extend(own);
            return second;
        };
        let share = fitted.first_end / a.length();
        let first_target = first.path.start.lerp(&first.path.motion.target, share);
        let share = fitted.second_start / b.length();
        let second_start = second.path.start.lerp(&second.path.motion.target, share);
        let mut shortened = first.ending(&a.part(0.0, fitted.first_end), basis, first.path.start, first_target);
        let mut between = first.further();
        between.path.motion.rapid = first.path.motion.rapid && second.path.motion.rapid;
        if first.path.motion.rapid && !second.path.motion.rapid {
            between.path.motion.feed = second.path.motion.feed;
        }
        let mut between = between.ending(&fitted.between, basis, shortened.path.motion.target, second_start);
        if corner.feed > 0.0 && !between.path.motion.rapid {
            between.path.motion.feed = corner.feed;
        }
        let start = between.path.motion.target;
        let target = second.path.motion.target;
        *second = second.ending(&b.part(fitted.second_start, b.length()), basis, start, target);
        second.path.motion.target = target;
        shortened.wish.corner = None;
        between.wish.corner = None;
        out.push(Item::Path(Box::new(shortened)));
        // Modes of later blocks, such as exact stops, begin after it: it belongs to the first element, as its feed does.
        let are_modes =
            self.behind.iter().any(is_mode) && self.behind.iter().all(|item| is_mode(item) || !item.counts());
        if !are_modes {
            // After separate words it has its own line: their effect comes before it.
            between.element.starts_block = self.behind.iter().any(Item::counts);
            out.append(&mut self.behind);
        }
        out.push(Item::Path(Box::new(between)));
        if are_modes {
            out.append(&mut self.behind);
        }
        out.extend(own);
        second
    }
}

/// `true` for a word that changes the state of later blocks and moves, stops and switches nothing.
fn is_mode(item: &Item) -> bool {
    matches!(item, Item::Element(element) if matches!(element.kind, Kind::Keep(_)))
}

/// Fits a transition; `Ok(None)` if the elements meet without a corner.
fn fit(transition: Transition, a: &Curve, b: &Curve) -> Result<Option<Fit>, String> {
    let (d, e) = (a.last_tangent(), b.first_tangent());
    let bend = angle_between(d, e);
    if bend < NO_CORNER {
        return Ok(None);
    }
    match transition {
        Transition::Round(radius) => rounding(radius, a, b).map(Some),
        Transition::ChamferSetback(setback) => chamfer(setback, a, b).map(Some),
        Transition::ChamferLength(length) => {
            // Between lines the setback follows from the triangle; arcs need a search, as their chord depends on it.
            let straight = length / 2.0 / ((PI - bend) / 2.0).sin();
            let lines = matches!((a, b), (Curve::Line { .. }, Curve::Line { .. }));
            let setback = if lines { straight } else { setback_of(length, a, b) };
            chamfer(setback, a, b).map(Some)
        }
    }
}

fn chamfer(setback: f64, a: &Curve, b: &Curve) -> Result<Fit, String> {
    let room = a.length().min(b.length());
    if !setback.is_finite() || setback > room + SAME_MM {
        return Err(format!(
            "a chamfer that begins {setback:.4} mm before the corner does not fit: the shorter element has {room:.4} mm"
        ));
    }
    let first_end = (a.length() - setback).max(0.0);
    let second_start = setback.min(b.length());
    Ok(Fit { first_end, between: Curve::Line { start: a.at(first_end), end: b.at(second_start) }, second_start })
}

/// The setback along both elements for a chamfer length.
fn setback_of(length: f64, a: &Curve, b: &Curve) -> f64 {
    let chord = |setback: f64| distance(a.at(a.length() - setback), b.at(setback));
    let (mut low, mut high) = (0.0, a.length().min(b.length()));
    if chord(high) < length {
        return f64::INFINITY;
    }
    for _ in 0..STEPS {
        let middle = f64::midpoint(low, high);
        if chord(middle) < length { low = middle } else { high = middle }
    }
    high
}

fn rounding(radius: f64, a: &Curve, b: &Curve) -> Result<Fit, String> {
    let (d, e) = (a.last_tangent(), b.first_tangent());
    // The center is on the side to which the contour bends.
    let side = if cross(d, e) >= 0.0 { 1.0 } else { -1.0 };
    let does_not_fit = || format!("a rounding of radius {radius:.4} mm does not fit between these elements");
    let (Some(beside_a), Some(beside_b)) = (a.offset(side * radius), b.offset(side * radius)) else {
        return Err(does_not_fit());
    };
    let corner = a.end();
    let ratio = |curve: &Curve, offset: &Curve| match (curve, offset) {
        (Curve::Arc { radius, .. }, Curve::Arc { radius: beside, .. }) => radius / beside,
        _ => 1.0,
    };
    let mut best: Option<(f64, f64, Flat)> = None;
    for center in beside_a.crossings(&beside_b).iter() {
        let first_end = beside_a.along(center, beside_a.length()) * ratio(a, &beside_a);
        let second_start = beside_b.along(center, 0.0) * ratio(b, &beside_b);
        let fits = (-SAME_MM..=a.length() + SAME_MM).contains(&first_end)
            && (-SAME_MM..=b.length() + SAME_MM).contains(&second_start);
        if fits && best.is_none_or(|(_, _, other)| distance(center, corner) < distance(other, corner)) {
            best = Some((first_end.clamp(0.0, a.length()), second_start.clamp(0.0, b.length()), center));
        }
    }
    let (first_end, second_start, center) = best.ok_or_else(does_not_fit)?;
    let towards = |curve: &Curve, along: f64| add(center, scaled(unit(left(curve.tangent(along))), -side * radius));
    let between = Curve::arc(towards(a, first_end), towards(b, second_start), center, side < 0.0, 0);
    Ok(Fit { first_end, between, second_start })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rounding_touches_both_elements() {
        // A line along the abscissa into a circle of radius 10 about (10, 10), reached at (4, 2) from outside.
        let line = Curve::Line { start: [-20.0, 2.0], end: [4.0, 2.0] };
        let arc = Curve::arc([4.0, 2.0], [0.0, 10.0], [10.0, 10.0], true, 0);
        let fit = rounding(1.0, &line, &arc).unwrap();
        let Curve::Arc { center, radius, sweep, .. } = fit.between else { panic!() };
        assert!((radius - 1.0).abs() < 1e-12 && (center[1] - 3.0).abs() < 1e-12 && sweep > 0.0);
        assert!((distance(center, [10.0, 10.0]) - 11.0).abs() < 1e-9);
        assert!(distance(line.at(fit.first_end), fit.between.start()) < 1e-9);
        assert!(distance(arc.at(fit.second_start), fit.between.end()) < 1e-9);
    }

    #[test]
    fn the_length_of_a_chamfer_between_arcs_is_that_of_its_chord() {
        let a = Curve::arc([0.0, 0.0], [10.0, 10.0], [10.0, 0.0], true, 0);
        let b = Curve::Line { start: [10.0, 10.0], end: [10.0, 30.0] };
        let fit = fit(Transition::ChamferLength(3.0), &a, &b).unwrap().unwrap();
        assert!((fit.between.length() - 3.0).abs() < 1e-9);
        assert!((a.length() - fit.first_end - fit.second_start).abs() < 1e-9);
    }
}
