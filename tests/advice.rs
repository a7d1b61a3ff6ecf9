//! Advice of diagnostics: it names the cause, and it helps when it is followed.

use super::support::Shop;

/// A mill whose table carries X and Y, without errors.
const MILL: &str = "[machine]
name = \"mill\"
topology = \"wXYFZSt\"
[axis.X]
direction = [-1, 0, 0]
travel_mm = [0, 500]
[axis.Y]
direction = [0, -1, 0]
travel_mm = [0, 400]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [0, 300]
[zero_offset.G54]
set = \"absolute\"
X_mm = 100
Y_mm = 100
Z_mm = 0
[[tool]]
number = 1
length_mm = 100
";

fn shop(program: &str) -> Shop {
    Shop::new().file("mill.toml", MILL).file("part.mpf", program)
}

fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split_whitespace()
}

const FIX: &str = "part.mpf -o out.mpf --machine mill.toml";

#[test]
fn a_decimal_comma_is_named_in_every_language() {
    for (dialect, block) in
        [("sinumerik", "G0 X10,5"), ("fanuc", "G0 X10,5"), ("rs274", "G0 X10,5"), ("grundig", "N1 G0 X10,5")]
    {
        let run =
            shop(&format!("{block}\n")).run(words(&format!("check part.mpf --machine mill.toml --dialect {dialect}")));
        run.exits(3).says("a comma within a number").says("write a decimal point, for example X10.5");
    }
}

#[test]
fn a_tool_with_a_name_gets_a_name_and_a_number() {
    let program = "G54 G90 G71\nT=\"MILL_10\" M6\nD1\nG0 X10 Y10 Z150\nG1 X20 F100\nM30\n";
    shop(program).run(words(FIX)).exits(4).says("T=\"MILL_10\" D1").says("with this text as its name, and a number");
    let tool = "[[tool]]\nnumber = 2\nname = \"MILL_10\"\nlength_mm = 80\n";
    shop(program).file("mill.toml", format!("{MILL}{tool}")).run(words(FIX)).exits(0);
}

#[test]
fn what_is_repeated_is_said_once_with_its_lines() {
    let program = "G54 G90 G71\nT7 M6\nD1\nG0 X10 Y10 Z150\nG1 X20 F100\nD1\nG1 X30\nD1\nG1 X40\nM30\n";
    let run = shop(program).run(words(FIX)).exits(4);
    assert_eq!(run.stderr.matches("T7 D1 has no value in the machine file").count(), 1, "{}", run.stderr);
    run.says("  = also in lines 3, 6 and 8\n").says("4 errors");
}

#[test]
fn beyond_the_travel_the_size_of_the_correction_is_no_matter() {
    let steep = format!("{MILL}[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n");
    let program = "G54 G90 G71\nT1 M6\nD1\nG0 X10 Y10 Z150\nG1 X9000 F100\nM30\n";
    let run = shop(program).file("mill.toml", steep).run(words(FIX)).exits(4).says("error[E0302]: X 91");
    assert!(!run.stderr.contains("E0303"), "{}", run.stderr);
}

#[test]
fn the_forgotten_machine_comes_before_what_follows_from_it() {
    // The demo machine has no rotary axes.
    let program = "G54 G90 G71 G0 X300 Y200 Z200\nTRAORI\nG1 X310 A3=0 B3=0 C3=1 F100\nM30\n";
    let run = Shop::new().file("part.mpf", program).run(words("check part.mpf")).exits(4);
    assert!(run.stderr.starts_with("warning[W0304]"), "{}", run.stderr);
    assert!(run.stderr.contains("error["), "{}", run.stderr);
}

#[test]
fn a_program_is_not_a_set_up() {
    let program = "G54 G90 G71 D0\nG0 X10 Y10 Z150\nG1 X20 F100\nM30\n";
    for header in ["", "%_N_PART_UFR\n"] {
        let shop = shop(program).file("other.mpf", format!("{header}{program}"));
        let run = shop.run(words("part.mpf -o out.mpf --machine mill.toml --setup other.mpf"));
        let run =
            run.exits(if header.is_empty() { 4 } else { 3 }).says("give it as the program; a set-up is a .toml file");
        assert_eq!(run.stderr.matches("error[").count(), 1, "{}", run.stderr);
    }
}

#[test]
fn options_name_what_is_missing_in_their_value() {
    let shop = shop("G54 G90 G71 D0\nG0 X10 Y10 Z150\nG1 X20 F100\nM30\n");
    let run = |line: &str| shop.run(words(line)).exits(2);
    run(&format!("{FIX} --zero G54")).says("'G54' does not state how the zero was set; write for example G54=touched");
    run(&format!("{FIX} --tolerance 1urad")).says("'urad' is not a unit of length");
    run(&format!("{FIX} --tolerance 1")).says("'1' has no unit");
    run("diff part.mpf part.mpf --machine mill.toml --axis W").says("the machine has no axis W");
    run("machine show mill.toml --at X9000").says("X 9000 mm is outside the travel from 0 to 500 mm");
    shop.run(words(&format!("{FIX} --zero G54=touched"))).exits(0);
}

#[test]
fn sections_that_are_missing_or_wrong_are_written_as_sections() {
    let check = |text: &str| Shop::new().file("m.toml", text).run(words("machine check m.toml")).exits(4);
    check("[axis.X]\ndirection = [1, 0, 0]\n").says("help: write a section [machine] with name and topology");
    check("machine = \"x\"\n").says("help: give machine in the file as a section");
    check(&MILL.replacen("[axis.X]", "controller = \"\"\n[axis.X]", 1)).says(" --> m.toml:4:14").says("fanuc, haas");
}

#[test]
fn a_squareness_that_turns_everything_names_the_other_axis() {
    let check =
        |own: &str| Shop::new().file("m.toml", format!("{MILL}[location]\n{own}\n")).run(words("machine check m.toml"));
    let found = check("EC0Y = 20").exits(0);
    found.says("warning[W0405]: EC0Y has no effect on this machine").says("EC0X describes this angle");
    // Followed: the other name has an effect.
    let followed = check("EC0X = -20").exits(0);
    assert!(!followed.stderr.contains("W0405") && !followed.stdout.contains("W0405"));
}

/// Distances between balls belong to probed balls; elsewhere they had no effect.
#[test]
fn known_lengths_are_refused_where_they_have_no_effect() {
    let bar = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\", \"length\"]\nsigma_um = 0.3\n[setup.A]\ncentre_mm = [200, 200, 100]\nlength_mm = 100\n";
    let rows = "setup,X_mm,Y_mm,Z_mm,dr_um\nA,300,200,100,0\nA,200,300,100,1\nA,100,200,100,0\nA,200,100,100,2\n";
    for own in ["[[length]]\nfrom = \"b1\"\nto = \"b2\"\nvalue_mm = 100\n", "[ball.b1]\nplace_mm = [1, 2, 3]\n"] {
        let shop = Shop::new().file("mill.toml", MILL).file("bar.csv", rows).file("bar.toml", format!("{bar}{own}"));
        let section = own.split(['[', ']', '.', '\n']).find(|word| !word.is_empty()).unwrap();
        shop.run(words("calibrate bar.csv --machine mill.toml --model EC0X -o fit.toml"))
            .exits(4)
            .says("error[E0402]")
            .says(section);
    }
}
