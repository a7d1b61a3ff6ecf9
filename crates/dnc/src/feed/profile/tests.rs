//! Shipped profiles, and profiles that are refused.

use super::*;
use ncfix_base::source::FileId;

#[test]
fn all_that_are_shipped_are_sound_and_named_as_their_files() {
    for (name, text) in PROFILES {
        let source = Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap();
        let profile = Profile::read(&source).unwrap();
        assert_eq!(profile.name, *name);
        let protocol = profile.protocol;
        assert!((protocol.create)(&profile).is_ok());
    }
}

#[test]
fn numbers_of_a_link_have_ranges() {
    let read = |text: &str| {
        let text = format!("name = \"a\"\nprotocol = \"grbl\"\n{text}");
        Profile::read(&Source::new(FileId(0), "a.toml", text.into_bytes()).unwrap())
    };
    for (section, key, least, most) in [
        ("serial", "baud", 50_i64, 4_000_000),
        ("window", "lines", 1, 1000),
        ("window", "bytes", 1, 65_536),
        ("window", "system_bytes", 1, 65_536),
        ("window", "planned", 0, 10_000),
        ("text", "longest_line", 1, 4096),
        ("answer", "repeats", 0, 100),
    ] {
        for (value, is_in) in
            [(least - 1, false), (least, true), (most, true), (most + 1, false), (4_000_000_001, false)]
        {
            if value < 0 {
                continue;
            }
            let found = read(&format!("[{section}]\n{key} = {value}\n"));
            match found {
                Ok(_) => assert!(is_in, "{key} = {value}"),
                Err(found) => assert!(
                    !is_in && found.iter().all(|one| one.code == Code::OUT_OF_RANGE),
                    "{key} = {value}: {found:?}"
                ),
            }
        }
    }
    for value in [0, 10_001] {
        let found = read(&format!("[depth]\nat_most = {value}\nsource = \"planner.h\"\n")).unwrap_err();
        assert_eq!(found[0].code, Code::OUT_OF_RANGE);
    }
}

#[test]
fn seven_bits_with_parity_and_two_stop_bits_are_eleven() {
    let serial =
        Serial { baud: 9600, data_bits: 7, parity: Parity::Even, stop_bits: 2, rts_cts: false, software_parity: false };
    assert_eq!(serial.bits_per_character(), 11);
    assert!((serial.characters_per_s() - 872.7).abs() < 0.1);
}
