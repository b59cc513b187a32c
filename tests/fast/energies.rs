//! Every term of the energy against its own derivatives, for every degree, and against exact identities.

use mechanics::body::Body;
use mechanics::element::{FunctionSpace, at};
use mechanics::energy::{
    BodyForce, Chamber, Elastic, Energy, FreeFlight, GasLaw, Hessian, IdealGas, Inertia, Isobaric,
    Iterate, Multiplier, PrescribedVolume, TimeStep, Traction, Wall,
};
use mechanics::math::random::Random;
use mechanics::math::sparse::{BlockMatrix, Pattern};
use mechanics::math::taylor::taylor;
use mechanics::schedule::Field;
use mesh::Vec3;
use tests::equilibrium::SILICONE;
use tests::{block, tag};

const MULTIPLIERS: [Multiplier; 1] = [Multiplier { pressure: 20e3, penalty: 5e10 }];
const FORCE: [f64; 3] = [1e3, -2e3, 9.81e3];
const TRACTION: [f64; 3] = [300.0, -100.0, 200.0];

/// A distorted block of 10 mm cells, two of them empty and open to the face x = 0, which is flat.
fn body() -> Body {
    let distort = |p: Vec3| {
        let bend = Vec3::new((40.0 * p.y).sin(), (60.0 * p.z).cos(), (50.0 * p.x).sin());
        let moved = p + 1e-3 * bend;
        if p.x < 1e-9 { Vec3::new(0.0, moved.y, moved.z) } else { moved }
    };
    let mesh = block([3, 3, 3], 0.01, |c| c == [0, 1, 1] || c == [1, 1, 1], distort);
    let inside = |x: f64| x > 0.0085 && x < 0.0225;
    let cavity = |p: Vec3| p.x < 0.025 && inside(p.y) && inside(p.z);
    tag(mesh, &[("seat", &|p| p.x < 1e-9), ("cavity", &cavity), ("skin", &|_| true)])
}

/// A term, and how many components are fixed at the seat: a force of gas has a potential where its rim is held, or slides
/// in its plane.
type Term = (&'static str, Box<dyn Energy>, usize);

fn terms(body: &Body, space: &FunctionSpace) -> Vec<Term> {
    let wall = || Wall::new(space, &body.facets("cavity").unwrap());
    let chamber = |wall: Wall, gas: Box<dyn GasLaw>, multiplier| -> Box<dyn Energy> {
        Box::new(Chamber { multiplier, ..Chamber::new(wall, gas) })
    };
    let isobaric = || Box::new(Isobaric { pressure: 20e3.into() });
    let ideal = || Box::new(IdealGas { fill: 20e3.into(), ambient: 101.3e3, exponent: 1.4 });
    let skin = body.facets("skin").unwrap();
    let field = |texts: [&str; 3]| Field(texts.map(|text| text.parse().unwrap()));
    let (weight, wind) = (
        field(["1e3*x*y/(z + 0.1)", "5e4*sin(50*z)*t", "-9810*(1 + x^2)"]),
        field(["3e4*y", "-2e6*y*z*t", "exp(30*(y - z))"]),
    );
    vec![
        ("elastic", Box::new(Elastic::whole(Box::new(SILICONE))), 0),
        ("inertia", Box::new(Inertia::new(space, 1100.0, 0..body.mesh.tets.len())), 0),
        ("body force", Box::new(BodyForce::whole(FORCE.into())), 0),
        ("body force in space", Box::new(BodyForce::whole(weight)), 0),
        ("traction", Box::new(Traction::new(space, &skin, TRACTION.into())), 0),
        ("traction in space", Box::new(Traction::new(space, &skin, wind)), 0),
        ("isobaric", chamber(wall(), isobaric(), None), 3),
        ("sliding", chamber(wall(), isobaric(), None), 1),
        ("ideal", chamber(wall(), ideal(), None), 3),
        ("volume", chamber(wall(), Box::new(PrescribedVolume::Factor(1.3.into())), Some(0)), 3),
        ("plugged", chamber(wall().plugged(), isobaric(), None), 0),
        ("plugged ideal", chamber(wall().plugged(), ideal(), None), 0),
    ]
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The slope is 2, or the remainder is nothing but rounding because the term is linear along the direction.
fn assert_taylor(name: &str, directional: f64, value: impl Fn(f64) -> f64) {
    const EPSILON: f64 = 5e-6;
    let along = |e: f64| Ok::<f64, std::convert::Infallible>(value(e));
    let Ok(result) = taylor(EPSILON, 5, directional, along);
    let linear = result.remainder[0] <= 1e-10 * (EPSILON * directional).abs();
    assert!(linear || (result.slope - 2.0).abs() < 0.1, "{name}: {result:?}");
}

#[test]
fn every_term_has_its_derivatives_for_every_degree() {
    let body = body();
    let rest = &body.mesh.vertices;
    for degree in [1, 2, 3] {
        let space = FunctionSpace::new(degree, rest.len(), body.mesh.tets.clone());
        let len = 3 * space.node_count();
        let seat: Vec<usize> =
            body.facets("seat").unwrap().into_iter().flat_map(|f| space.facet_nodes(f)).collect();
        for (name, energy, fixed) in terms(&body, &space) {
            let name = format!("{name} P{degree}");
            let mut random = Random::new(41);
            let mut field = |size: f64| -> Vec<f64> {
                let mut field: Vec<f64> = random.numbers(len).iter().map(|r| size * r).collect();
                seat.iter().for_each(|node| field[3 * node..3 * node + fixed].fill(0.0));
                field
            };
            let (u, q, lambda) = (field(2e-4), field(1.0), field(1.0));
            let free_flight = Some(FreeFlight { at: field(1e-3), square: 1e-4 });
            let step = TimeStep { h: 0.01, free_flight, ..TimeStep::default() };
            let motion: Vec<Vec3> = rest.iter().map(|_| random.vector()).collect();
            let at = |rest: &[Vec3], u: &[f64], f: &mut dyn FnMut(&Iterate)| {
                let (space, step) = (&space, Some(&step));
                let multipliers = &MULTIPLIERS;
                f(&Iterate { space, rest, u, time: 0.8, multipliers, step });
            };
            let gradient = |rest: &[Vec3], u: &[f64]| {
                let mut g = vec![0.0; len];
                at(rest, u, &mut |at| energy.add_gradient(at, &mut g));
                g
            };
            let moved = |e: f64| -> Vec<f64> { u.iter().zip(&q).map(|(u, q)| u + e * q).collect() };
            assert_taylor(&name, dot(&gradient(rest, &u), &q), |e| {
                let mut value = 0.0;
                at(rest, &moved(e), &mut |at| value = energy.value(at));
                value
            });
            let mut second = 0.0;
            at(rest, &u, &mut |at| {
                let (nodes, per_element) = (space.node_count(), space.nodes_per_element());
                let couplings = energy.couplings(at, 1.0);
                let pattern = Pattern::new(nodes, space.element_nodes(), per_element, &couplings);
                let mut hessian = BlockMatrix::zeros(&pattern);
                energy.add_hessian(at, Hessian::Exact, &mut hessian);
                second = dot(&hessian.multiply(&q), &lambda);
                if let Some(dense) = energy.rank_one(at) {
                    second += dense.scale * dot(&dense.vector, &q) * dot(&dense.vector, &lambda);
                }
            });
            assert_taylor(&name, second, |e| dot(&gradient(rest, &moved(e)), &lambda));
            let mut mixed = vec![0.0; 3 * rest.len()];
            at(rest, &u, &mut |at| energy.add_mixed_vjp(at, &lambda, &mut mixed));
            let along = |(v, m): (usize, &Vec3)| m.dot(&mechanics::element::at(&mixed, v));
            let by_rest: f64 = motion.iter().enumerate().map(along).sum();
            assert_taylor(&name, by_rest, |e| {
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
    let volume = mesh::measure::volume(&body.mesh);
    let area = |f: &[usize; 3]| {
        let [a, b, c] = f.map(|v| rest[v]);
        mesh::measure::triangle_area(a, b, c)
    };
    let area: f64 = body.facets("skin").unwrap().iter().map(area).sum();
    for degree in [1, 2, 3] {
        let space = FunctionSpace::new(degree, rest.len(), body.mesh.tets.clone());
        let u = vec![0.0; 3 * space.node_count()];
        for (name, energy, _) in terms(&body, &space) {
            let expected = match name {
                "body force" => volume * Vec3::from(FORCE),
                "traction" => area * Vec3::from(TRACTION),
                _ => continue,
            };
            let mut g = vec![0.0; u.len()];
            energy.add_gradient(&Iterate::new(&space, rest, &u, 1.0), &mut g);
            let found = -(0..space.node_count()).map(|i| at(&g, i)).sum::<Vec3>();
            assert!((found - expected).norm() < 1e-12 * expected.norm(), "{name} P{degree}");
        }
    }
}

/// The gas in a plugged chamber pushes the body nowhere, whatever it looks like.
#[test]
fn a_plugged_wall_feels_no_net_force_or_torque() {
    let body = body();
    let rest = &body.mesh.vertices;
    let space = FunctionSpace::new(2, rest.len(), body.mesh.tets.clone());
    let nodes = space.node_positions(rest);
    let u: Vec<f64> = Random::new(3).numbers(3 * nodes.len()).iter().map(|r| 1e-3 * r).collect();
    for (name, energy, _) in terms(&body, &space).iter().filter(|t| t.0.starts_with("plugged")) {
        let mut g = vec![0.0; u.len()];
        energy.add_gradient(&Iterate::new(&space, rest, &u, 1.0), &mut g);
        let all = || (0..nodes.len()).map(|n| (nodes[n] + at(&u, n), at(&g, n)));
        let force: Vec3 = all().map(|(_, f)| f).sum();
        let torque: Vec3 = all().map(|(x, f)| x.cross(&f)).sum();
        let size: f64 = all().map(|(_, f)| f.norm()).sum();
        assert!(force.norm() < 1e-13 * size, "{name} {force}");
        assert!(torque.norm() < 1e-13 * size * 0.03, "{name} {torque}");
    }
}
