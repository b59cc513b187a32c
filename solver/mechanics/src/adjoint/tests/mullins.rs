//! Bodies that soften, beside closed forms.

use super::*;
use crate::energy::Mullins;
use crate::material::{Material, OgdenRoxburgh};
use crate::testing::cube;

/// erf by Simpson's rule.
fn erf(x: f64) -> f64 {
    let n = 400;
    let h = x / f64::from(n);
    let weight = |i: i32| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
    let part = |i: i32| weight(i) * (-(h * f64::from(i)).powi(2)).exp();
    2.0 / std::f64::consts::PI.sqrt() * h / 3.0 * (0..=n).map(part).sum::<f64>()
}

/// A unit cube that is stretched along x without a change of volume, all of its nodes moved.
struct Stretched {
    problem: Problem,
    rest: Vec<Vec3>,
    nodes: Vec<Vec3>,
    integrator: Integrator,
}

const C: [f64; 2] = [55e3, 5e3];
const OF_CUBE: OgdenRoxburgh = OgdenRoxburgh { r: 2.0, m: 3e3, beta: 0.1 };

impl Stretched {
    fn new() -> Self {
        let mesh = cube(1, 0.0);
        let space = FunctionSpace::new(2, mesh.vertices.len(), mesh.tets.clone());
        let law = MooneyRivlin { c1: C[0], c2: C[1], c3: 0.0, d1: 1e6 };
        let energies = Energies::elastic(Box::new(law));
        let isochoric = law.isochoric().expect("in invariants");
        let count = mesh.tets.len();
        let energies = energies.with(Mullins::new(isochoric, OF_CUBE, 0..count, 0));
        let problem = Problem::new(space, energies, &[true; 3 * 27]);
        let nodes = problem.space.node_positions(&mesh.vertices);
        let zero = vec![0.0; problem.dofs()];
        let integrator = Integrator::new(Method::Quasistatic, State::new(zero.clone(), zero));
        Self { problem, rest: mesh.vertices, nodes, integrator }
    }

    fn displacement(&self, stretch: f64) -> Vec<f64> {
        let across = stretch.powf(-0.5) - 1.0;
        let one = |x: &Vec3| [(stretch - 1.0) * x.x, across * x.y, across * x.z];
        self.nodes.iter().flat_map(one).collect()
    }

    /// Makes a step to a stretch: the nodal forces and the energy there [N, J], and what is lost by then [J].
    fn go(&mut self, stretch: f64) -> (Vec<f64>, f64, f64) {
        let u = self.displacement(stretch);
        let step = self.integrator.step(0.0, 1.0);
        let at = Iterate { step: Some(&step), ..self.problem.iterate(&self.rest, &u, 1.0) };
        let (forces, _) = self.problem.gradient(&at);
        let energy = self.problem.energies.iter().map(|term| term.value(&at)).sum();
        let mullins: &Mullins = self.problem.energies.each().next().expect("it softens");
        let lost = mullins.summary(&at).lost;
        self.integrator.accept(&step, &u, self.problem.energies.internal(&at));
        (forces, energy, lost)
    }
}

/// W of the cube [J/m³].
fn energy_density(l: f64) -> f64 {
    C[0] * (l * l + 2.0 / l - 3.0) + C[1] * (2.0 * l + 1.0 / (l * l) - 3.0)
}

#[test]
fn a_stretched_cube_has_the_stress_of_the_formula() {
    let mut cube = Stretched::new();
    let mut largest = 0.0_f64;
    for (n, l) in [1.5, 1.3, 1.05, 1.2, 1.49, 1.7, 1.1, 1.6].into_iter().enumerate() {
        let w = energy_density(l);
        let x = (largest - w) / (OF_CUBE.m + OF_CUBE.beta * largest);
        let factor = if w < largest { 1.0 - erf(x) / OF_CUBE.r } else { 1.0 };
        assert_eq!(factor < 1.0, ![0, 5].contains(&n));
        // two thirds of σ₁₁ − σ₂₂ = 2 (λ² − 1/λ) (c₁ + c₂/λ), which is isochoric, over λ
        let expected = factor * 4.0 / 3.0 * (l * l - 1.0 / l) * (C[0] + C[1] / l) / l;
        let (forces, ..) = cube.go(l);
        let end = (0..cube.nodes.len()).filter(|&i| cube.nodes[i].x == 1.0);
        let force: f64 = end.map(|i| forces[3 * i]).sum();
        assert!((force / expected - 1.0).abs() < 1e-10, "{l}: {force} {expected}");
        largest = largest.max(w);
    }
}

/// From rest to a stretch and back, by the trapezoidal rule; the second time nothing is lost.
#[test]
fn the_work_of_a_cycle_is_what_is_lost() {
    let mut cube = Stretched::new();
    let steps = 400_i32;
    let mut last = cube.go(1.0);
    let mut before = cube.displacement(1.0);
    let mut work = [0.0; 2];
    for work in &mut work {
        for n in 1..=2 * steps {
            let up = 1.0 - f64::from((n - steps).abs()) / f64::from(steps);
            let next = cube.go(1.0 + 0.6 * up);
            let u = cube.displacement(1.0 + 0.6 * up);
            let moved = u.iter().zip(&before).map(|(u, before)| u - before);
            let forces = last.0.iter().zip(&next.0).map(|(a, b)| 0.5 * (a + b));
            *work += moved.zip(forces).map(|(u, f)| u * f).sum::<f64>();
            (last, before) = (next, u);
        }
    }
    let (_, energy, lost) = last;
    assert!((work[0] / lost - 1.0).abs() < 1e-4, "{work:?} {lost}");
    assert!((energy / lost - 1.0).abs() < 1e-10, "{energy} {lost}");
    assert!(lost > 0.2 * energy_density(1.6), "{lost}");
    assert!(work[1].abs() < 1e-4 * lost, "{work:?}");
}
