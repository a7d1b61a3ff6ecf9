//! Contour words: modal changes, and requests for the motion of the block.

use super::address::Named;
use super::channel::Channel;
use super::channel::SinumerikAtHand;
use super::gathered::{Gathered, NamedValue};
use super::modal::Modal;
use super::modal::MotionKind;
use crate::exec::core::contour::{
    Approach, Clearance, CompensationDoubt, ContourModal, ContourRequest, Corner, FeedAt, Side, Soft, SoftForm,
    SoftSide, Transition,
};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::path::Path;
use crate::exec::core::standing::InForce;
use crate::syntax::sinumerik::DimensionFunction;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::source::Span;
use ncfix_base::units::MM_PER_INCH;
use ncfix_machine::snc::{Element, WordValue};

/// Words that may be passed to the control, as the output contains no compensation.
pub(super) const PASSED_ON: &[&str] = &["G40", "CFC", "CFTCP", "CFIN", "CUT2D", "CUT2DF"];

impl ContourModal {
    /// Sets a modal word.
    fn set(&mut self, word: &str) {
        match word {
            "G40" => self.side = Side::Off,
            "CUT2D" => self.follows_frame = false,
            "CUT2DF" => self.follows_frame = true,
            "G41" => self.side = Side::Left,
            "G42" => self.side = Side::Right,
            "NORM" => self.approach = Approach::Norm,
            "KONT" => self.approach = Approach::Kont,
            "KONTT" | "KONTC" => self.approach = Approach::Polynomial,
            "G450" => self.sharp = false,
            "G451" => self.sharp = true,
            "CDON" => self.collision = true,
            "CDOF" | "CDOF2" => self.collision = false,
            "CFC" => self.feed_at = FeedAt::Contour,
            "CFTCP" => self.feed_at = FeedAt::Center,
            "CFIN" => self.feed_at = FeedAt::InnerContour(0),
            "G140" => self.soft_side = SoftSide::Compensation,
            "G141" => self.soft_side = SoftSide::Left,
            "G142" => self.soft_side = SoftSide::Right,
            "G143" => self.soft_side = SoftSide::Nearest,
            "G340" => self.soft_in_plane = false,
            "G341" => self.soft_in_plane = true,
            _ => {}
        }
    }
}

/// The form of a soft approach or retraction, and `true` if it retracts.
fn soft_form(word: &str) -> Option<(SoftForm, bool)> {
    Some(match word {
        "G147" => (SoftForm::Line, false),
        "G148" => (SoftForm::Line, true),
        "G247" => (SoftForm::Quadrant, false),
        "G248" => (SoftForm::Quadrant, true),
        "G347" => (SoftForm::Semicircle, false),
        "G348" => (SoftForm::Semicircle, true),
        _ => return None,
    })
}

/// Executes the contour words of a block, before its motion and before its G0, G1 and F take effect.
pub(super) fn contour_words(
    modal: &mut Modal,
    block: &mut SinumerikAtHand,
    outlet: &mut MotionSink<'_>,
    gathered: &Gathered,
) -> Result<(), Fault> {
    if gathered.contour.is_empty() && gathered.addresses.is_empty() {
        return Ok(());
    }
    for word in &gathered.contour {
        modal.contour.set(word);
    }
    let (scale, feed_scale) = (modal.modes.scale(), feed_scale(modal));
    let not_negative = |value: &NamedValue, name: &str| {
        if value.value >= 0.0 && value.value <= 1e6 {
            return Ok(value.value);
        }
        Err(bad_value(value.span, format!("{name}={} is not allowed", value.value), "write a value, 0 or larger"))
    };
    if let Some(value) = gathered.named(Named::Rndm) {
        modal.contour.round_mm = not_negative(value, "RNDM")? * scale;
    }
    if let Some(value) = gathered.named(Named::Frcm) {
        modal.contour.corner_feed = not_negative(value, "FRCM")? * feed_scale;
    }
    for (address, name) in [(Named::Offn, "OFFN"), (Named::Toffr, "TOFFR")] {
        let Some(value) = gathered.named(address) else { continue };
        if value.value.is_nan() || value.value.abs() > 1e6 {
            return Err(bad_value(value.span, format!("{name}={} is not allowed", value.value), "correct the value"));
        }
        let place = match address {
            Named::Offn => &mut modal.contour.allowance_mm,
            _ => &mut modal.contour.radius_change_mm,
        };
        *place = value.value * scale;
    }
    if let Some(value) = gathered.named(Named::Disc).filter(|value| value.value != 0.0) {
        return Err(fault(
            Code::NOT_SUPPORTED,
            value.span,
            "DISC above 0 is not supported: its corners are not arcs",
            "use DISC=0, or G451",
        ));
    }
    let words = gathered.contour.iter();
    if let Some((form, retracts)) = words.filter_map(|word| soft_form(word)).next() {
        block.soft = Some(soft_words(modal, outlet, gathered, form, retracts)?);
    }
    Ok(())
}

/// Checks that the radius of G41 and G42 is that of a cutting edge named by the program.
pub(super) fn check_edge(strict: bool, modal: &Modal, outlet: &mut MotionSink<'_>, gathered: &Gathered, span: Span) {
    let code = gathered.contour.iter().find(|word| matches!(**word, "G41" | "G42"));
    let Some(code) = code.filter(|_| strict && !modal.edge_stated) else { return };
    let message = format!("{code} without D: the radius would be that of the tool of an earlier program");
    let help = "program T, M6 where the machine needs it, and D before it";
    outlet.warnings.push(fault(Code::BAD_COMPENSATION, span, message, help));
}

fn feed_scale(modal: &Modal) -> f64 {
    if modal.inch_feed { MM_PER_INCH } else { 1.0 }
}

fn soft_words(
    modal: &Modal,
    outlet: &MotionSink<'_>,
    gathered: &Gathered,
    form: SoftForm,
    retracts: bool,
) -> Result<Soft, Fault> {
    let scale = modal.modes.scale();
    if let Some(value) = gathered.named(Named::Disrp) {
        let message = "DISRP is not supported";
        return Err(fault(
            Code::NOT_SUPPORTED,
            value.span,
            message,
            "move to the retraction plane in a previous block",
        ));
    }
    let size = gathered.named(Named::Disr).map_or(0.0, |value| value.value);
    let least = if form == SoftForm::Line { 0.0 } else { 1e-6 };
    if !(size >= least && size <= 1e6) {
        let span = gathered.named(Named::Disr).map_or(outlet.origin.span, |value| value.span);
        return Err(bad_value(span, format!("DISR={size} is not allowed here"), "write the radius or length"));
    }
    let clearance = match gathered.named(Named::Discl) {
        None => Clearance::Above(0.0),
        Some(value) if value.dimension == Some(DimensionFunction::Absolute) => Clearance::At(value.value * scale),
        Some(value) => Clearance::Above(value.value * scale),
    };
    Ok(Soft {
        form,
        retracts,
        side: modal.contour.soft_side,
        in_plane: modal.contour.soft_in_plane,
        size_mm: size * scale,
        clearance,
        infeed: gathered.named(Named::Fad).map_or(0.0, |value| value.value.max(0.0) * feed_scale(modal)),
        feed_before: modal.modes.feed,
        rapid_before: modal.modes.motion == MotionKind::Rapid,
    })
}

/// The transition requested after a block.
pub(super) fn corner_words(
    modal: &Modal,
    block: &mut SinumerikAtHand,
    standing: &InForce,
    gathered: &Gathered,
) -> Result<(), Fault> {
    block.corner = None;
    block.corner_feed = None;
    if gathered.addresses.is_empty() {
        return Ok(());
    }
    let scale = modal.modes.scale();
    let mut found: Option<Transition> = None;
    for (address, name) in [(Named::Rnd, "RND"), (Named::Chf, "CHF"), (Named::Chr, "CHR")] {
        let Some(value) = gathered.named(address) else { continue };
        if found.is_some() || !(value.value >= 0.0 && value.value <= 1e6) {
            let help = "write one of RND, CHF and CHR, with a value above 0";
            return Err(bad_value(value.span, format!("{name}={} is not allowed here", value.value), help));
        }
        if value.value == 0.0 {
            continue;
        }
        let size = value.value * scale * even_scale(modal, standing, value)?;
        found = Some(match address {
            Named::Rnd => Transition::Round(size),
            Named::Chf => Transition::ChamferLength(size),
            _ => Transition::ChamferSetback(size),
        });
    }
    let feed = gathered.named(Named::Frc).map(|value| value.value.max(0.0) * feed_scale(modal));
    let feed = feed.unwrap_or(modal.contour.corner_feed);
    block.corner_feed = found.is_none().then_some(feed);
    block.corner = found.map(|transition| Corner { transition, feed, is_modal: false });
    Ok(())
}

/// The factor by which the frame scales the plane.
fn even_scale(modal: &Modal, standing: &InForce, value: &NamedValue) -> Result<f64, Fault> {
    let frame = &standing.setup.frame;
    if frame.is_translation() {
        return Ok(1.0);
    }
    if !frame.keeps_circles(modal.modes.plane) {
        return Err(fault(
            Code::NOT_SUPPORTED,
            value.span,
            "a rounding or chamfer under unequal scale",
            "scale both axes of the plane equally",
        ));
    }
    let [abscissa, ..] = modal.modes.plane.axes();
    Ok(frame.linear().column(abscissa.slot()).norm())
}

/// Sine of the largest angle between a plane after the frame and that of the machine to be one plane: with a tool radius of 20 mm, both ways of
/// compensation then differ by less than 0.2 µm.
const SAME_PLANE: f64 = 1e-5;

/// The contour request of a block's motion; `None` if it has none.
pub(super) fn wish(channel: &mut Channel<'_>, path: &Path) -> Option<ContourRequest> {
    let (corner, soft) = (channel.block.corner.take(), channel.block.soft.take());
    let modal = channel.modal.contour;
    let is_open = channel.open_angle.is_some();
    if !is_open && corner.is_none() && soft.is_none() && modal.is_plain() && !channel.outlet.is_holding() {
        return None;
    }
    let modal_corner = (modal.round_mm > 0.0).then(|| {
        let frame = &channel.standing.setup.frame;
        let [abscissa, ..] = channel.modal.modes.plane.axes();
        let scale = frame.linear().column(abscissa.slot()).norm();
        // FRC has priority over FRCM, also for RNDM.
        let feed = channel.block.corner_feed.unwrap_or(modal.corner_feed);
        Corner { transition: Transition::Round(modal.round_mm * scale), feed, is_modal: true }
    });
    let beside = channel.modal.tool.radius_mm + modal.allowance_mm + modal.radius_change_mm;
    let distance_mm = match modal.side {
        Side::Off => 0.0,
        Side::Left => beside,
        Side::Right => -beside,
    };
    let corner = corner.or(modal_corner);
    let [.., applicate] = channel.modal.modes.plane.axes();
    let soft = soft.map(|soft| match soft.clearance {
        Clearance::At(value) => {
            let mut place = path.setup.programmed(&path.motion.target);
            place[applicate] = value;
            Soft { clearance: Clearance::At(path.basis.height(&path.setup.command(&place))), ..soft }
        }
        Clearance::Above(_) => soft,
    });
    let doubt = doubt(channel, path);
    Some(ContourRequest { modal, distance_mm, corner, soft, doubt, span: path.span, file: channel.outlet.origin.file })
}

/// The reason why the path of the tool center is not known: CUT2D compensates in the plane of G17 to G19, CUT2DF in that of the frame, and both know no
/// tool that turns. A plane of CYCLE800 is at right angles to the tool, so that cycles and contours there are those of the plane.
fn doubt(channel: &Channel<'_>, path: &Path) -> Option<CompensationDoubt> {
    let modal = &channel.modal.contour;
    if !modal.compensates() {
        return None;
    }
    let [.., applicate] = channel.modal.modes.plane.axes();
    let across = path.basis.lift([0.0, 0.0], 1.0).cross(&Vector::ith(applicate.slot(), 1.0)).norm();
    if across > SAME_PLANE && !modal.follows_frame && channel.modal.swivelled.is_none() {
        return Some(CompensationDoubt::TiltedPlane);
    }
    let kinematics = channel.outlet.kinematics.as_deref().filter(|_| path.setup.transform.is_some())?;
    let turns = |axis: Axis| !path.start_known.contains(axis) || path.start[axis] != path.motion.target[axis];
    kinematics.rotary_axes().any(turns).then_some(CompensationDoubt::ToolTurns)
}

/// Emits a motion through the contour stage.
pub(super) fn pass_path(channel: &mut Channel<'_>, path: Path, element: Element, wish: ContourRequest) {
    check_known(channel.settings.strict, &channel.modal, &mut channel.outlet, &path, &wish);
    let (tool, edge) = (&channel.modal.tool.active, channel.modal.edge);
    channel.outlet.name_register(&wish, || match tool {
        Some(WordValue::Number(number)) => format!("D{edge} of T{number}"),
        Some(WordValue::Name(name)) => format!("D{edge} of T=\"{}\"", String::from_utf8_lossy(name)),
        None => format!("D{edge}"),
    });
    if channel.open_angle.is_some() {
        channel.outlet.open(path, element, wish);
    } else {
        channel.outlet.pass_path(path, element, wish);
    }
}

/// Rejects motions that depend on positions the program has not stated.
fn check_known(strict: bool, modal: &Modal, outlet: &mut MotionSink<'_>, path: &Path, wish: &ContourRequest) {
    if path.motion.is_inverse_time() && wish.corner.is_some() {
        let message = "a rounding or chamfer with inverse-time feed (G93)";
        outlet.warnings.push(fault(Code::NOT_SUPPORTED, wish.span, message, "program the feed with G94 or G95"));
    }
    if strict {
        outlet.check_stated(path, wish, modal.modes.plane);
    }
}
