//! Fades out pairs of edges where they become parallel, because their closest
//! points jump there.
//!
//! m(y) = y (2 − y) for y < 1, else 1,   y = sin²φ / 10⁻³
//!
//! φ   angle between the edges; sin²φ = |a × b|² / (|a|² |b|²) [1]
//!
//! Source: Li et al. 2020, doi:10.1145/3386569.3392425, eq. 24, here with both
//! lengths taken from the same shape as the cross product.

use mesh::Vec3;

/// sin²φ below which a pair is faded [1].
const THRESHOLD: f64 = 1e-3;

/// m of edges `x[0..2]` and `x[2..4]` [1] and ∂m/∂xᵢ [1/m]. Zero with zero
/// gradient if an edge has no length.
#[must_use]
pub fn mollifier(x: &[Vec3; 4]) -> (f64, [Vec3; 4]) {
    let (a, b) = (x[1] - x[0], x[3] - x[2]);
    let n = a.cross(&b);
    let (aa, bb) = (a.norm_squared(), b.norm_squared());
    let scale = THRESHOLD * aa * bb;
    if scale == 0.0 {
        return (0.0, [Vec3::zeros(); 4]);
    }
    let y = n.norm_squared() / scale;
    if y >= 1.0 {
        return (1.0, [Vec3::zeros(); 4]);
    }
    let slope = 2.0 * (1.0 - y);
    let da = slope * (b.cross(&n) * (2.0 / scale) - a * (2.0 * y / aa));
    let db = slope * (n.cross(&a) * (2.0 / scale) - b * (2.0 * y / bb));
    (y * (2.0 - y), [-da, da, -db, db])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    #[test]
    fn gradient_belongs_to_the_value_in_the_faded_range() {
        let mut random = Random::new(4);
        for scale in [1.0, 1e-3] {
            let mut faded = 0;
            for _ in 0..100 {
                let (p, a) = (random.vector(), random.vector());
                let b = a + 0.03 * random.vector();
                let x = [Vec3::zeros(), a, p, p + b].map(|v| v * scale);
                let (m, gradient) = mollifier(&x);
                faded += usize::from(m < 1.0);
                let h = 1e-7 * scale;
                for i in 0..4 {
                    for k in 0..3 {
                        let shifted = |s: f64| {
                            let mut y = x;
                            y[i][k] += s;
                            mollifier(&y).0
                        };
                        let difference = (shifted(h) - shifted(-h)) / (2.0 * h);
                        // m'' is of order 1/(10⁻³ scale²): the error is below
                        // rounding 1e-16/h plus h² m'''
                        let error = (difference - gradient[i][k]).abs() * scale;
                        assert!(error < 1e-4 * (1.0 + gradient[i].norm() * scale), "{error}");
                    }
                }
            }
            assert!(faded > 20, "only {faded} samples in the faded range");
        }
    }
}
