//! The order of the bodies from the workpiece through the foundation to the tool.
//!
//! A topology is written from the workpiece `w` through the foundation `F` to the tool `t`. Example: in `wCBXFZYSt`, F carries X, X carries B, B carries C, and
//! C carries the workpiece; F carries Z, Z carries Y, Y carries the spindle S, and S carries the tool. A lower-case `f` is read as `F`; `S` may be omitted.

use std::fmt;
use std::str::FromStr;

use ncfix_base::geometry::{Axis, AxisSet};

/// Two branches of the chain, each from the foundation outwards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topology {
    /// Axes that carry the workpiece, starting at the foundation.
    pub workpiece: Vec<Axis>,
    /// Axes that carry the tool, starting at the foundation.
    pub tool: Vec<Axis>,
}

/// Branch of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Branch {
    /// From the foundation to the workpiece.
    Workpiece,
    /// From the foundation to the tool.
    Tool,
}

/// Reason why a text is not a topology.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopologyFault {
    /// It does not begin with `w`.
    NoWorkpiece,
    /// It does not end with `t`.
    NoTool,
    /// It has no `F`.
    NoFoundation,
    /// It has more than one `F`.
    TwoFoundations,
    /// A character that is not an axis letter.
    UnknownLetter(char),
    /// An axis letter that occurs twice.
    DoubleAxis(Axis),
    /// `S` at a place other than directly before `t`.
    MisplacedSpindle,
    /// No axis.
    NoAxis,
}

impl Topology {
    /// Returns the branch of an axis; `None` if the machine lacks it.
    #[must_use]
    pub fn branch(&self, axis: Axis) -> Option<Branch> {
        if self.workpiece.contains(&axis) {
            Some(Branch::Workpiece)
        } else if self.tool.contains(&axis) {
            Some(Branch::Tool)
        } else {
            None
        }
    }

    /// Returns all axes of both branches.
    #[must_use]
    pub fn axis_set(&self) -> AxisSet {
        self.workpiece.iter().chain(&self.tool).copied().collect()
    }
}

impl FromStr for Topology {
    type Err = TopologyFault;

    fn from_str(text: &str) -> Result<Self, TopologyFault> {
        // Case matters here: an upper-case W is the axis W.
        let body = text.strip_prefix('w').ok_or(TopologyFault::NoWorkpiece)?;
        let body = body.strip_suffix('t').ok_or(TopologyFault::NoTool)?;
        let body = body.strip_suffix('S').unwrap_or(body);
        let mut workpiece = Vec::new();
        let mut tool = Vec::new();
        let mut seen = AxisSet::EMPTY;
        let mut behind_foundation = false;
        for letter in body.chars() {
            match letter {
                'F' | 'f' if behind_foundation => return Err(TopologyFault::TwoFoundations),
                'F' | 'f' => behind_foundation = true,
                'S' => return Err(TopologyFault::MisplacedSpindle),
                _ => {
                    let axis = u8::try_from(letter)
                        .ok()
                        .filter(u8::is_ascii_uppercase)
                        .and_then(Axis::from_letter)
                        .ok_or(TopologyFault::UnknownLetter(letter))?;
                    if seen.contains(axis) {
                        return Err(TopologyFault::DoubleAxis(axis));
                    }
                    seen.insert(axis);
                    if behind_foundation { tool.push(axis) } else { workpiece.push(axis) }
                }
            }
        }
        if !behind_foundation {
            return Err(TopologyFault::NoFoundation);
        }
        if seen.is_empty() {
            return Err(TopologyFault::NoAxis);
        }
        // Written from the workpiece towards F, stored from F outwards.
        workpiece.reverse();
        Ok(Topology { workpiece, tool })
    }
}

impl fmt::Display for Topology {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("w")?;
        self.workpiece.iter().rev().try_for_each(|axis| write!(f, "{axis}"))?;
        f.write_str("F")?;
        self.tool.iter().try_for_each(|axis| write!(f, "{axis}"))?;
        f.write_str("St")
    }
}

impl fmt::Display for TopologyFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TopologyFault::NoWorkpiece => f.write_str("it does not begin with w (workpiece)"),
            TopologyFault::NoTool => f.write_str("it does not end with t (tool)"),
            TopologyFault::NoFoundation => f.write_str("F (foundation) is missing"),
            TopologyFault::TwoFoundations => f.write_str("F (foundation) is given twice"),
            TopologyFault::UnknownLetter(letter) => write!(f, "'{letter}' is not an axis letter"),
            TopologyFault::DoubleAxis(axis) => write!(f, "axis {axis} is given twice"),
            TopologyFault::MisplacedSpindle => f.write_str("S (spindle) is allowed only directly before t"),
            TopologyFault::NoAxis => f.write_str("it has no axis"),
        }
    }
}

impl std::error::Error for TopologyFault {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_run_from_the_foundation_outwards() {
        let topology: Topology = "wCBXfZYt".parse().unwrap();
        assert_eq!(topology.workpiece, [Axis::X, Axis::B, Axis::C]);
        assert_eq!(topology.tool, [Axis::Z, Axis::Y]);
        assert_eq!(topology.to_string(), "wCBXFZYSt");
        assert_eq!(topology.branch(Axis::B), Some(Branch::Workpiece));
        assert_eq!(topology.branch(Axis::Y), Some(Branch::Tool));
        assert_eq!(topology.branch(Axis::A), None);
    }

    #[test]
    fn axis_w_is_told_from_the_workpiece() {
        let topology: Topology = "wFXYZWSt".parse().unwrap();
        assert_eq!(topology.tool, [Axis::X, Axis::Y, Axis::Z, Axis::W]);
        assert_eq!("WFXt".parse::<Topology>(), Err(TopologyFault::NoWorkpiece));
    }

    #[test]
    fn faults_are_named() {
        for (text, fault) in [
            ("", TopologyFault::NoWorkpiece),
            ("wFXYZ", TopologyFault::NoTool),
            ("wXYZt", TopologyFault::NoFoundation),
            ("wXFFZt", TopologyFault::TwoFoundations),
            ("wXFQt", TopologyFault::UnknownLetter('Q')),
            ("wXFµt", TopologyFault::UnknownLetter('µ')),
            ("wXFxt", TopologyFault::UnknownLetter('x')),
            ("wXFYXt", TopologyFault::DoubleAxis(Axis::X)),
            ("wXFSYt", TopologyFault::MisplacedSpindle),
            ("wXFSSt", TopologyFault::MisplacedSpindle),
            ("wFSt", TopologyFault::NoAxis),
        ] {
            assert_eq!(text.parse::<Topology>(), Err(fault), "{text}");
        }
    }
}
