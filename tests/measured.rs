//! `ncfix correct-readings`: corrections taken out of positions that were read.

use std::fmt::Write as _;

use ncfix_base::csv::Table;
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::State;
use ncfix_model::{Model, Solve};
use proptest::prelude::*;

use crate::bench_machine::{Random, load_machine};
use crate::support::{Run, Shop, machine};

/// A machine with X, Y and Z on the tool side and one error function.
fn simple_machine(motion: &str) -> String {
    let axis =
        |letter: &str, direction: &str| format!("[axis.{letter}]\ndirection = {direction}\ntravel_mm = [-100, 500]\n");
    format!(
        "[machine]\nname = \"simple\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n{}{}{}{motion}",
        axis("X", "[1, 0, 0]"),
        axis("Y", "[0, 1, 0]"),
        axis("Z", "[0, 0, 1]")
    )
}

fn one_error(component: &str, rest: &str) -> String {
    simple_machine(&format!("[[motion]]\ncomponent = \"{component}\"\n{rest}\n"))
}

fn shop(machine: &str, data: impl AsRef<[u8]>) -> Shop {
    Shop::new().file("m.toml", machine).file("data.csv", data)
}

fn measured(shop: &Shop) -> Run {
    let files = ["correct-readings", "data.csv", "-o", "out.csv", "--machine", "m.toml"];
    // Errors here are larger than those of machines.
    shop.run(files.into_iter().chain(["--max-correction", "2mm"]))
}

/// Corrects positions as a program would be, writes them as readings, and demands the positions back.
fn takes_back(name: &str, rotary: &str, solve: Solve, is_far_from_poles: impl Fn(&AxisVector) -> bool) {
    let (machine_data, errors) = load_machine(name);
    let model = Model::new(&machine_data, &errors);
    let axes: Vec<Axis> = machine_data.axis_set().iter().collect();
    let mut random = Random(7);
    let mut data: String = "run,note".into();
    axes.iter().for_each(|axis| write!(data, ",{axis}").unwrap());
    data.push_str(",tool_z_mm,dx_um,tool_x_mm\n");
    let mut wanted = Vec::new();
    while wanted.len() < 200 {
        let mut nominal = AxisVector::ZERO;
        for &axis in &axes {
            let [low, high] = machine_data.axis(axis).unwrap().travel.unwrap();
            nominal[axis] = if axis.is_rotary() {
                random.between(-3.0, 3.0).clamp(low, high)
            } else {
                random.between(low + 1.0, high - 1.0)
            };
        }
        if !is_far_from_poles(&nominal) {
            continue;
        }
        // As they are written, so that the correction starts from the same numbers.
        let tool = Vector::new(
            (random.between(-20.0, 20.0) * 1e3).round() / 1e3,
            0.0,
            (random.between(-200.0, -50.0) * 1e3).round() / 1e3,
        );
        let read = model.solve(&nominal, &tool, &State::default(), &nominal, solve).unwrap();
        write!(data, "A,\"a; \"\"b\"\", {}\"", wanted.len()).unwrap();
        for &axis in &axes {
            let value = if axis.is_rotary() { read[axis].to_degrees() } else { read[axis] };
            write!(data, ",{value:.13}").unwrap();
        }
        writeln!(data, ",{}, 1.50 ,{}", tool[2], tool[0]).unwrap();
        wanted.push(nominal);
    }
    let shop = Shop::new().file("data.csv", &data);
    let run = shop
        .run([
            "correct-readings",
            "data.csv",
            "-o",
            "out.csv",
            "--rotary",
            rotary,
            "--max-correction",
            "2mm",
            "--machine",
            &machine(name),
        ])
        .exits(0);
    assert!(run.stderr.contains("rows         200"), "{}", run.stderr);
    let out = shop.text("out.csv");
    let mut largest = 0.0_f64;
    for ((before, after), nominal) in data.lines().zip(out.lines()).skip(1).zip(&wanted) {
        let cells = |line: &str| line.rsplitn(axes.len() + 4, ',').map(str::to_owned).collect::<Vec<_>>();
        let (before, after) = (cells(before), cells(after));
        assert_eq!(before[..3], after[..3], "tool and reading");
        assert_eq!(before.last(), after.last(), "run and note");
        for (k, &axis) in axes.iter().rev().enumerate() {
            let value: f64 = after[3 + k].parse().unwrap();
            // Rotary axes at an arm of 500 mm.
            let off =
                if axis.is_rotary() { (value.to_radians() - nominal[axis]) * 500.0 } else { value - nominal[axis] };
            largest = largest.max(off.abs());
        }
        if rotary == "hold" {
            for (k, _) in axes.iter().rev().enumerate().filter(|(_, axis)| axis.is_rotary()) {
                assert_eq!(before[3 + k], after[3 + k]);
            }
        }
    }
    assert!(largest < 1e-6, "{name}: {largest} mm");
    // The correction was not nothing.
    let moved = data.lines().zip(out.lines()).filter(|(before, after)| before != after).count();
    assert_eq!(moved, 200);
}

#[test]
fn what_the_correction_added_is_subtracted_on_three_axes() {
    takes_back("demo", "correct", Solve::Full, |_| true);
}

#[test]
fn what_the_correction_added_is_subtracted_on_five_axes() {
    takes_back("esmaeili_xyz5", "correct", Solve::Full, |nominal| nominal[Axis::B].sin().abs() > 0.05);
    takes_back("esmaeili_huron", "correct", Solve::Full, |nominal| nominal[Axis::A].sin().abs() > 0.2);
}

#[test]
fn held_rotary_axes_stay_as_they_were_read() {
    takes_back("esmaeili_xyz5", "hold", Solve::PositionOnly, |_| true);
}

#[test]
fn next_to_a_pole_the_tip_is_where_the_reading_says() {
    let (machine_data, errors) = load_machine("esmaeili_xyz5");
    let model = Model::new(&machine_data, &errors);
    let mut data = String::from("X,Y,Z,B,C\n");
    let poses: Vec<f64> = vec![0.0, 1e-4, 0.01, 0.1, 0.3, 1.0, -0.05];
    poses.iter().for_each(|b| writeln!(data, "10,20,300,{b},30").unwrap());
    let shop = Shop::new().file("data.csv", &data);
    shop.run([
        "correct-readings",
        "data.csv",
        "-o",
        "out.csv",
        "--max-correction",
        "2mm",
        "--machine",
        &machine("esmaeili_xyz5"),
    ])
    .exits(0);
    for (line, &b) in shop.text("out.csv").lines().skip(1).zip(&poses) {
        let values: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let position = |values: &[f64]| {
            let mut position = AxisVector::ZERO;
            for (axis, &value) in [Axis::X, Axis::Y, Axis::Z, Axis::B, Axis::C].into_iter().zip(values) {
                position[axis] = if axis.is_rotary() { value.to_radians() } else { value };
            }
            position
        };
        let read = position(&[10.0, 20.0, 300.0, b, 30.0]);
        let nominal = position(&values);
        let error = model.tip_error_mm(&nominal, &read, &Vector::zeros(), &State::default());
        assert!(error.norm() < 2e-6, "B{b}: {} mm", error.norm());
    }
}

#[test]
fn the_example_of_the_thesis() {
    // Esmaeili 2021, Figure 5.5: an error of 1 mm in Y; the machine reads 4 mm where the height is 5 mm.
    let shop = shop(&one_error("EYY", "kind = \"polynomial\"\ncoefficients = [1.0]"), "X,Y,Z\n0,4,0\n");
    measured(&shop).exits(0).says("correction Y        1000 µm       1000 µm");
    let text = shop.text("out.csv");
    let y: f64 = text.lines().nth(1).unwrap().split(',').nth(1).unwrap().parse().unwrap();
    assert!((y - 5.0).abs() < 1e-8, "{text}");
    assert!(text.starts_with("X,Y,Z\n0,") && text.ends_with(",0\n"), "{text}");
}

#[test]
fn the_sense_of_motion_follows_from_the_rows_of_a_run_or_is_given() {
    let machine = one_error("EXX", "kind = \"backlash\"\nvalue_um = 10");
    // Runs a and b interleaved: forward in a, backward in b; the last row says itself.
    let data = "run,X,Y,Z,X_dir\na,10,0,0,\nb,50,0,0,\na,20,0,0,\nb,40,0,0,\na,20,0,0,\nb,45,0,0,-1\n";
    let shop = shop(&machine, data);
    measured(&shop).exits(0).says("unknown in 2 rows: the middle of the backlash is assumed");
    let text = shop.text("out.csv");
    let x: Vec<f64> = text.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    let wanted = [10.0, 50.0, 20.005, 39.995, 20.005, 44.995];
    assert!(x.iter().zip(wanted).all(|(x, wanted)| (x - wanted).abs() < 1e-7), "{x:?}");
}

#[test]
fn a_table_of_a_spreadsheet_keeps_its_manner() {
    let machine = one_error("EXX", "kind = \"polynomial\"\ncoefficients = [0.5]");
    let data = b"\xef\xbb\xbfsep=;\r\nX;\"Y\"; Z ;note\r\n\"1,25\";2;3;\"a;\r\nb\xe4\"\r\n\r\n-4,5 ;5;6;1,2,3\r\n;;;\r\n7;8;9;";
    let shop = shop(&machine, data);
    measured(&shop).exits(0);
    let wanted =
        b"\xef\xbb\xbfsep=;\r\nX;\"Y\"; Z ;note\r\n\"1,75000000\";2;3;\"a;\r\nb\xe4\"\r\n\r\n-4,00000000 ;5;6;1,2,3\r\n;;;\r\n7,50000000;8;9;";
    assert_eq!(shop.bytes("out.csv").escape_ascii().to_string(), wanted.escape_ascii().to_string());
}

#[test]
fn standard_streams_and_tabs_will_do() {
    let shop = Shop::new().file("m.toml", one_error("EXX", "kind = \"polynomial\"\ncoefficients = [0.5]"));
    let run = shop
        .run_with_input(
            ["correct-readings", "-", "-o", "-", "--max-correction", "2mm", "--machine", "m.toml"],
            b"X\tY\tZ\n1\t2\t3\n",
        )
        .exits(0);
    assert_eq!(run.stdout, "X\tY\tZ\n1.50000000\t2\t3\n");
}

#[test]
fn without_errors_nothing_changes() {
    let data = "Z,X,Y,remark\r\n1.50,2e1,+3,äöü\r\n";
    let shop = shop(&simple_machine(""), data);
    measured(&shop).exits(0);
    assert_eq!(shop.text("out.csv"), data);
}

/// Demands a refusal with a place, and that an older result is still there.
#[track_caller]
fn refused(data: impl AsRef<[u8]>, code: &str, place: &str, words: &str) {
    let shop = shop(&simple_machine(""), data).file("out.csv", "older");
    measured(&shop)
        .exits(4)
        .says(&format!("error[{code}]"))
        .says(&format!("data.csv:{place}"))
        .says(words)
        .says("nothing was written");
    assert_eq!((shop.text("out.csv").as_str(), shop.names().len()), ("older", 3));
}

#[test]
fn tables_that_are_none_are_refused_at_their_place() {
    refused("", "E0601", "1:1", "the table is empty");
    refused("1,2,3\n4,5,6\n", "E0601", "1:1", "the column names are missing");
    refused("X,Y,Z\n1,2,3\n4,5\n", "E0601", "3:1", "this row has 2 cells, the header has 3");
    refused("X,Y,Z\n1,2,3\n4,5,6,7\n", "E0601", "3:1", "this row has 4 cells, the header has 3");
    refused("X,Y,Z\n1,2,\"3\n", "E0601", "2:5", "not closed");
    refused("X,Y,Z\n1,\"2\"0,3\n", "E0601", "2:6", "between a closing quotation mark");
    refused(b"\xff\xfeX\0,\0Y\0", "E0601", "1:", "UTF-16");
}

#[test]
fn columns_must_fit_the_machine() {
    refused("X,Y\n1,2\n", "E0602", "1:1", "there is no column Z");
    refused("X,Y,z_mm\n1,2,3\n", "E0602", "1:5", "rename the column z_mm to Z");
    refused("X,Y,Z,B\n1,2,3,4\n", "E0602", "1:7", "the machine simple has no axis B");
    refused("X,Y,Z,C_dir\n1,2,3,1\n", "E0602", "1:7", "has no axis C");
    refused("X,Y,Z,X\n1,2,3,4\n", "E0602", "1:7", "given twice");
}

#[test]
fn cells_must_be_numbers() {
    refused("X,Y,Z\n1,2,3\n1,two,3\n", "E0603", "3:3", "'two' in the column Y is not a number");
    refused("X,Y,Z\n1,,3\n", "E0603", "2:3", "the cell of Y is empty");
    for cell in ["nan", "inf", "1e999", "0x10", "1 000", "1.2.3", "--1", "1mm"] {
        refused(format!("X,Y,Z\n{cell},2,3\n"), "E0603", "2:1", "is not a number");
    }
    refused("X;Y;Z\n1,5;2;3\n1;2.5;3\n", "E0603", "3:3", "has a different decimal sign from '1,5' in line 2");
    refused("X;Y;Z\n1.234,5;2;3\n", "E0603", "2:1", "thousands separators");
    refused("X,Y,Z,X_dir\n1,2,3,0.5\n", "E0603", "2:7", "the direction of approach of X is 0.5");
    refused("X,Y,Z,tool_x_mm\n1,2,3,long\n", "E0603", "2:7", "'long'");
    // All of them in one run.
    let shop = shop(&simple_machine(""), "X,Y,Z\na,2,3\n1,b,3\n");
    measured(&shop).exits(4).says("2:1").says("3:3").says("2 errors");
}

#[test]
fn positions_outside_the_travel_are_refused() {
    refused("X,Y,Z\n1,2,3\n1,2,500.1\n", "E0302", "3:5", "Z 500.1 mm is outside the travel of -100 … 500 mm");
}

#[test]
fn a_reading_without_a_position_is_refused() {
    // X that does not move whatever is commanded.
    let shop = shop(&one_error("EXX", "kind = \"polynomial\"\ncoefficients = [0, -1.0]"), "X,Y,Z\n0,2,3\n1,2,3\n");
    measured(&shop).exits(4).says("error[E0308]").says("data.csv:3:1").says("nothing was written");
    assert_eq!(shop.names(), ["data.csv", "m.toml"]);
}

#[test]
fn the_data_are_never_overwritten() {
    let shop = shop(&simple_machine(""), "X,Y,Z\n1,2,3\n");
    shop.run(["correct-readings", "data.csv", "-o", "data.csv", "--machine", "m.toml"]).exits(4).says("E0310");
    shop.run(["correct-readings", "data.csv", "-o", "m.toml", "--machine", "m.toml"]).exits(4).says("E0310");
    shop.run(["correct-readings", "none.csv", "-o", "out.csv", "--machine", "m.toml"])
        .exits(2)
        .says("cannot read none.csv");
    shop.run(["correct-readings", "data.csv", "--machine", "m.toml"]).exits(2);
}

proptest! {
    /// Whatever comes in: no panic, and a copy that replaces nothing is the same.
    #[test]
    fn any_bytes_are_a_table_or_a_finding(bytes in proptest::collection::vec(
        proptest::sample::select(b"\"\",,;;\r\n\n\t X Y1.5e-\xff\0=sep".to_vec()), 0..60))
    {
        let source = Source::new(FileId(0), "t", bytes.clone()).unwrap();
        let (table, findings) = Table::read(&source);
        prop_assert_eq!(table.is_some(), findings.is_empty());
        if let Some(table) = table {
            let mut out = Vec::new();
            table.copy(&mut out).finish().unwrap();
            prop_assert_eq!(out, bytes);
            for row in table.rows() {
                for column in 0..table.names().len() {
                    prop_assert_eq!(row.text(column), source.slice(row.place(column).span));
                }
            }
        }
    }
}

#[test]
fn axes_are_all_known() {
    // The columns of a table are found by the letters that axes print.
    assert_eq!(AXES.map(|axis| axis.to_string()).concat(), "XYZUVWABC");
}
