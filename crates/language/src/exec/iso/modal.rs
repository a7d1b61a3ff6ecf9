//! What stays in force from block to block: modal codes, offsets, tool, position.

use super::codes::G80;
use super::frames::Transforms;
use super::zero_offset::System;
use crate::exec::core::contour::ContourModal;
use ncfix_base::geometry::{AxisSet, AxisVector, Frame, Plane, Vector};
use ncfix_base::units::MM_PER_INCH;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{FeedUnit, Setup, Turning};

/// Modal state of the channel.
#[derive(Clone, Debug)]
pub(super) struct Modal {
    /// Kind of motion, a G code in tenths; G80 for none.
    pub(super) motion: u16,
    pub(super) plane: Plane,
    pub(super) incremental: bool,
    /// G90.1
    pub(super) arc_absolute: bool,
    pub(super) inch: bool,
    /// mm/min, mm/turn or 1/min; 0 for none yet.
    pub(super) feed: f64,
    pub(super) feed_mode: FeedUnit,
    pub(super) speed: Option<f64>,
    /// The same as the output has it: of G96, m/min.
    pub(super) speed_word: f64,
    /// M3, M4 or M5.
    pub(super) spindle: u8,
    /// M7 and M8.
    pub(super) coolant: [bool; 2],
    /// M48 to M53: feed override, speed override, adaptive feed, feed stop.
    pub(super) overrides: [bool; 4],
    /// G99: cycles end at R.
    pub(super) to_r_plane: bool,
    /// G61, G61.1, G64, in tenths, and the words of G64.
    pub(super) path_control: (u16, Option<f64>, Option<f64>),
    /// G96 or G97, in tenths.
    pub(super) spindle_mode: u16,
    /// G54 and its kin.
    pub(super) system: System,
    /// The frame of the zero offset in force, that of all systems (EXT) included.
    pub(super) settable: Frame,
    /// Where the zero offset has no value in the machine file.
    pub(super) offset_assumed: bool,
    /// G92; of RS274/NGC G52 too.
    pub(super) shift: AxisVector,
    /// What G92.3 brings back.
    pub(super) stored_shift: AxisVector,
    /// G52 of Fanuc.
    pub(super) local: AxisVector,
    /// Rotation, scale, mirror, tilted plane.
    pub(super) transforms: Transforms,
    /// Code of length compensation, in tenths.
    pub(super) length_code: u16,
    /// Offset of the tool in force along X, Y, Z, mm.
    pub(super) length_mm: Vector,
    /// Where it has no value in the machine file.
    pub(super) length_assumed: bool,
    /// Selected with T, not yet changed to.
    pub(super) selected: Option<u32>,
    /// In the spindle.
    pub(super) active: Option<u32>,
    /// H and D in force.
    pub(super) h: u32,
    pub(super) d: Option<u32>,
    /// Radius of compensation, mm.
    pub(super) radius_mm: f64,
    pub(super) contour: ContourModal,
    /// G43.4, G43.5.
    pub(super) turning: Option<Turning>,
    /// Axis commands, mm and rad; under a transformation positions fixed to the workpiece.
    pub(super) command: AxisVector,
    /// Axes whose position the program has stated, in the frame in force.
    pub(super) known: AxisSet,
}

impl Modal {
    pub(super) fn new(start: Option<AxisVector>, machine: &Machine, language: Language) -> Self {
        let is_fanuc = language == Language::Fanuc;
        Modal {
            // LinuxCNC starts with G80, a Fanuc with G0 or G1 by parameter.
            motion: if is_fanuc { 0 } else { G80 },
            plane: machine.control.initial_plane,
            incremental: false,
            arc_absolute: false,
            inch: false,
            feed: 0.0,
            feed_mode: FeedUnit::PerMinute,
            speed: None,
            speed_word: 0.0,
            spindle: 5,
            coolant: [false; 2],
            overrides: [true, true, false, true],
            // LinuxCNC starts with G99.
            to_r_plane: !is_fanuc,
            path_control: (640, None, None),
            spindle_mode: 970,
            system: machine.control.initial_zero_offset.as_deref().and_then(System::of_name).unwrap_or(System::FIRST),
            settable: Frame::identity(),
            offset_assumed: false,
            shift: AxisVector::ZERO,
            stored_shift: AxisVector::ZERO,
            local: AxisVector::ZERO,
            transforms: Transforms::default(),
            length_code: 490,
            length_mm: Vector::zeros(),
            length_assumed: false,
            selected: None,
            active: None,
            h: 0,
            d: None,
            radius_mm: 0.0,
            contour: if is_fanuc { ContourModal::fanuc(&machine.control) } else { ContourModal::rs274() },
            turning: None,
            command: start.unwrap_or_default(),
            known: if start.is_some() { machine.axis_set() } else { AxisSet::EMPTY },
        }
    }

    /// mm per programmed length unit.
    pub(super) fn scale(&self) -> f64 {
        if self.inch { MM_PER_INCH } else { 1.0 }
    }

    /// Total frame: zero offset, shifts, then what is nearest to the programmed value.
    pub(super) fn frame(&self) -> Frame {
        let shifted = self.below_transforms();
        match self.transforms.frame() {
            None => shifted,
            Some(inner) => shifted.compose(&inner),
        }
    }

    /// Zero offset and shifts.
    pub(super) fn below_transforms(&self) -> Frame {
        self.settable.compose(&Frame::translation(self.shift + self.local))
    }

    /// How programmed positions relate to axis commands now.
    pub(super) fn setup(&self) -> Setup {
        Setup { frame: self.frame(), ..self.shown() }
    }

    /// What the control that runs the output knows of it: zero offset and tool.
    pub(super) fn shown(&self) -> Setup {
        Setup {
            frame: self.settable,
            tool_mm: -self.length_mm,
            plane: self.plane,
            transform: self.turning,
            assumed: self.offset_assumed || self.length_assumed,
        }
    }

    /// Where some axes are is unknown from here on. Those that a frame or a transformation mixes are unknown together; gives all that
    /// are.
    pub(super) fn forget(&mut self, axes: AxisSet) -> AxisSet {
        let mut lost = axes;
        if self.turning.is_some() {
            lost = AxisSet::ALL;
        } else if !self.frame().is_translation() && !axes.intersection(AxisSet::XYZ).is_empty() {
            lost = axes.union(AxisSet::XYZ);
        }
        self.known = self.known.difference(lost);
        lost
    }
}
