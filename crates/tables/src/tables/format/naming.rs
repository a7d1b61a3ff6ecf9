//! The axis of a single-axis file, by its name: `x.comp`, `mill-y.com`, `joint_2.comp`, `zscrew.comp`.

use crate::tables::Wiring;
use ncfix_base::geometry::Axis;

/// The axis of a file name, ignoring folders and extension.
pub(super) fn axis(wiring: &Wiring, name: &str) -> Option<Axis> {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let parts = || stem.split(|c: char| !c.is_ascii_alphanumeric()).filter(|part| !part.is_empty());
    let named = parts().rev().find_map(|part| wiring.axis(part));
    named.or_else(|| joint(wiring, stem)).or_else(|| parts().find_map(|part| screw(wiring, part)))
}

/// `joint_2` is the third axis: joints are numbered from 0.
fn joint(wiring: &Wiring, stem: &str) -> Option<Axis> {
    let lower = stem.to_ascii_lowercase();
    let (_, behind) = lower.rsplit_once("joint")?;
    let number: usize = behind.trim_start_matches(['_', '-', '.']).parse().ok()?;
    wiring.axes().nth(number)
}

/// `xscrew`, as the LinuxCNC manual names such a file.
fn screw(wiring: &Wiring, part: &str) -> Option<Axis> {
    let lower = part.to_ascii_lowercase();
    wiring.axis(lower.strip_suffix("screw")?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_one_axis_tell_it() {
        let wiring = Wiring::usual();
        for (name, expected) in [
            ("/tmp/mill.d/x.comp", Some(Axis::X)),
            ("mill-Y.COM", Some(Axis::Y)),
            ("a/AXIS_C.COM", Some(Axis::C)),
            ("joint_2.comp", Some(Axis::Z)),
            ("xscrew.comp", Some(Axis::X)),
            ("axis.comp", None),
            ("", None),
            ("joint99.comp", None),
        ] {
            assert_eq!(axis(&wiring, name), expected, "{name}");
        }
    }
}
