//! Recognises a chamber that balloons from the steps of Newton's method.
//!
//! A step δ that blows a chamber up does a work that its walls bear in part. What they leave moves the body on: −g·δ,
//! with the unbalanced force g. From the start of the step to its end that changes by −∫ δ·H δ, with the tangent H.
//! Near an equilibrium the end has a part of the start at most. Where it has as much,
//!
//! −g₁·δ ≥ −g₀·δ > 0
//!
//! the walls bear less the more the chamber grows: dP/dV < 0 at a held pressure, as beyond the limit of a balloon. Nothing
//! stops it there. [`STEPS`] such steps in a row or more, which make it grow by [`GROWTH`] together, are a chamber that
//! balloons: contact cuts steps short.
//!
//! Measured on the finger at 170 kPa, which balloons at 152 kPa: the ratio of both is 0.37, 0.66, 0.83, 0.90, 0.94, 0.97
//! and 1.003 in the second to the eighth step. It is recognised after 10 iterations from rest, and after 9, 7, 20 and 29
//! of 30 in later load steps. The gripper at 80 kPa from rest is recognised after 24 of 200. In 170 solves of the designs
//! of finger and gripper (its first level) no step was of that kind: the ratio was 0.82 at most where a chamber grew by
//! more than 5 %.

use super::Problem;
use crate::energy::Iterate;
use crate::math::linear::dot;

/// Steps in a row.
const STEPS: usize = 3;
/// Growth of the volume of a chamber in them together, relative to it before the first.
const GROWTH: f64 = 0.15;

/// What is known of the steps so far.
pub(super) struct Ballooning {
    /// Volume of every chamber at the start [m³].
    start: Vec<f64>,
    /// How many times that volume a chamber that balloons has at least.
    times: f64,
    /// Steps in a row.
    steps: usize,
    /// Volume of every chamber before the first of them [m³].
    before: Vec<f64>,
}

/// Displacement [m] and gradient of the energy [N] at an end of a step.
#[derive(Clone, Copy)]
pub(super) struct End<'a> {
    pub u: &'a [f64],
    pub gradient: &'a [f64],
}

impl Ballooning {
    /// Begins at an iterate.
    pub fn from(problem: &Problem, at: &Iterate, times: f64) -> Self {
        let start = volumes(problem, at).map(|(volume, _)| volume).collect();
        Self { start, times, steps: 0, before: Vec::new() }
    }

    /// Takes note of a step; of `at` all but the displacement is used. Volume at the start and now of a chamber that
    /// balloons [m³], if there is one.
    pub fn watch(
        &mut self,
        problem: &Problem,
        at: &Iterate,
        [from, to]: [End; 2],
    ) -> Option<[f64; 2]> {
        let step: Vec<f64> = to.u.iter().zip(from.u).map(|(to, from)| to - from).collect();
        let [before, after] = [from, to].map(|end| -dot(end.gradient, &step));
        if before <= 0.0 || after < before {
            self.steps = 0;
            return None;
        }
        if self.steps == 0 {
            let at = Iterate { u: from.u, ..*at };
            self.before = volumes(problem, &at).map(|(volume, _)| volume).collect();
        }
        self.steps += 1;
        if self.steps < STEPS {
            return None;
        }
        let at = Iterate { u: to.u, ..*at };
        let volumes = volumes(problem, &at).zip(self.before.iter().zip(&self.start));
        let mut grown = volumes.filter(|&((volume, pressure), (&before, &start))| {
            pressure > 0.0 && volume >= (1.0 + GROWTH) * before && volume >= self.times * start
        });
        let ((volume, _), (_, &start)) = grown.next()?;
        Some([start, volume])
    }
}

/// Volume [m³] and pressure [Pa] of every chamber.
fn volumes(problem: &Problem, at: &Iterate) -> impl Iterator<Item = (f64, f64)> {
    problem.energies.chambers().map(|(_, chamber)| {
        let (volume, gas) = chamber.state(at);
        (volume, gas.pressure)
    })
}

#[cfg(test)]
mod tests {
    use crate::energy::{Chamber, Energies, Isobaric};
    use crate::forward::{Configuration, Failure, Newton, Workspace};
    use crate::material::{Lame, NeoHookean};
    use crate::testing::{BALLOON, balloon_limit, eighth_shell, shell_problem, shell_wall};

    /// What becomes of an eighth of a sphere from rest under so many times the limit of the incompressible law.
    fn sphere(times: f64, ballooned: Option<f64>) -> Result<usize, Failure> {
        let mesh = eighth_shell(2, 2, BALLOON);
        let problem = shell_problem(&mesh, |space| {
            let gas = Box::new(Isobaric { pressure: (times * balloon_limit()).into() });
            let wall = shell_wall(&mesh, space, BALLOON);
            let chamber = Chamber::new(wall, gas);
            // shear modulus 1, bulk modulus 20
            let law = NeoHookean(Lame::new(2.95, 0.475));
            Energies::elastic(Box::new(law)).with_chamber("wall", chamber)
        });
        let newton =
            Newton { iterations: 200, relative: 1e-9, absolute: 0.0, negligible: 0.0, ballooned };
        let u = vec![0.0; problem.dofs()];
        let mut state = Configuration::new(&problem, &mesh.vertices, u, 1.0);
        let found = newton.solve(&problem, &mut Workspace::new(&problem), &mut state);
        found.map(|converged| converged.iterations)
    }

    /// A trial next to a known state has to grow less than a start from rest.
    #[test]
    fn a_sphere_beyond_its_limit_is_recognised_early() {
        for (times, grown) in [(1.05, 1.0), (1.2, 1.0), (1.5, 1.0), (1.2, 8.0)] {
            let failure = sphere(times, Some(grown)).expect_err("no equilibrium");
            let Failure::Balloons { iterations, start, volume } = failure else {
                panic!("{times}: {failure}")
            };
            assert!(iterations <= 15 && volume >= grown * start, "{times} {grown}: {failure}");
        }
    }

    #[test]
    fn a_sphere_below_its_limit_is_not_refused() {
        for times in [0.3, 0.6, 0.9, 0.95] {
            let [refused, patient] = [Some(1.0), None].map(|ballooned| sphere(times, ballooned));
            assert_eq!(refused, patient, "{times}");
            assert!(patient.is_ok(), "{times}: {patient:?}");
        }
    }
}
