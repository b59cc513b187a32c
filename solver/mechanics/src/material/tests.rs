//! What every row of the table of laws must hold.

use nalgebra::{Rotation3, Vector3};

use super::*;
use crate::math::lanes::tensor::splat;
use crate::math::lanes::{Lanes, Scalar, projection};
use crate::math::random::Random;
use crate::math::tensor::{project_isotropic, project_positive, vec9};
use crate::testing::check_gradient;

fn at(f: &Mat3) -> Kinematics {
    Kinematics::new(&(f - Mat3::identity()))
}

fn sample(law: &Law) -> Box<dyn Material> {
    (law.build)(law.sample)
}

/// Deformations with J > 0: distinct stretches, two and three equal ones, and
/// strong compression.
fn deformations() -> Vec<Mat3> {
    let odd = Mat3::new(1.2, 0.3, -0.1, 0.05, 0.8, 0.25, -0.2, 0.1, 1.3);
    let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
    let back = Rotation3::from_euler_angles(-0.8, 0.4, 0.9).into_inner();
    let stretched =
        |a: f64, b: f64, c: f64| turn * Mat3::from_diagonal(&Vector3::new(a, b, c)) * back;
    vec![
        odd,
        stretched(1.4, 0.9, 0.9),
        stretched(1.1, 1.1, 1.1),
        stretched(2.5, 0.7, 0.7 + 1e-9),
        stretched(0.6, 0.8, 1.0),
        Mat3::identity(),
    ]
}

fn rotation() -> Mat3 {
    Rotation3::from_euler_angles(0.7, 1.9, -0.4).into_inner()
}

fn flat(a: &Mat3) -> Vec<f64> {
    a.as_slice().to_vec()
}

#[test]
fn keys_are_unique_and_rows_complete() {
    let mut keys: Vec<_> = LAWS.iter().map(|law| law.key).collect();
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), LAWS.len());
    for law in LAWS {
        assert!(law.formula.starts_with("ψ = ") && !law.source.is_empty(), "{}", law.key);
        let count: usize = law.named(law.sample).iter().map(|(_, values)| values.len()).sum();
        assert_eq!(count, law.sample.len(), "{}", law.key);
        assert_eq!(law.check(law.sample), Ok(()), "the sample is admissible");
    }
}

#[test]
fn parameters_of_no_law_are_refused() {
    let cases: [(&str, &[f64], &str); 4] = [
        ("gent", &[1e4, 0.0, 2e6], "must be above 0"),
        ("gent", &[1e4, -3.0, 2e6], "must be above 0"),
        ("arruda-boyce", &[1e4, 1.0, 2e6], "lambda_m = 1: must be above 1"),
        ("ogden", &[1e4, 0.0, 2e6], "alpha of term 1 is 0"),
    ];
    for (key, values, words) in cases {
        let law = LAWS.iter().find(|law| law.key == key).expect("a law");
        let message = law.check(values).expect_err("no such law").to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn stress_is_the_derivative_of_energy() {
    for law in LAWS {
        let material = sample(law);
        let energy = |f: &[f64]| material.energy_density(&at(&Mat3::from_column_slice(f)));
        for f in deformations().iter().take(5) {
            let stress = material.first_piola(&at(f));
            check_gradient(&flat(f), stress.as_slice(), 1e-3, energy);
        }
    }
}

#[test]
fn tangent_is_the_derivative_of_stress() {
    let weight = Mat3::new(0.3, -0.2, 0.5, 0.1, 0.4, -0.6, 0.7, 0.2, -0.3);
    for law in LAWS {
        let material = sample(law);
        for f in deformations() {
            let tangent = material.tangent(&at(&f));
            let asymmetry = (tangent - tangent.transpose()).norm() / tangent.norm();
            assert!(asymmetry < 1e-13, "{}: {asymmetry}", law.key);
            let q = vec9(&Mat3::new(0.2, 0.5, -0.4, 0.3, -0.6, 0.1, 0.9, -0.2, 0.4));
            let direction = Mat3::from_column_slice(q.as_slice());
            let e = 1e-5;
            let stress = |s: f64| material.first_piola(&at(&(f + s * direction)));
            let change = vec9(&((stress(e) - stress(-e)) / (2.0 * e)));
            let error = (tangent * q - change).norm() / change.norm();
            assert!(error < 1e-8, "{}: {error} at {f}", law.key);
            if law.objective {
                // a linear law has no second-order remainder to measure
                let value =
                    |f: &[f64]| material.first_piola(&at(&Mat3::from_column_slice(f))).dot(&weight);
                let gradient = tangent * vec9(&weight);
                check_gradient(&flat(&f), gradient.as_slice(), 1e-2, value);
            }
        }
    }
}

/// p ∂v/∂p of a value v by a parameter p of a law with those of its sample.
pub(super) fn relative_slope<M: ?Sized>(
    law: &Law<M>,
    parameter: usize,
    value: impl Fn(Box<M>) -> f64,
) -> f64 {
    const STEP: f64 = 1e-5;
    let [up, down] = [STEP, -STEP].map(|step| {
        let mut values = law.sample.to_vec();
        values[parameter] *= 1.0 + step;
        value((law.build)(&values))
    });
    (up - down) / (2.0 * STEP)
}

#[test]
fn parameter_derivatives_are_those_of_stress() {
    let bar = Mat3::new(0.4, -0.1, 0.2, 0.8, 0.5, -0.3, -0.6, 0.1, 0.7);
    for law in LAWS {
        for f in deformations().iter().take(5) {
            let k = at(f);
            let mut gradient = vec![0.0; law.sample.len()];
            sample(law).add_parameter_vjp(&k, &bar, &mut gradient);
            let value = |law: Box<dyn Material>| law.first_piola(&k).dot(&bar);
            let scale = value(sample(law)).abs();
            for (i, g) in gradient.iter().enumerate() {
                let (slope, g) = (relative_slope(law, i, value), g * law.sample[i]);
                let error = (slope - g).abs();
                assert!(error < 1e-8 * (g.abs() + scale), "{} {i}: {slope} {g}", law.key);
            }
        }
    }
}

#[test]
fn parameter_derivatives_of_isochoric_parts_are_those_of_their_energies() {
    let mut laws = 0;
    for law in LAWS {
        let Some(own) = sample(law).isochoric() else { continue };
        laws += 1;
        for f in deformations().iter().take(5) {
            let k = at(f);
            let energy =
                |law: Box<dyn Material>| law.isochoric().expect("as the sample").energy_density(&k);
            let mut gradient = vec![0.0; law.sample.len()];
            own.add_energy_vjp(&k, 1.0, &mut gradient);
            let size = sample(law).energy_density(&k);
            for (i, g) in gradient.iter().enumerate() {
                let (slope, g) = (relative_slope(law, i, energy), g * law.sample[i]);
                assert!((slope - g).abs() < 1e-8 * size, "{} {i}: {slope} {g}", law.key);
            }
        }
    }
    assert_eq!(laws, 6);
}

#[test]
fn a_rotation_of_the_body_turns_its_stress_and_keeps_its_energy() {
    let q = rotation();
    for law in LAWS {
        let material = sample(law);
        for f in deformations().iter().take(5) {
            let (k, turned) = (at(f), at(&(q * f)));
            let (energy, other) = (material.energy_density(&k), material.energy_density(&turned));
            let stress = material.first_piola(&k);
            let change = (material.first_piola(&turned) - q * stress).norm() / stress.norm();
            let objective = (energy / other - 1.0).abs() < 1e-12 && change < 1e-12;
            assert_eq!(objective, law.objective, "{}: {energy} {other} {change}", law.key);
        }
    }
}

#[test]
fn no_direction_of_the_material_is_special() {
    let q = rotation();
    for law in LAWS {
        let material = sample(law);
        for f in deformations().iter().take(5) {
            // F → FQ for laws of finite strain; both sides for the linear one,
            // which rotations strain
            let (turned, left) =
                if law.objective { (f * q, Mat3::identity()) } else { (q.transpose() * f * q, q) };
            let (k, turned) = (at(f), at(&turned));
            let (energy, other) = (material.energy_density(&k), material.energy_density(&turned));
            assert!((energy / other - 1.0).abs() < 1e-12, "{}: {energy} {other}", law.key);
            let stress = material.first_piola(&k);
            let expected = left.transpose() * stress * q;
            let change = (material.first_piola(&turned) - expected).norm() / stress.norm();
            assert!(change < 1e-12, "{}: {change}", law.key);
        }
    }
}

#[test]
fn rest_is_free_of_stress_and_has_the_stated_moduli() {
    let rest = Kinematics::new(&Mat3::zeros());
    for law in LAWS {
        let (material, moduli) = (sample(law), (law.moduli)(law.sample));
        assert_eq!(material.energy_density(&rest), 0.0, "{}", law.key);
        assert_eq!(material.first_piola(&rest), Mat3::zeros(), "{}", law.key);
        let tangent = material.tangent(&rest);
        let mut random = Random::new(5);
        for _ in 0..4 {
            let h = Mat3::from_fn(|_, _| random.uniform());
            let expected = hooke(&moduli, &h);
            let error = (tangent * vec9(&h) - vec9(&expected)).norm() / expected.norm();
            assert!(error < 1e-14, "{}: {error}", law.key);
        }
    }
}

/// 2 shear dev ε + bulk tr ε I.
fn hooke(moduli: &Moduli, h: &Mat3) -> Mat3 {
    let strain = 0.5 * (h + h.transpose());
    2.0 * moduli.shear * strain
        + Mat3::from_diagonal_element((moduli.bulk - 2.0 / 3.0 * moduli.shear) * strain.trace())
}

#[test]
fn tiny_strains_lose_no_digits() {
    // at strain e, Hooke's law is met up to a relative error of order e
    let mut random = Random::new(6);
    for law in LAWS {
        let (material, moduli) = (sample(law), (law.moduli)(law.sample));
        for size in [1e-6, 1e-9, 1e-12] {
            let h = size * Mat3::from_fn(|_, _| random.uniform());
            let k = Kinematics::new(&h);
            let (stress, energy) = (material.first_piola(&k), material.energy_density(&k));
            let expected = hooke(&moduli, &h);
            let error = (stress - expected).norm() / expected.norm();
            assert!(error < 30.0 * size + 1e-13, "{}: stress {error} at {size}", law.key);
            let error = energy / (0.5 * expected.dot(&h)) - 1.0;
            assert!(error.abs() < 30.0 * size + 1e-13, "{}: energy {error} at {size}", law.key);
        }
    }
}

#[test]
fn an_inverted_point_has_infinite_energy() {
    for law in LAWS {
        for first in [0.0, -0.5] {
            let k = at(&Mat3::from_diagonal(&Vector3::new(first, 1.0, 1.0)));
            assert_eq!(sample(law).energy_density(&k), f64::INFINITY, "{}", law.key);
        }
    }
}

/// The silicone of the frog.
const SILICONE: MooneyRivlin = MooneyRivlin { c1: 55e3, c2: 5e3, c3: 1.7e3, d1: 1e6 };

#[test]
fn simple_shear_has_its_closed_form() {
    let gamma = 0.7;
    let mut shear = Mat3::identity();
    shear[(0, 1)] = gamma;
    let exact = 2.0 * gamma * 60e3 + 4.0 * 1.7e3 * gamma * gamma * gamma;
    assert!((SILICONE.first_piola(&at(&shear))[(0, 1)] / exact - 1.0).abs() < 1e-13);
}

#[test]
fn confined_compression_is_that_of_the_reference() {
    // given to three decimals
    let confined = Mat3::from_diagonal(&Vector3::new(0.9, 1.0, 1.0));
    assert!((SILICONE.first_piola(&at(&confined))[(0, 0)] + 252_377.923).abs() < 1e-3);
}

#[test]
fn uniaxial_tension_is_that_of_the_reference() {
    // stretch, nominal stress [Pa], lateral stretch of an independent solution
    for (stretch, stress, lateral) in [
        (0.5, -495_049.673, 1.385_341_280),
        (0.7, -167_759.445, 1.183_589_185),
        (0.9, -39_855.247, 1.050_946_424),
        (1.1, 31_925.636, 0.956_257_000),
        (1.5, 121_926.431, 0.829_035_958),
        (2.0, 202_580.172, 0.731_388_696),
        (3.0, 333_542.625, 0.627_557_180),
    ] {
        let (found_stress, found_lateral) = response::free_uniaxial(&SILICONE, stretch);
        assert!((found_lateral - lateral).abs() < 1e-9, "{stretch}: {found_lateral}");
        assert!((found_stress - stress).abs() < 1e-3, "{stretch}: {found_stress}");
    }
}

#[test]
fn laws_that_contain_each_other_agree() {
    let yeoh = Yeoh { c: [55e3, 0.0, 0.0], bulk: 2e6 };
    let mooney = MooneyRivlin { c1: 55e3, c2: 0.0, c3: 0.0, d1: 1e6 };
    // Ogden with α = 2 and −2 is Mooney–Rivlin: Ī₂ = Σ λ̄⁻² at J̄ = 1
    let with_second = MooneyRivlin { c1: 55e3, c2: 5e3, c3: 0.0, d1: 1e6 };
    let ogden = Ogden { terms: vec![(110e3, 2.0), (-10e3, -2.0)], bulk: 2e6 };
    for f in deformations() {
        let k = at(&f);
        for (a, b) in [(&yeoh as &dyn Material, &mooney as &dyn Material), (&ogden, &with_second)] {
            let (energy, other) = (a.energy_density(&k), b.energy_density(&k));
            assert!((energy - other).abs() < 1e-12 * (1.0 + other.abs()), "{energy} {other}");
            let scale = b.tangent(&k).norm();
            assert!((a.first_piola(&k) - b.first_piola(&k)).norm() < 1e-13 * scale);
            assert!((a.tangent(&k) - b.tangent(&k)).norm() < 1e-12 * scale);
        }
    }
}

fn projected_in_lanes(tangent: &Mat9, f: &Mat3) -> Mat9 {
    let mut lanes = [[Lanes::splat(Scalar, 0.0); 9]; 9];
    for (i, row) in lanes.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate().take(i + 1) {
            *entry = Lanes::splat(Scalar, tangent[(i, j)]);
        }
    }
    let pivots = projection::smallest_pivots(&lanes);
    projection::project_isotropic(&mut lanes, &splat(Scalar, f), pivots);
    Mat9::from_fn(|i, j| lanes[i.max(j)][i.min(j)].to_array()[0])
}

/// By the principal axes, in lanes, too, and by all nine eigenvalues, at compressions that make tangents
/// indefinite, too.
#[test]
fn projected_tangents_by_principal_axes_are_the_nearest_positive_ones() {
    let crushed = rotation() * Mat3::from_diagonal(&Vector3::new(0.35, 0.4, 1.1));
    let mut indefinite = 0;
    for law in LAWS {
        let material = sample(law);
        for f in deformations().into_iter().chain([crushed]) {
            let tangent = material.tangent(&at(&f));
            let (fast, nearest) = (project_isotropic(&tangent, &f), project_positive(&tangent));
            let error = (fast - nearest).norm() / tangent.norm();
            assert!(error < 1e-10, "{}: {error:.1e} at {f}", law.key);
            if law.objective {
                let error = (projected_in_lanes(&tangent, &f) - nearest).norm() / tangent.norm();
                assert!(error < 1e-10, "{}: {error:.1e} at {f} in lanes", law.key);
            }
            indefinite += usize::from((nearest - tangent).norm() > 1e-3 * tangent.norm());
        }
    }
    assert!(indefinite > LAWS.len(), "{indefinite} tangents were indefinite");
}

#[test]
fn the_parts_of_a_law_add_up_to_it() {
    for law in LAWS {
        let material = sample(law);
        let Some(split) = material.split() else { continue };
        for f in deformations() {
            let k = at(&f);
            let [u, first, second] = split.volumetric(k.j_minus_1);
            let by_j = vec9(&k.cofactor);
            let scale = material.tangent(&k).norm();
            let energy = split.pointwise.energy_density(&k) + u;
            assert!((energy - material.energy_density(&k)).abs() < 1e-13 * scale, "{}", law.key);
            let stress = split.pointwise.first_piola(&k) + first * k.cofactor;
            assert!((stress - material.first_piola(&k)).norm() < 1e-13 * scale, "{}", law.key);
            let mut tangent = split.pointwise.tangent(&k) + second * by_j * by_j.transpose();
            crate::math::tensor::add_j_hessian(&k.f, first, &mut tangent);
            assert!((tangent - material.tangent(&k)).norm() < 1e-13 * scale, "{}", law.key);
        }
        assert_eq!(split.volumetric(-1.0)[0], f64::INFINITY);
        // nothing of the pointwise part grows with the bulk modulus
        let rest = split.pointwise.tangent(&Kinematics::new(&Mat3::zeros()));
        assert!(rest.norm() < 15.0 * (law.moduli)(law.sample).shear, "{}", law.key);
    }
}

/// What stays at every point follows the shear and the bulk modulus.
#[test]
fn each_part_of_a_law_has_its_derivatives() {
    let bar = Mat3::new(0.4, -0.1, 0.2, 0.8, 0.5, -0.3, -0.6, 0.1, 0.7);
    for law in LAWS {
        let count = law.sample.len();
        let Some(split) = sample(law).split() else { continue };
        for f in deformations() {
            let k = at(&f);
            let stress = |split: &Split| split.pointwise.first_piola(&k).dot(&bar);
            let pressure = |split: &Split| split.volumetric(k.j_minus_1)[1];
            let (mut by_stress, mut by_pressure) = (vec![0.0; count], vec![0.0; count]);
            split.pointwise.add_parameter_vjp(&k, &bar, &mut by_stress);
            split.add_volumetric_vjp(k.j_minus_1, 1.0, &mut by_pressure);
            let size = pressure(&split).abs() + (law.moduli)(law.sample).shear;
            let values: [&dyn Fn(&Split) -> f64; 2] = [&stress, &pressure];
            for (value, by) in values.into_iter().zip([by_stress, by_pressure]) {
                for (i, by) in by.iter().enumerate() {
                    let value = |law: Box<dyn Material>| value(&law.split().expect("as before"));
                    let (slope, by) = (relative_slope(law, i, value), by * law.sample[i]);
                    assert!((slope - by).abs() < 1e-7 * size, "{} {i}: {slope} {by}", law.key);
                }
            }
        }
    }
}
