//! A slender bar, one end held, a small shear force on the other.
//!
//! Timoshenko's beam: δ = FL³/(3EI) + FL/(κ G b h), κ = 10(1 + ν)/(12 + 11ν).

use mesh::{TetMesh, Vec3};
use solver::energy::{Elastic, Energy, Traction};
use tests::block;
use tests::equilibrium::{MODULI, Problem, SILICONE, facets_where, mean};

const LENGTH: f64 = 0.1;
const SIDE: f64 = 0.01;
const FORCE: f64 = 1e-4;

fn timoshenko() -> f64 {
    let (mu, bulk) = MODULI;
    let young = 9.0 * bulk * mu / (3.0 * bulk + mu);
    let poisson = young / (2.0 * mu) - 1.0;
    let inertia = SIDE.powi(4) / 12.0;
    let kappa = 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);
    FORCE * LENGTH.powi(3) / (3.0 * young * inertia) + FORCE * LENGTH / (kappa * mu * SIDE * SIDE)
}

fn bar(cells: usize) -> TetMesh {
    block([10 * cells, cells, cells], SIDE / cells as f64, |_| false, |p| p)
}

/// Deflection of the loaded end over Timoshenko's.
fn ratio(degree: usize, cells: usize) -> f64 {
    let mesh = bar(cells);
    let end = facets_where(&mesh, |p| p.x > LENGTH - 1e-9);
    let energies = |space: &_| -> Vec<Box<dyn Energy>> {
        let shear = Vec3::new(0.0, 0.0, FORCE / (SIDE * SIDE));
        vec![
            Box::new(Elastic { material: Box::new(SILICONE) }),
            Box::new(Traction::new(space, &end, shear)),
        ]
    };
    let mut problem = Problem::new(mesh, degree, energies, |p| [p.x < 1e-9; 3]);
    problem.solve(1.0);
    let tip = |x: &&(Vec3, Vec3)| x.0.x > LENGTH - 1e-9;
    let lifts: Vec<f64> = problem.nodes().iter().filter(tip).map(|x| x.1.z - x.0.z).collect();
    mean(&lifts) / timoshenko()
}

#[test]
fn quadratic_elements_bend_and_linear_ones_lock() {
    let [p1, p1_fine, p2, p2_fine] =
        [(1, 1), (1, 2), (2, 1), (2, 2)].map(|(degree, cells)| ratio(degree, cells));
    eprintln!(
        "cantilever, deflection over Timoshenko's: P1 {p1:.3} (1 cell high), {p1_fine:.3} (2), \
         P2 {p2:.4}, {p2_fine:.4}"
    );
    assert!(p1 < 0.9 && p1_fine < 0.9 && p1 < p1_fine);
    assert!((p2_fine - 1.0).abs() < 0.01);
}
