//! The program: hands the command line to [`ncfix::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    ncfix::cli::run(std::env::args_os()).into()
}
