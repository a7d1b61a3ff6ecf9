//! The register of addresses that are names: `CR=`, `TURN=`, `RND=`, `AX[…]=` and their kin.
//!
//! An address with a value is gathered by its row here and found again by [`super::gathered::Gathered::named`]; whoever executes it
//! takes it from there. To add one, add a variant, a row, and the code that takes it.

/// An address that is a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Named {
    /// Radius of an arc.
    Cr,
    /// Extra turns of a helix.
    Turn,
    /// Opening angle of an arc.
    Ar,
    /// Intermediate point of an arc.
    I1,
    J1,
    K1,
    /// Polar angle and radius.
    Ap,
    Rp,
    /// Angle of a rotation in the working plane.
    Rpl,
    /// A part of a direction of the tool or surface: `A2=` (angles), `A3=` (tool), by its number and slot.
    Orientation(u8, u8),
}

/// Names and their addresses.
pub(super) const NAMED: &[(&str, Named)] = &[
    ("CR", Named::Cr),
    ("TURN", Named::Turn),
    ("AR", Named::Ar),
    ("AP", Named::Ap),
    ("RP", Named::Rp),
    ("RPL", Named::Rpl),
];

/// The address of a name, upper case.
pub(super) fn named(name: &str) -> Option<Named> {
    NAMED.iter().find(|(known, _)| *known == name).map(|&(_, address)| address)
}

/// The address of a letter with an extension: `I1=`, `A3=`.
pub(super) fn extended(letter: u8, extension: u32) -> Option<Named> {
    Some(match (letter, extension) {
        (b'I', 1) => Named::I1,
        (b'J', 1) => Named::J1,
        (b'K', 1) => Named::K1,
        _ => return super::orientation::address(letter, extension),
    })
}

impl Named {
    /// Whether a block moves because it has this address.
    pub(super) fn moves(self) -> bool {
        match self {
            Named::Cr
            | Named::Turn
            | Named::Ar
            | Named::I1
            | Named::J1
            | Named::K1
            | Named::Ap
            | Named::Rp
            | Named::Orientation(..) => true,
            Named::Rpl => false,
        }
    }
}
