//! Equilibrium 1 of Land et al. 2015, "Verification of cardiac mechanics software",
//! doi:10.1098/rspa.2015.0641: a bar of 10 × 1 × 1 mm of Guccione's material
//! with fibres along it, one end held, 4 Pa on its lower face, a follower load.
//! All codes of that paper find the end at a height of 4.0 to 4.2 mm.
//!
//! The load has a free rim, hence no potential: it is found as the limit of dead
//! loads, each of which is the follower load of the equilibrium before.

use mechanics::element::at;
use mechanics::energy::{Chamber, Energies, Energy, Isobaric, Wall};
use mechanics::material::{Kinematics, Material};
use mechanics::math::tensor::{Mat3, Mat9, vec9};
use mesh::Vec3;
use tests::block;
use tests::equilibrium::{Equilibrium, facets_where, newton};

use crate::nodal::NodalForces;

/// ψ = ½ C (e^Q − 1) + ½ K ln²J,  Q = b_f E₁₁² + b_t (E₂₂² + E₃₃² + 2E₂₃²)
/// + 2 b_fs (E₁₂² + E₁₃²), K for incompressibility.
struct Guccione;

const C: f64 = 2e3;
const BULK: f64 = 1e6;

/// Factors of E_ij² in Q.
fn factors() -> Mat3 {
    Mat3::new(8.0, 4.0, 4.0, 4.0, 2.0, 2.0, 4.0, 2.0, 2.0)
}

impl Guccione {
    /// E, B : E (entrywise), e^Q.
    fn parts(k: &Kinematics) -> (Mat3, Mat3, f64) {
        let h = k.f - Mat3::identity();
        let green = 0.5 * (h + h.transpose() + h.transpose() * h);
        let scaled = factors().component_mul(&green);
        (green, scaled, green.dot(&scaled).exp())
    }
}

impl Material for Guccione {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        if k.j() <= 0.0 {
            return f64::INFINITY;
        }
        let (_, _, exp) = Self::parts(k);
        0.5 * C * (exp - 1.0) + 0.5 * BULK * k.j_minus_1.ln_1p().powi(2)
    }

    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        let (_, scaled, exp) = Self::parts(k);
        k.f * scaled * (C * exp) + k.cofactor * (BULK * k.j_minus_1.ln_1p() / k.j())
    }

    fn tangent(&self, k: &Kinematics) -> Mat9 {
        let (_, scaled, exp) = Self::parts(k);
        let inverse = (k.cofactor / k.j()).transpose();
        let log = k.j_minus_1.ln_1p();
        let mut tangent = Mat9::zeros();
        for column in 0..9 {
            let mut h = Mat3::zeros();
            h[(column % 3, column / 3)] = 1.0;
            let strain = 0.5 * (h.transpose() * k.f + k.f.transpose() * h);
            let stress = scaled * (2.0 * scaled.dot(&strain)) + factors().component_mul(&strain);
            let elastic = (h * scaled + k.f * stress) * (C * exp);
            let trace = (inverse * h).trace();
            let turned = (inverse * h * inverse).transpose();
            let volume = (inverse.transpose() * trace - turned * log) * BULK;
            tangent.set_column(column, &vec9(&(elastic + volume)));
        }
        tangent
    }

    fn parameter_count(&self) -> usize {
        0
    }

    /// The law has no parameters that can be differentiated.
    fn add_parameter_vjp(&self, _: &Kinematics, _: &Mat3, _: &mut [f64]) {}
}

/// Height of the point (10, 0.5, 1) mm [mm], and the dead loads it took.
fn height(degree: usize, cells: usize) -> (f64, usize) {
    let edge = 1e-3 / cells as f64;
    let mesh = block([10 * cells, cells, cells], edge, |_| false, |p| p);
    let below = facets_where(&mesh, |p| p.z < 1e-9);
    let elastic = |_: &_| Energies::elastic(Box::new(Guccione));
    let mut body = Equilibrium::new(mesh, degree, elastic, |p| [p.x < 1e-9; 3]);
    let wall = Wall::new(&body.problem.space, &below);
    let gas = Chamber::new(wall, Box::new(Isobaric { pressure: 4.0.into() }));
    let newton = newton(60, 1e-8);
    let tip = |p: &(Vec3, Vec3)| (p.0 - Vec3::new(10e-3, 0.5e-3, 1e-3)).norm() < 1e-9;
    let node = body.nodes().iter().position(tip).expect("an even number of halves");
    let mut last = 0.0;
    for count in 1..60 {
        // the first loads are small steps
        let load = (0.25 * f64::from(count)).min(1.0);
        let mut force = vec![0.0; body.u.len()];
        gas.add_gradient(&body.problem.iterate(&body.rest, &body.u, load), &mut force);
        force.iter_mut().for_each(|f| *f = -*f);
        body.problem.energies = Energies::elastic(Box::new(Guccione)).with(NodalForces(force));
        body.balance(&newton, 1.0).unwrap();
        let now = 1e3 * (1e-3 + at(&body.u, node).z);
        if load == 1.0 && (now - last).abs() < 1e-5 {
            return (now, count as usize);
        }
        last = now;
    }
    panic!("the follower load did not settle: {last} mm");
}

#[test]
fn the_bar_of_land_ends_where_all_codes_put_it() {
    let (coarse, loads) = height(2, 2);
    eprintln!(
        "Land problem 1, P2, 2 cells high: {coarse:.3} mm after {loads} dead loads (4.0 to 4.2)"
    );
    assert!((4.0..4.2).contains(&coarse), "{coarse}");
}

#[test]
#[ignore = "half a minute: runs in make test-all"]
fn the_bar_of_land_stays_there_on_finer_meshes() {
    let ends = [height(1, 4).0, height(2, 3).0, height(3, 2).0];
    eprintln!("Land problem 1: P1 4 cells, P2 3 cells, P3 2 cells: {ends:.3?} mm");
    assert!(ends[1..].iter().all(|z| (4.0..4.2).contains(z)));
}
