//! Tests of the comparison of zero offsets.

use super::*;

/// X, Y and Z.
fn linear(values: [f64; 3]) -> ZeroValues {
    std::array::from_fn(|slot| values.get(slot).copied().unwrap_or(0.0))
}

fn expected(g54: [f64; 3]) -> ExpectedZero {
    ExpectedZero { offsets: vec![(G54, linear(g54))], named: vec![G54], ..ExpectedZero::default() }
}

/// A machine with a rotary axis A, whose offset is 15°.
fn expected_with_a() -> ExpectedZero {
    let mut zero = ExpectedZero { axes: b"XYZA".to_vec(), ..expected([1.0, 2.0, 3.0]) };
    zero.offsets[0].1[3] = 15.0;
    zero
}

/// A control with these lines.
fn watch(zero: ExpectedZero, lines: &[&str]) -> ZeroWatch {
    let mut watch = ZeroWatch::default();
    watch.expect(zero);
    lines.iter().for_each(|line| watch.hear(line));
    watch
}

fn sees(watch: &mut ZeroWatch, offset: &str) -> bool {
    watch.see(Some(offset)).is_some()
}

#[test]
fn the_whole_offset_counts_in_either_unit() {
    let lines = ["[G54:100.000,90.000,-60.000]", "[G92:0.000,10.000,0.000]", "[TLO:0.050]", "[GC:G0 G54 G17 G21]"];
    assert_eq!(watch(expected([100.0, 100.0, -60.0]), &lines).begin(), None);
    let why = watch(expected([100.0, 90.0, -60.0]), &lines).begin().unwrap();
    assert!(why.contains("Y_mm = 100.000") && why.contains("send G92.1 to the control"), "{why}");
    assert_eq!(watch(expected([254.0, 0.0, 0.0]), &["[G54:10.0000,0.0000,0.0000]"]).begin(), None);
    assert!(watch(expected([0.0; 3]), &["[G54:0.000,0.000,0.120]"]).begin().is_some());
    assert!(watch(expected([0.0; 3]), &["[G54:0.000,0.000,0.000]", "[TLO:0.000,0.000,5.000]"]).begin().is_some());
    // A control that states nothing.
    assert_eq!(watch(expected([7.0; 3]), &[]).begin(), None);
}

#[test]
fn an_offset_that_nobody_has_named_must_be_the_first_one() {
    let lines = ["[G54:0.000,0.000,0.000]", "[G55:5.000,0.000,0.000]", "[GC:G0 G55 G17 G21]"];
    let unnamed = || ExpectedZero { named: Vec::new(), ..expected([0.0; 3]) };
    assert!(watch(unnamed(), &lines).begin().is_some_and(|why| why.contains("G55 in force")));
    assert_eq!(watch(expected([0.0; 3]), &lines).begin(), None);
}

#[test]
fn an_offset_changes_by_a_line_only() {
    let lines = ["[G54:1.000,2.000,3.000]", "[G55:9.000,2.000,3.000]", "[GC:G0 G54]"];
    let mut running = watch(expected([1.0, 2.0, 3.0]), &lines);
    assert_eq!(running.begin(), None);
    assert_eq!(running.stated().as_deref(), Some("G54 1.000,2.000,3.000"));
    assert!(!sees(&mut running, "1.000,2.000,3.050") && sees(&mut running, "9.000,2.000,3.000"));
    running.sent(b"G55 G0 X1");
    assert!(!sees(&mut running, "9.000,2.000,3.000") && sees(&mut running, "6.000,2.000,3.000"));
    running.sent(b"G10 L20 P1 X0");
    assert!(!sees(&mut running, "6.000,2.000,3.000"));
}

#[test]
fn a_job_that_is_taken_up_needs_the_offset_of_its_beginning() {
    let begin = |earlier: &str, now: &str| {
        let zero = ExpectedZero { earlier: Some(earlier.to_owned()), named: vec![G54], ..ExpectedZero::default() };
        watch(zero, &[now]).begin()
    };
    assert_eq!(begin("G54 100.000,100.000,-60.000", "[G54:100.010,100.000,-60.000]"), None);
    assert!(
        begin("G54 100.000,100.000,-60.000", "[G54:107.000,100.000,-60.000]")
            .is_some_and(|why| why.contains("X107.000"))
    );
    assert_eq!(begin("G55 1.000,0.000,0.000", "[G54:107.000,100.000,-60.000]"), None);
}

#[test]
fn a_rotary_axis_of_the_machine_is_compared_in_degrees_within_a_revolution() {
    for (a, says) in
        [("15.000", None), ("375.000", None), ("15.005", None), ("14.980", Some("A14.980")), ("0.000", Some("A0.000"))]
    {
        let why = watch(expected_with_a(), &[&format!("[G54:1.000,2.000,3.000,{a}]")]).begin();
        assert_eq!(why.is_some(), says.is_some(), "{a}: {why:?}");
        assert!(why.is_none_or(|why| why.contains(says.unwrap()) && why.contains("A_deg = ")), "{a}");
    }
    // grblHAL states the order of its axes. A control with an axis that the machine lacks is not asked for it.
    let mut other = watch(expected_with_a(), &[]);
    other.has_axes("4:XYAZ");
    other.hear("[G54:1.000,2.000,15.000,3.000]");
    assert_eq!(other.begin(), None);
    assert_eq!(watch(expected([1.0, 2.0, 3.0]), &["[G54:1.000,2.000,3.000,77.000]"]).begin(), None);
    // A report in inches leaves degrees as they are: 1 mm = 0.03937 in.
    assert_eq!(watch(expected_with_a(), &["[G54:0.0394,0.0787,0.1181,15.0000]"]).begin(), None);
    assert_eq!(watch(expected_with_a(), &["[G54:1,2,3,15]"]).stated().as_deref(), Some("G54 1.000,2.000,3.000,15.000"));
}

/// LinuxCNC with G54 and, turned by 30°, G55.
fn linuxcnc(zero: ExpectedZero) -> ZeroWatch {
    let mut watch = ZeroWatch::new(ZeroSource::LinuxCnc);
    watch.expect(zero);
    watch.has_active(G54);
    watch.has_system(540, linear([10.0, 20.0, -30.0]));
    let mut turned = linear([1.0, 2.0, 3.0]);
    turned[ROTATION] = 30.0;
    watch.has_system(550, turned);
    watch
}

#[test]
fn a_rotation_of_the_offset_is_a_difference() {
    let both = |rotation: f64| {
        let mut turned = linear([1.0, 2.0, 3.0]);
        turned[ROTATION] = rotation;
        let offsets = vec![(540, linear([10.0, 20.0, -30.0])), (550, turned)];
        ExpectedZero { offsets, named: vec![540, 550], ..ExpectedZero::default() }
    };
    let mut same = linuxcnc(both(30.0));
    assert_eq!(same.begin(), None);
    assert!(!same.is_turned() && same.sent(b"G55") && same.is_turned());
    let why = linuxcnc(both(0.0)).begin().unwrap();
    assert!(why.contains("X1.000 Y2.000 Z3.000 R30.000") && why.contains("rotation_deg = [0, 0, 30.000]"), "{why}");
    assert!(why.contains("G21 G10 L2 P2 X1.000 Y2.000 Z3.000 R0.000"), "{why}");
}

#[test]
fn the_tool_length_counts_unless_the_program_states_its_own() {
    let begins = |states_length: bool| {
        let mut watch = linuxcnc(ExpectedZero { states_length, ..expected([10.0, 20.0, -30.0]) });
        watch.has_length(7.0);
        watch.begin()
    };
    let why = begins(false).unwrap();
    assert!(why.contains("with its tool length is X10.000 Y20.000 Z-23.000") && why.contains("send G49 to"), "{why}");
    assert_eq!(begins(true), None);
}

#[test]
fn a_sum_after_each_line_is_that_of_the_selected_offset() {
    let mut watch = linuxcnc(expected([10.0, 20.0, -30.0]));
    assert_eq!(watch.begin(), None);
    let at = |x: f64, y: f64, z: f64| [(b'X', x), (b'Y', y), (b'Z', z)];
    assert_eq!(watch.see_in_force(&at(10.0, 20.0, -30.0)), None);
    assert!(watch.see_in_force(&at(15.0, 20.0, -30.0)).is_some_and(|why| why.contains("X15.000")));
    watch.sent(b"G55");
    assert_eq!(watch.see_in_force(&at(1.0, 2.0, 3.0)), None);
    watch.sent(b"M30");
    assert_eq!(watch.see_in_force(&at(10.0, 20.0, -30.0)), None);
    // A tool length is no part of the sum; G92 shifts it by values that are not known.
    watch.sent(b"G43 H1");
    assert!(watch.see_in_force(&at(11.0, 20.0, -30.0)).is_some());
    watch.sent(b"G92 X0");
    assert_eq!(watch.see_in_force(&at(99.0, 20.0, -30.0)), None);
}

#[test]
fn a_control_that_states_only_the_offset_in_force_is_compared_when_it_is_selected() {
    let offsets = vec![(540, linear([1.0, 2.0, 3.0])), (550, linear([4.0, 5.0, 6.0]))];
    let zero = ExpectedZero { offsets, named: vec![540, 550], ..ExpectedZero::default() };
    let mut watch = ZeroWatch::new(ZeroSource::Marlin);
    watch.expect(zero);
    assert!(watch.begin().is_none() && !watch.is_complete());
    assert!(watch.sent(b"G54"));
    assert_eq!(watch.see_in_force(&[(b'X', 1.0), (b'Y', 2.0), (b'Z', 3.0)]), None);
    assert!(watch.sent(b"G55"));
    let why = watch.see_in_force(&[(b'X', 4.0), (b'Y', 5.0), (b'Z', 6.2)]).unwrap();
    assert!(why.contains("G55 of the control is X4.000 Y5.000 Z6.200"), "{why}");
}
