//! Thick walls that are pressed together, by elements of all kinds: which hold back, and which give way.
//!
//! - An octant of a hollow sphere, B = 2 A, under pressure from outside: pressure over stretch of the inner wall by the
//!   radial equation of the law.
//! - A block that is compressed along two axes, the top free: its surface folds at the stretch λ of Biot, where
//!   ξ³ + ξ² + 3ξ − 1 = 0 with ξ = λ³ for an incompressible neo-Hookean half-space, λ = 0.66614. All wavelengths fold at once.
//!   Elements that lock fold later, those that are too soft earlier.
//!
//! Source: Biot 1963, "Surface instability of rubber in compression", doi:10.1007/BF03184638.

use mechanics::element::FunctionSpace;
use mechanics::energy::{BodyEnergies, Elastic, Energies, Isobaric, Iterate};
use mechanics::forward::Stability;
use mechanics::material::{Lame, NeoHookean};
use mesh::Vec3;
use tests::equilibrium::{Equilibrium, facets_where, mean};
use tests::meshes::{extrude, shell_octant, square};
use tests::radial::{self, Wall};
use tests::symmetric_gas::{Planes, SymmetricGas};

const MU: f64 = 100e3;
const A: f64 = 0.005;
const B: f64 = 0.010;

/// Degree, and whether the change of volume is that of means.
type Kind = (usize, bool);
const KINDS: [Kind; 5] = [(1, false), (2, false), (2, true), (3, false), (3, true)];

fn name((degree, mean): Kind) -> String {
    format!("P{degree}{}", if mean { " mean" } else { "" })
}

/// Of a bulk modulus over the shear modulus.
fn elastic(ratio: f64, (_, mean): Kind) -> Elastic {
    let bulk = ratio * MU;
    let young = 9.0 * bulk * MU / (3.0 * bulk + MU);
    let law = NeoHookean(Lame::new(young, 0.5 * young / MU - 1.0));
    let standard = Elastic::whole(Box::new(law));
    if mean { standard.with_mean_dilatation().unwrap() } else { standard }
}

/// Error of the change of the inner radius, and degrees of freedom.
fn sphere(ratio: f64, kind: Kind, arcs: usize, stretch: f64) -> (f64, usize) {
    let stress = radial::neo_hookean(MU, (ratio - 2.0 / 3.0) * MU);
    let wall = Wall { radii: [A, B], sphere: true, stress: &stress };
    let outer = (1.0 + (stretch.powi(3) - 1.0) * (A / B).powi(3)).cbrt();
    let part = |l: f64| 4.0 / l + l.powi(-4);
    let pressure = wall.pressure(stretch, 0.5 * MU * (part(outer) - part(stretch)));
    let mesh = shell_octant(A, B, arcs, arcs);
    let facets = facets_where(&mesh, |p| p.norm() < A * (1.0 + 1e-9));
    let gas = |space: &FunctionSpace| {
        let gas = Box::new(Isobaric { pressure: pressure.into() });
        SymmetricGas::new(space, &facets, Planes::ThroughOrigin, gas)
    };
    let energies = |space: &FunctionSpace| {
        Energies::bodies(vec![BodyEnergies::new(elastic(ratio, kind))]).with(gas(space))
    };
    let on_plane = |p: Vec3| [p.x, p.y, p.z].map(|c| c < 1e-9 * A);
    let mut body = Equilibrium::new(mesh, kind.0, energies, on_plane);
    (1..=5).for_each(|step| body.solve(0.2 * f64::from(step)));
    let inner = |x: &&(Vec3, Vec3)| x.0.norm() < A * (1.0 + 1e-9);
    let stretches: Vec<f64> =
        body.vertices().iter().filter(inner).map(|x| x.1.norm() / A).collect();
    ((mean(&stretches) - 1.0) / (stretch - 1.0) - 1.0, body.u.len())
}

/// The stretch at which the surface of a block of so many cells along each edge folds, 0 where it does not down to 0.4,
/// and degrees of freedom.
fn fold(ratio: f64, kind: Kind, cells: usize) -> (f64, usize) {
    let mesh = extrude(&square([cells; 2]), cells, |[x, y], z| Vec3::new(x, y, z));
    let held = |p: Vec3| {
        let end = |c: f64| !(1e-9..=1.0 - 1e-9).contains(&c);
        [end(p.x), end(p.y), p.z < 1e-9]
    };
    let energies =
        |_: &FunctionSpace| Energies::bodies(vec![BodyEnergies::new(elastic(ratio, kind))]);
    let mut body = Equilibrium::new(mesh, kind.0, energies, held);
    let folded = |stretch: f64, body: &mut Equilibrium| {
        let up = upward(ratio, stretch);
        let nodes = body.problem.space.node_positions(&body.rest);
        let moved = |x: &Vec3| [(stretch - 1.0) * x.x, (stretch - 1.0) * x.y, (up - 1.0) * x.z];
        let u: Vec<f64> = nodes.iter().flat_map(moved).collect();
        let at = Iterate::new(&body.problem.space, &body.rest, &u, 1.0);
        let found = Stability::of(&body.problem, &mut body.workspace, &at).expect("a factor");
        found.negative > 0
    };
    let [mut sound, mut lost] = [0.95, 0.4];
    assert!(!folded(sound, &mut body));
    if !folded(lost, &mut body) {
        return (0.0, body.u.len());
    }
    while sound - lost > 1e-3 {
        let middle = f64::midpoint(sound, lost);
        if folded(middle, &mut body) { lost = middle } else { sound = middle }
    }
    (f64::midpoint(sound, lost), body.u.len())
}

/// The stretch of a free face where the others have one each: P₃₃ = 0, by bisection.
fn upward(ratio: f64, stretch: f64) -> f64 {
    let stress = radial::neo_hookean(MU, (ratio - 2.0 / 3.0) * MU);
    let [mut low, mut high] = [0.5, 2.0].map(|part| part * stretch.powi(-2));
    for _ in 0..100 {
        let middle = f64::midpoint(low, high);
        if stress([stretch, stretch, middle])[2] > 0.0 { high = middle } else { low = middle }
    }
    low
}

#[test]
fn a_thick_sphere_is_pressed_together_by_elements_of_all_kinds() {
    eprintln!("hollow sphere, B = 2 A, inner wall pressed to 0.8: error of its change [%]");
    for arcs in [2, 4] {
        let found = KINDS.map(|kind| [200.0, 1e4].map(|ratio| sphere(ratio, kind, arcs, 0.8)));
        for (kind, [(soft, dofs), (firm, _)]) in KINDS.into_iter().zip(found) {
            let [soft, firm] = [soft, firm].map(|error| 100.0 * error);
            let name = name(kind);
            eprintln!(
                "  {arcs} arcs, {name:8} {dofs:6} dofs: K = 200 G {soft:+.2}, 10 000 G {firm:+.2}"
            );
        }
        let [p1, _, p2_mean, p3, p3_mean] = found.map(|of| of.map(|(error, _)| error));
        for k in 0..2 {
            assert!(p1[k] < p2_mean[k] - 0.1, "linear elements lock");
            // facets are straight: all have the error of the shape
            assert!((p3_mean[k] - p2_mean[k]).abs() < 0.03 && (p3_mean[k] - p3[k]).abs() < 0.03);
        }
    }
}

#[test]
#[ignore = "a minute: runs in make test-all"]
fn the_surface_of_a_pressed_block_folds_by_elements_of_all_kinds() {
    eprintln!(
        "surface of a block, compressed along two axes: stretch at which it folds, Biot 0.6661"
    );
    for cells in [2, 4] {
        for kind in KINDS {
            let found = [20.0, 200.0, 1e4].map(|ratio| fold(ratio, kind, cells));
            let [soft, usual, firm] = found.map(|(stretch, _)| stretch);
            let (dofs, name) = (found[0].1, name(kind));
            eprintln!(
                "  {cells} cells, {name:8} {dofs:6} dofs: K = 20 G {soft:.3}, 200 G {usual:.3}, 10 000 G {firm:.3}"
            );
            // linear elements hold it: they do not fold at all, or late
            assert!(kind.0 > 1 || firm < 0.6, "{firm}");
        }
    }
}
