//! Manufactured solution u*_i = 0.1 sin πX_i sin πX_{i+1} on the unit cube, large
//! strain, with the body force f = −Div P(I + ∇u*) and u* on the boundary.

use std::f64::consts::PI;

use mechanics::element::{FunctionSpace, add_at, at, quadrature, tabulate};
use mechanics::energy::Energies;
use mechanics::forward::{Configuration, Problem, Workspace};
use mechanics::material::{Kinematics, Material, MooneyRivlin};
use mechanics::math::taylor::log_slope;
use mechanics::math::tensor::{Mat3, cofactor};
use mesh::Vec3;
use tests::block;
use tests::equilibrium::newton;

use crate::nodal::NodalForces;

const AMPLITUDE: f64 = 0.1;
/// Compressible, so that linear elements do not lock before they converge.
const LAW: MooneyRivlin = MooneyRivlin { c1: 55e3, c2: 5e3, c3: 1.7e3, d1: 1e5 };
/// Degree to which the force and the errors are integrated.
const FINE: usize = 10;

fn displacement(x: Vec3) -> Vec3 {
    Vec3::from_fn(|i, _| AMPLITUDE * (PI * x[i]).sin() * (PI * x[(i + 1) % 3]).sin())
}

fn gradient(x: Vec3) -> Mat3 {
    let mut g = Mat3::zeros();
    for i in 0..3 {
        let j = (i + 1) % 3;
        g[(i, i)] = AMPLITUDE * PI * (PI * x[i]).cos() * (PI * x[j]).sin();
        g[(i, j)] = AMPLITUDE * PI * (PI * x[i]).sin() * (PI * x[j]).cos();
    }
    g
}

/// ∂²u*_i/∂X_j∂X_k
fn second(x: Vec3, i: usize, j: usize, k: usize) -> f64 {
    let (a, b) = (i, (i + 1) % 3);
    let (sa, ca) = (PI * x[a]).sin_cos();
    let (sb, cb) = (PI * x[b]).sin_cos();
    let scale = AMPLITUDE * PI * PI;
    match (j, k) {
        (j, k) if j == k && (j == a || j == b) => -scale * sa * sb,
        (j, k) if j != k && [j, k].iter().all(|d| [a, b].contains(d)) => scale * ca * cb,
        _ => 0.0,
    }
}

/// f_i = −A_{iJkL} ∂²u*_k/∂X_J∂X_L
fn force(x: Vec3) -> Vec3 {
    let tangent = LAW.tangent(&Kinematics::new(&gradient(x)));
    let mut f = Vec3::zeros();
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                for l in 0..3 {
                    f[i] -= tangent[(3 * j + i, 3 * l + k)] * second(x, k, j, l);
                }
            }
        }
    }
    f
}

/// f as forces on nodes.
fn nodal_forces(space: &FunctionSpace, rest: &[Vec3]) -> NodalForces {
    let mut nodal = vec![0.0; 3 * space.node_count()];
    for_each_point(space, rest, |nodes, _, values, _, x, weight| {
        let f = weight * force(x);
        nodes.iter().zip(values).for_each(|(&n, v)| add_at(&mut nodal, n, &(f * *v)));
    });
    NodalForces(nodal)
}

/// Calls `f` with nodes, G⁻ᵀ, values, reference gradients, position and weight
/// [m³] of every point of a fine rule.
fn for_each_point(
    space: &FunctionSpace,
    rest: &[Vec3],
    mut f: impl FnMut(&[usize], &Mat3, &[f64], &[[f64; 3]], Vec3, f64),
) {
    let table = tabulate(space.degree(), &quadrature::tetrahedron(FINE));
    let elements = space.element_nodes().chunks_exact(space.nodes_per_element());
    for (tet, nodes) in space.tets().iter().zip(elements) {
        let corners = tet.map(|v| rest[v]);
        let [a, b, c, d] = corners;
        let g = Mat3::from_columns(&[b - a, c - a, d - a]);
        let to_rest = cofactor(&g) / g.determinant();
        for (q, weight) in table.weights.iter().enumerate() {
            let x = corners.iter().zip(&table.points[q]).map(|(x, l)| *x * *l).sum();
            let (values, slopes) = (&table.values[q], &table.gradients[q]);
            f(nodes, &to_rest, values, slopes, x, weight * g.determinant() / 6.0);
        }
    }
}

/// L² errors of u and of ∇u on n³ cells.
fn errors(degree: usize, exact: usize, n: usize) -> [f64; 2] {
    let mesh = block([n; 3], 1.0 / n as f64, |_| false, |p| p);
    let rest = mesh.vertices;
    let space = FunctionSpace::with_quadrature(degree, exact, rest.len(), mesh.tets);
    let nodes = space.node_positions(&rest);
    let on_boundary = |p: &Vec3| p.iter().any(|c| !(1e-9..1.0 - 1e-9).contains(c));
    let fixed: Vec<bool> = nodes.iter().flat_map(|p| [on_boundary(p); 3]).collect();
    let u: Vec<f64> = nodes.iter().flat_map(|&p| <[f64; 3]>::from(displacement(p))).collect();
    let energies = Energies::elastic(Box::new(LAW)).with(nodal_forces(&space, &rest));
    let problem = Problem::new(space, energies, &fixed);
    let newton = newton(20, 1e-11);
    let mut state = Configuration::new(&problem, &rest, u, 1.0);
    newton.solve(&problem, &mut Workspace::new(&problem), &mut state).unwrap();
    let u = state.u;
    let mut squares = [0.0; 2];
    for_each_point(&problem.space, &rest, |nodes, to_rest, values, slopes, x, weight| {
        let (mut value, mut slope) = (Vec3::zeros(), Mat3::zeros());
        for ((&n, v), g) in nodes.iter().zip(values).zip(slopes) {
            value += at(&u, n) * *v;
            slope += at(&u, n) * (to_rest * Vec3::from(*g)).transpose();
        }
        squares[0] += weight * (value - displacement(x)).norm_squared();
        squares[1] += weight * (slope - gradient(x)).norm_squared();
    });
    squares.map(f64::sqrt)
}

fn check(degree: usize, exact: usize, levels: &[usize]) {
    let h: Vec<f64> = levels.iter().map(|&n| 1.0 / n as f64).collect();
    let results: Vec<[f64; 2]> = levels.iter().map(|&n| errors(degree, exact, n)).collect();
    for (n, e) in levels.iter().zip(&results) {
        eprintln!("manufactured P{degree} n = {n:2}: L2 {:.3e}  H1 {:.3e}", e[0], e[1]);
    }
    let slope = |k: usize| log_slope(&h, &results.iter().map(|e| e[k]).collect::<Vec<_>>());
    let (l2, h1) = (slope(0), slope(1));
    eprintln!("manufactured P{degree}, quadrature {exact}: slopes L2 {l2:.2}, H1 {h1:.2}");
    assert!((l2 - (degree + 1) as f64).abs() < 0.15, "P{degree}: L2 slope {l2}");
    assert!((h1 - degree as f64).abs() < 0.15, "P{degree}: H1 slope {h1}");
}

#[test]
fn linear_elements_converge_with_their_order() {
    check(1, 5, &[6, 8, 12]);
}

#[test]
fn quadratic_elements_converge_with_their_order() {
    check(2, 5, &[4, 6, 8]);
}

#[test]
fn cubic_elements_converge_with_their_order() {
    check(3, 5, &[3, 4, 6]);
}
