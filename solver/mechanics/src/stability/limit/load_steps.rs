//! The limit of a body by load steps, where a path cannot be followed: to stable states near by, and by halves between
//! the last of them and a load at which there is none.
//!
//! The energy is minimised at a little more load. Its minimum belongs to the same path if it is near the last state and
//! stable. Where a chamber balloons instead, or the minimum is far away or not stable, the load has a limit in between.

use std::ops::ControlFlow;

use mesh::Vec3;

use crate::energy::Iterate;
use crate::forward::{Failure, LoadStep, Newton, Problem, Reached, Stepping, Workspace, attempt};
use crate::math::linear::norm;
use crate::stability::spectrum::negative_eigenvalues;
use crate::stability::tangent_system::{at_held_load, factor};

/// First step of the load, beside it, ...
const FIRST: f64 = 0.01;
/// ... the largest, ...
const LARGEST: f64 = 0.04;
/// ... and how near the load of a state that was refused has to be.
const SMALLEST: f64 = 0.0025;
/// Change of the displacement, beside it, above which a state is another one.
const NEARBY: f64 = 0.05;
/// Growth of a chamber in a search without end that is the growth of a balloon.
const GROWN: f64 = 0.2;

/// How to step.
pub(super) struct LoadSteps<'a> {
    /// A problem whose loads grow.
    pub problem: &'a Problem,
    /// Rest vertices [m].
    pub rest: &'a [Vec3],
    /// How equilibria are found.
    pub stepping: &'a Stepping,
    /// The largest load.
    pub most: f64,
}

/// How far the steps came.
pub(super) struct Outcome {
    /// The last stable state.
    pub last: Reached,
    /// Why not further.
    pub end: End,
}

/// Why load steps end.
pub(super) enum End {
    /// The largest load is reached.
    Most,
    /// The observer wanted no more.
    Stopped,
    /// The body does not bear this load.
    Limit(f64),
    /// No equilibrium was found, for reasons of the method.
    Unknown,
}

/// A state that was not found or is not the next one.
enum Refused {
    /// A chamber balloons, or the state is not stable.
    Limit,
    /// It is far from the last one: by a shorter step there may be one near by.
    Far,
    /// All else.
    Failed,
}

impl LoadSteps<'_> {
    /// From a state to the limit. Every state is shown to `observe`, which may end it.
    pub fn from(
        &self,
        workspace: &mut Workspace,
        mut last: Reached,
        mut observe: impl FnMut(&LoadStep) -> ControlFlow<()>,
    ) -> Outcome {
        let (mut part, mut refused) = (FIRST, None);
        loop {
            let further = (last.time * (1.0 + part)).min(self.most);
            let load = match &refused {
                Some((above, _)) if further >= *above => 0.5 * (last.time + above),
                _ => further,
            };
            let shortest = last.time * (1.0 + SMALLEST);
            match self.step(workspace, &last, load) {
                Ok(step) => {
                    let goes_on = observe(&step);
                    last = step.into_reached();
                    if goes_on.is_break() && last.time < self.most {
                        return Outcome { last, end: End::Stopped };
                    }
                    part = (2.0 * part).min(LARGEST);
                }
                Err(Refused::Far) if load > shortest => part = (0.5 * part).max(SMALLEST),
                Err(why) => refused = Some((load, why)),
            }
            if last.time >= self.most {
                return Outcome { last, end: End::Most };
            }
            match refused {
                Some((above, why)) if above <= last.time * (1.0 + SMALLEST) => {
                    let end = match why {
                        Refused::Limit | Refused::Far => End::Limit(above),
                        Refused::Failed => End::Unknown,
                    };
                    return Outcome { last, end };
                }
                _ => {}
            }
        }
    }

    /// The next state at a load.
    fn step(
        &self,
        workspace: &mut Workspace,
        last: &Reached,
        load: f64,
    ) -> Result<LoadStep, Refused> {
        let Self { problem, rest, .. } = *self;
        let newton = Newton { ballooned: Some(1.0), ..self.stepping.newton };
        let found = attempt(problem, workspace, &last.configuration(rest, None), load, &newton);
        let step = found.map_err(|failed| {
            log::debug!("a step to {load:.4} failed ({})", failed.failure);
            let [from, to] = [&last.u, &failed.u].map(|u| problem.iterate(rest, u, load));
            let mut grown = volumes(problem, &to).zip(volumes(problem, &from));
            let balloons = matches!(failed.failure, Failure::Balloons { .. })
                || grown.any(|(after, before)| after > (1.0 + GROWN) * before);
            if balloons { Refused::Limit } else { Refused::Failed }
        })?;
        let moved: Vec<f64> = step.u.iter().zip(&last.u).map(|(to, from)| to - from).collect();
        let moved = norm(&moved) / norm(&last.u);
        let stable = self.is_stable(workspace, &step.iterate(problem, rest));
        log::debug!("step to {load:.4}: moved by {moved:.2e}, stable: {stable}");
        match stable {
            false => Err(Refused::Limit),
            true if moved > NEARBY => Err(Refused::Far),
            true => Ok(step),
        }
    }

    fn is_stable(&self, workspace: &mut Workspace, at: &Iterate) -> bool {
        let constraints = self.problem.constraints(at);
        let factor = factor(self.problem, workspace, at);
        factor.is_some_and(|factor| {
            let held = at_held_load(self.problem, factor, &constraints);
            negative_eigenvalues(factor, &held) == 0
        })
    }
}

/// Volume of each chamber [m³].
fn volumes(problem: &Problem, at: &Iterate) -> impl Iterator<Item = f64> {
    problem.energies.chambers().map(|(_, chamber)| chamber.state(at).0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forward::{Integrator, Method, State, solve};
    use crate::stability::{FirstLimit, LimitSearch};
    use crate::testing::{balloon, balloon_limit};

    const NEWTON: Newton = Newton {
        iterations: 200,
        relative: 1e-10,
        absolute: 1e-12,
        negligible: 0.0,
        ballooned: None,
    };

    #[test]
    fn load_steps_find_the_limit_of_a_balloon() {
        let (problem, rest) = balloon(1, 1, 0.6 * balloon_limit());
        let stepping = Stepping { first: 1.0, largest: 1.0, smallest: 1e-3, newton: NEWTON };
        let steps = solve(&problem, &mut Workspace::new(&problem), &rest, &stepping, &[1.0]);
        let growing: Vec<_> = problem.energies.chambers().map(|(id, _)| id).collect();
        let held = problem.with_scaled_pressures(1.0, &growing);
        let first = steps.expect("a state").pop().expect("the last").into_reached();
        let zero = vec![0.0; held.dofs()];
        let integrator = Integrator::new(Method::Quasistatic, State::new(zero.clone(), zero));
        let mut searching = Workspace::new(&held);
        let search = LimitSearch { problem: &held, rest: &rest, stepping, most: 3.0, integrator };
        let FirstLimit::Found(found, _) =
            search.from(&mut searching, first.clone(), |_| ControlFlow::Continue(()))
        else {
            panic!("no limit")
        };
        let by_load = LoadSteps { problem: &held, rest: &rest, stepping: &stepping, most: 3.0 };
        let came = by_load.from(&mut searching, first.clone(), |_| ControlFlow::Continue(()));
        // nearly incompressible: Newton's method may fail before it is seen that the sphere balloons
        assert!(!matches!(came.end, End::Most | End::Stopped));
        let (last, found) = (came.last.time, found.at.time);
        assert!(last < found && found < last * (1.0 + 2.0 * SMALLEST), "{last} {found}");
        let mut loads = Vec::new();
        let by_load = LoadSteps { most: 1.2, ..by_load };
        let came = by_load.from(&mut searching, first, |step| {
            loads.push(step.time);
            ControlFlow::Continue(())
        });
        assert!(matches!(came.end, End::Most) && came.last.time == 1.2);
        assert!(loads.is_sorted() && loads.ends_with(&[1.2]), "{loads:?}");
    }
}
