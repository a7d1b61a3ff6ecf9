//! Positions of the holes of a canned cycle, the path between them, and the modal words.
//!
//! Fanuc (operator's manual, "canned cycle for drilling"): the tool moves to the hole at its current level, then to R; all words of the cycle are
//! modal until it ends. LinuxCNC (user manual, "canned cycles"): the tool first rises to R if it is below; words are modal as long as the code is
//! unchanged. Under G91, R is relative to the level at the start of the cycles and Z is relative to R.

use super::cycles::{Hole, HoleFault, HoleStep, fanuc, rs274};
use super::pattern::PeckWords;
use super::trip::Trip;
use crate::exec::core::step::{Place, Step, Turn};
use ncfix_dialect::Language;

/// Maximum number of steps of one block.
const MOST_STEPS: usize = 1_000_000;
/// Heights nearer to each other than this are equal, mm: an active length leaves a rounding error.
const SAME_MM: f64 = 1e-9;

/// A programmed number with its distance mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Level {
    /// mm
    pub(super) value: f64,
    /// `true` if G91 was active.
    pub(super) is_incremental: bool,
}

/// A block in a canned cycle: its words, mm and s, and other inputs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Call {
    /// The active cycle.
    pub(super) code: u16,
    /// Position of the tool.
    pub(super) from: Place,
    /// `true` if the position in the plane is an assumption: the tool then moves in any case.
    pub(super) is_lost: bool,
    /// R.
    pub(super) r: Option<f64>,
    /// Word of the tool axis.
    pub(super) bottom: Option<f64>,
    /// Q.
    pub(super) q: Option<f64>,
    /// I, J and K of a Haas.
    pub(super) pecks: PeckWords,
    /// P, s.
    pub(super) dwell_s: Option<f64>,
    /// K or L.
    pub(super) repeats: Option<u32>,
    /// `true` under G91.
    pub(super) incremental: bool,
    /// `true` for G99, `false` for G98.
    pub(super) to_r: bool,
    /// Rotation of the spindle.
    pub(super) spindle: Turn,
    /// Clearance of pecks, mm.
    pub(super) clearance: f64,
    /// Direction in the plane in which an oriented tool shifts.
    pub(super) aside: Option<[f64; 2]>,
    /// `true` if the control taps the holes itself: it makes the pecks of Q.
    pub(super) is_kept: bool,
}

/// The modal words.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Drill {
    /// The previous cycle.
    code: Option<u16>,
    /// The level at the start of the cycles.
    initial: Option<f64>,
    r: Option<Level>,
    bottom: Option<Level>,
    q: Option<f64>,
    /// The cycle whose block gave Q.
    q_code: u16,
    pecks: PeckWords,
    dwell_s: Option<f64>,
    /// `true` if the operator has withdrawn the tool from the last hole.
    is_drawn_out: bool,
}

impl Drill {
    /// Ends the cycles. In RS274/NGC a later cycle inherits P and Q.
    pub(super) fn end(&mut self, language: Language) {
        *self = match language {
            Language::Rs274 => Drill { code: None, initial: None, ..*self },
            _ => Drill::default(),
        };
    }

    /// Records the levels of a cycle that cannot run, for the blocks that repeat it.
    pub(super) fn keep_levels(&mut self, code: u16, r: Option<f64>, bottom: Option<f64>, is_incremental: bool) {
        let level = |value: f64| Level { value, is_incremental };
        self.code = Some(code);
        self.r = r.map(level).or(self.r);
        self.bottom = bottom.map(level).or(self.bottom);
    }

    /// Which of R and the bottom a block takes over from a block under another distance mode: G91 there, G90 here.
    pub(super) fn kept_from_steps(&self, call: &Call) -> [bool; 2] {
        let is_step = |level: Option<Level>, word: Option<f64>| {
            word.is_none() && !call.incremental && level.is_some_and(|level| level.is_incremental)
        };
        [is_step(self.r, call.r), is_step(self.bottom, call.bottom)]
    }

    /// Records that another motion has stated the tool position.
    pub(super) fn moved(&mut self) {
        self.is_drawn_out = false;
    }

    /// `true` if no word gives the depth of the pecks.
    pub(super) fn has_no_peck(&self) -> bool {
        self.q.is_none_or(|q| q == 0.0) && self.pecks.first.is_none()
    }

    /// Q of the cycle of the last block, if that block or one before it in the same cycle gave it, mm.
    pub(super) fn peck(&self) -> Option<f64> {
        self.q.filter(|_| Some(self.q_code) == self.code)
    }

    /// Depth of one peck in mm; `None` if the pecks have words of a Haas.
    pub(super) fn equal_pecks(&self) -> Option<f64> {
        self.q.filter(|q| *q > 0.0 && self.pecks == PeckWords::default())
    }

    /// P of the last block or of one before it, s.
    pub(super) fn dwell_s(&self) -> Option<f64> {
        self.dwell_s
    }

    /// `true` if the operator has determined the tool position along its axis.
    pub(super) fn is_drawn_out(&self) -> bool {
        self.is_drawn_out
    }

    /// Executes a block: appends its steps to `out`; `next` returns each hole from the previous one. Returns the final place.
    pub(super) fn run(
        &mut self,
        language: Language,
        call: &Call,
        next: impl FnMut([f64; 2]) -> Result<[f64; 2], HoleFault>,
        out: &mut Vec<Step>,
    ) -> Result<Place, HoleFault> {
        match language {
            Language::Rs274 => self.rs274(call, next, out),
            _ => self.fanuc(call, next, out),
        }
    }

    fn fanuc(
        &mut self,
        call: &Call,
        mut next: impl FnMut([f64; 2]) -> Result<[f64; 2], HoleFault>,
        out: &mut Vec<Step>,
    ) -> Result<Place, HoleFault> {
        let level = |value: f64| Level { value, is_incremental: call.incremental };
        let initial = *self.initial.get_or_insert(call.from.height);
        self.code = Some(call.code);
        self.r = call.r.map(level).or(self.r);
        self.bottom = call.bottom.map(level).or(self.bottom);
        if call.q.is_some() {
            (self.q, self.q_code) = (call.q, call.code);
        }
        self.pecks = call.pecks.or(self.pecks);
        let repeats = call.repeats.unwrap_or(1);
        if repeats == 0 {
            // The words are stored and nothing is drilled.
            self.dwell_s = call.dwell_s.or(self.dwell_s);
            return Ok(call.from);
        }
        self.dwell_s = call.dwell_s.or(self.dwell_s);
        let (Some(r), Some(bottom)) = (self.r, self.bottom) else {
            let missing = if self.r.is_none() { "R" } else { "the bottom of the hole" };
            // The manual of Haas calls R optional, but states no level for a cycle without it.
            let help = "program R and the depth: no manual states where the cycle would begin or end without them";
            return Err(fault(format!("{missing} was not programmed"), help));
        };
        // Q is data of the hole, which stay until G80 (Fanuc operator's manual, canned cycle).
        let is_tap = matches!(call.code, 740 | 840 | 842 | 843);
        if is_tap && self.q_code != call.code && self.q.is_some_and(|q| q != 0.0) {
            let message = "Q of an earlier cycle is still in force, so the control may tap in pecks".into();
            let help = "write G80 in a block before this cycle, or Q0 in its block";
            return Err(HoleFault { is_unsupported: true, ..fault(message, help) });
        }
        let r = r.value + if r.is_incremental { initial } else { 0.0 };
        let bottom = bottom.value + if bottom.is_incremental { r } else { 0.0 };
        let is_back_boring = call.code == 870;
        if is_back_boring && call.to_r {
            return Err(fault(
                "it is programmed under G99".into(),
                "program G98: back boring always returns to the initial level",
            ));
        }
        let hole = Hole {
            r,
            bottom,
            clear: if call.to_r { r } else { initial },
            dwell_s: self.dwell_s,
            q: self.q.filter(|_| !(call.is_kept && self.q_code == call.code)),
            pecks: self.pecks,
            clearance: call.clearance,
            slack: 1e-6,
            aside: call.aside,
        };
        let steps = fanuc::steps(call.code, &hole)?;
        limit(repeats, &steps)?;
        let mut trip = Trip { here: call.from, is_lost: call.is_lost, out };
        for _ in 0..repeats {
            let plane = next(trip.here.plane)?;
            trip.approach(Place { plane, ..trip.here });
            if !is_back_boring {
                trip.rapid(Place { plane, height: r });
            }
            trip.hole(plane, &steps);
        }
        Ok(trip.here)
    }

    fn rs274(
        &mut self,
        call: &Call,
        mut next: impl FnMut([f64; 2]) -> Result<[f64; 2], HoleFault>,
        out: &mut Vec<Step>,
    ) -> Result<Place, HoleFault> {
        let code = call.code;
        let is_same = self.code == Some(code);
        let level = |value: f64| Level { value, is_incremental: false };
        let sticky = |word: Option<f64>, kept: Option<Level>, what: &str| {
            let kept = kept.filter(|_| is_same).map(|kept| kept.value);
            word.or(kept).ok_or_else(|| fault(format!("it starts without {what}"), "program it in this block"))
        };
        let r_word = sticky(call.r, self.r, "R")?;
        let bottom_word = sticky(call.bottom, self.bottom, "the depth of the hole")?;
        let dwell_s = call.dwell_s.or(self.dwell_s.filter(|_| is_same || !rs274::WITH_DWELL.contains(&code)));
        if dwell_s.is_none() && rs274::WITH_DWELL.contains(&code) {
            return Err(fault("it starts without P".into(), "program the dwell in this block"));
        }
        let q = call.q.or(self.q.filter(|_| is_same));
        if q.is_none() && rs274::WITH_PECK.contains(&code) {
            return Err(fault("it starts without Q".into(), "program the depth of one peck in this block"));
        }
        let repeats = call.repeats.unwrap_or(1);
        if repeats == 0 {
            return Err(fault("L0".into(), "omit L, or the block"));
        }
        let initial = *self.initial.get_or_insert(call.from.height);
        let (r, bottom) =
            if call.incremental { (r_word + initial, r_word + initial + bottom_word) } else { (r_word, bottom_word) };
        if r < bottom {
            return Err(fault(format!("R {r} is below the bottom of the hole {bottom}"), "correct R or Z"));
        }
        let mut trip = Trip { here: call.from, is_lost: call.is_lost || self.is_drawn_out, out };
        let mut above = call.from.height;
        let mut old = initial;
        if old < r {
            let up = Place { height: r, ..call.from };
            if self.is_drawn_out {
                trip.state(up)
            } else {
                trip.rapid(up)
            }
            (old, above) = (r, r);
        }
        let clear = if call.to_r { r } else { old };
        let hole = Hole { r, bottom, clear, dwell_s, q, clearance: call.clearance, ..Hole::default() };
        let steps = rs274::steps(code, &hole, call.spindle)?;
        limit(repeats, &steps)?;
        let mut plane = call.from.plane;
        for hole in 0..repeats {
            plane = next(plane)?;
            let height = if hole == 0 && above > r + SAME_MM { above } else { clear };
            trip.approach(Place { plane, height });
            if height > r {
                trip.rapid(Place { plane, height: r });
            }
            trip.hole(plane, &steps);
        }
        self.is_drawn_out = matches!(steps.last(), Some(HoleStep::DrawnOut(_)));
        self.code = Some(code);
        self.r = Some(level(r_word));
        self.bottom = Some(level(bottom_word));
        self.dwell_s = dwell_s.or(self.dwell_s);
        self.q = q.or(self.q);
        Ok(trip.here)
    }
}

fn fault(message: String, help: &'static str) -> HoleFault {
    HoleFault { message, help, is_unsupported: false }
}

fn limit(repeats: u32, steps: &[HoleStep]) -> Result<(), HoleFault> {
    let count = u64::from(repeats).saturating_mul(steps.len() as u64 + 2);
    if count > MOST_STEPS as u64 {
        return Err(fault(format!("{repeats} repetitions of a cycle of {} steps", steps.len()), "correct the count"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CALL: Call = Call {
        code: 810,
        from: Place { plane: [0.0, 0.0], height: 50.0 },
        is_lost: false,
        r: Some(2.0),
        bottom: Some(-10.0),
        q: None,
        pecks: PeckWords { first: None, less: None, last: None },
        dwell_s: None,
        repeats: None,
        incremental: false,
        to_r: true,
        spindle: Turn::Clockwise,
        clearance: 1.0,
        aside: None,
        is_kept: false,
    };
    const WORDLESS: Call = Call { r: None, bottom: None, ..CALL };

    /// Holes at X10 and X20 from Z2 to Z-10, approached from Z50.
    fn two_holes() -> [Step; 7] {
        [
            Step::rapid(at(10.0, 0.0, 50.0)),
            Step::rapid(at(10.0, 0.0, 2.0)),
            Step::line(at(10.0, 0.0, -10.0)),
            Step::rapid(at(10.0, 0.0, 2.0)),
            Step::rapid(at(20.0, 0.0, 2.0)),
            Step::line(at(20.0, 0.0, -10.0)),
            Step::rapid(at(20.0, 0.0, 2.0)),
        ]
    }

    fn at(x: f64, y: f64, z: f64) -> Place {
        Place { plane: [x, y], height: z }
    }

    fn to(x: f64, y: f64) -> impl FnMut([f64; 2]) -> Result<[f64; 2], HoleFault> {
        move |_| Ok([x, y])
    }

    #[test]
    fn fanuc_words_stay_in_force_and_the_initial_level_is_that_of_the_first_hole() {
        let (mut drill, mut out) = (Drill::default(), Vec::new());
        let here = drill.run(Language::Fanuc, &CALL, to(10.0, 0.0), &mut out).unwrap();
        let here = drill.run(Language::Fanuc, &Call { from: here, ..WORDLESS }, to(20.0, 0.0), &mut out).unwrap();
        let last = Call { from: here, to_r: false, ..WORDLESS };
        let here = drill.run(Language::Fanuc, &last, to(30.0, 0.0), &mut out).unwrap();
        assert_eq!(here, at(30.0, 0.0, 50.0));
        let third =
            [Step::rapid(at(30.0, 0.0, 2.0)), Step::line(at(30.0, 0.0, -10.0)), Step::rapid(at(30.0, 0.0, 50.0))];
        assert_eq!(out, [&two_holes()[..], &third].concat());
        drill.end(Language::Fanuc);
        assert!(drill.run(Language::Fanuc, &Call { from: here, ..WORDLESS }, to(0.0, 0.0), &mut out).is_err());
    }

    #[test]
    fn fanuc_counts_r_from_the_initial_level_and_z_from_r_behind_g91() {
        let (mut drill, mut out) = (Drill::default(), Vec::new());
        let call = Call { r: Some(-48.0), bottom: Some(-12.0), repeats: Some(2), incremental: true, ..CALL };
        let further = |plane: [f64; 2]| Ok([plane[0] + 10.0, plane[1]]);
        drill.run(Language::Fanuc, &call, further, &mut out).unwrap();
        assert_eq!(out, two_holes());
        // K0 only stores the words.
        let (mut drill, mut out) = (Drill::default(), Vec::new());
        let noted = drill.run(Language::Fanuc, &Call { repeats: Some(0), ..CALL }, to(9.0, 9.0), &mut out).unwrap();
        assert_eq!((noted, out.len()), (CALL.from, 0));
        drill.run(Language::Fanuc, &WORDLESS, to(10.0, 0.0), &mut out).unwrap();
        assert_eq!(out.len(), 4);
    }

    #[test]
    fn the_pecks_of_a_tap_stay_its_own() {
        let tap = |code: u16, q: Option<f64>| Call { code, q, is_kept: true, ..CALL };
        let (mut drill, mut out) = (Drill::default(), Vec::new());
        drill.run(Language::Fanuc, &tap(840, Some(2.0)), to(10.0, 0.0), &mut out).unwrap();
        // The next hole has no Q in its block.
        drill.run(Language::Fanuc, &tap(840, None), to(20.0, 0.0), &mut out).unwrap();
        assert_eq!(drill.peck(), Some(2.0));
        // Another cycle inherits it: its meaning there is not known.
        let found = drill.run(Language::Fanuc, &tap(740, None), to(30.0, 0.0), &mut out).unwrap_err();
        assert!(found.is_unsupported && found.message.contains("earlier cycle"), "{}", found.message);
    }

    #[test]
    fn linuxcnc_goes_up_to_r_first_and_returns_to_what_is_higher() {
        let (mut drill, mut out) = (Drill::default(), Vec::new());
        let call = Call { from: at(1.0, 0.0, 1.0), r: Some(3.0), bottom: Some(-5.0), to_r: false, ..CALL };
        let here = drill.run(Language::Rs274, &call, to(5.0, 0.0), &mut out).unwrap();
        let wanted = [
            Step::rapid(at(1.0, 0.0, 3.0)),
            Step::rapid(at(5.0, 0.0, 3.0)),
            Step::line(at(5.0, 0.0, -5.0)),
            Step::rapid(at(5.0, 0.0, 3.0)),
        ];
        assert_eq!(out, wanted);
        // Another code needs its words again; the same code does not.
        assert!(drill.run(Language::Rs274, &Call { code: 850, ..WORDLESS }, to(0.0, 0.0), &mut Vec::new()).is_err());
        out.clear();
        drill.run(Language::Rs274, &Call { from: here, ..WORDLESS }, to(6.0, 0.0), &mut out).unwrap();
        assert_eq!(
            out,
            [Step::rapid(at(6.0, 0.0, 3.0)), Step::line(at(6.0, 0.0, -5.0)), Step::rapid(at(6.0, 0.0, 3.0))]
        );
    }

    #[test]
    fn linuxcnc_goes_back_to_the_old_level_on_its_way_to_the_next_hole() {
        let (mut drill, mut out) = (Drill::default(), Vec::new());
        let here = drill.run(Language::Rs274, &CALL, to(10.0, 0.0), &mut out).unwrap();
        out.clear();
        drill.run(Language::Rs274, &Call { from: here, to_r: false, ..WORDLESS }, to(30.0, 0.0), &mut out).unwrap();
        let wanted = [
            Step::rapid(at(30.0, 0.0, 50.0)),
            Step::rapid(at(30.0, 0.0, 2.0)),
            Step::line(at(30.0, 0.0, -10.0)),
            Step::rapid(at(30.0, 0.0, 50.0)),
        ];
        assert_eq!(out, wanted);
    }

    #[test]
    fn counts_have_an_end() {
        let (mut drill, mut out) = (Drill::default(), Vec::new());
        let call = Call { repeats: Some(u32::MAX), ..CALL };
        assert!(drill.run(Language::Fanuc, &call, to(0.0, 0.0), &mut out).is_err());
        assert!(drill.run(Language::Rs274, &call, to(0.0, 0.0), &mut out).is_err());
        assert!(drill.run(Language::Rs274, &Call { repeats: Some(0), ..CALL }, to(0.0, 0.0), &mut out).is_err());
    }
}
