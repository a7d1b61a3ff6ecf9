//! Errors of a piece of an emitted program against the part of the programmed move that it covers.
//!
//! The correction and a comparison with the original both evaluate pieces here, so that their figures agree. Means refer to stations along the programmed
//! path, which do not depend on its division into pieces. The maximum also includes the places at which bends, rounding and dead bands have their largest
//! effect.

use ncfix_base::geometry::{AxisSet, ROTARY_AXES, Vector};
use ncfix_machine::snc::Origin;
use ncfix_model::{DeadBand, Model, Off};

use super::lead::Lead;
use super::prediction::ErrorSide;
use super::route::Route;
use super::{ErrorPlace, Prediction};

/// Length below which a piece has no extent along its move, mm: half of the shortest emitted piece.
pub(super) const ON_THE_SPOT_MM: f64 = 0.005;
/// Weight of rotary axis deviations, mm per rad. It is small, as rotary corrections do not indicate another place, but table moves about the tip have
/// no other measure.
const ROTARY_ARM_MM: f64 = 10.0;
/// If the tip moves by at least this share of the weighted rotary motion, it alone determines the place.
const TIP_DECIDES: f64 = 0.1;
/// Weight of the rotation of the tool about itself, as a share of that of its direction. A correction does not determine this rotation. It decides only where
/// the direction stays too. The direction is then compared at a place that is wrong by at most half of this share of the rotation.
const ROLL_SHARE: f64 = 0.01;
/// Half the parameter step for a direction of the path.
const SENSE_STEP: f64 = 1e-4;
/// Iterations of the search for the nearest place on the programmed move, and the step that ends it, mm.
const NEAREST_STEPS: usize = 6;
const NEAREST_MM: f64 = 1e-9;
/// Maximum number of examined turning points of one arc.
const MOST_TURNINGS: usize = 64;

/// Offset of the tool from its nominal place.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Offset {
    /// Tip, in the workpiece frame, mm.
    pub(super) tip: Vector,
    /// Rotary axes, at [`ROTARY_ARM_MM`].
    turned: Vector,
}

impl Offset {
    pub(super) fn minus(&self, other: &Offset) -> Offset {
        Offset { tip: self.tip - other.tip, turned: self.turned - other.turned }
    }

    fn dot(&self, other: &Offset) -> f64 {
        self.tip.dot(&other.tip) + self.turned.dot(&other.turned)
    }

    pub(super) fn norm_mm(&self) -> f64 {
        self.dot(self).sqrt()
    }
}

/// A path of axis commands, with the bodies of the axes at its beginning.
#[derive(Clone, Copy, Debug)]
pub(super) struct LedPath<'a> {
    pub(super) route: &'a Route<'a>,
    pub(super) band: &'a DeadBand,
    /// Axes whose position was known at its beginning.
    pub(super) stated: AxisSet,
    /// From the spindle gauge point to the tip, in F at the zero pose, mm.
    pub(super) tool_mm: &'a Vector,
}

impl LedPath<'_> {
    /// Positions of the axes in their dead bands at a parameter.
    pub(super) fn band_at(&self, parameter: f64, lead: &Lead<'_>) -> DeadBand {
        let mut band = *self.band;
        lead.along(&mut band, self.route, self.stated, [0.0, parameter]);
        band
    }
}

/// A programmed move, and a piece of the emitted program that covers a part of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampledPiece<'a> {
    pub(super) lead: &'a Lead<'a>,
    /// The model of the head with all zero offsets, and the zero offset and head of the move.
    pub(super) base: &'a Model,
    pub(super) zero: Option<u16>,
    pub(super) head: u16,
    pub(super) programmed: LedPath<'a>,
    pub(super) emitted: LedPath<'a>,
    /// Origin of the move.
    pub(super) origin: Origin,
    pub(super) rapid: bool,
    /// Largest distance between the programmed curve and the move, mm.
    pub(super) off_curve_mm: f64,
    /// Error at the middle of the piece, if it is known already, mm.
    pub(super) middle_mm: Option<f64>,
}

/// Errors of a piece, mm.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PieceErrors {
    /// Largest error of the program at the stations of the part; `None` without stations.
    pub(super) before_mm: Option<f64>,
    /// Largest error of the piece.
    pub(super) after_mm: f64,
    /// Largest error of the piece after its start, with each unknown body on its best side.
    pub(super) nearest_mm: f64,
    /// Error at its start, as above.
    pub(super) start_mm: f64,
}

impl PieceErrors {
    /// Notes the largest and the smallest error at a place, mm.
    fn note(&mut self, [most_mm, nearest_mm]: [f64; 2]) {
        self.after_mm = self.after_mm.max(most_mm);
        self.nearest_mm = self.nearest_mm.max(nearest_mm);
    }
}

impl SampledPiece<'_> {
    /// Error of the program at a parameter of the move.
    pub(super) fn before(&self, parameter: f64) -> Off {
        let (nominal, band) = (self.programmed.route.at(parameter), self.programmed.band_at(parameter, self.lead));
        self.lead.error_mm(&band, (&nominal, &nominal), self.programmed.tool_mm, None)
    }

    /// Error at a share of the piece. On its path the tool may lag with a body; at the end it must have arrived.
    fn after(&self, share: f64, [from, to]: [f64; 2]) -> Off {
        let parameter = parameter_at(share, [from, to]);
        let places = (&self.programmed.route.at(parameter), &self.emitted.route.at(share));
        let band = self.emitted.band_at(share, self.lead);
        let way = (parameter < 1.0).then_some((self.programmed.route, parameter));
        self.lead.error_mm(&band, places, self.emitted.tool_mm, way)
    }

    /// Notes the error at a share of the piece, which may be the largest of the program.
    fn note(&self, share: f64, between: [f64; 2], prediction: &mut Prediction, out: &mut PieceErrors) -> Off {
        let off = self.after(share, between);
        out.note([off.most_mm, off.nearest.norm()]);
        let parameter = parameter_at(share, between);
        let place = || self.place(parameter, share, [&self.before(parameter), &off]);
        prediction.offer_largest(self.rapid, ErrorSide::After, &off, place);
        off
    }

    /// Offset of the tool from the place of the move at `parameter`, with the bodies `band` at the end of the piece.
    fn offset(&self, band: &DeadBand, parameter: f64) -> Offset {
        let command = self.emitted.route.end;
        let nominal = self.programmed.route.at(parameter);
        let tip = self.lead.error_mm(band, (&nominal, &command), self.emitted.tool_mm, None).nearest;
        let turned = ROTARY_AXES.map(|axis| ROTARY_ARM_MM * (command[axis] - nominal[axis]));
        Offset { tip, turned: Vector::from(turned) }
    }

    /// Offset of the tool at the end of the piece from the place of the move at `parameter`.
    pub(super) fn end_offset(&self, parameter: f64) -> Offset {
        self.offset(&self.emitted.band_at(1.0, self.lead), parameter)
    }

    /// Offset of the tip from the place of the move at `parameter`, with the bodies `band` at the end of the piece.
    fn tip_offset(&self, band: &DeadBand, parameter: f64) -> Vector {
        let nominal = self.programmed.route.at(parameter);
        self.lead.error_mm(band, (&nominal, &self.emitted.route.end), self.emitted.tool_mm, None).nearest
    }

    /// Rotation of the tool from its orientation in the move at `parameter`, at [`ROTARY_ARM_MM`]. The rotation about itself counts by [`ROLL_SHARE`].
    fn turned_offset(&self, band: &DeadBand, parameter: f64) -> Vector {
        let (model, tool_mm) = (self.lead.model, self.emitted.tool_mm);
        let ideal = model.nominal(&self.programmed.route.at(parameter), tool_mm);
        let turn = ideal.turn_to(&model.actual(&self.emitted.route.end, tool_mm, &band.state()));
        let tool_axis = model.kinematics().tool_axis();
        (turn - tool_axis * ((1.0 - ROLL_SHARE) * turn.dot(tool_axis))) * ROTARY_ARM_MM
    }

    /// Parameter of the move, not below `least`, at which its nominal tip is nearest to the end of the piece: Gauss–Newton from a guess. If the tip hardly
    /// moves, the direction of the tool counts too. Commands of rotary axes do not: their corrections do not indicate another place.
    pub(super) fn nearest(&self, guess: f64, least: f64) -> f64 {
        let band = self.emitted.band_at(1.0, self.lead);
        let route = self.programmed.route;
        let size_mm = route.size_mm();
        let mut parameter = guess;
        for step in 0..NEAREST_STEPS {
            let ends = [parameter - SENSE_STEP, parameter + SENSE_STEP].map(|value| value.clamp(0.0, 1.0));
            let [low, high] = ends;
            let tips = ends.map(|at| self.tip_offset(&band, at));
            let change = tips[1] - tips[0];
            let places = ends.map(|at| route.at(at));
            let turn = ROTARY_AXES.map(|axis| ROTARY_ARM_MM * (places[1][axis] - places[0][axis]));
            let (mut square, mut along) = (change.norm_squared(), change.dot(&self.tip_offset(&band, parameter)));
            if change.norm() <= TIP_DECIDES * Vector::from(turn).norm() {
                // The commands lead near the place, also over more than a turn; the direction then determines it.
                let turned = |at: f64| match step {
                    0 => self.offset(&band, at).turned,
                    _ => self.turned_offset(&band, at),
                };
                let change = turned(high) - turned(low);
                square += change.norm_squared();
                along += change.dot(&turned(parameter));
            }
            let before = parameter;
            if square > 0.0 {
                parameter -= (high - low) * along / square;
            }
            parameter = parameter.clamp(least, 1.0);
            if (parameter - before).abs() * size_mm < NEAREST_MM {
                break;
            }
        }
        parameter
    }

    /// Adds the errors of the piece, which covers the move between two parameters; `None` if it has no extent along its move and does not count.
    pub(super) fn sample(
        &self,
        between: [f64; 2],
        prediction: &mut Prediction,
        scratch: &mut Vec<f64>,
    ) -> Option<PieceErrors> {
        let [from, to] = between;
        let whole_mm = self.programmed.route.size_mm();
        if whole_mm * (to - from) < ON_THE_SPOT_MM && whole_mm > ON_THE_SPOT_MM {
            return None;
        }
        let mut out = PieceErrors::default();
        let chord_mm = self.off_curve_mm;
        self.note(1.0, between, prediction, &mut out);
        match self.middle_mm.filter(|&middle_mm| !prediction.is_largest_after(self.rapid, middle_mm)) {
            Some(middle_mm) => out.note([middle_mm; 2]),
            None => {
                self.note(0.5, between, prediction, &mut out);
            }
        }
        scratch.clear();
        self.lead.edges(self.emitted.band, self.emitted.route, scratch);
        // Rounding has its largest effect at the turning point of an axis on an arc.
        let mut place = 0.0;
        for _ in 0..MOST_TURNINGS {
            place = self.emitted.route.next_quadrant(AxisSet::XYZ, place);
            if place >= 1.0 {
                break;
            }
            scratch.push(place);
        }
        for &share in scratch.iter() {
            self.note(share, between, prediction, &mut out);
        }
        let (mut before_mm, mut has_largest): (Option<f64>, bool) = (None, false);
        for parameter in prediction.stations(self.rapid, whole_mm, between) {
            let share = (parameter - from) / (to - from);
            let (before, after) = (self.before(parameter), self.note(share, between, prediction, &mut out));
            before_mm = Some(before_mm.map_or(before.most_mm, |most_mm| most_mm.max(before.most_mm)));
            let form_mm = self.base.form_mm(self.zero, &before.nearest);
            let ranges_mm =
                [[before.nearest.norm(), before.most_mm], [after.nearest.norm() + chord_mm, after.most_mm + chord_mm]];
            prediction.add(self.rapid, ranges_mm, form_mm, &self.origin);
            let place = || self.place(parameter, share, [&before, &after]);
            prediction.offer(self.rapid, place);
            has_largest |= prediction.offer_largest(self.rapid, ErrorSide::Before, &before, place);
        }
        if has_largest {
            // The error is even larger at an end of the move, or where a body begins to follow after a reversal.
            scratch.clear();
            self.lead.edges(self.programmed.band, self.programmed.route, scratch);
            scratch.extend([0.0, 1.0]);
            for &parameter in scratch.iter().filter(|parameter| (from..=to).contains(*parameter)) {
                let share = (parameter - from) / (to - from);
                let before = self.before(parameter);
                let place = || self.place(parameter, share, [&before, &self.after(share, between)]);
                prediction.offer_largest(self.rapid, ErrorSide::Before, &before, place);
            }
        }
        if !self.lead.axes.is_empty() {
            let off = self.after(0.0, between);
            (out.after_mm, out.start_mm) = (out.after_mm.max(off.most_mm), off.nearest.norm());
        }
        out.after_mm += chord_mm;
        prediction.note_after(self.rapid, [out.nearest_mm + chord_mm, out.after_mm], &self.origin);
        out.before_mm = before_mm;
        Some(out)
    }

    fn place(&self, parameter: f64, share: f64, offs: [&Off; 2]) -> ErrorPlace {
        ErrorPlace {
            errors_mm: offs.map(|off| off.nearest),
            nominal: self.programmed.route.at(parameter),
            command: self.emitted.route.at(share),
            states: [
                self.programmed.band_at(parameter, self.lead).state(),
                self.emitted.band_at(share, self.lead).state(),
            ],
            tool_mm: *self.emitted.tool_mm,
            origin: self.origin,
            zero: self.zero,
            head: self.head,
            is_even: true,
        }
    }
}

/// The parameter of the move at a share of a piece; exact at its end.
fn parameter_at(share: f64, [from, to]: [f64; 2]) -> f64 {
    if share < 1.0 { from + (to - from) * share } else { to }
}
