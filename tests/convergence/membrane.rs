//! Sheets that are bonded to bodies: a balloon, layered cantilevers.
//!
//! Balloon of an incompressible neo-Hookean skin: P = 2 t μ/R (λ⁻¹ − λ⁻⁷).
//!
//! Cantilever of height h and width b with a sheet on its upper face, n = Y t/(E h): the neutral
//! axis is n h/(2 (1 + n)) above the middle, EI = E b h³/12 (1 + 4n)/(1 + n) and
//! δ = F L³/(3EI) + k F L/(G b h). A sheet in the middle has no part in bending.

use mechanics::energy::{Energies, Isobaric, Membrane, Traction};
use mechanics::material::sheet;
use mechanics::material::{Lame, NeoHookean};
use mesh::{TetMesh, Vec3, facet_key, topology};
use tests::block;
use tests::equilibrium::{Equilibrium, MODULI, SILICONE, facets_where, mean};
use tests::meshes::shell_octant;

use crate::symmetric_gas::{Planes, SymmetricGas};

const RADIUS: f64 = 0.01;
const MU: f64 = 3e5;
const THIN: f64 = 1e-4;

/// Pressure of the balloon at a stretch [Pa].
fn balloon(stretch: f64) -> f64 {
    2.0 * THIN * MU / RADIUS * (stretch.powi(-1) - stretch.powi(-7))
}

/// λ − 1 over that of the closed form at a pressure, of the inner skin of a very soft shell.
fn inflated(degree: usize, arcs: usize, stretch: f64) -> f64 {
    let mesh = shell_octant(RADIUS, 1.05 * RADIUS, arcs, 1);
    let facets = facets_where(&mesh, |p| p.norm() < RADIUS * (1.0 + 1e-9));
    let energies = |space: &_| {
        // a millionth of the skin's stiffness
        let soft = NeoHookean(Lame::new(0.2, 0.3));
        let mut energies = Energies::elastic(Box::new(soft));
        let skin = Box::new(sheet::NeoHookean { mu: MU });
        energies = energies.with(Membrane::new(space, &facets, THIN, skin));
        let gas = Box::new(Isobaric { pressure: balloon(stretch).into() });
        energies.with(SymmetricGas::new(space, &facets, Planes::ThroughOrigin, gas))
    };
    let on_plane = |p: Vec3| [p.x, p.y, p.z].map(|c| c < 1e-9 * RADIUS);
    let mut body = Equilibrium::new(mesh, degree, energies, on_plane);
    for load in [0.25, 0.5, 0.75, 0.9, 1.0] {
        body.solve(load);
    }
    let vertices = body.vertices();
    let inner = vertices.iter().filter(|x| x.0.norm() < RADIUS * (1.0 + 1e-9));
    let found: Vec<f64> = inner.map(|x| x.1.norm() / RADIUS).collect();
    (mean(&found) - 1.0) / (stretch - 1.0)
}

/// Flat facets are the error, of second order as for thick shells: at rest they lie up to 0.12 % of the
/// radius inside the sphere with 16 arcs, which is 6 % of λ − 1 = 0.02.
#[test]
fn a_balloon_keeps_the_law_of_laplace() {
    eprintln!("balloon, neo-Hookean skin: (λ − 1) over that of P = 2 t μ/R (1/λ − 1/λ⁷), P2");
    for stretch in [1.02, 1.2] {
        let found = [4, 8, 16].map(|arcs| inflated(2, arcs, stretch));
        let order = ((found[1] - 1.0) / (found[2] - 1.0)).abs().log2();
        // what second order tends to
        let limit = (4.0 * found[2] - found[1]) / 3.0;
        eprintln!(
            "  λ = {stretch}, 4, 8 and 16 arcs: {found:.5?}, order {order:.2}, limit {limit:.5}"
        );
        assert!((limit - 1.0).abs() < 0.02 && (order - 2.0).abs() < 0.3);
    }
}

const LENGTH: f64 = 0.2;
const SIDE: f64 = 0.01;
const FORCE: f64 = 1e-5;
/// Young's modulus [Pa] and Poisson's ratio of the silicone.
fn young() -> (f64, f64) {
    let (mu, bulk) = MODULI;
    let young = 9.0 * bulk * mu / (3.0 * bulk + mu);
    (young, young / (2.0 * mu) - 1.0)
}

/// Facets of the mesh in the plane z, on the boundary or inside.
fn facets_at(mesh: &TetMesh, z: f64) -> Vec<[usize; 3]> {
    let of_tet = |t: &[usize; 4]| topology::TET_FACETS.map(|f| facet_key(f.map(|c| t[c])));
    let here = |f: &[usize; 3]| f.iter().all(|&v| (mesh.vertices[v].z - z).abs() < 1e-9);
    let mut all: Vec<_> = mesh.tets.iter().flat_map(of_tet).filter(here).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Deflection of the end of a cantilever with a sheet at a height, whose stiffness is n times
/// that of the body [m]. Its held end is free to contract.
fn deflection(n: f64, height: f64) -> f64 {
    let mesh = block([40, 2, 2], SIDE / 2.0, |_| false, |p| p);
    let (young, poisson) = young();
    let end = facets_where(&mesh, |p| p.x > LENGTH - 1e-9);
    let layer = facets_at(&mesh, height);
    assert_eq!(layer.len(), 160);
    let energies = |space: &_| {
        let mut energies = Energies::elastic(Box::new(SILICONE));
        let shear = Vec3::new(0.0, 0.0, FORCE / (SIDE * SIDE));
        energies = energies.with(Traction::new(space, &end, shear.into()));
        // as thin as paper
        let thickness = 1e-4;
        let law = sheet::Linear { young: n * young * SIDE / thickness, poisson };
        energies = energies.with(Membrane::new(space, &layer, thickness, Box::new(law)));
        energies
    };
    Equilibrium::rise_of_end(mesh, energies, SIDE, LENGTH)
}

/// δ of composite-beam theory; k = 6/5 without a sheet, from the shear stress that balances
/// bending with one.
fn composite(n: f64) -> f64 {
    let (young, _) = young();
    let stiffer = (1.0 + 4.0 * n) / (1.0 + n);
    let axis = 0.5 * n / (1.0 + n);
    // q(s) = ½ ((s − axis)² − (½ + axis)²); k = (12/stiffer)² ∫ q² ds
    let (points, mut square) = (10_000, 0.0);
    for i in 0..points {
        let s = (f64::from(i) + 0.5) / f64::from(points) - 0.5;
        let q = 0.5 * ((s - axis).powi(2) - (0.5 + axis).powi(2));
        square += q * q / f64::from(points);
    }
    let k = (12.0 / stiffer).powi(2) * square;
    let bending = young * SIDE.powi(4) / 12.0 * stiffer;
    FORCE * LENGTH.powi(3) / (3.0 * bending) + k * FORCE * LENGTH / (MODULI.0 * SIDE * SIDE)
}

#[test]
fn a_cantilever_with_a_stiff_skin_bends_as_a_composite_beam() {
    eprintln!("cantilever 20:1 with a sheet on top, P2: deflection over that of composite beams");
    for n in [0.1, 1.0, 10.0] {
        let ratio = deflection(n, SIDE) / composite(n);
        eprintln!("  Y t/(E h) = {n}: {ratio:.4}");
        assert!((ratio - 1.0).abs() < 0.02, "{n}: {ratio}");
    }
    let inside = deflection(1.0, 0.5 * SIDE) / composite(0.0);
    eprintln!("  in the middle, Y t/(E h) = 1: {inside:.4} of that without a sheet");
    assert!((inside - 1.0).abs() < 0.01, "{inside}");
}
