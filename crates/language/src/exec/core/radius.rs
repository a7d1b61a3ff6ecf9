//! Which radius G41 and G42 work with.

/// Which radius of the tool radius compensation works with, and so who has its wear: this program or the control.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Radius {
    /// That of the tool, wear included.
    #[default]
    Whole,
    /// That of the tool without its wear, and so much more, mm.
    Beside(f64),
    /// This alone, mm: the register of the control holds nothing of the tool.
    Alone(f64),
}

impl Radius {
    /// The radius in force for a tool of a radius that has so much wear in it, mm.
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
