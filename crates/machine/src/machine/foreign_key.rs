//! Keys of `[control]` that the control of the machine does not have.

use super::section::Section;
use ncfix_base::diagnostic::Code;

const SINUMERIK: &str = "sinumerik";
const FANUC: &str = "fanuc";
const RS274: &str = "rs274";
const GRUNDIG: &str = "grundig";

/// Languages, with the names that a person reads.
const LANGUAGES: [(&str, &str); 4] =
    [(SINUMERIK, "Sinumerik"), (FANUC, "Fanuc and Haas"), (RS274, "RS274/NGC"), (GRUNDIG, "Grundig and MillPlus")];

/// Keys that not every control has, and the languages whose programs they concern. A key that ends with `_` stands for all that begin so.
const KEYS: &[(&[&str], &[&str])] = &[
    (
        &[
            "allow_synchronised",
            "edge_after_tool_change",
            "fine_shift",
            "increments_per_mm",
            "incremental_traverses_frame_change",
            "initial_codes",
            "mirror_toggles",
            "orientation_angles",
            "oripath",
            "relative_comparison",
            "swivel_direction_axis",
            "swivel_retract_",
            "tilt_about",
            "tool_length_plane",
            "transverse_axis",
        ],
        &[SINUMERIK],
    ),
    (
        &[
            "arc_radius_check",
            "arguments_two",
            "codes_within_rotation",
            "decimal_point",
            "dwell_turns",
            "dwell_with_point",
            "increment_system",
            "least_arc_feed_percent",
            "length_compensation",
            "macro_codes",
            "one_axis_in_rotation",
            "orient_shift",
            "signed_angles",
            "tip_coordinates",
            "word_meaning",
        ],
        &[FANUC],
    ),
    (&["arc_plane_from_words", "grundig_", "last_block_number"], &[GRUNDIG]),
    (&["arc_words_from_center"], &[FANUC, GRUNDIG]),
    (
        &[
            "chip_clearance_mm",
            "compensation_start",
            "peck_clearance_mm",
            "reference_point_",
            "rigid_tapping",
            "startup_code",
        ],
        &[FANUC, RS274],
    ),
    (&["compensation_corner", "rollover"], &[FANUC, RS274, GRUNDIG]),
    (&["max_program_levels", "passed_on_axes"], &[SINUMERIK, FANUC, RS274]),
];

/// Reports the keys that have no effect on the control of the machine.
pub(super) fn report(section: &mut Section<'_>, controller: &str) {
    let Some((language, shown)) = LANGUAGES.into_iter().find(|(name, _)| controller.eq_ignore_ascii_case(name)) else {
        return;
    };
    let fits = |known: &str, key: &str| if known.ends_with('_') { key.starts_with(known) } else { key == known };
    let foreign: Vec<(&str, &[&str])> = section
        .keys()
        .filter_map(|key| {
            let (_, own) = KEYS.iter().find(|(known, _)| known.iter().any(|known| fits(known, key)))?;
            (!own.contains(&language)).then_some((key, *own))
        })
        .collect();
    for (key, own) in foreign {
        let names: Vec<&str> =
            LANGUAGES.iter().filter(|(name, _)| own.contains(name)).map(|(_, shown)| *shown).collect();
        let message = format!("{key} has no effect with controller = \"{controller}\"");
        let help = format!(
            "remove the key, or correct [machine] controller: {key} is a setting of {}, and the programs of this machine are for {shown}",
            names.join(", ")
        );
        section.report(Code::FOREIGN_KEY, section.place_of_key(key), message, help);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_listed_once() {
        let mut all: Vec<&str> = KEYS.iter().flat_map(|(keys, _)| keys.iter().copied()).collect();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count);
        assert!(KEYS.iter().all(|(_, own)| !own.is_empty() && own.len() < LANGUAGES.len()));
    }
}
