//! One import in progress: the text, the answers so far, the open questions, and the notes on what was understood.

use std::cell::RefCell;

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_machine::machine::Machine;

use crate::answers::{ImportAnswers, MeasuringPoint, ReadingMaterial};
use crate::grid::{self, GridHeading, GridTable};
use crate::readings::{ImportedReadings, shown};
use crate::rows;
use crate::stated;
use crate::text::DecodedText;
use crate::unit::ReadingUnit;

/// Question that a file leaves open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImportQuestion {
    /// Option that answers it, without dashes.
    pub option: &'static str,
    /// Missing information: one sentence, lower case, no full stop.
    pub sentence: String,
    /// Values to choose from, or an example.
    pub advice: String,
}

impl ImportQuestion {
    /// Returns the refusal if nobody can answer.
    #[must_use]
    pub fn refusal(&self) -> Diagnostic {
        Diagnostic::nowhere(
            Code::IMPORT_QUESTION,
            self.sentence.clone(),
            format!("give --{}: {}", self.option, self.advice),
        )
    }
}

/// Reason why a reader stops.
#[derive(Clone, Debug)]
pub enum ImportStop {
    /// Nothing can be read before the questions are answered.
    Asks,
    /// The file is not what it seems to be.
    Refused(Box<Diagnostic>),
}

impl From<Box<Diagnostic>> for ImportStop {
    fn from(diagnostic: Box<Diagnostic>) -> ImportStop {
        ImportStop::Refused(diagnostic)
    }
}

/// Import in progress.
#[derive(Debug)]
pub struct Inquiry<'a> {
    /// Text of the file.
    pub text: &'a DecodedText,
    answers: &'a ImportAnswers,
    /// Machine on which the readings were taken.
    pub machine: &'a Machine,
    questions: Vec<ImportQuestion>,
    notes: Vec<String>,
    is_unit_stated: bool,
    /// True if the sign says where features come from, and not which difference they are.
    pub(crate) is_origin: bool,
    /// Options that the reader has asked for.
    used: RefCell<Vec<&'static str>>,
    /// Axes whose positions it has asked for.
    used_axes: RefCell<Vec<Axis>>,
    /// Positions of axes that the file states, mm and degrees.
    stated_at: Vec<(Axis, f64)>,
}

/// Quotes a line of the file in a note.
const MOST_QUOTED: usize = 80;

impl<'a> Inquiry<'a> {
    /// Begins an import.
    #[must_use]
    pub fn new(text: &'a DecodedText, answers: &'a ImportAnswers, machine: &'a Machine) -> Inquiry<'a> {
        Inquiry {
            text,
            answers,
            machine,
            questions: Vec::new(),
            notes: Vec::new(),
            is_unit_stated: false,
            is_origin: false,
            used: RefCell::default(),
            used_axes: RefCell::default(),
            stated_at: Vec::new(),
        }
    }

    /// Returns the quarter turns of the part about Z on the machine, and notes them: no file of a report states them.
    pub fn quarter_turns(&mut self) -> usize {
        let turns = self.answer("turned", |own| own.turned).unwrap_or(0);
        self.note(
            match turns {
                0 => "X of the part along X of the machine (--turned 90 if it was clamped turned)".to_owned(),
                turns => format!("the part was clamped turned by {}° about Z (--turned)", 90 * turns),
            },
            0,
        );
        turns
    }

    /// Returns the answer of an option, which then counts as used.
    pub fn answer<T>(&self, option: &'static str, of: impl FnOnce(&'a ImportAnswers) -> T) -> T {
        self.used.borrow_mut().push(option);
        of(self.answers)
    }

    /// Answers so far, without a mark that they are used.
    #[must_use]
    pub fn answers(&self) -> &'a ImportAnswers {
        self.answers
    }

    /// True if the reader has asked for an option.
    pub(crate) fn has_used(&self, option: &'static str) -> bool {
        self.used.borrow().contains(&option)
    }

    /// Returns the options that were given and that the reader did not ask for, with their dashes: they have no effect on these readings.
    #[must_use]
    pub fn unused(&self) -> Vec<String> {
        let (used, axes) = (self.used.borrow(), self.used_axes.borrow());
        let idle = self.answers.given().filter(|option| *option != "at" && !used.contains(option));
        let stood = self.answers.at.iter().filter(|(axis, _)| !axes.contains(axis));
        idle.map(|option| format!("--{option}"))
            .chain(stood.map(|(axis, value)| format!("--at {axis}{}", shown(*value))))
            .collect()
    }

    /// Returns the open questions.
    #[must_use]
    pub fn questions(&self) -> &[ImportQuestion] {
        &self.questions
    }

    /// Asks a question, once for each option. Several positions make one question, because one option answers all of them.
    pub fn ask(&mut self, option: &'static str, sentence: impl Into<String>, advice: impl Into<String>) {
        /// Beginning of the sentences about a missing fact, and of the example in an advice.
        const PARTS: [&str; 2] = ["the file does not state ", "such as "];
        let (sentence, mut advice) = (sentence.into(), advice.into());
        let is_first = self.questions.iter().all(|question| question.option != option);
        if option == "at" && is_first && !self.answers.at.is_empty() {
            // The option is given once, so the example has the known positions too.
            let known: Vec<String> =
                self.answers.at.iter().map(|(axis, value)| format!("{axis}{}", shown(*value))).collect();
            advice = format!("{advice},{}", known.join(","));
        }
        if let Some(first) = self.questions.iter_mut().find(|own| own.option == option && option == "at") {
            let fact = sentence.strip_prefix(PARTS[0]).unwrap_or(&sentence);
            if !first.sentence.contains(fact) {
                first.sentence = format!("{}, and {fact}", first.sentence);
                let examples = advice.split_once(PARTS[1]).map_or("", |(_, examples)| examples);
                first.advice = format!("{},{examples}", first.advice).trim_end_matches(',').to_owned();
            }
            return;
        }
        if is_first {
            self.questions.push(ImportQuestion { option, sentence, advice });
        }
    }

    /// Notes what was understood, with the line that proves it (0 if an option or a rule does).
    pub fn note(&mut self, sentence: impl Into<String>, line: usize) {
        let mut note = sentence.into();
        if line > 0 {
            let plain = |c: &char| !c.is_control();
            let whole = self.text.line(line).trim();
            let mut quoted: String = whole.chars().filter(plain).take(MOST_QUOTED).collect();
            if whole.chars().filter(plain).nth(MOST_QUOTED).is_some() {
                quoted.push('…');
            }
            note.push_str(&format!(" (line {line}: {quoted})"));
        }
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// Headings of the table as given by `--columns`, or its own.
    ///
    /// # Errors
    /// If `--columns` names more or fewer columns than the table has, or a unit that the heading contradicts.
    pub fn headings(&self, table: &GridTable) -> Result<Vec<GridHeading>, ImportStop> {
        if self.answer("columns", |own| own.columns.is_empty()) {
            return Ok(table.headings.clone());
        }
        let given = &self.answers.columns;
        if given.len() != table.width() {
            let message = format!("--columns names {} columns, the table has {}", given.len(), table.width());
            let help = "name each column in order; write - for a column that is not read";
            return Err(self.refused(message, help, table.heading_line));
        }
        let units = table.headings.iter().map(|heading| heading.unit).chain(std::iter::repeat(None));
        let mut found = Vec::new();
        for (text, unit) in given.iter().zip(units) {
            let heading = grid::heading_of(text);
            if let (Some(said), Some(stated)) = (heading.unit, unit)
                && said != stated
            {
                let message = format!("--columns {text} contradicts the file, whose heading says {}", stated.sign());
                return Err(self.refused(
                    message,
                    "remove the unit in --columns, or correct the heading",
                    table.heading_line,
                ));
            }
            found.push(GridHeading { unit: heading.unit.or(unit), ..heading });
        }
        Ok(found)
    }

    /// Checks that the value of an option is that of the file: `said` by the option, `stated` by the file with its line.
    ///
    /// # Errors
    /// If both are there and differ by more than `slack`.
    pub fn agreed(
        &self,
        option: &str,
        said: Option<f64>,
        stated: Option<(f64, usize)>,
        slack: f64,
    ) -> Result<(), ImportStop> {
        match (said, stated) {
            (Some(said), Some((stated, line))) if (said - stated).abs() > slack => {
                let (said, stated) = (shown(said), shown(stated));
                let message = format!("--{option} {said} contradicts the file, whose line {line} says {stated}");
                Err(self.refused(message, format!("remove --{option}, or correct the line"), line))
            }
            _ => Ok(()),
        }
    }

    /// Units that lines of the file state, with their lines.
    ///
    /// # Errors
    /// If one is not known.
    pub fn stated_units(&self) -> Result<Vec<(ReadingUnit, usize)>, ImportStop> {
        stated::units(self.text).map_err(|(word, line)| {
            let help = format!("write one of {}, {}", ReadingUnit::choices(false), ReadingUnit::choices(true));
            self.refused(format!("'{word}' is not a unit"), help, line)
        })
    }

    /// The unit of columns that must have the same one.
    ///
    /// # Errors
    /// If their headings state different units.
    pub fn one_unit(
        &self,
        units: impl Iterator<Item = Option<ReadingUnit>>,
        line: usize,
    ) -> Result<Option<(ReadingUnit, usize)>, ImportStop> {
        let mut units = units.flatten();
        let first = units.next();
        if let (Some(one), Some(other)) = (first, units.find(|unit| Some(*unit) != first)) {
            let message = format!("the headings state {} and {} for readings of one kind", one.sign(), other.sign());
            return Err(self.refused(message, "export these columns in one unit", line));
        }
        Ok(first.map(|unit| (unit, line)))
    }

    /// True if the heading of the readings states their unit.
    #[must_use]
    pub fn is_unit_stated(&self) -> bool {
        self.is_unit_stated
    }

    /// Unit of the readings. `found` is the unit in their headings with its line; lines such as `Unit;mm` are read here.
    ///
    /// # Errors
    /// A contradiction between the file and the option.
    pub fn unit(
        &mut self,
        found: Option<(ReadingUnit, usize)>,
        is_angle: bool,
        largest: f64,
    ) -> Result<ReadingUnit, ImportStop> {
        let default = if is_angle { ReadingUnit::Angle("urad", 1e-6) } else { ReadingUnit::Length("um", 1e-3) };
        let lines = self.stated_units()?;
        // A line may be about something else; a heading is about its column.
        self.is_unit_stated = found.is_some_and(|stated| !lines.contains(&stated));
        let own = found.into_iter().chain(lines.iter().copied().filter(|(unit, _)| unit.is_angle() == is_angle));
        let own: Vec<(ReadingUnit, usize)> = own.collect();
        let other = own.iter().find(|(unit, _)| Some(*unit) != own.first().map(|(unit, _)| *unit)).copied();
        let found = match (own.first().copied(), other, self.answer("unit", |own| own.unit)) {
            (Some((first, line)), Some((other, at)), None) => {
                let sentence = format!(
                    "the file states two units: {} in line {line}, {} in line {at}",
                    first.sign(),
                    other.sign()
                );
                self.ask("unit", sentence, format!("that of the readings, {} or {}", first.sign(), other.sign()));
                return Ok(default);
            }
            // The option chooses one of them.
            (_, Some(_), Some(said)) => own.iter().find(|(unit, _)| *unit == said).or(own.first()).copied(),
            (first, None, Some(_)) => first,
            (first, None, None) => first.or(lines.first().copied()),
            (None, Some(_), None) => None,
        };
        let unit = match (self.answers.unit, found) {
            (Some(said), Some((written, line))) if said != written => {
                let message =
                    format!("--unit {} contradicts the file, whose line {line} says {}", said.sign(), written.sign());
                return Err(self.refused(message, "remove --unit, or correct the heading", line));
            }
            (_, Some((unit, line))) => {
                self.note(format!("unit of the readings: {}", unit.sign()), line);
                unit
            }
            (Some(unit), None) => {
                self.note(format!("unit of the readings: --unit {}", unit.sign()), 0);
                unit
            }
            (None, None) => {
                let likely = match (is_angle, largest) {
                    (false, largest) if largest < 0.2 => "; values this small are usually mm",
                    (false, _) => "; values this large are usually µm",
                    (true, _) => "",
                };
                let sentence =
                    format!("the file does not state the unit of its readings (largest {}){likely}", shown(largest));
                self.ask("unit", sentence, format!("one of {}", ReadingUnit::choices(is_angle)));
                default
            }
        };
        if unit.is_angle() != is_angle {
            let (is, wanted) = if unit.is_angle() { ("an angle", "lengths") } else { ("a length", "angles") };
            let message = format!("the unit {} is {is}, but these readings are {wanted}", unit.sign());
            return Err(self.refused(
                message,
                "correct --unit, or name the measured error with --component",
                found.map_or(0, |(_, line)| line),
            ));
        }
        Ok(unit)
    }

    /// Positions of axes of the machine without a column, mm and degrees. `moved` are those with a column.
    pub fn other_positions(&mut self, moved: &[Axis]) -> Vec<(Axis, f64)> {
        let mut found = Vec::new();
        let mut missing = Vec::new();
        for axis in self.machine.axis_set().iter().filter(|axis| !moved.contains(axis)) {
            match self.given(axis) {
                Some(value) => found.push((axis, value)),
                None => missing.push(char::from(axis.letter()).to_string()),
            }
        }
        if !missing.is_empty() {
            let sentence =
                format!("the file does not state the position of {} during the measurement", missing.join(", "));
            let example: Vec<String> = missing.iter().map(|letter| format!("{letter}0")).collect();
            self.ask("at", sentence, format!("all of them, such as {}", example.join(",")));
        } else {
            let is_said = |axis: &Axis| self.stated_at.iter().all(|(own, _)| own != axis);
            let said = found.iter().filter(|(axis, _)| is_said(axis));
            let shown: Vec<String> =
                said.map(|(axis, value)| format!("{}{value}", char::from(axis.letter()))).collect();
            if shown.is_empty() {
                return found;
            }
            self.note(format!("positions of the other axes: --at {}", shown.join(",")), 0);
        }
        found
    }

    /// Position of an axis in `--at`, or in a column of the file.
    #[must_use]
    pub fn given(&self, axis: Axis) -> Option<f64> {
        self.used_axes.borrow_mut().push(axis);
        let all = self.answers.at.iter().chain(&self.stated_at);
        all.into_iter().find(|(own, _)| *own == axis).map(|(_, value)| *value)
    }

    /// Takes the position of an axis that did not move from a column of the file, mm or degrees.
    ///
    /// # Errors
    /// If `--at` states another one.
    pub fn state_position(&mut self, axis: Axis, value: f64, line: usize) -> Result<(), ImportStop> {
        /// Half a digit of a position, mm or degrees.
        const SLACK: f64 = 0.005;
        if let Some((_, said)) = self.answers.at.iter().find(|(own, _)| *own == axis)
            && (said - value).abs() > SLACK
        {
            let message =
                format!("--at {axis}{} contradicts the column {axis} of the file: {}", shown(*said), shown(value));
            return Err(self.refused(message, format!("remove {axis} from --at, or correct the column"), line));
        }
        self.note(format!("position of {axis}: {} in all rows", shown(value)), line);
        self.stated_at.push((axis, value));
        Ok(())
    }

    /// Machine position of the zero of the positions in the file, for linear axes that have a column.
    pub fn zero(&mut self, axes: &[Axis], what: &str) -> Vector {
        let mut zero = Vector::zeros();
        let mut missing = Vec::new();
        for (index, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate().filter(|(_, axis)| axes.contains(axis))
        {
            match self.given(axis) {
                Some(value) => zero[index] = value,
                None => missing.push(format!("{}0", char::from(axis.letter()))),
            }
        }
        if !missing.is_empty() {
            let sentence = format!("the file does not state the machine position of {what}");
            self.ask("at", sentence, format!("machine coordinates, such as {}", missing.join(",")));
        }
        zero
    }

    /// Vector from the gauge point to the measuring point, mm.
    pub fn tool(&mut self) -> Vector {
        match self.answer("tool", |own| own.tool) {
            Some(point) => {
                let vector = MeasuringPoint::vector_mm(point, self.machine);
                self.note(
                    format!(
                        "measuring point: {} {} {} mm from the spindle gauge point (--tool)",
                        shown(vector[0]),
                        shown(vector[1]),
                        shown(vector[2])
                    ),
                    0,
                );
                vector
            }
            None => {
                let sentence =
                    "the file does not state the place of the measuring point relative to the spindle gauge point";
                self.ask("tool", sentence, "the length in mm, or the vector x,y,z");
                Vector::zeros()
            }
        }
    }

    /// Temperature state of the scale or of the workpiece.
    ///
    /// # Errors
    /// If the option contradicts the file.
    pub fn material(&mut self, what: &str) -> Result<ReadingMaterial, ImportStop> {
        /// Digits to which temperature, K, and expansion, µm/m per K, are rounded.
        const SLACK: [f64; 2] = [0.5, 0.5];
        let said = self.answer("material", |own| own.material);
        if let Some(ReadingMaterial::Expanded { per_k, celsius }) = said {
            for (said, stated, slack) in [
                (celsius, stated::temperatures(self.text), SLACK[0]),
                (per_k * 1e6, stated::expansions(self.text), SLACK[1]),
            ] {
                if let Some((_, line)) = stated.first()
                    && stated.iter().all(|(value, _)| (value - said).abs() > slack)
                {
                    let message = format!("{} of --material contradicts line {line} of the file", shown(said));
                    let help = "correct --material; 20C states that the instrument refers the readings to 20 °C";
                    return Err(self.refused(message, help, *line));
                }
            }
        }
        Ok(match said {
            Some(material) => {
                let shown = match material {
                    ReadingMaterial::Reference => "the readings refer to 20 °C (--material 20C)".to_owned(),
                    ReadingMaterial::Expanded { per_k, celsius } => {
                        format!("{what}: {} µm/m per K at {celsius} °C (--material)", shown(per_k * 1e6))
                    }
                };
                self.note(shown, 0);
                material
            }
            None => {
                let stated = stated::temperatures(self.text).first().copied();
                let sentence = match stated {
                    // The instrument may have converted the readings with it.
                    Some((celsius, line)) => format!(
                        "line {line} of the file states {} °C, and not whether the readings refer to 20 °C: {}",
                        shown(celsius),
                        self.text
                            .line(line)
                            .chars()
                            .filter(|c| !c.is_control())
                            .take(MOST_QUOTED)
                            .collect::<String>()
                            .trim()
                    ),
                    None => format!("the file does not state the temperature of {what}"),
                };
                let advice = match stated {
                    Some((celsius, _)) => format!(
                        "20C if the software of the instrument has referred them already, else expansion of {what} (µm/m per K) and temperature, such as 11.5@{}",
                        shown(celsius)
                    ),
                    None => "20C if the readings refer to 20 °C, else expansion and temperature such as 11.5@26".into(),
                };
                self.ask("material", sentence, advice);
                ReadingMaterial::Reference
            }
        })
    }

    /// Temperature state of the scale of the axis that moved: as the file states it, else by the option.
    ///
    /// # Errors
    /// If lines of the file contradict each other, or the option contradicts the file.
    pub fn scale_material(&mut self) -> Result<ReadingMaterial, ImportStop> {
        const SCALE: &str = "the scale of the axis";
        if let Some((material, line)) = self.stated_material()? {
            let shown = match material {
                ReadingMaterial::Reference => "the readings refer to 20 °C".to_owned(),
                ReadingMaterial::Expanded { per_k, celsius } => format!(
                    "the readings do not refer to 20 °C, so they are converted; {SCALE}: {} µm/m per K at {} °C",
                    shown(per_k * 1e6),
                    shown(celsius)
                ),
            };
            self.note(shown, line);
            return Ok(material);
        }
        self.material(SCALE)
    }

    /// State of the material by the file alone, with the line that states whether the readings refer to 20 °C; `None` if the file does not state enough.
    ///
    /// # Errors
    /// If its lines contradict each other, or the option contradicts them.
    fn stated_material(&self) -> Result<Option<(ReadingMaterial, usize)>, ImportStop> {
        /// Temperatures that differ by less, K, are one temperature.
        const SAME_K: f64 = 0.5;
        let stated = stated::conversions(self.text);
        let Some(&(is_converted, line)) = stated.first() else { return Ok(None) };
        if let Some((_, other)) = stated.iter().find(|(one, _)| *one != is_converted) {
            let message = format!("line {other} contradicts line {line}: whether the readings refer to 20 °C");
            return Err(self.refused(message, "correct the file", *other));
        }
        let temperatures = stated::temperatures(self.text);
        let [low, high] = temperatures
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (one, _)| [low.min(*one), high.max(*one)]);
        let is_reference = temperatures.iter().all(|(celsius, _)| (celsius - 20.0).abs() < SAME_K);
        match (self.answers.material, is_converted) {
            (Some(ReadingMaterial::Expanded { .. }), true) => {
                let message = format!(
                    "line {line} of the file states that the readings refer to 20 °C; --material would convert them again"
                );
                Err(self.refused(message, "omit --material; if the line is wrong, correct the file", line))
            }
            (Some(ReadingMaterial::Reference), false) if temperatures.is_empty() || !is_reference => {
                let message =
                    format!("--material 20C contradicts line {line} of the file: the readings do not refer to 20 °C");
                let help = "state expansion and temperature of the scale, such as --material 11.5@26; if the line is wrong, correct the file";
                Err(self.refused(message, help, line))
            }
            (_, true) => Ok(Some((ReadingMaterial::Reference, line))),
            (Some(_), false) => Ok(None),
            (None, false) => {
                let expansions = stated::expansions(self.text);
                let is_one = |value: f64| expansions.iter().all(|(other, _)| *other == value);
                let expansion =
                    expansions.first().map(|(value, _)| *value).filter(|value| *value > 0.0 && is_one(*value));
                let found = expansion.filter(|_| high - low < SAME_K).map(|expansion| ReadingMaterial::Expanded {
                    per_k: expansion * 1e-6,
                    celsius: f64::midpoint(low, high),
                });
                Ok(found.map(|found| (found, line)))
            }
        }
    }

    /// Makes a refusal at a line (0 for none).
    #[must_use]
    pub fn refused(&self, message: impl Into<String>, help: impl Into<String>, line: usize) -> ImportStop {
        let found = if line > 0 {
            Diagnostic::at(Code::IMPORT_CONTRADICTION, self.text.place(line), message, help)
        } else {
            Diagnostic::nowhere(Code::IMPORT_CONTRADICTION, message, help)
        };
        ImportStop::Refused(Box::new(found))
    }

    /// Ends the import.
    #[must_use]
    pub fn finish(self, mut readings: ImportedReadings, format: &'static str) -> ImportedReadings {
        readings.unused = self.unused();
        readings.notes = self.notes;
        readings.gaps.extend(rows::gaps(&readings));
        readings.notes.insert(0, format!("format: {format}; encoding {}", self.text.encoding()));
        readings
    }
}
