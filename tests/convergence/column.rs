//! A column that buckles under its end load, a bifurcation.
//!
//! A column of Poisson's ratio 0 between z = ± h/2 that keeps its width, with hinged ends, shortens by λ without other
//! strain. With the law ψ = ½μ(I₁ − 3 − 2 ln J) the small motion u = U(Z) cos kX, w = W(Z) sin kX with k = π/L
//! leaves forces and free faces in balance where
//!
//! tanh(½kh) = q³ λ² tanh(½qkh),   q² = ½(1 + λ⁻²),   P/(b h) = μ(1/λ − λ)
//!
//! which tends to Euler's π²EI/L² with E = 2μ where h/L tends to 0. It has all of shear and large strain.

use std::f64::consts::PI;

use mechanics::energy::{Energies, Traction};
use mechanics::forward::Singularity;
use mechanics::material::{Lame, NeoHookean};
use mechanics::schedule::Field;
use mechanics::stability::FirstLimit;
use mesh::Vec3;
use tests::block;
use tests::equilibrium::{Equilibrium, facets_where};

/// Thickness [m] and Young's modulus [Pa].
const H: f64 = 0.01;
const YOUNG: f64 = 1e5;

/// End load over b h [Pa] of the formula.
fn exact(slenderness: f64) -> f64 {
    let half = 0.5 * PI / slenderness;
    let off = |stretch: f64| {
        let q = (0.5 * (1.0 + stretch.powi(-2))).sqrt();
        half.tanh() - q.powi(3) * stretch * stretch * (q * half).tanh()
    };
    let euler = (2.0 * half).powi(2) / 12.0;
    let (mut low, mut high) = (1.0 - 2.0 * euler, 1.0 - 0.5 * euler);
    let below = off(low) > 0.0;
    assert!(below != (off(high) > 0.0));
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if (off(middle) > 0.0) == below { low = middle } else { high = middle }
    }
    0.5 * YOUNG * (1.0 / low - low)
}

/// π²EI/(L² b h) [Pa].
fn euler(slenderness: f64) -> f64 {
    YOUNG * (PI / slenderness).powi(2) / 12.0
}

/// End load over b h [Pa] of a half of the column, from a hinge to the middle: in elements of a degree, with so many
/// along it and two over its thickness.
fn found(slenderness: f64, degree: usize, along: usize) -> f64 {
    let length = 0.5 * slenderness * H;
    let stretched =
        |p: Vec3| Vec3::new(p.x * length / (0.5 * H * along as f64), p.y, p.z - 0.5 * H);
    let mesh = block([along, 2, 2], 0.5 * H, |_| false, stretched);
    let full = 1.5 * euler(slenderness);
    let end = facets_where(&mesh, |p| p.x < 1e-9);
    let energies = |space: &_| {
        let pushed: Field = Vec3::new(full, 0.0, 0.0).into();
        let law = NeoHookean(Lame::new(YOUNG, 0.0));
        Energies::elastic(Box::new(law)).with(Traction::new(space, &end, pushed))
    };
    let held = |p: Vec3| [p.x > length - 1e-9, true, p.x < 1e-9];
    let mut column = Equilibrium::new(mesh, degree, energies, held);
    let FirstLimit::Found(limit, _) = column.first_limit(|_| ()) else { panic!("no limit") };
    assert!(limit.kind == Singularity::Bifurcation && limit.others == 0);
    limit.at.time * full
}

/// Threshold, set before: 1e-4 of the load. Elements of degree 2 miss it by their thickness, of which there are two, and
/// have 2e-3.
#[test]
fn a_column_buckles_at_the_load_of_its_closed_form() {
    eprintln!("column of L/h: P/(b h) [Pa] exact, over Euler's; P2 and P3 over the exact");
    for slenderness in [5.0, 10.0, 20.0, 40.0] {
        let exact = exact(slenderness);
        let [quadratic, cubic] = [(2, 16), (3, 8)]
            .map(|(degree, along)| found(slenderness, degree, along) / exact - 1.0);
        let corrected = exact / euler(slenderness);
        eprintln!("  {slenderness}: {exact:.4} {corrected:.6} {quadratic:.1e} {cubic:.1e}");
        assert!(quadratic.abs() < 2e-3 && cubic.abs() < 1e-4);
    }
}
