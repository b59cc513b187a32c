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

/// The states of a path, at most `most`.
fn follow(problem: &Problem, rest: &[Vec3], path: ArcLength, most: usize) -> Vec<LoadStep> {
    follow_to(problem, rest, path, most, false)
}

/// The same, or up to the first singular point.
fn follow_to(
    problem: &Problem,
    rest: &[Vec3],
    path: ArcLength,
    most: usize,
    at_first: bool,
) -> Vec<LoadStep> {
    let (mut workspace, mut stepper) = (Workspace::new(problem), stepper(problem));
    let mut follower = Continuation::new(path);
    let mut steps: Vec<LoadStep> = Vec::new();
    let stops =
        |step: &LoadStep| step.ends_time_step || (at_first && !point(step).passed.is_empty());
    while steps.len() < most && !steps.last().is_some_and(stops) {
        let step = follower.next(&mut stepper, problem, &mut workspace, rest);
        steps.push(step.unwrap_or_else(|unreached| panic!("{unreached}")));
    }
    steps
}

/// Length and thickness of the arch [m], and its Young's modulus [Pa].
const ARCH: (f64, f64, f64) = (1.0, 0.01, 1e6);

/// A clamped arch of Poisson's ratio 0, z = a (1 − cos κx)/2 with κ = 2π/L, under a load per area that is so many
/// times E κ⁴ h⁴ cos κx at t = 1; and the node at the middle of its crown.
fn arch(rise: f64, load: f64) -> (Problem, Vec<Vec3>, usize) {
    arch_of(40, ARCH.2, rise, load)
}

/// The same of so many cells and a Young's modulus, with the load of that of [`ARCH`].
fn arch_of(cells: usize, modulus: f64, rise: f64, load: f64) -> (Problem, Vec<Vec3>, usize) {
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
    let crown = nodes.iter().position(|s| *s == Vec3::new(0.5, 0.0, 0.5)).expect("a node");
    let force = load * young * k.powi(4) * h.powi(3);
    let force = format!("{force:e}*t*cos({k}*x)").parse::<Schedule>().expect("an expression");
    let field = Field([0.0.into(), 0.0.into(), force]);
    let energies = Energies::elastic(Box::new(NeoHookean(Lame::new(modulus, 0.0))));
    let energies = energies.with(BodyForce::whole(field));
    (Problem::new(space, energies, &fixed), rest, crown)
}

/// The cube [0, 1]³ in so many cells along x, an even number, 1 and 2, and symmetrical to x = 1/2: the path of an arch of
/// cells that are not so would turn to one side where its branch leaves.
fn symmetrical(cells: usize) -> mesh::TetMesh {
    let mut mesh = testing::block([cells / 2, 1, 2]);
    mesh.vertices.iter_mut().for_each(|x| x.x *= 0.5);
    let half = mesh.vertices.clone();
    let mut image = Vec::new();
    for (v, x) in half.iter().enumerate() {
        image.push(if x.x < 0.5 { mesh.vertices.len() } else { v });
        if x.x < 0.5 {
            mesh.vertices.push(Vec3::new(1.0 - x.x, x.y, x.z));
        }
    }
    let tets = mesh.tets.clone();
    mesh.tets.extend(tets.iter().map(|&[a, b, c, d]| [b, a, c, d].map(|v| image[v])));
    mesh
}

/// Load of a shallow clamped arch over E κ⁴ h⁴ at the amplitude b, both over the thickness:
/// (a − b)/24 + (a² − b²) b/32, from its bending and the thrust N = E A κ² (a² − b²)/16.
fn arch_load(rise: f64, b: f64) -> f64 {
    (rise - b) / 24.0 + (rise * rise - b * b) * b / 32.0
}

fn point(step: &LoadStep) -> &ArcPoint {
    step.path.as_deref().expect("a path")
}

fn passed(steps: &[LoadStep]) -> Vec<SingularPoint> {
    steps.iter().flat_map(|step| point(step).passed.clone()).collect()
}

/// Its limit points are at b² = (a² − 4/3)/3. With a = 1.5 its thrust stays below the one at which it would bend
/// sideways, N L²/(E I) = 80.76 (tan x = x at x = 4.4934), which is a² − b² = 2.7276. What the closed form neglects is
/// of the order of the squares of its slope, 0.05, and of h κ = 0.06: below 1 %.
#[test]
fn a_shallow_arch_snaps_through_at_the_load_of_its_closed_form() {
    let rise: f64 = 1.5;
    let turn = ((rise * rise - 4.0 / 3.0) / 3.0).sqrt();
    let limits = [arch_load(rise, turn), arch_load(rise, -turn)];
    let full = 1.2 * limits[0];
    let (problem, rest, crown) = arch(rise, full);
    let path = ArcLength { first: 0.1, largest: 0.2, smallest: 1e-3, end: 1.0 };
    let steps = follow(&problem, &rest, path, 80);
    let last = steps.last().expect("states");
    assert!(last.ends_time_step && last.time == 1.0, "{} states, t = {}", steps.len(), last.time);
    let height = |step: &LoadStep| rise + step.u[3 * crown + 2] / ARCH.1;
    for step in &steps {
        let expected = arch_load(rise, height(step)) / full;
        assert!((step.time - expected).abs() < 0.01, "{} {expected}", step.time);
    }
    let passed = passed(&steps);
    assert!(passed.iter().all(|point| point.kind == Singularity::LimitPoint), "{passed:?}");
    let [top, bottom] = [0, 1].map(|i| passed[i].loads);
    assert_eq!(passed.len(), 2);
    assert!(top.iter().all(|t| *t < limits[0] / full + 0.01), "{top:?}");
    assert!(bottom.iter().all(|t| *t > limits[1] / full - 0.01), "{bottom:?}");
    // it falls between both, on an unstable branch
    let falling: Vec<&LoadStep> = steps.iter().filter(|s| point(s).load_rate < 0.0).collect();
    assert!(falling.len() > 3 && falling.iter().all(|s| point(s).stability.negative == 1));
    assert!(
        steps.iter().filter(|s| point(s).load_rate > 0.0).all(|s| point(s).stability.negative == 0)
    );
}

#[test]
fn a_path_without_load_and_a_body_that_floats_are_refused() {
    let (problem, rest, _) = arch(1.1, 0.0);
    let path = ArcLength { first: 0.1, largest: 0.5, smallest: 1e-3, end: 1.0 };
    let follow = |problem: &Problem| {
        let mut workspace = Workspace::new(problem);
        let mut follower = Continuation::new(path);
        let next = follower.next(&mut stepper(problem), problem, &mut workspace, &rest);
        next.err().map(|unreached| unreached.failure)
    };
    assert_eq!(follow(&problem), Some(Failure::NoLoad));
}

/// The loads of the states before the first singular point of a path and after it, and the point by the direct method.
fn first_limit(
    problem: &Problem,
    rest: &[Vec3],
    path: ArcLength,
    kind: Singularity,
) -> (Limit, [f64; 2]) {
    let (mut workspace, mut stepper) = (Workspace::new(problem), stepper(problem));
    let mut follower = Continuation::new(path);
    let mut before = 0.0;
    let beyond = loop {
        let step = follower.next(&mut stepper, problem, &mut workspace, rest).expect("a state");
        if !point(&step).passed.is_empty() {
            break step;
        }
        before = step.time;
    };
    let nearer = match kind {
        Singularity::LimitPoint => follower.narrowed(&stepper, problem, &mut workspace, rest),
        Singularity::Bifurcation => None,
    };
    let start = configuration(rest, nearer.as_ref().unwrap_or(&beyond));
    let limit = Limit::near(problem, &mut workspace, &start, kind, &NEWTON);
    (limit.unwrap_or_else(|failure| panic!("{failure}")), [before, beyond.time])
}

fn configuration<'a>(rest: &'a [Vec3], step: &LoadStep) -> Configuration<'a> {
    let (u, multipliers) = (step.u.clone(), step.multipliers.clone());
    Configuration { rest, time: step.time, step: None, u, multipliers }
}

/// Each error of the load is at most a number times the square of the one before: the second last step shows it.
#[test]
fn the_direct_method_converges_quadratically_from_afar() {
    let rise: f64 = 1.5;
    let (problem, rest, _) = arch(rise, 0.15);
    let path = ArcLength { first: 0.1, largest: 0.5, smallest: 1e-3, end: 1.0 };
    let steps = follow_to(&problem, &rest, path, 40, true);
    let start = configuration(&rest, steps.last().expect("states"));
    let mut workspace = Workspace::new(&problem);
    let limit = Limit::near(&problem, &mut workspace, &start, Singularity::LimitPoint, &NEWTON);
    let limit = limit.unwrap_or_else(|failure| panic!("{failure}"));
    let errors: Vec<f64> = limit.history.iter().map(|l| (l.load - limit.load).abs()).collect();
    let seen: Vec<f64> = errors.iter().copied().filter(|e| *e > 1e-12).collect();
    let [.., before, last] = seen[..] else { panic!("{errors:?}") };
    assert!(last < 20.0 * before * before + 1e-9, "{errors:?}");
}

/// The load of the limit of an arch by its modulus, to which it is proportional, and by its rest vertices, of which
/// those that move break its symmetry.
#[test]
fn the_gradient_of_a_limit_is_its_derivative() {
    for (rise, load, kind) in
        [(1.5, 0.15, Singularity::LimitPoint), (2.5, 1.5, Singularity::Bifurcation)]
    {
        let (problem, rest, _) = arch_of(10, ARCH.2, rise, load * unit_load(rise, kind));
        let path = ArcLength { first: 0.1, largest: 0.5, smallest: 1e-3, end: 1.0 };
        let (found, _) = first_limit(&problem, &rest, path, kind);
        let again = |rest: &[Vec3]| {
            let (u, multipliers) = (found.u.clone(), found.multipliers.clone());
            let start = Configuration { rest, time: found.load, step: None, u, multipliers };
            let mut workspace = Workspace::new(&problem);
            let limit = Limit::near(&problem, &mut workspace, &start, kind, &NEWTON);
            limit.map(|limit| limit.load)
        };
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
        assert!((by_modulus * ARCH.2 / found.load - 1.0).abs() < 1e-6, "{by_modulus} {kind:?}");
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
    value: impl Fn(&[Vec3]) -> Result<f64, Failure>,
) {
    let mut random = crate::math::random::Random::new(5);
    let motion = rest.iter().map(|x| if inner(x) { size * random.vector() } else { Vec3::zeros() });
    let motion: Vec<Vec3> = motion.collect();
    let along = |by: f64| {
        let moved: Vec<Vec3> = rest.iter().zip(&motion).map(|(x, m)| x + by * m).collect();
        value(&moved)
    };
    let result = taylor(1.0, 6, dot(by, &testing::flat(&motion)), along).expect("states");
    assert!((result.slope - 2.0).abs() < 0.1, "{result:?}");
}

/// What the loads of an arch are times of.
fn unit_load(rise: f64, kind: Singularity) -> f64 {
    match kind {
        Singularity::LimitPoint => 1.0,
        Singularity::Bifurcation => arch_load(rise, (rise * rise - 2.7276).sqrt()),
    }
}
