//! The arguments of `ncfix decompose`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, PageChoice};
use ncfix_metrology::decompose::Smooth;

/// End of `ncfix decompose --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
A trace is a table NAME.csv with its description NAME.toml (kind = \"trace\") in the same folder: t_s, set-points X Y Z A C, encoders X_enc …, the tool displacement \
from a ball dx_um dy_um dz_um, and feed_mm_min and run for several runs along one path. The description may name the XML file saved by a Sinumerik \
with Diagnostics › Trace (control = \"f1000.xml\") and its signals. See docs/reference/decompose.md.

Examples:
  ncfix decompose f1000.csv f5832.csv f18896.csv --machine mill.toml
  ncfix decompose runs.csv --machine mill.toml --report speed.html
  ncfix decompose runs.csv --machine mill.toml -o extended.toml
  ncfix decompose runs.csv --machine mill.toml --motion path:20 --json";

/// `ncfix decompose`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct DecomposeArguments {
    /// Traces, each with its description NAME.toml in the same folder; all runs must follow one path
    #[arg(value_name = "TRACE.csv", required = true)]
    pub(in crate::cli) traces: Vec<PathBuf>,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    /// Link errors to fit to the slowest run, such as EC0Y,EB0A (default: all of the machine)
    #[arg(long, value_name = "LIST")]
    pub(in crate::cli) links: Option<String>,
    /// Description of motion errors: pose:DEGREE, polynomials of each axis position, or path:DEGREE, of the fraction of the path
    #[arg(long, value_name = "MODEL", default_value = "pose:6", value_parser = smooth)]
    pub(in crate::cli) motion: Smooth,
    /// Known delay from set-points to encoders, ms (default: fitted)
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = milliseconds)]
    pub(in crate::cli) record_delay_ms: Option<f64>,
    /// Known delay from encoders to readings, ms (default: fitted)
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = milliseconds)]
    pub(in crate::cli) reading_delay_ms: Option<f64>,
    /// Machine file to write, with the determined link errors, compliances and, in existing servo sections, loops; - for standard output
    #[arg(short, long, value_name = "EXTENDED.toml")]
    pub(in crate::cli) output: Option<PathBuf>,
    #[command(flatten)]
    /// Report page and its pictures.
    pub(in crate::cli) page: PageChoice,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// Permitted degrees.
const DEGREES: std::ops::RangeInclusive<usize> = 1..=40;

fn smooth(text: &str) -> Result<Smooth, String> {
    let (kind, degree) = text.split_once(':').ok_or("write pose:6 or path:20")?;
    let degree: usize = degree.parse().ok().filter(|degree| DEGREES.contains(degree)).ok_or("the degree is 1 to 40")?;
    match kind {
        "pose" => Ok(Smooth::Pose(degree)),
        "path" => Ok(Smooth::Path(degree)),
        _ => Err("write pose:6 or path:20".into()),
    }
}

fn milliseconds(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.parse().ok().filter(|ms: &f64| ms.abs() <= 1e4);
    value.ok_or_else(|| "write milliseconds, from -10000 to 10000".into())
}
