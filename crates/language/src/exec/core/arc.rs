//! Arcs of the working plane in any language: the center for a radius, and the transformation of an arc by a frame.

use super::path::Shape;
use super::sagitta::chord_count;
use ncfix_base::geometry::{Arc, AxisVector, CenterFault, Plane, PlaneBasis};
use ncfix_dialect::Language;
use ncfix_machine::machine::{ArcCenter, Control};
use ncfix_machine::snc::Setup;

/// Center of an arc whose radii differ within the tolerance, as each control is delivered.
const CENTERS: [(Language, ArcCenter); 4] = [
    (Language::Sinumerik, ArcCenter::Moved),
    (Language::Grundig, ArcCenter::Moved),
    (Language::Fanuc, ArcCenter::Kept),
    (Language::Rs274, ArcCenter::Kept),
];

/// A programmed arc: its plane, direction, start, end, center and extra turns.
#[derive(Clone, Copy, Debug)]
pub(in crate::exec) struct ProgrammedArc<'a> {
    pub(in crate::exec) plane: Plane,
    pub(in crate::exec) clockwise: bool,
    pub(in crate::exec) from: &'a AxisVector,
    pub(in crate::exec) to: &'a AxisVector,
    pub(in crate::exec) center_mm: [f64; 2],
    pub(in crate::exec) extra_turns: u32,
}

impl ProgrammedArc<'_> {
    /// The arc as the control checks and executes it; `tolerance` is the largest difference of its radii. Radius compensation is computed for a circle.
    ///
    /// # Errors
    /// A reason if the center fits neither start nor end.
    pub(in crate::exec) fn checked(
        &self,
        language: Language,
        control: &Control,
        is_compensated: bool,
        tolerance: impl Fn(f64) -> f64,
    ) -> Result<Arc, CenterFault> {
        let &ProgrammedArc { plane, clockwise, from, to, center_mm, extra_turns } = self;
        let delivered = CENTERS.iter().find(|(of, _)| *of == language).map(|(_, center)| *center);
        let keeps = control.arc_center.or(delivered) == Some(ArcCenter::Kept);
        if keeps && !(is_compensated && language != Language::Rs274) {
            return Arc::spiral(plane, clockwise, from, to, center_mm, extra_turns, tolerance);
        }
        Arc::through(plane, clockwise, from, to, center_mm, extra_turns, tolerance)
    }
}

/// Difference of the radii, mm, below which a point is the center itself.
const NO_RADIUS_MM: f64 = 1e-6;
/// Largest difference of the radii, mm and as a share, with which another reading of a center is likely. Posts write centers with three decimals.
const LIKELY_MM: f64 = 0.01;
const LIKELY_SHARE: f64 = 0.001;

/// `true` if a point has nearly the same distance from both ends of an arc: it is probably the center that was meant.
pub(in crate::exec) fn is_likely_center(start: [f64; 2], end: [f64; 2], center: [f64; 2]) -> bool {
    let radius = |point: [f64; 2]| (point[0] - center[0]).hypot(point[1] - center[1]);
    let (first, last) = (radius(start), radius(end));
    first > NO_RADIUS_MM && (first - last).abs() <= LIKELY_MM.max(LIKELY_SHARE * first)
}

/// Reason why there is no arc of a radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) enum RadiusFault {
    /// Start and end coincide, or the radius is 0.
    NoChord,
    /// Start and end are farther apart than twice the radius, mm.
    TooFar {
        /// Magnitude of the radius.
        radius_mm: f64,
        /// Half the distance.
        half_chord_mm: f64,
    },
}

impl RadiusFault {
    /// The message; `word` is the address of the radius.
    pub(in crate::exec) fn message(&self, word: &str) -> String {
        match self {
            RadiusFault::NoChord => format!("start and end of an arc with {word} coincide, or {word} is 0"),
            RadiusFault::TooFar { radius_mm, half_chord_mm } => {
                format!("the radius is {radius_mm:.4} mm, half the chord {half_chord_mm:.4} mm")
            }
        }
    }
}

/// Center of an arc of a signed radius between two points of the plane, mm: above 0 at most half a turn, below 0 more. `tolerance` is the largest
/// excess of half the chord over the radius.
///
/// # Errors
/// A reason if no arc has this radius.
pub(in crate::exec) fn center_of_radius(
    radius_mm: f64,
    start: [f64; 2],
    end: [f64; 2],
    clockwise: bool,
    tolerance: &impl Fn(f64) -> f64,
) -> Result<[f64; 2], RadiusFault> {
    let chord = [end[0] - start[0], end[1] - start[1]];
    let length = chord[0].hypot(chord[1]);
    if length == 0.0 || radius_mm == 0.0 {
        return Err(RadiusFault::NoChord);
    }
    let half = length / 2.0;
    if half - radius_mm.abs() > tolerance(radius_mm.abs()) {
        return Err(RadiusFault::TooFar { radius_mm: radius_mm.abs(), half_chord_mm: half });
    }
    let height = (radius_mm * radius_mm - half * half).max(0.0).sqrt();
    // The center of the short clockwise arc is to the right of the chord.
    let side = if clockwise == (radius_mm > 0.0) { 1.0 } else { -1.0 };
    let right = [chord[1] / length, -chord[0] / length];
    Ok([start[0].midpoint(end[0]) + side * height * right[0], start[1].midpoint(end[1]) + side * height * right[1]])
}

/// A programmed arc after the frame: an arc if circles stay circles, otherwise chords of the ellipse. `programmed` are its start and end as
/// programmed, or in base coordinates if the frame is a pure shift and the arc is defined there. `target` is its end in base coordinates.
pub(in crate::exec) fn behind_frame(
    arc: &Arc,
    programmed: [&AxisVector; 2],
    target: &AxisVector,
    setup: &Setup,
    chord_tolerance_mm: f64,
) -> Shape {
    let (clockwise, extra_turns) = (arc.clockwise, arc.extra_turns);
    let frame = &setup.frame;
    if frame.is_translation() {
        return Shape::Arc { clockwise, center: arc.center_mm, extra_turns };
    }
    let [abscissa, ordinate, _] = arc.plane.axes();
    if let Some(basis) = PlaneBasis::behind(frame, arc.plane).filter(|_| frame.keeps_circles(arc.plane)) {
        let mut center = *programmed[0];
        center[abscissa] = arc.center_mm[0];
        center[ordinate] = arc.center_mm[1];
        return Shape::Arc { clockwise, center: basis.flat(&setup.command(&center)), extra_turns };
    }
    // No direction is scaled by more than the norm of the matrix.
    let radius_mm = arc.radius_mm(programmed[0]) * frame.linear().norm();
    let sweep_rad = arc.sweep_rad(programmed[0], programmed[1]);
    let count = chord_count(radius_mm, sweep_rad, chord_tolerance_mm);
    let mut ends: Vec<AxisVector> = (1..count)
        .map(|k| arc.at(programmed[0], programmed[1], f64::from(k) / f64::from(count)))
        .map(|position| setup.command(&position))
        .collect();
    ends.push(*target);
    Shape::Chords(ends)
}
