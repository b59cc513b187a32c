//! A slender bar, one end held, a small shear force on the other.
//!
//! Timoshenko's beam: δ = FL³/(3EI) + FL/(κ G b h), κ = 10(1 + ν)/(12 + 11ν).
//! Its clamped end does not turn but may contract sideways; one that is fixed along all
//! axes is stiffer, by an amount that cubic elements give.

use mechanics::energy::{Elastic, Energies, Traction};
use mechanics::material::{Lame, NeoHookean};
use mesh::{TetMesh, Vec3};
use tests::block;
use tests::equilibrium::{Equilibrium, MODULI, SILICONE, facets_where, mean};

const LENGTH: f64 = 0.1;
const SIDE: f64 = 0.01;
const FORCE: f64 = 1e-4;

fn timoshenko((mu, bulk): (f64, f64)) -> f64 {
    let young = 9.0 * bulk * mu / (3.0 * bulk + mu);
    let poisson = young / (2.0 * mu) - 1.0;
    let inertia = SIDE.powi(4) / 12.0;
    let kappa = 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);
    FORCE * LENGTH.powi(3) / (3.0 * young * inertia) + FORCE * LENGTH / (kappa * mu * SIDE * SIDE)
}

fn bar(cells: usize) -> TetMesh {
    block([10 * cells, cells, cells], SIDE / cells as f64, |_| false, |p| p)
}

/// How the end x = 0 is held.
#[derive(Clone, Copy)]
enum End {
    /// Along all axes.
    Clamped,
    /// Along x; the lines through its middle also across themselves.
    Contracting,
}

impl End {
    fn held(self, p: Vec3) -> [bool; 3] {
        let middle = |c: f64| (c - 0.5 * SIDE).abs() < 1e-9;
        match self {
            _ if p.x > 1e-9 => [false; 3],
            Self::Clamped => [true; 3],
            Self::Contracting => [true, middle(p.y), middle(p.z)],
        }
    }
}

/// Deflection of the loaded end over Timoshenko's.
fn ratio(end_held: End, degree: usize, cells: usize) -> f64 {
    ratio_of(&Elastic::whole(Box::new(SILICONE)), MODULI, end_held, [degree, cells])
}

/// The same of a law with moduli.
fn ratio_of(
    elastic: &Elastic,
    moduli: (f64, f64),
    end_held: End,
    [degree, cells]: [usize; 2],
) -> f64 {
    let mesh = bar(cells);
    let end = facets_where(&mesh, |p| p.x > LENGTH - 1e-9);
    let energies = |space: &_| {
        let shear = Vec3::new(0.0, 0.0, FORCE / (SIDE * SIDE));
        let mut energies = Energies::bodies([elastic.clone()]);
        energies = energies.with(Traction::new(space, &end, shear.into()));
        energies
    };
    let mut problem = Equilibrium::new(mesh, degree, energies, |p| end_held.held(p));
    problem.solve(1.0);
    let tip = |x: &&(Vec3, Vec3)| x.0.x > LENGTH - 1e-9;
    let lifts: Vec<f64> = problem.nodes().iter().filter(tip).map(|x| x.1.z - x.0.z).collect();
    mean(&lifts) / timoshenko(moduli)
}

#[test]
fn quadratic_elements_bend_and_linear_ones_lock() {
    let p1 = [1, 2].map(|cells| ratio(End::Clamped, 1, cells));
    let p2 = [1, 2, 3].map(|cells| ratio(End::Clamped, 2, cells));
    let p3 = [1, 2].map(|cells| ratio(End::Clamped, 3, cells));
    eprintln!(
        "cantilever, deflection over Timoshenko's by cells in the height:\n  clamped P1 \
         {p1:.4?}, P2 {p2:.4?}, P3 {p3:.4?}"
    );
    // cubic elements have nodes in the middle for an even number of cells
    let free = [(2, 1), (2, 2), (2, 3), (3, 2)];
    let free = free.map(|(degree, cells)| ratio(End::Contracting, degree, cells));
    eprintln!("  contracting P2 {:.4?}, P3 {:.4?}", &free[..3], &free[3..]);
    // locking
    assert!(p1[0] < p1[1] && p1[1] < 0.9);
    assert!((p2[2] / p3[1] - 1.0).abs() < 0.01);
    assert!((free[2] - 1.0).abs() < 0.01 && (free[3] - 1.0).abs() < 0.01);
}

/// Where the volume of elements changes as a whole, their pressure is constant, but not that of a bar that bends:
/// they are soft, by the same whatever the bulk modulus, and converge.
#[test]
fn elements_with_mean_dilatation_are_soft_in_bending_and_converge() {
    let mu = 120e3;
    let errors = |bulk_over_shear: f64, mean: bool| {
        let bulk = bulk_over_shear * mu;
        let poisson = (3.0 * bulk - 2.0 * mu) / (2.0 * (3.0 * bulk + mu));
        let law = NeoHookean(Lame::new(2.0 * mu * (1.0 + poisson), poisson));
        let standard = Elastic::whole(Box::new(law));
        let elastic = if mean { standard.with_mean_dilatation().unwrap() } else { standard };
        [1, 2].map(|cells| 1.0 - ratio_of(&elastic, (mu, bulk), End::Contracting, [2, cells]))
    };
    let [soft, firm] = [20.0, 1e4].map(|ratio| [errors(ratio, false), errors(ratio, true)]);
    eprintln!(
        "cantilever, P2, 1 and 2 cells: missing with K = 20 G and 10 000 G, standard {:.4?} {:.4?}, \
         mean dilatation {:.4?} {:.4?}",
        soft[0], firm[0], soft[1], firm[1]
    );
    for [one, two] in [soft[1], firm[1]] {
        assert!(one < 0.0 && two < 0.0 && two.abs() < 0.25 * one.abs() && two > -0.03);
    }
    assert!((0..2).all(|cells| (soft[1][cells] - firm[1][cells]).abs() < 0.01));
}
