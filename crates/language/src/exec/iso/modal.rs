//! Modal state, which stays active from block to block: modal codes, offsets, tool, position.

use std::sync::Arc;

use super::codes::{G80, Group};
use super::frames::Transforms;
use super::zero_offset::System;
use crate::exec::core::contour::ContourModal;
use crate::exec::core::modal::{CodesInForce, Modes};
use crate::exec::core::position::Position;
use crate::exec::core::tool::ToolState;
use ncfix_base::geometry::{AxisSet, AxisVector, Frame, Vector};
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Setup, Turning, WrittenZero};

/// Modal state of the channel.
#[derive(Clone, Debug)]
pub(super) struct Modal {
    /// The motion mode is a G code in tenths; G80 for none.
    pub(super) modes: Modes<u16>,
    /// Codes of the other groups, in tenths.
    pub(super) codes: CodesInForce<Group, u16>,
    /// The speed as written in the output; under G96, m/min.
    pub(super) speed_word: f64,
    /// M3, M4 or M5.
    pub(super) spindle: u8,
    /// M7 and M8.
    pub(super) coolant: [bool; 2],
    /// M48 to M53: feed override, speed override, adaptive feed, feed stop.
    pub(super) overrides: [bool; 4],
    /// P and Q of G64, mm.
    pub(super) path_tolerance_mm: [Option<f64>; 2],
    /// G54 and related codes.
    pub(super) system: System,
    /// The frame of the active zero offset, including that of all systems (EXT).
    pub(super) settable: Frame,
    /// Index of the settable zero offset among those of the machine.
    pub(super) zero: Option<u16>,
    /// The zero offset, if the program has set its value.
    pub(super) written_zero: Option<Arc<WrittenZero>>,
    /// `true` if the zero offset has no value in the machine file.
    pub(super) offset_assumed: bool,
    /// G92; on RS274/NGC including G52.
    pub(super) shift: AxisVector,
    /// The shift that G92.3 restores.
    pub(super) stored_shift: AxisVector,
    /// G52 of Fanuc.
    pub(super) local: AxisVector,
    /// G254 of a Haas: the shift of the zero offset with the turned table.
    pub(super) turned_zero: Option<AxisVector>,
    /// Rotation, scale, mirror, tilted plane.
    pub(super) transforms: Transforms,
    /// The length is along X, Y, Z; it may be assumed, the radius may not.
    pub(super) tool: ToolState<u32, Vector>,
    /// Active H and D.
    pub(super) h: u32,
    /// True if the program has stated an H.
    pub(super) has_h: bool,
    /// `true` after a G28 of a Haas that ended the length compensation.
    pub(super) length_ended: bool,
    pub(super) d: Option<u32>,
    pub(super) contour: ContourModal,
    /// G43.4, G43.5.
    pub(super) turning: Option<Turning>,
    pub(super) position: Position,
}

/// Codes that are active at the start, of RS274/NGC and of a Fanuc: LinuxCNC starts with G99.
const RS274_START: &[(Group, u16)] = &[(Group::Retract, 990), START[0], START[1], START[2], START[3]];
const FANUC_START: &[(Group, u16)] = &[(Group::Retract, 980), START[0], START[1], START[2], START[3]];
/// Common to both.
const START: [(Group, u16); 4] =
    [(Group::ArcDistance, 911), (Group::Control, 640), (Group::SpindleMode, 970), (Group::Length, 490)];

impl Modal {
    pub(super) fn new(start: Option<AxisVector>, machine: &Machine, language: Language) -> Self {
        let is_fanuc = language == Language::Fanuc;
        Modal {
            // LinuxCNC starts with G80, a Fanuc with G0 or G1 depending on a parameter.
            modes: Modes::new(if is_fanuc { 0 } else { G80 }, machine.control.initial_plane),
            codes: CodesInForce::new(if is_fanuc { FANUC_START } else { RS274_START }),
            speed_word: 0.0,
            spindle: 5,
            coolant: [false; 2],
            overrides: [true, true, false, true],
            path_tolerance_mm: [None; 2],
            system: machine.control.initial_zero_offset.as_deref().and_then(System::of_name).unwrap_or(System::FIRST),
            settable: Frame::identity(),
            zero: None,
            written_zero: None,
            offset_assumed: false,
            shift: AxisVector::ZERO,
            stored_shift: AxisVector::ZERO,
            local: AxisVector::ZERO,
            turned_zero: None,
            transforms: Transforms::default(),
            tool: ToolState::default(),
            h: 0,
            has_h: false,
            length_ended: false,
            d: None,
            contour: if is_fanuc { ContourModal::fanuc(&machine.control) } else { ContourModal::rs274() },
            turning: None,
            position: Position::at_start(start, machine),
        }
    }

    /// The active code of a group with an initial code, in tenths.
    pub(super) fn code(&self, group: Group) -> u16 {
        self.codes.code(group).unwrap_or_default()
    }

    /// `true` under G99: cycles end at R.
    pub(super) fn ends_at_r(&self) -> bool {
        self.codes.is(Group::Retract, 990)
    }

    /// `true` if the program or the startup code has stated G98 or G99.
    pub(super) fn states_retract(&self) -> bool {
        self.codes.programmed(Group::Retract).is_some()
    }

    /// `true` under G96: S is the cutting speed.
    pub(super) fn has_cutting_speed(&self) -> bool {
        self.codes.is(Group::SpindleMode, 960)
    }

    /// `true` under G90.1.
    pub(super) fn has_absolute_centers(&self) -> bool {
        self.codes.is(Group::ArcDistance, 901)
    }

    /// Total frame: zero offset, shifts, then the transformations nearest to the programmed value.
    pub(super) fn frame(&self) -> Frame {
        let shifted = self.below_transforms();
        match self.transforms.frame() {
            None => shifted,
            Some(inner) => shifted.compose(&inner),
        }
    }

    /// Zero offset and shifts.
    pub(super) fn below_transforms(&self) -> Frame {
        let turned = self.turned_zero.unwrap_or(AxisVector::ZERO);
        self.settable.compose(&Frame::translation(turned + self.shift + self.local))
    }

    /// The current relation between programmed positions and axis commands.
    pub(super) fn setup(&self) -> Setup {
        Setup { frame: self.frame(), ..self.shown() }
    }

    /// The part of it that the control knows when it runs the output: zero offset, tool, and a tilted plane that is kept.
    pub(super) fn shown(&self) -> Setup {
        let kept = self.transforms.kept_stand();
        Setup {
            frame: kept.map_or(self.settable, |stand| self.settable.compose(&stand.frame)),
            tool_mm: -self.tool.length_mm,
            plane: self.modes.plane,
            transform: self.turning,
            assumed: self.offset_assumed || self.tool.assumed,
            zero: self.zero,
            written_zero: self.written_zero.clone(),
            head: self.tool.head,
        }
    }

    /// Makes the position of axes unknown. Axes that a frame or transformation mixes become unknown together. Returns all unknown axes.
    pub(super) fn forget(&mut self, axes: AxisSet) -> AxisSet {
        let frame = self.frame();
        self.position.forget(axes, self.turning.is_some(), &frame)
    }
}
