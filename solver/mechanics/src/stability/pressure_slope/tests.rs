//! The slope of the pressure of spheres, beside a closed form, differences of states and Taylor tests.

use mesh::Vec3;

use super::*;
use crate::adjoint::ScaledPressure;
use crate::energy::{Chamber, Elastic, Energies, Isobaric, Multiplier, PrescribedVolume};
use crate::material::{Lame, NeoHookean};
use crate::schedule::Schedule;
use crate::stability::continuation::tests::{check_by_shape, stepper};
use crate::testing::{
    BALLOON, BALLOON_MODULUS, balloon, balloon_limit, balloon_pressure, eighth_shell,
    shell_problem, shell_wall,
};

/// A body with a pressure in its chamber.
struct Case {
    problem: Problem,
    rest: Vec<Vec3>,
}

impl Case {
    /// A sphere without anything around it.
    fn alone(pressure: f64) -> Self {
        let (problem, rest) = balloon(2, 2, pressure);
        Self { problem, rest }
    }

    /// A compressible sphere in a liquid that fills all around it.
    fn in_liquid(pressure: f64) -> Self {
        let mesh = eighth_shell(2, 2, BALLOON);
        let law = NeoHookean(Lame::new(2.6, 0.3));
        let problem = shell_problem(&mesh, |space| {
            let gas = Box::new(Isobaric { pressure: Schedule::from(pressure) });
            let wall = shell_wall(&mesh, space, BALLOON);
            let inside = Chamber::new(wall, gas);
            let gas = Box::new(PrescribedVolume::Factor(Schedule::from(1.01)));
            let wall = shell_wall(&mesh, space, 1.0);
            let around = Chamber { multiplier: Some(0), ..Chamber::new(wall, gas) };
            let energies = Energies::elastic(Box::new(law));
            energies.with_chamber("wall", inside).with_chamber("around", around)
        });
        let multipliers = vec![Multiplier { pressure: 0.0, penalty: 1.0 }];
        Self { problem: problem.with_multipliers(multipliers), rest: mesh.vertices }
    }

    fn growing(&self) -> Vec<ChamberId> {
        self.problem.energies.chambers().map(|(id, _)| id).take(1).collect()
    }

    fn held(&self) -> Problem {
        self.problem.with_scaled_pressures(1.0, &self.growing())
    }

    /// The equilibrium of a rest shape at a load.
    fn at<'a>(&self, rest: &'a [Vec3], load: f64) -> Configuration<'a> {
        let held = self.held();
        let (mut workspace, mut stepper) = (Workspace::new(&held), stepper(&held));
        let step = stepper.next(&held, &mut workspace, rest, load).expect("an equilibrium");
        assert!(step.ends_time_step);
        Configuration {
            rest,
            time: load,
            step: None,
            u: step.u,
            multipliers: step.multipliers,
            balanced_at: None,
        }
    }

    fn slope_at(&self, rest: &[Vec3], load: f64) -> PressureSlope {
        let held = self.held();
        let mut workspace = Workspace::new(&held);
        let slope = PressureSlope::of(&held, &mut workspace, &self.at(rest, load), &self.growing());
        slope.unwrap_or_else(|failure| panic!("{failure}"))
    }

    fn gradient(&self) -> (PressureSlope, crate::adjoint::Gradient) {
        let (held, growing) = (self.held(), self.growing());
        let (state, slope) = (self.at(&self.rest, 1.0), self.slope_at(&self.rest, 1.0));
        let (problem, rest) = (&self.problem, &self.rest[..]);
        let grown = ScaledPressure { problem, held: &held, rest, time: 1.0, chambers: &growing };
        let gradient = grown.gradient_of_slope(&mut Workspace::new(&held), &state, &slope);
        (slope, gradient.expect("a gradient"))
    }
}

/// The closed form gives the pressure p at a stretch λ of the inner wall. The volume goes with λ³, so that
/// s = (dp/dλ) (λ³ − 1) / (3 λ² p).
#[test]
fn the_slope_of_a_sphere_is_that_of_its_closed_form() {
    let mut before = 1.0;
    for part in [0.3, 0.6, 0.9] {
        let pressure = part * balloon_limit();
        let (mut from, mut to) = (1.0, 1.5);
        for _ in 0..60 {
            let middle = 0.5 * (from + to);
            if balloon_pressure(middle) < pressure { from = middle } else { to = middle }
        }
        let stretch: f64 = from;
        let rise = (balloon_pressure(stretch + 1e-5) - balloon_pressure(stretch - 1e-5)) / 2e-5;
        let expected = rise / (3.0 * stretch * stretch) * (stretch.powi(3) - 1.0) / pressure;
        let case = Case::alone(pressure);
        let slope = case.slope_at(&case.rest, 1.0);
        assert!((slope.value / expected - 1.0).abs() < 0.02, "{} {expected}", slope.value);
        assert!(slope.value < before && slope.negative == 0);
        before = slope.value;
    }
}

/// D is P dV/dα, by the states at a little more and less pressure.
#[test]
fn the_slope_is_that_of_states_near_by() {
    for case in [Case::alone(0.6 * balloon_limit()), Case::in_liquid(0.3)] {
        let (held, growing) = (case.held(), case.growing());
        let work = |load: f64| {
            let state = case.at(&case.rest, load);
            work(&held, &Configuration { time: 1.0, ..state }, &growing)
        };
        let change = (work(1.0 + 1e-3) - work(1.0 - 1e-3)) / 2e-3;
        let (found, expected) = (case.slope_at(&case.rest, 1.0).value, work(1.0) / change);
        assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
    }
}

/// The slope depends on the pressure as along the path, and on p/G of a sphere alone.
#[test]
fn the_gradient_by_pressure_and_modulus_is_that_along_the_path() {
    for (case, pressure, alone) in [
        (Case::alone(0.6 * balloon_limit()), 0.6 * balloon_limit(), true),
        (Case::in_liquid(0.3), 0.3, false),
    ] {
        let (slope, by) = case.gradient();
        let at = |load: f64| case.slope_at(&case.rest, load).value;
        let along = (at(1.0 + 1e-3) - at(1.0 - 1e-3)) / 2e-3;
        let by_pressure = pressure * by.parameters.sum(0, case.growing()[0].owner());
        assert!((by_pressure / along - 1.0).abs() < 1e-4, "{by_pressure} {along}");
        if alone {
            let by_modulus = by.parameters.total(Elastic::owner(0))[0];
            let sum = BALLOON_MODULUS * by_modulus + by_pressure;
            assert!(sum.abs() < 1e-6 * slope.value, "{sum} {by_pressure}");
        }
    }
}

#[test]
fn the_gradient_by_the_rest_shape_passes_the_taylor_test() {
    for case in [Case::alone(0.6 * balloon_limit()), Case::in_liquid(0.3)] {
        let (_, by) = case.gradient();
        let inner = |x: &Vec3| x.iter().all(|x| *x > 1e-6);
        check_by_shape(&case.rest, 2e-3, inner, &by.rest, |rest| case.slope_at(rest, 1.0).value);
    }
}

#[test]
fn a_body_without_pressure_has_none() {
    let case = Case::alone(0.0);
    let held = case.held();
    let state = case.at(&case.rest, 1.0);
    let slope = PressureSlope::of(&held, &mut Workspace::new(&held), &state, &case.growing());
    assert!(matches!(slope, Err(Failure::NoLoad)));
}
