use nalgebra::{DMatrix, DVector};

use super::*;

/// Lower triangle of the 1D Laplacian of n points plus `shift` I.
fn laplacian(n: usize, shift: f64) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    let (mut start, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for c in 0..n {
        rows.push(c);
        values.push(2.0 + shift);
        if c + 1 < n {
            rows.push(c + 1);
            values.push(-1.0);
        }
        start.push(rows.len());
    }
    (start, rows, values)
}

/// A solver of such a matrix, with the unknowns eliminated from the end, and its values.
fn chain(n: usize, shift: f64) -> (SparseSolver, Vec<f64>) {
    let (start, rows, values) = laplacian(n, shift);
    let order: Vec<usize> = (0..n).rev().collect();
    (SparseSolver::new(start, &rows, &one_by_one(&order)), values)
}

#[test]
fn positive_and_indefinite_systems_are_solved_to_rounding() {
    let n = 300;
    let (mut solver, values) = chain(n, 0.0);
    // each unknown has one neighbour among those that follow it
    assert!((solver.cost().chain_flops / solver.cost().flops - 1.0).abs() < 1e-12);
    let b: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();

    for precision in [Precision::Single, Precision::Double] {
        let matrix = Symmetric::sparse(values.clone());
        let factored = solver.positive(matrix, precision).expect("eigenvalues are 2 - 2 cos > 0");
        // eliminated one by one from the end, the pivots are (k + 1)/k
        let pivot = factored.smallest_pivot().expect("a positive factor");
        let expected = (n as f64 + 1.0) / n as f64;
        assert!((pivot.value - expected).abs() < 1e-5 && (pivot.largest - 2.0).abs() < 1e-6);
        assert_eq!(pivot.unknown, 0);
        // the condition number is 4/π² n² = 4e4
        assert!(factored.solve(&mut b.clone()) < 1e-11);
        let (_, _, near) = laplacian(n, 1e-6);
        let near = Symmetric::sparse(near);
        let x = factored.solve_near(&near, &b, 1e-11).solved().expect("a shift of 1e-6 is near");
        let error: Vec<f64> =
            solver.pattern.multiply(&near, &x).iter().zip(&b).map(|(a, b)| a - b).collect();
        assert!(norm(&error) < 1e-10 * norm(&b));
        let far = Symmetric::sparse(laplacian(n, 100.0).2);
        assert_eq!(factored.solve_near(&far, &b, 1e-11), Outcome::Inaccurate);
    }

    // not -1: its second leading minor is zero, where pivoting within one
    // column cannot help
    let shifted = Symmetric::sparse(laplacian(n, -0.9).2);
    let failed = solver.factor_positive(shifted.clone(), Precision::Single);
    assert!(failed.is_err_and(|e| e.pivot < n && e.size == n) && solver.last().is_none());
    assert!(solver.factor_indefinite(shifted).solve(&mut b.clone()) < 1e-11);
}

/// The Laplacian of a cube of m³ points, in compressed columns, and an order by nested dissection.
fn cube(m: usize) -> (Vec<usize>, Vec<usize>, Vec<f64>, Vec<usize>) {
    let id = |x: usize, y: usize, z: usize| (x * m + y) * m + z;
    let (mut start, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    let mut adjacency = vec![Vec::new(); m * m * m];
    for (c, (x, y, z)) in (0..m * m * m).map(|c| (c, (c / (m * m), c / m % m, c % m))) {
        rows.push(c);
        values.push(6.1);
        let later = [(z + 1, id(x, y, z + 1)), (y + 1, id(x, y + 1, z)), (x + 1, id(x + 1, y, z))];
        for (_, other) in later.into_iter().filter(|(k, _)| *k < m) {
            rows.push(other);
            values.push(-1.0);
            adjacency[c].push(other);
            adjacency[other].push(c);
        }
        start.push(rows.len());
    }
    let order = crate::math::ordering::nested_dissection(&adjacency);
    (start, rows, values, order)
}

#[test]
fn many_threads_give_the_bits_of_one() {
    let m = 24;
    let (start, rows, values, order) = cube(m);
    let solver = SparseSolver::new(start, &rows, &one_by_one(&order));
    // enough for several tasks
    let cost = solver.cost();
    assert!(cost.flops > 2e8, "{cost:?}");
    // of the halves beside the last separator, and of theirs, one each is on the chain
    let chain = cost.chain_flops / cost.flops;
    assert!(chain > 0.1 && chain < 0.9, "{chain}");
    let b: Vec<f64> = (0..m * m * m).map(|i| (0.1 * i as f64).sin()).collect();
    for precision in [Precision::Single, Precision::Double] {
        let mut solutions = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("a thread pool").install(|| {
                let matrix = Symmetric::sparse(values.clone());
                let factored = solver.positive(matrix, precision).expect("diagonally dominant");
                let mut x = b.clone();
                assert!(factored.solve(&mut x) < 1e-13);
                let mut several = vec![b.clone(); 3];
                factored.solve_all_to(&mut several, 1e-8);
                [x, several.swap_remove(1)]
            })
        });
        let first = solutions[0].clone();
        solutions[1..].iter_mut().for_each(|x| assert_eq!(*x, first));
    }
}

/// More sides than go side by side, one of them zero; and two, which go one after the other.
#[test]
fn several_systems_have_the_solutions_of_each_alone() {
    let (start, rows, values, order) = cube(20);
    let solver = SparseSolver::new(start, &rows, &one_by_one(&order));
    let side = |k: usize| -> Vec<f64> {
        (0..8000).map(|i| k as f64 * (0.1 * (i + 31 * k) as f64).sin()).collect()
    };
    for precision in [Precision::Single, Precision::Double] {
        let matrix = Symmetric::sparse(values.clone());
        let factored = solver.positive(matrix, precision).expect("diagonally dominant");
        for count in [SYSTEMS + 5, 2] {
            let mut all: Vec<Vec<f64>> = (0..count).map(side).collect();
            factored.solve_all_to(&mut all, 1e-10);
            for (k, x) in all.iter().enumerate() {
                let b = side(k);
                assert!(norm(&factored.residual(&b, x)) <= 1.1e-10 * norm(&b), "{k}");
            }
        }
    }
}

#[test]
fn dense_columns_enter_without_being_assembled() {
    let n = 40;
    let column = |k: f64| -> Vec<f64> { (0..n).map(|i| (k * i as f64).sin()).collect() };
    let updates = vec![(3.0, column(0.1)), (1e4, column(0.37))];
    let b = column(1.3);
    for shift in [0.0, -0.9] {
        let (mut solver, lower) = chain(n, shift);
        let mut assembled = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => 2.0 + shift,
            1 => -1.0,
            _ => 0.0,
        });
        for (scale, u) in &updates {
            let u = DVector::from_column_slice(u);
            assembled += *scale * &u * u.transpose();
        }
        let expected = assembled.lu().solve(&DVector::from_column_slice(&b)).expect("regular");
        let matrix = Symmetric { lower, updates: updates.clone() };
        let mut x = b.clone();
        assert!(solver.factor(matrix, Precision::Single).solve(&mut x) < 1e-9);
        let error: Vec<f64> = x.iter().zip(expected.iter()).map(|(a, b)| a - b).collect();
        assert!(norm(&error) < 1e-9 * norm(&x), "{}", norm(&error));
    }
}

/// Without refinement a solution has the precision of its factor.
#[test]
fn a_factor_is_sharpened_once() {
    let n = 300;
    let b: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
    let (mut solver, values) = chain(n, 0.0);
    assert!(solver.refactor_double().is_none());
    let unrefined = |factored: &Factorization| {
        norm(&factored.residual(&b, &factored.inverse_times(&b))) / norm(&b)
    };
    let blunt = solver.factor_positive(Symmetric::sparse(values), Precision::Single);
    let blunt = unrefined(blunt.expect("positive"));
    // the two precisions are a factor of 5e8 apart
    let sharp = unrefined(solver.refactor_double().expect("a factor in single precision"));
    assert!(sharp < 1e-6 * blunt && sharp < 1e-11, "{blunt:e} {sharp:e}");
    assert!(solver.refactor_double().is_none());
}

#[test]
fn double_precision_decides_where_single_cannot() {
    let n = 300;
    let smallest = 2.0 - 2.0 * (std::f64::consts::PI / (n as f64 + 1.0)).cos();
    for (left, positive) in [(1e-9, true), (-1e-9, false), (-1e-2, false)] {
        let (solver, values) = chain(n, left - smallest);
        let done = solver.positive(Symmetric::sparse(values), Precision::Single);
        assert_eq!(done.is_ok(), positive, "{left}");
    }
}

/// The eigenvalues of the Laplacian of n points are 2 − 2 cos(kπ/(n + 1)): below a shift there are as many as
/// their formula says, and a dense part moves at most one of them across it.
#[test]
fn negative_eigenvalues_are_counted_with_the_dense_part() {
    let n = 60;
    let (mut solver, _) = chain(n, 0.0);
    let angle = |k: usize| std::f64::consts::PI * (k as f64) / (n as f64 + 1.0);
    for shift in [0.0, 0.03, 0.7, 1.9, 3.1] {
        let below = (1..=n).filter(|&k| 2.0 - 2.0 * angle(k).cos() < shift).count();
        let lower = laplacian(n, -shift).2;
        let factored = solver.factor(Symmetric::sparse(lower.clone()), Precision::Double);
        assert_eq!(factored.negative_eigenvalues(), below, "{shift}");
        // along the eigenvector of the third eigenvalue, which it moves by 10 and 0.9 of itself
        let vector: Vec<f64> = (1..=n).map(|i| (angle(3) * i as f64).sin()).collect();
        let square = dot(&vector, &vector);
        let third = 2.0 - 2.0 * angle(3).cos();
        for by in [10.0, -0.9 * third] {
            let updates = vec![(by / square, vector.clone())];
            let matrix = Symmetric { lower: lower.clone(), updates };
            let moved = usize::from(third + by < shift);
            let expected = below - usize::from(third < shift) + moved;
            let factored = solver.factor(matrix, Precision::Double);
            assert_eq!(factored.negative_eigenvalues(), expected, "{shift} {by}");
        }
    }
}
