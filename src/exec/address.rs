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
    /// Angle of a rotation in the working plane.
    Rpl,
    /// A part of a direction of the tool or surface: `A2=` (angles), `A3=` (tool), by its number and slot.
    Orientation(u8, u8),
}

/// Names and their addresses.
pub(super) const NAMED: &[(&str, Named)] = &[("CR", Named::Cr), ("TURN", Named::Turn), ("RPL", Named::Rpl)];

/// The address of a name, upper case.
pub(super) fn named(name: &str) -> Option<Named> {
    NAMED.iter().find(|(known, _)| *known == name).map(|&(_, address)| address)
}

impl Named {
    /// Whether a block moves because it has this address.
    pub(super) fn moves(self) -> bool {
        match self {
            Named::Cr | Named::Turn | Named::Orientation(..) => true,
            Named::Rpl => false,
        }
    }
}
