//! Lagrange basis on a simplex, any degree.
//!
//! φ_i(λ) = Π_k L_{i_k}(λ_k),  L_m(λ) = Π_{s<m} (pλ − s)/(s + 1),  Σ_k i_k = p
//!
//! λ are barycentric coordinates, i_k the multi-index of a node. Nodes are
//! ordered vertices first, then edges 01, 12, 20 (triangle) and 01, 12, 20, 03,
//! 13, 23 (tetrahedron), which is VTK's order.
//!
//! Source: Zienkiewicz, Taylor and Zhu, "The Finite Element Method: Its Basis
//! and Fundamentals", section on simplex elements.

use super::quadrature::Rule;

/// Edges of a tetrahedron in node order; the first three are a triangle's.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Multi-indices of the nodes of a simplex with `corners` corners.
fn nodes(corners: usize, degree: usize) -> Vec<Vec<usize>> {
    let single = |c: usize, value: usize| {
        let mut index = vec![0; corners];
        index[c] = value;
        index
    };
    let mut nodes: Vec<_> = (0..corners).map(|c| single(c, degree)).collect();
    if degree == 2 {
        let edges = if corners == 4 { 6 } else { 3 };
        for [a, b] in &EDGES[..edges] {
            let mut index = single(*a, 1);
            index[*b] = 1;
            nodes.push(index);
        }
    }
    nodes
}

/// L_m(λ) and its derivative.
fn factor(m: usize, degree: usize, lambda: f64) -> (f64, f64) {
    let p = degree as f64;
    let (mut value, mut slope) = (1.0, 0.0);
    for s in 0..m {
        let s = s as f64;
        let (term, term_slope) = ((p * lambda - s) / (s + 1.0), p / (s + 1.0));
        slope = slope * term + value * term_slope;
        value *= term;
    }
    (value, slope)
}

/// Basis values and gradients at the points of a quadrature rule.
#[derive(Clone, Debug)]
pub struct Tabulation {
    /// Quadrature weights as fractions of the simplex' measure.
    pub weights: Vec<f64>,
    /// Barycentric coordinates of each point.
    pub points: Vec<Vec<f64>>,
    /// Value of each basis function at each point: `values[q][a]`.
    pub values: Vec<Vec<f64>>,
    /// Derivatives ∂φ_a/∂ξ_k with ξ_k = λ_{k+1}: `gradients[q][a][k]`; unused
    /// components are zero.
    pub gradients: Vec<Vec<[f64; 3]>>,
}

/// Values of the basis of a tetrahedron at barycentric coordinates.
#[must_use]
pub fn values(degree: usize, lambda: &[f64; 4]) -> Vec<f64> {
    let value = |node: &Vec<usize>| -> f64 {
        node.iter().zip(lambda).map(|(&m, &l)| factor(m, degree, l).0).product()
    };
    nodes(4, degree).iter().map(value).collect()
}

/// Tabulates the basis of a degree on a rule.
#[must_use]
pub fn tabulate(degree: usize, rule: &Rule) -> Tabulation {
    let corners = rule.points[0].len();
    let nodes = nodes(corners, degree);
    let mut table = Tabulation {
        weights: rule.weights.clone(),
        points: rule.points.clone(),
        values: Vec::new(),
        gradients: Vec::new(),
    };
    for point in &rule.points {
        let (mut values, mut gradients) = (Vec::new(), Vec::new());
        for node in &nodes {
            let factors: Vec<_> =
                node.iter().zip(point).map(|(&m, &l)| factor(m, degree, l)).collect();
            let by_lambda = |k: usize| -> f64 {
                factors.iter().enumerate().map(|(c, f)| if c == k { f.1 } else { f.0 }).product()
            };
            values.push(factors.iter().map(|f| f.0).product());
            let mut gradient = [0.0; 3];
            for k in 1..corners {
                gradient[k - 1] = by_lambda(k) - by_lambda(0);
            }
            gradients.push(gradient);
        }
        table.values.push(values);
        table.gradients.push(gradients);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::super::quadrature;
    use super::*;

    #[test]
    fn the_basis_is_a_partition_of_unity_and_reproduces_quadratics() {
        for rule in [quadrature::tetrahedron(), quadrature::triangle()] {
            for degree in [1, 2] {
                let table = tabulate(degree, &rule);
                let nodes = nodes(rule.points[0].len(), degree);
                for (q, point) in rule.points.iter().enumerate() {
                    assert!((table.values[q].iter().sum::<f64>() - 1.0).abs() < 1e-14);
                    for k in 0..point.len() - 1 {
                        let sum: f64 = table.gradients[q].iter().map(|g| g[k]).sum();
                        assert!(sum.abs() < 1e-13);
                    }
                    // x = λ₁^p at the nodes, interpolated
                    let at =
                        |node: &Vec<usize>| (node[1] as f64 / degree as f64).powi(degree as i32);
                    let value: f64 =
                        nodes.iter().zip(&table.values[q]).map(|(n, v)| at(n) * v).sum();
                    let slope: f64 =
                        nodes.iter().zip(&table.gradients[q]).map(|(n, g)| at(n) * g[0]).sum();
                    let p = degree as i32;
                    assert!((value - point[1].powi(p)).abs() < 1e-14);
                    assert!((slope - f64::from(p) * point[1].powi(p - 1)).abs() < 1e-13);
                }
            }
        }
    }
}
