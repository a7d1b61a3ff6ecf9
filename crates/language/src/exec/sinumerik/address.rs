//! The register of named addresses: `CR=`, `TURN=`, `RND=`, `AX[…]=` and similar.
//!
//! An address with a value is gathered here and retrieved with [`super::gathered::Gathered::named`] where it is executed. To add one, add a row to
//! `grammars/sinumerik-words.tsv`, a variant, and the code that uses it.

/// A named address.
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
    /// Length of the parameter of a spline or polynomial.
    Pl,
    /// Weight of a control point.
    Pw,
    /// Degree of a B-spline.
    Sd,
    /// A component of a direction of tool or surface: `A2=` (angles), `A3=` (tool), by its number and slot.
    Orientation(u8, u8),
    /// Angles of the tool relative to path and surface.
    Lead,
    Tilt,
    /// Roundings and chamfers after the block, and their feed.
    Rnd,
    Rndm,
    Chf,
    Chr,
    Frc,
    Frcm,
    /// Angle of a straight contour element.
    Ang,
    /// Radius compensation: corner bulge, allowance, change of the radius.
    Disc,
    Offn,
    Toffr,
    /// Soft approach and retraction: size, clearance, retraction plane, infeed.
    Disr,
    Discl,
    Disrp,
    Fad,
}

/// The address of a letter with an extension: `I1=`, `A3=`.
pub(super) fn extended(letter: u8, extension: u32) -> Option<Named> {
    Some(match (letter, extension) {
        (b'I', 1) => Named::I1,
        (b'J', 1) => Named::J1,
        (b'K', 1) => Named::K1,
        _ => return address(letter, extension),
    })
}

impl Named {
    /// The address of a word with the treatment `read`, upper case.
    ///
    /// Productions `transition` and `orientation`, and the addresses of `compensation` and `soft`.
    pub(super) fn of(name: &str) -> Option<Named> {
        Some(match name {
            "CR" => Named::Cr,
            "TURN" => Named::Turn,
            "AR" => Named::Ar,
            "AP" => Named::Ap,
            "RP" => Named::Rp,
            "RPL" => Named::Rpl,
            "RND" => Named::Rnd,
            "RNDM" => Named::Rndm,
            "CHF" => Named::Chf,
            "CHR" => Named::Chr,
            "FRC" => Named::Frc,
            "FRCM" => Named::Frcm,
            "ANG" => Named::Ang,
            "DISC" => Named::Disc,
            "OFFN" => Named::Offn,
            "TOFFR" => Named::Toffr,
            "DISR" => Named::Disr,
            "DISCL" => Named::Discl,
            "DISRP" => Named::Disrp,
            "FAD" => Named::Fad,
            "LEAD" => Named::Lead,
            "TILT" => Named::Tilt,
            "PL" => Named::Pl,
            "PW" => Named::Pw,
            "SD" => Named::Sd,
            _ => return None,
        })
    }

    /// `true` if a block with this address moves.
    pub(super) fn moves(self) -> bool {
        matches!(
            self,
            Named::Cr
                | Named::Turn
                | Named::Ar
                | Named::I1
                | Named::J1
                | Named::K1
                | Named::Ap
                | Named::Rp
                | Named::Ang
                | Named::Orientation(2 | 3, _)
        )
    }
}

/// The address of `A2` to `C7`; `None` if it is not a direction.
pub(super) fn address(letter: u8, extension: u32) -> Option<Named> {
    let slot = letter.checked_sub(b'A').filter(|slot| *slot < 3)?;
    let number = u8::try_from(extension).ok().filter(|number| (2..=7).contains(number))?;
    Some(Named::Orientation(number, slot))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_dialect::{Treatment, WordPlace, words};

    #[test]
    fn every_address_of_the_table_is_taken_and_no_other() {
        for row in words().rows().iter().filter(|row| row.place == WordPlace::Block) {
            assert_eq!(Named::of(row.name).is_some(), row.treatment == Treatment::Read, "{}", row.name);
        }
    }
}
