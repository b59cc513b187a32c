//! How long a run will take, said before it begins.
//!
//! T = I (a P m² + f F + s L + c n) / R
//!
//! I  Newton iterations, by the kind of the steps ([`Steps`])
//! P  quadrature points, one of an element of degree 1;  m  nodes of an element
//! F  operations of a factorisation;  L  entries of the factor;  n  degrees of freedom
//! R  operations per second of a matrix product in single precision, measured in some
//!    milliseconds, so that the machine and the number of threads count
//!
//! The numbers were fitted to the scenes in `pipelines`; the chapter "Speed" of the book says how far predictions are off.
//! Iterations are what it knows least of: a time step takes 2 to 30 of them.

use super::{Problem, Workspace};
use crate::math::linear::product_speed;

/// Newton iterations to the first load of a static scene.
const STATIC: f64 = 11.0;
/// Newton iterations of a further load step. Frog and beam take 2 to 4.
const LOAD_STEP: f64 = 4.0;
/// Newton iterations of a time step without inertia.
const QUASISTATIC_STEP: f64 = 9.0;
/// Newton iterations of a time step without contact.
const STEP: f64 = 4.0;
/// Newton iterations of a time step with contact.
const CONTACT_STEP: f64 = 9.0;
/// Operations at a quadrature point for each pair of nodes: a. It is that of degree 2; other degrees take 1500.
const ASSEMBLY: f64 = 1100.0;
/// Share of the operations of a factorisation in an iteration: f.
const FACTORIZATIONS: f64 = 0.75;
/// Operations for each entry of the factor in the solves of an iteration: s.
const SOLVES: f64 = 560.0;

/// Operations for each degree of freedom in all else, such as trials of a step: c.
const OTHERS: f64 = 6.5e5;
/// Operations for each degree of freedom in contact and collision, which are added to c.
const CONTACT: f64 = 2e5;

/// The steps of a run, and how many.
#[derive(Clone, Copy, Debug)]
pub enum Steps {
    /// Load steps of a static scene.
    Load(usize),
    /// Time steps without inertia.
    Quasistatic(usize),
    /// Time steps with inertia.
    Dynamic(usize),
}

/// Predicted number of Newton iterations of a run.
pub fn predicted_iterations(problem: &Problem, steps: Steps) -> f64 {
    match steps {
        Steps::Load(count) => STATIC + LOAD_STEP * count.saturating_sub(1) as f64,
        Steps::Quasistatic(count) => QUASISTATIC_STEP * count as f64,
        Steps::Dynamic(count) if problem.energies.contact().is_some() => {
            CONTACT_STEP * count as f64
        }
        Steps::Dynamic(count) => STEP * count as f64,
    }
}

/// Predicted time of a run [s].
pub fn predicted_time(problem: &Problem, workspace: &Workspace, steps: Steps) -> f64 {
    let space = &problem.space;
    // strain of degree 1 is constant in an element: one point stands for all
    let each = if space.degree() == 1 { 1 } else { space.volume_table().weights.len() };
    let points = space.tets().len() * each;
    let pairs = space.nodes_per_element().pow(2);
    let factor = workspace.linear().cost();
    let others = if problem.energies.contact().is_some() { OTHERS + CONTACT } else { OTHERS };
    let work = ASSEMBLY * (points * pairs) as f64
        + FACTORIZATIONS * factor.flops
        + SOLVES * factor.entries as f64
        + others * problem.dofs() as f64;
    predicted_iterations(problem, steps) * work / product_speed()
}

/// A time as people say it, with one or two digits.
pub fn about(seconds: f64) -> String {
    match seconds {
        s if s < 1.5 => "a second".into(),
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 90.0 * 60.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_said_with_the_digits_they_have() {
        let said = [0.2, 41.3, 89.0, 91.0, 3500.0, 7300.0].map(about);
        assert_eq!(said, ["a second", "41 s", "89 s", "2 min", "58 min", "2.0 h"]);
    }
}
