//! Canned cycles of Fanuc's milling controls, G73, G74, G76 and G81 to G89 (operator's manuals 16i/18i-MB and 30i-MB, "canned cycle for
//! drilling").
//!
//! The clearance of a peck cycle from the reached depth is a setting (parameters 5114 and 5115). G76 and G87 shift by Q with the spindle oriented, in
//! a direction that is a setting (parameter 5101 bits 4 and 5). In G88 the operator withdraws the tool; here it retracts at rapid after a program
//! stop.

use super::{Hole, HoleFault, HoleStep, chip_breaking, deep_hole, wrong};
use crate::exec::core::step::Turn;

/// The steps at a hole from R on, for G87 from the initial level on.
pub(in crate::exec::iso) fn steps(code: u16, hole: &Hole) -> Result<Vec<HoleStep>, HoleFault> {
    let &Hole { r, bottom, clear, .. } = hole;
    let out = HoleStep::Rapid(clear);
    let on = HoleStep::Spindle(Turn::Clockwise);
    let mut steps = Vec::new();
    match code {
        810 => steps.extend([HoleStep::Feed(bottom), out]),
        820 => {
            steps.push(HoleStep::Feed(bottom));
            steps.extend(dwell(hole));
            steps.push(out);
        }
        // Parameter 5103, bit 1 (QZA): without Q one stroke, or alarm PS0045.
        730 | 830 if hole.q.is_none_or(|q| q == 0.0) && hole.pecks.first.is_none() => {
            steps.extend([HoleStep::Feed(bottom), out]);
        }
        730 => steps = chip_breaking(hole)?,
        830 => steps = deep_hole(hole)?,
        740 | 840 | 842 | 843 => {
            // Pecks of rigid tapping (Q) have two modes, selected by a parameter of the control (5200 bit 5).
            if hole.q.is_some_and(|q| q != 0.0) {
                let message = "tapping in pecks (Q) is not supported";
                let help = "omit Q, or program the pecks one by one";
                return Err(HoleFault { is_unsupported: true, ..wrong(message, help) });
            }
            let sense = if matches!(code, 840 | 842) { Turn::Clockwise } else { Turn::CounterClockwise };
            steps.push(HoleStep::Feed(bottom));
            steps.extend(dwell(hole));
            steps.extend([HoleStep::Spindle(sense.reversed()), HoleStep::Feed(r), HoleStep::Spindle(sense), out]);
        }
        760 => {
            let aside = aside(hole)?;
            steps.push(HoleStep::Feed(bottom));
            steps.extend(dwell(hole));
            steps.extend([
                HoleStep::Spindle(Turn::Oriented),
                HoleStep::Aside(aside),
                out,
                HoleStep::Aside([0.0; 2]),
                on,
            ]);
        }
        850 => steps.extend([HoleStep::Feed(bottom), HoleStep::Feed(r), out]),
        860 => steps.extend([HoleStep::Feed(bottom), HoleStep::Spindle(Turn::Off), out, on]),
        870 => {
            let aside = aside(hole)?;
            let oriented = HoleStep::Spindle(Turn::Oriented);
            steps.extend([oriented, HoleStep::Aside(aside), HoleStep::Rapid(r), HoleStep::Aside([0.0; 2]), on]);
            steps.push(HoleStep::Feed(bottom));
            steps.extend(dwell(hole));
            steps.extend([oriented, HoleStep::Aside(aside), out, HoleStep::Aside([0.0; 2]), on]);
        }
        880 => {
            steps.push(HoleStep::Feed(bottom));
            steps.extend(dwell(hole));
            steps.extend([HoleStep::Spindle(Turn::Off), HoleStep::Stop, out, on]);
        }
        890 => {
            steps.push(HoleStep::Feed(bottom));
            steps.extend(dwell(hole));
            steps.extend([HoleStep::Feed(r), out]);
        }
        _ => {
            let message = "this cycle is not supported";
            return Err(HoleFault { is_unsupported: true, ..wrong(message, "program its motions one by one") });
        }
    }
    Ok(steps)
}

fn dwell(hole: &Hole) -> Option<HoleStep> {
    hole.dwell_s.filter(|seconds| *seconds > 0.0).map(HoleStep::Dwell)
}

/// The shift position of the oriented tool; no shift without Q.
fn aside(hole: &Hole) -> Result<[f64; 2], HoleFault> {
    match (hole.q, hole.aside) {
        (None | Some(0.0), _) => Ok([0.0; 2]),
        (Some(q), Some(direction)) if q > 0.0 => Ok(direction.map(|part| part * q)),
        (Some(q), Some(_)) => Err(wrong(format!("Q {q} is below 0"), "give Q without a sign")),
        (Some(_), None) => Err(wrong(
            "the direction in which the oriented tool shifts by Q is not known",
            "set control.orient_shift, for example \"+X\" (Fanuc parameter 5101 bits 4 and 5)",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::pattern::PeckWords;
    use super::*;
    use HoleStep::{Aside, Dwell, Feed, Rapid, Spindle};

    const HOLE: Hole = Hole {
        r: 2.0,
        bottom: -20.0,
        clear: 50.0,
        dwell_s: None,
        q: Some(8.0),
        pecks: PeckWords { first: None, less: None, last: None },
        clearance: 1.0,
        slack: 0.0,
        aside: Some([-1.0, 0.0]),
    };

    #[track_caller]
    fn check(code: u16, hole: Hole, wanted: &[HoleStep]) {
        assert_eq!(steps(code, &hole).unwrap(), wanted, "{code}");
    }

    #[test]
    fn cycles_move_as_the_reference_says() {
        check(810, HOLE, &[Feed(-20.0), Rapid(50.0)]);
        check(820, Hole { dwell_s: Some(0.2), ..HOLE }, &[Feed(-20.0), Dwell(0.2), Rapid(50.0)]);
        check(850, HOLE, &[Feed(-20.0), Feed(2.0), Rapid(50.0)]);
        check(860, HOLE, &[Feed(-20.0), Spindle(Turn::Off), Rapid(50.0), Spindle(Turn::Clockwise)]);
        check(890, Hole { dwell_s: Some(0.2), ..HOLE }, &[Feed(-20.0), Dwell(0.2), Feed(2.0), Rapid(50.0)]);
        check(730, HOLE, &[Feed(-6.0), Rapid(-5.0), Feed(-14.0), Rapid(-13.0), Feed(-20.0), Rapid(50.0)]);
        let pecks =
            [Feed(-6.0), Rapid(2.0), Rapid(-5.0), Feed(-14.0), Rapid(2.0), Rapid(-13.0), Feed(-20.0), Rapid(50.0)];
        check(830, HOLE, &pecks);
    }

    #[test]
    fn fine_boring_steps_aside_where_the_setting_says() {
        let oriented = Spindle(Turn::Oriented);
        let on = Spindle(Turn::Clockwise);
        let hole = Hole { q: Some(0.5), ..HOLE };
        check(760, hole, &[Feed(-20.0), oriented, Aside([-0.5, 0.0]), Rapid(50.0), Aside([0.0; 2]), on]);
        let back = Hole { r: -30.0, ..hole };
        let wanted = [
            oriented,
            Aside([-0.5, 0.0]),
            Rapid(-30.0),
            Aside([0.0; 2]),
            on,
            Feed(-20.0),
            oriented,
            Aside([-0.5, 0.0]),
            Rapid(50.0),
            Aside([0.0; 2]),
            on,
        ];
        check(870, back, &wanted);
        assert!(steps(760, &Hole { aside: None, ..hole }).is_err());
        assert!(steps(760, &Hole { aside: None, q: None, ..hole }).is_ok());
    }

    #[test]
    fn tapping_turns_back() {
        let (right, left) = (Spindle(Turn::Clockwise), Spindle(Turn::CounterClockwise));
        let hole = Hole { q: None, ..HOLE };
        check(840, hole, &[Feed(-20.0), left, Feed(2.0), right, Rapid(50.0)]);
        check(740, hole, &[Feed(-20.0), right, Feed(2.0), left, Rapid(50.0)]);
        assert!(steps(840, &HOLE).unwrap_err().is_unsupported);
    }
}
