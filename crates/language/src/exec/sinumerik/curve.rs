//! Words of splines and polynomials.

use ncfix_base::geometry::Axis;
use ncfix_base::source::Span;
/// Coefficients a2 to a5.
pub(super) const COEFFICIENTS: usize = 4;

/// Curve words of a block.
#[derive(Debug, Default)]
pub(super) struct CurveWords {
    /// End conditions of splines; `true` for the end.
    pub(super) ends: Vec<(bool, End)>,
    pub(super) polynomials: Vec<(Axis, [f64; COEFFICIENTS])>,
    /// End value and coefficients of the denominator.
    pub(super) denominator: Option<(f64, [f64; COEFFICIENTS])>,
    pub(super) span: Span,
}

/// End condition of a spline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum End {
    /// BNAT, ENAT: without curvature.
    #[default]
    Natural,
    /// BTAN, ETAN: in the direction of the preceding or following motion.
    Tangent,
    /// BAUTO, EAUTO.
    Automatic,
}

impl End {
    /// The end condition of a code, with `true` for the end and `false` for the start.
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
