//! A quadratic model of the objective, and its minimum under linear inequalities.
//!
//! min  g·d + ½ dᵀ (B + λM) d      with   a_k·d ≥ −c_k
//!
//! B = Q C Qᵀ + θ (I − Q Qᵀ)       Q orthonormal; all of space with a matrix for every variable
//! a_k   derivatives of a constraint, c_k its value, or both of a bound
//! λM    what keeps a step short: dᵀ M d is the mean square of its motion; I where Q is not all of space
//!
//! With d = Q y + z and Qᵀ z = 0 it is a sparse convex problem for Clarabel. It gets those inequalities alone that the
//! minimum without them violates, and then those that it violates next.
//!
//! Source: Nocedal and Wright 2006, "Numerical Optimization", chapters 7, 16 and 18; Clarabel: Goulart and Chen 2024.

use std::cell::RefCell;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT,
    ZeroConeT,
};
use mechanics::math::linear::dot;
use nalgebra::{DMatrix, DVector};

/// Violation of an inequality over the length of steps that counts as rounding [1].
const ROUNDING: f64 = 1e-7;
/// Inequalities that are taken in at once.
const AT_ONCE: usize = 40;
/// How often some are taken in.
const ROUNDS: usize = 100;
/// Multiplier, over the largest, of an inequality that holds the minimum back.
const HOLDS: f64 = 1e-6;

/// B.
#[derive(Clone, Debug)]
pub struct Model {
    /// Q, if it is not all of space.
    basis: Option<DMatrix<f64>>,
    /// C.
    within: DMatrix<f64>,
    /// θ.
    beyond: f64,
}

impl Model {
    /// With a matrix for every variable.
    pub fn full(matrix: DMatrix<f64>) -> Self {
        Self { basis: None, within: matrix, beyond: 0.0 }
    }

    /// θ in all directions.
    pub fn round(variables: usize, curvature: f64) -> Self {
        let basis = Some(DMatrix::zeros(variables, 0));
        Self { basis, within: DMatrix::zeros(0, 0), beyond: curvature }
    }

    /// θ I − W K Wᵀ, which is positive definite.
    pub fn limited(curvature: f64, w: &DMatrix<f64>, k: &DMatrix<f64>) -> Self {
        let q = w.clone().qr().q();
        let through = q.tr_mul(w);
        let size = q.ncols();
        let within = curvature * DMatrix::identity(size, size) - &through * k * through.transpose();
        Self { within: 0.5 * (&within + within.transpose()), basis: Some(q), beyond: curvature }
    }

    /// Whether every variable has a row.
    pub fn is_full(&self) -> bool {
        self.basis.is_none()
    }

    /// Whether it is positive definite.
    pub fn is_positive(&self) -> bool {
        self.beyond >= 0.0 && self.within.clone().cholesky().is_some()
    }

    /// (y, z) of d.
    fn split(&self, d: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        match &self.basis {
            None => (d.clone(), DVector::zeros(0)),
            Some(q) => {
                let y = q.tr_mul(d);
                let z = d - q * &y;
                (y, z)
            }
        }
    }

    fn join(&self, y: &DVector<f64>, z: &DVector<f64>) -> DVector<f64> {
        self.basis.as_ref().map_or_else(|| y.clone(), |q| q * y + z)
    }

    /// dᵀ B d.
    pub fn bend(&self, d: &[f64]) -> f64 {
        let (y, z) = self.split(&DVector::from_column_slice(d));
        y.dot(&(&self.within * &y)) + self.beyond * z.norm_squared()
    }

    /// The model with λM added.
    fn shifted(&self, shift: f64, metric: &DMatrix<f64>) -> Self {
        let size = self.within.nrows();
        let within = match self.basis {
            None => &self.within + shift * metric,
            Some(_) => &self.within + shift * DMatrix::identity(size, size),
        };
        Self { basis: self.basis.clone(), within, beyond: self.beyond + shift }
    }

    /// B⁻¹ of vectors side by side.
    fn solve(&self, right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let Some(q) = &self.basis else {
            return Some(self.within.clone().cholesky()?.solve(right));
        };
        let y = q.tr_mul(right);
        let z = (right - q * &y) / self.beyond;
        let y = if y.is_empty() { y } else { self.within.clone().cholesky()?.solve(&y) };
        Some(q * y + z)
    }

    /// A mean of its eigenvalues over those of M.
    fn mean(&self, metric: &DMatrix<f64>) -> f64 {
        match self.basis {
            None => self.within.trace() / metric.trace(),
            Some(_) => self.beyond,
        }
    }
}

/// An inequality a·d ≥ −c.
#[derive(Clone, Debug)]
pub struct Row {
    /// Variables with their parts of a.
    pub a: Vec<(usize, f64)>,
    /// c, not negative in a problem.
    pub c: f64,
    /// Index of the constraint of a design that it is of, those of runs after those of the rest shape.
    pub of: Option<usize>,
}

impl Row {
    fn times(&self, d: &[f64]) -> f64 {
        self.a.iter().map(|(i, a)| a * d[*i]).sum()
    }

    fn size(&self) -> f64 {
        self.a.iter().map(|(_, a)| a * a).sum::<f64>().sqrt()
    }
}

/// The minimum of a model.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// d.
    pub d: Vec<f64>,
    /// Number and multiplier of each inequality that holds d back: by how much the minimum falls for each unit of c.
    pub multipliers: Vec<(usize, f64)>,
}

/// A model with its inequalities.
pub struct Problem<'a> {
    /// B.
    pub model: &'a Model,
    /// g.
    pub gradient: &'a [f64],
    /// M.
    pub metric: &'a DMatrix<f64>,
    /// The inequalities.
    pub rows: &'a [Row],
    /// How long steps are, about [m].
    pub length: f64,
    /// The inequalities that held the last minimum back: most hold the next one, too.
    held: RefCell<Vec<usize>>,
}

impl<'a> Problem<'a> {
    /// A model with a gradient, M and inequalities, whose steps are about so long [m].
    pub fn new(
        model: &'a Model,
        gradient: &'a [f64],
        metric: &'a DMatrix<f64>,
        rows: &'a [Row],
        length: f64,
    ) -> Self {
        Self { model, gradient, metric, rows, length, held: RefCell::default() }
    }

    /// g·d + ½ dᵀ B d.
    pub fn change(&self, d: &[f64]) -> f64 {
        dot(self.gradient, d) + 0.5 * self.model.bend(d)
    }

    /// A mean of the curvature, to begin λ with.
    pub fn mean_curvature(&self) -> f64 {
        self.model.mean(self.metric)
    }

    /// The minimum with λ; none where B + λM is not positive definite.
    pub fn minimum(&self, shift: f64) -> Option<Minimum> {
        let model = self.model.shifted(shift, self.metric);
        let gradient = DMatrix::from_column_slice(self.gradient.len(), 1, self.gradient);
        let free = -model.solve(&gradient)?.column(0);
        let mut found = Minimum { d: free.as_slice().to_vec(), multipliers: Vec::new() };
        let mut taken: Vec<usize> = Vec::new();
        for round in 0..ROUNDS {
            let mut new = self.violated(&found.d, &taken);
            if new.is_empty() {
                break;
            }
            if round == 0 {
                new.extend(self.held.take());
                new.sort_unstable();
                new.dedup();
            }
            taken.extend(new);
            found = self.within(&model, &taken)?;
        }
        let largest = found.multipliers.iter().map(|(_, m)| *m).fold(0.0, f64::max);
        found.multipliers.retain(|(_, m)| *m > HOLDS * largest);
        if !found.multipliers.is_empty() {
            self.held.replace(found.multipliers.iter().map(|(k, _)| *k).collect());
        }
        Some(self.polished(&model, &free, &found).unwrap_or(found))
    }

    /// The minimum with the inequalities that hold it back as equations, to rounding; none where one of them does not hold
    /// it back so, or another is violated.
    fn polished(&self, model: &Model, free: &DVector<f64>, found: &Minimum) -> Option<Minimum> {
        let rows: Vec<&Row> = found.multipliers.iter().map(|(k, _)| &self.rows[*k]).collect();
        if rows.is_empty() {
            return None;
        }
        let mut a = DMatrix::zeros(self.gradient.len(), rows.len());
        for (k, row) in rows.iter().enumerate() {
            row.a.iter().for_each(|(i, by)| a[(*i, k)] = *by / row.size());
        }
        let through = model.solve(&a)?;
        let lack = DVector::from_fn(rows.len(), |k, _| {
            -(rows[k].c + rows[k].times(free.as_slice())) / rows[k].size()
        });
        let pulls = a.tr_mul(&through).cholesky()?.solve(&lack);
        let d = free + &through * &pulls;
        let is_kept =
            |row: &Row| row.c + row.times(d.as_slice()) >= -ROUNDING * self.length * row.size();
        if pulls.min() < 0.0 || !self.rows.iter().all(is_kept) {
            return None;
        }
        let multipliers = found.multipliers.iter().zip(pulls.iter()).zip(&rows);
        let multipliers = multipliers.map(|(((k, _), pull), row)| (*k, pull / row.size()));
        Some(Minimum { multipliers: multipliers.collect(), d: d.as_slice().to_vec() })
    }

    /// The inequalities that d violates most, of those that are not taken in.
    fn violated(&self, d: &[f64], taken: &[usize]) -> Vec<usize> {
        let beyond = |k: usize| {
            let row = &self.rows[k];
            (row.c + row.times(d)) / row.size().max(f64::MIN_POSITIVE)
        };
        let all = (0..self.rows.len()).filter(|k| !taken.contains(k));
        let mut violated: Vec<(f64, usize)> = all.map(|k| (beyond(k), k)).collect();
        violated.retain(|(left, _)| *left < -ROUNDING * self.length);
        violated.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        violated.into_iter().take(AT_ONCE).map(|(_, k)| k).collect()
    }

    /// The minimum under some of the inequalities. In units of the length, and of what the objective falls along it.
    fn within(&self, model: &Model, taken: &[usize]) -> Option<Minimum> {
        let (n, size) = (self.gradient.len(), model.within.nrows());
        let all = size + if model.basis.is_some() { n } else { 0 };
        let gradient = DVector::from_column_slice(self.gradient);
        let unit = gradient.amax().max(f64::MIN_POSITIVE) * self.length;
        let squared = self.length * self.length / unit;
        let upper = (0..size).flat_map(|j| (0..=j).map(move |i| (i, j)));
        let mut entries: Vec<Entry> =
            upper.map(|(i, j)| (i, j, squared * model.within[(i, j)])).collect();
        entries.extend((size..all).map(|j| (j, j, squared * model.beyond)));
        let p = sparse([all, all], &entries);
        let (y, z) = model.split(&gradient);
        let q: Vec<f64> = y.iter().chain(z.iter()).map(|g| g * self.length / unit).collect();
        entries.clear();
        let mut b = Vec::new();
        if let Some(basis) = &model.basis {
            let all = (0..size).flat_map(|j| (0..n).map(move |i| (i, j)));
            entries.extend(all.map(|(i, j)| (j, size + i, basis[(i, j)])));
            b.resize(size, 0.0);
        }
        let equalities = b.len();
        let sizes: Vec<f64> = taken.iter().map(|&k| self.rows[k].size()).collect();
        for (&k, length) in taken.iter().zip(&sizes) {
            let Row { a, c, .. } = &self.rows[k];
            match &model.basis {
                None => entries.extend(a.iter().map(|(i, a)| (b.len(), *i, -a / length))),
                Some(basis) => {
                    for j in 0..size {
                        let on: f64 = a.iter().map(|(i, a)| a * basis[(*i, j)]).sum();
                        entries.push((b.len(), j, -on / length));
                    }
                    entries.extend(a.iter().map(|(i, a)| (b.len(), size + i, -a / length)));
                }
            }
            b.push(c / (length * self.length));
        }
        let a = sparse([b.len(), all], &entries);
        let cones: [SupportedConeT<f64>; 2] =
            [ZeroConeT(equalities), NonnegativeConeT(taken.len())];
        let settings =
            DefaultSettings { verbose: false, max_threads: 1, ..DefaultSettings::default() };
        let mut solver = DefaultSolver::new(&p, &q, &a, &b, &cones, settings).ok()?;
        solver.solve();
        let solution = &solver.solution;
        if !matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
            return None;
        }
        let x = DVector::from_column_slice(&solution.x) * self.length;
        let (y, z) = (x.rows(0, size).into_owned(), x.rows(size, all - size).into_owned());
        let d = model.join(&y, &z).as_slice().to_vec();
        let duals = taken.iter().zip(&solution.z[equalities..]).zip(&sizes);
        let multipliers =
            duals.map(|((&k, dual), length)| (k, dual * unit / (length * self.length)));
        Some(Minimum { d, multipliers: multipliers.collect() })
    }
}

/// Row, column and value.
type Entry = (usize, usize, f64);

/// A sparse matrix with so many rows and columns.
fn sparse([rows, columns]: [usize; 2], entries: &[Entry]) -> CscMatrix<f64> {
    let (i, (j, values)) = entries.iter().map(|&(i, j, value)| (i, (j, value))).unzip();
    CscMatrix::new_from_triplets(rows, columns, i, j, values)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::math::random::Random;

    use super::*;

    fn positive(n: usize, condition: f64, random: &mut Random) -> DMatrix<f64> {
        let q = DMatrix::from_vec(n, n, random.numbers(n * n)).qr().q();
        let power = |i: usize| condition.powf(-(i as f64) / (n - 1) as f64);
        &q * DMatrix::from_diagonal(&DVector::from_fn(n, |i, _| power(i))) * q.transpose()
    }

    /// The conditions of Karush, Kuhn and Tucker at the minimum of a problem.
    fn check_minimum(problem: &Problem, times: impl Fn(&DVector<f64>) -> DVector<f64>) {
        let found = problem.minimum(0.0).unwrap();
        let d = DVector::from_column_slice(&found.d);
        let mut slope = times(&d) + DVector::from_column_slice(problem.gradient);
        for (k, multiplier) in &found.multipliers {
            assert!(*multiplier > -1e-7, "{multiplier}");
            let row = &problem.rows[*k];
            row.a.iter().for_each(|(i, a)| slope[*i] -= multiplier * a);
            assert!(multiplier * (row.c + row.times(&found.d)) < 1e-5);
        }
        assert!(slope.amax() < 1e-5, "{}", slope.amax());
        assert!(problem.rows.iter().all(|row| row.c + row.times(&found.d) > -1e-6));
    }

    fn rows(n: usize, count: usize, random: &mut Random) -> Vec<Row> {
        let one = |_| {
            let a = random.numbers(n).into_iter().enumerate().collect();
            Row { a, c: random.numbers(1)[0].abs(), of: None }
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn minima_under_random_inequalities_meet_their_conditions() {
        let mut random = Random::new(5);
        for _ in 0..40 {
            let n = 12;
            let b = positive(n, 1e6, &mut random);
            let (gradient, rows) = (random.numbers(n), rows(n, 60, &mut random));
            let (model, metric) = (Model::full(b.clone()), DMatrix::identity(n, n));
            let problem = Problem::new(&model, &gradient, &metric, &rows, 1.0);
            check_minimum(&problem, |d| &b * d);
        }
    }

    /// θ I + 3 w wᵀ, known by its two vectors alone.
    #[test]
    fn a_limited_model_has_the_minimum_of_its_matrix() {
        let mut random = Random::new(6);
        for _ in 0..20 {
            let n = 15;
            let w = DMatrix::from_vec(n, 2, random.numbers(2 * n));
            let k = DMatrix::from_row_slice(2, 2, &[-3.0, 0.0, 0.0, -0.5]);
            let b = 0.7 * DMatrix::identity(n, n) - &w * &k * w.transpose();
            let model = Model::limited(0.7, &w, &k);
            let (gradient, rows) = (random.numbers(n), rows(n, 30, &mut random));
            let metric = DMatrix::identity(n, n);
            let problem = Problem::new(&model, &gradient, &metric, &rows, 1.0);
            let d = random.numbers(n);
            let through: DVector<f64> = &b * DVector::from_column_slice(&d);
            assert!((model.bend(&d) - dot(&d, through.as_slice())).abs() < 1e-12);
            check_minimum(&problem, |d| &b * d);
        }
    }

    /// The multiplier is what the minimum falls by when its inequality gives way.
    #[test]
    fn multipliers_are_derivatives_of_the_minimum() {
        let mut random = Random::new(7);
        let n = 8;
        let model = Model::full(positive(n, 1e3, &mut random));
        let (gradient, metric) = (random.numbers(n), DMatrix::identity(n, n));
        let mut rows = rows(n, 30, &mut random);
        let least = |rows: &[Row]| {
            let problem = Problem::new(&model, &gradient, &metric, rows, 1.0);
            let found = problem.minimum(0.0).unwrap();
            (problem.change(&found.d), found.multipliers)
        };
        let (_, multipliers) = least(&rows);
        let held: Vec<_> = multipliers.into_iter().filter(|(_, m)| *m > 1e-3).collect();
        assert!(!held.is_empty());
        for (k, multiplier) in held {
            let by = 1e-4;
            let own = rows[k].c;
            rows[k].c = own + by;
            let more = least(&rows).0;
            rows[k].c = own - by;
            let less = least(&rows).0;
            rows[k].c = own;
            let slope = (less - more) / (2.0 * by);
            assert!((slope / multiplier - 1.0).abs() < 1e-3, "{slope} {multiplier}");
        }
    }
}
