//! Programs that stand under their O number in a file of another name: `O1002` in `gauge_tool.cnc`.
//!
//! Fanuc and Haas know a program by its number, not by the name of a file. So the number is sought in the files of the program's own folders. The search is
//! bounded: a folder with too many files, or too large ones, is searched by names only.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::files;

/// Endings of program files, in lower case; the first one is of a name without an ending.
const ENDINGS: [&str; 8] = ["", "nc", "cnc", "tap", "txt", "prg", "eia", "min"];
/// Maximum number of program files in the folders.
const MOST_FILES: usize = 1000;
/// Maximum size of all these files together, bytes.
const MOST_BYTES: u64 = 64 << 20;
/// Maximum number of digits of an O number.
const MOST_DIGITS: usize = 8;

/// The program numbers in files, with the files of each.
#[derive(Debug, Default)]
pub(super) struct NumberedPrograms {
    files: HashMap<u32, Vec<PathBuf>>,
}

impl NumberedPrograms {
    /// Reads the numbers in the files of folders; none if there are too many or too large ones.
    pub(super) fn of<'a>(folders: impl IntoIterator<Item = &'a Path>) -> NumberedPrograms {
        let mut found = NumberedPrograms::default();
        let Some(paths) = candidates(folders) else { return found };
        for path in paths {
            let Ok(bytes) = files::bytes_of(&path, MOST_BYTES as usize) else { continue };
            for number in numbers(&bytes) {
                let known = found.files.entry(number).or_default();
                if known.last() != Some(&path) {
                    known.push(path.clone());
                }
            }
        }
        found
    }

    /// The file of a program number; an error names the files if there are several.
    pub(super) fn find(&self, number: u32) -> Result<Option<&Path>, String> {
        match self.files.get(&number).map(Vec::as_slice) {
            None | Some([]) => Ok(None),
            Some([path]) => Ok(Some(path)),
            Some([one, other, ..]) => {
                let [one, other] = [one, other].map(|path| path.strip_prefix(".").unwrap_or(path).display());
                Err(format!("O{number:04} is in {one} and in {other}, and it is not known which one the control has"))
            }
        }
    }
}

/// The program files of folders, in a fixed order; `None` above the limits.
pub(crate) fn candidates<'a>(folders: impl IntoIterator<Item = &'a Path>) -> Option<Vec<PathBuf>> {
    let (mut paths, mut bytes) = (Vec::new(), 0_u64);
    for folder in folders {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = folder.join(entry.file_name());
            let ending = path.extension().map_or_else(String::new, |end| end.to_string_lossy().to_ascii_lowercase());
            // A link may lead out of the folder.
            let Ok(data) = fs::symlink_metadata(&path) else { continue };
            if !data.is_file() || !ENDINGS.contains(&ending.as_str()) {
                continue;
            }
            bytes = bytes.saturating_add(data.len());
            if paths.len() == MOST_FILES || bytes > MOST_BYTES {
                return None;
            }
            paths.push(path);
        }
    }
    paths.sort();
    paths.dedup();
    Some(paths)
}

/// The O numbers at the beginnings of lines; a colon is the O of the ISO code.
pub(crate) fn numbers(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.split(|byte| matches!(byte, b'\n' | b'\r')).filter_map(|line| {
        let rest = line.trim_ascii_start().strip_prefix(b"O").or_else(|| {
            let line = line.trim_ascii_start();
            line.strip_prefix(b"o").or_else(|| line.strip_prefix(b":"))
        })?;
        let count = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        if count == 0 || count > MOST_DIGITS {
            return None;
        }
        std::str::from_utf8(rest.get(..count)?).ok()?.parse().ok()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_that_of_a_line_not_of_a_comment() {
        let text = b"%\nO1002 (GAUGE)\n(O7)\nG0 X1 O8\n :0003\r\no12\nO\n";
        assert_eq!(numbers(text).collect::<Vec<_>>(), [1002, 3, 12]);
    }

    #[test]
    fn two_files_of_one_number_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        write("gauge.cnc", "%\nO1002\nM99\n%\n");
        write("notes.md", "O1002\n");
        write("both.nc", "%\nO5\nM99\nO6\nM99\n%\n");
        let found = NumberedPrograms::of([folder.path()]);
        assert_eq!(found.find(1002), Ok(Some(folder.path().join("gauge.cnc").as_path())));
        assert_eq!(found.find(6), Ok(Some(folder.path().join("both.nc").as_path())));
        assert_eq!(found.find(7), Ok(None));
        write("copy.nc", "%\nO1002\nM99\n%\n");
        let message = NumberedPrograms::of([folder.path()]).find(1002).unwrap_err();
        assert!(message.contains("gauge.cnc") && message.contains("copy.nc"), "{message}");
    }
}
