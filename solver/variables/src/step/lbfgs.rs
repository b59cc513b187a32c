//! Limited-memory BFGS (L-BFGS): a model of the objective from the gradients of the last few steps.
//!
//! B = θ I − W K Wᵀ,  W = [Y  θS],  K = [−D  Lᵀ; L  θSᵀS]⁻¹,  θ = y·y / s·y of the last pair
//!
//! S, Y   steps s = θ₊ − θ and changes y = g₊ − g of the gradient, oldest first, as columns
//! D, L   diagonal and strict lower triangle of SᵀY
//!
//! Only the memory is held here, as plain data, so that an optimisation can be stopped and continued with the same
//! numbers.
//!
//! Source: Nocedal and Wright 2006, "Numerical Optimization", section 7.2.

use std::collections::VecDeque;

use mechanics::math::linear::{dot, norm};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::Model;

/// Pairs that are remembered.
const MEMORY: usize = 6;
/// cos of the angle between s and y below which a pair is left out: its
/// curvature is not positive, or drowned in rounding [1].
const CURVATURE: f64 = 1e-8;

/// A step and the change of the gradient along it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Pair {
    /// θ₊ − θ.
    pub s: Vec<f64>,
    /// g₊ − g.
    pub y: Vec<f64>,
}

/// The memory of the last steps, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lbfgs {
    pairs: VecDeque<Pair>,
}

impl Lbfgs {
    /// Whether there is no pair, so that nothing is known of the curvature.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// B; none without pairs.
    pub fn model(&self) -> Option<Model> {
        let pairs: Vec<&Pair> = self.pairs.iter().collect();
        // the oldest pair is dropped where the small matrix is singular in rounding
        (0..pairs.len()).find_map(|first| of_pairs(&pairs[first..]))
    }

    /// Takes in an accepted step and the change of the gradient, unless the
    /// curvature along it is not positive. Forgets the oldest pair when full.
    pub fn update(&mut self, s: Vec<f64>, y: Vec<f64>) {
        if dot(&s, &y) > CURVATURE * norm(&s) * norm(&y) {
            self.pairs.push_back(Pair { s, y });
            if self.pairs.len() > MEMORY {
                self.pairs.pop_front();
            }
        }
    }
}

fn of_pairs(pairs: &[&Pair]) -> Option<Model> {
    let last = pairs.last()?;
    let (m, n) = (pairs.len(), last.s.len());
    let theta = dot(&last.y, &last.y) / dot(&last.s, &last.y);
    let w =
        DMatrix::from_fn(
            n,
            2 * m,
            |i, k| {
                if k < m { pairs[k].y[i] } else { theta * pairs[k - m].s[i] }
            },
        );
    let inner = DMatrix::from_fn(2 * m, 2 * m, |i, j| match (i < m, j < m) {
        (true, true) if i == j => -dot(&pairs[i].s, &pairs[i].y),
        (true, true) => 0.0,
        (false, false) => theta * dot(&pairs[i - m].s, &pairs[j - m].s),
        (is_upper, _) => {
            // L_ij = s_i · y_j for i > j
            let (i, j) = if is_upper { (j - m, i) } else { (i - m, j) };
            if i > j { dot(&pairs[i].s, &pairs[j].y) } else { 0.0 }
        }
    });
    // rows and columns of one size, as steps may differ by orders
    let scale = DVector::from_fn(2 * m, |i, _| inner[(i, i)].abs().sqrt().recip());
    let scaled = DMatrix::from_fn(2 * m, 2 * m, |i, j| scale[i] * inner[(i, j)] * scale[j]);
    let inverse = scaled.try_inverse()?;
    let middle = DMatrix::from_fn(2 * m, 2 * m, |i, j| scale[i] * inverse[(i, j)] * scale[j]);
    let model = Model::limited(theta, &w, &middle);
    (middle.iter().all(|v| v.is_finite()) && model.is_positive()).then_some(model)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::step::Problem;

    /// The direction to the minimum of the model.
    fn direction(lbfgs: &Lbfgs, gradient: &[f64]) -> Vec<f64> {
        let n = gradient.len();
        let (model, metric) =
            (lbfgs.model().unwrap_or(Model::round(n, 1.0)), DMatrix::identity(n, n));
        let problem = Problem::new(&model, gradient, &metric, &[], 1.0);
        problem.minimum(0.0).unwrap().d
    }

    /// With exact line searches the directions are conjugate, so that a
    /// quadratic of n variables is minimised in n steps.
    #[test]
    fn a_quadratic_takes_as_many_steps_as_it_has_variables() {
        let curvature = [1.0, 3.0, 10.0, 40.0, 200.0];
        let gradient = |x: &[f64]| -> Vec<f64> {
            x.iter().zip(&curvature).map(|(x, c)| c * (x - 1.0)).collect()
        };
        let (mut lbfgs, mut x) = (Lbfgs::default(), vec![0.0; 5]);
        for _ in 0..5 {
            let g = gradient(&x);
            let p = direction(&lbfgs, &g);
            let bend: f64 = p.iter().zip(&curvature).map(|(p, c)| c * p * p).sum();
            let alpha = -dot(&g, &p) / bend;
            x.iter_mut().zip(&p).for_each(|(x, p)| *x += alpha * p);
            let y = p.iter().zip(&curvature).map(|(p, c)| alpha * c * p).collect();
            lbfgs.update(p.iter().map(|p| alpha * p).collect(), y);
        }
        assert!(norm(&gradient(&x)) < 1e-8, "{x:?}");
    }

    #[test]
    fn pairs_without_positive_curvature_are_left_out() {
        let mut lbfgs = Lbfgs::default();
        lbfgs.update(vec![1.0, 0.0], vec![-1.0, 0.0]);
        lbfgs.update(vec![1.0, 0.0], vec![0.0, 1.0]);
        lbfgs.update(vec![0.0, 0.0], vec![0.0, 0.0]);
        lbfgs.update(vec![1.0, 0.0], vec![f64::NAN, 0.0]);
        assert!(lbfgs.is_empty());
        assert_eq!(direction(&lbfgs, &[3.0, -2.0]), vec![-3.0, 2.0]);
    }

    /// One iteration with halving until Rosenbrock's function falls enough.
    fn iterate(lbfgs: &mut Lbfgs, x: &[f64]) -> Vec<f64> {
        let g = rosenbrock_gradient(x);
        let p = direction(lbfgs, &g);
        let slope = dot(&g, &p);
        assert!(slope < 0.0);
        let mut alpha = if lbfgs.is_empty() { 1e-3 } else { 1.0 };
        loop {
            let next: Vec<f64> = x.iter().zip(&p).map(|(x, p)| x + alpha * p).collect();
            if rosenbrock(&next) <= rosenbrock(x) + 1e-4 * alpha * slope {
                let y = rosenbrock_gradient(&next).iter().zip(&g).map(|(a, b)| a - b).collect();
                lbfgs.update(p.iter().map(|p| alpha * p).collect(), y);
                return next;
            }
            alpha *= 0.5;
        }
    }

    fn rosenbrock(x: &[f64]) -> f64 {
        100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2)
    }

    fn rosenbrock_gradient(x: &[f64]) -> Vec<f64> {
        let valley = 200.0 * (x[1] - x[0] * x[0]);
        vec![-2.0 * x[0] * valley - 2.0 * (1.0 - x[0]), valley]
    }

    #[test]
    fn rosenbrocks_valley_is_followed_to_its_end() {
        let (mut lbfgs, mut x) = (Lbfgs::default(), vec![-1.2, 1.0]);
        let mut iterations = 0;
        while norm(&rosenbrock_gradient(&x)) > 1e-8 {
            x = iterate(&mut lbfgs, &x);
            iterations += 1;
            assert!(iterations < 60);
        }
        assert!((x[0] - 1.0).abs() < 1e-8 && (x[1] - 1.0).abs() < 1e-8);
    }
}
