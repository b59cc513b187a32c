//! What can be fitted: a law, its unknowns, and where to start.

use mechanics::material::response::Mode;
use mechanics::material::{LAWS, Law};
use mechanics::math::least_squares::{Minimum, Residuals, levenberg_marquardt};
use nalgebra::{DMatrix, DVector};

use super::Test;

/// A law with a number of terms.
///
/// All parameters but the last follow from the unknowns; the last sets the bulk modulus.
pub struct Candidate {
    /// Name on the command line and in tables.
    pub name: &'static str,
    /// Key of the law.
    key: &'static str,
    /// What is varied.
    unknowns: Unknowns,
    /// The last parameter, from the others and bulk over shear modulus.
    last: fn(&[f64], f64) -> f64,
}

/// What is varied, and where that starts.
enum Unknowns {
    /// The parameters, all of them stresses.
    Stresses {
        /// Where to start, relative to half the shear modulus.
        start: &'static [f64],
        /// Whether all must be zero or positive, which makes the law stable.
        nonnegative: bool,
    },
    /// μ and 1/J_m of Gent's law: the neo-Hookean law is 1/J_m = 0.
    Limit,
    /// s and α of Ogden's law, μ = 2 exp(s)/α, which keeps every term stable; exponents to
    /// start from.
    Terms(&'static [&'static [f64]]),
}

/// 1/J_m to start from: chains that reach 32 times their length.
const START_OF_LIMIT: f64 = 1e-3;

/// What `solver fit` tries.
pub static CANDIDATES: &[Candidate] = &[
    Candidate {
        name: "neo-hookean",
        key: "neo-hookean",
        unknowns: Unknowns::Stresses { start: &[6.0], nonnegative: true },
        last: |_, ratio| (3.0 * ratio - 2.0) / (2.0 * (3.0 * ratio + 1.0)),
    },
    Candidate {
        name: "mooney-rivlin",
        key: "mooney-rivlin",
        unknowns: Unknowns::Stresses { start: &[0.8, 0.2, 0.05], nonnegative: true },
        last: |p, ratio| ratio * (p[0] + p[1]),
    },
    Candidate {
        name: "gent",
        key: "gent",
        unknowns: Unknowns::Limit,
        last: |p, ratio| ratio * p[0],
    },
    Candidate {
        name: "yeoh",
        key: "yeoh",
        unknowns: Unknowns::Stresses { start: &[1.0, 0.02, 0.0], nonnegative: false },
        last: |p, ratio| ratio * 2.0 * p[0],
    },
    ogden("ogden-1", &[&[1.5], &[2.5], &[5.0], &[-2.0]]),
    ogden("ogden-2", &[&[1.5, 5.0], &[2.0, -2.0], &[2.5, 8.0], &[1.3, 3.0]]),
    ogden("ogden-3", &[&[1.3, 5.0, -2.0], &[2.0, 6.0, -2.0], &[1.5, 4.0, 9.0]]),
];

const fn ogden(name: &'static str, exponents: &'static [&'static [f64]]) -> Candidate {
    Candidate {
        name,
        key: "ogden",
        unknowns: Unknowns::Terms(exponents),
        last: |p, ratio| {
            let (mu, alpha) = p.split_at(p.len() / 2);
            0.5 * ratio * mu.iter().zip(alpha).map(|(m, a)| m * a).sum::<f64>()
        },
    }
}

impl Candidate {
    /// The law.
    ///
    /// # Panics
    /// Never: every candidate's key is in the table, which a test proves.
    pub fn law(&self) -> &'static Law {
        LAWS.iter().find(|law| law.key == self.key).expect("a key of the table")
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        match self.unknowns {
            Unknowns::Stresses { start, .. } => start.len(),
            Unknowns::Limit => 2,
            Unknowns::Terms(exponents) => 2 * exponents[0].len(),
        }
    }

    /// Parameters of the law that fit best; nothing when none are admissible.
    pub(super) fn solve(&self, tests: &[Test], ratio: f64) -> Option<Vec<f64>> {
        let problem = Problem::new(self, tests, ratio)?;
        let mut values = self.parameters(&problem.best()?.x);
        let stresses = match self.unknowns {
            Unknowns::Stresses { .. } => values.len(),
            Unknowns::Limit | Unknowns::Terms(_) => values.len() / 2,
        };
        values[..stresses].iter_mut().for_each(|v| *v *= problem.unit);
        values.push((self.last)(&values, ratio));
        self.law().check(&values).ok()?;
        Some(values)
    }

    /// Parameters without the last one.
    fn parameters(&self, x: &[f64]) -> Vec<f64> {
        match self.unknowns {
            Unknowns::Stresses { .. } => x.to_vec(),
            Unknowns::Limit => vec![x[0], 1.0 / x[1]],
            Unknowns::Terms(_) => {
                let (s, alpha) = x.split_at(x.len() / 2);
                let mu = s.iter().zip(alpha).map(|(s, a)| 2.0 * s.exp() / a);
                mu.chain(alpha.iter().copied()).collect()
            }
        }
    }

    /// ∂/∂unknowns from ∂/∂parameters.
    fn chain(&self, parameters: &[f64], gradient: &[f64]) -> Vec<f64> {
        match self.unknowns {
            Unknowns::Stresses { .. } => gradient.to_vec(),
            Unknowns::Limit => vec![gradient[0], -parameters[1].powi(2) * gradient[1]],
            Unknowns::Terms(_) => {
                let n = parameters.len() / 2;
                let (mu, alpha) = parameters.split_at(n);
                let by_s = (0..n).map(|t| mu[t] * gradient[t]);
                let by_alpha = (0..n).map(|t| gradient[n + t] - mu[t] / alpha[t] * gradient[t]);
                by_s.chain(by_alpha).collect()
            }
        }
    }

    /// Whether unknowns give a law that resists at rest, and, where that is
    /// cheap to say, everywhere. Strains beyond Gent's limit have residuals that are not
    /// numbers, which no step accepts.
    fn admissible(&self, x: &[f64]) -> bool {
        match self.unknowns {
            Unknowns::Stresses { nonnegative: true, .. } => {
                x.iter().all(|v| *v >= 0.0) && x.iter().take(2).any(|v| *v > 0.0)
            }
            Unknowns::Stresses { .. } => x[0] > 0.0,
            Unknowns::Limit => x[0] > 0.0 && x[1] > 0.0,
            Unknowns::Terms(_) => {
                let (s, alpha) = x.split_at(x.len() / 2);
                let good =
                    |(s, a): (&f64, &f64)| s.abs() < 100.0 && (0.1..=20.0).contains(&a.abs());
                s.iter().zip(alpha).all(good)
            }
        }
    }
}

/// Least squares in units of the largest stress, so that all unknowns are of
/// order one.
#[derive(Clone)]
struct Problem<'a> {
    candidate: &'a Candidate,
    points: Vec<(Mode, f64, f64)>,
    unit: f64,
    ratio: f64,
    half_shear: f64,
}

impl<'a> Problem<'a> {
    fn new(candidate: &'a Candidate, tests: &[Test], ratio: f64) -> Option<Self> {
        let stress = tests.iter().flat_map(|t| t.points.iter().map(|p| p.1.abs()));
        let unit = stress.fold(0.0, f64::max);
        let half_shear = 0.5 * shear(tests)? / unit;
        let of =
            |t: &Test| -> Vec<_> { t.points.iter().map(|p| (t.mode, p.0, p.1 / unit)).collect() };
        Some(Self {
            candidate,
            points: tests.iter().flat_map(of).collect(),
            unit,
            ratio,
            half_shear,
        })
    }

    /// The best of what the starts lead to.
    fn best(&self) -> Option<Minimum> {
        let minima = self.starts().into_iter().filter_map(|(x, free)| self.minimize(&x, &free));
        minima.min_by(|a, b| a.sum.total_cmp(&b.sum))
    }

    /// Unknowns to start from, and which of them are free.
    fn starts(&self) -> Vec<(Vec<f64>, Vec<usize>)> {
        let n = self.candidate.unknowns();
        let all = |x: Vec<f64>| (x, (0..n).collect());
        match self.candidate.unknowns {
            Unknowns::Limit => vec![all(vec![2.0 * self.half_shear, START_OF_LIMIT])],
            Unknowns::Terms(exponents) => {
                self.ogden_starts(exponents).into_iter().map(all).collect()
            }
            Unknowns::Stresses { start, nonnegative } => {
                let start: Vec<f64> = start.iter().map(|s| s * self.half_shear).collect();
                if !nonnegative {
                    return vec![all(start)];
                }
                // an optimum under bounds has some unknowns at zero: try every choice
                let choice = |bits: usize| {
                    let free: Vec<usize> = (0..n).filter(|i| bits >> i & 1 == 1).collect();
                    let held = |i: usize| if free.contains(&i) { start[i] } else { 0.0 };
                    ((0..n).map(held).collect(), free)
                };
                (1..1 << n).map(choice).collect()
            }
        }
    }

    /// Equal terms, and the best fit with one term less beside a weak one.
    fn ogden_starts(&self, exponents: &[&[f64]]) -> Vec<Vec<f64>> {
        let terms = self.candidate.unknowns() / 2;
        let equal = |exponents: &&[f64]| {
            let s = (2.0 * self.half_shear / terms as f64).ln();
            std::iter::repeat_n(s, terms).chain(exponents.iter().copied()).collect()
        };
        let mut starts: Vec<Vec<f64>> = exponents.iter().map(equal).collect();
        let fewer = CANDIDATES.iter().find(|c| c.key == "ogden" && c.unknowns() + 2 == 2 * terms);
        let fewer = fewer.and_then(|candidate| Problem { candidate, ..self.clone() }.best());
        if let Some(Minimum { x, .. }) = fewer {
            let (s, alpha) = x.split_at(terms - 1);
            for extra in [-4.0, -1.5, 1.0, 6.0] {
                let weak = (0.1 * self.half_shear).ln();
                let s = s.iter().copied().chain([weak]);
                starts.push(s.chain(alpha.iter().copied()).chain([extra]).collect());
            }
        }
        starts
    }

    fn minimize(&self, start: &[f64], free: &[usize]) -> Option<Minimum> {
        let whole = |x: &[f64]| {
            let mut all = start.to_vec();
            free.iter().zip(x).for_each(|(&i, x)| all[i] = *x);
            all
        };
        let residuals = |x: &[f64]| {
            let all = whole(x);
            self.candidate.admissible(&all).then(|| self.residuals(&all, free))
        };
        let first: Vec<f64> = free.iter().map(|&i| start[i]).collect();
        let minimum = levenberg_marquardt(&first, residuals)?;
        Some(Minimum { x: whole(&minimum.x), sum: minimum.sum })
    }

    fn residuals(&self, unknowns: &[f64], free: &[usize]) -> Residuals {
        let parameters = self.candidate.parameters(unknowns);
        let mut values = parameters.clone();
        values.push((self.candidate.last)(&parameters, self.ratio));
        let material = (self.candidate.law().build)(&values);
        let mut r = DVector::zeros(self.points.len());
        let mut jacobian = DMatrix::zeros(self.points.len(), free.len());
        for (row, &(mode, stretch, stress)) in self.points.iter().enumerate() {
            r[row] = mode.nominal_stress(material.as_ref(), stretch) - stress;
            let mut gradient = vec![0.0; values.len()];
            mode.add_stress_gradient(material.as_ref(), stretch, &mut gradient);
            let gradient = self.candidate.chain(&parameters, &gradient[..parameters.len()]);
            for (column, &i) in free.iter().enumerate() {
                jacobian[(row, column)] = gradient[i];
            }
        }
        Residuals { r, jacobian }
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
