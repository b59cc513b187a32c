//! Limited-memory BFGS (L-BFGS), a quasi-Newton method: a descent direction from the last
//! few steps.
//!
//! p = −H g,   H ≈ (∂²J/∂θ²)⁻¹ by the two-loop recursion over pairs
//! s = θ₊ − θ,  y = g₊ − g,   started from H₀ = (s·y / y·y) I of the last pair
//!
//! Only the memory is held here; line search and evaluations are the caller's.
//! The state is plain data, so that an optimisation can be stopped and continued
//! with the same numbers.
//!
//! Source: Nocedal and Wright 2006, "Numerical Optimization", algorithm 7.4.

use std::collections::VecDeque;

use mechanics::math::linear::{dot, norm};
use serde::{Deserialize, Serialize};

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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lbfgs {
    memory: usize,
    pairs: VecDeque<Pair>,
}

impl Lbfgs {
    /// Remembers up to `memory` pairs, none yet.
    #[must_use]
    pub fn new(memory: usize) -> Self {
        Self { memory, pairs: VecDeque::new() }
    }

    /// Whether there is no pair, so that the direction is −g and its length
    /// says nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// The pairs, oldest first.
    pub(super) fn pairs(&self) -> impl Iterator<Item = &Pair> {
        self.pairs.iter()
    }

    /// The descent direction −H g.
    #[must_use]
    pub fn direction(&self, gradient: &[f64]) -> Vec<f64> {
        let mut p: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let mut alphas = Vec::with_capacity(self.pairs.len());
        for Pair { s, y } in self.pairs.iter().rev() {
            let alpha = dot(s, &p) / dot(s, y);
            add(&mut p, -alpha, y);
            alphas.push(alpha);
        }
        if let Some(Pair { s, y }) = self.pairs.back() {
            let scale = dot(s, y) / dot(y, y);
            p.iter_mut().for_each(|x| *x *= scale);
        }
        for (Pair { s, y }, alpha) in self.pairs.iter().zip(alphas.into_iter().rev()) {
            let beta = dot(y, &p) / dot(s, y);
            add(&mut p, alpha - beta, s);
        }
        p
    }

    /// Takes in an accepted step and the change of the gradient, unless the
    /// curvature along it is not positive. Forgets the oldest pair when full.
    pub fn update(&mut self, s: Vec<f64>, y: Vec<f64>) {
        if dot(&s, &y) > CURVATURE * norm(&s) * norm(&y) {
            self.pairs.push_back(Pair { s, y });
            if self.pairs.len() > self.memory {
                self.pairs.pop_front();
            }
        }
    }
}

/// x += a y.
fn add(x: &mut [f64], a: f64, y: &[f64]) {
    for (x, y) in x.iter_mut().zip(y) {
        *x += a * y;
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    type Value = fn(&[f64]) -> f64;
    type Gradient = fn(&[f64]) -> Vec<f64>;

    /// One iteration with halving until the value falls enough.
    fn iterate(lbfgs: &mut Lbfgs, x: &[f64], value: Value, gradient: Gradient) -> Vec<f64> {
        let g = gradient(x);
        let p = lbfgs.direction(&g);
        let slope = dot(&g, &p);
        assert!(slope < 0.0);
        let mut alpha = if lbfgs.is_empty() { 1e-3 } else { 1.0 };
        loop {
            let next: Vec<f64> = x.iter().zip(&p).map(|(x, p)| x + alpha * p).collect();
            if value(&next) <= value(x) + 1e-4 * alpha * slope {
                let y = gradient(&next).iter().zip(&g).map(|(a, b)| a - b).collect();
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
        let (mut lbfgs, mut x) = (Lbfgs::new(6), vec![-1.2, 1.0]);
        let mut iterations = 0;
        while norm(&rosenbrock_gradient(&x)) > 1e-8 {
            x = iterate(&mut lbfgs, &x, rosenbrock, rosenbrock_gradient);
            iterations += 1;
            assert!(iterations < 60);
        }
        assert!((x[0] - 1.0).abs() < 1e-8 && (x[1] - 1.0).abs() < 1e-8);
    }

    /// With exact line searches the directions are conjugate, so that a
    /// quadratic of n variables is minimised in n steps.
    #[test]
    fn a_quadratic_takes_as_many_steps_as_it_has_variables() {
        let curvature = [1.0, 3.0, 10.0, 40.0, 200.0];
        let gradient = |x: &[f64]| -> Vec<f64> {
            x.iter().zip(&curvature).map(|(x, c)| c * (x - 1.0)).collect()
        };
        let (mut lbfgs, mut x) = (Lbfgs::new(6), vec![0.0; 5]);
        for _ in 0..5 {
            let g = gradient(&x);
            let p = lbfgs.direction(&g);
            let bend: f64 = p.iter().zip(&curvature).map(|(p, c)| c * p * p).sum();
            let alpha = -dot(&g, &p) / bend;
            add(&mut x, alpha, &p);
            let y = p.iter().zip(&curvature).map(|(p, c)| alpha * c * p).collect();
            lbfgs.update(p.iter().map(|p| alpha * p).collect(), y);
        }
        assert!(norm(&gradient(&x)) < 1e-9, "{x:?}");
    }

    #[test]
    fn pairs_without_positive_curvature_are_left_out() {
        let mut lbfgs = Lbfgs::new(2);
        lbfgs.update(vec![1.0, 0.0], vec![-1.0, 0.0]);
        lbfgs.update(vec![1.0, 0.0], vec![0.0, 1.0]);
        lbfgs.update(vec![0.0, 0.0], vec![0.0, 0.0]);
        lbfgs.update(vec![1.0, 0.0], vec![f64::NAN, 0.0]);
        assert!(lbfgs.is_empty());
        assert_eq!(lbfgs.direction(&[3.0, -2.0]), vec![-3.0, 2.0]);
    }

    #[test]
    fn a_stored_state_goes_on_with_the_same_bits() {
        let (mut a, mut x) = (Lbfgs::new(6), vec![-1.2, 1.0]);
        for _ in 0..10 {
            x = iterate(&mut a, &x, rosenbrock, rosenbrock_gradient);
        }
        let text = serde_json::to_string(&(&a, &x)).unwrap();
        let (mut b, mut z): (Lbfgs, Vec<f64>) = serde_json::from_str(&text).unwrap();
        for _ in 0..10 {
            x = iterate(&mut a, &x, rosenbrock, rosenbrock_gradient);
            z = iterate(&mut b, &z, rosenbrock, rosenbrock_gradient);
        }
        assert_eq!(x, z);
    }
}
