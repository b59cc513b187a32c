//! Plane strain as a slab one element thick: a quarter of a ring under inner
//! pressure, ratio of radii 1.5, no displacement along z.
//!
//! References: Lamé's cylinder; for large pressure the boundary value problem of
//! a Neo-Hookean ring, solved independently.

use mechanics::energy::{Energies, Isobaric};
use mechanics::material::{Lame, Material, NeoHookean};
use tests::equilibrium::SILICONE;
use tests::meshes::ring_quarter;

use crate::inflated::{Hollow, Inflated};

fn ring(n: [usize; 2], material: impl Fn() -> Box<dyn Material>, pressure: f64) -> Inflated {
    let law = Box::new(Isobaric { pressure: pressure.into() });
    let mesh = ring_quarter(1.0, 1.5, 0.1, n);
    Inflated::new(Hollow::Tube, mesh, 1.0, 2, |_| Energies::elastic(material()), law)
}

/// a/A and b/B.
fn stretches(ring: &Inflated) -> [f64; 2] {
    [1.0, 1.5].map(|radius| ring.stretch_at(radius))
}

#[test]
fn the_ring_inflates_as_its_radial_solution() {
    // λ of the plane problem: Eν / ((1 + ν)(1 − ν))
    let lame = Lame { lambda: 1e5 * 0.35 / (1.35 * 0.65), ..Lame::new(1e5, 0.35) };
    let law = || -> Box<dyn Material> { Box::new(NeoHookean(lame)) };
    let table = [
        [1e3, 1.030_860_75, 1.016_788_62],
        [5e3, 1.191_106_78, 1.105_447_28],
        [1e4, 1.575_771_51, 1.326_154_25],
    ];
    let mut ring = ring([6, 24], law, 1e4);
    eprintln!("ring, P2, {} dofs: Pa, a/A b/B, errors in %", ring.body.u.len());
    for [pressure, reference @ ..] in table {
        ring.body.solve(pressure / 1e4);
        let ours = stretches(&ring);
        let error: [f64; 2] = std::array::from_fn(|k| 100.0 * (ours[k] / reference[k] - 1.0));
        eprintln!("  {pressure:6} {ours:.6?} {reference:.6?} {error:+.3?}");
        assert!(error.iter().all(|e| e.abs() < 0.5));
    }
}

#[test]
fn small_pressure_gives_the_cylinder_of_lame() {
    let reference = [7.696_078e-6, 3.529_412e-6];
    let errors = [[3, 12], [6, 24]].map(|n| {
        let mut ring = ring(n, || Box::new(SILICONE), 1.0);
        ring.body.solve(1.0);
        let ours = stretches(&ring);
        [0, 1].map(|k: usize| (ours[k] - 1.0) / reference[k] - 1.0)
    });
    eprintln!("cylinder of Lamé, P2, 12 and 24 segments: u(A), u(B) off by {errors:+.4?}");
    for (coarse, fine) in errors[0].iter().zip(errors[1]) {
        assert!(fine.abs() < 0.01 && fine.abs() < coarse.abs() / 2.5);
    }
}
