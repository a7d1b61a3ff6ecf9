//! Causes of parameters that are not identifiable, and remedies.

use std::fmt;

use crate::measure::data::DataSet;
use crate::measure::kind::{Measurand, Unknown};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_model::name::ErrorKind;
use ncfix_model::parameter::{ComponentTerm, ParameterName};

use super::column::Column;
use super::effect::{Parameter, lack};

/// Positions nearer to each other than this are equal, mm or rad.
const SAME_PLACE: f64 = 1e-3;
/// Largest distance of coplanar points from their plane, as a share of their extent.
const FLAT: f64 = 1e-3;
/// A ball-bar is along an axis if its part along another one is less than this share of its length: 1.7 degrees.
const ALONG: f64 = 0.03;

/// The cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum UndeterminedCause {
    /// An axis was at too few positions: the actual and the required number.
    Few(Axis, usize, usize),
    /// An axis was approached from one side only.
    OneSense(Axis),
    /// No row states from which side an axis came.
    NoSense(Axis),
    /// An axis was never beyond the start of a truncated power.
    Beyond(Axis),
    /// No row has a load on the table.
    NoLoad,
    /// All rows have the same load.
    OneLoad,
    /// No row has a temperature.
    NoTemperatures,
    /// An effect is not distinguishable from other parameters in these conditions and poses.
    Conditions,
    /// Nothing measured depends on it.
    Unfelt,
    /// Nothing determines the scale.
    Scale,
    /// The offsets of spindle and stylus.
    Stylus,
    /// A constant part, and the position of a part of the set-up.
    Constant,
    /// Other unknowns of set-ups.
    SetUp,
    /// Rotations with a single lever arm.
    Lever,
    /// All points are coplanar.
    Plane,
    /// Every ball-bar in the plane of these axes is parallel to one of them.
    AlongAxes([Axis; 2]),
    /// Angles of a rotary axis.
    Angles(Axis),
    /// All readings over the angles of a rotary axis are at one position of a linear axis.
    OneHeight(Axis, Axis),
    /// None of these.
    Poses,
}

impl UndeterminedCause {
    /// `true` if several parameters are not distinguishable in these poses.
    pub(super) fn is_of_poses(self) -> bool {
        matches!(
            self,
            UndeterminedCause::Conditions
                | UndeterminedCause::Lever
                | UndeterminedCause::Plane
                | UndeterminedCause::Angles(_)
                | UndeterminedCause::OneHeight(..)
                | UndeterminedCause::Poses
        )
    }

    /// The remedy; `many` for several parameters.
    pub(super) fn remedy(self, many: bool) -> String {
        let them = if many { "them" } else { "it" };
        // Of a pair, either one can be left out.
        let one_of_them = if many { "them" } else { "one of them" };
        match self {
            UndeterminedCause::Few(axis, found, needed) if axis.is_rotary() => {
                let more = needed.saturating_sub(found).max(1);
                let s = if more == 1 { "" } else { "s" };
                format!("index {axis} to at least {more} more angle{s}, or leave {them} out of the model")
            }
            UndeterminedCause::Few(axis, _, needed) => {
                format!("measure at {needed} or more positions of {axis}, or leave {them} out of the model")
            }
            UndeterminedCause::OneSense(axis) => {
                format!("approach positions of {axis} from both directions, or leave {them} out of the model")
            }
            UndeterminedCause::NoSense(axis) => format!(
                "if the rows are in the order of the motion, import with --order motion or remove order = \"unknown\"; else add the column {axis}_dir, or leave {them} out of the model"
            ),
            UndeterminedCause::Beyond(axis) => {
                format!("measure further along {axis}, or leave {them} out of the model")
            }
            UndeterminedCause::NoLoad => {
                format!("measure also with a load on the table and give it (load_N), or leave {them} out of the model")
            }
            UndeterminedCause::OneLoad => format!("measure also without the load, or leave {them} out of the model"),
            UndeterminedCause::NoTemperatures => {
                format!(
                    "measure also with the machine warm, with temperature columns or --state, or leave {them} out of the model"
                )
            }
            UndeterminedCause::Conditions => {
                format!(
                    "measure at other loads or temperatures, in poses in which they differ, or leave {them} out of the model"
                )
            }
            UndeterminedCause::Unfelt => {
                format!(
                    "measure where {} would have an effect, or leave {them} out of the model",
                    if many { "they" } else { "it" }
                )
            }
            UndeterminedCause::Scale => {
                "give a calibrated length (remove length from free, or with probed balls write [[length]] between two of them); \
                             without it, the scale of one axis cannot be fitted"
                    .into()
            }
            UndeterminedCause::Stylus => format!(
                "turn the spindle by hand between probings (spindle_deg), remove tool from free if the stylus is calibrated, or leave {them} out of the model"
            ),
            UndeterminedCause::Constant => {
                format!(
                    "leave {them} out of the model: the set-up absorbs constant parts, unless the description states its position"
                )
            }
            UndeterminedCause::SetUp => format!(
                "describe what is known of the set-up (remove it from free), measure in another one, or leave {them} out of the model"
            ),
            UndeterminedCause::Lever => {
                "measure the same with a second tool vector (another length, or off the spindle)".into()
            }
            UndeterminedCause::Plane => {
                format!(
                    "leave {one_of_them} out of the model; if the machine has poses outside this plane in which they differ, measure there as well"
                )
            }
            UndeterminedCause::AlongAxes([one, other]) => {
                format!("read the bar also near 45° and 135° between {one} and {other}, or leave {them} out of the model")
            }
            UndeterminedCause::Angles(axis) => {
                format!("index {axis} at three more angles, or leave {them} out of the model")
            }
            UndeterminedCause::OneHeight(rotary, linear) => {
                format!(
                    "measure over the same angles of {rotary} at a second position of {linear}, at least 100 mm away, or leave {them} out of the model"
                )
            }
            UndeterminedCause::Poses => {
                format!("leave {one_of_them} out of the model, or measure in poses in which they differ")
            }
        }
    }
}

/// The end of the sentence.
impl fmt::Display for UndeterminedCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UndeterminedCause::Few(axis, found, needed) => {
                let s = if *found == 1 { "" } else { "s" };
                write!(f, "; {axis} was at {found} position{s}; at least {needed} are needed")
            }
            UndeterminedCause::NoLoad => write!(f, "; there was no load on the table"),
            UndeterminedCause::OneLoad => write!(f, "; there was only one load"),
            UndeterminedCause::NoTemperatures => write!(f, "; there are no temperatures"),
            UndeterminedCause::OneSense(axis) => write!(f, "; {axis} was approached in one direction only"),
            UndeterminedCause::NoSense(axis) => write!(f, "; the directions of approach of {axis} are not known"),
            UndeterminedCause::Beyond(axis) => write!(f, "; {axis} did not move that far"),
            UndeterminedCause::Lever => write!(f, "; all measurements have one tool vector"),
            UndeterminedCause::AlongAxes([one, other]) => {
                write!(f, "; no reading of the ball-bar lies near 45° or 135° between {one} and {other}")
            }
            UndeterminedCause::Plane => write!(f, "; all measurements are in one plane"),
            UndeterminedCause::OneHeight(rotary, linear) => {
                write!(f, "; all readings over the angles of {rotary} are at one position of {linear}")
            }
            _ => Ok(()),
        }
    }
}

/// Determines the cause. `own` is a parameter, `others` those from which it is not distinguishable. `settles`: known lengths of the instruments alone would
/// distinguish it.
pub(super) fn cause(own: &Parameter, others: &[&Column], data: &[DataSet], settles: bool) -> UndeterminedCause {
    let all = || std::iter::once(own.clone()).chain(others.iter().filter_map(|column| column.parameter()));
    let (mut parameters, mut effects) = (Vec::new(), Vec::new());
    for one in all() {
        match one {
            Parameter::Geometry(name) => parameters.push(name),
            Parameter::Effect(parameter) => effects.push(parameter),
        }
    }
    if let Some(cause) = Some(&effects).filter(|effects| !effects.is_empty()).and_then(|effects| lack(effects, data)) {
        return cause;
    }
    let Parameter::Geometry(own) = own else {
        return of_effect(others, &parameters, data);
    };
    if settles && is_gain(own) {
        return UndeterminedCause::Scale;
    }
    if let Some(cause) = positions_lack(own, &parameters, others.is_empty(), data) {
        return cause;
    }
    if let Some(axes) = along_axes(own, data) {
        return UndeterminedCause::AlongAxes(axes);
    }
    if others.is_empty() {
        return UndeterminedCause::Unfelt;
    }
    let unknowns = || {
        others.iter().filter_map(|column| match column {
            Column::Unknown(_, unknown) => Some(*unknown),
            Column::Parameter(_) | Column::Effect(_) => None,
        })
    };
    if !effects.is_empty() {
        return UndeterminedCause::Conditions;
    }
    let is_about_size = parameters.iter().all(is_gain);
    let is_length = |one| matches!(one, Unknown::Length(_) | Unknown::Rod(_) | Unknown::RodTemperature(_));
    if is_about_size && (unknowns().any(is_length) || parameters.len() > 1) {
        return UndeterminedCause::Scale;
    }
    if parameters.len() == 1 {
        if own.component.axis().is_none() && unknowns().any(|one| matches!(one, Unknown::Tool(..))) {
            return UndeterminedCause::Stylus;
        }
        return if own.degree() == 0 { UndeterminedCause::Constant } else { UndeterminedCause::SetUp };
    }
    let turns = |name: &ParameterName| name.component.direction.is_rotation() && name.term != ComponentTerm::Whole;
    if parameters.iter().any(turns) && has_one_tool(data) {
        return UndeterminedCause::Lever;
    }
    if is_flat(data) {
        return UndeterminedCause::Plane;
    }
    let rotary = parameters.iter().filter_map(|name| name.component.axis()).find(|axis| axis.is_rotary());
    rotary.map_or(UndeterminedCause::Poses, |axis| about_angles(axis, &parameters, data))
}

/// The cause beside the location errors of a rotary axis that was at several angles.
fn about_angles(rotary: Axis, parameters: &[ParameterName], data: &[DataSet]) -> UndeterminedCause {
    /// Number of angles that determine a first harmonic, with one to spare.
    const ENOUGH: usize = 4;
    let places = |set: &DataSet, axis: Axis| {
        let mut found: Vec<f64> = Vec::new();
        for row in &set.observations {
            let at = row.reading.position[axis];
            if found.len() < ENOUGH && found.iter().all(|known| (known - at).abs() > SAME_PLACE) {
                found.push(at);
            }
        }
        found
    };
    let turning: Vec<&DataSet> = data.iter().filter(|set| places(set, rotary).len() >= ENOUGH).collect();
    if turning.is_empty() {
        return UndeterminedCause::Angles(rotary);
    }
    let is_one_place = |axis: &Axis| {
        let all: Vec<f64> = turning.iter().flat_map(|set| places(set, *axis)).collect();
        all.iter().all(|at| all.first().is_none_or(|first| (at - first).abs() <= SAME_PLACE))
    };
    let linear = parameters.iter().filter(|name| name.term == ComponentTerm::Whole);
    let mut linear = linear.filter_map(|name| name.component.axis()).filter(|axis| !axis.is_rotary());
    linear.find(is_one_place).map_or(UndeterminedCause::Poses, |axis| UndeterminedCause::OneHeight(rotary, axis))
}

/// The cause for a parameter of an effect although conditions did change; `geometry` are other parameters involved.
fn of_effect(others: &[&Column], geometry: &[ParameterName], data: &[DataSet]) -> UndeterminedCause {
    if others.is_empty() {
        return UndeterminedCause::Unfelt;
    }
    if let Some(cause) = geometry.iter().find_map(|name| positions_lack(name, geometry, false, data)) {
        return cause;
    }
    if others.iter().any(|column| column.is_of_machine()) {
        UndeterminedCause::Conditions
    } else {
        UndeterminedCause::SetUp
    }
}

/// Checks for an axis of the parameters with too few positions.
fn positions_lack(
    own: &ParameterName,
    all: &[ParameterName],
    is_unfelt: bool,
    data: &[DataSet],
) -> Option<UndeterminedCause> {
    if let (ComponentTerm::Knot { at, .. }, Some(axis)) = (own.term, own.component.axis()) {
        let begins = if axis.is_rotary() { f64::from(at).to_radians() } else { f64::from(at) };
        if observations(data).all(|position| position(axis) <= begins + SAME_PLACE) {
            return Some(UndeterminedCause::Beyond(axis));
        }
    }
    if is_unfelt && own.degree() == 0 && own.term != ComponentTerm::Backlash {
        return None;
    }
    let mut axes: Vec<Axis> = all.iter().filter_map(|name| name.component.axis()).collect();
    axes.sort_unstable();
    axes.dedup();
    axes.into_iter().find_map(|axis| {
        let names = || all.iter().filter(|name| name.component.axis() == Some(axis));
        let highest = names().map(ParameterName::degree).max().unwrap_or(0);
        let needed = (usize::from(highest) + 1).max(if axis.is_rotary() { 2 } else { 1 });
        if names().any(|name| name.term == ComponentTerm::Backlash) {
            let rows = || data.iter().flat_map(|set| &set.observations);
            let came = |sense: i8| rows().any(|row| row.reading.state.direction(axis) == sense);
            match (came(1), came(-1)) {
                (false, false) => return Some(UndeterminedCause::NoSense(axis)),
                (true, false) | (false, true) => return Some(UndeterminedCause::OneSense(axis)),
                (true, true) => {}
            }
        }
        let mut found: Vec<f64> = Vec::new();
        for position in observations(data) {
            let position = position(axis);
            if found.len() < needed && found.iter().all(|known| (known - position).abs() > SAME_PLACE) {
                found.push(position);
            }
        }
        (found.len() < needed).then_some(UndeterminedCause::Few(axis, found.len(), needed))
    })
}

/// The axis positions, row by row.
fn observations(data: &[DataSet]) -> impl Iterator<Item = impl Fn(Axis) -> f64> {
    data.iter().flat_map(|set| &set.observations).map(|row| move |axis: Axis| row.reading.position[axis])
}

/// `true` for the gain of an axis.
fn is_gain(name: &ParameterName) -> bool {
    let direction = name.component.direction;
    name.term == ComponentTerm::Coefficient(1)
        && !direction.is_rotation()
        && name.component.axis() == [Axis::X, Axis::Y, Axis::Z].get(direction.index()).copied()
}

/// `true` if all rows have the same tool vector.
fn has_one_tool(data: &[DataSet]) -> bool {
    let mut tools = data.iter().flat_map(|set| &set.observations).map(|row| row.reading.tool_mm);
    let first = tools.next();
    tools.all(|tool| first.is_none_or(|first| (tool - first).norm() < SAME_PLACE))
}

/// The plane of a squareness or straightness, if ball-bars are parallel to each of its axes, and none is between them. Only there would such an error
/// change the length of the bar.
fn along_axes(own: &ParameterName, data: &[DataSet]) -> Option<[Axis; 2]> {
    const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
    let direction = own.component.direction;
    let axis = own.component.axis().filter(|axis| !axis.is_rotary())?;
    let pair = match (own.component.kind, direction.is_rotation()) {
        (ErrorKind::Location, true) => match direction.index() {
            3 => [Axis::Y, Axis::Z],
            4 => [Axis::X, Axis::Z],
            _ => [Axis::X, Axis::Y],
        },
        (ErrorKind::Motion, false) if own.degree() > 0 => [axis, *LINEAR.get(direction.index())?],
        _ => return None,
    };
    let [one, other] = pair.map(|axis| LINEAR.iter().position(|known| *known == axis));
    let (one, other) = (one?, other?);
    if one == other || !data.iter().all(|set| set.kind.measurand == Measurand::BallDistance) {
        return None;
    }
    let mut is_along = [false; 2];
    for set in data {
        for row in &set.observations {
            let setup = set.setups.get(row.setup)?;
            let position = &row.reading.position;
            let tip = Vector::new(position[Axis::X], position[Axis::Y], position[Axis::Z]) + row.reading.tool_mm;
            let bar = tip - setup.centre_mm;
            let least = ALONG * bar.norm();
            match [bar[one].abs() > least, bar[other].abs() > least] {
                [true, true] => return None,
                [first, second] => is_along = [is_along[0] || first, is_along[1] || second],
            }
        }
    }
    (is_along == [true; 2]).then_some(pair)
}

/// `true` if the positions of the linear axes are coplanar or collinear.
fn is_flat(data: &[DataSet]) -> bool {
    let places =
        || observations(data).map(|position| Vector::new(position(Axis::X), position(Axis::Y), position(Axis::Z)));
    let count = places().count().max(1) as f64;
    let middle = places().sum::<Vector>() / count;
    let mut spread = nalgebra::Matrix3::<f64>::zeros();
    places().for_each(|place| spread += (place - middle) * (place - middle).transpose());
    let values = spread.symmetric_eigenvalues();
    values.min().max(0.0).sqrt() <= FLAT * values.max().max(0.0).sqrt()
}
