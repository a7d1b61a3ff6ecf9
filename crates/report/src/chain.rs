//! Chain of a machine for people: a sketch as text, and a picture of its bodies with the senses of the axes.

use std::fmt::Write as _;

use ncfix_base::geometry::{Axis, Vector};
use ncfix_machine::machine::{AxisData, Branch, Machine};

use super::machine::decimal;
use super::markup::Markup;
use super::plot::{Picture, WIDTH};

/// Height of the boxes, distance of a row of text, and top of the boxes, in the units of the picture.
const BOX: f64 = 34.0;
const ROW: f64 = 24.0;
const TOP: f64 = 48.0;
/// Vertical center of the arrows.
const ARROWS: f64 = 140.0;
/// Length of an arrow, and radius of a turn.
const LENGTH: f64 = 24.0;
const RADIUS: f64 = 15.0;
/// Components of a direction below this are zero.
const ZERO: f64 = 1e-6;

/// Body of the picture.
#[derive(Clone, Debug, PartialEq)]
struct ChainBody {
    label: String,
    /// Direction of the motion or of the axis of rotation; `None` for a body that does not move.
    motion: Option<(bool, Vector)>,
    is_foundation: bool,
}

/// Picture of a chain of bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct ChainPicture {
    title: String,
    bodies: Vec<ChainBody>,
    rows: Vec<String>,
}

/// Returns the axes of a machine from the workpiece to the tool, each with its side of F.
fn axes(machine: &Machine) -> Vec<(&AxisData, Branch)> {
    let side = |axes: Vec<Axis>, branch| axes.into_iter().filter_map(move |axis| Some((machine.axis(axis)?, branch)));
    let workpiece = machine.topology.workpiece.iter().rev().copied().collect();
    side(workpiece, Branch::Workpiece).chain(side(machine.topology.tool.clone(), Branch::Tool)).collect()
}

/// Motion of an axis in words: `moves the workpiece to -Y`.
fn motion(data: &AxisData, branch: Branch) -> String {
    let carried = if branch == Branch::Tool { "the spindle" } else { "the workpiece" };
    let parts: Vec<usize> = (0..3).filter(|&row| data.direction[row].abs() > ZERO).collect();
    let [x, y, z] = [0, 1, 2].map(|row| decimal(data.direction[row]));
    let own = match parts.as_slice() {
        [row] => Some((['X', 'Y', 'Z'][*row], data.direction[*row] > 0.0)),
        _ => None,
    };
    match (data.axis.is_rotary(), own) {
        (false, Some((letter, is_positive))) => {
            format!("moves {carried} to {}{letter}", if is_positive { '+' } else { '-' })
        }
        (true, Some((letter, is_positive))) => {
            let sense = if is_positive { "counter-clockwise" } else { "clockwise" };
            format!("turns {carried} {sense}, seen from {letter}+")
        }
        (true, None) => format!("turns {carried} counter-clockwise about ({x}, {y}, {z})"),
        (false, None) => format!("moves {carried} along ({x}, {y}, {z})"),
    }
}

fn travel(data: &AxisData) -> String {
    match data.travel {
        _ if data.modulo => "modulo".to_owned(),
        Some([low, high]) if data.axis.is_rotary() => {
            format!("{} to {} deg", decimal(low.to_degrees()), decimal(high.to_degrees()))
        }
        Some([low, high]) => format!("{} to {} mm", decimal(low), decimal(high)),
        None => "no travel stated".to_owned(),
    }
}

/// Returns the sketch of a chain as text: the bodies in one line, and a line for the positive motion of each axis.
#[must_use]
pub fn sketch(machine: &Machine) -> String {
    let mut out = format!("{}: {}\n\n", machine.name, machine.topology);
    let letters = |axes: &[Axis]| axes.iter().map(ToString::to_string).collect::<Vec<_>>();
    let workpiece: Vec<Axis> = machine.topology.workpiece.iter().rev().copied().collect();
    let mut bodies = vec!["workpiece".to_owned()];
    bodies.extend(letters(&workpiece));
    bodies.push("[F]".to_owned());
    bodies.extend(letters(&machine.topology.tool));
    bodies.extend(["spindle".to_owned(), "tool".to_owned()]);
    let _ = writeln!(out, "  {}\n", bodies.join(" - "));
    for (data, branch) in axes(machine) {
        // Writing into a String cannot fail.
        let _ = writeln!(out, "  {}+  {}; {}", data.axis, motion(data, branch), travel(data));
    }
    out
}

impl ChainPicture {
    /// Makes the picture of a machine.
    #[must_use]
    pub fn of(machine: &Machine) -> ChainPicture {
        let still =
            |label: &str| ChainBody { label: label.to_owned(), motion: None, is_foundation: label == FOUNDATION };
        let mut bodies = vec![still("w")];
        let all = axes(machine);
        let moving = |branch: Branch| {
            all.iter().filter(move |one| one.1 == branch).map(|(data, _)| ChainBody {
                label: data.axis.to_string(),
                motion: Some((data.axis.is_rotary(), data.direction)),
                is_foundation: false,
            })
        };
        bodies.extend(moving(Branch::Workpiece));
        bodies.push(still(FOUNDATION));
        bodies.extend(moving(Branch::Tool));
        bodies.push(still("S"));
        bodies.push(still("t"));
        let rows = all
            .iter()
            .map(|(data, branch)| format!("{}+ {}; {}", data.axis, motion(data, *branch), travel(data)))
            .collect();
        ChainPicture { title: format!("{}: {}", machine.name, machine.topology), bodies, rows }
    }
}

/// Label of the foundation.
const FOUNDATION: &str = "F";

/// Place of a vector of F in the picture, seen from the right, the front and above.
fn flat(vector: &Vector) -> [f64; 2] {
    [0.94 * vector.x + 0.5 * vector.y, 0.26 * vector.x - 0.36 * vector.y - 0.94 * vector.z]
}

/// Path of an arrow with its head.
fn arrow([x, y]: [f64; 2], [dx, dy]: [f64; 2]) -> String {
    let size = dx.hypot(dy).max(ZERO);
    let [ux, uy] = [dx / size * 8.0, dy / size * 8.0];
    let [ex, ey] = [x + dx, y + dy];
    format!(
        "M{x:.1} {y:.1}L{ex:.1} {ey:.1}M{:.1} {:.1}L{ex:.1} {ey:.1}L{:.1} {:.1}",
        ex - ux - 0.5 * uy,
        ey - uy + 0.5 * ux,
        ex - ux + 0.5 * uy,
        ey - uy - 0.5 * ux
    )
}

/// Path of a turn about an axis by the right-hand rule, with a head, and of the axis itself.
fn turn([x, y]: [f64; 2], axis: &Vector) -> String {
    let axis = axis.normalize();
    let other = if axis.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
    let first = axis.cross(&other).normalize();
    let second = axis.cross(&first);
    let at = |degrees: f64| {
        let angle = degrees.to_radians();
        let [dx, dy] = flat(&((first * angle.cos() + second * angle.sin()) * RADIUS));
        [x + dx, y + dy]
    };
    let mut out = String::new();
    for step in 0..=14 {
        let [px, py] = at(f64::from(step) * 20.0);
        let _ = write!(out, "{}{px:.1} {py:.1}", if step == 0 { 'M' } else { 'L' });
    }
    let ([from_x, from_y], [to_x, to_y]) = (at(262.0), at(288.0));
    out.push_str(&arrow([from_x, from_y], [to_x - from_x, to_y - from_y]));
    let [dx, dy] = flat(&(axis * LENGTH * 1.2));
    let _ = write!(out, "M{:.1} {:.1}L{:.1} {:.1}", x - dx, y - dy, x + dx, y + dy);
    out
}

fn label(out: &mut Markup, [x, y]: [f64; 2], anchor: &str, text: &str) {
    out.leaf("text", &[("x", &format_args!("{x:.1}")), ("y", &format_args!("{y:.1}")), ("text-anchor", &anchor)], text);
}

impl Picture for ChainPicture {
    fn title(&self) -> &str {
        &self.title
    }

    fn height(&self) -> f64 {
        ARROWS + 64.0 + ROW * self.rows.len() as f64
    }

    fn inside(&self, out: &mut Markup) {
        out.leaf("text", &[("x", &"10"), ("y", &"22"), ("font-size", &"1.06em"), ("font-weight", &"600")], &self.title);
        let step = (WIDTH - 20.0) / self.bodies.len().max(1) as f64;
        let center = |number: usize| 10.0 + step * (number as f64 + 0.5);
        let mut links = String::new();
        for number in 1..self.bodies.len() {
            let middle = TOP + BOX / 2.0;
            let _ =
                write!(links, "M{:.1} {middle:.1}H{:.1}", center(number - 1) + BOX / 2.0, center(number) - BOX / 2.0);
        }
        let line: [(&str, &dyn std::fmt::Display); 4] =
            [("class", &"axis"), ("stroke", &"#59636e"), ("stroke-width", &"2"), ("fill", &"none")];
        out.empty("path", &[line[0], line[1], line[2], line[3], ("d", &links)]);
        for (number, body) in self.bodies.iter().enumerate() {
            let x = center(number);
            let width = if body.is_foundation { "4" } else { "2" };
            out.empty(
                "rect",
                &[
                    ("class", &"axis"),
                    ("x", &format_args!("{:.1}", x - BOX / 2.0)),
                    ("y", &TOP),
                    ("width", &BOX),
                    ("height", &BOX),
                    ("rx", &"4"),
                    ("stroke", &"#59636e"),
                    ("stroke-width", &width),
                    ("fill", &"none"),
                ],
            );
            label(out, [x, TOP + BOX / 2.0 + 6.0], "middle", &body.label);
            let series = |is_rotary: bool| if is_rotary { ("s1", "#d55e00") } else { ("s0", "#0072b2") };
            if let Some((is_rotary, direction)) = &body.motion {
                let (class, color) = series(*is_rotary);
                let path = if *is_rotary {
                    turn([x, ARROWS], direction)
                } else {
                    let [dx, dy] = flat(&(direction * LENGTH));
                    arrow([x - dx / 2.0, ARROWS - dy / 2.0], [dx, dy])
                };
                // A class with a fill would fill the turn.
                out.empty(
                    "path",
                    &[
                        ("class", &class),
                        ("stroke", &color),
                        ("stroke-width", &"2.5"),
                        ("style", &"fill:none"),
                        ("d", &path),
                    ],
                );
            } else if body.is_foundation {
                for (letter, unit) in [("X", Vector::x()), ("Y", Vector::y()), ("Z", Vector::z())] {
                    let [dx, dy] = flat(&(unit * LENGTH * 0.8));
                    let path = arrow([x, ARROWS + 8.0], [dx, dy]);
                    out.empty("path", &[line[0], line[1], ("stroke-width", &"1.5"), line[3], ("d", &path)]);
                    label(out, [x + dx * 1.45, ARROWS + 13.0 + dy * 1.45], "middle", letter);
                }
            }
        }
        for (number, row) in self.rows.iter().enumerate() {
            label(out, [10.0, ARROWS + 64.0 + ROW * number as f64], "start", row);
        }
    }
}
