//! A quadratic model of the objective, and the step that minimises it within a trust region (method of Levenberg and
//! Marquardt).
//!
//! d = argmin gᵀ d + ½ dᵀ B d   with   l ≤ d ≤ u,   motion(d) ≤ Δ
//!
//! B is the curvature along first-order changes of the runs ([`Level::curvature`](super::Level::curvature)); between
//! two of these it is updated by y = g₊ − g (BFGS, damped). The region is kept by B + λ M in place of B, where
//! dᵀ M d is the mean square of the motion of the surface: what moves it far and gains little is held back first.
//!
//! Source: Nocedal and Wright 2006, "Numerical Optimization", chapters 4 and 10.3, procedure 18.2.

use mechanics::math::linear::dot;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Smallest eigenvalue of a model relative to its largest, where it has no curvature.
const LEAST_CURVATURE: f64 = 1e-8;
/// How much of the radius a step uses at least, where it is held back.
const USED: f64 = 0.8;
/// The first λ over the mean curvature.
const LEAST_SHIFT: f64 = 1e-8;
/// Part of the decrease of a step that a shorter one has to keep.
const NEARLY_ALL: f64 = 0.999;
/// Motion of a step that is taken for being shorter, over that of the other.
const MUCH_SHORTER: f64 = 0.9;
/// Sets of held variables that are tried, over the number of variables: random boxes of ten took 21 at most.
const SETS: usize = 20;
/// Most values of λ that are tried.
const SHIFTS: usize = 60;
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
    #[must_use]
    pub fn without_model(&self) -> Self {
        Self { radius: self.radius, ..Self::default() }
    }

    /// Whether there is no model yet.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.hessian.is_empty()
    }

    /// Whether there is a model that was updated at most `oldest` times and told the last decrease.
    #[must_use]
    pub fn is_good_for(&self, oldest: usize) -> bool {
        !self.is_empty() && self.age <= oldest && USABLE.contains(&self.agreement)
    }

    /// Takes in how the decrease along an accepted step agreed with the model, and how far it moved the surface [m].
    pub fn judge(&mut self, agreement: f64, motion: f64) {
        self.agreement = agreement;
        if agreement < POOR {
            self.radius = 0.5 * motion;
        } else if agreement > GOOD && motion > HELD_BACK * self.radius {
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
    #[must_use]
    pub fn matrix(&self) -> DMatrix<f64> {
        let n = self.hessian.len().isqrt();
        DMatrix::from_column_slice(n, n, &self.hessian)
    }

    /// gᵀ d + ½ dᵀ B d.
    #[must_use]
    pub fn change(&self, gradient: &[f64], d: &[f64]) -> f64 {
        let d = DVector::from_column_slice(d);
        dot(gradient, d.as_slice()) + 0.5 * d.dot(&(self.matrix() * &d))
    }

    /// The step that minimises the model within bounds on it, and moves no farther than `radius`; `metric` is M.
    #[must_use]
    pub fn step(
        &self,
        gradient: &[f64],
        bounds: &[[f64; 2]],
        metric: &DMatrix<f64>,
        radius: f64,
        motion: impl Fn(&[f64]) -> f64,
    ) -> Vec<f64> {
        let hessian = self.matrix();
        let at = |shift: f64| minimum(&(&hessian + shift * metric), gradient, bounds);
        let free = at(0.0);
        let mut high = LEAST_SHIFT * hessian.trace() / metric.trace();
        if motion(&free) <= radius {
            return self.shorter(gradient, free, high, at, motion);
        }
        let mut low = 0.0;
        let mut step = at(high);
        let mut shifts = 0;
        while motion(&step) > radius && shifts < SHIFTS {
            (low, high, shifts) = (high, 10.0 * high, shifts + 1);
            step = at(high);
        }
        while low > 0.0 && motion(&step) < USED * radius && shifts < SHIFTS {
            let middle = (low * high).sqrt();
            let tried = at(middle);
            if motion(&tried) > radius {
                low = middle;
            } else {
                (high, step) = (middle, tried);
            }
            shifts += 1;
        }
        self.shorter(gradient, step, 10.0 * high, at, motion)
    }

    /// Another step that gains nearly as much as this one and is much shorter, of the largest λ from one on; else
    /// this one. With more variables than targets a step may move far along directions that no target sees.
    fn shorter(
        &self,
        gradient: &[f64],
        step: Vec<f64>,
        mut shift: f64,
        at: impl Fn(f64) -> Vec<f64>,
        motion: impl Fn(&[f64]) -> f64,
    ) -> Vec<f64> {
        let enough = NEARLY_ALL * self.change(gradient, &step);
        let mut shortest = at(shift);
        let mut shifts = 0;
        while self.change(gradient, &at(10.0 * shift)) <= enough && shifts < SHIFTS {
            (shift, shifts) = (10.0 * shift, shifts + 1);
            shortest = at(shift);
        }
        let gains = self.change(gradient, &shortest) <= enough;
        if gains && motion(&shortest) < MUCH_SHORTER * motion(&step) { shortest } else { step }
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

/// argmin gᵀ d + ½ dᵀ A d within bounds around zero, A positive definite. It goes from zero to the minimum over what no
/// bound holds, as far as the next bound, and lets go of the bound that holds back most: every step descends, so that no
/// set of bounds comes twice (primal active sets, algorithm 16.3).
fn minimum(a: &DMatrix<f64>, gradient: &[f64], bounds: &[[f64; 2]]) -> Vec<f64> {
    let n = gradient.len();
    let gradient = DVector::from_column_slice(gradient);
    let (mut d, mut held) = (DVector::zeros(n), vec![false; n]);
    for _ in 0..SETS * n {
        let free: Vec<usize> = (0..n).filter(|&i| !held[i]).collect();
        let slope = (a * &d + &gradient).select_rows(&free);
        let Some(factor) = a.select_rows(&free).select_columns(&free).cholesky() else { break };
        let step = -factor.solve(&slope);
        let (mut share, mut blocking) = (1.0, None);
        for (&i, &s) in free.iter().zip(step.iter()) {
            let bound = bounds[i][usize::from(s > 0.0)];
            if s != 0.0 && (bound - d[i]) / s < share {
                (share, blocking) = (((bound - d[i]) / s).max(0.0), Some((i, bound)));
            }
        }
        free.iter().zip(step.iter()).for_each(|(&i, s)| d[i] += share * s);
        if let Some((i, bound)) = blocking {
            (held[i], d[i]) = (true, bound);
            continue;
        }
        let slope = a * &d + &gradient;
        let inward = |i: usize| if d[i] <= bounds[i][0] { -slope[i] } else { slope[i] };
        let pressed = (0..n).filter(|&i| held[i] && inward(i) > 0.0);
        let Some(i) = pressed.max_by(|&i, &j| inward(i).total_cmp(&inward(j))) else { break };
        held[i] = false;
    }
    d.as_slice().to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use mechanics::math::random::Random;

    /// Far out in each variable alone.
    const OPEN: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    fn largest(d: &[f64]) -> f64 {
        d.iter().fold(0.0, |most: f64, d| most.max(d.abs()))
    }

    /// A stiff and a soft direction, across both variables.
    fn valley() -> TrustRegion {
        let mut region = TrustRegion::default();
        region.renew(&DMatrix::from_row_slice(2, 2, &[101.0, 99.0, 99.0, 101.0]));
        region
    }

    #[test]
    fn a_near_minimum_is_reached_in_one_step() {
        let (region, gradient) = (valley(), [2.0, -2.0]);
        let d = region.step(&gradient, &[OPEN; 2], &DMatrix::identity(2, 2), 10.0, largest);
        assert!((d[0] + 1.0).abs() < 1e-12 && (d[1] - 1.0).abs() < 1e-12, "{d:?}");
        assert!((region.change(&gradient, &d) + 2.0).abs() < 1e-12);
    }

    /// Cut back to the same length, the step to the minimum would climb less far down: it goes along the soft direction.
    #[test]
    fn a_step_that_is_held_back_is_better_than_one_that_is_cut() {
        let (region, gradient) = (valley(), [3.0, 1.0]);
        let metric = DMatrix::identity(2, 2);
        let whole = region.step(&gradient, &[OPEN; 2], &metric, f64::INFINITY, largest);
        let held = region.step(&gradient, &[OPEN; 2], &metric, 0.01, largest);
        let length = largest(&held);
        assert!((0.008..=0.01).contains(&length), "{held:?}");
        let cut: Vec<f64> = whole.iter().map(|d| d * length / largest(&whole)).collect();
        assert!(region.change(&gradient, &held) < 1.2 * region.change(&gradient, &cut));
    }

    #[test]
    fn a_step_keeps_to_its_bounds_and_is_the_least_there() {
        let (region, gradient) = (valley(), [2.0, -2.0]);
        let bounds = [[-0.25, 0.5], OPEN];
        let d = region.step(&gradient, &bounds, &DMatrix::identity(2, 2), 10.0, largest);
        // with d₀ = −1/4 held: 101 d₁ = 2 + 99/4
        assert!((d[0] + 0.25).abs() < 1e-12 && (d[1] - 26.75 / 101.0).abs() < 1e-12, "{d:?}");
    }

    /// Condition numbers up to 1e8. Where all violated bounds were taken at once, a fifth of such boxes had no end.
    #[test]
    fn no_box_is_without_its_least_step() {
        let mut random = Random::new(7);
        for _ in 0..500 {
            let n = 10;
            let q = DMatrix::from_vec(n, n, random.numbers(n * n)).qr().q();
            let curvature = DVector::from_fn(n, |i, _| 10.0_f64.powf(-8.0 * i as f64 / 9.0));
            let a = &q * DMatrix::from_diagonal(&curvature) * q.transpose();
            let gradient = random.numbers(n);
            let ends = random.numbers(2 * n);
            let bounds: Vec<[f64; 2]> = ends.chunks(2).map(|e| [-e[0].abs(), e[1].abs()]).collect();
            let d = minimum(&a, &gradient, &bounds);
            let slope = &a * DVector::from_column_slice(&d) + DVector::from_column_slice(&gradient);
            for i in 0..n {
                let [low, high] = bounds[i];
                let further = (d[i] - slope[i]).clamp(low, high);
                assert!((further - d[i]).abs() < 1e-9, "{i}: {} within {:?}", d[i], bounds[i]);
            }
        }
    }

    /// Both variables do the same for the one target, each in a motion of its own.
    #[test]
    fn of_steps_that_gain_the_same_the_shortest_is_taken() {
        let mut region = TrustRegion::default();
        region.renew(&DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]));
        // besides a slope that the curvature does not know
        let gradient = [1.0 + 1e-6, 1.0 - 1e-6];
        let d = region.step(&gradient, &[OPEN; 2], &DMatrix::identity(2, 2), 1e3, largest);
        assert!((d[0] + 0.5).abs() < 0.02 && (d[1] + 0.5).abs() < 0.02, "{d:?}");
        assert!(region.change(&gradient, &d) < -0.499);
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
