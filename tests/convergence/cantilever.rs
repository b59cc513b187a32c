//! Slender bars, one end held, a small shear force on the other: of one law, of two layers, and with a sheet.
//!
//! All deflect by δ = F L³/(3EI) + k F L/(G b h), with the following EI and k. The held end does not turn but may
//! contract sideways; one that is fixed along all axes is stiffer, by an amount that cubic elements give.
//!
//! Of one law (Timoshenko): EI = E b h³/12, k = (12 + 11ν)/(10(1 + ν)).
//!
//! Of two bonded layers, each half of its height and with an own Young's modulus, r = E₂/E₁: the neutral axis is
//! h/4 · (r − 1)/(r + 1) above the middle and EI = E₁ b h³/96 · (1 + 14 r + r²)/(1 + r), the formula of a bimetal.
//!
//! With a sheet on its upper face, n = Y t/(E h): the neutral axis is n h/(2 (1 + n)) above the middle and
//! EI = E b h³/12 (1 + 4n)/(1 + n). A sheet in the middle has no part in bending.

use mechanics::element::FunctionSpace;
use mechanics::energy::{Elastic, Energies, Membrane, Traction};
use mechanics::material::{Lame, NeoHookean, sheet};
use mechanics::testing;
use mesh::{TetMesh, Vec3};
use tests::block;
use tests::equilibrium::{Equilibrium, MODULI, SILICONE, facets_where, mean};

/// Width and height [m].
const SIDE: f64 = 0.01;

/// A bar of a length [m] under a force [N].
struct Bar {
    length: f64,
    force: f64,
}

const SHORT: Bar = Bar { length: 0.1, force: 1e-4 };
const LONG: Bar = Bar { length: 0.2, force: 1e-5 };

/// How the end x = 0 is held.
#[derive(Clone, Copy)]
enum End {
    /// Along all axes.
    Clamped,
    /// Along x; the lines through its middle also across themselves.
    Contracting,
}

impl Bar {
    /// Mean deflection of the loaded end by elements of a degree [m].
    fn found(
        &self,
        mesh: TetMesh,
        degree: usize,
        held: End,
        energies: impl Fn(&FunctionSpace) -> Energies,
    ) -> f64 {
        let at_end = |p: Vec3| p.x > self.length - 1e-9;
        let end = facets_where(&mesh, at_end);
        let shear = Vec3::new(0.0, 0.0, self.force / (SIDE * SIDE));
        let loaded = |space: &_| energies(space).with(Traction::new(space, &end, shear.into()));
        let middle = |c: f64| (c - 0.5 * SIDE).abs() < 1e-9;
        let held = |p: Vec3| match held {
            _ if p.x > 1e-9 => [false; 3],
            End::Clamped => [true; 3],
            End::Contracting => [true, middle(p.y), middle(p.z)],
        };
        let mut bar = Equilibrium::new(mesh, degree, loaded, held);
        bar.solve(1.0);
        let nodes = bar.nodes().into_iter().filter(|x| at_end(x.0));
        mean(&nodes.map(|x| x.1.z - x.0.z).collect::<Vec<_>>())
    }

    /// δ by EI [N m²], and by G b h/k [N].
    fn exact(&self, bending: f64, shear: f64) -> f64 {
        self.force * self.length.powi(3) / (3.0 * bending) + self.force * self.length / shear
    }
}

/// Young's modulus [Pa] and Poisson's ratio by shear and bulk modulus [Pa].
fn young((mu, bulk): (f64, f64)) -> (f64, f64) {
    let young = 9.0 * bulk * mu / (3.0 * bulk + mu);
    (young, young / (2.0 * mu) - 1.0)
}

/// Deflection over Timoshenko's, of a law with shear and bulk modulus [Pa] in cells over the height.
fn ratio(elastic: &Elastic, moduli: (f64, f64), end: End, [degree, cells]: [usize; 2]) -> f64 {
    let mesh = block([10 * cells, cells, cells], SIDE / cells as f64, |_| false, |p| p);
    let found = SHORT.found(mesh, degree, end, |_| Energies::bodies([elastic.clone()]));
    let (young, poisson) = young(moduli);
    let kappa = 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);
    found / SHORT.exact(young * SIDE.powi(4) / 12.0, kappa * moduli.0 * SIDE * SIDE)
}

#[test]
fn quadratic_elements_bend_and_linear_ones_lock() {
    let silicone = Elastic::whole(Box::new(SILICONE));
    let ratio = |end, degree, cells| ratio(&silicone, MODULI, end, [degree, cells]);
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
        let moduli = (mu, bulk_over_shear * mu);
        let (young, poisson) = young(moduli);
        let standard = Elastic::whole(Box::new(NeoHookean(Lame::new(young, poisson))));
        let elastic = if mean { standard.with_mean_dilatation().unwrap() } else { standard };
        [1, 2].map(|cells| 1.0 - ratio(&elastic, moduli, End::Contracting, [2, cells]))
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

/// Deflection of two layers over that of the theory, with k = 6/5: shear has 0.3 % of a beam 20:1, so that k does not
/// matter here.
fn layered(ratio: f64) -> f64 {
    let (lower, poisson) = (1e5, 0.3);
    let mut mesh =
        block([40, 2, 4], SIDE / 4.0, |_| false, |p| Vec3::new(2.0 * p.x, 2.0 * p.y, p.z));
    let height = |tet: &[usize; 4]| tet.iter().map(|&v| mesh.vertices[v].z).sum::<f64>() / 4.0;
    let mut tets = mesh.tets.clone();
    tets.sort_by_key(|tet| height(tet) > SIDE / 2.0);
    let below = tets.iter().filter(|tet| height(tet) < SIDE / 2.0).count();
    assert_eq!(2 * below, tets.len());
    let all = tets.len();
    mesh.tets = tets;
    let found = LONG.found(mesh, 2, End::Contracting, |_| {
        let law = |young: f64| Box::new(NeoHookean(Lame::new(young, poisson)));
        let upper = Elastic::part(law(ratio * lower), below..all);
        Energies::bodies([Elastic::part(law(lower), 0..below), upper])
    });
    let bending =
        lower * SIDE.powi(4) / 96.0 * (1.0 + 14.0 * ratio + ratio * ratio) / (1.0 + ratio);
    let shear = lower / (2.0 * (1.0 + poisson)) * SIDE * SIDE * (1.0 + ratio) / 2.0;
    found / LONG.exact(bending, shear / 1.2)
}

/// Both ends of a beam of finite length and the equal Poisson ratios are in the tolerance.
#[test]
fn a_cantilever_of_two_layers_bends_as_a_bimetal() {
    eprintln!("cantilever 20:1 of two layers, P2: deflection over that of composite beams");
    for ratio in [1.0, 3.0, 10.0] {
        let found = layered(ratio);
        eprintln!("  E2/E1 = {ratio}: {found:.4}");
        assert!((found - 1.0).abs() < 0.01, "{ratio}: {found}");
    }
}

/// Deflection with a sheet at a height, whose stiffness is n times that of the body [m].
fn with_sheet(n: f64, height: f64) -> f64 {
    let mesh = block([40, 2, 2], SIDE / 2.0, |_| false, |p| p);
    let (young, poisson) = young(MODULI);
    let layer = testing::facets_where(&mesh, |p| (p.z - height).abs() < 1e-9);
    assert_eq!(layer.len(), 160);
    LONG.found(mesh, 2, End::Contracting, |space| {
        // as thin as paper
        let thickness = 1e-4;
        let law = sheet::Linear { young: n * young * SIDE / thickness, poisson };
        let sheet = Membrane::new(space, &layer, thickness, Box::new(law));
        Energies::elastic(Box::new(SILICONE)).with(sheet)
    })
}

/// δ of composite-beam theory; k = 6/5 without a sheet, from the shear stress that balances
/// bending with one.
fn composite(n: f64) -> f64 {
    let (young, _) = young(MODULI);
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
    LONG.exact(young * SIDE.powi(4) / 12.0 * stiffer, MODULI.0 * SIDE * SIDE / k)
}

#[test]
fn a_cantilever_with_a_stiff_skin_bends_as_a_composite_beam() {
    eprintln!("cantilever 20:1 with a sheet on top, P2: deflection over that of composite beams");
    for n in [0.1, 1.0, 10.0] {
        let ratio = with_sheet(n, SIDE) / composite(n);
        eprintln!("  Y t/(E h) = {n}: {ratio:.4}");
        assert!((ratio - 1.0).abs() < 0.02, "{n}: {ratio}");
    }
    let inside = with_sheet(1.0, 0.5 * SIDE) / composite(0.0);
    eprintln!("  in the middle, Y t/(E h) = 1: {inside:.4} of that without a sheet");
    assert!((inside - 1.0).abs() < 0.01, "{inside}");
}
