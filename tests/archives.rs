//! Archives of a control, and files that support programs without being one.

use crate::support::{Shop, machine};

/// A record of 512 bytes and its content, filled up to whole records.
fn entry(name: &str, folder: &str, content: &str) -> Vec<u8> {
    let mut record = vec![0; 512];
    let mut put = |at: usize, text: &str| record[at..at + text.len()].copy_from_slice(text.as_bytes());
    put(0, &format!("_N_{}", name.replace('.', "_")));
    put(50, name);
    put(108, "7");
    put(116, "040703");
    put(124, &content.len().to_string());
    put(384, folder);
    let sum: u32 = record.iter().map(|&byte| u32::from(byte)).sum();
    record[148..148 + sum.to_string().len()].copy_from_slice(sum.to_string().as_bytes());
    record.extend(content.as_bytes());
    record.resize(record.len().div_ceil(512) * 512, 0);
    record
}

/// An archive of files with their folders.
pub(crate) fn archive(files: &[(&str, &str, &str)]) -> Vec<u8> {
    let mut bytes = entry("", "", ";---components---\n");
    bytes[..12].copy_from_slice(b"@@MMCIBN.002");
    let sum: u32 = bytes[..148].iter().chain(&bytes[156..512]).map(|&byte| u32::from(byte)).sum();
    bytes[148..156].fill(0);
    bytes[148..148 + sum.to_string().len()].copy_from_slice(sum.to_string().as_bytes());
    for (name, folder, content) in files {
        bytes.extend(entry(name, folder, content));
    }
    bytes
}

const PART: (&str, &str, &str) = ("PART.MPF", "\\WKS.DIR\\PART.WPD\\", "G90 G54 G0 X1 Y2 Z50\nEDGE\nL6\nM30\n");
const EDGE: (&str, &str, &str) = ("EDGE.SPF", "\\WKS.DIR\\PART.WPD\\", "G1 X30 F100\nM17\n");
const FAR: (&str, &str, &str) = ("EDGE.SPF", "\\CMA.DIR\\", "G1 X99 F100\nM17\n");
const L6: (&str, &str, &str) = ("L6.SPF", "\\CMA.DIR\\", "G1 X40\nM17\n");

#[test]
fn a_program_in_an_archive_is_executed_with_its_subprograms() {
    let shop = Shop::new().file("SAVE.arc", archive(&[FAR, PART, L6, EDGE]));
    let run = shop.run(["snc", "SAVE.arc", "--machine", &machine("demo")]).exits(0);
    let moves: Vec<&str> = run.stdout.lines().skip(1).filter_map(|line| line.split(" ;@").next()).collect();
    assert!(moves[0].starts_with("G0 X") && moves.len() == 4, "{moves:?}");
    // The subprogram of the part's own folder goes before that of the machine builder.
    let x: Vec<f64> = moves[..3].iter().map(|line| line.split(' ').nth(1).unwrap()[1..].parse().unwrap()).collect();
    assert_eq!([x[1] - x[0], x[2] - x[0]], [29.0, 39.0]);
}

#[test]
fn tools_and_zero_offsets_of_an_archive_are_a_set_up() {
    let tools = ("TO1.TOA", "\\_N_TOA_DIR\\", "CHANDATA(1)\n$TC_DP3[5,1]=100\n$TC_DP6[5,1]=7\nM17\n");
    let offsets = ("CHANNEL1.UFR", "\\", "$P_UIFR[1,X,TR]=11\nM17\n");
    let shop = Shop::new()
        .file("SAVE.arc", archive(&[PART, tools, L6, offsets]))
        .file("m.toml", crate::system::IDEAL)
        .file("p.mpf", "G90 G54 G0 X1 Y=$TC_DP6[5,1] Z0\nM30\n");
    let run = shop.run(["snc", "p.mpf", "--machine", "m.toml", "--setup", "SAVE.arc"]).exits(0);
    assert!(run.stdout.contains("G0 X12 Y7 Z0"), "{}", run.stdout);
}

#[test]
fn one_of_several_programs_is_named_behind_the_archive() {
    let other = ("OTHER.MPF", "\\MPF.DIR\\", "G90 G54 G0 X7\nM30\n");
    let shop = Shop::new().file("SAVE.arc", archive(&[PART, EDGE, L6, other]));
    let demo = machine("demo");
    shop.run(["check", "SAVE.arc", "--machine", &demo])
        .exits(2)
        .says("SAVE.arc has 2 such programs")
        .says("MPF.DIR/OTHER.MPF, WKS.DIR/PART.WPD/PART.MPF");
    shop.run(["check", "SAVE.arc/OTHER.MPF", "--machine", &demo])
        .exits(0)
        .says("understood and executed, 2 moves and functions");
    shop.run(["check", "SAVE.arc/WKS.DIR/PART.WPD/part.mpf", "--machine", &demo]).exits(0);
    shop.run(["check", "SAVE.arc/NOWHERE.MPF", "--machine", &demo]).exits(2).says("has no file NOWHERE.MPF");
}

#[test]
fn definition_files_of_the_archive_are_read() {
    let part = ("PART.MPF", "\\MPF.DIR\\", "G90 G54 G0 X=DEPTH\nHOME\nM30\n");
    let gud = ("UGUD.DEF", "\\DEF.DIR\\", "DEF NCK REAL DEPTH=4\nM17\n");
    let mac = ("SMAC.DEF", "\\DEF.DIR\\", "DEFINE HOME AS G0 X5\nM17\n");
    let shop = Shop::new().file("SAVE.arc", archive(&[gud, mac, part]));
    shop.run(["check", "SAVE.arc", "--machine", &machine("demo")]).exits(0).says("executed, 3 moves and functions");
}

#[test]
fn a_damaged_archive_is_refused() {
    let good = archive(&[PART]);
    let demo = machine("demo");
    let mut flipped = good.clone();
    flipped[1024 + 10] ^= 1;
    let cases = [("FLIPPED.arc", flipped), ("SHORT.arc", good[..1500].to_vec()), ("HEAD.arc", good[..20].to_vec())];
    for (name, bytes) in cases {
        Shop::new().file(name, bytes).run(["check", name, "--machine", &demo]).exits(2).says("is damaged: at byte");
    }
    let no_program = archive(&[EDGE]);
    Shop::new().file("A.arc", no_program).run(["check", "A.arc", "--machine", &demo]).exits(2).says("no main program");
}

#[test]
fn the_archive_is_not_overwritten() {
    let shop = Shop::new().file("SAVE.arc", archive(&[PART, EDGE, L6]));
    let before = shop.bytes("SAVE.arc");
    shop.run(["SAVE.arc", "-o", "SAVE.arc", "--machine", &machine("demo")]).says("E0310");
    assert_eq!(shop.bytes("SAVE.arc"), before);
}

#[test]
fn support_files_are_called_what_they_are() {
    let demo = machine("demo");
    for (name, text, kind) in [
        ("TO1.INI", "%_N_TO1_TOA\nCHANDATA(1)\n$TC_TP2[1]=\"MILL\"\n$TC_DP1[1,1]=120\nM17\n", "tool data"),
        (
            "TEA.INI",
            "CHANDATA(1)\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\nN20050 $MC_A[1]=2\nM17\n",
            "machine data",
        ),
        ("UFR.INI", "CHANDATA(1)\n$P_UIFR[1,X,TR]=5\n$P_UIFR[1,Y,TR]=5\nM17\n", "zero offsets"),
        ("CEC.INI", "CHANDATA(1)\n$AN_CEC[0,0]=0.1\n$AN_CEC_STEP[0]=10\nM17\n", "compensation tables"),
        ("RPA.INI", "CHANDATA(1)\nR1=5\nR2=7\nM17\n", "R parameters"),
        ("GUD.DEF", "DEF NCK INT COUNT\nDEF CHAN REAL A_B=5\nM17\n", "definitions"),
        ("CUST.COM", "//S(START)\nHS1=(\"A\")\n//END\n", "screens"),
        (
            "MEASURED.MPF",
            "Point 1 pass 1 size -1.6427 error  0.0127\n\n***** Phase 2 *****\n   - Pass number 1 of 2\n",
            "log",
        ),
        ("RUN.LOG", "12:00 started (\n", "log"),
    ] {
        let shop = Shop::new().file(name, text);
        let says = format!("{name}: understood; a support file, not a program: {kind}; no errors or warnings");
        shop.run(["check", name, "--machine", &demo]).exits(0).says(&says);
        let json = shop.run(["check", name, "--json", "--machine", &demo]).exits(0).json();
        assert_eq!(json["support_file"], kind);
    }
    for program in [
        "trans x10 y5\nrot z30\nmirror x0\nM30\n",
        "stopre trans\ndiamon stopre\natrans z5 y1\ng0 x1\n",
        "go to work\nthen home\n",
        "",
    ] {
        let shop = Shop::new().file("P.MPF", program);
        assert!(
            shop.run(["check", "P.MPF", "--json", "--machine", &demo]).json()["support_file"].is_null(),
            "{program}"
        );
    }
    let shop = Shop::new().file("P.MPF", "R1=5\nDEF INT A\n$A_OUT[1]=1\nG0 X1\nM30\n");
    assert!(shop.run(["check", "P.MPF", "--json", "--machine", &demo]).json()["support_file"].is_null());
}

/// A set-up file of which nothing is read is no set-up.
#[test]
fn saved_data_with_the_header_of_a_program_is_refused() {
    let shop = Shop::new()
        .file("r.RPA", "%_N_RPA_MPF\nR1=25\n")
        .file("right.RPA", "%_N_RPA_INI\nR1=25\n")
        .file("part.mpf", "G0 X=R1 Y0 Z0\nM30\n");
    shop.run(["fix", "part.mpf", "-o", "o.mpf", "--setup", "r.RPA"])
        .exits(3)
        .says("error[E0101]: this header names a program (MPF), not saved data: nothing is read\n --> r.RPA:1:1");
    shop.run(["fix", "part.mpf", "-o", "o.mpf", "--setup", "right.RPA"]).exits(0);
}

#[test]
fn a_program_in_an_archive_as_text_has_its_folder_and_its_subprograms() {
    let text = "%_N_INITIAL_INI\nN10 $MN_INT_INCR_PER_MM=1000\n\
        %_N_EDGE_SPF\n;$PATH=/_N_CMA_DIR\nG1 X99 F100\nM17\n\
        %_N_PART_MPF\n;$PATH=/_N_WKS_DIR/_N_SHAFT_WPD\nG90 G54 G0 X1 Y2 Z50\nEDGE\nM30\n\
        %_N_EDGE_SPF\n;$PATH=/_N_WKS_DIR/_N_SHAFT_WPD\nG1 X30 F100\nM17\n\
        %_N_OTHER_MPF\n;$PATH=/_N_MPF_DIR\nG90 G54 G0 X7\nM30\n";
    let shop = Shop::new().file("SAVE.arc", text);
    let demo = machine("demo");
    for name in ["PART.MPF", "part.mpf", "WKS.DIR/SHAFT.WPD/PART.MPF"] {
        let run = shop.run(["snc", &format!("SAVE.arc/{name}"), "--machine", &demo]).exits(0);
        let moves: Vec<&str> = run.stdout.lines().skip(1).filter_map(|line| line.split(" ;@").next()).collect();
        let x: Vec<f64> = moves[..2].iter().map(|line| line.split(' ').nth(1).unwrap()[1..].parse().unwrap()).collect();
        assert_eq!(x[1] - x[0], 29.0, "{name}: {moves:?}");
    }
    shop.run(["check", "SAVE.arc/NOWHERE.MPF", "--machine", &demo]).exits(2).says("has no file NOWHERE.MPF");
}
