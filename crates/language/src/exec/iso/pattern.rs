//! Words of the drilling cycles of a Haas: pecks that become smaller, and patterns of holes.

/// I, J and K of G73 and G83, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PeckWords {
    /// I: the first peck.
    pub(super) first: Option<f64>,
    /// J: each peck is smaller by it.
    pub(super) less: Option<f64>,
    /// K: the least peck; with Q, the depth after which the tool clears the hole.
    pub(super) last: Option<f64>,
}

impl PeckWords {
    /// These words, or the modal ones if the block has none.
    pub(super) fn or(self, other: PeckWords) -> PeckWords {
        if self == PeckWords::default() { other } else { self }
    }
}

/// Holes about the current position, in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pattern {
    /// On a circle; angles in rad.
    Circle { radius_mm: f64, first: f64, step: f64, count: u32 },
    /// On a line that begins at the position.
    Line { step_mm: [f64; 2], count: u32 },
}

impl Pattern {
    /// The number of its holes.
    pub(super) fn count(&self) -> u32 {
        match self {
            Pattern::Circle { count, .. } | Pattern::Line { count, .. } => *count,
        }
    }

    /// A hole, from 0.
    pub(super) fn hole(&self, [x, y]: [f64; 2], place: u32) -> [f64; 2] {
        let place = f64::from(place);
        match self {
            Pattern::Circle { radius_mm, first, step, .. } => {
                let (sine, cosine) = (first + place * step).sin_cos();
                [x + radius_mm * cosine, y + radius_mm * sine]
            }
            Pattern::Line { step_mm: [dx, dy], .. } => [x + place * dx, y + place * dy],
        }
    }
}
