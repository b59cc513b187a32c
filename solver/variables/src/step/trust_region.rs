//! How far a quadratic model of the objective is trusted, and the step that minimises it there (method of Levenberg and
//! Marquardt).
//!
//! d = argmin g·d + ½ dᵀ B d   with   a_k·d ≥ −c_k,   motion(d) ≤ Δ
//!
//! B is the curvature along first-order changes of the runs (`design::Level::curvature`), updated
//! between two of these by y = g₊ − g (BFGS, damped), or that of [`Lbfgs`](super::Lbfgs). The region is kept by B + λ M in
//! place of B ([`Problem`]): what moves the surface far and gains little is held back first.
//!
//! Source: Nocedal and Wright 2006, "Numerical Optimization", chapters 4 and 10.3, procedure 18.2.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::{Minimum, Problem};

/// Smallest eigenvalue of a model relative to its largest. Its entries are off by about 1e-5, and so are the
/// directions that have no curvature: with less, the part of the gradient along these would be followed for a long way.
const LEAST_CURVATURE: f64 = 1e-6;
/// How much of the radius a step uses at least, where it is held back.
const USED: f64 = 0.8;
/// The first λ over the mean curvature.
const LEAST_SHIFT: f64 = 1e-8;
/// Part of the decrease of a step that a shorter one has to keep.
const NEARLY_ALL: f64 = 0.999;
/// Motion of a step that is taken for being shorter, over that of the other.
const MUCH_SHORTER: f64 = 0.9;
/// Most values of λ that are tried.
const SHIFTS: usize = 60;
/// Agreement of a model that is as good as exact: its region grows at once.
const EXACT: std::ops::Range<f64> = 0.9..1.1;
/// Agreement with a decrease above which a region grows, ...
const GOOD: f64 = 0.75;
/// ... and below which it shrinks.
const POOR: f64 = 0.25;
/// Motion over the radius of a step that the region holds back.
const HELD_BACK: f64 = 0.7;
/// Agreement of a model that is used once more.
const USABLE: std::ops::Range<f64> = 0.5..2.0;
/// Fraction of sᵀ B s that the curvature sᵀ y of an update has at least.
const DAMPING: f64 = 0.2;

/// The model at an accepted state, with how far it is trusted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrustRegion {
    /// Rows of B, one after the other; none before the first curvature.
    hessian: Vec<f64>,
    /// How far a step may move the surface; zero before the first step [m].
    pub radius: f64,
    /// Updates since the last curvature.
    age: usize,
    /// The decrease of the last step over what the model said [1].
    agreement: f64,
}

impl TrustRegion {
    /// As trusted as this one, without a model.
    pub fn without_model(&self) -> Self {
        Self { radius: self.radius, ..Self::default() }
    }

    /// Whether there is no model yet.
    pub fn is_empty(&self) -> bool {
        self.hessian.is_empty()
    }

    /// Whether there is a model that was updated at most `oldest` times and told the last decrease.
    pub fn is_good_for(&self, oldest: usize) -> bool {
        !self.is_empty() && self.age <= oldest && USABLE.contains(&self.agreement)
    }

    /// Takes in how the decrease along an accepted step agreed with the model, and how far it moved the surface [m].
    pub fn judge(&mut self, agreement: f64, motion: f64) {
        self.agreement = agreement;
        let is_held_back = motion > HELD_BACK * self.radius;
        if agreement < POOR {
            self.radius = 0.5 * motion;
        } else if is_held_back && EXACT.contains(&agreement) {
            self.radius *= 4.0;
        } else if is_held_back && agreement > GOOD {
            self.radius *= 2.0;
        }
    }

    /// Takes over a curvature without its negative part.
    pub fn renew(&mut self, curvature: &DMatrix<f64>) {
        let mut eigen = curvature.clone().symmetric_eigen();
        let least = LEAST_CURVATURE * eigen.eigenvalues.amax();
        eigen.eigenvalues.iter_mut().for_each(|e| *e = e.max(least));
        self.hessian = eigen.recompose().as_slice().to_vec();
        self.age = 0;
        self.agreement = 1.0;
    }

    /// The matrix B.
    pub fn matrix(&self) -> DMatrix<f64> {
        let n = self.hessian.len().isqrt();
        DMatrix::from_column_slice(n, n, &self.hessian)
    }

    /// Takes in an accepted step s and the change y of the gradient along it.
    pub fn update(&mut self, s: &[f64], y: &[f64]) {
        let mut hessian = self.matrix();
        let (s, y) = (DVector::from_column_slice(s), DVector::from_column_slice(y));
        let through = &hessian * &s;
        let (bend, own) = (s.dot(&through), s.dot(&y));
        if !(bend > 0.0 && own.is_finite()) {
            return;
        }
        let part = if own < DAMPING * bend { (1.0 - DAMPING) * bend / (bend - own) } else { 1.0 };
        let y = part * y + (1.0 - part) * &through;
        hessian += &y * y.transpose() / s.dot(&y) - &through * through.transpose() / bend;
        self.hessian = hessian.as_slice().to_vec();
        self.age += 1;
    }
}

/// The step that minimises the model under its inequalities and moves no farther than `radius`; none where the model
/// has no minimum.
pub fn step_within(
    problem: &Problem,
    radius: f64,
    motion: &dyn Fn(&[f64]) -> f64,
) -> Option<Minimum> {
    let first = LEAST_SHIFT * problem.mean_curvature();
    let free = problem.minimum(0.0).filter(|found| motion(&found.d) <= radius);
    if let Some(found) = free {
        return Some(shorter(problem, found, first, motion));
    }
    // the first λ of which there is a minimum and that keeps it within the region
    let (mut low, mut high, mut shifts) = (0.0, first, 0);
    let mut found = problem.minimum(high);
    while found.as_ref().is_none_or(|found| motion(&found.d) > radius) && shifts < SHIFTS {
        (low, high, shifts) = (high, 10.0 * high, shifts + 1);
        found = problem.minimum(high);
    }
    let mut found = found?;
    while low > 0.0 && motion(&found.d) < USED * radius && shifts < SHIFTS {
        let middle = (low * high).sqrt();
        match problem.minimum(middle) {
            Some(tried) if motion(&tried.d) <= radius => (high, found) = (middle, tried),
            _ => low = middle,
        }
        shifts += 1;
    }
    Some(shorter(problem, found, 10.0 * high, motion))
}

/// Another step that gains nearly as much as this one and is much shorter, of the largest λ from one on; else this one.
/// With more variables than targets a step may move far along directions that no target sees.
fn shorter(
    problem: &Problem,
    found: Minimum,
    mut shift: f64,
    motion: &dyn Fn(&[f64]) -> f64,
) -> Minimum {
    if !problem.model.is_full() {
        return found;
    }
    let enough = NEARLY_ALL * problem.change(&found.d);
    let at = |shift: f64| problem.minimum(shift).filter(|other| problem.change(&other.d) <= enough);
    let Some(mut shortest) = at(shift) else { return found };
    for _ in 0..SHIFTS {
        shift *= 10.0;
        let Some(next) = at(shift) else { break };
        shortest = next;
    }
    if motion(&shortest.d) < MUCH_SHORTER * motion(&found.d) { shortest } else { found }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::step::Model;

    fn largest(d: &[f64]) -> f64 {
        d.iter().fold(0.0, |most: f64, d| most.max(d.abs()))
    }

    /// A stiff and a soft direction, across both variables.
    fn valley() -> TrustRegion {
        let mut region = TrustRegion::default();
        region.renew(&DMatrix::from_row_slice(2, 2, &[101.0, 99.0, 99.0, 101.0]));
        region
    }

    /// The step of a region, with the change that its model says.
    fn step(region: &TrustRegion, gradient: &[f64], radius: f64) -> (Vec<f64>, f64) {
        let (model, metric) = (Model::full(region.matrix()), DMatrix::identity(2, 2));
        let problem = Problem::new(&model, gradient, &metric, &[], 1.0);
        let d = step_within(&problem, radius, &largest).unwrap().d;
        let change = problem.change(&d);
        (d, change)
    }

    /// Cut back to the same length, the step to the minimum would climb less far down: it goes along the soft direction.
    #[test]
    fn a_step_that_is_held_back_is_better_than_one_that_is_cut() {
        let (region, gradient) = (valley(), [3.0, 1.0]);
        let (whole, _) = step(&region, &gradient, f64::INFINITY);
        let (held, change) = step(&region, &gradient, 0.01);
        let length = largest(&held);
        assert!((0.008..=0.01).contains(&length), "{held:?}");
        let cut: Vec<f64> = whole.iter().map(|d| d * length / largest(&whole)).collect();
        let d = DVector::from_column_slice(&cut);
        let of_cut = 3.0 * cut[0] + cut[1] + 0.5 * d.dot(&(region.matrix() * &d));
        assert!(change < 1.2 * of_cut);
    }

    /// Both variables do the same for the one target, each in a motion of its own.
    #[test]
    fn of_steps_that_gain_the_same_the_shortest_is_taken() {
        let mut region = TrustRegion::default();
        region.renew(&DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]));
        // besides a slope that the curvature does not know
        let (d, change) = step(&region, &[1.0 + 1e-6, 1.0 - 1e-6], 1e3);
        assert!((d[0] + 0.5).abs() < 0.02 && (d[1] + 0.5).abs() < 0.02, "{d:?}");
        assert!(change < -0.499);
    }

    #[test]
    fn a_model_has_no_negative_curvature() {
        let mut region = TrustRegion::default();
        region.renew(&DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, -3.0]));
        let eigenvalues = region.matrix().symmetric_eigen().eigenvalues;
        assert!(eigenvalues.min() > 0.0 && (eigenvalues.max() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn an_update_takes_over_the_curvature_along_the_step() {
        let mut region = valley();
        let (s, y) = ([0.3, -0.1], [12.0, 4.0]);
        region.update(&s, &y);
        let through = region.matrix() * DVector::from_column_slice(&s);
        assert!((through - DVector::from_column_slice(&y)).norm() < 1e-10);
        assert_eq!(region.age, 1);
        // a curvature that is not positive is damped
        region.update(&s, &[-1.0, 1.0]);
        assert!(region.matrix().symmetric_eigen().eigenvalues.min() > 0.0);
    }
}
