//! What cannot be told is judged on exact poses, said in few sentences with what to do, and left out on request.

use ncfix_base::geometry::Vector;
use ncfix_machine::machine::{Condition, Load};
use ncfix_metrology::calibrate::effect::effect_parameters;
use ncfix_metrology::calibrate::{FitError, FitOptions, Lost, Parameter, fit, identify, reduce};
use ncfix_model::ErrorModel;

use crate::calibrate::{Bench, circles, cubic, lines, named, rumba, samba};
use crate::calibrate_effects::three_axes;
use crate::model::{Random, machine};

/// The full cubic model on Tables 5-3 and 4-1: Esmaeili 2021 has 81 and 84 coefficients of the machine, 83 without the scale bar.
fn tables() -> [(Bench, usize); 3] {
    let vertical = || cubic(&machine("wCBXFZYSt"));
    [(rumba(cubic(&machine("wCAYFXZSt"))), 81), (samba(vertical(), true), 84), (samba(vertical(), false), 83)]
}

/// Probings of a machine with errors of 30 µm, 1 µm of noise and whole increments: what depends on each other exactly does so to 1e-4 only, and
/// is not taken for told.
#[test]
fn errors_of_the_machine_tell_nothing() {
    for (bench, expected) in tables() {
        let (mut data, _) = bench.measured(1e-3, 0.0, &mut Random(5));
        for position in data.iter_mut().flat_map(|set| &mut set.observations).map(|row| &mut row.reading.position.0) {
            position.iter_mut().take(3).for_each(|mm| *mm = (*mm * 1000.0).round() / 1000.0);
        }
        let found = identify(&bench.machine, &ErrorModel::default(), &bench.parameters, &data).unwrap();
        assert_eq!(found.machine_rank, expected);
        let gap = found.singular_values[found.rank - 1] / found.singular_values[found.rank];
        assert!(gap > 1e5, "{gap:e}");
        // The fit judges the same, and from whatever it begins.
        let fault = fit(&bench.machine, &bench.errors, &bench.parameters, &data, FitOptions { robust: true });
        let Some(FitError::NotIdentified(lost)) = fault.err() else { panic!("{expected} were told") };
        assert_eq!(lost.leave_out.len(), 122 - expected);
    }
    // The bar at its length, but for contouring errors.
    let mut bench = circles(24, &[1.0]);
    bench.parameters = named("EXX1 EYY1 EZZ1");
    let mut random = Random(2);
    for position in bench.data[0].observations.iter_mut().map(|row| &mut row.reading.position.0) {
        position.iter_mut().take(3).for_each(|mm| *mm += 0.02 * random.symmetric());
    }
    assert_eq!(bench.lost().len(), 1, "the length and all gains");
}

/// A load that makes X longer by 10⁻⁴ lies on the table in all rows: what is told of the geometry is the same to the last digit, although bar and
/// gains look different by 30 µm. Its own coefficient is told from the length of the bar no better than the gain of X.
#[test]
fn effects_of_the_start_tell_nothing() {
    let text = "[[load]]\ncomponent = \"EXX\"\nreference_N = 1000\nalong = \"Y\"\narm_mm = 1e6\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n";
    let (_, heavy) = crate::calibrate_effects::machine(&three_axes(text));
    let mut bench = circles(24, &[1.0]);
    let mut condition = Condition::default();
    condition.add_load(Load { force_n: 1000.0, position_mm: Vector::zeros() });
    bench.data.iter_mut().for_each(|set| set.fill_in(&condition));
    let judge = |start: &ErrorModel, parameters: &[Parameter]| {
        identify(&bench.machine, start, parameters, &bench.data).unwrap()
    };
    let gains: Vec<Parameter> = named("EXX1 EYY1 EZZ1").into_iter().map(Parameter::from).collect();
    let (with, without) = (judge(&heavy, &gains), judge(&ErrorModel::default(), &gains));
    assert_eq!(with.singular_values, without.singular_values);
    assert_eq!((with.lost.leave_out.len(), with.lost), (1, without.lost));
    let load = effect_parameters(&heavy).into_iter().find(|one| one.name() == "load.EXX.coefficients[1]").unwrap();
    let found = judge(&heavy, &[gains.as_slice(), &[Parameter::from(load.clone())]].concat());
    assert_eq!(found.lost.leave_out.len(), 2, "{:?}", found.lost);
    assert!(found.lost.leave_out.contains(&Parameter::from(load)));
    assert!(found.lost.confused.iter().any(|one| one.sentence.ends_with("; there was only one load")));
}

#[test]
fn a_reduced_model_is_what_can_be_told() {
    for (bench, expected) in tables() {
        let (data, _) = bench.measured(1e-3, 0.0, &mut Random(5));
        let reduced = reduce(&bench.machine, &ErrorModel::default(), &bench.parameters, &data).unwrap();
        assert_eq!(reduced.parameters.len(), expected);
        let left_out: Vec<_> = reduced.left_out.iter().flat_map(|one| one.parameters.clone()).collect();
        assert_eq!(left_out.len(), 122 - expected);
        assert!(
            bench
                .parameters
                .iter()
                .copied()
                .map(Parameter::from)
                .all(|name| left_out.contains(&name) != reduced.parameters.contains(&name))
        );
        let found = identify(&bench.machine, &ErrorModel::default(), &reduced.parameters, &data).unwrap();
        assert_eq!((found.lost.leave_out.len(), found.rank), (0, found.columns.len()));
        let fit = fit(&bench.machine, &ErrorModel::default(), &reduced.parameters, &data, FitOptions { robust: false });
        // What was left out is in the others: the readings are said to the noise all the same.
        let fit = fit.unwrap();
        let squares: f64 = fit.residuals.iter().map(|(_, _, residual, _)| residual * residual).sum();
        let sigma = (squares / fit.freedom as f64).sqrt();
        assert!((sigma / 1e-3 - 1.0).abs() < 0.25, "{expected}: {sigma}");
    }
}

/// Of parameters of which one is the sum of others the least simple one goes, and location errors stay.
#[test]
fn the_least_simple_parameter_goes() {
    let left_out = |bench: &Bench| -> Vec<String> {
        let reduced = reduce(&bench.machine, &ErrorModel::default(), &bench.parameters, &bench.data).unwrap();
        reduced.left_out.iter().flat_map(|one| &one.parameters).map(ToString::to_string).collect()
    };
    let mut bench = circles(24, &[1.0, -1.0]);
    // Squareness is a straightness of degree 1, a constant is a place of the ball, a gain is the length.
    for (names, gone) in [
        ("EC0Y EXY1", "EXY1"),
        ("EXY1 EC0Y", "EXY1"),
        ("EXX1 EYY1 EZZ1", "EZZ1"),
        ("EZZ1 EXX1 EYY1", "EYY1"),
        ("EXX0 EXX2", "EXX0"),
        ("EXX1@-1000 EXX2 EXX1", "EXX1@-1000"),
    ] {
        bench.parameters = named(names);
        assert_eq!(left_out(&bench), [gone], "{names}");
    }
}

#[test]
fn what_cannot_be_told_is_said_in_few_sentences() {
    let lost = |bench: &Bench| -> Lost {
        identify(&bench.machine, &ErrorModel::default(), &bench.parameters, &bench.data).unwrap().lost
    };
    // A laser on X with one tool; Y and Z stand still.
    let mut bench = lines();
    bench.data[0].setups.truncate(1);
    bench.data[0].targets.truncate(1);
    bench.data[0].observations.retain(|row| row.setup == 0 && row.target == Some(0));
    bench.parameters = named("EXX0 EXX1 EXX2 EXX3 EBX1 EBX2 ECX1 ECX2 EYX1 EYX2 EXY1 EXY2 EXY3 EAZ1 EYY1");
    let found = lost(&bench);
    let said: Vec<(&str, &str)> =
        found.confused.iter().map(|one| (one.sentence.as_str(), one.remedy.as_str())).collect();
    assert_eq!(said.len(), 6, "{said:#?}");
    let has = |sentence: &str, remedy: &str| {
        assert!(said.iter().any(|(one, what)| one.starts_with(sentence) && what.starts_with(remedy)), "{said:#?}");
    };
    has(
        "EBX1, EBX2, ECX1 and ECX2 are not separable from EXX1 and EXX2; all measurements have one tool vector",
        "measure the same with a second tool vector",
    );
    has(
        "EXY1, EXY2 and EXY3 are not separable from the zero of the instrument; Y was at 1 position; at least 4 are needed",
        "measure at 4 or more positions of Y, or leave them out of the model",
    );
    has(
        "EYX1 and EYX2 have no effect on the measurements",
        "measure where they would have an effect, or leave them out of the model",
    );
    has("EXX0 is not separable from zero of EXX", "leave it out of the model: the set-up absorbs constant parts");
    assert_eq!(found.leave_out.len(), 15 - 3, "EXX1, EXX2 and EXX3 can be told");
    // Truncated powers where the axis never was are named by the first and the last.
    let mut bench = circles(24, &[1.0, -1.0]);
    let knots: Vec<String> = (6..20).map(|k| format!("EXX2@{}", 50 * k)).collect();
    bench.parameters = named(&format!("EXX2 {}", knots.join(" ")));
    let found = lost(&bench);
    assert_eq!(found.confused.len(), 1, "{found:#?}");
    assert_eq!(
        found.confused[0].sentence,
        "EXX2@300 … EXX2@950 have no effect on the measurements; X did not move that far"
    );
    assert_eq!(found.confused[0].remedy, "measure further along X, or leave them out of the model");
}

/// Circles of a bar of unknown length on a machine with a swivel table that stands: the scale of Z is not separable from the length of the bar. No further angle
/// of the table would change that.
#[test]
fn an_unknown_bar_and_not_a_standing_table_hides_a_scale() {
    let machine = "[machine]\nname = \"m\"\ntopology = \"wCAYFXZSt\"\n\
        [axis.C]\ndirection = [0, 0, -1]\npoint_mm = [300, -198, -440]\nmodulo = true\n\
        [axis.A]\ndirection = [-1, 0, 0]\npoint_mm = [300, -210, -480]\ntravel_deg = [-120, 30]\n\
        [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-450, 50]\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 600]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-550, 0]\n";
    let mut shop = crate::support::Shop::new().file("m.toml", machine);
    for (name, plane) in [("xy", [0, 1]), ("yz", [1, 2]), ("zx", [2, 0])] {
        let mut rows = "run,setup,X,Y,Z,tool_z_mm,dr_um\n".to_owned();
        for k in 0..72 {
            let angle = f64::from(5 * k).to_radians();
            let mut at = [300.0, -200.0, -150.0];
            at[plane[0]] += 100.0 * angle.cos();
            at[plane[1]] += 100.0 * angle.sin();
            let noise = if k % 3 == 0 { 0.2 } else { -0.1 };
            rows += &format!("ccw,A,{:.6},{:.6},{:.6},-150,{noise}\n", at[0], at[1], at[2]);
        }
        let description = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\", \"length\"]\nsigma_um = 0.1\n[position]\nA_deg = 0\n\
            C_deg = 0\n[setup.A]\ncentre_mm = [300, -200, -300]\nlength_mm = 100\n";
        shop = shop.file(&format!("{name}.csv"), rows).file(&format!("{name}.toml"), description);
    }
    let run = shop.run("calibrate xy.csv yz.csv zx.csv --machine m.toml -o out.toml".split_whitespace()).exits(0);
    let said: Vec<&str> = run.stderr.split("warning[").filter(|one| one.contains("EZZ1 is not separable")).collect();
    assert!(said.len() == 1 && said[0].contains("give a calibrated length") && !said[0].contains("index"), "{said:?}");
    // The model has no scale of Z, so nothing shows it.
    assert!(shop.text("out.toml").contains("\"EZZ\""), "{}", shop.text("out.toml"));
}
