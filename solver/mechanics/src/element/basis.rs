//! Lagrange basis on a simplex, any degree.
//!
//! φ_i(λ) = Π_k L_{i_k}(λ_k),  L_m(λ) = Π_{s<m} (pλ − s)/(s + 1),  Σ_k i_k = p
//!
//! λ are barycentric coordinates, i_k the multi-index of a node. Nodes are
//! ordered vertices first, then edges 01, 12, 20 (triangle) and 01, 12, 20, 03,
//! 13, 23 (tetrahedron), those of an edge ab from a to b, then faces 012
//! (triangle) and 013, 123, 023, 012 (tetrahedron). This is VTK's order.
//!
//! Sources: Zienkiewicz, Taylor and Zhu, "The Finite Element Method: Its Basis
//! and Fundamentals", section on simplex elements; order of the nodes: VTK's
//! classes vtkLagrangeTetra and vtkHigherOrderTetra.

use super::quadrature::Rule;

/// Edges of a tetrahedron in node order; the first three are a triangle's.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Faces of a tetrahedron in node order; a triangle has only the last.
pub const FACES: [[usize; 3]; 4] = [[0, 1, 3], [1, 2, 3], [0, 2, 3], [0, 1, 2]];

/// Largest degree for which the order of the nodes is known.
pub const HIGHEST_DEGREE: usize = 3;

/// Multi-indices of the nodes of a simplex with `corners` corners (3 or 4) for
/// a degree from 1 to 3.
pub fn nodes(corners: usize, degree: usize) -> Vec<Vec<usize>> {
    let index = |entries: &[(usize, usize)]| {
        let mut index = vec![0; corners];
        entries.iter().for_each(|&(corner, value)| index[corner] = value);
        index
    };
    let (edges, faces) =
        if corners == 4 { (&EDGES[..], &FACES[..]) } else { (&EDGES[..3], &FACES[3..]) };
    let mut nodes: Vec<_> = (0..corners).map(|c| index(&[(c, degree)])).collect();
    for &[a, b] in edges {
        nodes.extend((1..degree).map(|k| index(&[(a, degree - k), (b, k)])));
    }
    if degree == 3 {
        nodes.extend(faces.iter().map(|face| index(&face.map(|c| (c, 1)))));
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

/// Values of the basis of a triangle or tetrahedron at barycentric coordinates.
pub fn values(degree: usize, lambda: &[f64]) -> Vec<f64> {
    let value = |node: &Vec<usize>| -> f64 {
        node.iter().zip(lambda).map(|(&m, &l)| factor(m, degree, l).0).product()
    };
    nodes(lambda.len(), degree).iter().map(value).collect()
}

/// Tabulates the basis of a degree on a rule.
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
    fn the_basis_is_a_partition_of_unity_and_reproduces_its_degree() {
        for rule in [quadrature::tetrahedron(5), quadrature::triangle(5)] {
            for degree in 1..=HIGHEST_DEGREE {
                let table = tabulate(degree, &rule);
                let nodes = nodes(rule.points[0].len(), degree);
                for (q, point) in rule.points.iter().enumerate() {
                    assert!((table.values[q].iter().sum::<f64>() - 1.0).abs() < 1e-14);
                    for k in 0..point.len() - 1 {
                        let sum: f64 = table.gradients[q].iter().map(|g| g[k]).sum();
                        assert!(sum.abs() < 1e-13);
                    }
                    // (λ₁ + 2 λ₂)^p at the nodes, interpolated
                    let p = degree as i32;
                    let at = |l1: f64, l2: f64| l1 + 2.0 * l2;
                    let nodal: Vec<f64> = nodes
                        .iter()
                        .map(|n| (at(n[1] as f64, n[2] as f64) / f64::from(p)).powi(p))
                        .collect();
                    let here = at(point[1], point[2]);
                    let value: f64 = nodal.iter().zip(&table.values[q]).map(|(n, v)| n * v).sum();
                    assert!((value - here.powi(p)).abs() < 1e-13);
                    for (k, factor) in [(0, 1.0), (1, 2.0)] {
                        let slope: f64 =
                            nodal.iter().zip(&table.gradients[q]).map(|(n, g)| n * g[k]).sum();
                        let exact = f64::from(p) * here.powi(p - 1) * factor;
                        assert!((slope - exact).abs() < 1e-12, "{degree} {slope} {exact}");
                    }
                }
            }
        }
    }

    /// What VTK calls the vertices of a tetrahedron in its own barycentric
    /// coordinates, and which of these vanishes on each face in its order
    /// (vtkHigherOrderTetra: VertexMaxCoords, FaceMinCoord).
    const VTK_VERTEX: [usize; 4] = [3, 0, 1, 2];
    const VTK_FACE: [usize; 4] = [1, 3, 0, 2];

    #[test]
    fn cubic_nodes_are_in_the_order_of_vtk() {
        let nodes = nodes(4, 3);
        assert_eq!(nodes.len(), 20);
        // edges: from the first to the second vertex of vtkTetra's edges
        let edges = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
        for (i, [a, b]) in edges.into_iter().enumerate() {
            assert_eq!((nodes[4 + 2 * i][a], nodes[4 + 2 * i][b]), (2, 1));
            assert_eq!((nodes[5 + 2 * i][a], nodes[5 + 2 * i][b]), (1, 2));
        }
        for (i, vanishing) in VTK_FACE.into_iter().enumerate() {
            let opposite = VTK_VERTEX.iter().position(|&c| c == vanishing).expect("a permutation");
            let expected: Vec<usize> = (0..4).map(|c| usize::from(c != opposite)).collect();
            assert_eq!(nodes[16 + i], expected);
        }
    }
}
