//! The radius for G41 and G42.

/// The part of the tool radius that compensation uses; the wear is then handled by this program or by the control.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Radius {
    /// The tool radius including wear.
    #[default]
    Whole,
    /// The tool radius without wear, plus an amount, mm.
    Beside(f64),
    /// This value alone, mm: the control's register contains nothing of the tool.
    Alone(f64),
}

impl Radius {
    /// The effective radius, mm, for a tool radius that includes a wear, mm.
    pub(in crate::exec) fn of(self, whole_mm: f64, wear_mm: f64) -> f64 {
        match self {
            Radius::Whole => whole_mm,
            Radius::Beside(more_mm) => whole_mm - wear_mm + more_mm,
            Radius::Alone(radius_mm) => radius_mm,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wear_is_in_the_path_or_at_the_control_and_never_in_both() {
        assert_eq!(Radius::Whole.of(5.02, 0.02), 5.02);
        assert!((Radius::Beside(0.0).of(5.02, 0.02) - 5.0).abs() < 1e-12);
        assert!((Radius::Beside(-0.05).of(5.02, 0.02) - 4.95).abs() < 1e-12);
        assert_eq!(Radius::Alone(0.05).of(5.02, 0.02), 0.05);
    }
}
