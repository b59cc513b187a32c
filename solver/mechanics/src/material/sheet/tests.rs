//! What every row of the table of sheets must hold, with and without compression.

use nalgebra::{Matrix2, Matrix3x2, SMatrix};

use super::*;
use crate::material::tests::relative_slope;
use crate::math::random::Random;
use crate::testing::check_gradient;

/// E of principal stretches along a direction at an angle.
fn strain(stretches: [f64; 2], angle: f64) -> Strain {
    let [a, b] = stretches.map(|l| 0.5 * (l * l - 1.0));
    let (c, s) = (angle.cos(), angle.sin());
    Strain::new(a * c * c + b * s * s, a * s * s + b * c * c, 2.0 * (a - b) * c * s)
}

/// Principal stretches by what a sheet of any law is at them: taut ones, equal ones among them,
/// wrinkled and slack ones.
const TAUT: [[f64; 2]; 4] = [[1.3, 1.1], [1.2, 1.2], [1.5, 1.0], [1.05, 0.995]];
const WRINKLED: [[f64; 2]; 3] = [[1.3, 0.7], [1.1, 0.9], [1.8, 0.5]];
const SLACK: [[f64; 2]; 3] = [[0.95, 0.8], [0.9, 0.9], [0.99, 0.7]];

fn law(row: &Law<dyn Sheet>, tension: bool) -> Box<dyn Sheet> {
    relaxed((row.build)(row.sample), tension)
}

fn relaxed(law: Box<dyn Sheet>, tension: bool) -> Box<dyn Sheet> {
    if tension { Box::new(TensionField(law)) } else { law }
}

/// All strains at which a sheet has two derivatives, and resists.
fn strains(tension: bool) -> Vec<Strain> {
    let resisting: Vec<[f64; 2]> = if tension {
        [&TAUT[..], &WRINKLED[..]].concat()
    } else {
        [&TAUT[..], &WRINKLED[..], &SLACK[..]].concat()
    };
    resisting.into_iter().map(|stretches| strain(stretches, 0.4)).collect()
}

fn each(f: impl Fn(&Law<dyn Sheet>, &dyn Sheet, &Strain)) {
    for row in LAWS {
        for tension in [false, true] {
            let law = law(row, tension);
            strains(tension).iter().for_each(|e| f(row, &*law, e));
        }
    }
}

fn at(x: &[f64]) -> Strain {
    Strain::from_column_slice(x)
}

#[test]
fn states_are_told_apart() {
    for row in LAWS {
        let law = (row.build)(row.sample);
        for (all, expected) in
            [(&TAUT[..], State::Taut), (&WRINKLED[..], State::Wrinkled), (&SLACK[..], State::Slack)]
        {
            for stretches in all {
                assert_eq!(law.state(&strain(*stretches, 0.7)), expected, "{stretches:?}");
            }
        }
        assert_eq!(law.state(&Strain::zeros()), State::Taut, "{}", row.key);
    }
}

#[test]
fn stress_is_the_derivative_of_energy_and_tangent_that_of_stress() {
    each(|row, law, e| {
        let s = law.stress(e);
        check_gradient(e.as_slice(), s.as_slice(), 1e-3, |x| law.energy_density(&at(x)));
        let d = law.tangent(e);
        assert!((d - d.transpose()).amax() < 1e-13 * d.amax(), "{}", row.key);
        let q = Strain::new(0.3, -0.5, 0.8);
        let h = 1e-5;
        let change = (law.stress(&(e + h * q)) - law.stress(&(e - h * q))) / (2.0 * h);
        let error = (d * q - change).norm() / change.norm();
        assert!(error < 1e-7, "{}: {error:e} at {e}", row.key);
    });
}

#[test]
fn parameter_derivatives_are_those_of_stress() {
    let bar = Strain::new(0.4, -0.3, 0.7);
    for row in LAWS {
        for tension in [false, true] {
            for e in strains(tension) {
                let mut by = vec![0.0; row.sample.len()];
                law(row, tension).add_parameter_vjp(&e, &bar, &mut by);
                let value = |law: Box<dyn Sheet>| relaxed(law, tension).stress(&e).dot(&bar);
                let scale = value((row.build)(row.sample)).abs();
                for (i, by) in by.iter().enumerate() {
                    let (slope, by) = (relative_slope(row, i, value), by * row.sample[i]);
                    let error = (slope - by).abs();
                    assert!(error < 1e-8 * (by.abs() + scale), "{} {i}: {slope} {by}", row.key);
                }
            }
        }
    }
}

/// S of a diagonal strain, as force per rest width and thickness P = λ S.
fn nominal(law: &dyn Sheet, stretches: [f64; 2]) -> [f64; 2] {
    let s = law.stress(&strain(stretches, 0.0));
    [stretches[0] * s[0], stretches[1] * s[1]]
}

#[test]
fn uniaxial_and_biaxial_stretch_are_those_of_closed_forms() {
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    let (young, poisson, mu) = (2.1e5, 0.3, 3.2e4);
    let (linear, rubber) = (Linear { young, poisson }, NeoHookean { mu });
    for stretch in [0.8_f64, 1.001, 1.3, 2.0] {
        let e = 0.5 * (stretch * stretch - 1.0);
        // a strip: no stress across its natural width
        let narrow = |width: f64| (1.0 + 2.0 * width).sqrt();
        let width = narrow(linear.natural_width(e));
        let [along, across] = nominal(&linear, [stretch, width]);
        close(along, stretch * young * e);
        assert!(across.abs() < 1e-12 * along.abs());
        let width = narrow(rubber.natural_width(e));
        close(width, stretch.powf(-0.5));
        let [along, across] = nominal(&rubber, [stretch, width]);
        close(along, mu * (stretch - stretch.powi(-2)));
        assert!(across.abs() < 1e-12 * along.abs());
        // the same in both directions
        close(nominal(&linear, [stretch; 2])[0], stretch * young * e / (1.0 - poisson));
        close(nominal(&rubber, [stretch; 2])[0], mu * (stretch - stretch.powi(-5)));
    }
}

#[test]
fn small_strains_keep_their_digits() {
    let e = Strain::new(3e-9, -1e-9, 2e-9);
    let linear = Linear { young: 3.0 * 3.2e4, poisson: 0.5 };
    let rubber = NeoHookean { mu: 3.2e4 };
    assert!((rubber.stress(&e) - linear.stress(&e)).norm() < 1e-7 * linear.stress(&e).norm());
    assert!((rubber.energy_density(&e) / linear.energy_density(&e) - 1.0).abs() < 1e-7);
    let tangent = rubber.tangent(&Strain::zeros()) - linear.tangent(&Strain::zeros());
    assert!(tangent.amax() < 1e-15 * linear.tangent(&e).amax());
}

#[test]
fn the_basis_does_not_matter() {
    for row in LAWS {
        for tension in [false, true] {
            let law = law(row, tension);
            if law.has_axes() {
                continue;
            }
            for stretches in TAUT.into_iter().chain(WRINKLED) {
                let energy = |angle: f64| law.energy_density(&strain(stretches, angle));
                assert!((energy(1.1) / energy(0.0) - 1.0).abs() < 1e-12, "{}", row.key);
            }
        }
    }
}

#[test]
fn a_sheet_in_tension_carries_nothing_in_compression() {
    for row in LAWS {
        let law = law(row, true);
        for stretches in SLACK {
            let e = strain(stretches, 0.4);
            assert_eq!(law.energy_density(&e), 0.0);
            assert_eq!(law.stress(&e), Stress::zeros());
            assert_eq!(law.tangent(&e), Mat3::zeros());
        }
        for stretches in WRINKLED {
            // nothing across the wrinkles, and no matter how deep they are
            let [along, across] = nominal(&*law, stretches);
            assert!(along > 0.0 && across.abs() < 1e-13 * along, "{}", row.key);
            let deeper = [stretches[0], 0.9 * stretches[1]];
            assert!((nominal(&*law, deeper)[0] / along - 1.0).abs() < 1e-13, "{}", row.key);
        }
    }
}

/// The relaxed energy is the least over all wrinkles W ⪰ 0.
#[test]
fn wrinkles_take_up_as_much_as_lowers_the_energy_most() {
    let mut random = Random::new(3);
    let wrinkles: Vec<Strain> = (0..4000)
        .map(|_| {
            let [a, b, c, d] = [(); 4].map(|()| random.uniform());
            let root = Matrix2::new(a, b, c, d);
            let w = root.transpose() * root;
            Strain::new(w[(0, 0)], w[(1, 1)], 2.0 * w[(0, 1)])
        })
        .collect();
    for row in LAWS {
        let (full, relaxed) = (law(row, false), law(row, true));
        for stretches in TAUT.into_iter().chain(WRINKLED).chain(SLACK) {
            let e = strain(stretches, 0.4);
            let least = relaxed.energy_density(&e);
            let scale = full.energy_density(&e);
            assert!(least <= scale * (1.0 + 1e-14), "{}", row.key);
            for w in &wrinkles {
                for size in [1e-3, 1e-2, 0.1, 1.0] {
                    let with = full.energy_density(&(e + size * w));
                    assert!(with >= least - 1e-13 * scale, "{}: {with} {least}", row.key);
                }
            }
        }
    }
}

/// No jump of energy and stress where a sheet becomes wrinkled or slack.
#[test]
fn energy_and_stress_are_continuous() {
    for row in LAWS {
        let law = law(row, true);
        let largest = law.tangent(&Strain::zeros()).amax();
        let step = 1e-9;
        for first in [0.3, 0.05] {
            let width = law.natural_width(first);
            for border in [width, 0.0] {
                let e = |off: f64| match border {
                    0.0 => Strain::new(off, -0.2, 0.0),
                    border => Strain::new(first, border + off, 0.0),
                };
                let jump = law.stress(&e(step)) - law.stress(&e(-step));
                // of two sides that are 2 steps apart
                assert!(jump.amax() < 3.0 * step * largest, "{} {jump}", row.key);
                let jump = law.energy_density(&e(step)) - law.energy_density(&e(-step));
                assert!(jump.abs() < 3.0 * step * law.stress(&e(step)).amax() + 1e-12 * largest);
            }
        }
    }
}

/// ∂²ψᵣ/∂F² has no negative eigenvalue, in any state.
#[test]
fn the_relaxed_energy_is_convex_in_the_deformation() {
    let mut random = Random::new(8);
    for row in LAWS {
        let law = law(row, true);
        let largest = law.tangent(&Strain::zeros()).amax();
        for _ in 0..2000 {
            let f = Matrix3x2::from_fn(|i, j| f64::from(u8::from(i == j)) + 0.6 * random.uniform());
            let c = f.transpose() * f;
            let e = Strain::new(0.5 * (c[(0, 0)] - 1.0), 0.5 * (c[(1, 1)] - 1.0), c[(0, 1)]);
            let (s, d) = (law.stress(&e), law.tangent(&e));
            let mut by = SMatrix::<f64, 3, 6>::zeros();
            for i in 0..3 {
                (by[(0, i)], by[(1, 3 + i)]) = (f[(i, 0)], f[(i, 1)]);
                (by[(2, i)], by[(2, 3 + i)]) = (f[(i, 1)], f[(i, 0)]);
            }
            let s = Matrix2::new(s[0], s[2], s[2], s[1]);
            let hessian = by.transpose() * d * by + s.kronecker(&Mat3::identity());
            let least = hessian.symmetric_eigenvalues().min();
            assert!(least > -1e-12 * (largest + hessian.amax()), "{}: {least}", row.key);
        }
    }
}

/// A strip of fabric at any angle to the warp: the off-axis modulus of orthotropic plies, by rotating the stiffness.
#[test]
fn a_strip_of_fabric_has_its_modulus_off_the_axes() {
    let fabric = Woven { warp: 3e6, weft: 4e5, shear: 5e4, poisson: 0.4 };
    let compliance = fabric.tangent(&Strain::zeros()).try_inverse().expect("it resists");
    for degrees in [0.0_f64, 10.0, 45.0, 72.0, 90.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let softness = c.powi(4) / 3e6
            + s.powi(4) / 4e5
            + (1.0 / 5e4 - 2.0 * 0.4 / 3e6) * s.powi(2) * c.powi(2);
        let stress = 1e3 * Stress::new(c * c, s * s, s * c);
        let e = compliance * stress;
        let along = e.dot(&Strain::new(c * c, s * s, s * c));
        assert!((1e3 / along * softness - 1.0).abs() < 1e-12, "{degrees}°");
        // in tension alone it is just taut, and further compressed across it carries the same
        let relaxed = TensionField(Box::new(fabric));
        let across = Strain::new(s * s, c * c, -2.0 * s * c);
        let found = relaxed.stress(&(e - 1e-3 * across));
        assert!((found - stress).norm() < 1e-10 * stress.norm(), "{degrees}° {found}");
    }
}

/// With the moduli of an isotropic sheet it is that sheet, wrinkled, too.
#[test]
fn a_fabric_without_a_grain_is_isotropic() {
    let (young, poisson) = (2.1e5, 0.3);
    let shear = young / (2.0 * (1.0 + poisson));
    let plain: Box<dyn Sheet> = Box::new(Linear { young, poisson });
    let fabric: Box<dyn Sheet> = Box::new(Woven { warp: young, weft: young, shear, poisson });
    let both = [plain, fabric].map(TensionField);
    for stretches in TAUT.into_iter().chain(WRINKLED) {
        let e = strain(stretches, 0.4);
        let [s, other] = [0, 1].map(|k| both[k].stress(&e));
        assert!((s - other).norm() < 1e-12 * s.norm(), "{stretches:?}");
        let [d, other] = [0, 1].map(|k| both[k].tangent(&e));
        assert!((d - other).norm() < 1e-7 * d.norm(), "{stretches:?} {d} {other}");
    }
}

/// The best of all strips of strong fabrics, beside a search through ten thousand.
#[test]
fn strips_of_a_wrinkled_fabric_store_most() {
    let mut random = Random::new(4);
    for fabric in [
        Woven { warp: 1e7, weft: 2e5, shear: 3e4, poisson: 0.3 },
        Woven { warp: 3e5, weft: 4e5, shear: 9e5, poisson: -0.2 },
    ] {
        let relaxed = TensionField(Box::new(fabric));
        for _ in 0..300 {
            let e = Strain::from_fn(|_, _| random.uniform() - 0.2);
            if fabric.state(&e) != State::Wrinkled {
                continue;
            }
            let stored = |k: usize| {
                let (s, c) = (1e-4 * std::f64::consts::PI * k as f64).sin_cos();
                let n = Stress::new(c * c, s * s, s * c);
                let soft = (fabric.tangent(&e).try_inverse().expect("it resists") * n).dot(&n);
                0.5 * n.dot(&e).max(0.0).powi(2) / soft
            };
            let most = (0..10_000).map(stored).fold(0.0, f64::max);
            let found = relaxed.energy_density(&e);
            assert!((most / found - 1.0).abs() < 1e-5 && most < found * (1.0 + 1e-12), "{e}");
        }
    }
}
