//! Contour requests of the program: modal codes, and the request of one motion to the stage.

use ncfix_base::geometry::Plane;
use ncfix_base::geometry::{Frame, PlaneBasis};
use ncfix_base::source::{FileId, Span};

/// G40, G41, G42.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum Side {
    #[default]
    Off,
    Left,
    Right,
}

/// Start and end of compensation: NORM, KONT and related modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum Approach {
    /// Straight to the perpendicular position.
    #[default]
    Norm,
    /// Around the first corner if the start is behind the contour.
    Kont,
    /// Perpendicular to its own end, then around the first corner if that is an outer one.
    Own,
    /// KONTT, KONTC.
    Polynomial,
}

/// The contours on which F applies if the tool moves beside them: CFC, CFTCP, CFIN, and setting 44 of a Haas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum FeedAt {
    /// The contour.
    #[default]
    Contour,
    /// The tool center.
    Center,
    /// The contour of inner arcs, down to this share of F, percent; the tool center elsewhere.
    InnerContour(u8),
}

/// Side of soft approach and retraction: G140 to G143.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum SoftSide {
    /// That of the compensation.
    #[default]
    Compensation,
    Left,
    Right,
    /// The side of the start relative to the tangent.
    Nearest,
}

/// Modal state of contours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::exec) struct ContourModal {
    pub(in crate::exec) side: Side,
    pub(in crate::exec) approach: Approach,
    /// `true` for G451, `false` for G450: straight around outer corners.
    pub(in crate::exec) sharp: bool,
    /// CDON: intersections of motions that are not neighbors count too.
    pub(in crate::exec) collision: bool,
    pub(in crate::exec) feed_at: FeedAt,
    /// RNDM, mm, 0 for none.
    pub(in crate::exec) round_mm: f64,
    /// FRCM, 0 for none.
    pub(in crate::exec) corner_feed: f64,
    /// OFFN, mm.
    pub(in crate::exec) allowance_mm: f64,
    /// TOFFR, mm.
    pub(in crate::exec) radius_change_mm: f64,
    pub(in crate::exec) soft_side: SoftSide,
    /// `true` for G341, `false` for G340.
    pub(in crate::exec) soft_in_plane: bool,
    /// The rules of radius compensation.
    pub(in crate::exec) rules: Rules,
    /// CUT2DF: the plane of the compensation is that of the frame.
    pub(in crate::exec) follows_frame: bool,
    /// G43, G44 of Grundig.
    pub(in crate::exec) reach: Reach,
    /// Number of activations of compensation so far.
    pub(in crate::exec) activation: u32,
    /// The number of the radius register next to G41 and G42: D.
    pub(in crate::exec) register: Option<u32>,
    /// The plane as the output shows it.
    pub(in crate::exec) shown: Shown,
    /// G40 I J: the direction in the plane in which the contour virtually continues after its end.
    pub(in crate::exec) leaves_along: Option<[f64; 2]>,
}

impl ContourModal {
    /// `true` if radius compensation is active.
    pub(in crate::exec) fn compensates(&self) -> bool {
        self.side != Side::Off
    }

    /// `true` if motions are unaffected.
    pub(in crate::exec) fn is_plain(&self) -> bool {
        !self.compensates() && self.round_mm == 0.0 && self.reach == Reach::End
    }
}

/// The transition between two contour elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) enum Transition {
    /// RND: an arc of this radius, mm.
    Round(f64),
    /// CHF: a chamfer of this length, mm.
    ChamferLength(f64),
    /// CHR: a chamfer that begins and ends at this distance from the corner, mm.
    ChamferSetback(f64),
}

/// A transition after a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) struct Corner {
    pub(in crate::exec) transition: Transition,
    /// Its feed, 0 for that of the block.
    pub(in crate::exec) feed: f64,
    /// RNDM: may be omitted.
    pub(in crate::exec) is_modal: bool,
}

/// The form of a soft approach or retraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::exec) enum SoftForm {
    Line,
    Quadrant,
    Semicircle,
}

/// End of the fast part of a soft approach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) enum Clearance {
    /// At this distance from the plane of the contour, mm.
    Above(f64),
    /// At this height, mm: as programmed, then above the plane of the basis.
    At(f64),
}

/// A soft approach or retraction: G147, G247, G347 and G148, G248, G348.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) struct Soft {
    pub(in crate::exec) form: SoftForm,
    pub(in crate::exec) retracts: bool,
    pub(in crate::exec) side: SoftSide,
    pub(in crate::exec) in_plane: bool,
    /// DISR, mm.
    pub(in crate::exec) size_mm: f64,
    /// DISCL.
    pub(in crate::exec) clearance: Clearance,
    /// FAD, 0 for none.
    pub(in crate::exec) infeed: f64,
    /// Feed and rapid mode of the previous block.
    pub(in crate::exec) feed_before: f64,
    pub(in crate::exec) rapid_before: bool,
}

/// The reason why the path of the tool center is not known under radius compensation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::exec) enum CompensationDoubt {
    /// The tool turns under a five-axis transformation.
    ToolTurns,
    /// A frame tilts the plane, but not by CYCLE800 and without CUT2DF.
    TiltedPlane,
}

/// The contour request of one motion.
#[derive(Clone, Copy, Debug)]
pub(in crate::exec) struct ContourRequest {
    pub(in crate::exec) modal: ContourModal,
    /// Distance of the tool center to the left of the contour, mm; 0 without compensation.
    pub(in crate::exec) distance_mm: f64,
    pub(in crate::exec) corner: Option<Corner>,
    pub(in crate::exec) soft: Option<Soft>,
    /// The reason why the path of the tool center is not known under radius compensation.
    pub(in crate::exec) doubt: Option<CompensationDoubt>,
    pub(in crate::exec) span: Span,
    pub(in crate::exec) file: FileId,
}

impl ContourRequest {
    /// `true` if the tool is beside the programmed contour or end, by its radius.
    pub(in crate::exec) fn is_beside(&self) -> bool {
        self.compensates() || self.modal.reach != Reach::End
    }

    pub(in crate::exec) fn compensates(&self) -> bool {
        self.modal.side != Side::Off
    }
}

/// The rules of radius compensation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum Rules {
    #[default]
    Sinumerik,
    /// Cutter compensation C. With [`ContourModal::sharp`], lines around outer corners.
    Fanuc,
    /// RS274/NGC as in LinuxCNC: the first motion ends beside its own end, none leads off.
    Rs274,
    /// With [`ContourModal::sharp`], outer corners to the intersection.
    Grundig,
}

/// End of a straight motion without side compensation: G43, G44 of Grundig.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum Reach {
    /// At its end.
    #[default]
    End,
    /// G43: a radius before it.
    To,
    /// G44: a radius beyond it.
    Past,
}

/// Tolerance of equal plane normals.
const SAME_PLANE: f64 = 1e-12;

/// The plane of the program as seen in the output frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum Shown {
    #[default]
    Same,
    /// Seen from the other side: left of the contour there is right of it here.
    Mirrored,
    /// Another plane.
    Other,
}

impl Shown {
    /// The plane with the given basis after the program's frame, as seen in the output frame.
    pub(in crate::exec) fn of(basis: &PlaneBasis, output: &Frame, plane: Plane) -> Shown {
        let normal = |basis: &PlaneBasis| basis.lift([0.0, 0.0], 1.0);
        let Some(shown) = PlaneBasis::behind(output, plane) else { return Shown::Other };
        match normal(basis).dot(&normal(&shown)) {
            along if along > 1.0 - SAME_PLANE => Shown::Same,
            along if along < SAME_PLANE - 1.0 => Shown::Mirrored,
            _ => Shown::Other,
        }
    }
}
