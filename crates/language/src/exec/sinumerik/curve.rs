//! Words of splines and polynomials.

use ncfix_base::geometry::Axis;
use ncfix_base::source::Span;
/// Coefficients a2 to a5.
pub(super) const COEFFICIENTS: usize = 4;

/// What a block says of curves.
#[derive(Debug, Default)]
pub(super) struct CurveWords {
    /// How splines begin or end from here on.
    pub(super) ends: Vec<(bool, End)>,
    pub(super) polynomials: Vec<(Axis, [f64; COEFFICIENTS])>,
    /// End value and coefficients of the denominator.
    pub(super) denominator: Option<(f64, [f64; COEFFICIENTS])>,
    pub(super) span: Span,
}

/// How a spline begins or ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum End {
    /// BNAT, ENAT: without curvature.
    #[default]
    Natural,
    /// BTAN, ETAN: in the direction of the motion before or behind it.
    Tangent,
    /// BAUTO, EAUTO.
    Automatic,
}

impl End {
    /// Whether a code is about the end rather than the start, and what it says.
    pub(super) fn of(code: &str) -> Option<(bool, End)> {
        let end = match code.get(1..)? {
            "NAT" => End::Natural,
            "TAN" => End::Tangent,
            "AUTO" => End::Automatic,
            _ => return None,
        };
        Some((code.starts_with('E'), end))
    }
}
