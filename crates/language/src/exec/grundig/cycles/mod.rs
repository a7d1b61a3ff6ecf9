//! Machining cycles: what a control does at one position, as elementary moves.
//!
//! A cycle is defined once (G81 … G89) and acts wherever G79 or G77 names a position. Its words keep their meaning in every plane; here
//! the plane is abscissa and ordinate about the position, and heights are relative to the workpiece zero along the tool axis. Each
//! cycle is one file and one row of [`CYCLES`].

mod bore;
mod circular_pocket;
mod drill;
mod pattern;
mod peck;
mod pocket;
mod ream;
mod rectangular_pocket;
mod slot;
mod step;
mod tap;

pub(super) use pattern::bolt_circle;
pub(super) use step::{Feed, Flat, Step};

/// A cycle.
pub(super) struct Cycle {
    /// Its G number.
    pub(super) number: u16,
    /// What it makes, for findings.
    pub(super) title: &'static str,
    /// Words that it must have, by letter.
    pub(super) needs: &'static [u8],
    /// What it does at a position.
    pub(super) steps: fn(&CycleWords, &At) -> Result<Vec<Step>, CycleFault>,
}

/// The register.
pub(super) const CYCLES: &[Cycle] = &[
    Cycle { number: 81, title: "drilling", needs: b"YZ", steps: drill::steps },
    Cycle { number: 83, title: "deep-hole drilling", needs: b"YZK", steps: peck::steps },
    Cycle { number: 84, title: "tapping", needs: b"YZ", steps: tap::steps },
    Cycle { number: 85, title: "reaming", needs: b"YZ", steps: ream::steps },
    Cycle { number: 86, title: "boring", needs: b"YZ", steps: bore::steps },
    Cycle { number: 87, title: "rectangular pocket", needs: b"XYZB", steps: rectangular_pocket::steps },
    Cycle { number: 88, title: "slot", needs: b"XYZB", steps: slot::steps },
    Cycle { number: 89, title: "circular pocket", needs: b"ZBR", steps: circular_pocket::steps },
];

/// The cycle of a G number.
pub(super) fn find(number: u16) -> Option<&'static Cycle> {
    CYCLES.iter().find(|cycle| cycle.number == number)
}

/// The words with which a cycle was defined: lengths in mm, dwells in s, angles in degrees as programmed.
#[derive(Clone, Debug, Default)]
pub(super) struct CycleWords(Vec<(u8, u16, f64)>);

impl CycleWords {
    /// Takes a word; index 0 for a letter alone. A later one replaces an earlier one.
    pub(super) fn set(&mut self, letter: u8, index: u16, value: f64) {
        match self.0.iter_mut().find(|word| (word.0, word.1) == (letter, index)) {
            Some(word) => word.2 = value,
            None => self.0.push((letter, index, value)),
        }
    }

    /// The value of a word.
    pub(super) fn get(&self, letter: u8, index: u16) -> Option<f64> {
        self.0.iter().find(|word| (word.0, word.1) == (letter, index)).map(|word| word.2)
    }

    /// The value of a letter alone, or 0.
    fn value(&self, letter: u8) -> f64 {
        self.get(letter, 0).unwrap_or(0.0)
    }
}

/// Where and with what a cycle is carried out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct At {
    /// Position in the plane, mm.
    pub(super) point: Flat,
    /// Height of the surface, mm.
    pub(super) surface: f64,
    /// Height at which the tool is, mm.
    pub(super) height: f64,
    /// Turn of pockets and slots about the position (B1=), rad.
    pub(super) rotation_rad: f64,
    /// Radius of the tool, mm; 0 where it has none.
    pub(super) tool_radius_mm: f64,
    /// By how much above the old depth a peck begins again, mm (machine constant).
    pub(super) peck_clearance_mm: f64,
    /// Cutting width of pockets without I, per cent of the tool diameter (machine constant).
    pub(super) engagement_percent: f64,
    /// Whether the position of a slot is the center of the arc at its end, or its end itself.
    pub(super) slot_from_arc_center: bool,
}

/// Why a cycle cannot be carried out: what was found, and what to do.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CycleFault {
    pub(super) message: String,
    pub(super) help: &'static str,
}

fn fault(message: impl Into<String>, help: &'static str) -> CycleFault {
    CycleFault { message: message.into(), help }
}

/// The heights of a drilling cycle: first clearance above the surface (Y), depth (Z, below it negative), and how far above the first
/// clearance the tool retracts (B).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Heights {
    clearance: f64,
    bottom: f64,
    retract: f64,
}

impl Heights {
    fn of(words: &CycleWords, at: &At) -> Result<Heights, CycleFault> {
        let clearance = at.surface + words.value(b'Y');
        let bottom = at.surface + words.value(b'Z');
        let retract = clearance + words.value(b'B');
        if bottom >= clearance || retract < clearance {
            return Err(fault(
                "the depth (Z) is not below the first clearance (Y), or the retraction (B) is negative",
                "Z is negative into the workpiece, Y and B are distances above it",
            ));
        }
        Ok(Heights { clearance, bottom, retract })
    }

    /// To the hole at the height at which the tool is – not below the first clearance –, then down to that.
    fn approach(&self, at: &At, steps: &mut Vec<Step>) {
        if at.height < self.clearance {
            steps.push(Step::rapid_height(self.clearance));
        }
        steps.push(Step::rapid_plane(at.point));
        steps.push(Step::rapid_height(self.clearance));
    }
}

/// A dwell at the bottom.
fn dwell(words: &CycleWords, steps: &mut Vec<Step>) {
    let seconds = words.value(b'X');
    if seconds > 0.0 {
        steps.push(Step::Dwell(seconds));
    }
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

    /// Heights of the steps, rapids marked.
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
        // Pecks 10, 8, 6 and the rest of 1, each lifted by 1.
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
        // Without J the tool leaves the hole each time and comes back to 1 mm above the old depth.
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
