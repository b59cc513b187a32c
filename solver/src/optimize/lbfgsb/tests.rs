use mechanics::math::random::Random;

use super::*;

/// A positive definite matrix of eigenvalues up to 30.
fn matrix(random: &mut Random, n: usize) -> DMatrix<f64> {
    let a = DMatrix::from_fn(n, n, |_, _| random.uniform());
    &a * a.transpose() * 3.0 + DMatrix::identity(n, n) * 0.5
}

fn vector(random: &mut Random, n: usize) -> DVector<f64> {
    DVector::from_vec(random.numbers(n))
}

/// A memory of steps on a quadratic.
fn memory(random: &mut Random, a: &DMatrix<f64>, pairs: usize) -> Lbfgs {
    let mut memory = Lbfgs::new(pairs);
    for _ in 0..pairs {
        let s = vector(random, a.nrows());
        memory.update(s.as_slice().to_vec(), (a * s).as_slice().to_vec());
    }
    memory
}

#[test]
fn the_model_is_the_inverse_of_the_recursion() {
    let mut random = Random::new(8);
    for pairs in [1, 3, 6] {
        let a = matrix(&mut random, 9);
        let memory = memory(&mut random, &a, pairs);
        let model = Model::new(&memory);
        let g = vector(&mut random, 9);
        let p = DVector::from_vec(memory.direction(g.as_slice()));
        assert!((model.times(&p) + &g).norm() < 1e-9 * g.norm());
        let free: Vec<usize> = (0..9).collect();
        assert!((model.solve_within(&free, &g).unwrap() + &p).norm() < 1e-9 * p.norm());
    }
}

/// All choices of variables at their lower bound, their upper bound or free: the
/// one that meets the conditions of the minimum.
fn brute_force(b: &DMatrix<f64>, x: &[f64], g: &[f64], l: &[f64], u: &[f64]) -> Vec<f64> {
    let n = x.len();
    for code in 0..3_usize.pow(n as u32) {
        let state: Vec<usize> = (0..n).map(|i| code / 3_usize.pow(i as u32) % 3).collect();
        let free: Vec<usize> = (0..n).filter(|&i| state[i] == 2).collect();
        let mut z: Vec<f64> = (0..n).map(|i| [l[i], u[i], x[i]][state[i]]).collect();
        let gradient = |z: &[f64]| -> DVector<f64> {
            DVector::from_column_slice(g) + b * DVector::from_fn(n, |i, _| z[i] - x[i])
        };
        let start = gradient(&z);
        let right = DVector::from_fn(free.len(), |k, _| -start[free[k]]);
        if !free.is_empty() {
            let own = b.select_rows(&free).select_columns(&free);
            let step = own.lu().solve(&right).unwrap();
            free.iter().enumerate().for_each(|(k, &i)| z[i] += step[k]);
        }
        let slope = gradient(&z);
        let right = |i: usize| match state[i] {
            0 => slope[i] >= 0.0,
            1 => slope[i] <= 0.0,
            _ => z[i] >= l[i] && z[i] <= u[i],
        };
        if (0..n).all(right) {
            return z;
        }
    }
    unreachable!("a convex model has a minimum in a box")
}

#[test]
fn the_step_is_the_minimiser_in_the_box() {
    let mut random = Random::new(9);
    let mut at_bounds = [0; 6];
    for pairs in [0, 1, 2, 4, 5] {
        for _ in 0..20 {
            let n = 5;
            let a = matrix(&mut random, n);
            let memory = memory(&mut random, &a, pairs);
            let model = Model::new(&memory);
            let b = DMatrix::from_columns(
                &(0..n)
                    .map(|i| model.times(&DMatrix::identity(n, n).column(i).into_owned()))
                    .collect::<Vec<_>>(),
            );
            let [x, g] = [0, 1].map(|_| vector(&mut random, n));
            let bounds = |sign: f64, random: &mut Random| -> Vec<f64> {
                x.iter().map(|x| x + sign * 0.2 * (random.uniform() + 1.0)).collect()
            };
            let (l, u) = (bounds(-1.0, &mut random), bounds(1.0, &mut random));
            let found = memory.step(x.as_slice(), g.as_slice(), &l, &u);
            let expected = brute_force(&b, x.as_slice(), g.as_slice(), &l, &u);
            for (a, b) in found.iter().zip(&expected) {
                assert!((a - b).abs() < 1e-8, "{pairs}: {found:?} {expected:?}");
            }
            at_bounds[(0..n).filter(|&i| found[i] == l[i] || found[i] == u[i]).count()] += 1;
        }
    }
    assert!(at_bounds[1..5].iter().all(|n| *n > 3), "{at_bounds:?}");
}

#[test]
fn without_bounds_it_is_the_step_of_the_recursion() {
    let mut random = Random::new(10);
    let a = matrix(&mut random, 12);
    let memory = memory(&mut random, &a, 4);
    let [x, g] = [0, 1].map(|_| vector(&mut random, 12));
    let (l, u) = (vec![f64::NEG_INFINITY; 12], vec![f64::INFINITY; 12]);
    let z = memory.step(x.as_slice(), g.as_slice(), &l, &u);
    let p = memory.direction(g.as_slice());
    (0..12).for_each(|i| assert!((z[i] - x[i] - p[i]).abs() < 1e-9));
}

fn rosenbrock(x: &[f64]) -> (f64, Vec<f64>) {
    let valley = x[1] - x[0] * x[0];
    let value = 100.0 * valley * valley + (1.0 - x[0]).powi(2);
    (value, vec![-400.0 * x[0] * valley - 2.0 * (1.0 - x[0]), 200.0 * valley])
}

/// One iteration with halving towards the minimiser of the model.
fn iterate(memory: &mut Lbfgs, x: &[f64], l: &[f64], u: &[f64], change: f64) -> Vec<f64> {
    let (value, g) = rosenbrock(x);
    let near = |sign: f64, bound: &[f64]| -> Vec<f64> {
        x.iter()
            .zip(bound)
            .map(|(x, b)| if sign < 0.0 { b.max(x - change) } else { b.min(x + change) })
            .collect()
    };
    let to = memory.step(x, &g, &near(-1.0, l), &near(1.0, u));
    let mut alpha = 1.0;
    loop {
        let s: Vec<f64> = to.iter().zip(x).map(|(z, x)| alpha * (z - x)).collect();
        let next: Vec<f64> = x.iter().zip(&s).map(|(x, s)| x + s).collect();
        let (trial, slope) = rosenbrock(&next);
        if trial <= value + 1e-4 * dot(&g, &s) || alpha < 1e-12 {
            memory.update(s, slope.iter().zip(&g).map(|(a, b)| a - b).collect());
            return next;
        }
        alpha *= 0.5;
    }
}

/// The minimum inside the box, on one side of it, and in a corner.
#[test]
fn rosenbrocks_valley_is_followed_within_bounds() {
    for (l, u, minimum) in [
        ([-2.0, -2.0], [2.0, 2.0], [1.0, 1.0]),
        ([-2.0, -2.0], [0.5, 2.0], [0.5, 0.25]),
        ([1.5, -2.0], [3.0, 1.0], [1.5, 1.0]),
    ] {
        let (mut memory, mut iterations) = (Lbfgs::new(6), 0);
        let mut x = vec![f64::max(l[0], -1.2), -0.5];
        while projected_gradient_norm(&x, &rosenbrock(&x).1, &l, &u) > 1e-8 {
            x = iterate(&mut memory, &x, &l, &u, 0.5);
            assert!(x.iter().zip(&l).all(|(x, l)| x >= l) && x.iter().zip(&u).all(|(x, u)| x <= u));
            iterations += 1;
            assert!(iterations < 60, "{x:?}");
        }
        assert!((x[0] - minimum[0]).abs() < 1e-7 && (x[1] - minimum[1]).abs() < 1e-7, "{x:?}");
    }
}

#[test]
fn a_stored_state_goes_on_with_the_same_bits() {
    let (l, u) = ([-2.0, -2.0], [0.5, 2.0]);
    let (mut a, mut x) = (Lbfgs::new(6), vec![-1.2, 1.0]);
    for _ in 0..6 {
        x = iterate(&mut a, &x, &l, &u, 0.1);
    }
    let text = serde_json::to_string(&(&a, &x)).unwrap();
    let (mut b, mut z): (Lbfgs, Vec<f64>) = serde_json::from_str(&text).unwrap();
    for _ in 0..6 {
        x = iterate(&mut a, &x, &l, &u, 0.1);
        z = iterate(&mut b, &z, &l, &u, 0.1);
    }
    assert_eq!(x, z);
}
