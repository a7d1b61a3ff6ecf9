//! What the program wants of the contour: modal codes, and what one motion asks of the stage.

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

/// How compensation begins and ends: NORM, KONT and its kin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum Approach {
    /// Straight to the perpendicular position.
    #[default]
    Norm,
    /// Around the first corner where the start lies behind the contour.
    Kont,
    /// Square to its own end, then around the first corner where that is an outer one.
    Own,
    /// KONTT, KONTC.
    Polynomial,
}

/// On which contours F holds where the tool moves beside them: CFC, CFTCP, CFIN.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum FeedAt {
    /// The contour.
    #[default]
    Contour,
    /// The tool center.
    Center,
    /// The contour of inner arcs, the tool center elsewhere.
    InnerContour,
}

/// Side of soft approach and retraction: G140 to G143.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum SoftSide {
    /// That of the compensation.
    #[default]
    Compensation,
    Left,
    Right,
    /// Where the start lies as seen from the tangent.
    Nearest,
}

/// Modal state of contours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::exec) struct ContourModal {
    pub(in crate::exec) side: Side,
    pub(in crate::exec) approach: Approach,
    /// G451 instead of G450: straight around outer corners.
    pub(in crate::exec) sharp: bool,
    /// CDON: intersections of motions that are no neighbors count too.
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
    /// G341 instead of G340.
    pub(in crate::exec) soft_in_plane: bool,
    /// Whose rules of radius compensation hold.
    pub(in crate::exec) rules: Rules,
    /// G43, G44 of Grundig.
    pub(in crate::exec) reach: Reach,
    /// How often compensation has been switched on.
    pub(in crate::exec) activation: u32,
    /// The number of the register that holds the radius, where it stands beside G41 and G42: D.
    pub(in crate::exec) register: Option<u32>,
    /// The plane as the output shows it.
    pub(in crate::exec) shown: Shown,
    /// G40 I J: the direction in the plane in which the contour seems to go on behind its end.
    pub(in crate::exec) leaves_along: Option<[f64; 2]>,
}

impl ContourModal {
    /// Whether radius compensation is on.
    pub(in crate::exec) fn compensates(&self) -> bool {
        self.side != Side::Off
    }

    /// Whether motions are what they are.
    pub(in crate::exec) fn is_plain(&self) -> bool {
        !self.compensates() && self.round_mm == 0.0 && self.reach == Reach::End
    }
}

/// What stands between two contour elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) enum Transition {
    /// RND: an arc of this radius, mm.
    Round(f64),
    /// CHF: a chamfer of this length, mm.
    ChamferLength(f64),
    /// CHR: a chamfer that begins and ends this far from the corner, mm.
    ChamferSetback(f64),
}

/// A transition behind a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) struct Corner {
    pub(in crate::exec) transition: Transition,
    /// Its feed, 0 for that of the block.
    pub(in crate::exec) feed: f64,
    /// RNDM: does not have to be there.
    pub(in crate::exec) is_modal: bool,
}

/// The form of a soft approach or retraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::exec) enum SoftForm {
    Line,
    Quadrant,
    Semicircle,
}

/// Where the fast part of a soft approach ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) enum Clearance {
    /// This far from the plane of the contour, mm.
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
    /// Feed and rapid of the block before.
    pub(in crate::exec) feed_before: f64,
    pub(in crate::exec) rapid_before: bool,
}

/// What one motion asks of the stage.
#[derive(Clone, Copy, Debug)]
pub(in crate::exec) struct Wish {
    pub(in crate::exec) modal: ContourModal,
    /// Distance of the tool center to the left of the contour, mm; 0 without compensation.
    pub(in crate::exec) distance_mm: f64,
    pub(in crate::exec) corner: Option<Corner>,
    pub(in crate::exec) soft: Option<Soft>,
    pub(in crate::exec) span: Span,
    pub(in crate::exec) file: FileId,
}

impl Wish {
    /// Whether the tool stops or moves beside what is programmed, by its radius.
    pub(in crate::exec) fn is_beside(&self) -> bool {
        self.compensates() || self.modal.reach != Reach::End
    }

    pub(in crate::exec) fn compensates(&self) -> bool {
        self.modal.side != Side::Off
    }
}

/// Whose rules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum Rules {
    #[default]
    Sinumerik,
    /// Cutter compensation C. [`ContourModal::sharp`]: lines around outer corners.
    Fanuc,
    /// RS274/NGC as LinuxCNC executes it: the first motion ends beside its own end, none leads off.
    Rs274,
    /// [`ContourModal::sharp`]: outer corners to the intersection.
    Grundig,
}

/// Where a straight motion without compensation of its side ends: G43, G44 of Grundig.
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

/// Normals of planes are the same to this.
const SAME_PLANE: f64 = 1e-12;

/// The plane of the program as the frame of the output shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::exec) enum Shown {
    #[default]
    Same,
    /// From the other side: what is left of the contour there is right of it here.
    Mirrored,
    /// Another plane.
    Other,
}

impl Shown {
    /// The plane behind the frame of the program, whose basis is given, as the frame of the output has it.
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
