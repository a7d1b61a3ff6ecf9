//! A custom dialect detector: a post-processor writes Fanuc programs into files `.tap`, with its own name in the first line.
//!
//! Without the detector, ncfix takes the text for Sinumerik, in which this drilling cycle does not exist.

#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use ncfix::extend::dialect::{Detector, find};
use ncfix::prelude::{DialectChoice, Machine, Program, Registry};

/// Two holes. No word of this program belongs to one control only.
const PART: &str = "\
(SHOP POST 7)
G90 G0 X100. Y50. Z50.
G99 G81 Z-5. R2. F100.
X200.
G80
M30
";

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let fanuc = find("fanuc").ok_or("ncfix has no such dialect")?;
    let detector = Detector::new("shop post", fanuc, &["tap"], r"^\(SHOP POST \d+\)$")?;
    let registry = Registry::default().with_detector(detector);

    let program = Program::parse_with("holes.tap", PART, DialectChoice::Guess, &registry)?;
    let machine = Machine::demo();
    let found = program.check(&machine);
    print!("{}", found.drawn());
    let moves = program.moves(&machine)?.filter(Result::is_ok).count();
    println!("{moves} elements as a Fanuc");
    assert!(!found.has_errors() && moves > 6);

    // If the extension is not that of the detector, the pattern of a line decides.
    let other = Program::parse_with("holes.nc", PART, DialectChoice::Guess, &registry)?;
    assert_eq!(other.moves(&machine)?.count(), program.moves(&machine)?.count());

    // The built-in detectors alone do not recognize it.
    let plain = Program::parse("holes.tap", PART, DialectChoice::Guess);
    assert!(plain.map_or(true, |plain| plain.check(&machine).has_errors()));
    Ok(())
}
