//! Reversal: backlash, lateral play and turning play, which depend on the sense of the last motion of the axis.
//!
//! They stand in `[[motion]]` with `kind = "backlash"`.

use super::SourceInfo;

/// The source.
pub(super) static SOURCE: SourceInfo = SourceInfo {
    name: "reversal",
    title: "backlash and lateral play",
    sections: &[],
    example: "\
[[motion]]
component = \"EYY\"
kind = \"backlash\"
value_um = 6.0
[[motion]]
component = \"EZX\"
kind = \"backlash\"
positions_mm = [0, 700]
values_um = [2.0, 5.0]
",
};
