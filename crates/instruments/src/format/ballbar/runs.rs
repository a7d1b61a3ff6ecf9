//! Runs of a ball-bar in the order of their motion: a stated direction decides, and a table that is sorted by angle is turned round.

use ncfix_base::geometry::Axis;

use super::facts::is_standard;
use crate::inquiry::{ImportStop, Inquiry};

/// Angle of backward motion above which rows go both ways, degrees: measured angles are not exact.
const BACK_DEG: f64 = 5.0;

/// Readings of one circle.
pub(super) struct CircleRun {
    /// Label in the file, without the direction.
    pub(super) name: String,
    /// 1 from the first axis of the plane to the second, else -1, if the file or an option states it.
    pub(super) turn: Option<f64>,
    /// Angle in degrees, value, line; in the order of the motion after [`sort`].
    pub(super) readings: Vec<(f64, f64, usize)>,
}

/// Direction of the angles in the order of the rows.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Order {
    Rising,
    Falling,
    Both,
    None,
}

/// Name of a direction.
fn word(turn: f64) -> &'static str {
    if turn > 0.0 { "ccw" } else { "cw" }
}

/// Direction in which the angles of rows go.
fn order(readings: &[(f64, f64, usize)]) -> Order {
    let mut swept = 0.0_f64;
    let [mut least, mut most] = [0.0_f64; 2];
    // How far the rows went back from their highest and from their lowest angle.
    let [mut down, mut up] = [0.0_f64; 2];
    for pair in readings.windows(2) {
        let step = pair[1].0 - pair[0].0;
        // A step across 360° is a short one.
        swept += if step.abs() > 180.0 { step - 360.0 * (step / 360.0).round() } else { step };
        [least, most] = [least.min(swept), most.max(swept)];
        [down, up] = [down.max(most - swept), up.max(swept - least)];
    }
    match (up > BACK_DEG, down > BACK_DEG) {
        (true, true) => Order::Both,
        (true, false) => Order::Rising,
        (false, true) => Order::Falling,
        (false, false) => Order::None,
    }
}

/// Direction of run number `index`, by the option `--turn`.
pub(super) fn by_option(inquiry: &Inquiry<'_>, index: usize) -> Option<f64> {
    match inquiry.answer("turn", |own| own.turns.as_slice()) {
        [only] => Some(*only),
        several => several.get(index).copied(),
    }
}

/// Puts the readings of every run into the order of its motion, and asks for a direction that nothing states. `is_timed` for angles that follow from times.
///
/// # Errors
/// If directions contradict each other or the option.
pub(super) fn sort(
    inquiry: &mut Inquiry<'_>,
    runs: &mut [CircleRun],
    is_timed: bool,
    line: usize,
) -> Result<(), ImportStop> {
    let said = inquiry.answers().turns.len();
    if said > 1 && said != runs.len() {
        let message = format!("--turn names {said} directions, the file has {} runs", runs.len());
        return Err(inquiry.refused(message, "give one direction for all, or one for each run in their order", line));
    }
    for (index, run) in runs.iter_mut().enumerate() {
        let own_line = run.readings.first().map_or(line, |(_, _, line)| *line);
        match (run.turn, by_option(inquiry, index)) {
            (Some(stated), Some(said)) if stated != said => {
                let message = format!("--turn {} contradicts the file, which says {}", word(said), word(stated));
                return Err(inquiry.refused(message, "remove --turn, or correct the file", own_line));
            }
            (None, said) => run.turn = said,
            _ => {}
        }
        let shown = label(&run.name, run.turn);
        let shown = if shown.is_empty() { "the circle".to_owned() } else { format!("run {shown}") };
        match (run.turn, order(&run.readings)) {
            (Some(_), Order::Both) if !is_timed => {
                let message = format!("{shown} has one direction, but its angles go both ways");
                let help = "give each circle a run of its own, in a column 'run'";
                return Err(inquiry.refused(message, help, own_line));
            }
            (Some(turn), own @ (Order::Rising | Order::Falling)) if (own == Order::Rising) != (turn > 0.0) => {
                run.readings.reverse();
                let way = if own == Order::Rising { "ascend" } else { "descend" };
                let note = format!(
                    "{shown}: the stated direction is {}, and the angles {way}, so the readings are written in reverse order",
                    word(turn)
                );
                inquiry.note(note, 0);
            }
            _ => {}
        }
    }
    // A table that is sorted by angle lists every circle at ascending angles, so these do not say how the machine moved.
    let is_open = |run: &CircleRun| run.turn.is_none();
    if runs.iter().any(is_open) {
        let is_telling = |run: &CircleRun| matches!(order(&run.readings), Order::Falling | Order::Both);
        if runs.iter().any(is_telling) {
            inquiry.note("direction of the circles: that of the order of the rows", line);
        } else {
            let example = if runs.len() > 1 { "ccw, cw, or one for each run such as ccw,cw" } else { "ccw or cw" };
            let sentence = "the file does not state the direction of the circles, and its angles only ascend";
            inquiry.ask("turn", sentence, example);
        }
    }
    Ok(())
}

/// Label of a run in the measurement: its name, and its direction if that is stated.
fn label(name: &str, turn: Option<f64>) -> String {
    let parts = [name, turn.map_or("", word)];
    parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}

/// Label of a run with the direction of ISO 230-4: in the plane ZX it is seen from +Y, whichever axis the angles of the file begin at.
pub(super) fn standard_label(run: &CircleRun, plane: [Axis; 2]) -> String {
    let sense = if is_standard(plane) { 1.0 } else { -1.0 };
    label(&run.name, run.turn.map(|turn| turn * sense))
}
