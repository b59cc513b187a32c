//! What can be fitted: a law, its unknowns, and where to start.

use nalgebra::{DMatrix, DVector};

use super::Test;
use crate::material::{LAWS, Law};
use crate::math::least_squares::{Minimum, levenberg_marquardt};

/// A law with a number of terms.
///
/// All parameters but the last are unknowns; the last sets the bulk modulus.
pub struct Candidate {
    /// Name on the command line and in tables.
    pub name: &'static str,
    /// Key of the law.
    key: &'static str,
    /// Exponents to start from, for Ogden's law.
    exponents: &'static [&'static [f64]],
    /// Unknowns relative to half the shear modulus to start from, for other
    /// laws.
    start: &'static [f64],
    /// Whether all unknowns must be zero or positive, which makes the law
    /// stable.
    nonnegative: bool,
    /// The last parameter, from the unknowns and bulk over shear modulus.
    last: fn(&[f64], f64) -> f64,
}

/// What `solver fit` tries.
pub static CANDIDATES: &[Candidate] = &[
    Candidate {
        name: "neo-hookean",
        key: "neo-hookean",
        exponents: &[],
        start: &[6.0],
        nonnegative: true,
        last: |_, ratio| (3.0 * ratio - 2.0) / (2.0 * (3.0 * ratio + 1.0)),
    },
    Candidate {
        name: "mooney-rivlin",
        key: "mooney-rivlin",
        exponents: &[],
        start: &[0.8, 0.2, 0.05],
        nonnegative: true,
        last: |x, ratio| ratio * (x[0] + x[1]),
    },
    Candidate {
        name: "yeoh",
        key: "yeoh",
        exponents: &[],
        start: &[1.0, 0.02, 0.0],
        nonnegative: false,
        last: |x, ratio| ratio * 2.0 * x[0],
    },
    ogden("ogden-1", &[&[1.5], &[2.5], &[5.0], &[-2.0]]),
    ogden("ogden-2", &[&[1.5, 5.0], &[2.0, -2.0], &[2.5, 8.0], &[1.3, 3.0]]),
    ogden("ogden-3", &[&[1.3, 5.0, -2.0], &[2.0, 6.0, -2.0], &[1.5, 4.0, 9.0]]),
];

const fn ogden(name: &'static str, exponents: &'static [&'static [f64]]) -> Candidate {
    Candidate {
        name,
        key: "ogden",
        exponents,
        start: &[],
        nonnegative: false,
        last: |x, ratio| {
            let (mu, alpha) = x.split_at(x.len() / 2);
            0.5 * ratio * mu.iter().zip(alpha).map(|(m, a)| m * a).sum::<f64>()
        },
    }
}

impl Candidate {
    /// The law.
    ///
    /// # Panics
    /// Never: every candidate's key is in the table, which a test proves.
    #[must_use]
    pub fn law(&self) -> &'static Law {
        LAWS.iter().find(|law| law.key == self.key).expect("a key of the table")
    }

    /// Number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.exponents.first().map_or(self.start.len(), |e| 2 * e.len())
    }

    /// Parameters of the law that fit best; nothing when none are admissible.
    pub(super) fn solve(&self, tests: &[Test], ratio: f64) -> Option<Vec<f64>> {
        // stress in units of its largest value: all unknowns are of order one
        let stress = tests.iter().flat_map(|t| t.points.iter().map(|p| p.1.abs()));
        let unit = stress.fold(0.0, f64::max);
        let half_shear = 0.5 * shear(tests)? / unit;
        let mut best: Option<Minimum> = None;
        for (start, free) in self.starts(half_shear) {
            let Some(minimum) = self.minimize(tests, unit, &start, &free) else { continue };
            if best.as_ref().is_none_or(|b| minimum.sum < b.sum) {
                best = Some(minimum);
            }
        }
        let mut values = best?.x;
        let stresses = if self.exponents.is_empty() { values.len() } else { values.len() / 2 };
        values[..stresses].iter_mut().for_each(|v| *v *= unit);
        values.push((self.last)(&values, ratio));
        self.law().check(&values).ok()?;
        Some(values)
    }

    /// Unknowns to start from, and which of them are free.
    fn starts(&self, half_shear: f64) -> Vec<(Vec<f64>, Vec<usize>)> {
        let n = self.unknowns();
        if !self.exponents.is_empty() {
            let one = |exponents: &&[f64]| {
                let share = 4.0 * half_shear / exponents.len() as f64;
                let mu = exponents.iter().map(|alpha| share / alpha);
                (mu.chain(exponents.iter().copied()).collect(), (0..n).collect())
            };
            return self.exponents.iter().map(one).collect();
        }
        let start: Vec<f64> = self.start.iter().map(|s| s * half_shear).collect();
        if !self.nonnegative {
            return vec![(start, (0..n).collect())];
        }
        // an optimum under bounds has some unknowns at zero: try every choice
        let choice = |bits: usize| {
            let free: Vec<usize> = (0..n).filter(|i| bits >> i & 1 == 1).collect();
            let held = |i: usize| if free.contains(&i) { start[i] } else { 0.0 };
            ((0..n).map(held).collect(), free)
        };
        (1..1 << n).map(choice).collect()
    }

    fn minimize(
        &self,
        tests: &[Test],
        unit: f64,
        start: &[f64],
        free: &[usize],
    ) -> Option<Minimum> {
        let whole = |x: &[f64]| {
            let mut all = start.to_vec();
            free.iter().zip(x).for_each(|(&i, x)| all[i] = *x);
            all
        };
        let residuals = |x: &[f64]| {
            let all = whole(x);
            self.admissible(&all).then(|| self.residuals(tests, unit, &all, free))
        };
        let first: Vec<f64> = free.iter().map(|&i| start[i]).collect();
        let minimum = levenberg_marquardt(&first, residuals)?;
        Some(Minimum { x: whole(&minimum.x), sum: minimum.sum })
    }

    fn residuals(
        &self,
        tests: &[Test],
        unit: f64,
        unknowns: &[f64],
        free: &[usize],
    ) -> (DVector<f64>, DMatrix<f64>) {
        let mut values = unknowns.to_vec();
        values.push((self.last)(unknowns, 1.0));
        let material = (self.law().build)(&values);
        let points: Vec<_> =
            tests.iter().flat_map(|t| t.points.iter().map(|p| (t.mode, p.0, p.1))).collect();
        let mut r = DVector::zeros(points.len());
        let mut jacobian = DMatrix::zeros(points.len(), free.len());
        for (row, &(mode, stretch, stress)) in points.iter().enumerate() {
            r[row] = mode.nominal_stress(material.as_ref(), stretch) - stress / unit;
            let mut gradient = vec![0.0; values.len()];
            mode.add_stress_gradient(material.as_ref(), stretch, &mut gradient);
            for (column, &i) in free.iter().enumerate() {
                jacobian[(row, column)] = gradient[i];
            }
        }
        (r, jacobian)
    }

    /// Whether unknowns give a law that resists at rest, and, where that is
    /// cheap to say, everywhere.
    fn admissible(&self, x: &[f64]) -> bool {
        if !self.exponents.is_empty() {
            let (mu, alpha) = x.split_at(x.len() / 2);
            let good = |(m, a): (&f64, &f64)| m * a > 0.0 && (0.1..=20.0).contains(&a.abs());
            return mu.iter().zip(alpha).all(good);
        }
        if self.nonnegative {
            return x.iter().all(|v| *v >= 0.0) && x.iter().take(2).any(|v| *v > 0.0);
        }
        x[0] > 0.0
    }
}

/// Shear modulus of the neo-Hookean law with the best fit; nothing if it is not
/// positive.
fn shear(tests: &[Test]) -> Option<f64> {
    let (mut product, mut square) = (0.0, 0.0);
    for test in tests {
        for &(stretch, stress) in &test.points {
            let [a, _, c] = test.mode.stretches(stretch);
            let unit = a - c * c / a;
            product += unit * stress;
            square += unit * unit;
        }
    }
    let shear = product / square;
    (shear.is_finite() && shear > 0.0).then_some(shear)
}
