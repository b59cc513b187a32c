//! Force of contact and friction on a part of the bodies.
//!
//! along            J = d · F                    [N]
//! squared          J = |F|²                     [N²]
//! sum of squares   J = Σ_n |f_n|²               [N²]
//! sum              J = Σ_n √(|f_n|² + ε²) − ε   [N]
//!
//! f_n   force on node n, as it is simulated [N];   F = Σ_n f_n
//! d     a direction [1];   ε = 1 mN, so that J is smooth where a contact begins
//!
//! J depends on u and X through the forces alone. Where a part is pressed from
//! opposite sides, F cancels and both sums do not. The sum of squares depends on
//! the mesh, as a force is shared by more nodes on a finer one, and is largest
//! where one node carries everything; the sum of magnitudes is the total force.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use mechanics::element;
use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{Builder, Kind, Specification, TAGS, form};
use super::{Equilibrium, Objective};
use crate::written::Names;

pub(super) const KIND: Kind = Kind {
    key: "contact-force",
    formula: "of the force F of contact and friction on nodes: d·F, |F|², Σ |f_n|², or Σ |f_n|",
    unit: "N or N²",
    keys: &[
        TAGS,
        ("form", "\"along\", \"squared\" (default), \"sum-of-squares\" or \"sum\""),
        ("direction", "d, for \"along\""),
    ],
    may_be_maximised: true,
    needs_contact: true,
    form: form::<Keys>(),
};

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Keys {
    on: Names,
    #[serde(default)]
    form: Form,
    /// Of any length [1].
    direction: Option<[f64; 3]>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Form {
    Along,
    #[default]
    Squared,
    SumOfSquares,
    Sum,
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        match (self.form, &self.direction) {
            (Form::Along, None) => bail!("form = \"along\" needs direction = [x, y, z]"),
            (Form::Along, Some(d)) => ensure!(
                d.iter().all(|x| x.is_finite()) && d.iter().any(|x| *x != 0.0),
                "direction = {d:?}: must be finite, and not zero"
            ),
            (_, direction) => ensure!(
                direction.is_none(),
                "direction is for form = \"along\" only; remove one of them"
            ),
        }
        Ok(())
    }

    fn prepare(&self, _: &Path) -> Result<Builder> {
        let on = self.on.clone();
        let direction = self.direction.map_or_else(Vec3::zeros, Vec3::from);
        let resultant = match self.form {
            Form::Along => Resultant::Along(direction),
            Form::Squared => Resultant::Squared,
            Form::SumOfSquares => Resultant::SumOfSquares,
            Form::Sum => Resultant::Sum,
        };
        Ok(Box::new(move |name, bodies| {
            let facets = bodies.facets(&on)?;
            let nodes = facets.iter().flat_map(|&f| bodies.space.facet_nodes(f)).collect();
            Ok(Box::new(ContactForce::new(name, nodes, resultant)))
        }))
    }
}

/// What of the forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resultant {
    /// The component of the sum along a direction.
    Along(Vec3),
    /// The square of the sum.
    Squared,
    /// The sum of the squares over nodes.
    SumOfSquares,
    /// The sum of the magnitudes over nodes, smooth below 1 mN.
    Sum,
}

/// ε of the sum of magnitudes [N].
const SMOOTH: f64 = 1e-3;

/// √(|f|² + ε²).
fn magnitude(f: &Vec3) -> f64 {
    (f.norm_squared() + SMOOTH * SMOOTH).sqrt()
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
            Resultant::Sum => {
                self.nodes.iter().map(|&n| magnitude(&element::at(at.contact, n)) - SMOOTH).sum()
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
                Resultant::Sum => {
                    let f = element::at(at.contact, n);
                    f / magnitude(&f)
                }
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
        for resultant in [Resultant::Squared, Resultant::SumOfSquares, Resultant::Sum] {
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
        let (one, other) = (126f64.sqrt(), 26f64.sqrt());
        assert!((force(Resultant::Sum).value(&case.at()) - (one + other)).abs() < 2.1e-3);
    }
}
