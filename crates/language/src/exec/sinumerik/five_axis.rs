//! State of five-axis transformations, and of tools that point along a surface.

use ncfix_base::geometry::Vector;
use ncfix_base::source::Span;
use ncfix_machine::machine::OrientationAngles;
use ncfix_machine::snc::Turning;
/// What a block says of it.
#[derive(Debug, Default)]
pub(super) struct TransformWords {
    /// `TRAORI`, `TRAORI(2)`, `TRAFOOF`.
    pub(super) switch: Option<(&'static str, Span)>,
    /// `ORIWKS`, `ORIAXES` …
    pub(super) codes: Vec<&'static str>,
}

/// What is in force of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Transform {
    pub(super) is_on: bool,
    /// Orientations are meant in the machine's directions (ORIMKS).
    pub(super) in_machine: bool,
    /// ORIAXES, ORIVECT; `None` before the program says it.
    pub(super) turning: Option<Turning>,
    /// ORIRPY, ORIEULER; `None` before the program says it.
    pub(super) angles: Option<OrientationAngles>,
    /// LEAD, TILT, ORIPATH.
    pub(super) surface: Surface,
}

impl Transform {
    /// Takes over whether a transformation is in force, which SAVE does not bring back.
    pub(super) fn keep_switch_of(&mut self, left: &Transform) {
        self.is_on = left.is_on;
    }

    /// A code of the group of ORIAXES.
    pub(super) fn turn(&mut self, turning: Turning) {
        self.turning = Some(turning);
        self.surface.follows_path = false;
    }

    /// How the tool turns; `None` without a transformation. Where no code of the group of ORIAXES was programmed, ORIMKS moves the
    /// rotary axes in proportion and ORIWKS the tool along a great circle (Sinumerik MD21104).
    pub(super) fn turning(&self) -> Option<Turning> {
        let usual = if self.in_machine { Turning::Axes } else { Turning::Vector };
        self.is_on.then(|| self.turning.unwrap_or(usual))
    }
}

/// What is in force of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    /// ORIPATH: every motion ends in the direction that path and surface give.
    pub(super) follows_path: bool,
    /// At the end of the last block, coordinates of the program, of any length.
    pub(super) normal: Vector,
    /// LEAD and TILT, rad; `None` before the program says them.
    pub(super) angles: [Option<f64>; 2],
}

impl Default for Surface {
    fn default() -> Self {
        // Whatever plane is active.
        Surface { follows_path: false, normal: Vector::z(), angles: [None; 2] }
    }
}
