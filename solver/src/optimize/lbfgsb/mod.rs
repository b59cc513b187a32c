//! Limited-memory BFGS within bounds (L-BFGS-B): the minimiser of the model in a box.
//!
//! m(z) = g·(z − x) + ½ (z − x)ᵀ B (z − x)     over l ≤ z ≤ u
//!
//! B = θ I − W M Wᵀ,  W = [Y  θS],  M = [−D  Lᵀ; L  θSᵀS]⁻¹,  θ = y·y / s·y
//!
//! S, Y   steps and changes of the gradient, oldest first, as columns
//! D, L   diagonal and strict lower triangle of SᵀY
//!
//! B is the inverse of what [`Lbfgs::direction`] applies. The minimiser is found by
//! turns: along the projected gradient to its first minimum, the Cauchy point, and
//! from there in the space of the variables that are not at a bound, until the
//! projected gradient of the model vanishes. Each turn lowers m, which is convex.
//! Bounds of the problem and of the change in one iteration are one box, their
//! intersection.
//!
//! Source: Byrd, Lu, Nocedal and Zhu 1995, doi:10.1137/0916069, whose method is the
//! first turn.

use mechanics::math::linear::dot;
use nalgebra::{DMatrix, DVector};

use super::Lbfgs;
use super::lbfgs::Pair;

/// Most turns in search of the active set; two or three are usual.
const TURNS: usize = 50;

/// Projected gradient of the model, relative to that at the start, that counts as
/// zero [1].
const ZERO: f64 = 1e-10;

impl Lbfgs {
    /// The minimiser of the model of J about `x` with gradient `g`, within bounds:
    /// `x` is brought within them first. Without pairs B is the identity, so that
    /// the length of the step says nothing.
    ///
    /// # Panics
    /// When lengths differ or a lower bound is above its upper one.
    #[must_use]
    pub fn step(&self, x: &[f64], g: &[f64], lower: &[f64], upper: &[f64]) -> Vec<f64> {
        assert!(x.len() == g.len() && x.len() == lower.len() && x.len() == upper.len());
        assert!(lower.iter().zip(upper).all(|(l, u)| l <= u), "a lower bound above its upper one");
        let (model, bounds) = (Model::new(self), Bounds { lower, upper });
        let from = DVector::from_column_slice(x);
        let start: Vec<f64> =
            x.iter().zip(lower).zip(upper).map(|((x, l), u)| x.clamp(*l, *u)).collect();
        let mut z = DVector::from_vec(start);
        let gradient = |z: &DVector<f64>| DVector::from_column_slice(g) + model.times(&(z - &from));
        let wanted =
            ZERO * projected_gradient_norm(z.as_slice(), gradient(&z).as_slice(), lower, upper);
        for _ in 0..TURNS {
            let slope = gradient(&z);
            if projected_gradient_norm(z.as_slice(), slope.as_slice(), lower, upper) <= wanted {
                break;
            }
            bounds.to_cauchy_point(&model, &mut z, &slope);
            let slope = gradient(&z);
            bounds.to_subspace_minimum(&model, &mut z, &slope);
        }
        z.as_slice().to_vec()
    }
}

/// The largest component of P(x − g) − x, P the projection on the box: zero exactly
/// where no step within the bounds descends.
#[must_use]
pub fn projected_gradient_norm(x: &[f64], g: &[f64], lower: &[f64], upper: &[f64]) -> f64 {
    let one = |i: usize| ((x[i] - g[i]).clamp(lower[i], upper[i]) - x[i]).abs();
    (0..x.len()).map(one).fold(0.0, f64::max)
}

/// B.
struct Model {
    theta: f64,
    /// W and M; none without pairs.
    w: Option<(DMatrix<f64>, DMatrix<f64>)>,
}

impl Model {
    fn new(memory: &Lbfgs) -> Self {
        let pairs: Vec<&Pair> = memory.pairs().collect();
        // the oldest pair is dropped where the small matrix is singular in rounding
        (0..pairs.len())
            .find_map(|first| Self::of(&pairs[first..]))
            .unwrap_or(Self { theta: 1.0, w: None })
    }

    fn of(pairs: &[&Pair]) -> Option<Self> {
        let last = pairs.last()?;
        let (m, n) = (pairs.len(), last.s.len());
        let theta = dot(&last.y, &last.y) / dot(&last.s, &last.y);
        let w = DMatrix::from_fn(n, 2 * m, |i, k| {
            if k < m { pairs[k].y[i] } else { theta * pairs[k - m].s[i] }
        });
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
        middle.iter().all(|v| v.is_finite()).then_some(Self { theta, w: Some((w, middle)) })
    }

    /// B d.
    fn times(&self, d: &DVector<f64>) -> DVector<f64> {
        let Some((w, m)) = &self.w else { return d * self.theta };
        d * self.theta - w * (m * (w.tr_mul(d)))
    }

    /// Solves B d = r in the space of some variables, by Woodbury's formula.
    fn solve_within(&self, free: &[usize], r: &DVector<f64>) -> Option<DVector<f64>> {
        let Some((w, m)) = &self.w else { return Some(r / self.theta) };
        let own = w.select_rows(free);
        let size = own.ncols();
        let inner = DMatrix::identity(size, size) - m * own.tr_mul(&own) / self.theta;
        let right = m * own.tr_mul(r) / self.theta;
        let v = inner.lu().solve(&right)?;
        Some((r + own * v) / self.theta)
    }
}

/// The bounds.
struct Bounds<'a> {
    lower: &'a [f64],
    upper: &'a [f64],
}

impl Bounds<'_> {
    /// From `z` along the path of the projected gradient to the first minimum of the
    /// model. Between the breakpoints at which variables meet their bounds, the path
    /// is straight and the model a parabola.
    fn to_cauchy_point(&self, model: &Model, z: &mut DVector<f64>, gradient: &DVector<f64>) {
        let bound = |i: usize| if gradient[i] < 0.0 { self.upper[i] } else { self.lower[i] };
        let meets = |i: usize| {
            if gradient[i] == 0.0 { f64::INFINITY } else { (z[i] - bound(i)) / gradient[i] }
        };
        let mut breaks: Vec<(f64, usize)> = (0..z.len()).map(|i| (meets(i), i)).collect();
        breaks.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut direction = -gradient;
        breaks.iter().filter(|b| b.0 <= 0.0).for_each(|b| direction[b.1] = 0.0);
        let mut next = breaks.iter().copied().filter(|b| b.0 > 0.0).peekable();
        let (mut gone, mut slope) = (0.0, gradient.clone());
        while direction.iter().any(|d| *d != 0.0) {
            let bent = model.times(&direction);
            let (descent, curvature) = (slope.dot(&direction), direction.dot(&bent));
            let minimum = if curvature > 0.0 { -descent / curvature } else { f64::INFINITY };
            let until = next.peek().map_or(f64::INFINITY, |b| b.0 - gone).max(0.0);
            if descent >= 0.0 || (minimum.is_infinite() && until.is_infinite()) {
                return;
            }
            let length = minimum.clamp(0.0, until);
            z.axpy(length, &direction, 1.0);
            slope.axpy(length, &bent, 1.0);
            if minimum < until {
                return;
            }
            gone += until;
            while let Some((_, i)) = next.next_if(|b| b.0 <= gone) {
                z[i] = bound(i);
                direction[i] = 0.0;
            }
        }
    }

    /// From `z` towards the minimum of the model over the variables that are not at
    /// a bound, up to the first bound.
    fn to_subspace_minimum(&self, model: &Model, z: &mut DVector<f64>, gradient: &DVector<f64>) {
        let inside = |&i: &usize| z[i] > self.lower[i] && z[i] < self.upper[i];
        let free: Vec<usize> = (0..z.len()).filter(inside).collect();
        if free.is_empty() {
            return;
        }
        let right = DVector::from_fn(free.len(), |k, _| -gradient[free[k]]);
        let Some(step) = model.solve_within(&free, &right) else { return };
        if !step.iter().all(|d| d.is_finite()) || step.dot(&right) <= 0.0 {
            return;
        }
        let limit = |k: usize| {
            let bound = if step[k] > 0.0 { self.upper[free[k]] } else { self.lower[free[k]] };
            if step[k] == 0.0 { f64::INFINITY } else { (bound - z[free[k]]) / step[k] }
        };
        let limits: Vec<f64> = (0..free.len()).map(limit).collect();
        let length = limits.iter().copied().fold(1.0, f64::min);
        for (k, &i) in free.iter().enumerate() {
            // exactly at the bound, or the variable would count as free
            let bound = if step[k] > 0.0 { self.upper[i] } else { self.lower[i] };
            z[i] = if limits[k] <= length { bound } else { z[i] + length * step[k] };
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
