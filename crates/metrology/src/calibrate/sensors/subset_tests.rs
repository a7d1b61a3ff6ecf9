//! The search against all subsets, and its speed.

use nalgebra::{DMatrix, DVector};

use super::subset::Products;

fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
}

/// Columns with common causes, as the sensors of a machine have, and values of these causes.
fn plant(rows: usize, columns: usize, own: f64, seed: &mut u64) -> (DMatrix<f64>, DVector<f64>) {
    let causes = DMatrix::from_fn(rows, 5, |_, _| random(seed));
    let mix = DMatrix::from_fn(5, columns, |_, _| random(seed));
    let noise = DMatrix::from_fn(rows, columns, |_, _| own * random(seed));
    let weights = DVector::from_fn(5, |_, _| random(seed));
    let values = &causes * weights + DVector::from_fn(rows, |_, _| 0.1 * random(seed));
    (causes * mix + noise, values)
}

fn products(columns: &DMatrix<f64>, values: &DVector<f64>) -> Products {
    let mut unit = columns.clone();
    unit.column_iter_mut().for_each(|mut column| {
        column.normalize_mut();
    });
    Products { columns: unit.tr_mul(&unit), values: unit.tr_mul(values), total: values.norm_squared() }
}

/// Residual of columns, from the singular values of the columns themselves.
fn left(columns: &DMatrix<f64>, values: &DVector<f64>, members: &[usize]) -> f64 {
    let part = columns.select_columns(members);
    let solution = part.clone().svd(true, true).solve(values, 1e-12).unwrap();
    (part * solution - values).norm_squared()
}

#[test]
fn it_is_the_best_of_all_subsets() {
    let mut seed = 3;
    for (count, own) in [(6, 0.3), (9, 0.05), (12, 0.2), (12, 1.0)] {
        let (columns, values) = plant(60, count, own, &mut seed);
        let found = products(&columns, &values).best(7, u64::MAX);
        assert_eq!(found.len(), 7.min(count));
        for (size, subset) in (1..).zip(&found) {
            assert!(subset.is_exact && subset.members.len() == size);
            let all = (0_u32..1 << count).filter(|mask| mask.count_ones() == size as u32);
            let best = all
                .map(|mask| (0..count).filter(|bit| mask & (1 << bit) != 0).collect::<Vec<_>>())
                .map(|members| left(&columns, &values, &members))
                .fold(f64::INFINITY, f64::min);
            let own = left(&columns, &values, &subset.members);
            assert!((subset.squares / best - 1.0).abs() < 1e-9 && own < best * (1.0 + 1e-9), "{count} {size}");
        }
    }
}

#[test]
fn steps_alone_would_miss_a_pair() {
    // Neither of the first two is informative alone, together they are the values; the third is the best single one.
    let mut seed = 5;
    let hidden = DVector::from_fn(50, |_, _| random(&mut seed));
    let values = DVector::from_fn(50, |_, _| random(&mut seed));
    let noisy = &values + DVector::from_fn(50, |_, _| 0.3 * random(&mut seed));
    let columns = DMatrix::from_columns(&[hidden.clone() * 9.0 + &values, hidden, noisy]);
    let found = products(&columns, &values).best(2, u64::MAX);
    assert_eq!((found[0].members.clone(), found[1].members.clone()), (vec![2], vec![0, 1]));
    assert!(found[1].squares < 1e-9);
}

#[test]
fn columns_that_depend_on_others_are_no_members() {
    let mut seed = 7;
    let (columns, values) = plant(40, 4, 0.5, &mut seed);
    let twice = DMatrix::from_columns(&[columns.column(0), columns.column(1), columns.column(0), columns.column(2)]);
    let all = products(&twice, &values);
    assert_eq!(all.rank(), 3);
    let found = all.best(4, u64::MAX);
    assert_eq!(found.len(), 3);
    assert!(!(found[2].members.contains(&0) && found[2].members.contains(&2)));
}

#[test]
fn a_search_that_is_given_up_says_so() {
    let mut seed = 9;
    let (columns, values) = plant(80, 30, 1.0, &mut seed);
    let found = products(&columns, &values).best(8, 10_000);
    assert!(found[0].is_exact && !found[7].is_exact && found[7].members.len() == 8);
}

#[test]
fn forty_sensors_and_nine_of_them() {
    let mut seed = 11;
    for own in [0.02, 0.3, 3.0] {
        let (columns, values) = plant(1440, 40, own, &mut seed);
        let started = std::time::Instant::now();
        let found = products(&columns, &values).best(9, 20_000_000_000);
        // Tens of milliseconds; visiting all 273 million subsets of nine would take far longer in a test build.
        assert!(started.elapsed().as_secs() < 20, "noise {own}: {:?}", started.elapsed());
        assert!(found.len() == 9 && found.iter().all(|subset| subset.is_exact));
        assert!(found.windows(2).all(|pair| pair[1].squares <= pair[0].squares));
    }
}
