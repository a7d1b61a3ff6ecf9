//! Balls on the table, probed at many angles of the rotary axes: the published strategies of Esmaeili 2021 (Table 4-1, SAMBA; Table 5-3, RUMBA), and a
//! generated one for any machine with rotary axes (chase the ball).
//!
//! A row is the position at which tip and ball would coincide; the program ends above it, along the tool, where a probing cycle begins.

use std::f64::consts::{PI, TAU};

use super::builder::{Builder, PlanReach, observation};
use super::{PlanKind, PlanRefused, RowSpacing, Wishes, empty, kind, middle};
use crate::measure::data::{Free, Observation, Setup};
use crate::measure::reading::Reading;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{Branch, Machine, State};
use ncfix_machine::snc::{Dwell, Kind};

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "probe",
    title: "probing of balls on the table: variants samba (Table 4-1), rumba (Table 5-3), rumba-check (Table 5-4), or indexed (generated)",
    wishes: &["ball", "radius", "variant", "points", "tilt", "clearance", "feed", "dwell", "line"],
    spacing: RowSpacing::Angle,
    has_setups: false,
    build,
};

/// Radius of the circle of balls: all printed angles are within the travel of the machines for which they were made.
const RADIUS_MM: f64 = 70.0;

/// Spindle, B, C in degrees and the balls (Esmaeili 2021, Table 4-1).
const SAMBA: [([i16; 3], &[usize]); 32] = [
    ([0, 10, 30], &[3, 4, 5]),
    ([0, 30, 90], &[3, 4, 5]),
    ([0, 50, 150], &[3, 4, 5]),
    ([0, 70, 210], &[3, 4, 5]),
    ([0, 90, 270], &[3, 4, 5, 6]),
    ([0, 60, 180], &[3, 4, 5]),
    ([0, 40, 120], &[3, 4, 6]),
    ([0, 20, 60], &[3, 4, 6]),
    ([0, -10, -30], &[3, 4, 5]),
    ([0, -30, -90], &[3, 4, 5]),
    ([0, -50, -150], &[3, 4, 5]),
    ([0, -70, -210], &[3, 4, 5]),
    ([0, -90, -270], &[3, 4, 5, 6]),
    ([0, -60, -180], &[3, 4, 5]),
    ([0, -40, -120], &[3, 4, 6]),
    ([0, -20, -60], &[3, 4, 6]),
    ([0, 0, 90], &[1, 2, 3, 4, 5, 6]),
    ([0, 0, 240], &[3, 4, 5]),
    ([0, 0, 300], &[3, 4, 5]),
    ([0, 0, 180], &[1, 2, 3, 4, 5, 6]),
    ([0, 0, 45], &[1, 2, 3, 4, 5, 6]),
    ([0, 0, -45], &[1, 2, 3, 4, 5, 6]),
    ([0, 0, -180], &[1, 2, 3, 4, 5, 6]),
    ([0, 0, -300], &[3, 4, 5]),
    ([0, 0, -240], &[3, 4, 5]),
    ([0, 0, -90], &[1, 2, 3, 4, 5, 6]),
    ([0, 0, 0], &[1, 2, 3, 4, 5, 6]),
    ([60, 0, 0], &[3]),
    ([120, 0, 0], &[3]),
    ([180, 0, 0], &[3]),
    ([240, 0, 0], &[3]),
    ([300, 0, 0], &[3]),
];

/// A and C in degrees, for each of four balls (Esmaeili 2021, Table 5-3).
#[rustfmt::skip]
const RUMBA: [[i16; 2]; 42] = [
    [15, 60], [30, 180], [45, 280], [55, 340], [40, 240], [20, 120], [0, 0], [-20, -100],
    [-40, 250], [-55, 350], [-50, -310], [-25, -40], [0, 180], [0, 280], [0, 360], [0, 320],
    [0, 210], [0, -160], [0, -300], [0, -220], [0, -50], [15, 0], [40, 0], [55, 0],
    [45, 0], [30, 0], [-20, 0], [-45, 0], [-55, 0], [-35, 0], [44, -30], [53, -208],
    [36, -318], [30, 45], [21, 326], [9, 290], [-16, -12], [-54, -304], [-40, -10], [-17, 100],
    [-38, 197], [-5, 345],
];

/// A and C in degrees, for the single ball of the validation (Esmaeili 2021, Table 5-4).
#[rustfmt::skip]
const RUMBA_CHECK: [[i16; 2]; 60] = [
    [8, 55], [16, 120], [40, 180], [38, 240], [55, 300], [50, 330], [45, 270], [36, 210],
    [23, 150], [12, 90], [4, 30], [-5, -30], [-12, -90], [-28, -150], [-31, -210], [-48, -270],
    [-52, -330], [-5, -300], [-43, -240], [-34, -180], [-23, -120], [-11, -55], [8, 140], [18, 190],
    [12, 250], [30, 290], [22, 310], [47, 10], [24, 50], [38, 100], [41, 160], [53, 200],
    [-34, -45], [-43, -140], [-50, -170], [-20, -220], [-15, -280], [-10, -310], [-5, -70], [-16, 135],
    [-50, 280], [-36, 94], [-10, 20], [-26, 200], [28, -40], [50, -300], [20, -280], [37, -100],
    [10, -280], [0, 0], [0, 90], [0, 240], [0, 300], [0, 180], [0, 45], [0, -45],
    [0, -180], [0, -300], [0, -240], [0, -90],
];

/// A strategy of probing.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ProbeStrategy {
    Samba,
    Rumba,
    RumbaCheck,
    /// Generated for any machine with rotary axes.
    Indexed,
}

impl ProbeStrategy {
    fn from_word(word: &str) -> Option<ProbeStrategy> {
        Some(match word {
            "samba" => ProbeStrategy::Samba,
            "rumba" => ProbeStrategy::Rumba,
            "rumba-check" => ProbeStrategy::RumbaCheck,
            "indexed" => ProbeStrategy::Indexed,
            _ => return None,
        })
    }
}

/// Rotary axes, spindle angle and ball of a probing.
type Pose = (AxisVector, i16, usize);

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, PlanRefused> {
    let tool_mm = wishes.tool_mm();
    let word = wishes.variant.as_deref().unwrap_or("indexed");
    let strategy = ProbeStrategy::from_word(word).ok_or_else(|| {
        PlanRefused(format!("unknown kind of probing '{word}'; the variants are samba, rumba, rumba-check, indexed"))
    })?;
    let (poses, balls_needed, free): (Vec<Pose>, usize, &[Free]) = match strategy {
        ProbeStrategy::Samba => (samba(machine)?, 6, &[]),
        ProbeStrategy::Rumba => (rumba(machine, &RUMBA, 4)?, 4, &[Free::Tool]),
        ProbeStrategy::RumbaCheck => (rumba(machine, &RUMBA_CHECK, 1)?, 1, &[Free::Tool]),
        ProbeStrategy::Indexed => {
            let balls = if wishes.balls_mm.is_empty() { 4 } else { wishes.balls_mm.len() };
            (indexed(machine, wishes, balls)?, balls, &[Free::Tool])
        }
    };
    let balls_mm = balls(machine, wishes, balls_needed)?;
    let mut data = empty(kind("probe")?, free);
    data.targets = (1..=balls_needed).map(|number| format!("b{number}")).collect();
    let mut plan = Builder::new(machine, wishes, data);
    let clearance_mm = wishes.clearance_mm.unwrap_or(20.0).max(0.0);
    let feed = wishes.feed.unwrap_or(2000.0);
    plan.reach = PlanReach::Above { clearance_mm, above_mm: clearance_mm, retract: true, feed };
    plan.at_pose = match (&wishes.line, wishes.dwell_s) {
        (Some(line), _) => vec![Kind::Verbatim(line.as_bytes().to_vec())],
        (None, Some(seconds)) => vec![Kind::Dwell(Dwell::Seconds(seconds))],
        (None, None) => {
            let mut stop = Builder::new(machine, wishes, plan.data.clone());
            stop.words(&[(b'M', 0.0)]);
            stop.path
        }
    };
    let row = |plan: &Builder, (rotary, _, ball): &Pose, setup: usize| -> Result<Observation, PlanRefused> {
        let place = balls_mm.get(*ball).copied().unwrap_or_else(Vector::zeros);
        let missing = || PlanRefused(format!("the linear axes of {} cannot place the tool", machine.name));
        // The angles are commanded, the tip position is found.
        let rotary = plan.on_increments(rotary);
        let position = plan.kinematics.placed(&place, &rotary, &tool_mm).ok_or_else(missing)?;
        let reading = Reading { position, tool_mm, state: State::default() };
        Ok(Observation { target: Some(*ball), ..observation(reading, setup) })
    };
    let mut spindle = None;
    let (mut left_out, mut near) = (0, 0);
    let mut label = String::new();
    for pose in &poses {
        let (rotary, turned, ball) = pose;
        if strategy == ProbeStrategy::Samba && spindle != Some(*turned) {
            spindle = Some(*turned);
            label = format!("S{turned}");
            plan.data.setups.push(Setup { label: label.clone(), ..Setup::default() });
            plan.retract()?;
            plan.stop(&format!("turn the spindle to {turned} deg"));
        } else if plan.data.setups.is_empty() {
            plan.data.setups.push(Setup { label: "A".into(), ..Setup::default() });
        }
        let setup = plan.data.setups.len().saturating_sub(1);
        let row = row(&plan, pose, setup)?;
        if strategy == ProbeStrategy::Indexed
            && !(is_reachable(&plan, &row, clearance_mm) && is_clear(&plan, &row, &balls_mm, clearance_mm))
        {
            left_out += 1;
            continue;
        }
        near += usize::from(!is_clear(&plan, &row, &balls_mm, clearance_mm));
        let angles = plan.kinematics.rotary_axes().map(|axis| format!(" {axis}{:.1}", rotary[axis].to_degrees()));
        let angles: String = angles.collect();
        plan.comment(&format!("ball b{}{angles}", ball + 1));
        plan.visit(&row, &label)?;
    }
    if left_out > 0 {
        plan.notes.push(format!(
            "{left_out} of {} poses are omitted: they are out of reach, or another ball is in the path",
            poses.len()
        ));
    }
    if near > 0 {
        plan.notes.push(format!(
            "at {near} poses the tool passes within {clearance_mm} mm of another ball: check them before you run the program"
        ));
    }
    if wishes.balls_mm.is_empty() {
        let shown = balls_mm.iter().map(|ball| format!("{:.0},{:.0},{:.0}", ball.x, ball.y, ball.z));
        let shown: Vec<String> = shown.collect();
        plan.notes.push(format!("the balls are assumed at {}; give --ball X,Y,Z for each", shown.join("; ")));
    }
    if strategy == ProbeStrategy::Samba {
        plan.notes
            .push("the stylus is assumed to be calibrated: other angles of the spindle only repeat a pose".into());
    }
    if plan.data.observations.is_empty() {
        return Err(PlanRefused("no pose is within the travel; give --ball, --tool or a smaller --tilt".into()));
    }
    let more = indexed(machine, &Wishes { points: Some(60), ..wishes.clone() }, balls_needed)?;
    for (rotary, turned, ball) in more {
        let row = row(&plan, &(rotary, turned, ball), 0)?;
        if is_reachable(&plan, &row, clearance_mm) && is_clear(&plan, &row, &balls_mm, clearance_mm) {
            plan.candidates.push(row);
        }
    }
    Ok(plan)
}

fn is_reachable(plan: &Builder, row: &Observation, clearance_mm: f64) -> bool {
    let position = plan.on_increments(&row.reading.position);
    let high = plan.raised(&position, &row.reading.tool_mm, clearance_mm);
    plan.outside(&position).is_none() && high.is_ok_and(|high| plan.outside(&high).is_none())
}

/// `true` if the tool, at its tip and along its retraction, keeps a distance from all other balls.
fn is_clear(plan: &Builder, row: &Observation, balls_mm: &[Vector], distance_mm: f64) -> bool {
    let tip = plan.kinematics.tip_mm(&row.reading.position, &row.reading.tool_mm);
    let along = plan.kinematics.direction(&row.reading.position);
    let others = balls_mm.iter().enumerate().filter(|(number, _)| Some(*number) != row.target);
    others.map(|(_, ball)| ball - tip).all(|off| (off - along * off.dot(&along).max(0.0)).norm() >= distance_mm)
}

/// Rejects a machine whose table has other axes.
fn needs(machine: &Machine, axes: [Axis; 2], what: &str) -> Result<(), PlanRefused> {
    let rotary: Vec<Axis> = machine.topology.workpiece.iter().copied().filter(|axis| axis.is_rotary()).collect();
    if rotary == axes && machine.topology.tool.iter().all(|axis| !axis.is_rotary()) {
        return Ok(());
    }
    let [tilt, turn] = axes;
    Err(PlanRefused(format!(
        "{what} is for a table {turn} on {tilt}, but {} is another machine; use the generated poses: --variant indexed",
        machine.name
    )))
}

fn samba(machine: &Machine) -> Result<Vec<Pose>, PlanRefused> {
    needs(machine, [Axis::B, Axis::C], "Table 4-1")?;
    let mut out = Vec::new();
    for ([spindle, b, c], balls) in SAMBA {
        let rotary = rotary([(Axis::B, b), (Axis::C, c)]);
        out.extend(balls.iter().map(|ball| (rotary, spindle, ball - 1)));
    }
    Ok(out)
}

fn rumba(machine: &Machine, angles: &'static [[i16; 2]], balls: usize) -> Result<Vec<Pose>, PlanRefused> {
    needs(machine, [Axis::A, Axis::C], if balls == 1 { "Table 5-4" } else { "Table 5-3" })?;
    let poses = |ball| angles.iter().map(move |&[a, c]| (rotary([(Axis::A, a), (Axis::C, c)]), 0, ball));
    Ok((0..balls).flat_map(poses).collect())
}

fn rotary(angles: [(Axis, i16); 2]) -> AxisVector {
    let mut out = AxisVector::ZERO;
    for (axis, degrees) in angles {
        out[axis] = f64::from(degrees).to_radians();
    }
    out
}

/// Poses for every ball: the axes together along a path that fills their ranges evenly, then each axis alone with the others at zero.
fn indexed(machine: &Machine, wishes: &Wishes, balls: usize) -> Result<Vec<Pose>, PlanRefused> {
    let table = machine.topology.workpiece.iter().rev();
    let head = machine.topology.tool.iter().rev();
    let axes: Vec<Axis> = table.chain(head).copied().filter(|axis| axis.is_rotary()).collect();
    if axes.is_empty() {
        let message = format!("{} has no rotary axis; plan a sphere or a plate instead", machine.name);
        return Err(PlanRefused(message));
    }
    let tilt = wishes.tilt.unwrap_or(60_f64.to_radians()).abs();
    let count = wishes.points.unwrap_or(42).clamp(2, 2000);
    let together = if axes.len() > 1 { count / 2 } else { 0 };
    let alone = (count - together).div_ceil(axes.len()).max(2);
    let range = |axis: Axis| {
        // The table's own axis makes full turns, the others tilt.
        let most = if machine.topology.branch(axis) == Some(Branch::Workpiece) && axes.first() == Some(&axis) {
            PI
        } else {
            tilt
        };
        let [low, high] = machine.axis(axis).and_then(|data| data.travel).unwrap_or([-TAU, TAU]);
        [low.max(-most).min(high), high.min(most).max(low)]
    };
    let mut angles = Vec::new();
    for number in 0..together {
        let mut pose = AxisVector::ZERO;
        for (k, &axis) in axes.iter().enumerate() {
            let [low, high] = range(axis);
            // Multiples of irrational numbers fill a range evenly for any number of them.
            let step = [0.618_033_988_75, 0.754_877_666_25, 0.569_840_290_998].get(k).copied().unwrap_or(0.5);
            let share = (0.5 + step * (number as f64 + 1.0)).fract();
            pose[axis] = (low + (high - low) * share).to_degrees().round().to_radians();
        }
        angles.push(pose);
    }
    for &axis in &axes {
        let [low, high] = range(axis);
        for number in 0..alone {
            let mut pose = AxisVector::ZERO;
            let share = number as f64 / (alone - 1).max(1) as f64;
            pose[axis] = low + (high - low) * share;
            angles.push(pose);
        }
    }
    Ok((0..balls).flat_map(|ball| angles.iter().map(move |pose| (*pose, 0, ball))).collect())
}

/// Positions of balls: the given ones, otherwise on a circle about the table's axis, at two heights.
pub(super) fn balls(machine: &Machine, wishes: &Wishes, count: usize) -> Result<Vec<Vector>, PlanRefused> {
    if !wishes.balls_mm.is_empty() {
        let given = wishes.balls_mm.len();
        let enough = given >= count;
        let refused = || PlanRefused(format!("{count} balls are needed, but {given} are given"));
        return enough.then(|| wishes.balls_mm.clone()).ok_or_else(refused);
    }
    let radius_mm = wishes.radius_mm.unwrap_or(RADIUS_MM);
    let table = machine.topology.workpiece.iter().rev().find(|axis| axis.is_rotary());
    let (origin, axis) = match table.and_then(|&axis| machine.axis(axis)) {
        Some(data) => {
            // Balls are on the side of the spindle; if the table turns across it, on the positive side.
            let along = data.direction.dot(&machine.spindle.axis);
            let side = if along.abs() > 1e-3 { along } else { data.direction[data.direction.iamax()] };
            let sign = if side < 0.0 { -1.0 } else { 1.0 };
            (data.point_mm, data.direction * sign)
        }
        None => (middle(machine) + machine.spindle.origin_mm + wishes.tool_mm(), machine.spindle.axis),
    };
    let aside = Vector::ith((axis.iamax() + 1) % 3, 1.0);
    let one = (aside - axis * aside.dot(&axis)).normalize();
    let other = axis.cross(&one);
    let place = |number: usize| {
        let angle = TAU * number as f64 / count as f64;
        let height_mm = if number.is_multiple_of(2) { 40.0 } else { 60.0 };
        let place = origin + (one * angle.cos() + other * angle.sin()) * radius_mm + axis * height_mm;
        // Rounded to whole µm, as a user would state them.
        place.map(|value| (value * 1000.0).round() / 1000.0 + 0.0)
    };
    Ok((0..count).map(place).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_tables_have_as_many_probings() {
        assert_eq!(SAMBA.iter().map(|(_, balls)| balls.len()).sum::<usize>(), 109);
        assert_eq!(RUMBA.len() * 4, 168);
    }
}
