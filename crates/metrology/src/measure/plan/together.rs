//! Paths about a ball of the workpiece on which the rotary axes turn together (Lei and Hsu 2003, ch. 3 and 5; Andolfatto et al. 2011, 4.3 and Fig. 8).
//!
//! The control interpolates axes in each block, so the tip leaves the ball between two poses. The sensors have a small range: the difference stays
//! within [`NEST_MM`] along each linear axis.
//!
//! The corner: let J₁ and J₂ be the motion of the ball per angle of either axis at the middle of their ranges. With angles of ±t/|J₁| and ±t/|J₂|, both
//! axes move the ball equally far, and the legs along J₁/|J₁| + J₂/|J₂| and J₁/|J₁| − J₂/|J₂| meet at a right angle.

use super::builder::{Builder, Extra};
use super::follow::{TurnedAxis, every, turns};
use super::{PlanRefused, Wishes, empty, kind, probe};
use crate::measure::data::{Free, Setup};
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::Machine;

/// Largest distance of the ball from the middle of the sensors along each linear axis, mm.
const NEST_MM: f64 = 0.1;
/// Positions within a block at which this distance is calculated.
const SAMPLES: u32 = 12;
/// Angle of a straight piece of the axis that turns most, rad.
const CHORD: f64 = std::f64::consts::PI / 360.0;
/// Lowest feed, mm/min, ratio of a feed to the one before, and number of feeds.
const FEEDS: (f64, f64, usize) = (1000.0, 1.8, 6);
/// Longest run at the lowest feed, s: the memory of a recorder.
const RUN_S: f64 = 15.0;
/// Time at the start of a run by which the records are aligned, s.
const TAG_S: f64 = 1.0;
/// Motion of the ball per angle below which it is on the axis, mm/rad.
const ON_AXIS_MM: f64 = 5.0;
/// Maximum number of blocks of a leg.
const MOST_BLOCKS: usize = 2000;
/// Step of differences, rad.
const STEP: f64 = 1e-5;

/// The plan of a variant: `together` or `corner`.
pub(super) fn build(machine: &Machine, wishes: &Wishes, variant: &str) -> Result<Builder, PlanRefused> {
    if wishes.axis.is_some() {
        return Err(PlanRefused(format!("--variant {variant} turns all rotary axes: leave out --axis")));
    }
    let turns = turns(machine, wishes)?;
    let &[first, second, ..] = turns.as_slice() else {
        return Err(PlanRefused(format!("{} has only one rotary axis: no two turn together", machine.name)));
    };
    let place_mm = probe::balls(machine, wishes, 1)?.first().copied().unwrap_or_default();
    let data = empty(kind("displacement")?, &[Free::Offset]);
    let mut ball = BallPath { plan: Builder::new(machine, wishes, data), place_mm, tool_mm: wishes.tool_mm() };
    match variant {
        "together" => ball.straight(&turns, wishes)?,
        "corner" => ball.corner([first, second], wishes)?,
        _ => {
            let message = format!("unknown path '{variant}' about a ball; the variants are together, corner");
            return Err(PlanRefused(message));
        }
    }
    ball.plan.stop("remove the nest of sensors");
    if wishes.balls_mm.is_empty() {
        let [x, y, z] = [place_mm.x, place_mm.y, place_mm.z];
        ball.plan.notes.push(format!("the ball is assumed at {x:.0},{y:.0},{z:.0}; give --ball X,Y,Z"));
    }
    Ok(ball.plan)
}

/// A path about a ball.
struct BallPath {
    plan: Builder,
    /// The ball in the workpiece frame.
    place_mm: Vector,
    /// The tool, to the middle of the sensors.
    tool_mm: Vector,
}

impl BallPath {
    /// The pose with the tip at the ball.
    fn pose(&self, rotary: &AxisVector) -> Result<AxisVector, PlanRefused> {
        let placed = self.plan.kinematics.placed(&self.place_mm, rotary, &self.tool_mm);
        placed
            .ok_or_else(|| PlanRefused(format!("the linear axes of {} cannot place the tool", self.plan.machine.name)))
    }

    /// Largest difference of a linear axis from the ball within a block, mm.
    fn leaves_mm(&self, from: &AxisVector, to: &AxisVector) -> Result<f64, PlanRefused> {
        let mut most = 0.0_f64;
        for sample in 1..SAMPLES {
            let here = between(from, to, f64::from(sample) / f64::from(SAMPLES));
            let ball = self.pose(&here)?;
            most = self.plan.kinematics.placing_axes().map(|axis| (ball[axis] - here[axis]).abs()).fold(most, f64::max);
        }
        Ok(most)
    }

    /// Refuses a block on which the ball leaves the sensors.
    fn check(&self, from: &AxisVector, to: &AxisVector, help: &str) -> Result<(), PlanRefused> {
        let leaves_mm = self.leaves_mm(from, to)?;
        if leaves_mm <= NEST_MM {
            return Ok(());
        }
        let [um, most] = [leaves_mm, NEST_MM].map(|mm| mm * 1e3);
        Err(PlanRefused(format!(
            "the ball would be {um:.0} µm from the middle of the sensors, more than {most:.0} µm; {help}"
        )))
    }

    /// Goes to the first pose, where the sensors are mounted.
    fn mount(&mut self, first: &AxisVector, feed: f64) -> Result<(), PlanRefused> {
        self.plan.data.setups.push(Setup { label: "ball".to_owned(), ..Setup::default() });
        self.plan.stop("remove the nest of sensors: the axes go to their first position");
        self.plan.approach(first, feed)?;
        self.plan.stop("mount the nest at the ball and set it to zero");
        Ok(())
    }

    fn row(&mut self, run: &str, feed: f64) -> Result<(), PlanRefused> {
        let Some(here) = self.plan.last() else { return Ok(()) };
        let extra = Extra { run: run.to_owned(), feed: Some(feed), ..Extra::default() };
        self.plan.row(&here, self.tool_mm, 0, extra)
    }

    /// All rotary axes from the first to the last angle of each, and back.
    fn straight(&mut self, turns: &[TurnedAxis], wishes: &Wishes) -> Result<(), PlanRefused> {
        let feed = wishes.feed.unwrap_or(FEEDS.0);
        let widest = turns.iter().map(|turn| turn.range[1] - turn.range[0]).fold(0.0, f64::max);
        let rows = (widest / every(wishes)).round().clamp(1.0, 1e6);
        let chord = wishes.chord.unwrap_or(CHORD).clamp(1e-4, 0.2);
        let pieces = (widest / rows / chord).ceil().max(1.0);
        let rotary_at = |share: f64| {
            let mut rotary = AxisVector::ZERO;
            for turn in turns {
                rotary[turn.axis] = turn.range[0] + (turn.range[1] - turn.range[0]) * share;
            }
            rotary
        };
        let first = self.pose(&rotary_at(0.0))?;
        self.mount(&first, feed)?;
        for run in 1..=wishes.runs.unwrap_or(1).clamp(1, 1000) {
            for is_back in [false, true] {
                let label = format!("{run}{}", if is_back { '-' } else { '+' });
                let at = |row: f64| rotary_at(if is_back { 1.0 - row / rows } else { row / rows });
                for row in 0..=rows as u32 {
                    for piece in 1..=pieces as u32 {
                        let share = f64::from(row) - 1.0 + f64::from(piece) / pieces;
                        if share >= 0.0 {
                            let to = self.pose(&at(share))?;
                            if let Some(from) = self.plan.last() {
                                self.check(&from, &to, "give a smaller --chord")?;
                            }
                            self.plan.go(&to, Some(feed))?;
                        }
                    }
                    self.row(&label, feed)?;
                    self.plan.dwell(wishes.dwell_s.unwrap_or(2.0));
                }
            }
        }
        Ok(())
    }

    /// Motion of the ball per angle of an axis, as positions of the linear axes, mm/rad.
    fn slope(&self, at: &AxisVector, turn: TurnedAxis) -> Result<Vector, PlanRefused> {
        let mut there = *at;
        there[turn.axis] += STEP;
        let slope = (self.pose(&there)?.xyz() - self.pose(at)?.xyz()) / STEP;
        if slope.norm() < ON_AXIS_MM {
            let axis = turn.axis;
            return Err(PlanRefused(format!(
                "the ball is on the axis of {axis}, which does not move it: give another --ball X,Y,Z"
            )));
        }
        Ok(slope)
    }

    /// Two legs with a right angle between them, at several feeds.
    fn corner(&mut self, turns: [TurnedAxis; 2], wishes: &Wishes) -> Result<(), PlanRefused> {
        let mut middle = AxisVector::ZERO;
        for turn in turns {
            middle[turn.axis] = turn.range[0].midpoint(turn.range[1]);
        }
        let [one, other] = [self.slope(&middle, turns[0])?, self.slope(&middle, turns[1])?];
        let cosine = one.normalize().dot(&other.normalize());
        if cosine.abs() > 0.95 {
            let message =
                "both rotary axes move the ball along one line, so the path has no corner: give another --ball X,Y,Z";
            return Err(PlanRefused(message.into()));
        }
        let angles = [one, other].map(|slope| 1.0 / slope.norm());
        // Share −1 is the start, 0 the corner, 1 the end.
        let rotary_at = |share: f64, size_mm: f64| {
            let mut rotary = middle;
            rotary[turns[0].axis] += size_mm * angles[0] * share;
            rotary[turns[1].axis] -= size_mm * angles[1] * share.abs();
            rotary
        };
        let low = wishes.feed.unwrap_or(FEEDS.0);
        let room = turns.iter().zip(angles).map(|(turn, angle)| (turn.range[1] - turn.range[0]) / 2.0 / angle);
        let largest_mm = room.fold(f64::INFINITY, f64::min);
        let fits = |size_mm: f64| -> Result<bool, PlanRefused> {
            const PARTS: u32 = 200;
            let mut length_mm = 0.0;
            let mut last: Option<Vector> = None;
            for part in 0..=PARTS {
                let here = self.pose(&rotary_at(2.0 * f64::from(part) / f64::from(PARTS) - 1.0, size_mm))?;
                if self.plan.outside(&self.plan.on_increments(&here)).is_some() {
                    return Ok(false);
                }
                length_mm += last.map_or(0.0, |last| (here.xyz() - last).norm());
                last = Some(here.xyz());
            }
            Ok(length_mm <= low * RUN_S / 60.0)
        };
        let [mut size_mm, mut too_large_mm] = [0.0, largest_mm];
        if fits(largest_mm)? {
            size_mm = largest_mm;
        }
        for _ in 0..30 {
            let tried = f64::midpoint(size_mm, too_large_mm);
            if fits(tried)? {
                size_mm = tried;
            } else {
                too_large_mm = tried;
            }
        }
        if size_mm < 1.0 {
            let message = "the ball cannot be followed near the middle of the rotary axes: give another --ball X,Y,Z, or a larger --feed";
            return Err(PlanRefused(message.into()));
        }
        let poses = self.blocks(&|share| rotary_at(share, size_mm), wishes)?;
        let &[first, ..] = poses.as_slice() else { return Ok(()) };
        self.mount(&first, low)?;
        let most = self.plan.machine.axes.iter().flatten().filter(|data| !data.axis.is_rotary());
        let most = most.filter_map(|data| data.max_feed).fold(f64::INFINITY, f64::min);
        let runs = wishes.runs.unwrap_or(FEEDS.2).clamp(1, 100);
        let feeds: Vec<f64> = (0..runs as i32).map(|run| (low * FEEDS.1.powi(run)).round()).collect();
        let usable: Vec<f64> = feeds.iter().copied().filter(|feed| *feed <= most).collect();
        if usable.len() < feeds.len() {
            let machine = &self.plan.machine.name;
            let note = format!(
                "{} of {} feeds are used: the linear axes of {machine} have {most} mm/min",
                usable.len(),
                feeds.len()
            );
            self.plan.notes.push(note);
        }
        for feed in usable {
            self.plan.dwell(wishes.dwell_s.unwrap_or(TAG_S));
            let label = feed.to_string();
            self.row(&label, feed)?;
            for pose in poses.iter().skip(1) {
                self.plan.go(pose, Some(feed))?;
                self.row(&label, feed)?;
            }
            self.plan.comment("back, without readings");
            for pose in poses.iter().rev().skip(1) {
                self.plan.go(pose, Some(low))?;
            }
        }
        let blocks = poses.len() - 1;
        self.plan
            .notes
            .push(format!("{blocks} blocks with a corner keep the ball within {:.0} µm of the sensors", NEST_MM * 1e3));
        Ok(())
    }

    /// The ends of the blocks of both legs, on increments of the control.
    fn blocks(&self, rotary_at: &dyn Fn(f64) -> AxisVector, wishes: &Wishes) -> Result<Vec<AxisVector>, PlanRefused> {
        let leg = |start: f64, count: usize| -> Result<Vec<AxisVector>, PlanRefused> {
            let pose = |k: usize| {
                self.pose(&rotary_at(start + k as f64 / count as f64)).map(|at| self.plan.on_increments(&at))
            };
            (0..=count).map(pose).collect()
        };
        let leaves = |poses: &[AxisVector]| -> Result<f64, PlanRefused> {
            let mut most = 0.0_f64;
            for pair in poses.windows(2) {
                most = most.max(self.leaves_mm(&pair[0], &pair[1])?);
                if most > NEST_MM {
                    break;
                }
            }
            Ok(most)
        };
        let mut legs = Vec::new();
        let mut longest = 0;
        for start in [-1.0, 0.0] {
            let mut count = 1;
            let mut poses = leg(start, count)?;
            while leaves(&poses)? > NEST_MM {
                if count >= MOST_BLOCKS {
                    return Err(PlanRefused(format!(
                        "the path needs more than {MOST_BLOCKS} blocks: give a ball nearer to the axes"
                    )));
                }
                count += 1;
                poses = leg(start, count)?;
            }
            longest = longest.max(count);
            legs.push(poses);
        }
        if let Some(points) = wishes.points {
            let counts = [points.div_ceil(2), points / 2];
            if counts[1] == 0 {
                return Err(PlanRefused(
                    "a path with a corner has at least two blocks: give --points 2 or more".into(),
                ));
            }
            legs = vec![leg(-1.0, counts[0])?, leg(0.0, counts[1])?];
            for pair in legs.iter().flat_map(|poses| poses.windows(2)) {
                self.check(&pair[0], &pair[1], &format!("give --points {} or more", 2 * longest))?;
            }
        }
        let mut poses = Vec::new();
        for (number, mut leg) in legs.into_iter().enumerate() {
            poses.extend(leg.drain(number.min(1)..));
        }
        Ok(poses)
    }
}

/// The axis positions at a share of a block.
fn between(from: &AxisVector, to: &AxisVector, share: f64) -> AxisVector {
    let mut out = *from;
    for axis in ncfix_base::geometry::AXES {
        out[axis] = from[axis] + (to[axis] - from[axis]) * share;
    }
    out
}
