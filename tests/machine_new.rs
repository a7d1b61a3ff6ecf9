//! `ncfix machine new`: every template as a machine file, its kinematics, and the data of controls.

use nalgebra::{Matrix4, Point3, Rotation3, Translation3, Unit, Vector3};

use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_machine::describe::{self, StatedPivot, StatedSense, TEMPLATES, Template};

use crate::machine_file::load;
use crate::support::Shop;

/// Pivots that differ in every component.
const PIVOTS: [(&str, [f64; 3]); 3] =
    [("A", [300.0, -210.0, -480.0]), ("B", [120.0, 250.0, -90.0]), ("C", [310.0, -198.0, -440.0])];

fn usable() -> impl Iterator<Item = &'static Template> {
    TEMPLATES.iter().filter(|template| template.lacks.is_empty())
}

/// Words that state the sense and the pivot of each rotary axis.
fn stated(template: &Template, sense: char) -> Vec<String> {
    let mut words = Vec::new();
    for rotary in template.rotary {
        let axis = rotary.axis.to_string();
        let [x, y, z] = PIVOTS.iter().find(|row| row.0 == axis).unwrap().1;
        words.extend([format!("--sense={axis}={sense}"), format!("--pivot={axis}={x},{y},{z}")]);
    }
    words
}

fn made(template: &Template, control: &str, sense: char, further: &[&str]) -> (Shop, String) {
    let shop = Shop::new();
    let mut words: Vec<String> = ["machine", "new", "m.toml", "--like", template.name, "--control", control]
        .iter()
        .map(|word| (*word).to_owned())
        .collect();
    words.extend(stated(template, sense));
    words.extend(further.iter().map(|word| (*word).to_owned()));
    let run = shop.run(&words).exits(0);
    (shop, run.stdout)
}

#[test]
fn every_template_is_listed_with_its_chain() {
    let run = Shop::new().run(["machine", "new", "--list"]).exits(0);
    assert!(TEMPLATES.len() >= 18);
    for template in TEMPLATES {
        let line = run.stdout.lines().find(|line| line.split_whitespace().next() == Some(template.name)).unwrap();
        assert!(line.contains(template.topology) && line.contains(template.line), "{line}");
    }
}

#[test]
fn every_template_passes_the_check_and_corrects_a_program() {
    for template in usable() {
        let (shop, sketch) = made(template, "sinumerik", '-', &["--picture", "m.svg"]);
        assert!(sketch.contains(template.topology), "{sketch}");
        shop.run(["machine", "check", "m.toml"]).exits(0).says("m.toml: no errors or warnings");
        let text = shop.text("m.toml");
        assert!(text.contains("ASSUMED") && text.contains("Not measured"), "{text}");
        let svg = shop.text("m.svg");
        roxmltree::Document::parse(&svg).unwrap();
        for letter in template.topology.chars() {
            assert!(svg.contains(&format!(">{letter}</text>")), "{}: {letter}", template.name);
        }
        // Every template has this point in its travel.
        let [x, y, z] = template.travels_mm.map(|[low, high]| f64::midpoint(low, high));
        let program =
            format!("G17 G90 G71 G94 G500\nG0 X{x} Y{y} Z{z}\nG1 X{} F500\nG1 Y{}\nM30\n", x + 10.0, y + 10.0);
        std::fs::write(shop.path("p.mpf"), program).unwrap();
        let run = shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
        assert!(!run.stderr.contains("error["), "{}: {}", template.name, run.stderr);
    }
}

/// Homogeneous matrix of an axis: the motion of its body in F.
fn motion(axis: Axis, direction: [f64; 3], pivot: [f64; 3], command: f64) -> Matrix4<f64> {
    let direction = Vector3::from(direction);
    if !axis.is_rotary() {
        return Translation3::from(direction * command).to_homogeneous();
    }
    let there = Translation3::from(Vector3::from(pivot)).to_homogeneous();
    let back = Translation3::from(-Vector3::from(pivot)).to_homogeneous();
    there * Rotation3::from_axis_angle(&Unit::new_normalize(direction), command).to_homogeneous() * back
}

#[test]
fn the_kinematics_of_every_template_agree_with_matrices() {
    // Directions by hand: a slide that carries the tool moves along its letter, one that carries the workpiece against it.
    let tool = Vector3::new(1.5, -2.0, -117.0);
    for template in usable() {
        for sense in ['+', '-'] {
            let (shop, _) = made(template, "sinumerik", sense, &[]);
            let (loaded, findings) = load(&shop.text("m.toml"));
            assert!(findings.is_empty(), "{}: {findings:?}", template.name);
            let (machine, errors) = loaded.unwrap();
            let model = ncfix_model::Model::new(&machine, &errors);
            let (before, after) = template.topology.split_once('F').unwrap();
            for seed in 1..=6 {
                let mut command = AxisVector::ZERO;
                for axis in AXES {
                    let value = (f64::from(seed) * 1.7 + axis.slot() as f64).sin();
                    command[axis] = if axis.is_rotary() { value * 1.4 } else { value * 200.0 };
                }
                let of = |letter: char| -> Matrix4<f64> {
                    let axis = Axis::from_letter(letter as u8).unwrap();
                    let rotary = template.rotary.iter().find(|one| one.axis == axis);
                    let sign = match rotary {
                        Some(_) => {
                            if sense == '+' {
                                1.0
                            } else {
                                -1.0
                            }
                        }
                        None => {
                            if before.contains(letter) {
                                -1.0
                            } else {
                                1.0
                            }
                        }
                    };
                    let mut own = [0.0; 3];
                    own[axis.dimension()] = 1.0;
                    let line = rotary.map_or(own, |one| one.line).map(|part| part * sign);
                    let pivot = PIVOTS.iter().find(|row| row.0 == letter.to_string()).map_or([0.0; 3], |row| row.1);
                    motion(axis, line, pivot, command[axis])
                };
                // From F outwards: the topology of the workpiece is written towards F.
                let workpiece = before
                    .trim_start_matches('w')
                    .chars()
                    .rev()
                    .map(of)
                    .fold(Matrix4::<f64>::identity(), |all: Matrix4<f64>, one: Matrix4<f64>| all * one);
                let spindle = after
                    .trim_end_matches("St")
                    .chars()
                    .map(of)
                    .fold(Matrix4::<f64>::identity(), |all: Matrix4<f64>, one: Matrix4<f64>| all * one);
                let relative = workpiece.try_inverse().unwrap() * spindle;
                let tip = relative.transform_point(&Point3::from(tool));
                let pose = model.nominal(&command, &Vector::from([tool.x, tool.y, tool.z]));
                let far =
                    (Vector3::new(pose.translation.x, pose.translation.y, pose.translation.z) - tip.coords).norm();
                assert!(far < 1e-9, "{} {sense} {seed}: {far}", template.name);
            }
        }
    }
}

#[test]
fn dangerous_values_are_never_assumed() {
    let run = Shop::new().run(["machine", "new", "m.toml", "--like", "trunnion-ac"]).exits(2);
    for text in ["sense of A", "sense of C", "a point on the axis of A", "a point on the axis of C", "--pivot C=X,Y,Z"]
    {
        assert!(run.stderr.contains(text), "{text}: {}", run.stderr);
    }
    Shop::new().run(["machine", "new", "m.toml", "--like", "lathe"]).exits(2).says("no machine file for a lathe yet");
    Shop::new().run(["machine", "new", "m.toml", "--like", "lath"]).exits(2).says("is not a template");
    Shop::new().run(["machine", "new", "m.toml", "--like", "vmc", "--sense", "C=+"]).exits(2).says("has no axis C");
    let shop = Shop::new().file("m.toml", "");
    shop.run(["machine", "new", "m.toml", "--like", "vmc"]).exits(2).says("exists already");
}

#[test]
fn statements_are_read_as_they_are_written() {
    assert!("C=-".parse::<StatedSense>().is_ok_and(|sense| !sense.is_positive));
    assert!("C=1,2,3".parse::<StatedPivot>().is_ok_and(|pivot| pivot.point_mm == [1.0, 2.0, 3.0]));
}

#[test]
fn settings_of_grbl_give_travels_and_feeds() {
    let settings = "$0=10\n$3=1\n$13=0\n$22=1\n$23=3\n$100=80.000\n$101=80.000\n$102=400.000\n$110=5000.000\n$111=5000.000\n\
                    $112=600.000\n$130=600.000\n$131=900.000\n$132=80.000\nok\n";
    let shop = Shop::new().file("grbl.txt", settings);
    let run = shop.run(["machine", "new", "m.toml", "--like", "router", "--from", "grbl.txt"]).exits(0);
    assert!(run.stdout.contains("Grbl settings ($$)"), "{}", run.stdout);
    let text = shop.text("m.toml");
    for part in [
        "travel_mm = [-600, 0]",
        "max_feed_mm_min = 600",
        "grbl.txt:12",
        "controller = \"grbl\"",
        "increment_mm = 0.001",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // A motor that turns the other way does not turn the axis.
    assert!(text.contains("direction = [1, 0, 0]") && text.contains("grbl.txt:2 $3 = 1"), "{text}");
    shop.run(["machine", "check", "m.toml"]).exits(0);
}

/// The name of the control stays: firmware of the Grbl family refuses words that LinuxCNC executes, and a Haas reads some words otherwise than a Fanuc.
#[test]
fn the_name_of_the_control_stays() {
    for (control, name) in [
        ("grbl", "grbl"),
        ("grblHAL", "grblhal"),
        ("fluidnc", "fluidnc"),
        ("linuxcnc", "linuxcnc"),
        ("haas", "haas"),
        ("828D", "828d"),
        ("fanuc", "fanuc"),
        ("millplus", "millplus"),
    ] {
        let shop = Shop::new().file("p.ngc", "G21 G17 G90 G94 G54\nT1 M6\nG0 X1 Y1\nM2\n");
        shop.run(["machine", "new", "m.toml", "--like", "router", "--control", control]).exits(0);
        let text = shop.text("m.toml");
        assert!(text.contains(&format!("controller = \"{name}\"")), "{control}: {text}");
        shop.run(["machine", "check", "m.toml"]).exits(0);
        if name == "grbl" {
            // Grbl 1.1 has no M6.
            let zero = "[zero_offset.G54]\nX_mm = -300\nY_mm = -300\nZ_mm = -20\n[[tool]]\nnumber = 1\nlength_mm = 0\n";
            let shop = shop.file("m.toml", format!("{text}\n{zero}"));
            shop.run(["check", "p.ngc", "--machine", "m.toml"]).says("W0241");
        }
    }
}

/// A punch-out of offsets without G20 or G21 states no unit, and the machine file that could state it does not exist yet.
#[test]
fn the_unit_of_saved_offsets_is_an_option() {
    let shop = Shop::new().file("OFFS.TXT", "%\nG10L2P1X-10.Y-8.Z-2.\n%\n");
    let words = |more: &[&'static str]| {
        let all = "machine new m.toml --like vmc --control fanuc --travel X=-500..0 --travel Y=-400..0 --travel Z=-400..0 --setup OFFS.TXT";
        shop.run(all.split(' ').chain(more.iter().copied()))
    };
    words(&[]).exits(4).says("--saved-unit");
    words(&["--saved-unit", "inch"]).exits(0);
    let text = shop.text("m.toml");
    // 10 inches are 254 mm.
    assert!(text.contains("saved_unit = \"inch\"") && text.contains("X_mm = -254"), "{text}");
    let line = text.lines().find(|line| line.starts_with("saved_unit")).unwrap();
    assert!(line.ends_with("# unit of saved offsets and tools"), "{line}");
}

/// A punch-out whose end is missing may lack a wear, and two values of one offset leave open which one is in force.
#[test]
fn a_cut_off_or_contradictory_punch_out_is_refused() {
    let words = "machine new m.toml --like vmc --control fanuc --travel X=-500..0 --travel Y=-400..0 --travel Z=-400..0 --saved-unit mm --setup OFFS.TXT";
    let new = |text: &str| Shop::new().file("OFFS.TXT", text).run(words.split(' '));
    let whole = "%\nG10L2P1X-10.Y-8.Z-2.\nG10L10P1R120.\nG10L11P1R-0.02\n%\n";
    new(whole).exits(0);
    new(&whole.replace("G10L11P1R-0.02\n%\n", "")).exits(4).says("its end is missing").says("OFFS.TXT:3");
    let twice = whole.replace("G10L10", "G10L2P1X-11.Y-8.\nG10L10");
    new(&twice).exits(4).says("a second, different value of X").says("OFFS.TXT:3");
    // The same value again is no contradiction; nor is a file without any %.
    new(&twice.replace("X-11.", "X-10.")).exits(0);
    new(&whole.replace("%\n", "")).exits(0);
}

/// `$13=1` of the settings is the unit of the answer to `$#` (Grbl 1.1 wiki): -21.6535 inches are -550 mm.
#[test]
fn the_setting_13_of_grbl_is_the_unit_of_its_offsets() {
    let settings = "$0=10\n$3=0\n$13=1\n$22=1\n$23=0\n$100=80\n$110=5000\n$130=600\n$131=600\n$132=80\n";
    let shop = Shop::new().file("g.txt", settings).file("o.txt", "[G54:-21.6535,-21.6535,-0.3937]\n[TLO:0.0000]\n");
    shop.run("machine new m.toml --like router --from g.txt --setup o.txt".split(' ')).exits(0);
    assert!(shop.text("m.toml").contains("X_mm = -549.99"), "{}", shop.text("m.toml"));
}

/// T2 is worn by 0.02 mm. The zero and T1 go into the new file; without T2 no program with it is corrected by mistake.
#[test]
fn a_worn_tool_does_not_refuse_the_other_offsets() {
    let saved =
        "%\nG21\nG10L2P1X-10.Y-8.Z-2.\nG10L10P1R100.\nG10L12P1R5.\nG10L10P2R80.\nG10L12P2R4.\nG10L13P2R-0.02\n%\n";
    let program = |tool: u32| {
        format!("%\nO1\nG21 G90 G17 G94 G54\nT{tool} M6\nG43 H{tool} Z50.\nG0 X0. Y0.\nG1 X5. F500\nM30\n%\n")
    };
    let shop = Shop::new().file("OFFS.TXT", saved).file("one.nc", program(1)).file("two.nc", program(2));
    let all = "machine new m.toml --like vmc --control fanuc --travel X=-500..500 --travel Y=-400..400 --travel Z=-400..400 --setup OFFS.TXT";
    let run = shop.run(all.split(' ')).exits(0);
    assert!(
        run.stdout.contains("T2: the radius has a wear") && run.stdout.contains("--setup OFFS.TXT"),
        "{}",
        run.stdout
    );
    let text = shop.text("m.toml");
    assert!(text.contains("X_mm = -10") && text.contains("length_mm = 100"), "{text}");
    assert!(text.contains("radius has a wear: T2") && !text.contains("length_mm = 80"), "{text}");
    shop.run(["check", "one.nc", "--machine", "m.toml"]).exits(0);
    shop.run(["check", "two.nc", "--machine", "m.toml"]).exits(4).says("E0307");
    shop.run(["check", "two.nc", "--machine", "m.toml", "--setup", "OFFS.TXT"]).exits(0);
}

#[test]
fn an_ini_of_linuxcnc_gives_limits_in_its_unit() {
    let ini = "[EMC]\nMACHINE = mill\n[KINS]\nKINEMATICS = trivkins coordinates=XYZ\n[TRAJ]\nCOORDINATES = X Y Z\n\
               LINEAR_UNITS = inch\n[AXIS_X]\nMIN_LIMIT = -10\nMAX_LIMIT = 10.5\nMAX_VELOCITY = 2\n[JOINT_1]\n\
               MIN_LIMIT = 0\nMAX_LIMIT = 8\nBACKLASH = 0.001\n[JOINT_2]\nMIN_LIMIT = -4\nMAX_LIMIT = 0\nCOMP_FILE = z.comp\n";
    let shop = Shop::new().file("mill.ini", ini);
    shop.run(["machine", "new", "m.toml", "--like", "vmc", "--from", "mill.ini"]).exits(0);
    let text = shop.text("m.toml");
    // 25.4 mm an inch; 2 inch/s are 3048 mm/min.
    for part in [
        "[-254, 266.7]",
        "[0, 203.2]",
        "[-101.6, 0]",
        "max_feed_mm_min = 3048",
        "BACKLASH = 0.001",
        "COMP_FILE = z.comp",
        "saved_unit = \"inch\"",
        "mill.ini:9",
        // LinuxCNC, INI Configuration, EMCIO: without these keys the tool change moves no axis.
        "name = \"M6\"",
        "moves = false",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    for more in ["[EMCIO]\nTOOL_CHANGE_QUILL_UP = 1\n", "[RS274NGC]\nREMAP = M6 modalgroup=6 ngc=change\n"] {
        let shop = Shop::new().file("mill.ini", format!("{ini}{more}"));
        shop.run(["machine", "new", "m.toml", "--like", "vmc", "--from", "mill.ini"]).exits(0);
        assert!(!shop.text("m.toml").contains("moves = false"), "{more}");
    }
    let shop = Shop::new().file("mill.ini", ini.replace("LINEAR_UNITS = inch\n", ""));
    shop.run(["machine", "new", "m.toml", "--like", "vmc", "--from", "mill.ini"]).exits(2).says("LINEAR_UNITS");
}

/// Machine data of a swivel table, in the layout of an archive.
const TRAORI: &str = "N10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[1]=\"Y1\"\n\
    N10000 $MN_AXCONF_MACHAX_NAME_TAB[2]=\"Z1\"\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[3]=\"A1\"\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[4]=\"C1\"\n\
    N20080 $MC_AXCONF_CHANAX_NAME_TAB[3]=\"A\"\nN20080 $MC_AXCONF_CHANAX_NAME_TAB[4]=\"C\"\n\
    N24100 $MC_TRAFO_TYPE_1=40\nN24110 $MC_TRAFO_AXES_IN_1[3]=4\nN24110 $MC_TRAFO_AXES_IN_1[4]=5\n\
    N24500 $MC_TRAFO5_PART_OFFSET_1[0]=-300\nN24500 $MC_TRAFO5_PART_OFFSET_1[1]=198\nN24500 $MC_TRAFO5_PART_OFFSET_1[2]=440\n\
    N24550 $MC_TRAFO5_BASE_TOOL_1[0]=300\nN24550 $MC_TRAFO5_BASE_TOOL_1[1]=-210\nN24550 $MC_TRAFO5_BASE_TOOL_1[2]=-480\n\
    N24560 $MC_TRAFO5_JOINT_OFFSET_1[1]=12\nN24560 $MC_TRAFO5_JOINT_OFFSET_1[2]=40\n\
    N24570 $MC_TRAFO5_AXIS1_1[0]=-1\nN24572 $MC_TRAFO5_AXIS2_1[2]=-1\n\
    N10200 $MN_INT_INCR_PER_MM=1000\nN30310 $MA_ROT_IS_MODULO[AX5]=1\nN32000 $MA_MAX_AX_VELO[AX1]=30000\nN32000 $MA_MAX_AX_VELO[AX4]=25\n\
    N32100 $MA_AX_MOTION_DIR[AX1]=-1\nN36100 $MA_POS_LIMIT_MINUS[AX1]=0\nN36110 $MA_POS_LIMIT_PLUS[AX1]=600\n\
    N36100 $MA_POS_LIMIT_MINUS[AX4]=-120\nN36110 $MA_POS_LIMIT_PLUS[AX4]=30\n";

/// A value that is no number is not 0, inches are not mm, and a file in UTF-16 says so.
#[test]
fn machine_data_that_cannot_be_used_are_refused() {
    let new = |bytes: Vec<u8>| {
        let shop = Shop::new();
        std::fs::write(shop.path("md.ini"), bytes).unwrap();
        let run = shop.run("machine new m.toml --like trunnion-ac --from md.ini".split(' '));
        if run.code != 0 {
            assert!(!shop.path("m.toml").exists());
        }
        run
    };
    let comma = TRAORI.replace("BASE_TOOL_1[2]=-480", "BASE_TOOL_1[2]=-480,5");
    new(comma.into_bytes()).exits(2).says("-480,5").says("not a number");
    let inch = format!("N10240 $MN_SCALING_SYSTEM_IS_METRIC=0\n{TRAORI}");
    new(inch.into_bytes()).exits(2).says("inches");
    let metric = format!("N10240 $MN_SCALING_SYSTEM_IS_METRIC=1\n{TRAORI}");
    let run = new(metric.into_bytes()).exits(0);
    assert!(run.stdout.contains("$MC_TRAFO5_JOINT_OFFSET_1[0]"), "{}", run.stdout);
    let wide: Vec<u8> = [0xFF, 0xFE].into_iter().chain(TRAORI.bytes().flat_map(|byte| [byte, 0])).collect();
    new(wide).exits(2).says("UTF-16");
}

#[test]
fn machine_data_of_a_sinumerik_give_the_chain_of_traori() {
    // Points: BASE_TOOL and BASE_TOOL + JOINT_OFFSET, the worked example of the five-axis page.
    let shop = Shop::new().file("md.ini", TRAORI);
    shop.run(["machine", "new", "m.toml", "--like", "trunnion-ac", "--from", "md.ini"]).exits(0);
    let text = shop.text("m.toml");
    for part in [
        "point_mm = [300, -210, -480]",
        "point_mm = [300, -198, -440]",
        "direction = [-1, 0, 0]",
        "direction = [0, 0, -1]",
        "modulo = true",
        "travel_deg = [-120, 30]",
        "travel_mm = [0, 600]",
        "max_feed_deg_min = 9000",
        "MD32100 of X is -1",
        "increments_per_mm = 1000",
        "axis_order = [\"X\", \"Y\", \"Z\", \"A\", \"C\"]",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("not closed"), "{text}");
    shop.run(["machine", "check", "m.toml"]).exits(0).says("no errors or warnings");
    // A spindle has the number 4, so A is AX5 and C is AX6.
    let spindle = TRAORI
        .replace("TAB[3]=\"A1\"", "TAB[3]=\"SP\"\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[5]=\"C1\"")
        .replace("TAB[4]=\"C1\"", "TAB[4]=\"A1\"")
        .replace("[AX5]", "[AX6]")
        .replace("[AX4]", "[AX5]");
    let later = Shop::new().file("md.ini", spindle);
    later.run(["machine", "new", "m.toml", "--like", "trunnion-ac", "--from", "md.ini"]).exits(0);
    let named = later.text("m.toml");
    assert!(named.contains("axis_order = [\"X\", \"Y\", \"Z\", \"-\", \"A\", \"C\"]"), "{named}");
    assert!(named.contains("travel_deg = [-120, 30]"), "{named}");
    std::fs::write(later.path("e.toml"), format!("{named}\n[location]\nEC0Y = 100\nEA0C = 50\n")).unwrap();
    let tables =
        ["tables", "--machine", "e.toml", "--format", "cec", "--scheme", "fik", "--tool", "100", "-o", "T.INI"];
    let made = later.run(tables).exits(0);
    assert!(!made.stderr.contains("W0903"), "{}", made.stderr);
    let written = later.text("T.INI");
    assert!(written.contains("OUTPUT_AXIS") && !written.contains("(AX4)"), "{written}");
    assert!(written.contains("A AX5") && written.contains("(AX5)"), "{written}");
    // The data state two axes in the table.
    shop.run(["machine", "new", "h.toml", "--like", "head-ac", "--from", "md.ini"])
        .exits(2)
        .says("choose another template");
    // Without the names of the channel axes, TRAORI does not state its axes: the refusal says that its data were not used.
    let nameless: String =
        TRAORI.lines().filter(|line| !line.contains("CHANAX")).map(|line| format!("{line}\n")).collect();
    Shop::new()
        .file("md.ini", nameless)
        .run(["machine", "new", "m.toml", "--like", "trunnion-ac", "--from", "md.ini"])
        .exits(2)
        .says("$MC_AXCONF_CHANAX_NAME_TAB");
    // The same vectors in a swivel data record.
    let record = "$TC_CARR4[1]=300\n$TC_CARR5[1]=-210\n$TC_CARR6[1]=-480\n$TC_CARR7[1]=-1\n$TC_CARR12[1]=-1\n$TC_CARR16[1]=12\n$TC_CARR17[1]=40\n\
                  $TC_CARR18[1]=-300\n$TC_CARR19[1]=198\n$TC_CARR20[1]=440\n$TC_CARR21[1]=A\n$TC_CARR22[1]=C\n$TC_CARR23[1]=\"P\"\n";
    let shop = Shop::new().file("carr.ini", record);
    shop.run(["machine", "new", "m.toml", "--like", "trunnion-ac", "--from", "carr.ini"]).exits(0);
    let text = shop.text("m.toml");
    assert!(text.contains("point_mm = [300, -198, -440]") && text.contains("direction = [0, 0, -1]"), "{text}");
}

/// MD20150 has the places of the words in their groups: G18 is the second plane, G54 the second zero offset after G500, G70 the first unit. A program that
/// does not state its zero offset runs in G54, and one without a unit in inches.
#[test]
fn words_in_force_after_a_reset_are_taken_from_the_machine_data() {
    let reset = "N20150 $MC_GCODE_RESET_VALUES[5]=2\nN20150 $MC_GCODE_RESET_VALUES[7]=2\nN20150 $MC_GCODE_RESET_VALUES[12]=1\n\
                 N20150 $MC_GCODE_RESET_VALUES[13]=1\n";
    let shop = Shop::new().file("md.ini", format!("{TRAORI}{reset}"));
    shop.run(["machine", "new", "m.toml", "--like", "trunnion-ac", "--from", "md.ini"]).exits(0);
    let text = shop.text("m.toml");
    for part in ["initial_plane = 18", "initial_zero_offset = \"G54\"", "MD20150[7]", "G70 (inches)"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("MD20150[13]"), "{text}");
    shop.run(["machine", "check", "m.toml"]).exits(0).says("no errors or warnings");
    // As delivered: G17, G500, G71.
    let usual = reset.replace("[5]=2", "[5]=1").replace("[7]=2", "[7]=1").replace("[12]=1", "[12]=2");
    let shop = Shop::new().file("md.ini", format!("{TRAORI}{usual}"));
    shop.run(["machine", "new", "m.toml", "--like", "trunnion-ac", "--from", "md.ini"]).exits(0);
    assert!(!shop.text("m.toml").contains("initial_"), "{}", shop.text("m.toml"));
}

/// The data of the control were read into the machine file; later the axis of A moved by half a millimeter along Y, and programs begin in G55.
#[test]
fn data_of_the_control_that_contradict_the_machine_file_are_named() {
    let reset = "N20150 $MC_GCODE_RESET_VALUES[7]=2\n";
    let saved = |text: String| format!("%_N_INITIAL_INI\n{text}M17\n");
    let same = saved(format!("{TRAORI}{reset}"));
    let moved = same.replace("BASE_TOOL_1[1]=-210", "BASE_TOOL_1[1]=-210.5").replace("VALUES[7]=2", "VALUES[7]=3");
    let turned = same.replace("AXIS1_1[0]=-1", "AXIS1_1[0]=1");
    let shop = Shop::new()
        .file("md.ini", format!("{TRAORI}{reset}"))
        .file("same.ini", &same)
        .file("moved.ini", &moved)
        .file("turned.ini", &turned);
    shop.run(["machine", "new", "m.toml", "--like", "trunnion-ac", "--from", "md.ini"]).exits(0);
    let show = |setup: &str| {
        shop.run(["machine", "show", "m.toml", "--at", "X0,Y0,Z0", "--tool", "100", "--setup", setup]).exits(0)
    };
    assert!(!show("same.ini").stderr.contains("W0407"), "{}", show("same.ini").stderr);
    let run = show("moved.ini")
        .says("warning[W0407]")
        .says("initial_zero_offset = \"G55\"")
        .says("the axis of A")
        .says("the axis of C");
    assert_eq!(run.stderr.matches("0.500 mm away").count(), 2, "{}", run.stderr);
    assert_eq!(show("turned.ini").says("A turns about (1, 0, 0)").stderr.matches("W0407").count(), 1);
    // A part offset of 340 instead of 440 leaves 100 mm open: the zero offsets of the control lack them under TRAORI.
    std::fs::write(shop.path("open.ini"), same.replace("PART_OFFSET_1[2]=440", "PART_OFFSET_1[2]=340")).unwrap();
    show("open.ini").says("warning[W0407]").says("TRAORI shifts the zero of the workpiece by (0, 0, -100) mm");
}

#[test]
fn names_of_controls_are_understood_or_answered() {
    let file = |name: &str| {
        format!(
            "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"{name}\"\n\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 9]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 9]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 9]\n"
        )
    };
    for name in ["grbl", "grblHAL", "linuxcnc", "840D sl", "828d", "Haas", "fanuc", "MillPlus"] {
        Shop::new().file("m.toml", file(name)).run(["machine", "check", "m.toml"]).exits(0);
    }
    for (name, advice) in [
        ("mach3", "write controller = \"rs274\""),
        ("mazak", "write controller = \"fanuc\" if it runs programs in its ISO mode"),
        // Its DIN/ISO programs are not those of a Fanuc: they are refused (E0118).
        ("heidenhain", "neither Klartext nor DIN/ISO"),
        ("TNC 640", "neither Klartext nor DIN/ISO"),
        ("iTNC 530", "neither Klartext nor DIN/ISO"),
        ("latin", "write one of"),
    ] {
        Shop::new().file("m.toml", file(name)).run(["machine", "check", "m.toml"]).exits(4).says(advice);
    }
}

#[test]
fn a_machine_is_described_measured_and_corrected_by_commands_alone() {
    let shop = Shop::new();
    shop.run(["machine", "new", "m.toml", "--like", "vmc", "--control", "linuxcnc", "--travel=Z=-200..0"]).exits(0);
    // Readings of a laser: X goes 20 µm too far in 400 mm.
    let readings =
        "component,X,Y,Z,value_um\nEXX,0,0,0,0\nEXX,100,0,0,5\nEXX,200,0,0,10\nEXX,300,0,0,15\nEXX,400,0,0,20\n";
    std::fs::write(shop.path("laser.csv"), readings).unwrap();
    std::fs::write(shop.path("laser.toml"), "[measurement]\nkind = \"direct\"\nsigma_um = 0.1\n").unwrap();
    std::fs::write(shop.path("model.txt"), "EXX1\n").unwrap();
    shop.run(["calibrate", "laser.csv", "--machine", "m.toml", "--model", "model.txt", "-o", "c.toml"]).exits(0);
    assert!(shop.text("c.toml").contains("ASSUMED"), "comments are kept");
    std::fs::write(shop.path("p.ngc"), "G21 G17 G90 G94\nG53 G0 Z0\nG53 G0 X0 Y0\nG53 G1 X400 F500\nM2\n").unwrap();
    shop.run(["p.ngc", "-o", "out.ngc", "--machine", "c.toml"]).exits(0);
    let run = shop.run(["verify", "p.ngc", "out.ngc", "--machine", "c.toml"]).exits(0);
    assert!(run.stdout.contains("error after"), "{}", run.stdout);
}

/// A measured error leaves the lists of what was not, and its measurement leaves the list of the next ones.
#[test]
fn comments_of_the_template_follow_the_measurements() {
    let template = usable().find(|template| template.rotary.is_empty()).unwrap();
    let (shop, _) = made(template, "sinumerik", '-', &[]);
    let own = "# EXX is checked every spring\n";
    let text = shop.text("m.toml") + own;
    let after = |names: &[&str]| names.iter().fold(text.clone(), |text, name| describe::measured(&text, name));
    assert!(text.contains("\n#   EXX EYX EZX EAX EBX ECX  and backlash\n"), "{text}");
    assert!(after(&["EXX1", "EXX2@100"]).contains("\n#   EYX EZX EAX EBX ECX  and backlash\n"));
    assert!(after(&["EXXb", "EXX1"]).contains("\n#   EYX EZX EAX EBX ECX\n"));
    // The pitches of the other axes are still to be measured.
    assert!(after(&["EXX1"]).contains("pitch and backlash of each axis"));
    let pitches = after(&["EXX1", "EYY1", "EZZ1"]);
    assert!(!pitches.contains("pitch and backlash of each axis") && pitches.contains("ncfix square"), "{pitches}");
    let names: Vec<String> = text
        .lines()
        .filter_map(|line| line.strip_prefix("#   E"))
        .flat_map(|line| {
            line.split_whitespace().map(|word| format!("E{}", word.trim_start_matches('E'))).collect::<Vec<_>>()
        })
        .filter(|name| name.len() == 3 || name.len() == 4 && name.as_bytes()[2] == b'0')
        .chain(["EXXb", "EYYb", "EZZb"].map(str::to_owned))
        .collect();
    let all: Vec<&str> = names.iter().map(String::as_str).collect();
    let left = after(&all);
    for words in ["Not measured", "Measure next", "not measured yet", "No error of this machine"] {
        assert!(!left.contains(words), "{words}: {left}");
    }
    // Words of a person stay.
    assert!(left.ends_with(own), "{left}");
}
