//! A homogeneous deformation prescribed at the boundary of a distorted block is
//! found inside.

use mechanics::element::{FunctionSpace, at};
use mechanics::energy::Energies;
use mechanics::forward::{Newton, Problem, Stepping, Workspace, solve};
use mesh::Vec3;
use tests::block;
use tests::equilibrium::SILICONE;

const GRADIENT: [[f64; 3]; 3] = [[0.2, 0.1, -0.05], [0.0, -0.1, 0.15], [0.1, 0.05, 0.3]];

#[test]
fn constant_strain_is_exact_for_every_degree() {
    let distort = |p: Vec3| p + 1e-3 * Vec3::new((300.0 * p.y).sin(), (200.0 * p.z).cos(), 0.0);
    let mesh = block([3, 3, 3], 0.01, |_| false, distort);
    for degree in [1, 2, 3] {
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
        let nodes = space.node_positions(&mesh.vertices);
        let exact: Vec<f64> = nodes
            .iter()
            .flat_map(|x| GRADIENT.map(|row| row[0] * x.x + row[1] * x.y + row[2] * x.z))
            .collect();
        let mut fixed = vec![false; exact.len()];
        for facet in mesh::topology::boundary(&mesh).facets {
            for node in space.facet_nodes(facet) {
                fixed[3 * node..3 * node + 3].fill(true);
            }
        }
        let energies = Energies::elastic(Box::new(SILICONE));
        let problem = Problem::new(space, energies, &fixed).with_displacement(&exact);
        let mut workspace = Workspace::new(&problem);
        let newton = Newton {
            iterations: 30,
            relative: 1e-15,
            absolute: 1e-12,
            negligible: 0.0,
            ballooned: None,
        };
        let stepping = Stepping { first: 0.5, largest: 1.0, smallest: 1e-3, newton };
        let rest = &mesh.vertices;
        let steps = solve(&problem, &mut workspace, rest, &stepping, &[1.0]).unwrap();
        let solution = steps.last().unwrap();
        let largest = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let error: Vec<f64> = solution.u.iter().zip(&exact).map(|(a, b)| a - b).collect();
        let error = largest(&error) / largest(&exact);
        let (gradient, _) = problem.gradient(&problem.iterate(rest, &solution.u, 1.0));
        let net: Vec3 = (0..nodes.len()).map(|i| at(&gradient, i)).sum();
        eprintln!("patch P{degree}: displacement {error:.1e}, net force {:.1e} N", net.norm());
        assert!(error < 1e-12, "P{degree}: {error}");
        assert!(net.norm() < 1e-12 * largest(&gradient) * nodes.len() as f64);
    }
}
