//! The alignment of the reference of a straightness in a diagnosis.
//!
//! Optics and straightedges are aligned by hand. Their angle to the axis and the squareness of the axis have the same effect on the readings, and neither is
//! rarer than the other: nothing in the readings decides between them. So the slope is an unknown of the set-up, unless the description states a square.

use super::measurement::Measurement;
use crate::measure::data::{DataSet, Free};
use crate::measure::kind::direct::is_straightness;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::number::significant;
use ncfix_base::source::Span;
use ncfix_base::units::urad_from_rad;
use ncfix_model::ErrorName;

/// Frees the alignment of every straightness whose description does not state its reference, and names those among the first `used` measurements.
pub(super) fn release(all: &mut [Measurement], used: usize, findings: &mut Vec<Diagnostic>) {
    for (number, one) in all.iter_mut().enumerate() {
        let data = &mut one.data;
        if data.is_square_stated || data.free.contains(&Free::Slope) || !data.kind.free.contains(&Free::Slope) {
            continue;
        }
        let slopes = slopes(data);
        if slopes.is_empty() {
            continue;
        }
        // An alignment moves the zero too.
        for free in [Free::Offset, Free::Slope] {
            if !data.free.contains(&free) {
                data.free.push(free);
            }
        }
        if number < used {
            let place = Place { file: one.sources[1].id(), span: Span::default() };
            findings.push(not_used(&slopes, place));
        }
    }
}

/// Every straightness of a measurement with its largest slope in a set-up, rad.
fn slopes(data: &DataSet) -> Vec<(ErrorName, f64)> {
    let mut all: Vec<(ErrorName, f64)> = Vec::new();
    for row in &data.observations {
        let Some(component) = row.component.filter(|name| is_straightness(*name)) else { continue };
        if !all.iter().any(|(known, _)| *known == component) {
            all.push((component, 0.0));
        }
    }
    for (component, largest) in &mut all {
        for setup in 0..data.setups.len().max(1) {
            let slope = slope(data, *component, setup);
            if slope.abs() > largest.abs() {
                *largest = slope;
            }
        }
    }
    all
}

/// Slope of the least-squares line through the readings of a component in a set-up, rad; 0 if its axis did not move.
fn slope(data: &DataSet, component: ErrorName, setup: usize) -> f64 {
    let Some(axis) = component.axis() else { return 0.0 };
    let own = data.observations.iter().filter(|row| row.component == Some(component) && row.setup == setup);
    let points: Vec<[f64; 2]> = own.filter_map(|row| Some([row.reading.position[axis], row.values[0]?])).collect();
    let count = points.len().max(1) as f64;
    let [place, value] = [0, 1].map(|k: usize| points.iter().map(|point| point[k]).sum::<f64>() / count);
    let product: f64 = points.iter().map(|point| (point[0] - place) * (point[1] - value)).sum();
    let squares: f64 = points.iter().map(|point| (point[0] - place).powi(2)).sum();
    if squares > 0.0 { product / squares } else { 0.0 }
}

/// A warning that slopes are not used.
fn not_used(slopes: &[(ErrorName, f64)], place: Place) -> Diagnostic {
    let of =
        |(component, slope): &(ErrorName, f64)| format!("{component} ({} µrad)", significant(urad_from_rad(*slope)));
    let all: Vec<String> = slopes.iter().map(of).collect();
    let message = format!(
        "the slope of {} is not used: the alignment of the reference and a squareness explain it equally well, and the description does not state the reference",
        all.join(", ")
    );
    let help = "if the reference is a square, write reference = \"square\" in [measurement]; if it was aligned by hand, write free = [\"offset\", \"slope\"]";
    Diagnostic::at(Code::SLOPE_LEFT_OUT, place, message, help)
}
