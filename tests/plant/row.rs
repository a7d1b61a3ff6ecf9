//! What is measured: rows (where the axes stand and under what circumstances), set-ups, and the sheet of one pair of files.

use super::climate::Climate;
use super::vector::V3;

/// A circle with a ball-bar at one row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Circle {
    /// Axes of abscissa and ordinate.
    pub(crate) plane: [usize; 2],
    /// rad
    pub(crate) angle: f64,
    /// 1 counter-clockwise, −1 clockwise.
    pub(crate) sense: f64,
    pub(crate) radius: f64,
}

/// One row: axes X Y Z (mm) A C (rad) and all that may drive an error.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    pub(crate) q: [f64; 5],
    /// Senses of the last motion.
    pub(crate) dir: [f64; 5],
    /// mm/s and mm/s² while reading.
    pub(crate) v: V3,
    pub(crate) a: V3,
    /// From the gauge point of the spindle to the tip.
    pub(crate) tool: V3,
    pub(crate) t: f64,
    /// When the clock of the file was 0.
    pub(crate) began: f64,
    /// When the instrument was set to zero after it was mounted.
    pub(crate) zeroed: Option<f64>,
    pub(crate) run: String,
    pub(crate) setup: usize,
    /// Which sheet of its kind: another day has other drifts.
    pub(crate) day: usize,
    pub(crate) feed: f64,
    pub(crate) rpm: f64,
    /// N, and where it stands on the table, mm.
    pub(crate) load: f64,
    pub(crate) load_at: V3,
    /// rad
    pub(crate) spindle: f64,
    /// Number of a ball.
    pub(crate) target: usize,
    /// Direction and axis of the component.
    pub(crate) component: [usize; 2],
    pub(crate) circle: Option<Circle>,
}

impl Row {
    /// The commanded point of the tool: command plus tool vector.
    pub(crate) fn point(&self) -> V3 {
        [0, 1, 2].map(|k| self.q[k] + self.tool[k])
    }
}

/// Kinds of readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Displacement,
    Ballbar,
    Probe,
    Direct,
}

impl Kind {
    /// As a description says it.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Kind::Displacement => "displacement",
            Kind::Ballbar => "ballbar",
            Kind::Probe => "probe",
            Kind::Direct => "direct",
        }
    }
}

/// A mounting: what is said of it, and what is true beside.
#[derive(Clone, Debug, Default)]
pub(crate) struct Setup {
    pub(crate) label: String,
    pub(crate) centre: V3,
    pub(crate) length: f64,
    /// Of the table ball, mm.
    pub(crate) off_centre: V3,
    pub(crate) off_length: f64,
    /// Of a displacement or the zero of an instrument.
    pub(crate) offset: V3,
    pub(crate) turn: V3,
    /// Of the stylus with the spindle at 0.
    pub(crate) stylus: V3,
    /// Zeros of the components, by direction and axis.
    pub(crate) zero: [[f64; 5]; 6],
}

/// A column beside axes, senses, tool, set-up, run and readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Column {
    Time,
    Feed,
    Speed,
    Load,
    Spindle,
}

/// One pair of files.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    pub(crate) stem: String,
    pub(crate) kind: Kind,
    /// Whether angles were read.
    pub(crate) angles: bool,
    /// Noise of a reading, mm or rad.
    pub(crate) sigma: f64,
    /// Standard deviation of the slow drift of the readings in units of sigma, and its length in rows.
    pub(crate) wander: [f64; 2],
    pub(crate) free: Vec<&'static str>,
    pub(crate) setups: Vec<Setup>,
    /// Balls in the workpiece frame.
    pub(crate) balls: Vec<V3>,
    /// Which of dx dy dz is read.
    pub(crate) reads: [bool; 3],
    pub(crate) columns: Vec<Column>,
    pub(crate) climate: Option<Climate>,
    pub(crate) rows: Vec<Row>,
}

impl Sheet {
    /// An empty sheet.
    pub(crate) fn new(stem: &str, kind: Kind, sigma: f64, free: &[&'static str], columns: &[Column]) -> Sheet {
        let one = matches!(kind, Kind::Ballbar | Kind::Direct);
        Sheet {
            stem: stem.to_owned(),
            kind,
            angles: false,
            sigma,
            wander: [0.5, 60.0],
            free: free.to_vec(),
            setups: Vec::new(),
            balls: Vec::new(),
            reads: [true, !one, !one],
            columns: columns.to_vec(),
            climate: None,
            rows: Vec::new(),
        }
    }

    /// Its unit in the files, per mm or rad: always micro.
    pub(crate) fn unit(&self) -> &'static str {
        if self.angles { "urad" } else { "um" }
    }
}
