//! The cycle of a control: the kernel against the iterated solution, dosing, handover, rings, and the command.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::fs::FileExt as _;
use std::time::Duration;

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Machine, State};
use ncfix_model::{ErrorModel, Model, Solve, file::load};
use ncfix_tables::realtime::ring::{Client, Ring};
use ncfix_tables::realtime::{Cycle, Dosing, Kernel, Signals, Updater, handover};

use crate::bench_machine::{motion, polynomial};
use crate::machines::xyz_machine;
use crate::support::{Shop, machine as machine_path, repository};

fn sample(name: &str) -> (Machine, ErrorModel) {
    let bytes = std::fs::read(repository(&format!("samples/machines/{name}.toml"))).unwrap();
    load(&Source::new(FileId(0), name, bytes).unwrap()).0.unwrap()
}

fn at(values: &[(Axis, f64)]) -> AxisVector {
    let mut vector = AxisVector::ZERO;
    values.iter().for_each(|&(axis, value)| vector[axis] = value);
    vector
}

/// An XYZ machine whose X is too long by a share of the way, and has an offset, mm.
fn stretched(share: f64, offset_mm: f64) -> (Machine, Model) {
    let machine = xyz_machine();
    let errors = ErrorModel { motion: vec![motion("EXX", polynomial(&[offset_mm, share]))], ..ErrorModel::default() };
    let model = Model::new(&machine, &errors);
    (machine, model)
}

fn kernel((machine, model): &(Machine, Model)) -> Kernel {
    Kernel::new(machine, model, &Vector::zeros(), Solve::Full)
}

#[test]
fn kernels_agree_with_the_iterated_solution_on_every_sample() {
    for name in ["demo", "esmaeili_xyz5", "esmaeili_huron", "knee_mill", "maho700s", "universal_mill", "vmc"] {
        let (machine, errors) = sample(name);
        let model = Model::new(&machine, &errors);
        for mode in [Solve::Full, Solve::PositionOnly] {
            let kernel = Kernel::new(&machine, &model, &Vector::new(0.0, 0.0, -150.0), mode);
            let found = kernel.agreement(&machine, &model, 300);
            assert!(found.position_mm < 1e-5 && found.direction_rad < 1e-8, "{name}: {found:?}");
            assert!(found.unequal == 0 && found.largest_mm > 0.01, "{name}: {found:?}");
        }
    }
}

#[test]
fn next_to_a_pole_the_damping_is_the_same() {
    let (machine, errors) = sample("esmaeili_xyz5");
    let model = Model::new(&machine, &errors);
    let (tool_mm, state) = (Vector::new(0.0, 0.0, -150.0), State::default());
    let kernel = Kernel::new(&machine, &model, &tool_mm, Solve::Full);
    for tilt in -60..=60 {
        let values =
            [(Axis::X, 100.0), (Axis::Y, 300.0), (Axis::Z, 150.0), (Axis::B, 1e-3 * f64::from(tilt)), (Axis::C, 0.5)];
        let nominal = at(&values);
        let exact = model.solve(&nominal, &tool_mm, &state, &nominal, Solve::Full).unwrap();
        let fast = nominal + kernel.correction(&nominal, &state).unwrap();
        assert!((fast - exact).max_abs(&[Axis::X, Axis::Y, Axis::Z]) < 1e-6, "{tilt}");
        assert!((fast - exact).max_abs(&[Axis::B, Axis::C]) < 1e-9, "{tilt}");
    }
}

#[test]
fn a_stretched_axis_has_the_correction_of_arithmetic() {
    // The tip is at x (1 + s) + a: the command for x is (x − a) / (1 + s).
    let stretched = stretched(1e-4, 0.02);
    let correction = kernel(&stretched).correction(&at(&[(Axis::X, 100.0)]), &State::default()).unwrap();
    assert!((correction[Axis::X] - ((100.0 - 0.02) / 1.0001 - 100.0)).abs() < 1e-9, "{correction:?}");
    assert_eq!(correction[Axis::Y], 0.0);
}

#[test]
fn functions_of_two_axes_and_short_waves_are_not_left_out() {
    let text = std::fs::read_to_string(repository("samples/machines/demo.toml")).unwrap();
    let more = "\n[[motion]]\ncomponent = \"EAY\"\nkind = \"cross\"\ncoefficients = [0, 1e-9]\nwith = \"X\"\nwith_coefficients = [0, 1.0]\n\
                [[motion]]\ncomponent = \"EYZ\"\nkind = \"periodic\"\nperiod_mm = 5.0\namplitude_um = 4\n\
                [[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 6\n";
    let source = Source::new(FileId(0), "more", (text + more).into_bytes()).unwrap();
    let (machine, errors) = load(&source).0.unwrap();
    let model = Model::new(&machine, &errors);
    let kernel = Kernel::new(&machine, &model, &Vector::new(0.0, 0.0, -100.0), Solve::Full);
    assert_eq!([Axis::Y, Axis::Z].map(|axis| kernel.direct_functions(axis)), [1, 1]);
    let found = kernel.agreement(&machine, &model, 300);
    assert!(found.position_mm < 2e-5, "{found:?}");
}

#[test]
fn a_cycle_doses_clamps_holds_and_knows_the_sense() {
    let machine = xyz_machine();
    let [low, high] = machine.axis(Axis::X).unwrap().travel.unwrap();
    let reversal =
        ncfix_model::motion::EntryFunction::Backlash(ncfix_model::motion::backlash::Backlash::constant(6e-3));
    let errors = ErrorModel {
        motion: vec![motion("EXX", polynomial(&[5e-3])), motion("EXX", reversal)],
        ..ErrorModel::default()
    };
    let model = Model::new(&machine, &errors);
    let (_publisher, subscriber) = handover(Kernel::new(&machine, &model, &Vector::zeros(), Solve::Full));
    let mut cycle = Cycle::new(subscriber, Dosing::new(2e-3, 1e-6), 1e-3, 1e-6);
    let mut step = |x: f64| {
        let answer = cycle.step(&at(&[(Axis::X, x)]));
        ((answer.correction[Axis::X] * 1e6).round() / 1e3, answer.signals)
    };
    let middle = f64::midpoint(low, high);
    let none = Signals::default();
    // −5 µm without a sense, −8 µm upwards, −2 µm downwards, by no more than 2 µm a cycle.
    assert_eq!(step(middle), (-2.0, Signals::DOSED));
    assert_eq!(step(middle), (-4.0, Signals::DOSED));
    assert_eq!(step(middle), (-5.0, none));
    assert_eq!(step(middle + 1.0), (-7.0, Signals::DOSED));
    assert_eq!(step(middle + 1.0), (-8.0, none));
    // A flicker of less than an increment is no reversal.
    assert_eq!(step(middle + 0.9995), (-8.0, none));
    assert_eq!(step(middle), (-6.0, Signals::DOSED));
    for no_number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(step(no_number), (-6.0, Signals::HELD));
    }
    assert_eq!(step(middle), (-4.0, Signals::DOSED));
    assert_eq!(step(middle), (-2.0, none));
    let beyond = step(high + 10.0);
    assert!(beyond.1.has(Signals::BEYOND) && beyond.0 == -4.0, "{beyond:?}");
    assert!(step(1e300).1.has(Signals::BEYOND));
}

#[test]
fn a_new_kernel_comes_without_a_jump_and_the_newest_wins() {
    let [old, new, newest] = [1e-3, 50e-3, 21e-3].map(|offset| kernel(&stretched(0.0, offset)));
    let (mut publisher, subscriber) = handover(old);
    let mut cycle = Cycle::new(subscriber, Dosing::new(1e-3, 1e-6), 1e-3, 1e-6);
    assert_eq!(cycle.step(&AxisVector::ZERO).correction[Axis::X], -1e-3);
    publisher.publish(new);
    // The cycle stands still meanwhile: this one waits until it has taken the one before.
    publisher.publish(newest);
    assert!(!publisher.pump());
    let first = cycle.step(&AxisVector::ZERO);
    assert!(first.signals.has(Signals::RENEWED));
    assert!(publisher.pump());
    let mut last = first.correction[Axis::X];
    for _ in 0..40 {
        let now = cycle.step(&AxisVector::ZERO).correction[Axis::X];
        assert!((now - last).abs() <= 1e-3 + 1e-15, "{last} {now}");
        last = now;
    }
    assert!((last + 21e-3).abs() < 1e-12);
    // Without a publisher the kernel in force stays.
    drop(publisher);
    assert_eq!(cycle.step(&AxisVector::ZERO).signals, Signals::default());
}

#[test]
fn a_thread_renews_the_kernel_while_the_cycle_runs() {
    let (publisher, subscriber) = handover(kernel(&stretched(0.0, 1e-3)));
    let mut count = 0;
    let updater = Updater::start(publisher, Duration::from_millis(1), move || {
        count += 1;
        Some(kernel(&stretched(0.0, f64::from(count % 7) * 1e-3)))
    });
    let mut cycle = Cycle::new(subscriber, Dosing::new(1e-4, 1e-6), 1e-3, 1e-6);
    let (mut last, mut renewed) = (0.0, 0);
    while renewed < 20 {
        let answer = cycle.step(&AxisVector::ZERO);
        assert!((answer.correction[Axis::X] - last).abs() <= 1e-4 + 1e-15);
        last = answer.correction[Axis::X];
        renewed += u32::from(answer.signals.has(Signals::RENEWED));
    }
    drop(updater);
    cycle.step(&AxisVector::ZERO);
}

#[test]
fn rings_carry_set_points_there_and_corrections_back() {
    let folder = tempfile::tempdir().unwrap();
    let file = File::options().read(true).write(true).create_new(true).open(folder.path().join("ring")).unwrap();
    let (_publisher, subscriber) = handover(kernel(&stretched(0.0, 7e-3)));
    let mut cycle = Cycle::new(subscriber, Dosing::new(1.0, 1.0), 1e-3, 1e-6);
    assert!(Client::open(&file).is_err());
    let axes = xyz_machine().axis_set();
    assert!(Ring::create(&file, axes, 3).is_err());
    let ring = Ring::create(&file, axes, 4).unwrap();
    // The head as documented, read without the code under test.
    let bytes = std::fs::read(folder.path().join("ring")).unwrap();
    assert_eq!(&bytes[..8], b"NCFIXRT1");
    let word = |index: usize| u64::from_le_bytes(bytes[8 * index..8 * index + 8].try_into().unwrap());
    assert_eq!([1, 2, 5, 6].map(word), [1, 3, 4, 8]);
    assert_eq!(&bytes[24..40], b"XYZ\0\0\0\0\0\0\0\0\0\0\0\0\0");
    assert_eq!(bytes.len(), 1024 + 2 * 4 * 8 * 8);
    let client = Client::open(&file).unwrap();
    assert_eq!(client.axes(), [Axis::X, Axis::Y, Axis::Z]);
    assert_eq!(ring.serve(&mut cycle), Ok(None));
    for round in 0..5_u64 {
        for k in 0..4 {
            assert!(client.put(10 * round + k, &at(&[(Axis::X, k as f64), (Axis::Z, 2.5)])));
        }
        assert!(!client.put(99, &AxisVector::ZERO), "the ring is full");
        while ring.serve(&mut cycle).unwrap().is_some() {}
        for k in 0..4 {
            let (number, answer) = client.take().unwrap();
            assert_eq!(number, 10 * round + k);
            assert!((answer.correction[Axis::X] + 7e-3).abs() < 1e-12, "{answer:?}");
        }
        assert!(client.take().is_none());
    }
    // The first set-point of the last round lies where byte 1024 says: number and X Y Z.
    let bytes = std::fs::read(folder.path().join("ring")).unwrap();
    assert_eq!(u64::from_le_bytes(bytes[1024..1032].try_into().unwrap()), 40);
    assert_eq!(f64::from_le_bytes(bytes[1048..1056].try_into().unwrap()), 2.5);
    assert!(!ring.beat());
    client.stop();
    assert!(ring.beat());
    // A control that goes over the end of the ring: 20 set-points were read, 25 written; or one that read corrections that there are not.
    for (byte, count) in [(128, 25_u64), (512, 21)] {
        let before = ring.serve(&mut cycle);
        assert_eq!(before, Ok(None));
        let own =
            u64::from_le_bytes(std::fs::read(folder.path().join("ring")).unwrap()[byte..byte + 8].try_into().unwrap());
        file.write_all_at(&count.to_le_bytes(), byte as u64).unwrap();
        assert!(ring.serve(&mut cycle).is_err(), "{byte}");
        file.write_all_at(&own.to_le_bytes(), byte as u64).unwrap();
    }
}

/// The same orders in a ring (Spaan 1995, Fig. 6.2, processes 2 and 5): 100 µrad times the height of the tip, 200 mm with a tool of 100 mm and 50 mm with one
/// of 250 mm. Bytes are read and written as documented.
#[test]
fn another_tool_and_a_reference_run_are_orders_of_a_ring() {
    let shop = tilted_shop();
    let path = shop.path("ring");
    let name = path.display().to_string();
    let arguments =
        ["realtime", "--machine", "m.toml", "--ring", &name, "--records", "4", "--tool", "100", "--dose-um", "8"];
    let child = shop.command(arguments).spawn().unwrap();
    let mut client = None;
    for _ in 0..2000 {
        let opened = File::options().read(true).write(true).open(&path);
        client =
            opened.ok().filter(|file| file.metadata().unwrap().len() > 0).and_then(|file| Client::open(&file).ok());
        if client.is_some() {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let client = client.unwrap();
    let here = at(&[(Axis::Z, 300.0)]);
    let taken = || {
        for _ in 0..2000 {
            if let Some((_, answer)) = client.take() {
                return (answer.correction[Axis::X] * 1e3).round();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("no answer");
    };
    let mut found = Vec::new();
    for number in 0..3 {
        assert!(client.put(number, &here));
        found.push(taken());
    }
    assert!(client.put_after_reference(3, &here));
    found.push(taken());
    assert!(client.put_with_tool(4, &here, &[0.0, 0.0, -250.0]));
    found.push(taken());
    // More set-points than the ring has records: no order of an earlier round comes again.
    for number in 5..12 {
        assert!(client.put(number, &here));
        found.push(taken());
    }
    assert_eq!(found, [-8.0, -16.0, -20.0, -8.0, -5.0, -5.0, -5.0, -5.0, -5.0, -5.0, -5.0, -5.0]);
    // The tool of the order stands at byte 832, and the order of set-point 4 after its number and three values.
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(f64::from_le_bytes(bytes[848..856].try_into().unwrap()), -250.0);
    // A tool of 10 m has no kernel.
    assert!(client.put_with_tool(12, &here, &[0.0, 0.0, -10_000.0]));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(4));
    assert!(String::from_utf8_lossy(&output.stderr).contains("the tool of the set-points has no kernel"));
}

#[test]
fn every_line_has_its_correction() {
    let shop = Shop::new();
    let demo = machine_path("demo");
    let command = ["realtime", "--machine", &demo, "--tool", "120", "--dose-um", "off", "--latency"];
    let run = shop.run_with_input(command, b"X,Y,Z\n350,250,200\n351,250,200\n900,250,200\n").exits(0);
    let stdout = run.stdout.clone();
    let lines: Vec<&str> = stdout.lines().collect();
    assert_eq!(lines[0], "dX_um,dY_um,dZ_um,signals");
    assert_eq!(lines.len(), 4);
    assert!(lines[1].ends_with(",") && lines[3].ends_with(",beyond"), "{}", run.stdout);
    let (machine, errors) = sample("demo");
    let nominal = at(&[(Axis::X, 350.0), (Axis::Y, 250.0), (Axis::Z, 200.0)]);
    let exact = Model::new(&machine, &errors)
        .solve(&nominal, &Vector::new(0.0, 0.0, -120.0), &State::default(), &nominal, Solve::Full)
        .unwrap();
    for (axis, cell) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(lines[1].split(',')) {
        let um: f64 = cell.parse().unwrap();
        assert!((um - 1e3 * (exact[axis] - nominal[axis])).abs() < 0.02, "{axis} {cell}");
    }
    run.says("200 intervals per axis").says("3 set-points; 1 beyond").says("p99.9");
    let words = shop.run_with_input(command, b"X350 Y250 Z200\nX351\n").exits(0).stdout;
    assert_eq!(words.lines().collect::<Vec<_>>(), lines[..3]);
}

/// Z tilted about Y by 100 µrad moves the tip by 100 µrad times its height above the origin: Z 300 with a tool of 100 mm stands at 200, one of 250 mm
/// at 50 mm.
fn tilted_shop() -> Shop {
    let axes = "[axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [-200, 200]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-200, 200]\n\
                [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 400]\n";
    let machine = format!(
        "[machine]\nname = \"m\"\ntopology = \"wXYFZSt\"\ncontroller = \"sinumerik\"\n{axes}\
         [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n[location]\nEB0Z = 100\n"
    );
    Shop::new().file("m.toml", machine)
}

/// The corrections of X in µm, and the signals, of an answer to lines.
fn x_of(stdout: &str) -> Vec<(f64, String)> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[0].parse().unwrap(), cells[cells.len() - 1].to_owned())
    };
    stdout.lines().skip(1).map(row).collect()
}

/// Spaan 1995, Fig. 6.2, processes 2 and 5.
#[test]
fn another_tool_and_a_reference_run_are_lines_too() {
    let shop = tilted_shop();
    let words = ["realtime", "--machine", "m.toml", "--tool", "100", "--dose-um", "off"];
    let run = shop.run_with_input(words, b"X0 Y0 Z300\ntool 250\nX0\nX0\ntool 0,0,-100\nX0\n").exits(0);
    let rows = x_of(&run.stdout);
    assert_eq!(rows.len(), 4, "{}", run.stdout);
    for ((x, signals), (expected, word)) in
        rows.iter().zip([(-20.0, ""), (-5.0, "renewed"), (-5.0, ""), (-20.0, "renewed")])
    {
        assert!((x - expected).abs() < 0.01 && signals == word, "{}", run.stdout);
    }
    // The control has dropped its correction, which begins at zero again: at most 8 µm a set-point.
    let words = ["realtime", "--machine", "m.toml", "--tool", "100", "--dose-um", "8"];
    let rows = x_of(&shop.run_with_input(words, b"X0 Y0 Z300\nX0\nX0\nreset\nX0\nX0\nX0\n").exits(0).stdout);
    let found: Vec<f64> = rows.iter().map(|(x, _)| x.round()).collect();
    assert_eq!(found, [-8.0, -16.0, -20.0, -8.0, -16.0, -20.0]);
}

/// Two heads whose gauge points are off by 5 and −7 µm along X, so that the commands need −5 and 7 µm.
fn two_heads() -> Shop {
    let axes = "[axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [-200, 200]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-200, 200]\n\
                [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 400]\n";
    let heads = "[[head]]\nname = \"a\"\nselect = [\"M81\"]\n[head.location]\nEX0S = 5\n\
                 [[head]]\nname = \"b\"\nselect = [\"M82\"]\nstart = true\naxis = [0, 1, 0]\n[head.location]\nEX0S = -7\n";
    let machine = format!("[machine]\nname = \"m\"\ntopology = \"wXYFZSt\"\ncontroller = \"sinumerik\"\n{axes}{heads}");
    Shop::new().file("m.toml", machine)
}

#[test]
fn another_head_with_its_tool_is_a_line() {
    let words = ["realtime", "--machine", "m.toml", "--head", "a", "--dose-um", "off"];
    let input = b"X0 Y0 Z300\nhead b 50\nX0\nX0\nhead a 0,0,-80\nX0\n";
    let run = two_heads().run_with_input(words, input).exits(0);
    let expected = [(-5.0, ""), (7.0, "renewed"), (7.0, ""), (-5.0, "renewed")];
    let rows = x_of(&run.stdout);
    assert_eq!(rows.len(), expected.len(), "{}", run.stdout);
    for ((x, signals), (wanted, word)) in rows.iter().zip(expected) {
        assert!((x - wanted).abs() < 0.01 && signals == word, "{}", run.stdout);
    }
    // Numbers are those of the machine file, whichever head is active at the start.
    run.says("heads: 0 a, 1 b");
    for (line, what) in [
        ("head c 50", "the control selects the head c, and the machine m has 0 a, 1 b"),
        ("head b", "head needs a name and a tool"),
        ("head b 5x", "'5x' is neither a length nor a vector"),
    ] {
        let run = two_heads().run_with_input(words, format!("X0 Y0 Z300\n{line}\nX0\n").as_bytes()).exits(4);
        assert_eq!(run.stdout.lines().count(), 2, "{line}: {}", run.stdout);
        run.says("E0801").says(what);
    }
    // Which head is active now is not known from the machine file.
    let run = two_heads().run_with_input(&words[..3], b"X0 Y0 Z300\n").exits(2);
    assert!(run.stderr.contains("choose it with --head"), "{}", run.stderr);
}

#[test]
fn another_head_is_an_order_of_a_ring_and_an_unknown_order_ends_the_run() {
    let shop = two_heads();
    let path = shop.path("ring");
    let name = path.display().to_string();
    for wrong in [9, 3] {
        let arguments =
            ["realtime", "--machine", "m.toml", "--head", "b", "--ring", &name, "--records", "4", "--dose-um", "off"];
        let child = shop.command(arguments).spawn().unwrap();
        let mut client = None;
        for _ in 0..2000 {
            let opened = File::options().read(true).write(true).open(&path);
            client =
                opened.ok().filter(|file| file.metadata().unwrap().len() > 0).and_then(|file| Client::open(&file).ok());
            if client.is_some() {
                break;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let client = client.unwrap();
        let here = at(&[(Axis::Z, 300.0)]);
        let taken = || {
            for _ in 0..2000 {
                if let Some((_, answer)) = client.take() {
                    return (answer.correction[Axis::X] * 1e3).round();
                }
                std::thread::sleep(Duration::from_millis(5));
            }
            panic!("no answer");
        };
        let mut found = Vec::new();
        assert!(client.put(0, &here));
        found.push(taken());
        assert!(client.put_with_head(1, &here, 0, &[0.0, 0.0, -80.0]));
        found.push(taken());
        assert!(client.put(2, &here));
        found.push(taken());
        assert_eq!(found, [7.0, -5.0, -5.0]);
        // The number of the head of the order stands at byte 856.
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(u64::from_le_bytes(bytes[856..864].try_into().unwrap()), 0);
        // No order has the number 9, and no head the number 2.
        let is_put =
            if wrong == 9 { client.put_after(3, &here, wrong) } else { client.put_with_head(3, &here, 2, &[0.0; 3]) };
        assert!(is_put);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(4));
        let text = String::from_utf8_lossy(&output.stderr);
        let what = if wrong == 9 { "the order 9, which does not exist" } else { "the control selects the head 2" };
        assert!(text.contains(what) && client.take().is_none(), "{text}");
    }
}

/// 100 µrad at 9.7 m is 0.97 mm: more than is allowed. No set-point after it has an answer.
#[test]
fn a_tool_whose_correction_is_too_large_ends_the_run() {
    let run =
        tilted_shop().run_with_input(["realtime", "--machine", "m.toml"], b"X0 Y0 Z300\ntool 10000\nX0\n").exits(4);
    assert_eq!(run.stdout.lines().count(), 2, "{}", run.stdout);
    run.says("E0303").says("E0801").says("1 set-points before it were answered");
}

#[test]
fn five_axes_have_corrections_in_their_units() {
    let path = machine_path("esmaeili_xyz5");
    let run = Shop::new()
        .run_with_input(
            ["realtime", "--machine", &path, "--dose-um", "off", "--dose-urad", "off"],
            b"X0 Y0 Z100 B30 C0\n",
        )
        .exits(0);
    assert!(run.stdout.starts_with("dX_um,dY_um,dZ_um,dB_urad,dC_urad,signals\n"), "{}", run.stdout);
}

#[test]
fn a_line_that_is_no_set_point_ends_the_run() {
    let demo = machine_path("demo");
    let run = Shop::new().run_with_input(["realtime", "--machine", &demo], b"X1 Y2 Z3\nX1 Y2x\nX1\n").exits(4);
    assert_eq!(run.stdout.lines().count(), 2, "{}", run.stdout);
    run.says("E0801").says("standard input:2:5: '2x' is not a number").says("1 set-points before it were answered");
}

#[test]
fn a_model_with_huge_corrections_is_refused() {
    let demo = machine_path("demo");
    let run = Shop::new().run(["realtime", "--machine", &demo, "--max-correction", "5um"]).exits(4);
    run.says("E0303");
}

#[test]
fn a_kernel_that_cannot_follow_the_model_is_pointed_out() {
    let text = std::fs::read_to_string(repository("samples/machines/demo.toml")).unwrap();
    // 0.15 mm within 0.6 mm: a slope of a quarter, of which two steps leave a sixteenth.
    let steep = "\n[[motion]]\ncomponent = \"EXX\"\nkind = \"periodic\"\nperiod_mm = 4.0\namplitude_um = 150\n";
    let shop = Shop::new().file("m.toml", text + steep);
    let run = shop.run_with_input(["realtime", "--machine", "m.toml"], b"X1 Y2 Z3\n").exits(0);
    run.says("W0801").says("additional functions: 1 of X");
}

/// A machine whose X grows by 10 µm per K of a sensor.
fn warm_shop(state: &str) -> Shop {
    let text = std::fs::read_to_string(repository("samples/machines/demo.toml")).unwrap();
    let drift = "\n[[drift]]\ndirection = \"X\"\nsensors = [{ name = \"spindle\", um_per_K = 10.0 }]\n";
    Shop::new().file("m.toml", text + drift).file("state.toml", state)
}

#[test]
fn a_state_that_changes_renews_the_kernel_and_the_dosing_makes_it_no_jump() {
    let shop = warm_shop("[temperature_C]\nspindle = 20.0\n");
    let arguments =
        ["realtime", "--machine", "m.toml", "--state", "state.toml", "--update-s", "0.1", "--dose-um", "0.5"];
    let mut child = shop.command(arguments).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(output.next().unwrap().unwrap().starts_with("dX_um"));
    let mut ask = || {
        input.write_all(b"X350 Y250 Z200\n").unwrap();
        let line = output.next().unwrap().unwrap();
        let x: f64 = line.split(',').next().unwrap().parse().unwrap();
        (x, line)
    };
    let mut last = 0.0;
    let settled = loop {
        let (x, line) = ask();
        if line.ends_with(',') {
            break x;
        }
    };
    last += settled;
    std::fs::write(shop.path("state.toml"), "[temperature_C]\nspindle = 21.0\n").unwrap();
    let mut is_renewed = false;
    for _ in 0..2000 {
        let (x, line) = ask();
        assert!((x - last).abs() <= 0.5 + 1e-3, "{last} {line}");
        last = x;
        is_renewed |= line.contains("renewed");
        if is_renewed && line.ends_with(',') {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    // 1 K makes 10 µm, which are taken back.
    assert!(is_renewed && (settled - last - 10.0).abs() < 0.01, "{settled} {last}");
    drop(input);
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_state_that_breaks_leaves_the_kernel_in_force() {
    let shop = warm_shop("[temperature_C]\nspindle = 25.0\n");
    let arguments =
        ["realtime", "--machine", "m.toml", "--state", "state.toml", "--update-s", "0.1", "--dose-um", "off"];
    let mut child = shop.command(arguments).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut ask = || {
        input.write_all(b"X350 Y250 Z200\n").unwrap();
        output.next().unwrap().unwrap()
    };
    ask();
    let before = ask();
    std::fs::write(shop.path("state.toml"), "[temperature_C\n").unwrap();
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(ask(), before);
    drop(input);
    let errors = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
    assert!(errors.contains("W0802") && errors.contains("the kernel was not updated"), "{errors}");
    assert!(child.wait().unwrap().success());
}

#[test]
fn the_command_serves_a_ring_until_the_control_ends_it() {
    let shop = Shop::new();
    let path = shop.path("ring");
    let name = path.display().to_string();
    let demo = machine_path("demo");
    let arguments = ["realtime", "--machine", &demo, "--ring", &name, "--records", "8", "--dose-um", "off"];
    let child = shop.command(arguments).spawn().unwrap();
    let mut client = None;
    for _ in 0..2000 {
        let opened = File::options().read(true).write(true).open(&path);
        client =
            opened.ok().filter(|file| file.metadata().unwrap().len() > 0).and_then(|file| Client::open(&file).ok());
        if client.is_some() {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let client = client.unwrap();
    assert!(client.put(42, &at(&[(Axis::X, 350.0), (Axis::Y, 250.0), (Axis::Z, 200.0)])));
    let (number, answer) = loop {
        if let Some(taken) = client.take() {
            break taken;
        }
        std::thread::yield_now();
    };
    assert!(number == 42 && answer.correction[Axis::X] != 0.0);
    shop.run(["realtime", "--machine", &demo, "--ring", &name]).exits(2).says("already exists");
    client.stop();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("1 set-points"));
    assert!(!path.exists());
}
