//! Body force and traction against their own derivatives, all energies with
//! cubic elements, and resultants.

use mechanics::body::Body;
use mechanics::element::{FunctionSpace, at};
use mechanics::energy::{
    BodyForce, Chamber, Elastic, Energy, Hessian, Isobaric, Iterate, Traction, Wall,
};
use mechanics::math::random::Random;
use mechanics::math::sparse::{BlockMatrix, Pattern};
use mechanics::math::taylor::taylor;
use mechanics::schedule::Field;
use mesh::Vec3;
use tests::equilibrium::SILICONE;
use tests::{block, tag};

const FORCE: [f64; 3] = [1e3, -2e3, 9.81e3];
const TRACTION: [f64; 3] = [300.0, -100.0, 200.0];

/// A distorted block of 10 mm cells with a closed hole.
fn body() -> Body {
    let distort =
        |p: Vec3| p + 1e-3 * Vec3::new((40.0 * p.y).sin(), (60.0 * p.z).cos(), (50.0 * p.x).sin());
    let mesh = block([3, 3, 3], 0.01, |c| c == [1, 1, 1], distort);
    let hole = |p: Vec3| (p - Vec3::repeat(0.0155)).amax() < 0.0075;
    tag(mesh, &[("hole", &hole), ("side", &|p| p.x < 0.0025)])
}

fn energies(body: &Body, space: &FunctionSpace) -> Vec<Box<dyn Energy>> {
    let wall = Wall::new(space, &body.facets("hole").unwrap());
    vec![
        Box::new(Elastic::whole(Box::new(SILICONE))),
        Box::new(Chamber::new(wall, Box::new(Isobaric { pressure: 20e3.into() }))),
        Box::new(BodyForce::whole(FORCE.into())),
        Box::new(BodyForce::whole(field(["1e3*x*y/z", "5e4*sin(50*z)*t", "-9810*(1 + x^2)"]))),
        Box::new(Traction::new(space, &body.facets("side").unwrap(), TRACTION.into())),
        Box::new(Traction::new(
            space,
            &body.facets("side").unwrap(),
            field(["3e4*y", "-2e6*y*z*t", "exp(30*(y - z))"]),
        )),
    ]
}

fn field(components: [&str; 3]) -> Field {
    Field(components.map(|text| text.parse().unwrap()))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The slope is 2, or the remainder is nothing but rounding because the term is
/// linear along the direction.
fn assert_taylor(name: &str, epsilon: f64, directional: f64, value: impl Fn(f64) -> f64) {
    let along = |e: f64| Ok::<f64, std::convert::Infallible>(value(e));
    let Ok(result) = taylor(epsilon, 5, directional, along);
    let linear = result.remainder[0] <= 1e-10 * (epsilon * directional).abs();
    assert!(linear || (result.slope - 2.0).abs() < 0.1, "{name}: {result:?}");
}

#[test]
fn every_term_has_its_derivatives_for_every_degree() {
    let body = body();
    let rest = &body.mesh.vertices;
    for degree in [1, 2, 3] {
        let space = FunctionSpace::new(degree, rest.len(), body.mesh.tets.clone());
        let mut random = Random::new(41);
        let len = 3 * space.node_count();
        let u: Vec<f64> = random.numbers(len).iter().map(|r| 2e-4 * r).collect();
        let (q, lambda) = (random.numbers(len), random.numbers(len));
        let motion: Vec<Vec3> = rest.iter().map(|_| random.vector()).collect();
        let moved = |e: f64| -> Vec<f64> { u.iter().zip(&q).map(|(u, q)| u + e * q).collect() };
        for energy in energies(&body, &space) {
            let name = format!("{} P{degree}", energy.name());
            let iterate = |rest: &[Vec3], u: &[f64], f: &mut dyn FnMut(&Iterate)| {
                f(&Iterate::new(&space, rest, u, 0.8));
            };
            let value = |u: &[f64]| {
                let mut value = 0.0;
                iterate(rest, u, &mut |at| value = energy.value(at));
                value
            };
            let gradient = |rest: &[Vec3], u: &[f64]| {
                let mut g = vec![0.0; len];
                iterate(rest, u, &mut |at| energy.add_gradient(at, &mut g));
                g
            };
            assert_taylor(&name, 2e-5, dot(&gradient(rest, &u), &q), |e| value(&moved(e)));
            let pattern = Pattern::new(
                space.node_count(),
                space.element_nodes(),
                space.nodes_per_element(),
                &[],
            );
            let mut hessian = BlockMatrix::zeros(&pattern);
            iterate(rest, &u, &mut |at| energy.add_hessian(at, Hessian::Exact, &mut hessian));
            let second = dot(&hessian.multiply(&q), &lambda);
            assert_taylor(&name, 2e-5, second, |e| dot(&gradient(rest, &moved(e)), &lambda));
            let mut mixed = vec![0.0; 3 * rest.len()];
            iterate(rest, &u, &mut |at| energy.add_mixed_vjp(at, &lambda, &mut mixed));
            let by_rest: f64 = motion.iter().enumerate().map(|(v, m)| m.dot(&at(&mixed, v))).sum();
            assert_taylor(&name, 2e-5, by_rest, |e| {
                let shape: Vec<Vec3> = rest.iter().zip(&motion).map(|(x, m)| x + e * m).collect();
                dot(&gradient(&shape, &u), &lambda)
            });
        }
    }
}

#[test]
fn resultants_are_force_times_volume_and_traction_times_area() {
    let body = body();
    let rest = &body.mesh.vertices;
    let volume: f64 = body
        .mesh
        .tets
        .iter()
        .map(|t| {
            let [a, b, c, d] = t.map(|v| rest[v]);
            mesh::measure::tet_volume(a, b, c, d)
        })
        .sum();
    let side = body.facets("side").unwrap();
    let area: f64 =
        side.iter().map(|f| mesh::measure::triangle_area(rest[f[0]], rest[f[1]], rest[f[2]])).sum();
    for degree in [1, 2, 3] {
        let space = FunctionSpace::new(degree, rest.len(), body.mesh.tets.clone());
        let u = vec![0.0; 3 * space.node_count()];
        let resultant = |energy: &dyn Energy| -> Vec3 {
            let mut g = vec![0.0; u.len()];
            energy.add_gradient(&Iterate::new(&space, rest, &u, 1.0), &mut g);
            -(0..space.node_count()).map(|i| at(&g, i)).sum::<Vec3>()
        };
        let weight = resultant(&BodyForce::whole(FORCE.into()));
        assert!((weight - volume * Vec3::from(FORCE)).norm() < 1e-12 * weight.norm());
        let pull = resultant(&Traction::new(&space, &side, TRACTION.into()));
        assert!((pull - area * Vec3::from(TRACTION)).norm() < 1e-12 * pull.norm());
    }
}
