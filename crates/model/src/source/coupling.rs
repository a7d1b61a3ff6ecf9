//! Cross-coupling: motion errors that also depend on the position of another axis (Spaan 1995, ch. 4, fig. 4.1).
//!
//! They are entries of `[[motion]]` with the kinds of functions of two axes.

use super::SourceInfo;

/// Name, title and sections of the source.
pub(super) static SOURCE: SourceInfo = SourceInfo {
    name: "coupling",
    title: "cross-coupling of two axes",
    sections: &[],
    example: "\
[[motion]]
component = \"EAY\"
kind = \"cross\"
coefficients = [0, 1e-9]
with = \"X\"
with_coefficients = [0, 1.0]
[[motion]]
component = \"EAY\"
kind = \"grid\"
positions_mm = [0, 250, 500]
with = \"X\"
with_positions_mm = [0, 700]
values_urad = [[0, 2], [6, 3], [4, -1]]
",
};
