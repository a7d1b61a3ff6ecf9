//! The arguments of `ncfix decompose`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, PageChoice};
use ncfix_metrology::decompose::Smooth;

/// What `ncfix decompose --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
A trace is a table NAME.csv with its description NAME.toml (kind = \"trace\") beside it: t_s, set-points X Y Z A C, encoders X_enc …, the tool from \
a ball dx_um dy_um dz_um, and feed_mm_min and run where it has several runs over one path. The description may name the XML file that a Sinumerik saved \
with Diagnostics › Trace (control = \"f1000.xml\") and its signals. docs/decompose.md says more.

Examples:
  ncfix decompose f1000.csv f5832.csv f18896.csv --machine mill.toml
  ncfix decompose runs.csv --machine mill.toml --report speed.html
  ncfix decompose runs.csv --machine mill.toml -o extended.toml
  ncfix decompose runs.csv --machine mill.toml --motion path:20 --json";

/// `ncfix decompose`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct DecomposeArguments {
    /// Tables of traces, each with its description NAME.toml beside it; all runs follow one path
    #[arg(value_name = "TRACE.csv", required = true)]
    pub(in crate::cli) traces: Vec<PathBuf>,
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    /// Link errors that are fitted to the slowest run, as EC0Y,EB0A; without it all that the machine has
    #[arg(long, value_name = "LIST")]
    pub(in crate::cli) links: Option<String>,
    /// How motion errors are described: pose:DEGREE, polynomials of the position of each axis, or path:DEGREE, of the share of the path
    #[arg(long, value_name = "MODEL", default_value = "pose:6", value_parser = smooth)]
    pub(in crate::cli) motion: Smooth,
    /// Delay of the encoders behind the set-points, where it is known: it is not looked for then
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = milliseconds)]
    pub(in crate::cli) record_delay_ms: Option<f64>,
    /// Delay of the readings behind the encoders, where it is known
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = milliseconds)]
    pub(in crate::cli) reading_delay_ms: Option<f64>,
    /// Write the machine file with what gives way, as dynamic sections; - for standard output
    #[arg(short, long, value_name = "EXTENDED.toml")]
    pub(in crate::cli) output: Option<PathBuf>,
    #[command(flatten)]
    /// Which page.
    pub(in crate::cli) page: PageChoice,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// Degrees that make sense.
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
