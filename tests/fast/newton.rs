//! Newton's method at the rounding floor, and the softest mode.

use mechanics::energy::{BodyForce, Energies};
use mechanics::forward::Failure;
use mechanics::material::{Kinematics, Material, MooneyRivlin};
use mechanics::math::tensor::{Mat3, Mat9};
use mechanics::stability::SoftestMode;
use mesh::Vec3;
use tests::block;
use tests::equilibrium::{Equilibrium, SILICONE, newton};

/// A law whose stresses are wrong in their ninth digit, in a way that changes with
/// every bit of F.
struct Blurred(MooneyRivlin);

impl Material for Blurred {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        self.0.energy_density(k)
    }
    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        self.0.first_piola(k).zip_map(&k.f, |stress, f| {
            let hash = f.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11;
            stress * (1.0 + 1e-9 * (hash as f64 / 2.0_f64.powi(52) - 1.0))
        })
    }
    fn tangent(&self, k: &Kinematics) -> Mat9 {
        self.0.tangent(k)
    }
    fn parameter_count(&self) -> usize {
        self.0.parameter_count()
    }
    fn add_parameter_vjp(&self, k: &Kinematics, bar: &Mat3, out: &mut [f64]) {
        self.0.add_parameter_vjp(k, bar, out);
    }
}

/// A bar of square section that bends under its weight.
fn bar(cells: [usize; 3], edge: f64, force: f64, law: fn() -> Box<dyn Material>) -> Equilibrium {
    Equilibrium::new(
        block(cells, edge, |_| false, |p| p),
        2,
        |_| {
            let down = Vec3::new(0.0, 0.0, -force);
            Energies::elastic(law()).with(BodyForce::whole(down.into()))
        },
        |p| [p.x < 1e-9; 3],
    )
}

/// The residual that Newton's method ends at, for any tolerance, is within a factor of
/// the estimate: for stiff and slender bodies, small and large strain.
#[test]
fn the_rounding_floor_is_where_residuals_end() {
    for (cells, edge, force) in [
        ([2, 2, 2], 1e-2, 1e4),
        ([2, 2, 2], 1e-2, 1e6),
        ([2, 2, 2], 1e1, 1e2),
        ([12, 1, 1], 1e-2, 1e2),
        ([40, 1, 1], 1e-3, 1e2),
    ] {
        let mut bar = bar(cells, edge, force, || Box::new(SILICONE));
        let end = bar.balance(&newton(60, 1e-20), 1.0).unwrap();
        let floor = end.floor.expect("nobody reaches 1e-20");
        eprintln!("{cells:?}: residual {:.1e} N, floor {floor:.1e} N", end.residual);
        assert!(end.residual < floor && end.residual > 1e-3 * floor, "{cells:?} {end:?}");
    }
}

#[test]
fn forces_that_are_not_accurate_stagnate_above_the_floor() {
    let mut bar = bar([3, 2, 2], 1e-2, 1e4, || Box::new(Blurred(SILICONE)));
    let newton = newton(40, 1e-12);
    let failure = bar.balance(&newton, 1.0).unwrap_err();
    let Failure::Stagnated { iterations, residual, wanted, floor, scale } = failure else {
        panic!("{failure}")
    };
    assert!(iterations < 20 && wanted < residual && floor < residual, "{failure}");
    assert!((1e-11..1e-8).contains(&(residual / scale)), "{failure}");
    assert!(failure.to_string().contains("floor by rounding"), "{failure}");
}

/// The softest motion of a clamped bar is its first bending: a beam on the
/// node masses of the identity has no closed form, but its stiffness falls with
/// the fourth power of the length, and one free bar has none.
#[test]
fn the_softest_motion_of_a_bar_bends_it() {
    let softest_mode = |length: usize, held: bool| {
        let mut bar = Equilibrium::new(
            block([length, 1, 1], 1e-2, |_| false, |p| p),
            2,
            |_| Energies::elastic(Box::new(SILICONE)),
            |p| [held && p.x < 1e-9; 3],
        );
        let zero = vec![0.0; bar.problem.dofs()];
        let mode = SoftestMode::of(
            &bar.problem,
            &mut bar.workspace,
            &bar.problem.iterate(&bar.rest, &zero, 0.0),
            0.1,
        );
        let end = bar.rest.iter().position(|p| p.x > 0.01 * length as f64 - 1e-9).unwrap();
        let motion = mechanics::element::at(&mode.motion, end);
        (mode, motion)
    };
    let (short, motion) = softest_mode(8, true);
    let (long, _) = softest_mode(16, true);
    assert!(!short.floats(1.0) && motion.x.abs() < 0.5 * motion.norm(), "{motion}");
    // bending alone would give 1/16; the short bar also shears
    let ratio = long.stiffness.unwrap() / short.stiffness.unwrap();
    assert!((1.0 / 16.0..0.08).contains(&ratio), "{ratio}");
    // a pivot is never below the smallest eigenvalue
    assert!(short.pivot.unwrap().value >= short.stiffness.unwrap());
    assert!(softest_mode(8, false).0.floats(1.0));
}
