//! A test workpiece: a grid of stepped holes with stairs between them, milled level by level and measured on a coordinate measuring machine.
//!
//! The part follows Spaan 1995 (Figs. 5.10 to 5.12): each hole has a level after the other, each with four plane walls, whose middle is the place of the
//! tool in X and Y. A stair between two holes has a tread for each level, which is its place in Z. The dimensions are those of ncfix. A level is milled at
//! all holes and stairs before the next one, so the levels also show what changes with time.
//!
//! Signs: readings are the displacement of the tool, as measured minus nominal. A tool that is too far in +X makes a hole at +X; one that is too low
//! makes a low tread.

use super::builder::{Builder, Extra, PlannedFeature, PlannedPart};
use super::{PlanKind, PlanRefused, RowSpacing, Wishes, along_spindle, empty, kind};
use crate::measure::data::{Free, Setup};
use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector, FrameParts, Vector};
use ncfix_machine::machine::{Machine, Tool};

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "workpiece",
    title: "test workpiece of stepped holes and stairs, for a coordinate measuring machine (Spaan 1995, ch. 5)",
    wishes: &["blank", "levels", "points", "every", "radius", "center", "clearance", "feed", "speed", "dwell"],
    spacing: RowSpacing::Length,
    has_setups: false,
    build,
};

/// Sides of the blank, mm: choice of ncfix, it fits the travels of small machines.
const BLANK_MM: [f64; 3] = [200.0, 200.0, 50.0];
/// Number of levels (Spaan 1995, ch. 5).
const LEVELS: usize = 12;
/// Holes along a side: choice of ncfix, the least number that shows a bow.
const HOLES: usize = 3;
/// Distance between holes, mm: choice of ncfix.
const PITCH_MM: f64 = 60.0;
/// Radius of the end mill, mm: choice of ncfix.
const RADIUS_MM: f64 = 6.0;
/// Length of the end mill if the machine has none of this radius, mm: choice of ncfix.
const LENGTH_MM: f64 = 100.0;
/// Height of a level, mm: choice of ncfix, a stylus of 2 mm finds its wall.
const HEIGHT_MM: f64 = 3.0;
/// Width of the ledge between the walls of two levels, mm: choice of ncfix, the shaft of a stylus passes.
const LEDGE_MM: f64 = 0.7;
/// Distance of the end mill from the center of the lowest level, mm: choice of ncfix. The plane part of its walls is twice as wide.
const LEAST_LOOP_MM: f64 = 2.0;
/// Width of a tread, mm: choice of ncfix, for a stylus of 2 mm.
const TREAD_MM: f64 = 3.0;
/// Least thickness of a wall between a hole, a stair and a side of the blank, mm: choice of ncfix, about as stiff as the end mill.
const WALL_MM: f64 = 3.0;
/// Least thickness of the floor, mm: choice of ncfix.
const FLOOR_MM: f64 = 5.0;
/// Height above the last level, or above the blank, at which the end mill goes on at the feed of plunging, mm: choice of ncfix.
const ABOVE_MM: f64 = 1.0;
/// Feed, mm/min, and spindle speed, 1/min: choice of ncfix, for light cuts in aluminum.
const FEED: f64 = 500.0;
/// As [`FEED`].
const SPEED: f64 = 4000.0;
/// Share of the feed at which the end mill plunges: choice of ncfix.
const PLUNGE: f64 = 0.2;
/// Rapid feed of a machine without a stated one, for the planned times, mm/min: choice of ncfix.
const RAPID: f64 = 10_000.0;
/// Largest numbers of levels, and of holes along a side.
const MOST_LEVELS: usize = 50;
/// As [`MOST_LEVELS`].
const MOST_HOLES: usize = 50;
/// Two lengths are equal, mm.
const SAME_MM: f64 = 1e-6;

/// Dimensions of the workpiece. The zero is the center of the top of the blank.
struct Shape {
    blank_mm: Vector,
    levels: usize,
    holes: usize,
    pitch_mm: f64,
    radius_mm: f64,
}

impl Shape {
    fn new(wishes: &Wishes) -> Result<Shape, PlanRefused> {
        let shape = Shape {
            blank_mm: wishes.blank_mm.unwrap_or_else(|| Vector::from(BLANK_MM)),
            levels: wishes.levels.unwrap_or(LEVELS),
            holes: wishes.points.unwrap_or(HOLES),
            pitch_mm: wishes.every.unwrap_or(PITCH_MM),
            radius_mm: wishes.radius_mm.unwrap_or(RADIUS_MM),
        };
        shape.check().map(|()| shape)
    }

    /// Z of the floor of a level, mm.
    fn floor_mm(&self, level: usize) -> f64 {
        -HEIGHT_MM * level as f64
    }

    /// Distance of the tool axis from the center at the walls of a level, mm.
    fn loop_mm(&self, level: usize) -> f64 {
        LEAST_LOOP_MM + LEDGE_MM * (self.levels - level) as f64
    }

    /// Half of the width of a hole at its widest level, mm.
    fn half_hole_mm(&self) -> f64 {
        self.loop_mm(1) + self.radius_mm
    }

    /// Distance from the center to the outermost hole, mm.
    fn reach_mm(&self) -> f64 {
        (self.holes - 1) as f64 / 2.0 * self.pitch_mm
    }

    /// X or Y of the holes of a column or row, mm.
    fn place_mm(&self, number: usize) -> f64 {
        number as f64 * self.pitch_mm - self.reach_mm()
    }

    /// Y of the tool axis at the first and the last place of the slot of a level, relative to the middle of its stair, mm.
    fn slot_mm(&self, level: usize) -> [f64; 2] {
        let half = TREAD_MM * self.levels as f64 / 2.0;
        [TREAD_MM * (level - 1) as f64 - half, half]
    }

    /// Refuses a part that cannot be milled or measured.
    fn check(&self) -> Result<(), PlanRefused> {
        let refused = |text: String| Err(PlanRefused(text));
        if !(1..=MOST_LEVELS).contains(&self.levels) || !(2..=MOST_HOLES).contains(&self.holes) {
            return refused(format!(
                "a workpiece has 1 to {MOST_LEVELS} levels and 2 to {MOST_HOLES} holes along a side; correct --levels or --points"
            ));
        }
        let (blank, radius, half) = (&self.blank_mm, self.radius_mm, self.half_hole_mm());
        // The first loop leaves a square core, of which the plunge at the center takes a circle.
        let core = (half - 2.0 * radius) * std::f64::consts::SQRT_2;
        if core > radius {
            return refused(format!(
                "an end mill of radius {radius} mm would leave a core in holes {} mm wide; give a larger --radius or fewer --levels",
                2.0 * half
            ));
        }
        let depth = -self.floor_mm(self.levels);
        if depth + FLOOR_MM > blank.z {
            return refused(format!(
                "{} levels are {depth} mm deep and need a blank at least {} mm high, but it has {} mm; give a higher --blank or fewer --levels",
                self.levels,
                depth + FLOOR_MM,
                blank.z
            ));
        }
        let between = self.pitch_mm / 2.0 - half - radius;
        let along = self.pitch_mm - TREAD_MM * self.levels as f64 - 2.0 * radius;
        if between.min(along) < WALL_MM {
            let least = (2.0 * (half + radius + WALL_MM)).max(self.pitch_mm - along + WALL_MM);
            return refused(format!(
                "holes at a distance of {} mm leave no wall of {WALL_MM} mm beside the stairs; give --every {least:.1} or more",
                self.pitch_mm
            ));
        }
        let aside = blank.x.min(blank.y) / 2.0 - self.reach_mm();
        if aside < 2.0 * half {
            return refused(format!(
                "the outer holes are {:.1} mm wide, and only {aside:.1} mm from a side of the blank; give a larger --blank, fewer --points or a smaller --every",
                2.0 * half
            ));
        }
        Ok(())
    }
}

/// The end mill.
struct EndMill {
    number: u32,
    length_mm: f64,
    is_known: bool,
}

impl EndMill {
    /// A tool of the machine with this radius and length, or a tool that is not in its file.
    fn new(machine: &Machine, wishes: &Wishes, radius_mm: f64) -> Result<EndMill, PlanRefused> {
        let stated = wishes.tools_mm.first();
        if let Some(tool) = stated.filter(|tool| tool.x.abs() > SAME_MM || tool.y.abs() > SAME_MM || tool.z >= 0.0) {
            let [x, y, z] = [tool.x, tool.y, tool.z];
            return Err(PlanRefused(format!(
                "the end mill must be along the spindle, and {x},{y},{z} is not; give its length, such as --tool 100"
            )));
        }
        let is_same = |tool: &&Tool| {
            let [length, second, third] = tool.length_mm;
            let is_straight = second.abs() + third.abs() < SAME_MM && length > 0.0;
            let is_long = stated.is_none_or(|stated| (stated.z + length).abs() < SAME_MM);
            is_straight && is_long && tool.edge == 1 && (tool.radius_mm - radius_mm).abs() < SAME_MM
        };
        if let Some(tool) = machine.tools.iter().find(is_same) {
            return Ok(EndMill { number: tool.number, length_mm: tool.length_mm[0], is_known: true });
        }
        let number = (1..=u32::MAX).find(|number| machine.tools.iter().all(|tool| tool.number != *number)).unwrap_or(1);
        Ok(EndMill { number, length_mm: stated.map_or(LENGTH_MM, |tool| -tool.z), is_known: false })
    }
}

/// The zero offset of a program with this zero, mm, and `true` if the machine has it: otherwise one that the machine does not have.
fn zero_offset(machine: &Machine, origin_mm: &Vector) -> (String, bool) {
    let is_same = |parts: &FrameParts| {
        let turns = FrameParts { translation: AxisVector::ZERO, fine: AxisVector::ZERO, ..*parts };
        // Rotary axes are at their zero.
        let mut wanted = AxisVector::ZERO;
        wanted.set_xyz(*origin_mm);
        let off = |axis: Axis| (parts.translation[axis] + parts.fine[axis] - wanted[axis]).abs();
        turns == FrameParts::default() && AXES.into_iter().all(|axis| off(axis) < SAME_MM)
    };
    let is_sinumerik = machine.controller == "sinumerik";
    // Sinumerik has G54 to G57 and G505 to G599, the others have G54 to G59.
    let is_there = |number: &u32| if is_sinumerik { !(58..505).contains(number) } else { *number <= 59 };
    let names: Vec<String> = (54..=599).filter(is_there).map(|number| format!("G{number}")).collect();
    let own = names.iter().find(|name| machine.zero_offsets.get(*name).is_some_and(is_same));
    let unused = || names.iter().find(|name| !machine.zero_offsets.contains_key(*name));
    let name = own.or_else(unused).map_or("G54", String::as_str);
    (name.to_owned(), own.is_some())
}

/// A workpiece under construction.
struct Milling {
    plan: Builder,
    shape: Shape,
    origin_mm: Vector,
    tool_mm: Vector,
    clearance_mm: f64,
    feed: f64,
    rapid: f64,
    /// Planned time since the first motion, s.
    time_s: f64,
}

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, PlanRefused> {
    if along_spindle(machine) != (2, 1.0) {
        return Err(PlanRefused("the workpiece is milled from above, and the spindle is not along +Z".into()));
    }
    let shape = Shape::new(wishes)?;
    let mill = EndMill::new(machine, wishes, shape.radius_mm)?;
    let tool_mm = Vector::new(0.0, 0.0, -mill.length_mm);
    if -shape.floor_mm(shape.levels) >= mill.length_mm {
        return Err(PlanRefused(format!("an end mill of {} mm does not reach the lowest level", mill.length_mm)));
    }
    let mut data = empty(kind("displacement")?, &[Free::Offset, Free::Rotation]);
    data.setups.push(Setup { label: "A".into(), ..Setup::default() });
    let mut plan = Builder::new(machine, wishes, data);
    let increment = machine.control.increment_mm;
    let rounded = |value: f64| if increment > 0.0 { (value / increment).round() * increment } else { value };
    let origin_mm = wishes.centre_or_middle(machine, &tool_mm).map(rounded);
    let (name, has_offset) = zero_offset(machine, &origin_mm);
    let slowest = machine.axes.iter().flatten().filter(|data| !data.axis.is_rotary());
    let milling = Milling {
        clearance_mm: wishes.clearance_mm.unwrap_or(20.0).max(ABOVE_MM),
        feed: wishes.feed.unwrap_or(FEED),
        rapid: slowest.filter_map(|data| data.max_feed).min_by(f64::total_cmp).unwrap_or(RAPID),
        origin_mm,
        tool_mm,
        time_s: 0.0,
        plan: {
            plan.part = Some(PlannedPart { zero_offset: name.clone(), origin_mm, tool: mill.number, tool_mm });
            plan
        },
        shape,
    };
    milling.reaches_the_blank()?;
    let speed = wishes.speed.unwrap_or(SPEED);
    let mut milling = milling.with_notes(&name, has_offset, &mill, speed);
    milling.mill(speed, wishes.dwell_s.unwrap_or(0.0))?;
    Ok(milling.plan)
}

impl Milling {
    /// Refuses a blank that the tool cannot reach everywhere.
    fn reaches_the_blank(&self) -> Result<(), PlanRefused> {
        let half = self.shape.blank_mm / 2.0;
        for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
            let corner = self.origin_mm + Vector::new(x * half.x, y * half.y, 0.0);
            let outside = self.plan.outside(&self.plan.at_tip(&corner, &self.tool_mm));
            // The path has its own check of Z.
            if let Some(axis) = outside.filter(|axis| *axis != Axis::Z) {
                let [low, high] = self.plan.travel(axis).unwrap_or_default();
                let size = self.shape.blank_mm[axis.dimension()];
                return Err(PlanRefused(format!(
                    "the blank of {size} mm in {axis} is beyond the positions {low} to {high} that {axis} has minus its margin; give a smaller --blank, another --center or a smaller --margin"
                )));
            }
        }
        Ok(())
    }

    /// Notes for the user, and the beginning of the program: what is assumed.
    fn with_notes(mut self, zero: &str, has_offset: bool, mill: &EndMill, speed: f64) -> Milling {
        let Shape { blank_mm: blank, levels, holes, pitch_mm, radius_mm } = &self.shape;
        let [x, y, z] = [self.origin_mm.x, self.origin_mm.y, self.origin_mm.z].map(shown);
        let length = shown(mill.length_mm);
        let plunge = shown(self.feed * PLUNGE);
        let lines = [
            format!("blank {} x {} x {} mm; the zero is the center of its top", blank.x, blank.y, blank.z),
            format!(
                "{levels} levels of {HEIGHT_MM} mm, {holes} x {holes} holes {pitch_mm} mm apart, {} stairs between them",
                holes * (holes - 1)
            ),
            format!(
                "end mill T{}: radius {radius_mm} mm, length {length} mm; it must cut over its center",
                mill.number
            ),
            format!("{speed} 1/min, {} mm/min, plunging with {plunge} mm/min; no cutter compensation", self.feed),
            format!("zero offset {zero}: X {x}, Y {y}, Z {z}, as positions of the tool tip"),
        ];
        lines.iter().for_each(|line| self.plan.comment(line));
        self.plan.notes.extend(lines);
        let on_axes = shown(self.origin_mm.z + mill.length_mm);
        self.plan.notes.push(format!("for ncfix import, the zero of the report is at --at X{x},Y{y},Z{on_axes}"));
        if !has_offset || !mill.is_known {
            let offset = format!(
                "    [zero_offset.{zero}]\n    X_mm = {x}\n    Y_mm = {y}\n    Z_mm = {z}\n    set = \"absolute\""
            );
            let tool = format!(
                "    [[tool]]\n    number = {}\n    length_mm = {length}\n    radius_mm = {radius_mm}",
                mill.number
            );
            let missing = [(!has_offset, offset), (!mill.is_known, tool)];
            let missing: Vec<String> = missing.into_iter().filter_map(|(is, text)| is.then_some(text)).collect();
            self.plan.notes.push(format!(
                "the machine file has other values, or none; give these to check, fix and verify in a file with --setup, and enter them at the control:\n{}",
                missing.join("\n")
            ));
        }
        self
    }

    /// Mills all levels, one after the other.
    fn mill(&mut self, speed: f64, dwell_s: f64) -> Result<(), PlanRefused> {
        self.plan.stop("clamp the blank, without clamps in the way of the tool");
        self.plan.words(&[(b'S', speed), (b'M', 3.0)]);
        let up = self.clearance_mm;
        let first = Vector::new(self.shape.place_mm(0), self.shape.place_mm(0), up);
        self.push(&first, None, [Axis::Z].into_iter().collect())?;
        // Rotary axes move once to their zero.
        self.push(&first, None, self.plan.machine.axis_set())?;
        for level in 1..=self.shape.levels {
            if level > 1 && dwell_s > 0.0 {
                self.plan.dwell(dwell_s);
                self.time_s += dwell_s;
            }
            for row in 0..self.shape.holes {
                for step in 0..self.shape.holes {
                    // Alternating rows; a stair is between the hole of its number and the next one in X.
                    let column = if row.is_multiple_of(2) { step } else { self.shape.holes - 1 - step };
                    let stair = if row.is_multiple_of(2) { column.checked_sub(1) } else { Some(column) };
                    let stair = stair.filter(|stair| step > 0 && stair + 1 < self.shape.holes);
                    if let Some(stair) = stair {
                        self.stair(level, [stair, row])?;
                    }
                    self.hole(level, [column, row])?;
                }
            }
        }
        self.plan.words(&[(b'M', 5.0)]);
        Ok(())
    }

    /// Mills a level of a hole: down at its center, along its four walls, back to the center and up.
    fn hole(&mut self, level: usize, [column, row]: [usize; 2]) -> Result<(), PlanRefused> {
        let [x, y] = [column, row].map(|number| self.shape.place_mm(number));
        let (floor, wall) = (self.shape.floor_mm(level), self.shape.loop_mm(level));
        let name = format!("H{}L{level:02}", row * self.shape.holes + column + 1);
        let side = 2.0 * (wall + self.shape.radius_mm);
        self.plan.comment(&format!(
            "{name}: four walls {} mm apart about X{} Y{}, floor Z{}",
            shown(side),
            shown(x),
            shown(y),
            shown(floor)
        ));
        self.down(x, y, level)?;
        // Each wall is reached outwards, so a backlash widens the hole and leaves its center.
        let around = [[1.0, 0.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0]];
        for [right, back] in around {
            self.go(&Vector::new(x + right * wall, y + back * wall, floor), Some(self.feed))?;
        }
        // The walls are measured in the middle of their height.
        let middle = Vector::new(0.0, 0.0, HEIGHT_MM / 2.0);
        let nominal_mm = Vector::new(x, y, floor) + middle;
        let feature = PlannedFeature { name, level: count(level), nominal_mm, reads: [true, true, false] };
        self.row(feature, self.tool_mm + middle)?;
        if let Some(row) = self.plan.data.observations.last_mut() {
            [Axis::X, Axis::Y].iter().for_each(|axis| row.reading.state.direction[axis.slot()] = 0);
        }
        self.up(x, y)
    }

    /// Mills a level of a stair: a slot from its own tread to the end of the stair.
    fn stair(&mut self, level: usize, [column, row]: [usize; 2]) -> Result<(), PlanRefused> {
        let x = self.shape.place_mm(column) + self.shape.pitch_mm / 2.0;
        let middle = self.shape.place_mm(row);
        let floor = self.shape.floor_mm(level);
        let [from, to] = self.shape.slot_mm(level).map(|along| middle + along);
        let name = format!("S{}L{level:02}", row * (self.shape.holes - 1) + column + 1);
        // The next slot begins a tread later, so the tread lies between the edge of the tool and its axis, on the side of the start.
        let behind = Vector::new(0.0, TREAD_MM / 2.0 - self.shape.radius_mm, 0.0);
        let nominal_mm = Vector::new(x, from, floor) + behind;
        self.plan.comment(&format!("{name}: tread Z{} about X{} Y{}", shown(floor), shown(x), shown(nominal_mm.y)));
        self.down(x, from, level)?;
        let feature = PlannedFeature { name, level: count(level), nominal_mm, reads: [false, false, true] };
        self.row(feature, self.tool_mm + behind)?;
        self.go(&Vector::new(x, to, floor), Some(self.feed))?;
        self.up(x, to)
    }

    /// Moves over a place and down to a level there.
    fn down(&mut self, x: f64, y: f64, level: usize) -> Result<(), PlanRefused> {
        let before = self.shape.floor_mm(level - 1) + ABOVE_MM;
        self.go(&Vector::new(x, y, self.clearance_mm), None)?;
        self.go(&Vector::new(x, y, ABOVE_MM), None)?;
        self.go(&Vector::new(x, y, before), Some(self.feed))?;
        self.go(&Vector::new(x, y, self.shape.floor_mm(level)), Some(self.feed * PLUNGE))
    }

    /// Retracts above the blank.
    fn up(&mut self, x: f64, y: f64) -> Result<(), PlanRefused> {
        self.go(&Vector::new(x, y, self.clearance_mm), None)
    }

    /// A straight move of the tip to a position relative to the zero of the workpiece, mm; at rapid without a feed.
    fn go(&mut self, to_mm: &Vector, feed: Option<f64>) -> Result<(), PlanRefused> {
        self.push(to_mm, feed, [Axis::X, Axis::Y, Axis::Z].into_iter().collect())
    }

    fn push(&mut self, to_mm: &Vector, feed: Option<f64>, named: AxisSet) -> Result<(), PlanRefused> {
        let to = self.plan.at_tip(&(self.origin_mm + to_mm), &self.tool_mm);
        let to = self.plan.on_increments(&to);
        if let Some(last) = self.plan.last() {
            self.time_s += (to.xyz() - last.xyz()).norm() / feed.unwrap_or(self.rapid) * 60.0;
        }
        self.plan.push_named(to, None, feed, named)
    }

    /// A row at the last position, for a point of the tool.
    fn row(&mut self, feature: PlannedFeature, tool_mm: Vector) -> Result<(), PlanRefused> {
        let Some(here) = self.plan.last() else { return Ok(()) };
        let extra = Extra { time_s: Some(self.time_s.round()), feature: Some(feature), ..Extra::default() };
        self.plan.row(&here, tool_mm, 0, extra)
    }
}

/// A level as it is written.
fn count(level: usize) -> u32 {
    u32::try_from(level).unwrap_or(u32::MAX)
}

/// A length without trailing zeros, to 0.1 µm.
fn shown(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}
