//! `$P_GG[group]`: the number of the active code within its G group.

use super::expression::Scope;
use super::frame_store::settable_number;
use super::modal::MotionKind;
use ncfix_base::geometry::Plane;
use ncfix_machine::snc::ThreadCode;

/// Codes of a group in the order of their numbers, from 1.
const MEMBERS: &[(u8, &[&str])] = &[
    (7, &["G40", "G41", "G42"]),
    (10, &["G60", "G64", "G641", "G642", "G643", "G644", "G645"]),
    (12, &["G601", "G602", "G603"]),
    (15, &["G93", "G94", "G95", "G96", "G97", "G931", "G961", "G971", "G942", "G952", "G962", "G972", "G973"]),
    (16, &["CFC", "CFTCP", "CFIN"]),
    (17, &["NORM", "KONT", "KONTT", "KONTC"]),
    (18, &["G450", "G451"]),
    (21, &["BRISK", "SOFT", "DRIVE"]),
    (23, &["CDOF", "CDON", "CDOF2"]),
    (24, &["FFWOF", "FFWON"]),
    (25, &["ORIWKS", "ORIMKS"]),
    (29, &["DIAMOF", "DIAMON", "DIAM90"]),
    (30, &["COMPOF", "COMPON", "COMPCURV", "COMPCAD"]),
    (40, &["CUTCONOF", "CUTCONON"]),
    (43, &["G140", "G141", "G142", "G143"]),
    (44, &["G340", "G341"]),
    (47, &["G290", "G291"]),
    (49, &["CP", "PTP"]),
    (59, &["DYNNORM", "DYNPOS", "DYNROUGH", "DYNSEMIFIN", "DYNFINISH"]),
];

/// Codes of the groups whose state is stored elsewhere.
const MORE_MEMBERS: &[(u8, &[&str])] = &[
    (1, &["G0", "G1", "G2", "G3", "CIP"]),
    (6, &["G17", "G18", "G19"]),
    (13, &["G70", "G71", "G700", "G710"]),
    (14, &["G90", "G91"]),
];

/// The code for a number within its group.
pub(super) fn code_of(group: i64, number: i64) -> Option<String> {
    if group == 8 {
        return match number {
            1 => Some("G500".to_owned()),
            2..=5 => Some(format!("G{}", 52 + number)),
            6..=100 => Some(format!("G{}", 499 + number)),
            _ => None,
        };
    }
    let (_, members) = MEMBERS.iter().chain(MORE_MEMBERS).find(|(known, _)| i64::from(*known) == group)?;
    let place = usize::try_from(number).ok()?.checked_sub(1)?;
    members.get(place).map(|name| (*name).to_owned())
}

impl Scope<'_> {
    /// The number of the active code; `None` for groups with unknown numbers.
    pub(super) fn member(&self, group: i64) -> Option<i64> {
        let modal = self.modal;
        let first_if = |first: bool| if first { 1 } else { 2 };
        Some(match group {
            1 => match modal.modes.motion {
                MotionKind::Rapid => 1,
                MotionKind::Line => 2,
                MotionKind::Clockwise => 3,
                MotionKind::CounterClockwise => 4,
                MotionKind::Through => 5,
                MotionKind::Tangent => 15,
                MotionKind::Akima => 6,
                MotionKind::BSpline => 7,
                MotionKind::Cubic => 8,
                MotionKind::Polynomial => 9,
                MotionKind::Thread(ThreadCode::G33) => 10,
                MotionKind::Thread(ThreadCode::G331) => 11,
                MotionKind::Thread(ThreadCode::G332) => 12,
                MotionKind::Thread(ThreadCode::G34) => 16,
                MotionKind::Thread(ThreadCode::G35) => 17,
                // Never active after its block.
                MotionKind::Thread(ThreadCode::G63) => return None,
            },
            6 => match modal.modes.plane {
                Plane::XY => 1,
                Plane::ZX => 2,
                Plane::YZ => 3,
            },
            8 => settable_number(modal.stated.offset())? + 1,
            13 => 1 + i64::from(!modal.modes.inch) + 2 * i64::from(modal.technological),
            14 => first_if(!modal.modes.incremental),
            _ => {
                let group = u8::try_from(group).ok()?;
                let word = modal.stated.codes.code(group)?;
                let (_, members) = MEMBERS.iter().find(|(known, _)| *known == group)?;
                i64::try_from(members.iter().position(|member| *member == word)?).ok()? + 1
            }
        })
    }
}
