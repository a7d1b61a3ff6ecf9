//! Reversal: backlash, lateral play and angular play, which depend on the direction of the last motion of the axis.
//!
//! They are entries of `[[motion]]` with `kind = "backlash"`.

use super::SourceInfo;

/// Name, title and sections of the source.
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
