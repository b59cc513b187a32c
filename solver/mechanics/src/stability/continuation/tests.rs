//! Paths, and the limits on them, beside closed forms.

use std::f64::consts::PI;

use super::*;
use crate::adjoint::ScaledPressure;
use crate::element::FunctionSpace;
use crate::energy::{BodyForce, Elastic, Energies};
use crate::forward::{Integrator, Method, Newton, State, Stepping};
use crate::material::{Lame, NeoHookean};
use crate::math::linear::dot;
use crate::math::taylor::taylor;
use crate::schedule::{Field, Schedule};
use crate::stability::Limit;
use crate::testing;

pub(in crate::stability) const NEWTON: Newton =
    Newton { iterations: 30, relative: 1e-10, absolute: 1e-12, negligible: 0.0, ballooned: None };

pub(in crate::stability) fn stepper(problem: &Problem) -> TimeStepper {
    let zero = vec![0.0; problem.dofs()];
    let start = State::new(zero.clone(), zero);
    let stepping = Stepping { first: 1.0, largest: 1.0, smallest: 1e-3, newton: NEWTON };
    TimeStepper::new(stepping, Integrator::new(Method::Quasistatic, start))
}

const PATH: ArcLength = ArcLength { first: 0.1, largest: 0.5, smallest: 1e-3, end: 1.0 };

/// Length and thickness of the arch [m], and its Young's modulus [Pa].
const ARCH: (f64, f64, f64) = (1.0, 0.01, 1e6);

/// A clamped arch of so many cells and Poisson's ratio 0, z = a (1 − cos κx)/2 with κ = 2π/L, under a load per area that
/// is so many times E κ⁴ h⁴ cos κx at t = 1.
fn arch(cells: usize, rise: f64, load: f64) -> (Problem, Vec<Vec3>) {
    let (length, h, young) = ARCH;
    let mesh = symmetrical(cells);
    let k = 2.0 * PI / length;
    let place = |s: &Vec3| {
        let (x, angle) = (length * s.x, 2.0 * PI * s.x);
        let normal = Vec3::new(-0.5 * rise * h * k * angle.sin(), 0.0, 1.0).normalize();
        let line = Vec3::new(x, 0.05 * s.y, 0.5 * rise * h * (1.0 - angle.cos()));
        line + (s.z - 0.5) * h * normal
    };
    let rest: Vec<Vec3> = mesh.vertices.iter().map(place).collect();
    let space = FunctionSpace::new(2, rest.len(), mesh.tets.clone());
    let nodes = space.node_positions(&mesh.vertices);
    let clamped = |s: &Vec3| s.x == 0.0 || s.x == 1.0;
    let fixed: Vec<bool> = nodes.iter().flat_map(|s| [clamped(s), true, clamped(s)]).collect();
    let force = load * young * k.powi(4) * h.powi(3);
    let force = format!("{force:e}*t*cos({k}*x)").parse::<Schedule>().expect("an expression");
    let field = Field([0.0.into(), 0.0.into(), force]);
    let energies = Energies::elastic(Box::new(NeoHookean(Lame::new(young, 0.0))));
    let energies = energies.with(BodyForce::whole(field));
    (Problem::new(space, energies, &fixed), rest)
}

/// The cube [0, 1]³ in so many cells along x, an even number, 1 and 2, and symmetrical to x = 1/2: the path of an arch of
/// cells that are not so would turn to one side where its branch leaves.
fn symmetrical(cells: usize) -> mesh::TetMesh {
    let mut half = testing::block([cells / 2, 1, 2]);
    half.vertices.iter_mut().for_each(|x| x.x = 0.5 * x.x - 0.5);
    let mut mesh = testing::whole(&half);
    mesh.vertices.iter_mut().for_each(|x| x.x += 0.5);
    mesh
}

#[test]
fn a_path_without_load_is_refused() {
    let (problem, rest) = arch(40, 1.1, 0.0);
    let mut workspace = Workspace::new(&problem);
    let next =
        Continuation::new(PATH).next(&mut stepper(&problem), &problem, &mut workspace, &rest);
    assert_eq!(next.err().map(|unreached| unreached.failure), Some(Failure::NoLoad));
}

/// The state beyond the first singular point of a path, and what follows it.
fn beyond(problem: &Problem, rest: &[Vec3]) -> (LoadStep, Continuation, TimeStepper) {
    let (mut workspace, mut stepper) = (Workspace::new(problem), stepper(problem));
    let mut follower = Continuation::new(PATH);
    loop {
        let step = follower.next(&mut stepper, problem, &mut workspace, rest).expect("a state");
        if !step.path.as_deref().expect("a path").passed.is_empty() {
            return (step, follower, stepper);
        }
    }
}

/// The singular point next to a state by the direct method.
fn limit(problem: &Problem, rest: &[Vec3], near: &Reached, kind: Singularity) -> Limit {
    let (mut workspace, start) = (Workspace::new(problem), near.configuration(rest, None));
    let limit = Limit::near(problem, &mut workspace, &start, kind, &NEWTON);
    limit.unwrap_or_else(|failure| panic!("{failure}"))
}

/// Each error of the load is at most a number times the square of the one before: the second last step shows it.
#[test]
fn the_direct_method_converges_quadratically_from_afar() {
    let (problem, rest) = arch(40, 1.5, 0.15);
    let (beyond, ..) = beyond(&problem, &rest);
    let limit = limit(&problem, &rest, &beyond.into_reached(), Singularity::LimitPoint);
    let errors: Vec<f64> = limit.history.iter().map(|l| (l.load - limit.at.time).abs()).collect();
    let seen: Vec<f64> = errors.iter().copied().filter(|e| *e > 1e-12).collect();
    let [.., before, last] = seen[..] else { panic!("{errors:?}") };
    assert!(last < 20.0 * before * before + 1e-9, "{errors:?}");
}

/// The load of the limit of an arch by its modulus, to which it is proportional, and by its rest vertices, of which
/// those that move break its symmetry.
#[test]
fn the_gradient_of_a_limit_is_its_derivative() {
    // half as much again as the second one bears, by its closed form
    for (rise, load, kind) in
        [(1.5, 0.15, Singularity::LimitPoint), (2.5, 0.28, Singularity::Bifurcation)]
    {
        let (problem, rest) = arch(10, rise, load);
        let (beyond, follower, stepper) = beyond(&problem, &rest);
        let nearer = match kind {
            Singularity::LimitPoint => {
                follower.narrowed(&stepper, &problem, &mut Workspace::new(&problem), &rest)
            }
            Singularity::Bifurcation => None,
        };
        let found = limit(&problem, &rest, &nearer.unwrap_or(beyond).into_reached(), kind);
        let again = |rest: &[Vec3]| limit(&problem, rest, &found.at, kind).at.time;
        let grown = ScaledPressure {
            problem: &problem,
            held: &problem,
            rest: &rest,
            time: 1.0,
            chambers: &[],
        };
        let by = grown.gradient(&mut Workspace::new(&problem), &found).expect("a gradient");
        // loads of the problem itself are those at t = 1, its law is the same
        let by_modulus = by.parameters.total(Elastic::owner(0))[0];
        assert!((by_modulus * ARCH.2 / found.at.time - 1.0).abs() < 1e-6, "{by_modulus} {kind:?}");
        let inner = |x: &Vec3| x.x > 1e-6 && x.x < ARCH.0 - 1e-6;
        check_by_shape(&rest, 2e-4, inner, &by.rest, again);
    }
}

/// A Taylor test by the rest shape [m], of which inner vertices move by a size [m].
pub(in crate::stability) fn check_by_shape(
    rest: &[Vec3],
    size: f64,
    inner: impl Fn(&Vec3) -> bool,
    by: &[f64],
    value: impl Fn(&[Vec3]) -> f64,
) {
    let mut random = crate::math::random::Random::new(5);
    let motion = rest.iter().map(|x| if inner(x) { size * random.vector() } else { Vec3::zeros() });
    let motion: Vec<Vec3> = motion.collect();
    let along = |by: f64| {
        let moved: Vec<Vec3> = rest.iter().zip(&motion).map(|(x, m)| x + by * m).collect();
        Ok::<_, std::convert::Infallible>(value(&moved))
    };
    let Ok(result) = taylor(1.0, 6, dot(by, &testing::flat(&motion)), along);
    assert!((result.slope - 2.0).abs() < 0.1, "{result:?}");
}
