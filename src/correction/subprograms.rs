//! The output with subprograms: names that no other program has, and the files.

use std::collections::BTreeSet;
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use crate::disk::files::bytes_of;
use crate::disk::numbered_programs;
use crate::disk::output::Target;
use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::source::MAX_BYTES;
use ncfix_dialect::Language;
use ncfix_path::emit::{self, FoldedProgram, SubprogramNames, SubprogramStyle};
use ncfix_report::correction::CorrectionReport;

/// Bytes at the beginning of a file in which a stamp can be.
const HEAD_BYTES: u64 = 4096;

/// Notation of the calls at the control.
///
/// # Errors
/// If it has none.
pub(super) fn style(language: Language, machine: &Machine) -> Result<SubprogramStyle, Error> {
    let control = &machine.machine.control;
    if control.firmware.is_some() {
        return Err(Error::usage("this control has no subprograms; leave out --subprograms".into()));
    }
    Ok(match language {
        Language::Sinumerik => SubprogramStyle::Sinumerik,
        Language::Fanuc if control.iso.is_haas() => SubprogramStyle::Haas,
        Language::Fanuc => SubprogramStyle::Fanuc,
        Language::Rs274 => SubprogramStyle::Rs274,
        Language::Grundig => SubprogramStyle::Grundig,
    })
}

/// Text of the main program, and the files beside it with their texts.
pub(crate) type FoldedFiles = (Vec<u8>, Vec<(Target, Vec<u8>)>);

/// The program at `output` with its subprograms, from a text with marks; `first` is the number of the first subprogram, 0 for the usual one. `read`
/// are the files of the programs that the source calls. Returns the targets of the files beside it.
///
/// # Errors
/// If there are not enough names, or a file cannot be written.
pub(crate) fn fold(
    marked: &[u8],
    (style, first): (SubprogramStyle, u32),
    output: &Path,
    (source, read): (&[u8], &[PathBuf]),
    report: &mut CorrectionReport,
) -> Result<FoldedFiles, Error> {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let mut names = SubprogramNames::new(style, &stem, first);
    names.avoid(source);
    for path in read {
        names.avoid(&bytes_of(path, MAX_BYTES).map_err(|error| Error::file("read", path, &error))?);
    }
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    avoid_files(&mut names, folder, output);
    let folded = emit::fold(marked, names).ok_or_else(|| {
        Error::usage(format!(
            "--subprograms: {} would need more subprograms than there are free names; leave out the option, or give another first number",
            output.display()
        ))
    })?;
    let FoldedProgram { main, beside, names, blocks, .. } = folded;
    report.blocks_out = blocks;
    report.subprograms = names;
    let file = |(name, text): (String, Vec<u8>)| Ok((Target::new(&folder.join(format!("{name}.SPF")))?, text));
    Ok((main, beside.into_iter().map(file).collect::<Result<_, Error>>()?))
}

/// Leaves out the names of other programs in the folder of the output.
fn avoid_files(names: &mut SubprogramNames, folder: &Path, output: &Path) {
    let own = output.file_name();
    let entries: BTreeSet<PathBuf> =
        fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    for path in entries {
        let Some(name) = path.file_name().filter(|name| Some(*name) != own).and_then(|name| name.to_str()) else {
            continue;
        };
        // A file of an earlier correction is replaced.
        let is_ours = name.ends_with(".SPF") && names.may_be(name.trim_end_matches(".SPF")) && is_stamped(&path);
        if !is_ours {
            names.avoid(name.as_bytes());
        }
    }
    if names.is_of_tape() {
        // Read without a note: the output may replace such a file.
        let files = numbered_programs::candidates([folder]).unwrap_or_default();
        let others = files.iter().filter(|path| path.file_name() != own);
        let used: BTreeSet<u32> = others
            .filter_map(|path| fs::read(path).ok())
            .flat_map(|bytes| numbered_programs::numbers(&bytes).collect::<Vec<_>>())
            .collect();
        names.avoid_numbers(|number| used.contains(&number));
    }
}

/// `true` if a file is the output of a correction.
fn is_stamped(path: &Path) -> bool {
    let mut head = Vec::new();
    let is_read = fs::File::open(path).and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head)).is_ok();
    is_read && emit::is_stamped(&head)
}
