//! Steps of a cycle at a position, in any language. Families derive them from their words, and execute them with the motions of their channel.

/// A point of the plane: abscissa and ordinate, mm.
pub(in crate::exec) type Flat = [f64; 2];

/// A position in the plane and along the tool axis; program coordinates, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::exec) struct Place {
    pub(in crate::exec) plane: Flat,
    /// Along the tool axis.
    pub(in crate::exec) height: f64,
}

/// Purpose of a feed motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) enum Feed {
    /// Cutting: the active feed.
    Cut,
    /// Into the material or out of it: a separate feed, if given.
    Plunge,
}

/// Spindle command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::exec) enum Turn {
    /// M3
    Clockwise,
    /// M4
    CounterClockwise,
    /// M5
    Off,
    /// M19: oriented stop.
    Oriented,
    /// Opposite to the direction before the cycle.
    Reversed,
    /// As before the cycle.
    Again,
}

impl Turn {
    /// The opposite direction.
    pub(in crate::exec) fn reversed(self) -> Turn {
        match self {
            Turn::Clockwise => Turn::CounterClockwise,
            Turn::CounterClockwise => Turn::Clockwise,
            other => other,
        }
    }

    /// The number of the M code; `before` is that of the direction before the cycle.
    pub(in crate::exec) fn m_code(self, before: u16) -> u16 {
        match self {
            Turn::Clockwise => 3,
            Turn::CounterClockwise => 4,
            Turn::Off => 5,
            Turn::Oriented => 19,
            Turn::Reversed => 7 - before,
            Turn::Again => before,
        }
    }
}

/// A step of a cycle, in the coordinates of the plane and along the tool axis, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) enum Step {
    /// At rapid; `None` keeps a coordinate.
    Rapid { plane: Option<Flat>, height: Option<f64> },
    /// Straight with feed.
    Line { plane: Option<Flat>, height: Option<f64>, feed: Feed },
    /// On an arc of the plane with the cutting feed; a full circle if it ends at its start.
    Arc { end: Flat, center: Flat, clockwise: bool },
    /// Dwell, s.
    Dwell(f64),
    /// A spindle command.
    Spindle(Turn),
    /// Program stop M0, for the operator.
    Stop,
    /// Something outside the program has moved the tool to a position.
    Brought(Place),
}

impl Step {
    pub(in crate::exec) fn rapid(to: Place) -> Step {
        Step::Rapid { plane: Some(to.plane), height: Some(to.height) }
    }

    pub(in crate::exec) fn line(to: Place) -> Step {
        Step::Line { plane: Some(to.plane), height: Some(to.height), feed: Feed::Cut }
    }

    pub(in crate::exec) fn rapid_plane(point: Flat) -> Step {
        Step::Rapid { plane: Some(point), height: None }
    }

    pub(in crate::exec) fn rapid_height(height: f64) -> Step {
        Step::Rapid { plane: None, height: Some(height) }
    }

    pub(in crate::exec) fn to_height(height: f64, feed: Feed) -> Step {
        Step::Line { plane: None, height: Some(height), feed }
    }

    pub(in crate::exec) fn to(point: Flat) -> Step {
        Step::Line { plane: Some(point), height: None, feed: Feed::Cut }
    }
}
