//! Mean dilatation: derivatives, and what is known of it.

use mesh::TetMesh;

use super::*;
use std::sync::Arc;

use crate::energy::tests::{Case, Sample};
use crate::energy::{Energy, Hessian};
use crate::material::{Kinematics, LAWS, Lame, NeoHookean};
use crate::math::linear::{dot, norm};
use crate::math::random::Random;
use crate::testing::cube;

/// A cube of a degree with random displacements.
fn case(degree: usize, size: f64) -> Case {
    let (mut mesh, mut random) = (cube(1, 0.0), Random::new(31));
    mesh.vertices.iter_mut().for_each(|x| *x += 0.05 * random.vector());
    Case::new(mesh, degree, &mut random, size)
}

/// The laws with a term of the change of volume alone: their elements as a whole, with their parameters.
fn laws() -> impl Iterator<Item = (&'static str, Elastic, &'static [f64])> {
    LAWS.iter().filter_map(|law| {
        let mean = Elastic::whole((law.build)(law.sample)).with_mean_dilatation()?;
        Some((law.key, mean, law.sample))
    })
}

/// All laws, as a whole and with mean dilatation.
pub fn samples() -> Vec<Sample> {
    let mut samples = Vec::new();
    for degree in [2, 3] {
        let case = Arc::new(case(degree, 0.03));
        for law in LAWS {
            for mean in [false, true] {
                if mean && laws().all(|(key, ..)| key != law.key) {
                    continue;
                }
                let term = move |numbers: &[f64]| -> Box<dyn Energy> {
                    let whole = Elastic::whole((law.build)(numbers));
                    let own = if mean { whole.with_mean_dilatation() } else { Some(whole) };
                    Box::new(own.expect("a term of the volume"))
                };
                samples.push(Sample {
                    name: format!("{} P{degree}, mean dilatation: {mean}", law.key),
                    case: Arc::clone(&case),
                    sizes: [1e-3; 2],
                    numbers: law.sample.to_vec(),
                    term: Box::new(term),
                });
            }
        }
    }
    samples
}

#[test]
fn laws_without_a_term_of_the_volume_alone_have_no_mean_dilatation() {
    let with: Vec<&str> = laws().map(|(key, ..)| key).collect();
    let expected = [
        "mooney-rivlin",
        "mooney-rivlin-quadratic",
        "neo-hookean",
        "yeoh",
        "gent",
        "arruda-boyce",
        "ogden",
    ];
    assert_eq!(with, expected);
}

/// In degree 3 a dilatation that is linear is its own projection, and U is integrated as at the points where U is quadratic in
/// it: both elements have the same energy; with one mean alone they have not.
#[test]
fn a_linear_dilatation_is_kept_in_degree_3() {
    // J = 1 + ε x: only u_x = ε x²/2 varies
    let case = case(3, 0.0);
    let nodes = case.space.node_positions(&case.rest);
    let u: Vec<f64> = nodes.iter().flat_map(|x| [0.05 * x.x * x.x, 0.0, 0.0]).collect();
    let at = case.at(&u, &case.rest);
    // its term of the volume alone is d1 (J − 1)²
    let sample = [0.0, 0.0, 0.0, 1e6];
    let law = LAWS.iter().find(|law| law.key == "mooney-rivlin-quadratic");
    let standard = Elastic::whole((law.expect("in the table").build)(&sample));
    let mean = standard.clone().with_mean_dilatation().expect("it has one");
    let (value, other) = (mean.value(&at), standard.value(&at));
    assert!(value > 0.0 && (value / other - 1.0).abs() < 1e-12, "{value} {other}");
}

/// J is the same everywhere, and so is all that is made with it.
#[test]
fn a_homogeneous_deformation_is_that_of_the_standard_element() {
    let gradient = Mat3::new(0.2, 0.1, -0.05, 0.0, -0.1, 0.15, 0.1, 0.05, 0.3);
    for degree in [2, 3] {
        let case = case(degree, 0.0);
        let nodes = case.space.node_positions(&case.rest);
        let u: Vec<f64> = nodes.iter().flat_map(|x| (gradient * x).data.0[0]).collect();
        for (key, mean, _) in laws() {
            let standard = Elastic { mean: None, ..mean.clone() };
            let at = case.at(&u, &case.rest);
            let (value, other) = (mean.value(&at), standard.value(&at));
            assert!((value / other - 1.0).abs() < 1e-12, "{key}: {value} {other}");
            let (force, other) =
                (case.gradient(&mean, &u, &case.rest), case.gradient(&standard, &u, &case.rest));
            let difference: Vec<f64> = force.iter().zip(&other).map(|(a, b)| a - b).collect();
            assert!(dot(&difference, &difference) < 1e-20 * dot(&other, &other), "{key}");
        }
    }
}

/// Both elements are the same for degree 1, to the last bit.
#[test]
fn linear_elements_do_not_change() {
    let case = case(1, 0.03);
    for (key, mean, _) in laws() {
        let standard = Elastic { mean: None, ..mean.clone() };
        let force = |elastic: &Elastic| case.gradient(elastic, &case.u, &case.rest);
        assert_eq!(force(&mean), force(&standard), "{key}");
    }
}

/// A block that is compressed along two directions folds at its free top from a stretch of 0.666 on (Biot 1963). With all
/// of the bulk modulus at the mean it did at 0.745 in degree 2, and at 0.733 in degree 3, whatever the mesh.
#[test]
fn a_compressed_surface_folds_no_earlier_than_it_should() {
    let law = NeoHookean(Lame::new(3e5, 0.49975));
    for degree in [2, 3] {
        let mut case = case(degree, 0.0);
        let TetMesh { vertices, tets } = cube(2, 0.0);
        case.space = FunctionSpace::new(degree, vertices.len(), tets);
        case.rest = vertices;
        let nodes = case.space.node_positions(&case.rest);
        let held = |x: &Vec3| [x.x == 0.0 || x.x == 1.0, x.y == 0.0 || x.y == 1.0, x.z == 0.0];
        let held: Vec<bool> = nodes.iter().flat_map(held).collect();
        let free: Vec<usize> = (0..held.len()).filter(|&dof| !held[dof]).collect();
        let mean = Elastic::whole(Box::new(law)).with_mean_dilatation().expect("a split law");
        let mut smallest_at = |stretch: f64| {
            // as high as it is without a force on its top
            let (mut low, mut high) = (1.0, 4.0);
            for _ in 0..60 {
                let up = 0.5 * (low + high);
                let strain = Vec3::new(stretch, stretch, up) - Vec3::repeat(1.0);
                let stress = law.first_piola(&Kinematics::new(&Mat3::from_diagonal(&strain)));
                if stress[(2, 2)] < 0.0 { low = up } else { high = up }
            }
            let moved =
                |x: &Vec3| [(stretch - 1.0) * x.x, (stretch - 1.0) * x.y, (low - 1.0) * x.z];
            case.u = nodes.iter().flat_map(moved).collect();
            case.smallest_of(&mean, Hessian::Exact, &free)
        };
        let [before, after] = [0.7, 0.62].map(&mut smallest_at);
        assert!(before > 0.0 && after < 0.0, "degree {degree}: {before:.1e} {after:.1e}");
    }
}

#[test]
fn projected_hessians_are_positive_semidefinite() {
    // so strained that the exact Hessian is not
    for (degree, size) in [(2, 0.08), (3, 0.03)] {
        let case = case(degree, size);
        let mut indefinite = 0;
        for (key, elastic, _) in laws() {
            indefinite += usize::from(case.smallest(&elastic, Hessian::Exact) < -1e-6);
            let projected = case.smallest(&elastic, Hessian::Projected);
            assert!(projected > -1e-12, "{key}: {projected}");
        }
        assert!(indefinite > 2, "{indefinite} exact Hessians were indefinite");
    }
}

/// A Hessian with foreseen pressures is off by the square of the step, and exact where no step was made.
#[test]
fn pressures_are_foreseen_to_first_order() {
    for degree in [1, 2, 3] {
        let case = case(degree, 0.03);
        let step = Random::new(9).numbers(case.u.len());
        let all = LAWS.iter().map(|law| (law.key, Elastic::whole((law.build)(law.sample))));
        for (key, elastic) in all.chain(laws().map(|(key, mean, _)| (key, mean))) {
            let times = |before: Option<&[f64]>| {
                let at = Iterate { before, ..case.here() };
                case.products(&at, &elastic, Hessian::Exact, [&step[..]].into_iter()).remove(0)
            };
            let exact = times(None);
            let off = |size: f64| {
                let moved = case.u.iter().zip(&step).map(|(u, d)| u - size * d);
                let foreseen = times(Some(&moved.collect::<Vec<f64>>()));
                let error = foreseen.iter().zip(&exact).map(|(a, b)| a - b);
                norm(&error.collect::<Vec<f64>>()) / norm(&exact)
            };
            let [none, small, large] = [0.0, 1e-4, 2e-4].map(off);
            assert!(none < 1e-14, "{key} {degree}: {none:.1e}");
            let ratio = large / small;
            let unforeseen = small == 0.0;
            assert!(unforeseen || (ratio - 4.0).abs() < 0.02, "{key} {degree}: {ratio}");
            let foresees = elastic.material.decoupled().is_some() || key == "neo-hookean";
            assert!(unforeseen != foresees || elastic.mean.is_some(), "{key} {degree}");
        }
    }
}

/// Fields of results: of a law in an element, the forces of the energy.
#[test]
fn stresses_at_points_are_those_of_the_forces() {
    [2, 3].map(|degree| case(degree, 0.02)).iter().for_each(check_stresses);
}

fn check_stresses(case: &Case) {
    let at = case.at(&case.u, &case.rest);
    for (key, elastic, _) in laws() {
        let (mut energy, mut power) = (0.0, 0.0);
        for e in elastic.elements(&case.space) {
            let law = elastic.law_in(&at, e);
            for point in points(&at, e, false).1 {
                energy += point.weight * law.energy_density(&point.k);
                power += point.weight * law.first_piola(point.place, &point.k).dot(&point.k.grad_u);
            }
        }
        assert!((energy / elastic.value(&at) - 1.0).abs() < 1e-12, "{key}");
        let force = case.gradient(&elastic, &case.u, &case.rest);
        assert!((power / dot(&force, &case.u) - 1.0).abs() < 1e-12, "{key}");
    }
}
