//! `ncfix import`: columns of time, temperature and other drivers stay with their readings, and rows that differ in them are no copies.

use crate::import::{import, shop};

/// Options that answer the questions of a list of displacements.
const LIST: &[&str] = &["--sign", "+", "--tool", "0"];

#[test]
fn a_thermal_log_keeps_time_and_temperatures() {
    // The first two rows have one reading; their times and temperatures differ.
    let rows = "t_s,T_bed_C,Load,X,Y,Z,dz_mm\n0,25.8,1,125,125,10,0.0100\n20,27.9,1,125,125,10,0.0100\n40,,1,125,125,10,0.0125\n";
    let shop = shop().file("log.csv", rows);
    let run = import(&shop, "log.csv", "tool.toml", LIST).exits(0);
    assert!(run.stderr.contains("columns that are kept: t_s, T_bed_C"), "{}", run.stderr);
    assert!(run.stderr.contains("columns that are not read: Load (line 1"), "{}", run.stderr);
    let expected = "setup,X,Y,Z,tool_x_mm,tool_y_mm,tool_z_mm,t_s,T_bed_C,dz_um\n\
        A,125,125,10,0,0,0,0,25.8,10\nA,125,125,10,0,0,0,20,27.9,10\nA,125,125,10,0,0,0,40,,12.5\n";
    assert_eq!(shop.text("out.csv"), expected);
    // A row that also has the same time and temperature is a copy.
    let shop = shop.file("copy.csv", rows.replace("20,27.9", "0,25.8"));
    import(&shop, "copy.csv", "tool.toml", LIST).exits(4).says("E0605").says("line 2,");
    // A cell that is no number does not stop the file.
    let shop = shop.file("words.csv", rows.replace("27.9", "cold"));
    import(&shop, "words.csv", "tool.toml", LIST).exits(0).says("columns that are not read: T_bed_C");
}

#[test]
fn a_long_table_of_a_laser_keeps_its_drivers() {
    let laser = ["--axis", "X", "--at", "Y200,Z100", "--sign", "+", "--tool", "0", "--material", "20C"];
    let long = "Target [mm];Dev [um];t_s;T_air_C\n0;1.0;0;20.5\n100;2.0;30;20.6\n200;3.5;60;20.8\n";
    // In a wide table, a line has readings of several times.
    let wide = "Target [mm];1+ [um];1- [um];T_air_C\n0;1.0;1.5;20.5\n100;2.0;2.5;20.6\n200;3.5;3.0;20.8\n";
    let shop = shop().file("long.csv", long).file("wide.csv", wide);
    import(&shop, "long.csv", "tool.toml", &laser).exits(0);
    assert!(shop.text("out.csv").lines().any(|line| line == "A,EXX,100,0,0,0,30,20.6,2"), "{}", shop.text("out.csv"));
    import(&shop, "wide.csv", "tool.toml", &laser).exits(0).says("columns that are not read: T_air_C");
}
