//! Quadrature with positive weights on triangle and tetrahedron.
//!
//! Weights sum to 1 and are multiplied by the simplex' area [m²] or volume
//! [m³].
//!
//! Up to degree 5: symmetric rules of 7 and 14 points. Above: conical products
//! of Gauss–Jacobi rules, ∫_T f = ∫₀¹ (1 − s)^{d−1} ∫_{T'} f(s, (1 − s) y) dy ds,
//! with ⌈(degree + 1)/2⌉ points per direction.
//!
//! Sources: triangle, 7 points: Radon 1948; tetrahedron, 14 points: Walkington
//! 2000, "Quadrature on simplices of arbitrary dimension"; conical products:
//! Stroud 1971, "Approximate Calculation of Multiple Integrals", section 2.4;
//! Gauss–Jacobi nodes from the recurrence: Golub and Welsch 1969,
//! doi:10.1090/S0025-5718-69-99647-1.

use nalgebra::DMatrix;

/// Degree to which energies are integrated unless a scene says otherwise.
pub const DEFAULT_DEGREE: usize = 5;

/// A quadrature rule in barycentric coordinates.
pub struct Rule {
    /// Fractions of the simplex' measure.
    pub weights: Vec<f64>,
    /// Barycentric coordinates, one more than the dimension.
    pub points: Vec<Vec<f64>>,
}

impl Rule {
    /// The points of which all coordinates but one are `a`.
    fn add_orbit(&mut self, corners: usize, a: f64, weight: f64) {
        for k in 0..corners {
            let mut point = vec![a; corners];
            point[k] = 1.0 - (corners - 1) as f64 * a;
            self.points.push(point);
            self.weights.push(weight);
        }
    }
}

/// A rule on the triangle that is exact to `degree`.
pub fn triangle(degree: usize) -> Rule {
    if degree <= 5 { radon() } else { conical(2, degree) }
}

/// A rule on the tetrahedron that is exact to `degree`.
pub fn tetrahedron(degree: usize) -> Rule {
    if degree <= 5 { walkington() } else { conical(3, degree) }
}

/// 7 points, exact to degree 5.
fn radon() -> Rule {
    let root = 15.0_f64.sqrt();
    let mut rule = Rule { weights: vec![9.0 / 40.0], points: vec![vec![1.0 / 3.0; 3]] };
    for sign in [-1.0, 1.0] {
        rule.add_orbit(3, (6.0 + sign * root) / 21.0, (155.0 + sign * root) / 1200.0);
    }
    rule
}

/// 14 points, exact to degree 5.
fn walkington() -> Rule {
    let mut rule = Rule { weights: Vec::new(), points: Vec::new() };
    rule.add_orbit(4, 0.092_735_250_310_891_23, 0.073_493_043_116_361_95);
    rule.add_orbit(4, 0.310_885_919_263_300_6, 0.112_687_925_718_015_85);
    let (b, weight) = (0.045_503_704_125_649_65, 0.042_546_020_777_081_47);
    for first in 0..4 {
        for second in first + 1..4 {
            let mut point = vec![0.5 - b; 4];
            point[first] = b;
            point[second] = b;
            rule.points.push(point);
            rule.weights.push(weight);
        }
    }
    rule
}

/// The conical product on a simplex of a dimension.
fn conical(dimension: usize, degree: usize) -> Rule {
    let mut rule = Rule { weights: vec![1.0], points: vec![vec![1.0]] };
    for d in 1..=dimension {
        let cone = gauss_jacobi(degree / 2 + 1, d - 1);
        let mut next = Rule { weights: Vec::new(), points: Vec::new() };
        for (&(s, factor), (point, weight)) in
            cone.iter().flat_map(|c| rule.points.iter().zip(&rule.weights).map(move |p| (c, p)))
        {
            // the apex has weight s, the face of the lower rule 1 − s
            let mut lambda: Vec<f64> = point.iter().map(|l| (1.0 - s) * l).collect();
            lambda.push(s);
            next.points.push(lambda);
            next.weights.push(factor * weight);
        }
        rule = next;
    }
    rule
}

/// Nodes in (0, 1) and weights of sum 1 for the weight function (1 − s)^a:
/// eigenvalues and squared first components of the Jacobi matrix of the
/// orthogonal polynomials.
pub(crate) fn gauss_jacobi(points: usize, a: usize) -> Vec<(f64, f64)> {
    let a = a as f64;
    let mut jacobi = DMatrix::zeros(points, points);
    for k in 0..points {
        // on (−1, 1) with the weight (1 − x)^a; s = (1 + x)/2
        let n = k as f64;
        let denominator = (2.0 * n + a) * (2.0 * n + a + 2.0);
        jacobi[(k, k)] = if a == 0.0 { 0.0 } else { -a * a / denominator };
        if k > 0 {
            let c = 2.0 * n + a;
            let square = 4.0 * n * n * (n + a) * (n + a) / (c * c * (c * c - 1.0));
            jacobi[(k, k - 1)] = square.sqrt();
            jacobi[(k - 1, k)] = square.sqrt();
        }
    }
    let eigen = jacobi.symmetric_eigen();
    let mut rule: Vec<_> = (0..points)
        .map(|i| (0.5 * (1.0 + eigen.eigenvalues[i]), eigen.eigenvectors[(0, i)].powi(2)))
        .collect();
    rule.sort_by(|x, y| x.0.total_cmp(&y.0));
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: i32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    /// ∫ Π λ_k^{e_k} over the simplex of dimension d, divided by its measure:
    /// d! Π e_k! / (d + Σ e_k)!
    fn exact(exponents: &[i32]) -> f64 {
        let d = exponents.len() as i32 - 1;
        let product: f64 = exponents.iter().map(|&e| factorial(e)).product();
        factorial(d) * product / factorial(d + exponents.iter().sum::<i32>())
    }

    fn integrate(rule: &Rule, exponents: &[i32]) -> f64 {
        let monomial =
            |p: &Vec<f64>| p.iter().zip(exponents).map(|(l, &e)| l.powi(e)).product::<f64>();
        rule.points.iter().zip(&rule.weights).map(|(p, w)| w * monomial(p)).sum()
    }

    #[test]
    fn rules_are_positive_and_exact_to_their_degree() {
        for degree in [5, 6, 7, 8, 9, 10] {
            let (tri, tet) = (triangle(degree), tetrahedron(degree));
            assert!(tri.weights.iter().chain(&tet.weights).all(|&w| w > 0.0));
            assert!(tri.points.iter().chain(&tet.points).flatten().all(|&l| l > 0.0));
            let degree = degree as i32;
            for i in 0..=degree {
                for j in 0..=degree - i {
                    for k in 0..=degree - i - j {
                        let e = [0, i, j, k];
                        assert!((integrate(&tet, &e) - exact(&e)).abs() < 2e-15, "{degree} {e:?}");
                        let e = &e[..3];
                        assert!((integrate(&tri, e) - exact(e)).abs() < 2e-15, "{degree} {e:?}");
                    }
                }
            }
        }
    }
}
