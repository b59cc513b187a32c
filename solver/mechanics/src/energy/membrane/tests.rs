//! Sheets on the boundary of a block and inside it, of all degrees and in all states.

use mesh::{TetMesh, topology};

use super::*;
use crate::energy::Axis;
use crate::material::sheet::LAWS;
use crate::material::sheet::TensionField;
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::math::sparse::Pattern;
use crate::testing::{check_gradient, cube, flat, points as from_flat};

/// A sheet with a state near a homogeneous one.
struct Case {
    name: String,
    space: FunctionSpace,
    rest: Vec<Vec3>,
    u: Vec<f64>,
    membrane: Membrane,
}

/// The warp of sheets with axes: around an axis beside the body, askew to the sheets.
const HELICAL: Direction = Direction::Helical(
    Axis { point: Vec3::new(0.3, -1.5, 0.2), along: Vec3::new(0.6, 0.0, 0.8) },
    0.6,
);

/// Step of Taylor tests: no point comes to another state [m].
const SIZE: f64 = 5e-5;

/// What is the same for all points of the sheets: λ₁ and λ₂ in the plane.
const STRETCHES: [(&str, [f64; 2]); 4] = [
    ("taut", [1.4, 1.2]),
    ("wrinkled", [1.3, 0.75]),
    ("compressed", [0.85, 0.9]),
    ("nearly at rest", [1.02, 1.01]),
];

/// The top of a block of two layers and the plane between them, which is bent.
fn facets(mesh: &TetMesh) -> Vec<[usize; 3]> {
    let mut all: Vec<[usize; 3]> = Vec::new();
    for tet in &mesh.tets {
        for corners in topology::TET_FACETS {
            let facet = mesh::facet_key(corners.map(|c| tet[c]));
            let is_at = |z: f64| facet.iter().all(|&v| (mesh.vertices[v].z - z).abs() < 1e-9);
            if is_at(1.0) || is_at(0.5) {
                all.push(facet);
            }
        }
    }
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), 16);
    all
}

impl Case {
    fn new(degree: usize, stretches: [f64; 2], sheet: Box<dyn Sheet>, name: String) -> Self {
        let mut mesh = cube(2, 0.0);
        let facets = facets(&mesh);
        for v in &mut mesh.vertices {
            *v += 0.05 * Vec3::new((3.0 * v.y).sin(), (2.0 * v.z).cos(), (2.0 * v.x * v.y).sin());
        }
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
        let turn = nalgebra::Rotation3::from_euler_angles(0.5, -0.4, 1.2);
        let mut random = Random::new(31);
        let place = |x: Vec3| {
            let [a, b] = stretches;
            turn * Vec3::new(a * x.x, b * x.y, 0.9 * x.z) - x
        };
        let u = space.node_positions(&mesh.vertices).into_iter();
        // small enough for all points to be in one state
        let u = u.flat_map(|x| <[f64; 3]>::from(place(x) + 1e-4 * random.vector())).collect();
        let has_axes = sheet.has_axes();
        let membrane = Membrane::new(&space, &facets, 2e-3, sheet);
        let membrane = if has_axes { membrane.along(HELICAL) } else { membrane };
        Self { name, space, rest: mesh.vertices, u, membrane }
    }

    fn at<'a>(&'a self, rest: &'a [Vec3], u: &'a [f64]) -> Iterate<'a> {
        Iterate::new(&self.space, rest, u, 1.0)
    }

    fn here(&self) -> Iterate<'_> {
        self.at(&self.rest, &self.u)
    }

    fn gradient(&self, rest: &[Vec3], u: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; u.len()];
        self.membrane.add_gradient(&self.at(rest, u), &mut gradient);
        gradient
    }

    fn times_hessian(&self, kind: Hessian, q: &[f64]) -> Vec<f64> {
        let space = &self.space;
        let (nodes, each) = (space.element_nodes(), space.nodes_per_element());
        let pattern = Pattern::new(space.node_count(), nodes, each, &[]);
        let mut matrix = BlockMatrix::zeros(&pattern);
        self.membrane.add_hessian(&self.here(), kind, &mut matrix);
        matrix.multiply(q)
    }

    fn share(&self, state: State) -> f64 {
        let all = self.membrane.summary(&self.here());
        [all.taut, all.wrinkled, all.slack][state as usize]
    }
}

/// All laws with and without compression, in the states in which they resist.
fn cases(degrees: &[usize]) -> Vec<Case> {
    let mut cases = Vec::new();
    for &degree in degrees {
        for (state, stretches) in STRETCHES {
            for row in LAWS {
                let name = format!("{} {state} P{degree}", row.key);
                let law = || (row.build)(row.sample);
                cases.push(Case::new(degree, stretches, law(), name.clone()));
                if state != "compressed" {
                    let relaxed = Box::new(TensionField(law()));
                    cases.push(Case::new(degree, stretches, relaxed, name + " in tension"));
                }
            }
        }
    }
    cases
}

#[test]
fn every_case_is_in_one_state() {
    for case in cases(&[1, 2, 3]) {
        let state = match case.name.split(' ').nth(1) {
            Some("wrinkled") => State::Wrinkled,
            Some("compressed") => State::Slack,
            _ => State::Taut,
        };
        assert!((case.share(state) - 1.0).abs() < 1e-12, "{}", case.name);
    }
}

#[test]
fn gradient_and_hessian_are_derivatives_of_the_energy() {
    for case in cases(&[1, 2, 3]) {
        let gradient = case.gradient(&case.rest, &case.u);
        let value = |u: &[f64]| case.membrane.value(&case.at(&case.rest, u));
        check_gradient(&case.u, &gradient, SIZE, value);
        let lambda = Random::new(5).numbers(case.u.len());
        let product = case.times_hessian(Hessian::Exact, &lambda);
        let value = |u: &[f64]| dot(&case.gradient(&case.rest, u), &lambda);
        check_gradient(&case.u, &product, SIZE, value);
    }
}

#[test]
fn the_mixed_derivative_is_that_of_the_gradient_by_the_rest_shape() {
    for case in cases(&[1, 2, 3]) {
        let lambda = Random::new(6).numbers(case.u.len());
        let mut mixed = vec![0.0; 3 * case.rest.len()];
        case.membrane.add_mixed_vjp(&case.here(), &lambda, &mut mixed);
        let value = |x: &[f64]| dot(&case.gradient(&from_flat(x), &case.u), &lambda);
        check_gradient(&flat(&case.rest), &mixed, SIZE, value);
    }
}

#[test]
fn parameter_derivatives_are_those_of_the_gradient() {
    for row in LAWS {
        for (tension, stretches) in [(false, [0.85, 0.9]), (true, [1.3, 0.75]), (true, [1.4, 1.2])]
        {
            let with = |numbers: &[f64]| {
                let law = (row.build)(&numbers[1..=row.sample.len()]);
                let law: Box<dyn Sheet> = if tension { Box::new(TensionField(law)) } else { law };
                let mut case = Case::new(2, stretches, law, row.key.to_owned());
                case.membrane.thickness = numbers[0];
                if let (Some(Direction::Helical(axis, _)), Some(angle)) =
                    (case.membrane.direction, numbers.get(1 + row.sample.len()))
                {
                    case.membrane.direction = Some(Direction::Helical(axis, *angle));
                }
                case
            };
            let mut numbers: Vec<f64> = [2e-3].iter().chain(row.sample).copied().collect();
            numbers.extend((row.build)(row.sample).has_axes().then_some(0.6));
            let case = with(&numbers);
            let lambda = Random::new(7).numbers(case.u.len());
            let by = case.membrane.parameter_vjp(&case.here(), &lambda);
            assert_eq!(by.len(), numbers.len());
            for (i, by) in by.iter().enumerate() {
                let value = |e: f64| {
                    let mut numbers = numbers.clone();
                    numbers[i] *= 1.0 + e;
                    let case = with(&numbers);
                    dot(&case.gradient(&case.rest, &case.u), &lambda)
                };
                // differences by the angle have the third derivatives of cos 4α
                let h = if i > row.sample.len() { 1e-5 } else { 1e-4 };
                let slope = (value(h) - value(-h)) / (2.0 * h * numbers[i]);
                let scale = value(0.0).abs() / numbers[i];
                assert!((slope - by).abs() < 1e-7 * (by.abs() + scale), "{} {i}", row.key);
            }
        }
    }
}

#[test]
fn a_slack_sheet_does_nothing() {
    for degree in [1, 2, 3] {
        for row in LAWS {
            let law = Box::new(TensionField((row.build)(row.sample)));
            let case = Case::new(degree, [0.85, 0.9], law, row.key.to_owned());
            assert!((case.share(State::Slack) - 1.0).abs() < 1e-12);
            assert_eq!(case.membrane.value(&case.here()), 0.0);
            let q = Random::new(8).numbers(case.u.len());
            let mut mixed = vec![0.0; 3 * case.rest.len()];
            case.membrane.add_mixed_vjp(&case.here(), &q, &mut mixed);
            let all = [
                case.gradient(&case.rest, &case.u),
                case.times_hessian(Hessian::Exact, &q),
                mixed,
                case.membrane.parameter_vjp(&case.here(), &q),
            ];
            assert!(all.iter().flatten().all(|x| *x == 0.0), "{}", row.key);
        }
    }
}

#[test]
fn the_projected_hessian_is_positive_and_that_of_a_sheet_in_tension_exact() {
    let mut random = Random::new(9);
    for case in cases(&[1, 2]) {
        let convex = case.name.ends_with("tension") || case.name.contains("taut");
        let q = random.numbers(case.u.len());
        let [exact, projected] =
            [Hessian::Exact, Hessian::Projected].map(|kind| case.times_hessian(kind, &q));
        assert!(dot(&q, &projected) >= 0.0, "{}", case.name);
        let change: Vec<f64> = exact.iter().zip(&projected).map(|(e, p)| e - p).collect();
        let relative = (dot(&change, &change) / dot(&exact, &exact)).sqrt();
        assert_eq!(
            relative < 1e-12,
            convex || case.name.contains("nearly"),
            "{} {relative:e}",
            case.name
        );
    }
}

/// Energy and forces of a flat sheet under a homogeneous deformation and any rotation, of any
/// degree and mesh.
#[test]
fn a_homogeneous_deformation_has_the_energy_of_the_formula() {
    for row in LAWS {
        for degree in [1, 2, 3] {
            let mut mesh = cube(2, 0.0);
            let facets = facets(&mesh);
            // facets of any shape in their planes
            let inside = |x: f64| x * (1.0 - x);
            for v in &mut mesh.vertices {
                *v += Vec3::new(0.5, -0.3, 0.0) * inside(v.x) * inside(v.y) * 4.0 * 0.5;
            }
            let law = (row.build)(row.sample);
            let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
            let turn = nalgebra::Rotation3::from_euler_angles(0.5, -0.4, 1.2);
            let to = turn * Mat3::from_diagonal(&Vec3::new(1.3, 1.1, 0.7));
            let u: Vec<f64> = space
                .node_positions(&mesh.vertices)
                .into_iter()
                .flat_map(|x| <[f64; 3]>::from(to * x - x))
                .collect();
            let membrane = Membrane::new(&space, &facets, 2e-3, law);
            // 0.5 rad from x in the plane of the sheets, and not in it
            let (sin, cos) = 0.5_f64.sin_cos();
            let membrane = membrane.along(Direction::Constant(Vec3::new(cos, sin, 0.4)));
            let at = Iterate::new(&space, &mesh.vertices, &u, 1.0);
            let [first, second] = [1.3, 1.1].map(|stretch| 0.5 * (stretch * stretch - 1.0));
            let e = Strain::new(
                first * cos * cos + second * sin * sin,
                first * sin * sin + second * cos * cos,
                2.0 * (second - first) * sin * cos,
            );
            // two squares of 1 m²
            let exact = 2.0 * 2e-3 * membrane.sheet.energy_density(&e);
            assert!((membrane.value(&at) / exact - 1.0).abs() < 1e-12, "{}", row.key);
            let summary = membrane.summary(&at);
            assert!(
                (summary.area - 2.0).abs() < 1e-12 && (summary.energy / exact - 1.0).abs() < 1e-12
            );
            assert!((summary.stretch[0] - 1.1).abs() < 1e-12);
            assert!((summary.stretch[1] - 1.3).abs() < 1e-12);
            let s = membrane.sheet.stress(&e);
            let tension = 1e-3 * (s[0] + s[1] + (s[0] - s[1]).hypot(2.0 * s[2]));
            assert!((summary.tension / tension - 1.0).abs() < 1e-12);
        }
    }
}
