//! Elementary moves of a cycle.

/// A point of the plane: abscissa and ordinate, mm.
pub(in crate::exec::grundig) type Flat = [f64; 2];

/// What a feed motion is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec::grundig) enum Feed {
    /// Cutting: the feed in force.
    Cut,
    /// Into the material or out of it: F2=, else the feed in force.
    Plunge,
}

/// A step of a cycle, in the coordinates of the plane and along the tool axis, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec::grundig) enum Step {
    /// At rapid; what is `None` stays.
    Rapid { plane: Option<Flat>, height: Option<f64> },
    /// Straight with feed.
    Line { plane: Option<Flat>, height: Option<f64>, feed: Feed },
    /// On an arc of the plane with the cutting feed; where it begins is its end, it is a full circle.
    Arc { end: Flat, center: Flat, clockwise: bool },
    /// Seconds.
    Dwell(f64),
    /// The spindle turns the other way round.
    Reverse,
    /// The spindle stops, at its position where that is programmed.
    Stop,
    /// The spindle turns again as before the cycle.
    Resume,
}

impl Step {
    pub(super) fn rapid_plane(point: Flat) -> Step {
        Step::Rapid { plane: Some(point), height: None }
    }

    pub(super) fn rapid_height(height: f64) -> Step {
        Step::Rapid { plane: None, height: Some(height) }
    }

    pub(super) fn to_height(height: f64, feed: Feed) -> Step {
        Step::Line { plane: None, height: Some(height), feed }
    }

    pub(super) fn to(point: Flat) -> Step {
        Step::Line { plane: Some(point), height: None, feed: Feed::Cut }
    }
}
