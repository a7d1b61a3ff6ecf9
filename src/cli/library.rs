//! Programs and definition files beside the main program and in the folders of a control's file system.
//!
//! `L123`, `POCKET` become files of the main program's folder, then of the folders of `control.search_path`, then of the conventional
//! folders `SPF.DIR`, `CUS.DIR`, `CMA.DIR`, `CST.DIR` up to two levels above it, whatever the case of their names.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::voice;
use crate::exec::Library;

/// Folders of a control that are searched without being named, in its order.
const USUAL: [&str; 4] = ["SPF", "CUS", "CMA", "CST"];
/// The folder of definition files.
const DEFINITIONS: &str = "DEF";
/// Definition files of a control in the order in which it reads them, macros first.
pub(super) const DEFINITION_FILES: [&str; 14] =
    ["SMAC", "MMAC", "PMAC", "UMAC", "SGUD", "PGUD", "MGUD", "UGUD", "GUD4", "GUD5", "GUD6", "GUD7", "GUD8", "GUD9"];
/// So many folders above that of the program may be the root of the control's file system.
const LEVELS_UP: usize = 2;
/// Folders that one program may add with CALLPATH.
const MAX_ADDED: usize = 100;

/// A folder whose files are listed when the first one is looked for.
struct Folder {
    path: PathBuf,
    /// Files by lower-case name; several where only the case differs.
    files: Option<HashMap<String, Vec<PathBuf>>>,
}

/// The folders of the main program and its control.
pub(super) struct FolderLibrary {
    /// Searched first: the program's own, those of the machine file, `SPF.DIR`.
    first: Vec<Folder>,
    /// Added by CALLPATH.
    added: Vec<Folder>,
    /// Searched last: `CUS.DIR`, `CMA.DIR`, `CST.DIR`.
    last: Vec<Folder>,
    /// Where the definition files are.
    definitions: Vec<Folder>,
    /// Where paths from the root of the control's file system may begin.
    roots: Vec<PathBuf>,
    loaded: Rc<RefCell<Vec<PathBuf>>>,
}

impl FolderLibrary {
    /// The folder of `program` and what belongs to it; none for a program from standard input. The second value lists, as the
    /// program runs, the files that were read: none of them may be overwritten.
    pub(super) fn beside(program: Option<&Path>, search_path: &[String]) -> (FolderLibrary, Rc<RefCell<Vec<PathBuf>>>) {
        let loaded = Rc::default();
        let own = program.map(|program| match program.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
            _ => PathBuf::from("."),
        });
        let mut library = FolderLibrary {
            first: Vec::new(),
            added: Vec::new(),
            last: Vec::new(),
            definitions: Vec::new(),
            roots: own.as_deref().map(roots).unwrap_or_default(),
            loaded: Rc::clone(&loaded),
        };
        let base = own.clone().unwrap_or_default();
        library.first.extend(own.into_iter().map(Folder::new));
        library.first.extend(search_path.iter().map(|entry| Folder::new(base.join(entry))));
        for (place, name) in USUAL.into_iter().enumerate() {
            let found = library.usual(name);
            if place == 0 { library.first.extend(found) } else { library.last.extend(found) }
        }
        library.definitions = library.usual(DEFINITIONS);
        (library, loaded)
    }

    /// The folders of a conventional name, nearest first.
    fn usual(&self, name: &str) -> Vec<Folder> {
        let found = self.roots.iter().filter_map(|root| subfolder(root, name));
        found.map(Folder::new).collect()
    }

    /// The file of a program. Only names of files in the folders are ever compared, so no name leads out of them.
    /// The first file of these names, folder by folder.
    fn find(&mut self, names: &[String]) -> Option<PathBuf> {
        let mut folders = self.first.iter_mut().chain(&mut self.added).chain(&mut self.last);
        folders.find_map(|folder| folder.find(names))
    }

    /// The folder that a path of the control means: `/_N_WKS_DIR/_N_PART_WPD`, `NC:/WKS.DIR/PART.WPD`.
    fn resolve(&self, path: &str) -> Option<PathBuf> {
        let path = path.replace('\\', "/");
        let path = path.rsplit(':').next().unwrap_or_default();
        let parts: Vec<&str> = path.split('/').filter(|part| !part.is_empty()).collect();
        self.roots.iter().find_map(|root| {
            let mut folder = root.clone();
            for part in &parts {
                let name = part.strip_prefix("_N_").or_else(|| part.strip_prefix("_n_")).unwrap_or(part);
                folder = subfolder(&folder, name)?;
            }
            Some(folder)
        })
    }

    fn read(&self, path: PathBuf, role: &str) -> Option<(String, Vec<u8>)> {
        let bytes = fs::read(&path).ok()?;
        let shown = path.strip_prefix(".").unwrap_or(&path).display().to_string();
        voice::note(|| format!("read {shown}: {role}"));
        self.loaded.borrow_mut().push(path);
        Some((shown, bytes))
    }
}

impl Folder {
    fn new(path: PathBuf) -> Folder {
        Folder { path, files: None }
    }

    fn find(&mut self, candidates: &[String]) -> Option<PathBuf> {
        let files = self.files.get_or_insert_with(|| list(&self.path));
        candidates.iter().find_map(|candidate| {
            let paths = files.get(&candidate.to_lowercase())?;
            let same_case = |path: &&PathBuf| path.file_name().is_some_and(|file| file == candidate.as_str());
            paths.iter().find(same_case).or_else(|| paths.first()).cloned()
        })
    }
}

/// The forms of the name of a program's file.
fn file_names(name: &str) -> Vec<String> {
    vec![
        format!("{name}.SPF"),
        format!("{name}.MPF"),
        name.to_owned(),
        format!("_N_{name}_SPF"),
        format!("_N_{name}_MPF"),
    ]
}

/// The folder itself and those above it, as far as they may be the root of the control's file system.
fn roots(own: &Path) -> Vec<PathBuf> {
    let full = own.canonicalize().unwrap_or_else(|_| own.to_path_buf());
    let mut roots = vec![own.to_path_buf()];
    roots.extend(full.ancestors().skip(1).take(LEVELS_UP).map(Path::to_path_buf));
    roots
}

/// The subfolder `NAME`, `NAME.DIR` or, for `NAME_DIR`, `NAME.DIR`, in any case.
fn subfolder(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.to_lowercase();
    let dotted = name.rsplit_once('_').map(|(front, ending)| format!("{front}.{ending}"));
    let with_ending = format!("{name}.dir");
    let mut found: Vec<PathBuf> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| {
            let known = entry.file_name().to_string_lossy().to_lowercase();
            known == name || known == with_ending || Some(known) == dotted
        })
        .map(|entry| folder.join(entry.file_name()))
        .filter(|path| path.is_dir())
        .collect();
    found.sort();
    found.into_iter().next()
}

/// The plain files of a folder by lower-case name, in a fixed order.
fn list(folder: &Path) -> HashMap<String, Vec<PathBuf>> {
    let mut files: HashMap<String, Vec<PathBuf>> = HashMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if let (Ok(name), true) = (entry.file_name().into_string(), entry.path().is_file()) {
            files.entry(name.to_lowercase()).or_default().push(folder.join(name));
        }
    }
    files.values_mut().for_each(|paths| paths.sort());
    files
}

impl Library for FolderLibrary {
    fn load(&mut self, name: &str) -> Option<(String, Vec<u8>)> {
        let path = self.find(&file_names(name))?;
        self.read(path, "subprogram, in a folder that belongs to the program")
    }

    fn load_file(&mut self, names: &[String]) -> Option<(String, Vec<u8>)> {
        let path = self.find(names)?;
        self.read(path, "subprogram, in a folder that belongs to the program")
    }

    fn load_path(&mut self, path: &str, name: &str) -> Option<(String, Vec<u8>)> {
        let (folder, _) = path.rsplit_once(['/', '\\'])?;
        let file = Folder::new(self.resolve(folder)?).find(&file_names(name))?;
        self.read(file, "subprogram, by its path on the control")
    }

    fn add_folder(&mut self, path: &str) {
        if path.is_empty() {
            self.added.clear();
        } else if let Some(folder) = self.resolve(path).filter(|_| self.added.len() < MAX_ADDED) {
            self.added.push(Folder::new(folder));
        }
    }

    fn definitions(&mut self) -> Vec<(String, Vec<u8>)> {
        let mut found = Vec::new();
        for name in DEFINITION_FILES {
            let candidates = [format!("{name}.DEF"), format!("_N_{name}_DEF")];
            let mut folders = self.first.iter_mut().chain(&mut self.definitions).chain(&mut self.last);
            found.extend(folders.find_map(|folder| folder.find(&candidates)));
        }
        found
            .into_iter()
            .filter_map(|path| self.read(path, "definitions, in a folder that belongs to the program"))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        // Where the file system knows no case both are in one folder.
        shown.retain(|name| name != "def.dir/_N_SMAC_DEF");
        assert_eq!(shown, ["DEF.DIR/UGUD.DEF"]);
    }
}
