//! Makes compensation tables for a format, and rejects tables that increase the error or have no effect.

use super::request::TablesRequest;
use super::result::{FewerRow, MissingPart, ReversalRow, TablesCheck, TablesResult, TriedScheme};
use crate::tables::format::Holds;
use crate::tables::scheme::{self, Scheme, Schemes, Task};
use crate::tables::{Format, Tables, Wiring};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Axis;
use ncfix_base::number::significant;
use ncfix_base::units::um_from_mm;
use ncfix_model::Accumulator;

/// Settings for filling tables.
#[derive(Clone, Copy, Debug)]
pub struct Filling<'a> {
    /// The format of the tables.
    pub format: &'static Format,
    /// The scheme; `None` for the fewest tables that reach the tolerance.
    pub scheme: Option<&'a Scheme>,
    /// The schemes to select from.
    pub schemes: &'a Schemes,
    /// Number of points of a table.
    pub points: usize,
    /// Permitted residual error, mm: root mean square over the region.
    pub tolerance_mm: f64,
    /// `true` to compute the residuals with fewer tables too.
    pub tries_fewer: bool,
    /// Largest number of tables: the best set of them is taken.
    pub most: Option<usize>,
    /// `true` to omit the tables of a stated scheme that the tolerance does not need.
    pub is_fewest: bool,
}

/// Tables that reduce the error.
#[derive(Clone, Debug)]
pub struct MadeTables {
    /// The tables.
    pub tables: Tables,
    /// The scheme that filled them.
    pub scheme: &'static str,
    /// Their residual errors.
    pub checked: TablesCheck,
}

/// Makes tables and records the result and the tried schemes.
///
/// # Errors
/// The diagnostic with the reason: the scheme does not fit the format, no scheme reaches the tolerance, all values would be 0, or the tables would
/// increase the error.
pub fn make(
    request: &TablesRequest<'_>,
    filling: &Filling<'_>,
    result: &mut TablesResult,
) -> Result<MadeTables, Box<Diagnostic>> {
    let model = request.model();
    let errors = Accumulator::sum(request.machine, request.errors, request.condition, |_| true);
    let task = Task {
        target: request.target(&model),
        orientation: request.orientation,
        errors: &errors,
        region: &request.region,
        points: filling.points,
        tolerance_mm: filling.tolerance_mm,
        multiplication: request.multiplication.unwrap_or_default(),
        format: filling.format,
        wiring: &request.wiring,
    };
    let refused = |why: String, help: String| Box::new(Diagnostic::nowhere(Code::TABLES_DO_NOT_FIT, why, help));
    let (name, whole, tables) = match (filling.scheme, filling.most) {
        (Some(scheme), most) => {
            let whole = scheme.tables(&task).map_err(|why| refused(why, help(&task, ANOTHER)))?;
            let tables = match most {
                Some(most) => scheme::fewer::at_most(&task, &whole, most),
                None if filling.is_fewest => scheme::auto::fewest(&task, &whole).unwrap_or_else(|| whole.clone()),
                None => whole.clone(),
            };
            (scheme.name, whole, tables)
        }
        (None, Some(most)) => {
            let (best, tried) = scheme::auto::choose_at_most(filling.schemes, &task, most);
            result.tried = tried.iter().map(TriedScheme::from).collect();
            let Some((scheme, [whole, tables])) = best else {
                let tried: Vec<String> = result.tried.iter().map(said).collect();
                return Err(refused(format!("no scheme fits: {}", tried.join("; ")), help(&task, OTHER_FORMAT)));
            };
            (scheme.name, whole, tables)
        }
        (None, None) => {
            let (best, tried) = scheme::auto::choose_with(filling.schemes, &task);
            result.aim = Some(aim(filling.tolerance_mm));
            result.tried = tried.iter().map(TriedScheme::from).collect();
            let Some((scheme, tables)) = best else {
                let tried: Vec<String> = result.tried.iter().map(said).collect();
                let why = format!("no scheme reaches {}: {}", aim(filling.tolerance_mm), tried.join("; "));
                return Err(refused(why, help(&task, &larger(&result.tried))));
            };
            (scheme.name, tables.clone(), tables)
        }
    };
    if tables.errors.is_some() {
        result.left_out = scheme::functions::left_out(&task).iter().map(MissingPart::from).collect();
    }
    if !filling.format.can_hold(Holds::Senses) {
        result.reversals = reversals(&task);
    }
    result.machine.clone_from(&request.machine.name);
    name.clone_into(&mut result.scheme);
    filling.format.name.clone_into(&mut result.format);
    result.note(&tables);
    result.sums = request.largest_sums(&tables);
    if let Some(most) = filling.most {
        if tables.count() > most {
            let why = format!(
                "{most} tables are allowed, but the scheme {name} cannot do with fewer than {}",
                tables.count()
            );
            return Err(refused(why, help(&task, ANOTHER)));
        }
        if tables.is_empty() && !whole.are_zeros() {
            let why = format!("no set of at most {most} of the {} tables of {name} reduces the error", whole.count());
            return Err(refused(why, help(&task, "allow more tables with --most")));
        }
        result.chosen_of = Some(whole.count());
    }
    let checked = request.check(&tables);
    if tables.are_zeros() {
        result.tables = 0;
        let (why, help) = idle(&checked, &task);
        return Err(refused(why, help));
    }
    if let Some(diagnostic) = worse(&request.everywhere(&tables, &checked), &request.volume()) {
        result.tables = 0;
        return Err(Box::new(diagnostic));
    }
    result.ranges = request.asked_ranges();
    if filling.tries_fewer {
        result.fewer = scheme::fewer::fewer(&task, &whole).iter().map(FewerRow::from).collect();
    }
    Ok(MadeTables { tables, scheme: name, checked })
}

/// The reversal values of the axes, with their names and numbers at the control.
fn reversals(task: &Task<'_>) -> Vec<ReversalRow> {
    let row = |one: &scheme::Reversal| {
        let unit = |value: f64| if one.axis.is_rotary() { value.to_degrees() } else { value };
        ReversalRow {
            axis: one.axis.to_string(),
            name: task.wiring.name(one.axis),
            joint: task.wiring.axes().position(|axis| axis == one.axis).unwrap_or_default(),
            value: unit(one.mean),
            spread: unit(one.spread),
        }
    };
    scheme::reversals(task).iter().map(row).collect()
}

/// The limits of a format's control that tables exceed, one diagnostic each.
#[must_use]
pub fn misfits(format: &Format, tables: &Tables, wiring: &Wiring) -> Vec<Diagnostic> {
    let help = "try fewer --points, a larger --tolerance or another --scheme; ncfix tables --list shows the limits";
    let faults = format.faults_of(tables, wiring).into_iter();
    faults.map(|fault| Diagnostic::nowhere(Code::TABLES_DO_NOT_FIT, fault, help)).collect()
}

/// The diagnostic for tables that increase the error over `where_`, at the tip or in the tool direction.
#[must_use]
pub fn worse(checked: &TablesCheck, where_: &str) -> Option<Diagnostic> {
    /// Rounding difference between two summation orders, µm.
    const ROUNDED_UM: f64 = 1e-3;
    /// Change of the direction that does not count, µrad: axes that are corrected by some µm meet a slightly different angular error. It moves the tip of a tool of 500 mm
    /// by 0.05 µm, less than the finest increment of a control that writes micrometers with one decimal.
    const TURNED_URAD: f64 = 0.1;
    let (before, with) = (checked.before, checked.tables);
    // A constant error of the tip is gone with the next touched zero: what counts is the rest.
    let [tip_before, tip_with] = checked.about_shift_um.unwrap_or([before.rms_um, with.rms_um]);
    let of_tip = if checked.about_shift_um.is_some() { ", apart from a constant," } else { "" };
    let kinds = [
        (("tip", of_tip), "µm RMS", tip_before, tip_with, ROUNDED_UM),
        (("direction of the tool", ""), "µrad RMS", before.tilt_rms_urad, with.tilt_rms_urad, TURNED_URAD),
    ];
    let ((what, about), unit, without, left, _) =
        kinds.into_iter().find(|(.., without, left, least)| *left > without + least)?;
    let message = format!(
        "the tables would increase the error: the {what} is off{about} by {} {unit} without them and by {} {unit} with them over {where_}, most at {}",
        significant(without),
        significant(left),
        checked.worst
    );
    let help = "nothing was written; take another --scheme (auto tries them all; own cannot correct an axis as a function of another one), --orientation off \
                where the direction gets worse, the --tool that is used, a --range as large as the use";
    Some(Diagnostic::nowhere(Code::TABLES_MAKE_WORSE, message, help))
}

/// The sentence about the mean shift of all positions by tables, to which a zero that was touched without them does not fit; `None` if it is below a micrometer.
#[must_use]
pub fn shifted(checked: &TablesCheck) -> Option<String> {
    /// Shift that a touched zero does not show, µm: the resolution of an edge finder.
    const UNSEEN_UM: f64 = 1.0;
    checked.shift_um.iter().any(|shift| shift.abs() >= UNSEEN_UM).then_some(())?;
    let [x, y, z] = checked.shift_um.map(significant);
    Some(format!(
        "these tables shift all positions by X {x} Y {y} Z {z} um in the mean: after loading them, touch off every zero again"
    ))
}

/// The axes with direction-dependent errors for which the format has no tables.
fn plays(task: &Task<'_>) -> Vec<String> {
    let has_play = |axis: &Axis| task.target.model.features(*axis).backlash;
    let is_left = !task.format.can_hold(Holds::Senses);
    task.region.axes().filter(has_play).filter(|_| is_left).map(|axis| axis.to_string()).collect()
}

/// Advice if no scheme fits the format.
const OTHER_FORMAT: &str = "try another --format";

/// Advice for a stated scheme.
const ANOTHER: &str = "try --scheme auto, which takes a scheme that the format holds";

/// Returns the advice for `--scheme auto`: the tolerance that the best of the tried schemes reaches.
fn larger(tried: &[TriedScheme]) -> String {
    match tried.iter().filter_map(|one| one.rms_um).min_by(f64::total_cmp) {
        Some(rms_um) => format!("try --tolerance {:.2}um or larger", (rms_um / scheme::AIM * 100.0).ceil() / 100.0),
        None => "try a larger --tolerance".to_owned(),
    }
}

/// The help text for tables that do not fit.
fn help(task: &Task<'_>, advice: &str) -> String {
    let mut help = format!("ncfix tables --list shows what each format holds; {advice}");
    if task.target.machine.axes.iter().flatten().any(|data| data.axis.is_rotary()) {
        help += "; --orientation six-rows or off asks for less of the rotary axes, --range for a part of the travel";
    }
    let plays = plays(task).join(" ");
    if !plays.is_empty() {
        help += &format!(
            "; the error that depends on the direction of {plays} remains: use the control's backlash parameter, or a format with directions"
        );
    }
    help
}

/// The machine data of the backlash, with their values.
fn settings(task: &Task<'_>) -> String {
    let rows = reversals(task);
    let words = |text: String| text.split_whitespace().collect::<Vec<_>>().join(" ");
    rows.iter().flat_map(ReversalRow::settings).map(words).collect::<Vec<_>>().join("; ")
}

/// The reason for all-zero tables, and the help text.
fn idle(checked: &TablesCheck, task: &Task<'_>) -> (String, String) {
    let before = checked.before;
    let is_nothing = |um: f64, urad: f64| um < 1e-3 && urad < 1e-3;
    if is_nothing(before.max_um, before.tilt_max_urad) {
        return ("the model has no errors that tables correct".into(), "calibrate the machine first".into());
    }
    let left = format!("{} µm RMS", significant(before.rms_um));
    let plays = plays(task).join(" ");
    if !plays.is_empty() {
        let why = format!("all values would be 0: the {left} depend only on the direction of motion of {plays}");
        let help = format!(
            "{} has no tables for a direction of motion: enter the backlash in the control's backlash parameter ({}), or choose cec, comp, ssfk or heidenhain",
            task.format.title,
            settings(task)
        );
        return (why, help);
    }
    if before.rms_um <= um_from_mm(task.tolerance_mm) {
        let why =
            format!("all values would be 0: the tip is off by {left} without tables, which is within the tolerance");
        return (why, "choose a smaller --tolerance, or use no tables".into());
    }
    let why = format!("all values would be 0 in the digits of {}, and the tip is off by {left}", task.format.title);
    (why, help(task, "try another --scheme or --format"))
}

/// `0.95 µm, 5 % below the tolerance`
fn aim(tolerance_mm: f64) -> String {
    let below = (1.0 - scheme::AIM) * 100.0;
    let aim = format!("{:.9}", um_from_mm(scheme::AIM * tolerance_mm));
    format!("{} µm, {below:.0} % below the tolerance", aim.trim_end_matches('0').trim_end_matches('.'))
}

/// `free with 33 points has a residual of 4.20 µm`
fn said(tried: &TriedScheme) -> String {
    match (&tried.reason, tried.rms_um) {
        (Some(reason), _) => format!("{}: {reason}", tried.scheme),
        (None, rms) => {
            format!("{} with {} points has a residual of {:.2} µm", tried.scheme, tried.points, rms.unwrap_or(f64::NAN))
        }
    }
}
