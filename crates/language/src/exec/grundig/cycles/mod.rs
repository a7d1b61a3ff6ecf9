//! Machining cycles: the elementary moves of the control at one position.
//!
//! A cycle is defined once (G81 … G89) and executed at each position of G79 or G77. Its words keep their meaning in every plane. Here the plane is
//! abscissa and ordinate about the position, and heights are relative to the workpiece zero along the tool axis. Each cycle is one file and one row
//! of [`CYCLES`].

mod basis;
mod bore;
mod circular_pocket;
mod drill;
mod pattern;
mod peck;
mod pocket;
mod ream;
mod rectangular_pocket;
mod slot;
mod tap;

pub(super) use basis::{At, CycleFault, CycleWords};
pub(super) use pattern::bolt_circle;

use crate::exec::core::step::Step;

/// A cycle.
pub(super) struct Cycle {
    /// Its G number.
    pub(super) number: u16,
    /// Its name in messages.
    pub(super) title: &'static str,
    /// Required words, by letter.
    pub(super) needs: &'static [u8],
    /// Its name if its strokes are not those of the control.
    pub(super) own_strokes: Option<&'static str>,
    /// Its steps at a position.
    pub(super) steps: fn(&CycleWords, &At) -> Result<Vec<Step>, CycleFault>,
}

/// The registry of cycles.
pub(super) const CYCLES: &[Cycle] = &[
    Cycle { number: 81, title: "drilling", needs: b"YZ", own_strokes: None, steps: drill::steps },
    Cycle { number: 83, title: "deep-hole drilling", needs: b"YZK", own_strokes: None, steps: peck::steps },
    Cycle { number: 84, title: "tapping", needs: b"YZ", own_strokes: None, steps: tap::steps },
    Cycle { number: 85, title: "reaming", needs: b"YZ", own_strokes: None, steps: ream::steps },
    Cycle { number: 86, title: "boring", needs: b"YZ", own_strokes: None, steps: bore::steps },
    Cycle {
        number: 87,
        title: "rectangular pocket",
        needs: b"XYZB",
        own_strokes: Some("G87"),
        steps: rectangular_pocket::steps,
    },
    Cycle { number: 88, title: "slot", needs: b"XYZB", own_strokes: Some("G88"), steps: slot::steps },
    Cycle {
        number: 89,
        title: "circular pocket",
        needs: b"ZBR",
        own_strokes: Some("G89"),
        steps: circular_pocket::steps,
    },
];

/// The cycle of a G number.
pub(super) fn find(number: u16) -> Option<&'static Cycle> {
    CYCLES.iter().find(|cycle| cycle.number == number)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words `letter[index]=value` and a position.
    pub(super) fn words(list: &[(u8, u16, f64)]) -> CycleWords {
        let mut out = CycleWords::default();
        list.iter().for_each(|&(letter, index, value)| out.set(letter, index, value));
        out
    }

    pub(super) fn run(number: u16, list: &[(u8, u16, f64)], at: At) -> Vec<Step> {
        let cycle = find(number).unwrap();
        (cycle.steps)(&words(list), &at).unwrap()
    }

    /// Heights of the steps; rapid moves are marked.
    pub(super) fn heights(steps: &[Step]) -> Vec<(bool, f64)> {
        let of = |step: &Step| match step {
            Step::Rapid { height: Some(height), .. } => Some((true, *height)),
            Step::Line { height: Some(height), .. } => Some((false, *height)),
            _ => None,
        };
        steps.iter().filter_map(of).collect()
    }

    #[test]
    fn drilling_goes_to_its_heights() {
        let at = At { point: [10.0, 20.0], surface: -5.0, height: 10.0, ..At::default() };
        let steps = run(81, &[(b'Y', 0, 2.0), (b'B', 0, 8.0), (b'Z', 0, -10.0), (b'X', 0, 0.5)], at);
        // Surface -5: first clearance -3, bottom -15, retraction 5.
        assert_eq!(heights(&steps), [(true, -3.0), (false, -15.0), (true, 5.0)]);
        assert!(steps.contains(&Step::Dwell(0.5)));
    }

    #[test]
    fn a_tool_below_the_first_clearance_rises_first() {
        let steps = run(81, &[(b'Y', 0, 2.0), (b'Z', 0, -10.0)], At { height: -1.0, ..At::default() });
        assert_eq!(steps[0], Step::rapid_height(2.0));
    }

    #[test]
    fn pecks_get_shorter_and_end_at_the_bottom() {
        let at = At { height: 10.0, peck_clearance_mm: 1.0, ..At::default() };
        let list = [(b'Y', 0, 2.0), (b'Z', 0, -25.0), (b'K', 0, 10.0), (b'I', 0, 2.0), (b'J', 0, 1.0)];
        // Pecks 10, 8, 6 and a remainder of 1, each followed by a lift of 1.
        let expected = [
            (true, 2.0),
            (false, -10.0),
            (true, -9.0),
            (false, -18.0),
            (true, -17.0),
            (false, -24.0),
            (true, -23.0),
            (false, -25.0),
            (true, 2.0),
        ];
        assert_eq!(heights(&run(83, &list, at)), expected);
        // Without J the tool leaves the hole after each peck and returns to 1 mm above the previous depth.
        let expected = [(true, 2.0), (false, -10.0), (true, 2.0), (true, -9.0), (false, -12.0), (true, 2.0)];
        let list = [(b'Y', 0, 2.0), (b'Z', 0, -12.0), (b'K', 0, 10.0)];
        assert_eq!(heights(&run(83, &list, at)), expected);
    }

    #[test]
    fn a_peck_that_would_shrink_to_nothing_stays() {
        let at = At { height: 10.0, ..At::default() };
        let list = [(b'Y', 0, 2.0), (b'Z', 0, -12.0), (b'K', 0, 5.0), (b'I', 0, 5.0), (b'J', 0, 1.0)];
        let expected =
            [(true, 2.0), (false, -5.0), (true, -4.0), (false, -10.0), (true, -9.0), (false, -12.0), (true, 2.0)];
        assert_eq!(heights(&run(83, &list, at)), expected);
    }

    #[test]
    fn reaming_leaves_the_hole_at_feed() {
        let at = At { point: [10.0, 20.0], surface: -5.0, height: 10.0, ..At::default() };
        let steps = run(85, &[(b'Y', 0, 2.0), (b'B', 0, 8.0), (b'Z', 0, -10.0), (b'X', 0, 0.5)], at);
        // Surface -5: first clearance -3, bottom -15, retraction 5.
        assert_eq!(heights(&steps), [(true, -3.0), (false, -15.0), (false, -3.0), (true, 5.0)]);
        assert!(steps.contains(&Step::Dwell(0.5)));
        // Without B the tool stays at the first clearance.
        let steps = run(85, &[(b'Y', 0, 2.0), (b'Z', 0, -10.0)], at);
        assert_eq!(heights(&steps), [(true, -3.0), (false, -15.0), (false, -3.0)]);
    }

    #[test]
    fn a_tool_may_be_as_wide_as_the_slot_and_no_wider() {
        let list = words(&[(b'X', 0, 40.0), (b'Y', 0, 12.0), (b'Z', 0, -2.0), (b'B', 0, 1.0)]);
        let steps = |tool_radius_mm| {
            let at = At { tool_radius_mm, engagement_percent: 60.0, ..At::default() };
            (find(88).unwrap().steps)(&list, &at)
        };
        assert_eq!([5.5, 6.0, 6.5].map(|radius| steps(radius).is_ok()), [true, true, false]);
    }

    #[test]
    fn no_depth_is_a_finding() {
        let cycle = find(81).unwrap();
        assert!((cycle.steps)(&words(&[(b'Y', 0, 2.0), (b'Z', 0, 3.0)]), &At::default()).is_err());
    }

    #[test]
    fn each_number_stands_once() {
        for (place, cycle) in CYCLES.iter().enumerate() {
            assert!(CYCLES[place + 1..].iter().all(|other| other.number != cycle.number), "G{}", cycle.number);
        }
    }
}
