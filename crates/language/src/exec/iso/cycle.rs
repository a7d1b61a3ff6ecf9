//! A block in a canned cycle: collects its words, gets the steps from [`super::drill`], and emits them.

use super::channel::Cycles;
use super::feed;
use super::kept_cycle;
use super::measure;
use super::modal::Modal;
use super::modes;
use super::one_axis;
use super::spline;
use super::step;
use super::tapping;
use super::target;
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::settings::RunSettings;
use crate::exec::core::standing::InForce;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use std::sync::Arc as Shared;

use super::channel::Channel;
use super::codes::{G80, Group, name_of};
use super::cycles::{HoleFault, rs274};
use super::drill::Call;
use super::gathered::Gathered;
use super::measure::whole;
use super::pattern::{Pattern, PeckWords};
use super::polar;
use super::step::Step;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::step::{Place, Step as CycleStep, Turn};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Plane, Vector};
use ncfix_base::source::Span;
use ncfix_machine::snc::{Dwell, FeedUnit, Kind, MotionMode, Word, WordValue};

/// A rapid step along the tool that is shorter belongs to the motion to the hole, mm: corrected levels of two holes differ by it.
const SAME_LEVEL_MM: f64 = 0.02;

/// `true` if a code in tenths is a canned cycle for holes.
pub(super) fn is_cycle(code: u16, is_rs274: bool) -> bool {
    match code {
        760 => !is_rs274,
        730 | 740 | 842 | 843 => true,
        _ => code.is_multiple_of(10) && (810..=890).contains(&code),
    }
}

fn is_tapping(code: u16) -> bool {
    matches!(code, 740 | 840 | 842 | 843)
}

/// Records the motion mode that becomes active.
pub(super) fn note_motion(channel: &mut Channel<'_>, code: u16) {
    let before = std::mem::replace(&mut channel.modal.modes.motion, code);
    if before == code || is_cycle(code, channel.is_rs274()) {
        return;
    }
    spline::drop_curve(&mut channel.special, code);
    modes::leave_exact_stops(channel, false);
    channel.cycles.line = code;
    channel.cycles.is_rigid = false;
    channel.cycles.drill.end(channel.language);
    if code != G80 {
        channel.cycles.drill.moved();
    }
}

/// Executes a block in a cycle.
pub(super) fn cycle(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    cycle_at(channel, gathered, code, None)
}

/// Executes a block in a cycle, at the holes of a pattern if there is one.
pub(super) fn cycle_at(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    code: u16,
    pattern: Option<Pattern>,
) -> Result<(), Fault> {
    let span = gathered.code_span(if channel.is_rs274() { Group::Motion } else { Group::Cycle });
    if pattern.is_none() {
        no_faster_return(channel, gathered, code)?;
    }
    check_cycle(channel, gathered, code, span)?;
    let [abscissa, ordinate, applicate] = channel.modal.modes.plane.axes();
    let here = target::here(&channel.modal, &channel.standing);
    let bottom = word_of(channel, gathered, applicate)?;
    let mut words = [word_of(channel, gathered, abscissa)?, word_of(channel, gathered, ordinate)?];
    if channel.special.polar.is_some() {
        // The second word is an angle.
        words[1] = measure::angle(
            channel.settings.machine,
            channel.language,
            &mut channel.warned,
            gathered,
            ordinate.letter(),
        )?;
    }
    let named: AxisSet = gathered.axes.intersection([abscissa, ordinate].into_iter().collect());
    if let Some((others, values)) = one_axis::other_axes(channel, gathered, named)? {
        for (axis, word) in [abscissa, ordinate].into_iter().zip(&mut words).filter(|(axis, _)| others.contains(*axis))
        {
            *word = Some(values[axis]);
        }
    }
    let polar_words = [
        measure::length(channel, gathered, b'@')?,
        measure::angle(channel.settings.machine, channel.language, &mut channel.warned, gathered, b'^')?,
    ];
    let is_polar = polar_words.iter().any(Option::is_some);
    let incremental = channel.modal.modes.incremental;
    for (axis, word) in [abscissa, ordinate].into_iter().zip(words) {
        if incremental || word.is_none() || pattern.is_some() {
            target::check_stated(channel.settings.strict, &channel.modal, axis, gathered.span)?;
        }
    }
    if let Err(found) = target::check_stated(channel.settings.strict, &channel.modal, applicate, gathered.span) {
        // The block states the place of its hole: the next hole has no fault of its own.
        if !incremental && !is_polar && pattern.is_none() && channel.special.polar.is_none() {
            let mut place = here;
            for (axis, word) in [abscissa, ordinate].into_iter().zip(words) {
                place[axis] = word.unwrap_or(place[axis]);
            }
            let setup = Shared::clone(&channel.standing.setup);
            if let Ok(command) = step::reach(&channel.modal, &setup, named, &place, span) {
                channel.modal.position.command = command;
                channel.modal.position.known = channel.modal.position.known.union(named);
            }
        }
        return Err(found);
    }
    let mut others = gathered.axes.difference([abscissa, ordinate, applicate].into_iter().collect());
    let mut end = here;
    for axis in others.iter() {
        let value = target::axis_value(channel, gathered, axis)?;
        end[axis] = match incremental {
            true => value + here[axis],
            false => target::absolute(channel.settings.machine, &channel.modal, gathered, axis, value, here[axis])?,
        };
    }
    let from = Place { plane: [here[abscissa], here[ordinate]], height: here[applicate] };
    let call = match call(channel, gathered, code, bottom, from, pattern.as_ref()) {
        Ok(call) => call,
        Err(found) => {
            // The next holes of the cycle have these levels: they are not faults of their own.
            let r = measure::length(channel, gathered, b'R')?;
            channel.cycles.drill.keep_levels(code, r, bottom, incremental);
            return Err(found);
        }
    };
    warn_of_steps(channel, gathered, &call, applicate);
    let mut polar = channel.special.polar;
    let mut hole = 0;
    let mut of_pattern = || {
        hole += 1;
        pattern.as_ref().map(|pattern| pattern.hole([here[abscissa], here[ordinate]], hole - 1))
    };
    let next = |from: [f64; 2]| match &mut polar {
        _ if pattern.is_some() => Ok(of_pattern().unwrap_or(from)),
        Some(polar) => Ok(polar.target(from, words[0], words[1], incremental)),
        None if is_polar => polar::rs274(from, polar_words[0], polar_words[1], incremental).ok_or_else(|| HoleFault {
            message: "polar words at the origin, where the direction is undefined".into(),
            help: "give both @ and ^ with G90",
            is_unsupported: false,
        }),
        None => Ok([0, 1].map(|k: usize| match words.get(k).copied().flatten() {
            Some(word) if incremental => from[k] + word,
            Some(word) => word,
            None => from[k],
        })),
    };
    let was_drawn_out = channel.cycles.drill.is_drawn_out();
    let mut actions = Vec::new();
    let done = channel.cycles.drill.run(channel.language, &call, next, &mut actions);
    if channel.special.polar.is_some() {
        channel.special.polar = polar;
    }
    done.map_err(|found| {
        let code_of = if found.is_unsupported { Code::NOT_SUPPORTED } else { Code::BAD_WORD_VALUE };
        fault(code_of, span, format!("{}: {}", name_of(code), found.message), found.help)
    })?;
    if actions.is_empty() {
        return Ok(());
    }
    let is_kept = is_tapping(code) && is_left_to_control(channel, code);
    let begins = gathered.code(Group::Cycle) == Some(code) && matches!(code, 730 | 830);
    if begins && channel.language == Language::Fanuc && channel.cycles.drill.has_no_peck() {
        let message = format!("{} without Q drills in one stroke", name_of(code));
        let help = "program Q, the depth of one peck (parameter 5103, bit 1: one stroke or alarm PS0045)";
        channel.outlet.warnings.push(fault(Code::UNUSUAL_MOTION, gathered.span, message, help));
    }
    let holes = call.repeats.unwrap_or(1) as usize;
    if incremental && holes > 1 && others.iter().any(|axis| end[axis] != here[axis]) {
        let message = format!("{} repeats with an incremental move of another axis", name_of(code));
        let help = "write a block for each hole: ncfix does not repeat the move of the other axis";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    let may_stay = !is_tapping(code) || tapping::may_stay(channel, gathered);
    let kept = ((channel.settings.keeps_cycles || is_kept && channel.settings.keeps_taps) && may_stay)
        .then(|| kept_cycle::of(channel, &call, [here[abscissa], here[ordinate]], holes, &actions))
        .flatten();
    let writes_cycle = kept.is_some() && channel.settings.strict;
    if is_kept {
        tapping::check(channel, gathered, (code, kept.is_some()), span)?;
    } else if kept.is_none()
        && is_tapping(code)
        && modes::code_of_motion(channel.language, &channel.cycles, gathered) == Some(code)
    {
        let message = "tapping becomes feed moves with a spindle reversal between them";
        let help = "use a compensating tapping chuck; keep the override at 100 %";
        channel.outlet.warnings.push(fault(Code::TAPPING_BY_FEED, span, message, help));
    }
    // Grbl and its relatives always follow the exact path, and have no G64 to end it.
    if !writes_cycle && channel.settings.machine.control.firmware.is_none() {
        stop_exactly(channel.language, &channel.modal, &mut channel.cycles, &mut channel.outlet);
    }
    // Other axes move with the positioning in the plane, never with a motion along the tool: a table that turns while the drill descends breaks it.
    let is_positioned = matches!(actions.first(), Some(CycleStep::Rapid { plane: Some(plane), height })
        if *plane != [end[abscissa], end[ordinate]] && height.is_none_or(|height| height == end[applicate]));
    let turns_first = !others.is_empty() && !is_positioned;
    if turns_first {
        let (named, span) = (std::mem::take(&mut others), gathered.span);
        step::step(channel, Step { rapid: true, end, named, feed_named: false, motion_mode: MotionMode::Path, span })?;
    }
    let mut is_leveled = false;
    let mut starts = kept.iter().flat_map(|kept| kept.starts.iter().copied()).peekable();
    let mut feed_named = gathered.has(b'F');
    let mut is_brought = was_drawn_out;
    let mut tapped = 0;
    // All holes of a block have the same steps.
    let of_one_tap = actions.iter().filter(|step| is_in_hole(step)).count() / holes.max(1);
    for (place, &action) in actions.iter().enumerate() {
        let is_start = starts.next_if_eq(&place).is_some();
        if is_start && place > 0 {
            kept_cycle::end(channel);
        }
        let before = place.checked_sub(1).and_then(|before| actions.get(before));
        let follows_rapid = before.is_none_or(|before| matches!(before, CycleStep::Rapid { .. }));
        let is_level = follows_rapid
            && matches!(action, CycleStep::Rapid { plane: Some(plane), height: Some(height) }
            if plane == [end[abscissa], end[ordinate]] && (height - end[applicate]).abs() < SAME_LEVEL_MM);
        if (place > 0 || turns_first) && !is_level && !std::mem::take(&mut is_leveled) {
            channel.outlet.begin_line();
        }
        is_leveled = is_level && place == 0;
        if let Some(kept) = kept.as_ref().filter(|_| is_start) {
            kept_cycle::begin(channel, kept);
        }
        if place < tapped {
            continue;
        }
        if is_kept && kept.is_none() && is_in_hole(&action) && !matches!(action, CycleStep::Brought(_)) {
            let steps = actions.get(place..).unwrap_or_default();
            // A tap that ends at R has no rapid move before the next one at the same place.
            let count = steps.iter().take(of_one_tap).take_while(|step| is_in_hole(step)).count();
            tapped = place + count;
            let peck = channel.cycles.drill.peck();
            let hole = tapping::TappedHole { code, level: end, peck, steps: steps.get(..count).unwrap_or_default() };
            tapping::tap(channel, &hole, gathered.span)?;
            feed_named = false;
            continue;
        }
        let (rapid, to) = match action {
            CycleStep::Rapid { plane, height } | CycleStep::Line { plane, height, .. } => {
                let plane = plane.unwrap_or([end[abscissa], end[ordinate]]);
                let to = Place { plane, height: height.unwrap_or(end[applicate]) };
                (matches!(action, CycleStep::Rapid { .. }), to)
            }
            CycleStep::Brought(to) => {
                end[applicate] = to.height;
                brought(
                    &channel.settings,
                    &channel.standing,
                    &mut channel.modal,
                    &mut channel.outlet,
                    applicate,
                    &end,
                    gathered.span,
                )?;
                is_brought = true;
                continue;
            }
            other => {
                aside(&mut channel.modal, &mut channel.outlet, other);
                continue;
            }
        };
        let mut named = std::mem::take(&mut others);
        for (axis, value) in [(abscissa, to.plane[0]), (ordinate, to.plane[1]), (applicate, to.height)] {
            let is_asked = place == 0 && axis != applicate && gathered.axes.contains(axis);
            if value != end[axis] || is_asked || is_brought {
                named.insert(axis);
            }
            end[axis] = value;
        }
        is_brought = false;
        let is_named = std::mem::take(&mut feed_named);
        let span = gathered.span;
        step::step(channel, Step { rapid, end, named, feed_named: is_named, motion_mode: MotionMode::Path, span })?;
    }
    if kept.is_some() {
        kept_cycle::end(channel);
    }
    Ok(())
}

/// `true` for a step of a hole other than a rapid move.
fn is_in_hole(step: &CycleStep) -> bool {
    !matches!(step, CycleStep::Rapid { .. })
}

/// Warns if the levels of a hole are those of a block under G91 and this one is under G90.
fn warn_of_steps(channel: &mut Channel<'_>, gathered: &Gathered, call: &Call, applicate: Axis) {
    let [has_r, has_bottom] = channel.cycles.drill.kept_from_steps(call);
    let drills = call.repeats != Some(0);
    if channel.is_rs274() || !channel.settings.strict || !drills || !(has_r || has_bottom) {
        return;
    }
    if std::mem::replace(&mut channel.cycles.is_step_named, true) {
        return;
    }
    let words = match (has_r, has_bottom) {
        (true, true) => format!("R and {applicate}"),
        (true, false) => "R".to_owned(),
        (false, _) => applicate.to_string(),
    };
    let message = format!(
        "{words} of {} were programmed under G91, and this hole is under G90: ncfix keeps the levels that they had",
        name_of(call.code)
    );
    let help = "write R and the depth in the first block after G90: no manual states whether the control keeps the levels or reads these values as positions";
    channel.outlet.warnings.push(fault(Code::STEPS_UNDER_G90, gathered.span, message, help));
}

/// Handles an axis that the operator has moved: its position is an assumption.
fn brought(
    settings: &RunSettings<'_>,
    standing: &InForce,
    modal: &mut Modal,
    outlet: &mut MotionSink<'_>,
    axis: Axis,
    place: &AxisVector,
    span: Span,
) -> Result<(), Fault> {
    let setup = Shared::clone(&standing.setup);
    let named: AxisSet = [axis].into_iter().collect();
    modal.position.command = step::reach(modal, &setup, named, place, span)?;
    if settings.strict {
        let lost = modal.forget(named);
        outlet.push(Kind::Lost(lost));
    }
    Ok(())
}

/// Emits an action of a cycle other than motion.
fn aside(modal: &mut Modal, outlet: &mut MotionSink<'_>, action: CycleStep) {
    let word = |number: u16| Word { letter: b'M', extension: None, value: WordValue::Number(f64::from(number)) };
    let before = modal.spindle;
    match action {
        CycleStep::Dwell(seconds) => outlet.push(Kind::Dwell(Dwell::Seconds(seconds))),
        CycleStep::Spindle(Turn::Off) => outlet.push(Kind::After(vec![word(5)])),
        CycleStep::Spindle(turn) => outlet.push(Kind::Before(vec![word(turn.m_code(u16::from(before)))])),
        CycleStep::Stop => outlet.push(Kind::After(vec![word(0)])),
        CycleStep::Rapid { .. } | CycleStep::Line { .. } | CycleStep::Arc { .. } | CycleStep::Brought(_) => {}
    }
}

/// The words of a block and the other inputs of its cycle.
fn call(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    code: u16,
    bottom: Option<f64>,
    from: Place,
    pattern: Option<&Pattern>,
) -> Result<Call, Fault> {
    let is_rs274 = channel.is_rs274();
    let [abscissa, ordinate, applicate] = channel.modal.modes.plane.axes();
    let is_haas = channel.settings.machine.control.iso.is_haas();
    let dwell_s = feed::dwell_of_p(channel.settings.machine, channel.language, gathered, &name_of(code))?;
    if let Some(seconds) = dwell_s.filter(|seconds| *seconds < 0.0) {
        let message = format!("a dwell of {seconds} s");
        return Err(bad_value(gathered.span_of(b'P'), message, "write P without a sign"));
    }
    if !is_rs274 && !is_haas && gathered.has(b'K') {
        check_count(channel, gathered, code)?;
    }
    let mut repeats = pattern.as_ref().map(|pattern| pattern.count());
    for letter in match pattern {
        Some(_) => &b""[..],
        None if is_rs274 || is_haas => &b"L"[..],
        None => &b"KL"[..],
    } {
        if let Some(value) = gathered.raw(*letter) {
            let name = char::from(*letter).to_string();
            repeats = Some(whole(value, gathered.span_of(*letter), &name)?);
        }
    }
    // Only a block with a position or depth drills.
    if !is_rs274 && pattern.is_none() && gathered.axes.is_empty() && !gathered.has(b'R') {
        // Q is stored only in a block that drills, or with K0 (B-63944EN, canned cycle for drilling: restrictions of Q).
        if gathered.has(b'Q') && repeats != Some(0) {
            let message =
                format!("{} has Q in a block without a hole, where the control does not store it", name_of(code));
            return Err(bad_value(gathered.span_of(b'Q'), message, "write Q into the block of the first hole"));
        }
        repeats = Some(0);
    }
    if is_rs274 {
        gathered.use_up(b"$");
    }
    // Scaling applies to positions only: pecks and clearances are those of the machine.
    let growth = channel.modal.transforms.growth(if matches!(code, 760 | 870) { abscissa } else { applicate });
    let iso = &channel.settings.machine.control.iso;
    let clearance = match code {
        _ if is_rs274 => rs274::CLEARANCE_MM,
        730 => iso.chip_clearance_mm,
        _ => iso.peck_clearance_mm,
    };
    Ok(Call {
        code,
        from,
        is_lost: ![abscissa, ordinate].into_iter().all(|axis| channel.modal.position.known.contains(axis)),
        r: measure::length(channel, gathered, b'R')?,
        bottom,
        q: measure::length(channel, gathered, b'Q')?.map(|q| q / growth),
        pecks: match code {
            730 | 830 if is_haas && pattern.is_none() => peck_words(channel, gathered, growth)?,
            _ => PeckWords::default(),
        },
        dwell_s,
        repeats,
        incremental: channel.modal.modes.incremental,
        to_r: channel.modal.ends_at_r(),
        spindle: match channel.modal.spindle {
            3 => Turn::Clockwise,
            4 => Turn::CounterClockwise,
            _ => Turn::Off,
        },
        clearance: clearance / growth,
        aside: iso
            .orient_shift
            .map(|(axis, sign)| direction_of(&channel.modal, &channel.standing, axis, sign * growth)),
        is_kept: is_tapping(code) && is_left_to_control(channel, code),
    })
}

/// I, J and K of the pecks of a Haas; scaling does not apply to them.
fn peck_words(channel: &mut Channel<'_>, gathered: &Gathered, growth: f64) -> Result<PeckWords, Fault> {
    let mut word = |letter: u8| measure::length(channel, gathered, letter).map(|word| word.map(|it| it / growth));
    Ok(PeckWords { first: word(b'I')?, less: word(b'J')?, last: word(b'K')? })
}

/// A machine direction in the plane of the program.
fn direction_of(modal: &Modal, standing: &InForce, axis: Axis, sign: f64) -> [f64; 2] {
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    let direction = standing.setup.frame.unapply_direction(Vector::ith(axis.dimension(), sign));
    [abscissa, ordinate].map(|axis| direction.get(axis.slot()).copied().unwrap_or_default())
}

fn word_of(channel: &mut Channel<'_>, gathered: &Gathered, axis: Axis) -> Result<Option<f64>, Fault> {
    Ok(if gathered.axes.contains(axis) { Some(target::axis_value(channel, gathered, axis)?) } else { None })
}

/// Rejects J of a tap on a Haas, beside which the J of a pattern is a count or an angle.
fn no_faster_return(channel: &Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    if !is_tapping(code) || !gathered.has(b'J') || !channel.settings.machine.control.iso.is_haas() {
        return Ok(());
    }
    let name = name_of(code);
    let message = format!("{name} with J, the multiple of the speed at which the tap retracts, is not supported");
    let help = "omit J: the tap then retracts at the speed of setting 130";
    Err(fault(Code::NOT_SUPPORTED, gathered.span_of(b'J'), message, help))
}

/// Rejects state that is incompatible with a cycle.
fn check_cycle(channel: &Channel<'_>, gathered: &Gathered, code: u16, span: Span) -> Result<(), Fault> {
    let name = name_of(code);
    let refused = if channel.modal.contour.compensates() {
        Some(("radius compensation", "end it with G40 first"))
    } else if channel.modal.turning.is_some() {
        Some(("tool center point control", "end it with G49 first"))
    } else if channel.modal.modes.feed_unit == FeedUnit::InverseTime {
        Some(("inverse-time feed (G93)", "program G94 or G95"))
    } else {
        None
    };
    if let Some((what, help)) = refused {
        return Err(fault(Code::NOT_SUPPORTED, span, format!("{name} under {what}"), help));
    }
    let rotary = gathered.axes.difference(AxisSet::XYZ).iter().next();
    if let Some(axis) = rotary.filter(|_| channel.is_rs274()) {
        let message = format!("{axis} in a canned cycle");
        return Err(bad_value(gathered.span_of(axis.letter()), message, "move it in its own block"));
    }
    if channel.is_rs274() && matches!(code, 740 | 840) && channel.modal.modes.plane != Plane::XY {
        let message = format!("{name} outside the XY plane: LinuxCNC exchanges the axes there");
        return Err(fault(Code::NOT_SUPPORTED, span, message, "select G17, or program the motions one by one"));
    }
    let is_left = is_left_to_control(channel, code);
    if is_tapping(code) && channel.settings.strict && !channel.is_rs274() && !is_left {
        check_rigid(channel.settings.machine, &channel.cycles, code, &name, span)?;
    }
    Ok(())
}

/// K of a peck cycle is the number of holes on a Fanuc and a depth on a Haas.
///
/// A number of holes has no decimal point. A Haas would read it in increments, which nobody writes beside the step to the next hole under G91, or beside a Q
/// with a decimal point.
fn check_count(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    if !matches!(code, 730 | 830) || channel.settings.machine.control.iso.reads_as_fanuc() {
        return Ok(());
    }
    let name = name_of(code);
    let span = gathered.span_of(b'K');
    let writes_points = channel.modal.modes.incremental || gathered.is_pointed(b'Q');
    let is_count = writes_points && gathered.is_unpointed(b'K');
    if !is_count {
        let message = format!("K of {name}: on a Fanuc the number of holes, on a Haas a depth");
        let help = "write the number of holes with L and G91, or omit K; or set control.word_meaning = \"fanuc\" or controller = \"haas\"";
        return Err(fault(Code::TWO_MEANINGS, span, message, help));
    }
    if channel.settings.strict {
        let message =
            format!("K of {name} counts holes, as on a Fanuc; on a Haas it is a depth, and the block drills one hole");
        let help =
            "for a Haas, set controller = \"haas\"; control.word_meaning = \"fanuc\" confirms the number of holes";
        channel.outlet.warnings.push(fault(Code::UNUSUAL_MOTION, span, message, help));
    }
    Ok(())
}

/// `true` if the control executes a tapping cycle of the output.
fn is_left_to_control(channel: &Channel<'_>, code: u16) -> bool {
    let settings = &channel.settings;
    let may_be_rigid = settings.machine.control.iso.rigid_tapping != Some(false);
    settings.strict
        && settings.keeps_tapping
        && !channel.is_rs274()
        && (channel.cycles.is_rigid || matches!(code, 842 | 843) || may_be_rigid)
}

/// Rejects tapping that synchronizes, or may synchronize, spindle and axis.
fn check_rigid(machine: &Machine, cycles: &Cycles, code: u16, name: &str, span: Span) -> Result<(), Fault> {
    let rigid = machine.control.iso.rigid_tapping;
    let is_rigid = cycles.is_rigid || matches!(code, 842 | 843) || rigid == Some(true);
    if is_rigid {
        let message = format!("{name} is rigid tapping: single motions do not synchronize spindle and axis");
        let help = "put the tapping into a program that is not corrected";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    if rigid.is_none() {
        let message = format!("whether {name} is rigid tapping depends on a parameter of the control");
        let help = "set control.rigid_tapping = false in the machine file if a chuck compensates the length";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    Ok(())
}

/// LinuxCNC stops exactly within cycles; the equivalent motions must not be blended.
fn stop_exactly(language: Language, modal: &Modal, cycles: &mut Cycles, outlet: &mut MotionSink<'_>) {
    if (language == Language::Rs274)
        && !modal.codes.is(Group::Control, 610)
        && !std::mem::replace(&mut cycles.is_exact, true)
    {
        outlet.push(Kind::Keep("G61"));
    }
}
