//! Logs of temperatures and loads: what is read, what is refused and where.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Vector;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::condition::log;
use ncfix_machine::machine::{Condition, Load};

fn read(bytes: &[u8]) -> (Option<Condition>, Vec<(String, usize, usize)>) {
    let source = Source::new(FileId(0), "log.csv", bytes.to_vec()).unwrap();
    let (condition, findings) = log::load(&source);
    let seen = |finding: &Diagnostic| {
        let (line, column) = source.line_column(finding.place.unwrap().span.start);
        (finding.code.to_string(), line, column)
    };
    (condition, findings.iter().map(seen).collect())
}

#[track_caller]
fn sound(bytes: &[u8]) -> Condition {
    let (condition, findings) = read(bytes);
    assert!(findings.is_empty(), "{findings:?}");
    condition.unwrap()
}

fn temperature_c(condition: &mut Condition, sensor: &str, time_s: f64) -> Option<f64> {
    condition.set_time(time_s);
    condition.temperature_c(sensor, 0.0)
}

#[test]
fn temperatures_are_read_with_gaps_and_stand_at_the_last_row() {
    let mut log = sound(b"t_s,spindle_rpm,T_head_C,T_bed_C,X\n0,0,20,,1\n60,,,19.5,2\n120,3000,26,,\n180,,,,\n");
    assert_eq!(log.time_s(), 180.0);
    assert_eq!(log.temperature_c("T_head", 0.0), Some(26.0));
    assert_eq!(log.sensors().collect::<Vec<_>>(), ["T_bed", "T_head"]);
    for (sensor, time_s, expected) in [
        ("T_head", 0.0, 20.0),
        ("T_head", 60.0, 23.0),
        ("T_head", 90.0, 24.5),
        ("T_bed", 0.0, 19.5),
        ("T_bed", 99.0, 19.5),
    ] {
        assert_eq!(temperature_c(&mut log, sensor, time_s), Some(expected), "{sensor} {time_s}");
    }
    assert_eq!(log.temperature_c("T_none", 0.0), None);
}

#[test]
fn tables_as_spreadsheets_write_them_say_the_same() {
    let plain = sound(b"t_s,T_head_C,note\n0,20.5,a\n60.5,21,b\n");
    for bytes in [
        &b"\xef\xbb\xbft_s;T_head_C;note\r\n0;20,5;a\r\n60,5;21;b\r\n;;\r\n\r\n"[..],
        b"\"t_s\"\t\"T_head_C\"\tnote\n0\t20.5\t\n60.5\t21\t\n",
        b"t_s, T_head_C, note\r0 , 20.5 ,\"a, b\"\r60.5,21e0,\xfc\r",
    ] {
        assert_eq!(sound(bytes), plain, "{}", String::from_utf8_lossy(bytes));
    }
}

#[test]
fn a_load_stays_until_another_is_stated() {
    let mut log = sound(b"t_s,load_N,load_x_mm,load_z_mm\n0,,,\n10,1700,,-280\n20,,,\n30,,50,\n40,0,0,0\n");
    let mut loads = |time_s: f64| {
        log.set_time(time_s);
        log.loads().to_vec()
    };
    let load = |force_n: f64, x: f64, z: f64| vec![Load { force_n, position_mm: Vector::new(x, 0.0, z) }];
    assert_eq!(loads(9.9), []);
    assert_eq!(loads(10.0), load(1700.0, 0.0, -280.0));
    assert_eq!(loads(29.0), load(1700.0, 0.0, -280.0));
    assert_eq!(loads(30.0), load(1700.0, 50.0, -280.0));
    assert_eq!(loads(99.0), load(0.0, 0.0, 0.0));
    assert_eq!(loads(0.0), []);
    let own = Load { force_n: 5.0, position_mm: Vector::zeros() };
    log.add_load(own);
    log.set_time(10.0);
    assert_eq!(log.loads(), [load(1700.0, 0.0, -280.0)[0], own]);
    log.clear_loads();
    log.set_time(30.0);
    assert_eq!(log.loads(), []);
}

#[test]
fn a_log_is_known_by_its_first_line() {
    let is_log = |text: &str| log::is_log(&Source::new(FileId(0), "state", text.as_bytes().to_vec()).unwrap());
    for text in ["t_s,T_head_C\n0,20\n", "\n\"t_s\";T_head_C", "\u{feff}t_s\tT_C\r\n", "anything", "sep=;\nt_s;T_C"] {
        assert!(is_log(text), "{text}");
    }
    for text in [
        "",
        "\n",
        "\u{feff}[temperature_C]",
        "# t_s,T_C\n",
        "[temperature_C]\nT = 1\n",
        "  temperature_C = { T = 1 }\n",
    ] {
        assert!(!is_log(text), "{text}");
    }
}

#[track_caller]
fn finds(bytes: &[u8], expected: &[(&str, usize, usize)]) {
    let (condition, findings) = read(bytes);
    let expected: Vec<_> = expected.iter().map(|&(code, line, column)| (code.to_owned(), line, column)).collect();
    assert_eq!(findings, expected, "{}", String::from_utf8_lossy(bytes));
    assert!(condition.is_none());
}

#[test]
fn faults_are_found_at_line_and_column() {
    finds(b"", &[("E0601", 1, 1)]);
    finds(b"\n\n", &[("E0601", 1, 1)]);
    finds(b"t_s,T_head_C\n", &[("E0601", 1, 1)]);
    finds(b"T_head_C\n20\n", &[("E0602", 1, 1)]);
    finds(b"t_s,dx_um\n0,1\n", &[("E0602", 1, 1)]);
    finds(b"t_s,load_x_mm\n0,1\n", &[("E0602", 1, 1)]);
    finds(b"t_s,T_C,T_C\n0,1,2\n", &[("E0602", 1, 9)]);
    finds(b"t\0_s\n", &[("E0601", 1, 2)]);
    finds(b"t_s,T_C\n0,20\n1\n2,20,3\n", &[("E0601", 3, 1), ("E0601", 4, 1)]);
    finds(b"t_s;T_C\n0;20.5\n1;20,5\n", &[("E0603", 3, 3)]);
    finds(
        b"t_s,T_head_C,load_N\n0,20,1\n60,2O,-1\n\n120,500,x\n60,20,1\n,20,1\n300,nan,inf\n1e999,20,1\n",
        &[
            ("E0603", 3, 4),
            ("E0603", 3, 7),
            ("E0603", 5, 5),
            ("E0603", 5, 9),
            ("E0603", 6, 1),
            ("E0603", 7, 1),
            ("E0603", 8, 5),
            ("E0603", 8, 9),
            ("E0603", 9, 1),
        ],
    );
    let many = format!("t_s,T_C\n{}", "a,b\n".repeat(100_000));
    assert!(read(many.as_bytes()).1.len() <= 51);
}

#[test]
fn no_bytes_make_it_panic() {
    let log = b"t_s;T_head_C;\"load_N\";load_z_mm\r\n0;20,5;\"1\";2\r\n60;;;\r\n120;21,5;7;-3\r\n";
    for at in 0..log.len() {
        for byte in [0, b'"', b';', b',', b'\n', b'\r', b'-', b'9', 0xff] {
            let mut bytes = log.to_vec();
            bytes[at] = byte;
            let (condition, findings) = read(&bytes);
            assert_eq!(condition.is_none(), !findings.is_empty());
            let _ = read(&bytes[..at]);
        }
    }
}

#[test]
fn a_long_log_is_read_in_a_moment() {
    let mut text = String::from("t_s");
    (0..16).for_each(|index| write!(text, ",T_{index}_C").unwrap());
    for row in 0..100_000 {
        write!(text, "\n{}", row * 60).unwrap();
        (0..16).for_each(|index| write!(text, ",{}.{:02}", 20 + index, row % 100).unwrap());
    }
    let start = Instant::now();
    let condition = sound(text.as_bytes());
    let elapsed = start.elapsed();
    assert_eq!(condition.temperature_c("T_15", 0.0), Some(35.99));
    // Two cores that others use too, without optimization: a tenth of it is usual.
    assert!(elapsed < Duration::from_secs(5), "{elapsed:?}");
}
