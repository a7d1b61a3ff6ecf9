//! Selects the places at which a piece is checked, so that no deviation between its ends is missed.
//!
//! The error functions of an axis are smooth over a known length (`Features::length`); samples an eighth of it apart are safe. Kinks of tables are
//! sampled exactly.

use std::f64::consts::FRAC_PI_8;

use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisSet};
use ncfix_model::Model;

use super::increment::Increments;
use super::route::Route;

/// Samples per smooth length.
const SAMPLES_PER_LENGTH: f64 = 8.0;
/// Samples of a piece that contains a kink: the residual between them is a hundredth of a smooth bend next to the kink.
const BESIDE_KINKS: u32 = 9;
/// Samples of a piece whose end rounding uses much of the tolerance: the maximum deviation then may be anywhere. The residual between them is 4
/// (1/12)², 3 % of the bend.
const BESIDE_ROUNDING: u32 = 5;
/// Rounding above this share of the tolerance counts as much. Below it, the largest deviation outside the middle is at most 1.3 % of the tolerance
/// larger than in the middle.
const MUCH_ROUNDING: f64 = 0.2;
/// Turn of the tool between samples of a path of the tip, rad: a harmonic of four periods per turn has eight of them.
const SAMPLED_TURN_RAD: f64 = std::f64::consts::PI / 16.0;
/// Maximum samples of one piece, which bounds its check time. A helix of 999 turns, the most that can be programmed, needs a quarter of it.
const MOST_SAMPLES: f64 = 65_536.0;

/// Selects the sampling places.
#[derive(Clone, Debug)]
pub(super) struct Sampler {
    /// Samples per mm or rad of each axis.
    density: [f64; AXIS_COUNT],
    knots: Vec<(Axis, Vec<f64>)>,
    /// Axes whose errors depend on the direction of motion.
    pub(super) backlash: AxisSet,
    /// Minimum number of samples of a piece.
    least: u32,
}

impl Sampler {
    pub(super) fn new(model: &Model) -> Sampler {
        let of_axis = |axis| model.features(axis);
        Sampler {
            density: AXES.map(|axis| SAMPLES_PER_LENGTH / of_axis(axis).length),
            knots: AXES
                .map(|axis| (axis, of_axis(axis).knots.clone()))
                .into_iter()
                .filter(|(_, k)| !k.is_empty())
                .collect(),
            backlash: AXES.into_iter().filter(|&axis| of_axis(axis).backlash).collect(),
            least: 1,
        }
    }

    /// Adapts the sampler to pieces whose ends are rounded to increments and that may deviate by a tolerance, mm.
    pub(super) fn with_rounding(mut self, increments: &Increments, tolerance_mm: f64) -> Sampler {
        if increments.rounding_mm() > MUCH_ROUNDING * tolerance_mm {
            self.least = BESIDE_ROUNDING;
        }
        self
    }

    /// The number of samples of the whole route; pieces need their share.
    pub(super) fn whole(&self, route: &Route<'_>) -> f64 {
        route.travels().iter().zip(&self.density).map(|(travel, density)| travel * density).sum()
    }

    /// The largest share of a route that one check can cover.
    pub(super) fn longest_share(&self, whole: f64) -> f64 {
        if whole > MOST_SAMPLES { MOST_SAMPLES / whole } else { f64::INFINITY }
    }

    /// Fills `fractions` with places between the ends of the piece of `route` between two parameters, as fractions (0 … 1) of the piece. `whole` is
    /// the result of [`Sampler::whole`] for the route. Errors have their kinks at commands, so kinks are located on the route `emitted` that the axes
    /// take.
    pub(super) fn fractions(
        &self,
        (route, whole): (&Route<'_>, f64),
        between: [f64; 2],
        emitted: &Route<'_>,
        fractions: &mut Vec<f64>,
    ) {
        fractions.clear();
        let share = between[1] - between[0];
        let needed = whole * share;
        // Along a path of the tip the errors change with the turn of the tool too.
        let turned = (route.sweep_rad().abs() * share / FRAC_PI_8).max(route.turn_rad() * share / SAMPLED_TURN_RAD);
        // Odd, so that the middle, where a bend deviates most, is included. The conversion is exact: at most 65536.
        let count = (needed.max(turned).ceil().min(MOST_SAMPLES) as u32).max(self.least) | 1;
        fractions.extend((1..=count).map(|k| f64::from(k) / f64::from(count + 1)));
        let first = fractions.len();
        for (axis, knots) in &self.knots {
            let [a, b] = [emitted.start[*axis], emitted.end[*axis]];
            let reach = emitted.travel(*axis);
            let from = knots.partition_point(|&knot| knot < a.min(b) - reach);
            for &knot in knots[from..].iter().take_while(|&&knot| knot <= a.max(b) + reach) {
                emitted.crossings(*axis, knot, [0.0, 1.0], fractions);
            }
        }
        if fractions.len() > first && count < BESIDE_KINKS {
            // The maximum deviation of a bend with a kink may be anywhere, not only in the middle.
            fractions.extend((1..=BESIDE_KINKS).map(|k| f64::from(k) / f64::from(BESIDE_KINKS + 1)));
        }
    }
}
