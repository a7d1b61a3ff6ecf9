//! Canned cycles of RS274/NGC, G73, G74 and G81 to G89, as in LinuxCNC (its user manual, "G81–G89", and the output of its interpreter).
//!
//! A peck cycle keeps 0.010 inch from the reached depth. G74, G84, G86 and G88 need a rotating spindle and restore its rotation. In G88 the operator
//! withdraws the tool, which is assumed done. G85 returns to R with feed, then continues at rapid; G89 returns with feed all the way.

use super::{Hole, HoleFault, HoleStep, chip_breaking, deep_hole, wrong};
use crate::exec::core::step::Turn;

/// Retraction of G73, and clearance of G83, mm.
pub(in crate::exec::iso) const CLEARANCE_MM: f64 = 0.254;

/// Cycles that need P in their first block.
pub(in crate::exec::iso) const WITH_DWELL: [u16; 4] = [820, 860, 880, 890];
/// Cycles that need Q in their first block.
pub(in crate::exec::iso) const WITH_PECK: [u16; 2] = [730, 830];

/// The steps at a hole from R on; `spindle` is the spindle rotation.
pub(in crate::exec::iso) fn steps(code: u16, hole: &Hole, spindle: Turn) -> Result<Vec<HoleStep>, HoleFault> {
    let &Hole { r, bottom, clear, .. } = hole;
    let dwell = HoleStep::Dwell(hole.dwell_s.unwrap_or(0.0));
    let again = HoleStep::Spindle(spindle);
    let off = HoleStep::Spindle(Turn::Off);
    Ok(match code {
        810 => vec![HoleStep::Feed(bottom), HoleStep::Rapid(clear)],
        820 => vec![HoleStep::Feed(bottom), dwell, HoleStep::Rapid(clear)],
        730 => chip_breaking(hole)?,
        830 => deep_hole(hole)?,
        740 | 840 => {
            let wanted = if code == 840 { Turn::Clockwise } else { Turn::CounterClockwise };
            if spindle != wanted {
                let message =
                    format!("it taps after M{}, but the spindle does not turn in this direction", wanted.m_code(0));
                return Err(wrong(message, "start the spindle before the cycle"));
            }
            let back = HoleStep::Spindle(spindle.reversed());
            vec![HoleStep::Feed(bottom), off, back, dwell, HoleStep::Feed(clear), off, again]
        }
        850 => vec![HoleStep::Feed(bottom), HoleStep::Feed(r), HoleStep::Rapid(clear)],
        860 => {
            turns(spindle)?;
            vec![HoleStep::Feed(bottom), dwell, off, HoleStep::Rapid(clear), again]
        }
        880 => {
            turns(spindle)?;
            vec![HoleStep::Feed(bottom), dwell, off, HoleStep::Stop, again, HoleStep::DrawnOut(clear)]
        }
        890 => vec![HoleStep::Feed(bottom), dwell, HoleStep::Feed(clear)],
        _ => {
            let message = "this cycle is not supported";
            return Err(HoleFault { is_unsupported: true, ..wrong(message, "program its motions one by one") });
        }
    })
}

fn turns(spindle: Turn) -> Result<(), HoleFault> {
    match spindle {
        Turn::Clockwise | Turn::CounterClockwise => Ok(()),
        _ => Err(wrong("the spindle does not turn", "start the spindle before the cycle")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::pattern::PeckWords;
    use super::*;
    use HoleStep::{DrawnOut, Dwell, Feed, Rapid, Spindle, Stop};

    const HOLE: Hole = Hole {
        r: 2.0,
        bottom: -20.0,
        clear: 50.0,
        dwell_s: Some(0.5),
        q: Some(8.0),
        pecks: PeckWords { first: None, less: None, last: None },
        clearance: CLEARANCE_MM,
        slack: 0.0,
        aside: None,
    };

    #[track_caller]
    fn check(code: u16, spindle: Turn, wanted: &[HoleStep]) {
        assert_eq!(steps(code, &HOLE, spindle).unwrap(), wanted, "{code}");
    }

    #[test]
    fn cycles_move_as_the_manual_says() {
        let on = Turn::Clockwise;
        check(810, Turn::Off, &[Feed(-20.0), Rapid(50.0)]);
        check(820, Turn::Off, &[Feed(-20.0), Dwell(0.5), Rapid(50.0)]);
        check(
            830,
            on,
            &[
                Feed(-6.0),
                Rapid(2.0),
                Rapid(-6.0 + 0.254),
                Feed(-14.0),
                Rapid(2.0),
                Rapid(-14.0 + 0.254),
                Feed(-20.0),
                Rapid(50.0),
            ],
        );
        check(730, on, &[Feed(-6.0), Rapid(-6.0 + 0.254), Feed(-14.0), Rapid(-14.0 + 0.254), Feed(-20.0), Rapid(50.0)]);
        check(850, on, &[Feed(-20.0), Feed(2.0), Rapid(50.0)]);
        check(860, on, &[Feed(-20.0), Dwell(0.5), Spindle(Turn::Off), Rapid(50.0), Spindle(on)]);
        check(880, on, &[Feed(-20.0), Dwell(0.5), Spindle(Turn::Off), Stop, Spindle(on), DrawnOut(50.0)]);
        check(890, on, &[Feed(-20.0), Dwell(0.5), Feed(50.0)]);
    }

    #[test]
    fn tapping_turns_back_and_needs_the_right_sense() {
        let (right, left) = (Spindle(Turn::Clockwise), Spindle(Turn::CounterClockwise));
        let off = Spindle(Turn::Off);
        check(840, Turn::Clockwise, &[Feed(-20.0), off, left, Dwell(0.5), Feed(50.0), off, right]);
        check(740, Turn::CounterClockwise, &[Feed(-20.0), off, right, Dwell(0.5), Feed(50.0), off, left]);
        assert!(steps(840, &HOLE, Turn::CounterClockwise).is_err());
        assert!(steps(740, &HOLE, Turn::Off).is_err());
        assert!(steps(860, &HOLE, Turn::Off).is_err());
        assert!(steps(870, &HOLE, Turn::Clockwise).unwrap_err().is_unsupported);
    }
}
