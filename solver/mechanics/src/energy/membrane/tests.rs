//! Sheets on the boundary of a block and inside it, of all degrees and in all states.

use mesh::TetMesh;

use super::*;
use crate::energy::Axis;
use crate::energy::tests::{Case, Sample};
use crate::material::sheet::LAWS;
use crate::material::sheet::TensionField;
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::testing::{cube, facets_where};

/// A sheet with a state near a homogeneous one.
struct Sheets {
    name: String,
    case: Case,
    membrane: Membrane,
}

/// The warp of sheets with axes: around an axis beside the body, askew to the sheets.
const HELICAL: Direction = Direction::Helical(
    Axis { point: Vec3::new(0.3, -1.5, 0.2), along: Vec3::new(0.6, 0.0, 0.8) },
    0.6,
);

/// First steps of Taylor tests: no point comes to another state [m].
const SIZES: [f64; 2] = [5e-5, 5e-6];

/// What is the same for all points of the sheets: λ₁ and λ₂ in the plane.
const STRETCHES: [(&str, [f64; 2]); 4] = [
    ("taut", [1.4, 1.2]),
    ("wrinkled", [1.3, 0.75]),
    ("compressed", [0.85, 0.9]),
    ("nearly at rest", [1.02, 1.01]),
];

/// The top of a block of two layers and the plane between them, which is bent.
fn facets(mesh: &TetMesh) -> Vec<[usize; 3]> {
    let at = |z: f64| facets_where(mesh, |x| (x.z - z).abs() < 1e-9);
    let all = [at(1.0), at(0.5)].concat();
    assert_eq!(all.len(), 16);
    all
}

impl Sheets {
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
        let case = Case { space, rest: mesh.vertices, u, step: None };
        Self { name, case, membrane }
    }

    fn share(&self, state: State) -> f64 {
        let all = self.membrane.summary(&self.case.here());
        [all.taut, all.wrinkled, all.slack][state as usize]
    }
}

/// All laws with and without compression, in the states in which they resist.
fn cases(degrees: &[usize]) -> Vec<Sheets> {
    let mut cases = Vec::new();
    for &degree in degrees {
        for (state, stretches) in STRETCHES {
            for row in LAWS {
                let name = format!("{} {state} P{degree}", row.key);
                let law = || (row.build)(row.sample);
                cases.push(Sheets::new(degree, stretches, law(), name.clone()));
                if state != "compressed" {
                    let relaxed = Box::new(TensionField(law()));
                    cases.push(Sheets::new(degree, stretches, relaxed, name + " in tension"));
                }
            }
        }
    }
    cases
}

/// All cases; of the warp of laws with axes the angle is a number, too.
pub fn samples() -> Vec<Sample> {
    let sample = |Sheets { name, case, membrane }: Sheets| {
        let key = name.split(' ').next();
        let row = LAWS.iter().find(|row| Some(row.key) == key).expect("a law");
        let mut numbers: Vec<f64> = [2e-3].iter().chain(row.sample).copied().collect();
        numbers.extend(membrane.direction.map(|_| 0.6));
        let tension = name.ends_with("tension");
        let term = move |numbers: &[f64]| -> Box<dyn Energy> {
            let law = (row.build)(&numbers[1..=row.sample.len()]);
            let law: Box<dyn Sheet> = if tension { Box::new(TensionField(law)) } else { law };
            let mut own = Membrane { thickness: numbers[0], sheet: law.into(), ..membrane.clone() };
            if let Some(Direction::Helical(axis, _)) = own.direction {
                own.direction = Some(Direction::Helical(axis, numbers[numbers.len() - 1]));
            }
            Box::new(own)
        };
        let (case, term) = (Arc::new(case), Box::new(term));
        Sample { name, case, sizes: SIZES, numbers, term }
    };
    cases(&[1, 2, 3]).into_iter().map(sample).collect()
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
fn the_projected_hessian_is_positive_and_that_of_a_sheet_in_tension_exact() {
    let mut random = Random::new(9);
    for case in cases(&[1, 2]) {
        let convex = case.name.ends_with("tension") || case.name.contains("taut");
        let q = random.numbers(case.case.u.len());
        let [exact, projected] = [Hessian::Exact, Hessian::Projected]
            .map(|kind| case.case.times_hessian(&case.membrane, kind, &q));
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
