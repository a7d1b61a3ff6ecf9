//! Machines of the plant: chain of axes, the errors that are known, and where the tool really is. Written from the conventions of axes and
//! errors (ISO 230-1, ISO 841) alone.

use super::row::Row;
use super::vector::{Frame, Mat, V3, add, scale, transposed, turn};

/// Letters of the axes by their number.
pub(crate) const LETTERS: [&str; 5] = ["X", "Y", "Z", "A", "C"];
/// Letters of the directions EX EY EZ EA EB EC.
pub(crate) const DIRECTIONS: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];
/// The number that stands for the spindle where errors of location are meant.
pub(crate) const SPINDLE: usize = 5;

/// An error that the machine file has, and rightly.
#[derive(Clone, Debug)]
pub(crate) enum Known {
    /// Direction, axis, mm or rad.
    Location(usize, usize, f64),
    /// Coefficients from degree 0.
    Polynomial(usize, usize, Vec<f64>),
    /// Positions and values.
    Table(usize, usize, Vec<f64>, Vec<f64>),
    /// The reversal value.
    Backlash(usize, usize, f64),
}

/// A machine.
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    pub(crate) name: &'static str,
    pub(crate) topology: &'static str,
    /// Axes on the side of the workpiece, from F outwards, and on that of the tool.
    pub(crate) table: Vec<usize>,
    pub(crate) tool: Vec<usize>,
    pub(crate) direction: [V3; 5],
    pub(crate) point: [V3; 5],
    pub(crate) travel: [[f64; 2]; 5],
    pub(crate) origin: V3,
    pub(crate) known: Vec<Known>,
}

/// All errors at one row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Errors {
    pub(crate) motion: [[f64; 6]; 5],
    pub(crate) location: [[f64; 6]; 6],
    /// Added to the commands.
    pub(crate) command: [f64; 5],
    /// The tool from the workpiece, F's directions, mm.
    pub(crate) tip: V3,
    /// Added to the tool vector.
    pub(crate) tool: V3,
    /// Added to the readings, mm or rad.
    pub(crate) reading: V3,
}

/// Tool in the workpiece.
pub(crate) struct Seen {
    pub(crate) nominal: Frame,
    pub(crate) actual: Frame,
    /// From the workpiece's directions to F's.
    pub(crate) to_f: Mat,
}

impl Machine {
    /// Three linear axes; three chains by number.
    pub(crate) fn mill(variant: u64) -> Machine {
        let (topology, table, tool): (_, &[usize], &[usize]) = match variant % 3 {
            0 => ("wXYFZSt", &[1, 0], &[2]),
            1 => ("wFXYZSt", &[], &[0, 1, 2]),
            _ => ("wXFYZSt", &[0], &[1, 2]),
        };
        let mut out = Machine {
            name: "plant_mill",
            topology,
            table: table.to_vec(),
            tool: tool.to_vec(),
            direction: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]],
            point: [[0.0; 3]; 5],
            travel: [[0.0, 700.0], [0.0, 500.0], [-20.0, 520.0], [0.0; 2], [0.0; 2]],
            origin: [0.0; 3],
            known: vec![
                Known::Location(5, usize::from(!variant.is_multiple_of(3)), 14e-6),
                Known::Polynomial(0, 0, vec![0.0, -1.2e-5, 1.1e-8]),
                Known::Table(1, 0, vec![0.0, 200.0, 450.0, 700.0], vec![0.0, 3.1e-3, 4.4e-3, -1.2e-3]),
                Known::Polynomial(4, 2, vec![0.0, 3.0e-8]),
                Known::Backlash(1, 1, 2.0e-3),
            ],
        };
        table.iter().for_each(|&axis| out.direction[axis] = scale(out.direction[axis], -1.0));
        out
    }

    /// Swivelling rotary table.
    pub(crate) fn five_axis() -> Machine {
        let mut out = Machine::mill(1);
        out.name = "plant_five";
        out.topology = "wCAYFXZSt";
        (out.table, out.tool) = (vec![1, 3, 4], vec![0, 2]);
        out.direction = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]];
        out.point[3] = [0.0, 10.0, -30.0];
        out.point[4] = [5.0, 10.0, 0.0];
        out.travel = [[-450.0, 450.0], [-450.0, 450.0], [-250.0, 650.0], [-110.0, 110.0], [-3600.0, 3600.0]];
        out.known = vec![
            Known::Location(5, 1, 9e-6),
            Known::Location(1, 4, 7e-3),
            Known::Polynomial(0, 0, vec![0.0, 1.5e-5]),
            Known::Location(3, 3, -11e-6),
        ];
        out
    }

    /// Its axes in the order of their letters.
    pub(crate) fn axes(&self) -> Vec<usize> {
        (0..5).filter(|axis| self.table.contains(axis) || self.tool.contains(axis)).collect()
    }

    /// Adds the known errors, times a factor: 0 where a control takes them out already.
    pub(crate) fn add_known(&self, row: &Row, factor: f64, errors: &mut Errors) {
        for known in &self.known {
            match known {
                Known::Location(d, axis, size) => errors.location[*axis][*d] += factor * size,
                Known::Polynomial(d, axis, c) => {
                    let q = row.q[*axis];
                    errors.motion[*axis][*d] += factor * c.iter().rev().fold(0.0, |sum, c| sum * q + c);
                }
                Known::Table(d, axis, at, values) => {
                    errors.motion[*axis][*d] += factor * between(at, values, row.q[*axis]);
                }
                Known::Backlash(d, axis, size) => {
                    errors.motion[*axis][*d] += factor * size / 2.0 * row.dir[*axis];
                }
            }
        }
    }

    fn branch(&self, axes: &[usize], row: &Row, errors: Option<&Errors>) -> Frame {
        let mut out = Frame::shift([0.0; 3]);
        for &axis in axes {
            let q = row.q[axis] + errors.map_or(0.0, |errors| errors.command[axis]);
            let by = scale(self.direction[axis], q);
            let motion = if axis < 3 { Frame::shift(by) } else { Frame::turn(by) };
            out = out.then(&Frame::shift(self.point[axis]));
            if let Some(errors) = errors {
                out = out.then(&Frame::small(errors.location[axis]));
            }
            out = out.then(&motion);
            if let Some(errors) = errors {
                out = out.then(&Frame::small(errors.motion[axis]));
            }
            out = out.then(&Frame::shift(scale(self.point[axis], -1.0)));
        }
        out
    }

    /// The tool in the workpiece with given errors or without any.
    pub(crate) fn pose(&self, row: &Row, errors: Option<&Errors>) -> Frame {
        let mut tool = self.branch(&self.tool, row, errors).then(&Frame::shift(self.origin));
        let mut vector = row.tool;
        if let Some(errors) = errors {
            tool = tool.then(&Frame::small(errors.location[SPINDLE]));
            vector = add(vector, errors.tool);
        }
        self.branch(&self.table, row, errors).sees(&tool.then(&Frame::shift(vector)))
    }

    /// From the workpiece's directions to F's, without errors.
    pub(crate) fn to_f(&self, row: &Row) -> Mat {
        self.branch(&self.table, row, None).r
    }

    /// Where the tool is and where it should be.
    pub(crate) fn see(&self, row: &Row, errors: &Errors) -> Seen {
        let (nominal, to_f) = (self.pose(row, None), self.to_f(row));
        let mut actual = self.pose(row, Some(errors));
        actual.t = add(actual.t, turn(&transposed(&to_f), errors.tip));
        Seen { nominal, actual, to_f }
    }

    /// The machine file.
    pub(crate) fn toml(&self) -> String {
        let mut out = format!(
            "[machine]\nname = \"{}\"\ntopology = \"{}\"\ncontroller = \"sinumerik\"\nreference_temperature_C = 20.0\n",
            self.name, self.topology
        );
        for axis in self.axes() {
            let unit = if axis < 3 { "mm" } else { "deg" };
            let [low, high] = self.travel[axis];
            out += &format!(
                "\n[axis.{}]\ndirection = {}\npoint_mm = {}\ntravel_{unit} = [{low}, {high}]\nmax_feed_{unit}_min = 12000\n",
                LETTERS[axis],
                list(&self.direction[axis]),
                list(&self.point[axis])
            );
        }
        out += &format!("\n[spindle]\norigin_mm = {}\naxis = [0, 0, 1]\n\n[location]\n", list(&self.origin));
        for known in &self.known {
            if let Known::Location(d, axis, size) = known {
                out += &format!("E{}0{} = {:?}\n", DIRECTIONS[*d], LETTERS[*axis], micro(*d, *size));
            }
        }
        for known in &self.known {
            let (d, axis, text) = match known {
                Known::Location(..) => continue,
                Known::Polynomial(d, axis, c) => {
                    (d, axis, format!("kind = \"polynomial\"\ncoefficients = {}\n", list(c)))
                }
                Known::Table(d, axis, at, values) => {
                    let (at, values) = (list(at), list(&values.iter().map(|v| micro(*d, *v)).collect::<Vec<_>>()));
                    (d, axis, format!("kind = \"table\"\npositions_mm = {at}\nvalues_{} = {values}\n", unit(*d)))
                }
                Known::Backlash(d, axis, size) => {
                    (d, axis, format!("kind = \"backlash\"\nvalue_{} = {:?}\n", unit(*d), micro(*d, *size)))
                }
            };
            out += &format!("\n[[motion]]\ncomponent = \"E{}{}\"\n{text}", DIRECTIONS[*d], LETTERS[*axis]);
        }
        out
    }
}

/// µm of mm or µrad of rad by the direction, without the noise of the arithmetic.
fn micro(direction: usize, value: f64) -> f64 {
    let per = if direction < 3 { 1e3 } else { 1e6 };
    (value * per * 1e3).round() / 1e3
}

fn unit(direction: usize) -> &'static str {
    if direction < 3 { "um" } else { "urad" }
}

fn list(values: &[f64]) -> String {
    let cells: Vec<String> = values.iter().map(|v| format!("{v:?}")).collect();
    format!("[{}]", cells.join(", "))
}

fn between(at: &[f64], values: &[f64], q: f64) -> f64 {
    let last = at.len() - 1;
    if q <= at[0] {
        return values[0];
    }
    for k in 0..last {
        if q <= at[k + 1] {
            return values[k] + (values[k + 1] - values[k]) * (q - at[k]) / (at[k + 1] - at[k]);
        }
    }
    values[last]
}
