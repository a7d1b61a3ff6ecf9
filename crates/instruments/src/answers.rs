//! Answers to the questions of an import, as options give them.

use ncfix_base::geometry::{Axis, Vector};
use ncfix_machine::machine::Machine;

use crate::unit::ReadingUnit;
use crate::words;

/// Option that answers a question.
#[derive(Clone, Copy, Debug)]
pub struct ImportOption {
    /// Name on the command line, without dashes.
    pub name: &'static str,
    /// Example of its value; empty for a switch.
    pub example: &'static str,
    /// Fact that it states.
    pub meaning: &'static str,
    /// True if the answers have it, with a value that would change readings to which it applies.
    given: fn(&ImportAnswers) -> bool,
    set: fn(&mut ImportAnswers, &str) -> Result<(), String>,
}

/// All options, in the order of the help.
pub const OPTIONS: &[ImportOption] = &[
    ImportOption {
        name: "axis",
        example: "X",
        meaning: "Axis that moved",
        given: |of| of.axis.is_some(),
        set: |to, text| {
            to.axis = Some(axis(text)?);
            Ok(())
        },
    },
    ImportOption {
        name: "component",
        example: "EYX",
        meaning: "Measured error: EXX positioning, EYX straightness, EBX angle of X",
        given: |of| of.component.is_some(),
        set: |to, text| {
            to.component = Some(component(text)?);
            Ok(())
        },
    },
    ImportOption {
        name: "reference",
        example: "square",
        meaning: "Reference of a straightness: square if its direction is exact, else straightedge (default): its alignment is then an unknown",
        given: |of| of.is_square.is_some(),
        set: |to, text| {
            to.is_square = Some(match text {
                "square" => true,
                "straightedge" => false,
                _ => return Err("write square or straightedge".to_owned()),
            });
            Ok(())
        },
    },
    ImportOption {
        name: "at",
        example: "Y200,Z100",
        meaning: "Positions of the other axes, or the zero or center of the positions in the file; machine coordinates, mm and degrees",
        given: |of| !of.at.is_empty(),
        set: |to, text| {
            to.at = positions(text)?;
            Ok(())
        },
    },
    ImportOption {
        name: "sign",
        example: "+",
        meaning: "+ if, for a positive reading, the tool is too far in the positive direction as seen from the workpiece (angles: turned by the right-hand rule), else -; a level on a moving table: the opposite",
        given: |of| of.sign.is_some(),
        set: |to, text| {
            to.sign = Some(sign(text)?);
            Ok(())
        },
    },
    ImportOption {
        name: "unit",
        example: "um",
        meaning: "Unit of the readings",
        given: |of| of.unit.is_some(),
        set: |to, text| {
            to.unit = Some(unit(text)?);
            Ok(())
        },
    },
    ImportOption {
        name: "columns",
        example: "target,1+,1-",
        meaning: "Meaning of each column, in order; - for a column that is not read",
        given: |of| !of.columns.is_empty(),
        set: |to, text| {
            to.columns = text.split(',').map(|part| part.trim().to_owned()).collect();
            Ok(())
        },
    },
    ImportOption {
        name: "tool",
        example: "120",
        meaning: "Length from the spindle gauge point to the measuring point, or its vector x,y,z, mm",
        given: |of| of.tool.is_some(),
        set: |to, text| {
            to.tool = Some(tool(text)?);
            Ok(())
        },
    },
    ImportOption {
        name: "material",
        example: "11.5@26",
        meaning: "Expansion in µm/m per K and temperature in °C: of the linear scale during the measurement, of the bar of a ball-bar, or of the part while it was cut on this machine; 20C if the readings already refer to 20 °C",
        // Readings without a length refer to every temperature.
        given: |of| matches!(of.material, Some(ReadingMaterial::Expanded { .. })),
        set: |to, text| {
            to.material = Some(material(text)?);
            Ok(())
        },
    },
    ImportOption {
        name: "plane",
        example: "XY",
        meaning: "Plane of a ball-bar circle, and the two axes from which and to which angles count: XY, YZ or ZX (XZ counts from X to Z)",
        given: |of| of.plane.is_some(),
        set: |to, text| {
            to.plane = Some(plane(text)?);
            Ok(())
        },
    },
    ImportOption {
        name: "radius",
        example: "150",
        meaning: "Nominal length of the ball-bar, mm",
        given: |of| of.radius_mm.is_some(),
        set: |to, text| {
            to.radius_mm = Some(positive(text)?);
            Ok(())
        },
    },
    ImportOption {
        name: "length",
        example: "calibrated",
        meaning: "Length of the ball-bar: calibrated if the deviations refer to its calibrated length, else unknown (default): it is then an unknown of the fit",
        given: |of| of.is_calibrated.is_some(),
        set: |to, text| {
            to.is_calibrated = Some(is_or_unknown(text, "calibrated")?);
            Ok(())
        },
    },
    ImportOption {
        name: "length-sigma",
        example: "0.5",
        meaning: "Standard uncertainty of the calibrated length of the ball-bar by its certificate (half of U for k = 2), µm",
        given: |of| of.length_sigma_um.is_some(),
        set: |to, text| {
            to.length_sigma_um = Some(positive(text.trim_end_matches("um").trim_end_matches("µm").trim())?);
            Ok(())
        },
    },
    ImportOption {
        name: "feed",
        example: "1000",
        meaning: "Feed of a ball-bar circle, mm/min",
        given: |of| of.feed.is_some(),
        set: |to, text| {
            to.feed = Some(positive(text)?);
            Ok(())
        },
    },
    ImportOption {
        name: "start-angle",
        example: "-180",
        meaning: "Angle at the first reading of a ball-bar circle by time, with the overshoot, degrees",
        given: |of| of.start_deg.is_some(),
        set: |to, text| {
            to.start_deg = Some(angle(text)?);
            Ok(())
        },
    },
    ImportOption {
        name: "turn",
        example: "ccw",
        meaning: "Direction of ball-bar circles: ccw from the first axis of the plane to the second, or cw; one for all, or one for each run such as ccw,cw",
        given: |of| !of.turns.is_empty(),
        set: |to, text| {
            to.turns = text.split(',').map(turn).collect::<Result<_, _>>()?;
            Ok(())
        },
    },
    ImportOption {
        name: "order",
        example: "motion",
        meaning: "Order of the rows: motion if it is that of the motion or machining, which gives directions of approach, else unknown (default for meshes, height maps and features)",
        given: |of| of.is_in_order.is_some(),
        set: |to, text| {
            to.is_in_order = Some(is_or_unknown(text, "motion")?);
            Ok(())
        },
    },
    ImportOption {
        name: "turned",
        example: "90",
        meaning: "Angle about Z by which the part of a CMM report was turned on the machine, degrees, + from X to Y: 90 if X of the part pointed along Y+ of the machine; 0 (default), 90, 180 or -90",
        given: |of| of.turned.is_some(),
        set: |to, text| {
            to.turned = Some(match text {
                "0" => 0,
                "90" | "+90" => 1,
                "180" | "-180" => 2,
                "-90" | "270" => 3,
                _ => return Err("write 0, 90, 180 or -90".to_owned()),
            });
            Ok(())
        },
    },
    ImportOption {
        name: "sigma",
        example: "0.5",
        meaning: "Standard uncertainty of a reading, µm or µrad; without it a calibration estimates it",
        given: |of| of.sigma.is_some(),
        set: |to, text| {
            to.sigma = Some(positive(text)?);
            Ok(())
        },
    },
];

/// Error component of an axis: direction 0 to 2 along X Y Z, 3 to 5 about them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeasuredComponent {
    /// Direction.
    pub direction: usize,
    /// Axis that moves.
    pub axis: Axis,
}

impl MeasuredComponent {
    /// Positioning of an axis.
    #[must_use]
    pub fn positioning(axis: Axis) -> MeasuredComponent {
        MeasuredComponent { direction: b"XYZABC".iter().position(|&letter| letter == axis.letter()).unwrap_or(0), axis }
    }

    /// True for an angle.
    #[must_use]
    pub fn is_angle(self) -> bool {
        self.direction >= 3
    }

    /// True for the deviation in the direction of the axis itself.
    #[must_use]
    pub fn is_positioning(self) -> bool {
        self == MeasuredComponent::positioning(self.axis)
    }

    /// Returns the letter of its direction.
    #[must_use]
    pub fn letter(self) -> char {
        ['X', 'Y', 'Z', 'A', 'B', 'C'].get(self.direction).copied().unwrap_or('X')
    }
}

impl std::fmt::Display for MeasuredComponent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "E{}{}", self.letter(), char::from(self.axis.letter()))
    }
}

/// Temperature state to which readings refer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReadingMaterial {
    /// Readings at 20 °C, or corrected to it by the instrument.
    Reference,
    /// Scale or workpiece at another temperature.
    Expanded {
        /// Expansion per K.
        per_k: f64,
        /// Temperature, °C.
        celsius: f64,
    },
}

impl ReadingMaterial {
    /// Returns the expansion from 20 °C, as a fraction of the length.
    #[must_use]
    pub fn stretch(self) -> f64 {
        match self {
            ReadingMaterial::Reference => 0.0,
            ReadingMaterial::Expanded { per_k, celsius } => per_k * (celsius - 20.0),
        }
    }
}

/// Place of the measuring point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeasuringPoint {
    /// Distance from the gauge point along the spindle, mm.
    Length(f64),
    /// Vector from the gauge point in F at the zero pose, mm.
    Vector(Vector),
}

impl MeasuringPoint {
    /// Returns the vector in F at the zero pose, mm.
    #[must_use]
    pub fn vector_mm(self, machine: &Machine) -> Vector {
        match self {
            MeasuringPoint::Length(mm) => machine.spindle.axis * -mm,
            MeasuringPoint::Vector(vector) => vector,
        }
    }
}

/// Answers; `None` where the option was not given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportAnswers {
    /// Axis that moved.
    pub axis: Option<Axis>,
    /// Measured component.
    pub component: Option<MeasuredComponent>,
    /// Positions, mm and degrees.
    pub at: Vec<(Axis, f64)>,
    /// Sign of the readings, 1 or -1.
    pub sign: Option<f64>,
    /// Unit of the readings.
    pub unit: Option<ReadingUnit>,
    /// Meanings of the columns.
    pub columns: Vec<String>,
    /// Measuring point.
    pub tool: Option<MeasuringPoint>,
    /// Temperature state.
    pub material: Option<ReadingMaterial>,
    /// First and second axis of a circle.
    pub plane: Option<[Axis; 2]>,
    /// Nominal length of a ball-bar, mm.
    pub radius_mm: Option<f64>,
    /// True if the length of a ball-bar is calibrated.
    pub is_calibrated: Option<bool>,
    /// Standard uncertainty of the calibrated length, µm.
    pub length_sigma_um: Option<f64>,
    /// Feed, mm/min.
    pub feed: Option<f64>,
    /// Angle at the first reading of a circle by time, degrees.
    pub start_deg: Option<f64>,
    /// Direction of circles, one for all or one for each run: 1 from the first axis of the plane to the second, else -1.
    pub turns: Vec<f64>,
    /// True if the order of the rows is that of the motion.
    pub is_in_order: Option<bool>,
    /// Standard uncertainty, µm or µrad.
    pub sigma: Option<f64>,
    /// Quarter turns of the part about Z on the machine.
    pub turned: Option<usize>,
    /// True if a height map is that of a calibrated flat.
    pub is_flat_reference: bool,
    /// True if a straightness was read along a square.
    pub is_square: Option<bool>,
}

impl ImportAnswers {
    /// Takes the value of an option.
    ///
    /// # Errors
    /// A sentence if the value is not one of this option, or the option does not exist.
    pub fn set(&mut self, option: &str, text: &str) -> Result<(), String> {
        let known = OPTIONS.iter().find(|one| one.name == option);
        known.map_or_else(|| Err(format!("there is no option --{option}")), |known| (known.set)(self, text.trim()))
    }

    /// Names of the options that were given, in the order of the help.
    pub(crate) fn given(&self) -> impl Iterator<Item = &'static str> {
        let named = OPTIONS.iter().filter(|option| (option.given)(self)).map(|option| option.name);
        named.chain(self.is_flat_reference.then_some("flat-reference"))
    }
}

/// Answers of a command with several files: those for all of them, and those for single ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileAnswers {
    /// Answers for all files.
    pub all: ImportAnswers,
    /// File, option and value of the answers for single files.
    own: Vec<(String, String, String)>,
    /// Options that were given for all files.
    given: Vec<String>,
}

impl FileAnswers {
    /// Takes the value of an option: `VALUE` for all files, or `FILE=VALUE` for one. FILE is its name, with or without the ending.
    ///
    /// # Errors
    /// A sentence if the value is not one of this option, or is given twice.
    pub fn set(&mut self, option: &str, text: &str) -> Result<(), String> {
        // `Y=200` and `Y200,Z=100` are positions.
        let of_file = text.split_once('=').filter(|(file, _)| file.chars().count() > 1 && !file.contains(','));
        let twice = |of: &str| format!("it is given twice{of}");
        let Some((file, value)) = of_file else {
            if self.given.iter().any(|own| own == option) {
                return Err(twice("; for one file write FILE=VALUE"));
            }
            self.given.push(option.to_owned());
            return self.all.set(option, text);
        };
        if self.own.iter().any(|(own, known, _)| own == file && known == option) {
            return Err(twice(&format!(" for {file}")));
        }
        ImportAnswers::default().set(option, value)?;
        self.own.push((file.to_owned(), option.to_owned(), value.to_owned()));
        Ok(())
    }

    /// The answers for a file by its name: its own, and for other options those for all files.
    #[must_use]
    pub fn of(&self, name: &str) -> ImportAnswers {
        let mut answers = self.all.clone();
        for (_, option, value) in self.own.iter().filter(|(file, ..)| is_named(file, name)) {
            // It was accepted before.
            let _ = answers.set(option, value);
        }
        answers
    }

    /// True if an answer with this option is for this file alone.
    #[must_use]
    pub fn is_own(&self, name: &str, option: &str) -> bool {
        self.own.iter().any(|(file, own, _)| own == option && is_named(file, name))
    }

    /// The first file of an answer that none of the names means.
    #[must_use]
    pub fn stranger<'a>(&self, names: impl Iterator<Item = &'a str> + Clone) -> Option<&str> {
        let is_known = |file: &str| names.clone().any(|name| is_named(file, name));
        self.own.iter().map(|(file, ..)| file.as_str()).find(|file| !is_known(file))
    }
}

/// True if a word means a file: its name, with or without the ending.
fn is_named(word: &str, name: &str) -> bool {
    word == name || name.rsplit_once('.').is_some_and(|(stem, _)| stem == word)
}

fn angle(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| value.abs() <= 3600.0);
    value.ok_or_else(|| format!("'{text}' is not an angle in degrees"))
}

/// Direction of a circle: 1 for `ccw`, -1 for `cw`.
///
/// # Errors
/// If the text is neither.
pub fn turn(text: &str) -> Result<f64, String> {
    match text.trim() {
        "+" | "+1" | "1" => Ok(1.0),
        "-" | "-1" | "\u{2212}" => Ok(-1.0),
        text => words::turn(text)
            .map(f64::from)
            .ok_or_else(|| format!("'{text}' is not a direction of a circle; write ccw or cw")),
    }
}

fn axis(text: &str) -> Result<Axis, String> {
    let wrong = || format!("'{text}' is not an axis; write for example X");
    match text.as_bytes() {
        [letter] => Axis::from_letter(letter.to_ascii_uppercase()).ok_or_else(wrong),
        _ => Err(wrong()),
    }
}

/// Reads an error component such as `EYX`.
///
/// # Errors
/// A sentence if the text is not one.
pub fn component(text: &str) -> Result<MeasuredComponent, String> {
    let wrong = || format!("'{text}' is not an error of a motion; write for example EXX, EYX or EBX");
    let [b'E', direction, letter] = *text.to_ascii_uppercase().as_bytes() else { return Err(wrong()) };
    let direction = b"XYZABC".iter().position(|&own| own == direction).ok_or_else(wrong)?;
    Ok(MeasuredComponent { direction, axis: Axis::from_letter(letter).ok_or_else(wrong)? })
}

fn number(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite() && value.abs() < 1e9);
    value.ok_or_else(|| format!("'{text}' is not a number; write for example 12.5"))
}

/// True for this word, false for `unknown`.
fn is_or_unknown(text: &str, word: &str) -> Result<bool, String> {
    match text {
        "unknown" => Ok(false),
        _ if text == word => Ok(true),
        _ => Err(format!("write {word} or unknown")),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err(format!("'{text}' is not above 0")) })
}

fn positions(text: &str) -> Result<Vec<(Axis, f64)>, String> {
    let mut found: Vec<(Axis, f64)> = Vec::new();
    for part in text.split(',').map(str::trim) {
        let wrong = || format!("'{part}' is not an axis position; write for example Y200,Z100");
        let letter = part.chars().next().filter(char::is_ascii).ok_or_else(wrong)?;
        let axis = Axis::from_letter(letter.to_ascii_uppercase() as u8).ok_or_else(wrong)?;
        let value = number(part.get(1..).unwrap_or_default().trim().trim_start_matches('=')).map_err(|_| wrong())?;
        if found.iter().any(|(own, _)| *own == axis) {
            return Err(format!("{} is given twice", char::from(axis.letter())));
        }
        found.push((axis, value));
    }
    Ok(found)
}

fn sign(text: &str) -> Result<f64, String> {
    match text {
        "+" | "+1" | "plus" => Ok(1.0),
        "-" | "-1" | "minus" | "\u{2212}" => Ok(-1.0),
        _ => Err(format!("'{text}' is not a sign; write + or -")),
    }
}

fn unit(text: &str) -> Result<ReadingUnit, String> {
    ReadingUnit::find(text).ok_or_else(|| {
        format!("'{text}' is not a unit; write one of {}, {}", ReadingUnit::choices(false), ReadingUnit::choices(true))
    })
}

fn tool(text: &str) -> Result<MeasuringPoint, String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(number).collect();
    match numbers?.as_slice() {
        [mm] => Ok(MeasuringPoint::Length(*mm)),
        [x, y, z] => Ok(MeasuringPoint::Vector(Vector::new(*x, *y, *z))),
        _ => Err(format!("'{text}' is neither a length nor a vector; write for example 120 or 0,0,-120")),
    }
}

fn material(text: &str) -> Result<ReadingMaterial, String> {
    let wrong =
        || format!("'{text}' is not a state of the material; write 20C, or expansion and temperature such as 11.5@26");
    if matches!(text.to_lowercase().as_str(), "20c" | "20°c" | "20") {
        return Ok(ReadingMaterial::Reference);
    }
    let (expansion, celsius) = text.split_once('@').ok_or_else(wrong)?;
    let celsius = celsius.trim().trim_end_matches(['C', 'c', '°']);
    let (expansion, celsius) = (number(expansion).map_err(|_| wrong())?, number(celsius).map_err(|_| wrong())?);
    // The ranges of a data file: up to 0.001 per K, -30 to 150 °C.
    if !(0.0..=1000.0).contains(&expansion) || !(-30.0..=150.0).contains(&celsius) {
        return Err(wrong());
    }
    Ok(ReadingMaterial::Expanded { per_k: expansion * 1e-6, celsius })
}

/// Reads a plane: first and second axis, in which angles count from the first to the second.
///
/// # Errors
/// A sentence if the text is not one.
pub fn plane(text: &str) -> Result<[Axis; 2], String> {
    match text.trim().to_uppercase().as_str() {
        "XY" | "G17" => Ok([Axis::X, Axis::Y]),
        "YZ" | "G19" => Ok([Axis::Y, Axis::Z]),
        "ZX" | "G18" => Ok([Axis::Z, Axis::X]),
        "YX" => Ok([Axis::Y, Axis::X]),
        "ZY" => Ok([Axis::Z, Axis::Y]),
        "XZ" => Ok([Axis::X, Axis::Z]),
        _ => Err(format!("'{text}' is not a plane; write XY, YZ or ZX")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn examples_of_options_are_values_of_them() {
        for option in OPTIONS {
            let mut answers = ImportAnswers::default();
            answers.set(option.name, option.example).unwrap_or_else(|error| panic!("{}: {error}", option.name));
            assert_ne!(answers, ImportAnswers::default(), "{}", option.name);
            assert!(answers.set(option.name, "?").is_err() || option.name == "columns", "{}", option.name);
        }
    }

    #[test]
    fn an_answer_for_one_file_goes_before_that_for_all() {
        let mut answers = FileAnswers::default();
        for (option, text) in [("at", "Y=200"), ("at", "laser_Y=X300,Z-200"), ("unit", "um"), ("unit", "lid.csv=mm")] {
            answers.set(option, text).unwrap();
        }
        assert_eq!(answers.of("laser_X.csv").at, [(Axis::Y, 200.0)]);
        assert_eq!(answers.of("laser_Y.csv").at, [(Axis::X, 300.0), (Axis::Z, -200.0)]);
        assert_ne!(answers.of("lid.csv").unit, answers.of("lid.txt").unit);
        assert!(answers.set("unit", "mm").is_err() && answers.set("unit", "lid.csv=um").is_err());
        assert!(answers.set("unit", "x.csv=banana").is_err());
        assert_eq!(answers.stranger(["laser_Y.csv", "lid.csv"].into_iter()), None);
        assert_eq!(answers.stranger(["laser_Y.csv"].into_iter()), Some("lid.csv"));
    }

    #[test]
    fn materials_expand_from_20_degrees() {
        let mut answers = ImportAnswers::default();
        answers.set("material", "23.8@26").unwrap();
        // 23.8 µm/m per K times 6 K.
        assert!((answers.material.unwrap().stretch() - 142.8e-6).abs() < 1e-12);
    }
}
