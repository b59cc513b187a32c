//! Degree-5 quadrature with positive weights on triangle and tetrahedron.
//!
//! Weights sum to 1 and are multiplied by the simplex' area [m²] or volume
//! [m³].
//!
//! Sources: triangle, 7 points: Radon 1948; tetrahedron, 14 points: Walkington
//! 2000, "Quadrature on simplices of arbitrary dimension".

/// A quadrature rule in barycentric coordinates.
pub struct Rule {
    /// Fractions of the simplex' measure.
    pub weights: Vec<f64>,
    /// Barycentric coordinates, one more than the dimension.
    pub points: Vec<Vec<f64>>,
}

/// 7 points, exact to degree 5.
#[must_use]
pub fn triangle() -> Rule {
    let root = 15.0_f64.sqrt();
    let mut rule = Rule { weights: vec![9.0 / 40.0], points: vec![vec![1.0 / 3.0; 3]] };
    for sign in [-1.0, 1.0] {
        let (a, weight) = ((6.0 + sign * root) / 21.0, (155.0 + sign * root) / 1200.0);
        for k in 0..3 {
            let mut point = vec![a; 3];
            point[k] = 1.0 - 2.0 * a;
            rule.points.push(point);
            rule.weights.push(weight);
        }
    }
    rule
}

/// 14 points, exact to degree 5.
#[must_use]
pub fn tetrahedron() -> Rule {
    let mut rule = Rule { weights: Vec::new(), points: Vec::new() };
    for (a, weight) in [
        (0.092_735_250_310_891_23, 0.073_493_043_116_361_95),
        (0.310_885_919_263_300_6, 0.112_687_925_718_015_85),
    ] {
        for k in 0..4 {
            let mut point = vec![a; 4];
            point[k] = 1.0 - 3.0 * a;
            rule.points.push(point);
            rule.weights.push(weight);
        }
    }
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
    fn monomials_are_exact_to_degree_five_and_not_six() {
        let (tri, tet) = (triangle(), tetrahedron());
        for i in 0..=5 {
            for j in 0..=5 - i {
                for k in 0..=5 - i - j {
                    let e = [0, i, j, k];
                    assert!((integrate(&tet, &e) - exact(&e)).abs() < 1e-15);
                    assert!((integrate(&tri, &e[..3]) - exact(&e[..3])).abs() < 1e-15);
                }
            }
        }
        assert!((integrate(&tet, &[0, 6, 0, 0]) - exact(&[0, 6, 0, 0])).abs() > 1e-6);
        assert!((integrate(&tri, &[0, 6, 0]) - exact(&[0, 6, 0])).abs() > 1e-6);
    }
}
