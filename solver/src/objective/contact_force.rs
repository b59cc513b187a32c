//! Force of contact and friction on a part of the bodies.
//!
//! along            J = d · F                 [N]
//! squared          J = |F|²                  [N²]
//! sum of squares   J = Σ_n |f_n|²            [N²]
//!
//! f_n   force on node n, as it is simulated [N];   F = Σ_n f_n
//! d     a direction [1]
//!
//! J depends on u and X through the forces alone. Where a part is pressed from
//! opposite sides, F cancels and the sum of squares does not; the latter depends
//! on the mesh, as a force is shared by more nodes on a finer one.

use mesh::Vec3;

use super::{Equilibrium, Objective};
use crate::element;

/// What of the forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resultant {
    /// The component of the sum along a direction.
    Along(Vec3),
    /// The square of the sum.
    Squared,
    /// The sum of the squares over nodes.
    SumOfSquares,
}

/// Force on some nodes.
pub struct ContactForce {
    name: String,
    nodes: Vec<usize>,
    resultant: Resultant,
}

impl ContactForce {
    /// The force on nodes, each of which counts once. A direction is made a unit
    /// vector.
    #[must_use]
    pub fn new(name: &str, mut nodes: Vec<usize>, resultant: Resultant) -> Self {
        nodes.sort_unstable();
        nodes.dedup();
        let resultant = match resultant {
            Resultant::Along(direction) => Resultant::Along(direction.normalize()),
            other => other,
        };
        Self { name: name.to_owned(), nodes, resultant }
    }

    fn sum(&self, f: &[f64]) -> Vec3 {
        self.nodes.iter().map(|&n| element::at(f, n)).sum()
    }
}

impl Objective for ContactForce {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        match self.resultant {
            Resultant::Along(direction) => direction.dot(&self.sum(at.contact)),
            Resultant::Squared => self.sum(at.contact).norm_squared(),
            Resultant::SumOfSquares => {
                self.nodes.iter().map(|&n| element::at(at.contact, n).norm_squared()).sum()
            }
        }
    }

    fn add_du(&self, _: &Equilibrium, _: f64, _: &mut [f64]) {}

    fn uses_contact(&self) -> bool {
        true
    }

    fn add_dcontact(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        let sum = self.sum(at.contact);
        for &n in &self.nodes {
            let by = match self.resultant {
                Resultant::Along(direction) => direction,
                Resultant::Squared => 2.0 * sum,
                Resultant::SumOfSquares => 2.0 * element::at(at.contact, n),
            };
            element::add_at(out, n, &(weight * by));
        }
    }

    fn add_drest(&self, _: &Equilibrium, _: f64, _: &mut [f64]) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::tests::Case;

    #[test]
    fn derivatives_belong_to_the_value() {
        let case = Case::cube(2, 1.0);
        for resultant in [Resultant::Squared, Resultant::SumOfSquares] {
            case.check(&ContactForce::new("f", vec![9, 3, 40, 3], resultant));
        }
    }

    #[test]
    fn components_are_linear_and_nodes_count_once() {
        let mut case = Case::cube(1, 1.0);
        let force = |resultant| ContactForce::new("f", vec![4, 2, 4], resultant);
        let along = force(Resultant::Along(Vec3::new(0.0, 3.0, 4.0)));
        let mut by = vec![0.0; case.contact.len()];
        along.add_dcontact(&case.at(), 10.0, &mut by);
        let expected = |n: usize| if n == 2 || n == 4 { [0.0, 6.0, 8.0] } else { [0.0; 3] };
        by.chunks_exact(3).enumerate().for_each(|(n, by)| {
            by.iter().zip(expected(n)).for_each(|(a, b)| assert!((a - b).abs() < 1e-14));
        });
        case.contact.fill(0.0);
        case.contact[6..9].copy_from_slice(&[1.0, 5.0, 10.0]);
        case.contact[12..15].copy_from_slice(&[-1.0, 0.0, -5.0]);
        assert!((along.value(&case.at()) - (3.0 + 4.0)).abs() < 1e-14);
        assert!((force(Resultant::Squared).value(&case.at()) - 50.0).abs() < 1e-13);
        assert!((force(Resultant::SumOfSquares).value(&case.at()) - 152.0).abs() < 1e-13);
    }
}
