//! What another crate adds to the registries: an error source, a kind of motion error, a cause and an instrument, by public names alone.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_dnc::sense::source::{OpenedSource, Polled, SourcePlan, Wanted, polled};
use ncfix_dnc::sense::{Config, Panel, ReadingOutlet, SensorSource, SensorSources, SourceReport};
use ncfix_machine::machine::edit::{Edit, Given};
use ncfix_machine::machine::file::{DEMO, Section};
use ncfix_machine::machine::{Condition, Machine, State};
use ncfix_metrology::calibrate::{FitOptions, Parameter, fit};
use ncfix_metrology::diagnose::cause::{self, Candidate, Cause, Correctable, EffectKind as CauseEffect, Weight};
use ncfix_metrology::diagnose::extend::{Anchor, Change, again, extension};
use ncfix_metrology::diagnose::fault::{self, Checks, DataDefect, DefectCheck, DefectKind, Then};
use ncfix_metrology::diagnose::scene::{Scene, Through};
use ncfix_metrology::diagnose::{Causes, diagnose_with};
use ncfix_metrology::measure::data::{self, DataSet, Observation, ReadAs};
use ncfix_metrology::measure::kind::{self, Equation, Instrument, Instruments, Measurand, Seen};
use ncfix_model::motion::{Entry, EntryFunction, MotionFunction, MotionKind};
use ncfix_model::preset::Preset;
use ncfix_model::source::{MachineFileReading, Parameter as SourceParameter, WrittenAt};
use ncfix_model::{
    Accumulator, Effect, ErrorModel, ErrorSource, Model, ModelRegisters, Solve, SourceInfo, Sources, file, write,
};
use ncfix_tables::tables::{FORMATS, Format, Formats, SCHEMES, Scheme, Schemes, format};

use crate::model::Random;

#[path = "../examples/own_cause.rs"]
mod own_cause;
#[path = "../examples/own_detector.rs"]
mod own_detector;
#[path = "../examples/own_error_source.rs"]
mod own_error_source;

#[test]
fn the_examples_run() {
    own_error_source::main().unwrap();
    own_cause::main().unwrap();
    own_detector::main().unwrap();
}

static BEAM: SourceInfo = SourceInfo {
    name: "beam",
    title: "sag of a beam on two supports",
    sections: &["beam"],
    example: "[[beam]]\naxis = \"X\"\nfrom_mm = 0\nto_mm = 700\nmid_um = -12\n",
};

struct Beams;

impl ErrorSource for Beams {
    fn info(&self) -> &'static SourceInfo {
        &BEAM
    }

    fn read(&self, reading: &mut MachineFileReading<'_, '_>, errors: &mut ErrorModel) {
        for (entry, mut section) in reading.root.sections("beam").into_iter().enumerate() {
            let axis = section.required("axis", "\"X\"", Section::text).map(str::to_owned);
            let [from, to, mid] =
                ["from_mm", "to_mm", "mid_um"].map(|key| section.required(key, "100", Section::number));
            section.finish(reading.findings);
            if let (Some(axis), Some(from), Some(to), Some(mid)) = (axis, from, to, mid) {
                let sag = Sag { span_mm: [from, to], mid_mm: mid / 1000.0 };
                errors.effects.push(Box::new(Beam { entry, axis, sag }));
            }
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Beam {
    entry: usize,
    axis: String,
    sag: Sag,
}

impl Effect for Beam {
    fn source(&self) -> &'static SourceInfo {
        &BEAM
    }

    fn label(&self) -> String {
        format!("EZ{}", self.axis)
    }

    fn contribute(&self, _: &Condition, sum: &mut Accumulator<'_>) {
        sum.add_motion(self.label().parse().unwrap(), &EntryFunction::Own(self.sag.clone().into()), 1.0);
    }

    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&SourceParameter<'_>, &mut f64)) {
        let written = Some(WrittenAt { entry: self.entry, key: "mid_um", factor: 1000.0 });
        let name = format!("beam.{}.mid", self.axis);
        visit(&SourceParameter { name: &name, is_linear: true, written }, &mut self.sag.mid_mm);
    }
}

/// 16 f u² (1 − u)² at the share u of the span.
#[derive(Clone, Debug, PartialEq)]
struct Sag {
    span_mm: [f64; 2],
    mid_mm: f64,
}

fn shape([from, to]: [f64; 2], at: f64) -> f64 {
    let u = ((at - from) / (to - from)).clamp(0.0, 1.0);
    16.0 * (u * (1.0 - u)).powi(2)
}

impl MotionFunction for Sag {
    fn kind(&self) -> &'static str {
        "sag"
    }

    fn value(&self, axis: Axis, command: &AxisVector, _: &State) -> f64 {
        self.mid_mm * shape(self.span_mm, command[axis])
    }

    fn visit_values(&mut self, visit: &mut dyn FnMut(&str, &mut f64)) {
        visit("mid", &mut self.mid_mm);
    }
}

/// The same as a kind of motion error: `kind = "sag"`.
struct SagKind;

impl MotionKind for SagKind {
    fn name(&self) -> &str {
        "sag"
    }

    fn read(&self, entry: &mut Entry<'_>) -> Option<EntryFunction> {
        let span = entry.positions("span")?;
        let mid_mm = entry.deviation("mid")?;
        let &[from, to] = span.as_slice() else { return None };
        Some(EntryFunction::Own(Sag { span_mm: [from, to], mid_mm }.into()))
    }

    fn example(&self) -> &str {
        "component = \"EZX\"\nkind = \"sag\"\nspan_mm = [0, 700]\nmid_um = -12\n"
    }
}

fn read(text: &str, registers: &ModelRegisters) -> (Option<(Machine, ErrorModel)>, Vec<String>) {
    let source = Source::new(FileId(0), "machine.toml", text.as_bytes().to_vec()).unwrap();
    let (loaded, findings) = file::load_with(&source, registers);
    (loaded, findings.iter().map(|finding| format!("{} {}", finding.code.as_str(), finding.message)).collect())
}

fn with_beams() -> ModelRegisters {
    ModelRegisters::default().with_source(Beams)
}

/// The machine of the examples without errors of its own.
fn bare(more: &str) -> String {
    let end = DEMO.find("[location]").unwrap();
    format!("{}{more}", &DEMO[..end])
}

fn at_x(x: f64) -> AxisVector {
    let mut command = AxisVector::ZERO;
    command[Axis::X] = x;
    command
}

#[test]
fn a_section_of_a_source_that_is_registered_is_read_and_another_is_unknown() {
    let text = bare(BEAM.example);
    let (loaded, findings) = read(&text, &with_beams());
    assert!(findings.is_empty(), "{findings:?}");
    let (machine, errors) = loaded.unwrap();
    assert_eq!(errors.sources().iter().map(|source| source.name).collect::<Vec<_>>(), ["beam"]);
    let shown = ncfix_report::machine::table(&machine, &errors);
    assert!(shown.contains(&format!("{:<12}{:<34}{:>3}: EZX", BEAM.name, BEAM.title, 1)), "{shown}");
    let (loaded, findings) = read(&text, &ModelRegisters::default());
    assert!(loaded.is_none() && findings[0].starts_with("E0402 unknown key beam"), "{findings:?}");
    // What is wrong in the section is reported with the rest.
    let wrong = text.replace("from_mm = 0", "form_mm = 0");
    let (loaded, findings) = read(&wrong, &with_beams());
    assert!(loaded.is_none());
    assert_eq!(findings.len(), 2, "{findings:?}");
}

#[test]
fn its_errors_are_predicted_and_corrected() {
    let (machine, errors) = read(&bare(BEAM.example), &with_beams()).0.unwrap();
    let (model, tool, state) = (Model::new(&machine, &errors), Vector::zeros(), State::default());
    // X carries the workpiece: where it sags, the tool is above it. Quarter: 16 · (3/16)² = 9/16.
    for (x, um) in [(0.0, 0.0), (175.0, 12.0 * 9.0 / 16.0), (350.0, 12.0), (700.0, 0.0)] {
        let off = model.deviation(&at_x(x), &tool, &state).translation;
        assert!((off.z * 1e3 - um).abs() < 1e-9 && off.x.abs() < 1e-12, "{x}: {off:?}");
        let solved = model.solve(&at_x(x), &tool, &state, &at_x(x), Solve::Full).unwrap();
        assert!((solved[Axis::Z] + um / 1e3).abs() < 1e-9, "{x}: {solved:?}");
    }
    // Two bends of the beam need pieces of a good part of its length.
    assert!((50.0..200.0).contains(&model.features(Axis::X).length));
}

#[test]
fn its_parameters_have_names_and_are_written_back() {
    let text = bare(BEAM.example);
    let (_, errors) = read(&text, &with_beams()).0.unwrap();
    let mut changed = errors.clone();
    assert!(errors == changed);
    let all = ncfix_metrology::calibrate::effect::effect_parameters(&errors);
    assert_eq!(all.iter().map(|one| one.name()).collect::<Vec<_>>(), ["beam.X.mid"]);
    Parameter::from(all[0].clone()).set(&mut changed, -0.0155);
    assert!(errors != changed);
    let written = write::write(&text, &errors, &changed).unwrap();
    assert_eq!(written, text.replace("mid_um = -12", "mid_um = -15.5"));
}

#[test]
fn a_section_that_is_no_list_is_written_back_too() {
    let mut edit = Edit::parse("[beam]\nmid_um = 3 # so far\n").unwrap();
    assert!(
        edit.set_at("beam", 0, "mid_um", &Given::Number(4.5)) && !edit.set_at("beam", 1, "mid_um", &Given::Whole(1))
    );
    assert_eq!(edit.text(), "[beam]\nmid_um = 4.5 # so far\n");
}

#[test]
fn a_change_adds_to_a_single_section_or_writes_it() {
    let change = Change::Section { section: "overhang", amounts: vec![("sag_um", -2.5)] };
    let texts = [
        ("[overhang]\nsag_um = 10.0 # of May\n", "[overhang]\nsag_um = 7.5 # of May\n"),
        ("", "[overhang]\nsag_um = -2.5\n"),
    ];
    for (before, after) in texts {
        let mut edit = Edit::parse(before).unwrap();
        assert_eq!(change.make(&mut edit).unwrap(), Anchor::Key("overhang", "sag_um".into()));
        assert_eq!(edit.text(), after);
    }
}

static ONE_SQUARENESS: Preset = Preset {
    name: "one squareness",
    title: "squareness of X to Y",
    source: "ISO 230-1:2012",
    parameters: |_| Ok(vec!["EC0X".parse().unwrap()]),
};

#[test]
fn a_preset_that_is_registered_is_fitted_and_another_is_no_parameter() {
    use ncfix::{Calibration, CalibrationOptions, Registry};
    let file = crate::support::repository("samples/machines/demo.toml");
    let data = [ncfix::DataSet::read(crate::support::repository("samples/measurements/ball_bar.csv")).unwrap()];
    let mut options = CalibrationOptions::default();
    options.parameters = vec![ONE_SQUARENESS.name.into()];
    let machine = ncfix::Machine::from_file_with(&file, &Registry::default().with_preset(&ONE_SQUARENESS)).unwrap();
    let fitted = Calibration::run(&machine, &data, &options).unwrap();
    assert_eq!(fitted.parameters().iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), ["EC0X"]);
    let without = ncfix::Machine::from_file(&file).unwrap();
    assert!(Calibration::run(&without, &data, &options).unwrap_err().to_string().contains("one squareness"));
}

#[test]
fn a_kind_of_motion_errors_is_read_like_those_that_are_built_in() {
    let text = bare(&format!("[[motion]]\n{}", SagKind.example()));
    let registers = ModelRegisters::default().with_motion_kind(SagKind);
    let (loaded, findings) = read(&text, &registers);
    assert!(findings.is_empty(), "{findings:?}");
    let (machine, errors) = loaded.unwrap();
    let model = Model::new(&machine, &errors);
    let off = model.deviation(&at_x(350.0), &Vector::zeros(), &State::default()).translation;
    assert!((off.z - 0.012).abs() < 1e-12, "{off:?}");
    let doubled = errors.motion[0].function.scaled(2.0);
    assert_eq!(doubled.value(Axis::X, &at_x(350.0), &State::default()), -0.024);
    assert!(doubled != errors.motion[0].function && doubled.scaled(0.0).is_zero());
    let (loaded, findings) = read(&text, &ModelRegisters::default());
    assert!(loaded.is_none() && findings[0].contains("unknown kind \"sag\""), "{findings:?}");
    // A load may have it too.
    let load = "[[load]]\ncomponent = \"EZX\"\nreference_N = 1000\nkind = \"sag\"\nspan_mm = [0, 700]\nmid_um = -12\n";
    let (loaded, findings) = read(&bare(load), &registers);
    assert!(findings.is_empty(), "{findings:?}");
    let names = ncfix_metrology::calibrate::effect::effect_parameters(&loaded.unwrap().1);
    assert_eq!(names[0].name(), "load.EZX.mid");
}

#[test]
fn a_name_or_a_section_of_another_is_refused() {
    let refused = |sources: Sources| sources.try_with(Beams).err().map(|refused| refused.0);
    assert_eq!(refused(Sources::default()), None);
    let twice = Sources::default().with(Beams);
    assert_eq!(refused(twice).unwrap(), "the error source \"beam\" already exists");
    struct Greedy;
    impl ErrorSource for Greedy {
        fn info(&self) -> &'static SourceInfo {
            static INFO: SourceInfo = SourceInfo { name: "greedy", title: "", sections: &["axis"], example: "" };
            &INFO
        }
        fn read(&self, _: &mut MachineFileReading<'_, '_>, _: &mut ErrorModel) {}
    }
    let refused = Sources::default().try_with(Greedy).unwrap_err();
    assert_eq!(refused.0, "error source \"greedy\": the section axis of the machine file belongs to another source");
}

static SAGS: Cause = Cause {
    name: "sagging beam",
    effect: CauseEffect::Own("beam-sag"),
    made_by: "the weight of what travels along it",
    shown_by: "a bow that is flat at both supports",
    separate_by: "another weight on the table",
    correctable: Correctable::Program,
    propose,
};

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for data in scene.machine.axes.iter().flatten().filter(|data| data.axis == Axis::X) {
        let (Some(span), Some(_)) = (data.travel, cause::range(scene, data.axis)) else { continue };
        let component = format!("EZ{}", data.axis).parse().unwrap();
        let axis = data.axis;
        let weight = Weight::new(move |row| shape(span, row.position[axis]));
        let one = Candidate::one(&SAGS, component, Through::Component(component), weight).driven_by(&[&axis]);
        out.push(one.written(move |amounts| {
            Ok(vec![Change::Entry {
                list: "beam",
                words: vec![("axis", axis.to_string())],
                keys: vec![("from_mm", Given::Number(span[0])), ("to_mm", Given::Number(span[1]))],
                amounts: vec![("mid_um", amounts[0] * 1000.0)],
            }])
        }));
    }
}

/// Heights along X over a beam that sags by 12 µm, with noise of 0.3 µm.
fn heights(machine: &Machine, seed: u64) -> DataSet {
    let mut random = Random(seed);
    let mut table = "X,Y,Z,dz_um\n".to_owned();
    for step in 0..=70 {
        let x = 10.0 * f64::from(step);
        let noise: f64 = (0..4).map(|_| 0.26 * random.symmetric()).sum();
        let _ = writeln!(table, "{x},250,100,{:.3}", 12.0 * shape([0.0, 700.0], x) + noise);
    }
    measured(&table, "kind = \"displacement\"\nsigma_um = 0.3\nfree = [\"offset\"]\n", machine)
}

fn measured(table: &str, description: &str, machine: &Machine) -> DataSet {
    let source = |id, text: &str| Source::new(FileId(id), "data", text.as_bytes().to_vec()).unwrap();
    let description = source(1, &format!("[measurement]\n{description}"));
    let instruments = Instruments::default().with(&GAUGE);
    let (data, findings) =
        data::load_with(&instruments, [&source(0, table), &description], "data", machine, ReadAs::Readings);
    assert!(findings.is_empty(), "{findings:?}");
    data.unwrap()
}

#[test]
fn a_cause_is_named_and_its_term_written_fitted_and_read_again() {
    let text = bare("");
    let (machine, errors) = read(&text, &with_beams()).0.unwrap();
    let sets = [heights(&machine, 1), heights(&machine, 2)];
    let scene = Scene::new(&machine, &errors, &sets).unwrap();
    let causes = Causes::default().with(&SAGS);
    let found = diagnose_with(&causes, &scene, &scene, 1, &mut |_, _| {});
    let [one] = found.findings.as_slice() else { panic!("{:?}", found.findings) };
    let candidate = &one.candidate;
    assert_eq!((candidate.cause.name, candidate.parameter.as_str()), ("sagging beam", "EZX"));
    assert_eq!(candidate.cause.effect.to_string(), "beam-sag");
    assert!((one.size.value.abs() - 12.0).abs() < 0.3 && one.size.unit == "um", "{:?}", one.size);
    assert!(found.held_out.as_ref().unwrap().gain.0 > 0.8);
    assert!(found.causes.iter().any(|tried| tried.cause.name == "sagging beam" && tried.candidates == 1));
    let changes = extension(&found, &scene, 1).remove(0).unwrap();
    let mut edit = Edit::parse(&text).unwrap();
    for change in &changes {
        change.make(&mut edit).unwrap();
    }
    let grown = edit.text();
    let (_, extended) = read(&grown, &with_beams()).0.unwrap();
    let parameters = again(&errors, &extended, &changes);
    assert_eq!(parameters.iter().map(ToString::to_string).collect::<Vec<_>>(), ["beam.X.mid"]);
    let fitted = fit(&machine, &extended, &parameters, &sets, FitOptions { robust: true }).unwrap();
    assert!((parameters[0].get(&fitted.errors) + 0.012).abs() < 2e-4);
    let written = write::write(&grown, &extended, &fitted.errors).unwrap();
    let (_, last) = read(&written, &with_beams()).0.unwrap();
    assert!((parameters[0].get(&last) - parameters[0].get(&fitted.errors)).abs() < 1e-9);
    // The same again adds to the entry.
    changes[0].make(&mut edit).unwrap();
    assert_eq!(edit.text().matches("[[beam]]").count(), 1);
    let (_, doubled) = read(&edit.text(), &with_beams()).0.unwrap();
    let [once, twice] = [&extended, &doubled].map(|errors| parameters[0].get(errors));
    assert!((twice - 2.0 * once).abs() < 2e-9, "{once} {twice}");
    // At another place it is another entry.
    let Change::Entry { list, words, amounts, .. } = changes[0].clone() else { panic!("{changes:?}") };
    let keys = vec![("from_mm", Given::Number(0.0)), ("to_mm", Given::Number(350.0))];
    Change::Entry { list, words, amounts, keys }.make(&mut edit).unwrap();
    assert_eq!(edit.text().matches("[[beam]]").count(), 2);
}

/// A gauge that reads the height of the tool above the table alone.
static GAUGE: Instrument = Instrument {
    name: "height",
    title: "height of the tool above the table",
    measurand: Measurand::Other,
    free: &[],
    read: |_, row, sign, observation| {
        let column = kind::needed(row, "height_um")?;
        observation.values[0] = kind::optional(row, Some(column), sign)?.map(|um| um / 1000.0);
        Ok(())
    },
    check: |_, _, _| {},
    unknowns: |_| Vec::new(),
    start: kind::zeros,
    equations: height,
    ties: kind::no_ties,
    temperature: None,
    columns: &["height_um"],
};

fn height(_: &DataSet, one: &Observation, seen: &Seen<'_>, _: &[f64], out: &mut Vec<Equation>) {
    if let Some(read) = one.values[0] {
        let residual = read - seen.displacement().z;
        out.push(Equation { residual, by_tip: seen.direction(2), ..Equation::default() });
    }
}

#[test]
fn an_instrument_is_read_and_fitted() {
    let (machine, errors) = read(&bare(BEAM.example), &with_beams()).0.unwrap();
    let mut table = "X,Y,Z,height_um\n".to_owned();
    for step in 0..=20 {
        let x = 35.0 * f64::from(step);
        let _ = writeln!(table, "{x},0,0,{:.6}", 20.0 * shape([0.0, 700.0], x));
    }
    let set = measured(&table, "kind = \"height\"\nsigma_um = 0.3\n", &machine);
    let parameter = Parameter::from(ncfix_metrology::calibrate::effect::effect_parameters(&errors).remove(0));
    let fitted =
        fit(&machine, &errors, std::slice::from_ref(&parameter), &[set], FitOptions { robust: false }).unwrap();
    assert!((parameter.get(&fitted.errors) + 0.020).abs() < 1e-8);
}

/// Rows beyond a place are the ones of another part.
static BEYOND: DefectCheck = DefectCheck {
    name: "beyond the part",
    made_by: "a plan that went too far",
    shown_by: "X above 600 mm",
    source: "the shop",
    look: |view, out| {
        for (set, data) in view.sets() {
            let is_beyond = |one: &Observation| one.reading.position[Axis::X] > 600.0;
            let Some(first) = data.observations.iter().position(is_beyond) else { continue };
            let rows = [first, data.observations.len() - 1];
            let (what, evidence) = ("rows beyond the part".into(), format!("from row {first} on"));
            out.push(DataDefect {
                kind: DefectKind::Own("beyond"),
                set,
                name: data.name.clone(),
                what,
                rows,
                evidence,
                then: Then::WithoutRows,
            });
        }
    },
};

#[test]
fn a_fault_of_the_data_is_found() {
    let (machine, errors) = read(&bare(""), &ModelRegisters::default()).0.unwrap();
    let sets = [heights(&machine, 3)];
    let scene = Scene::new(&machine, &errors, &sets).unwrap();
    let found = |checks: &Checks| -> Vec<[usize; 2]> {
        let all = fault::find_with(checks, &scene);
        all.iter().filter(|one| one.kind == DefectKind::Own("beyond")).map(|one| one.rows).collect()
    };
    assert_eq!(found(&Checks::default().with(&BEYOND)), [[61, 70]]);
    assert!(found(&Checks::default()).is_empty());
}

static SHOP: Format = Format { name: "shop", is_mine: |name, _| name.ends_with(".shop"), ..FORMATS[0] };

#[test]
fn a_table_format_and_a_scheme_are_found() {
    let formats = Formats::default().with(&SHOP);
    assert_eq!(format::guess_with(&formats, "a.shop", b"").map(|one| one.name), Some("shop"));
    assert!(format::guess("a.shop", b"").is_none());
    static UPPER: Format = Format { name: "SHOP", ..FORMATS[0] };
    assert!(formats.try_with(&UPPER).is_err());
    static PLAIN: Scheme = Scheme { name: "plain", ..SCHEMES[0] };
    assert_eq!(Schemes::default().with(&PLAIN).iter().count(), SCHEMES.len() + 1);
}

/// A sensor that always says the same.
struct Constant;

#[derive(Debug)]
struct Always(f64, Vec<usize>);

impl SensorSource for Constant {
    fn name(&self) -> &str {
        "constant"
    }

    fn title(&self) -> &str {
        "a number that stays"
    }

    fn read(&self, section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
        let value = section.required("value", "21.5", Section::number)?;
        Some(Arc::new(Always(value, wanted.iter().map(|one| one.index).collect())))
    }
}

impl SourcePlan for Always {
    fn open(&self, _: &Path, every: Duration) -> Result<OpenedSource, String> {
        Ok(polled(Always(self.0, self.1.clone()), every))
    }
}

impl Polled for Always {
    fn poll(&mut self, outlet: &ReadingOutlet) -> Result<(), String> {
        self.1.iter().for_each(|&channel| outlet.tell(channel, SourceReport::Value(self.0), None));
        Ok(())
    }
}

#[test]
fn a_source_of_readings_is_read_and_asked() {
    let text = "poll_s = 0.05\n[source.own]\nkind = \"constant\"\nvalue = 21.5\n[channel.T_a]\nsource = \"own\"\n";
    let source = Source::new(FileId(0), "S.toml", text.as_bytes().to_vec()).unwrap();
    assert!(Config::read(&source).is_err());
    let config = Config::read_with(&source, &SensorSources::default().with(Constant)).unwrap();
    assert_eq!(config.sources[0].kind.title(), "a number that stays");
    let mut panel = Panel::open(&config, Path::new(".")).unwrap();
    let begun = Instant::now();
    let mut last = None;
    // Three values that agree are believed.
    while last.is_none() && begun.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(25));
        panel.take(begun.elapsed());
        last = panel.channels().find_map(|reading| reading.value_c);
    }
    assert_eq!(last, Some(21.5));
}

#[test]
fn a_machine_of_the_library_keeps_its_registry() {
    let registry = ncfix::Registry::default().with_source(Beams).with_cause(&SAGS).with_instrument(&GAUGE);
    let text = bare(BEAM.example);
    let machine = ncfix::Machine::from_text_with("mill.toml", &text, &registry).unwrap();
    let error = machine.deviation(&at_x(350.0), ncfix::ToolVector::Length(0.0), &State::default());
    assert!((error.position_um[2] - 12.0).abs() < 1e-9, "{error:?}");
    assert!(machine.registry().causes.find("sagging beam").is_some());
    let refused = ncfix::Machine::from_text("mill.toml", &text).unwrap_err();
    assert!(refused.diagnostics().errors().any(|one| one.message().contains("unknown key beam")));
}
