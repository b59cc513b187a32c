//! Cantilever of two bonded layers, each half of its height h and with an own Young's modulus.
//!
//! With r = E₂/E₁ the neutral axis is h/4 · (r − 1)/(r + 1) above the middle and
//! EI = E₁ b h³/96 · (1 + 14 r + r²)/(1 + r), the formula of a bimetal; the end moves by
//! δ = F L³/(3EI) + k F L/(μ₁ b h).

use mechanics::energy::{Elastic, Energies, Traction};
use mechanics::material::{Lame, NeoHookean};
use mesh::Vec3;
use tests::block;
use tests::equilibrium::{Equilibrium, facets_where};

const LENGTH: f64 = 0.2;
const SIDE: f64 = 0.01;
const FORCE: f64 = 1e-5;
/// Of the lower layer [Pa].
const YOUNG: f64 = 1e5;
const POISSON: f64 = 0.3;

/// Deflection of the end by finite elements; the held end is free to contract [m].
fn deflection(ratio: f64) -> f64 {
    let mut mesh =
        block([40, 2, 4], SIDE / 4.0, |_| false, |p| Vec3::new(2.0 * p.x, 2.0 * p.y, p.z));
    let height = |tet: &[usize; 4]| tet.iter().map(|&v| mesh.vertices[v].z).sum::<f64>() / 4.0;
    let mut tets = mesh.tets.clone();
    tets.sort_by_key(|tet| height(tet) > SIDE / 2.0);
    let below = tets.iter().filter(|tet| height(tet) < SIDE / 2.0).count();
    assert_eq!(2 * below, tets.len());
    let all = tets.len();
    mesh.tets = tets;
    let end = facets_where(&mesh, |p| p.x > LENGTH - 1e-9);
    let energies = |space: &_| {
        let law = |young: f64| Box::new(NeoHookean(Lame::new(young, POISSON)));
        let layers =
            [Elastic::part(law(YOUNG), 0..below), Elastic::part(law(ratio * YOUNG), below..all)];
        let mut energies = Energies::bodies(layers);
        let shear = Vec3::new(0.0, 0.0, FORCE / (SIDE * SIDE));
        energies = energies.with(Traction::new(space, &end, shear.into()));
        energies
    };
    Equilibrium::rise_of_end(mesh, energies, SIDE, LENGTH)
}

/// That of the theory, with k = 6/5: shear has 0.3 % of a beam 20:1, so that k does not matter here.
fn composite(ratio: f64) -> f64 {
    let bending =
        YOUNG * SIDE.powi(4) / 96.0 * (1.0 + 14.0 * ratio + ratio * ratio) / (1.0 + ratio);
    let shear = YOUNG / (2.0 * (1.0 + POISSON)) * SIDE * SIDE * (1.0 + ratio) / 2.0;
    FORCE * LENGTH.powi(3) / (3.0 * bending) + 1.2 * FORCE * LENGTH / shear
}

/// Both ends of a beam of finite length and the equal Poisson ratios are in the tolerance.
#[test]
fn a_cantilever_of_two_layers_bends_as_a_bimetal() {
    eprintln!("cantilever 20:1 of two layers, P2: deflection over that of composite beams");
    for ratio in [1.0, 3.0, 10.0] {
        let found = deflection(ratio) / composite(ratio);
        eprintln!("  E2/E1 = {ratio}: {found:.4}");
        assert!((found - 1.0).abs() < 0.01, "{ratio}: {found}");
    }
}
