//! Programs and definition files in the folder of the main program and in the folders of a control's file system.
//!
//! `L123`, `POCKET` become files of the main program's folder, then of the folders of `control.search_path`, then of
//! the conventional folders `SPF.DIR`, `CUS.DIR`, `CMA.DIR`, `CST.DIR` up to two levels above it, with names in any
//! case.
//!
//! A symbolic link is followed if its target is in one of these folders or below. Any other link is refused: the
//! author of a folder of programs must not select other files of the disk for reading, whose text could be shown in
//! diagnostics.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::files;
use super::numbered_programs::NumberedPrograms;
use crate::error::reason;
use ncfix_base::source::MAX_BYTES;
use ncfix_language::exec::Library;

/// Folders of a control that are searched by default, in its order.
const USUAL: [&str; 4] = ["SPF", "CUS", "CMA", "CST"];
/// Folders at the root of a control's file system. Above the folder of the program a path must begin with one of
/// them, because other folders may belong to anyone, and `/etc/passwd` is not a program.
const TOP: [&str; 7] = ["WKS", "MPF", "SPF", "CUS", "CMA", "CST", "DEF"];
/// The folder of definition files.
const DEFINITIONS: &str = "DEF";
/// Definition files of a control in its reading order, macros first.
pub(crate) const DEFINITION_FILES: [&str; 14] =
    ["SMAC", "MMAC", "PMAC", "UMAC", "SGUD", "PGUD", "MGUD", "UGUD", "GUD4", "GUD5", "GUD6", "GUD7", "GUD8", "GUD9"];
/// Number of levels above the folder of the program that may be the root of the control's file system.
const LEVELS_UP: usize = 2;
/// Maximum number of folders that one program may add with CALLPATH.
const MAX_ADDED: usize = 100;

/// A folder whose files are listed at the first search.
struct Folder {
    path: PathBuf,
    /// Files by lower-case name; several if their names differ only in case.
    files: Option<HashMap<String, Vec<PathBuf>>>,
}

/// The folders of the main program and of its control.
pub(crate) struct FolderLibrary {
    /// Searched first: the program's own, those of the machine file, `SPF.DIR`.
    first: Vec<Folder>,
    /// Added by CALLPATH.
    added: Vec<Folder>,
    /// Searched last: `CUS.DIR`, `CMA.DIR`, `CST.DIR`.
    last: Vec<Folder>,
    /// Folders of the definition files.
    definitions: Vec<Folder>,
    /// Folders at which paths from the root of the control's file system may begin.
    roots: Vec<PathBuf>,
    /// Program numbers in the files of the first folders, read at the first search.
    numbered: Option<NumberedPrograms>,
    loaded: Rc<RefCell<Vec<PathBuf>>>,
    /// The reason why a file was not read; a later name without a file does not change it.
    refused: Option<String>,
}

impl FolderLibrary {
    /// The folder of `program` and its related folders; none for a program from standard input. The second value
    /// lists the files that were read while the program runs: they must not be overwritten.
    pub(crate) fn beside(program: Option<&Path>, search_path: &[String]) -> (FolderLibrary, Rc<RefCell<Vec<PathBuf>>>) {
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
            numbered: None,
            loaded: Rc::clone(&loaded),
            refused: None,
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
        found.filter(|folder| !is_link(folder) || leads_into(folder, &self.roots)).map(Folder::new).collect()
    }

    /// The file of a program: the first file with one of these names, folder by folder. Names are only compared with
    /// those of files in the folders, so no name leads out of them.
    fn find(&mut self, names: &[String]) -> Option<PathBuf> {
        let mut folders = self.first.iter_mut().chain(&mut self.added).chain(&mut self.last);
        folders.find_map(|folder| folder.find(names))
    }

    /// The folder of a path in the notation of the control: `/_N_WKS_DIR/_N_PART_WPD`, `NC:/WKS.DIR/PART.WPD`.
    fn resolve(&self, path: &str) -> Option<PathBuf> {
        let path = path.replace('\\', "/");
        let path = path.rsplit(':').next().unwrap_or_default();
        let parts: Vec<&str> = path.split('/').filter(|part| !part.is_empty()).collect();
        let plain =
            |part: &str| part.strip_prefix("_N_").or_else(|| part.strip_prefix("_n_")).unwrap_or(part).to_owned();
        let top = parts.first().map(|part| plain(part).to_ascii_uppercase()).unwrap_or_default();
        let top = top.strip_suffix(".DIR").or_else(|| top.strip_suffix("_DIR")).unwrap_or(&top);
        // The first root is the folder of the program itself.
        let reach = if TOP.contains(&top) { self.roots.len() } else { 1 };
        self.roots.iter().take(reach).find_map(|root| {
            let mut folder = root.clone();
            for part in &parts {
                let name = &plain(part);
                folder = subfolder(&folder, name)?;
                if is_link(&folder) && !leads_into(&folder, &self.roots) {
                    return None;
                }
            }
            Some(folder)
        })
    }

    /// Reads a file of a folder, and stores the reason if it must not or cannot be read.
    fn read(&mut self, path: PathBuf, role: &str) -> Option<(String, Vec<u8>)> {
        let shown = path.strip_prefix(".").unwrap_or(&path).display().to_string();
        if is_link(&path) {
            let folders = self.first.iter().chain(&self.added).chain(&self.last).chain(&self.definitions);
            if !leads_into(&path, folders.map(|folder| &folder.path)) {
                self.refused = Some(format!(
                    "{shown} is a symbolic link that leads out of the folders that belong to the program"
                ));
                return None;
            }
        }
        match files::bytes_of(&path, MAX_BYTES) {
            Ok(bytes) => {
                self.refused = None;
                log::info!("read {shown}: {role}");
                self.loaded.borrow_mut().push(path);
                Some((shown, bytes))
            }
            Err(error) => {
                self.refused = Some(format!("{shown} cannot be read: {}", reason(&error)));
                None
            }
        }
    }
}

fn is_link(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink())
}

/// True if the target of a link is in one of these folders or below.
fn leads_into(link: &Path, folders: impl IntoIterator<Item = impl AsRef<Path>>) -> bool {
    let Ok(end) = link.canonicalize() else { return false };
    folders.into_iter().any(|folder| folder.as_ref().canonicalize().is_ok_and(|folder| end.starts_with(folder)))
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

/// The possible names of a program's file.
fn file_names(name: &str) -> Vec<String> {
    vec![
        format!("{name}.SPF"),
        format!("{name}.MPF"),
        name.to_owned(),
        format!("_N_{name}_SPF"),
        format!("_N_{name}_MPF"),
    ]
}

/// The folder itself and those above it that may be the root of the control's file system.
fn roots(own: &Path) -> Vec<PathBuf> {
    let full = own.canonicalize().unwrap_or_else(|_| own.to_path_buf());
    let mut roots = vec![own.to_path_buf()];
    // The root of the disk is never the root of a control's file system.
    let above = full.ancestors().skip(1).take(LEVELS_UP).filter(|folder| folder.parent().is_some());
    roots.extend(above.map(Path::to_path_buf));
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

    fn load_number(&mut self, number: u32) -> Option<(String, Vec<u8>)> {
        let folders = self.first.iter().map(|folder| folder.path.as_path());
        let numbered = self.numbered.get_or_insert_with(|| NumberedPrograms::of(folders));
        match numbered.find(number).map(|path| path.map(Path::to_path_buf)) {
            Ok(path) => self.read(path?, "subprogram, by its number in a folder that belongs to the program"),
            Err(message) => {
                self.refused = Some(message);
                None
            }
        }
    }

    fn load_path(&mut self, path: &str, name: &str) -> Option<(String, Vec<u8>)> {
        let (folder, _) = path.rsplit_once(['/', '\\'])?;
        let file = Folder::new(self.resolve(folder)?).find(&file_names(name))?;
        self.read(file, "subprogram, by its path on the control")
    }

    fn refusal(&mut self) -> Option<String> {
        self.refused.take()
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
        let role = "definitions, in a folder that belongs to the program";
        let read = found.into_iter().filter_map(|path| self.read(path, role)).collect();
        // Missing data are reported when they are used.
        self.refused = None;
        read
    }
}
