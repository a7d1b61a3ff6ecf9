//! Compensation tables: what each scheme leaves on machines of the literature.

use ncfix::machine::{Condition, Machine, State};
use ncfix::model::{Accumulator, ErrorModel, Model};
use ncfix::source::{FileId, Source};
use ncfix::tables::check::{Check, check};
use ncfix::tables::region::Region;
use ncfix::tables::scheme::{self, Task};
use ncfix::tables::{Control, Multiplication, Orientation, Tables, Wiring, format};

use crate::support::repository;

/// Poses of a check, and the start of their generator: none of a scheme's own.
const POSES: usize = 2000;
const SEED: u64 = 7;

pub(crate) struct Bench {
    pub(crate) machine: Machine,
    errors: ErrorModel,
}

impl Bench {
    pub(crate) fn of(text: &str) -> Bench {
        let source = Source::new(FileId(0), "machine.toml", text.as_bytes().to_vec()).unwrap();
        let (loaded, findings) = ncfix::model::file::load(&source);
        assert!(findings.iter().all(|one| !one.is_error()), "{findings:?}");
        let (machine, errors) = loaded.unwrap();
        Bench { machine, errors }
    }

    pub(crate) fn sample(name: &str) -> Bench {
        Bench::of(&std::fs::read_to_string(repository(&format!("samples/machines/{name}.toml"))).unwrap())
    }
}

struct Wish<'a> {
    scheme: &'a str,
    format: &'a str,
    points: usize,
    tolerance_um: f64,
    orientation: Orientation,
}

/// The tables of a scheme, and what they leave.
fn made(bench: &Bench, region: &Region, wish: &Wish<'_>) -> (Tables, Check) {
    let model = Model::new(&bench.machine, &bench.errors);
    let sum = Accumulator::sum(&bench.machine, &bench.errors, &Condition::default(), |_| true);
    let target = ncfix::tables::Target {
        machine: &bench.machine,
        model: &model,
        tool_mm: ncfix::geometry::Vector::new(0.0, 0.0, -100.0),
        orientation: wish.orientation,
    };
    let wiring = Wiring::of(&bench.machine);
    let task = Task {
        target,
        errors: &sum,
        region,
        points: wish.points,
        tolerance_mm: wish.tolerance_um / 1e3,
        multiplication: Multiplication::Instead,
        format: format::find(wish.format).unwrap(),
        wiring: &wiring,
    };
    let tables = scheme::find(wish.scheme).unwrap().tables(&task).unwrap();
    let check = check(&target, &Control::new(&bench.machine, &tables), &region.poses(POSES, SEED));
    (tables, check)
}

#[test]
fn probe_huron() {
    let bench = Bench::sample("esmaeili_huron");
    let region = Region::travel(&bench.machine).unwrap();
    for scheme in ["fik", "trigonometric", "polynomial", "free"] {
        let wish = Wish { scheme, format: "cec", points: 37, tolerance_um: 1.0, orientation: Orientation::Smooth };
        let started = std::time::Instant::now();
        let (tables, check) = made(&bench, &region, &wish);
        eprintln!(
            "{scheme}: {} tables {} entries; before {:.2} after {:.3} max {:.3} um; tilt {:.1} -> {:.1} (exact {:.1}) urad; {:?}",
            tables.count(),
            tables.entries(),
            check.before.mean_mm() * 1e3,
            check.tables.mean_mm() * 1e3,
            check.tables.max_mm() * 1e3,
            check.before.rms_rad() * 1e6,
            check.tables.rms_rad() * 1e6,
            check.exact.rms_rad() * 1e6,
            started.elapsed()
        );
    }
    let _ = State::default();
}
