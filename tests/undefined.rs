//! Variables without a value: one finding for each, whatever comes of it.

use crate::exec::check_codes;
use crate::support::{Shop, dialects, machine};

#[test]
fn a_variable_that_is_not_defined_is_said_once() {
    check_codes("G90 G0 X0 Y0 Z0\nR1=NIX\nX=NIX\nY=NIX+1\nNIX=5\nNIX[2]=5\nZ=OTHER\nM30", &["E0206:2", "E0206:7"]);
    check_codes("R1=$A_IN[1]\nR2=$A_IN[2]\nR3=$A_IN[1]\nM30", &["E0219:1", "E0219:2"]);
    let rs274 = |text, expected: &[&str]| crate::iso::check_codes("rs274", text, expected);
    rs274("G21 G90\nG0 X#<a>\nG0 Y[#<a>+1]\nG0 Z#<b>\nM2", &["E0206:2", "E0206:4"]);
    rs274("G21 G90\nG0 X#<_hal[a.b]>\nG0 Y#<_hal[a.b]>\nG0 Z#<_hal[a.c]>\nM2", &["E0219:2", "E0219:4"]);
    crate::iso::check_codes("fanuc", "G21 G90\n#1=#3012\n#2=#3012\n#3=#3011\nM30", &["E0219:2", "E0219:4"]);
}

#[test]
fn what_was_to_take_its_value_is_no_finding_of_its_own() {
    check_codes("DEF REAL DEPTH=NIX, WIDE=2\nG90 G0 X0 Y=WIDE Z=DEPTH\nG0 Z=WIDE\nM30", &["E0206:1"]);
    check_codes("DEF REAL DEPTH=1/0, WIDE=NIX\nG90 G0 X0 Y=WIDE Z=DEPTH\nM30", &["E0209:1", "E0206:1"]);
    let rs274 = |text, expected: &[&str]| crate::iso::check_codes("rs274", text, expected);
    rs274("G21 G90\n#<a>=#<b>\nG0 X#<a>\nG0 Y#<b>\n#<c>=[#<a>+1]\nG0 Z#<c>\nM2", &["E0206:2"]);
    rs274("G21 G90\n#<a>=[1/0]\nG0 X#<a>\nM2", &["E0209:2"]);
    // A value that it gets later is one.
    rs274("G21 G90\n#<a>=#<b>\n#<a>=2\nG0 X#<a>\nM2", &["E0206:2"]);
}

#[test]
fn nothing_is_written_whatever_is_not_said_again() {
    for (dialect, machine_name) in dialects() {
        let text = match dialect {
            "sinumerik" => "N1 G90 G71 G54 G0 X0 Y0 Z=NIX\nN2 Z=NIX\nN3 M30\n",
            "rs274" => "G21 G90 G54 G0 X0 Y0 Z#<nix>\nG0 Z#<nix>\nM2\n",
            "fanuc" => "G21 G90 G54 G0 X0. Y0. Z#3012\nG0 Z#3012\nM30\n",
            // What was never assigned counts as 0.
            _ => continue,
        };
        let shop = Shop::new().file("a.nc", text);
        let machine = machine(machine_name);
        let run = shop.run(["fix", "a.nc", "-o", "b.nc", "--dialect", dialect, "--machine", &machine]).exits(4);
        assert_eq!(run.stderr.matches("\nerror[").count() + usize::from(run.stderr.starts_with("error[")), 1);
        assert_eq!(shop.names(), ["a.nc"]);
    }
}

/// R parameters and the variables from #500 on keep their values when the power is off. snc counts them as 0 or null, and says so once for each.
#[test]
fn snc_names_the_values_of_earlier_programs_that_it_assumes() {
    let part = "G54 G17 G90\nT1 D1 M6\nS1000 M3\nG0 X=R1 Y50 Z10\nG1 X=R1+R2 F500\nM30\n";
    let shop = Shop::new()
        .file("part.mpf", part)
        .file("set.mpf", format!("R1=0 R2=50\n{part}"))
        .file("part.nc", "O1\nG21 G90 G54\nG0 X10. Y10.\nG0 X20. Y#500\nM30\n");
    let demo = machine("demo");
    let run = shop.run(["snc", "part.mpf", "--machine", &demo]).exits(0).says("warning[W0240]").says("\"$R[1]\" = ");
    assert_eq!(
        [run.stderr.matches("R1 keeps").count(), run.stderr.matches("R2 keeps").count()],
        [1, 1],
        "{}",
        run.stderr
    );
    assert!(!shop.run(["snc", "set.mpf", "--machine", &demo]).exits(0).stderr.contains("W0240"));
    let run = shop.run(["snc", "part.nc", "--machine", &demo, "--dialect", "fanuc"]).exits(0).says("#500 keeps");
    assert_eq!(run.stderr.matches("W0240").count(), 1, "{}", run.stderr);
    // A correction is refused.
    shop.run(["check", "part.mpf", "--machine", &demo]).says("E0219");
}
