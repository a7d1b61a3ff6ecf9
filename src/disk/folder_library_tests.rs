//! Tests of the folders in which programs are searched, in temporary folders.

use std::fs;
use std::path::Path;

use super::folder_library::FolderLibrary;
use ncfix_language::exec::Library as _;

fn folder(files: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in files {
        let path = folder.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, file).unwrap();
    }
    folder
}

fn library(program: &Path) -> FolderLibrary {
    FolderLibrary::beside(Some(program), &[]).0
}

fn text(found: Option<(String, Vec<u8>)>) -> Option<String> {
    found.map(|(_, bytes)| String::from_utf8(bytes).unwrap())
}

fn load(folder: &Path, name: &str) -> Option<String> {
    text(library(&folder.join("main.mpf")).load(name))
}

#[test]
fn names_are_found_in_any_case_and_form() {
    let folder = folder(&["l10.spf", "POCKET.MPF", "_N_EDGE_SPF", "PLAIN"]);
    let found = |name| load(folder.path(), name);
    assert_eq!(found("L10").as_deref(), Some("l10.spf"));
    assert_eq!(found("pocket").as_deref(), Some("POCKET.MPF"));
    assert_eq!(found("EDGE").as_deref(), Some("_N_EDGE_SPF"));
    assert_eq!(found("PLAIN").as_deref(), Some("PLAIN"));
    assert_eq!(found("L010"), None);
}

#[test]
fn a_subprogram_goes_before_a_main_program() {
    let folder = folder(&["A.MPF", "A.SPF", "A"]);
    assert_eq!(load(folder.path(), "A").as_deref(), Some("A.SPF"));
}

#[test]
fn no_name_leads_out_of_the_folder() {
    let outer = folder(&["SECRET.SPF"]);
    let inner = outer.path().join("inner");
    fs::create_dir(&inner).unwrap();
    assert_eq!(load(&inner, "../SECRET"), None);
    assert_eq!(load(&inner, outer.path().join("SECRET").to_str().unwrap()), None);
    assert_eq!(load(outer.path(), "inner"), None);
    assert!(library(&inner.join("m.mpf")).load_path("/../SECRET", "SECRET").is_none());
    // Folders above that of the program that do not belong to a control.
    let root = folder(&["etc/PASSWD", "jobs/a/MAIN.MPF", "jobs/a/parts/L1.SPF", "MPF.DIR/L2.SPF"]);
    let mut library = library(&root.path().join("jobs/a/MAIN.MPF"));
    assert!(library.load_path("/etc/passwd", "PASSWD").is_none());
    assert!(library.load_path("/_N_jobs_DIR/_N_a/MAIN", "MAIN").is_none());
    assert_eq!(text(library.load_path("/parts/L1", "L1")).as_deref(), Some("jobs/a/parts/L1.SPF"));
    assert_eq!(text(library.load_path("/_N_MPF_DIR/L2", "L2")).as_deref(), Some("MPF.DIR/L2.SPF"));
}

#[cfg(unix)]
#[test]
fn links_are_followed_within_the_folders_of_the_program() {
    use std::os::unix::fs::symlink;
    let outer = folder(&["SECRET.SPF", "own/parts/L1.SPF", "own/MAIN.MPF", "common/L2.SPF", "elsewhere/L3.SPF"]);
    let own = outer.path().join("own");
    symlink("parts/L1.SPF", own.join("INSIDE.SPF")).unwrap();
    symlink("../common/L2.SPF", own.join("SHARED.SPF")).unwrap();
    symlink(outer.path().join("SECRET.SPF"), own.join("OUTSIDE.SPF")).unwrap();
    symlink("AROUND.SPF", own.join("AROUND.SPF")).unwrap();
    let (mut library, _) = FolderLibrary::beside(Some(&own.join("MAIN.MPF")), &["../common".to_owned()]);
    assert_eq!(text(library.load("INSIDE")).as_deref(), Some("own/parts/L1.SPF"));
    assert_eq!(text(library.load("SHARED")).as_deref(), Some("common/L2.SPF"));
    assert!(library.refusal().is_none());
    assert!(library.load("OUTSIDE").is_none());
    assert!(
        library
            .refusal()
            .unwrap()
            .ends_with("OUTSIDE.SPF is a symbolic link that leads out of the folders that belong to the program")
    );
    // A link to itself is not a file.
    assert!(library.load("AROUND").is_none() && library.refusal().is_none());
    // A linked folder counts if its target is below a possible root of the control's file system.
    let nested = folder(&["a/b/c/MAIN.MPF", "a/other/L4.SPF"]);
    symlink("../../other", nested.path().join("a/b/c/SPF.DIR")).unwrap();
    symlink(outer.path().join("elsewhere"), nested.path().join("a/b/c/CUS.DIR")).unwrap();
    let mut library = self::library(&nested.path().join("a/b/c/MAIN.MPF"));
    assert_eq!(text(library.load("L4")).as_deref(), Some("a/other/L4.SPF"));
    assert!(library.load("L3").is_none());
}

#[test]
fn loaded_files_are_remembered_and_standard_input_has_none() {
    let folder = folder(&["L1.SPF"]);
    let (mut library, loaded) = FolderLibrary::beside(Some(&folder.path().join("m.mpf")), &[]);
    library.load("L1").unwrap();
    assert_eq!(*loaded.borrow(), [folder.path().join("L1.SPF")]);
    assert!(FolderLibrary::beside(None, &[]).0.load("L1").is_none());
}

#[test]
fn folders_are_searched_in_the_order_of_the_control() {
    let root = folder(&[
        "WKS.DIR/PART.WPD/MAIN.MPF",
        "WKS.DIR/PART.WPD/L1.SPF",
        "spf.dir/L1.SPF",
        "spf.dir/L2.SPF",
        "more/L3.SPF",
        "CUS/L2.SPF",
        "CUS/L3.SPF",
        "CMA.DIR/L4.SPF",
        "CST.DIR/L4.SPF",
        "WKS.DIR/OTHER.WPD/L4.SPF",
        "WKS.DIR/OTHER.WPD/L5.SPF",
    ]);
    let program = root.path().join("WKS.DIR/PART.WPD/MAIN.MPF");
    let (mut library, _) = FolderLibrary::beside(Some(&program), &["../../more".to_owned()]);
    assert_eq!(text(library.load("L1")).as_deref(), Some("WKS.DIR/PART.WPD/L1.SPF"));
    assert_eq!(text(library.load("L2")).as_deref(), Some("spf.dir/L2.SPF"));
    assert_eq!(text(library.load("L3")).as_deref(), Some("more/L3.SPF"));
    assert_eq!(text(library.load("L4")).as_deref(), Some("CMA.DIR/L4.SPF"));
    assert!(library.load("L5").is_none());
    let other = "WKS.DIR/OTHER.WPD/L5.SPF";
    assert_eq!(text(library.load_path("/_N_WKS_DIR/_N_OTHER_WPD/L5", "L5")).as_deref(), Some(other));
    assert_eq!(text(library.load_path("NC:/WKS.DIR/OTHER.WPD/L5.SPF", "L5")).as_deref(), Some(other));
    library.add_folder("/_N_WKS_DIR/_N_OTHER_WPD");
    assert_eq!(text(library.load("L5")).as_deref(), Some(other));
    assert_eq!(text(library.load("L4")).as_deref(), Some("WKS.DIR/OTHER.WPD/L4.SPF"), "before CUS, CMA and CST");
    library.add_folder("");
    assert!(library.load("L5").is_none());
}

#[test]
fn definition_files_are_found_macros_first() {
    let root = folder(&["MPF.DIR/MAIN.MPF", "DEF.DIR/UGUD.DEF", "def.dir/_N_SMAC_DEF", "MPF.DIR/OTHER.DEF"]);
    let found = library(&root.path().join("MPF.DIR/MAIN.MPF")).definitions();
    let mut shown: Vec<String> = found.into_iter().map(|file| text(Some(file)).unwrap()).collect();
    // If the file system ignores case, both are in one folder.
    shown.retain(|name| name != "def.dir/_N_SMAC_DEF");
    assert_eq!(shown, ["DEF.DIR/UGUD.DEF"]);
}
