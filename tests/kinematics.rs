//! Nominal kinematics of the machine room against the forward function of the model, on machines of every build.

use std::f64::consts::TAU;

use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_model::{ErrorModel, Model};

use crate::model::{Random, machines, sample};

const TOOL: [f64; 3] = [3.0, -2.0, -150.0];

fn rotary_count(machine: &Machine) -> usize {
    machine.axis_set().iter().filter(|axis| axis.is_rotary()).count()
}

#[test]
fn tip_and_direction_are_those_of_the_model() {
    let mut random = Random(11);
    for machine in machines() {
        let (kinematics, model) = (Kinematics::new(&machine), Model::new(&machine, &ErrorModel::default()));
        for _ in 0..100 {
            let (command, tool) = (random.command(3.0), Vector::from(TOOL));
            let pose = model.nominal(&command, &tool);
            assert!((kinematics.tip_mm(&command, &tool) - pose.translation).norm() < 1e-9, "{}", machine.topology);
            let direction = pose.rotation * machine.spindle.axis;
            assert!((kinematics.direction(&command) - direction).norm() < 1e-12, "{}", machine.topology);
            assert!((kinematics.rotation(&command) - pose.rotation).norm() < 1e-12, "{}", machine.topology);
        }
    }
}

#[test]
fn linear_axes_bring_the_tip_back_to_where_a_pose_has_it() {
    let mut random = Random(12);
    for machine in machines() {
        let kinematics = Kinematics::new(&machine);
        for _ in 0..100 {
            let (command, tool) = (random.command(3.0), Vector::from(TOOL));
            let tip = kinematics.tip_mm(&command, &tool);
            let mut start = command;
            for axis in kinematics.placing_axes() {
                start[axis] = f64::NAN;
            }
            let found = kinematics.placed(&tip, &start, &tool).unwrap();
            for axis in AXES {
                assert!((found[axis] - command[axis]).abs() < 1e-8, "{} {axis}", machine.topology);
            }
        }
    }
}

/// One of the two ways is the pose that the direction was taken from, the other has the same direction.
#[test]
fn rotary_angles_of_a_direction_are_found_both_ways() {
    let mut random = Random(13);
    let mut found_both = 0;
    for machine in machines().into_iter().filter(|machine| rotary_count(machine) == 2) {
        let kinematics = Kinematics::new(&machine);
        let model = Model::new(&machine, &ErrorModel::default());
        for _ in 0..300 {
            let command = random.command(2.5);
            if kinematics.distance_from_singularity(&command) < 0.01 {
                continue;
            }
            let direction = model.nominal(&command, &Vector::zeros()).rotation * machine.spindle.axis;
            let mut near = command;
            for axis in [Axis::A, Axis::B, Axis::C] {
                near[axis] += 0.01 * random.symmetric();
            }
            let ways = kinematics.orientations(&direction, &near);
            let first = ways[0].unwrap();
            let off = [Axis::A, Axis::B, Axis::C].map(|axis| (first[axis] - command[axis]).abs());
            let is_here = machine.axis_set().iter().filter(|axis| axis.is_rotary());
            let off = is_here.map(|axis| off[axis.slot() - 6]).fold(0.0, f64::max);
            assert!(off < 1e-7, "{}: {off}", machine.topology);
            found_both += u32::from(ways[1].is_some());
            for way in ways.into_iter().flatten() {
                let reached = model.nominal(&way, &Vector::zeros()).rotation * machine.spindle.axis;
                assert!((reached - direction).norm() < 1e-9, "{}", machine.topology);
                for axis in machine.axis_set().iter().filter(|axis| axis.is_rotary()) {
                    let [low, high] = machine.axis(axis).unwrap().travel.unwrap();
                    assert!((low - 1e-8..=high + 1e-8).contains(&way[axis]));
                }
            }
        }
    }
    assert!(found_both > 600, "{found_both}");
}

#[test]
fn one_rotary_axis_reaches_its_circle_and_nothing_else() {
    let machine = machines().into_iter().find(|machine| machine.topology.to_string() == "wXFYZBSt").unwrap();
    let kinematics = Kinematics::new(&machine);
    let direction = Vector::new(0.6, 0.0, 0.8);
    let found = kinematics.orientation(&direction, &AxisVector::ZERO).unwrap();
    // The head turns by the right-hand rule about +Y: Z goes to X.
    assert!((found[Axis::B] - 0.6_f64.asin()).abs() < 1e-12);
    assert_eq!(kinematics.orientation(&Vector::new(0.0, 0.6, 0.8), &AxisVector::ZERO), None);
}

#[test]
fn a_singular_pose_keeps_the_angle_and_what_is_out_of_reach_is_refused() {
    let (machine, _) = sample("esmaeili_xyz5");
    let kinematics = Kinematics::new(&machine);
    let mut near = AxisVector::ZERO;
    near[Axis::C] = 1.25;
    near[Axis::B] = 0.2;
    let found = kinematics.orientation(&Vector::z(), &near).unwrap();
    assert!((found[Axis::C] - 1.25).abs() < 1e-12 && found[Axis::B].abs() < 1e-12);
    assert!(kinematics.distance_from_singularity(&found) < 1e-12);
    // The 45° table turns the tool from straight up to flat, and no further down.
    let (huron, _) = sample("esmaeili_huron");
    let huron = Kinematics::new(&huron);
    assert!(huron.orientation(&Vector::new(0.6, 0.0, 0.8), &AxisVector::ZERO).is_some());
    assert_eq!(huron.orientation(&Vector::new(0.8, 0.0, -0.6), &AxisVector::ZERO), None);
    for bad in [Vector::zeros(), Vector::new(f64::NAN, 0.0, 1.0), Vector::new(f64::INFINITY, 0.0, 1.0)] {
        assert_eq!(huron.orientation(&bad, &AxisVector::ZERO), None);
    }
}

#[test]
fn full_turns_are_chosen_by_the_shortest_way_within_travel() {
    let (machine, _) = sample("esmaeili_xyz5");
    let kinematics = Kinematics::new(&machine);
    let mut command = AxisVector::ZERO;
    command[Axis::B] = 0.5;
    command[Axis::C] = 0.3;
    let direction = kinematics.direction(&command);
    let mut near = command;
    near[Axis::C] = 0.3 + 3.0 * TAU + 0.1;
    let found = kinematics.orientation(&direction, &near).unwrap();
    assert!((found[Axis::C] - (0.3 + 3.0 * TAU)).abs() < 1e-9);
    // Beyond 7200 degrees there is no more turn: 20 turns are the limit.
    near[Axis::C] = 20.0 * TAU - 0.01;
    let found = kinematics.orientation(&direction, &near).unwrap();
    assert!(found[Axis::C] <= 20.0 * TAU + 1e-9, "{}", found[Axis::C]);
    assert_eq!(kinematics.beyond_travel(&found), None);
    near[Axis::C] = 20.0 * TAU + 1.0;
    assert_eq!(kinematics.beyond_travel(&near), Some(Axis::C));
}
