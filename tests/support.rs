//! Runs the built program the way a person does: files in, arguments, exit status, both outputs, files out.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A folder of files and the commands that run in it.
pub(crate) struct Shop {
    folder: tempfile::TempDir,
}

/// What a run left behind.
#[derive(Debug)]
pub(crate) struct Run {
    /// Exit status.
    pub(crate) code: i32,
    /// Standard output.
    pub(crate) stdout: String,
    /// Standard error.
    pub(crate) stderr: String,
    /// The first argument.
    pub(crate) command: String,
}

/// A file of the repository.
pub(crate) fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The dialects that have samples, each with the machine on which its bad programs are tried.
pub(crate) fn dialects() -> Vec<(&'static str, &'static str)> {
    let machine = |name: &str| match name {
        "grundig" => "universal_mill",
        "fanuc" => "vmc",
        "rs274" => "knee_mill",
        _ => "demo",
    };
    let executable = ncfix_dialect::DIALECTS.iter().filter(|dialect| dialect.is_executable);
    executable.map(|dialect| (dialect.name, machine(dialect.name))).collect()
}

/// The path of a sample machine, as an argument.
pub(crate) fn machine(name: &str) -> String {
    repository(&format!("samples/machines/{name}.toml")).display().to_string()
}

impl Shop {
    /// An empty folder.
    pub(crate) fn new() -> Shop {
        Shop { folder: tempfile::tempdir().unwrap() }
    }

    /// Adds a file.
    pub(crate) fn file(self, name: &str, content: impl AsRef<[u8]>) -> Shop {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
        self
    }

    /// Adds a copy of a file of the repository under its own name.
    pub(crate) fn copy(self, path: &str) -> Shop {
        let path = repository(path);
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        self.file(&name, fs::read(path).unwrap())
    }

    /// The path of a file in the folder.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The bytes of a file in the folder.
    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The text of a file in the folder.
    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    /// Names of all files in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs `ncfix` with arguments in the folder, with nothing on standard input.
    pub(crate) fn run<S: AsRef<str>>(&self, arguments: impl IntoIterator<Item = S>) -> Run {
        self.run_with_input(arguments, b"")
    }

    /// Runs `ncfix` with arguments in the folder and bytes on standard input.
    pub(crate) fn run_with_input<S: AsRef<str>>(&self, arguments: impl IntoIterator<Item = S>, input: &[u8]) -> Run {
        let arguments: Vec<String> = arguments.into_iter().map(|argument| argument.as_ref().to_owned()).collect();
        let mut child = self.command(&arguments).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        // A run that refuses its arguments does not read its input.
        let _ = stdin.write_all(input);
        drop(stdin);
        let output = child.wait_with_output().unwrap();
        Run {
            code: output.status.code().unwrap(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
            command: arguments.into_iter().next().unwrap_or_default(),
        }
    }

    /// The command, for tests that need the process itself.
    pub(crate) fn command<S: AsRef<str>>(&self, arguments: impl IntoIterator<Item = S>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ncfix"));
        command.args(arguments.into_iter().map(|argument| argument.as_ref().to_owned()));
        command.current_dir(self.folder.path()).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
        command.env_remove("NCFIX_MACHINE");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }
}

impl Run {
    /// Demands an exit status; shows both outputs where it differs.
    #[track_caller]
    pub(crate) fn exits(self, code: i32) -> Run {
        assert_eq!(self.code, code, "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }

    /// Demands a text on standard error.
    #[track_caller]
    pub(crate) fn says(self, text: &str) -> Run {
        assert!(self.stderr.contains(text), "'{text}' is not in stderr:\n{}", self.stderr);
        self
    }

    /// Standard output as JSON, which keeps to the schema of the command.
    #[track_caller]
    pub(crate) fn json(&self) -> serde_json::Value {
        crate::schemas::keeps_to_its_schema(&self.command, &self.stdout);
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {}", self.stdout))
    }

    /// Codes of the findings in the JSON on standard output, sorted, each once.
    #[track_caller]
    pub(crate) fn codes(&self) -> Vec<String> {
        let json = self.json();
        let mut codes: Vec<String> = json["diagnostics"]
            .as_array()
            .unwrap()
            .iter()
            .map(|finding| finding["code"].as_str().unwrap().to_owned())
            .collect();
        codes.sort();
        codes.dedup();
        codes
    }
}
