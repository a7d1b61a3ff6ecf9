//! Machines of the tests, built in code.

use std::collections::BTreeMap;

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{AxisData, Control, Lever, Machine, Spindle, Topology};

/// Three linear axes on the tool side, wide travel, G54 at X100 Y50 Z10.
pub(crate) fn xyz_machine() -> Machine {
    let axis = |axis: Axis| {
        let mut direction = Vector::zeros();
        direction[axis.dimension()] = 1.0;
        let (point_mm, travel, max_feed) = (Vector::zeros(), Some([-1e6, 1e6]), Some(1e4));
        Some(AxisData {
            axis,
            name: None,
            direction,
            point_mm,
            travel,
            modulo: false,
            max_feed,
            start_rad: None,
            clamps: Vec::new(),
            lever: Lever::Carried,
        })
    };
    let mut axes = [const { None }; 9];
    for letter in [Axis::X, Axis::Y, Axis::Z] {
        axes[letter.slot()] = axis(letter);
    }
    let mut zero_offsets = BTreeMap::new();
    let mut g54 = AxisVector::ZERO;
    g54.set_xyz(Vector::new(100.0, 50.0, 10.0));
    zero_offsets.insert("G54".to_owned(), g54.into());
    Machine {
        name: "test".into(),
        topology: "wFXYZSt".parse::<Topology>().unwrap(),
        controller: "sinumerik".into(),
        reference_temperature_c: 20.0,
        sensor_references_c: Default::default(),
        active_tables: Default::default(),
        axis_order: Vec::new(),
        axes,
        spindle: Spindle { origin_mm: Vector::zeros(), axis: Vector::z() },
        heads: Vec::new(),
        has_fixed_head: false,
        control: Control::default(),
        zero_offsets,
        partial_offsets: BTreeMap::new(),
        datums: BTreeMap::new(),
        radius_wear_mm: BTreeMap::new(),
        base_frames: BTreeMap::new(),
        parameters: BTreeMap::new(),
        system: BTreeMap::new(),
        gud: BTreeMap::new(),
        strain: None,
        load_sensors: Vec::new(),
        servo: None,
        measured: None,
        uncertainty: None,
        tools: Vec::new(),
    }
}
