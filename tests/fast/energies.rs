//! Energies against their own derivatives and against exact identities.

use mechanics::element::FunctionSpace;
use mechanics::energy::{
    Chamber, Elastic, Energy, FreeFlight, GasLaw, Hessian, IdealGas, Inertia, Isobaric, Iterate,
    Multiplier, PrescribedVolume, TimeStep, Wall,
};
use mechanics::material::MooneyRivlin;
use mechanics::math::random::Random;
use mechanics::math::sparse::{BlockMatrix, Pattern};
use mesh::Vec3;
use tests::{block, tag};

const MULTIPLIERS: [Multiplier; 1] = [Multiplier { pressure: 20e3, penalty: 5e10 }];

const SILICONE: MooneyRivlin = MooneyRivlin { c1: 55e3, c2: 5e3, c3: 1.7e3, d1: 1e6 };

/// A distorted 3×2×2 block of 10 mm cells, one cell of it empty and open to the
/// face x = 0.
fn body() -> mechanics::body::Body {
    let distort = |p: Vec3| {
        let bend = Vec3::new((40.0 * p.y).sin(), (60.0 * p.z).cos(), (50.0 * p.x).sin());
        p + 1e-3 * bend
    };
    let mesh = block([3, 3, 3], 0.01, |c| c == [0, 1, 1] || c == [1, 1, 1], distort);
    let inside = |p: Vec3| p.y > 0.0085 && p.y < 0.0225 && p.z > 0.0085 && p.z < 0.0225;
    tag(mesh, &[("seat", &|p| p.x < 0.0025), ("cavity", &|p| inside(p) && p.x < 0.025)])
}

struct Case {
    name: &'static str,
    space: FunctionSpace,
    rest: Vec<Vec3>,
    u: Vec<f64>,
    energy: Box<dyn Energy>,
    /// Zero where the wall's rim is fixed, so that the gas force has a potential.
    mask: Vec<f64>,
    step: TimeStep,
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for degree in [1, 2] {
        for name in [
            "elastic",
            "inertia",
            "isobaric",
            "sliding",
            "ideal",
            "volume",
            "plugged",
            "plugged ideal",
        ] {
            let body = body();
            let mut rest = body.mesh.vertices.clone();
            if name == "sliding" {
                body.facets("seat").unwrap().iter().flatten().for_each(|&v| rest[v].x = 0.0);
            }
            let space = FunctionSpace::new(degree, rest.len(), body.mesh.tets.clone());
            let mut mask = vec![1.0; 3 * space.node_count()];
            for facet in body.facets("seat").unwrap() {
                for node in space.facet_nodes(facet) {
                    // the mouth of the chamber slides in its plane x = 0
                    let fixed = match name {
                        "sliding" => 1,
                        "plugged" | "plugged ideal" => 0,
                        _ => 3,
                    };
                    mask[3 * node..3 * node + fixed].fill(0.0);
                }
            }
            let mut random = Random::new(7);
            let u = mask.iter().map(|m| m * 4e-4 * random.uniform()).collect();
            let energy: Box<dyn Energy> = match name {
                "inertia" => Box::new(Inertia::new(&space, 1100.0, 0..body.mesh.tets.len())),
                "elastic" => Box::new(Elastic::whole(Box::new(SILICONE))),
                name => {
                    let wall = Wall::new(&space, &body.facets("cavity").unwrap());
                    let wall = if name.starts_with("plugged") { wall.plugged() } else { wall };
                    let gas: Box<dyn GasLaw> = match name {
                        "isobaric" | "sliding" | "plugged" => {
                            Box::new(Isobaric { pressure: 20e3.into() })
                        }
                        "volume" => Box::new(PrescribedVolume::Factor(1.3.into())),
                        _ => {
                            let (fill, ambient) = (20e3.into(), 101.3e3);
                            Box::new(IdealGas { fill, ambient, exponent: 1.4 })
                        }
                    };
                    let multiplier = (name == "volume").then_some(0);
                    Box::new(Chamber { multiplier, ..Chamber::new(wall, gas) })
                }
            };
            let at = mask.iter().map(|m| m * 1e-3 * random.uniform()).collect();
            let free_flight = Some(FreeFlight { at, square: 1e-4 });
            let step = TimeStep { h: 0.01, free_flight, ..TimeStep::default() };
            cases.push(Case { name, space, rest, u, energy, mask, step });
        }
    }
    cases
}

impl Case {
    fn direction(&self, seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed);
        self.mask.iter().map(|m| m * random.uniform()).collect()
    }

    fn at<'a>(&'a self, u: &'a [f64], rest: &'a [Vec3]) -> Iterate<'a> {
        Iterate {
            space: &self.space,
            rest,
            u,
            time: 0.8,
            multipliers: &MULTIPLIERS,
            step: Some(&self.step),
            chord: None,
        }
    }

    fn gradient(&self, u: &[f64], rest: &[Vec3]) -> Vec<f64> {
        let mut g = vec![0.0; u.len()];
        self.energy.add_gradient(&self.at(u, rest), &mut g);
        g.iter().zip(&self.mask).map(|(g, m)| g * m).collect()
    }
}

fn moved(u: &[f64], step: f64, q: &[f64]) -> Vec<f64> {
    u.iter().zip(q).map(|(u, q)| u + step * q).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Central differences with a step of 1e-4 of the nodal displacement leave a
/// relative error of about 1e-8.
const STEP: f64 = 4e-8;
const TOLERANCE: f64 = 1e-6;

#[test]
fn gradients_are_the_derivatives_of_the_energies() {
    for case in cases() {
        let q = case.direction(11);
        let value = |s: f64| case.energy.value(&case.at(&moved(&case.u, s, &q), &case.rest));
        let difference = (value(STEP) - value(-STEP)) / (2.0 * STEP);
        let exact = dot(&case.gradient(&case.u, &case.rest), &q);
        assert!((difference / exact - 1.0).abs() < TOLERANCE, "{} {difference} {exact}", case.name);
    }
}

#[test]
fn hessians_are_the_derivatives_of_the_gradients() {
    for case in cases() {
        let q = case.direction(13);
        let gradient = |s: f64| case.gradient(&moved(&case.u, s, &q), &case.rest);
        let (plus, minus) = (gradient(STEP), gradient(-STEP));
        let pattern = Pattern::new(
            case.space.node_count(),
            case.space.element_nodes(),
            case.space.nodes_per_element(),
            &case.energy.couplings(&case.at(&case.u, &case.rest), 1.0),
        );
        let mut hessian = BlockMatrix::zeros(&pattern);
        case.energy.add_hessian(&case.at(&case.u, &case.rest), Hessian::Exact, &mut hessian);
        let mut product = hessian.multiply(&q);
        if let Some(dense) = case.energy.rank_one(&case.at(&case.u, &case.rest)) {
            let along = dense.scale * dot(&dense.vector, &q);
            product.iter_mut().zip(&dense.vector).for_each(|(p, v)| *p += along * v);
        }
        let (mut error, mut size) = (0.0, 0.0);
        for i in 0..q.len() {
            let exact = product[i] * case.mask[i];
            let difference = (plus[i] - minus[i]) / (2.0 * STEP);
            error += (exact - difference).powi(2);
            size += exact.powi(2);
        }
        assert!((error / size).sqrt() < TOLERANCE, "{} {error} {size}", case.name);
    }
}

#[test]
fn mixed_derivatives_are_those_of_the_gradient_in_the_rest_shape() {
    for case in cases() {
        let lambda = case.direction(17);
        let mut random = Random::new(19);
        let q: Vec<Vec3> = case.rest.iter().map(|_| random.vector()).collect();
        let value = |s: f64| {
            let rest: Vec<Vec3> = case.rest.iter().zip(&q).map(|(x, q)| x + s * q).collect();
            dot(&case.gradient(&case.u, &rest), &lambda)
        };
        let difference = (value(STEP) - value(-STEP)) / (2.0 * STEP);
        let mut mixed = vec![0.0; 3 * case.rest.len()];
        case.energy.add_mixed_vjp(&case.at(&case.u, &case.rest), &lambda, &mut mixed);
        let exact: f64 =
            q.iter().enumerate().map(|(v, q)| mechanics::element::at(&mixed, v).dot(q)).sum();
        assert!((difference / exact - 1.0).abs() < TOLERANCE, "{} {difference} {exact}", case.name);
    }
}

#[test]
fn a_homogeneous_deformation_has_no_inner_force() {
    // the patch test: residual at inner nodes beside the force on the boundary
    let distort = |p: Vec3| p + 1e-3 * Vec3::new((300.0 * p.y).sin(), (200.0 * p.z).cos(), 0.0);
    let mesh = block([3, 3, 3], 0.01, |_| false, distort);
    let gradient = random_tet_mesh();
    for degree in [1, 2] {
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
        let nodes = space.node_positions(&mesh.vertices);
        let u: Vec<f64> = nodes
            .iter()
            .flat_map(|x| gradient.map(|row| row[0] * x.x + row[1] * x.y + row[2] * x.z))
            .collect();
        let elastic = Elastic::whole(Box::new(SILICONE));
        let at = Iterate::new(&space, &mesh.vertices, &u, 1.0);
        let mut g = vec![0.0; u.len()];
        elastic.add_gradient(&at, &mut g);
        let mut on_boundary = vec![false; nodes.len()];
        for facet in mesh::topology::boundary(&mesh).facets {
            space.facet_nodes(facet).into_iter().for_each(|n| on_boundary[n] = true);
        }
        let largest = |inner: bool| {
            (0..nodes.len())
                .filter(|&n| on_boundary[n] != inner)
                .map(|n| mechanics::element::at(&g, n).norm())
                .fold(0.0, f64::max)
        };
        assert!(largest(true) < 1e-12 * largest(false), "{} {}", largest(true), largest(false));
    }
}

fn random_tet_mesh() -> [[f64; 3]; 3] {
    [[0.2, 0.1, -0.05], [0.0, -0.1, 0.15], [0.1, 0.05, 0.3]]
}

/// The gas in a plugged chamber pushes the body nowhere, whatever it looks like; without the plug it does.
#[test]
fn a_plugged_wall_feels_no_net_force_or_torque() {
    for case in cases().iter().filter(|case| case.name.starts_with("plugged")) {
        let mut g = vec![0.0; case.u.len()];
        case.energy.add_gradient(&case.at(&case.u, &case.rest), &mut g);
        let nodes = case.space.node_positions(&case.rest);
        let at = |of: &[f64], n: usize| mechanics::element::at(of, n);
        let force: Vec3 = (0..nodes.len()).map(|n| at(&g, n)).sum();
        let torque: Vec3 =
            (0..nodes.len()).map(|n| (nodes[n] + at(&case.u, n)).cross(&at(&g, n))).sum();
        let size: f64 = (0..nodes.len()).map(|n| at(&g, n).norm()).sum();
        assert!(force.norm() < 1e-13 * size, "{} {force}", case.name);
        assert!(torque.norm() < 1e-13 * size * 0.03, "{} {torque}", case.name);
    }
}

#[test]
fn a_closed_wall_feels_no_net_force_or_torque() {
    let mesh = block([3, 3, 3], 0.01, |c| c == [1, 1, 1], |p| p);
    let hollow = |p: Vec3| (p - Vec3::repeat(0.015)).amax() < 0.006;
    let body = tag(mesh, &[("cavity", &hollow)]);
    let space = FunctionSpace::new(2, body.mesh.vertices.len(), body.mesh.tets.clone());
    let wall = Wall::new(&space, &body.facets("cavity").unwrap());
    let nodes = space.node_positions(&body.mesh.vertices);
    assert!((wall.volume(&space, |n| nodes[n]) / 1e-6 - 1.0).abs() < 1e-13);
    let mut random = Random::new(3);
    let u: Vec<f64> = (0..3 * nodes.len()).map(|_| 1e-3 * random.uniform()).collect();
    let gas = Box::new(Isobaric { pressure: 1e3.into() });
    let pressure = Chamber::new(wall, gas);
    let mut g = vec![0.0; u.len()];
    let at = Iterate::new(&space, &body.mesh.vertices, &u, 1.0);
    pressure.add_gradient(&at, &mut g);
    let force = |n: usize| mechanics::element::at(&g, n);
    let position = |n: usize| nodes[n] + mechanics::element::at(&u, n);
    let sum: Vec3 = (0..nodes.len()).map(force).sum();
    let torque: Vec3 = (0..nodes.len()).map(|n| position(n).cross(&force(n))).sum();
    let scale: f64 = (0..nodes.len()).map(|n| force(n).norm()).sum();
    assert!(sum.norm() < 1e-14 * scale && torque.norm() < 1e-14 * 0.03 * scale);
}
