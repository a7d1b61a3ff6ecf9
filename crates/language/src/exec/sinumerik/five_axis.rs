//! State of five-axis transformations, and of tool directions relative to a surface.

use ncfix_base::geometry::Vector;
use ncfix_base::source::Span;
use ncfix_machine::machine::OrientationAngles;
use ncfix_machine::snc::Turning;
/// The G group of TOROT, TOFRAME and TOROTOF.
pub(super) const TOOL_FRAME: u8 = 53;

/// Transformation words of a block.
#[derive(Debug, Default)]
pub(super) struct TransformWords {
    /// `TRAORI`, `TRAORI(2)`, `TRAFOOF`.
    pub(super) switch: Option<(&'static str, Span)>,
    /// `TOROT`, `TOFRAME`, `TOROTOF`.
    pub(super) tool_frame: Option<(&'static str, Span)>,
    /// `ORIWKS`, `ORIAXES` …
    pub(super) codes: Vec<&'static str>,
}

/// Active transformation state.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Transform {
    pub(super) is_on: bool,
    /// Orientations refer to machine directions (ORIMKS).
    pub(super) in_machine: bool,
    /// ORIAXES, ORIVECT; `None` before the program sets it.
    pub(super) turning: Option<Turning>,
    /// ORIRPY, ORIEULER; `None` before the program sets it.
    pub(super) angles: Option<OrientationAngles>,
    /// LEAD, TILT, ORIPATH.
    pub(super) surface: Surface,
}

impl Transform {
    /// Takes over the activation of the transformation, which SAVE does not restore.
    pub(super) fn keep_switch_of(&mut self, left: &Transform) {
        self.is_on = left.is_on;
    }

    /// Sets a code of the group of ORIAXES.
    pub(super) fn turn(&mut self, turning: Turning) {
        self.turning = Some(turning);
        self.surface.follows_path = false;
    }

    /// The interpolation of the tool direction; `None` without transformation. If no code of the group of ORIAXES was programmed, ORIMKS moves the
    /// rotary axes in proportion and ORIWKS the tool along a great circle (Sinumerik MD21104).
    pub(super) fn turning(&self) -> Option<Turning> {
        let usual = if self.in_machine { Turning::Axes } else { Turning::Vector };
        self.is_on.then(|| self.turning.unwrap_or(usual))
    }
}

/// Active state of the surface words.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    /// ORIPATH: every motion ends in the direction given by path and surface.
    pub(super) follows_path: bool,
    /// At the end of the last block, in program coordinates, of any length.
    pub(super) normal: Vector,
    /// LEAD and TILT, rad; `None` before the program sets them.
    pub(super) angles: [Option<f64>; 2],
}

impl Default for Surface {
    fn default() -> Self {
        // Independent of the active plane.
        Surface { follows_path: false, normal: Vector::z(), angles: [None; 2] }
    }
}
