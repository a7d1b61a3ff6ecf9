//! Polynomials: `POLY` with `PO[X]=(end,a2,a3,…)`, `PO[]=(end,b2,…)` for a common denominator, and `PL=`.
//!
//! f(p) = a0 + a1 p + a2 p² + …, p from 0 to PL, a0 the start, a1 such that the end is met; an axis without polynomial moves in proportion to p. With
//! a denominator, geometry axes are quotients.

use super::address::Named;
use super::context::MotionContext;
use super::curve::COEFFICIENTS;
use super::curve::CurveWords;
use super::gathered::Gathered;
use super::gatherer::Gatherer;
use super::modal::{Modal, MotionKind};
use super::spline::curve_fault;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::path::Shape;
use crate::exec::core::position::BEGIN_ABSOLUTE;
use crate::syntax::sinumerik::{ExprId, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AXES, AXIS_COUNT, AxisVector, Bezier, Weighted};

/// Maximum number of chords of one block.
const MOST_CHORDS: usize = 100_000;

impl Gatherer<'_> {
    /// `PO[X]=(…)`, `PO[]=(…)`
    ///
    /// Production `polynomial`.
    pub(super) fn polynomial(&self, axes: &[Option<ExprId>], word: &Word, out: &mut Gathered) -> Result<(), Fault> {
        let values: Vec<f64> = match word.value {
            Value::Arguments(range) => {
                let arguments = self.scope.program.arguments_of(range);
                arguments.iter().map(|id| id.map_or(Ok(0.0), |id| self.scope.number(id))).collect::<Result<_, _>>()?
            }
            Value::Expr(id) => vec![self.scope.number(id)?],
            _ => return Err(self.unsupported(word)),
        };
        let (Some((&end, rest)), true) = (values.split_first(), values.len() <= COEFFICIENTS + 1) else {
            let help = "write the end, then the coefficients of the second to the fifth power";
            return Err(bad_value(word.span, "PO takes one to five values", help));
        };
        let mut coefficients = [0.0; COEFFICIENTS];
        coefficients.iter_mut().zip(rest).for_each(|(place, value)| *place = *value);
        out.curve.span = word.span;
        match axes {
            [] | [None] => {
                out.curve.denominator = Some((end, coefficients));
                Ok(())
            }
            [Some(axis)] => {
                let axis = self.scope.axis(*axis)?;
                self.axis(axis.letter(), &Word { value: Value::Number(end, false), ..*word }, out)?;
                out.curve.polynomials.push((axis, coefficients));
                Ok(())
            }
            _ => Err(self.unsupported(word)),
        }
    }
}

/// The shape of a block that is not an arc: a curve under POLY, otherwise a line.
pub(super) fn shape(
    gathered: &Gathered,
    modal: &Modal,
    context: MotionContext<'_>,
    start: &AxisVector,
    target: &AxisVector,
) -> Result<Shape, Fault> {
    let words = &gathered.curve;
    if modal.modes.motion != MotionKind::Polynomial || words.polynomials.is_empty() {
        return Ok(Shape::Line);
    }
    let length = match gathered.named(Named::Pl) {
        None => 1.0,
        Some(value) if value.value > 0.0 && value.value.is_finite() => value.value,
        Some(value) => return Err(bad_value(value.span, "PL must be above 0", "write the length of the parameter")),
    };
    let unknown = words.polynomials.iter().find(|(axis, _)| context.strict && !modal.position.known.contains(*axis));
    if let Some((axis, _)) = unknown {
        let message = format!("the position of {axis} is not known yet");
        let help = BEGIN_ABSOLUTE;
        return Err(fault(Code::UNKNOWN_START, words.span, message, help));
    }
    let powers = powers(
        words,
        modal.modes.scale(),
        [&context.setup.programmed(start), &context.setup.programmed(target)],
        length,
    )
    .ok_or_else(|| bad_value(words.span, "a denominator applies only to X, Y and Z", "remove the rotary polynomial"))?;
    let Some(curve) = Bezier::of_powers(&powers) else { return Ok(Shape::Line) };
    let mut ends = Vec::new();
    let mut budget = MOST_CHORDS;
    // Frames preserve lines and ratios, so points may be transformed one by one; scales enlarge.
    let growth = context.setup.frame.linear().norm().max(1.0);
    let tolerance_mm = context.control.chord_tolerance_mm / growth;
    curve
        .chords(tolerance_mm, &mut budget, &mut |end| ends.push(context.setup.command(&end)))
        .map_err(|found| curve_fault(found, words.span))?;
    ends.push(*target);
    Ok(Shape::Chords(ends))
}

/// Coefficients of numerators and denominator by a parameter from 0 to 1.
fn powers(
    words: &CurveWords,
    scale: f64,
    [start, end]: [&AxisVector; 2],
    length: f64,
) -> Option<[Weighted; COEFFICIENTS + 3]> {
    let mut out = [[0.0; AXIS_COUNT + 1]; COEFFICIENTS + 3];
    // p = length · t: the coefficient of t^k is that of p^k times length^k.
    let of = |start: f64, end: f64, coefficients: &[f64; COEFFICIENTS], unit: f64| {
        let mut powers = [0.0; COEFFICIENTS + 3];
        let mut factor = length;
        let mut rest = end - start;
        for (power, coefficient) in powers.iter_mut().skip(2).zip(coefficients) {
            factor *= length;
            *power = coefficient * unit * factor;
            rest -= *power;
        }
        powers[0] = start;
        powers[1] = rest;
        powers
    };
    let denominator = words.denominator.map(|(end, coefficients)| of(1.0, end, &coefficients, 1.0));
    let mut whole = [0.0; COEFFICIENTS + 3];
    whole[0] = 1.0;
    let whole = denominator.unwrap_or(whole);
    let end_weight: f64 = whole.iter().sum();
    for axis in AXES {
        let slot = axis.slot();
        let polynomial = words.polynomials.iter().find(|(known, _)| *known == axis);
        let powers = match polynomial {
            Some(_) if axis.is_rotary() && denominator.is_some() => return None,
            Some((_, coefficients)) => {
                let unit = if axis.is_rotary() { 1_f64.to_radians() } else { scale };
                of(start[axis], end[axis] * end_weight, coefficients, unit)
            }
            None => {
                // In proportion for any denominator: (start + way · t) · denominator.
                let mut powers = whole.map(|part| part * start[axis]);
                for (k, part) in whole.iter().enumerate().take(COEFFICIENTS + 2) {
                    powers[k + 1] += part * (end[axis] - start[axis]);
                }
                powers
            }
        };
        for (row, power) in out.iter_mut().zip(powers) {
            row[slot] = power;
        }
    }
    for (row, power) in out.iter_mut().zip(whole) {
        row[AXIS_COUNT] = power;
    }
    Some(out)
}
