//! Corrects a part program for the measured errors of one machine, and prints the error of the tool before and after.

#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use ncfix::prelude::*;

/// A pocket in a plate, milled on a Sinumerik.
const PART: &str = "\
N10 G17 G90 G71 G500
N20 G0 X50 Y50 Z100
N30 Z5
N40 G1 Z-2 F300
N50 X600 F800
N60 Y400
N70 G3 X550 Y450 CR=50
N80 G1 X50
N90 Y50
N100 G0 Z100
N110 M30
";

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    // With your own machine file: Machine::from_file("mill.toml")?
    let machine = Machine::demo();
    let program = Program::parse("part.mpf", PART, DialectChoice::Sinumerik)?;

    let found = program.check(&machine);
    print!("{}", found.drawn());
    if found.has_errors() {
        return Err("the program has errors on this machine".into());
    }

    let mut options = Options::default();
    options.tolerance_mm = 0.0005;
    let correction = program.correct(&machine, &options);

    // The text streams into any writer: a file, a socket.
    let mut text = Vec::new();
    let report = correction.write_to(&mut text)?;
    print!("{}", report.table());

    // The corrected program is executed again and compared with the original.
    let corrected = Program::parse("part_corrected.mpf", text, DialectChoice::Sinumerik)?;
    let verified = program.verify(&corrected, &machine)?;
    let (before, after) = (verified.before.unwrap_or_default(), verified.after.unwrap_or_default());
    println!("largest error of the tool: {:.2} µm before, {:.2} µm after", before.max_um, after.max_um);
    assert!(after.max_um < 1.0 && before.max_um > 10.0);
    Ok(())
}
